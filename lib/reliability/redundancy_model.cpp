#include "reliability/redundancy_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "reliability/station_kernel.h"

namespace surveymc::reliability {

using Eigen::Index;

namespace {

/// -V V' from the u columns of V; kStride doubles from column to column and from row to row, a row in registers.
template <std::size_t kStride>
void minus_products(std::size_t n, std::size_t u, const double* columns, double* out) {
  for (std::size_t i = 0; i < n; ++i) {
    std::array<double, kStride> sum{};
    for (std::size_t c = 0; c < u; ++c) {
      const double* column = columns + c * kStride;
      const double own = -column[i];
      for (std::size_t j = 0; j < kStride; ++j) sum[j] = std::fma(own, column[j], sum[j]);
    }
    for (std::size_t j = 0; j < kStride; ++j) out[i * kStride + j] = sum[j];
  }
}

}  // namespace

void RedundancyModel::set(std::size_t n, const double* w, std::size_t u, const double* v, double omega) {
  if (n > kMost) throw std::invalid_argument("too many observations");
  count_ = n;
  stride_ = (n + kRegister - 1) / kRegister * kRegister;
  redundancy_ = static_cast<Index>(n) - static_cast<Index>(u);
  omega_ = omega;
  whole_ = nullptr;
  taken_ = 0;
  std::array<double, kMost * kMost> columns;  // of V, one after the other
  std::fill_n(columns.begin(), u * stride_, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < u; ++c) columns[c * stride_ + i] = v[i * u + c];
  static_assert(kMost == 4 * kRegister);
  const auto products = stride_ <= kRegister       ? minus_products<kRegister>
                        : stride_ == 2 * kRegister ? minus_products<2 * kRegister>
                        : stride_ == 3 * kRegister ? minus_products<3 * kRegister>
                                                   : minus_products<4 * kRegister>;
  products(n, u, columns.data(), matrix_.data());
  for (std::size_t i = 0; i < n; ++i) matrix_[i * (stride_ + 1)] += 1;
  residuals_.fill(0);
  diagonal_.fill(0);
  for (std::size_t i = 0; i < n; ++i) {
    const double redundancy = matrix_[i * (stride_ + 1)];
    if (!(redundancy > kLeastRedundancy) || w[i] == 0) {
      for (std::size_t j = 0; j < n; ++j) matrix_[i * stride_ + j] = matrix_[j * stride_ + i] = 0;
      continue;
    }
    diagonal_[i] = redundancy;
    residuals_[i] = w[i] * std::sqrt(redundancy);
  }
  set_w();
}

void RedundancyModel::set_w() {
  for (std::size_t i = 0; i < stride_; ++i) {
    const double redundancy = diagonal_[i], w = residuals_[i] / std::sqrt(redundancy > 0 ? redundancy : 1);
    w_[i] = redundancy > 0 ? w : 0;
  }
}

void RedundancyModel::row(std::size_t k, Row& out) const {
  const double* whole = (whole_ ? whole_ : this)->matrix_.data() + k * stride_;
  for (std::size_t j = 0; j < stride_; ++j) out[j] = whole[j];
  for (std::size_t n = 0; n < taken_; ++n) {
    const double* b = matrix_.data() + n * stride_;
    const double own = -b[k];
    for (std::size_t j = 0; j < stride_; ++j) out[j] = std::fma(own, b[j], out[j]);
  }
}

std::uint64_t RedundancyModel::inseparable_from(Index i) const {
  constexpr double kLeast = (1 - 1e-9) * (1 - 1e-9), kRounding = 2e-14;
  const auto own = static_cast<std::size_t>(i);
  const double gi = diagonal_[own];
  if (!(gi > 0)) return 0;
  Row g;
  row(own, g);
  std::array<std::int64_t, kMost> hits;  // all at once: nearly always there is no other
  std::int64_t any = 0;
  for (std::size_t j = 0; j < stride_; ++j) {
    const double gj = diagonal_[j], least = kLeast * (gi * gj) - kRounding * (gi > gj ? gi : gj);
    hits[j] = (g[j] * g[j] > least) & (gj > 0);
    any += hits[j];
  }
  if (any == 1) return std::uint64_t{1} << own;
  std::uint64_t bits = 0;
  for (std::size_t j = 0; j < count_; ++j) bits |= static_cast<std::uint64_t>(hits[j]) << j;
  return bits;
}

void RedundancyModel::pair_statistics(Index i, Row& out) const {
  const auto own = static_cast<std::size_t>(i);
  const double ei = residuals_[own], per = 1 / diagonal_[own], one = ei * ei * per;
  Row g;
  row(own, g);
  for (std::size_t j = own / kRegister * kRegister; j < stride_; ++j) {
    const double share = g[j] * per, left = diagonal_[j] - share * g[j], more = residuals_[j] - share * ei;
    const bool counts = left > kLeastRedundancy * diagonal_[j];
    const double both = one + more * more / (counts ? left : 1);
    out[j] = counts ? both : one;
  }
}

void RedundancyModel::take_out(std::size_t k) {
  Row g;
  row(k, g);
  const double per = 1 / std::sqrt(g[k]), share = residuals_[k] * per;
  double* b = matrix_.data() + taken_ * stride_;
  for (std::size_t j = 0; j < stride_; ++j) {
    b[j] = g[j] * per;
    diagonal_[j] = std::fma(-b[j], b[j], diagonal_[j]);
    residuals_[j] = std::fma(-b[j], share, residuals_[j]);
  }
  ++taken_;
  --redundancy_;
  omega_ = std::fma(-share, share, omega_);
  diagonal_[k] = residuals_[k] = 0;
}

void RedundancyModel::set_without(const RedundancyModel& whole, const std::vector<Index>& observations) {
  count_ = whole.count_;
  stride_ = whole.stride_;
  redundancy_ = whole.redundancy_;
  omega_ = whole.omega_;
  whole_ = &whole;
  taken_ = 0;
  residuals_ = whole.residuals_;
  diagonal_ = whole.diagonal_;
  // The largest share that is left first, as in parity.h; what is in the span of the others takes no redundancy.
  for (std::size_t n = 0; n < observations.size(); ++n) {
    std::size_t best = kMost;
    double most = kLeastRedundancy;
    for (const Index i : observations) {
      const auto k = static_cast<std::size_t>(i);
      const double before = whole.diagonal_[k];
      if (before > 0 && diagonal_[k] / before > most) {  // one that was taken out has none left
        best = k;
        most = diagonal_[k] / before;
      }
    }
    if (best == kMost) break;
    take_out(best);
  }
  for (const Index k : observations) diagonal_[static_cast<std::size_t>(k)] = 0;
  for (std::size_t i = 0; i < stride_; ++i) {
    const bool stays = redundancy_ > 0 && diagonal_[i] >= kLeastRedundancy;
    diagonal_[i] = stays ? diagonal_[i] : 0;
    residuals_[i] = stays ? residuals_[i] : 0;
  }
  if (redundancy_ == 0) omega_ = 0;
  set_w();
}

const RedundancyModel& RedundancyFamily::without(const std::vector<Index>& observations) {
  if (observations.empty()) return whole_;
  for (std::size_t i = 0; i < used_; ++i)
    if (members_[i]->out == observations) return members_[i]->model;
  if (used_ == members_.size()) members_.push_back(std::make_unique<Member>());
  Member& m = *members_[used_++];
  m.out = observations;
  m.model.set_without(whole_, observations);
  return m.model;
}

}  // namespace surveymc::reliability
