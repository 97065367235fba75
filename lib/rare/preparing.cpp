#include "rare/preparing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.h"
#include "random/rare_channels.h"
#include "rare/subset_simulation.h"
#include "stats/linear_algebra.h"

namespace surveymc::rare {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPilots = 4, kSearchDimensions = 12, kGradientPoints = 6;
constexpr double kSpread = 1.3;  // of adapted covariances

/// What draws of the preparing are for: the high bits of their trial number.
enum class Stage : std::uint64_t { search = 1, look = 2, adapt = 3 };

std::uint64_t first_trial(Stage stage, std::uint64_t round) {
  return (static_cast<std::uint64_t>(stage) << 24 | round) << 24;
}

class Search {
 public:
  Search(const LimitState& state, const random::Stream& stream)
      : state_(state), stream_(stream), n_(state.dimension()) {}

  VectorXd values(const MatrixXd& z) {
    evaluations += static_cast<std::uint64_t>(z.cols());
    VectorXd g = values_at(state_, z);
    for (double& x : g)
      if (std::isnan(x)) x = kInfinity;
    return g;
  }

  /// The nearest point of the event on the ray to `z`, a point of the event, within |z| 2^-12: eight places at a time.
  VectorXd on_ray(const VectorXd& z, double from = 0) {
    double lo = from, hi = 1;
    for (int pass = 0; pass < 4; ++pass) {
      MatrixXd places(n_, 7);
      for (int i = 0; i < 7; ++i) places.col(i) = (lo + (hi - lo) * (i + 1) / 8) * z;
      const VectorXd g = values(places);
      int first = 0;
      while (first < 7 && !(g[first] <= 0)) ++first;
      const double width = (hi - lo) / 8;
      hi = lo + width * (first + 1);
      lo = hi - width;
    }
    return hi * z;
  }

  /// A design point near a sample of the event.
  VectorXd improved(const VectorXd& sample) {
    VectorXd best = on_ray(sample);
    if (n_ <= kSearchDimensions) best = searched(best);
    for (int step = 0; step < 6; ++step) {
      const VectorXd next = stepped(best);
      if (next.size() == 0) break;
      const bool settled = next.norm() > best.norm() * (1 - 1e-5);
      best = next;
      if (settled) break;
    }
    return best;
  }

  std::uint64_t evaluations = 0;

 private:
  /// Shrinking random search: of the points about the best one, the nearest of the event.
  VectorXd searched(VectorXd best) {
    constexpr int kRounds = 12, kTries = 24;
    double size = 0.5;
    for (int round = 0; round < kRounds; ++round, size *= 0.7) {
      DrawnTrials drawn;
      draw_trials({}, addresses_in(random::kRarePilot, {}, n_), stream_, first_trial(Stage::search, searches_++),
                  kTries / simd::kGroup, n_, drawn);
      MatrixXd tries(n_, kTries);
      for (int t = 0; t < kTries; ++t) {
        VectorXd z(n_);
        for (int i = 0; i < n_; ++i) z[i] = best[i] + size * best.norm() / std::sqrt(n_) * drawn.z.value(t, i);
        if (z.norm() >= best.norm()) z *= best.norm() * (1 - 0.2 * size) / z.norm();
        tries.col(t) = z;
      }
      const VectorXd g = values(tries);
      for (int t = 0; t < kTries; ++t)
        if (g[t] <= 0 && tries.col(t).norm() < best.norm()) best = tries.col(t);
    }
    return on_ray(best, 0.9);
  }

  /// One Hasofer-Lind-Rackwitz step; empty where g does not change sign there, or not nearer.
  VectorXd stepped(const VectorXd& at) {
    const double h = 1e-4 * std::max(1.0, at.norm());
    MatrixXd places(n_, 2 * n_ + 1);
    for (int i = 0; i < 2 * n_; ++i) {
      places.col(i) = at;
      places(i / 2, i) += i % 2 == 0 ? h : -h;
    }
    places.col(2 * n_) = at;
    const VectorXd g = values(places);
    VectorXd slope(n_);
    for (int i = 0; i < n_; ++i) slope[i] = (g[2 * i] - g[2 * i + 1]) / (2 * h);
    const double squares = slope.squaredNorm();
    if (!(squares > 0) || !std::isfinite(squares)) return {};
    const VectorXd next = (slope.dot(at) - g[2 * n_]) / squares * slope;
    if (!(next.norm() < at.norm() * 1.05) || !(next.norm() > 0)) return {};
    // Behind the point lies the event, in front of it not: otherwise the slope deceived.
    constexpr double kReach = 0.03;
    MatrixXd ray(n_, 2);
    ray << next * (1 - kReach), next * (1 + kReach);
    const VectorXd along = values(ray);
    if (!(along[1] <= 0) || along[0] <= 0) return {};
    const VectorXd found = on_ray(ray.col(1), (1 - kReach) / (1 + kReach));
    return found.norm() < at.norm() ? found : VectorXd{};
  }

