#include "msa_benefit/parameter_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "analysis/multistation_prediction.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "msa_benefit/scenario.h"
#include "scenario/reference_field.h"
#include "scenario/scenario.h"
#include "scenario/well_design.h"
#include "stats/order_statistics.h"

namespace surveymc::studies::msa_benefit {

namespace {

/// What one cell of the maps says.
struct Cell {
  double rank = 0, learnt = 0, condition_index = 0;
  std::array<double, 2> before{}, after{};  ///< azimuth (deg), lateral (m)
  analysis::RobustLimits limits;
  double ratio(std::size_t quantity) const { return after[quantity] / before[quantity]; }
};

class SetMapPoint final : public study::StudyPoint {
 public:
  explicit SetMapPoint(const SetMapScenario& s) : s_(s), cost_(s.estimator.cost()) {}

  study::PointResult report(const stats::Tally&, const montecarlo::RunOptions& options) const override {
    std::vector<Cell> cells;
    for (const double inclination : s_.inclination_deg) {
      if (options.stop && *options.stop) throw Interrupted("stopped before all maps were made");
      for (const double azimuth : s_.azimuth_deg) cells.push_back(cell(inclination, azimuth));
    }
    study::PointResult r;
    r.maps = maps(cells);
    r.tables = {summary(cells)};
    analysis::RobustLimits limits;
    for (const Cell& c : cells) limits = analysis::worse_of(limits, c.limits);
    if (const auto warnings = scenario::warn_of_limits(limits); !warnings.empty())
      r.tables.push_back(compare::warnings_table(warnings));
    return r;
  }

 private:
  Cell cell(double inclination_deg, double azimuth_deg) const {
    const survey::Survey well = benefit_well(s_.well, inclination_deg, azimuth_deg);
    analysis::MultistationRun run = analysis::multistation_run(well, s_.field);
    run.tool = s_.sizes.tool;
    run.tool_sd = s_.sizes.tool_sd;
    run.accelerometer = s_.sizes.accelerometer;
    run.magnetometer = s_.sizes.magnetometer;
    run.reference = s_.sizes.reference;
    run.reference_per_station = s_.sizes.reference_per_station;
    const analysis::MultistationPrediction p = analysis::predict_multistation(run, s_.estimator.fit, cost_);
    const survey::Station& last = well.stations.back();
    const Eigen::RowVector3d lateral = survey::rotation_hla_from_nev(last.inclination, last.azimuth).row(1);
    const auto sd = [&](const Eigen::Matrix3d& c) { return std::sqrt((lateral * c * lateral.transpose()).value()); };
    Cell c{static_cast<double>(p.observability.rank),
           static_cast<double>(p.observability.learnt),
           p.observability.combinations.condition_indices[0],
           {p.uncorrected_azimuth_sd / kDegree, sd(p.uncorrected_covariance)},
           {p.azimuth_sd / kDegree, sd(p.position_covariance)},
           p.limits};
    // Noise of the accelerometers turns a vertical hole to any azimuth.
    if (s_.sizes.accelerometer > 0 && is_vertical(inclination_deg)) c.before[0] = c.after[0] = kNaN;
    return c;
  }

  std::vector<store::Map> maps(const std::vector<Cell>& cells) const {
    const std::vector<store::Axis> axes{
        {"inclination", "deg", "inclination of the last station", s_.inclination_deg},
        {"azimuth", "deg", "azimuth of the last station, from true north", s_.azimuth_deg}};
    std::vector<store::Map> out;
    const auto add = [&](const std::string& name, const std::string& unit, const std::string& meaning,
                         const std::function<double(const Cell&)>& value) {
      store::Map m{name, unit, meaning, axes, {}};
      for (const Cell& c : cells) m.values.push_back(value(c));
      out.push_back(std::move(m));
    };
    add("rank", "1", "combinations of parameters that have an effect: condition index below 1e6",
        [](const Cell& c) { return c.rank; });
    add("learnt", "1", "combinations of parameters that the run knows better than the priors do",
        [](const Cell& c) { return c.learnt; });
    add("condition_index", "1", "of the weakest combination; inf: without effect",
        [](const Cell& c) { return c.condition_index; });
    const std::array<std::string, 2> meaning{"azimuth of the last station", "last position to the side of the hole"};
    for (std::size_t q = 0; q < 2; ++q) {
      const std::string name = kBenefits[q], unit = kBenefitUnits[q];
      add(name + "_ratio", "1", meaning[q] + ": sd after the correction over sd before",
          [q](const Cell& c) { return c.ratio(q); });
      add(name + "_sd_before_" + unit, unit, meaning[q] + ": sd of the readings as they are",
          [q](const Cell& c) { return c.before[q]; });
      add(name + "_sd_after_" + unit, unit, meaning[q] + ": sd after the correction",
          [q](const Cell& c) { return c.after[q]; });
    }
    return out;
  }

