/// Study: every source of an error model drawn and taken through depth, inclination, azimuth and nonlinear minimum
/// curvature, against the covariance of the model. Is the covariance that decides about collisions right?
///
///   survey, field, models (config) -> what every draw does at every station (propagate: well_errors)
///   -> draws -> depths and directions -> minimum curvature (propagate: drawn_well) -> tally at the reported depths
///
/// compared with
///   iscwsa             balanced tangential effects, the sums of position_covariance, whose rule holds between
///                      stations: there the covariance is linear in depth
///   minimum_curvature  exact derivatives of the same path: what is left is nonlinearity
///   second             mean to second order, covariance to fourth order in the sizes (orders/second.h)
///   unscented, cubature5  sigma points along the three directions of the draws that move the position
///                      (orders/sigma_points.h)
///   profile            exact along the dominant direction of the draws, first order around it (orders/profile.h)
///
/// The exact first-order effect of the same draws is a control variate of all means and sds.
#include "error_model_monte_carlo/study.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/LU>

#include "base/error.h"
#include "base/units.h"
#include "compare/position_comparison.h"
#include "propagate/ellipse.h"
#include "propagate/hole_direction.h"
#include "random/study_stream.h"
#include "scenario/disturbance.h"
#include "scenario/survey_spacing.h"
#include "scenario/validity_tables.h"
#include "stats/antithetic.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::error_model_monte_carlo {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Axes shorter than this share of the longest are of second order where a source has several draws.
constexpr double kLeastAxis = 0.05;
/// A source that is smaller than this share of the whole has no first-order effect but rounding.
constexpr double kRounding = 1e-10;

/// Covariance at a point from those at both stations of its leg: linear in measured depth, as position_covariance has
/// it.
template <class CovarianceAt>
Matrix3d between_stations(const propagate::WellPoint& point, const CovarianceAt& covariance_at) {
  if (point.share == 1) return covariance_at(point.station);
  const Matrix3d before = point.station > 1 ? covariance_at(point.station - 1) : Matrix3d::Zero();  // tied on exactly
  return (1 - point.share) * before + point.share * covariance_at(point.station);
}

Formulation formulation_of(const std::string& name, const Matrix3d& covariance) {
  Formulation f;
  f.name = name;
  f.covariance = covariance;
  const propagate::Ellipsoid body = propagate::ellipsoid(covariance);
  f.axes = body.axes;
  f.sd = body.semi_axes;
  // A body without volume (all errors in one plane) has no Mahalanobis distance and covers nothing.
  f.weight = f.sd[2] > 0 ? Matrix3d(covariance.inverse()) : Matrix3d::Constant(kNaN);
  const Matrix2d horizontal = covariance.topLeftCorner<2, 2>();
  const propagate::Ellipse e = propagate::ellipse(horizontal);
  f.horizontal_axes = e.axes;
  f.horizontal_weight = e.semi_minor > 0 ? Matrix2d(horizontal.inverse()) : Matrix2d::Constant(kNaN);
  return f;
}

}  // namespace

ErrorModelMonteCarlo::ErrorModelMonteCarlo(Scenario scenario)
    : s_(std::move(scenario)),
      stream_(random::stream_of(s_.seed)),
      errors_(propagate::resized(
          propagate::well_errors(s_.survey, s_.tvd, s_.tools.runs, s_.field, s_.latitude, s_.multiplier, s_.vertical),
          s_.laws)),
      places_(propagate::draw_places(errors_)),
      mixing_(propagate::well_mixing(errors_, s_.laws, places_)),
      independent_(errors_),
      stop_({}, s_.verdict, {}) {
  if (s_.disturbance) {
    disturbed_ = propagate::disturbed_draws(errors_, s_.tools.runs, *s_.disturbance, s_.field);
    independent_ = propagate::with_independent_draws(errors_, *disturbed_);
  }
  // A depth between stations needs the one below it, too.
  scenario::require_drawable(s_.model_place, errors_, propagate::point_at(s_.survey, s_.report_md.back()).station);
  predict();
  predict_sources();
  predict_tails();
  plan_draws();
  const std::size_t controlled = quantities_.size(), depths = depths_.size();
  stop_ = compare::VerdictStop(
      s_.trial_plan, s_.verdict, [this](const stats::Tally& t) { return judged_rows(t); },
      {depths + (law_draws_.empty() ? 0 : 1), depths, controlled, s_.antithetic ? controlled + depths : 0, 0, true});
}

