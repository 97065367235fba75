/// Study: what survey tools are claimed to be worth, hole by hole: standard deviations at the end of straight holes
/// over inclination and azimuth, by error model. No Monte Carlo.
///
///   codes, field, grid (config) -> a straight hole per cell -> covariance of its last station by every model
///   (propagate)
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/table_rows.h"
#include "config/meanings.h"
#include "propagate/tool_validity.h"
#include "scenario/error_models.h"
#include "scenario/scenario.h"
#include "stats/order_statistics.h"
#include "study/experiment.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::tool_code_map {
namespace {

struct Scenario {
  survey::ReferenceField field;
  double latitude = 0;  ///< rad; NaN where no model needs it
  std::vector<std::string> names;
  std::vector<config::SharedModel> models;
  std::vector<double> inclinations_deg, azimuths_deg;  ///< of the cells; azimuths from true north
  double length = 0, spacing = 0;                      ///< m
};

/// `codes`: names, or `{ match = [...], without = [...] }`.
std::vector<std::string> read_codes(config::ConfigReader& c) {
  if (!c.has("codes.match")) return c.texts("codes", "names of shipped error models, or { match, without }");
  const std::vector<std::string> match = c.texts("codes.match", "patterns of names; * stands for any text");
  const std::vector<std::string> without = c.has("codes.without")
                                               ? c.texts("codes.without", "patterns of names that are left out")
                                               : std::vector<std::string>();
  const std::vector<std::string> names = config::matching_shipped_models(match, without);
  c.require(!names.empty(), "codes.match", "fits no shipped error model: surveymc models lists them");
  return names;
}

Scenario read_scenario(config::ConfigReader& c) {
  Scenario s;
  s.field = scenario::read_field(c);
  s.names = read_codes(c);
  for (const std::string& name : s.names) {
    const config::ShippedModel* shipped = config::find_shipped_model(name);
    if (shipped == nullptr)
      c.fail("codes", fmt::format("unknown error model \"{}\": {}", name, config::shipped_model_suggestion(name)));
    c.require(std::count(s.names.begin(), s.names.end(), name) == 1, "codes",
              fmt::format("\"{}\" is in the list twice", name));
    s.models.push_back(config::read_shipped_model(c, "codes", *shipped));
  }
  s.latitude = scenario::read_latitude(c, s.models);
  s.inclinations_deg = c.grid("map.inclination_deg", config::Range::closed(0, 180), "inclinations of the map");
  s.azimuths_deg = c.grid("map.azimuth_deg", config::Range::closed(-360, 360), "azimuths of the map, from true north");
  s.length = c.number("map.length_m", config::Range::positive(),
                      "length of the hole, whose first station is the tie-on, without error", 900);
  s.spacing =
      c.number("map.spacing_m", config::Range::positive(), "distance of the stations; random errors depend on it", 30);
  const double intervals = s.length / s.spacing;
  c.require(intervals < 100'000.5, "map.spacing_m", "more than 100000 stations a hole");
  c.require(std::abs(intervals - std::round(intervals)) < 1e-6 && intervals > 0.5, "map.spacing_m",
            "must divide length_m into whole intervals");
  if (c.has("trials"))
    c.integer("trials", 0, 1'000'000'000'000,
              config::meaning::kUnusedTrials);  // any config may have it; nothing is drawn here
  c.finish();
  return s;
}

std::vector<store::Axis> axes_of(const Scenario& s) {
  return {{"error_model", "", "error model of the survey tool", s.names},
          {"inclination", "deg", "inclination of the hole", s.inclinations_deg},
          {"azimuth", "deg", "azimuth of the hole, true north", s.azimuths_deg}};
}

survey::Survey straight_hole(const Scenario& s, double inclination, double azimuth) {
  survey::Survey hole;
  const auto intervals = static_cast<int>(std::lround(s.length / s.spacing));
  for (int k = 0; k <= intervals; ++k) hole.stations.push_back({s.spacing * k, inclination, azimuth, 0});
  return hole;
}

/// Of the values of one model at which it holds.
struct Spread {
  std::size_t cells = 0, inside = 0, without_covariance = 0;
  std::vector<double> lateral;
};

class ToolCodeMap final : public study::StudyPoint {
 public:
  explicit ToolCodeMap(Scenario scenario) : s_(std::move(scenario)) {}

  study::PointResult report(const stats::Tally&, const montecarlo::RunOptions& options) const override {
    const std::vector<store::Axis> axes = axes_of(s_);
    const std::size_t cells = s_.inclinations_deg.size() * s_.azimuths_deg.size(), all = s_.models.size() * cells;
    const auto map = [&](const char* name, const char* unit, const char* meaning) {
      return store::Map{name, unit, meaning, axes, std::vector<double>(all)};
    };
    study::PointResult r;
    r.maps = {map("sd_high_side_m", "m", "one standard deviation at the end of a straight hole, high side"),
              map("sd_lateral_m", "m", "one standard deviation at the end of a straight hole, lateral"),
              map("sd_along_hole_m", "m", "one standard deviation at the end of a straight hole, along it"),
              map("inside_range", "1", "1 where the model claims to hold, else 0")};
    std::vector<Spread> spreads(s_.models.size());
    for (std::size_t cell = 0; cell < cells; ++cell) {
      if (options.stop && *options.stop) throw Interrupted("stopped");
      const double inclination = s_.inclinations_deg[cell / s_.azimuths_deg.size()] * kDegree,
                   azimuth = s_.azimuths_deg[cell % s_.azimuths_deg.size()] * kDegree;
      const survey::Survey hole = straight_hole(s_, inclination, azimuth);
      const std::vector<double> tvd = survey::true_vertical_depths(hole);
      const Eigen::Matrix3d to_hla = survey::rotation_hla_from_nev(inclination, azimuth);
      for (std::size_t m = 0; m < s_.models.size(); ++m) {
        const auto covariances = propagate::tool_covariances(hole, tvd, {{1, s_.models[m]}}, s_.field, s_.latitude,
                                                             propagate::SourceDetail::none);
        const Eigen::Matrix3d hla = to_hla * covariances.total.back() * to_hla.transpose();
        const std::size_t at = m * cells + cell;
        for (int axis = 0; axis < 3; ++axis) {
          const double variance = hla(axis, axis);  // NaN stays
          r.maps[static_cast<std::size_t>(axis)].values[at] = std::sqrt(variance < 0 ? 0 : variance);
        }
        const bool holds = propagate::holds_at(*s_.models[m], inclination, azimuth - s_.field.declination);
        r.maps[3].values[at] = holds ? 1 : 0;
        Spread& spread = spreads[m];
        ++spread.cells;
        spread.inside += holds;
        spread.without_covariance += std::isnan(hla(1, 1));
        if (holds && !std::isnan(hla(1, 1))) spread.lateral.push_back(r.maps[1].values[at]);
      }
    }
    r.tables = {summary(spreads)};
    return r;
  }

 private:
  store::Table summary(std::vector<Spread>& spreads) const {
    compare::TableRows t("summary", "the maps by error model; lateral standard deviations where the model holds");
    for (std::size_t m = 0; m < spreads.size(); ++m) {
      Spread& x = spreads[m];
      std::sort(x.lateral.begin(), x.lateral.end());
      const error_model::Model& model = *s_.models[m];
      t.word("error_model", "of the survey tool", s_.names[m]);
      t.word("title", "of the model", model.title);
      t.count("terms", "number of error sources", model.terms.size());
      t.count("cells", "holes", x.cells);
      t.count("inside_range", "holes for which the model claims to hold", x.inside);
      t.count("without_covariance", "holes at which a term has no finite effect", x.without_covariance);
      t.number("sd_lateral_least_m", "m", "one standard deviation", x.lateral.empty() ? kNaN : x.lateral.front());
      t.number("sd_lateral_median_m", "m", "one standard deviation",
               x.lateral.empty() ? kNaN : stats::median(x.lateral));
      t.number("sd_lateral_largest_m", "m", "one standard deviation", x.lateral.empty() ? kNaN : x.lateral.back());
      t.word("note", "what the model's author says", model.note);
    }
    return t.take();
  }

  Scenario s_;
};

class ToolCodeMapPlan final : public study::PlanOfPoint<Scenario, ToolCodeMap> {
 public:
  using PlanOfPoint::PlanOfPoint;
  std::vector<store::Axis> map_axes() const override { return axes_of(s_); }
  /// The codes that patterns chose.
  std::string details() const override {
    std::string out;
    for (std::size_t m = 0; m < s_.names.size(); ++m)
      out += fmt::format("{}: {} ({} terms)\n", s_.names[m], s_.models[m]->title, s_.models[m]->terms.size());
    return out;
  }
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::tool_code_map,
          "Maps of what survey tools are claimed to be worth, over inclination and azimuth",
          "OWSG tool codes, sets A and B", study::plan_of<ToolCodeMapPlan, read_scenario>};
}

}  // namespace surveymc::studies::tool_code_map
