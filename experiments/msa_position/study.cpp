/// Study: sensor errors left by multi-station analysis and related estimators, and the position uncertainty due to
/// them, by Monte Carlo and by three analytic propagations. Source: S. Vis, TU Delft 2019 (tables 5-11, figures 6 and
/// 7).
///
///   truth -> readings (sensor) -> gains and biases (estimate) -> corrected survey, minimum curvature (survey) -> tally
///
/// compared with the first-order prediction: covariance of the estimate (estimate), and of the position as
///   joint       the whole first order: what each draw does directly and through the estimate (analysis/first_order.h)
///   systematic  the six sensor errors independent of each other, constant in the run   (wrong: drops correlations)
///   random      independent from station to station                                     (wrong: drops everything)
#include "msa_position/study.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/LU>

#include "analysis/msa_chain.h"
#include "base/units.h"
#include "compare/position_comparison.h"
#include "estimate/estimators.h"
#include "estimate/msa.h"
#include "msa_position/parameter_set.h"
#include "propagate/ellipse.h"
#include "random/study_stream.h"
#include "scenario/disturbance.h"
#include "stats/antithetic.h"
#include "study/experiment.h"
#include "survey/corrected_position.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::msa_position {

using Eigen::Matrix2d;

namespace {

/// The study's first trials choose the start of MSA, for all trials alike (estimate/msa.h).
std::unique_ptr<estimate::Estimator> choose_estimator(const Scenario& s, const sensor::CleanReadings& clean,
                                                      const random::Stream& stream) {
  constexpr int kProbes = 64;
  const std::vector<survey::StationFields> truth = sensor::station_fields(clean);
  if (s.estimator.name != "msa" || s.estimator.solver != "gauss_newton" || !s.estimator.estimates_all())
    return estimate::make_estimator(s.estimator, s.field, truth);
  survey::ReadingBlock readings = sensor::make_reading_block(kProbes, s.survey.size(), s.noise);
  sensor::simulate_readings(clean, s.field, s.noise, stream, 0, readings);
  if (s.spread.any()) {
    survey::LaneArray deviation(readings.groups(), 6);
    sensor::spread_tools(clean, s.spread, s.noise.antithetic, stream, 0, readings, deviation);
  }
  return estimate::make_cheapest_msa({s.estimator.max_iterations, s.estimator.step_tolerance}, s.field, truth,
                                     clean.magnetic_T, readings);
}

/// The comparison tables, in the order of the result.
struct ComparisonTable {
  std::string name, long_name;
};
const std::array<ComparisonTable, 4> kTables{
    {{"parameters", "estimates of gains and biases against the first-order prediction"},
     {"hanak_parameters",
      "estimates in the convention b = (2 - scale) m - offset, against their noise-free values and the consider "
      "covariance"},
     {"position", "final position of the corrected survey against three propagations"},
     {"position_hla", "the same along high side, lateral and hole at the last station"}}};

}  // namespace

Components::Components(const Scenario& s) {
  const auto add = [this](int& place, bool wanted, int size) {
    if (!wanted) return;
    place = count;
    count += size;
  };
  add(nees_horizontal, s.with_position, 3);
  add(axes, s.with_position, 6);
  add(hole, s.with_position, 3);
  add(reference, estimate::estimator_kind(s.estimator.name).estimates_reference, 2);
  add(hanak, s.estimator.name == "wls_consider", 6);
  add(claimed, s.assumed_noise != sensor::AssumedNoise::constant, 6);
}

