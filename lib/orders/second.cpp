#include "orders/second.h"

namespace surveymc::orders {

Centre centre_of(const PathChain& chain, const ExpansionParts& parts) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(chain.dimension());
  const Path point = chain.path(zero, {0.0});
  const Eigen::VectorXd state = point.states.rows() > 0 ? Eigen::VectorXd(point.states.col(0)) : Eigen::VectorXd();
  return {point.at.col(0), state, chain.expand(zero, state, parts)};
}

Moments first_order(const Centre& c) { return {c.value, c.expansion.first * c.expansion.first.transpose()}; }

Moments second_order(const Chain& chain, const Centre& centre) {
  // Central differences of the trace, by a thousandth of a normal: truncated at 1e-6 of the terms, rounded at 1e-9.
  constexpr double kStep = 1e-3;
  const Expansion& e = centre.expansion;
  Moments m = first_order(centre);
  m.mean += e.trace / 2;
  Eigen::Matrix3d mixed = Eigen::Matrix3d::Zero();
  for (int a = 0; a < 3; ++a) {
    const double length = e.first.row(a).norm();
    if (!(length > 0)) continue;
    const Eigen::VectorXd step = kStep / length * e.first.row(a).transpose();
    mixed.row(a) = length / (4 * kStep) *
                   (chain.expand(step, centre.state, {}).trace - chain.expand(-step, centre.state, {}).trace);
  }
  m.covariance += e.squares / 2 + mixed + mixed.transpose();
  return m;
}

Moments second_order(const Chain& chain) {
  ExpansionParts parts;
  parts.squares = true;
  return second_order(chain, centre_of(chain, parts));
}

}  // namespace surveymc::orders
