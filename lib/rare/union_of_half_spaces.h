#pragma once
/// Sampling of a union of half spaces (Owen, Maximov and Chertkov 2019): the probability that any of several tests
/// rejects, at any level.
///
///   p_i = P(w_i > k_i), P = sum p_i;  draw half space i with probability p_i / P and w_i from its tail; the rest
///   stays; weight P / (number of half spaces that hold): bounded by P
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "random/stream.h"

namespace surveymc::rare {

/// w = direction . z > distance. `direction`: of unit length.
struct HalfSpace {
  Eigen::VectorXd direction;
  double distance = 0;
};

/// |w| > k as two half spaces.
void add_two_sided(const Eigen::VectorXd& direction, double k, std::vector<HalfSpace>& to);

class UnionSampler {
 public:
  /// All of one dimension, at least one.
  explicit UnionSampler(std::vector<HalfSpace> half_spaces);

  /// P: the upper bound of all weights, and Bonferroni's.
  double bound() const { return sum_; }
  int dimension() const { return static_cast<int>(half_spaces_.front().direction.size()); }
  /// Moves plain normals z to a trial of the union by two uniforms in (0, 1); the weight of the trial. `chosen`: the
  /// half space that was drawn.
  double draw(double choice, double tail, Eigen::VectorXd& z, std::size_t& chosen) const;
  std::uint64_t hash() const;

 private:
  std::vector<HalfSpace> half_spaces_;
  std::vector<double> p_;
  double sum_ = 0;
};

/// P(any |w_i| > k_i) of uncorrelated w with probabilities p_i: 1 - prod(1 - p_i), without cancellation.
double any_of_independent(const std::vector<double>& p);

}  // namespace surveymc::rare
