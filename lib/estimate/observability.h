#pragma once
/// Combinations of parameters, gains and biases for example, that the stations determine or leave open.
///
/// Singular value decomposition of the residuals' Jacobian with its columns scaled to unit length (Belsley, Kuh and
/// Welsch 1980, chapter 3). It does not depend on the parameters' units, so that its condition is one of geometry
/// alone.
///   J diag(1 / |J_i|) = U diag(mu) V'
/// A small mu_j says that the residuals hardly change when the parameters move along v_j.
#include <array>
#include <span>
#include <string>

#include <Eigen/Core>

namespace surveymc::estimate {

/// Combinations of n parameters are numbered from the weakest.
struct Observability {
  Eigen::VectorXd singular_values;     ///< rising; n equal ones (1) if no two parameters are alike
  Eigen::VectorXd condition_indices;   ///< largest singular value over this one; infinite at zero
  Eigen::MatrixXd directions;          ///< column j: v_j, in units of 1 / |J_i|; its largest entry is > 0
  Eigen::VectorXd variance_inflation;  ///< variance over that with orthogonal columns
};

/// `jacobian`: residuals by parameters, one row a residual of unit variance. A parameter without any effect (a column
/// of zeros) is a combination of its own with singular value zero. Where there are fewer residuals than parameters, the
/// combinations that are left have singular value zero. `sizes`: of each parameter, in units in which columns can be
/// compared: one below kNoEffect of the longest, or of 1, is zero but for rounding. Empty: only zeros are.
Observability observability(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& sizes = {});
inline constexpr double kNoEffect = 1e-12;

/// Above kWeakCondition a combination is weak, and harms all results that depend on it (Belsley et al. 1980: 30 to 100,
/// "moderate to strong").
inline constexpr double kWeakCondition = 30, kSevereCondition = 100;
/// Above this condition, readings in double precision do not determine a combination.
inline constexpr double kHopelessCondition = 1e6;

inline constexpr std::array<const char*, 6> kParameterNames{"gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z"};
inline constexpr std::array<const char*, 6> kParameterUnits{"1", "1", "1", "nT", "nT", "nT"};
inline const char* parameter_name(int parameter) { return kParameterNames[static_cast<std::size_t>(parameter)]; }

/// The combination in words: "gain_z against bias_z" (errors of opposite sign), "gain_x with gain_y" (of the same).
/// Names parameters whose entry of `direction` is at least 0.4 of the largest, in the order of the parameters. `names`:
/// one an entry.
std::string combination_name(const Eigen::VectorXd& direction, std::span<const char* const> names = kParameterNames);

}  // namespace surveymc::estimate
