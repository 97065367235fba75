#pragma once
/// The linear model of an adjustment as its redundancy matrix, in standard deviations: what searches for gross errors
/// need, in less time than by parity.h.
///
///   G = D C' (C Q C')^-1 C D = I - V V',  D D = Q,  e = residuals,  Omega = |e|^2
///   w_i = e_i / sqrt(G_ii),  r_i = G_ii,  correlation of two tests = G_ij / sqrt(G_ii G_jj)
/// Without observation k: G - b b', b = G_k / sqrt(G_kk),  e - b c, c = e_k / sqrt(G_kk),  Omega - c^2. A search asks
/// for the diagonal and for few rows, so that a model without some observations keeps their rows b, and no matrix.
/// These are the quantities of parity.h: a_i.a_j = G_ij / (sd_i sd_j), a_i.t = e_i / sd_i.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "reliability/snooping.h"

namespace surveymc::reliability {

class RedundancyModel {
 public:
  static constexpr std::size_t kMost = 32;  ///< observations
  using Row = std::array<double, kMost>;    ///< a number for each observation; without meaning beyond the last

  /// From V (n x u, row by row, of orthonormal columns) and the n tests w. Observations with w = 0 cannot be tested.
  /// `redundancy`: n - u. Throws std::invalid_argument for more than kMost observations.
  void set(std::size_t n, const double* w, std::size_t u, const double* v, double omega);
  /// What is left of `whole`, which set() made, without these observations. It refers to `whole`.
  void set_without(const RedundancyModel& whole, const std::vector<Eigen::Index>& observations);

  Eigen::Index observations() const { return static_cast<Eigen::Index>(count_); }
  Eigen::Index redundancy() const { return redundancy_; }
  double omega() const { return omega_; }
  /// 0 where it cannot be tested.
  double w(Eigen::Index i) const { return w_[static_cast<std::size_t>(i)]; }
  bool is_testable(Eigen::Index i) const { return diagonal_[static_cast<std::size_t>(i)] > 0; }
  /// The observations with |rho| > 1 - 1e-9, i itself too, as bits, to the rounding of G, which after some rejections
  /// is large beside an observation of which little is left. None where i cannot be tested.
  std::uint64_t inseparable_from(Eigen::Index i) const;
  /// How much Omega falls without i and j, for each j > i.
  void pair_statistics(Eigen::Index i, Row& out) const;

  RedundancyModel() = default;
  RedundancyModel(const RedundancyModel&) = delete;
  RedundancyModel& operator=(const RedundancyModel&) = delete;

 private:
  /// Row k of G, in whole registers.
  void row(std::size_t k, Row& out) const;
  void take_out(std::size_t k);
  void set_w();

  static constexpr std::size_t kRegister = 8;
  std::size_t count_ = 0, stride_ = 0;  ///< stride_: count_ in whole registers
  Eigen::Index redundancy_ = 0;
  double omega_ = 0;
  const RedundancyModel* whole_ = nullptr;  ///< null: this is one
  std::size_t taken_ = 0;                   ///< rows b
  // No memory is asked for in a search.
  Row residuals_, w_, diagonal_;              ///< diagonal_: of G; 0: not testable
  std::array<double, kMost * kMost> matrix_;  ///< of the whole: G; otherwise the rows b. stride_ from row to row
};

/// A trial's model, and what is left of it without some observations, each computed once: the searches of a trial
/// reject the same few again and again. The memory serves the next trial, too.
class RedundancyFamily {
 public:
  /// Of the next trial: to be set().
  RedundancyModel& begin() {
    used_ = 0;
    return whole_;
  }
  const RedundancyModel& whole() const { return whole_; }
  /// Without these, in any order. Valid until begin().
  const RedundancyModel& without(const std::vector<Eigen::Index>& observations);

 private:
  struct Member {
    std::vector<Eigen::Index> out;
    RedundancyModel model;
  };
  RedundancyModel whole_;
  std::vector<std::unique_ptr<Member>> members_;  ///< the first `used_`
  std::size_t used_ = 0;
};

/// As the functions of the same names in snooping.h.
std::vector<SuspectGroup> inseparable_groups(const RedundancyModel& model);
SnoopingResult data_snooping(RedundancyFamily& family, double critical);
SnoopingResult iterative_snooping(RedundancyFamily& family, double critical);
SnoopingResult iterative_snooping_with_readmission(RedundancyFamily& family, double critical);
SnoopingResult pair_search(RedundancyFamily& family, double critical);

}  // namespace surveymc::reliability
