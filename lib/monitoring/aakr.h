#pragma once
/// Auto-associative kernel regression (AAKR): predicts the reading of every sensor from the readings of all sensors.
#include <vector>

#include "monitoring/samples.h"

namespace surveymc::monitoring {

struct AakrBatch;

/// Boechat, Moreno and Haramura, eqs 1-3 with the kernel of eq 2 corrected:
///   u_i^2 = |X_i - x|^2,  w_i = exp(-(u_i^2 - min u^2) / (2 h^2)),  xhat = sum_i w_i X_i / sum_i w_i
/// The shift by the least distance cancels in the quotient; without it a query far from the memory is 0 / 0.
/// Memory and queries are scaled (z). Weights are computed to 1e-13 of their values. Same bits on every instruction
/// set.
///
/// Vectors beyond the cutoff, u_i^2 - min u^2 > 2 h^2 ln(2 m / kNegligibleShare), may be left out: all of them together
/// weigh less than kNegligibleShare of the nearest, so that no prediction moves by more of the memory's extent.
class Aakr {
 public:
  /// memory: m x p, at least one row and one column; bandwidth > 0 (InputError otherwise).
  Aakr(const Samples& memory, double bandwidth);

  int sensors() const { return sensors_; }
  int vectors() const { return vectors_; }
  double bandwidth() const { return bandwidth_; }

  static constexpr double kNegligibleShare = 1e-13;
  /// Of the square of a distance beyond that of the nearest vector.
  double cutoff() const;

  /// Memory that predictions of many queries use again: one per thread.
  using Scratch = std::vector<double>;
  /// queries: count x p, row by row; predictions the same; nearest (count): distance to the nearest memory vector, the
  /// indicator of operation outside of the training range. It costs half as much again; null: not wanted.
  void predict(const double* queries, int count, double* predictions, double* nearest, Scratch& scratch) const;
  /// The same as the kernel sees it (aakr_lanes.h).
  AakrBatch batch(const double* queries, int count, double* predictions, double* nearest, Scratch& scratch) const;

 private:
  int sensors_, vectors_;
  double bandwidth_;
  std::size_t padded_;
  double scale_;
  Eigen::VectorXd direction_;
  double largest_norm_ = 0;
  std::vector<double> memory_, low_, high_;  // scaled: aakr_lanes.h
};

}  // namespace surveymc::monitoring
