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
  int state = 0;    ///< as of ChainState
  double value = 0, sd = 1;
};

struct Readings {
  std::vector<StationReading> y;
  std::vector<std::array<bool, 6>> left_out = {};  ///< readings that are not to be used; empty: all are
  std::vector<KnownState> known = {};              ///< for solve_blocks alone

  int stations() const { return static_cast<int>(y.size()); }
  bool used(int station, std::size_t axis) const {
    return left_out.empty() || !left_out[static_cast<std::size_t>(station)][axis];
  }
};

/// A place to linearise at, and to begin from.
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

/// Turns frames and adds to the states: what a solver's step does to its point.
void step_station(Point& point, int station, const Eigen::Vector3d& delta, const ChainVector& dc);

/// J at a point: squares of the whitened residuals, of the first station's states, of the links, of references where
/// they are independent, of interference.
double chain_cost(const Model& model, const Readings& readings, const Point& at);
/// The readings' part of it.
double readings_cost(const Model& model, const Readings& readings, const Point& at);

/// J of a solution's own frames and states.
Point point_of(const Solution& solution);

/// Squared length of a step, in prior sd for the chain and mrad for the attitudes, mean over the stations.
double step_size2(const Model& model, const std::vector<Eigen::Vector3d>& delta, const std::vector<ChainVector>& dc,
                  const Eigen::VectorXd& da);

/// What the cost has beyond first order at a station, whitened as above: half its Hessian is
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
/// `linear`: of the same station at the same point.
StationCurvature curvature(const Model& model, const StationLinear& linear, const Point& at, int station);

struct Options {
  int max_iterations = 200;  ///< steps tried, rejected ones included
  /// Converged when the undamped step d, of gradient g and quadratic model B (halves), satisfies both
  ///   sqrt(step_size2(d)) <= step_tolerance    (root mean square over the stations, in prior sd and in mrad)
  ///   g.B^-1 g <= gradient_tolerance (1 + J)   (what the model still promises J to fall by)
  double step_tolerance = 1e-9;
  double gradient_tolerance = 1e-10;
  /// A step is taken when J falls by more than this part of what the quadratic model promises.
  double least_gain = 1e-4;
  bool damped = true;  ///< false: plain Gauss-Newton, every step taken, which may not converge
};

}  // namespace surveymc::chained
