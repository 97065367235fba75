/// Study: position uncertainty of a surveyed well by the error models of its tools (ISCWSA MWD Rev 4, Rev 5.10, the
/// OWSG tool codes, or the user's own). No Monte Carlo: the covariance of every station, whole and by source, compared
/// with published figures.
///
///   survey, field, models (config) -> effects of every term at every station, summed as their modes say (propagate)
///   -> covariance, ellipse and ellipsoid per station
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/error.h"
#include "compare/annotations.h"
#include "compare/tails.h"
#include "config/meanings.h"
#include "montecarlo/threads.h"
#include "position_covariance/tables.h"
#include "position_covariance/uncertainty.h"
#include "propagate/disturbed_errors.h"
#include "propagate/drawn_well.h"
#include "scenario/disturbance.h"
#include "scenario/reference_laws.h"
#include "scenario/scenario.h"
#include "scenario/survey_spacing.h"
#include "scenario/validity_tables.h"
#include "study/experiment.h"
#include "survey/frames.h"
#include "survey/survey.h"

namespace surveymc::studies::position_covariance {
namespace {

constexpr std::array<const char*, 6> kElements{"nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2"};

double element(const Eigen::Matrix3d& c, const std::string& name) {
  const auto index = [](char letter) { return letter == 'n' ? 0 : letter == 'e' ? 1 : 2; };
  return c(index(name[0]), index(name[1]));
}

/// An entry of `[[published]]` for this point.
struct Published {
  std::size_t station;
  std::string source;  ///< code, or "total"
  std::vector<std::pair<std::string, double>> values;
  std::string origin;
};

std::size_t read_station(config::ConfigReader& entry, const survey::Survey& survey) {
  const double md = entry.number("md_m", config::Range::non_negative(), "measured depth of the row");
  if (const auto k = survey::station_at(survey, md)) return *k;
  entry.fail("md_m", "the survey has no station at this depth");
}

/// `[[published]] source, table, error_source (for covariance_by_source), md_m, values = { nn_m2 = ... }, at`.
std::vector<Published> read_published(config::ConfigReader& c, const survey::Survey& survey,
                                      const scenario::ToolRuns& tools) {
  std::vector<Published> out;
  for (config::ConfigReader& entry : c.tables("published", config::meaning::kPublished)) {
    const compare::PublishedEntry given = compare::read_published(entry);
    Published p{0, "total", given.values, given.source};
    if (entry.choice("table", {"covariance", "covariance_by_source"}, config::kMeaningElsewhere) ==
        "covariance_by_source")
      p.source = entry.text("error_source", "source of the row, of `covariance_by_source`");
    for (const auto& [quantity, value] : p.values)
      entry.require(std::find(kElements.begin(), kElements.end(), quantity) != kElements.end(), "values",
                    "must be of nn_m2, ee_m2, vv_m2, ne_m2, nv_m2, ev_m2");
    if (!given.here) continue;  // another point may have another survey or model
    p.station = read_station(entry, survey);
    entry.require(p.source == "total" || scenario::has_source(tools, p.source), "error_source",
                  "no model here has this code");
    out.push_back(std::move(p));
  }
  return out;
}

std::vector<PublishedElement> compare(const std::vector<Published>& published, const survey::Survey& survey,
                                      const propagate::ToolCovariances& result) {
  std::vector<PublishedElement> out;
  for (const Published& p : published) {
    const auto row = static_cast<std::size_t>(std::find(result.sources.begin(), result.sources.end(), p.source) -
                                              result.sources.begin());
    const Eigen::Matrix3d own =
        p.source == "total" ? result.total[p.station] : result.by_source[p.station * result.sources.size() + row];
    for (const auto& [quantity, value] : p.values)
      out.push_back(
          {survey.stations[p.station].md, p.source, quantity, element(own, quantity), value, own.trace(), p.origin});
  }
  return out;
}

constexpr std::size_t kMostDisturbed = 5000;

struct Scenario {
  survey::ReferenceField field;
  double latitude = 0;  ///< rad; NaN where no model needs it
  survey::Survey survey;
  scenario::ToolRuns tools;
  std::optional<disturbance::Disturbance> disturbance;  ///< its terms are in the models of `tools`
  std::vector<double> tvd;
  std::vector<propagate::Validity> validity;
  propagate::SourceDetail detail = propagate::SourceDetail::all;
  bool last_only = false;  ///< tables have the last station alone, and not the models
  UncertaintyReport report;
  double margin = 0;
  std::vector<Published> published;
  random::ReferenceLaws laws;
  compare::TailRule tails;
};

propagate::SourceDetail read_source_detail(config::ConfigReader& c) {
  const std::string word = c.choice("output.by_source", {"all", "last", "none"},
                                    "of which stations the table `covariance_by_source` has rows", "all");
  return word == "all"    ? propagate::SourceDetail::all
         : word == "last" ? propagate::SourceDetail::last
                          : propagate::SourceDetail::none;
}

Scenario read_scenario(config::ConfigReader& c) {
  Scenario s;
  s.field = scenario::read_field(c);
  s.survey = scenario::read_survey(c, s.field, false);
  s.tools = scenario::read_tool_runs(c, s.survey);
  s.latitude = scenario::read_latitude(c, scenario::models_of(s.tools));
  s.tvd = scenario::read_true_vertical_depths(c, s.survey);
  s.disturbance = scenario::read_disturbance(c, s.survey, {.is_drawn = false});
  if (s.disturbance) {
    c.require(s.survey.stations.size() <= kMostDisturbed, "disturbance.kind",
              fmt::format("at most {} stations: time is quadratic in them", kMostDisturbed));
    s.tools.runs = c.place("disturbance.kind").with_place([&] {
      return propagate::disturbed_runs(s.tools.runs, *s.disturbance, s.field);
    });
  }
  s.validity = propagate::tool_validity(s.survey, s.tools.runs, s.field, s.latitude);
  scenario::read_outside_range(c, s.survey, s.tools.runs, s.validity);
  scenario::warn_of_idle_terms(c, s.tools, s.field, s.latitude);
  s.detail = read_source_detail(c);
  s.last_only = c.choice("output.stations", {"all", "last"},
                         "'last': the tables `covariance` and `ellipsoid` have the last station alone, `error_terms` "
                         "is left out, and `output.by_source` must be 'last' or 'none'",
                         "all") == "last";
  if (s.last_only && s.detail == propagate::SourceDetail::all)
    c.fail("output.by_source", "must be \"last\" or \"none\" where output.stations = \"last\"");
  s.report = read_uncertainty_report(c, s.survey);
  if (c.has("trials"))
    c.integer("trials", 0, 1'000'000'000'000,
              config::meaning::kUnusedTrials);  // any config may have it; nothing is drawn here
  s.margin = c.number(
      "verdict.margin", config::Range::open(0, 1),
      "largest difference from a published element that agrees, relative to the trace of the covariance", 1e-6);
  s.published = read_published(c, s.survey, s.tools);
  for (const Published& p : s.published)
    if (p.source != "total" && s.detail != propagate::SourceDetail::all)
      c.fail("output.by_source", "must be \"all\": there are published values of a source");
  s.laws = scenario::read_reference_laws(c, {.sizes = false});
  scenario::warn_of_idle_laws(c, s.laws, {&s.tools});
  s.tails = compare::read_tail_rule(c, s.laws);
  scenario::set_beside_laws(c, s.disturbance, s.laws, s.tails);
  c.require(!s.tails.wanted || s.tails.predicted, "disturbance.kind",
            "only \"ar1\" is normal: of another disturbance the table `tails` has no prediction, but "
            "error_model_monte_carlo has trials");
  if (s.disturbance && s.tails.wanted)
    c.place("disturbance.kind").with_place([&] {
      propagate::require_few_draws(s.tools.runs, s.survey.stations.size());
    });
  c.finish();
  return s;
}

/// Table `tails` of the last station.
store::Table tails_table(const Scenario& s) {
  propagate::WellErrors errors = propagate::well_errors(s.survey, s.tvd, s.tools.runs, s.field, s.latitude);
  if (s.disturbance)
    errors = propagate::with_independent_draws(
        errors, propagate::disturbed_draws(errors, s.tools.runs, *s.disturbance, s.field));
  const std::size_t last = s.survey.stations.size() - 1;
  const survey::Station& at = s.survey.stations[last];
  const compare::WellTails tails =
      compare::well_tails(propagate::well_mixing(errors, s.laws, propagate::draw_places(errors)),
                          propagate::draw_effects(errors, {last, 1}, propagate::FirstOrder::iscwsa),
                          survey::rotation_hla_from_nev(at.inclination, at.azimuth));
  return compare::tails_table(tails.quantities, s.tails, nullptr, 0, {}, {}, 0, 0);
}

class PositionCovariance final : public study::StudyPoint {
 public:
  explicit PositionCovariance(Scenario scenario) : scenario_(std::move(scenario)) {}

