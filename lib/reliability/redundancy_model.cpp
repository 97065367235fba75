#include "reliability/redundancy_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "reliability/station_kernel.h"

namespace surveymc::reliability {

using Eigen::Index;

RedundancyModel::RedundancyModel(const std::vector<double>& w, const std::vector<double>& v, Index redundancy,
                                 double omega)
    : count_(w.size()), stride_((w.size() + 7) / 8 * 8), redundancy_(redundancy), omega_(omega), cleared_(0) {
  if (count_ > kMost) throw std::invalid_argument("too many observations");
  const std::size_t unknowns = v.size() / count_;
  std::array<double, kMost> column;  // of V: all products with one of its elements side by side
  column.fill(0);
  std::fill_n(matrix_.begin(), count_ * stride_, 0.0);
  for (std::size_t c = 0; c < unknowns; ++c) {
    for (std::size_t i = 0; i < count_; ++i) column[i] = v[i * unknowns + c];
    for (std::size_t i = 0; i < count_; ++i) {
      double* row = matrix_.data() + i * stride_;
      for (std::size_t j = 0; j < stride_; ++j) row[j] += column[i] * column[j];
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    double* row = matrix_.data() + i * stride_;
    for (std::size_t j = 0; j < stride_; ++j) row[j] = 0 - row[j];
    row[i] = 1 + row[i];
  }
  residuals_.fill(0);
  for (std::size_t i = 0; i < count_; ++i) {
    if (!(matrix_[i * (stride_ + 1)] > kLeastRedundancy) || w[i] == 0) {
      clear(i);
      continue;
    }
    residuals_[i] = w[i] * std::sqrt(matrix_[i * (stride_ + 1)]);
  }
  set_w();
}

RedundancyModel& RedundancyModel::operator=(const RedundancyModel& other) {
  count_ = other.count_;
  stride_ = other.stride_;
  redundancy_ = other.redundancy_;
  omega_ = other.omega_;
  cleared_ = other.cleared_;
  residuals_ = other.residuals_;
  w_ = other.w_;
  diagonal_ = other.diagonal_;
  std::copy_n(other.matrix_.begin(), count_ * stride_, matrix_.begin());
  return *this;
}

void RedundancyModel::set_w() {
  diagonal_.fill(0);
  for (std::size_t i = 0; i < count_; ++i) diagonal_[i] = matrix_[i * (stride_ + 1)];
  for (std::size_t i = 0; i < kMost; ++i) {
    const double redundancy = diagonal_[i], w = residuals_[i] / std::sqrt(redundancy > 0 ? redundancy : 1);
    w_[i] = redundancy > 0 ? w : 0;
  }
}

std::uint64_t RedundancyModel::inseparable_from(Index i) const {
  constexpr double kLeast = (1 - 1e-9) * (1 - 1e-9), kRounding = 2e-14;
  const auto own = static_cast<std::size_t>(i);
  const double* row = matrix_.data() + own * stride_;
  const double gi = diagonal_[own];
  std::array<std::int64_t, kMost> hits;  // all at once: nearly always there is no other
  std::int64_t any = 0;
  for (std::size_t j = 0; j < stride_; ++j) {
    const double gj = diagonal_[j], least = kLeast * (gi * gj) - kRounding * (gi > gj ? gi : gj);
    hits[j] = (row[j] * row[j] > least) & (gj > 0);
    any += hits[j];
  }
  if (!(gi > 0)) return 0;
  if (any == 1) return bit(own);
  std::uint64_t bits = 0;
  for (std::size_t j = 0; j < count_; ++j) bits |= static_cast<std::uint64_t>(hits[j]) << j;
  return bits;
}

std::array<double, RedundancyModel::kMost> RedundancyModel::pair_statistics(Index i) const {
  const auto own = static_cast<std::size_t>(i);
  const double ei = residuals_[own], gi = diagonal_[own], one = ei * ei / gi;
  const double* row = matrix_.data() + own * stride_;
  std::array<double, kMost> all;
  all.fill(one);
  for (std::size_t j = 0; j < stride_; ++j) {
    const double share = row[j] / gi, left = diagonal_[j] - share * row[j], more = residuals_[j] - share * ei;
    const bool counts = left > kLeastRedundancy * diagonal_[j];
    const double both = one + more * more / (counts ? left : 1);
    all[j] = counts ? both : one;
  }
  return all;
}

void RedundancyModel::clear(std::size_t k) {
  for (std::size_t i = 0; i < count_; ++i) matrix_[i * stride_ + k] = matrix_[k * stride_ + i] = 0;
  residuals_[k] = 0;
  cleared_ |= bit(k);
}

void RedundancyModel::remove(std::size_t k) {
  std::array<double, kMost> row;
  std::copy_n(matrix_.data() + k * stride_, stride_, row.data());
  const double per = 1 / row[k], e = residuals_[k];
  omega_ -= e * e * per;
  --redundancy_;
  for (std::size_t i = 0; i < count_; ++i) {
    const double share = row[i] * per;
    if (share == 0) continue;
    residuals_[i] -= share * e;
    double* at = matrix_.data() + i * stride_;
    for (std::size_t j = 0; j < stride_; ++j) at[j] -= share * row[j];
  }
  clear(k);
}

void RedundancyModel::reject(const std::vector<Index>& observations) {
  // The largest share that is left first, as in parity.h; what is in the span of the others takes no redundancy.
  // diagonal_ is still that of the whole.
  for (std::size_t n = 0; n < observations.size(); ++n) {
    std::size_t best = kMost;
    double most = kLeastRedundancy;
    for (const Index k : observations) {
      const double before = diagonal_[static_cast<std::size_t>(k)],
                   now = matrix_[static_cast<std::size_t>(k) * (stride_ + 1)];
      if (before > 0 && now / before > most) {  // one that was removed has none left
        best = static_cast<std::size_t>(k);
        most = now / before;
      }
    }
    if (best == kMost) break;
    remove(best);
  }
  for (const Index k : observations) clear(static_cast<std::size_t>(k));
  for (std::size_t i = 0; i < count_; ++i)
    if ((cleared_ & bit(i)) == 0 && (redundancy_ == 0 || !(matrix_[i * (stride_ + 1)] >= kLeastRedundancy))) clear(i);
  if (redundancy_ == 0) omega_ = 0;
  set_w();
}

void RedundancyFamily::begin(const RedundancyModel& whole) {
  if (members_.empty()) members_.push_back(std::make_unique<Member>());
  members_.front()->model = whole;
  used_ = 1;
}

const RedundancyModel& RedundancyFamily::without(const std::vector<Index>& observations) {
  for (std::size_t i = 0; i < used_; ++i)
    if (members_[i]->out == observations) return members_[i]->model;
  if (used_ == members_.size()) members_.push_back(std::make_unique<Member>());
  Member& m = *members_[used_++];
  m.out = observations;
  m.model = members_.front()->model;
  m.model.reject(observations);
  return m.model;
}

}  // namespace surveymc::reliability
