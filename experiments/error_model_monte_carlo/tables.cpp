/// Tables of the study `error_model_monte_carlo`.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/standard_deviation.h"
#include "base/units.h"
#include "compare/order_rows.h"
#include "compare/position_comparison.h"
#include "compare/table_rows.h"
#include "error_model_monte_carlo/study.h"
#include "propagate/ellipse.h"
#include "stats/antithetic.h"
#include "stats/tests.h"

namespace surveymc::studies::error_model_monte_carlo {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr std::array<const char*, 3> kNev{"north", "east", "vertical"};
constexpr std::array<const char*, 3> kHla{"high_side", "lateral", "along_hole"};

/// No verdict on a direction that first order does not reach. `of`: the largest sd; NaN where there is no prediction.
void unless_reached(compare::ComparisonRow& row, double predicted, double of) {
  if (predicted > 1e-12 * of || std::isnan(of)) return;
  row.ratio = row.ratio_interval.lo = row.ratio_interval.hi = kNaN;
  compare::leave_unjudged(row, "zero to first order");
}

/// sqrt(u' C u); NaN where it is none.
double sd_along(const Matrix3d& covariance, const Vector3d& direction) {
  const double variance = direction.dot(covariance * direction);
  return variance >= 0 ? std::sqrt(variance) : kNaN;
}

}  // namespace

std::string ErrorModelMonteCarlo::place(std::size_t depth) const {
  return depths_.size() > 1 ? fmt::format("{:.10g} m", depths_[depth].md) : std::string();
}

std::vector<compare::Row> ErrorModelMonteCarlo::rows_of(const Scenario& s, const ErrorModelMonteCarlo* point,
                                                        std::size_t d) {
  using enum compare::Statistic;
  const Depth* depth = point ? &point->depths_[d] : nullptr;
  std::vector<compare::Row> rows;
  const auto add = [&](const char* table, const std::string& formulation, const std::string& quantity,
                       compare::Statistic statistic, std::size_t component, double prediction) -> compare::Row& {
    return rows.emplace_back(compare::Row{.table = table,
                                          .formulation = formulation,
                                          .quantity = quantity,
                                          .unit = "m",
                                          .statistic = statistic,
                                          .component = static_cast<int>(component),
                                          .prediction = prediction});
  };
  const std::size_t nev = point ? point->nev_[0][d] : 0, hla = point ? point->hla_[d] : 0;
  for (std::size_t a = 0; a < 3; ++a) {
    compare::Row& row = add("axes", "", std::string("mean_") + kNev[a], mean, nev + a, depth ? depth->truth[a] : kNaN);
    row.offset = row.prediction;
  }
  std::vector<std::string> formulations = s.formulations;  // and those that a config may name all the same
  for (const std::string& f : kFormulations)
    if (std::find(formulations.begin(), formulations.end(), f) == formulations.end()) formulations.push_back(f);
  for (std::size_t f = 0; f < formulations.size(); ++f) {
    const std::string& name = formulations[f];
    const bool available = f < s.formulations.size();
    const Formulation* p = depth && available ? &depth->formulations[f] : nullptr;
    const std::size_t axes = p ? point->axes_[f][d] : 0, first = rows.size();
    for (std::size_t a = 0; a < 3; ++a)
      add("axes", name, fmt::format("sd_axis_{}", a + 1), sd, axes + a, p ? p->sd[a] : kNaN);
    for (std::size_t a = 0; a < 3; ++a)
      add("axes", name, fmt::format("mean_axis_{}", a + 1), mean, axes + a, p ? p->axes.col(a).dot(p->mean) : kNaN);
    for (std::size_t a = 0; a < 3; ++a)
      add("position", name, std::string("sd_") + kNev[a], sd, nev + a,
          p ? sd_along(p->covariance, Vector3d::Unit(a)) : kNaN);
    for (std::size_t a = 0; a < 3; ++a)
      add("position_hla", name, std::string("sd_") + kHla[a], sd, hla + a,
          p ? sd_along(p->covariance, Vector3d(depth->hla.row(a))) : kNaN);
    const std::size_t judged = rows.size();  // a NEES and single sources have no confidence sequence
    if (is_first_order(name)) {
      add("axes", name, "nees", squared_distance, f, 3);
      for (const char* q : {"sd_along", "sd_along_2", "sd_along_3"}) add("by_source", name, q, other, 0, kNaN);
      add("ellipse", name, "ellipse", other, 0, kNaN);
    }
    for (std::size_t r = first; r < rows.size(); ++r) {
      rows[r].available = available && !(p && rows[r].quantity == "nees" && !p->weight.allFinite());
      rows[r].predicted = r < judged;
    }
  }
  for (compare::Row& row : compare::tail_rows(compare::kWellDirections, s.tails)) rows.push_back(std::move(row));
  return rows;
}

