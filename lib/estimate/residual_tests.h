#pragma once
/// Do the residuals of an estimate fit the noise that was claimed for its inputs? One test of all of them, and one for
/// each (Baarda 1968; Teunissen 2000, chapter 4).
///
/// Under the null the residuals v = e + J dx, whatever the estimator made of dx, where e has the covariance
///   Q = blockdiag(Q_k) + U U',  Q_k station k's own noise, U the draws common to all stations (the reference field).
/// With M = Q^-1 - Q^-1 J (J' Q^-1 J)^-1 J' Q^-1, which J's columns vanish under, to first order
///   T = v' M v                        chi-squared with 2 n - 6 degrees
///   w_i = (M v)_i / sqrt(M_ii)        standard normal; the most powerful test of an error in residual i alone
///   (M v)_i / M_ii +- 1 / sqrt(M_ii)  the size of that error, if it is the only one
/// U are unknowns with a prior of their own, so that all costs are linear in the stations: one thin QR of
/// [Q_k^-1/2 (J_k U_k); 0 1].
#include <vector>

#include "estimate/field_misfit.h"
#include "estimate/input_errors.h"

namespace surveymc::estimate {

struct ResidualTests {
  double statistic = 0;  ///< T
  int redundancy = 0;    ///< its degrees of freedom, 2 n - 6
  /// Per station, components horizontal and vertical; NaN where no other reading checks the residual.
  std::vector<Eigen::Vector2d> w;
  std::vector<Eigen::Vector2d> error, error_sd;  ///< nT
  std::vector<Eigen::Vector2d> pull;             ///< per station: its part of M v, 1/nT
  std::vector<Eigen::Matrix2d> precision;        ///< per station: its block of M, 1/nT^2

  /// A-posteriori variance factor T / redundancy: 1 if the noise is as claimed. NaN without redundancy.
  double variance_factor() const;
};

/// `noise.magnetometer` must be positive. At least three stations.
ResidualTests residual_tests(const std::vector<survey::StationFields>& stations,
                             const std::vector<FieldMisfit>& misfits, const InputErrors& noise);

/// Test of an error that moves the two residuals of one station along c (nT per unit of the error): w = c'Mv /
/// sqrt(c'Mc), its size c'Mv / c'Mc and the sd of that. NaN where the residuals do not see it.
struct DirectionTest {
  double w, error, error_sd;
};
DirectionTest direction_test(const ResidualTests& tests, std::size_t station, const Eigen::Vector2d& c);
/// Correlation of the tests of two such errors: 1 or -1 if they cannot be told apart.
double direction_correlation(const ResidualTests& tests, std::size_t station, const Eigen::Vector2d& a,
                             const Eigen::Vector2d& b);

}  // namespace surveymc::estimate
