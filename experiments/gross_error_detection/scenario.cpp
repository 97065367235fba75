#include "gross_error_detection/scenario.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "analysis/gross_error_event.h"
#include "compare/trial_plan.h"
#include "config/suggest.h"
#include "gross_error_detection/tables.h"
#include "reliability/nonlinear_detectable.h"
#include "scenario/adjustment_scenario.h"

namespace surveymc::studies::gross_error_detection {
namespace {

/// One attitude a station: lists of one length, and numbers that hold for all stations.
std::vector<survey::Attitude> read_attitudes(config::ConfigReader& c, const reliability::AdjustmentModel& model,
                                             bool stations_given) {
  const config::Range any = config::Range::closed(-360, 360);
  const std::vector<std::pair<std::string, std::vector<double>>> angles{
      {"inclination_deg", c.number_or_list("inclination_deg", config::Range::closed(0, 180),
                                           "inclination; of `mse_shared` also a list with one value a station")},
      {"toolface_deg", c.number_or_list("toolface_deg", any, "toolface from y; of `mse_shared` also a list")},
      {"magnetic_azimuth_deg",
       c.number_or_list("magnetic_azimuth_deg", any, "magnetic azimuth; of `mse_shared` also a list")}};
  const bool several = model.mode == reliability::AdjustmentMode::mse_shared;
  std::size_t count = 1;
  std::string listed;
  for (const auto& [key, values] : angles) {
    if (values.size() == 1) continue;
    c.require(several, key,
              "a list has one value a station: only with mode = \"mse_shared\" (for several attitudes, "
              "sweep)");
    c.require(listed.empty() || values.size() == count, key,
              fmt::format("has {} values, {} has {}: one a station", values.size(), listed, count));
    count = values.size();
    listed = key;
  }
  if (several && listed.empty()) count = static_cast<std::size_t>(model.stations);
  if (several && !listed.empty() && stations_given)
    c.require(count == static_cast<std::size_t>(model.stations), "stations",
              fmt::format("{} has {} values: one a station", listed, count));
  c.require(count <= 200, "stations", "at most 200: every trial is adjusted as a whole");
  if (model.rotational_shot) {
    c.require(angles[0].second.size() == 1, "inclination_deg", "the shots of one station share it: one number");
    c.require(angles[2].second.size() == 1, "magnetic_azimuth_deg", "the shots of one station share it: one number");
  }
  std::vector<survey::Attitude> all(count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto at = [&](std::size_t a) {
      const std::vector<double>& v = angles[a].second;
      return v[v.size() == 1 ? 0 : k] * kDegree;
    };
    all[k] = {at(0), at(2), at(1)};  // inclination, azimuth, toolface
  }
  return all;
}

/// Size of an error: a number with its unit, or a minimal detectable error times its own factor; both times `all`, the
/// factor of all errors.
void read_size(config::ConfigReader& e, const Scenario& s, InjectedError& injected, double all) {
  const std::size_t o = injected.observation;
  const std::string unit = reliability::observation_unit(o), number_key = "size_" + unit;
  if (!e.has("size")) {
    for (const char* other : {"mps2", "nT", "deg"})
      e.require(unit == other || !e.has(std::string("size_") + other), std::string("size_") + other,
                fmt::format("errors of {} are in {}", reliability::observation_names()[o], unit));
    // Large enough for anything that still is a reading
    const double most = unit == "nT" ? 1e5 : unit == "deg" ? 20 : 10;
    injected.error.size =
        all *
        e.number(number_key, config::Range::closed(-most, most), "the gross error, in the unit of the observation") /
        reliability::observation_scale(o);
    return;
  }
  e.require(!e.has(number_key), number_key, "not together with size");
  const std::string size = e.choice("size", {"minimal_detectable", "nonlinear_detectable", "nonlinear_own_test"},
                                    "the gross error, in minimal detectable errors: of linear theory, or of a single "
                                    "station as found by the general test or by the reading's own");
  injected.factor =
      all * e.number("factor", config::Range::closed(-100, 100), "multiplies `size`; its sign is that of the error", 1);
  injected.place = e.place("size");
  injected.error.size = 1;
  injected.size = size == "minimal_detectable"     ? InjectedError::Size::minimal_detectable
                  : size == "nonlinear_detectable" ? InjectedError::Size::nonlinear_detectable
                                                   : InjectedError::Size::nonlinear_own_test;
  e.require(injected.size == InjectedError::Size::minimal_detectable ||
                (s.attitudes.size() == 1 && !s.model.systematic_terms),
            "size", fmt::format("\"{}\" is known for a single station only", size));
}

/// Size of an error that is detectable, in internal units.
double detectable_size(const Scenario& s, const InjectedError& e) {
  const double lambda = reliability::lambda0(s.levels);
  if (e.size == InjectedError::Size::minimal_detectable) {
    const double sensitivity =
        reliability::sensitivities(reliability::linear_model(s.model, s.attitudes))[e.error.number];
    e.place.require(sensitivity > 0, "the linear minimal detectable error is infinite at this attitude");
    return e.factor * lambda / sensitivity;
  }
  const reliability::DetectedBy test = e.size == InjectedError::Size::nonlinear_own_test
                                           ? reliability::DetectedBy::own_test
                                           : reliability::DetectedBy::general_test;
  const double detectable = reliability::nonlinear_detectable_error(s.model, s.attitudes.front(), e.observation, lambda,
                                                                    e.factor < 0 ? -1 : 1, test);
  e.place.require(std::isfinite(detectable), "the nonlinear minimal detectable error is infinite at this attitude");
  return std::abs(e.factor) * detectable;
}

void read_injected(config::ConfigReader& c, Scenario& s) {
  const double factor =
      c.number("factor", config::Range::closed(-100, 100), "multiplies all gross errors; made to be swept", 1);
  for (config::ConfigReader& e : c.tables("inject", "gross errors; none: false alarms only")) {
    const std::vector<std::string> names(reliability::observation_names().begin(),
                                         reliability::observation_names().end());
    const std::string name = e.choice("observation", names, "the reading or reference in error");
    InjectedError injected;
    injected.label = name;
    injected.observation = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    e.require(reliability::is_observed(s.model.mode, injected.observation), "observation",
              fmt::format("{} is not observed in mode {}", name,
                          reliability::adjustment_mode_names()[static_cast<std::size_t>(s.model.mode)]));
    injected.station = static_cast<std::size_t>(
        e.integer("station", 0, static_cast<std::int64_t>(s.attitudes.size()) - 1, "the station in error, from 0", 0));
    if (s.attitudes.size() > 1 && injected.observation < reliability::kReadings)
      injected.label += fmt::format("_{}", injected.station);
    injected.error.number =
        reliability::observation_number(s.model, s.attitudes.size(), injected.station, injected.observation);
    for (const InjectedError& other : s.injected)
      e.require(other.error.number != injected.error.number, "observation", "has two errors");
    read_size(e, s, injected, factor);
    s.injected.push_back(std::move(injected));
  }
}

std::vector<SnoopingStrategy> read_strategies(config::ConfigReader& c, bool pope) {
  std::vector<SnoopingStrategy> all;
  const std::vector<std::string> wanted =
      c.has("strategy") ? c.texts("strategy",
                                  "how readings are rejected: 'single' (the largest statistic), 'iterative', "
                                  "'readmission', 'pairs'; Pope's test: 'single' only")
                        : std::vector<std::string>{c.text("strategy", config::kMeaningElsewhere, "single")};
  for (const std::string& name : wanted) {
    const auto& names = strategy_names();
    const auto at = std::find(names.begin(), names.end(), name);
    c.require(at != names.end(), "strategy", config::none_of(name, {names.begin(), names.end()}));
    const auto strategy = static_cast<SnoopingStrategy>(at - names.begin());
    c.require(std::find(all.begin(), all.end(), strategy) == all.end(), "strategy", name + " is in the list twice");
    c.require(!pope || strategy == SnoopingStrategy::single, "strategy",
              "with test = \"pope\" only \"single\": the others work with a known variance");
    all.push_back(strategy);
  }
  return all;
}

/// The rest of a config with `[[event]]`.
void read_event_run(config::ConfigReader& c, Scenario& s) {
  using Kind = analysis::GrossErrorEventKind;
  s.event_run = events::read_event_run(c, {"union"});
  s.annotations =
      events::read_event_annotations(c, {"linear", "nonlinear", "single_test", "independent", "bonferroni"});
  std::vector<events::EventQuantity> quantities;
  for (const char* q : analysis::kGrossErrorEvents) quantities.push_back({q, events::EventLimits::none});
  s.events = events::read_events(c, quantities);
  for (const events::EventRule& e : s.events) {
    const auto kind = static_cast<Kind>(e.quantity);
    e.place.require(kind == Kind::false_alarm_any || !s.injected.empty(),
                    "no error is injected: must have [[inject]], or be \"false_alarm_any\"");
    e.place.require(kind != Kind::identified_wrong || s.strategies == std::vector{SnoopingStrategy::single},
                    "known where the reading of the largest test is blamed: must be with strategy = \"single\"");
    c.require(s.event_run.sampling.method != "union" || (kind == Kind::false_alarm_any && !s.pope), "sampling.method",
              "the event is no union of half spaces: must be of another method, or the event \"false_alarm_any\" of "
              "test = \"w\"");
  }
  c.finish();
}

}  // namespace

const std::vector<std::string>& strategy_names() {
  static const std::vector<std::string> names{"single", "iterative", "readmission", "pairs"};
  return names;
}

const std::vector<std::string>& outcome_names() {
  static const std::vector<std::string> names{"identified", "identified_group", "identified_partly", "identified_wrong",
                                              "missed"};
  return names;
}

std::vector<reliability::GrossError> Scenario::errors() const {
  std::vector<reliability::GrossError> all;
  for (const InjectedError& e : injected) all.push_back(e.error);
  return all;
}

void require_redundancy(const Scenario& s) {
  try {
    reliability::linear_model(s.model, s.attitudes);
  } catch (const std::invalid_argument&) {
    s.noise_place.fail(
        "must not be so small beside the other errors that the covariance of the misclosures is singular in double "
        "precision");
  }
}

Scenario with_sizes(Scenario s) {
  for (InjectedError& e : s.injected)
    if (e.size != InjectedError::Size::given) e.error.size = detectable_size(s, e);
  return s;
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  const bool of_events = events::has_events(c);
  const bool stations_given = c.has("stations");
  s.model = scenario::read_adjustment_model(c);
  const reliability::SigmaModel usual;
  const bool is_magnetic = s.model.sigma.magnetometer_noise / usual.magnetometer_noise <=
                           s.model.sigma.accelerometer_noise / usual.accelerometer_noise;
  s.noise_place = c.place(is_magnetic ? "sigma.magnetometer_noise_nT" : "sigma.accelerometer_noise_mps2");
  s.model.field.dip = scenario::read_dip(c, s.model);
  s.model.rotational_shot =
      c.boolean("rotational_shot",
                "of `mse_shared`: the stations are shots of one station, and share inclination and azimuth", false);
  const bool shared = s.model.mode == reliability::AdjustmentMode::mse_shared;
  c.require(shared || !s.model.rotational_shot, "rotational_shot", "only with mode = \"mse_shared\"");
  s.model.systematic_terms = s.model.systematic_terms && shared;  // may be given, so that the mode can be swept
  s.levels = scenario::read_test_levels(c);
  s.attitudes = read_attitudes(c, s.model, stations_given);
  s.model.stations = static_cast<int>(s.attitudes.size());
  s.pope = c.choice("test", {"w", "pope"}, "'w': variance known; 'pope': variance unknown", "w") == "pope";
  s.strategies = read_strategies(c, s.pope);
  read_injected(c, s);
  if (of_events) {
    read_event_run(c, s);
    return s;
  }
  s.verdict = compare::read_verdict_rule(c);
  s.false_alarm_margin =
      c.number("verdict.false_alarm_margin", config::Range::open(0, 1), "margin of rates of false alarms", 0.1);
  s.trial_plan = compare::read_verdict_plan(c, rows_of(s), s.verdict, {});
  s.annotations = compare::Annotations::read(c, rows_of(s));
  c.finish();
  return s;
}

}  // namespace surveymc::studies::gross_error_detection
