/// The rows of the study `msa_position`, each declared once, and the comparison that it becomes.
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/position_comparison.h"
#include "estimate/estimators.h"
#include "msa_position/study.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::msa_position {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

namespace {

/// What a config's rows have before the run is prepared: no number.
const Model& no_model() {
  static const Model none = [] {
    Model m;
    analysis::MsaPrediction& p = m.prediction;
    const auto blank = [](auto&... numbers) { (numbers.setConstant(kNaN), ...); };
    blank(p.parameters, p.parameter_covariance, p.reference_shift, p.reference_covariance, p.claimed_covariance,
          p.position, p.uncorrected, p.position_covariance[0], p.position_covariance[1], p.position_covariance[2],
          m.horizontal_axes[0], m.hla_from_nev);
    p.claimed_azimuth_sd.fill(kNaN);
    return m;
  }();
  return none;
}

/// The nominal tool's gains and biases.
Vector6d tool_of(const Scenario& s) {
  Vector6d tool;
  for (int i = 0; i < 6; ++i) tool[i] = i < 3 ? s.errors.gain[i] : s.errors.bias[i - 3];
  return tool;
}

/// The tallied NEES is then that of the claim.
bool claims_what_is_predicted(const Vector6d& tool, const analysis::MsaPrediction& p) {
  const Matrix6d claimed = p.claimed_covariance.topLeftCorner<6, 6>();
  for (int i = 0; i < 6; ++i) {
    if (!(std::abs(p.parameters[i] - tool[i]) <= 1e-9 * std::sqrt(claimed(i, i)))) return false;
    for (int j = 0; j <= i; ++j)
      if (!(std::abs(claimed(i, j) - p.parameter_covariance(i, j)) <= 1e-12 * std::sqrt(claimed(i, i) * claimed(j, j))))
        return false;
  }
  return true;
}

/// Mean and claimed covariance of the estimates in Hanak's convention.
struct HanakPrediction {
  Vector6d mean;
  Matrix6d covariance;
};
HanakPrediction hanak_prediction(const Vector6d& tool, const analysis::MsaPrediction& p) {
  Matrix6d by_parameters = Matrix6d::Zero();
  Vector6d truth;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double gain = tool[i], bias = tool[3 + i];
    truth[i] = hanak_of(gain, bias).scale;
    truth[3 + i] = hanak_of(gain, bias).offset;
    by_parameters(i, i) = 1 / (gain * gain);
    by_parameters(3 + i, i) = -bias / (gain * gain);
    by_parameters(3 + i, 3 + i) = 1 / gain;
  }
  const Vector6d shift = p.parameters - tool;  // of the estimate, by priors and by noise with a mean
  const Matrix6d claimed = p.claimed_covariance.topLeftCorner<6, 6>();
  return {truth + by_parameters * shift, by_parameters * claimed * by_parameters.transpose()};
}

}  // namespace

compare::Row& RowAdder::operator()(const char* table, const char* formulation, const std::string& quantity,
                                   const char* unit, compare::Statistic statistic, int component,
                                   double prediction) const {
  return rows_.emplace_back(compare::Row{.table = table,
                                         .formulation = formulation,
                                         .quantity = quantity,
                                         .unit = unit,
                                         .statistic = statistic,
                                         .component = component,
                                         .sigmas = 3,
                                         .prediction = prediction});
}

double sd_above_rounding(double variance, const Eigen::Matrix3d& covariance) {
  return variance > 1e-14 * covariance.trace() ? std::sqrt(variance) : 0;
}