  const LimitState& state_;
  const random::Stream& stream_;
  int n_;
  std::uint64_t searches_ = 0;
};

void sort_by_beta(std::vector<DesignPoint>& designs) {
  std::stable_sort(designs.begin(), designs.end(),
                   [](const DesignPoint& a, const DesignPoint& b) { return a.beta < b.beta; });
}

/// A design point that is nearer to `z` than this share of its own distance.
bool has_near(const std::vector<DesignPoint>& designs, const VectorXd& z, double share) {
  return std::any_of(designs.begin(), designs.end(),
                     [&](const DesignPoint& d) { return (d.z - z).norm() < share * d.beta; });
}

Component unit_component(ComponentKind kind, double share, VectorXd mean, double sd, int design) {
  const Index r = mean.size();
  return {kind, share, std::move(mean), sd * MatrixXd::Identity(r, r), design};
}

/// Shifted and wide components alone.
Proposal looking_proposal(const std::vector<DesignPoint>& designs, const MatrixXd& basis, double wide_share,
                          double wide_sd) {
  std::vector<Component> all;
  const std::vector<double> shares = shares_of(designs);
  for (std::size_t k = 0; k < designs.size(); ++k)
    all.push_back(unit_component(ComponentKind::shifted, (1 - wide_share) * shares[k], basis.transpose() * designs[k].z,
                                 1, static_cast<int>(k)));
  all.push_back(unit_component(ComponentKind::wide, wide_share, VectorXd::Zero(basis.cols()), wide_sd, -1));
  return {basis, all};
}

/// Gives design points to samples of the event whose weight is large, the largest first.
void cover(std::vector<DesignPoint>& designs, const MatrixXd& samples, Search& search, int most) {
  while (static_cast<int>(designs.size()) < most) {
    const std::vector<double> shares = shares_of(designs);
    const double largest_share = *std::max_element(shares.begin(), shares.end());
    const double beta = designs.front().beta, bound = std::log(3.0) - beta * beta / 2 - std::log(largest_share);
    Index worst = -1;
    double most_weight = bound;
    for (Index i = 0; i < samples.cols(); ++i) {
      double density = 0, top = -kInfinity;  // ln sum_k a_k exp(z.z_k - beta_k^2/2)
      for (std::size_t k = 0; k < designs.size(); ++k) {
        const double x = std::log(shares[k]) + samples.col(i).dot(designs[k].z) - designs[k].beta * designs[k].beta / 2;
        density = x > top ? density * std::exp(top - x) + 1 : density + std::exp(x - top);
        top = std::max(top, x);
      }
      const double weight = -(top + std::log(density));
      if (weight > most_weight) {
        most_weight = weight;
        worst = i;
      }
    }
    if (worst < 0) return;
    VectorXd z = search.improved(samples.col(worst));
    if (has_near(designs, z, 0.1)) z = search.on_ray(samples.col(worst));
    designs.push_back({z, z.norm()});
    sort_by_beta(designs);
  }
}

MatrixXd joined(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(a.rows() > 0 ? a.rows() : b.rows(), a.cols() + b.cols());
  if (a.cols() > 0) both.leftCols(a.cols()) = a;
  if (b.cols() > 0) both.rightCols(b.cols()) = b;
  return both;
}

struct Round {
  DrawnTrials drawn;
  std::vector<double> g;
};

Round draw_round(const LimitState& state, const random::Stream& stream, const Proposal& proposal, int count,
                 std::uint64_t first) {
  const int groups = survey::groups_for(count), n = state.dimension();
  Round r;
  draw_trials(proposal, addresses_in(random::kRarePilot, random::kRarePilotChoice, n), stream, first, groups, n,
              r.drawn);
  r.g.resize(static_cast<std::size_t>(groups * simd::kGroup));
  state.evaluate(r.drawn.z, groups, r.g.data());
  r.g.resize(static_cast<std::size_t>(count));
  for (double& x : r.g)
    if (std::isnan(x)) x = kInfinity;
  return r;
}

MatrixXd hits_of(const Round& r, int n) {
  const auto count = std::count_if(r.g.begin(), r.g.end(), [](double x) { return x <= 0; });
  MatrixXd hits(n, count);
  Index at = 0;
  for (std::size_t t = 0; t < r.g.size(); ++t)
    if (r.g[t] <= 0) {
      for (int i = 0; i < n; ++i) hits(i, at) = r.drawn.z.value(static_cast<int>(t), i);
      ++at;
    }
  return hits;
}

}  // namespace