std::vector<compare::ComparisonRow> ErrorModelMonteCarlo::compared(const stats::Tally& tally, std::size_t d,
                                                                   const std::string& table) const {
  std::vector<compare::ComparisonRow> rows;
  for (const compare::Row& row : rows_of(s_, this, d)) {
    if (row.table != table || !row.available) continue;
    const auto component = static_cast<std::size_t>(row.component);
    if (row.statistic == compare::Statistic::squared_distance) {
      // NEES = that of the control, whose mean is known, and the mean of the difference; with a disturbance or laws
      // itself.
      stats::SampleSummary nees = summary_of(tally, d, column_of(component, 0));
      if (!is_plain()) nees.mean += (depths_[d].formulations[component].weight * drawn_[0].control[d]).trace();
      rows.push_back(compare::compare_row(row, nees, s_.verdict, tally.trials));
      continue;
    }
    const Found x = found(tally, component);
    if (row.statistic == compare::Statistic::mean) {
      rows.push_back(compare::compare_row(row, x.mean, s_.verdict, tally.trials));
      continue;
    }
    rows.push_back(compare::labelled(
        row.formulation,
        compare::compare_value(row.quantity, row.unit, x.sd, row.prediction, s_.verdict, tally.trials, units(tally))));
    for (const Formulation& p : depths_[d].formulations)
      if (p.name == row.formulation && is_first_order(p.name)) unless_reached(rows.back(), row.prediction, p.sd[0]);
  }
  return rows;
}

compare::RowsOfTables ErrorModelMonteCarlo::judged_rows(const stats::Tally& tally) const {
  compare::RowsOfTables all;
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    for (const char* table : {"axes", "position", "position_hla"})
      all.push_back({table, compared(tally, d, table), place(d)});
  }
  return all;
}

std::vector<store::Table> ErrorModelMonteCarlo::judged_tables(const stats::Tally& tally) const {
  constexpr std::array<const char*, 3> kLongNames{
      "position errors along the axes of the predicted ellipsoids, largest first",
      "position errors north, east and down", "position errors along high side, lateral and hole"};
  std::vector<store::Table> tables(kLongNames.size());
  compare::RowsOfTables all = judged_rows(tally);
  for (std::size_t i = 0; i < all.size(); ++i) {  // the tables of one depth, then those of the next
    auto& [name, rows, place] = all[i];
    const std::size_t t = i % tables.size();
    stop_.add_notes(name, rows, tally, place);
    s_.annotations.apply(name, rows);
    compare::append_at_depth(tables[t],
                             compare::comparison_table(name, kLongNames[t] + compare::at_confidence(s_.verdict), rows,
                                                       tally.trials, tally.failed, true),
                             depths_[i / tables.size()].md);
  }
  return tables;
}

