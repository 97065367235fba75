/// The checked settings of a config of `mwd_drift`.
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "compare/trial_plan.h"
#include "config/meanings.h"
#include "mwd_drift/study.h"

namespace surveymc::studies::mwd_drift {
namespace {

monitoring::Vector6 sensor_values(config::ConfigReader& c, const std::string& key, const config::Range& range,
                                  std::string_view meaning, double accelerometer_mg, double magnetometer_nT) {
  const double a = c.number(key + ".accelerometer_mg", range, meaning, accelerometer_mg) * kMilliG;
  const double m = c.number(key + ".magnetometer_nT", range, meaning, magnetometer_nT);
  return (monitoring::Vector6() << a, a, a, m, m, m).finished();
}

}  // namespace

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.trials = static_cast<std::uint64_t>(c.integer("trials", 1, 100'000'000, "wells to draw"));
  s.field = scenario::read_field(c);
  s.stations = static_cast<int>(c.integer("well.stations", 3, 100'000, "stations of the well", 80));
  s.spacing = c.number("well.spacing_m", config::Range::positive(), "distance of the stations", 30);
  s.inclination_from = kDegree * c.number("well.inclination_from_deg", config::Range::closed(0, 180),
                                          "inclination of the first station", 0);
  s.inclination_to = kDegree * c.number("well.inclination_to_deg", config::Range::closed(0, 180),
                                        "inclination of the last station", 60);
  s.azimuth = kDegree *
              c.number("well.magnetic_azimuth_deg", config::Range::closed(0, 360), "magnetic azimuth of the well", 60);
  s.noise = sensor_values(c, "noise", config::Range::positive(), "one sd of a reading of these sensors", 0.2, 20);
  s.walk = sensor_values(c, "walk", config::Range::positive(),
                         "one sd of the step of these biases from station to station", 0.02, 2);
  s.scatter = {kMilliG * c.number("scatter.gravity_mg", config::Range::non_negative(),
                                  "one sd of the gravity reference, at each station", 0.1),
               c.number("scatter.total_nT", config::Range::non_negative(),
                        "one sd of the total-field reference, at each station", 30),
               kDegree * c.number("scatter.dip_deg", config::Range::non_negative(),
                                  "one sd of the dip reference, at each station", 0.05)};
  const std::string sensor = c.choice("drift.sensor", {kSensors.begin(), kSensors.end()}, "the sensor that drifts");
  s.sensor = static_cast<int>(std::find(kSensors.begin(), kSensors.end(), sensor) - kSensors.begin());
  s.drift_at_td = monitoring::Vector6::Zero();
  s.drift_at_td[s.sensor] =
      s.sensor < 3
          ? kMilliG * c.number("drift.at_td_mg", config::Range{}, "drift of an accelerometer at the last station")
          : c.number("drift.at_td_nT", config::Range{}, "drift of a magnetometer at the last station");
  s.from_station = static_cast<int>(
      c.integer("drift.from_station", 0, s.stations - 2, "the last station without drift, counted from 0", 20));
  s.sprt.shift =
      c.number("sprt.shift_sd", config::Range::positive(), "shift that the SPRT looks for, in sd of a channel", 3);
  s.sprt.variance = 1;
  s.sprt.false_alarm = c.number("sprt.false_alarm", config::Range::open(0, 0.5),
                                "false alarms that the SPRT allows a decision (alpha)", 1e-4);
  s.sprt.missed_alarm = c.number("sprt.missed_alarm", config::Range::open(0, 0.5),
                                 "missed alarms that the SPRT allows a decision (beta)", 0.10);
  s.alarm_sd = c.number("filter.alarm_sd", config::Range::positive(), "an estimated bias of so many sd is an alarm", 3);
  s.verdict.confidence = c.number("verdict.confidence", compare::kConfidences, config::meaning::kConfidence, 0.95);
  s.verdict.margin = c.number("verdict.margin", config::Range::open(0, 1), config::meaning::kMargin, s.verdict.margin);
  s.verdict.nees_margin =
      c.number("verdict.nees_margin", config::Range::open(0, 1), config::meaning::kNeesMargin, s.verdict.nees_margin);
  const std::vector<double> no_rows;
  const Outcomes none(no_rows);
  std::vector<compare::Row> names;
  for (const compare::ComparisonRow& r : comparison_rows(s, none))
    names.push_back({"comparison", r.formulation, r.quantity});
  for (const compare::ComparisonRow& r : claim_rows(s, none)) names.push_back({"claims", r.formulation, r.quantity});
  s.annotations = compare::Annotations::read(c, names);
  c.finish();
  return s;
}

}  // namespace surveymc::studies::mwd_drift
