#pragma once
/// Chained multistation as one least-squares problem on SO(3)^N x R^9N, by the descent of descent.h: block
/// tridiagonal with 12 x 12 blocks, bordered by the amplitudes of interference. Cost linear in stations.
#include "chained/basic_solution.h"
#include "chained/linearised_station.h"

namespace surveymc::chained {

/// The point at which every station has the attitude that `solver` finds for it alone (the basic solution), and chain
/// and interference are zero.
Point basic_start(const Model& model, const Readings& readings, const StationSolver& solver = basic_frame);

/// Where a descent ended.
struct Ended {
  Point at;
  double cost = 0;  ///< J
  Status status = Status::iteration_limit;
  int iterations = 0;
};

/// Descends from `start`, for any model. Throws InputError for an invalid one.
Ended descend_blocks(const Model& model, const Readings& readings, const Point& start, const Options& options = {});

/// The solution at the end of a descent, with its covariances.
Solution solution_at(const Model& model, const Readings& readings, const Ended& end);

/// The rounding error of J. A whitened residual is the difference of two numbers of size y/s, each accurate to a part
/// of epsilon. So J, the sum of n squares, is accurate to 2 epsilon (y/s) sqrt(n J), and to epsilon of itself. The
/// result is four times that.
double cost_rounding(const Model& model, int stations, double cost);

/// Minimises J (chain_cost) from `start`; covariances are those of Gauss-Newton's normal matrix at the minimum,
/// inverted block by block. Throws InputError for an invalid model; `status` says how it ended.
Solution solve_blocks(const Model& model, const Readings& readings, const Point& start, const Options& options = {});
Solution solve_blocks(const Model& model, const Readings& readings, const Options& options = {});

/// One station alone, with a Gaussian prior of its chained states: the cost that a filter minimises at `station`.
struct StationMinimum {
  Eigen::Matrix3d frame;
  ChainVector chain;
  Status status;
  int iterations;
};
StationMinimum solve_station(const Model& model, const Readings& readings, int station, const Eigen::Matrix3d& frame,
                             const ChainVector& mean, const ChainMatrix& covariance, const Options& options = {});

}  // namespace surveymc::chained