store::Table ErrorModelMonteCarlo::by_source_table(const stats::Tally& tally) const {
  store::Table all;
  std::vector<propagate::WellPoint> points;
  for (const Depth& d : depths_) points.push_back(d.point);
  std::vector<std::vector<propagate::PointMoments>> exact;
  if (!s_.samples())
    for (const std::size_t source : single_) exact.push_back(propagate::source_moments(errors_, points, source));
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    std::vector<compare::ComparisonRow> rows;
    std::vector<std::string> codes, modes;  // beside the rows
    std::vector<double> across;
    std::array<std::vector<double>, 3> mean;
    for (std::size_t i = 0; i < single_.size(); ++i) {
      const propagate::ErrorSource& source = errors_.sources[single_[i]];
      std::size_t first_order = 0;
      for (const Formulation& f : depths_[d].formulations) {
        if (!is_first_order(f.name)) continue;
        const std::size_t which = first_order++;
        const SourcePrediction& p = sources_[i][d][which];
        Vector3d shift = Vector3d::Zero();
        double square = 0;  // of the sd in all directions
        if (s_.samples()) {
          for (int a = 0; a < 3; ++a) {
            const Found x = found(tally, nev_[1 + i][d] + static_cast<std::size_t>(a));
            shift[a] = x.mean.units > 1 ? x.mean.mean : kNaN;
            square += x.sd.value * x.sd.value;
          }
        } else {
          shift = exact[i][d].mean;
          square = exact[i][d].covariance.trace();
        }
        std::vector<compare::ComparisonRow> own;
        for (std::size_t a = 0; a < p.axes.size(); ++a) {
          compare::Estimate sd;
          if (s_.samples()) {
            sd = found(tally, along_[i][d][which] + a).sd;
          } else {
            sd.value = sd_along(exact[i][d].covariance, p.axes[a]);
            sd.interval = {sd.value, sd.value};
          }
          square -= sd.value * sd.value;
          own.push_back(compare::labelled(
              f.name, compare::compare_value(a == 0 ? "sd_along" : fmt::format("sd_along_{}", a + 1), "m", sd, p.sd[a],
                                             s_.verdict, tally.trials, units(tally))));
          if (p.cancels) compare::leave_unjudged(own.back(), "its effects nearly cancel here: not judged");
        }
        for (compare::ComparisonRow& row : own) {
          rows.push_back(std::move(row));
          codes.push_back(source.code);
          modes.emplace_back(1, error_model::mode_letter(source.mode));
          across.push_back(standard_deviation(square));
          for (std::size_t a = 0; a < 3; ++a) mean[a].push_back(shift[static_cast<Eigen::Index>(a)]);
        }
      }
    }
    s_.annotations.apply("by_source", rows);
    store::Table t = compare::comparison_table(
        "by_source",
        (s_.samples() ? "position errors of single sources" : "position errors of single sources by quadrature") +
            compare::at_confidence(s_.verdict),
        rows, tally.trials, tally.failed, true);
    t.columns.insert(t.columns.begin(), {{"source", "", "code of the error source", codes},
                                         {"mode", "", "how its errors go together: R, S, W or G", modes}});
    t.columns.push_back(
        {"across_m", "m", "one standard deviation across the compared axes, which first order has not", across});
    for (std::size_t a = 0; a < 3; ++a)
      t.columns.push_back({fmt::format("mean_{}_m", kNev[a]), "m", "mean shift", mean[a]});
    compare::append_at_depth(all, std::move(t), depths_[d].md);
  }
  return all;
}

store::Table ErrorModelMonteCarlo::disturbance_runs_table() const {
  constexpr std::uint64_t kShownTrials = 6;
  constexpr std::size_t kShownStations = 200;
  compare::TableRows t("disturbance_runs",
                       "the first trials of the disturbance along the run, and what it alone does to the position");
  std::vector<bool> keep(errors_.sources.size(), false);
  for (const std::uint32_t draw : disturbed_->draws) keep[errors_.draws[draw].source] = true;
  const propagate::WellErrors own = propagate::only_sources(errors_, keep),
                              independent = propagate::with_independent_draws(own, *disturbed_);
  std::vector<std::vector<double>> values;
  for (std::uint64_t trial = 0; trial < kShownTrials; ++trial) {
    const std::vector<double> made = disturbed_->disturbance.values(stream_, trial, s_.antithetic);
    values.emplace_back(errors_.draws.size(), 0.0);
    for (std::size_t i = 0; i < made.size(); ++i) values.back()[disturbed_->draws[i]] = made[i];
  }
  const std::size_t last = depths_.back().point.station, stride = 1 + last / kShownStations;
  for (std::size_t k = 1; k <= last; k += stride) {
    const survey::Station& at = s_.survey.stations[k];
    const Vector3d lateral = survey::rotation_hla_from_nev(at.inclination, at.azimuth).row(1);
    const auto along = [&](const propagate::WellErrors& errors) {
      return Eigen::RowVectorXd(lateral.transpose() *
                                propagate::draw_effects(errors, {k, 1}, propagate::FirstOrder::minimum_curvature));
    };
    const Eigen::RowVectorXd by_draws = along(own);
    const double sd = along(independent).norm();
    for (std::uint64_t trial = 0; trial < kShownTrials; ++trial) {
      const std::vector<double>& z = values[trial];
      double azimuth = 0;
      for (const propagate::DrawEffect& e : own.at[k]) azimuth += z[e.draw] * e.azimuth;
      t.count("trial", "number of the trial", trial);
      t.number("md_m", "m", "measured depth of the station", at.md);
      t.number("time_h", "h", "since the first station", (s_.disturbance->times[k] - s_.disturbance->times[0]) / 3600);
      t.number("azimuth_deg", "deg", "error of the station's azimuth by the disturbance", azimuth / kDegree);
      t.number("lateral_m", "m", "lateral error of the position there by the disturbance, to first order",
               by_draws * Eigen::Map<const Eigen::VectorXd>(z.data(), static_cast<Eigen::Index>(z.size())));
      t.number("lateral_sd_m", "m", "its predicted sd", sd);
      t.number("independent_sd_m", "m", "its sd if the draws of the stations were independent", by_draws.norm());
    }
  }
  return t.take();
}

