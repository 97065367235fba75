#pragma once
/// The linear model of an adjustment as its redundancy matrix, in standard deviations: what searches for gross errors
/// need, in less time than by parity.h.
///
///   G = D C' (C Q C')^-1 C D = I - V V',  D D = Q,  e = residuals,  Omega = |e|^2
///   w_i = e_i / sqrt(G_ii),  r_i = G_ii,  correlation of two tests = G_ij / sqrt(G_ii G_jj)
/// Without observation k: G - G_k G_k' / G_kk,  e - G_k e_k / G_kk,  Omega - e_k^2 / G_kk.
/// These are the quantities of parity.h: a_i.a_j = G_ij / (sd_i sd_j), a_i.t = e_i / sd_i.
#include <array>
#include <cstddef>
#include <vector>

#include "reliability/snooping.h"

namespace surveymc::reliability {

class RedundancyModel {
 public:
  static constexpr std::size_t kMost = 32;  ///< observations

  /// From V (n x u, row by row, of orthonormal columns) and w. Observations with w = 0 cannot be tested. `redundancy`:
  /// n - u. Throws std::invalid_argument for more than kMost observations.
  RedundancyModel(const std::vector<double>& w, const std::vector<double>& v, Eigen::Index redundancy, double omega);

  Eigen::Index observations() const { return static_cast<Eigen::Index>(count_); }
  Eigen::Index redundancy() const { return redundancy_; }
  double omega() const { return omega_; }
  /// 0 where it cannot be tested.
  double w(Eigen::Index i) const { return w_[static_cast<std::size_t>(i)]; }
  bool is_testable(Eigen::Index i) const { return at(i, i) > 0; }
  /// |rho| > 1 - 1e-9 of two observations, to the rounding of G, which after some rejections is large beside an
  /// observation of which little is left.
  bool are_inseparable(Eigen::Index i, Eigen::Index j) const {
    constexpr double kLeast = (1 - 1e-9) * (1 - 1e-9), kRounding = 2e-14;
    const double gi = at(i, i), gj = at(j, j), both = at(i, j) * at(i, j);
    return gi > 0 && gj > 0 && both > kLeast * (gi * gj) - kRounding * (gi > gj ? gi : gj);
  }
  /// How much Omega falls without both.
  double pair_statistic(Eigen::Index i, Eigen::Index j) const;

  RedundancyModel without(const std::vector<Eigen::Index>& observations) const;

  RedundancyModel(const RedundancyModel& other) { *this = other; }
  RedundancyModel& operator=(const RedundancyModel& other);

 private:
  double at(Eigen::Index i, Eigen::Index j) const {
    return matrix_[static_cast<std::size_t>(i) * stride_ + static_cast<std::size_t>(j)];
  }
  void remove(std::size_t k);
  void clear(std::size_t k);
  void set_w();

  std::size_t count_, stride_;  ///< stride_: from a row to the next, count_ in whole registers
  Eigen::Index redundancy_;
  double omega_;
  // No memory is asked for in a search, and a copy takes no more than the rows that there are.
  std::array<double, kMost> residuals_, w_;
  std::array<double, kMost * kMost> matrix_;
};

/// As the functions of the same names in snooping.h.
std::vector<SuspectGroup> inseparable_groups(const RedundancyModel& model);
SnoopingResult data_snooping(const RedundancyModel& model, double critical);
SnoopingResult iterative_snooping(const RedundancyModel& model, double critical);
SnoopingResult iterative_snooping_with_readmission(const RedundancyModel& model, double critical);
SnoopingResult pair_search(const RedundancyModel& model, double critical);

}  // namespace surveymc::reliability
