/// Tables of `msa_position` on predictions beyond first order: which of them a quantity needs, and what the first-order
/// ellipse holds.
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "compare/order_rows.h"
#include "msa_position/study.h"

namespace surveymc::studies::msa_position {

store::Table PositionPoint::orders_table(const stats::Tally& tally) const {
  compare::TableRows t("orders", "which order of prediction the final position needs, without a trial" + intervals_);
  const auto row = [&](const char* quantity, const Eigen::Vector3d& direction, int component) {
    compare::write_order(t, quantity, direction, *orders_, s_.orders.wanted, inputs_,
                         compare::order_sample(sample(tally, component), s_.verdict), s_.verdict);
  };
  for (int i = 0; i < 3; ++i)
    row(kDirections[static_cast<std::size_t>(i)], Eigen::Vector3d::Unit(i), Components::position + i);
  for (int i = 0; i < 3; ++i)
    row(kHoleDirections[static_cast<std::size_t>(i)], hla_from_nev_.row(i).transpose(), at_.hole + i);
  return t.take();
}

store::Table PositionPoint::profile_path_table() const {
  compare::TableRows t("profile_path",
                       "the last position along the direction of the errors that moves it most, all others at zero");
  const orders::Profile& p = *orders_->profile;
  for (std::size_t i = 0; i < p.t.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const auto coordinate = [&](const char* name, const char* meaning, int axis) {
      t.number(name, "m", meaning, p.path(axis, at));
    };
    t.number("t", "1", "size of the errors, in standard deviations", p.t[i]);
    t.number("weight", "1", "probability of the point", p.weights[i]);
    coordinate("north_m", "error of the position", 0);
    coordinate("east_m", "error of the position", 1);
    coordinate("vertical_m", "error of the position", 2);
    t.number("along_m", "m", "error along the longest horizontal axis of first order", p.axis.dot(p.path.col(at)));
    t.number("first_m", "m", "the same by first order",
             p.axis.dot(orders_->centre.value + orders_->centre.expansion.first * p.direction * p.t[i]));
  }
  return t.take();
}

store::Table PositionPoint::density_table() const {
  compare::TableRows t("density",
                       "density of the horizontal error of the last position, by the profile and to first "
                       "order");
  const orders::Mixture mixture = orders::without_gaps(*orders_->profile);
  const orders::Mixture first{{1, orders_->first.mean, orders_->first.covariance}};
  const Eigen::Vector3d along = orders_->profile->axis, across(-along.y(), along.x(), 0);
  for (const auto& [name, direction] : {std::pair{"along", along}, {"across", across}}) {
    // All that 200,000 trials would show.
    constexpr int kPoints = 241;
    constexpr double kTail = 5e-6;
    if (!(direction.dot(first[0].covariance * direction) > 0)) continue;
    const double low = std::min(orders::quantile(mixture, direction, kTail), orders::quantile(first, direction, kTail)),
                 high = std::max(orders::quantile(mixture, direction, 1 - kTail),
                                 orders::quantile(first, direction, 1 - kTail));
    for (int i = 0; i < kPoints; ++i) {
      const double x = low + (high - low) * i / (kPoints - 1);
      t.word("quantity", "along the longest horizontal axis of first order, or across it", name);
      t.number("azimuth_deg", "deg", "of that direction", std::atan2(direction.y(), direction.x()) / kDegree);
      t.number("error_m", "m", "error of the last position in that direction", x);
      t.number("profile", "1/m", "density by the profile", orders::density(mixture, direction, x));
      t.number("first", "1/m", "density to first order", orders::density(first, direction, x));
    }
  }
  return t.take();
}

store::Table PositionPoint::order_coverage_table(const stats::Tally& tally) const {
  compare::TableRows t(
      "order_coverage",
      "what the horizontal ellipse of first order holds, by the profile and by the trials" + intervals_);
  compare::write_order_coverage(t, orders_->profile->mixture,
                                {prediction_.position - true_position_, prediction_.position_covariance[0]},
                                tally.counts.data(), tally.moments.count, s_.verdict.confidence, [] {});
  return t.take();
}

}  // namespace surveymc::studies::msa_position
