#include "chained_quantities.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "base/units.h"
#include "config/readings_csv.h"
#include "estimate/chained_attitude.h"
#include "estimate/chained_start.h"
#include "study/table_rows.h"

namespace surveymc {

using Vector12 = Eigen::Matrix<double, 12, 1>;

QuantityArray station_errors(const ChainedRun& run, const ReferenceField& field, std::size_t k,
                             const Eigen::Matrix3d& frame, double gravity, double horizontal, double down) {
  const Attitude at = attitude_of(frame), &truth = run.attitudes[k];
  const auto& c = run.states[k];
  const auto degrees = [](double x) { return std::remainder(x, 2 * kPi) / kDegree; };
  return {degrees(at.azimuth - truth.azimuth),
          degrees(at.inclination - truth.inclination),
          degrees(at.toolface - truth.toolface),
          (gravity - field.gravity - c[0]) / kMilliG,
          horizontal - field.total * std::cos(field.dip) - c[1],
          down - field.total * std::sin(field.dip) - c[2]};
}

RunCheck check_alone(const ChainedScenario& s, ChainedEstimator estimator, const ChainedRun& run) {
  RunCheck out;
  const ChainedModel m = s.model(ChainReferences::chained);
  const SingleWeights weights = single_weights(m);
  for (std::size_t k = 0; k < run.readings.size(); ++k) {
    const SingleStation x = estimator == ChainedEstimator::base ? basic_station(run.readings[k])
                                                                : fully_optimised_station(m, weights, run.readings[k]);
    StationCheck check;
    check.error = station_errors(run, s.field, k, x.frame, x.gravity, x.horizontal, x.down);
    check.claimed_sd.fill(std::nan(""));
    out.stations.push_back(check);
  }
  return out;
}

RunCheck check_chained(const ChainedScenario& s, const ChainedRun& run, const ChainedSolution& solution) {
  RunCheck out;
  out.status = solution.status;
  out.cost = solution.cost;
  const double bh = s.field.total * std::cos(s.field.dip), bd = s.field.total * std::sin(s.field.dip);
  for (std::size_t k = 0; k < run.readings.size(); ++k) {
    const StationEstimate& e = solution.stations[k];
    StationCheck check;
    check.error =
        station_errors(run, s.field, k, e.frame, s.field.gravity + e.chain[0], bh + e.chain[1], bd + e.chain[2]);
    const Eigen::Vector3d angles = attitude_sd(e.frame, e.covariance.topLeftCorner<3, 3>()) / kDegree;
    const Vector12 sd = e.covariance.diagonal().cwiseSqrt();
    check.claimed_sd = {angles[1], angles[0], angles[2], sd[3] / kMilliG, sd[4], sd[5]};
    Vector12 error;
    error.head<3>() = rotation_between(run.frames[k], e.frame);
    error.tail<kChainStates>() = e.chain - Eigen::Map<const ChainVector>(run.states[k].data());
    for (std::size_t i = 0; i < kChainedQuantities; ++i) check.z[i] = check.error[i] / check.claimed_sd[i];
    for (std::size_t i = kChainedQuantities; i < kChainedZ; ++i) {
      const auto state = static_cast<Eigen::Index>(i);
      check.z[i] = error[state] / sd[state];
    }
    check.nees = error.dot(e.covariance.llt().solve(error));
    out.stations.push_back(check);
  }
  return out;
}

Table endings_table(const std::string& what, const char* kind, const char* meaning,
                    const std::vector<ChainedEndings>& endings, std::uint64_t trials) {
  TableRows t("failures", what);
  const auto write = [&](const ChainedEndings& x) {
    for (std::size_t i = 0; i < kChainedStatuses; ++i) {
      t.word(kind, meaning, x.name);
      t.word("status", "converged, or why not: iteration_limit, no_descent, saddle, not_finite",
             kChainedStatusNames[i]);
      t.count("count", "trials", x.counts[i]);
      t.count("trials", "trials run", trials);
    }
  };
  write_rows(t, endings, write);
  return t.take();
}

}  // namespace surveymc
