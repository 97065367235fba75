#pragma once
/// Variance components by groups of observations, from the residuals of a least-squares fit. W. Foerstner, Allgemeine
/// Vermessungs-Nachrichten 86, 1979: with the weights P of a group k, its residuals e and the trace of its redundancy
///   s_k^2 = e' P e / r_k,   r_k = trace(I - J N^-1 J' P)_k
/// the weights are divided by s_k^2 and the fit is made anew, until every s_k^2 is 1. GROOPS has the same as
/// "variance component estimation".
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace surveymc::multistation {

/// A fit with observations whose weights are those of `factors` (one variance factor a group).
struct GroupedFit {
  Eigen::VectorXd residuals;  ///< in units of the a-priori sd
  Eigen::MatrixXd jacobian;   ///< of them, a column a parameter
  Eigen::VectorXd weights;    ///< of each, without the factors: a robust fit's, or 1
  Eigen::MatrixXd inverse;    ///< (J'WJ + P)^-1 with the factors, P the priors' information
};

struct VarianceComponent {
  double factor = 1;       ///< s^2: variance over the a-priori one
  double redundancy = 0;   ///< r_k
  double sd = 0;           ///< of `factor`, if the noise is normal: factor sqrt(2 / r_k)
  bool estimated = false;  ///< false: r_k is below kFewestRedundant, the a-priori factor is kept
};

inline constexpr double kFewestRedundant = 3;

struct VarianceComponents {
  std::vector<VarianceComponent> groups;
  int iterations = 0;
  bool converged = false;  ///< every factor changed by less than a thousandth
};

/// `group`: of every residual, from 0. `fit(factors)` makes the fit with these variance factors.
VarianceComponents variance_components(const std::vector<int>& group, int groups,
                                       const std::function<GroupedFit(const std::vector<double>& factors)>& fit);

}  // namespace surveymc::multistation
