#pragma once
/// A station of the chained model to first order, whitened by the noise of its readings.
#include <array>
#include <vector>

#include "estimate/chained_model.h"

namespace surveymc {

using ChainVector = Eigen::Matrix<double, kChainStates, 1>;

struct ChainedReadings {
  std::vector<StationReading> y;
  std::vector<std::array<bool, 6>> left_out = {};  ///< readings that are not to be used; empty: all are

  int stations() const { return static_cast<int>(y.size()); }
  bool used(int station, std::size_t axis) const {
    return left_out.empty() || !left_out[static_cast<std::size_t>(station)][axis];
  }
};

/// A place to linearise at, and to begin from.
struct ChainedPoint {
  std::vector<Eigen::Matrix3d> frames;
  std::vector<ChainVector> chain;
  Eigen::VectorXd interference;
};

/// e ~ residual - by_delta delta - by_chain dc - by_interference da, each row over its sd; 0 for readings left out.
struct StationLinear {
  Eigen::Matrix<double, 6, 1> residual;
  Eigen::Matrix<double, 6, 3> by_delta;                               ///< -[f]x, -[h - b_m]x
  Eigen::Matrix<double, 6, kChainStates> by_chain;                    ///< (-d, 1; n, d, 1)
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 3> by_interference;  ///< weight(k) M directions
};
StationLinear linearise(const ChainedModel& model, const ChainedReadings& readings, const ChainedPoint& at,
                        int station);

/// Turns frames and adds to the states: what a solver's step does to its point.
void step_station(ChainedPoint& point, int station, const Eigen::Vector3d& delta, const ChainVector& dc);

/// J at a point: squares of the whitened residuals, of the first station's states, of the links, of references where
/// they are independent, of interference.
double chained_cost(const ChainedModel& model, const ChainedReadings& readings, const ChainedPoint& at);

/// J of a solution's own frames and states.
ChainedPoint point_of(const ChainedSolution& solution);

/// Squared length of a step, in prior sd for the chain and mrad for the attitudes, mean over the stations.
double step_size2(const ChainedModel& model, const std::vector<Eigen::Vector3d>& delta,
                  const std::vector<ChainVector>& dc, const Eigen::VectorXd& da);

struct ChainedOptions {
  int max_iterations = 100;
  /// Converged when the root mean square step is below this part of a prior sd (of a mrad for attitudes).
  double step_tolerance = 1e-9;
  bool damped = true;  ///< Levenberg's damping; false: plain Gauss-Newton, which may not converge
};

}  // namespace surveymc
