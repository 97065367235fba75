/// Study: how many stations in error does a multi-station analysis bear, by loss? The errors of a tool code are drawn
/// as six-axis readings, some stations get gross errors, and the run is estimated by least squares, by robust losses,
/// and by the informed fit, which knows the wrong stations and leaves them out.
///
///   tool code -> readings (sensor) -> parameters (multistation) -> directions of the right stations (survey)
/// Compared is what the right stations contribute to the lateral error of the last position, sum L_k sinI dA_k
/// (analysis/corrected_survey.h): a wrong station's own direction is lost with any estimate.
#include "robustness_map/study.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "random/study_stream.h"
#include "stats/sample_summary.h"

namespace surveymc::studies::robustness_map {

using multistation::Loss;

namespace {

constexpr int kBatch = 64;          // trials: their readings stay in the cache
constexpr double kMostLost = 0.01;  // share of the trials without a solution

/// The first leg of a well is doubled, as codes do (analysis/corrected_survey.h).
constexpr bool kFirstLegDoubled = true;

survey::LaneArray no_correction() {
  survey::LaneArray x(1, 6, true);
  for (int i = 0; i < 6; ++i) x.fill(0, i, i < 3 ? 1 : 0);
  return x;
}

/// Readings as drawn: directions of gravity and their lengths, `gravity`.
multistation::SixAxisBlock six_axes(const survey::ReadingBlock& drawn, const survey::LaneArray& gravity,
                                    double reference_gravity) {
  multistation::SixAxisBlock b(drawn.trials, drawn.stations);
  for (int g = 0; g < drawn.groups(); ++g) {
    std::fill_n(b.reference.row(g, 0), simd::kGroup, reference_gravity);
    for (int i = 0; i < 2; ++i) std::copy_n(drawn.reference.row(g, i), simd::kGroup, b.reference.row(g, 1 + i));
    for (int r = 0; r < 3 * drawn.stations; ++r) {
      std::copy_n(drawn.magnetic.row(g, r), simd::kGroup, b.magnetic.row(g, r));
      for (int lane = 0; lane < simd::kGroup; ++lane)
        b.gravity.row(g, r)[lane] = gravity.row(g, r / 3)[lane] * drawn.down.row(g, r)[lane];
    }
  }
  return b;
}

/// Corrected readings as a survey takes them.
survey::ReadingBlock directions_of(const multistation::SixAxisBlock& corrected) {
  survey::ReadingBlock b(corrected.trials, corrected.stations, true, false);
  for (int g = 0; g < b.groups(); ++g)
    for (int k = 0; k < b.stations; ++k)
      for (int lane = 0; lane < simd::kGroup; ++lane) {
        const auto at = [&](int axis) { return corrected.gravity.row(g, 3 * k + axis)[lane]; };
        const double size = std::hypot(at(0), at(1), at(2));
        for (int axis = 0; axis < 3; ++axis) {
          b.down.row(g, 3 * k + axis)[lane] = at(axis) / size;
          b.magnetic.row(g, 3 * k + axis)[lane] = corrected.magnetic.row(g, 3 * k + axis)[lane];
        }
      }
  return b;
}

}  // namespace

std::string estimator_name(const Scenario& s, std::size_t estimator) {
  return estimator == 0 ? "informed" : multistation::loss_names()[static_cast<std::size_t>(s.losses[estimator - 1])];
}

std::vector<compare::Row> rows_of(const Scenario& s, const std::vector<double>& variance_ratios) {
  std::vector<compare::Row> rows;
  const bool clean = s.gross.count == 0;
  for (std::size_t e = 1; e <= s.losses.size(); ++e) {
    const std::string name = estimator_name(s, e);
    const bool predicted = clean && !variance_ratios.empty();
    rows.push_back({.table = "prediction",
                    .formulation = name,
                    .quantity = "rms_ratio",
                    .unit = "1",
                    .statistic = compare::Statistic::other,
                    .component = component(e, kLateral),
                    .prediction = predicted ? std::sqrt(variance_ratios[e - 1]) : kNaN,
                    .available = s.losses[e - 1] != Loss::least_squares});
    rows.push_back({.table = "prediction",
                    .formulation = name,
                    .quantity = "nees",
                    .unit = "1",
                    .statistic = compare::Statistic::squared_distance,
                    .component = component(e, kNees),
                    .prediction = clean ? s.fit.parameters.size() : kNaN});
  }
  return rows;
}

compare::Estimate rms_ratio(const stats::Moments& m, std::size_t estimator, std::size_t over, double confidence) {
  const int a = component(estimator, kSquare), b = component(over, kSquare);
  if (m.count < 2 || !(m.mean[b] > 0)) return {};
  const double ratio = std::sqrt(m.mean[a] / m.mean[b]);
  // Of ln(mean_a / mean_b) / 2, to first order: squares of the same trials go together.
  const Eigen::MatrixXd c = m.covariance();
  const double n = static_cast<double>(m.count),
               variance = (c(a, a) / (m.mean[a] * m.mean[a]) + c(b, b) / (m.mean[b] * m.mean[b]) -
                           2 * c(a, b) / (m.mean[a] * m.mean[b])) /
                          n,
               half = stats::normal_quantile((1 + confidence) / 2) * std::sqrt(std::max(variance, 0.0)) / 2;
  return {ratio, {ratio * std::exp(-half), ratio * std::exp(half)}};
}

RobustnessPoint::RobustnessPoint(Scenario scenario)
    : s_(std::move(scenario)),
      setup_(sensor::disturbed_run_setup(s_.well, s_.field)),
      stations_(analysis::measured_stations(s_.well, s_.field, kFirstLegDoubled)),
      tied_(survey::tied_survey(s_.well, s_.field.declination, kFirstLegDoubled)),
      plan_(multistation::fit_plan(s_.fit)) {
  const propagate::CodeDraws& d = s_.draws;
  setup_.sd = d.sensors;
  setup_.interference = d.interference;
  setup_.run = {d.run.total, d.run.dip, d.run.declination_in(s_.field)};
  setup_.station = {d.station.total, d.station.dip, d.station.declination_in(s_.field)};
  setup_.noise = s_.noise;
  estimators_.push_back(multistation::robust_options(Loss::least_squares));
  costs_.emplace_back();
  for (const Loss loss : s_.losses) {
    estimators_.push_back(multistation::robust_options(loss));
    costs_.push_back(multistation::loss_cost(loss, plan_));
    variance_ratios_.push_back(analysis::lateral_variance_ratio(stations_, d, s_.noise, s_.fit, loss));
  }
  for (const multistation::LossCost& cost : costs_)
    claims_.emplace_back(stations_, s_.draws, s_.noise, multistation::as_weighed(s_.fit, cost));
  rows_ = rows_of(s_, variance_ratios_);
}

/// One row a trial; columns as Component of each estimator.
struct RobustnessPoint::Outcome {
  Eigen::MatrixXd values;
  std::vector<bool> converged, claimed;  ///< claimed: all covariances are positive definite
  std::vector<char> wrong;               ///< stations a trial
  std::vector<Eigen::MatrixXd> weights;  ///< of each estimator: a row a trial, a column a station
};

RobustnessPoint::Outcome RobustnessPoint::simulate(std::uint64_t first, int count) const {
  const int groups = survey::groups_for(count), stations = setup_.stations();
  const auto n = static_cast<std::size_t>(stations);
  const random::Stream stream = random::stream_of(s_.seed);
  survey::ReadingBlock drawn = sensor::make_disturbed_block(count, setup_);
  survey::LaneArray gravity(groups, stations);
  sensor::draw_disturbed_runs(setup_, stream, first, drawn, nullptr, &gravity);
  Outcome out;
  out.wrong = sensor::add_gross_errors(s_.gross, stream, first, setup_.frames, drawn);
  const multistation::SixAxisBlock readings = six_axes(drawn, gravity, s_.field.gravity);
  survey::LaneArray right(groups, stations);  // weights of the informed fit
  for (int g = 0; g < groups; ++g)
    for (int k = 0; k < stations; ++k)
      for (int lane = 0; lane < simd::kGroup; ++lane)
        right.row(g, k)[lane] =
            out.wrong[static_cast<std::size_t>(g * simd::kGroup + lane) * n + static_cast<std::size_t>(k)] ? 0 : 1;
  // True parameters, as the readings were drawn.
  const multistation::PerParameter<double> sd = analysis::tool_sizes(s_.draws);
  const int p = s_.fit.parameters.size();
  Eigen::MatrixXd truth = Eigen::MatrixXd::Zero(count, p);
  for (int t = 0; t < count; ++t)
    for (int i = 0; i < p; ++i) {
      const int at = s_.fit.parameters.index(i);
      if (at >= survey::kSensorTerms) continue;
      const auto z = [&](std::uint32_t index) {
        return stream.normal(first + static_cast<std::uint64_t>(t), random::Channel::disturbed_run, index);
      };
      const auto term = static_cast<std::uint32_t>(at);
      truth(t, i) = at == survey::kMagnetometerBias + 2
                        ? s_.draws.sensors[term] * z(term) + s_.draws.interference * z(survey::kSensorTerms)
                        : sd[term] * z(term);
    }
  out.values.resize(count, component(estimators_.size(), kLateral));
  out.converged.assign(static_cast<std::size_t>(count), true);
  out.claimed = out.converged;
  const survey::LaneArray uncorrected = no_correction();
  survey::LaneArray position(groups, 3), lateral(groups, stations);
  for (std::size_t e = 0; e < estimators_.size(); ++e) {
    multistation::FitBlock found(count, s_.fit);
    multistation::RobustBlock robust(count, stations);
    multistation::robust_fit_block(readings, plan_, s_.fit.parameters, estimators_[e], stream, first, found, robust,
                                   e == 0 ? &right : nullptr);
    multistation::SixAxisBlock corrected = six_axes(drawn, gravity, s_.field.gravity);
    multistation::correct_block(corrected, plan_, s_.fit.parameters, found);
    const survey::ReadingBlock directions = directions_of(corrected);
    survey::corrected_tied_positions(directions, uncorrected, tied_, position, lateral);
    out.weights.emplace_back(count, stations);
    for (int t = 0; t < count; ++t) {
      double sum = 0, right_weight = 0, wrong_weight = 0;
      std::vector<double> weights(n);
      for (int k = 0; k < stations; ++k) {
        const auto at = static_cast<std::size_t>(k);
        const bool wrong = out.wrong[static_cast<std::size_t>(t) * n + at] != 0;
        weights[at] = out.weights.back()(t, k) = robust.weights.value(t, k);
        (wrong ? wrong_weight : right_weight) += weights[at];
        if (!wrong) sum += stations_.lever[at] * lateral.value(t, k);
      }
      Eigen::VectorXd error(p);
      for (int i = 0; i < p; ++i) error[i] = found.estimate.value(t, i) - truth(t, i);
      const Eigen::MatrixXd claimed = claims_[e].covariance(weights.data(), costs_[e]);
      const Eigen::VectorXd unit = claimed.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::LLT<Eigen::MatrixXd> factored(unit.asDiagonal() * claimed * unit.asDiagonal());
      error = unit.asDiagonal() * error;
      const double nees = factored.info() == Eigen::Success ? error.dot(factored.solve(error)) : kNaN;
      const double wrong_stations = s_.gross.count,
                   values[kComponents] = {sum, sum * sum, nees, right_weight / (stations - wrong_stations),
                                          wrong_stations > 0 ? wrong_weight / wrong_stations : 0};
      for (int i = 0; i < kComponents; ++i) out.values(t, component(e, static_cast<Component>(i))) = values[i];
      if (found.converged.value(t, 0) == 0 || !std::isfinite(sum)) out.converged[static_cast<std::size_t>(t)] = false;
      if (!std::isfinite(nees)) out.claimed[static_cast<std::size_t>(t)] = false;
    }
  }
  return out;
}

stats::Tally RobustnessPoint::run_block(montecarlo::TrialBlock block) const {
  Eigen::MatrixXd values(block.count, component(estimators_.size(), kLateral));
  Eigen::Index kept = 0;
  std::uint64_t unclaimed = 0;
  stats::Tally tally;
  for (int from = 0; from < block.count; from += kBatch) {
    const int count = std::min(kBatch, block.count - from);
    const std::uint64_t first = block.first + static_cast<std::uint64_t>(from);
    const Outcome o = simulate(first, count);
    for (int t = 0; t < count; ++t) {
      const auto at = static_cast<std::size_t>(t);
      ++tally.trials;
      unclaimed += o.converged[at] && !o.claimed[at];
      if (o.converged[at] && o.claimed[at])
        values.row(kept++) = o.values.row(t);
      else
        tally.add_failed(first + static_cast<std::uint64_t>(t));
    }
  }
  tally.counts = {unclaimed};
  tally.moments = stats::Moments::of(values.topRows(kept));
  return tally;
}

std::vector<compare::ComparisonRow> RobustnessPoint::prediction_rows(const stats::Tally& tally) const {
  const stats::Moments& m = tally.moments;
  std::vector<compare::ComparisonRow> rows;
  for (const compare::Row& row : rows_) {
    if (!row.available) continue;
    const auto estimator = static_cast<std::size_t>(row.component / kComponents);
    if (row.statistic == compare::Statistic::squared_distance && !std::isnan(row.prediction)) {
      rows.push_back(compare::compare_row(
          row, m.count < 2 ? stats::SampleSummary{} : stats::summarise(m, row.component), s_.verdict, tally.trials));
      continue;
    }
    const compare::Estimate found = row.statistic == compare::Statistic::other
                                        ? rms_ratio(m, estimator, 0, s_.verdict.confidence)
                                        : compare::mean_estimate(m, row.component, s_.verdict.confidence);
    rows.push_back(compare::labelled(
        row.formulation,
        compare::compare_value(row.quantity, row.unit, found, row.prediction, s_.verdict, tally.trials, m.count)));
  }
  const std::uint64_t unclaimed = tally.counts.empty() ? 0 : tally.counts.front();
  compare::leave_undecided(rows, tally.failed - unclaimed, tally.trials, kMostLost, "estimates");
  compare::leave_undecided(rows, unclaimed, tally.trials, kMostLost, "estimates", "have no claimed covariance");
  return rows;
}

study::PointResult RobustnessPoint::report(const stats::Tally& tally, const montecarlo::RunOptions&) const {
  std::vector<compare::ComparisonRow> rows = prediction_rows(tally);
  s_.annotations.apply("prediction", rows);
  return {{breakdown_table(s_, variance_ratios_, tally),
           compare::comparison_table("prediction",
                                     "robust losses where no station is wrong: Monte Carlo against first order" +
                                         compare::at_confidence(s_.verdict),
                                     rows, tally.trials, tally.failed, true)},
          {},
          {}};
}

std::string RobustnessPoint::replay(std::uint64_t trial) const {
  const auto lane = static_cast<Eigen::Index>(trial % simd::kGroup);
  const Outcome o = simulate(trial / simd::kGroup * simd::kGroup, simd::kGroup);
  const int stations = setup_.stations();
  std::string text = fmt::format("trial {}\n", trial);
  for (std::size_t e = 0; e < estimators_.size(); ++e)
    text += fmt::format("  {:<13} lateral {:.17g} m, NEES {:.17g}\n", estimator_name(s_, e),
                        o.values(lane, component(e, kLateral)), o.values(lane, component(e, kNees)));
  for (int k = 0; k < stations; ++k)
    if (o.wrong[static_cast<std::size_t>(lane * stations + k)]) {
      text += fmt::format("  station {} is wrong; weights", k + 1);
      for (std::size_t e = 1; e < estimators_.size(); ++e)
        text += fmt::format(" {} {:.4f}", estimator_name(s_, e), o.weights[e](lane, k));
      text += '\n';
    }
  if (!o.claimed[static_cast<std::size_t>(lane)]) text += "  without a claimed covariance\n";
  return text + (o.converged[static_cast<std::size_t>(lane)] ? "  converged\n" : "  NOT converged\n");
}

namespace {

class RobustnessPlan final : public study::PlanOfPoint<Scenario, RobustnessPoint> {
 public:
  using PlanOfPoint::PlanOfPoint;
  std::uint64_t trials() const override { return s_.trials; }
  double cost() const override {
    return static_cast<double>(s_.stations()) * static_cast<double>(s_.losses.size()) * static_cast<double>(s_.trials);
  }
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::robustness_map,
          "How many stations in error a multi-station analysis bears, by loss, kind and size of the errors",
          "robust losses (Huber 1981; Holland and Welsch 1977), LMedS (Rousseeuw 1984) in multi-station analysis",
          study::plan_of<RobustnessPlan, read_scenario>};
}

}  // namespace surveymc::studies::robustness_map
