/// Tables of `msa_position` on predictions beyond first order: which of them a quantity needs, and what the first-order
/// ellipse holds.
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
