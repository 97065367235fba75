#include "rare/union_of_half_spaces.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <boost/math/distributions/normal.hpp>

#include "stats/normal_tail.h"

namespace surveymc::rare {

void add_two_sided(const Eigen::VectorXd& direction, double k, std::vector<HalfSpace>& to) {
  to.push_back({direction, k});
  to.push_back({-direction, k});
}

UnionSampler::UnionSampler(std::vector<HalfSpace> half_spaces) : half_spaces_(std::move(half_spaces)) {
  for (const HalfSpace& h : half_spaces_) {
    p_.push_back(stats::normal_upper_tail(h.distance));
    sum_ += p_.back();
  }
}

double UnionSampler::draw(double choice, double tail, Eigen::VectorXd& z, std::size_t& chosen) const {
  double left = choice * sum_;
  chosen = 0;
  while (chosen + 1 < p_.size() && left >= p_[chosen]) left -= p_[chosen++];
  const HalfSpace& h = half_spaces_[chosen];
  // The tail's quantile; rounding of the smallest tails must not leave it.
  const double w =
      std::max(h.distance, boost::math::quantile(boost::math::complement(boost::math::normal(), tail * p_[chosen])));
  z += h.direction * (w - h.direction.dot(z));
  std::size_t holding = 0;
  for (std::size_t i = 0; i < half_spaces_.size(); ++i)
    holding += i == chosen || half_spaces_[i].direction.dot(z) > half_spaces_[i].distance;
  return sum_ / static_cast<double>(holding);
}

std::uint64_t UnionSampler::hash() const {
  std::uint64_t h = 0x9e3779b97f4a7c15u;
  const auto add = [&](double x) { h = (h ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3u, h ^= h >> 29; };
  for (const HalfSpace& s : half_spaces_) {
    for (const double x : s.direction) add(x);
    add(s.distance);
  }
  return h == 0 ? 1 : h;
}

double any_of_independent(const std::vector<double>& p) {
  double log_none = 0;
  for (const double x : p) log_none += std::log1p(-x);
  return -std::expm1(log_none);
}

}  // namespace surveymc::rare
