#include "reliability/gross_error_trials.h"

#include <cmath>

#include "reliability/gross_error_lanes.h"
#include "reliability/snooping.h"
#include "simd/instruction_set.h"

namespace surveymc::reliability {

using Eigen::Index;
using Eigen::VectorXd;

GrossErrorTrials::GrossErrorTrials(const AdjustmentModel& model, const std::vector<survey::Attitude>& attitudes,
                                   const std::vector<GrossError>& errors, const random::Stream& stream)
    : model_(model), attitudes_(attitudes), errors_(errors), stream_(stream) {
  for (const survey::Attitude& at : attitudes) {
    const Observations y = true_observations(at, model.field);
    truth_.push_back({y[0], y[1], y[2], y[3], y[4], y[5]});
  }
  variances_ = adjustment_variances(model, truth_);
}

bool GrossErrorTrials::on_lanes() const {
  return attitudes_.size() == 1 && !(model_.mode == AdjustmentMode::mse_shared && model_.systematic_terms);
}

bool GrossErrorTrials::shots_on_lanes() const {
  return attitudes_.size() > 1 && attitudes_.size() <= kMostShots && model_.mode == AdjustmentMode::mse_shared &&
         !model_.systematic_terms && variances_.head(static_cast<Index>(kReadings * attitudes_.size())).minCoeff() > 0;
}

StationReadings GrossErrorTrials::readings_of(const VectorXd& noise, bool with_errors) const {
  VectorXd error = noise;
  if (with_errors)
    for (const GrossError& e : errors_) error[e.number] += e.size;
  StationReadings y{truth_, {model_.field.gravity, model_.field.total, model_.field.dip}};
  const Index refs = static_cast<Index>(kReadings * truth_.size());
  const bool systematic = noise.size() == refs + 15;
  for (std::size_t k = 0; k < truth_.size(); ++k)
    for (std::size_t i = 0; i < kReadings; ++i) {
      double& reading = y.readings[k][i];
      const auto o = static_cast<Index>(i);
      // Systematic terms are observed as 0, so their draws are their true values with the opposite sign
      if (systematic) reading = (reading + noise[refs + 3 + o]) / (1 - noise[refs + 9 + o]);
      reading += error[static_cast<Index>(kReadings * k) + o];
    }
  if (noise.size() > refs)
    for (std::size_t j = 0; j < 3; ++j) y.references[j] += error[refs + static_cast<Index>(j)];
  return y;
}

StationReadings GrossErrorTrials::readings_without_noise(bool with_errors) const {
  return readings_of(VectorXd::Zero(variances_.size()), with_errors);
}

StationReadings GrossErrorTrials::readings(std::uint64_t trial, bool with_errors) const {
  VectorXd normals(variances_.size());
  for (Index i = 0; i < normals.size(); i += 4) {
    const std::array<double, 4> z =
        stream_.normals<double>(trial, random::Channel::gross_error_study, static_cast<std::uint32_t>(i / 4));
    for (Index k = i; k < std::min(i + 4, normals.size()); ++k) normals[k] = z[static_cast<std::size_t>(k - i)];
  }
  return readings(normals, with_errors);
}

StationReadings GrossErrorTrials::readings(const VectorXd& normals, bool with_errors) const {
  return readings_of(variances_.cwiseSqrt().cwiseProduct(normals), with_errors);
}

void GrossErrorTrials::simulate(std::uint64_t first, survey::LaneArray& without, survey::LaneArray& with,
                                int groups) const {
  const survey::ReferenceField& f = model_.field;
  GrossErrorBatch b{{}, {}, {}, stream_, first, groups, without.row(0, 0), with.row(0, 0)};
  const Observations y = true_observations(attitudes_.front(), f);
  for (std::size_t i = 0; i < kStationObservations; ++i) {
    const bool there = static_cast<Index>(i) < variances_.size();
    b.scale.sd[i] = there ? std::sqrt(variances_[static_cast<Index>(i)]) / relative_unit(i, f) : 0;
    b.truth[i] = y[i] / relative_unit(i, f);
  }
  for (const GrossError& e : errors_) {
    const auto i = static_cast<std::size_t>(e.number);
    b.error[i] += e.size / relative_unit(i, f);
  }
  b.scale.dip = f.dip;
  b.scale.sin_dip = std::sin(f.dip);
  b.scale.cos_dip = std::cos(f.dip);
  b.scale.without_bz = model_.mode == AdjustmentMode::sse_axial;
  simd::run_kernel<isa_v3::gross_error_trials, isa_v4::gross_error_trials>(b);
  // Rare trials whose Gauss-Newton steps do not settle, by the general adjustment: the same for both instruction sets
  for (int t = 0; t < groups * simd::kGroup; ++t)
    for (const bool with_errors : {false, true}) {
      survey::LaneArray& block = with_errors ? with : without;
      if (block.value(t, kConvergedRow) != 0) continue;
      put(tests_of(adjusted(readings(first + static_cast<std::uint64_t>(t), with_errors))), t, block);
    }
}

namespace {

/// Units of the observations on lanes: all readings, then the references.
double lane_unit(const survey::ReferenceField& f, std::size_t observation, std::size_t readings) {
  return relative_unit(observation < readings ? observation % kReadings : kReadings + observation - readings, f);
}

}  // namespace

ShotsModel GrossErrorTrials::shots_model() const {
  ShotsModel m{attitudes_.size(), model_.rotational_shot, {}, std::sin(model_.field.dip), std::cos(model_.field.dip)};
  for (std::size_t i = 0; i < m.observations(); ++i)
    m.sd[i] = std::sqrt(variances_[static_cast<Index>(i)]) / lane_unit(model_.field, i, kReadings * m.shots);
  return m;
}

ShotsRows GrossErrorTrials::shots_rows() const {
  const std::size_t shots = attitudes_.size();
  return {kReadings * shots + 3, model_.rotational_shot ? 6 + shots - 1 : 3 + 3 * shots};
}

ShotsBatch GrossErrorTrials::shots_batch(std::uint64_t first, survey::LaneArray& without, survey::LaneArray& with,
                                         int groups) const {
  ShotsBatch b{shots_model(), {}, {}, stream_, first, groups, without.row(0, 0), with.row(0, 0)};
  const std::size_t readings = kReadings * b.model.shots;
  for (std::size_t i = 0; i < readings; ++i)
    b.truth[i] = truth_[i / kReadings][i % kReadings] / lane_unit(model_.field, i, readings);
  b.truth[readings] = b.truth[readings + 1] = 1;  // the dip is counted from the true one
  for (const GrossError& e : errors_) {
    const auto i = static_cast<std::size_t>(e.number);
    b.error[i] += e.size / lane_unit(model_.field, i, readings);
  }
  return b;
}

void GrossErrorTrials::simulate_shots(std::uint64_t first, survey::LaneArray& without, survey::LaneArray& with,
                                      int groups) const {
  const ShotsBatch b = shots_batch(first, without, with, groups);
  simd::run_kernel<isa_v3::shots_trials, isa_v4::shots_trials>(b);
}

TrialTests GrossErrorTrials::tests_of_shots(const survey::LaneArray& block, int trial) const {
  const ShotsRows rows = shots_rows();
  TrialTests t;
  t.converged = block.value(trial, rows.converged()) != 0;
  t.omega = block.value(trial, rows.omega());
  t.largest = block.value(trial, rows.largest());
  t.w.resize(static_cast<Index>(rows.observations));
  for (Index i = 0; i < t.w.size(); ++i) t.w[i] = block.value(trial, static_cast<int>(i));
  return t;
}

void GrossErrorTrials::model_of_shots(const survey::LaneArray& with, int trial, RedundancyModel& model) const {
  const ShotsRows rows = shots_rows();
  std::array<double, kMostShotObservations> w;
  std::array<double, kMostShotObservations * kMostShotUnknowns> v;
  for (std::size_t i = 0; i < rows.observations; ++i) w[i] = with.value(trial, static_cast<int>(i));
  for (std::size_t i = 0; i < rows.observations * rows.unknowns; ++i)
    v[i] = with.value(trial, rows.base() + static_cast<int>(i));
  model.set(rows.observations, w.data(), rows.unknowns, v.data(), with.value(trial, rows.omega()));
}

void GrossErrorTrials::put(const TrialTests& tests, int trial, survey::LaneArray& block) {
  const auto cell = [&](int row) -> double& { return block.row(trial / simd::kGroup, row)[trial % simd::kGroup]; };
  if (!tests.converged) return;
  for (int i = 0; i < static_cast<int>(kStationObservations); ++i) cell(i) = i < tests.w.size() ? tests.w[i] : 0;
  cell(kOmegaRow) = tests.omega;
  cell(kLargestRow) = tests.largest;
  unsigned tied = 0;
  for (const Index i : tests.suspects) tied |= 1u << i;
  cell(kTiedRow) = tied;
  cell(kConvergedRow) = 1;
}

TrialTests GrossErrorTrials::tests_of(const survey::LaneArray& block, int trial) {
  TrialTests t;
  t.converged = block.value(trial, kConvergedRow) != 0;
  t.omega = block.value(trial, kOmegaRow);
  t.largest = block.value(trial, kLargestRow);
  t.w.resize(static_cast<Index>(kStationObservations));
  const auto tied = static_cast<unsigned>(block.value(trial, kTiedRow));
  for (Index i = 0; i < t.w.size(); ++i) {
    t.w[i] = block.value(trial, static_cast<int>(i));
    if ((tied >> i) & 1u) t.suspects.push_back(i);
  }
  return t;
}

TrialTests GrossErrorTrials::tests_of(const StationAdjustment& a) {
  TrialTests t;
  t.converged = a.converged;
  if (!a.converged) return t;
  t.omega = a.omega;
  t.w = w_statistics(a.parity);
  t.largest = t.w.cwiseAbs().maxCoeff();
  const SnoopingResult worst = data_snooping(a.parity, 0);
  if (!worst.rejected.empty()) t.suspects = worst.rejected.front();
  return t;
}

}  // namespace surveymc::reliability
