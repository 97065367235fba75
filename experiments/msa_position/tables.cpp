/// Tables of the study `msa_position` beside those of rows: ellipses, covariances, correlations, control variates,
/// pairs and samples.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/position_comparison.h"
#include "compare/table_rows.h"
#include "msa_position/study.h"
#include "stats/tests.h"

namespace surveymc::studies::msa_position {

using Eigen::Matrix2d;
using Eigen::Matrix3d;

namespace {

void write_counts(compare::TableRows& t, const stats::Tally& tally) {
  t.count("trials", "trials run", tally.trials);
  t.count("failed", "trials without a converged estimate, not in the statistics", tally.failed);
}

}  // namespace

store::Table PositionPoint::ellipse_table(const stats::Tally& tally) const {
  constexpr int at = Components::position;
  compare::HorizontalSample found{tally.trials, tally.failed, units(tally), antithetic(), {}, {}};
  if (found.units > 2) {
    found.mean = prediction_.position.head<2>() + tally.moments.mean.segment<2>(at);
    found.covariance = covariance(tally).block<2, 2>(at, at);
  }
  compare::TableRows t(
      "ellipse", "horizontal one-sigma ellipses of the final position, and how Monte Carlo fills them" + intervals_);
  compare::write_sample_ellipse(t, found);
  for (std::size_t f = 0; f < kFormulations.size(); ++f) {
    const int which = static_cast<int>(f);
    compare::EllipseRow row{kFormulations[f], prediction_.position.head<2>(),
                            prediction_.position_covariance[f].topLeftCorner<2, 2>()};
    if (found.units > 2) {
      row.along = {sample(tally, at_.axes + 2 * which), sample(tally, at_.axes + 2 * which + 1)};
      std::copy_n(tally.counts.begin() + static_cast<std::ptrdiff_t>(3 * f), 3, row.inside.begin());
      row.nees = sample(tally, at_.nees_horizontal + which);
      row.wishart_p = stats::wishart_test(found.covariance, row.predicted, found.units).p_value;
    }
    row.expected = s_.annotations.expected("ellipse", kFormulations[f], "ellipse");
    compare::write_ellipse(t, row, found, s_.verdict);
  }
  return t.take();
}

store::Table PositionPoint::covariance_table(const stats::Tally& tally) const {
  compare::TableRows t("position_covariance", "covariance of the final position, true north");
  const auto row = [&](const std::string& name, const Matrix3d& c) {
    t.word("formulation", "monte_carlo, or which analytic prediction", name);
    t.covariance("nev", "element of the covariance", c);
  };
  if (units(tally) > 1) row("monte_carlo", covariance(tally).block<3, 3>(Components::position, Components::position));
  for (std::size_t f = 0; f < kFormulations.size(); ++f) row(kFormulations[f], prediction_.position_covariance[f]);
  return t.take();
}

std::optional<stats::WishartTest> PositionPoint::parameter_test(const stats::Tally& tally) const {
  constexpr std::uint64_t kFewest = 20;
  const bool predicted =
      s_.assumed_noise == sensor::AssumedNoise::constant && prediction_.parameter_covariance(0, 0) > 0;
  if (!predicted || units(tally) <= kFewest) return {};
  return stats::wishart_test(covariance(tally).topLeftCorner<6, 6>(), prediction_.parameter_covariance, units(tally));
}

store::Table PositionPoint::covariance_tests_table(const stats::Tally& tally) const {
  const std::optional<stats::WishartTest> test = parameter_test(tally);
  compare::TableRows t("covariance_tests", "likelihood-ratio tests of whole covariances, without a margin");
  t.word("formulation", "which analytic prediction", "first_order");
  t.word("quantity", "whose covariance", "parameters");
  t.count("dimension", "rows of the matrix", 6);
  t.number("statistic", "1", "chi-squared with dimension (dimension + 1) / 2 degrees", test ? test->statistic : kNaN);
  t.number("wishart_p", "1", "p-value of the test", test ? test->p_value : kNaN);
  t.word("wishart_family", "differs: the test says so among all rows of the file (Holm at 5 %); may be chance: not so",
         "");
  return t.take();
}

store::Table PositionPoint::correlation_table(const stats::Tally& tally) const {
  compare::TableRows t("parameter_correlation",
                       "correlation of the estimates; near -1 or 1: the two can hardly be told apart" + intervals_);
  const auto correlation = [](const auto& c, int i, int j) { return c(i, j) / std::sqrt(c(i, i) * c(j, j)); };
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j) {
      double r = kNaN;
      stats::Interval ci{r, r};
      if (units(tally) > 4) {
        r = correlation(tally.moments.squares, i, j);
        // Fisher's z
        const double half = stats::normal_quantile(1 - (1 - s_.verdict.interval_confidence(units(tally))) / 2) /
                            std::sqrt(static_cast<double>(units(tally)) - 3);
        ci = {std::tanh(std::atanh(r) - half), std::tanh(std::atanh(r) + half)};
      }
      t.word("parameter_a", "first parameter", estimate::kParameterNames[static_cast<std::size_t>(j)]);
      t.word("parameter_b", "second parameter", estimate::kParameterNames[static_cast<std::size_t>(i)]);
      t.estimate("monte_carlo", "1", "correlation of the Monte-Carlo estimates", r, ci);
      t.number("analytic", "1", "correlation by the first-order covariance",
               correlation(prediction_.parameter_covariance, i, j));
      write_counts(t, tally);
    }
  return t.take();
}