Model model_of(const Scenario& s) {
  Model m;
  m.clean = sensor::clean_readings(s.survey, s.field, s.errors);
  const std::optional<Eigen::MatrixXd> correlation = s.reference.correlation();
  m.prediction = analysis::predict_msa(s.survey, s.field, s.errors, s.spread, s.noise, m.clean, s.estimator,
                                       correlation ? &*correlation : nullptr);
  m.estimator = choose_estimator(s, m.clean, random::stream_of(s.seed));
  for (std::size_t f = 0; f < kFormulations.size(); ++f) {
    const Matrix2d horizontal = m.prediction.position_covariance[f].topLeftCorner<2, 2>();
    const propagate::Ellipse e = propagate::ellipse(horizontal);
    // An ellipse without area (all errors in one direction) has no Mahalanobis distance and covers nothing.
    m.horizontal_weight[f] = e.semi_minor > 0 ? Matrix2d(horizontal.inverse()) : Matrix2d::Constant(kNaN);
    m.horizontal_axes[f] = e.axes;
  }
  const survey::Station& last = s.survey.stations.back();
  m.hla_from_nev = survey::rotation_hla_from_nev(last.inclination, last.azimuth);
  m.parameter_weight = m.prediction.parameter_covariance.inverse();
  m.true_position = survey::minimum_curvature_positions(s.survey).back();
  if (s.orders.any()) {
    const analysis::MsaChain chain({s.survey, s.field, m.clean, s.noise, s.spread, s.errors}, s.estimator);
    m.orders = orders::predict(chain, s.orders.wanted,
                               [&chain](const orders::Centre& centre) { return chain.directions(centre.state); });
    m.inputs = sensor::names_of(chain.normals(), s.survey.size());
  }
  return m;
}

PositionPoint::PositionPoint(Scenario scenario, Model model)
    : s_(std::move(scenario)),
      rows_(rows_of(s_, &model)),
      stop_(s_.trial_plan, s_.verdict,
            [this](const stats::Tally& t) {
              compare::RowsOfTables all;
              for (const ComparisonTable& table : kTables) all.push_back({table.name, rows_of_table(table.name, t)});
              return all;
            },
            {.own_groups = s_.reference.laws.any() ? 1u : 0u}),
      clean_(std::move(model.clean)),
      md_(s_.survey.md()),
      mixing_(sensor::reference_mixing(s_.reference.laws, s_.noise, s_.survey.size())),
      law_draws_(scenario::law_draws(mixing_)),
      prediction_(std::move(model.prediction)),
      orders_(std::move(model.orders)),
      inputs_(std::move(model.inputs)),
      true_position_(model.true_position),
      stream_(random::stream_of(s_.seed)),
      estimator_(std::move(model.estimator)),
      at_(s_),
      intervals_(compare::at_confidence(s_.verdict)),
      horizontal_weight_(model.horizontal_weight),
      horizontal_axes_(model.horizontal_axes),
      hla_from_nev_(model.hla_from_nev),
      parameter_weight_(model.parameter_weight),
      claimed_weight_(prediction_.claimed_covariance.topLeftCorner<6, 6>().inverse()) {
  if (s_.calibration.on) make_calibrated();
  if (s_.tails.wanted) predict_tails();
}

void PositionPoint::predict_tails() {
  const Eigen::Matrix3d& covariance = prediction_.position_covariance[0];
  Eigen::Matrix<double, 3, 6> directions;
  directions << Eigen::Matrix3d::Identity(), hla_from_nev_.transpose();
  const std::vector<double>& weights = prediction_.weights.reference;
  for (int q = 0; q < 6; ++q) {
    const Eigen::Vector3d u = directions.col(q);
    const double variance = u.dot(covariance * u);
    compare::TailQuantity tail{
        kTailNames[static_cast<std::size_t>(q)], variance > 1e-14 * covariance.trace() ? std::sqrt(variance) : 0, {}};
    if (tail.sd > 0 && !weights.empty()) {
      using Weights = Eigen::Matrix<double, sensor::NoiseWeights::kSums, Eigen::Dynamic>;
      const Eigen::Map<const Weights> of_draws(weights.data(), sensor::NoiseWeights::kSums,
                                               static_cast<Eigen::Index>(weights.size()) / sensor::NoiseWeights::kSums);
      const Eigen::VectorXd along = (u.transpose() * of_draws.bottomRows<3>()).transpose() / tail.sd;
      tail.parts = stats::heavy_parts(mixing_.slots, mixing_.slot_of, along, 1);
    }
    tails_.push_back(std::move(tail));
  }
}

void PositionPoint::count_tails(const Eigen::Ref<const Eigen::MatrixXd>& values, std::uint64_t* counts) const {
  for (std::size_t q = 0; q < tails_.size(); ++q) {
    const int i = static_cast<int>(q), column = i < 3 ? Components::position + i : at_.hole + i - 3;
    // Both errors of an antithetic pair are as large, to first order: the first stands for both.
    for (Eigen::Index t = 0; t < values.rows(); t += antithetic() ? 2 : 1)
      compare::count_beyond(values(t, column), tails_[q].sd, s_.tails, counts + q * s_.tails.k.size());
  }
}

