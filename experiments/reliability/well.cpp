/// Study: the reliability of every reading of one well, and the effect of an undetected gross error on the final
/// position. It goes beyond Nyrnes, Torkildsen, Nahavandchi, who treat the attitude of a single station. No random
/// numbers.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "base/error.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "config/meanings.h"
#include "reliability/along_well.h"
#include "reliability/scenario.h"
#include "scenario/adjustment_scenario.h"
#include "scenario/drilling.h"
#include "scenario/scenario.h"
#include "study/experiment.h"

namespace surveymc::studies::reliability {
namespace {

struct WellScenario {
  AdjustmentModel model;
  double lambda0 = 0;
  std::vector<std::size_t> observations;
  survey::Survey survey;
  bool worst_toolface = false;
  DetectedBy test = DetectedBy::general_test;
  std::int64_t listed = 5;
};

WellScenario read_well_scenario(config::ConfigReader& c, random::StudySeed seed) {
  WellScenario s;
  c.integer("trials", 0, 1'000'000'000'000, config::meaning::kUnusedTrials, 0);
  const bool stations_given = c.has("stations");
  s.model = scenario::read_adjustment_model(c);
  s.model.field.dip = scenario::read_dip(c, s.model);
  if (!c.has("field.model")) s.model.field.convergence = scenario::read_convergence(c);
  s.lambda0 = lambda0(scenario::read_test_levels(c));
  s.observations = read_observations(c, s.model.mode);
  s.worst_toolface =
      c.choice(
          "toolface", {"survey", "worst"},
          "'survey': toolfaces of the survey; 'worst': of all toolfaces the one at which the error moves the end most",
          "survey") == "worst";
  s.test = c.choice("detected_by", {"general", "own"},
                    "the test that finds the error: the general one, or the reading's own", "general") == "own"
               ? DetectedBy::own_test
               : DetectedBy::general_test;
  s.listed = c.integer("listed", 1, 1000, "stations in the table `worst_stations`", 5);
  s.survey = s.worst_toolface ? scenario::read_survey(c, s.model.field, false)
                              : scenario::read_drilled_survey(c, s.model.field, seed);
  if (stations_given)
    c.require(static_cast<std::size_t>(s.model.stations) == s.survey.stations.size(), "stations",
              fmt::format("the survey has {}; leave it out, or give this number", s.survey.stations.size()));
  c.finish();
  return s;
}

/// An error that is just found, its toolface, and the result of linear theory at this toolface.
struct Found {
  FoundError error;
  StationEffect linear;
  double toolface = 0;
  bool is_linear = false;  ///< a reference that all stations share: by linear theory alone

  double moves() const { return is_linear ? linear.position.norm() : error.position.norm(); }
  double size() const { return is_linear ? linear.detectable : error.size; }
};

/// Larger by more than 20 %, either way.
bool differ(double a, double b) {
  if (std::isinf(a) && std::isinf(b)) return false;
  return !(std::abs(a) <= 1.2 * std::abs(b) && std::abs(b) <= 1.2 * std::abs(a));
}

/// The same of distances, m; those below a nanometre are rounding.
bool positions_differ(double a, double b) {
  constexpr double kRounding = 1e-9;
  return std::max(a, b) > kRounding && differ(a, b);
}

/// The maximum of f between two toolfaces by golden section, to 0.001 degrees: f has one there, or the better of what
/// was tried is kept.
template <class F>
void search_between(double lo, double hi, const F& f) {
  constexpr double kGolden = 0.6180339887498949;
  double a = hi - kGolden * (hi - lo), b = lo + kGolden * (hi - lo), of_a = f(a), of_b = f(b);
  while (hi - lo > 1e-3 * kDegree) {
    if (of_a > of_b) {
      hi = b;
      b = a;
      of_b = of_a;
      a = hi - kGolden * (hi - lo);
      of_a = f(a);
    } else {
      lo = a;
      a = b;
      of_a = of_b;
      b = lo + kGolden * (hi - lo);
      of_b = f(b);
    }
  }
}

class ReliabilityWellPoint final : public study::StudyPoint {
 public:
  explicit ReliabilityWellPoint(WellScenario scenario) : s_(std::move(scenario)) {}

