#include "chained/mode_search.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <nlopt.hpp>

#include "base/units.h"
#include "chained/attitude.h"
#include "chained/basic_solution.h"
#include "chained/reading_residual.h"

namespace surveymc::chained {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

using Objective = std::function<double(const std::vector<double>&)>;

double call(const std::vector<double>& x, std::vector<double>&, void* objective) {
  const double value = (*static_cast<Objective*>(objective))(x);
  return std::isfinite(value) ? value : 1e300;
}

/// Nelder-Mead from x, which it replaces by the best point. The result is only a start for the descent: three digits
/// are enough.
double nelder_mead(Objective objective, std::vector<double>& x, double step, int evaluations) {
  nlopt::opt opt(nlopt::LN_NELDERMEAD, static_cast<unsigned>(x.size()));
  opt.set_min_objective(call, &objective);
  opt.set_xtol_abs(1e-3 * step);
  opt.set_ftol_rel(1e-6);
  opt.set_maxeval(evaluations);
  opt.set_initial_step(step);
  double value = 0;
  try {
    opt.optimize(x, value);
  } catch (const nlopt::roundoff_limited&) {  // x is the best point so far
  }
  return value;
}

double squared(double x) { return x * x; }

StationReading without(const Model& m, const StationReading& y, const std::vector<double>& offsets) {
  StationReading r = y;
  for (std::size_t i = 0; i < 6; ++i) r[i] -= offsets[i] * m.prior_sd[kReferenceStates + i];
  return r;
}

Point point_with(const Model& m, const Readings& readings, const std::vector<double>& offsets) {
  Point p;
  ChainVector c = ChainVector::Zero();
  for (std::size_t i = 0; i < 6; ++i)
    c[static_cast<Eigen::Index>(kReferenceStates + i)] = offsets[i] * m.prior_sd[kReferenceStates + i];
  for (const StationReading& y : readings.y) p.frames.push_back(basic_station(without(m, y, offsets)).frame);
  p.chain.assign(readings.y.size(), c);
  p.interference = Eigen::VectorXd::Zero(m.interference.states());
  return p;
}

/// Misfit of constant offsets: gravity and fields of the corrected readings against the references, whose errors and
/// half a run's walk of the offsets count as noise.
double offset_misfit(const Model& m, const Readings& readings, const std::vector<double>& offsets) {
  const double half = readings.stations() / 2.0;
  const auto variance = [&](std::size_t reference, std::size_t reading) {
    return squared(m.noise[reading]) + half * squared(m.link_sd[kReferenceStates + reading]) +
           squared(m.prior_sd[reference]);
  };
  double sum = 0;
  for (const StationReading& y : readings.y) {
    const SingleStation s = basic_station(without(m, y, offsets));
    sum += squared(s.gravity - m.gravity) / variance(kGravityError, 2) +
           squared(s.horizontal - m.horizontal) / variance(kHorizontalError, 5) +
           squared(s.down - m.down) / variance(kDownError, 5);
  }
  for (const double b : offsets) sum += b * b;
  return sum;
}

Point search_offsets_from(const Model& m, const Readings& readings, std::vector<double> x) {
  nelder_mead([&](const std::vector<double>& b) { return offset_misfit(m, readings, b); }, x, 1.0, 3000);
  return point_with(m, readings, x);
}

std::vector<double> offsets_of(const Model& m, const Point& p) {
  std::vector<double> x(6);
  for (std::size_t i = 0; i < 6; ++i) {
    double mean = 0;
    for (const ChainVector& c : p.chain) mean += c[static_cast<Eigen::Index>(kReferenceStates + i)];
    x[i] = mean / static_cast<double>(p.chain.size()) / m.prior_sd[kReferenceStates + i];
  }
  return x;
}

bool same_mode(const Solution& a, const Solution& b) {
  double turn = 0;
  for (std::size_t k = 0; k < a.stations.size(); ++k)
    turn = std::max(turn, rotation_between(a.stations[k].frame, b.stations[k].frame).norm());
  return turn < 1e-6;  // minima after the descent are right to 1e-12
}

}  // namespace

