#include "sensor/magnetometer.h"

#include <cassert>

namespace surveymc {

double unit_noise_mean(NoiseLaw law) {
  switch (law) {
    case NoiseLaw::gaussian_half_open:
      return std::sqrt(2 / kPi);
    case NoiseLaw::uniform_half_open:
      return 0.5;
    default:
      return 0;
  }
}

double unit_noise_variance(NoiseLaw law) {
  switch (law) {
    case NoiseLaw::gaussian:
      return 1;
    case NoiseLaw::gaussian_half_open:
      return 1 - 2 / kPi;
    case NoiseLaw::uniform:
      return 1.0 / 3;
    case NoiseLaw::uniform_half_open:
      return 1.0 / 12;
  }
  return 0;
}

CleanReadings clean_readings(const Survey& survey, const ReferenceField& field, const MagnetometerErrors& errors) {
  CleanReadings clean;
  for (const Station& s : survey.stations) {
    const Attitude at = magnetic_attitude(s, field.declination);
    const Vec3<double> b = magnetic_T(at, field.total, field.dip);
    clean.field_T.push_back(b);
    clean.magnetic_T.push_back({errors.gain[0] * b.x + errors.bias[0], errors.gain[1] * b.y + errors.bias[1],
                                errors.gain[2] * b.z + errors.bias[2]});
    clean.gravity_T.push_back(scale(field.gravity, down_T(at)));
  }
  return clean;
}

ReadingBlock make_reading_block(int trials, int stations, const NoiseModel& noise) {
  return {trials, stations, noise.accelerometer > 0, noise.reference == ReferenceNoise::per_station};
}

namespace {

/// Four draws of size 1 of the law.
template <class T>
std::array<T, 4> unit_draws(NoiseLaw law, const Stream& stream, const Bits<T>& trial, Channel channel,
                            std::uint32_t call) {
  std::array<T, 4> x;
  if (law == NoiseLaw::gaussian || law == NoiseLaw::gaussian_half_open) {
    x = stream.normals<T>(trial, channel, call);
    if (law == NoiseLaw::gaussian_half_open)
      for (T& v : x) v = abs(v);
  } else {
    x = stream.uniforms<T>(trial, channel, call);
    if (law == NoiseLaw::uniform)
      for (T& v : x) v = fma(v, T(2.0), T(-1.0));
  }
  return x;
}

double component(const Vec3<double>& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/// clean + size * draw for rows 3 k + axis, one half group.
template <class T>
void add_noise(const std::vector<Vec3<double>>& clean, NoiseLaw law, double size, const Stream& stream,
               std::uint64_t first_trial, Channel channel, double* out) {
  const Bits<T> trial = consecutive<T>(first_trial);
  const int rows = 3 * static_cast<int>(clean.size());
  for (int r = 0; r < rows; r += 4) {
    const auto draw = unit_draws<T>(law, stream, trial, channel, static_cast<std::uint32_t>(r / 4));
    for (int i = 0; i < 4 && r + i < rows; ++i)
      store(out + (r + i) * kGroup, fma(T(size), draw[static_cast<std::size_t>(i)],
                                        T(component(clean[static_cast<std::size_t>((r + i) / 3)], (r + i) % 3))));
  }
}

template <class T>
void normalise(int stations, double* down) {
  for (int k = 0; k < stations; ++k, down += 3 * kGroup) {
    const Vec3<T> g{load<T>(down), load<T>(down + kGroup), load<T>(down + 2 * kGroup)};
    const Vec3<T> u = scale(T(1.0) / norm(g), g);
    store(down, u.x);
    store(down + kGroup, u.y);
    store(down + 2 * kGroup, u.z);
  }
}

/// Horizontal and vertical reference of each row pair: total and dip with their errors of this trial.
template <class T>
void draw_reference(const ReferenceField& field, const NoiseModel& noise, const Stream& stream,
                    std::uint64_t first_trial, int pairs, double* out) {
  const Bits<T> trial = consecutive<T>(first_trial);
  for (int k = 0; k < pairs; k += 2) {  // one call serves two stations
    std::array<T, 4> draw{T(0.0), T(0.0), T(0.0), T(0.0)};
    if (noise.reference != ReferenceNoise::none)
      draw = stream.normals<T>(trial, Channel::reference_field, static_cast<std::uint32_t>(k / 2));
    for (int i = 0; i < 2 && k + i < pairs; ++i) {
      const auto j = static_cast<std::size_t>(2 * i);
      const T total = fma(T(noise.reference_total), draw[j], T(field.total));
      const auto [sin_dip, cos_dip] = sincos(fma(T(noise.reference_dip), draw[j + 1], T(field.dip)));
      store(out + (2 * (k + i)) * kGroup, total * cos_dip);
      store(out + (2 * (k + i) + 1) * kGroup, total * sin_dip);
    }
  }
}

}  // namespace

void simulate_readings(const CleanReadings& clean, const ReferenceField& field, const NoiseModel& noise,
                       const Stream& stream, std::uint64_t first_trial, ReadingBlock& out) {
  assert(first_trial % kGroup == 0);
  const int reference_pairs = out.reference_stride > 0 ? out.stations : 1;
  for (int group = 0; group < out.groups(); ++group)
    for (int i = 0; i < kGroup; i += lane_count<Lanes>) {
      const std::uint64_t first = first_trial + static_cast<std::uint64_t>(group * kGroup + i);
      add_noise<Lanes>(clean.magnetic_T, noise.law, noise.magnetometer, stream, first, Channel::magnetometer_noise,
                       out.magnetic.row(group, 0) + i);
      if (group == 0 || !out.down.shared()) {
        // Without accelerometer noise the same direction goes to all lanes of the one shared group.
        add_noise<Lanes>(clean.gravity_T, NoiseLaw::gaussian, noise.accelerometer, stream, first,
                         Channel::accelerometer_noise, out.down.row(group, 0) + i);
        normalise<Lanes>(out.stations, out.down.row(group, 0) + i);
      }
      draw_reference<Lanes>(field, noise, stream, first, reference_pairs, out.reference.row(group, 0) + i);
    }
}

}  // namespace surveymc
