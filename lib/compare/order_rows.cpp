#include "compare/order_rows.h"

#include <algorithm>
#include <cmath>

namespace surveymc::compare {

OrderSample order_sample(const stats::SampleSummary& found, const VerdictRule& rule) {
  if (found.units < 2) return {};
  return {{std::sqrt(found.variance), stats::sd_interval(found, rule.interval_confidence(found.units))},
          found.skewness,
          found.kurtosis};
}

void write_order(TableRows& t, const std::string& quantity, const Eigen::Vector3d& direction,
                 const orders::Predictions& predictions, const orders::WantedOrders& wanted,
                 const std::vector<std::string>& inputs, const OrderSample& found, const VerdictRule& rule) {
  const orders::Moments &first = predictions.first, &second = *predictions.second;
  const auto sd_of = [&](const orders::Moments& m) {
    return std::sqrt(std::max(0.0, direction.dot(m.covariance * direction)));
  };
  const orders::DominantInput input = orders::dominant_input(predictions.centre.expansion.first, inputs, direction);
  t.word("quantity", "component of the error of the last position", quantity);
  t.estimate("monte_carlo", "m", "sd of the trials", found.sd.value, found.sd.interval);
  t.number("monte_carlo_skewness", "1", "skewness of the trials", found.skewness);
  t.number("monte_carlo_kurtosis", "1", "kurtosis of the trials, 3 if normal", found.kurtosis);
  t.number("sd_first", "m", "sd to first order", sd_of(first));
  t.number("sd_second", "m", "sd to fourth order in the sizes", sd_of(second));
  t.number("mean_second", "m", "mean error to second order", direction.dot(second.mean));
  if (predictions.profile) {
    const orders::Profile& profile = *predictions.profile;
    const orders::Mixture smooth = orders::without_gaps(profile);
    const orders::Shape shape = orders::shape_along(profile.mixture, direction);
    const orders::OrderVerdict v = orders::order_needed(first, second, profile, direction, rule.margin);
    t.number("sd_profile", "m", "sd of the profile", shape.sd);
    t.number("mean_profile", "m", "mean error of the profile", shape.mean);
    t.number("skewness", "1", "skewness of the profile", shape.skewness);
    t.number("kurtosis", "1", "kurtosis of the profile, 3 if normal", shape.kurtosis);
    for (const auto& [name, p] : {std::pair{"q_0_00135", 0.0013498980316301},
                                  {"q_0_02275", 0.0227501319481792},
                                  {"q_0_5", 0.5},
                                  {"q_0_97725", 0.977249868051821},
                                  {"q_0_99865", 0.99865010196837}})
      t.number(name, "m", "quantile of the profile", orders::quantile(smooth, direction, p));
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
    t.count("solves", "runs that the profile took: its points and nodes",
            static_cast<std::int64_t>(wanted.options.grid + wanted.options.nodes));
    t.count("left_out", "nodes of the profile beyond a fold", static_cast<std::int64_t>(profile.nodes_left_out));
  }
  t.word("input", "input with the largest share of the first-order variance", input.name);
  t.number("share", "1", "its share", input.share);
}

double order_value(const orders::Predictions& predictions, const Eigen::Vector3d& direction, double margin) {
  return static_cast<double>(
      orders::order_needed(predictions.first, *predictions.second, *predictions.profile, direction, margin).order);
}

store::Table order_shares_table(const std::string& quantity, const std::vector<double>& orders) {
  TableRows t("order_shares", "share of the map by the order of prediction that " + quantity + " needs");
  const auto cells = std::count_if(orders.begin(), orders.end(), [](double x) { return std::isfinite(x); });
  t.count("cells", "of the map, where it is determined", static_cast<std::int64_t>(cells));
  for (std::size_t i = 0; i < orders::kOrderNames.size(); ++i)
    t.number(orders::kOrderNames[i], "1", "share of these cells",
             static_cast<double>(std::count(orders.begin(), orders.end(), static_cast<double>(i))) /
                 static_cast<double>(cells));
  return t.take();
}

}  // namespace surveymc::compare
