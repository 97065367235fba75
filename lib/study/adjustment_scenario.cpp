#include "study/adjustment_scenario.h"

#include "base/units.h"

namespace surveymc::study {

reliability::AdjustmentModel read_adjustment_model(config::ConfigReader& c) {
  reliability::AdjustmentModel m;
  m.mode = reliability::adjustment_mode(c.choice("mode", reliability::adjustment_mode_names()));
  m.field.total = c.number("field.total_nT", config::Range::closed(1e3, 1e6), m.field.total);
  m.field.gravity = c.number("field.gravity_mps2", config::Range::closed(9.7, 9.9), m.field.gravity);
  m.field.declination = c.number("field.declination_deg", config::Range::closed(-180, 180), 0) * kDegree;
  m.stations = static_cast<int>(c.integer("stations", 1, 1'000'000, m.stations));
  m.systematic_terms = c.boolean("systematic_terms", false);

  // Noise of zero would make misclosures without covariance in the mse modes; so large a sigma has no digits left.
  const config::Range positive{0, 1e5, true, false}, any = config::Range::closed(0, 1e5),
                                                     small = config::Range::closed(0, 1);
  reliability::SigmaModel& s = m.sigma;
  s.accelerometer_bias = c.number("sigma.accelerometer_bias_mps2", small, s.accelerometer_bias);
  s.accelerometer_scale = c.number("sigma.accelerometer_scale", small, s.accelerometer_scale);
  s.accelerometer_noise =
      c.number("sigma.accelerometer_noise_mps2", config::Range{0, 1, true, false}, s.accelerometer_noise);
  s.magnetometer_bias = c.number("sigma.magnetometer_bias_nT", any, s.magnetometer_bias);
  s.magnetometer_scale = c.number("sigma.magnetometer_scale", small, s.magnetometer_scale);
  s.magnetometer_noise = c.number("sigma.magnetometer_noise_nT", positive, s.magnetometer_noise);
  s.axial_interference = c.number("sigma.axial_interference_nT", any, s.axial_interference);
  s.gravity = c.number("sigma.gravity_mps2", config::Range{0, 1, true, false}, s.gravity);
  s.total_field = c.number("sigma.total_field_nT", positive, s.total_field);
  s.dip = c.number("sigma.dip_deg", config::Range{0, 45, true, false}, 0.12) * kDegree;
  return m;
}

reliability::TestLevels read_test_levels(config::ConfigReader& c) {
  reliability::TestLevels l;
  l.tails = c.choice("tails", {"one", "two"}, "one") == "one" ? reliability::Tails::one : reliability::Tails::two;
  l.alpha = c.number("alpha", config::Range::open(0, 1), l.alpha);
  c.require(reliability::two_sided_alpha(l) < 1, "alpha", "per tail it must be below 0.5");
  l.power = c.number("power", config::Range::open(0, 1), l.power);
  c.require(reliability::lambda0(l) > 0, "power", "must be above the probability of a false alarm in one tail");
  return l;
}

}  // namespace surveymc::study
