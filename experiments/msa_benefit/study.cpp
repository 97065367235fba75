/// Study: where does multi-station analysis help? Uncertainty of azimuth and lateral position after MSA over that
/// before MSA, for every direction of the hole. Before MSA the tool has its a-priori errors (ISCWSA error model). After
/// MSA it has the errors that MSA leaves, most of all those due to an imperfect reference field.
///
/// The maps are first-order predictions without trials. Where a config has [[verify]], Monte Carlo is compared with
/// them:
///   truth, tool drawn -> readings (sensor) -> gains and biases (estimate) -> azimuth, minimum curvature (survey)
#include "msa_benefit/study.h"

#include <cmath>

#include <fmt/format.h>

#include "base/error.h"
#include "base/units.h"
#include "random/study_stream.h"
#include "sensor/tool_spread.h"
#include "study/experiment.h"
#include "survey/corrected_position.h"

namespace surveymc::studies::msa_benefit {

namespace {

constexpr int kPerDirection = 4;  // azimuth before, after (deg), lateral before, after (m)

/// Gains 1 and biases 0 in every lane: readings taken as they are.
survey::LaneArray no_correction() {
  survey::LaneArray parameters(1, 6, true);
  for (int i = 0; i < 6; ++i) parameters.fill(0, i, i < 3 ? 1 : 0);
  return parameters;
}

/// Magnetic azimuth of the last station, readings corrected by `parameters` (rad).
double last_azimuth(const survey::ReadingBlock& b, const survey::LaneArray& parameters, int trial) {
  const int row = 3 * (b.stations - 1);
  const auto corrected = [&](int i) {
    return (b.magnetic.value(trial, row + i) - parameters.value(trial, 3 + i)) / parameters.value(trial, i);
  };
  const survey::Vec3<double> u{b.down.value(trial, row), b.down.value(trial, row + 1), b.down.value(trial, row + 2)};
  const survey::Vec3<double> t =
      survey::tangent_from_fields(u, survey::Vec3<double>{corrected(0), corrected(1), corrected(2)});
  return std::atan2(t.y, t.x);
}

/// In the order and units of kPerDirection.
std::array<double, kPerDirection> predicted_sd(const analysis::Benefit& b) {
  return {b.before.azimuth / kDegree, b.after.azimuth / kDegree, b.before.lateral, b.after.lateral};
}

/// What a cell of the maps says. Noise of accelerometers turns a vertical hole to any azimuth, before and after: it has
/// none whose sd could be told, and what predict_benefit() gives grows with the nearness to the vertical.
analysis::Benefit benefit_at(const Scenario& s, double inclination, double azimuth) {
  analysis::Benefit b =
      analysis::predict_benefit(benefit_well(s, inclination, azimuth), s.field, s.errors, s.estimator);
  if (s.errors.down > 0 && is_vertical(inclination)) b.before.azimuth = b.after.azimuth = kNaN;
  return b;
}

/// Of all directions. Throws InputError where the stations do not determine the estimated parameters.
std::vector<VerifiedWell> verified_wells(const Scenario& s) {
  std::vector<VerifiedWell> wells;
  for (const VerifiedDirection& d : s.verify) {
    VerifiedWell v;
    v.direction = d;
    v.survey = benefit_well(s, d.inclination_deg, d.azimuth_deg);
    v.clean = sensor::clean_readings(v.survey, s.field, {});
    const survey::Station& last = v.survey.stations.back();
    v.lateral_N = survey::rotation_hla_from_nev(last.inclination, last.azimuth).row(1);
    v.position = survey::minimum_curvature_positions(v.survey).back().transpose();
    v.benefit = analysis::predict_benefit(v.survey, s.field, s.errors, s.estimator);
    d.place.require(std::isfinite(v.benefit.condition),
                    fmt::format("with azimuth_deg = {}: the stations do not determine the estimated parameters, there "
                                "is nothing to verify",
                                d.azimuth_deg));
    wells.push_back(std::move(v));
  }
  return wells;
}

}  // namespace

std::vector<compare::Row> rows_of(const Scenario& s, const std::vector<VerifiedWell>& wells) {
  std::vector<compare::Row> rows;
  const auto add = [&](const std::string& formulation, int q, int component, double prediction) {
    const std::string quantity = fmt::format("{}_{}", kBenefits[q / 2], q % 2 == 0 ? "before" : "after");
    compare::Row row{.table = "verification",
                     .formulation = formulation,
                     .quantity = "sd_" + quantity,
                     .unit = kBenefitUnits[q / 2],
                     .statistic = compare::Statistic::sd,
                     .component = component,
                     .prediction = prediction,
                     .available = !s.verify.empty()};
    rows.push_back(row);
    row.table = "calibration";
    row.quantity = quantity;
    row.calibrated = true;
    rows.push_back(row);
  };
  for (std::size_t d = 0; d < s.verify.size(); ++d)
    for (int q = 0; q < kPerDirection; ++q)
      add(fmt::format("inclination {:g} azimuth {:g}", s.verify[d].inclination_deg, s.verify[d].azimuth_deg), q,
          kPerDirection * static_cast<int>(d) + q, wells.empty() ? kNaN : predicted_sd(wells[d].benefit)[q]);
  for (int q = 0; q < kPerDirection && s.verify.empty(); ++q) add("", q, -1, kNaN);
  return rows;
}

/// Errors of a batch in one direction, in the order of kPerDirection; NaN where the estimate did not converge.
struct BenefitPoint::Errors {
  std::vector<std::array<double, kPerDirection>> of_trial;
  std::vector<bool> converged;
};

BenefitPoint::BenefitPoint(Scenario scenario)
    : s_(std::move(scenario)),
      stop_(s_.trial_plan, s_.verdict,
            [this](const stats::Tally& t) {
              return compare::RowsOfTables{{"verification", verification_rows(t)}};
            }),
      estimator_(estimate::make_estimator(s_.estimator, s_.field)),
      uncorrected_(no_correction()),
      verified_(verified_wells(s_)),
      rows_(rows_of(s_, verified_)),
      calibrated_rows_(compare::calibrated_rows(rows_, s_.calibration)) {
  for (const compare::Row& row : calibrated_rows_)
    calibrated_.push_back(compare::normal_quantity(row.formulation, row.quantity, row.prediction));
}

BenefitPoint::Errors BenefitPoint::simulate(const VerifiedWell& v, std::uint64_t first, int count) const {
  const random::Stream stream = random::stream_of(s_.seed);
  survey::ReadingBlock readings = sensor::make_reading_block(count, v.survey.size(), s_.noise);
  estimate::EstimateBlock estimates(count);
  survey::LaneArray deviation(survey::groups_for(count), 6), before(survey::groups_for(count), 3),
      after(survey::groups_for(count), 3);
  sensor::simulate_readings(v.clean, s_.field, s_.noise, stream, first, readings);
  if (s_.spread.any()) sensor::spread_tools(v.clean, s_.spread, false, stream, first, readings, deviation);
  estimator_->solve(readings, estimates);
  const std::vector<double> md = v.survey.md();
  survey::corrected_final_positions(readings, uncorrected_, md, s_.field.declination, before);
  survey::corrected_final_positions(readings, estimates.parameters, md, s_.field.declination, after);

  const double truth = v.survey.stations.back().azimuth - s_.field.declination;
  Errors out;
  for (int t = 0; t < count; ++t) {
    const auto azimuth = [&](const survey::LaneArray& parameters) {
      return std::remainder(last_azimuth(readings, parameters, t) - truth, 2 * kPi) / kDegree;
    };
    const auto lateral = [&](const survey::LaneArray& position) -> double {
      return v.lateral_N.dot(Eigen::RowVector3d(position.value(t, 0), position.value(t, 1), position.value(t, 2)) -
                             v.position);
    };
    out.of_trial.push_back({azimuth(uncorrected_), azimuth(estimates.parameters), lateral(before), lateral(after)});
    out.converged.push_back(estimates.converged.value(t, 0) != 0);
  }
  return out;
}

stats::Tally BenefitPoint::run_block(montecarlo::TrialBlock block) const {
  const auto directions = static_cast<Eigen::Index>(verified_.size());
  Eigen::MatrixXd values(block.count, kPerDirection * directions);
  std::vector<bool> sound(static_cast<std::size_t>(block.count), true);
  for (Eigen::Index d = 0; d < directions; ++d) {
    const Errors e = simulate(verified_[static_cast<std::size_t>(d)], block.first, block.count);
    for (int t = 0; t < block.count; ++t) {
      const auto trial = static_cast<std::size_t>(t);
      sound[trial] = sound[trial] && e.converged[trial];
      for (int q = 0; q < kPerDirection; ++q)
        values(t, kPerDirection * d + q) = e.of_trial[trial][static_cast<std::size_t>(q)];
    }
  }
  stats::Tally tally;
  Eigen::Index kept = 0;  // a trial counts in all directions or in none
  for (int t = 0; t < block.count; ++t) {
    ++tally.trials;
    if (sound[static_cast<std::size_t>(t)]) {
      values.row(kept++) = values.row(t).eval();
    } else {
      tally.add_failed(block.first + static_cast<std::uint64_t>(t));
    }
  }
  tally.moments = stats::Moments::of(values.topRows(kept));
  stop_.keep(block, tally);
  tally.counts.assign(calibrated_.size() * stats::kPitSlots, 0);
  for (std::size_t c = 0; c < calibrated_.size(); ++c)
    calibrated_[c].cells.count(values.col(calibrated_rows_[c].component).data(), static_cast<std::size_t>(kept), 0,
                               tally.counts.data() + c * stats::kPitSlots);
  return tally;
}

std::vector<compare::ComparisonRow> BenefitPoint::verification_rows(const stats::Tally& tally) const {
  return compare::compare_rows(rows_, "verification", s_.verdict, tally.trials, tally.moments);
}

store::Table BenefitPoint::verification_table(const stats::Tally& tally) const {
  std::vector<compare::ComparisonRow> rows = verification_rows(tally);
  std::vector<double> inclination, azimuth;
  stop_.add_notes("verification", rows, tally);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const VerifiedDirection& direction = verified_[i / kPerDirection].direction;
    inclination.push_back(direction.inclination_deg);
    azimuth.push_back(direction.azimuth_deg);
  }
  s_.annotations.apply("verification", rows);
  for (compare::ComparisonRow& row : rows) row.formulation.clear();  // the direction has columns of its own
  store::Table t = compare::comparison_table(
      "verification",
      "azimuth of the last station and last lateral position, before and after MSA, against the "
      "first-order prediction of the maps" +
          compare::at_confidence(s_.verdict),
      rows, tally.trials, tally.failed);
  t.columns.insert(t.columns.begin(), {{"inclination_deg", "deg", "inclination of the last station", inclination},
                                       {"azimuth_deg", "deg", "azimuth of the last station", azimuth}});
  return t;
}