void ErrorModelMonteCarlo::predict() {
  const auto is_wanted = [this](const char* name) {
    return std::find(s_.formulations.begin(), s_.formulations.end(), name) != s_.formulations.end();
  };
  wanted_ = {is_wanted("second"), is_wanted("unscented"), is_wanted("cubature5"), is_wanted("profile"), {}};
  const std::vector<Vector3d> positions = survey::minimum_curvature_positions(s_.survey);
  for (const double md : s_.report_md) {
    Depth d;
    d.md = md;
    d.point = propagate::point_at(s_.survey, md);
    const propagate::LegGeometry leg = propagate::leg_geometry(errors_, d.point.station);
    const propagate::DrawnErrors<double> none{0, 0, 0, 0};
    d.truth =
        positions[d.point.station - 1] + survey::to_eigen(propagate::drawn_leg_point(leg, none, none, d.point.share));
    const std::vector<survey::Station>& stations = s_.survey.stations;
    const propagate::HoleDirection along =
        propagate::hole_direction(stations[d.point.station - 1], stations[d.point.station], d.point.share);
    d.hla = survey::rotation_hla_from_nev(along.inclination, along.azimuth);
    d.effects = propagate::draw_effects(independent_, d.point, propagate::FirstOrder::minimum_curvature);
    const Matrix3d exact = propagate::covariance_of(d.effects);
    d.orders = orders::predict(propagate::WellChain(independent_, d.point), wanted_, orders::first_order_directions);
    for (const std::string& name : s_.formulations) {
      if (!is_first_order(name)) {
        const orders::Moments m = *d.orders.of(name);
        Formulation f = formulation_of(name, exact);
        f.mean = m.mean;
        f.covariance = m.covariance;
        for (int a = 0; a < 3; ++a) {
          const double variance = f.axes.col(a).dot(m.covariance * f.axes.col(a));
          f.sd[a] = variance > 0 ? std::sqrt(variance) : kNaN;  // at large sizes the series is no covariance
        }
        d.formulations.push_back(f);
      } else {
        const auto at_station = [&](std::size_t k) {
          return propagate::covariance_of(propagate::draw_effects(independent_, {k, 1}, propagate::FirstOrder::iscwsa));
        };
        d.formulations.push_back(
            formulation_of(name, name == "minimum_curvature" ? exact : between_stations(d.point, at_station)));
      }
    }
    depths_.push_back(std::move(d));
  }
}

void ErrorModelMonteCarlo::predict_tails() {
  if (!s_.tails.wanted) return;
  const propagate::WellMixing mixing =
      propagate::well_mixing(independent_, s_.laws, propagate::draw_places(independent_));
  for (Depth& d : depths_) d.tails = compare::well_tails(mixing, d.effects, d.hla);
  for (std::size_t e = 0; e < s_.laws.elements.size(); ++e)
    for (std::size_t i = 0; i < errors_.draws.size() && s_.laws.elements[e].law; ++i)
      if (mixing_.slot_of_draw[i] >= 0 &&
          errors_.sources[errors_.draws[i].source].element == static_cast<random::ReferenceElement>(e)) {
        law_draws_.push_back({static_cast<random::ReferenceElement>(e),
                              mixing_.slots[static_cast<std::size_t>(mixing_.slot_of_draw[i])], places_[i].channel,
                              places_[i].index});
        break;
      }
}

