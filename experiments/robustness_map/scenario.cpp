#include "robustness_map/scenario.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/robust_claim.h"
#include "analysis/well_design.h"
#include "base/units.h"
#include "compare/trial_plan.h"
#include "config/meanings.h"
#include "config/shipped_models.h"
#include "config/suggest.h"
#include "robustness_map/study.h"
#include "scenario/error_models.h"
#include "scenario/parameter_set.h"
#include "scenario/reference_field.h"
#include "scenario/scenario.h"
#include "scenario/well_design.h"

namespace surveymc::studies::robustness_map {
namespace {

config::SharedModel read_model(config::ConfigReader& c, const std::string& key, const std::string& name) {
  const config::ShippedModel* shipped = config::find_shipped_model(name);
  if (shipped == nullptr) c.fail(key, "no such tool code: " + config::shipped_model_suggestion(name));
  return config::read_shipped_model(c, key, *shipped);
}

/// Sizes of all errors but the gross ones: those of a tool code, total field and dip from its axial twin.
propagate::CodeDraws read_draws(config::ConfigReader& c) {
  const std::string base = c.text("code.base", "tool code whose errors are drawn, of the tool and of the reference");
  const config::SharedModel model = read_model(c, "code.base", base);
  std::vector<std::string> names;
  for (const config::ShippedModel& m : config::shipped_models()) names.push_back(m.name);
  const std::string twin_name = propagate::axial_twin(config::find_shipped_model(base)->name, names);
  config::SharedModel twin;
  if (!twin_name.empty()) twin = read_model(c, "code.base", twin_name);
  propagate::CodeDraws d =
      c.place("code.base").with_place([&] { return propagate::map_code(*model, twin.get()).draws; });
  const double scale =
      c.number("draw.scale", config::Range::positive(), "multiplies all errors of the code, not the gross ones", 1);
  if (!c.boolean("draw.run",
                 "draws errors that are constant in a run: of the tool and of the reference; false: those of the "
                 "stations alone",
                 true)) {
    d.sensors = {};
    d.interference = 0;
    d.run = {};
  }
  if (!c.boolean("draw.declination",
                 "draws errors of the declination: no fit can see them, so that they hide what fits differ in", true))
    for (propagate::CodeDraws::Reference* r : {&d.run, &d.station}) r->declination = r->east = 0;
  return d.scaled(scale);
}

void read_well(config::ConfigReader& c, Scenario& s) {
  if (c.has("survey.file") || c.has("survey.plan")) {
    s.well = scenario::read_survey(c, s.field, true);
  } else {
    const analysis::WellDesign design = scenario::read_well_design(c, s.seed);
    const double inclination = c.number("well.inclination_deg", config::Range{0, 180, true, true},
                                        "inclination of the last station of a made-up well"),
                 azimuth = c.number("well.azimuth_deg", config::Range::closed(-360, 360),
                                    "azimuth of the last station, from true north");
    s.well = analysis::make_well(design, inclination * kDegree, azimuth * kDegree);
  }
  c.require(s.well.size() >= 8, c.has("well.kind") ? "well.stations" : "survey",
            "must have at least 8 stations: the first is the tie-on, and half of the others may be wrong");
}

void read_gross(config::ConfigReader& c, Scenario& s) {
  const std::vector<std::string>& kinds = sensor::gross_kind_names();
  const std::string kind = c.choice(
      "gross.kind", kinds,
      "'scattered': any stations, each with an error of its own; 'casing': the first stations, one field of the earth "
      "that decays; 'stretch': neighbours anywhere, one field of the earth",
      "scattered");
  s.gross.kind = static_cast<sensor::GrossKind>(std::find(kinds.begin(), kinds.end(), kind) - kinds.begin());
  s.gross.size = c.number("gross.size_nT", config::Range::closed(0, 1e5), "one sd of a gross error along each axis",
                          s.gross.kind == sensor::GrossKind::casing ? 2000 : 1500);
  const double share = c.number("gross.share", config::Range{0, 0.5, false, true},
                                "share of the measured stations in error, below a half; rounded to stations");
  s.gross.count = static_cast<int>(std::lround(share * s.stations()));
  c.require(2 * s.gross.count < s.stations(), "gross.share", "must leave more right stations than wrong ones");
}

void read_fit(config::ConfigReader& c, Scenario& s) {
  using multistation::ParameterSet;
  c.require(!c.has("estimator.robust"), "estimator.robust", "the study compares losses: name them in estimator.losses");
  const ParameterSet biases = ParameterSet::of({"mbx", "mby", "mbz"});
  s.fit.parameters = biases;
  if (c.has("estimator.parameters")) s.fit.parameters = scenario::read_parameters(c, {"3"}).set.value_or(biases);
  const std::string set = s.fit.parameters.name();
  if (c.boolean("estimator.use_priors",
                "priors of the parameters: sizes of the code, and a milliradian of rotations and axes; false: none. "
                "Without the key true, but for '3' and '6'",
                set != biases.name() && set != "6")) {
    const multistation::PerParameter<double> sd = analysis::tool_sizes(s.draws);
    for (std::size_t i = 0; i < sd.size(); ++i)
      if (sd[i] > 0) s.fit.prior_sd[i] = sd[i];
  } else {
    s.fit.prior_sd.fill(std::numeric_limits<double>::infinity());
  }
  const double gravity = c.number("estimator.gravity_mps2", config::Range::positive(),
                                  "size of a residual of gravity; used where accelerometers are estimated", 0.006),
               field = c.number("estimator.field_nT", config::Range::positive(),
                                "size of a residual of the horizontal or vertical field", 70);
  s.fit.sizes = {gravity, field, field};
  s.fit.gravity_is_noisy = false;  // no code has noise of the accelerometers
  const auto& sensors = s.draws.sensors;
  const bool moves_gravity =
      std::any_of(sensors.begin(), sensors.begin() + survey::kMagnetometerBias, [](double sd) { return sd > 0; });
  c.require(moves_gravity || !s.fit.parameters.corrects_accelerometers(), "estimator.parameters",
            "has errors of the accelerometers, but nothing that is drawn moves |g|, so that they have no claimed "
            "covariance: leave out draw.run = false, or estimate the magnetometers alone");
  s.fit.total = s.field.total;
  s.fit.dip = s.field.dip;
}

}  // namespace

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  using multistation::Loss;
  Scenario s;
  s.seed = seed;
  s.field = scenario::read_field(c);
  s.draws = read_draws(c);
  s.noise = c.number("noise.magnetometer_nT", config::Range::closed(0, 1e5),
                     "one sd of a magnetometer reading, per axis and station; no code has it", 0);
  read_well(c, s);
  read_gross(c, s);
  read_fit(c, s);
  s.losses = {Loss::least_squares};
  const std::vector<std::string>& names = multistation::loss_names();
  const std::vector<std::string> robust(names.begin() + 1, names.end());
  std::vector<std::string> wanted = robust;
  if (c.has("estimator.losses"))
    wanted = c.texts("estimator.losses",
                     "robust losses beside least squares: 'l1', 'huber', 'cauchy', 'tukey' (which starts at the least "
                     "median of squares); without it all");
  for (const std::string& name : wanted) {
    const auto at = std::find(robust.begin(), robust.end(), name);
    if (at == robust.end()) c.fail("estimator.losses", config::none_of(name, robust));
    s.losses.push_back(static_cast<Loss>(at - robust.begin() + 1));
    c.require(std::count(s.losses.begin(), s.losses.end(), s.losses.back()) == 1, "estimator.losses",
              "\"" + name + "\" is there twice");
  }
  s.verdict = compare::read_verdict_rule(c);
  s.trials = static_cast<std::uint64_t>(c.integer("trials", 2, 1'000'000'000'000, config::meaning::kTrials));
  s.annotations = compare::Annotations::read(c, rows_of(s));
  c.finish();
  return s;
}

}  // namespace surveymc::studies::robustness_map
