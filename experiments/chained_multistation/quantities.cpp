#include "chained_multistation/quantities.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "base/units.h"
#include "chained/attitude.h"
#include "chained/basic_solution.h"
#include "compare/table_rows.h"
#include "config/readings_csv.h"

namespace surveymc::studies::chained_multistation {

using Vector12 = Eigen::Matrix<double, 12, 1>;

QuantityArray station_errors(const sensor::ChainedRun& run, const survey::ReferenceField& field, std::size_t k,
                             const Eigen::Matrix3d& frame, double gravity, double horizontal, double down) {
  const survey::Attitude at = chained::attitude_of(frame), &truth = run.attitudes[k];
  const auto& c = run.states[k];
  const auto degrees = [](double x) { return std::remainder(x, 2 * kPi) / kDegree; };
  return {degrees(at.azimuth - truth.azimuth),
          degrees(at.inclination - truth.inclination),
          degrees(at.toolface - truth.toolface),
          (gravity - field.gravity - c[0]) / kMilliG,
          horizontal - field.total * std::cos(field.dip) - c[1],
          down - field.total * std::sin(field.dip) - c[2]};
}

RunCheck check_alone(const Scenario& s, Solver estimator, const sensor::ChainedRun& run) {
  RunCheck out;
  const chained::Model m = s.model(chained::ChainReferences::chained);
  const chained::SingleWeights weights = chained::single_weights(m);
  for (std::size_t k = 0; k < run.readings.size(); ++k) {
    const chained::SingleStation x = estimator == Solver::base
                                         ? chained::basic_station(run.readings[k])
                                         : chained::fully_optimised_station(m, weights, run.readings[k]);
    StationCheck check;
    check.error = station_errors(run, s.field, k, x.frame, x.gravity, x.horizontal, x.down);
    check.claimed_sd.fill(kNaN);
    out.stations.push_back(check);
  }
  return out;
}

RunCheck check_chained(const Scenario& s, const sensor::ChainedRun& run, const chained::Solution& solution) {
  RunCheck out;
  out.status = solution.status;
  out.cost = solution.cost;
  const double bh = s.field.total * std::cos(s.field.dip), bd = s.field.total * std::sin(s.field.dip);
  for (std::size_t k = 0; k < run.readings.size(); ++k) {
    const chained::StationEstimate& e = solution.stations[k];
    StationCheck check;
    check.error =
        station_errors(run, s.field, k, e.frame, s.field.gravity + e.chain[0], bh + e.chain[1], bd + e.chain[2]);
    const Eigen::Vector3d angles = chained::attitude_sd(e.frame, e.covariance.topLeftCorner<3, 3>()) / kDegree;
    const Vector12 sd = e.covariance.diagonal().cwiseSqrt();
    check.claimed_sd = {angles[1], angles[0], angles[2], sd[3] / kMilliG, sd[4], sd[5]};
    Vector12 error;
    error.head<3>() = chained::rotation_between(run.frames[k], e.frame);
    error.tail<chained::kChainStates>() = e.chain - Eigen::Map<const chained::ChainVector>(run.states[k].data());
    for (std::size_t i = 0; i < kRunQuantities; ++i) check.z[i] = check.error[i] / check.claimed_sd[i];
    for (std::size_t i = kRunQuantities; i < kTestedStates; ++i) {
      const auto state = static_cast<Eigen::Index>(i);
      check.z[i] = error[state] / sd[state];
    }
    check.nees = error.dot(e.covariance.llt().solve(error));
    out.stations.push_back(check);
  }
  return out;
}

store::Table endings_table(const std::string& what, const char* kind, const char* meaning,
                           const std::vector<Endings>& endings, const stats::Tally& tally) {
  const bool is_empty = tally.counts.empty();
  compare::TableRows t("failures", what);
  const auto write = [&](const Endings& x) {
    for (std::size_t i = 0; i < stats::kDescentStatuses; ++i) {
      t.word(kind, meaning, x.name);
      t.word("status", "converged, or why not: iteration_limit, no_descent, saddle, not_finite",
             stats::kDescentStatusNames[i]);
      t.count("count", "trials", is_empty ? 0 : tally.counts[x.first + i]);
      t.count("trials", "trials run", tally.trials);
    }
  };
  compare::write_rows(t, is_empty ? std::vector<Endings>() : endings, write);
  return t.take();
}

}  // namespace surveymc::studies::chained_multistation
