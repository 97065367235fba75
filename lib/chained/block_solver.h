#pragma once
/// Chained multistation as one least-squares problem on SO(3)^N x R^9N, by the descent of descent.h: block
/// tridiagonal with 12 x 12 blocks, bordered by the amplitudes of interference. Cost linear in stations.
#include "chained/basic_solution.h"
#include "chained/linearised_station.h"

namespace surveymc::chained {

/// Every station as `solver` solves it alone (the basic solution), chain and interference zero.
Point basic_start(const Model& model, const Readings& readings, const StationSolver& solver = basic_frame);

/// Minimises J (chain_cost) from `start`; covariances are those of Gauss-Newton's normal matrix at the minimum,
/// inverted block by block. Throws InputError for an invalid model; `status` says how it ended.
Solution solve_blocks(const Model& model, const Readings& readings, const Point& start, const Options& options = {});
Solution solve_blocks(const Model& model, const Readings& readings, const Options& options = {});

/// One station alone, its chain known beforehand as a Gaussian: what a filter minimises at `station`.
struct StationMinimum {
  Eigen::Matrix3d frame;
  ChainVector chain;
  Status status;
  int iterations;
};
StationMinimum solve_station(const Model& model, const Readings& readings, int station, const Eigen::Matrix3d& frame,
                             const ChainVector& mean, const ChainMatrix& covariance, const Options& options = {});

}  // namespace surveymc::chained
