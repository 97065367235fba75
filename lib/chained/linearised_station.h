#pragma once
/// A station of the chained model to first order, whitened by the noise of its readings.
#include <array>
#include <vector>

#include "chained/model.h"

namespace surveymc::chained {

using ChainVector = Eigen::Matrix<double, kChainStates, 1>;
using ChainMatrix = Eigen::Matrix<double, kChainStates, kChainStates>;

/// A chained state that is known from elsewhere: adds ((c - value) / sd)^2 to the cost.
struct KnownState {
  int station = 0;  ///< from 0
  int state = 0;    ///< as in ChainState
  double value = 0, sd = 1;
};

struct Readings {
  std::vector<StationReading> y;
  std::vector<std::array<bool, 6>> left_out = {};  ///< readings not to be used; empty: all are used
  std::vector<KnownState> known = {};              ///< read by solve_blocks alone

  int stations() const { return static_cast<int>(y.size()); }
  bool used(int station, std::size_t axis) const {
    return left_out.empty() || !left_out[static_cast<std::size_t>(station)][axis];
  }
};

/// A point of linearisation, or the start of an iteration.
struct Point {
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
StationLinear linearise(const Model& model, const Readings& readings, const Point& at, int station);

/// Applies a solver's step to its point: turns frames and adds to the states.
void step_station(Point& point, int station, const Eigen::Vector3d& delta, const ChainVector& dc);

/// J at a point: squares of the whitened residuals, of the first station's states, of the links, of references where
/// they are independent, of interference.
double chain_cost(const Model& model, const Readings& readings, const Point& at);
/// The part of J that comes from the readings.
double readings_cost(const Model& model, const Readings& readings, const Point& at);

/// J of a solution's own frames and states.
Point point_of(const Solution& solution);

/// Squared length of a step, in prior sd for the chain and mrad for the attitudes, mean over the stations.
double step_size2(const Model& model, const std::vector<Eigen::Vector3d>& delta, const std::vector<ChainVector>& dc,
                  const Eigen::VectorXd& da);

/// Second-order terms of the cost at a station, whitened as above: half the Hessian is
///   J'J - (delta_delta, delta_chain, delta_interference; their transposes)
/// with u = W e, the residual over its variance:
///   delta_delta        = sum of (u v' + v u')/2 - (u.v) 1   over (u_f, f) and (u_h, h)
///   delta_chain        = -d x u_f to e_g,  n x u_h to e_H,  d x u_h to e_D;  0 to offsets
///   delta_interference = weight(k) (M directions) x u_h.
struct StationCurvature {
  Eigen::Matrix3d delta_delta;
  Eigen::Matrix<double, 3, kReferenceStates> delta_chain;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> delta_interference;
};
/// `linear` belongs to the same station and point.
StationCurvature curvature(const Model& model, const StationLinear& linear, const Point& at, int station);

}  // namespace surveymc::chained
