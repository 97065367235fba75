#pragma once
/// A gas-lifted oil well with four pressure gauges: public stand-in for the OLGA model of Boechat, Moreno and Haramura.
/// Eikrem-type model with three states; the parameters are ours.
#include <array>
#include <compare>
#include <vector>

#include "monitoring/samples.h"

namespace surveymc::monitoring {

/// SI units throughout.
struct GasLiftWell {
  double gravity = 9.81, gas_constant = 8.314, molar_mass = 0.020;  ///< m/s2, J/(mol K), kg/mol
  double annulus_temperature = 320, tubing_temperature = 340;       ///< K
  double annulus_length = 2500, tubing_length = 2500;               ///< m
  double annulus_volume = 60;                                       ///< m3
  double tubing_diameter = 0.124;                                   ///< m, above and below the injection point
  double reservoir_length = 100;                                    ///< m of tubing below the injection point
  double oil_density = 850, gas_oil_ratio = 0;                      ///< kg/m3; kg/kg
  double reservoir_coefficient = 4e-6;                              ///< kg/(s Pa)
  double injection_coefficient = 4e-5, production_coefficient = 1e-3, manifold_coefficient = 6e-5;  ///< m2
  double friction = 0.02;
  double reservoir_pressure = 18e6, separator_pressure = 1e6;  ///< Pa
};

/// kg: gas in the annulus, gas in the tubing, liquid in the tubing.
using GasLiftState = std::array<double, 3>;

/// Pa: bottom hole, top of the tubing, top of the annulus, upstream of the injection choke.
struct GasLiftPressures {
  double pt_f = 0, pt_t = 0, pt_g = 0, pt_m = 0;
};

/// Time derivative of the state (kg/s) at an injection rate (kg/s).
GasLiftState gas_lift_derivative(const GasLiftWell& well, const GasLiftState& state, double injection);
GasLiftPressures gas_lift_pressures(const GasLiftWell& well, const GasLiftState& state, double injection);

/// The steady state, stable or not: Newton's method with the exact Jacobian, followed from a stable rate.
/// InputError if there is none with flow through all valves.
GasLiftState gas_lift_steady_state(const GasLiftWell& well, double injection);

/// Derivatives (1/s) of the masses' rates by the masses: an eigenvalue with a positive real part means casing heading.
Eigen::Matrix3d gas_lift_jacobian(const GasLiftWell& well, const GasLiftState& state, double injection);

/// One step of the classical Runge-Kutta method of fourth order; dt in seconds.
GasLiftState gas_lift_step(const GasLiftWell& well, const GasLiftState& state, double injection, double dt);

/// Injection rates (kg/s) held in turn, each for the same time.
struct InjectionSchedule {
  double step_h = 7.5;
  std::vector<double> rates;
  auto operator<=>(const InjectionSchedule&) const = default;
};
/// 30 steps, 12 to train and 18 to test, between 0.40 and 0.90 kg/s. `out_of_range`: the last six are 0.92 to 1.10.
InjectionSchedule gas_lift_schedule(bool out_of_range);

/// How many samples simulate_gas_lift() gives.
Eigen::Index gas_lift_samples(const InjectionSchedule& schedule, double sample_s);

/// Pressures (Pa; columns PT_f, PT_t, PT_g, PT_m) every `sample_s` from time 0 to the end of the schedule (excluded),
/// from the steady state of the first rate; Runge-Kutta steps of `dt_s`, of which a sample takes a whole number.
Samples simulate_gas_lift(const GasLiftWell& well, const InjectionSchedule& schedule, double sample_s, double dt_s);

}  // namespace surveymc::monitoring
