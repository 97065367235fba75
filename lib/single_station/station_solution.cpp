#include "single_station/station_solution.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "simd/instruction_set.h"
#include "single_station/axial_correction.h"
#include "single_station/axial_correction_lanes.h"

namespace surveymc::single_station {
namespace {

bool pulls_horizontal(StationMethod m) { return m == StationMethod::extended_bh || m == StationMethod::optimising; }

ToolAxes<double> axes_of(const StationSolution& x) {
  return {std::sin(x.attitude.inclination),
          std::cos(x.attitude.inclination),
          std::sin(x.attitude.toolface),
          std::cos(x.attitude.toolface),
          x.gravity,
          1.0};
}

using Row = Eigen::Matrix<double, 1, 10>;

/// Standard deviations of the inputs of StationGains.
Row input_sds(const StationSigmas& s) {
  return (Row() << s.accelerometer_xy, s.accelerometer_xy, s.accelerometer_z, s.gravity, s.magnetometer_xy,
          s.magnetometer_xy, s.magnetometer_z, s.axial, s.vertical, s.horizontal)
      .finished();
}

/// Errors of the solution by the inputs, and of the misclosures Bd_ref - Bd and Bh_ref - Bh of the adjustment; these
/// with the variance that the weights give them, which take the attitude as exact. Bh: where it is observed, else 0.
struct ErrorRows {
  Row inclination, across, gravity, north, east, vertical, axial;  // across: sin I times the error of the toolface
  Row missing_vertical, missing_horizontal = Row::Zero();
  double variance_vertical = 0, variance_horizontal = 0;
};

ErrorRows error_rows(const StationSolution& x, const StationSigmas& s, StationMethod method) {
  const ToolAxes<double> at = axes_of(x);
  // A vertical hole has sin I = 0 exactly, which the sine of pi is not.
  const double si = at.si < 1e-15 ? 0 : at.si, ci = at.ci, per_g = 1 / x.gravity;
  const ConditionGains<double> k = condition_gains(at, s, method);
  const NorthCovariance<double> p = north_covariance(at, k, s, method);

  // Accelerometers: lean and z, with the pull of the gravity reference.
  Row lean = Row::Zero(), z = Row::Zero();
  lean[0] = z[2] = 1;
  if (method == StationMethod::optimising) {
    const double a = s.accelerometer_xy * s.accelerometer_xy, c = s.accelerometer_z * s.accelerometer_z;
    const double v = si * si * a + ci * ci * c + s.gravity * s.gravity;
    Row missing = -(si * lean + ci * z);
    missing[3] = 1;
    lean += a * si / v * missing;
    z += c * ci / v * missing;
  }
  ErrorRows rows;
  rows.inclination = (ci * lean - si * z) * per_g;
  rows.across = Row::Zero();
  rows.across[1] = per_g;
  rows.gravity = si * lean + ci * z;

  // Errors of `high`, `right` and bz that follow from turning readings by a wrong attitude and comparing them with a
  // model at this attitude. The effect of a wrong toolface on the azimuth of a vertical hole, a turn psi = cosI across
  // / sinI about the vertical, is left out here: it changes neither Bh nor Bd nor Mz.
  const double n = x.north, e = x.east, d = x.vertical;
  Row high = (si * n + ci * d) * rows.inclination, axial = (si * d - ci * n) * rows.inclination;
  high[4] = axial[6] = axial[7] = 1;
  Row w = si * high - ci * axial;
  w[8] = 1;
  rows.missing_vertical = w + e * rows.across;
  rows.variance_vertical = k.variance;
  rows.north = ci * high + si * axial + k.north * rows.missing_vertical;
  rows.east = d * rows.across;
  rows.east[5] = 1;
  rows.vertical = -si * high + ci * axial + k.vertical * w + e * (k.vertical - 1) * rows.across;
  rows.axial = k.axial * rows.missing_vertical;
  rows.axial[7] -= 1;
  if (!pulls_horizontal(method)) return rows;

  const double bh = x.horizontal(), ca = n / bh, sa = e / bh;
  const double v = ca * ca * p.north + sa * sa * p.east + s.horizontal * s.horizontal;
  Row missing = -(ca * rows.north + sa * rows.east);
  missing[9] = 1;
  rows.missing_horizontal = missing;
  rows.variance_horizontal = v;
  rows.north += p.north * ca / v * missing;
  rows.east += p.east * sa / v * missing;
  rows.vertical += p.vertical_north * ca / v * missing;
  rows.axial += p.axial_north * ca / v * missing;
  return rows;
}

}  // namespace

const std::vector<std::string>& station_method_names() {
  static const std::vector<std::string> names{"basic", "simple", "extended", "extended_bh", "optimising"};
  return names;
}

StationMethod station_method(const std::string& name) {
  const std::vector<std::string>& names = station_method_names();
  const auto at = std::find(names.begin(), names.end(), name);
  require(at != names.end(), "single-station method \"{}\": must be one of {}", name, fmt::join(names, ", "));
  return static_cast<StationMethod>(at - names.begin());
}

void check_sigmas(const StationSigmas& s, StationMethod method) {
  const auto check = [](double x, bool positive, const char* name) {
    require(std::isfinite(x) && (positive ? x > 0 : x >= 0), "sigma of {} = {}: must be finite and {} 0", name, x,
            positive ? ">" : ">=");
  };
  const bool optimising = method == StationMethod::optimising;
  check(s.accelerometer_xy, optimising, "the x and y accelerometers");
  check(s.accelerometer_z, optimising, "the z accelerometer");
  check(s.magnetometer_xy, true, "the x and y magnetometers");
  check(s.magnetometer_z, true, "the z magnetometer");
  check(s.gravity, optimising, "the reference gravity");
  check(s.horizontal, pulls_horizontal(method), "the reference Bh");
  check(s.vertical, false, "the reference Bd");
  check(s.axial, false, "the axial magnetisation");
}

StationSolution solve_station(const survey::Vec3<double>& g_T, const survey::Vec3<double>& b_T,
                              const StationReferences& ref, const StationSigmas& s, StationMethod method) {
  check_sigmas(s, method);
  const bool optimise = method == StationMethod::optimising;
  const ToolAxes<double> at = axes_from_accelerometers(g_T, optimise, ref.gravity, s);
  const FieldSolution<double> f = solve_field(at, b_T, ref.horizontal, ref.vertical, s, method);
  StationSolution x;
  x.determined = f.found == 1 && std::isfinite(f.north) && std::isfinite(f.east) && std::isfinite(f.vertical) &&
                 std::isfinite(f.axial);
  const auto positive = [](double angle) { return angle < 0 ? angle + 2 * kPi : angle; };
  x.attitude = {std::atan2(at.si, at.ci), positive(std::atan2(f.east, f.north)), positive(std::atan2(at.st, at.ct))};
  x.gravity = at.gravity;
  x.north = f.north;
  x.east = f.east;
  x.vertical = f.vertical;
  x.axial = f.axial;
  x.misclosure = f.misclosure;
  x.cost = f.cost;
  x.redundancy = method == StationMethod::extended ? 1 : pulls_horizontal(method) ? 2 : 0;
  return x;
}

StationGains station_gains(const StationSolution& x, const StationSigmas& s, StationMethod method) {
  const ErrorRows rows = error_rows(x, s, method);
  const double ci = std::cos(x.attitude.inclination), per_g = 1 / x.gravity;
  const double sine = std::sin(x.attitude.inclination), si = sine < 1e-15 ? 0 : sine;
  const double bh = x.horizontal(), ca = x.north / bh, sa = x.east / bh;
  const double infinity = kInfinity;
  const Row azimuth = (ca * rows.east - sa * rows.north) / bh;
  StationGains gains;
  gains << rows.inclination, rows.across, azimuth, azimuth, rows.gravity, ca * rows.north + sa * rows.east,
      rows.vertical, rows.axial;
  // azimuth -= cosI toolface; turn = azimuth +- toolface, written so that nothing cancels
  gains(1, 1) = si > 0 ? per_g / si : infinity;
  gains(2, 1) = si > 0 ? azimuth[1] - ci * per_g / si : -std::copysign(infinity, ci);
  gains(3, 1) = azimuth[1] + (ci >= 0 ? si / (1 + ci) : -si / (1 - ci)) * per_g;
  return gains;
}

StationCovariance station_covariance(const StationSolution& x, const StationSigmas& weights, StationMethod method,
                                     const StationSigmas& actual) {
  const StationGains gains = station_gains(x, weights, method);
  const Row sd = input_sds(actual);
  StationCovariance c = StationCovariance::Zero();
  for (Eigen::Index i = 0; i < 10; ++i) {
    if (sd[i] == 0) continue;
    for (Eigen::Index r = 0; r < 8; ++r)
      for (Eigen::Index q = 0; q < 8; ++q) {
        const double a = gains(r, i) * sd[i], b = gains(q, i) * sd[i];
        if (a != 0 && b != 0) c(r, q) += a * b;  // an infinite gain times none is none
      }
  }
  return c;
}

double fit_statistic(const StationSolution& x, const StationReferences& ref, const StationSigmas& s,
                     StationMethod method) {
  if (x.redundancy == 0) return kNaN;
  const ErrorRows rows = error_rows(x, s, method);
  Row sd = input_sds(s);
  if (method == StationMethod::optimising) sd[7] = 0;  // its model has no Mz
  // Misclosures over the sd that the weights give them: their squares are the parts of the cost. u, v: their errors.
  const double a = x.misclosure / std::sqrt(rows.variance_vertical);
  const Row u = rows.missing_vertical.cwiseProduct(sd) / std::sqrt(rows.variance_vertical);
  if (x.redundancy == 1) return a * a / u.squaredNorm();
  const double b = std::copysign(std::sqrt(std::max(0.0, x.cost - a * a)), ref.horizontal - x.horizontal());
  const Row v = rows.missing_horizontal.cwiseProduct(sd) / std::sqrt(rows.variance_horizontal);
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
  return (a * a * vv - 2 * a * b * uv + b * b * uu) / (uu * vv - uv * uv);
}

survey::LaneArray solve_stations(const survey::LaneArray& readings, int stations, int groups,
                                 const StationSigmas& sigmas, StationMethod method) {
  check_sigmas(sigmas, method);
  survey::LaneArray solutions(groups, stations * kStationSolutionRows);
  const StationSolveBatch b{readings.row(0, 0), solutions.row(0, 0), groups * stations, sigmas, method};
  simd::run_kernel<isa_v3::solve_station_batch, isa_v4::solve_station_batch>(b);
  return solutions;
}

}  // namespace surveymc::single_station
