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
  solver.computeFromTridiagonal(diagonal, beside);
  GaussHermite q;
  for (int i = 0; i < n; ++i) {
    // The set is symmetric: the mean of both sides removes what rounding left.
    const double x = 0.5 * (solver.eigenvalues()[i] - solver.eigenvalues()[n - 1 - i]);
    const double v = solver.eigenvectors()(0, i), w = solver.eigenvectors()(0, n - 1 - i);
    q.nodes.push_back(x);
    q.weights.push_back(0.5 * (v * v + w * w));
  }
  return q;
}

}  // namespace surveymc::stats
