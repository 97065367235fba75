/// Study: the reliability of every reading of one well, and what an undetected gross error does to its final position.
/// Goes beyond Nyrnes, Torkildsen, Nahavandchi, who stop at the attitude of a single station. No random numbers.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/error.h"
#include "experiments.h"
#include "reliability/along_well.h"
#include "reliability_config.h"
#include "study/scenario.h"
#include "study/table_rows.h"

namespace surveymc {
namespace {

struct Scenario {
  AdjustmentModel model;
  double lambda0 = 0;
  std::vector<std::size_t> observations;
  Survey survey;
  bool worst_toolface = false;
  std::int64_t listed = 5;
};

Scenario read_scenario(ConfigReader& c) {
  Scenario s;
  c.integer("trials", 0, 1'000'000'000'000, 0);
  s.model = read_adjustment_model(c);
  s.model.field.dip = c.number("field.dip_deg", Range::closed(-89, 89), 75) * kDegree;
  s.model.field.convergence = c.number("field.convergence_deg", Range::closed(-180, 180), 0) * kDegree;
  s.lambda0 = lambda0(read_test_levels(c));
  s.observations = read_observations(c, s.model.mode);
  s.worst_toolface = c.choice("toolface", {"survey", "worst"}, "survey") == "worst";
  s.listed = c.integer("listed", 1, 1000, 5);
  s.survey = read_survey(c, s.model.field, !s.worst_toolface);
  c.finish();
  return s;
}

/// An effect, and the toolface at which it was found.
struct Found {
  StationEffect effect;
  double toolface = 0;
};

class ReliabilityWellPoint final : public StudyPoint {
 public:
  explicit ReliabilityWellPoint(Scenario scenario) : s_(std::move(scenario)) {}

  PointResult report(const Tally&, const RunOptions& options) const override {
    std::vector<std::vector<Found>> found(s_.observations.size());  // [observation][station]
    WellReliability well;
    std::vector<double> toolfaces = {std::nan("")};
    if (s_.worst_toolface) {
      toolfaces.clear();
      for (int t = 0; t < 180; t += 5) toolfaces.push_back(t * kDegree);  // tau + 180 is the same up to a sign
    }
    for (const double toolface : toolfaces) {
      if (options.stop && *options.stop) throw Interrupted("stopped before all toolfaces were tried");
      Survey survey = s_.survey;
      if (s_.worst_toolface)
        for (Station& station : survey.stations) station.toolface = toolface;
      well = reliability_along_well(s_.model, survey, s_.lambda0);
      for (std::size_t o = 0; o < s_.observations.size(); ++o) {
        found[o].resize(survey.stations.size());
        for (std::size_t k = 0; k < survey.stations.size(); ++k) {
          const StationEffect& e = effect_of(well, s_.observations[o], k);
          Found& f = found[o][k];
          if (&toolface == &toolfaces.front() || !(e.position.norm() <= f.effect.position.norm()))
            f = {e, survey.stations[k].toolface};
        }
      }
    }
    PointResult r;
    r.tables = {worst_table(found)};
    if (!s_.worst_toolface) r.tables.push_back(systematic_table(well));
    r.tables.push_back(stations_table(found));
    return r;
  }

 private:
  bool is_shared_reference(std::size_t observation) const {
    return s_.model.mode == AdjustmentMode::mse_shared && observation >= kReadings;
  }
  const StationEffect& effect_of(const WellReliability& well, std::size_t observation, std::size_t station) const {
    return is_shared_reference(observation) ? well.references[observation - kReadings]
                                            : well.stations[station][observation];
  }

  static void write_position(TableRows& t, const std::string& effect, const Eigen::Vector3d& position) {
    t.number("position_north_m", "m", effect + ", north", position[0]);
    t.number("position_east_m", "m", effect + ", east", position[1]);
    t.number("position_vertical_m", "m", effect + ", down", position[2]);
    t.number("position_m", "m", "length of that", position.norm());
  }

