#pragma once
/// Combinations of gains and biases that the stations determine or leave open.
///
/// Singular value decomposition of the residuals' Jacobian with its columns scaled to unit length (Belsley, Kuh and
/// Welsch 1980, chapter 3). It does not depend on the parameters' units, so that its condition is one of geometry
/// alone.
///   J diag(1 / |J_i|) = U diag(mu) V'
/// A small mu_j says that the residuals hardly change when the parameters move along v_j.
#include <array>
#include <string>

#include <Eigen/Core>

namespace surveymc::estimate {

/// Combinations are numbered from the weakest. Parameters: gain x, y, z, bias x, y, z.
struct Observability {
  Eigen::Matrix<double, 6, 1> singular_values;     ///< rising; six equal ones (1) if no two parameters are alike
  Eigen::Matrix<double, 6, 1> condition_indices;   ///< largest singular value over this one; infinite at zero
  Eigen::Matrix<double, 6, 6> directions;          ///< column j: v_j, in units of 1 / |J_i|; its largest entry is > 0
  Eigen::Matrix<double, 6, 1> variance_inflation;  ///< variance over that with orthogonal columns
};

/// `jacobian`: residuals by parameters, one row a residual of unit variance, at least six rows. A parameter without any
/// effect (a column of zeros) is a combination of its own with singular value zero.
Observability observability(const Eigen::Matrix<double, Eigen::Dynamic, 6>& jacobian);

/// Above kWeakCondition a combination is weak, and harms all results that depend on it (Belsley et al. 1980: 30 to 100,
/// "moderate to strong").
inline constexpr double kWeakCondition = 30, kSevereCondition = 100;
/// Above this condition, readings in double precision do not determine a combination.
inline constexpr double kHopelessCondition = 1e6;

/// The combination in words: "gain_z against bias_z" (errors of opposite sign), "gain_x with gain_y" (of the same).
/// Names parameters whose entry of `direction` is at least 0.4 of the largest, in the order of the parameters.
std::string combination_name(const Eigen::Matrix<double, 6, 1>& direction);

inline constexpr std::array<const char*, 6> kParameterNames{"gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z"};
inline constexpr std::array<const char*, 6> kParameterUnits{"1", "1", "1", "nT", "nT", "nT"};
inline const char* parameter_name(int parameter) { return kParameterNames[static_cast<std::size_t>(parameter)]; }

}  // namespace surveymc::estimate