  study::PointResult report(const stats::Tally&, const montecarlo::RunOptions& options) const override {
    const auto check = [&] {
      if (options.stop && *options.stop) throw Interrupted("stopped before all stations were tried");
    };
    std::vector<std::vector<Found>> found(s_.observations.size());  // [observation][station]
    for (auto& of_observation : found) of_observation.resize(s_.survey.stations.size());
    const WellReliability as_surveyed =
        s_.worst_toolface ? WellReliability{} : reliability_along_well(s_.model, s_.survey, s_.lambda0);
    if (!s_.worst_toolface) {
      const WellErrors errors(s_.model, s_.survey, s_.lambda0, s_.test);
      for (std::size_t k = 0; k < s_.survey.stations.size(); ++k) {
        check();
        for (std::size_t o = 0; o < s_.observations.size(); ++o)
          if (!is_shared_reference(s_.observations[o]))
            keep_larger(found[o][k], errors, s_.survey.stations[k].toolface, o, k);
      }
    } else {
      search_toolfaces(found, check);
    }
    add_linear(found, as_surveyed, check);
    study::PointResult r;
    r.tables = {worst_table(found)};
    if (!s_.worst_toolface) r.tables.push_back(systematic_table(as_surveyed));
    r.tables.push_back(stations_table(found));
    return r;
  }

 private:
  survey::Survey at_toolface(double toolface) const {
    survey::Survey survey = s_.survey;
    for (survey::Station& station : survey.stations) station.toolface = toolface;
    return survey;
  }

  /// Both signs of an error; keeps the one that moves the end of the well more. Returns that distance.
  double keep_larger(Found& f, const WellErrors& errors, double toolface, std::size_t o, std::size_t k) const {
    double larger = 0;
    for (const int sign : {1, -1}) {
      const FoundError e = errors.of(k, s_.observations[o], sign);
      const double moves = e.position.norm();
      larger = std::max(larger, moves);
      if (f.error.size == 0 || moves > f.moves()) f = {e, {}, toolface, false};
    }
    return larger;
  }

  /// The worst toolface of every reading of every station: a grid of 5 degrees finds the maxima (tau + 180 degrees is
  /// the same up to signs, which are both tried), and each that comes near the largest is then searched continuously.
  template <class Check>
  void search_toolfaces(std::vector<std::vector<Found>>& found, const Check& check) const {
    constexpr std::size_t kGrid = 36;
    constexpr double kStep = kPi / kGrid, kNear = 0.8;
    constexpr double kFlat = 1e-6;  // sizes end within 1e-10 of themselves
    const std::size_t stations = s_.survey.stations.size();
    std::vector<std::vector<std::array<double, kGrid>>> moves(found.size());
    for (auto& of_observation : moves) of_observation.resize(stations);
    for (std::size_t t = 0; t < kGrid; ++t) {
      const double toolface = static_cast<double>(t) * kStep;
      const WellErrors errors(s_.model, at_toolface(toolface), s_.lambda0, s_.test);
      for (std::size_t k = 0; k < stations; ++k) {
        check();
        for (std::size_t o = 0; o < found.size(); ++o)
          if (!is_shared_reference(s_.observations[o]))
            moves[o][k][t] = keep_larger(found[o][k], errors, toolface, o, k);
      }
    }
    const WellErrors at_zero(s_.model, at_toolface(0), s_.lambda0, s_.test);
    for (std::size_t o = 0; o < found.size(); ++o)
      for (std::size_t k = 0; k < stations && !is_shared_reference(s_.observations[o]); ++k) {
        check();
        const auto& m = moves[o][k];
        const double largest = *std::max_element(m.begin(), m.end());
        if (!std::isfinite(largest)) continue;
        if (largest - *std::min_element(m.begin(), m.end()) <= kFlat * largest) {
          found[o][k].error.size = 0;  // an axial sensor: rounding must not choose the toolface
          keep_larger(found[o][k], at_zero, 0, o, k);
          continue;
        }
        for (std::size_t t = 0; t < kGrid; ++t) {
          const double before = m[(t + kGrid - 1) % kGrid], after = m[(t + 1) % kGrid];
          if (m[t] < kNear * largest || m[t] < before || m[t] <= after) continue;
          const double middle = static_cast<double>(t) * kStep;
          search_between(middle - kStep, middle + kStep, [&](double toolface) {
            const WellErrors errors(s_.model, at_toolface(toolface), s_.lambda0, s_.test);
            return keep_larger(found[o][k], errors, toolface, o, k);
          });
        }
        Found& f = found[o][k];  // the search may have left [0, 180) by a step
        if (f.toolface < 0) f.toolface += 2 * kPi;
      }
  }

  /// Linear theory at the toolfaces that were found, and for the references that all stations share.
  template <class Check>
  void add_linear(std::vector<std::vector<Found>>& found, const WellReliability& as_surveyed,
                  const Check& check) const {
    const WellReliability at_zero =
        s_.worst_toolface ? reliability_along_well(s_.model, at_toolface(0), s_.lambda0) : as_surveyed;
    for (std::size_t o = 0; o < found.size(); ++o)
      for (std::size_t k = 0; k < found[o].size(); ++k) {
        Found& f = found[o][k];
        if (is_shared_reference(s_.observations[o])) {
          f.is_linear = true;
          f.linear = effect_of(at_zero, s_.observations[o], k);
          continue;
        }
        check();
        f.linear = effect_of(
            s_.worst_toolface ? reliability_along_well(s_.model, at_toolface(f.toolface), s_.lambda0) : as_surveyed,
            s_.observations[o], k);
      }
  }