store::Table ErrorModelMonteCarlo::ellipse_table(const stats::Tally& tally) const {
  compare::TableRows t(
      "ellipse", "horizontal one-sigma ellipses, and how Monte Carlo fills them" + compare::at_confidence(s_.verdict));
  for (std::size_t d = 0; d < depths_.size() && units(tally) > 2; ++d) {
    const Depth& depth = depths_[d];
    const Eigen::Vector2d truth = depth.truth.head<2>();
    const compare::HorizontalSample sample{tally.trials,
                                           tally.failed,
                                           units(tally),
                                           s_.antithetic,
                                           truth + tally.groups[d].mean.head<2>(),
                                           sample_covariance(tally, d).topLeftCorner<2, 2>()};
    t.number("md_m", "m", "measured depth", depth.md);
    compare::write_sample_ellipse(t, sample);
    for (std::size_t f = 0; f < s_.formulations.size(); ++f) {
      const Formulation& p = depth.formulations[f];
      if (!is_first_order(p.name)) continue;
      compare::EllipseRow row{p.name, truth, p.covariance.topLeftCorner<2, 2>()};
      std::copy_n(tally.counts.begin() + static_cast<std::ptrdiff_t>(3 * (d * s_.formulations.size() + f)), 3,
                  row.inside.begin());
      const Eigen::Index first = 3 + 4 * static_cast<Eigen::Index>(f);
      row.nees = summary_of(tally, d, first + 1);
      for (int a = 0; a < 2; ++a) row.along[static_cast<std::size_t>(a)] = summary_of(tally, d, first + 2 + a);
      // Pairs of trials with opposite draws are no normal sample of as many degrees of freedom.
      row.wishart_p =
          s_.antithetic ? kNaN : stats::wishart_test(sample.covariance, row.predicted, sample.units).p_value;
      row.expected = s_.annotations.expected("ellipse", row.formulation, "ellipse");
      t.number("md_m", "m", "measured depth", depth.md);
      compare::write_ellipse(t, row, sample, s_.verdict);
    }
  }
  return t.take([&] {
    t.number("md_m", "m", "measured depth", 0);
    compare::write_ellipse(t, {"", Eigen::Vector2d::Zero(), Eigen::Matrix2d::Zero()}, {}, s_.verdict);
  });
}

store::Table ErrorModelMonteCarlo::orders_table(const stats::Tally& tally) const {
  compare::TableRows t(
      "orders", "which order of prediction the position needs, without a trial" + compare::at_confidence(s_.verdict));
  std::vector<std::string> inputs;
  for (const propagate::ErrorDraw& draw : independent_.draws) inputs.push_back(independent_.sources[draw.source].code);
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    const Depth& depth = depths_[d];
    const auto row = [&](const std::string& quantity, const Vector3d& direction, std::size_t component) {
      compare::OrderSample sample;
      if (s_.samples() && units(tally) > 1) {
        const stats::Moments& columns = tally.controlled[component];
        sample = {found(tally, component).sd, columns.skewness(0), columns.kurtosis(0)};
      }
      t.number("md_m", "m", "measured depth", depth.md);
      compare::write_order(t, quantity, direction, depth.orders, wanted_, inputs, sample, s_.verdict);
    };
    const auto number = [&](const std::vector<std::size_t>& first, std::size_t axis) {
      return s_.samples() ? first[d] + axis : 0;
    };
    const Matrix3d axes = propagate::ellipsoid(propagate::covariance_of(depth.effects)).axes;
    for (std::size_t a = 0; a < 3; ++a)
      row(fmt::format("axis_{}", a + 1), axes.col(static_cast<Eigen::Index>(a)), number(whole_sd_, a));
    for (std::size_t a = 0; a < 3; ++a)
      row(kNev[a], Vector3d::Unit(static_cast<Eigen::Index>(a)), s_.samples() ? nev_[0][d] + a : 0);
    for (std::size_t a = 0; a < 3; ++a)
      row(kHla[a], depth.hla.row(static_cast<Eigen::Index>(a)).transpose(), number(hla_, a));
  }
  return t.take();
}