std::uint64_t PositionPoint::trials_needed(const stats::Tally& tally) const {
  if (units(tally) < 2) return s_.trial_plan.trials;  // nothing to predict from
  if (stop_.is_on()) return stop_.trials_needed(tally);
  double needed = 0;
  for (const std::string& quantity : s_.trial_plan.quantities) {
    const auto row = std::find_if(rows_.begin(), rows_.end(),
                                  [&](const compare::Row& r) { return r.controlled && r.quantity == quantity; });
    const stats::ControlledEstimate e = sd_estimate(tally, row->component);
    const bool controlled = s_.control_variate;
    const stats::Interval ci = controlled ? e.controlled_interval : e.plain_interval;
    const double width = (ci.hi - ci.lo) / 2 / (controlled ? e.controlled : e.plain) / s_.trial_plan.relative_ci;
    needed = std::max(needed, std::isfinite(width) ? static_cast<double>(tally.trials) * width * width : 1e18);
  }
  return static_cast<std::uint64_t>(std::ceil(needed));
}

/// The arrays of a batch of trials; reused from batch to batch.
struct PositionPoint::Batch {
  Batch(int trials, const Scenario& s)
      : readings(sensor::make_reading_block(trials, s.survey.size(), s.noise)),
        estimates(trials),
        position(survey::groups_for(trials), 3),
        sums(survey::groups_for(trials), sensor::NoiseWeights::kSums),
        deviation(survey::groups_for(trials), 6),
        nees(survey::groups_for(trials), 1),
        azimuth(survey::groups_for(trials), static_cast<int>(kAzimuths.size())) {
    if (s.assumed_noise != sensor::AssumedNoise::constant) readings.add_assumed_sd();
  }
  survey::ReadingBlock readings;
  estimate::EstimateBlock estimates;
  survey::LaneArray position, sums;
  survey::LaneArray deviation;  ///< of the run's tool from the nominal one
  survey::LaneArray nees;       ///< squared Mahalanobis distance of the parameters from their prediction
  survey::LaneArray azimuth;    ///< tangents of the errors of the calibrated azimuths
};

/// The tallied vector of trial `t` of a batch, and the ellipses it lies in.
template <class Row>
void PositionPoint::observe(const Batch& b, int t, Row& x, std::vector<std::uint64_t>& inside) const {
  for (int i = 0; i < 6; ++i) {
    const double deviation = s_.spread.any() ? b.deviation.value(t, i) : 0;
    x[at_.parameter + i] = b.estimates.parameters.value(t, i) - prediction_.parameters[i] - deviation;
  }
  x[at_.nees_parameters] = b.nees.value(t, 0);
  if (at_.reference >= 0) {
    const double bh = b.estimates.reference.value(t, 0), bv = b.estimates.reference.value(t, 1);
    x[at_.reference] = std::hypot(bh, bv) - s_.field.total;
    x[at_.reference + 1] = (std::atan2(bv, bh) - s_.field.dip) / kDegree;
  }
  for (int i = 0; i < 3 && at_.hanak >= 0; ++i) {
    const HanakPair estimate = hanak_of(b.estimates.parameters.value(t, i), b.estimates.parameters.value(t, 3 + i));
    x[at_.hanak + i] = estimate.scale;
    x[at_.hanak + 3 + i] = estimate.offset;
    if (!s_.spread.any()) continue;
    // As the parameters above: the error of the estimate about the nominal tool, not the spread of the tools.
    const auto a = static_cast<std::size_t>(i);
    const HanakPair nominal = hanak_of(s_.errors.gain[a], s_.errors.bias[a]),
                    own = hanak_of(s_.errors.gain[a] + b.deviation.value(t, i),
                                   s_.errors.bias[a] + b.deviation.value(t, 3 + i));
    x[at_.hanak + i] += nominal.scale - own.scale;
    x[at_.hanak + 3 + i] += nominal.offset - own.offset;
  }
  for (int i = 0; i < 6 && at_.claimed >= 0; ++i) x[at_.claimed + i] = b.estimates.claimed_variance.value(t, i);
  if (!s_.with_position) return;
  Eigen::Vector3d r;
  for (int i = 0; i < 3; ++i) r[i] = x[at_.position + i] = b.position.value(t, i) - prediction_.position[i];
  const Eigen::Vector3d hole = hla_from_nev_ * r;
  for (int i = 0; i < 3; ++i) x[at_.hole + i] = hole[i];
  const double n = r[0], e = r[1];
  for (std::size_t f = 0; f < kFormulations.size(); ++f) {
    const int which = static_cast<int>(f);
    const Matrix2d &w = horizontal_weight_[f], &axes = horizontal_axes_[f];
    const double squared = w(0, 0) * n * n + 2 * w(0, 1) * n * e + w(1, 1) * e * e;
    x[at_.nees_horizontal + which] = squared;
    for (int a = 0; a < 2; ++a) x[at_.axes + 2 * which + a] = axes(0, a) * n + axes(1, a) * e;
    compare::count_inside(squared, inside.data() + 3 * f);
  }
}

