#include "proximity/pair_scan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <boost/math/tools/minima.hpp>

#include "base/units.h"
#include "propagate/hole_direction.h"
#include "survey/survey.h"

namespace surveymc::proximity {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// m: centre lines that are nearer meet. Between them there is no direction, only rounding.
constexpr double kCoincident = 1e-6;

double positive_turn(double angle) { return angle < 0 ? angle + 2 * kPi : angle; }

/// The listed azimuth where the hole is vertical, so that a direction about it means what the survey says.
double azimuth_of(const PairGeometry& g, const PathPoint& p) {
  return propagate::azimuth_of(p.tangent, g.reference_survey->stations[p.leg + (p.share == 1 ? 1 : 0)].azimuth);
}

double toolface_of(const PairGeometry& g, const PathPoint& p, const Vector3d& d) {
  const double inclination = std::atan2(std::hypot(p.tangent.x(), p.tangent.y()), p.tangent.z());
  const Vector3d hla = survey::rotation_hla_from_nev(inclination, azimuth_of(g, p)) * d;
  // A direction along the hole has no toolface.
  if (std::hypot(hla.x(), hla.y()) <= 1e-9 * d.norm()) return kNaN;
  return positive_turn(std::atan2(hla.y(), hla.x()));
}

PairPoints pair_of(const PairGeometry& g, ScanDirection direction, const PathPoint& from, const ClosestPoint& to) {
  PairPoints p;
  p.reference = direction == ScanDirection::reference ? from : to.point;
  p.offset = direction == ScanDirection::reference ? to.point : from;
  p.end = to.end;
  p.distance = to.distance;
  if (p.distance < kCoincident) {
    p.distance = 0;
    p.offset.position = p.reference.position;
  }
  const Vector3d d = p.offset.position - p.reference.position;
  p.bearing = std::hypot(d.x(), d.y()) <= 1e-9 * d.norm() ? kNaN : positive_turn(std::atan2(d.y(), d.x()));
  p.toolface = d.isZero(0) ? kNaN : toolface_of(g, p.reference, d);
  return p;
}

const WellPath& scanned(const PairGeometry& g, ScanDirection direction) {
  return direction == ScanDirection::reference ? *g.reference : *g.offset;
}
const WellPath& other(const PairGeometry& g, ScanDirection direction) {
  return direction == ScanDirection::reference ? *g.offset : *g.reference;
}

/// Measured depths of a scan: all stations, and points `step` apart from the first of them on.
std::vector<double> scanned_depths(const PairGeometry& g, const WellPath& path, double step) {
  std::vector<double> md;
  for (std::size_t k = g.first_scanned; k < path.stations(); ++k) {
    md.push_back(path.md(k));
    if (step <= 0 || k + 1 == path.stations()) continue;
    const double begin = path.md(g.first_scanned);
    for (double i = std::floor((path.md(k) - begin) / step) + 1; survey::is_deeper(path.md(k + 1), begin + i * step);
         ++i)
      if (survey::is_deeper(begin + i * step, path.md(k))) md.push_back(begin + i * step);
  }
  return md;
}

double value_of(LeastOf quantity, const PairGeometry& g, const PairErrors& errors, const PairPoints& points) {
  if (quantity == LeastOf::distance) return points.distance;
  const Vector3d d = points.offset.position - points.reference.position;
  const Matrix3d c =
      relative_covariance(errors, errors.reference->covariance_at(points.reference.leg, points.reference.share),
                          errors.offset->covariance_at(points.offset.leg, points.offset.share), points.reference.leg,
                          points.reference.share, points.offset.leg, points.offset.share);
  if (quantity == LeastOf::mahalanobis) return mahalanobis(d, c);
  const Vector3d u = points.distance > 0 ? Vector3d(d / points.distance) : Vector3d::Zero();
  return separation_factor(g.rule, points.distance, g.radii, pedal_radius(c, u));
}

}  // namespace

PairPoints pair_at(const PairGeometry& g, ScanDirection direction, double md) {
  const PathPoint from = scanned(g, direction).at(md);
  return pair_of(g, direction, from, other(g, direction).closest(from.position, g.first));
}

std::vector<PairPoints> scan(const PairGeometry& g, ScanDirection direction, double step, double keep) {
  const WellPath &path = scanned(g, direction), &target = other(g, direction);
  std::vector<PairPoints> out;
  std::vector<ClosestPoint> minima;
  for (const double md : scanned_depths(g, path, step)) {
    if (keep <= 1) {
      out.push_back(pair_at(g, direction, md));
      continue;
    }
    const PathPoint from = path.at(md);
    target.local_minima(from.position, g.first, minima);
    std::stable_sort(minima.begin(), minima.end(),
                     [](const ClosestPoint& a, const ClosestPoint& b) { return a.distance < b.distance; });
    for (std::size_t i = 0; i < minima.size(); ++i)
      if (i == 0 || minima[i].distance <= keep * minima.front().distance) {
        out.push_back(pair_of(g, direction, from, minima[i]));
        out.back().minimum = static_cast<int>(i) + 1;
      }
  }
  return out;
}

