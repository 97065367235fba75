#pragma once
/// Moments by a few values of F: sigma points in the r directions that matter, the rest by first order and the trace of
/// its curvature at the centre.
///   unscented  0 and +-sqrt 3 e_i, weights (3 - r) / 3 and 1 / 6: kappa = 3 - r (Julier and Uhlmann 2004); 2 r + 1
///   cubature5  0, +-sqrt 3 e_i, +-sqrt 3 e_i +- sqrt 3 e_j, weights (4 - r) / 18 and 1 / 36 of the latter two: exact
///              for polynomials of degree 5 (Stroud 1971, E_n^r2 5-2); 2 r^2 + 1
/// With r > 3 some weights are negative, and the covariance may lose its definiteness.
#include "orders/chain.h"

namespace surveymc::orders {

struct SigmaPointMoments {
  Moments moments;
  int values = 0;           ///< of F
  bool is_definite = true;  ///< false: the covariance is none
};

/// `directions`: d x r, orthonormal. NaN where F has no value at one of the points.
SigmaPointMoments unscented(const Chain& chain, const Centre& centre, const Eigen::MatrixXd& directions);
SigmaPointMoments cubature5(const Chain& chain, const Centre& centre, const Eigen::MatrixXd& directions);

}  // namespace surveymc::orders
