#pragma once
/// Chained multistation as one least-squares problem on SO(3)^N x R^9N, by the descent of chained_descent.h: block
/// tridiagonal with 12 x 12 blocks, bordered by the amplitudes of interference. Cost linear in stations.
#include "estimate/chained_linear.h"
#include "estimate/chained_start.h"

namespace surveymc {

/// Every station as `solver` solves it alone (the basic solution), chain and interference zero.
ChainedPoint basic_start(const ChainedModel& model, const ChainedReadings& readings,
                         const StationSolver& solver = basic_frame);

/// Minimises J (chained_cost) from `start`; covariances are those of Gauss-Newton's normal matrix at the minimum,
/// inverted block by block. Throws InputError for an invalid model; `status` says how it ended.
ChainedSolution solve_chained(const ChainedModel& model, const ChainedReadings& readings, const ChainedPoint& start,
                              const ChainedOptions& options = {});
ChainedSolution solve_chained(const ChainedModel& model, const ChainedReadings& readings,
                              const ChainedOptions& options = {});

/// One station alone, its chain known beforehand as a Gaussian: what a filter minimises at `station`.
struct StationMinimum {
  Eigen::Matrix3d frame;
  ChainVector chain;
  ChainedStatus status;
  int iterations;
};
StationMinimum solve_chained_station(const ChainedModel& model, const ChainedReadings& readings, int station,
                                     const Eigen::Matrix3d& frame, const ChainVector& mean,
                                     const ChainMatrix& covariance, const ChainedOptions& options = {});

}  // namespace surveymc
