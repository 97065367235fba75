#include "analysis/msa_event.h"

#include <cmath>

#include "base/units.h"
#include "survey/corrected_position.h"

namespace surveymc::analysis {

MsaEvent::MsaEvent(const MsaTrials& trials, const estimate::Estimator& estimator, const MsaEventRule& rule)
    : trials_(trials),
      estimator_(estimator),
      rule_(rule),
      normals_(sensor::reading_normals(trials.survey.size(), trials.noise, trials.spread)),
      md_(trials.survey.md()),
      position_(survey::minimum_curvature_positions(trials.survey).back()) {}

void MsaEvent::evaluate(const survey::LaneArray& z, int groups, double* g) const {
  const int count = groups * simd::kGroup;
  survey::ReadingBlock readings = sensor::make_reading_block(count, trials_.survey.size(), trials_.noise);
  sensor::readings_of_normals(trials_.clean, trials_.field, trials_.noise, trials_.spread, normals_, z, groups,
                              readings);
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
      quantity = rule_.quantity == kMsaNorth ? error.x() : rule_.quantity == kMsaEast ? error.y() : error.norm();
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
