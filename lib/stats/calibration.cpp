#include "stats/calibration.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <boost/math/distributions/chi_squared.hpp>

#include "base/units.h"
#include "stats/normal_tail.h"
#include "stats/simultaneous_band.h"

namespace surveymc::stats {
namespace {

constexpr std::size_t kInner = kPitBins - 1;

/// Edges of the slots as u: i / 100, 0.025, 0.975.
std::array<double, kPitBins + 1> edges_as_u() {
  std::array<double, kPitBins + 1> u{};
  std::size_t at = 0;
  for (int i = 1; i < kPitBins; ++i) {
    if (i == 3) u[at++] = 0.025;
    if (i == 98) u[at++] = 0.975;
    u[at++] = i / double(kPitBins);
  }
  assert(at == u.size());
  return u;
}

double u_of(std::size_t inner) { return static_cast<double>(inner + 1) / kPitBins; }

double binomial_sd(double u, double n) { return std::sqrt(u * (1 - u) / n); }

/// D of one unit of size, at all inner points; linear in the size.
struct Shape {
  const char* name;
  std::array<double, kInner> d;
};

std::vector<Shape> shapes_of(ClaimedLaw law) {
  std::vector<Shape> shapes;
  if (law.degrees > 0) {
    const boost::math::chi_squared chi(law.degrees);
    Shape sd{"sd", {}};
    for (std::size_t i = 0; i < kInner; ++i) {
      const double x = boost::math::quantile(chi, u_of(i));
      sd.d[i] = -2 * x * boost::math::pdf(chi, x);
    }
    return {sd};
  }
  Shape sd{"sd", {}}, shift{"shift", {}}, skewness{"skewness", {}}, kurtosis{"kurtosis", {}};
  for (std::size_t i = 0; i < kInner; ++i) {
    const double z = normal_quantile(u_of(i)), density = std::exp(-0.5 * z * z) / std::sqrt(2 * kPi);
    sd.d[i] = -z * density;
    shift.d[i] = -density;
    skewness.d[i] = -(z * z - 1) * density / 6;  // Edgeworth
    kurtosis.d[i] = -(z * z * z - 3 * z) * density / 24;
  }
  return {sd, shift, skewness, kurtosis};
}

void fit_shape(const std::array<double, kInner>& d, ClaimedLaw law, CalibrationResult& out) {
  double best = kInfinity;
  for (const Shape& s : shapes_of(law)) {
    double along = 0, square = 0, rest = 0;
    for (std::size_t i = 0; i < kInner; ++i) {
      along += d[i] * s.d[i];
      square += s.d[i] * s.d[i];
    }
    const double size = along / square;
    for (std::size_t i = 0; i < kInner; ++i) rest += (d[i] - size * s.d[i]) * (d[i] - size * s.d[i]);
    if (!(rest < best)) continue;
    best = rest;
    out.shape = s.name;
    out.size = size;
  }
}

/// Simultaneous p-value of a deviation of z pointwise standard errors, two-sided.
double p_of_deviation(double z, std::uint64_t n) {
  return z <= 0 ? 1 : band_p_value(n, kPitBins, std::min(1.0, 2 * normal_upper_tail(z)));
}

/// `n` units of so many trials each.
void judge_with_margin(const std::array<double, kInner>& d, double n, double trials_each, double margin,
                       CalibrationResult& out) {
  bool inside = true;
  double beyond = 0, to_agree = 0, to_differ = kInfinity, least_room = kInfinity;  // in standard errors; as parts of n
  for (std::size_t i = 0; i < kInner; ++i) {
    const double sd = binomial_sd(u_of(i), n), half = out.quantile * sd, size = std::abs(d[i]);
    inside = inside && size + half <= margin;
    if (size - half > margin) out.verdict = "differs";
    beyond = std::max(beyond, (size - margin) / sd);
    least_room = std::min(least_room, (margin - size) / sd);
    const double distance = std::max(std::abs(size - margin), 1e-3 * margin), part = half / distance;
    if (size > margin)
      to_differ = std::min(to_differ, part * part);
    else
      to_agree = std::max(to_agree, part * part);
  }
  const auto units = static_cast<std::uint64_t>(n);
  out.p_differs = p_of_deviation(beyond, units);
  out.p_agrees = p_of_deviation(least_room, units);
  if (!out.verdict.empty()) return;
  out.verdict = inside ? "agrees" : "undecided";
  if (!inside)
    out.trials_to_decide =
        static_cast<std::uint64_t>(std::ceil(1.1 * n * trials_each * (beyond > 0 ? to_differ : to_agree)));
}

}  // namespace

PitCells::PitCells(const std::array<double, kPitBins + 1>& edges) : beyond_(edges.size()) {
  std::copy(edges.begin(), edges.end(), edges_.begin());
  edges_.back() = kNaN;
  first_ = edges.front();
  const double length = edges.back() - edges.front();
  per_unit_ = kLookUp / length * (1 - 1e-9);  // what is below the last edge stays within
  for (std::size_t i = 0; i < kLookUp; ++i) {
    // A little before its beginning, so that rounding of the place cannot skip an edge.
    const double begin = first_ + (static_cast<double>(i) - 1e-6) / per_unit_;
    start_[i] = static_cast<std::uint8_t>(std::upper_bound(edges.begin(), edges.end(), begin) - edges.begin());
  }
  start_[kLookUp] = static_cast<std::uint8_t>(beyond_);
  has_single_edges_ = true;
  for (std::size_t i = 0; i < kLookUp; ++i) {
    const double end = first_ + (static_cast<double>(i + 1) + 1e-6) / per_unit_;
    const auto below = static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), end) - edges.begin());
    has_single_edges_ = has_single_edges_ && below <= start_[i] + std::size_t{1};
  }
}

