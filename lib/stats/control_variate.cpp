#include "stats/control_variate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stats/linear_algebra.h"

namespace surveymc::stats {
namespace {

enum { kYi, kYj, kLi, kLj, kYY, kLL, kColumns };
constexpr int kKept = kColumns;  // one more column where trials failed: 1 of those kept, 0 of those lost
constexpr std::array<int, 3> kControls{kLi, kLj, kLL};

/// An estimate, and the variance of its error: the variance of the per-trial terms, whose mean is the first-order
/// error, over their count.
struct Estimate {
  double value, variance;
};

/// Moments over all trials of the six columns and of kKept, from those of the kept and of the lost.
Moments with_lost(const Moments& kept, const Moments& lost) {
  const auto widened = [](const Moments& m, double is_kept) {
    Moments w(kColumns + 1);
    w.count = m.count;
    w.mean.head<kColumns>() = m.mean;
    w.mean[kKept] = is_kept;
    w.squares.topLeftCorner<kColumns, kColumns>() = m.squares;
    return w;
  };
  Moments all = widened(kept, 1);
  all.merge(widened(lost, 0));
  return all;
}

/// Estimates from units (trials, pairs) of N columns: six, or kKept too.
template <int N>
class Estimation {
 public:
  using Combination = Eigen::Matrix<double, N, 1>;  // coefficients of the columns
  /// `all`: of every unit; `kept`: of those that did not fail, the same where N is six.
  Estimation(const Moments& all, const Moments& kept, double control_covariance)
      : all_(all), kept_(kept), control_covariance_(control_covariance) {}

  struct Term {
    Estimate estimate;
    Combination influence;
  };
  struct Terms {
    Term plain, controlled;
  };
  Terms mean() const {
    const Term plain = mean_term(kYi);
    return {plain, controlled(plain)};
  }
  Terms covariance() const {
    const double i = controlled(mean_term(kYi)).estimate.value, j = controlled(mean_term(kYj)).estimate.value;
    return {covariance_term(kept_.mean[kYi], kept_.mean[kYj]), controlled(covariance_term(i, j))};
  }
  /// Not below the rounding errors of its sum: of an estimator that is linear nothing else is left.
  static double variance_of_mean(const Moments& m, const Combination& c) {
    const double rounding =
        std::numeric_limits<double>::epsilon() * c.cwiseAbs().dot(m.squares.cwiseAbs() * c.cwiseAbs());
    return std::max(c.dot(m.squares * c), rounding) / (static_cast<double>(m.count) - 1) / static_cast<double>(m.count);
  }

 private:
  /// The mean over the kept of what `influence` combines is a ratio of means over all.
  void as_ratio(Combination& influence) const {
    if constexpr (N > kColumns) {
      const double of_kept = influence.template head<kColumns>().dot(kept_.mean);
      influence[kKept] = -of_kept;
      influence /= all_.mean[kKept];
    }
  }

  /// Mean of y_i or y_j.
  Term mean_term(int component) const {
    Term t{{kept_.mean[component], 0}, Combination::Zero()};
    t.influence[component] = 1;
    as_ratio(t.influence);
    t.estimate.variance = variance_of_mean(all_, t.influence);
    return t;
  }

  /// E[y_i y_j] - mean_i mean_j, linearised about these means: only the mean of y_i y_j - mean_j y_i - mean_i y_j is
  /// estimated. With the controlled means, the neglected term is the square of their error, which is smaller than that
  /// of the sample means.
  Term covariance_term(double mean_i, double mean_j) const {
    const Eigen::VectorXd& m = kept_.mean;
    Term t{{m[kYY] - mean_j * m[kYi] - mean_i * m[kYj] + mean_i * mean_j, 0}, Combination::Zero()};
    t.influence[kYY] = 1;
    t.influence[kYi] -= mean_j;
    t.influence[kYj] -= mean_i;
    as_ratio(t.influence);
    t.estimate.variance = variance_of_mean(all_, t.influence);
    return t;
  }

  /// `plain` less its regression on the controls, whose means over all units are 0, 0 and the control covariance.
  Term controlled(const Term& plain) const {
    const Moments& m = all_;
    Eigen::MatrixXd among(3, 3);
    Eigen::VectorXd with_plain(3), excess(3), scale(3);
    for (int a = 0; a < 3; ++a) {
      const int i = kControls[static_cast<std::size_t>(a)];
      // A control that does not vary (a direction that noise does not reach to first order) gets no weight.
      scale[a] = m.squares(i, i) > 0 ? 1 / std::sqrt(m.squares(i, i)) : 0;
      excess[a] = m.mean[i] - (i == kLL ? control_covariance_ : 0);
      with_plain[a] = m.squares.row(i).dot(plain.influence) * scale[a];
    }
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        among(a, b) = m.squares(kControls[static_cast<std::size_t>(a)], kControls[static_cast<std::size_t>(b)]) *
                      scale[a] * scale[b];
    // l_i and l_j are one for i = j: the solution of least norm shares the weight between them.
    const Eigen::VectorXd weight = scale.cwiseProduct(least_squares_solution(among, with_plain, 1e-9));
    Term t = plain;
    t.estimate.value -= weight.dot(excess);
    for (int a = 0; a < 3; ++a) t.influence[kControls[static_cast<std::size_t>(a)]] -= weight[a];
    t.estimate.variance = variance_of_mean(m, t.influence);
    return t;
  }

