/// Study: how large a gross error may pass the tests undetected, and its effect on the attitude, over a grid of
/// attitudes. Source: Nyrnes, Torkildsen, Nahavandchi, Kart og Plan 65, figures 1-6. No random numbers.
///
///   model, grid -> layers (layers.h) -> maps, table `summary`, published statements
///
/// Maps of more than one piece are streams, computed while they are written, unless they are slow to compute or needed
/// whole (tolerances, statements).
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "compare/table_rows.h"
#include "config/meanings.h"
#include "config/suggest.h"
#include "reliability/layers.h"
#include "reliability/responses.h"
#include "reliability/scenario.h"
#include "reliability/summary.h"
#include "scenario/adjustment_scenario.h"
#include "study/experiment.h"

namespace surveymc::studies::reliability {
namespace {

constexpr std::size_t kMostHeld = std::size_t{1} << 22;  // points of a map that may be needed whole: 32 MB each
constexpr std::size_t kMostSlow = std::size_t{1} << 20;  // points of maps at microseconds a point and more
constexpr double kMostPoints = 1e12;

struct Tolerance {
  bool given = false;
  double inclination_deg = 0.1, azimuth_deg = 1;
};

struct Scenario {
  LayerModel layer_model;
  ReliabilityGrid grid;
  std::vector<ErrorSubject> subjects;
  std::vector<std::string> layers;
  std::vector<Statement> statements;
  Tolerance tolerance;
};

std::vector<std::string> read_layers(config::ConfigReader& c, const LayerModel& m, const ErrorSubject& subject) {
  if (!c.has("maps")) return default_layers(m, subject);
  const std::vector<std::string> known = layer_names(m, subject);
  std::vector<std::string> layers =
      c.texts("maps",
              "maps that are made; without it redundancy number, minimal detectable error and its effects on the "
              "angles, and with a gross error or `weakest_of` those that go with it");
  for (const std::string& l : layers) {
    const bool there = std::find(known.begin(), known.end(), l) != known.end();
    c.require(there || subject.combined() || has_gross_error(m) || !is_response_layer(l), "maps",
              l + " needs the size of the error: gross_error_" + subject_unit(subject));
    c.require(there, "maps", config::none_of(l, known));
    c.require(std::count(layers.begin(), layers.end(), l) == 1, "maps", l + " is in the list twice");
  }
  return layers;
}

Scenario read_scenario(config::ConfigReader& c) {
  Scenario s;
  c.integer("trials", 0, 1'000'000'000'000, config::meaning::kUnusedTrials,
            0);  // as every config may have; nothing is drawn here
  s.layer_model.model = scenario::read_adjustment_model(c);
  const TestLevels levels = scenario::read_test_levels(c);
  s.layer_model.lambda0 = lambda0(levels);
  s.layer_model.power = levels.power;
  s.subjects = read_subjects(c, s.layer_model.model.mode);
  s.layer_model.gross_error = read_gross_error(c, s.subjects);
  s.grid = read_grid(c, s.layer_model.model.field.dip);
  s.layers = read_layers(c, s.layer_model, s.subjects.front());
  double points = static_cast<double>(s.subjects.size());
  for (const auto* axis : {&s.grid.noise_scale, &s.grid.dip_deg, &s.grid.inclination_deg, &s.grid.toolface_deg,
                           &s.grid.magnetic_azimuth_deg})
    points *= static_cast<double>(axis->size());
  c.require(points <= kMostPoints, "inclination_deg",
            fmt::format("{:.3g} points in all: at most {:g}", points, kMostPoints));
  const auto slow = std::find_if(s.layers.begin(), s.layers.end(), is_slow_layer);
  c.require(slow == s.layers.end() || points <= static_cast<double>(kMostSlow), "maps",
            slow == s.layers.end() ? "" : fmt::format("{} takes a grid of at most {} points", *slow, kMostSlow));
  if (c.has("tolerance")) {
    s.tolerance = {true,
                   c.number("tolerance.inclination_deg", config::Range::positive(),
                            "largest effect on the inclination that is accepted, in the table `tolerance`", 0.1),
                   c.number("tolerance.azimuth_deg", config::Range::positive(),
                            "largest effect on the azimuth that is accepted, in the table `tolerance`", 1)};
    c.require(points <= static_cast<double>(kMostHeld), "tolerance", "takes a grid that fits into memory");
  }
  if (c.has("statement")) {
    c.require(points <= static_cast<double>(kMostHeld), "statement", "takes a grid that fits into memory");
    s.statements = read_statements(c, s.grid, s.subjects, s.layers);
  }
  c.finish();
  return s;
}

std::vector<store::Axis> axes_of(const Scenario& s) {
  std::vector<store::Axis> axes;
  if (s.subjects.size() > 1) {
    std::vector<std::string> names;
    for (const ErrorSubject& subject : s.subjects) names.push_back(subject_name(subject));
    axes.push_back({"observation", "", "observation in which the error is", names});
  }
  const ReliabilityGrid& g = s.grid;
  if (g.noise_scale.size() > 1) axes.push_back({"noise_scale", "1", "factor on the sd of the noise", g.noise_scale});
  if (g.dip_deg.size() > 1) axes.push_back({"dip", "deg", "dip of the field, positive down", g.dip_deg});
  axes.push_back({"inclination", "deg", "inclination", g.inclination_deg});
  axes.push_back({"toolface", "deg", "toolface from the y axis (tau of the paper)", g.toolface_deg});
  axes.push_back({"magnetic_azimuth", "deg", "magnetic azimuth", g.magnetic_azimuth_deg});
  return axes;
}

class ReliabilityMapPoint final : public study::StudyPoint {
 public:
  /// `scenario` with its layer_model.maps.
  explicit ReliabilityMapPoint(Scenario scenario) : s_(std::move(scenario)), axes_(axes_of(s_)) {}

