#include "monitoring/gas_lift_well.h"

#include <cmath>

#include <Eigen/LU>

#include "base/error.h"
#include "base/units.h"
#include "simd/dual.h"

namespace surveymc::monitoring {

using namespace simd;
namespace {

template <class T>
T positive(const T& x) {
  return select(x > T(0.0), x, T(0.0));
}
/// Root that is 0 at 0, with a derivative that is 0 there, as of a closed valve.
template <class T>
T root(const T& x) {
  const auto open = x > T(0.0);
  return select(open, sqrt(select(open, x, T(1.0))), T(0.0));
}

template <class T>
struct GasLiftFlow {
  std::array<T, 3> derivative;
  T bottom_hole, tubing_top, annulus_top;
};

/// x: kg of annulus gas, tubing gas, tubing liquid. T: double, or Dual for the Jacobian.
template <class T>
GasLiftFlow<T> flow(const GasLiftWell& p, const std::array<T, 3>& x, double injection) {
  const double area = kPi / 4 * p.tubing_diameter * p.tubing_diameter;
  const double volume = (p.tubing_length + p.reservoir_length) * area, g = p.gravity;
  const double tubing_gas = p.gas_constant * p.tubing_temperature / p.molar_mass,
               annulus_gas = p.gas_constant * p.annulus_temperature / p.molar_mass;
  const T pat = T(annulus_gas / p.annulus_volume) * x[0];
  const T pai = pat + T(g * p.annulus_length / p.annulus_volume) * x[0];
  const T pwh = T(tubing_gas) * x[1] / (T(volume) - x[2] / T(p.oil_density));
  const T m = x[1] + x[2] - T(p.oil_density * p.reservoir_length * area);
  const T density = m / T(p.tubing_length * area);
  const T wpc = T(p.production_coefficient) * root(density * positive(pwh - T(p.separator_pressure)));
  const T friction = T(p.friction * p.tubing_length / (2 * p.tubing_diameter * area * area)) * wpc * wpc / density;
  const T pwi = pwh + T(g / area) * m + friction;
  const T pwf = pwi + T(p.oil_density * g * p.reservoir_length);
  const T wiv = T(p.injection_coefficient) * root(pai * positive(pai - pwi) / T(annulus_gas));
  const T wr = T(p.reservoir_coefficient) * positive(T(p.reservoir_pressure) - pwf);
  const T gas = wr * T(p.gas_oil_ratio / (1 + p.gas_oil_ratio)), oil = wr * T(1 / (1 + p.gas_oil_ratio));
  const T tubing = x[1] + x[2];
  return {{T(injection) - wiv, wiv + gas - wpc * x[1] / tubing, oil - wpc * x[2] / tubing}, pwf, pwh, pat};
}

}  // namespace

Eigen::Matrix3d gas_lift_jacobian(const GasLiftWell& well, const GasLiftState& x, double injection) {
  using D = Dual<double, 3>;
  const auto f = flow<D>(well, {D::variable(x[0], 0), D::variable(x[1], 1), D::variable(x[2], 2)}, injection);
  Eigen::Matrix3d j;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) j(r, c) = f.derivative[static_cast<std::size_t>(r)].d[static_cast<std::size_t>(c)];
  return j;
}

namespace {

/// False if Newton's method does not end at a state in which all three masses are positive.
bool newton(const GasLiftWell& well, double injection, GasLiftState& x) {
  for (int i = 0; i < 50; ++i) {
    const GasLiftState f = gas_lift_derivative(well, x, injection);
    const Eigen::Vector3d step =
        gas_lift_jacobian(well, x, injection).partialPivLu().solve(Eigen::Vector3d(f[0], f[1], f[2]));
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] -= step[static_cast<Eigen::Index>(k)];
      largest = std::max(largest, std::abs(step[static_cast<Eigen::Index>(k)] / x[k]));
      if (!(x[k] > 0)) return false;
    }
    if (largest < 1e-13) return true;
  }
  return false;
}

}  // namespace

