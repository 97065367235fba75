#include "rare/proposal.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "simd/instruction_set.h"

namespace surveymc::rare {

const char* name_of(ComponentKind kind) {
  return kind == ComponentKind::adapted ? "adapted" : kind == ComponentKind::shifted ? "shifted" : "wide";
}

Proposal::Proposal(Eigen::MatrixXd basis, std::vector<Component> components)
    : basis_(std::move(basis)), components_(std::move(components)) {
  for (const Component& c : components_) {
    assert(c.mean.size() == basis_.cols() && c.root.rows() == basis_.cols());
    double scale = std::log(c.share);
    for (Eigen::Index i = 0; i < c.root.rows(); ++i) scale -= std::log(c.root(i, i));
    log_scale_.push_back(scale);
  }
}

std::size_t Proposal::choose(double uniform) const {
  double sum = 0;
  for (std::size_t k = 0; k + 1 < components_.size(); ++k)
    if ((sum += components_[k].share) > uniform) return k;
  return components_.size() - 1;
}

double Proposal::log_ratio(std::size_t k, const double* y) const {
  const Component& c = components_[k];
  const Eigen::Index r = c.mean.size();
  constexpr Eigen::Index kFew = 64;
  double own[kFew];
  std::vector<double> many(r > kFew ? static_cast<std::size_t>(r) : 0);
  double* x = r > kFew ? many.data() : own;
  double squares = 0;
  for (Eigen::Index i = 0; i < r; ++i) {
    double s = y[i] - c.mean[i];
    for (Eigen::Index j = 0; j < i; ++j) s -= c.root(i, j) * x[j];
    x[i] = s / c.root(i, i);
    squares += y[i] * y[i] - x[i] * x[i];
  }
  return log_scale_[k] + squares / 2;
}

double Proposal::log_weight(const double* y) const {
  if (components_.empty()) return 0;
  double most = log_ratio(0, y), sum = 1;  // sum_k exp(ratio_k - most)
  for (std::size_t k = 1; k < components_.size(); ++k) {
    const double ratio = log_ratio(k, y);
    if (ratio <= most) {
      sum += std::exp(ratio - most);
    } else {
      sum = sum * std::exp(most - ratio) + 1;
      most = ratio;
    }
  }
  return -(most + std::log(sum));
}

std::uint64_t Proposal::hash() const {
  if (is_plain()) return 0;
  std::uint64_t h = 0xcbf29ce484222325u;  // FNV-1a, a word at a time
  const auto add = [&](double x) { h = (h ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3u, h ^= h >> 29; };
  const auto add_all = [&](const auto& m) {
    for (Eigen::Index i = 0; i < m.size(); ++i) add(m.data()[i]);
  };
  add_all(basis_);
  for (const Component& c : components_) {
    add(static_cast<double>(c.kind));
    add(c.share);
    add_all(c.mean);
    add_all(c.root);
  }
  return h == 0 ? 1 : h;
}

TrialAddresses addresses_in(random::Channel normals, random::Channel choice, int n) {
  TrialAddresses a;
  for (int i = 0; i < n; i += 4) a.calls.push_back({normals, static_cast<std::uint32_t>(i / 4)});
  a.choice = choice;
  return a;
}

void draw_trials(const Proposal& proposal, const TrialAddresses& from, const random::Stream& stream,
                 std::uint64_t first_trial, int groups, int n, DrawnTrials& out) {
  const std::size_t trials = static_cast<std::size_t>(groups) * simd::kGroup;
  if (out.log_weight.size() != trials) out.z = survey::LaneArray(groups, n);
  out.log_weight.assign(trials, 0);
  out.component.assign(trials, 0);
  const NormalBatch batch{from.calls.data(),
                          from.calls.size(),
                          static_cast<std::size_t>(n),
                          first_trial,
                          static_cast<std::size_t>(groups),
                          out.z.row(0, 0),
                          out.z.group_stride()};
  simd::run_kernel<isa_v3::draw_normals, isa_v4::draw_normals>(batch, stream);
  if (proposal.is_plain()) return;
  const auto r = static_cast<std::size_t>(proposal.basis().cols());
  out.y.resize(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(trials));
  survey::LaneArray y(1, static_cast<int>(r));
  for (int g = 0; g < groups; ++g) {
    const BasisBatch b{proposal.basis().data(), static_cast<std::size_t>(n), r, out.z.row(g, 0), y.row(0, 0)};
    simd::run_kernel<isa_v3::project, isa_v4::project>(b);
    for (int lane = 0; lane < simd::kGroup; ++lane) {
      const auto t = static_cast<std::size_t>(g * simd::kGroup + lane);
      const std::uint64_t trial = first_trial + t;
      const std::size_t k = proposal.choose(stream.uniforms<double>(trial, from.choice, std::uint64_t{0})[0]);
      const Component& c = proposal.components()[k];
      double* drawn = out.y.data() + t * r;
      for (std::size_t i = 0; i < r; ++i) {
        double s = c.mean[static_cast<Eigen::Index>(i)];
        for (std::size_t j = 0; j <= i; ++j)
          s += c.root(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * y.row(0, static_cast<int>(j))[lane];
        drawn[i] = s;
      }
      for (std::size_t i = 0; i < r; ++i)
        y.row(0, static_cast<int>(i))[lane] = drawn[i] - y.row(0, static_cast<int>(i))[lane];
      out.component[t] = static_cast<std::uint32_t>(k);
      out.log_weight[t] = proposal.log_weight(drawn);
    }
    simd::run_kernel<isa_v3::shift, isa_v4::shift>(b);
  }
}

}  // namespace surveymc::rare