  study::PointResult report(const stats::Tally&, const montecarlo::RunOptions& options) const override {
    study::PointResult r;
    const std::size_t points = s_.grid.points(), all = points * s_.subjects.size();
    const bool slow = std::any_of(s_.layers.begin(), s_.layers.end(), is_slow_layer);
    const bool needed_whole = s_.tolerance.given || !s_.statements.empty();
    if (all > kMostHeld || (all > store::kStreamPiece && !slow && !needed_whole)) {
      const LayerSource source = [&](std::size_t o, std::size_t first, std::size_t count) {
        return std::move(layer_values(s_.layer_model, {s_.subjects[o]}, s_.layers, first, count)[0]);
      };
      r.tables.push_back(summary_table(s_.grid, s_.subjects, s_.layers, source, all <= kMostHeld, options));
      r.streams.push_back(stream());
      return r;
    }

    // [observation][layer][point], in pieces so that a signal is heard
    std::vector<std::vector<std::vector<double>>> held(s_.subjects.size(),
                                                       std::vector<std::vector<double>>(s_.layers.size()));
    const std::size_t piece = slow ? 256 : store::kStreamPiece;
    for (std::size_t at = 0; at < points; at += piece) {
      if (options.stop && *options.stop) throw Interrupted("stopped before all maps were made");
      const auto part = layer_values(s_.layer_model, s_.subjects, s_.layers, at, std::min(piece, points - at));
      for (std::size_t o = 0; o < held.size(); ++o)
        for (std::size_t l = 0; l < s_.layers.size(); ++l)
          held[o][l].insert(held[o][l].end(), part[o][l].begin(), part[o][l].end());
    }
    const LayerSource source = [&](std::size_t o, std::size_t first, std::size_t count) {
      std::vector<std::vector<double>> part;
      for (const auto& values : held[o])
        part.emplace_back(values.begin() + static_cast<std::ptrdiff_t>(first),
                          values.begin() + static_cast<std::ptrdiff_t>(first + count));
      return part;
    };
    r.tables.push_back(summary_table(s_.grid, s_.subjects, s_.layers, source, true, options));
    if (!s_.statements.empty())
      r.tables.push_back(statements_table(s_.grid, s_.subjects, s_.layers, s_.statements, source));
    r.maps = empty_maps();
    for (std::size_t l = 0; l < s_.layers.size(); ++l)
      for (auto& of_observation : held)
        r.maps[l].values.insert(r.maps[l].values.end(), of_observation[l].begin(), of_observation[l].end());
    if (s_.tolerance.given) add_tolerance(r);
    return r;
  }

 private:
  std::string unit_of(const std::string& layer) const {
    const std::string first = layer_unit(layer, s_.subjects.front());
    for (const ErrorSubject& s : s_.subjects)
      if (layer_unit(layer, s) != first) return "mixed";
    return first;
  }

  std::vector<store::Map> empty_maps() const {
    std::vector<store::Map> maps;
    for (const std::string& l : s_.layers) maps.push_back({l, unit_of(l), layer_meaning(l), axes_, {}});
    return maps;
  }

