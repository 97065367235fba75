#include "scenario/scenario.h"

#include <algorithm>
#include <optional>

#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "config/foreign_table.h"
#include "config/meanings.h"
#include "config/suggest.h"
#include "estimate/estimators.h"
#include "estimate/observability.h"
#include "scenario/input_remarks.h"
#include "scenario/survey_spacing.h"
#include "survey/minimum_curvature.h"
#include "survey/survey.h"

namespace surveymc::scenario {

namespace {

constexpr const char* kNorthOfSurvey = "survey.azimuth_reference";

/// Options of the importer that the config gives for a survey file in another form. `table`: where the keys are,
/// "survey." or "".
config::ImportOptions read_import_options(config::ConfigReader& c, const std::string& table) {
  config::ImportOptions options;
  const auto add = [&](const char* key, const char* option, const std::vector<std::string>& allowed,
                       std::string_view meaning) {
    const std::string full = table + key;
    if (c.has(full))
      options.emplace_back(option, allowed.empty() ? c.text(full, meaning) : c.choice(full, allowed, meaning));
  };
  add("depth_unit", "depth-unit", {"m", "ft", "usft"},
      "unit of depths ('usft': US survey feet); without it what the heading says");
  add("angle_unit", "angle-unit", {"deg", "rad", "gon"},
      "unit of angles; without it what the heading says, or degrees. 'Grad' in a heading may mean either, and is asked "
      "about");
  add("decimal", "decimal", {"point", "comma"},
      "decimal mark, needed where 1,234 may be either; without it what the numbers show");
  add("columns", "columns", {},
      "columns by number from 1 or heading, 'md=1,inc=3,azi=4'; without it by their headings");
  add("skip_lines", "skip-lines", {}, "lines, or rows of a sheet, to leave out: '12,15-20'");
  add("sheet", "sheet", {}, "sheet of a workbook");
  add("trajectory", "trajectory", {},
      "name, uid or number in a WITSML file of several; the well in a table of several");
  add("encoding", "encoding", {}, "encoding of a text file");
  return options;
}

/// The north that the config writes, not its default: by has() that would be kept out of the resolved config.
std::optional<std::string> written_north(config::ConfigReader& c, const std::string& key) {
  if (!c.is_text(key)) return std::nullopt;
  return c.choice(key, {"true", "magnetic", "grid"}, config::kMeaningElsewhere);
}

/// The table that the file of `key` holds, in our own form or in that of another program. `north`: the key of its
/// north; `key_prefix`: what messages write before the keys of `options`.
config::InputTable read_any_table(config::ConfigReader& c, const std::string& key, config::ForeignKind kind,
                                  const config::ImportOptions& options, const std::string& north,
                                  const std::string& key_prefix) {
  std::string reading, told;
  for (const auto& [name, value] : options) reading += fmt::format("{}{} {}", reading.empty() ? "" : ", ", name, value);
  const std::string path = c.text(key, config::kMeaningElsewhere);
  config::InputTable table = c.table(
      key,
      kind == config::ForeignKind::survey
          ? "the survey: a CSV with `md_m` or `md_ft`, `inclination_deg`, `azimuth_deg`, `toolface_deg` where it is "
            "needed, and `tvd_m` or `tvd_ft` and `time_s` if there; or a file of another program"
          : "the readings: a CSV with `md_m` or `md_ft` and `gx ... bz` in `_mps2` or `_mg` and `_nT` or `_uT`, at "
            "least 3 stations (1 for estimators by single stations and 'chained'); or a file of another program",
      [&](const std::filesystem::path& place) {
        config::ImportOptions all = options;
        if (const auto written = written_north(c, north)) all.emplace_back("azimuth-reference", *written);
        // By has(), as remark_on_survey() asks for it.
        const std::string unusual = key.substr(0, key.rfind('.') + 1) + "unusual";
        if (kind == config::ForeignKind::survey && c.has(unusual))
          all.emplace_back("unusual", c.choice(unusual, {"refuse", "allow"}, config::meaning::kUnusual));
        config::ReadTable read = config::read_any_form(place, path, kind, all, key_prefix);
        told = std::move(read.told);
        read.table.doubts = std::move(read.warnings);
        return std::move(read.table);
      },
      reading);
  if (!told.empty()) c.note(told);
  for (const std::string& text : table.doubts) {  // "survey.las:line 12: what is doubtful"
    const std::size_t end = text.starts_with(path) ? text.find(": ", path.size()) : std::string::npos;
    if (end == std::string::npos)
      c.warn_at(path, "", text);
    else
      c.warn_at(text.substr(0, end), "", text.substr(end + 2));
  }
  return table;
}

survey::Survey read_planned_survey(config::ConfigReader& c) {
  const double kickoff =
                   c.number("survey.plan.kickoff_m", config::Range::non_negative(),
                            "a planned well in place of `survey.file`: measured depth where it leaves the vertical"),
               per_30m = c.number("survey.plan.build_deg_per_30m", config::Range{0, 90, true, false},
                                  "build rate of the planned well", 3),
               inclination =
                   kDegree *
                   c.number("survey.plan.inclination_deg", config::Range::closed(0, 180),
                            "inclination to which the planned well builds, and which it holds down to its end"),
               azimuth = kDegree * c.number("survey.plan.azimuth_deg", config::Range::closed(-360, 360),
                                            "azimuth of the planned well, from true north"),
               bottom =
                   c.number("survey.plan.md_m", config::Range::positive(), "measured depth of the planned well's end"),
               spacing = c.number("survey.plan.spacing_m", config::Range{0, 1000, true, false},
                                  "distance of stations along the planned well; random errors depend on it", 30);
  c.require(bottom / spacing < 100'000.5, "survey.plan.spacing_m", "more than 100000 stations");
  c.require(per_30m / 30 * spacing <= 90, "survey.plan.build_deg_per_30m",
            fmt::format("with survey.plan.spacing_m = {} there is more than 90 deg between two stations", spacing));
  survey::Survey well;
  for (int k = 0; k == 0 || well.stations.back().md < bottom; ++k) {
    const double regular = spacing * k, md = survey::is_deeper(bottom, regular) ? regular : bottom,
                 built = std::clamp((md - kickoff) * per_30m / 30 * kDegree, 0.0, inclination);
    well.stations.push_back({md, built, azimuth, 0});
  }
  return well;
}

}  // namespace

config::AzimuthReference read_azimuth_reference(config::ConfigReader& c, const config::InputTable& table,
                                                const std::string& key) {
  const config::NamedNorth named = config::named_north(table);
  const std::string said = named == config::NamedNorth::true_north ? "true"
                           : named == config::NamedNorth::magnetic ? "magnetic"
                           : named == config::NamedNorth::grid     ? "grid"
                                                                   : "";
  if (named == config::NamedNorth::unreferenced && !c.is_text(key))
    throw InputError(
        fmt::format("{}: the file does not say which north azimuths are counted from: must be known: "
                    "{} = \"true\", \"magnetic\" or \"grid\"",
                    table.path, key));
  const std::string north =
      c.choice(key, {"true", "magnetic", "grid"}, config::meaning::kNorth, said.empty() ? "true" : said);
  if (!said.empty() && north != said)
    c.fail(key, fmt::format("{} says {} north: must agree; leave this key out", table.path, said));
  return north == "magnetic" ? config::AzimuthReference::magnetic
         : north == "grid"   ? config::AzimuthReference::grid
                             : config::AzimuthReference::true_north;
}

void warn_of_north(config::ConfigReader& c, const config::InputTable& table,
                   const config::SurveyConventions& conventions) {
  const auto warn = [&](const char* north, const char* angle, const char* way_out) {
    c.warn_at(table.path, "", fmt::format("azimuths are from {} north, and the {} is 0", north, angle),
              fmt::format("if that is not meant, set {}", way_out));
  };
  using enum config::AzimuthReference;
  // On the central meridian of a known grid the convergence is 0.
  if (conventions.azimuth_reference == grid && conventions.convergence == 0 && !c.has("field.grid"))
    warn("grid", "convergence", "field.convergence_deg or field.grid");
  if (conventions.azimuth_reference == magnetic && conventions.declination == 0)
    warn("magnetic", "declination", "field.declination_deg");
}

config::InputTable read_readings_table(config::ConfigReader& c) {
  return read_any_table(c, "readings", config::ForeignKind::readings, {}, kNorthOfSurvey, "survey.");
}

config::InputTable read_offset_table(config::ConfigReader& c) {
  return read_any_table(c, "file", config::ForeignKind::survey, read_import_options(c, ""), "azimuth_reference",
                        "offset.");
}

survey::Survey read_survey(config::ConfigReader& c, const survey::ReferenceField& field, bool needs_toolface) {
  if (c.has("survey.plan")) {
    if (c.has("survey.file")) c.fail("survey.file", "not together with [survey.plan], a made-up well");
    if (needs_toolface) c.fail("survey.plan", "has no toolfaces, which this study needs: give survey.file");
    return read_planned_survey(c);
  }
  config::SurveyConventions conventions;
  const config::InputTable table = read_any_table(c, "survey.file", config::ForeignKind::survey,
                                                  read_import_options(c, "survey."), kNorthOfSurvey, "survey.");
  // Before its zero is asked for, which a file without toolface does not have: this throws.
  if (needs_toolface && table.find("toolface_deg") < 0) config::survey_from_table(table, conventions, true);
  const std::vector<std::string> zeros{"x", "y"};
  const std::string zero = needs_toolface
                               ? c.choice("survey.toolface_zero", zeros, config::meaning::kToolfaceZero)
                               : c.choice("survey.toolface_zero", zeros, config::meaning::kToolfaceZero, "y");
  conventions.toolface_zero = zero == "x" ? config::ToolfaceZero::x : config::ToolfaceZero::y;
  conventions.azimuth_reference = read_azimuth_reference(c, table, "survey.azimuth_reference");
  conventions.declination = field.declination;
  conventions.convergence = field.convergence;
  survey::Survey survey = config::survey_from_table(table, conventions, needs_toolface);
  warn_of_north(c, table, conventions);
  remark_on_survey(c, table, survey, conventions);
  return read_interpolation(c, "survey.interpolate_m", survey, needs_toolface);
}

std::vector<double> read_true_vertical_depths(config::ConfigReader& c, const survey::Survey& survey) {
  if (c.has("survey.plan")) return survey::true_vertical_depths(survey);
  return true_vertical_depths_of(c.csv("survey.file", config::kMeaningElsewhere), survey);
}

sensor::MagnetometerErrors read_magnetometer_errors(config::ConfigReader& c) {
  const std::vector<double> gain =
      c.numbers("sensor.gain", config::Range::open(0.1, 10), "true gains of the magnetometers x, y, z", 3,
                std::vector<double>{1, 1, 1});
  const std::vector<double> bias =
      c.numbers("sensor.bias_nT", config::Range::closed(-1e5, 1e5), "true biases of the magnetometers x, y, z", 3,
                std::vector<double>{0, 0, 0});
  return {{gain[0], gain[1], gain[2]}, {bias[0], bias[1], bias[2]}};
}

sensor::NoiseModel read_noise(config::ConfigReader& c) {
  sensor::NoiseModel n;
  const double scale = c.number("noise.scale", config::Range::positive(), "multiplies every noise size", 1);
  n.magnetometer = scale * c.number("noise.magnetometer_nT", config::Range::closed(0, 1e5),
                                    "size of `noise.law`, per axis and station");
  n.accelerometer = scale * c.number("noise.accelerometer_mps2", config::Range::closed(0, 1),
                                     "one sd, per axis and station, Gaussian", 0);
  const std::string law =
      c.choice("noise.law", {"gaussian", "gaussian_half_open", "uniform", "uniform_half_open"},
               "law of the magnetometer noise of size s: 'gaussian' (s is one sd), 'gaussian_half_open' (its absolute "
               "value), 'uniform' (+- s), 'uniform_half_open' (0 to s)",
               "gaussian");
  n.law = law == "gaussian_half_open"  ? sensor::NoiseLaw::gaussian_half_open
          : law == "uniform"           ? sensor::NoiseLaw::uniform
          : law == "uniform_half_open" ? sensor::NoiseLaw::uniform_half_open
                                       : sensor::NoiseLaw::gaussian;
  // The model's name stands for its sizes, one draw a run: a model that is wrong is so for the whole well.
  const bool named = c.has("noise.reference.name");
  const ReferenceSize size =
      named ? reference_size(c.choice(
                  "noise.reference.name", kFieldModels,
                  "the model's error as draws: one draw a run, of 138 nT and 0.20 deg, each of which can be given"))
            : ReferenceSize{};
  const std::string per =
      c.choice("noise.reference.per", {"none", "run", "station"},
               "how often an error of the reference is drawn; must be given where a size is", named ? "run" : "none");
  n.reference = per == "run"       ? sensor::ReferenceNoise::per_run
                : per == "station" ? sensor::ReferenceNoise::per_station
                                   : sensor::ReferenceNoise::none;
  // Given but unused values stay allowed, so that `per` can be swept.
  const double total = c.number("noise.reference.total_nT", config::Range::closed(0, 1e5),
                                "one sd of the reference's total field", size.total);
  const double dip = c.number("noise.reference.dip_deg", config::Range::closed(0, 45), "one sd of the reference's dip",
                              size.dip / kDegree);
  if (n.reference == sensor::ReferenceNoise::none && (total > 0 || dip > 0) && !named)
    c.require(
        c.has("noise.reference.per"), total > 0 ? "noise.reference.total_nT" : "noise.reference.dip_deg",
        "noise.reference.per is missing, which says when it is drawn: \"run\", \"station\", or \"none\" for never");
  if (n.reference != sensor::ReferenceNoise::none) {
    n.reference_total = scale * total;
    n.reference_dip = scale * dip * kDegree;
  }
  return n;
}

sensor::ToolSpread read_tool_spread(config::ConfigReader& c) {
  return {c.number("sensor.spread.gain", config::Range::closed(0, 0.3),
                   "every run has a tool of its own: one sd of its gains about `sensor.gain`", 0),
          c.number("sensor.spread.bias_nT", config::Range::closed(0, 1e5),
                   "one sd of a tool's biases about `sensor.bias_nT`", 0),
          c.number("sensor.spread.axial_bias_nT", config::Range::closed(0, 1e5),
                   "one sd of the drill string's interference, which adds to the bias of z", 0)};
}

namespace {

/// Estimators with this trait, for messages.
template <class Trait>
std::string names_with(const Trait& has_trait) {
  std::vector<std::string_view> names;
  for (const estimate::EstimatorKind& k : estimate::estimators())
    if (has_trait(k)) names.push_back(k.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

estimate::EstimatorOptions read_estimator(config::ConfigReader& c, const estimate::InputErrors& truth,
                                          const survey::ReferenceField& field, const std::vector<std::string>& names) {
  estimate::EstimatorOptions o;
  o.name =
      c.choice("estimator.name", names,
               "estimator: 'msa': horizontal and vertical field of all stations against the reference; 'msa_weighted': "
               "with the covariance of both; 'msa_joint': the reference is unknown, too; 'wls': readings against the "
               "true field, attitude known; 'wls_consider': as 'msa_weighted', the reference considered only");
  const estimate::EstimatorKind& kind = estimate::estimator_kind(o.name);
  c.require(kind.predict != nullptr, "estimator.name",
            "this study compares with a prediction to first order, and \"" + o.name + "\" has none");
  o.solver = c.choice("estimator.solver", estimate::solver_names(), "minimiser; not of wls", o.solver);
  c.require(kind.has_second_solvers || o.solver == "gauss_newton", "estimator.solver",
            o.name + " is solved in closed form: must be \"gauss_newton\"");
  o.max_iterations =
      static_cast<int>(c.integer("estimator.max_iterations", 1, 10000, "most iterations of a trial", o.max_iterations));
  o.step_tolerance = c.number("estimator.step_tolerance", config::Range{0, 1e-2, true, false},
                              "converged when no unknown moves by more (gains 1, biases in units of the total field)",
                              o.step_tolerance);
  o.assumed = truth;
  if (!kind.derivative.empty())
    o.derivative = c.choice("estimator.derivative", estimate::derivative_names(),
                            "where the derivative by a gain is taken: 'measured': at the reading, noise included, "
                            "which shifts gains by the noise; 'fitted': at the fitted field",
                            std::string(kind.derivative));
  else if (c.has("estimator.derivative"))
    c.fail("estimator.derivative",
           "only " + names_with([](const estimate::EstimatorKind& k) { return !k.derivative.empty(); }) + " have it");
  if (!kind.weighs) return o;
  o.assumed.magnetometer = c.number("estimator.magnetometer_nT", config::Range::closed(0, 1e5),
                                    "one sd that the estimator assumes of a magnetometer reading", truth.magnetometer);
  c.require(o.assumed.magnetometer > 0, "estimator.magnetometer_nT",
            "must be > 0: " + o.name + " weighs the readings by it");
  o.assumed.down =
      c.number("estimator.accelerometer_mps2", config::Range::closed(0, 1),
               "one sd that the estimator assumes of an accelerometer reading", truth.down * field.gravity) /
      field.gravity;
  o.assumed.total = c.number("estimator.reference.total_nT", config::Range::closed(0, 1e5),
                             "one sd that the estimator assumes of the reference's total field", truth.total);
  o.assumed.dip = c.number("estimator.reference.dip_deg", config::Range::closed(0, 45),
                           "one sd that the estimator assumes of the reference's dip", truth.dip / kDegree) *
                  kDegree;
  o.assumed.gain = c.number("estimator.prior.gain", config::Range::closed(0, 10),
                            "one sd of the prior of each gain about 1; 0: no prior", truth.gain);
  o.assumed.bias = c.number("estimator.prior.bias_nT", config::Range::closed(0, 1e6),
                            "one sd of the prior of each bias about 0; 0: no prior", truth.bias);
  o.assumed.axial_bias = c.number("estimator.prior.axial_bias_nT", config::Range::closed(0, 1e6),
                                  "one sd that the prior of the axial bias has besides; 0: none", truth.axial_bias);
  return o;
}

std::array<bool, 6> read_estimated_parameters(config::ConfigReader& c) {
  std::array<bool, 6> estimated{true, true, true, true, true, true};
  if (!c.has("estimator.estimated")) return estimated;
  estimated.fill(false);
  for (const std::string& name : c.texts("estimator.estimated",
                                         "parameters that are estimated, of gain_x to bias_z: the others are taken as "
                                         "1 and 0, whatever they are; without it all six")) {
    const auto* at = std::find(estimate::kParameterNames.begin(), estimate::kParameterNames.end(), name);
    if (at == estimate::kParameterNames.end())
      c.fail("estimator.estimated",
             config::none_of(name, {estimate::kParameterNames.begin(), estimate::kParameterNames.end()}));
    bool& flag = estimated[static_cast<std::size_t>(at - estimate::kParameterNames.begin())];
    c.require(!flag, "estimator.estimated", "\"" + name + "\" is there twice");
    flag = true;
  }
  return estimated;
}

sensor::AssumedNoise read_assumed_noise(config::ConfigReader& c, const std::string& estimator) {
  if (!estimate::estimator_kind(estimator).weighs_each_reading) {
    if (c.has("estimator.magnetometer_drawn"))
      c.fail("estimator.magnetometer_drawn",
             "only " + names_with([](const estimate::EstimatorKind& k) { return k.weighs_each_reading; }) + " has it");
    return sensor::AssumedNoise::constant;
  }
  const std::string drawn =
      c.choice("estimator.magnetometer_drawn", {"constant", "sd", "variance"},
               "of 'wls': what it assumes of a reading is drawn anew in each run, as 'sd' in (0, size) nT or as "
               "'variance' in (0, size) nT^2; only with `outputs` 'parameters' and without `control_variate`",
               "constant");
  return drawn == "sd"         ? sensor::AssumedNoise::random_sd
         : drawn == "variance" ? sensor::AssumedNoise::random_variance
                               : sensor::AssumedNoise::constant;
}

}  // namespace surveymc::scenario