  void put(TableRows& t, std::size_t observation, std::size_t station, const Found& f) const {
    const bool common = is_shared_reference(observation);
    const StationEffect& e = f.effect;
    const auto of_station = [&](double x) { return common ? std::nan("") : x; };
    t.word("observation", "in which the error is", observation_names()[observation]);
    t.count("station", "number of the station, from 0; -1: an error of all stations",
            common ? std::int64_t{-1} : static_cast<std::int64_t>(station));
    t.number("md_m", "m", "measured depth", of_station(s_.survey.stations[station].md));
    t.number("toolface_deg", "deg", "toolface from y, of the survey or the worst one",
             of_station(f.toolface / kDegree));
    t.word("unit", "of the minimal detectable error", observation_unit(observation));
    t.number("redundancy_number", "1", "redundancy number", e.redundancy);
    t.number("minimal_detectable_error", "1", "minimal detectable error nabla_0, in the row's unit",
             e.detectable * observation_scale(observation));
    t.number("external_inclination_deg", "deg", "effect of +nabla_0 on the station's inclination",
             of_station(e.inclination / kDegree));
    t.number("external_toolface_deg", "deg", "effect of +nabla_0 on the station's toolface",
             of_station(e.toolface / kDegree));
    t.number("external_azimuth_deg", "deg", "effect of +nabla_0 on the station's azimuth",
             of_station(e.azimuth / kDegree));
    write_position(t, "effect of +nabla_0 on the final position", e.position);
  }

  Table stations_table(const std::vector<std::vector<Found>>& found) const {
    TableRows t("stations", "every observation of every station");
    for (std::size_t o = 0; o < s_.observations.size(); ++o)
      for (std::size_t k = 0; k < found[o].size(); ++k)
        if (k == 0 || !is_shared_reference(s_.observations[o])) put(t, s_.observations[o], k, found[o][k]);
    return t.take();
  }

  Table worst_table(const std::vector<std::vector<Found>>& found) const {
    TableRows t("worst_stations", "stations where an undetected error matters most to the final position");
    for (std::size_t o = 0; o < s_.observations.size(); ++o) {
      std::vector<std::size_t> order(is_shared_reference(s_.observations[o]) ? 1 : found[o].size());
      for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
      std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return found[o][a].effect.position.norm() > found[o][b].effect.position.norm();
      });
      order.resize(std::min(order.size(), static_cast<std::size_t>(s_.listed)));
      for (const std::size_t k : order) put(t, s_.observations[o], k, found[o][k]);
    }
    return t.take();
  }

  Table systematic_table(const WellReliability& well) const {
    TableRows t("systematic", "the same error in one sensor at all stations, which the model does not know");
    const bool none = std::none_of(s_.observations.begin(), s_.observations.end(),
                                   [](std::size_t o) { return o < kReadings; });  // all are references
    for (const std::size_t o : none ? std::vector<std::size_t>{0} : s_.observations) {
      if (o >= kReadings) continue;
      const CommonEffect& e = well.common[o];
      t.word("observation", "in which the error is", observation_names()[o]);
      t.word("unit", "of the minimal detectable error", observation_unit(o));
      t.number("minimal_detectable_error", "1", "minimal detectable common error, in the row's unit", e.detectable);
      write_position(t, "its effect on the final position", e.position);
    }
    if (none) t.drop_rows();
    return t.take();
  }

  Scenario s_;
};

class ReliabilityWellPlan final : public PointPlan {
 public:
  explicit ReliabilityWellPlan(Scenario scenario) : s_(std::move(scenario)) {}
  std::unique_ptr<StudyPoint> prepare(const RunOptions&) const override {
    return std::make_unique<ReliabilityWellPoint>(s_);
  }

 private:
  Scenario s_;
};

}  // namespace

Experiment reliability_well_experiment() {
  return {StudyId::reliability_well,
          "Gross errors along a well: minimal detectable errors, effect on the final position",
          "beyond E. Nyrnes, T. Torkildsen, H. Nahavandchi, Kart og Plan 65",
          [](ConfigReader& config, StudySeed) -> std::unique_ptr<PointPlan> {
            return std::make_unique<ReliabilityWellPlan>(read_scenario(config));
          }};
}

}  // namespace surveymc
