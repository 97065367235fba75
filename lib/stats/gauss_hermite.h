#pragma once
#include <vector>

namespace surveymc::stats {

/// Nodes and weights of Gauss-Hermite quadrature for the standard normal: E f(z) = sum weight f(node), exact for
/// polynomials of degree 2 n - 1. Nodes are eigenvalues of the
/// recurrence's matrix (Golub and Welsch 1969).
struct GaussHermite {
  std::vector<double> nodes, weights;
};
GaussHermite gauss_hermite(int n);

}  // namespace surveymc::stats