void ErrorModelMonteCarlo::predict_sources() {
  if (s_.sources == Sources::total) return;
  for (std::size_t i = 0; i < errors_.sources.size(); ++i) {
    const propagate::ErrorSource& source = errors_.sources[i];
    const bool wanted = s_.sources == Sources::listed
                            ? std::find(s_.listed.begin(), s_.listed.end(), source.code) != s_.listed.end()
                        : s_.sources == Sources::quadrature ? is_for_quadrature(source)
                                                            : true;
    if (wanted && !source.draws.empty()) single_.push_back(i);
  }
  // Sd at shallower stations, by which a source whose effects cancel is told.
  const Eigen::MatrixXd sds =
      propagate::source_sds(independent_, depths_.back().point.station, propagate::FirstOrder::iscwsa);
  for (const std::size_t i : single_) {
    const propagate::ErrorSource& source = independent_.sources[i];
    sources_.emplace_back();
    for (const Depth& d : depths_) {
      sources_.back().emplace_back();
      const double largest =
          sds.row(static_cast<Eigen::Index>(i)).head(static_cast<Eigen::Index>(d.point.station + 1)).maxCoeff();
      for (const Formulation& f : d.formulations) {
        if (!is_first_order(f.name)) continue;
        const bool is_exact = f.name == "minimum_curvature";
        const Eigen::Matrix3Xd effects =
            is_exact ? d.effects
                     : propagate::draw_effects(independent_, {d.point.station, 1}, propagate::FirstOrder::iscwsa);
        const auto at_station = [&](std::size_t k) {
          if (k != d.point.station || disturbed_) return source_covariance(i, {k, 1}, propagate::FirstOrder::iscwsa);
          return propagate::covariance_of(effects, source);
        };
        SourcePrediction p;
        p.covariance = is_exact ? source_covariance(i, d.point, propagate::FirstOrder::minimum_curvature)
                                : between_stations(d.point, at_station);
        const bool has_effect_of_one_draw = is_exact || d.point.share == 1;
        const propagate::Ellipsoid body = propagate::ellipsoid(p.covariance);
        const double whole = std::sqrt(f.covariance.trace());
        const bool is_one_draw = source.draws.size() == 1;
        for (int a = 0; a < (is_one_draw ? 1 : 3); ++a)
          if (body.semi_axes[a] > kLeastAxis * body.semi_axes[0] && body.semi_axes[a] > kRounding * whole) {
            // Of one draw the effect itself is the axis, to the last digit.
            const bool is_effect = is_one_draw && has_effect_of_one_draw;
            const Vector3d effect = effects.col(source.draws.front());
            p.axes.push_back(is_effect ? Vector3d(effect.normalized()) : Vector3d(body.axes.col(a)));
            p.sd.push_back(is_effect ? effect.norm() : body.semi_axes[a]);
          }
        const double sd = std::sqrt(p.covariance.trace());
        p.cancels = f.name == "iscwsa" && (sd < 0.3 * largest || sd < 0.01 * whole);
        sources_.back().back().push_back(std::move(p));
      }
    }
  }
}

Matrix3d ErrorModelMonteCarlo::source_covariance(std::size_t source, const propagate::WellPoint& point,
                                                 propagate::FirstOrder which) const {
  const bool is_random = errors_.sources[source].mode == error_model::PropagationMode::random;
  if (!disturbed_ || !is_random)
    return propagate::covariance_of(propagate::draw_effects(independent_, point, which), independent_.sources[source]);
  // Independent draws belong to no source where elements are correlated: of this source alone they do.
  std::vector<bool> keep(errors_.sources.size(), false);
  keep[source] = true;
  const propagate::WellErrors own =
      propagate::with_independent_draws(propagate::only_sources(errors_, keep), *disturbed_);
  return propagate::covariance_of(propagate::draw_effects(own, point, which));
}

std::size_t ErrorModelMonteCarlo::add_quantity(std::size_t drawn, std::size_t depth, const Vector3d& direction) {
  quantities_.push_back({drawn, depth, direction});
  return quantities_.size() - 1;
}