Prepared prepare_from(const LimitState& state, const random::Stream& stream, const PreparingOptions& options,
                      const std::vector<VectorXd>& points) {
  constexpr double kKeep = 2.5, kLeastWide = 1.3;
  constexpr int kRounds = 8;
  Prepared out;
  for (const VectorXd& z : points) out.designs.push_back({z, z.norm()});
  sort_by_beta(out.designs);
  const double beta = out.designs.front().beta;
  std::erase_if(out.designs, [&](const DesignPoint& d) { return d.beta > beta + kKeep; });
  if (out.designs.size() > static_cast<std::size_t>(options.max_components))
    out.designs.resize(static_cast<std::size_t>(options.max_components));
  out.proposal = adapt_proposal(state, stream, out.designs, basis_of(out.designs, state.dimension()), options,
                                std::max(kLeastWide, beta / std::sqrt(3.0)), kRounds, true, out.evaluations);
  return out;
}

MatrixXd basis_of(const std::vector<DesignPoint>& designs, int n) {
  constexpr int kAll = 4;
  constexpr double kNew = 1e-3;  // of a design point's length: below it adds no direction
  if (n <= kAll) return MatrixXd::Identity(n, n);
  MatrixXd basis(n, 0);
  for (const DesignPoint& d : designs) {
    VectorXd rest = d.z;
    for (int twice = 0; twice < 2; ++twice) rest -= basis * (basis.transpose() * rest);
    if (rest.norm() < kNew * d.beta) continue;
    basis.conservativeResize(n, basis.cols() + 1);
    basis.col(basis.cols() - 1) = rest.normalized();
  }
  return basis;
}

std::vector<double> shares_of(const std::vector<DesignPoint>& designs) {
  std::vector<double> shares;
  double sum = 0;
  for (const DesignPoint& d : designs) {
    const double first = designs.front().beta;
    shares.push_back(std::exp(-(d.beta * d.beta - first * first) / 4));
    sum += shares.back();
  }
  for (double& s : shares) s /= sum;
  return shares;
}

Proposal adapt_proposal(const LimitState& state, const random::Stream& stream, const std::vector<DesignPoint>& designs,
                        const MatrixXd& basis, const PreparingOptions& o, double wide_sd, int rounds, bool until_hit,
                        std::uint64_t& evaluations) {
  const Index r = basis.cols();
  const std::size_t modes = designs.size();
  const std::vector<double> shifted = shares_of(designs);
  struct Adapted {
    double share;
    VectorXd mean;
    MatrixXd root;
  };
  std::vector<Adapted> adapted;
  for (std::size_t k = 0; k < modes; ++k)
    adapted.push_back({shifted[k], basis.transpose() * designs[k].z, MatrixXd::Identity(r, r)});
  const auto proposal_of = [&] {
    std::vector<Component> all;
    for (std::size_t k = 0; k < modes; ++k)
      all.push_back({ComponentKind::adapted, o.adapted * adapted[k].share, adapted[k].mean, adapted[k].root,
                     static_cast<int>(k)});
    for (std::size_t k = 0; k < modes; ++k)
      all.push_back(unit_component(ComponentKind::shifted, o.shifted * shifted[k], basis.transpose() * designs[k].z, 1,
                                   static_cast<int>(k)));
    all.push_back(unit_component(ComponentKind::wide, o.wide, VectorXd::Zero(r), wide_sd, -1));
    return Proposal(basis, all);
  };
  int reached = 0;
  for (int round = 0; round < rounds && !(until_hit && reached >= 2); ++round) {
    const Proposal now = proposal_of();
    const Round drawn =
        draw_round(state, stream, now, o.pilot, first_trial(Stage::adapt, static_cast<std::uint64_t>(round)));
    evaluations += static_cast<std::uint64_t>(o.pilot);
    std::vector<double> sorted = drawn.g;
    const auto tenth = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 10);
    std::nth_element(sorted.begin(), tenth, sorted.end());
    const double level = std::max(0.0, *tenth);
    reached += level == 0;
    if (!std::isfinite(level)) continue;
    // Weights relative to the largest: they are as small as the probability.
    double most = -kInfinity;
    for (std::size_t t = 0; t < drawn.g.size(); ++t)
      if (drawn.g[t] <= level) most = std::max(most, drawn.drawn.log_weight[t]);
    std::vector<double> weight(modes, 0), squares(modes, 0);
    std::vector<VectorXd> mean(modes, VectorXd::Zero(r));
    std::vector<MatrixXd> second(modes, MatrixXd::Zero(r, r));
    for (std::size_t t = 0; t < drawn.g.size(); ++t) {
      if (!(drawn.g[t] <= level)) continue;
      const double w = std::exp(drawn.drawn.log_weight[t] - most);
      const VectorXd y = drawn.drawn.y.col(static_cast<Index>(t));
      std::vector<double> part(modes);
      double top = -kInfinity, sum = 0;
      for (std::size_t k = 0; k < modes; ++k) top = std::max(top, part[k] = now.log_ratio(k, y.data()));
      for (double& x : part) sum += x = std::exp(x - top);
      for (std::size_t k = 0; k < modes; ++k) {
        const double own = w * part[k] / sum;
        weight[k] += own;
        squares[k] += own * own;
        mean[k] += own * y;
        second[k] += own * y * y.transpose();
      }
    }
    double all = 0;
    for (const double w : weight) all += w;
    if (!(all > 0)) continue;
    double shares = 0;
    for (std::size_t k = 0; k < modes; ++k) shares += adapted[k].share = std::max(0.01, weight[k] / all);
    for (std::size_t k = 0; k < modes; ++k) {
      adapted[k].share /= shares;
      const double effective = squares[k] > 0 ? weight[k] * weight[k] / squares[k] : 0;
      if (effective < 4 * static_cast<double>(r) + 4) continue;  // too few for a covariance
      const VectorXd m = mean[k] / weight[k];
      const stats::Cholesky root = stats::cholesky(kSpread * (second[k] / weight[k] - m * m.transpose()));
      if (!root.positive_definite()) continue;
      adapted[k].mean = m;
      adapted[k].root = root.lower();
    }
  }
  return proposal_of();
}

