#pragma once
/// All tests for gross errors, in the space of the whitened misclosures.
///
/// Linear model of conditions: C (y - true y) = w with Cov(y) = Q diagonal. With L L' = C Q C' the misclosures
/// t = L^-1 w have unit covariance, and an error of one unit in observation i moves them by column a_i of A = L^-1 C:
///   Omega = |t|^2        (= e' P e, the paper's constrained sum of squares)
///   nabla_i = a_i.t / |a_i|^2 (eq 10),  w_i = a_i.t / |a_i| (eq 11),  r_i = sigma_i^2 |a_i|^2 (eq 21)
///   T = |projection of t onto the columns of Z|^2 (eqs 4, 7),  correlation of two tests = a_i.a_j / (|a_i||a_j|)
/// An observation that is taken out of the adjustment takes its direction with it: t and all columns lose it.
#include <vector>

#include <Eigen/Core>

namespace surveymc::reliability {

struct ParityModel {
  Eigen::MatrixXd columns;   ///< A: conditions x observations, per unit of each observation
  Eigen::VectorXd whitened;  ///< t
  Eigen::VectorXd variance;  ///< Q of the observations; 0 for one that is not there
  Eigen::Index redundancy;   ///< n - u: directions that are left

  Eigen::Index observations() const { return columns.cols(); }
  double omega() const { return whitened.squaredNorm(); }
};

/// From conditions C (m x n), their misclosures and the variances of y. C Q C' must be positive definite: throws
/// std::invalid_argument where it is not. Columns of observations that cannot be tested (r < 1e-10) are set to zero.
ParityModel parity_model(const Eigen::MatrixXd& conditions, const Eigen::VectorXd& misclosures,
                         const Eigen::VectorXd& variance);

/// The model without these observations. Those that can then no longer be tested have zero columns.
ParityModel without(const ParityModel& model, const std::vector<Eigen::Index>& observations);

/// r_i, all in [0, 1]; their sum is the redundancy.
Eigen::VectorXd redundancy_numbers(const ParityModel& model);
/// |w| of an error of one unit: lambda = |a_i| nabla, eq 13. 0: not testable.
Eigen::VectorXd sensitivities(const ParityModel& model);
/// Eq 11 for every observation. 0 where it is not testable.
Eigen::VectorXd w_statistics(const ParityModel& model);
/// Eq 10. NaN where the observation is not testable.
Eigen::VectorXd estimated_errors(const ParityModel& model);
/// Correlations of the w-statistics; 0 beside the unit diagonal for those that are not testable.
Eigen::MatrixXd test_correlations(const ParityModel& model);

/// T of eq 4 (variance known) for errors of all `observations` together, F of eq 5, tau2 of eq 6, with r = rank of Z.
/// F is +infinity and tau2 n-u over r where nothing is left of Omega; NaN for r = 0.
struct GeneralTest {
  double chi_squared, fisher, tau_squared;
  Eigen::Index rank;
};
GeneralTest general_test(const ParityModel& model, const std::vector<Eigen::Index>& observations);
/// The same for errors that are combinations of observations: Z, one column each (eq 1).
GeneralTest general_test(const ParityModel& model, const Eigen::MatrixXd& directions);

/// Eq 15: tau_i = w_i / sigma0, sigma0^2 = Omega / (n-u). NaN if Omega is 0.
Eigen::VectorXd pope_statistics(const ParityModel& model);

/// Of all errors in `observations` of one length, measured in their standard deviations, the one that shows least.
struct WeakestCombination {
  double detectable;          ///< its length when it is found as nabla_0 is; infinite if it never is
  Eigen::VectorXd direction;  ///< unit vector, in standard deviations; its largest entry is positive
};
WeakestCombination weakest_combination(const ParityModel& model, const std::vector<Eigen::Index>& observations,
                                       double lambda0);

/// Minimal detectable size of an error along a direction (a column of Z).
double detectable_along(const ParityModel& model, const Eigen::VectorXd& direction, double lambda0);

}  // namespace surveymc::reliability