void ErrorModelMonteCarlo::plan_draws() {
  if (!s_.samples()) return;
  std::vector<propagate::WellPoint> points;
  for (const Depth& d : depths_) points.push_back(d.point);
  std::vector<propagate::DrawPlace> places = places_;
  for (std::uint32_t i = 0; disturbed_ && i < disturbed_->draws.size(); ++i)
    places[disturbed_->draws[i]] = {propagate::kGivenDraws, i};
  const auto add_well = [&](const propagate::WellErrors& errors, int source) {
    Drawn w{propagate::drawn_well(errors, points, places, true, mixing_), source, {}};
    for (const Depth& d : depths_)
      w.control.push_back(source < 0 ? propagate::covariance_of(d.effects)
                                     : source_covariance(static_cast<std::size_t>(source), d.point,
                                                         propagate::FirstOrder::minimum_curvature));
    drawn_.push_back(std::move(w));
    nev_.emplace_back();
    for (std::size_t d = 0; d < depths_.size(); ++d) {
      nev_.back().push_back(quantities_.size());
      for (int a = 0; a < 3; ++a) add_quantity(drawn_.size() - 1, d, Vector3d::Unit(a));
    }
  };
  const auto add_axes = [&](std::size_t drawn, std::size_t depth, const Matrix3d& axes) {
    const std::size_t first = quantities_.size();
    for (int a = 0; a < 3; ++a) add_quantity(drawn, depth, axes.col(a));
    return first;
  };
  add_well(errors_, -1);
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    hla_.push_back(add_axes(0, d, depths_[d].hla.transpose()));
    whole_sd_.push_back(add_axes(0, d, propagate::ellipsoid(drawn_[0].control[d]).axes));
  }
  for (std::size_t f = 0; f < s_.formulations.size(); ++f) {
    axes_.emplace_back();
    for (std::size_t d = 0; d < depths_.size(); ++d)
      axes_.back().push_back(add_axes(0, d, depths_[d].formulations[f].axes));
  }
  for (std::size_t i = 0; i < single_.size(); ++i) {
    std::vector<bool> keep(errors_.sources.size(), false);
    keep[single_[i]] = true;
    add_well(propagate::only_sources(errors_, keep), static_cast<int>(single_[i]));
    const std::size_t drawn = drawn_.size() - 1;
    along_.emplace_back();
    whole_axes_.emplace_back();
    for (std::size_t d = 0; d < depths_.size(); ++d) {
      along_.back().emplace_back();
      for (const SourcePrediction& p : sources_[i][d]) {
        along_.back().back().push_back(quantities_.size());
        for (const Vector3d& axis : p.axes) add_quantity(drawn, d, axis);
      }
      whole_axes_.back().push_back(
          add_axes(drawn, d, propagate::ellipsoid(propagate::covariance_of(depths_[d].effects)).axes));
    }
  }
}

std::optional<survey::LaneArray> ErrorModelMonteCarlo::made_draws(std::uint64_t first_trial, int groups) const {
  if (!disturbed_) return std::nullopt;
  const auto fours = static_cast<int>((disturbed_->draws.size() + 3) / 4);
  survey::LaneArray rows(groups, 4 * fours);
  disturbed_->disturbance.fill(stream_, first_trial, s_.antithetic, groups, rows);
  return rows;
}