stats::Tally PositionPoint::run_block(montecarlo::TrialBlock block) const {
  // A batch fits the first-level caches, and is below the size that the allocator returns to the system each time. Its
  // size changes no bit of the result.
  const int bytes_per_trial = s_.survey.size() * 3 * static_cast<int>(sizeof(double));
  const unsigned fitting = 65536u / static_cast<unsigned>(bytes_per_trial);
  const int batch =
      std::clamp(static_cast<int>(std::bit_floor(fitting)), simd::kGroup, montecarlo::kBlockTrials);  // divides a block
  Batch b(std::min(batch, block.count), s_);
  stats::Tally tally;
  tally.counts.assign(law_counts(), 0);
  // One quantity a column; a few spare rows, or all columns would fall into the same sets of the cache.
  Eigen::MatrixXd values(block.count + 8, at_.count);
  Eigen::MatrixXd controls(s_.control_variate ? block.count + 8 : 0, sensor::NoiseWeights::kSums);
  Eigen::MatrixXd angles(has_azimuths_ ? block.count + 8 : 0, static_cast<Eigen::Index>(kAzimuths.size()));
  // Controls of trials that are not in the statistics: of the failed, and of the others of their antithetic pairs.
  std::vector<Eigen::VectorXd> lost;
  const auto lose = [&](int t) {
    if (!s_.control_variate) return;
    lost.emplace_back(static_cast<int>(sensor::NoiseWeights::kSums));
    for (int q = 0; q < sensor::NoiseWeights::kSums; ++q)
      lost.back()[q] = b.sums.value(t, q) - prediction_.linear.mean[q];
  };
  Eigen::Index kept = 0;
  for (int begin = 0; begin < block.count; begin += batch) {
    const int count = std::min(batch, block.count - begin);
    if (count != b.readings.trials) b = Batch(count, s_);
    const std::uint64_t first = block.first + static_cast<std::uint64_t>(begin);
    simulate(first, b);
    for (int t = 0; t < count; ++t) {
      const std::uint64_t trial = first + static_cast<std::uint64_t>(t);
      ++tally.trials;
      const auto converged = [&b](int i) { return b.estimates.converged.value(i, 0) != 0; };
      if (!converged(t)) {
        tally.add_failed(trial);
        lose(t);
        continue;
      }
      if (antithetic() && !converged(t ^ 1)) {
        ++tally.left_out;
        lose(t);
      } else {
        auto x = values.row(kept);
        observe(b, t, x, tally.counts);
        if (s_.control_variate)
          for (int q = 0; q < sensor::NoiseWeights::kSums; ++q)
            controls(kept, q) = b.sums.value(t, q) - prediction_.linear.mean[q];
        for (int a = 0; a < angles.cols() && has_azimuths_; ++a) angles(kept, a) = b.azimuth.value(t, a);
        ++kept;
      }
      if (trial < s_.save_samples) {
        tally.samples.push_back(static_cast<double>(trial));
        for (int i = 0; i < 6; ++i) tally.samples.push_back(b.estimates.parameters.value(t, i));
        for (int i = 0; i < 3; ++i) tally.samples.push_back(b.position.value(t, i));
      }
    }
  }
  tally.moments = stats::Moments::of(values.topRows(kept));
  if (antithetic()) tally.pairs = stats::Moments::of(stats::pair_columns(values.topRows(kept)));
  count_calibration(values.topRows(kept), angles, tally.counts);
  count_tails(values.topRows(kept), tally.counts.data() + tail_counts());
  compare::DrawnLaws::add(stream_, law_draws_, block, antithetic(), tally);
  stop_.keep(block, tally);
  for (std::size_t p = 0; p < kControlledPairs.size() && s_.control_variate; ++p) {
    const auto [i, j] = kControlledPairs[p];
    const Eigen::MatrixXd columns = stats::control_columns(values.col(i).head(kept), values.col(j).head(kept),
                                                           controls.col(i).head(kept), controls.col(j).head(kept));
    tally.controlled.push_back(stats::Moments::of(columns));
    if (antithetic()) tally.controlled_pairs.push_back(stats::Moments::of(stats::pair_means(columns)));
  }
  for (std::size_t p = 0; p < kControlledPairs.size() && !lost.empty(); ++p) {
    const auto [i, j] = kControlledPairs[p];
    Eigen::MatrixXd of_pair(static_cast<Eigen::Index>(lost.size()), 2);
    for (std::size_t t = 0; t < lost.size(); ++t) of_pair.row(static_cast<Eigen::Index>(t)) << lost[t][i], lost[t][j];
    const Eigen::MatrixXd columns = stats::lost_columns(of_pair.col(0), of_pair.col(1));
    tally.controlled.push_back(stats::Moments::of(columns));
    if (antithetic()) tally.controlled_pairs.push_back(stats::Moments::of(stats::pair_means(columns)));
  }
  return tally;
}

