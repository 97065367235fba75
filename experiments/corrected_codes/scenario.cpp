#include "corrected_codes/scenario.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "analysis/readings_analysis.h"
#include "base/units.h"
#include "compare/trial_plan.h"
#include "config/shipped_models.h"
#include "config/suggest.h"
#include "corrected_codes/study.h"
#include "scenario/disturbance.h"
#include "scenario/error_models.h"
#include "scenario/parameter_set.h"
#include "scenario/reference_field.h"
#include "scenario/reference_laws.h"
#include "scenario/scenario.h"
#include "scenario/well_design.h"

namespace surveymc::studies::corrected_codes {
namespace {

using analysis::CodeQuantity;
using analysis::CodeScope;

config::SharedModel read_model(config::ConfigReader& c, const std::string& key, const std::string& name) {
  const config::ShippedModel* shipped = config::find_shipped_model(name);
  if (shipped == nullptr) c.fail(key, "no such tool code: " + config::shipped_model_suggestion(name));
  return config::read_shipped_model(c, key, *shipped);
}

std::vector<std::string> shipped_names() {
  std::vector<std::string> names;
  for (const config::ShippedModel& m : config::shipped_models()) names.push_back(m.name);
  return names;
}

/// `[draw.reference] total_nT, dip_deg, station_total_nT, station_dip_deg`: in place of the twin's, or where there is
/// none.
void read_reference(config::ConfigReader& c, bool has_twin, propagate::CodeDraws& d) {
  const auto size = [&](const std::string& key, std::string_view meaning, double& value, double unit) {
    const std::string name = "draw.reference." + key;
    const config::Range range = config::Range::closed(0, 1e5);
    value = unit * (has_twin ? c.number(name, range, meaning, value / unit) : c.number(name, range, meaning));
  };
  size("total_nT", "one sd of the total field less its reference, drawn once a run", d.run.total, 1);
  size("dip_deg", "one sd of the dip less its reference, drawn once a run", d.run.dip, kDegree);
  size("station_total_nT", "one sd of the total field of a station, drawn at each", d.station.total, 1);
  size("station_dip_deg", "one sd of the dip of a station, drawn at each", d.station.dip, kDegree);
}

/// Sizes that weighted estimators assume.
propagate::CodeDraws read_assumed(config::ConfigReader& c, const Scenario& s, const propagate::CodeDraws& of_base,
                                  const error_model::Model& claimed, const error_model::Model* twin) {
  if (c.choice("correction.assumed", {"base", "claimed"},
               "sizes that 'joint', 'joint_priors' and the defaults of [estimator] assume: those of the base code, or "
               "those of the claimed one; `draw` does not change them",
               "base") == "base")
    return of_base;
  propagate::CodeDraws d =
      c.place("correction.assumed").with_place([&] { return propagate::map_code(claimed, twin).draws; });
  d.run.total = s.which.draws.run.total;
  d.run.dip = s.which.draws.run.dip;
  d.station = s.which.draws.station;
  return d;
}

/// `estimator.parameters`, `estimator.robust`. What it does not name are the sizes of the code: priors of biases and
/// scales, the reference of the run, and what is drawn at the stations, which no estimate can tell from noise.
analysis::Correction read_parameters(config::ConfigReader& c, const propagate::CodeDraws& assumed, double noise,
                                     const survey::ReferenceField& field, std::string& name) {
  scenario::AssumedSizes sizes{.magnetometer = noise, .reference = {0, assumed.run.total, assumed.run.dip}};
  for (std::size_t i = 0; i < survey::kSensorTerms; ++i)
    if (assumed.sensors[i] > 0) sizes.prior_sd[i] = assumed.sensors[i];
  double& axial = sizes.prior_sd[multistation::kMagnetometerBias + 2];
  const double drawn = std::hypot(assumed.sensors[survey::kMagnetometerBias + 2], assumed.interference);
  if (drawn > 0) axial = drawn;
  analysis::Correction own;
  own.kind = analysis::Correction::Kind::parameters;
  scenario::refuse_beside_parameters(c, {"estimator.estimated"});
  const scenario::SetEstimator estimator = scenario::read_parameter_set(c, sizes, field);
  own.parameters = estimator.fit;
  own.robust = estimator.robust;
  own.cost = estimator.cost();
  const double sine = std::sin(field.dip), cosine = std::cos(field.dip), total = assumed.station.total,
               turned = field.total * assumed.station.dip;
  own.parameters.sizes[1] = std::hypot(own.parameters.sizes[1], total * cosine, turned * sine);
  own.parameters.sizes[2] = std::hypot(own.parameters.sizes[2], total * sine, turned * cosine);
  name = own.parameters.parameters.name();
  if (std::isdigit(static_cast<unsigned char>(name.front())) != 0) name += " parameters";
  if (own.robust.loss != multistation::Loss::least_squares)
    name += " by " + multistation::loss_names()[static_cast<std::size_t>(own.robust.loss)];
  if (own.parameters.estimates_reference) name += " (joint)";
  return own;
}

analysis::Correction read_correction(config::ConfigReader& c, const propagate::CodeDraws& assumed,
                                     const survey::ReferenceField& field, std::string& name) {
  const double noise =
      c.number("correction.noise_nT", config::Range::positive(),
               "one sd that weighted estimators assume of a reading, besides what the code draws at the "
               "stations",
               1);
  std::vector<std::string> names = analysis::correction_names();
  names.emplace_back("estimator");
  name = c.choice("correction.kind", names,
                  "'none'; 'msa': six parameters, unweighted; 'msa3': three biases; 'joint': six and the reference; "
                  "'joint_priors': with priors; 'axial': every station for itself; 'estimator': as [estimator] says");
  for (const char* key : {"estimator.parameters", "estimator.robust"})
    c.require(name == "estimator" || !c.has(key), key, "needs correction.kind = \"estimator\"");
  if (name != "estimator") return analysis::correction(name, assumed, noise);
  if (scenario::wants_parameter_set(c)) return read_parameters(c, assumed, noise, field, name);
  analysis::Correction own;
  own.kind = analysis::Correction::Kind::run;
  own.estimator =
      scenario::read_estimator(c, analysis::assumed_errors(assumed, noise), field, analysis::readings_estimators());
  own.estimator.estimated = scenario::read_estimated_parameters(c);
  return own;
}

/// The survey's toolfaces by a sequence.
void turn_tool(survey::Survey& well, analysis::ToolfaceSequence sequence, random::StudySeed seed) {
  analysis::WellDesign design;
  design.stations = well.size();
  design.toolface = sequence;
  design.seed = seed;
  const survey::Survey turned = analysis::make_well(design, 0, 0);
  for (std::size_t k = 0; k < well.stations.size(); ++k) well.stations[k].toolface = turned.stations[k].toolface;
}

/// The field of the well, or of the places of a map.
void read_field(config::ConfigReader& c, Scenario& s) {
  if (!c.has("map.latitude_deg") && !c.has("map.longitude_deg")) {
    s.field = scenario::read_field(c);
    return;
  }
  s.latitude_deg = c.grid("map.latitude_deg", config::Range::closed(-90, 90),
                          "latitudes of maps over places, of one well, by field.model and field.date");
  s.longitude_deg = c.grid("map.longitude_deg", config::Range::closed(-180, 360), "longitudes of maps over places");
  s.places = scenario::read_field_of_places(c);
  s.field = s.places.at(s.latitude_deg.front() * kDegree, s.longitude_deg.front() * kDegree);
}

void read_well(config::ConfigReader& c, Scenario& s) {
  if (c.has("well.kind")) {
    c.require(!c.has("survey.file") && !c.has("survey.plan"), "well.kind", "not together with [survey]");
    s.design = scenario::read_well_design(c, s.seed);
    c.require(s.design->stations >= 3, "well.stations", "must be at least 3: the first is the tie-on");
    if (c.has("map.inclination_deg") && !c.has("well.inclination_deg")) return;
    const double inclination = c.number("well.inclination_deg", config::Range{0, 180, true, true},
                                        "inclination of the last station of a made-up well"),
                 azimuth = c.number("well.azimuth_deg", config::Range::closed(-360, 360),
                                    "azimuth of the last station, from true north");
    s.well = analysis::make_well(*s.design, inclination * kDegree, azimuth * kDegree);
    return;
  }
  if (c.has("map.inclination_deg")) c.fail("map.inclination_deg", "needs a made-up well: give well.kind");
  const std::string toolface =
      c.choice("draw.toolface", {"survey", "even", "random", "constant"},
               "toolfaces of a survey: 'survey': as its file has them; 'even': turned by 137.50776 deg a station; "
               "'random': by the seed; 'constant': 0, a slide",
               "survey");
  s.well = scenario::read_survey(c, s.field, toolface == "survey");
  c.require(s.well->size() >= 3, "survey.file", "must have at least three stations: the first is the tie-on");
  using enum analysis::ToolfaceSequence;
  if (toolface != "survey")
    turn_tool(*s.well, toolface == "even" ? even : toolface == "random" ? random : constant, s.seed);
}

/// Laws of what is drawn of the reference, and the sd that follow from its sizes.
void read_laws(config::ConfigReader& c, Scenario& s) {
  s.laws = scenario::read_reference_laws(c, {.terms = false});
  c.require(s.laws.global == s.laws.well, "reference_law.modes",
            "errors of G and W are one draw here: give both or none of them");
  if (s.well && s.latitude_deg.empty()) s.tails = compare::read_tail_rule(c, s.laws);
  using Element = random::ReferenceElement;
  const auto resize = [&](propagate::CodeDraws::Reference& r) {
    r.declination *= s.laws.of(Element::declination).sd;
    r.east *= s.laws.of(Element::declination).sd;
    r.dip *= s.laws.of(Element::dip).sd;
    r.total *= s.laws.of(Element::total).sd;
  };
  if (s.laws.global) resize(s.which.draws.run);
  if (s.laws.random) resize(s.which.draws.station);
}

template <class Value, std::size_t N>
std::vector<Value> read_words(config::ConfigReader& c, const std::string& key, std::string_view meaning,
                              const std::array<const char*, N>& words, const std::vector<Value>& fallback) {
  if (!c.has(key)) return fallback;
  std::vector<Value> out;
  for (const std::string& word : c.texts(key, meaning)) {
    const auto* at = std::find(words.begin(), words.end(), word);
    if (at == words.end()) c.fail(key, config::none_of(word, {words.begin(), words.end()}));
    out.push_back(static_cast<Value>(at - words.begin()));
    c.require(std::count(out.begin(), out.end(), out.back()) == 1, key, "\"" + word + "\" is there twice");
  }
  return out;
}

}  // namespace

namespace {

/// The disturbance takes the place of what the code draws at every station.
void read_disturbance(config::ConfigReader& c, Scenario& s) {
  if (!c.has("disturbance.kind")) return;
  c.require(s.well && !s.has_map(), "disturbance.kind", "maps have no [disturbance]: give one well");
  s.disturbance = scenario::read_disturbance(c, *s.well, {.is_drawn = s.trials > 0});
  const disturbance::Disturbance& d = *s.disturbance;
  constexpr std::array<disturbance::Element, 3> kElements{disturbance::kTotal, disturbance::kDip,
                                                          disturbance::kDeclination};
  std::vector<disturbance::StationDraw> draws;
  for (std::size_t k = 1; k < s.well->stations.size(); ++k)
    for (std::uint32_t i = 0; i < kElements.size(); ++i)
      draws.push_back(
          {k, kElements[i], i, random::Channel::disturbed_station, 4 * static_cast<std::uint32_t>(k - 1) + i});
  s.disturbed = std::make_shared<const disturbance::StationDisturbance>(d, s.field, draws);
  propagate::CodeDraws::Reference& station = s.which.draws.station;
  if (d.match_variance) {
    const std::array<double, 3> sizes{station.total, station.dip, station.declination_in(s.field)};
    c.require(std::any_of(sizes.begin(), sizes.end(), [](double size) { return size > 0; }), "disturbance.match",
              "\"variance\" is that of the code's errors of mode R of the reference, which are 0");
    for (std::size_t i = 0; i < sizes.size() && !d.keeps_normals(); ++i)
      c.require(sizes[i] == 0 || s.disturbed->sizes()[kElements[i]] > 0, "disturbance.match",
                fmt::format("the disturbance does not change the {}, which is drawn at every station",
                            random::reference_elements()[kElements[i]]));
    station = {d.scale * station.total, d.scale * station.dip, d.scale * station.declination, d.scale * station.east};
  } else {
    const auto& sizes = s.disturbed->sizes();
    station = {d.scale * sizes[disturbance::kTotal], d.scale * sizes[disturbance::kDip],
               d.scale * sizes[disturbance::kDeclination], 0};
  }
  s.which.correlation = [disturbed = s.disturbed](int a, std::size_t j, int b, std::size_t k) {
    return disturbed->correlation(3 * j + static_cast<std::size_t>(a), 3 * k + static_cast<std::size_t>(b));
  };
}

}  // namespace

bool Scenario::wants(CodeScope scope) const { return std::find(scopes.begin(), scopes.end(), scope) != scopes.end(); }

bool Scenario::wants_azimuth() const {
  return std::find(quantities.begin(), quantities.end(), CodeQuantity::azimuth) != quantities.end();
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.base = c.text("code.base", "tool code of the uncorrected survey, whose errors are drawn: \"MWD+IFR1\"");
  s.claimed = c.text("code.claimed", "tool code that is claimed for the corrected survey: \"MWD+IFR1+MS\"");
  const config::SharedModel base = read_model(c, "code.base", s.base),
                            claimed = read_model(c, "code.claimed", s.claimed);
  const std::string by_name = propagate::axial_twin(config::find_shipped_model(s.base)->name, shipped_names());
  if (!by_name.empty() || c.has("code.reference_of"))
    s.reference_of = c.text("code.reference_of",
                            "tool code from which the sizes of total field and dip are read; without it the twin of "
                            "the base with axial correction, by name",
                            by_name);
  config::SharedModel twin;
  if (!s.reference_of.empty())
    twin = read_model(c, c.has("code.reference_of") ? "code.reference_of" : "code.base", s.reference_of);
  propagate::MappedCode mapped =
      c.place("code.base").with_place([&] { return propagate::map_code(*base, twin.get()); });
  s.terms = std::move(mapped.terms);
  const propagate::CodeDraws of_base = mapped.draws;
  s.which.claimed =
      c.place("code.claimed").with_place([&] { return std::make_shared<const propagate::ClaimedCode>(*claimed); });
  s.which.draws = of_base;
  read_reference(c, twin != nullptr, s.which.draws);
  s.which.draws.interference =
      c.number("draw.amil_nT", config::Range::closed(0, 1e5),
               "one sd of the drill string's axial interference; without it that of the base", of_base.interference);
  s.which.draws =
      s.which.draws.scaled(c.number("draw.scale", config::Range::positive(),
                                    "multiplies all errors that are drawn, not those claimed or assumed", 1));
  s.which.turned = c.boolean("draw.turn",
                             "turns the tool of the whole run by an angle, uniform, drawn anew in every trial: codes "
                             "claim the mean over toolfaces",
                             false);
  s.which.noise = c.number("noise.magnetometer_nT", config::Range::closed(0, 1e5),
                           "one sd of a magnetometer reading, per axis and station; no code has it", 0);
  read_field(c, s);
  propagate::CodeDraws assumed = read_assumed(c, s, of_base, *claimed, twin.get());
  if (twin == nullptr) {
    assumed.run = s.which.draws.run;
    assumed.station = s.which.draws.station;
  }
  s.which.correction = read_correction(c, assumed, s.field, s.correction);
  c.require(s.which.correction.kind != analysis::Correction::Kind::parameters || s.latitude_deg.empty(),
            "estimator.parameters", "has no maps over places: residuals are weighed by the sizes in one field");
  read_well(c, s);
  read_laws(c, s);
  if (!s.latitude_deg.empty()) {
    c.require(s.design.has_value(), "map.latitude_deg", "needs a made-up well: give well.kind");
    c.require(!c.has("map.inclination_deg"), "map.latitude_deg",
              "not together with map.inclination_deg: a map is over places or over directions");
  } else if (c.has("map.inclination_deg")) {
    s.inclination_deg = c.grid("map.inclination_deg", config::Range{0, 180, true, true},
                               "inclinations of the maps, of the last station");
    s.azimuth_deg = c.grid("map.azimuth_deg", config::Range::closed(-360, 360),
                           "azimuths of the maps, of the last station, from true north");
  }
  s.trials = static_cast<std::uint64_t>(
      c.integer("trials", 0, 1'000'000'000'000, "trials at every point of the sweep; 0: first order alone", 0));
  read_disturbance(c, s);
  if (s.which.correction.robust.loss != multistation::Loss::least_squares) {
    const propagate::CodeDraws::Reference& of_station = s.which.draws.station;
    c.require(s.which.noise > 0 || of_station.total > 0 || of_station.dip > 0, "estimator.robust.loss",
              "weighs stations by errors of their own, of which there are none: give noise.magnetometer_nT");
    c.require(!s.disturbance, "disturbance.kind",
              "the cost of estimator.robust.loss is that of independent stations: leave one of them out");
    c.require(!s.laws.any(), "reference_law",
              "the cost of estimator.robust.loss is that of normal errors: leave one of them out");
  }
  c.require(s.trials == 0 || s.well, "trials", "maps have no trials: give well.inclination_deg, or leave it out");
  c.require(s.trials == 0 || s.latitude_deg.empty(), "trials",
            "a map over places has no trials: sweep field.latitude_deg and field.longitude_deg");
  s.scopes = read_words<CodeScope>(c, "compare.scope",
                                   "'magnetic': terms that a correction of magnetometers can change; 'total': all, of "
                                   "which the others are on both sides",
                                   analysis::kCodeScopes, {CodeScope::magnetic});
  s.quantities = read_words<CodeQuantity>(
      c, "compare.quantities",
      "'lateral', 'high_side', 'north', 'east', 'worst' (any direction of the horizontal plane) at the last station, "
      "'azimuth' at every station; without it all",
      analysis::kCodeQuantities,
      {CodeQuantity::lateral, CodeQuantity::high_side, CodeQuantity::north, CodeQuantity::east, CodeQuantity::worst,
       CodeQuantity::azimuth});
  s.margin = c.number("compare.margin", config::Range::closed(0, 10), "a ratio up to 1 + margin holds", 0.05);
  s.orders = scenario::read_prediction_orders(c);
  scenario::require_orders_of(c, s.laws, s.disturbance.has_value(), s.orders);
  scenario::set_beside_laws(c, s.disturbance, s.laws, s.tails);
  c.require(!s.orders.any() || s.which.correction.kind != analysis::Correction::Kind::parameters, "prediction.orders",
            "beyond \"first\" are of six gains and biases: not together with estimator.parameters");
  c.require(!s.orders.any() || !s.which.turned, "prediction.orders",
            "beyond \"first\" are made of normals, and draw.turn draws a uniform angle: leave one out");
  s.verdict = compare::read_verdict_rule(c);
  s.annotations = compare::Annotations::read(c, rows_of(s));
  c.finish();
  return s;
}

}  // namespace surveymc::studies::corrected_codes
