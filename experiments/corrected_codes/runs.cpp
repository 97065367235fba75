#include "corrected_codes/runs.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/units.h"
#include "estimate/estimators.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::corrected_codes {

namespace {

constexpr double kPlausible = 4;       // sd of the axial errors: more is no other explanation of a reading
constexpr double kSameMinimum = 1e-3;  // nT^2: two minima whose costs differ by less are one

}  // namespace

CorrectedRuns::CorrectedRuns(const analysis::CodeCase& which, const survey::Survey& well,
                             const survey::ReferenceField& field, const analysis::CodeComparison& comparison)
    : which_(which),
      setup_(sensor::disturbed_run_setup(well, field)),
      tied_(survey::tied_survey(well, field.declination, which.claimed->first_leg_doubled())),
      uncorrected_(1, 6, true),
      position_(survey::minimum_curvature_positions(well).back()) {
  const propagate::CodeDraws& d = which_.draws;
  setup_.sd = d.sensors;
  setup_.interference = d.interference;
  setup_.run = {d.run.total, d.run.dip, d.run.declination_in(field)};
  setup_.station = {d.station.total, d.station.dip, d.station.declination_in(field)};
  setup_.noise = which_.noise;
  setup_.turned = which_.turned;
  for (int i = 0; i < 6; ++i) uncorrected_.fill(0, i, i < 3 ? 1 : 0);
  if (which_.correction.kind == analysis::Correction::Kind::none) return;
  if (reads_gravity()) {
    which_.correction.parameters = analysis::in_field(which_.correction.parameters, field);
    plan_ = multistation::fit_plan(which_.correction.parameters);
    return;
  }
  std::vector<survey::Vec3<double>> expected;
  for (const survey::StationFields& f : comparison.stations.fields) expected.push_back(f.field_T);
  const bool whole_run = which_.correction.kind == analysis::Correction::Kind::run;
  // Without errors the six parameters of a straight hole are not determined: there is no start near their estimate.
  const bool near = whole_run && comparison.after.determined;
  estimator_ = estimate::make_estimator(whole_run ? which_.correction.estimator : analysis::axial_estimator(), field,
                                        near ? comparison.stations.fields : std::vector<survey::StationFields>(),
                                        near ? expected : std::vector<survey::Vec3<double>>());
}

namespace {

/// The axial reading with which the horizontal field of a station is as strong as with its own: near the other minimum
/// of the axial correction. |u x b|^2 is a parabola in the axial field.
double mirrored(const survey::ReadingBlock& one, int group, int lane) {
  const auto at = [&](const survey::LaneArray& rows, int axis) { return rows.row(group, axis)[lane]; };
  const double ux = at(one.down, 0), uy = at(one.down, 1), across = ux * ux + uy * uy;
  const double middle = at(one.down, 2) * (ux * at(one.magnetic, 0) + uy * at(one.magnetic, 1)) / across;
  return across > 0 ? 2 * middle - at(one.magnetic, 2) : at(one.magnetic, 2);
}

}  // namespace

void CorrectedRuns::correct_stations(survey::ReadingBlock& readings, survey::LaneArray& converged,
                                     survey::LaneArray& ambiguous) const {
  survey::ReadingBlock one(readings.trials, 1, true, false);
  estimate::EstimateBlock estimates(readings.trials), other(readings.trials);
  const double most = kPlausible * which_.draws.axial_bias();
  for (int g = 0; g < readings.groups(); ++g) {
    for (int r = 0; r < 2; ++r) std::copy_n(readings.reference.row(g, r), simd::kGroup, one.reference.row(g, r));
    std::fill_n(converged.row(g, 0), simd::kGroup, 1.0);
  }
  for (int k = 0; k < readings.stations; ++k) {
    for (int g = 0; g < readings.groups(); ++g)
      for (int axis = 0; axis < 3; ++axis) {
        std::copy_n(readings.magnetic.row(g, 3 * k + axis), simd::kGroup, one.magnetic.row(g, axis));
        std::copy_n(readings.down.row(g, 3 * k + axis), simd::kGroup, one.down.row(g, axis));
      }
    estimator_->solve(one, estimates);
    for (int g = 0; g < readings.groups(); ++g)
      for (int lane = 0; lane < simd::kGroup; ++lane) one.magnetic.row(g, 2)[lane] = mirrored(one, g, lane);
    estimator_->solve(one, other);
    for (int g = 0; g < readings.groups(); ++g)
      for (int lane = 0; lane < simd::kGroup; ++lane) {
        // The axial field of the other minimum, and the error of the reading that it would mean.
        const double axial = one.magnetic.row(g, 2)[lane] - other.parameters.row(g, 5)[lane],
                     error = readings.magnetic.row(g, 3 * k + 2)[lane] - axial;
        if (other.converged.row(g, 0)[lane] != 0 && std::abs(error) < most &&
            other.cost.row(g, 0)[lane] < estimates.cost.row(g, 0)[lane] - kSameMinimum)
          ambiguous.row(g, 0)[lane] = 1;
        readings.magnetic.row(g, 3 * k + 2)[lane] -= estimates.parameters.row(g, 5)[lane];
        if (estimates.converged.row(g, 0)[lane] == 0) converged.row(g, 0)[lane] = 0;
      }
  }
}

