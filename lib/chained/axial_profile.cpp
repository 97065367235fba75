#include "chained/axial_profile.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/units.h"
#include "chained/attitude.h"
#include "stats/intervals.h"
#include "stats/normal_tail.h"

namespace surveymc::chained {
namespace {

constexpr int kBias = kMagnetometerOffset + 2;

struct Conditional {
  double bias = 0, cost = 0, log_density = 0;
  double azimuth = 0, azimuth_sd = 0;  ///< azimuth less that of the lowest minimum
  Solution solution;
};

class Profile {
 public:
  Profile(const Model& m, const Readings& readings, const Solution& lowest, int station)
      : m_(m), readings_(readings), station_(station) {
    const StationEstimate& s = lowest.stations[static_cast<std::size_t>(station)];
    claimed_ = std::sqrt(s.covariance(3 + kBias, 3 + kBias));
    azimuth_ = attitude_of(s.frame).azimuth;
    polish_.step_tolerance = 1e-6;
  }
  double claimed_sd() const { return claimed_; }
  double azimuth() const { return azimuth_; }

  /// The minimum with the station's axial bias held at `bias`, searched from the minimum of a neighbouring value.
  std::optional<Conditional> at(double bias, const Solution& from) const {
    const double sd = 1e-3 * claimed_;  // small enough to hold the bias
    Readings held = readings_;
    held.known.push_back({station_, kBias, bias, sd});
    Conditional c;
    c.solution = solve_blocks(m_, held, point_of(from), polish_);
    if (!c.solution.converged) return std::nullopt;
    const StationEstimate& s = c.solution.stations[static_cast<std::size_t>(station_)];
    const double miss = (s.chain[kBias] - bias) / sd;
    c.bias = s.chain[kBias];
    c.cost = c.solution.cost - miss * miss;
    c.log_density = -(c.cost + c.solution.log_determinant) / 2;
    c.azimuth = std::remainder(attitude_of(s.frame).azimuth - azimuth_, 2 * kPi);
    c.azimuth_sd = attitude_sd(s.frame, s.covariance.topLeftCorner<3, 3>())[1];
    return c;
  }

