/// Ellipses, covariances, control variates and samples of the study `msa_position`.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "msa_position.h"
#include "stats/tests.h"
#include "study/position_comparison.h"
#include "study/table_writer.h"

namespace surveymc {

using Eigen::Matrix2d;
using Eigen::Matrix3d;

Table MsaPosition::ellipse_table(const Tally& tally) const {
  constexpr int at = MsaComponents::position;
  HorizontalSample found{tally.trials, tally.failed, units(tally), antithetic(), {}, {}};
  if (found.units > 2) {
    found.mean = prediction_.position.head<2>() + tally.moments.mean.segment<2>(at);
    found.covariance = covariance(tally).block<2, 2>(at, at);
  }
  TableWriter w(ellipse_columns("horizontal one-sigma ellipses of the final position, and how Monte Carlo fills them" +
                                intervals_));
  write_sample_ellipse(w, found);
  for (std::size_t f = 0; f < kFormulations.size(); ++f) {
    const int which = static_cast<int>(f);
    EllipseRow row{kFormulations[f], prediction_.position.head<2>(),
                   prediction_.position_covariance[f].topLeftCorner<2, 2>()};
    if (found.units > 2) {
      row.along = {sample(tally, at_.axes + 2 * which), sample(tally, at_.axes + 2 * which + 1)};
      std::copy_n(tally.counts.begin() + static_cast<std::ptrdiff_t>(3 * f), 3, row.inside.begin());
      row.nees = sample(tally, at_.nees_horizontal + which);
      row.wishart_p = wishart_test(found.covariance, row.predicted, found.units).p_value;
    }
    row.expected = s_.annotations.expected("ellipse", kFormulations[f], "ellipse");
    write_ellipse(w, row, found, s_.verdict);
  }
  return w.take();
}

Table MsaPosition::covariance_table(const Tally& tally) const {
  Table t{"position_covariance", "covariance of the final position, true north"};
  t.columns = {word_column("formulation", "monte_carlo, or which analytic prediction")};
  for (const char* name : {"nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2"})
    t.columns.push_back(number_column(name, "m2", "element of the covariance"));
  TableWriter w(std::move(t));
  const auto row = [&](const std::string& name, const Matrix3d& c) {
    w << name << c(0, 0) << c(1, 1) << c(2, 2) << c(0, 1) << c(0, 2) << c(1, 2);
  };
  if (units(tally) > 1)
    row("monte_carlo", covariance(tally).block<3, 3>(MsaComponents::position, MsaComponents::position));
  for (std::size_t f = 0; f < kFormulations.size(); ++f) row(kFormulations[f], prediction_.position_covariance[f]);
  return w.take();
}

Table MsaPosition::correlation_table(const Tally& tally) const {
  Table t{"parameter_correlation",
          "correlation of the estimates; near -1 or 1: the two can hardly be told apart" + intervals_};
  t.columns = {word_column("parameter_a", "first parameter"), word_column("parameter_b", "second parameter")};
  add_with_interval(t, "monte_carlo", "1", "correlation of the Monte-Carlo estimates");
  t.columns.push_back(number_column("analytic", "1", "correlation by the first-order covariance"));
  t.columns.push_back(count_column("trials", "trials run"));
  t.columns.push_back(count_column("failed", "trials without a converged estimate, not in the statistics"));
  const auto correlation = [](const auto& c, int i, int j) { return c(i, j) / std::sqrt(c(i, i) * c(j, j)); };
  TableWriter w(std::move(t));
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j) {
      double r = std::nan("");
      Interval ci{r, r};
      if (units(tally) > 4) {
        r = correlation(tally.moments.squares, i, j);
        // Fisher's z
        const double half =
            normal_quantile(1 - (1 - s_.verdict.confidence) / 2) / std::sqrt(static_cast<double>(units(tally)) - 3);
        ci = {std::tanh(std::atanh(r) - half), std::tanh(std::atanh(r) + half)};
      }
      w << std::string(kParameters[static_cast<std::size_t>(j)])
        << std::string(kParameters[static_cast<std::size_t>(i)]) << r << ci.lo << ci.hi
        << correlation(prediction_.parameter_covariance, i, j) << static_cast<std::int64_t>(tally.trials)
        << static_cast<std::int64_t>(tally.failed);
    }
  return w.take();
}