void CorrectedRuns::correct_parameters(survey::ReadingBlock& readings, const survey::LaneArray& gravity,
                                       const random::Stream& stream, std::uint64_t first,
                                       survey::LaneArray& converged) const {
  const multistation::FitOptions& o = which_.correction.parameters;
  multistation::SixAxisBlock both(readings.trials, readings.stations);
  for (int g = 0; g < readings.groups(); ++g) {
    for (int k = 0; k < readings.stations; ++k)
      for (int row = 3 * k; row < 3 * k + 3; ++row) {
        std::copy_n(readings.magnetic.row(g, row), simd::kGroup, both.magnetic.row(g, row));
        for (int lane = 0; lane < simd::kGroup; ++lane)
          both.gravity.row(g, row)[lane] = gravity.row(g, k)[lane] * readings.down.row(g, row)[lane];
      }
    std::fill_n(both.reference.row(g, 0), simd::kGroup, setup_.field.gravity);
    for (int r = 0; r < 2; ++r) std::copy_n(readings.reference.row(g, r), simd::kGroup, both.reference.row(g, 1 + r));
  }
  multistation::FitBlock found(readings.trials, o);
  multistation::RobustBlock robust(readings.trials, readings.stations);
  multistation::fit_block_by_loss(both, plan_, o.parameters, which_.correction.robust, stream, first, found, robust);
  multistation::correct_block(both, plan_, o.parameters, found);
  for (int g = 0; g < readings.groups(); ++g) {
    std::copy_n(found.converged.row(g, 0), simd::kGroup, converged.row(g, 0));
    for (int k = 0; k < readings.stations; ++k)
      for (int lane = 0; lane < simd::kGroup; ++lane) {
        const auto down = [&](int axis) { return both.gravity.row(g, 3 * k + axis)[lane]; };
        const double length = std::hypot(down(0), down(1), down(2));
        for (int axis = 0; axis < 3; ++axis) {
          readings.down.row(g, 3 * k + axis)[lane] = down(axis) / length;
          readings.magnetic.row(g, 3 * k + axis)[lane] = both.magnetic.row(g, 3 * k + axis)[lane];
        }
      }
  }
}

CorrectedRun CorrectedRuns::correct(survey::ReadingBlock readings, const survey::LaneArray& gravity,
                                    const random::Stream& stream, std::uint64_t first) const {
  const int groups = readings.groups();
  CorrectedRun out{{{groups, 3}, {groups, 3}},
                   {{groups, stations()}, {groups, stations()}},
                   survey::LaneArray(groups, 1),
                   survey::LaneArray(groups, 1)};
  survey::corrected_tied_positions(readings, uncorrected_, tied_, out.position[0], out.lateral[0]);
  for (int g = 0; g < groups; ++g) std::fill_n(out.converged.row(g, 0), simd::kGroup, 1.0);
  if (which_.correction.kind == analysis::Correction::Kind::run) {
    estimate::EstimateBlock estimates(readings.trials);
    estimator_->solve(readings, estimates);
    survey::corrected_tied_positions(readings, estimates.parameters, tied_, out.position[1], out.lateral[1]);
    for (int g = 0; g < groups; ++g) std::copy_n(estimates.converged.row(g, 0), simd::kGroup, out.converged.row(g, 0));
    return out;
  }
  if (which_.correction.kind == analysis::Correction::Kind::station)
    correct_stations(readings, out.converged, out.ambiguous);
  if (reads_gravity()) correct_parameters(readings, gravity, stream, first, out.converged);
  survey::corrected_tied_positions(readings, uncorrected_, tied_, out.position[1], out.lateral[1]);
  return out;
}