  store::MapStream stream() const {
    return {empty_maps(), [this](std::size_t first, std::size_t count) {
              const std::size_t points = s_.grid.points();
              std::vector<std::vector<double>> out(s_.layers.size());
              while (count > 0) {  // observations are the slowest axis
                const std::size_t at = first % points, n = std::min(count, points - at);
                auto part = std::move(layer_values(s_.layer_model, {s_.subjects[first / points]}, s_.layers, at, n)[0]);
                for (std::size_t l = 0; l < out.size(); ++l) {
                  if (out[l].empty())
                    out[l] = std::move(part[l]);
                  else
                    out[l].insert(out[l].end(), part[l].begin(), part[l].end());
                }
                first += n;
                count -= n;
              }
              return out;
            }};
  }

  /// The toolface of the tool is not known beforehand. So this adds maps without the axis toolface: the worst toolface,
  /// and the share of the grid's toolfaces whose undetected error stays within the tolerances; and a table over all
  /// points.
  void add_tolerance(study::PointResult& r) const {
    store::Map worst{
        "worst_toolface_external_azimuth_deg", "deg", "largest |external_azimuth_deg| over the toolfaces", axes_, {}};
    store::Map share{
        "share_of_toolfaces_within_tolerance",
        "1",
        fmt::format("share of the toolfaces whose +nabla_0 turns the azimuth by at most {:g} deg and the inclination "
                    "by at most {:g} deg",
                    s_.tolerance.azimuth_deg, s_.tolerance.inclination_deg),
        axes_,
        {}};
    for (store::Map* m : {&worst, &share})
      std::erase_if(m->axes, [](const store::Axis& a) { return a.name == "toolface"; });
    compare::TableRows t("tolerance", "share of the points whose undetected errors stay within the tolerances");
    const std::size_t azimuths = s_.grid.magnetic_azimuth_deg.size(), toolfaces = s_.grid.toolface_deg.size(),
                      points = s_.grid.points();
    for (const ErrorSubject& subject : s_.subjects) {
      const auto effect =
          layer_values(s_.layer_model, {subject}, {"external_inclination_deg", "external_azimuth_deg"}, 0, points)[0];
      const auto within = [&](std::size_t k) {
        return std::pair{std::abs(effect[0][k]) <= s_.tolerance.inclination_deg,
                         std::abs(effect[1][k]) <= s_.tolerance.azimuth_deg};
      };
      double inclination = 0, azimuth = 0, both = 0;
      for (std::size_t outer = 0; outer < points / (azimuths * toolfaces); ++outer)
        for (std::size_t a = 0; a < azimuths; ++a) {
          double largest = 0, kept = 0;
          for (std::size_t toolface = 0; toolface < toolfaces; ++toolface) {
            const std::size_t k = (outer * toolfaces + toolface) * azimuths + a;
            const auto [i_ok, a_ok] = within(k);
            inclination += i_ok;
            azimuth += a_ok;
            kept += i_ok && a_ok;
            largest = std::max(largest, std::abs(effect[1][k]));
          }
          both += kept;
          worst.values.push_back(largest);
          share.values.push_back(kept / static_cast<double>(toolfaces));
        }
      const double all = static_cast<double>(points);
      t.word("observation", "in which the error is", subject_name(subject));
      t.number("tolerance_inclination_deg", "deg", "largest effect on the inclination that is accepted",
               s_.tolerance.inclination_deg);
      t.number("tolerance_azimuth_deg", "deg", "largest effect on the azimuth that is accepted",
               s_.tolerance.azimuth_deg);
      t.number("share_inclination", "1", "share of points within, inclination", inclination / all);
      t.number("share_azimuth", "1", "share of points within, azimuth", azimuth / all);
      t.number("share_both", "1", "share of points within, both", both / all);
    }
    r.tables.push_back(t.take());
    r.maps.push_back(std::move(worst));
    r.maps.push_back(std::move(share));
  }

  Scenario s_;
  std::vector<store::Axis> axes_;
};

class ReliabilityMapPlan final : public study::PlanOf<Scenario> {
 public:
  using PlanOf::PlanOf;
  std::vector<store::Axis> map_axes() const override { return axes_of(s_); }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    Scenario s = s_;
    s.layer_model.maps = std::make_shared<ReliabilityMaps>(s.layer_model.model, s.grid, s.layer_model.lambda0);
    return std::make_unique<ReliabilityMapPoint>(std::move(s));
  }
};

}  // namespace

study::Experiment map_experiment() {
  return {random::StudyId::reliability_map,
          "Gross errors: minimal detectable errors and their effect, over a grid of attitudes",
          "E. Nyrnes, T. Torkildsen, H. Nahavandchi, Kart og Plan 65, figures 1 to 6",
          study::plan_of<ReliabilityMapPlan, read_scenario>};
}

}  // namespace surveymc::studies::reliability
