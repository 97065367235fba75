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
#include <cstdint>
#include <memory>
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
  bool is_testable(Eigen::Index i) const { return diagonal_[static_cast<std::size_t>(i)] > 0; }
  /// The observations with |rho| > 1 - 1e-9, i itself too, as bits, to the rounding of G, which after some rejections
  /// is large beside an observation of which little is left. None where i cannot be tested.
  std::uint64_t inseparable_from(Eigen::Index i) const;
  /// How much Omega falls without i and another one, for each other one.
  std::array<double, kMost> pair_statistics(Eigen::Index i) const;

  /// Takes observations out.
  void reject(const std::vector<Eigen::Index>& observations);

  RedundancyModel() : count_(0), stride_(0), redundancy_(0), omega_(0), cleared_(0) {}
  RedundancyModel(const RedundancyModel& other) { *this = other; }
  RedundancyModel& operator=(const RedundancyModel& other);

 private:
  double at(Eigen::Index i, Eigen::Index j) const {
    return matrix_[static_cast<std::size_t>(i) * stride_ + static_cast<std::size_t>(j)];
  }
  static constexpr std::uint64_t bit(std::size_t k) { return std::uint64_t{1} << k; }
  void remove(std::size_t k);
  void clear(std::size_t k);
  void set_w();

  std::size_t count_, stride_;  ///< stride_: from a row to the next, count_ in whole registers
  Eigen::Index redundancy_;
  double omega_;
  std::uint64_t cleared_;  ///< bits of the observations that have no row
  // No memory is asked for in a search, and a copy takes no more than the rows that there are.
  std::array<double, kMost> residuals_, w_, diagonal_;  ///< diagonal_: of the matrix, when nothing is being taken out
  std::array<double, kMost * kMost> matrix_;
};

/// A trial's model, and what is left of it without some observations, each computed once: the searches of a trial
/// reject the same few again and again. The memory serves the next trial, too.
class RedundancyFamily {
 public:
  void begin(const RedundancyModel& whole);
  /// Without these, in any order, in time for no more than a copy and its rejections. Valid until begin().
  const RedundancyModel& without(const std::vector<Eigen::Index>& observations);

 private:
  struct Member {
    std::vector<Eigen::Index> out;
    RedundancyModel model;
  };
  std::vector<std::unique_ptr<Member>> members_;  ///< the first `used_`; the very first is the whole
  std::size_t used_ = 0;
};

/// As the functions of the same names in snooping.h.
std::vector<SuspectGroup> inseparable_groups(const RedundancyModel& model);
SnoopingResult data_snooping(RedundancyFamily& family, double critical);
SnoopingResult iterative_snooping(RedundancyFamily& family, double critical);
SnoopingResult iterative_snooping_with_readmission(RedundancyFamily& family, double critical);
SnoopingResult pair_search(RedundancyFamily& family, double critical);

}  // namespace surveymc::reliability