void PitCells::count(const double* x, std::size_t n, double offset, std::uint64_t* slots) const {
  if (!has_single_edges_) {
    for (std::size_t t = 0; t < n; ++t) ++slots[of(x[t] + offset)];
    return;
  }
  std::uint64_t unjudged = 0;
  for (std::size_t t = 0; t < n; ++t) {
    const double value = x[t] + offset, place = (value - first_) * per_unit_;
    const double within = place < kLookUp ? place : kLookUp;  // NaN is at the end
    const std::size_t slot = start_[static_cast<std::size_t>(static_cast<int>(within > 0 ? within : 0.0))];
    ++slots[slot + static_cast<std::size_t>(value >= edges_[slot])];
    unjudged += static_cast<std::uint64_t>(std::isnan(value));
  }
  slots[beyond_] -= unjudged;
  slots[kPitUnjudged] += unjudged;
}

PitCells PitCells::normal(double sd) {
  if (!(sd > 0) || !std::isfinite(sd)) return {};
  std::array<double, kPitBins + 1> edges = edges_as_u();
  for (double& e : edges) e = sd * normal_quantile(e);
  return PitCells(edges);
}

PitCells PitCells::normal_angle(double sd) {
  std::array<double, kPitBins + 1> edges = edges_as_u();
  if (!(sd > 0) || !(sd * normal_quantile(edges.back()) < kPi / 2)) return {};
  for (double& e : edges) e = std::tan(sd * normal_quantile(e));
  return PitCells(edges);
}

PitCells PitCells::chi_squared(double degrees) {
  std::array<double, kPitBins + 1> edges = edges_as_u();
  for (double& e : edges) e = chi_squared_quantile(degrees, e);
  return PitCells(edges);
}

PitCounts pit_counts(std::span<const std::uint64_t> slots) {
  assert(slots.size() == kPitSlots);
  PitCounts c;
  const std::array<double, kPitBins + 1> edges = edges_as_u();
  std::size_t bin = 0;
  for (std::size_t i = 0; i < kPitUnjudged; ++i) {
    c.bins[bin] += slots[i];
    c.total += slots[i];
    const bool cut = i < edges.size() && (edges[i] == 0.025 || edges[i] == 0.975);
    if (!cut) ++bin;
    const double below = i == 0 ? 0 : edges[i - 1], above = i < edges.size() ? edges[i] : 1;
    if (below >= 0.025 && above <= 0.975) c.central95 += slots[i];
  }
  c.unjudged = slots[kPitUnjudged];
  return c;
}

CalibrationResult judge_calibration(const PitCounts& counts, std::uint64_t units, ClaimedLaw law, double margin,
                                    double confidence) {
  assert(counts.total > 0 && units > 0);
  const double total = static_cast<double>(counts.total), n = static_cast<double>(units);
  CalibrationResult out;
  std::array<double, kInner> d{};
  std::uint64_t below = 0;
  double smallest = 1;
  for (std::size_t i = 0; i < kInner; ++i) {
    below += counts.bins[i];
    const double u = u_of(i), share = static_cast<double>(below) / total;
    d[i] = share - u;
    if (std::abs(d[i]) > std::abs(out.largest)) {
      out.largest = d[i];
      out.at = u;
    }
    // Both trials of a pair as if they were one.
    const auto x = units == counts.total ? below : static_cast<std::uint64_t>(std::llround(share * n));
    smallest = std::min(smallest, pointwise_p(x, units, u));
  }
  if (out.at == 0) out.at = 0.5;
  out.quantile = band_quantile(units, kPitBins, confidence);
  const double half = out.quantile * binomial_sd(out.at, n);
  out.interval = {out.largest - half, out.largest + half};
  out.p_band = band_p_value(units, kPitBins, smallest);
  constexpr int kWide = 20;
  double chi = 0;
  for (int b = 0; b < kWide; ++b) {
    double found = 0;
    for (int i = 0; i < kPitBins / kWide; ++i)
      found += static_cast<double>(counts.bins[static_cast<std::size_t>(b * (kPitBins / kWide) + i)]);
    const double expected = n / kWide, difference = found * n / total - expected;
    chi += difference * difference / expected;
  }
  out.p_chi_squared = chi_squared_upper_tail(kWide - 1, chi);
  fit_shape(d, law, out);
  if (margin > 0) {
    judge_with_margin(d, n, total / n, margin, out);
  } else {
    out.verdict = out.p_band < 1 - confidence ? "differs" : "agrees";
    out.p_differs = out.p_band;
    out.p_agrees = kNaN;  // a test that finds nothing is no proof
  }
  return out;
}

std::vector<double> calibration_shape(const std::string& shape, double size, ClaimedLaw law) {
  std::vector<double> out(kInner, 0.0);
  for (const Shape& s : shapes_of(law))
    if (s.name == shape)
      for (std::size_t i = 0; i < kInner; ++i) out[i] = size * s.d[i];
  return out;
}

}  // namespace surveymc::stats
