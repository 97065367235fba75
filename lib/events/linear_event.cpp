#include "events/linear_event.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "stats/heavy_tail.h"
#include "stats/normal_tail.h"

namespace surveymc::events {
namespace {

using Eigen::VectorXd;

constexpr double kLeastShare = 0.02;
constexpr std::size_t kMostHeavy = 8, kMostStarts = 4;

/// The error along a direction as u' H of variance 1: some of H have a V.
struct HeavyError {
  VectorXd unit;  ///< u
  std::vector<rare::MixingNormal> mixing;
  std::vector<double> square, sum;  ///< of the elements of u with this V

  HeavyError(VectorXd direction, const std::vector<rare::MixingNormal>& all) : unit(std::move(direction)) {
    for (const rare::MixingNormal& m : all) {
      double squares = 0, together = 0;
      for (const std::uint32_t i : m.of) {
        squares += unit[i] * unit[i];
        together += unit[i];
      }
      if (!(squares > 0)) continue;
      mixing.push_back(m);
      square.push_back(squares);
      sum.push_back(together);
    }
  }

  std::vector<stats::HeavyPart> parts() const {
    std::vector<stats::HeavyPart> out;
    for (std::size_t m = 0; m < mixing.size(); ++m)
      out.push_back({mixing[m].law, std::copysign(std::sqrt(square[m]), sum[m])});
    return out;
  }
  bool is_symmetric() const {
    return std::all_of(mixing.begin(), mixing.end(), [](const auto& m) { return m.law->is_symmetric(); });
  }
  /// The V that count, largest share first.
  std::vector<std::size_t> heavy() const {
    std::vector<std::size_t> out;
    for (std::size_t m = 0; m < mixing.size(); ++m)
      if (square[m] > kLeastShare) out.push_back(m);
    std::stable_sort(out.begin(), out.end(), [&](std::size_t a, std::size_t b) { return square[a] > square[b]; });
    if (out.size() > kMostHeavy) out.resize(kMostHeavy);
    return out;
  }

  /// The point nearest to the origin where u' H = limit and the V have the normals `v`.
  VectorXd nearest_point(double limit, const std::vector<double>& v) const {
    VectorXd slope = unit;
    double shift = 0;
    for (std::size_t m = 0; m < mixing.size(); ++m) {
      const random::MixingLaw::Draw d = mixing[m].law->draw(v[m]);
      for (const std::uint32_t i : mixing[m].of) slope[i] *= d.factor;
      shift += d.shift * sum[m];
    }
    VectorXd z = (limit - shift) / slope.squaredNorm() * slope;
    for (std::size_t m = 0; m < mixing.size(); ++m) z[mixing[m].row] = v[m];
    return z;
  }
  /// Its squared distance.
  double distance2(double limit, const std::vector<double>& v) const {
    double slope2 = 1, shift = 0, out = 0;
    for (std::size_t m = 0; m < mixing.size(); ++m) {
      const random::MixingLaw::Draw d = mixing[m].law->draw(v[m]);
      slope2 += square[m] * (d.factor * d.factor - 1);
      shift += sum[m] * d.shift;
      out += v[m] * v[m];
    }
    return out + (limit - shift) * (limit - shift) / slope2;
  }
  /// The nearest point of all V near that where `first` alone is large: V by V, twice.
  VectorXd nearest_point(double limit, std::size_t first, const std::vector<std::size_t>& of) const {
    std::vector<double> v(mixing.size(), 0);
    const auto improve = [&](std::size_t m) {
      double best = kInfinity, at = 0;
      for (int i = 0; i <= 80; ++i) {
        v[m] = 0.1 * i;
        if (const double d = distance2(limit, v); d < best) best = d, at = v[m];
      }
      v[m] = at;
    };
    for (int twice = 0; twice < 2; ++twice) {
      improve(first);
      for (const std::size_t m : of)
        if (m != first) improve(m);
    }
    return nearest_point(limit, v);
  }
};

}  // namespace

void predict(TrialEvent& event, const LinearEvent& linear) {
  const double k = linear.limit, norm = linear.slope.norm(), sides = linear.is_two_sided ? 2 : 1;
  const double normal = sides * stats::normal_upper_tail(k);
  event.is_two_sided = linear.is_two_sided;
  if (linear.mixing.empty()) {
    event.predictions = {{"first_order", normal}};
    event.starts = {k * linear.slope / norm};
    if (linear.is_two_sided) event.starts.push_back(-event.starts.front());
    return;
  }
  const HeavyError error(linear.slope / norm, linear.mixing);
  const bool is_known = k > 0 && (linear.is_two_sided || error.is_symmetric());
  event.predictions = {{"first_order", is_known ? sides / 2 * stats::beyond(error.parts(), {k}).front() : kNaN},
                       {"normal", normal}};
  const std::vector<std::size_t> heavy = error.heavy();
  event.starts.clear();
  for (const double side : {1.0, -1.0}) {
    if (side < 0 && !linear.is_two_sided) break;
    event.starts.push_back(error.nearest_point(side * k, std::vector<double>(error.mixing.size(), 0)));
    for (std::size_t i = 0; i < std::min(heavy.size(), kMostStarts); ++i)
      event.starts.push_back(error.nearest_point(side * k, heavy[i], heavy));
  }
}

}  // namespace surveymc::events
