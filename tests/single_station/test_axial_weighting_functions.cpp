/// The weighting functions of axially corrected tools against the correction itself: Bz is taken such that (Bh, Bv) is
/// nearest to the reference.
#include <cmath>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "config/shipped_models.h"
#include "error_model/model_graph.h"
#include "single_station/station_solution.h"

using namespace surveymc;
using namespace surveymc::single_station;

namespace {

constexpr double kGravity = 9.80665, kField = 50000, kDip = 72 * kDegree;

/// Errors of readings and references.
struct Errors {
  survey::Vec3<double> accelerometer_bias{0, 0, 0}, accelerometer_scale{0, 0, 0};
  survey::Vec3<double> magnetometer_bias{0, 0, 0}, magnetometer_scale{0, 0, 0};
  double dip = 0, field = 0;
};

survey::Vec3<double> with_errors(const survey::Vec3<double>& x, const survey::Vec3<double>& bias,
                                 const survey::Vec3<double>& scale) {
  return {x.x * (1 + scale.x) + bias.x, x.y * (1 + scale.y) + bias.y, x.z * (1 + scale.z) + bias.z};
}

/// Magnetic azimuth that the correction finds. Magnetometers are next to perfect and Mz is free, so that Bz alone
/// moves.
double corrected_azimuth(const survey::Attitude& at, const Errors& e) {
  StationSigmas sigmas;
  sigmas.accelerometer_xy = sigmas.accelerometer_z = 1e-3;
  sigmas.magnetometer_xy = sigmas.magnetometer_z = 1e-4;
  sigmas.gravity = sigmas.horizontal = sigmas.vertical = 1;
  sigmas.axial = 1e5;
  const survey::Vec3<double> u = survey::down_T(at);
  const survey::Vec3<double> g = with_errors({kGravity * u.x, kGravity * u.y, kGravity * u.z}, e.accelerometer_bias,
                                             e.accelerometer_scale),
                             b = with_errors(survey::magnetic_T(at, kField, kDip), e.magnetometer_bias,
                                             e.magnetometer_scale);
  const double total = kField + e.field, dip = kDip + e.dip;
  const StationSolution s =
      solve_station(g, b, {kGravity, total * std::cos(dip), total * std::sin(dip)}, sigmas, StationMethod::extended_bh);
  REQUIRE(s.determined);
  return s.attitude.azimuth;
}

/// Change of the azimuth by one unit, from both sides.
template <class Set>
double derivative(const survey::Attitude& at, double step, const Set& set) {
  Errors plus, minus;
  set(plus, step);
  set(minus, -step);
  return std::remainder(corrected_azimuth(at, plus) - corrected_azimuth(at, minus), 2 * kPi) / (2 * step);
}

/// sinI w_A of a shipped function.
double lateral(const char* name, const survey::Attitude& at) {
  return error_model::weights_at(*config::shipped_functions().at(name),
                                 {.inclination = at.inclination, .azimuth = at.azimuth},
                                 error_model::surroundings_of({}, kDip, kField, kGravity, 1))
      .lateral;
}

/// Mean square over toolface of the derivatives by x and by y.
template <class Set>
double mean_square(survey::Attitude at, double step, const Set& set) {
  constexpr int kToolfaces = 12;
  double sum = 0;
  for (int i = 0; i < kToolfaces; ++i) {
    at.toolface = 2 * kPi * i / kToolfaces;
    for (const bool x : {true, false}) {
      const double d = derivative(at, step, [&](Errors& e, double by) { set(e, x, by); });
      sum += d * d / kToolfaces;
    }
  }
  return sum;
}

double square_sum(std::initializer_list<const char*> names, const survey::Attitude& at) {
  double sum = 0;
  for (const char* name : names) sum += lateral(name, at) * lateral(name, at);
  return sum;
}

}  // namespace

TEST_CASE("Weighting functions of axially corrected tools are the derivatives of the correction") {
  for (const double inclination : {20.0, 55.0, 85.0, 110.0})
    for (const double azimuth : {10.0, 60.0, 140.0, 250.0, 340.0}) {
      survey::Attitude at{inclination * kDegree, azimuth * kDegree, 0.7};
      const double si = std::sin(at.inclination);
      CAPTURE(inclination, azimuth);
      // Differences of azimuths have 1e-15 rad, over these steps 1e-9 of a weight; the step's square costs 1e-6.
      const auto close = [&](const char* name, double step, const auto& set) {
        CAPTURE(name);
        const double expected = lateral(name, at);
        CHECK(std::abs(si * derivative(at, step, set) - expected) <= 1e-4 * std::max(std::abs(expected), 1e-6));
      };
      close("ABIZ", 1e-3, [](Errors& e, double by) { e.accelerometer_bias.z = by; });
      close("ASIZ", 1e-4, [](Errors& e, double by) { e.accelerometer_scale.z = by; });
      close("MDI", 1e-4, [](Errors& e, double by) { e.dip = by; });
      close("MFI", 5, [](Errors& e, double by) { e.field = by; });
      const auto close_pair = [&](std::initializer_list<const char*> names, double step, const auto& set) {
        CAPTURE(*names.begin());
        const double expected = square_sum(names, at);
        CHECK(std::abs(si * si * mean_square(at, step, set) - expected) <= 1e-4 * expected);
      };
      close_pair({"ABIXY-TI1", "ABIXY-TI2"}, 1e-3,
                 [](Errors& e, bool x, double by) { (x ? e.accelerometer_bias.x : e.accelerometer_bias.y) = by; });
      close_pair({"ASIXY-TI1", "ASIXY-TI2", "ASIXY-TI3"}, 1e-4,
                 [](Errors& e, bool x, double by) { (x ? e.accelerometer_scale.x : e.accelerometer_scale.y) = by; });
      close_pair({"MBIXY-TI1", "MBIXY-TI2"}, 5,
                 [](Errors& e, bool x, double by) { (x ? e.magnetometer_bias.x : e.magnetometer_bias.y) = by; });
      close_pair({"MSIXY-TI1", "MSIXY-TI2", "MSIXY-TI3"}, 1e-4,
                 [](Errors& e, bool x, double by) { (x ? e.magnetometer_scale.x : e.magnetometer_scale.y) = by; });
      // Bz is not used: its errors do nothing.
      CHECK(std::abs(derivative(at, 5, [](Errors& e, double by) { e.magnetometer_bias.z = by; })) < 1e-9);
    }
}
