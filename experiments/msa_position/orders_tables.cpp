/// Tables of `msa_position` on predictions beyond first order: which of them a quantity needs, and what the first-order
/// ellipse holds.
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "compare/table_rows.h"
#include "msa_position/study.h"

namespace surveymc::studies::msa_position {

store::Table PositionPoint::orders_table(const stats::Tally& tally) const {
  compare::TableRows t("orders", "which order of prediction the final position needs, without a trial" + intervals_);
  const auto row = [&](const char* quantity, const Eigen::Vector3d& direction, int component) {
    const orders::Moments &first = orders_->first, &second = *orders_->second;
    const auto sd_of = [&](const orders::Moments& m) {
      return std::sqrt(std::max(0.0, direction.dot(m.covariance * direction)));
    };
    const orders::DominantInput input = orders::dominant_input(orders_->centre.expansion.first, inputs_, direction);
    const stats::SampleSummary found = sample(tally, component);
    const bool has_sample = units(tally) > 1;
    const auto if_sampled = [has_sample](double x) { return has_sample ? x : kNaN; };
    t.word("quantity", "component of the error of the last position", quantity);
    t.estimate("monte_carlo", "m", "sd of the trials", if_sampled(std::sqrt(found.variance)),
               has_sample ? stats::sd_interval(found, s_.verdict.interval_confidence(units(tally)))
                          : stats::Interval{kNaN, kNaN});
    t.number("monte_carlo_skewness", "1", "skewness of the trials", if_sampled(found.skewness));
    t.number("monte_carlo_kurtosis", "1", "kurtosis of the trials, 3 if normal", if_sampled(found.kurtosis));
    t.number("sd_first", "m", "sd to first order", sd_of(first));
    t.number("sd_second", "m", "sd to fourth order in the sizes", sd_of(second));
    t.number("mean_second", "m", "mean error to second order", direction.dot(second.mean));
    if (orders_->profile) {
      const orders::Profile& profile = *orders_->profile;
      const orders::Shape shape = orders::shape_along(profile.mixture, direction);
      const orders::OrderVerdict v = orders::order_needed(first, second, profile, direction, s_.verdict.margin);
      t.number("sd_profile", "m", "sd of the profile", shape.sd);
      t.number("mean_profile", "m", "mean error of the profile", shape.mean);
      t.number("skewness", "1", "skewness of the profile", shape.skewness);
      t.number("kurtosis", "1", "kurtosis of the profile, 3 if normal", shape.kurtosis);
      for (const auto& [name, p] : {std::pair{"q_0_00135", 0.0013498980316301},
                                    {"q_0_02275", 0.0227501319481792},
                                    {"q_0_5", 0.5},
                                    {"q_0_97725", 0.977249868051821},
                                    {"q_0_99865", 0.99865010196837}})
        t.number(name, "m", "quantile of the profile", orders::quantile(profile.mixture, direction, p));
      t.number("e2", "1", "sd of second order over that of first, less 1", v.e2);
      t.number("m2", "1", "mean error of second order in first-order sds", v.m2);
      t.number("e4", "1", "sd of the profile over that of second order, less 1", v.e4);
      t.number("remainder", "1", "sd of the profile by every other node over that by all, less 1", v.remainder);
      t.number("jump_at", "1", "where the estimate goes over to another minimum, in sds along the profile",
               v.jump ? (v.jump->from + v.jump->to) / 2 : kNaN);
      t.number("jump_m", "m", "how far it leaps there", v.jump ? direction.dot(v.jump->leap) : kNaN);
      t.number("jump_probability", "1", "of a run beyond it", v.jump ? v.jump->probability : 0);
      t.word("order", "which order suffices: first, second, profile or sample",
             orders::kOrderNames[static_cast<std::size_t>(v.order)]);
      t.count("solves", "estimates that the profile took",
              static_cast<std::int64_t>(s_.orders.wanted.options.grid + s_.orders.wanted.options.nodes));
      t.count("left_out", "nodes of the profile beyond a fold", static_cast<std::int64_t>(profile.nodes_left_out));
    }
    t.word("input", "input with the largest share of the first-order variance", input.name);
    t.number("share", "1", "its share", input.share);
  };
  for (int i = 0; i < 3; ++i)
    row(kDirections[static_cast<std::size_t>(i)], Eigen::Vector3d::Unit(i), Components::position + i);
  for (int i = 0; i < 3; ++i)
    row(kHoleDirections[static_cast<std::size_t>(i)], hla_from_nev_.row(i).transpose(), at_.hole + i);
  return t.take();
}

store::Table PositionPoint::order_coverage_table(const stats::Tally& tally) const {
  compare::TableRows t(
      "order_coverage",
      "what the horizontal ellipse of first order holds, by the profile and by the trials" + intervals_);
  const std::vector<double> sigmas{1, 2, 3};
  const std::vector<double> inside = orders::inside_ellipse(
      orders_->profile->mixture, prediction_.position - true_position_, prediction_.position_covariance[0], sigmas);
  for (std::size_t k = 0; k < sigmas.size(); ++k) {
    t.number("sigma", "1", "size of the ellipse", sigmas[k]);
    t.number("normal", "1", "share of a normal distribution in its own ellipse",
             1 - std::exp(-0.5 * sigmas[k] * sigmas[k]));
    t.number("profile", "1", "share by the profile; absent where the ellipse has no area", inside[k]);
    const bool has_area = std::isfinite(inside[k]);
    t.share("monte_carlo", "share of the converged trials", has_area ? tally.counts[k] : 0,
            has_area ? tally.moments.count : 0, s_.verdict.confidence);
  }
  return t.take();
}

}  // namespace surveymc::studies::msa_position
