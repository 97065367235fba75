#include "sensor/magnetometer.h"

#include <cassert>
#include <cmath>

#include "sensor/simulate_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

// Both in the order of NoiseLaw.
double unit_noise_mean(NoiseLaw law) {
  return std::array{0.0, std::sqrt(2 / kPi), 0.0, 0.5}[static_cast<std::size_t>(law)];
}

double unit_noise_variance(NoiseLaw law) {
  return std::array{1.0, 1 - 2 / kPi, 1.0 / 3, 1.0 / 12}[static_cast<std::size_t>(law)];
}

bool symmetric(NoiseLaw law) { return law == NoiseLaw::gaussian || law == NoiseLaw::uniform; }

CleanReadings clean_readings(const survey::Survey& survey, const survey::ReferenceField& field,
                             const MagnetometerErrors& errors) {
  CleanReadings clean;
  for (const survey::Station& s : survey.stations) {
    const survey::Attitude at = survey::magnetic_attitude(s, field.declination);
    const survey::Vec3<double> b = survey::magnetic_T(at, field.total, field.dip);
    clean.field_T.push_back(b);
    clean.magnetic_T.push_back({errors.gain[0] * b.x + errors.bias[0], errors.gain[1] * b.y + errors.bias[1],
                                errors.gain[2] * b.z + errors.bias[2]});
    const survey::Vec3<double> g = scale(field.gravity, survey::down_T(at));
    clean.gravity_T.push_back(g);
    clean.down_T.push_back(scale(1 / norm(g), g));
  }
  return clean;
}

std::vector<survey::StationFields> station_fields(const CleanReadings& clean) {
  std::vector<survey::StationFields> fields;
  for (std::size_t k = 0; k < clean.field_T.size(); ++k) fields.push_back({clean.field_T[k], clean.down_T[k]});
  return fields;
}

NoiseSumMoments noise_sum_moments(const NoiseWeights& weights, NoiseLaw law, const Eigen::MatrixXd* correlation) {
  NoiseSumMoments m{};
  using Row = Eigen::Matrix<double, NoiseWeights::kSums, 1>;
  const auto add = [&](const std::vector<double>& w, double mean, double variance) {
    for (std::size_t r = 0; r < w.size(); r += NoiseWeights::kSums) {
      const Eigen::Map<const Row> row(w.data() + r);
      m.mean += mean * row;
      m.covariance += variance * row * row.transpose();
    }
  };
  m.mean.setZero();
  m.covariance.setZero();
  add(weights.magnetometer, unit_noise_mean(law), unit_noise_variance(law));
  add(weights.accelerometer, 0, 1);
  add(weights.reference, 0, 1);
  add(weights.tool, 0, 1);
  if (correlation == nullptr) return m;
  const Eigen::Map<const Eigen::Matrix<double, NoiseWeights::kSums, Eigen::Dynamic>> w(
      weights.reference.data(), NoiseWeights::kSums, correlation->cols());
  m.covariance += w * (*correlation - Eigen::MatrixXd::Identity(w.cols(), w.cols())) * w.transpose();
  return m;
}

ReferenceMixing reference_mixing(const random::ReferenceLaws& laws, const NoiseModel& noise, int stations) {
  ReferenceMixing m;
  if (!laws.any() || noise.reference == ReferenceNoise::none) return m;
  const bool of_run = noise.reference == ReferenceNoise::per_run;
  for (int k = 0; k < (of_run ? 1 : stations); ++k) {
    std::int32_t shared = -1;
    for (const auto element : {random::ReferenceElement::total, random::ReferenceElement::dip}) {
      const auto& law = laws.of(element).law;
      if (law && (!laws.shared_mixing || shared < 0)) {
        shared = static_cast<std::int32_t>(m.slots.size());
        const std::uint32_t slot = laws.slot(element);
        m.slots.push_back(
            of_run ? random::MixingSlot{law, random::kMixingRun, slot}
                   : random::MixingSlot{law, random::kMixingStation, 4 * static_cast<std::uint32_t>(k) + slot});
      }
      m.slot_of.push_back(law ? shared : -1);
    }
  }
  return m;
}

survey::ReadingBlock make_reading_block(int trials, int stations, const NoiseModel& noise) {
  return {trials, stations, noise.accelerometer > 0, noise.reference == ReferenceNoise::per_station};
}

ReadingRows reading_rows(const CleanReadings& clean, const survey::ReferenceField& field, survey::ReadingBlock& out) {
  return {&clean.magnetic_T.front().x,
          &clean.gravity_T.front().x,
          &clean.down_T.front().x,
          &clean.field_T.front().x,
          out.magnetic.row(0, 0),
          out.down.row(0, 0),
          out.reference.row(0, 0),
          out.magnetic.group_stride(),
          out.down.group_stride(),
          out.reference.group_stride(),
          out.stations,
          out.reference_stride > 0 ? out.stations : 1,
          field.total,
          field.dip};
}

void simulate_readings(const CleanReadings& clean, const survey::ReferenceField& field, const NoiseModel& noise,
                       const random::Stream& stream, std::uint64_t first_trial, survey::ReadingBlock& out,
                       const NoiseWeights* weights, survey::LaneArray* sums, const ReferenceMixing* mixing,
                       const survey::LaneArray* made) {
  assert(first_trial % simd::kGroup == 0);
  assert(!noise.antithetic || symmetric(noise.law));
  const auto data = [](const std::vector<double>& v) { return v.empty() ? nullptr : v.data(); };
  survey::LaneArray drawn;
  const bool mixed = mixing != nullptr && !mixing->slots.empty();
  if (mixed) {
    drawn = survey::LaneArray(out.groups(), 2 * static_cast<int>(mixing->slots.size()));
    random::draw_mixing(stream, mixing->slots, first_trial, noise.antithetic, out.groups(), drawn.row(0, 0),
                        drawn.group_stride());
  }
  const SimulateBatch batch{reading_rows(clean, field, out),
                            out.groups(),
                            first_trial,
                            noise,
                            stream,
                            weights ? data(weights->magnetometer) : nullptr,
                            weights ? data(weights->accelerometer) : nullptr,
                            weights ? data(weights->reference) : nullptr,
                            weights ? sums->row(0, 0) : nullptr,
                            weights ? sums->group_stride() : 0,
                            mixed ? drawn.row(0, 0) : nullptr,
                            mixed ? drawn.group_stride() : 0,
                            mixed ? mixing->slot_of.data() : nullptr,

                            made ? made->row(0, 0) : nullptr,
                            made ? made->group_stride() : 0};
  simd::run_kernel<isa_v3::simulate, isa_v4::simulate>(batch);
}

}  // namespace surveymc::sensor
