#include "analysis/msa_event.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "survey/corrected_position.h"

namespace surveymc::analysis {

MsaEvent::MsaEvent(const MsaTrials& trials, const estimate::Estimator& estimator, const MsaEventRule& rule,
                   const sensor::ReferenceMixing& mixing)
    : trials_(trials),
      estimator_(estimator),
      rule_(rule),
      normals_(sensor::reading_normals(trials.survey.size(), trials.noise, trials.spread)),
      md_(trials.survey.md()),
      position_(survey::minimum_curvature_positions(trials.survey).back()) {
  for (const random::MixingSlot& slot : mixing.slots) {
    const std::uint32_t call = slot.index / 4;
    const auto at = std::find_if(mixing_calls_.begin(), mixing_calls_.end(), [&](const sensor::NormalAddress& a) {
      return a.channel == slot.channel && a.call == call;
    });
    const auto number = static_cast<std::uint32_t>(at - mixing_calls_.begin());
    if (at == mixing_calls_.end()) mixing_calls_.push_back({slot.channel, call});
    mixing_.push_back({static_cast<std::uint32_t>(normals_.rows()) + 4 * number + slot.index % 4, slot.law, {}});
  }
  for (std::size_t i = 0; i < mixing.slot_of.size(); ++i)
    if (const std::int32_t slot = mixing.slot_of[i]; slot >= 0)
      mixing_[static_cast<std::size_t>(slot)].of.push_back(static_cast<std::uint32_t>(normals_.reference) +
                                                           static_cast<std::uint32_t>(i));
}

void MsaEvent::evaluate(const survey::LaneArray& z, int groups, double* g) const {
  const int count = groups * simd::kGroup;
  survey::ReadingBlock readings = sensor::make_reading_block(count, trials_.survey.size(), trials_.noise);
  const auto make = [&](const survey::LaneArray& normals) {
    sensor::readings_of_normals(trials_.clean, trials_.field, trials_.noise, trials_.spread, normals_, normals, groups,
                                readings);
  };
  if (mixing_.empty()) {
    make(z);
  } else {  // errors that are not normal, in the place of their normals
    survey::LaneArray errors(groups, dimension());
    for (int group = 0; group < groups; ++group) {
      std::copy(z.row(group, 0), z.row(group, dimension()), errors.row(group, 0));
      for (const rare::MixingNormal& m : mixing_)
        for (int lane = 0; lane < simd::kGroup; ++lane) {
          const random::MixingLaw::Draw d = m.law->draw(z.row(group, static_cast<int>(m.row))[lane]);
          for (const std::uint32_t i : m.of) {
            double& x = errors.row(group, static_cast<int>(i))[lane];
            x = std::fma(d.factor, x, d.shift);
          }
        }
    }
    make(errors);
  }
  estimate::EstimateBlock estimates(count);
  estimator_.solve(readings, estimates);
  survey::LaneArray position;
  if (rule_.quantity >= kMsaNorth) {
    position = survey::LaneArray(groups, 3);
    survey::corrected_final_positions(readings, estimates.parameters, md_, trials_.field.declination, position);
  }
  for (int t = 0; t < count; ++t) {
    if (estimates.converged.value(t, 0) == 0) {
      g[t] = kNaN;
      continue;
    }
    double quantity;
    if (rule_.quantity < kMsaNorth) {
      quantity = estimates.parameters.value(t, static_cast<int>(rule_.quantity));
    } else {
      const Eigen::Vector3d error(position.value(t, 0) - position_.x(), position.value(t, 1) - position_.y(),
                                  position.value(t, 2) - position_.z());
      quantity = rule_.quantity >= kMsaInSd    ? std::abs(rule_.direction.dot(error))
                 : rule_.quantity == kMsaNorth ? error.x()
                 : rule_.quantity == kMsaEast  ? error.y()
                                               : error.norm();
    }
    g[t] = g_of(quantity);
  }
}

rare::TrialAddresses addresses_of(const sensor::ReadingNormals& normals, random::Channel choice) {
  rare::TrialAddresses from{{}, choice};
  for (const sensor::NormalAddress& a : normals.calls) from.calls.push_back({a.channel, a.call});
  return from;
}

Eigen::VectorXd gradient_of(const sensor::NoiseWeights& weights, int sum, const sensor::ReadingNormals& normals) {
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(normals.rows());
  const auto add = [&](const std::vector<double>& w, int first) {
    if (first < 0) return;
    for (std::size_t r = 0; r * sensor::NoiseWeights::kSums < w.size(); ++r)
      slope[first + static_cast<Eigen::Index>(r)] = w[r * sensor::NoiseWeights::kSums + static_cast<std::size_t>(sum)];
  };
  add(weights.magnetometer, normals.magnetometer);
  add(weights.accelerometer, normals.accelerometer);
  add(weights.reference, normals.reference);
  add(weights.tool, normals.tool);
  return slope;
}

}  // namespace surveymc::analysis