  study::PointResult report(const stats::Tally&, const montecarlo::RunOptions& options) const override {
    const Scenario& s = scenario_;
    // Two tables take as long as the covariances themselves: a station is done when it is in all three.
    enum Stage { covariances, first_table, second_table };
    const auto at_station = [&options, n = s.survey.stations.size()](Stage stage) {
      constexpr std::size_t kStages = 3;
      return [&options, n, stage](std::size_t done) {
        if (stage != covariances && done % kLook != 0 && done != n) return;
        look(options.stop);
        if (options.progress) options.progress((stage * n + done) / kStages, n);
      };
    };
    propagate::ToolCovariances result;
    store::Table by_source;
    // With two threads a long table is made beside the covariances; with one that would be done twice.
    const bool is_apart = montecarlo::threads_for(options.threads, 2) > 1 && is_long(s) && s.published.empty();
    const auto own_part = [&](int share) {
      if (share == 0) {
        result = covariances_of(s, is_apart ? propagate::SourceDetail::none : s.detail, at_station(covariances));
      } else {
        propagate::ToolCovariances all = covariances_of(s, s.detail, [&options](std::size_t) { look(options.stop); });
        by_source = covariance_by_source_table(s.survey, all, s.detail);
      }
      return false;
    };
    montecarlo::in_threads(
        is_apart ? 2 : 1, [] { return false; }, own_part);
    std::vector<propagate::Validity> validity = s.validity;
    for (const propagate::NonFiniteTerm& term : result.non_finite)
      validity.push_back(propagate::validity_of(term, s.tools.runs));
    const std::vector<PublishedElement> published = compare(s.published, s.survey, result);
    study::PointResult r;
    const auto of_stations = [&](store::Table t) {
      if (s.last_only) return store::rows_of(t, t.rows() - 1, 1);  // not ?:, which copies the other table
      return t;
    };
    r.tables.push_back(of_stations(covariance_table(s.survey, result, at_station(first_table))));
    if (s.detail != propagate::SourceDetail::none)
      r.tables.push_back(is_apart ? std::move(by_source) : covariance_by_source_table(s.survey, result, s.detail));
    r.tables.push_back(of_stations(ellipsoid_table(s.survey, s.tvd, result.total, at_station(second_table))));
    if (s.disturbance) r.tables.push_back(scenario::disturbance_table(*s.disturbance, s.field, nullptr));
    r.tables.push_back(tool_codes_table(s.tools));
    if (!s.last_only) r.tables.push_back(error_terms_table(s.tools));
    r.tables.push_back(scenario::validity_table(s.survey, s.tools, validity));
    r.tables.push_back(gyro_table(s.survey, s.tools, result));
    r.tables.push_back(published_table(published, s.margin));
    r.tables.push_back(uncertainty_table(s.survey, result, s.report));
    if (s.tails.wanted) {
      r.tables.push_back(tails_table(s));
      r.tables.push_back(compare::laws_table(s.laws, {}, nullptr, nullptr, compare::VerdictRule{}.confidence));
    }
    std::vector<compare::Warning> warnings = scenario::validity_warnings(s.survey, s.tools, validity);
    scenario::add_spacing_warning(warnings, s.survey, s.tvd, s.tools, s.field, s.latitude);
    r.tables.push_back(compare::warnings_table(warnings));
    return r;
  }

