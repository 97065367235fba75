#include "scenario/station_sigmas.h"

#include <fmt/format.h>

namespace surveymc::scenario {

single_station::StationSigmas read_station_sigmas(config::ConfigReader& c) {
  const config::Range acceleration = config::Range::closed(0, 1), field{0, 1e6, true, false},
                      any_field = config::Range::closed(0, 1e6);
  single_station::StationSigmas s;
  s.accelerometer_xy =
      c.number("sigma.accelerometer_xy_mps2", acceleration, "one sd of the accelerometers x and y", 0.0);
  s.accelerometer_z =
      c.number("sigma.accelerometer_z_mps2", acceleration, "one sd of the accelerometer z", s.accelerometer_xy);
  s.gravity = c.number("sigma.gravity_mps2", acceleration, "one sd of the gravity reference", 0.0);
  s.magnetometer_xy = c.number("sigma.magnetometer_xy_nT", field, "one sd of the magnetometers x and y");
  s.magnetometer_z = c.number("sigma.magnetometer_z_nT", field, "one sd of the magnetometer z", s.magnetometer_xy);
  s.horizontal = c.number("sigma.horizontal_nT", any_field, "one sd of the horizontal reference field", 0.0);
  s.vertical = c.number("sigma.vertical_nT", any_field, "one sd of the vertical reference field");
  s.axial = c.number("sigma.axial_magnetisation_nT", any_field,
                     "one sd of the axial magnetisation, a priori; 0: unknown", 0.0);
  return s;
}

void require_station_sigmas(const config::ConfigReader& c, const std::string& key, single_station::StationMethod method,
                            const single_station::StationSigmas& s) {
  const std::string& name = single_station::station_method_names()[static_cast<std::size_t>(method)];
  const auto needed = [&](double sigma, const char* sigma_key) {
    if (sigma > 0) return;
    const std::string rule = "must be > 0: the method " + name + " weighs with it";
    if (c.has(sigma_key)) c.fail(sigma_key, rule);
    c.fail(key, fmt::format("{} {}", sigma_key, rule));
  };
  const bool optimising = method == single_station::StationMethod::optimising;
  if (optimising || method == single_station::StationMethod::extended_bh) needed(s.horizontal, "sigma.horizontal_nT");
  if (!optimising) return;
  needed(s.gravity, "sigma.gravity_mps2");
  needed(s.accelerometer_xy, "sigma.accelerometer_xy_mps2");
  needed(s.accelerometer_z, "sigma.accelerometer_z_mps2");
}

}  // namespace surveymc::scenario
