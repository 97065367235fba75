#pragma once
/// The model of chained multistation analysis (ISCWSA slides, chained multistation; decoded in
/// docs/studies/chained_multistation.md).
///
/// Notation of all files of this folder: at station k
///   M = [n e d]  directions of magnetic north, east and down in the tool frame: a rotation, free at every station
///   c            nine states that are chained from station to station, in the order of ChainState
///   f = -(g + e_g) d + b_a                       accelerometers: specific force, which points up (slides' sign)
///   h = (Bh + e_H) n + (Bd + e_D) d + b_m + i_k  magnetometers; i_k: external interference, if there is any
/// Readings y = (f, h) + noise. The tool frame is that of survey/frames.h; gravity_T there is -f.
#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "stats/descent.h"

namespace surveymc::chained {

inline constexpr int kChainStates = 9;
/// Index of the first component of each chained state.
enum ChainState {
  kGravityError = 0,         ///< e_g, m/s2: gravity less its reference
  kHorizontalError = 1,      ///< e_H, nT: horizontal field less its reference
  kDownError = 2,            ///< e_D, nT: downward field less its reference
  kAccelerometerOffset = 3,  ///< b_a x, y, z, m/s2
  kMagnetometerOffset = 6    ///< b_m x, y, z, nT
};
inline constexpr int kReferenceStates = 3;  ///< the first three
using ChainArray = std::array<double, kChainStates>;
/// Specific force x, y, z (m/s2), then magnetic field x, y, z (nT), tool frame.
using StationReading = std::array<double, 6>;

enum class ChainReferences {
  chained,     ///< errors of the references walk from station to station, like the sensors' offsets
  independent  ///< observed anew at every station, with reference_sd
};

/// Interference from the drill string or a casing left behind: a vector fixed in N that fades as the survey goes on,
///   i_k = (1 + rate k)^-2 M (directions a),  k = 0, 1, ...,
/// a: amplitudes, constant in a run, with a prior sd.
struct InterferenceModel {
  Eigen::Matrix3Xd directions = Eigen::Matrix3Xd(3, 0);  ///< one a column, N-E-V unit vectors; none: no interference
  double rate = 0.35;
  double prior_sd = 2000;  ///< nT

  Eigen::Index states() const { return directions.cols(); }
  double weight(int station) const { return 1 / ((1 + rate * station) * (1 + rate * station)); }
};

/// Sizes are one standard deviation each.
struct Model {
  double gravity = 9.80665, horizontal = 0, down = 0;   ///< references: m/s2, nT, nT
  StationReading noise{};                               ///< of a reading, independent from station to station
  ChainArray prior_sd{};                                ///< of c at the first station
  ChainArray link_sd{};                                 ///< of the change of c from a station to the next
  std::array<double, kReferenceStates> reference_sd{};  ///< with ChainReferences::independent, at every station
  ChainReferences references = ChainReferences::chained;
  InterferenceModel interference = {};

  bool independent() const { return references == ChainReferences::independent; }
};

/// The sizes that slide 7 lists of one kind of quantity.
struct ChainSize {
  double random = 0;  ///< s: of a reading, or of a reference
  double walk = 0;    ///< D: of the change from a station to the next
  double offset = 0;  ///< XO, of a sensor's offset; 0: by expected_offset
};
/// XO, "random value plus random walk effect (approx)", of n stations:
///   XO^2 = s^2 + D^2 (n + 1)(2 n + 1) / (6 n)
/// reproduces all five printed values of slide 7. If size.offset is given, the result is size.offset.
double expected_offset(const ChainSize& size, int stations);

/// Slide 7 as a model. Internal units.
struct ChainSizes {
  ChainSize accelerometer_xy, accelerometer_z, magnetometer_xy, magnetometer_z, gravity, field;
  double horizontal = 0, down = 0, gravity_reference = 9.80665;  ///< the references
};
/// prior_sd^2 = s^2 + D^2 for references and XO^2 + D^2 for sensors; reference_sd = XO.
Model make_model(const ChainSizes& sizes, int stations, ChainReferences references);

/// Throws InputError unless all sizes are positive and finite (walks may not be zero: the chain would be singular).
void check(const Model& model);

/// One station of a solution.
struct StationEstimate {
  Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();  ///< M: columns n, e, d
  Eigen::Matrix<double, kChainStates, 1> chain = Eigen::Matrix<double, kChainStates, 1>::Zero();
  /// Covariance of (delta, c): delta turns the frame, M_true = exp([delta]x) M, rad, tool axes; then the chained
  /// states.
  Eigen::Matrix<double, 12, 12> covariance = Eigen::Matrix<double, 12, 12>::Zero();
};

/// How an iteration ended.
using Status = stats::DescentStatus;

/// A step's size is the root mean square over the stations, in prior sd and in mrad (step_size2).
using Options = stats::DescentOptions;

struct Solution {
  bool converged = false;  ///< status is Status::converged
  Status status = Status::iteration_limit;
  int iterations = 0;  ///< steps tried, rejected ones included
  double cost = 0;     ///< J: squares of all whitened equations; chi-squared(3 stations) under the model
  /// ln det of half the Hessian of J by Gauss-Newton, of all unknowns in rad, m/s2 and nT. Set by solve_blocks alone.
  double log_determinant = 0;
  std::vector<StationEstimate> stations;
  Eigen::VectorXd interference;  ///< amplitudes, nT
  Eigen::MatrixXd interference_covariance;
};

}  // namespace surveymc::chained