 private:
  using AtStation = std::function<void(std::size_t)>;
  static constexpr std::size_t kLook = 256;

  static void look(const std::atomic<bool>* stop) {
    if (stop && *stop) throw Interrupted("stopped before all stations were done");
  }

  static propagate::ToolCovariances covariances_of(const Scenario& s, propagate::SourceDetail detail,
                                                   const AtStation& at_station) {
    if (!s.disturbance)
      return propagate::tool_covariances(s.survey, s.tvd, s.tools.runs, s.field, s.latitude, detail, nullptr, false,
                                         at_station);
    propagate::StationEffects effects;
    propagate::ToolCovariances c = propagate::tool_covariances(s.survey, s.tvd, s.tools.runs, s.field, s.latitude,
                                                               detail, &effects, false, at_station);
    propagate::add_correlation(c, effects, s.tools.runs, *s.disturbance, s.field, detail);
    return c;
  }

  static bool is_long(const Scenario& s) {
    std::size_t terms = 0;  // sources, or more
    for (const propagate::ToolRun& run : s.tools.runs) terms += run.model->terms.size();
    return s.detail == propagate::SourceDetail::all && s.survey.stations.size() * terms > store::kMostHeldRows;
  }

  const Scenario scenario_;
};

class PositionCovariancePlan final : public study::PlanOfPoint<Scenario, PositionCovariance> {
 public:
  using PlanOfPoint::PlanOfPoint;
  double cost() const override {
    double terms = 0;
    for (const propagate::ToolRun& run : s_.tools.runs) terms += static_cast<double>(run.model->terms.size());
    return s_.survey.size() * terms;
  }
  /// The models with their terms, everything that they extend applied.
  std::string details() const override {
    std::string out;
    for (const propagate::ToolRun& run : s_.tools.runs) {
      const std::string text = config::model_text(*run.model), terms = text.substr(text.find("[[model]]"));
      if (out.find(terms) == std::string::npos) out += terms;
    }
    return out;
  }
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::position_covariance,
          "Position uncertainty of a well by the error models of its survey tools",
          "ISCWSA MWD error model Rev 4 and Rev 5.10, OWSG tool codes",
          study::plan_of<PositionCovariancePlan, read_scenario>};
}

}  // namespace surveymc::studies::position_covariance