/// Plain and controlled estimates side by side. The controlled estimate removes the first-order prediction for the very
/// noise of each trial: its interval is narrower, and its difference from the analytic value is nonlinearity.
store::Table PositionPoint::control_variate_table(const stats::Tally& tally) const {
  std::string title =
      "estimates without and with the first-order prediction of each trial as control variate" + intervals_;
  if (tally.failed > 0)
    title += fmt::format("; of the {}: {} failed ({:.2g} of all){}, whose control is known and accounted for",
                         antithetic() ? "pairs of which both trials converged" : "converged trials", tally.failed,
                         static_cast<double>(tally.failed) / static_cast<double>(tally.trials),
                         antithetic() ? fmt::format(" and {} converged beside one that failed", tally.left_out) : "");
  compare::TableRows t("control_variate", title);
  const auto put = [&](const std::string& quantity, const std::string& unit, const stats::ControlledEstimate& e,
                       double offset, double factor, double analytic, bool judged) {
    const auto estimate = [&](const char* name, const char* meaning, double x, const stats::Interval& i) {
      t.estimate(name, "1", meaning, offset + factor * x, {offset + factor * i.lo, offset + factor * i.hi});
    };
    const stats::Interval ratio{analytic / e.controlled_interval.hi, analytic / e.controlled_interval.lo};
    t.word("quantity", "what is estimated", quantity);
    t.word("unit", "unit of the values in this row", unit);
    estimate("plain", "Monte-Carlo estimate", e.plain, e.plain_interval);
    estimate("controlled", "Monte-Carlo estimate with control variate", e.controlled, e.controlled_interval);
    t.number("analytic", "1", "first-order prediction, exact for this noise", offset + factor * analytic);
    t.estimate("ratio", "1", "analytic / controlled; absent for means and covariances",
               judged ? analytic / e.controlled : kNaN, judged ? ratio : stats::Interval{kNaN, kNaN});
    t.number("variance_reduction", "1",
             "how many times more independent trials the plain estimate needs for the same interval",
             e.variance_reduction);
    t.number("margin", "1", "what agrees: the ratio within 1 -+ margin", judged ? s_.verdict.margin : kNaN);
    const compare::Verdict verdict =
        judged ? compare::judge(ratio, s_.verdict.margin, tally.trials) : compare::Verdict{};
    t.word("verdict", "agrees, differs or undecided, by the controlled estimate", verdict.word);
    compare::write_evidence(t,
                            verdict.word.empty()
                                ? compare::Evidence{}
                                : compare::evidence_of(analytic / e.controlled, ratio, s_.verdict, units(tally), true),
                            verdict.trials_to_decide);
    write_counts(t, tally);
  };
  if (units(tally) < 20) return t.take([&] { put("", "", {}, 0, 1, kNaN, false); });
  const double confidence = s_.verdict.interval_confidence(units(tally));
  const auto& linear = prediction_.linear.covariance;
  const auto both = [&](int i, const std::string& name, const std::string& mean_name, const std::string& unit,
                        double offset) {
    const auto p = static_cast<std::size_t>(i);
    const stats::Moments *m = &tally.controlled[p], *pairs = controlled_pairs(tally, p);
    const stats::LostTrials lost = lost_trials(tally, p);
    put(mean_name, unit, stats::controlled_mean(*m, linear(i, i), confidence, pairs, lost), offset, 1, 0, false);
    put("sigma3_" + name, unit, stats::controlled_sd(*m, linear(i, i), confidence, pairs, lost), 0, 3,
        std::sqrt(linear(i, i)), true);
  };
  for (std::size_t i = 0; i < 6; ++i)
    both(static_cast<int>(i), estimate::kParameterNames[i], std::string("mean_") + estimate::kParameterNames[i],
         estimate::kParameterUnits[i], prediction_.parameters[static_cast<int>(i)]);
  if (s_.with_position) {
    for (std::size_t i = 0; i < 3; ++i)
      both(Components::position + static_cast<int>(i), kDirections[i], std::string("correction_") + kDirections[i], "m",
           prediction_.position[static_cast<int>(i)] - prediction_.uncorrected[static_cast<int>(i)]);
    for (std::size_t p = 9; p < kControlledPairs.size(); ++p) {
      const auto [i, j] = kControlledPairs[p];
      put(fmt::format("covariance_{}_{}", kDirections[static_cast<std::size_t>(i - Components::position)],
                      kDirections[static_cast<std::size_t>(j - Components::position)]),
          "m2",
          stats::controlled_covariance(tally.controlled[p], linear(i, j), confidence, controlled_pairs(tally, p),
                                       lost_trials(tally, p)),
          0, 1, linear(i, j), false);
    }
  }
  return t.take();
}