study::PointResult PositionPoint::report(const stats::Tally& tally, const montecarlo::RunOptions&) const {
  study::PointResult r;
  std::vector<compare::ComparisonRow> published;
  for (const ComparisonTable& table : kTables) {
    std::vector<compare::ComparisonRow> rows = rows_of_table(table.name, tally);
    if (rows.empty()) continue;
    stop_.add_notes(table.name, rows, tally);
    r.tables.push_back(
        compare::comparison_table(table.name, table.long_name + intervals_, rows, tally.trials, tally.failed, true));
    if (table.name != "position_hla") published.insert(published.end(), rows.begin(), rows.end());
  }
  if (s_.with_position) {
    r.tables.push_back(ellipse_table(tally));
    r.tables.push_back(covariance_table(tally));
    if (orders_ && orders_->second) r.tables.push_back(orders_table(tally));
    if (orders_ && orders_->profile) {
      r.tables.push_back(order_coverage_table(tally));
      r.tables.push_back(profile_path_table());
      r.tables.push_back(density_table());
    }
  }
  if (s_.tails.wanted) {
    const bool drawn = tally.trials > 0;
    r.tables.push_back(compare::tails_table(tails_, s_.tails, drawn ? tally.counts.data() + tail_counts() : nullptr,
                                            units(tally), s_.verdict, s_.annotations, tally.trials, tally.failed));
    const bool has_law = drawn && !mixing_.slots.empty();
    r.tables.push_back(compare::laws_table(s_.reference.laws, law_draws_, has_law ? &tally.groups.front() : nullptr,
                                           has_law ? tally.counts.data() + law_counts() : nullptr,
                                           s_.verdict.confidence));
  }
  r.tables.push_back(covariance_tests_table(tally));
  r.tables.push_back(correlation_table(tally));
  if (s_.control_variate) r.tables.push_back(control_variate_table(tally));
  if (s_.annotations.has_published()) r.tables.push_back(compare::published_fit_table(published));
  for (store::Table& t :
       compare::calibration_tables(s_.calibration, calibrated_, tally.counts, kCounts, antithetic(), s_.annotations))
    r.tables.push_back(std::move(t));
  if (stop_.is_on()) r.tables.push_back(stop_.looks_table(tally));
  r.tables.push_back(compare::failed_trials_table("trials without a converged estimate", tally.failed_trials));
  if (antithetic()) r.tables.push_back(pairs_table(tally));
  if (s_.reference.disturbance)
    r.tables.push_back(scenario::disturbance_table(*s_.reference.disturbance, s_.field, &stream_));
  if (s_.save_samples > 0) r.samples = {samples_table(tally)};
  return r;
}