Prepared prepare_proposal(const LimitState& state, const random::Stream& stream, const PreparingOptions& o,
                          const std::vector<VectorXd>& starts) {
  const int n = state.dimension();
  Prepared out;
  Search search(state, stream);
  MatrixXd hits;
  for (int pilot = 0; pilot < kPilots; ++pilot) {
    // Replicates of the check are numbered from 0.
    const SubsetReplicate r =
        subset_simulation(state, stream, (std::uint64_t{1} << 32) + static_cast<std::uint64_t>(pilot), o.subset_pilot);
    out.evaluations += r.evaluations;
    hits = joined(hits, r.hits);
  }
  for (const VectorXd& start : starts) {
    constexpr std::array<double, 6> kReach{1, 1.05, 1.15, 1.3, 1.6, 2};
    MatrixXd places(n, kReach.size());
    for (std::size_t i = 0; i < kReach.size(); ++i) places.col(static_cast<Index>(i)) = kReach[i] * start;
    const VectorXd g = search.values(places);
    const auto first = std::find_if(g.begin(), g.end(), [](double x) { return x <= 0; }) - g.begin();
    if (first < g.size()) hits = joined(hits, places.col(first));
  }
  if (hits.cols() == 0) {
    out.evaluations += search.evaluations;
    return out;
  }
  std::vector<Index> order(static_cast<std::size_t>(hits.cols()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return hits.col(a).squaredNorm() < hits.col(b).squaredNorm(); });
  const auto add = [&](const VectorXd& z) {
    if (!has_near(out.designs, z, 0.05)) out.designs.push_back({z, z.norm()});
    sort_by_beta(out.designs);
  };
  add(search.improved(hits.col(order[0])));
  const bool is_high = n > kSearchDimensions;
  for (std::size_t i = 1; is_high && i < std::min<std::size_t>(kGradientPoints, order.size()); ++i) {
    add(search.improved(hits.col(order[i * (order.size() - 1) / (kGradientPoints - 1)])));
    if (static_cast<int>(out.designs.size()) >= o.max_components) break;
  }
  if (!is_high) {
    cover(out.designs, hits, search, o.max_components);
    constexpr int kLooks = 4;
    for (std::uint64_t round = 0; round < kLooks; ++round) {
      const MatrixXd basis = basis_of(out.designs, n);
      const double sd = std::max(1.5, 1.2 * out.designs.front().beta / std::sqrt(static_cast<double>(basis.cols())));
      const Round r = draw_round(state, stream, looking_proposal(out.designs, basis, 0.3, sd), o.pilot,
                                 first_trial(Stage::look, round));
      out.evaluations += static_cast<std::uint64_t>(o.pilot);
      cover(out.designs, hits_of(r, n), search, o.max_components);
    }
  }
  const MatrixXd basis = basis_of(out.designs, n);
  const double sd = std::max(1.3, out.designs.front().beta / std::sqrt(static_cast<double>(basis.cols())));
  constexpr int kRounds = 4;
  out.proposal = adapt_proposal(state, stream, out.designs, basis, o, sd, kRounds, false, out.evaluations);
  out.evaluations += search.evaluations;
  return out;
}

}  // namespace surveymc::rare
