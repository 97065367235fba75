#include "estimate/multistation_readings.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "compare/verdict.h"
#include "config/meanings.h"
#include "config/readings_csv.h"
#include "estimate/run_tables.h"
#include "multistation/hold_out.h"
#include "random/study_id.h"
#include "scenario/input_remarks.h"
#include "scenario/parameter_set.h"
#include "scenario/scenario.h"
#include "stats/intervals.h"

namespace surveymc::studies::estimate {
namespace {

namespace ms = multistation;

constexpr const char* kJustified = "justified";
/// A set within so much of the least criterion explains the run about as well (Kass and Raftery, J. Amer. Stat. Assoc.
/// 90, 1995: 2 ln of a Bayes factor below 2 is not worth more than a bare mention).
constexpr double kAsGood = 2;

struct OwnRun {
  survey::ReferenceField field;
  survey::SixAxisReadings file;
  ms::Stations stations;
  std::string set;                      ///< name of a set, kJustified, or empty: `own`
  std::optional<ms::ParameterSet> own;  ///< a list of parameters
  ms::FitOptions options;
  scenario::AskedLoss asked;    ///< the sets are fitted by all losses
  bool has_components = false;  ///< sizes of the residuals by variance components
  std::vector<std::vector<int>> folds;
  bool has_groups = false;
  double confidence = 0.95;
  config::ConfigPlace place;  ///< of the file
};

void read_parameters(config::ConfigReader& c, OwnRun& r) {
  r.set = kJustified;
  if (!c.has("estimator.parameters")) return;
  const scenario::AskedParameters asked = scenario::read_parameters(c, {kJustified});
  if (!asked.set) return;
  const std::vector<std::string>& sets = ms::set_names();
  r.set = asked.set->name();
  if (std::find(sets.begin(), sets.end(), r.set) != sets.end()) return;
  r.set.clear();
  r.own = asked.set;
}

/// Which stations are judged by the fit of the others.
void read_folds(config::ConfigReader& c, OwnRun& r) {
  const auto stations = static_cast<std::int64_t>(r.file.md.size());
  for (config::ConfigReader& group : c.tables("group",
                                              "shots at several rolls about one direction; each group is held "
                                              "out once, the direction in the tool comes from the others")) {
    const auto first = group.integer("first", 1, stations, "number of its first shot, from 1"),
               last = group.integer("last", first, stations, "number of its last shot");
    group.require(last - first >= 2, "last", "must leave at least three shots in the group");
    std::vector<int> fold;
    for (std::int64_t k = first - 1; k < last; ++k) {
      for (const std::vector<int>& other : r.folds)
        group.require(std::find(other.begin(), other.end(), k) == other.end(), "first",
                      fmt::format("shot {} is in a group before", k + 1));
      fold.push_back(static_cast<int>(k));
    }
    r.folds.push_back(fold);
  }
  r.has_groups = !r.folds.empty();
  if (r.has_groups) return;
  r.folds.resize(2);
  for (int k = 0; k < stations; ++k) r.folds[static_cast<std::size_t>(k % 2)].push_back(k);
}

void read_reference(config::ConfigReader& c, ms::FitOptions& o) {
  const std::string how = c.choice(
      "estimator.reference.name", {"consider", "estimated", "unknown"},
      "'consider': the fit takes the reference as it is, and claims count its errors; 'estimated': with its errors as "
      "priors; 'unknown': lengths of gravity and field as given, the dip not: shots of an instrument anywhere",
      "consider");
  o.reference = scenario::read_reference_errors(c, {});
  o.estimates_reference = how != "consider";
  c.require(how != "estimated" || o.reference.gravity > 0 || o.reference.total > 0 || o.reference.dip > 0,
            "estimator.reference.name",
            "takes the reference's errors as priors: give estimator.reference.gravity_mps2, total_nT or dip_deg");
  if (how != "unknown") return;
  o.residuals = ms::ResidualKind::calibration;
  for (const char* key : {"estimator.reference.total_nT", "estimator.reference.dip_deg"})
    c.require(!c.has(key), key, "is not of estimator.reference.name = \"unknown\": leave it out");
  o.reference.total = 0;
  o.reference.dip = kInfinity;
}

OwnRun read_multistation_run(config::ConfigReader& c) {
  OwnRun r;
  r.field = scenario::read_field(c);
  const bool gravity = c.choice("accelerometers", {"gravity", "specific_force"}, config::meaning::kAccelerometers,
                                "gravity") == "gravity";
  constexpr std::size_t kFewest = 6;
  ms::FitOptions& o = r.options;
  read_reference(c, o);
  o.max_iterations = 200;
  const bool is_instrument = o.residuals == ms::ResidualKind::calibration;
  r.file = config::readings_from_table(
      scenario::read_readings_table(c),
      {gravity ? config::AccelerometerSign::gravity : config::AccelerometerSign::specific_force, r.field.gravity,
       r.field.total, kFewest, is_instrument});
  read_parameters(c, r);
  r.asked = scenario::read_loss(c);
  r.has_components = c.boolean("estimator.variance_components",
                               "sizes of the residuals of gravity and of both components of the field from the "
                               "residuals themselves, by a least-squares fit of the set that is asked for, or of "
                               "'21'; `residual_sd` is where that begins",
                               false);
  o.total = r.field.total;
  o.dip = r.field.dip;
  if (!is_instrument) scenario::remark_on_readings(c, r.file, r.field);
  o.prior_sd = scenario::read_priors(c, o.prior_sd);
  if (!c.boolean("estimator.use_priors", "false: nothing is known of the tool before the run", true)) {
    c.require(!c.has("estimator.priors"), "estimator.use_priors",
              "is false, and estimator.priors has values: drop one");
    o.prior_sd.fill(kInfinity);
  }
  const auto positive = [&](const char* key, const char* meaning, double fallback) {
    return c.number(key, config::Range::positive(), meaning, fallback);
  };
  o.sizes[0] = positive("residual_sd.gravity_mps2", "one sd of the length of gravity at a station", o.sizes[0]);
  o.sizes[1] = positive("residual_sd.field_nT",
                        "one sd of the horizontal and of the vertical field at a station; of the total field where the "
                        "reference is unknown",
                        o.sizes[1]);
  o.sizes[2] = is_instrument ? positive("residual_sd.sine_of_dip",
                                        "one sd of the sine of the dip at a station, where the "
                                        "reference is unknown",
                                        0.004)
                             : o.sizes[1];
  const ms::Reference reference = ms::reference_of(o.residuals, r.field.gravity, o.total, o.dip);
  for (std::size_t k = 0; k < r.file.md.size(); ++k)
    r.stations.push_back({r.file.gravity_T[k], r.file.magnetic_T[k], reference});
  read_folds(c, r);
  r.confidence =
      c.number("confidence", config::Range::open(0, 1), config::meaning::kConfidenceOfIntervals, r.confidence);
  if (c.has("trials")) c.integer("trials", 0, 1'000'000'000'000, config::meaning::kUnusedTrials);
  r.place = c.place("readings");
  c.finish();
  return r;
}

/// One set of parameters and a loss: its fit to all stations, and what it predicts of those that it has not seen.
struct Candidate {
  ms::Loss loss = ms::Loss::least_squares;
  ms::FitOptions options;
  ms::FittedStations fitted;
  ms::CrossValidation held_out;
  double learnt = kNaN;
  double criterion = kNaN;    ///< of least squares alone: costs of other losses are not of the same kind
  std::string failure;        ///< why there is no fit; empty if there is one
  std::string is_not_judged;  ///< why held-out stations do not judge it; empty if they do
};

Candidate candidate(const OwnRun& r, const ms::ParameterSet& set, ms::Loss loss) {
  Candidate c;
  c.loss = loss;
  c.options = r.options;
  c.options.parameters = set;
  ms::RobustOptions robust = ms::robust_options(loss, r.asked.start);
  robust.reweightings = 5000;  // l1 of few shots takes small steps
  robust.newton_steps = 100;   // biases of an instrument may be as large as the field
  robust.tolerance = 1e-5;
  const random::Stream subsets(0, static_cast<std::uint32_t>(random::StudyId::estimate));  // whatever the seed
  const ms::Fitter fitter = [&](const ms::Stations& s) {
    return loss == ms::Loss::least_squares ? ms::fit_by_least_squares(s, c.options)
                                           : ms::fit_robustly(s, c.options, robust, subsets);
  };
  try {
    c.fitted = fitter(r.stations);
    require(c.fitted.fit.converged, "the fit does not converge");
    c.learnt = ms::learnt_parameters(c.fitted.fit, c.options);
    if (loss == ms::Loss::least_squares)
      c.criterion = ms::information_criterion(c.fitted.fit, c.options, r.stations.size());
  } catch (const InputError& e) {
    c.failure = e.what();
    return c;
  }
  try {
    c.held_out = ms::cross_validate(r.stations, r.folds, r.has_groups, c.options, fitter);
  } catch (const InputError& e) {
    c.is_not_judged = e.what();
  }
  return c;
}

/// All sets by all losses, and which of them is taken.
struct SetAnswer {
  std::vector<Candidate> sets;
  std::size_t justified = 0, taken = 0;
};

SetAnswer choose_set(const OwnRun& r) {
  SetAnswer a;
  std::vector<ms::ParameterSet> sets;
  for (const std::string& name : ms::set_names()) sets.push_back(ms::ParameterSet::named(name));
  const std::string own = r.own ? r.own->name() : "";
  if (r.own && std::none_of(sets.begin(), sets.end(), [&own](const ms::ParameterSet& s) { return s.name() == own; }))
    sets.push_back(*r.own);
  for (const ms::ParameterSet& set : sets)
    for (std::size_t loss = 0; loss < ms::loss_names().size(); ++loss)
      a.sets.push_back(candidate(r, set, static_cast<ms::Loss>(loss)));
  const auto value = [](const Candidate& c) {
    return c.failure.empty() && std::isfinite(c.criterion) ? c.criterion : kInfinity;
  };
  const auto least = std::min_element(a.sets.begin(), a.sets.end(),
                                      [&](const Candidate& x, const Candidate& y) { return value(x) < value(y); });
  require(std::isfinite(value(*least)), "no set of parameters can be fitted: of {} {}",
          least->options.parameters.name(), least->failure);
  a.justified = static_cast<std::size_t>(least - a.sets.begin());
  const std::string name = r.own ? own : r.set == kJustified ? least->options.parameters.name() : r.set;
  const auto taken = std::find_if(a.sets.begin(), a.sets.end(), [&](const Candidate& c) {
    return c.loss == r.asked.loss && c.options.parameters.name() == name;
  });
  require(taken->failure.empty(), "estimator.parameters = {}: {}", name, taken->failure);
  a.taken = static_cast<std::size_t>(taken - a.sets.begin());
  return a;
}

store::Table parameters_table(const OwnRun& r, const Candidate& c) {
  compare::TableRows t("parameters", "errors of the tool" + compare::at_confidence(r.confidence));
  const double z = stats::normal_quantile((1 + r.confidence) / 2);
  const ms::Fit& fit = c.fitted.fit;
  for (int i = 0; i < c.options.parameters.size(); ++i) {
    const ms::Parameter& p = c.options.parameters[i];
    const double x = fit.estimate[i], sd = std::sqrt(fit.covariance(i, i)),
                 prior = c.options.prior_sd[static_cast<std::size_t>(c.options.parameters.index(i))];
    t.word("quantity", "name of the parameter", p.name);
    t.word("unit", "unit of the values in this row", p.unit);
    t.number("estimate", "1", "in the unit of the row", x, "ci_low ci_high");
    t.number("sd", "1", "standard deviation, by the size that the residuals have", sd);
    t.number("ci_low", "1", "lower bound of the confidence interval", x - z * sd);
    t.number("ci_high", "1", "upper bound of the confidence interval", x + z * sd);
    t.number("prior_sd", "1", "one sd of the prior about 0; inf: none", prior);
    t.number("learnt", "1", "share of the prior's variance that the run takes away", fit.learnt[i]);
    t.word("meaning", "what it is", p.meaning);
  }
  return t.take();
}

store::Table sets_table(const SetAnswer& a) {
  compare::TableRows t("sets",
                       "sets of parameters: what a run justifies, and what each predicts of stations that its "
                       "fit has not seen");
  for (std::size_t i = 0; i < a.sets.size(); ++i) {
    const Candidate& c = a.sets[i];
    const ms::CrossValidation& h = c.held_out;
    const bool has_fit = c.failure.empty();
    const auto number = [&](const char* name, const char* unit, const char* meaning, double x) {
      t.number(name, unit, meaning, has_fit ? x : kNaN);
    };
    const auto judged = [&](const char* name, const char* unit, const char* meaning, double x) {
      number(name, unit, meaning, c.is_not_judged.empty() ? x : kNaN);
    };
    t.word("set", "name, or the parameters", c.options.parameters.name());
    t.word("loss", "of the fit", ms::loss_names()[static_cast<std::size_t>(c.loss)]);
    t.count("parameters", "how many", c.options.parameters.size());
    number("learnt", "1", "how many the run says more of than the priors do, with the reference, by claimed sizes",
           c.learnt);
    number("s0", "1", "residuals of the fit to all stations over their claimed sizes", c.fitted.s0);
    number("criterion", "1", "m ln(cost / m) + learnt ln m of the fit to all stations: least where justified",
           c.criterion);
    number("difference", "1", "criterion less that of the justified set", c.criterion - a.sets[a.justified].criterion);
    t.word("judgement", "of least squares: justified; as good: within 2 of it; worse; or undetermined: there is no fit",
           !has_fit                                                ? "undetermined"
           : i == a.justified                                      ? "justified"
           : !std::isfinite(c.criterion)                           ? ""
           : c.criterion - a.sets[a.justified].criterion < kAsGood ? "as good"
                                                                   : "worse");
    t.word("taken", "yes: of which the other tables are", i == a.taken ? "yes" : "");
    judged("nees", "1", "squared residuals of held-out stations over what the fit says of them: 1 if all is as claimed",
           h.nees);
    judged("nees_median", "1", "the same by medians: of most stations, whatever a few are", h.nees_median);
    judged("coverage_95", "1", "share of held-out stations in their 95 % ellipsoid", h.coverage);
    judged("raw_sd_gravity_mps2", "mps2", "spread of the length of gravity over held-out stations, as read",
           h.spread_before.gravity);
    judged("sd_gravity_mps2", "mps2", "the same, corrected by the fit of the other stations", h.spread_after.gravity);
    judged("raw_sd_total_field_nT", "nT", "spread of the total field, as read", h.spread_before.total);
    judged("sd_total_field_nT", "nT", "the same, corrected", h.spread_after.total);
    judged("raw_sd_dip_deg", "deg", "spread of the dip, as read", h.spread_before.dip / kDegree);
    judged("sd_dip_deg", "deg", "the same, corrected", h.spread_after.dip / kDegree);
    judged("raw_axis_rms_deg", "deg", "angle of the axis that shots were turned about with its mean, as read",
           h.axis_rms_before / kDegree);
    judged("axis_rms_deg", "deg", "the same, corrected; only with groups", h.axis_rms / kDegree);
    t.word("note", "why there is no fit, or no fit without the stations that are held out",
           has_fit ? c.is_not_judged : c.failure);
  }
  return t.take();
}

store::Table reference_table(const OwnRun& r, const Candidate& c) {
  compare::TableRows t("reference", "the reference, as given and as estimated with the tool");
  const ms::ReferenceErrors &x = c.fitted.fit.reference, &sd = c.fitted.fit.reference_sd, &prior = c.options.reference;
  const bool is_calibration = c.options.residuals == ms::ResidualKind::calibration;
  // Errors of the dip are linear in the residuals' values.
  const double dip = is_calibration
                         ? std::asin(std::clamp(std::sin(r.field.dip) + std::cos(r.field.dip) * x.dip, -1.0, 1.0))
                         : r.field.dip + x.dip;
  const auto row = [&](const char* name, double given, double estimate, double s, double p, double unit) {
    t.word("quantity", "gravity (m/s2), total field (nT), dip (deg)", name);
    t.number("given", "1", "in the unit of the quantity", given / unit);
    t.number("estimate", "1", "in the unit of the quantity", estimate / unit);
    t.number("sd", "1", "standard deviation of the estimate, by the size that the residuals have", s / unit);
    t.number("prior_sd", "1", "one sd of what was given; inf: unknown, 0: taken as exact", p / unit);
  };
  row("gravity_mps2", r.field.gravity, r.field.gravity + x.gravity, sd.gravity, prior.gravity, 1);
  row("total_field_nT", r.field.total, r.field.total + x.total, sd.total, prior.total, 1);
  row("dip_deg", r.field.dip, dip, sd.dip, prior.dip, kDegree);
  return t.take();
}

store::Table stations_table(const OwnRun& r, const Candidate& c) {
  compare::TableRows t("stations", "attitudes and field of every station, as read and corrected");
  const ms::Fit& fit = c.fitted.fit;
  const auto attitude = [&](std::size_t k, const ms::PerParameter<double>& tool) {
    const Eigen::Matrix3d earth = ms::earth_from_tool(r.stations[k], tool);
    struct {
      double inclination, azimuth, toolface;
    } at{std::acos(std::clamp(earth(2, 2), -1.0, 1.0)), std::atan2(earth(1, 2), earth(0, 2)),
         std::atan2(-earth(2, 0), -earth(2, 1))};
    return at;
  };
  for (std::size_t k = 0; k < r.stations.size(); ++k) {
    const auto raw = attitude(k, {}), corrected = attitude(k, fit.tool);
    const ms::FieldNumbers before = ms::field_numbers(r.stations[k], {}),
                           after = ms::field_numbers(r.stations[k], fit.tool);
    t.count("station", "number of the station, from 1", k + 1);
    t.number("md_m", "m", "measured depth", r.file.md[k]);
    t.number("raw_inclination_deg", "deg", "of the tool's z axis, as read", raw.inclination / kDegree);
    t.number("inclination_deg", "deg", "corrected", corrected.inclination / kDegree);
    t.number("raw_azimuth_magnetic_deg", "deg", "from magnetic north, as read", compare::turn_in_degrees(raw.azimuth));
    t.number("azimuth_magnetic_deg", "deg", "corrected", compare::turn_in_degrees(corrected.azimuth));
    t.number("toolface_deg", "deg", "corrected, from the tool's y axis", compare::turn_in_degrees(corrected.toolface));
    t.number("raw_gravity_mps2", "mps2", "length of gravity, as read", before.gravity);
    t.number("gravity_mps2", "mps2", "corrected", after.gravity);
    t.number("raw_total_field_nT", "nT", "total field, as read", before.total);
    t.number("total_field_nT", "nT", "corrected", after.total);
    t.number("raw_dip_deg", "deg", "dip, as read", before.dip / kDegree);
    t.number("dip_deg", "deg", "corrected", after.dip / kDegree);
    const auto column = static_cast<Eigen::Index>(k);
    const auto residual = [&](const char* name, const char* meaning, Eigen::Index i) {
      t.number(name, "1", meaning, fit.residuals(i, column));
    };
    residual("residual_gravity", "of the fit, in units of its claimed size", 0);
    residual("residual_first", "horizontal field; total field where the reference is unknown", 1);
    residual("residual_second", "vertical field; sine of the dip where the reference is unknown", 2);
    t.number("weight", "1", "of the station in the fit", c.fitted.weights.empty() ? 1 : c.fitted.weights[k]);
  }
  return t.take();
}

std::vector<analysis::Warning> warnings_of(const SetAnswer& a) {
  std::vector<analysis::Warning> warnings;
  const auto warn = [&](const char* severity, const std::string& message) { warnings.push_back({severity, message}); };
  const Candidate &taken = a.sets[a.taken], &justified = a.sets[a.justified];
  const auto of_least_squares = std::find_if(a.sets.begin(), a.sets.end(), [&](const Candidate& c) {
    return c.loss == ms::Loss::least_squares && c.options.parameters.name() == taken.options.parameters.name();
  });
  if (const double more = of_least_squares->criterion - justified.criterion; more >= kAsGood)
    warn("warning", fmt::format("set {} is not what the run justifies: its criterion is {:.1f} above that of set {}",
                                taken.options.parameters.name(), more, justified.options.parameters.name()));
  if (!(taken.fitted.s0 < 2 && taken.fitted.s0 > 0.5))
    warn("warning",
         fmt::format("residuals are {:.3g} times their claimed sizes (residual_sd): errors that no parameter "
                     "of the set describes, a wrong reference, or gross errors",
                     taken.fitted.s0));
  if (!taken.is_not_judged.empty())
    warn("warning", fmt::format("no held-out stations judge the fit: {}", taken.is_not_judged));
  else if (taken.held_out.nees > 2)
    warn("warning",
         fmt::format("stations that the fit has not seen are off by {:.3g} times what it says of them: do not "
                     "take its sd to other readings",
                     std::sqrt(taken.held_out.nees)));
  std::vector<std::string> unlearnt;
  for (int i = 0; i < taken.options.parameters.size(); ++i)
    if (taken.fitted.fit.learnt[i] < 0.1) unlearnt.emplace_back(taken.options.parameters[i].name);
  if (!unlearnt.empty())
    warn("info",
         fmt::format("the run says next to nothing of {}: their estimates are the prior", fmt::join(unlearnt, ", ")));
  warn("info",
       "held-out stations tell whether a fit predicts readings of this run; nothing here knows the true attitudes");
  return warnings;
}

ms::VarianceComponents components_of(const OwnRun& r) {
  ms::FitOptions o = r.options;
  o.parameters = r.own ? *r.own : ms::ParameterSet::named(r.set == kJustified ? "21" : r.set);
  try {
    return ms::residual_components(r.stations, o);
  } catch (const InputError& e) {
    throw InputError(
        fmt::format("estimator.variance_components: of set {}: {}; name a smaller set in "
                    "estimator.parameters",
                    o.parameters.name(), e.what()));
  }
}

store::Table components_table(const OwnRun& r, const ms::VarianceComponents& components) {
  compare::TableRows t("variance_components", "sizes of the residuals, as given and as the residuals have them");
  const bool is_instrument = r.options.residuals == ms::ResidualKind::calibration;
  const std::array<const char*, 3> names{"gravity_mps2", is_instrument ? "total_field_nT" : "horizontal_field_nT",
                                         is_instrument ? "sine_of_dip" : "vertical_field_nT"};
  for (std::size_t j = 0; j < names.size(); ++j) {
    const ms::VarianceComponent& c = components.groups[j];
    t.word("residual", "which residuals of the stations", names[j]);
    t.number("given_sd", "1", "residual_sd, in the unit of the residual", r.options.sizes[j]);
    t.number("sd", "1", "by the residuals; as given where they are too few", r.options.sizes[j] * std::sqrt(c.factor));
    t.number("factor", "1", "variance over that of what was given", c.factor);
    t.number("sd_factor", "1", "one standard deviation of the factor, if residuals are normal", c.sd);
    t.number("redundancy", "1", "observations that the fit leaves over", c.redundancy);
    t.word("estimated", "no: fewer than three observations are left over", c.estimated ? "yes" : "no");
  }
  return t.take();
}

std::vector<store::Table> multistation_tables(const OwnRun& given) {
  OwnRun r = given;
  std::optional<ms::VarianceComponents> components;
  if (r.has_components) {
    components = components_of(given);
    r.options = ms::with_components(given.options, *components);
  }
  const SetAnswer a = choose_set(r);
  const Candidate& taken = a.sets[a.taken];
  std::vector<store::Table> tables{parameters_table(r, taken), sets_table(a)};
  if (components) tables.push_back(components_table(given, *components));
  if (r.options.estimates_reference) tables.push_back(reference_table(r, taken));
  tables.push_back(stations_table(r, taken));
  std::vector<analysis::Warning> warnings = warnings_of(a);
  if (components && !components->converged)
    warnings.push_back({"warning", "variance components do not settle: sizes of residuals are those of the last step"});
  tables.push_back(warnings_table(warnings));
  return tables;
}

}  // namespace

std::unique_ptr<study::PointPlan> multistation_readings_result(config::ConfigReader& config) {
  return std::make_unique<EstimatePlan<OwnRun, multistation_tables>>(read_multistation_run(config));
}

}  // namespace surveymc::studies::estimate
