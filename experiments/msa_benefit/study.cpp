/// Study: where does multi-station analysis help? Uncertainty of azimuth and lateral position after MSA over that
/// before MSA, for every direction of the hole. Before MSA the tool has its a-priori errors (ISCWSA error model). After
/// MSA it has the errors that MSA leaves, most of all those due to an imperfect reference field.
///
/// The maps are first-order predictions without trials. Where a config has [[verify]], Monte Carlo is compared with
/// them:
///   truth, tool drawn -> readings (sensor) -> gains and biases (estimate) -> azimuth, minimum curvature (survey)
#include "msa_benefit/study.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/msa_chain.h"
#include "base/error.h"
#include "base/units.h"
#include "compare/order_rows.h"
#include "msa_benefit/parameter_set.h"
#include "random/study_stream.h"
#include "scenario/disturbance.h"
#include "sensor/tool_spread.h"
#include "study/experiment.h"
#include "survey/corrected_position.h"

namespace surveymc::studies::msa_benefit {

namespace {

constexpr int kPerDirection = 4;  // azimuth before, after (deg), lateral before, after (m)
constexpr int kLateralAfter = 3;

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
analysis::Benefit benefit_at(const Scenario& s, double inclination, double azimuth,
                             const std::optional<Eigen::MatrixXd>& correlation) {
  const Eigen::MatrixXd* c = correlation ? &*correlation : nullptr;
  analysis::Benefit b =
      analysis::predict_benefit(benefit_well(s, inclination, azimuth), s.field, s.errors, s.estimator, c);
  if (s.errors.down > 0 && is_vertical(inclination)) b.before.azimuth = b.after.azimuth = kNaN;
  return b;
}

analysis::MsaChain chain_of(const Scenario& s, const survey::Survey& well) {
  return {{well, s.field, sensor::clean_readings(well, s.field, {}), s.noise, s.spread}, s.estimator};
}

orders::Predictions predicted_orders(const analysis::MsaChain& chain, const orders::WantedOrders& wanted) {
  return orders::predict(chain, wanted,
                         [&chain](const orders::Centre& centre) { return chain.directions(centre.state); });
}

/// Of all directions. Throws InputError where the stations do not determine the estimated parameters.
std::vector<VerifiedWell> verified_wells(const Scenario& s) {
  std::vector<VerifiedWell> wells;
  const std::optional<Eigen::MatrixXd> correlation = s.reference.correlation();
  for (const VerifiedDirection& d : s.verify) {
    VerifiedWell v;
    v.direction = d;
    v.survey = benefit_well(s, d.inclination_deg, d.azimuth_deg);
    v.clean = sensor::clean_readings(v.survey, s.field, {});
    const survey::Station& last = v.survey.stations.back();
    v.lateral_N = survey::rotation_hla_from_nev(last.inclination, last.azimuth).row(1);
    v.position = survey::minimum_curvature_positions(v.survey).back().transpose();
    v.benefit =
        analysis::predict_benefit(v.survey, s.field, s.errors, s.estimator, correlation ? &*correlation : nullptr);
    d.place.require(std::isfinite(v.benefit.condition),
                    fmt::format("with azimuth_deg = {}: the stations do not determine the estimated parameters, there "
                                "is nothing to verify",
                                d.azimuth_deg));
    if (s.orders.any()) {
      const analysis::MsaChain chain = chain_of(s, v.survey);
      v.orders = predicted_orders(chain, s.orders.wanted);
      v.inputs = sensor::names_of(chain.normals(), v.survey.size());
    }
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
  for (std::size_t d = 0; d < s.verify.size(); ++d) {
    const std::string direction = direction_name(s.verify[d]);
    const int first = kPerDirection * static_cast<int>(d);
    for (int q = 0; q < kPerDirection; ++q)
      add(direction, q, first + q, wells.empty() ? kNaN : predicted_sd(wells[d].benefit)[q]);
    for (const std::string& name : s.orders.names) {
      if (name == "first") continue;
      const std::optional<orders::Moments> m = wells.empty() ? std::nullopt : wells[d].orders->of(name);
      compare::Row row{.table = "verification",
                       .formulation = fmt::format("{} {}", direction, name),
                       .quantity = "mean_lateral_after",
                       .unit = "m",
                       .statistic = compare::Statistic::mean,
                       .component = first + kLateralAfter};
      if (m) row.prediction = wells[d].lateral_N * m->mean;
      rows.push_back(row);
      row.quantity = "sd_lateral_after";
      row.statistic = compare::Statistic::sd;
      if (m) row.prediction = std::sqrt(wells[d].lateral_N * m->covariance * wells[d].lateral_N.transpose());
      rows.push_back(row);
    }
  }
  for (int q = 0; q < kPerDirection && s.verify.empty(); ++q) add("", q, -1, kNaN);
  for (const VerifiedDirection& d : s.verify)
    for (compare::Row& row : compare::tail_rows(kTailNames, s.tails, direction_name(d))) rows.push_back(std::move(row));
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
            },
            {.own_groups = s_.reference.laws.any() ? 1u : 0u}),
      estimator_(estimate::make_estimator(s_.estimator, s_.field)),
      uncorrected_(no_correction()),
      verified_(verified_wells(s_)),
      mixing_(sensor::reference_mixing(s_.reference.laws, s_.noise, s_.well.stations)),
      law_draws_(scenario::law_draws(mixing_)),
      rows_(rows_of(s_, verified_)),
      calibrated_rows_(compare::calibrated_rows(rows_, s_.calibration)) {
  for (const compare::Row& row : calibrated_rows_)
    calibrated_.push_back(compare::normal_quantity(row.formulation, row.quantity, row.prediction));
  if (!s_.tails.wanted) return;
  for (const VerifiedWell& v : verified_)
    for (compare::TailQuantity& q : tails_after(v.benefit, mixing_)) {
      q.place = direction_name(v.direction);
      tails_.push_back(std::move(q));
    }
}

BenefitPoint::Errors BenefitPoint::simulate(const VerifiedWell& v, std::uint64_t first, int count,
                                            const survey::LaneArray& made) const {
  const random::Stream stream = random::stream_of(s_.seed);
  survey::ReadingBlock readings = sensor::make_reading_block(count, v.survey.size(), s_.noise);
  estimate::EstimateBlock estimates(count);
  survey::LaneArray deviation(survey::groups_for(count), 6), before(survey::groups_for(count), 3),
      after(survey::groups_for(count), 3);
  sensor::simulate_readings(v.clean, s_.field, s_.noise, stream, first, readings, nullptr, nullptr, &mixing_,
                            s_.reference.disturbed ? &made : nullptr);
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
  const random::Stream stream = random::stream_of(s_.seed);
  const survey::LaneArray made = s_.reference.made(stream, block.first, false, survey::groups_for(block.count));
  for (Eigen::Index d = 0; d < directions; ++d) {
    const Errors e = simulate(verified_[static_cast<std::size_t>(d)], block.first, block.count, made);
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
  tally.counts.assign(law_counts(), 0);
  for (std::size_t c = 0; c < calibrated_.size(); ++c)
    calibrated_[c].cells.count(values.col(calibrated_rows_[c].component).data(), static_cast<std::size_t>(kept), 0,
                               tally.counts.data() + c * stats::kPitSlots);
  for (std::size_t q = 0; q < tails_.size(); ++q) {
    const auto direction = static_cast<Eigen::Index>(q / kBenefits.size());
    for (Eigen::Index t = 0; t < kept; ++t)
      compare::count_beyond(
          values(t, kPerDirection * direction + 1 + 2 * static_cast<Eigen::Index>(q % kBenefits.size())), tails_[q].sd,
          s_.tails, tally.counts.data() + tail_counts() + q * s_.tails.k.size());
  }
  compare::DrawnLaws::add(stream, law_draws_, block, false, tally);
  stop_.keep(block, tally);
  return tally;
}

std::vector<compare::ComparisonRow> BenefitPoint::verification_rows(const stats::Tally& tally) const {
  return compare::compare_rows(rows_, "verification", s_.verdict, tally.trials, tally.moments);
}

store::Table BenefitPoint::verification_table(const stats::Tally& tally) const {
  std::vector<compare::ComparisonRow> rows = verification_rows(tally);
  std::vector<double> inclination, azimuth;
  stop_.add_notes("verification", rows, tally);
  s_.annotations.apply("verification", rows);
  const bool has_orders = s_.orders.any();
  const std::size_t per_direction = rows.size() / verified_.size();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const VerifiedDirection& direction = verified_[i / per_direction].direction;
    inclination.push_back(direction.inclination_deg);
    azimuth.push_back(direction.azimuth_deg);
    // The direction has columns of its own; of the formulation the order is left.
    std::string& formulation = rows[i].formulation;
    const bool is_first = i % per_direction < kPerDirection;
    formulation = !has_orders ? "" : is_first ? "first" : formulation.substr(formulation.rfind(' ') + 1);
  }
  store::Table t = compare::comparison_table(
      "verification",
      "azimuth of the last station and last lateral position, before and after MSA, against the "
      "predictions, of which the maps are the first" +
          compare::at_confidence(s_.verdict),
      rows, tally.trials, tally.failed, has_orders);
  t.columns.insert(t.columns.begin(), {{"inclination_deg", "deg", "inclination of the last station", inclination},
                                       {"azimuth_deg", "deg", "azimuth of the last station", azimuth}});
  return t;
}

store::Table BenefitPoint::tails_table(const stats::Tally& tally) const {
  store::Table t =
      compare::tails_table(tails_, s_.tails, tally.trials > 0 ? tally.counts.data() + tail_counts() : nullptr,
                           tally.moments.count, s_.verdict, s_.annotations, tally.trials, tally.failed);
  // The direction gets columns of its own, and so has the sd of an azimuth, which is no length.
  std::vector<double> inclination, azimuth, degrees;
  const auto at =
      std::find_if(t.columns.begin(), t.columns.end(), [](const store::Column& c) { return c.name == "sd_m"; });
  auto& metres = std::get<std::vector<double>>(at->values);
  auto& formulations =
      std::get<std::vector<std::string>>(std::find_if(t.columns.begin(), t.columns.end(), [](const store::Column& c) {
                                           return c.name == "formulation";
                                         })->values);
  const std::size_t per_quantity = metres.size() / tails_.size();
  for (std::size_t i = 0; i < metres.size(); ++i) {
    const std::size_t q = i / per_quantity;
    const VerifiedDirection& direction = verified_[q / kBenefits.size()].direction;
    inclination.push_back(direction.inclination_deg);
    azimuth.push_back(direction.azimuth_deg);
    degrees.push_back(q % kBenefits.size() == 0 ? metres[i] : kNaN);
    if (q % kBenefits.size() == 0) metres[i] = kNaN;
    formulations[i] = formulations[i].substr(formulations[i].rfind(' ') + 1);
  }
  t.columns.insert(at + 1, {"sd_deg", "deg", "the predicted one of an azimuth", degrees});
  t.columns.insert(t.columns.begin(), {{"inclination_deg", "deg", "inclination of the last station", inclination},
                                       {"azimuth_deg", "deg", "azimuth of the last station", azimuth}});
  return t;
}

store::Table BenefitPoint::orders_table(const stats::Tally& tally) const {
  compare::TableRows t("orders", "which order of prediction the lateral position after MSA needs, without a trial" +
                                     compare::at_confidence(s_.verdict));
  for (std::size_t d = 0; d < verified_.size(); ++d) {
    const VerifiedWell& v = verified_[d];
    t.number("inclination_deg", "deg", "inclination of the last station", v.direction.inclination_deg);
    t.number("azimuth_deg", "deg", "azimuth of the last station", v.direction.azimuth_deg);
    const Eigen::Index component = static_cast<Eigen::Index>(kPerDirection * d) + kLateralAfter;
    compare::write_order(t, "lateral", v.lateral_N.transpose(), *v.orders, s_.orders.wanted, v.inputs,
                         tally.moments.count < 2
                             ? compare::OrderSample{}
                             : compare::order_sample(stats::summarise(tally.moments, component), s_.verdict),
                         s_.verdict);
  }
  return t.take();
}

std::vector<double> BenefitPoint::orders_needed(const std::vector<analysis::Benefit>& benefits,
                                                const montecarlo::RunOptions& options) const {
  orders::WantedOrders wanted;
  wanted.profile = true;
  wanted.options = s_.orders.wanted.options;
  std::vector<double> needed;
  for (const double inclination : s_.inclination_deg)
    for (const double azimuth : s_.azimuth_deg) {
      if (options.stop && *options.stop) throw Interrupted("stopped before all maps were made");
      if (!std::isfinite(benefits[needed.size()].condition)) {
        needed.push_back(kNaN);
        continue;
      }
      const survey::Survey well = benefit_well(s_, inclination, azimuth);
      const survey::Station& last = well.stations.back();
      needed.push_back(compare::order_value(predicted_orders(chain_of(s_, well), wanted),
                                            survey::rotation_hla_from_nev(last.inclination, last.azimuth).row(1),
                                            s_.verdict.margin));
    }
  return needed;
}

study::PointResult BenefitPoint::report(const stats::Tally& tally, const montecarlo::RunOptions& options) const {
  std::vector<analysis::Benefit> benefits;
  const std::optional<Eigen::MatrixXd> correlation = s_.reference.correlation();
  for (const double inclination : s_.inclination_deg) {
    if (options.stop && *options.stop) throw Interrupted("stopped before all maps were made");
    for (const double azimuth : s_.azimuth_deg) benefits.push_back(benefit_at(s_, inclination, azimuth, correlation));
  }
  study::PointResult r;
  const bool has_profile = s_.orders.wanted.profile;
  const std::vector<double> needed = has_profile ? orders_needed(benefits, options) : std::vector<double>();
  r.maps = benefit_maps(s_, benefits, needed);
  if (s_.tails.wanted && s_.tails.predicted)
    for (store::Map& m : tail_maps(s_, benefits, mixing_)) r.maps.push_back(std::move(m));
  r.tables.push_back(benefit_summary(s_, benefits));
  if (!verified_.empty()) r.tables.push_back(verification_table(tally));
  if (s_.tails.wanted) {
    if (!verified_.empty()) r.tables.push_back(tails_table(tally));
    const bool has_law = tally.trials > 0 && !law_draws_.empty();
    r.tables.push_back(compare::laws_table(s_.reference.laws, law_draws_, has_law ? &tally.groups.front() : nullptr,
                                           has_law ? tally.counts.data() + law_counts() : nullptr,
                                           s_.verdict.confidence));
  }
  if (s_.reference.disturbance) {
    const random::Stream stream = random::stream_of(s_.seed);
    r.tables.push_back(
        scenario::disturbance_table(*s_.reference.disturbance, s_.field, verified_.empty() ? nullptr : &stream));
  }
  if (!verified_.empty() && s_.orders.any() && verified_.front().orders->second)
    r.tables.push_back(orders_table(tally));
  if (has_profile) r.tables.push_back(compare::order_shares_table("the lateral position after MSA", needed));
  if (stop_.is_on()) r.tables.push_back(stop_.looks_table(tally));
  for (store::Table& t :
       compare::calibration_tables(s_.calibration, calibrated_, tally.counts, 0, false, s_.annotations))
    r.tables.push_back(std::move(t));
  return r;
}

std::string BenefitPoint::replay(std::uint64_t trial) const {
  std::string text = fmt::format("trial {}\n", trial);
  const auto lane = static_cast<std::size_t>(trial % simd::kGroup);
  const std::uint64_t first = trial / simd::kGroup * simd::kGroup;
  const survey::LaneArray made = s_.reference.made(random::stream_of(s_.seed), first, false, 1);
  for (const VerifiedWell& v : verified_) {
    const Errors e = simulate(v, first, simd::kGroup, made);
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
  /// A direction of the maps costs about as much as a trial, and a thousand with its order.
  double cost() const override {
    const auto directions =
        static_cast<double>(s_.inclination_deg.size() * s_.azimuth_deg.size()) * (s_.orders.wanted.profile ? 1000 : 1);
    return s_.well.stations * (directions + static_cast<double>(s_.verify.size() * s_.trial_plan.trials));
  }
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::msa_benefit,
          "Where multi-station analysis makes azimuth and lateral position better, and where worse",
          "ISCWSA MWD error model (a-priori sensor errors); S. Vis, TU Delft 2019 (MSA)",
          [](config::ConfigReader& config, random::StudySeed seed) -> std::unique_ptr<study::PointPlan> {
            if (std::optional<SetMapScenario> set = read_set_maps(config, seed)) return set_map_plan(std::move(*set));
            return std::make_unique<MsaBenefitPlan>(read_scenario(config, seed));
          }};
}

}  // namespace surveymc::studies::msa_benefit