study::PointResult BenefitPoint::report(const stats::Tally& tally, const montecarlo::RunOptions& options) const {
  std::vector<analysis::Benefit> benefits;
  for (const double inclination : s_.inclination_deg) {
    if (options.stop && *options.stop) throw Interrupted("stopped before all maps were made");
    for (const double azimuth : s_.azimuth_deg) benefits.push_back(benefit_at(s_, inclination, azimuth));
  }
  study::PointResult r;
  r.maps = benefit_maps(s_, benefits);
  r.tables.push_back(benefit_summary(s_, benefits));
  if (!verified_.empty()) r.tables.push_back(verification_table(tally));
  if (stop_.is_on()) r.tables.push_back(stop_.looks_table(tally));
  for (store::Table& t :
       compare::calibration_tables(s_.calibration, calibrated_, tally.counts, 0, false, s_.annotations))
    r.tables.push_back(std::move(t));
  return r;
}

std::string BenefitPoint::replay(std::uint64_t trial) const {
  std::string text = fmt::format("trial {}\n", trial);
  const auto lane = static_cast<std::size_t>(trial % simd::kGroup);
  for (const VerifiedWell& v : verified_) {
    const Errors e = simulate(v, trial / simd::kGroup * simd::kGroup, simd::kGroup);
    const std::array<double, kPerDirection>& x = e.of_trial[lane];
    text += fmt::format(
        "  inclination {} deg, azimuth {} deg\n"
        "    azimuth error    before {:.17g} deg, after {:.17g} deg\n"
        "    lateral error    before {:.17g} m, after {:.17g} m\n"
        "    {}\n",
        v.direction.inclination_deg, v.direction.azimuth_deg, x[0], x[1], x[2], x[3],
        e.converged[lane] ? "converged" : "NOT converged");
  }
  return text;
}

namespace {

class MsaBenefitPlan final : public study::PlanOfPoint<Scenario, BenefitPoint> {
 public:
  using PlanOfPoint::PlanOfPoint;
  /// A direction of the maps costs about as much as a trial.
  double cost() const override {
    const auto directions = static_cast<double>(s_.inclination_deg.size() * s_.azimuth_deg.size());
    return s_.well.stations * (directions + static_cast<double>(s_.verify.size() * s_.trial_plan.trials));
  }
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::msa_benefit,
          "Where multi-station analysis makes azimuth and lateral position better, and where worse",
          "ISCWSA MWD error model (a-priori sensor errors); S. Vis, TU Delft 2019 (MSA)",
          study::plan_of<MsaBenefitPlan, read_scenario>};
}

}  // namespace surveymc::studies::msa_benefit