Point search_attitudes(const Model& m, const Readings& readings) {
  Point p;
  for (const StationReading& y : readings.y) {
    double best = 0;
    Matrix3d best_frame;
    for (int start = 0; start < 8; ++start) {
      const Matrix3d from = frame_of({kPi / 4, (start % 4) * kPi / 2, (start / 4) * kPi});
      const auto frame = [&](const std::vector<double>& x) -> ToolFrame<double> {
        return turned<double>({x[0], x[1], x[2]},
                              {survey::from_eigen(Vector3d(from.col(0))), survey::from_eigen(Vector3d(from.col(2)))});
      };
      const auto misfit = [&](const std::vector<double>& x) {
        const auto e = reading_residual<double>(m.gravity, m.horizontal, m.down, y, frame(x), {}, {0, 0, 0});
        double sum = 0;
        for (std::size_t i = 0; i < 6; ++i)
          sum += squared(e[i]) / (squared(m.noise[i]) + squared(m.prior_sd[kReferenceStates + i]));
        return sum;
      };
      std::vector<double> x(3, 0.0);
      const double value = nelder_mead(misfit, x, 0.5, 1000);
      if (start > 0 && value >= best) continue;
      best = value;
      const ToolFrame<double> found = frame(x);
      best_frame.col(0) = survey::to_eigen(found.n);
      best_frame.col(1) = survey::to_eigen(cross(found.d, found.n));
      best_frame.col(2) = survey::to_eigen(found.d);
    }
    p.frames.push_back(best_frame);
  }
  p.chain.assign(readings.y.size(), ChainVector::Zero());
  p.interference = Eigen::VectorXd::Zero(m.interference.states());
  return p;
}

Point search_offsets(const Model& m, const Readings& readings) {
  return search_offsets_from(m, readings, std::vector<double>(6, 0.0));
}

Point mirrored(const Model& m, const Readings& readings, const Point& point, bool search) {
  double shift = 0;
  for (std::size_t k = 0; k < point.frames.size(); ++k) {
    // Bh cosA / sinI = Bh n_z / sin^2 I; where the hole is nearly vertical there is no second solution to look for
    const Vector3d d = point.frames[k].col(2);
    const double sine2 = std::max(d.x() * d.x() + d.y() * d.y(), 0.01);
    shift += 2 * (m.horizontal + point.chain[k][kHorizontalError]) * point.frames[k](2, 0) / sine2;
  }
  std::vector<double> x = offsets_of(m, point);
  x[5] += shift / static_cast<double>(point.frames.size()) / m.prior_sd[kMagnetometerOffset + 2];
  return search ? search_offsets_from(m, readings, x) : point_with(m, readings, x);
}

Modes find_modes(const Model& m, const Readings& readings, const SearchOptions& options) {
  std::vector<Point> starts{basic_start(m, readings), search_offsets(m, readings)};
  for (std::size_t i = 0; i < 2; ++i) {
    starts.push_back(mirrored(m, readings, starts[i], false));
    starts.push_back(mirrored(m, readings, starts[i], true));
  }
  if (options.attitudes) starts.push_back(search_attitudes(m, readings));
  Modes out;
  const auto add = [&](Solution s) {
    if (!s.converged) return;
    for (const Solution& known : out.modes)
      if (same_mode(known, s)) return;
    out.modes.push_back(std::move(s));
  };
  for (const Point& start : starts) add(solve_blocks(m, readings, start, options.polish));
  if (!out.modes.empty()) {  // the minimum's own mirror image
    std::sort(out.modes.begin(), out.modes.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
    add(solve_blocks(m, readings, mirrored(m, readings, point_of(out.modes.front()), false), options.polish));
  }
  std::sort(out.modes.begin(), out.modes.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  out.ambiguous = out.modes.size() > 1 && out.modes[1].cost - out.modes[0].cost < options.ambiguity;
  return out;
}

}  // namespace surveymc::chained