GasLiftState gas_lift_derivative(const GasLiftWell& well, const GasLiftState& state, double injection) {
  return flow<double>(well, state, injection).derivative;
}

GasLiftPressures gas_lift_pressures(const GasLiftWell& well, const GasLiftState& state, double injection) {
  const auto f = flow<double>(well, state, injection);
  const double choke = injection / well.manifold_coefficient;
  const double gas = well.gas_constant * well.annulus_temperature / well.molar_mass;
  return {f.bottom_hole, f.tubing_top, f.annulus_top,
          (f.annulus_top + std::sqrt(f.annulus_top * f.annulus_top + 4 * choke * choke * gas)) / 2};
}

GasLiftState gas_lift_step(const GasLiftWell& well, const GasLiftState& x, double injection, double dt) {
  const auto at = [&](double h, const GasLiftState& k) {
    return gas_lift_derivative(well, {x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2]}, injection);
  };
  const GasLiftState k1 = gas_lift_derivative(well, x, injection), k2 = at(dt / 2, k1), k3 = at(dt / 2, k2),
                     k4 = at(dt, k3);
  GasLiftState next;
  for (std::size_t i = 0; i < 3; ++i) next[i] = x[i] + dt / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  return next;
}

GasLiftState gas_lift_steady_state(const GasLiftWell& well, double injection) {
  require(injection > 0, "gas-lift well: injection = {} kg/s: must be > 0", injection);
  // A start-up of 40 h at a stable rate leads into the basin of Newton's method; then the rate moves in small steps.
  constexpr double kStable = 0.6;
  GasLiftState x{4000, 1000, 8000};
  for (int i = 0; i < 40 * 720; ++i) x = gas_lift_step(well, x, kStable, 5);
  bool found = newton(well, kStable, x);
  const int steps = 1 + static_cast<int>(std::abs(injection - kStable) / 0.02);
  for (int i = 1; i <= steps && found; ++i) found = newton(well, kStable + (injection - kStable) * i / steps, x);
  require(found, "gas-lift well: no steady state at an injection of {} kg/s", injection);
  return x;
}

InjectionSchedule gas_lift_schedule(bool out_of_range) {
  InjectionSchedule s{7.5, {.60, .80, .50, .70, .90, .40, .65, .85, .45, .75, .55, .88,  // training
                            .70, .50, .85, .60, .42, .78, .55, .66, .88, .48, .74, .62, .82, .45, .58, .72, .52, .80}};
  if (out_of_range) {
    constexpr std::array<double, 6> kBeyond{.92, 1.00, 1.06, 1.10, 1.03, .96};
    std::copy(kBeyond.begin(), kBeyond.end(), s.rates.end() - 6);
  }
  return s;
}

Eigen::Index gas_lift_samples(const InjectionSchedule& schedule, double sample_s) {
  return static_cast<Eigen::Index>(
      std::llround(schedule.step_h * 3600 * static_cast<double>(schedule.rates.size()) / sample_s));
}

Samples simulate_gas_lift(const GasLiftWell& well, const InjectionSchedule& schedule, double sample_s, double dt_s) {
  const Eigen::Index samples = gas_lift_samples(schedule, sample_s);
  const auto steps = std::llround(sample_s / dt_s);
  const auto rate = [&](double t) {  // a step at a whole multiple of its length belongs to the next rate
    const auto i = static_cast<std::size_t>(std::floor(t / (schedule.step_h * 3600) + 1e-9));
    return schedule.rates[std::min(i, schedule.rates.size() - 1)];
  };
  Samples out(samples, 4);
  GasLiftState x = gas_lift_steady_state(well, schedule.rates.front());
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double t = static_cast<double>(i) * sample_s;
    const GasLiftPressures p = gas_lift_pressures(well, x, rate(t));
    out.row(i) << p.pt_f, p.pt_t, p.pt_g, p.pt_m;
    for (long long k = 0; k < steps; ++k) x = gas_lift_step(well, x, rate(t + static_cast<double>(k) * dt_s), dt_s);
  }
  return out;
}

}  // namespace surveymc::monitoring
