#include "reliability/redundancy_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "reliability/station_kernel.h"

namespace surveymc::reliability {

using Eigen::Index;

RedundancyModel::RedundancyModel(const std::vector<double>& w, const std::vector<double>& v, Index redundancy,
                                 double omega)
    : count_(w.size()), stride_((w.size() + 7) / 8 * 8), redundancy_(redundancy), omega_(omega) {
  if (count_ > kMost) throw std::invalid_argument("too many observations");
  const std::size_t unknowns = v.size() / count_;
  std::fill_n(matrix_.begin(), count_ * stride_, 0.0);
  residuals_.fill(0);
  for (std::size_t i = 0; i < count_; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double product = 0;
      for (std::size_t c = 0; c < unknowns; ++c) product += v[i * unknowns + c] * v[j * unknowns + c];
      matrix_[i * stride_ + j] = matrix_[j * stride_ + i] = (i == j ? 1 : 0) - product;
    }
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
  residuals_ = other.residuals_;
  w_ = other.w_;
  std::copy_n(other.matrix_.begin(), count_ * stride_, matrix_.begin());
  return *this;
}

void RedundancyModel::set_w() {
  w_.fill(0);
  for (std::size_t i = 0; i < count_; ++i) {
    const double redundancy = matrix_[i * (stride_ + 1)];
    w_[i] = redundancy > 0 ? residuals_[i] / std::sqrt(redundancy) : 0;
  }
}

double RedundancyModel::pair_statistic(Index i, Index j) const {
  const double ei = residuals_[static_cast<std::size_t>(i)], ej = residuals_[static_cast<std::size_t>(j)];
  const double one = ei * ei / at(i, i), share = at(i, j) / at(i, i), left = at(j, j) - share * at(i, j);
  if (!(left > kLeastRedundancy * at(j, j))) return one;
  const double more = ej - share * ei;
  return one + more * more / left;
}

void RedundancyModel::clear(std::size_t k) {
  for (std::size_t i = 0; i < count_; ++i) matrix_[i * stride_ + k] = matrix_[k * stride_ + i] = 0;
  residuals_[k] = 0;
}

void RedundancyModel::remove(std::size_t k) {
  std::array<double, kMost> row;
  std::copy_n(matrix_.data() + k * stride_, stride_, row.data());
  const double per = 1 / row[k], e = residuals_[k];
  omega_ -= e * e * per;
  --redundancy_;
  for (std::size_t i = 0; i < count_; ++i) {
    const double share = row[i] * per;
    residuals_[i] -= share * e;
    double* at = matrix_.data() + i * stride_;
    for (std::size_t j = 0; j < stride_; ++j) at[j] -= share * row[j];
  }
  clear(k);
}

RedundancyModel RedundancyModel::without(const std::vector<Index>& observations) const {
  RedundancyModel m = *this;
  // The largest share that is left first, as in parity.h; what is in the span of the others takes no redundancy.
  for (std::size_t n = 0; n < observations.size(); ++n) {
    std::size_t best = kMost;
    double most = kLeastRedundancy;
    for (const Index k : observations) {
      const std::size_t at = static_cast<std::size_t>(k) * (stride_ + 1);
      if (matrix_[at] > 0 && m.matrix_[at] / matrix_[at] > most) {  // one that was removed has none left
        best = static_cast<std::size_t>(k);
        most = m.matrix_[at] / matrix_[at];
      }
    }
    if (best == kMost) break;
    m.remove(best);
  }
  for (const Index k : observations) m.clear(static_cast<std::size_t>(k));
  for (std::size_t i = 0; i < count_; ++i)
    if (m.redundancy_ == 0 || !(m.matrix_[i * (stride_ + 1)] >= kLeastRedundancy)) m.clear(i);
  if (m.redundancy_ == 0) m.omega_ = 0;
  m.set_w();
  return m;
}

}  // namespace surveymc::reliability
