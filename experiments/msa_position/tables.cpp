/// Comparison tables of the study `msa_position`.
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/position_comparison.h"
#include "estimate/estimators.h"
#include "msa_position/study.h"

namespace surveymc::studies::msa_position {

compare::ComparisonRow PositionPoint::mean_row(const std::string& quantity, const char* unit, const stats::Tally& tally,
                                               int component, double offset, double predicted) const {
  return compare::compare_mean(quantity, unit, sample(tally, component), offset, predicted, s_.verdict, tally.trials);
}

compare::ComparisonRow PositionPoint::sd_row(const char* formulation, const std::string& of, const char* unit,
                                             const stats::Tally& tally, int component, double predicted) const {
  return compare::labelled(formulation, compare::compare_sd("sigma3_" + of, unit, 3, sample(tally, component),
                                                            predicted, s_.verdict, tally.trials));
}

std::vector<compare::ComparisonRow> PositionPoint::parameter_rows(const stats::Tally& tally) const {
  // Weights that are drawn anew in every run have no linear prediction.
  const bool predicted = s_.assumed_noise == sensor::AssumedNoise::constant;
  std::vector<compare::ComparisonRow> rows;
  for (int i = 0; i < 6; ++i) {
    const auto a = static_cast<std::size_t>(i);
    rows.push_back(mean_row(std::string("mean_") + estimate::kParameterNames[a], estimate::kParameterUnits[a], tally,
                            at_.parameter + i, prediction_.parameters[i],
                            predicted ? prediction_.parameters[i] : kNaN));
  }
  for (int i = 0; i < 6; ++i) {
    const auto a = static_cast<std::size_t>(i);
    rows.push_back(sd_row("first_order", estimate::kParameterNames[a], estimate::kParameterUnits[a], tally,
                          at_.parameter + i, predicted ? std::sqrt(prediction_.parameter_covariance(i, i)) : kNaN));
  }
  // The claim of the estimator, by the errors that it assumes; MSA assumes nothing and makes no claim.
  for (int i = 0; i < 6 && estimate::estimator_kind(s_.estimator.name).weighs; ++i) {
    const auto a = static_cast<std::size_t>(i);
    const double claimed = predicted                 ? std::sqrt(prediction_.claimed_covariance(i, i))
                           : tally.moments.count > 0 ? std::sqrt(tally.moments.mean[at_.claimed + i])
                                                     : kNaN;
    rows.push_back(sd_row("claimed", estimate::kParameterNames[a], estimate::kParameterUnits[a], tally,
                          at_.parameter + i, claimed));
  }
  if (at_.reference >= 0)
    for (const compare::ComparisonRow& row : reference_rows(tally)) rows.push_back(row);
  if (predicted && prediction_.parameter_covariance(0, 0) > 0) {
    rows.push_back(compare::compare_nees("nees", sample(tally, at_.nees_parameters), 6, s_.verdict, tally.trials));
    if (const std::optional<stats::WishartTest> test = parameter_test(tally))
      rows.back().note += fmt::format("; Wishart test of the 6x6 covariance: p = {:.2g}", test->p_value);
  }
  s_.annotations.apply("parameters", rows);
  return rows;
}

std::optional<stats::WishartTest> PositionPoint::parameter_test(const stats::Tally& tally) const {
  constexpr std::uint64_t kFewest = 20;
  const bool predicted =
      s_.assumed_noise == sensor::AssumedNoise::constant && prediction_.parameter_covariance(0, 0) > 0;
  if (!predicted || units(tally) <= kFewest) return {};
  return stats::wishart_test(covariance(tally).topLeftCorner<6, 6>(), prediction_.parameter_covariance, units(tally));
}

std::vector<compare::ComparisonRow> PositionPoint::reference_rows(const stats::Tally& tally) const {
  const std::array<double, 2> truth{s_.field.total, s_.field.dip / kDegree}, unit{1, kDegree};
  std::vector<compare::ComparisonRow> rows;
  for (std::size_t a = 0; a < 2; ++a)
    rows.push_back(mean_row(std::string("mean_") + kReference[a], kReferenceUnits[a], tally,
                            at_.reference + static_cast<int>(a), truth[a],
                            truth[a] + prediction_.reference_shift[static_cast<Eigen::Index>(a)] / unit[a]));
  for (const bool claimed : {false, true})
    for (std::size_t a = 0; a < 2; ++a) {
      const auto i = static_cast<Eigen::Index>(a);
      const double variance =
          claimed ? prediction_.claimed_covariance(6 + i, 6 + i) : prediction_.reference_covariance(i, i);
      rows.push_back(sd_row(claimed ? "claimed" : "first_order", kReference[a], kReferenceUnits[a], tally,
                            at_.reference + static_cast<int>(a), std::sqrt(variance) / unit[a]));
    }
  return rows;
}

std::vector<compare::ComparisonRow> PositionPoint::hanak_rows(const stats::Tally& tally) const {
  // The nominal tool, and the derivatives by its gains and biases.
  Eigen::Matrix<double, 6, 6> by_parameters = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> truth, shift;  // shift: mean error of the estimate, by priors and by noise with a mean
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const double gain = s_.errors.gain[a], bias = s_.errors.bias[a];
    const HanakPair tool = hanak_of(gain, bias);
    truth[i] = tool.scale;
    truth[3 + i] = tool.offset;
    shift[i] = prediction_.parameters[i] - gain;
    shift[3 + i] = prediction_.parameters[3 + i] - bias;
    by_parameters(i, i) = 1 / (gain * gain);
    by_parameters(3 + i, i) = -bias / (gain * gain);
    by_parameters(3 + i, 3 + i) = 1 / gain;
  }
  const Eigen::Matrix<double, 6, 1> expected = truth + by_parameters * shift;
  const Eigen::Matrix<double, 6, 6> claimed = prediction_.claimed_covariance.topLeftCorner<6, 6>();
  const Eigen::Matrix<double, 6, 6> covariance = by_parameters * claimed * by_parameters.transpose();
  std::vector<compare::ComparisonRow> rows;
  for (std::size_t a = 0; a < 6; ++a)
    rows.push_back(mean_row(std::string("mean_") + kHanakParameters[a], estimate::kParameterUnits[a], tally,
                            at_.hanak + static_cast<int>(a), 0, expected[static_cast<Eigen::Index>(a)]));
  for (std::size_t a = 0; a < 6; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    rows.push_back(sd_row("", kHanakParameters[a], estimate::kParameterUnits[a], tally, at_.hanak + static_cast<int>(a),
                          std::sqrt(covariance(i, i))));
  }
  s_.annotations.apply("hanak_parameters", rows);
  return rows;
}