CorrectedRun CorrectedRuns::run(const random::Stream& stream, std::uint64_t first, int count,
                                const survey::LaneArray* made) const {
  survey::ReadingBlock readings = sensor::make_disturbed_block(count, setup_);
  survey::LaneArray gravity;
  if (reads_gravity()) gravity = survey::LaneArray(readings.groups(), stations());
  sensor::draw_disturbed_runs(setup_, stream, first, readings, made, reads_gravity() ? &gravity : nullptr);
  return correct(std::move(readings), gravity, stream, first);
}

std::vector<CorrectedRuns::DrawnRow> CorrectedRuns::drawn_rows() const {
  std::vector<DrawnRow> rows;
  const auto add = [&rows](int row, std::size_t input, double size) {
    if (size > 0) rows.push_back({row, input});
  };
  for (std::size_t i = 0; i < survey::kSensorTerms; ++i) add(static_cast<int>(i), i, setup_.sd[i]);
  const int of_run = static_cast<int>(survey::kSensorTerms);
  add(of_run, analysis::kInterference, setup_.interference);
  add(of_run + 1, analysis::kTotalField, setup_.run.total);
  add(of_run + 2, analysis::kDip, setup_.run.dip);
  add(of_run + 3, analysis::kDeclination, setup_.run.declination);
  const int first = of_run + 4, noise = first + 3 * stations();
  for (int k = 0; k < stations(); ++k) {
    add(first + 3 * k, analysis::kStationTotalField, setup_.station.total);
    add(first + 3 * k + 1, analysis::kStationDip, setup_.station.dip);
    add(first + 3 * k + 2, analysis::kStationDeclination, setup_.station.declination);
    for (int axis = 0; axis < 3; ++axis) add(noise + 3 * k + axis, analysis::kMagnetometerNoise, setup_.noise);
  }
  return rows;
}

std::vector<std::string> CorrectedRuns::inputs() const {
  std::vector<std::string> names;
  for (const DrawnRow& r : drawn_rows()) names.emplace_back(analysis::kCodeInputNames[r.input]);
  return names;
}

orders::DifferenceChain CorrectedRuns::chain() const {
  assert(!reads_gravity());
  const std::vector<DrawnRow> rows = drawn_rows();
  const auto values = [this, rows](const Eigen::MatrixXd& z) {
    constexpr Eigen::Index kBatch = 64;  // their readings stay in the cache
    const int all = static_cast<int>(survey::kSensorTerms) + 4 + 6 * stations();
    Eigen::Matrix3Xd out(3, z.cols());
    for (Eigen::Index from = 0; from < z.cols(); from += kBatch) {
      const int count = static_cast<int>(std::min(kBatch, z.cols() - from));
      survey::ReadingBlock readings = sensor::make_disturbed_block(count, setup_);
      survey::LaneArray lanes(readings.groups(), all);
      for (int t = 0; t < count; ++t)
        for (std::size_t r = 0; r < rows.size(); ++r)
          lanes.row(t / simd::kGroup, rows[r].row)[t % simd::kGroup] = z(static_cast<Eigen::Index>(r), from + t);
      sensor::disturbed_readings(setup_, lanes, readings);
      const CorrectedRun run = correct(std::move(readings), {}, random::Stream(0, 0), 0);
      for (int t = 0; t < count; ++t)
        for (int a = 0; a < 3; ++a)
          out(a, from + t) = run.converged.value(t, 0) != 0 ? run.position[1].value(t, a) - position_[a] : kNaN;
    }
    return out;
  };
  return {static_cast<Eigen::Index>(rows.size()), values};
}

}  // namespace surveymc::studies::corrected_codes
