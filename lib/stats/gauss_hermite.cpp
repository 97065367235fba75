#include "stats/gauss_hermite.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace surveymc::stats {

GaussHermite gauss_hermite(int n) {
  // Orthonormal polynomials: x p_k = sqrt(k + 1) p_{k+1} + sqrt(k) p_{k-1}.
  const Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd beside(n - 1);
  for (int k = 1; k < n; ++k) beside[k - 1] = std::sqrt(static_cast<double>(k));
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
  GaussHermite q;
  for (int i = 0; i < n; ++i) {
    // The set is symmetric: the mean of both sides removes what rounding left.
    const double x = 0.5 * (solver.eigenvalues()[i] - solver.eigenvalues()[n - 1 - i]);
    // Christoffel: a weight is 1 / sum p_k^2, right to rounding even where eigenvectors have none of its digits.
    double before = 0, at = 1, sum = 0;
    for (int k = 0; k < n; ++k) {
      sum += at * at;
      const double next = (x * at - std::sqrt(static_cast<double>(k)) * before) / std::sqrt(k + 1.0);
      before = at;
      at = next;
    }
    q.nodes.push_back(x);
    q.weights.push_back(1 / sum);
  }
  return q;
}

}  // namespace surveymc::stats
