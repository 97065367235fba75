#include "scenario/adjustment_scenario.h"

#include "base/units.h"
#include "config/meanings.h"
#include "scenario/reference_field.h"

namespace surveymc::scenario {

namespace {

/// All of the field but the dip, unless the place gives the dip as well. `usual`: what is not given.
survey::ReferenceField read_adjustment_field(config::ConfigReader& c, survey::ReferenceField usual) {
  if (const std::optional<PlacedField> placed = read_placed_field(c)) return placed->field;
  usual.total = c.number("field.total_nT", config::Range::closed(1e3, 1e6), config::meaning::kTotalField, usual.total);
  usual.gravity =
      c.number("field.gravity_mps2", config::Range::closed(9.7, 9.9), config::meaning::kGravity, usual.gravity);
  usual.declination =
      c.number("field.declination_deg", config::Range::closed(-180, 180), config::meaning::kDeclination, 0) * kDegree;
  return usual;
}

}  // namespace

double read_dip(config::ConfigReader& c, const reliability::AdjustmentModel& model) {
  if (c.has("field.model")) return model.field.dip;
  return c.number("field.dip_deg", config::Range::closed(-89, 89), config::meaning::kDip, 75) * kDegree;
}

reliability::AdjustmentModel read_adjustment_model(config::ConfigReader& c) {
  reliability::AdjustmentModel m;
  m.mode = reliability::adjustment_mode(
      c.choice("mode", reliability::adjustment_mode_names(),
               "'sse': one station; 'sse_axial': one station without bz; 'mse_fixed': one of many stations, references "
               "free of error; 'mse_shared': `stations` stations share the references"));
  m.field = read_adjustment_field(c, m.field);
  m.stations = static_cast<int>(
      c.integer("stations", 1, 1'000'000, "stations that share the references, of `mse_shared`", m.stations));
  m.systematic_terms =
      c.boolean("systematic_terms",
                "of `mse_shared`: the 12 biases and scale factors are unknowns, with the sigmas as priors", false);

  // Noise of zero would make misclosures without covariance in the mse modes; so large a sigma has no digits left.
  constexpr double kLeast_nT = 1e-4, kLeast_mps2 = 1e-9;  // below, those misclosures differ in their last digits only
  const config::Range positive{0, 1e5, true, false}, any = config::Range::closed(0, 1e5),
                                                     small = config::Range::closed(0, 1);
  reliability::SigmaModel& s = m.sigma;
  s.accelerometer_bias = c.number(
      "sigma.accelerometer_bias_mps2", small,
      "one sd of an accelerometer's bias (eq 22); biases and scales count in the sse modes and with `systematic_terms`",
      s.accelerometer_bias);
  s.accelerometer_scale =
      c.number("sigma.accelerometer_scale", small, "one sd of an accelerometer's scale factor", s.accelerometer_scale);
  s.accelerometer_noise = c.number("sigma.accelerometer_noise_mps2", config::Range::closed(kLeast_mps2, 1),
                                   "one sd of an accelerometer's noise", s.accelerometer_noise);
  s.magnetometer_bias =
      c.number("sigma.magnetometer_bias_nT", any, "one sd of a magnetometer's bias", s.magnetometer_bias);
  s.magnetometer_scale =
      c.number("sigma.magnetometer_scale", small, "one sd of a magnetometer's scale factor", s.magnetometer_scale);
  s.magnetometer_noise = c.number("sigma.magnetometer_noise_nT", config::Range::closed(kLeast_nT, 1e5),
                                  "one sd of a magnetometer's noise", s.magnetometer_noise);
  s.axial_interference = c.number("sigma.axial_interference_nT", any,
                                  "one sd of the axial interference of the drill string", s.axial_interference);
  s.gravity = c.number("sigma.gravity_mps2", config::Range{0, 1, true, false},
                       "one sd of the gravity reference; not in `mse_fixed`", s.gravity);
  const bool named = c.has("sigma.reference");
  const ReferenceSize size =
      named ? reference_size(c.choice(
                  "sigma.reference", kFieldModels,
                  "the model's errors as sds of total field (138 nT) and dip (0.20 deg), each of which can be given"))
            : ReferenceSize{s.total_field, 0.12 * kDegree};
  s.total_field = c.number("sigma.total_field_nT", positive,
                           "one sd of the reference of the total field; not in `mse_fixed`", size.total);
  s.dip = c.number("sigma.dip_deg", config::Range{0, 45, true, false},
                   "one sd of the reference of the dip; not in `mse_fixed`", named ? size.dip / kDegree : 0.12) *
          kDegree;
  return m;
}

reliability::TestLevels read_test_levels(config::ConfigReader& c) {
  reliability::TestLevels l;
  l.tails = c.choice("tails", {"one", "two"},
                     "'one': alpha is per tail, as in the paper; 'two': alpha is of both tails", "one") == "one"
                ? reliability::Tails::one
                : reliability::Tails::two;
  l.alpha = c.number("alpha", config::Range::open(0, 1), "level of a test", l.alpha);
  c.require(reliability::two_sided_alpha(l) < 1, "alpha", "per tail it must be below 0.5");
  l.power = c.number("power", config::Range::open(0, 1), "power of a test", l.power);
  c.require(reliability::lambda0(l) > 0, "power", "must be above the probability of a false alarm in one tail");
  return l;
}

}  // namespace surveymc::scenario