 private:
  const Model& m_;
  const Readings& readings_;
  int station_;
  double claimed_ = 0, azimuth_ = 0;
  Options polish_;
};

/// Smallest x with sum of weights Phi((x - azimuth)/sd) >= p.
double mixture_quantile(const std::vector<Conditional>& points, const std::vector<double>& weights, double p) {
  double low = 1e300, high = -1e300;
  for (const Conditional& c : points) {
    low = std::min(low, c.azimuth - 10 * c.azimuth_sd);
    high = std::max(high, c.azimuth + 10 * c.azimuth_sd);
  }
  for (int it = 0; it < 60; ++it) {
    const double x = (low + high) / 2;
    double below = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      below += weights[i] * stats::normal_upper_tail((points[i].azimuth - x) / points[i].azimuth_sd);
    (below < p ? low : high) = x;
  }
  return (low + high) / 2;
}

/// The profile around every minimum, in steps that change J by about 1/2; `out.complete` becomes false where the
/// profile cannot be followed.
std::vector<std::vector<Conditional>> trace_segments(const Profile& profile, const std::vector<Solution>& modes,
                                                     const AxialProfileOptions& options, AxialProfile& out) {
  const Solution& lowest = modes.front();
  const auto k = static_cast<std::size_t>(out.station);
  std::vector<std::pair<double, double>> ranges;
  std::vector<std::vector<Conditional>> segments;
  int count = 0;
  for (const Solution& mode : modes) {
    const double middle = mode.stations[k].chain[kBias];
    if (mode.cost - lowest.cost > options.cutoff) break;
    if (std::any_of(ranges.begin(), ranges.end(),
                    [&](const auto& r) { return r.first <= middle && middle <= r.second; }))
      continue;
    const std::optional<Conditional> centre = profile.at(middle, mode);
    if (!centre) {
      out.complete = false;
      continue;
    }
    std::vector<Conditional> segment{*centre};
    for (const double side : {-1.0, 1.0}) {
      Conditional last = *centre;
      double step = out.claimed_sd / 2;
      while (last.cost - lowest.cost <= options.cutoff) {
        if (++count > options.max_points) {
          out.complete = false;
          break;
        }
        const std::optional<Conditional> next = profile.at(last.bias + side * step, last.solution);
        const double change = next ? std::abs(next->cost - last.cost) : 1e300;
        if (change > 2 && step > out.claimed_sd / 64) {
          step /= 2;
          continue;
        }
        if (!next) {
          out.complete = false;
          break;
        }
        last = *next;
        segment.push_back(last);
        if (change < 0.5) step = std::min(1.5 * step, 2 * out.claimed_sd);
      }
    }
    std::sort(segment.begin(), segment.end(), [](const auto& a, const auto& b) { return a.bias < b.bias; });
    ranges.emplace_back(segment.front().bias, segment.back().bias);
    segments.push_back(std::move(segment));
  }
  return segments;
}

/// Mean, sd and interval of the azimuth and of the bias by integration over the profile.
void integrate_azimuth(std::vector<std::vector<Conditional>> segments, const AxialProfileOptions& options,
                       AxialProfile& out) {
  double top = -1e300;
  for (const auto& segment : segments)
    for (const Conditional& c : segment) top = std::max(top, c.log_density);
  std::vector<Conditional> points;
  std::vector<double> weights;
  double sum = 0;
  for (auto& segment : segments)
    for (std::size_t i = 0; i < segment.size(); ++i) {
      const double left = i > 0 ? segment[i].bias - segment[i - 1].bias : 0,
                   right = i + 1 < segment.size() ? segment[i + 1].bias - segment[i].bias : 0;
      weights.push_back((left + right) / 2 * std::exp(segment[i].log_density - top));
      sum += weights.back();
      points.push_back(segment[i]);
      points.back().solution = {};
    }
  if (!(sum > 0)) {
    out.complete = false;
    return;
  }
  double mean_bias = 0, square_bias = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    weights[i] /= sum;
    const double b = points[i].bias - out.bias, a = points[i].azimuth;
    mean_bias += weights[i] * b;
    square_bias += weights[i] * b * b;
    mean += weights[i] * a;
    square += weights[i] * (a * a + points[i].azimuth_sd * points[i].azimuth_sd);
  }
  out.mean_bias = out.bias + mean_bias;
  out.sd_bias = std::sqrt(square_bias - mean_bias * mean_bias);
  out.azimuth_mean = out.azimuth + mean;
  out.azimuth_sd = std::sqrt(square - mean * mean);
  out.azimuth_low = out.azimuth + mixture_quantile(points, weights, (1 - options.confidence) / 2);
  out.azimuth_high = out.azimuth + mixture_quantile(points, weights, (1 + options.confidence) / 2);
}

}  // namespace

AxialProfile profile_azimuth(const Model& m, const Readings& readings, const std::vector<Solution>& modes, int station,
                             const AxialProfileOptions& options, bool always) {
  const Solution& lowest = modes.front();
  const auto k = static_cast<std::size_t>(station);
  const Profile profile(m, readings, lowest, station);
  AxialProfile out;
  out.station = station;
  out.bias = out.mean_bias = lowest.stations[k].chain[kBias];
  out.claimed_sd = out.sd_bias = profile.claimed_sd();
  out.azimuth = out.azimuth_mean = profile.azimuth();
  out.azimuth_claimed_sd = out.azimuth_sd =
      attitude_sd(lowest.stations[k].frame, lowest.stations[k].covariance.topLeftCorner<3, 3>())[1];
  const auto by_sd = [&](double z) {
    out.azimuth_low = out.azimuth - z * out.azimuth_sd;
    out.azimuth_high = out.azimuth + z * out.azimuth_sd;
  };
  by_sd(stats::normal_quantile((1 + options.confidence) / 2));
  const std::optional<Conditional> low = profile.at(out.bias - 2 * out.claimed_sd, lowest),
                                   high = profile.at(out.bias + 2 * out.claimed_sd, lowest);
  out.complete = low && high;
  out.rise_low = low ? low->cost - lowest.cost : kNaN;
  out.rise_high = high ? high->cost - lowest.cost : kNaN;
  const auto four = [&](double rise) { return std::abs(rise / 4 - 1) <= options.parabola; };
  const bool one_mode = modes.size() < 2 || modes[1].cost - lowest.cost > options.cutoff;
  out.parabola = one_mode && four(out.rise_low) && four(out.rise_high);
  if ((out.parabola && !always) || !std::isfinite(out.azimuth_claimed_sd)) return out;

  std::vector<std::vector<Conditional>> segments = trace_segments(profile, modes, options, out);
  integrate_azimuth(std::move(segments), options, out);
  return out;
}

}  // namespace surveymc::chained
