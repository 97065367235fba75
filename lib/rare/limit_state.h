#pragma once
/// An event as a region of the standard normals a trial is made of: it happens where the limit state g(z) <= 0.
#include <Eigen/Core>

#include "survey/readings.h"

namespace surveymc::rare {

class LimitState {
 public:
  virtual ~LimitState() = default;
  /// n: how many normals a trial takes.
  virtual int dimension() const = 0;
  /// g of 8 `groups` trials; rows of `z` are their normals 0 .. n - 1. NaN: the trial has no result. The value of a
  /// trial does not depend on the others. Called from several threads.
  virtual void evaluate(const survey::LaneArray& z, int groups, double* g) const = 0;
  /// Numbers that the state reports of each hit beside g (marks() of them), and g together with these.
  virtual int marks() const { return 0; }
  virtual void evaluate_marked(const survey::LaneArray& z, int groups, double* g, double* /*marks*/) const {
    evaluate(z, groups, g);
  }
};

/// g of the points in the columns of `z` (n x count).
Eigen::VectorXd values_at(const LimitState& state, const Eigen::MatrixXd& z);

}  // namespace surveymc::rare