  bool is_shared_reference(std::size_t observation) const {
    return s_.model.mode == AdjustmentMode::mse_shared && observation >= kReadings;
  }
  const StationEffect& effect_of(const WellReliability& well, std::size_t observation, std::size_t station) const {
    return is_shared_reference(observation) ? well.references[observation - kReadings]
                                            : well.stations[station][observation];
  }

  static void write_position(compare::TableRows& t, const std::string& effect, const Eigen::Vector3d& position) {
    t.number("position_north_m", "m", effect + ", north", position[0]);
    t.number("position_east_m", "m", effect + ", east", position[1]);
    t.number("position_vertical_m", "m", effect + ", down", position[2]);
    t.number("position_m", "m", "length of that", position.norm());
  }

  void put(compare::TableRows& t, std::size_t observation, std::size_t station, const Found& f) const {
    const bool common = is_shared_reference(observation);
    const FoundError& e = f.error;
    const StationEffect& l = f.linear;
    const Eigen::Vector3d& moved = common ? l.position : e.position;
    const bool off =
        !common && (differ(e.size, l.detectable) || positions_differ(e.position.norm(), l.position.norm()));
    const double unit = observation_scale(observation);
    const auto of_station = [&](double x) { return common ? kNaN : x; };
    t.word("observation", "in which the error is", observation_names()[observation]);
    t.count("station", "number of the station, from 0; -1: an error of all stations",
            common ? std::int64_t{-1} : static_cast<std::int64_t>(station));
    t.number("md_m", "m", "measured depth", of_station(s_.survey.stations[station].md));
    t.number("toolface_deg", "deg", "toolface from y, of the survey or the worst one",
             of_station(f.toolface / kDegree));
    t.word("unit", "of the minimal detectable error", observation_unit(observation));
    t.number("redundancy_number", "1", "redundancy number", l.redundancy);
    t.number(
        "minimal_detectable_error", "1",
        "smallest error that is found, without linearisation, with the sign that moves the end of the well more; in "
        "the row's unit",
        f.size() * unit);
    t.number("external_inclination_deg", "deg", "its effect on the station's inclination",
             of_station(e.inclination / kDegree));
    t.number("external_toolface_deg", "deg", "its effect on the station's toolface; empty: no value",
             of_station(e.toolface / kDegree));
    t.number("external_azimuth_deg", "deg", "its effect on the station's azimuth; empty: no value",
             of_station(e.azimuth / kDegree));
    write_position(t, "its effect on the final position", moved);
    t.number("linear_detectable_error", "1", "minimal detectable error of linear theory there", l.detectable * unit);
    t.number("linear_position_m", "m", "its effect on the final position, to first order", l.position.norm());
    t.word("note", "\"linear differs\": by more than 20 % in size or effect; \"linear\": no other",
           common ? "linear"
           : off  ? "linear differs"
                  : "");
  }

  store::Table stations_table(const std::vector<std::vector<Found>>& found) const {
    compare::TableRows t("stations", "every observation of every station");
    for (std::size_t o = 0; o < s_.observations.size(); ++o)
      for (std::size_t k = 0; k < found[o].size(); ++k)
        if (k == 0 || !is_shared_reference(s_.observations[o])) put(t, s_.observations[o], k, found[o][k]);
    return t.take();
  }

  store::Table worst_table(const std::vector<std::vector<Found>>& found) const {
    compare::TableRows t("worst_stations", "stations where an undetected error matters most to the final position");
    for (std::size_t o = 0; o < s_.observations.size(); ++o) {
      std::vector<std::size_t> order(is_shared_reference(s_.observations[o]) ? 1 : found[o].size());
      for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
      std::stable_sort(order.begin(), order.end(),
                       [&](std::size_t a, std::size_t b) { return found[o][a].moves() > found[o][b].moves(); });
      order.resize(std::min(order.size(), static_cast<std::size_t>(s_.listed)));
      for (const std::size_t k : order) put(t, s_.observations[o], k, found[o][k]);
    }
    return t.take();
  }

  store::Table systematic_table(const WellReliability& well) const {
    compare::TableRows t("systematic",
                         "the same error in one sensor at all stations, which the model does not know; linear theory");
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

  WellScenario s_;
};

}  // namespace

study::Experiment well_experiment() {
  return {random::StudyId::reliability_well,
          "Gross errors along a well: minimal detectable errors, effect on the final position",
          "beyond E. Nyrnes, T. Torkildsen, H. Nahavandchi, Kart og Plan 65",
          study::plan_of<study::PlanOfPoint<WellScenario, ReliabilityWellPoint>, read_well_scenario>};
}

}  // namespace surveymc::studies::reliability