PairClearance clearance_of(const PairGeometry& g, const PairErrors& errors, const PairPoints& points,
                           bool with_factor) {
  const Vector3d d = points.offset.position - points.reference.position;
  const Vector3d u = points.distance > 0 ? Vector3d(d / points.distance) : Vector3d::Zero();
  const Matrix3d c_reference = errors.reference->covariance_at(points.reference.leg, points.reference.share),
                 c_offset = errors.offset->covariance_at(points.offset.leg, points.offset.share),
                 c = relative_covariance(errors, c_reference, c_offset, points.reference.leg, points.reference.share,
                                         points.offset.leg, points.offset.share);
  PairClearance r;
  r.sd_reference = pedal_radius(c_reference, u);
  r.sd_offset = pedal_radius(c_offset, u);
  r.sd_relative = pedal_radius(c, u);
  r.separation_factor = separation_factor(g.rule, points.distance, g.radii, r.sd_relative);
  r.ellipse_separation = ellipse_separation(g.rule, points.distance, g.radii, r.sd_relative);
  r.sigma_distance = points.distance == 0 ? 0.0 : points.distance / r.sd_relative;
  r.mahalanobis = mahalanobis(d, c);
  r.ellipsoid_factor = with_factor && errors.is_independent ? ellipsoid_factor(d, c_reference, c_offset) : kNaN;
  return r;
}

std::vector<PairPoints> least_samples(const PairGeometry& g, ScanDirection direction) {
  constexpr int kParts = 4;
  const WellPath& path = scanned(g, direction);
  std::vector<PairPoints> samples;
  for (std::size_t k = g.first_scanned; k < path.stations(); ++k)
    for (int i = 0; i < (k + 1 == path.stations() ? 1 : kParts); ++i)
      samples.push_back(
          pair_at(g, direction, i == 0 ? path.md(k) : path.md(k) + i * (path.md(k + 1) - path.md(k)) / kParts));
  return samples;
}

std::array<Least, 3> least_clearance(const PairGeometry& g, const PairErrors& errors, ScanDirection direction,
                                     const std::vector<PairPoints>& pairs, const std::vector<PairPoints>& samples) {
  constexpr double kRounding = 1e-12;  // of the value: a plateau has no minima
  constexpr int kBits = 24;            // 2^-24 of the bracket
  const auto points_at = [&](double md) { return pair_at(g, direction, md); };
  std::vector<double> md;
  for (const PairPoints& p : samples)
    md.push_back(direction == ScanDirection::reference ? p.reference.md : p.offset.md);
  std::array<Least, 3> out;
  for (std::size_t q = 0; q < kLeastOf.size(); ++q) {
    Least& least = out[q];
    least.at_station = least.continuous = kNaN;
    for (const PairPoints& p : pairs) {
      const double x = value_of(kLeastOf[q], g, errors, p);
      least.is_everywhere = least.is_everywhere && !std::isnan(x);
      if (std::isnan(x) || x >= least.at_station - kRounding * std::abs(x)) continue;  // of equal ones the first
      least.at_station = x;
      least.station_pair = p;
    }
    least.continuous = least.at_station;
    least.pair = least.station_pair;
    std::vector<double> value;
    for (const PairPoints& p : samples) {
      value.push_back(value_of(kLeastOf[q], g, errors, p));
      least.is_everywhere = least.is_everywhere && !std::isnan(value.back());
    }
    for (std::size_t i = 0; i < md.size(); ++i) {
      const double lo = i == 0 ? HUGE_VAL : value[i - 1], hi = i + 1 == md.size() ? HUGE_VAL : value[i + 1];
      const double rounding = kRounding * std::abs(value[i]);
      if (!(value[i] <= lo && value[i] <= hi) || !std::isfinite(value[i])) continue;
      if (value[i] < least.continuous - rounding) {
        least.continuous = value[i];
        least.pair = samples[i];
      }
      if (!(value[i] < lo - rounding || value[i] < hi - rounding)) continue;
      const auto [at, x] = boost::math::tools::brent_find_minima(
          [&](double depth) { return value_of(kLeastOf[q], g, errors, points_at(depth)); }, md[i == 0 ? 0 : i - 1],
          md[std::min(i + 1, md.size() - 1)], kBits);
      if (x < least.continuous - rounding) {
        least.continuous = x;
        least.pair = points_at(at);
      }
    }
  }
  return out;
}

}  // namespace surveymc::proximity