std::vector<compare::Row> rows_of(const Scenario& s, const Model* model) {
  using enum compare::Statistic;
  const Model& m = model ? *model : no_model();
  const analysis::MsaPrediction& p = m.prediction;
  const estimate::EstimatorKind& kind = estimate::estimator_kind(s.estimator.name);
  const Components at(s);
  // Weights that are drawn anew in every run have no linear prediction.
  const bool linear = s.assumed_noise == sensor::AssumedNoise::constant, has_position = s.with_position,
             has_reference = kind.estimates_reference, has_hanak = at.hanak >= 0;
  const Vector6d tool = tool_of(s);
  std::vector<compare::Row> rows;
  const RowAdder add(rows);
  const auto sigma3 = [](const char* of) { return std::string("sigma3_") + of; };
  const auto mean_of = [](const char* of) { return std::string("mean_") + of; };
  const auto& names = estimate::kParameterNames;
  const auto& units = estimate::kParameterUnits;
  const std::array<double, 2> reference_unit{1, kDegree}, reference{s.field.total, s.field.dip / kDegree};

  for (int i = 0; i < 6; ++i) {
    compare::Row& row = add("parameters", "", mean_of(names[i]), units[i], mean, at.parameter + i, kNaN);
    row.offset = p.parameters[i];
    row.predicted = linear;
    if (linear) row.prediction = p.parameters[i];
  }
  for (int i = 0; i < 6; ++i) {
    compare::Row& row = add("parameters", "first_order", sigma3(names[i]), units[i], sd, at.parameter + i,
                            linear ? std::sqrt(p.parameter_covariance(i, i)) : kNaN);
    row.predicted = linear;
    row.controlled = true;
  }
  // The claim of the estimator, by the errors that it assumes; MSA assumes nothing and makes no claim.
  for (int i = 0; i < 6; ++i) {
    compare::Row& row = add("parameters", "claimed", sigma3(names[i]), units[i], sd, at.parameter + i,
                            std::sqrt(p.claimed_covariance(i, i)));
    if (!linear) row.variance = at.claimed + i;
    row.available = kind.weighs;
  }
  for (int i = 0; i < 2; ++i) {
    compare::Row& row = add("parameters", "", mean_of(kReference[i]), kReferenceUnits[i], mean, at.reference + i,
                            reference[i] + p.reference_shift[i] / reference_unit[i]);
    row.offset = reference[i];
    row.available = has_reference;
  }
  for (const bool claimed : {false, true})
    for (int i = 0; i < 2; ++i) {
      const double variance = claimed ? p.claimed_covariance(6 + i, 6 + i) : p.reference_covariance(i, i);
      add("parameters", claimed ? "claimed" : "first_order", sigma3(kReference[i]), kReferenceUnits[i], sd,
          at.reference + i, std::sqrt(variance) / reference_unit[i])
          .available = has_reference;
    }
  compare::Row& distance = add("parameters", "", "nees", "1", squared_distance, at.nees_parameters, 6);
  distance.predicted = false;  // a NEES has no confidence sequence
  distance.available = linear && (model == nullptr || p.parameter_covariance(0, 0) > 0);

  const HanakPrediction hanak = hanak_prediction(tool, p);
  for (const bool of_mean : {true, false})
    for (int i = 0; i < 6; ++i) {
      add("hanak_parameters", "", of_mean ? mean_of(kHanakParameters[i]) : sigma3(kHanakParameters[i]), units[i],
          of_mean ? mean : sd, at.hanak + i, of_mean ? hanak.mean[i] : std::sqrt(hanak.covariance(i, i)))
          .available = has_hanak;
    }

  for (int i = 0; i < 3; ++i) {
    const double correction = p.position[i] - p.uncorrected[i];
    compare::Row& row =
        add("position", "", std::string("correction_") + kDirections[i], "m", mean, at.position + i, correction);
    row.offset = correction;
    row.available = has_position;
  }
  // Beyond first order: mean and sd.
  for (const std::string& name : s.orders.names) {
    if (name == "first") continue;
    const std::optional<orders::Moments> found = m.orders ? m.orders->of(name) : std::nullopt;
    for (const bool of_mean : {true, false})
      for (int i = 0; i < 3; ++i) {
        const double offset = p.position[i] - p.uncorrected[i];
        compare::Row& row = add("position", name.c_str(),
                                of_mean ? std::string("correction_") + kDirections[i] : sigma3(kDirections[i]), "m",
                                of_mean ? mean : sd, at.position + i,
                                !found    ? kNaN
                                : of_mean ? m.true_position[i] + found->mean[i] - p.uncorrected[i]
                                          : std::sqrt(found->covariance(i, i)));
        if (of_mean) row.offset = offset;
      }
  }
  for (std::size_t f = 0; f < kFormulations.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      compare::Row& row = add("position", kFormulations[f], sigma3(kDirections[i]), "m", sd, at.position + i,
                              std::sqrt(p.position_covariance[f](i, i)));
      row.controlled = true;
      row.available = has_position;
    }
  for (std::size_t f = 0; f < kFormulations.size(); ++f) {
    const Eigen::Matrix3d c = m.hla_from_nev * p.position_covariance[f] * m.hla_from_nev.transpose();
    for (int i = 0; i < 3; ++i)
      add("position_hla", kFormulations[f], sigma3(kHoleDirections[i]), "m", sd, at.hole + i,
          sd_above_rounding(c(i, i), c))
          .available = has_position;
  }
  for (const char* f : kFormulations) {
    compare::Row& row = add("ellipse", f, "ellipse", "", other, -1, kNaN);
    row.predicted = false;
    row.available = has_position;
  }

  for (compare::Row& row : compare::tail_rows(kTailNames, s.tails)) rows.push_back(std::move(row));

  const auto calibrate = [&](const char* formulation, const char* quantity, compare::Statistic statistic, int component,
                             double offset, double prediction) -> compare::Row& {
    compare::Row& row = add("calibration", formulation, quantity, "", statistic, component, prediction);
    row.offset = offset;
    row.calibrated = true;
    row.available = linear;
    return row;
  };
  for (int i = 0; i < 6; ++i) {
    compare::Row& row = calibrate("claimed", names[i], sd, at.parameter + i, p.parameters[i] - tool[i],
                                  linear ? std::sqrt(p.claimed_covariance(i, i)) : 1);
    if (!linear) row.variance = at.claimed + i;
    row.available = true;
  }
  for (int i = 0; i < 2; ++i)
    calibrate("claimed", kReference[i], sd, at.reference + i, 0,
              std::sqrt(p.claimed_covariance(6 + i, 6 + i)) / reference_unit[i])
        .available = linear && has_reference;
  calibrate("claimed", "nees", squared_distance,
            claims_what_is_predicted(tool, p) ? at.nees_parameters : kClaimedDistance, 0, 6);
  for (int i = 0; i < 3; ++i) calibrate("claimed", kAzimuths[i], angle, kAzimuth - i, 0, p.claimed_azimuth_sd[i]);
  const Eigen::Matrix3d& joint = p.position_covariance[0];
  const Eigen::Vector3d off = p.position - Eigen::Vector3d(survey::minimum_curvature_positions(s.survey).back());
  for (int i = 0; i < 3; ++i)
    calibrate("joint", kDirections[i], sd, at.position + i, off[i], std::sqrt(joint(i, i))).available =
        linear && has_position;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d axis = m.horizontal_axes[0].col(i);
    calibrate("joint", i == 0 ? "major_axis" : "minor_axis", sd, at.axes + i, axis.dot(off.head<2>()),
              sd_above_rounding(axis.dot(joint.topLeftCorner<2, 2>() * axis), joint))
        .available = linear && has_position;
  }
  return rows;
}

std::vector<compare::ComparisonRow> PositionPoint::rows_of_table(const std::string& table,
                                                                 const stats::Tally& tally) const {
  std::vector<compare::Row> declared = rows_;
  for (compare::Row& row : declared)  // the mean of what the estimator claims in each trial
    if (row.variance >= 0)
      row.prediction = tally.moments.count > 0 ? std::sqrt(tally.moments.mean[row.variance]) : kNaN;
  std::vector<compare::ComparisonRow> rows = compare::compare_rows(
      declared, table, s_.verdict, tally.trials, [&](const compare::Row& row) { return sample(tally, row.component); });
  if (const std::optional<stats::WishartTest> test = parameter_test(tally); test && table == "parameters")
    rows.back().note += fmt::format("; Wishart test of the 6x6 covariance: p = {:.2g}", test->p_value);
  if (orders_ && orders_->unscented && !orders_->unscented->is_definite)
    for (compare::ComparisonRow& row : rows)
      if (row.formulation == "unscented") row.note += "; its covariance is none: that of cubature5 in its place";
  s_.annotations.apply(table, rows);
  return rows;
}

}  // namespace surveymc::studies::msa_position