stats::Tally ErrorModelMonteCarlo::run_block(montecarlo::TrialBlock block) const {
  const auto depths = static_cast<Eigen::Index>(depths_.size());
  const int groups = survey::groups_for(block.count);
  stats::Tally tally;
  tally.trials = static_cast<std::uint64_t>(block.count);
  tally.counts.assign(law_counts(), 0);
  // Errors and controls of every drawn well: a trial a row, 3 columns a depth.
  std::vector<Eigen::MatrixXd> errors, controls;
  const std::optional<survey::LaneArray> made = made_draws(block.first, groups);
  for (const Drawn& w : drawn_) {
    survey::LaneArray out(groups, w.well.rows());
    w.well.draw(stream_, block.first, s_.antithetic, groups, out, made ? &*made : nullptr);
    errors.emplace_back(block.count, 3 * depths);
    controls.emplace_back(block.count, 3 * depths);
    for (int r = 0; r < 3 * static_cast<int>(depths); ++r)
      for (int t = 0; t < block.count; ++t) {
        errors.back()(t, r) = out.value(t, r);
        controls.back()(t, r) = out.value(t, r + 3 * static_cast<int>(depths));
      }
  }
  // A trial without a position (a dogleg of 180 deg) is in no statistics, nor is its antithetic other.
  const auto is_finite = [&](int t) {
    return std::all_of(errors.begin(), errors.end(), [&](const Eigen::MatrixXd& e) { return e.row(t).allFinite(); });
  };
  std::vector<int> kept;
  for (int t = 0; t < block.count; ++t) {
    const std::uint64_t trial = block.first + static_cast<std::uint64_t>(t);
    if (!is_finite(t)) {
      tally.add_failed(trial);
    } else if (s_.antithetic && !is_finite(t ^ 1)) {
      ++tally.left_out;
    } else {
      kept.push_back(t);
      for (std::size_t d = 0; d < depths_.size() && trial < s_.save_samples; ++d) {
        const auto c = 3 * static_cast<Eigen::Index>(d);
        tally.samples.insert(tally.samples.end(), {depths_[d].md, static_cast<double>(trial), errors[0](t, c),
                                                   errors[0](t, c + 1), errors[0](t, c + 2)});
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(kept.size());
  const auto rows_of = [&](const Eigen::MatrixXd& all, std::size_t depth) {
    Eigen::MatrixX3d x(n, 3);
    for (Eigen::Index t = 0; t < n; ++t)
      x.row(t) = all.block<1, 3>(kept[static_cast<std::size_t>(t)], 3 * static_cast<Eigen::Index>(depth));
    return x;
  };
  for (const Quantity& q : quantities_) {
    const Eigen::VectorXd y = rows_of(errors[q.drawn], q.depth) * q.direction,
                          l = rows_of(controls[q.drawn], q.depth) * q.direction;
    const Eigen::MatrixXd columns = stats::control_columns(y, y, l, l);
    tally.controlled.push_back(stats::Moments::of(columns));
    if (s_.antithetic) tally.controlled_pairs.push_back(stats::Moments::of(stats::pair_means(columns)));
  }
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    const Eigen::MatrixX3d e = rows_of(errors[0], d), l = rows_of(controls[0], d);
    Eigen::MatrixXd values(n, column_of(s_.formulations.size(), 0));
    values.leftCols<3>() = e;
    for (std::size_t f = 0; f < s_.formulations.size(); ++f) {
      const Formulation& p = depths_[d].formulations[f];
      for (Eigen::Index t = 0; t < n; ++t) {
        const Vector3d r = e.row(t), linear = l.row(t);
        const Eigen::Vector2d h = r.head<2>();
        const double horizontal = h.dot(p.horizontal_weight * h);
        values(t, column_of(f, 0)) = r.dot(p.weight * r) - (is_plain() ? 0 : linear.dot(p.weight * linear));
        values(t, column_of(f, 1)) = horizontal;
        for (int a = 0; a < 2; ++a) values(t, column_of(f, 2 + a)) = p.horizontal_axes.col(a).dot(h);
        compare::count_inside(horizontal, tally.counts.data() + 3 * (d * s_.formulations.size() + f));
      }
    }
    tally.groups.push_back(stats::Moments::of(values));
    if (s_.antithetic) tally.controlled_pairs.push_back(stats::Moments::of(stats::pair_columns(values)));
    for (std::size_t i = 0; i < depths_[d].tails.quantities.size(); ++i) {
      const Eigen::VectorXd along = e * depths_[d].tails.directions.col(static_cast<Eigen::Index>(i));
      // Both errors of an antithetic pair are as large: the first stands for both.
      for (Eigen::Index t = 0; t < n; t += s_.antithetic ? 2 : 1)
        compare::count_beyond(
            along[t], depths_[d].tails.quantities[i].sd, s_.tails,
            tally.counts.data() + tail_counts() + (d * compare::kWellDirections.size() + i) * s_.tails.k.size());
    }
  }
  compare::DrawnLaws::add(stream_, law_draws_, block, s_.antithetic, tally);
  stop_.keep(block, tally);
  return tally;
}

std::uint64_t ErrorModelMonteCarlo::units(const stats::Tally& tally) const {
  if (tally.controlled.empty()) return 0;
  return s_.antithetic ? tally.controlled_pairs.front().count : tally.controlled.front().count;
}

ErrorModelMonteCarlo::Found ErrorModelMonteCarlo::found(const stats::Tally& tally, std::size_t quantity) const {
  Found out;
  if (units(tally) < 2) return out;
  const Quantity& q = quantities_[quantity];
  const stats::Moments& columns = tally.controlled[quantity];
  const stats::Moments* pairs = s_.antithetic ? &tally.controlled_pairs[quantity] : nullptr;
  const double variance = q.direction.dot(drawn_[q.drawn].control[q.depth] * q.direction);
  const double confidence = s_.verdict.interval_confidence(units(tally));
  const stats::ControlledEstimate sd = stats::controlled_sd(columns, variance, confidence, pairs),
                                  mean = stats::controlled_mean(columns, variance, confidence, pairs);
  // The known mean of a control is that over all trials: where some failed, it serves no more.
  const bool plain = tally.failed > 0 || is_plain();
  out.sd =
      plain ? compare::Estimate{sd.plain, sd.plain_interval} : compare::Estimate{sd.controlled, sd.controlled_interval};
  // A path that is linear in the draws leaves no residual, whose variance may be rounding below zero.
  const auto without_residual = [](stats::Interval& i, double value) {
    if (std::isfinite(value) && !(std::isfinite(i.lo) && std::isfinite(i.hi))) i = {value, value};
  };
  without_residual(out.sd.interval, out.sd.value);
  stats::Interval interval = plain ? mean.plain_interval : mean.controlled_interval;
  without_residual(interval, plain ? mean.plain : mean.controlled);
  const double half = (interval.hi - interval.lo) / 2 / stats::normal_quantile(0.5 + confidence / 2);
  out.mean.units = units(tally);
  out.mean.mean = plain ? mean.plain : mean.controlled;
  out.mean.variance = out.sd.value * out.sd.value;
  out.mean.unit_variance = half * half * static_cast<double>(out.mean.units);
  return out;
}

stats::SampleSummary ErrorModelMonteCarlo::summary_of(const stats::Tally& tally, std::size_t depth,
                                                      Eigen::Index column) const {
  if (units(tally) < 2) return {};
  const stats::Moments& m = tally.groups[depth];
  return s_.antithetic ? stats::summarise_pairs(m, tally.controlled_pairs[quantities_.size() + depth], column)
                       : stats::summarise(m, column);
}

Matrix3d ErrorModelMonteCarlo::sample_covariance(const stats::Tally& tally, std::size_t depth) const {
  const stats::Moments& m = tally.groups[depth];
  const Eigen::MatrixXd all =
      s_.antithetic ? stats::paired_covariance(m, tally.controlled_pairs[quantities_.size() + depth]) : m.covariance();
  return all.topLeftCorner<3, 3>();
}

study::PointResult ErrorModelMonteCarlo::report(const stats::Tally& tally, const montecarlo::RunOptions&) const {
  study::PointResult r;
  if (s_.samples()) r.tables = judged_tables(tally);
  if (s_.sources != Sources::total) r.tables.push_back(by_source_table(tally));
  if (s_.samples()) r.tables.push_back(ellipse_table(tally));
  if (s_.tails.wanted) {
    r.tables.push_back(tails_table(tally));
    const bool drawn = tally.trials > 0 && !law_draws_.empty();
    r.tables.push_back(compare::laws_table(s_.laws, law_draws_, drawn ? &tally.groups[depths_.size()] : nullptr,
                                           drawn ? tally.counts.data() + law_counts() : nullptr,
                                           s_.verdict.confidence));
  }
  if (wanted_.profile) {
    r.tables.push_back(orders_table(tally));
    r.tables.push_back(order_coverage_table(tally));
  }
  r.tables.push_back(covariance_table(tally));
  if (s_.disturbance) {
    r.tables.push_back(scenario::disturbance_table(*s_.disturbance, s_.field, &stream_));
    r.tables.push_back(disturbance_runs_table());
  }
  if (stop_.is_on()) r.tables.push_back(stop_.looks_table(tally));
  if (s_.sources == Sources::each) r.tables.push_back(additivity_table(tally));
  r.tables.push_back(scenario::validity_table(s_.survey, s_.tools, s_.validity));
  std::vector<compare::Warning> warnings = scenario::validity_warnings(s_.survey, s_.tools, s_.validity);
  scenario::add_spacing_warning(warnings, s_.survey, s_.tvd, s_.tools, s_.field, s_.latitude);
  r.tables.push_back(compare::warnings_table(warnings));
  if (s_.save_samples > 0 && s_.samples()) r.samples = {compare::position_samples_table(tally.samples)};
  return r;
}

std::string ErrorModelMonteCarlo::replay(std::uint64_t trial) const {
  if (!s_.samples()) return {};
  survey::LaneArray out(1, drawn_.front().well.rows());
  const std::uint64_t first = trial / simd::kGroup * simd::kGroup;
  const std::optional<survey::LaneArray> made = made_draws(first, 1);
  drawn_.front().well.draw(stream_, first, s_.antithetic, 1, out, made ? &*made : nullptr);
  const int lane = static_cast<int>(trial % simd::kGroup);
  std::string text = fmt::format("trial {}\n", trial);
  for (std::size_t i = 0; i < errors_.station_draws; ++i) {
    const std::uint64_t drawn = s_.antithetic ? trial / 2 : trial;
    const double normal = stream_.normal(drawn, places_[i].channel, places_[i].index),
                 sign = s_.antithetic && trial % 2 == 1 ? -1 : 1;
    double z = sign * normal;
    if (const int slot = mixing_.slot_of_draw[i]; slot >= 0) {
      const random::MixingSlot& of = mixing_.slots[static_cast<std::size_t>(slot)];
      const random::MixingLaw::Draw v = of.law->draw(stream_.normal(drawn, of.channel, of.index));
      z = v.factor * z + v.shift;
    }
    const propagate::ErrorDraw& d = errors_.draws[i];
    text += fmt::format("  {} ({}), from {:.10g} m on: {:.17g}\n", errors_.sources[d.source].code,
                        error_model::mode_letter(errors_.sources[d.source].mode), s_.survey.stations[d.first].md, z);
  }
  text += fmt::format("  and {} draws of one station each\n", errors_.draws.size() - errors_.station_draws);
  constexpr std::array<const char*, 3> kNames{"north", "east", "vertical"};
  for (std::size_t d = 0; d < depths_.size(); ++d) {
    text += fmt::format("  error at {:.10g} m:", depths_[d].md);
    for (int a = 0; a < 3; ++a)
      text += fmt::format(" {} {:.17g} m", kNames[static_cast<std::size_t>(a)],
                          out.value(lane, 3 * static_cast<int>(d) + a));
    text += "\n";
  }
  return text;
}

namespace {

/// What a trial costs: it draws every source at every station.
double trial_cost(const Scenario& s) {
  double terms = 0;
  for (const propagate::ToolRun& run : s.tools.runs) terms += static_cast<double>(run.model->terms.size());
  return s.survey.size() * terms;
}

class ErrorModelMonteCarloPlan final : public study::PlanOfPoint<Scenario, ErrorModelMonteCarlo> {
 public:
  using PlanOfPoint::PlanOfPoint;
  /// Without trials it is the prediction.
  double cost() const override { return trial_cost(s_) * std::max(1.0, static_cast<double>(s_.trial_plan.trials)); }
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::error_model_monte_carlo,
          "Every source of an error model drawn through nonlinear minimum curvature, against its covariance",
          "ISCWSA MWD error model Rev 4 and Rev 5.10, OWSG tool codes; Williamson 2000, section on assumptions",
          [](config::ConfigReader& config, random::StudySeed seed) -> std::unique_ptr<study::PointPlan> {
            Scenario s = read_scenario(config, seed);
            if (s.events.empty()) return std::make_unique<ErrorModelMonteCarloPlan>(std::move(s));
            return events::event_plan(
                s.event_run, s.annotations, random::stream_of(s.seed), [s] { return events_of(s); },
                montecarlo::kBlockTrials, trial_cost(s));
          }};
}

}  // namespace surveymc::studies::error_model_monte_carlo