  const Moments &all_, &kept_;
  double control_covariance_;
};

struct Estimates {
  Estimate plain, controlled;
  /// Variance of the plain terms over as many independent trials, over that of the controlled ones: each trial of a
  /// pair by itself has their distribution.
  double variance_reduction;
};

enum class Wanted { mean, covariance };

template <int N>
Estimates estimates_of(Wanted wanted, const Moments& units, const Moments& kept_units, const Moments& trials,
                       double control_covariance) {
  const Estimation<N> e(units, kept_units, control_covariance);
  const auto terms = wanted == Wanted::mean ? e.mean() : e.covariance();
  return {terms.plain.estimate, terms.controlled.estimate,
          Estimation<N>::variance_of_mean(trials, terms.plain.influence) / terms.controlled.estimate.variance};
}

Estimates estimates_of(Wanted wanted, const Moments& trials, const Moments* pairs, const LostTrials& lost,
                       double control_covariance) {
  const Moments& kept = pairs ? *pairs : trials;
  const Moments* lost_units = pairs ? lost.pairs : lost.trials;
  if (!lost.trials || !lost_units || lost.trials->count == 0)
    return estimates_of<kColumns>(wanted, kept, kept, trials, control_covariance);
  return estimates_of<kColumns + 1>(wanted, with_lost(kept, *lost_units), kept, with_lost(trials, *lost.trials),
                                    control_covariance);
}

/// `quantile`: half of the interval in standard errors.
Interval around(const Estimate& e, double quantile) {
  const double half = quantile * std::sqrt(e.variance);
  return {e.value - half, e.value + half};
}

/// Interval of the standard deviation, from an estimate of the variance: symmetric in the logarithm, so that it stays
/// positive.
Interval around_root(const Estimate& e, double quantile) {
  const double factor = std::exp(quantile * std::sqrt(e.variance) / (2 * e.value));
  return {std::sqrt(e.value) / factor, std::sqrt(e.value) * factor};
}

double normal_quantile_of(double confidence) { return normal_quantile(1 - (1 - confidence) / 2); }

/// The quantile of a controlled variance or covariance: in pairs that of the fourth Hermite polynomial
/// (control_variate.h).
double controlled_quantile(double confidence, const Moments* pairs) {
  const double z = normal_quantile_of(confidence);
  if (!pairs) return z;
  return z * (1 + 0.235 * std::pow(z / 1.96, 1.7) * std::pow(1000 / static_cast<double>(pairs->count), 0.82));
}

}  // namespace

Eigen::MatrixXd control_columns(const Eigen::Ref<const Eigen::VectorXd>& y_i,
                                const Eigen::Ref<const Eigen::VectorXd>& y_j,
                                const Eigen::Ref<const Eigen::VectorXd>& l_i,
                                const Eigen::Ref<const Eigen::VectorXd>& l_j) {
  Eigen::MatrixXd x(y_i.size(), static_cast<Eigen::Index>(kColumns));
  x.col(kYi) = y_i;
  x.col(kYj) = y_j;
  x.col(kLi) = l_i;
  x.col(kLj) = l_j;
  x.col(kYY) = y_i.cwiseProduct(y_j);
  x.col(kLL) = l_i.cwiseProduct(l_j);
  return x;
}

Eigen::MatrixXd lost_columns(const Eigen::Ref<const Eigen::VectorXd>& l_i,
                             const Eigen::Ref<const Eigen::VectorXd>& l_j) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(l_i.size());
  return control_columns(none, none, l_i, l_j);
}

ControlledEstimate controlled_mean(const Moments& trials, double control_variance, double confidence,
                                   const Moments* pairs, const LostTrials& lost) {
  const Estimates e = estimates_of(Wanted::mean, trials, pairs, lost, control_variance);
  return {e.plain.value, e.controlled.value, around(e.plain, normal_quantile_of(confidence)),
          around(e.controlled, normal_quantile_of(confidence)), e.variance_reduction};
}

ControlledEstimate controlled_covariance(const Moments& trials, double control_covariance, double confidence,
                                         const Moments* pairs, const LostTrials& lost) {
  const Estimates e = estimates_of(Wanted::covariance, trials, pairs, lost, control_covariance);
  return {e.plain.value, e.controlled.value, around(e.plain, normal_quantile_of(confidence)),
          around(e.controlled, controlled_quantile(confidence, pairs)), e.variance_reduction};
}

ControlledEstimate controlled_sd(const Moments& trials, double control_variance, double confidence,
                                 const Moments* pairs, const LostTrials& lost) {
  const Estimates e = estimates_of(Wanted::covariance, trials, pairs, lost, control_variance);
  return {std::sqrt(e.plain.value), std::sqrt(e.controlled.value), around_root(e.plain, normal_quantile_of(confidence)),
          around_root(e.controlled, controlled_quantile(confidence, pairs)), e.variance_reduction};
}

}  // namespace surveymc::stats