store::Table ErrorModelMonteCarlo::order_coverage_table(const stats::Tally& tally) const {
  compare::TableRows t("order_coverage",
                       "what the horizontal ellipse of minimum_curvature holds, by the profile and by the trials" +
                           compare::at_confidence(s_.verdict));
  const auto first = std::find(s_.formulations.begin(), s_.formulations.end(), "minimum_curvature");
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    const Depth& depth = depths_[d];
    const bool is_counted = first != s_.formulations.end() && !tally.counts.empty();
    const auto at = 3 * (d * s_.formulations.size() + static_cast<std::size_t>(first - s_.formulations.begin()));
    compare::write_order_coverage(t, depth.orders.profile->mixture,
                                  {Vector3d::Zero(), propagate::covariance_of(depth.effects)},
                                  is_counted ? tally.counts.data() + at : nullptr, tally.trials - tally.failed,
                                  s_.verdict.confidence, [&] { t.number("md_m", "m", "measured depth", depth.md); });
  }
  return t.take();
}

store::Table ErrorModelMonteCarlo::covariance_table(const stats::Tally& tally) const {
  compare::TableRows t("position_covariance", "covariance of the position, true north");
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    const auto row = [&](const std::string& name, const Matrix3d& c) {
      t.number("md_m", "m", "measured depth", depths_[d].md);
      t.word("formulation", "monte_carlo, or which analytic prediction", name);
      t.covariance("nev", "element of the covariance", c);
    };
    if (units(tally) > 1) row("monte_carlo", sample_covariance(tally, d));
    for (const Formulation& f : depths_[d].formulations) row(f.name, f.covariance);
  }
  return t.take();
}

store::Table ErrorModelMonteCarlo::tails_table(const stats::Tally& tally) const {
  store::Table all;
  const std::uint64_t runs = units(tally);
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    const std::uint64_t* counts = tally.counts.empty() ? nullptr
                                                       : tally.counts.data() + tail_counts() +
                                                             d * compare::kWellDirections.size() * s_.tails.k.size();
    compare::append_at_depth(all,
                             compare::tails_table(depths_[d].tails.quantities, s_.tails, counts, runs, s_.verdict,
                                                  s_.annotations, tally.trials, tally.failed),
                             depths_[d].md);
  }
  return all;
}

store::Table ErrorModelMonteCarlo::additivity_table(const stats::Tally& tally) const {
  compare::TableRows t(
      "additivity",
      "the whole model against the sum of its sources' covariances, each by Monte Carlo, along the axes of "
      "minimum_curvature" +
          compare::at_confidence(s_.verdict));
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    const Matrix3d axes = propagate::ellipsoid(drawn_[0].control[d]).axes;
    for (int a = 0; a < 3; ++a) {
      const Vector3d u = axes.col(a);
      double sum = 0, square = 0;  // of variances, and of their half widths
      for (std::size_t i = 0; i < single_.size(); ++i) {
        const compare::Estimate sd = found(tally, whole_axes_[i][d] + static_cast<std::size_t>(a)).sd;
        sum += sd.value * sd.value;
        square += std::pow((sd.interval.hi - sd.interval.lo) * sd.value, 2);
      }
      const double whole = found(tally, whole_sd_[d] + static_cast<std::size_t>(a)).sd.value, of_sum = std::sqrt(sum),
                   half = 0.5 * std::sqrt(square) / of_sum, predicted = sd_along(drawn_[0].control[d], u);
      t.number("md_m", "m", "measured depth", depths_[d].md);
      t.count("axis", "of the predicted ellipsoid, largest first", a + 1);
      t.number("predicted_sd_m", "m", "first order, minimum_curvature", predicted);
      t.number("total_sd_m", "m", "Monte Carlo of the whole model", whole);
      t.estimate("sum_sd_m", "m", "root of the sum of the sources' variances by Monte Carlo", of_sum,
                 {of_sum - half, of_sum + half});
      t.number("total_over_predicted", "1", "Monte Carlo of the whole over first order", whole / predicted);
      t.number("sum_over_predicted", "1", "sum of the sources over first order", of_sum / predicted);
      t.number("total_over_sum", "1", "whole over the sum of its parts: 1 if effects only add", whole / of_sum);
    }
  }
  return t.take();
}

}  // namespace surveymc::studies::error_model_monte_carlo