std::vector<compare::ComparisonRow> PositionPoint::position_rows(const stats::Tally& tally) const {
  std::vector<compare::ComparisonRow> rows;
  for (int i = 0; i < 3; ++i) {
    const double correction = prediction_.position[i] - prediction_.uncorrected[i];
    rows.push_back(mean_row(std::string("correction_") + kDirections[static_cast<std::size_t>(i)], "m", tally,
                            at_.position + i, correction, correction));
  }
  for (std::size_t f = 0; f < kFormulations.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      rows.push_back(sd_row(kFormulations[f], kDirections[static_cast<std::size_t>(i)], "m", tally, at_.position + i,
                            std::sqrt(prediction_.position_covariance[f](i, i))));
    }
  s_.annotations.apply("position", rows);
  return rows;
}

std::vector<compare::ComparisonRow> PositionPoint::hole_rows(const stats::Tally& tally) const {
  std::vector<compare::ComparisonRow> rows;
  for (std::size_t f = 0; f < kFormulations.size(); ++f) {
    const Eigen::Matrix3d c = hla_from_nev_ * prediction_.position_covariance[f] * hla_from_nev_.transpose();
    for (int i = 0; i < 3; ++i) {
      // A direction without first-order error (plane wells have two) has only the rounding of the rotation: taken as
      // zero.
      const double variance = c(i, i) > 1e-14 * c.trace() ? c(i, i) : 0;
      rows.push_back(sd_row(kFormulations[f], kHoleDirections[static_cast<std::size_t>(i)], "m", tally, at_.hole + i,
                            std::sqrt(variance)));
    }
  }
  s_.annotations.apply("position_hla", rows);
  return rows;
}

}  // namespace surveymc::studies::msa_position