  store::Table summary(const std::vector<Cell>& cells) const {
    std::vector<double> ratio;
    std::int64_t worse = 0, full = 0;
    double fewest = kInfinity, most = 0;
    for (const Cell& c : cells) {
      ratio.push_back(c.ratio(1));
      worse += ratio.back() > 1.01;
      full += c.rank == s_.estimator.fit.parameters.size();
      fewest = std::min(fewest, c.learnt);
      most = std::max(most, c.learnt);
    }
    compare::TableRows t("summary", "what a run tells of the parameters, over all directions of the map");
    t.word("parameters", "that are estimated", s_.estimator.fit.parameters.name());
    t.count("size", "of the set", s_.estimator.fit.parameters.size());
    t.count("directions", "of the map", cells.size());
    t.count("full_rank", "directions in which every combination has an effect", full);
    t.number("learnt_least", "1", "fewest combinations that the run knows better than the priors do", fewest);
    t.number("learnt_most", "1", "most of them", most);
    t.number("worse_share", "1", "share of the directions whose lateral is worse after the correction, by over 1 %",
             static_cast<double>(worse) / static_cast<double>(cells.size()));
    t.number("ratio_median", "1", "median of the lateral's sd after over before", stats::median(ratio));
    t.number("ratio_worst", "1", "largest of it", *std::max_element(ratio.begin(), ratio.end()));
    return t.take();
  }

  SetMapScenario s_;
  multistation::LossCost cost_;
};

class SetMapPlan final : public study::PlanOf<SetMapScenario> {
 public:
  using PlanOf::PlanOf;
  double cost() const override {
    return 20.0 * s_.well.stations * static_cast<double>(s_.inclination_deg.size() * s_.azimuth_deg.size());
  }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    return std::make_unique<SetMapPoint>(s_);
  }
};

}  // namespace

std::optional<SetMapScenario> read_set_maps(config::ConfigReader& c, random::StudySeed seed) {
  if (!scenario::wants_parameter_set(c)) return std::nullopt;
  scenario::refuse_beside_parameters(
      c, {"prediction", "calibration", "estimator.estimated", "trials", "tails", "reference_law", "disturbance.kind"});
  SetMapScenario s;
  s.field = scenario::read_field(c);
  const sensor::NoiseModel noise = scenario::read_noise(c);
  s.sizes = scenario::multistation_sizes(c, noise);
  s.estimator = scenario::read_parameter_set(c, {noise.accelerometer, noise.magnetometer, s.sizes.reference}, s.field);
  s.sizes.tool_sd = scenario::read_tool_sd(c, s.estimator.fit);
  s.inclination_deg = c.grid("inclination_deg", config::Range::closed(0, 180), config::kMeaningElsewhere);
  s.azimuth_deg = c.grid("azimuth_deg", config::Range::closed(0, 360), config::kMeaningElsewhere);
  s.well = scenario::read_well_design(c, seed);
  c.require(!c.has("verify"), "verify", "maps of estimator.parameters have no trials: msa_position has them");
  c.finish();
  return s;
}

std::unique_ptr<study::PointPlan> set_map_plan(SetMapScenario scenario) {
  return std::make_unique<SetMapPlan>(std::move(scenario));
}

}  // namespace surveymc::studies::msa_benefit
