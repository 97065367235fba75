#include "disturbance/process.h"

#include <cassert>
#include <cmath>

#include "base/units.h"

namespace surveymc::disturbance {
namespace {

constexpr double kDay = 86400;
/// A storm is over after so many times its decay: 1e-7 of its height is left.
constexpr double kLongestDecays = 16;

double storm_shape(const Process& p, double since) {
  if (since < 0) return 0;
  return since < p.rise ? since / p.rise : std::exp(-(since - p.rise) / p.decay);
}

/// Integral of s(u) s(u + lag) over all u, lag >= 0.
double shape_product(const Process& p, double lag) {
  const double r = p.rise, d = p.decay;
  // Both in the rise, u from 0 to r - lag; the first in the rise and the second behind it; both behind it.
  double sum = 0.5 * d * std::exp(-lag / d);
  if (r == 0) return sum;
  const double from = std::max(0.0, r - lag);
  if (lag < r) sum += (from * from * from / 3 + lag * from * from / 2) / (r * r);
  // Integral of (u / r) exp(-(u + lag - r) / d) from `from` to r.
  const auto primitive = [&](double u) { return -d * (u + d) * std::exp(-(u + lag - r) / d) / r; };
  return sum + primitive(r) - primitive(from);
}

std::size_t steps_of(const Series& s, double seconds) {
  const auto n = static_cast<double>(s.field.cols());
  const double steps = std::fmod(std::round(seconds / s.step), n);
  return static_cast<std::size_t>(steps < 0 ? steps + n : steps);
}

}  // namespace

Eigen::Matrix3d covariance(const Process& p, double lag) {
  if (lag < 0) return covariance(p, -lag).transpose();
  switch (p.kind) {
    case Kind::ar1: {
      const double r = lag == 0 ? 1 : p.tau == 0 ? 0 : std::exp(-lag / p.tau);
      return (r * p.sd.cwiseAbs2()).asDiagonal();
    }
    case Kind::storm:
      return (p.storms * shape_product(p, lag) * p.sd.cwiseAbs2()).asDiagonal();
    case Kind::series: {
      const auto n = p.series->field.cols(), shift = static_cast<Eigen::Index>(steps_of(*p.series, lag)),
                 rest = n - shift;
      const Eigen::Matrix3Xd& x = p.series->field;
      const Eigen::Matrix3d sum =
          x.leftCols(rest) * x.rightCols(rest).transpose() + x.rightCols(shift) * x.leftCols(shift).transpose();
      return sum / static_cast<double>(n);
    }
  }
  return Eigen::Matrix3d::Zero();
}

Eigen::Matrix3Xd draw(const Process& p, const std::vector<double>& times, const random::Stream& stream,
                      std::uint64_t trial) {
  const auto n = static_cast<Eigen::Index>(times.size());
  Eigen::Matrix3Xd x = Eigen::Matrix3Xd::Zero(3, n);
  switch (p.kind) {
    case Kind::ar1:
      for (Eigen::Index k = 0; k < n; ++k) {
        const auto z = stream.normals<double>(trial, kAr1, static_cast<std::uint64_t>(k));
        const Eigen::Vector3d own = p.sd.cwiseProduct(Eigen::Vector3d(z[0], z[1], z[2]));
        const auto at = static_cast<std::size_t>(k);
        const double r = k == 0 || p.tau == 0 ? 0 : std::exp(-(times[at] - times[at - 1]) / p.tau);
        x.col(k) = k == 0 ? own : Eigen::Vector3d(r * x.col(k - 1) + std::sqrt(1 - r * r) * own);
      }
      break;
    case Kind::storm: {
      // Storms that began before the run still decay in it.
      double onset = times.front() - p.rise - kLongestDecays * p.decay;
      for (std::uint64_t storm = 0;; ++storm) {
        const auto u = stream.uniforms<double>(trial, kStorm, storm);
        onset += -std::log(u[0]) / p.storms;
        if (onset > times.back()) break;
        const double v = p.mixing ? -std::log(u[1]) : 1;
        const auto z = stream.normals<double>(trial, kStormVector, storm);
        const Eigen::Vector3d height = std::sqrt(v) * p.sd.cwiseProduct(Eigen::Vector3d(z[0], z[1], z[2]));
        for (Eigen::Index k = 0; k < n; ++k)
          x.col(k) += storm_shape(p, times[static_cast<std::size_t>(k)] - onset) * height;
      }
      break;
    }
    case Kind::series: {
      const auto count = static_cast<std::size_t>(p.series->field.cols());
      const double u = stream.uniforms<double>(trial, kStart, std::uint64_t{0})[0];
      const auto start = static_cast<std::size_t>(u * static_cast<double>(count));
      for (Eigen::Index k = 0; k < n; ++k) {
        const std::size_t after = steps_of(*p.series, times[static_cast<std::size_t>(k)] - times.front());
        x.col(k) = p.series->field.col(static_cast<Eigen::Index>((start + after) % count));
      }
      break;
    }
  }
  return x;
}

double storms_of_run(const Process& p, double seconds) {
  return p.storms * (seconds + p.rise + kLongestDecays * p.decay);
}

double kurtosis(const Process& p, const Eigen::RowVector3d& direction) {
  switch (p.kind) {
    case Kind::ar1:
      return direction.transpose().cwiseProduct(p.sd).isZero(0) ? kNaN : 3;
    case Kind::storm: {
      // Fourth cumulant of shot noise: rate E V^2 3 sd^4 times the integral of s^4.
      const double variance = direction.cwiseAbs2() * p.sd.cwiseAbs2(), of_v = p.mixing ? 2 : 1;
      const double second = p.storms * shape_product(p, 0), fourth = p.storms * (p.rise / 5 + p.decay / 4);
      return variance > 0 ? 3 + 3 * of_v * fourth / (second * second) : kNaN;
    }
    case Kind::series: {
      const Eigen::ArrayXd x = (direction * p.series->field).transpose().array().square();
      return x.mean() > 0 ? x.square().mean() / (x.mean() * x.mean()) : kNaN;
    }
  }
  return kNaN;
}

double outside_three_sd(const Process& p, const Eigen::RowVector3d& direction) {
  if (p.kind == Kind::storm) return kNaN;
  if (p.kind == Kind::ar1) return std::erfc(3 / std::sqrt(2.0));
  const Eigen::ArrayXd x = (direction * p.series->field).transpose().array().square();
  return static_cast<double>((x > 9 * x.mean()).count()) / static_cast<double>(x.size());
}

Series daily_waves(const Eigen::Matrix3d& amplitude, const Eigen::Matrix3d& maximum) {
  Series s;
  s.field.setZero(3, 1440);
  for (Eigen::Index minute = 0; minute < s.field.cols(); ++minute)
    for (int component = 0; component < 3; ++component)
      for (int wave = 0; wave < 3; ++wave)
        s.field(component, minute) +=
            amplitude(component, wave) *
            std::cos(2 * kPi * (wave + 1) / 24 * (static_cast<double>(minute) / 60 - maximum(component, wave)));
  return s;
}

void take_off_quiet_level(Series& s, QuietLevel level) {
  if (level == QuietLevel::daily) {
    const auto day = static_cast<Eigen::Index>(std::lround(kDay / s.step));
    assert(day > 0 && s.field.cols() >= 2 * day);
    for (Eigen::Index minute = 0; minute < day; ++minute) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double count = 0;
      for (Eigen::Index i = minute; i < s.field.cols(); i += day, ++count) sum += s.field.col(i);
      for (Eigen::Index i = minute; i < s.field.cols(); i += day) s.field.col(i) -= sum / count;
    }
  }
  const Eigen::Vector3d mean = s.field.rowwise().mean();
  s.field.colwise() -= mean;
}

Eigen::Matrix3d elements_by_field(const survey::ReferenceField& field) {
  const double c = std::cos(field.dip), s = std::sin(field.dip), f = field.total;
  Eigen::Matrix3d m;
  m << 0, 1 / (f * c), 0,  //
      -s / f, 0, c / f,    //
      c, 0, s;
  return m;
}

}  // namespace surveymc::disturbance