/// Plain and controlled estimates side by side. The controlled one removes what the first-order prediction says of the
/// very noise of each trial: its interval is narrower, and its difference from the analytic value is nonlinearity.
Table MsaPosition::control_variate_table(const Tally& tally) const {
  Table t{"control_variate",
          "estimates without and with the first-order prediction of each trial as control variate" + intervals_};
  t.columns = {word_column("quantity", "what is estimated"), word_column("unit", "unit of the values in this row")};
  add_with_interval(t, "plain", "1", "Monte-Carlo estimate");
  add_with_interval(t, "controlled", "1", "Monte-Carlo estimate with control variate");
  t.columns.push_back(number_column("analytic", "1", "first-order prediction, exact for this noise"));
  add_with_interval(t, "ratio", "1", "analytic / controlled; absent for means and covariances");
  t.columns.push_back(
      number_column("variance_reduction", "1",
                    "how many times more independent trials the plain estimate needs for the same interval"));
  t.columns.push_back(word_column("verdict", "agrees, differs or undecided, by the controlled estimate"));
  t.columns.push_back(count_column("trials", "trials run"));
  t.columns.push_back(count_column("failed", "trials without a converged estimate, not in the statistics"));
  TableWriter w(std::move(t));
  // Without the trials that failed, the mean of the control is no longer known.
  if (tally.failed > 0 || units(tally) < 20) return w.take();

  const double nan = std::nan("");
  const auto put = [&](const std::string& quantity, const std::string& unit, const ControlledEstimate& e, double offset,
                       double factor, double analytic, bool judged) {
    const auto interval = [&](double x, const Interval& i) {
      w << offset + factor * x << offset + factor * i.lo << offset + factor * i.hi;
    };
    w << quantity << unit;
    interval(e.plain, e.plain_interval);
    interval(e.controlled, e.controlled_interval);
    w << offset + factor * analytic;
    const Interval ratio{analytic / e.controlled_interval.hi, analytic / e.controlled_interval.lo};
    if (judged)
      w << analytic / e.controlled << ratio.lo << ratio.hi;
    else
      w << nan << nan << nan;
    w << e.variance_reduction << (judged ? judge(ratio, s_.verdict.margin, tally.trials).word : std::string())
      << static_cast<std::int64_t>(tally.trials) << static_cast<std::int64_t>(tally.failed);
  };
  const double confidence = s_.verdict.confidence;
  const auto& linear = prediction_.linear.covariance;
  const auto both = [&](int i, const std::string& name, const std::string& mean_name, const std::string& unit,
                        double offset) {
    const auto p = static_cast<std::size_t>(i);
    const Moments *m = &tally.controlled[p], *pairs = controlled_pairs(tally, p);
    put(mean_name, unit, controlled_mean(*m, linear(i, i), confidence, pairs), offset, 1, 0, false);
    put("sigma3_" + name, unit, controlled_sd(*m, linear(i, i), confidence, pairs), 0, 3, std::sqrt(linear(i, i)),
        true);
  };
  for (std::size_t i = 0; i < 6; ++i)
    both(static_cast<int>(i), kParameters[i], std::string("mean_") + kParameters[i], kParameterUnits[i],
         prediction_.parameters[static_cast<int>(i)]);
  if (s_.with_position) {
    for (std::size_t i = 0; i < 3; ++i)
      both(MsaComponents::position + static_cast<int>(i), kDirections[i], std::string("correction_") + kDirections[i],
           "m", prediction_.position[static_cast<int>(i)] - prediction_.uncorrected[static_cast<int>(i)]);
    for (std::size_t p = 9; p < kControlledPairs.size(); ++p) {
      const auto [i, j] = kControlledPairs[p];
      put(fmt::format("covariance_{}_{}", kDirections[static_cast<std::size_t>(i - MsaComponents::position)],
                      kDirections[static_cast<std::size_t>(j - MsaComponents::position)]),
          "m2", controlled_covariance(tally.controlled[p], linear(i, j), confidence, controlled_pairs(tally, p)), 0, 1,
          linear(i, j), false);
    }
  }
  return w.take();
}

Table MsaPosition::failures_table(const Tally& tally) const {
  Table t{"failed_trials", "trials without a converged estimate; replay one with `surveymc run CONFIG --trial K`"};
  std::vector<std::int64_t> numbers(tally.failed_trials.begin(), tally.failed_trials.end());
  t.columns = {{"trial", "1", "number of the trial, from 0", std::move(numbers)}};
  return t;
}

Table MsaPosition::pairs_table(const Tally& tally) const {
  Table t{"antithetic_pairs", "trials 2j and 2j + 1 with opposite draws; a pair is the unit of all intervals"};
  const auto column = [&](const char* name, const char* what, std::uint64_t count) {
    t.columns.push_back({name, "1", what, std::vector<std::int64_t>{static_cast<std::int64_t>(count)}});
  };
  column("trials", "trials run", tally.trials);
  column("failed", "trials without a converged estimate, not in the statistics", tally.failed);
  column("left_out", "converged trials not in the statistics: the other of their pair failed", tally.left_out);
  column("pairs", "pairs in the statistics", tally.pairs.count);
  return t;
}

Table MsaPosition::samples_table(const Tally& tally) const {
  Table t{"realisations", "estimates and final positions of the first converged trials"};
  t.columns = {number_column("trial", "1", "number of the trial, from 0")};
  for (std::size_t i = 0; i < 6; ++i)
    t.columns.push_back(number_column(i < 3 ? kParameters[i] : fmt::format("{}_nT", kParameters[i]), kParameterUnits[i],
                                      "MSA estimate"));
  const std::size_t with_position = t.columns.size() + 3;
  if (s_.with_position)
    for (const char* d : kDirections)
      t.columns.push_back(number_column(fmt::format("{}_m", d), "m", "final position relative to the first station"));
  const std::size_t columns = t.columns.size();
  TableWriter w(std::move(t));
  for (std::size_t i = 0; i < tally.samples.size(); ++i)
    if (i % with_position < columns) w << tally.samples[i];
  return w.take();
}

}  // namespace surveymc