store::Table PositionPoint::pairs_table(const stats::Tally& tally) const {
  compare::TableRows t("antithetic_pairs",
                       "trials 2j and 2j + 1 with opposite draws; a pair is the unit of all intervals");
  write_counts(t, tally);
  t.count("left_out", "converged trials not in the statistics: the other of their pair failed", tally.left_out);
  t.count("pairs", "pairs in the statistics", tally.pairs.count);
  return t.take();
}

store::Table PositionPoint::samples_table(const stats::Tally& tally) const {
  store::Table t{"realisations", "estimates and final positions of the first converged trials"};
  t.columns = {compare::number_column("trial", "1", "number of the trial, from 0")};
  for (std::size_t i = 0; i < 6; ++i)
    t.columns.push_back(compare::number_column(
        i < 3 ? estimate::kParameterNames[i] : fmt::format("{}_nT", estimate::kParameterNames[i]),
        estimate::kParameterUnits[i], "MSA estimate"));
  const std::size_t with_position = t.columns.size() + 3;
  if (s_.with_position)
    for (const char* d : kDirections)
      t.columns.push_back(
          compare::number_column(fmt::format("{}_m", d), "m", "final position relative to the first station"));
  const std::size_t columns = t.columns.size();
  std::vector<double> shown;
  for (std::size_t i = 0; i < tally.samples.size(); ++i)
    if (i % with_position < columns) shown.push_back(tally.samples[i]);
  return compare::table_of_numbers(std::move(t), shown);
}

}  // namespace surveymc::studies::msa_position