std::string PositionPoint::replay(std::uint64_t trial) const {
  const std::uint64_t first = trial / simd::kGroup * simd::kGroup;
  const int lane = static_cast<int>(trial % simd::kGroup);
  Batch b(simd::kGroup, s_);
  simulate(first, b);
  std::string text = fmt::format("trial {}\n", trial);
  text += fmt::format("  reference field  Bh {:.17g} nT, Bv {:.17g} nT (station 0)\n",
                      b.readings.reference.value(lane, 0), b.readings.reference.value(lane, 1));
  for (std::size_t i = 0; i < 6 && s_.spread.any(); ++i)
    text +=
        fmt::format("  true {:<11} {:.17g} {}\n", estimate::kParameterNames[i],
                    (i < 3 ? s_.errors.gain[i] : s_.errors.bias[i - 3]) + b.deviation.value(lane, static_cast<int>(i)),
                    estimate::kParameterUnits[i]);
  if (at_.reference >= 0)
    text += fmt::format("  estimated field  Bh {:.17g} nT, Bv {:.17g} nT (station 0)\n",
                        b.estimates.reference.value(lane, 0), b.estimates.reference.value(lane, 1));
  for (int i = 0; i < 6; ++i)
    text += fmt::format("  {:<16} {:.17g} {}\n", estimate::kParameterNames[static_cast<std::size_t>(i)],
                        b.estimates.parameters.value(lane, i), estimate::kParameterUnits[static_cast<std::size_t>(i)]);
  text += fmt::format("  cost             {:.17g} nT2 after {} evaluations, {}\n", b.estimates.cost.value(lane, 0),
                      b.estimates.iterations.value(lane, 0),
                      b.estimates.converged.value(lane, 0) != 0 ? "converged" : "NOT converged");
  for (int i = 0; i < 3 && s_.with_position; ++i)
    text += fmt::format("  {:<16} {:.17g} m\n", kDirections[static_cast<std::size_t>(i)], b.position.value(lane, i));
  return text;
}

void PositionPoint::simulate(std::uint64_t first, Batch& b) const {
  const sensor::NoiseWeights* weights = s_.control_variate ? &prediction_.weights : nullptr;
  const survey::LaneArray made = s_.reference.made(stream_, first, s_.noise.antithetic, b.readings.groups());
  sensor::simulate_readings(clean_, s_.field, s_.noise, stream_, first, b.readings, weights, &b.sums, &mixing_,
                            s_.reference.disturbed ? &made : nullptr);
  if (s_.spread.any())
    sensor::spread_tools(clean_, s_.spread, s_.noise.antithetic, stream_, first, b.readings, b.deviation, weights,
                         &b.sums);
  if (b.readings.has_assumed_sd)
    sensor::draw_assumed_sd(s_.assumed_noise, s_.estimator.assumed.magnetometer, stream_, first, b.readings);
  estimator_->solve(b.readings, b.estimates);
  for (int group = 0; group < b.readings.groups(); ++group) {
    parameter_nees(b, group, b.nees.row(group, 0));
    if (has_azimuths_) azimuth_errors(b, group);
  }
  if (s_.with_position)
    survey::corrected_final_positions(b.readings, b.estimates.parameters, md_, s_.field.declination, b.position);
}

/// Trial by trial of a group; the inner loops are as long as a register.
void PositionPoint::parameter_nees(const Batch& b, int group, double* nees) const {
  double error[6][simd::kGroup];
  for (int i = 0; i < 6; ++i)
    for (int t = 0; t < simd::kGroup; ++t)
      error[i][t] = b.estimates.parameters.row(group, i)[t] - prediction_.parameters[i] -
                    (s_.spread.any() ? b.deviation.row(group, i)[t] : 0);
  double sum[simd::kGroup] = {};
  for (int i = 0; i < 6; ++i) {
    double row[simd::kGroup] = {};  // the lower half of the weight, whose off-diagonal elements count twice
    for (int j = 0; j <= i; ++j)
      for (int t = 0; t < simd::kGroup; ++t) row[t] += (j < i ? 2 : 1) * parameter_weight_(i, j) * error[j][t];
    for (int t = 0; t < simd::kGroup; ++t) sum[t] += row[t] * error[i][t];
  }
  std::copy(sum, sum + simd::kGroup, nees);
}

/// The hole's azimuth is atan2(e_z, n_z) with east e = u x b and north n = b - (u.b) u, both of length Bh.
void PositionPoint::azimuth_errors(Batch& b, int group) const {
  for (std::size_t place = 0; place < azimuth_places_.size(); ++place) {
    const int row = 3 * static_cast<int>(azimuth_places_[place]);
    const double s = sin_azimuth_[place], c = cos_azimuth_[place];
    double* out = b.azimuth.row(group, static_cast<int>(place));
    for (int t = 0; t < simd::kGroup; ++t) {
      double u[3], field[3];
      for (int i = 0; i < 3; ++i) {
        u[i] = b.readings.down.row(group, row + i)[t];
        field[i] = (b.readings.magnetic.row(group, row + i)[t] - b.estimates.parameters.row(group, 3 + i)[t]) /
                   b.estimates.parameters.row(group, i)[t];
      }
      const double east = u[0] * field[1] - u[1] * field[0],
                   north = field[2] - (u[0] * field[0] + u[1] * field[1] + u[2] * field[2]) * u[2];
      const double across = east * c - north * s, along = north * c + east * s;
      out[t] = along > 0 ? across / along : across > 0 ? kInfinity : -kInfinity;
    }
  }
}

stats::SampleSummary PositionPoint::sample(const stats::Tally& tally, int component) const {
  if (units(tally) < 2) return {};
  return antithetic() ? stats::summarise_pairs(tally.moments, tally.pairs, component)
                      : stats::summarise(tally.moments, component);
}

Eigen::MatrixXd PositionPoint::covariance(const stats::Tally& tally) const {
  return antithetic() ? stats::paired_covariance(tally.moments, tally.pairs) : tally.moments.covariance();
}

stats::LostTrials PositionPoint::lost_trials(const stats::Tally& tally, std::size_t p) {
  const std::size_t at = kControlledPairs.size() + p;
  return {at < tally.controlled.size() ? &tally.controlled[at] : nullptr,
          at < tally.controlled_pairs.size() ? &tally.controlled_pairs[at] : nullptr};
}

stats::ControlledEstimate PositionPoint::sd_estimate(const stats::Tally& tally, int component) const {
  const auto p = static_cast<std::size_t>(component);  // kControlledPairs begins with the nine variances
  if (s_.control_variate)
    return stats::controlled_sd(tally.controlled[p], prediction_.linear.covariance(component, component),
                                s_.verdict.interval_confidence(units(tally)), controlled_pairs(tally, p),
                                lost_trials(tally, p));
  stats::ControlledEstimate e;
  const stats::SampleSummary s = sample(tally, component);
  e.plain = std::sqrt(s.variance);
  e.plain_interval = stats::sd_interval(s, s_.verdict.confidence);
  return e;
}

namespace {

class MsaPositionPlan final : public study::PlanOf<Scenario> {
 public:
  using PlanOf::PlanOf;
  double cost() const override { return 1.0 * s_.survey.size() * static_cast<double>(s_.trial_plan.trials); }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    return s_.survey_place.with_place([&] { return std::make_unique<PositionPoint>(s_, model_of(s_)); });
  }
};

}  // namespace

study::Experiment experiment() {
  study::Experiment e{random::StudyId::msa_position,
                      "Multi-station analysis and weighted least squares: errors left in parameters and final position",
                      "S. Vis, TU Delft 2019, tables 5 to 11, figures 6 and 7",
                      [](config::ConfigReader& config, random::StudySeed seed) -> std::unique_ptr<study::PointPlan> {
                        if (std::optional<SetScenario> set = read_set_scenario(config, seed))
                          return set_plan(std::move(*set));
                        Scenario s = read_scenario(config, seed);
                        // A survey's geometry may be one that no run can have: with_place() says which survey, in which
                        // case.
                        if (!s.events.empty())
                          return events::event_plan(
                              s.event_run, s.annotations, random::stream_of(s.seed),
                              [s] { return s.survey_place.with_place([&] { return events_of(s); }); },
                              montecarlo::kBlockTrials, s.survey.size());
                        return std::make_unique<MsaPositionPlan>(std::move(s));
                      }};
  e.approximations = {"systematic", "random"};
  return e;
}

}  // namespace surveymc::studies::msa_position
