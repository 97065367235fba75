#include "clearance/drawn_pairs.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/position_comparison.h"
#include "compare/table_rows.h"
#include "propagate/ellipse.h"
#include "random/study_stream.h"
#include "stats/control_variate.h"
#include "survey/readings.h"

namespace surveymc::studies::clearance {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using proximity::PairErrors;
using proximity::ScanDirection;
using proximity::SharedDraws;

constexpr int kBatch = 64;  // trials drawn at a time

const Formulation& formulation_of(const Scenario& s, const std::string& name) {
  static const Formulation kSharedHole{"shared", Formulation::Kind::shared_hole};
  const auto at =
      std::find_if(s.formulations.begin(), s.formulations.end(), [&](const Formulation& f) { return f.name == name; });
  return at == s.formulations.end() ? kSharedHole : *at;
}

}  // namespace

std::unique_ptr<const DrawnPairs> drawn_pairs(const Scenario& s) {
  std::unique_ptr<DrawnPairs> out(new DrawnPairs(s, random::stream_of(s.seed)));
  const Reference reference = scenario::pair_reference(s.reference, s.interpolation);
  const propagate::WellErrors drawn = scenario::drawn_errors(s.reference, s.reference.tools, s.drawing.vertical);
  std::vector<propagate::WellPoint> points;
  for (const double md : s.report_md) points.push_back(proximity::well_point(reference.path().at(md)));
  scenario::require_drawable(s.reference.model_place, drawn, points.back().station, s.reference.name);
  out->reference_ =
      std::make_unique<proximity::DrawnPoints>(proximity::drawn_points(drawn, points, propagate::draw_places(drawn)));
  for (const Well& well : s.offsets) out->add_offset(reference, drawn, well);
  return out;
}

void DrawnPairs::add_offset(const Reference& reference, const propagate::WellErrors& drawn_reference,
                            const Well& well) {
  const Pair pair = scenario::well_pair(s_, reference, well);
  Offset out;
  out.name = well.name;
  std::vector<propagate::WellPoint> reference_points, points;
  for (std::size_t d = 0; d < s_.report_md.size(); ++d) {
    if (s_.report_md[d] <= pair.geometry.reference->md(pair.geometry.first)) continue;
    out.depths.push_back(d);
    out.points.push_back(proximity::pair_at(pair.geometry, ScanDirection::reference, s_.report_md[d]));
    reference_points.push_back(proximity::well_point(out.points.back().reference));
    points.push_back(proximity::well_point(out.points.back().offset));
  }
  if (points.empty()) return;
  const std::size_t deepest =
      std::max_element(points.begin(), points.end(), [](const propagate::WellPoint& a, const propagate::WellPoint& b) {
        return a.station < b.station;
      })->station;
  // The sidetrack's own run of "shared", or one well of which the run goes on.
  const propagate::WellErrors as_one_well = scenario::drawn_errors(well, well.tools, s_.drawing.vertical);
  const propagate::WellErrors as_sidetrack =
      well.kickoff ? scenario::drawn_errors(well, well.tools_from_kickoff, s_.drawing.vertical)
                   : propagate::WellErrors{};
  scenario::require_drawable(well.model_place, as_one_well, deepest, well.name);
  if (well.kickoff) scenario::require_drawable(well.model_place, as_sidetrack, deepest, well.name);
  const auto offset_of = [&](const Formulation& f) -> const propagate::WellErrors& {
    return f.kind == Formulation::Kind::sharing ? as_one_well : as_sidetrack;
  };
  const auto shared_of = [&](const Formulation& f) {
    return f.kind == Formulation::Kind::sharing
               ? proximity::shared_draws(drawn_reference, as_one_well, pair.formulation(f.name))
               : proximity::draws_of_shared_hole(drawn_reference, as_sidetrack, *well.kickoff);
  };
  const auto truth_of = [&](const Formulation& f) {
    const std::string name = !s_.drawing.formulation.empty()       ? s_.drawing.formulation
                             : f.kind == Formulation::Kind::zeroed ? "shared"
                                                                   : f.name;
    const auto same =
        std::find_if(out.truths.begin(), out.truths.end(), [&](const Truth& t) { return t.formulation == name; });
    if (same != out.truths.end()) return static_cast<std::size_t>(same - out.truths.begin());
    const Formulation& drawn = formulation_of(s_, name);
    const propagate::WellErrors& errors = offset_of(drawn);
    const SharedDraws shared = shared_of(drawn);
    Truth t{name,
            std::make_unique<proximity::DrawnPoints>(
                proximity::drawn_points(errors, points, proximity::offset_places(drawn_reference, errors, shared))),
            {}};
    for (std::size_t i = 0; i < points.size(); ++i)
      t.control.push_back(proximity::relative_covariance(drawn_reference, errors, shared, reference_points[i],
                                                         points[i], propagate::FirstOrder::minimum_curvature));
    out.truths.push_back(std::move(t));
    return out.truths.size() - 1;
  };
  for (const Formulation& f : s_.formulations) {
    if (!f.is_for(well)) continue;
    if (!s_.drawing.formulation.empty() && !formulation_of(s_, s_.drawing.formulation).is_for(well)) continue;
    Judgement j{f.name, truth_of(f), {}};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const proximity::PairPoints& p = out.points[i];
      const PairErrors& errors = pair.formulation(f.name);
      const Matrix3d c =
          f.kind == Formulation::Kind::zeroed
              ? proximity::relative_covariance(errors,
                                               errors.reference->covariance_at(p.reference.leg, p.reference.share),
                                               errors.offset->covariance_at(p.offset.leg, p.offset.share),
                                               p.reference.leg, p.reference.share, p.offset.leg, p.offset.share)
              : proximity::relative_covariance(drawn_reference, offset_of(f), shared_of(f), reference_points[i],
                                               points[i], propagate::FirstOrder::iscwsa);
      const propagate::Ellipsoid body = propagate::ellipsoid(c);
      Judgement::AtDepth at;
      const Vector3d d = p.offset.position - p.reference.position;
      at.directions.col(0) = p.distance > 0 ? Vector3d(d / p.distance) : Vector3d::Zero();
      at.sd[0] = proximity::pedal_radius(c, at.directions.col(0));
      at.weight.setZero();
      for (int a = 0; a < 3; ++a) {
        at.directions.col(1 + a) = body.axes.col(a);
        at.sd[1 + a] = body.semi_axes[a];
        at.weight += body.axes.col(a) * body.axes.col(a).transpose() / (body.semi_axes[a] * body.semi_axes[a]);
      }
      if (!(body.semi_axes[2] > 0)) at.weight.setConstant(kNaN);
      j.at.push_back(at);
    }
    out.judgements.push_back(std::move(j));
  }
  offsets_.push_back(std::move(out));
}

template <class Visit>
void DrawnPairs::visit_trials(std::uint64_t first_trial, int count, Visit visit) const {
  survey::LaneArray reference(kBatch / simd::kGroup, reference_->well().rows());
  std::vector<std::vector<survey::LaneArray>> offsets(offsets_.size());
  for (std::size_t o = 0; o < offsets_.size(); ++o)
    for (const Truth& t : offsets_[o].truths) offsets[o].emplace_back(kBatch / simd::kGroup, t.offset->well().rows());
  for (int done = 0; done < count; done += kBatch) {
    const int trials = std::min(kBatch, count - done), groups = survey::groups_for(trials);
    const std::uint64_t first = first_trial + static_cast<std::uint64_t>(done);
    reference_->well().draw(stream_, first, false, groups, reference);
    for (std::size_t o = 0; o < offsets_.size(); ++o)
      for (std::size_t t = 0; t < offsets_[o].truths.size(); ++t)
        offsets_[o].truths[t].offset->well().draw(stream_, first, false, groups, offsets[o][t]);
    for (int t = 0; t < trials; ++t) visit(done + t, t, reference, offsets);
  }
}

stats::Tally DrawnPairs::run_block(std::uint64_t first_trial, int count) const {
  stats::Tally tally;
  tally.trials = static_cast<std::uint64_t>(count);
  std::vector<Eigen::MatrixXd> errors, controls, nees;  // of every offset, judgement and depth
  for (const Offset& o : offsets_)
    for (const Judgement& j : o.judgements)
      for (std::size_t d = 0; d < j.at.size(); ++d) {
        errors.emplace_back(count, kDirections);
        controls.emplace_back(count, kDirections);
        nees.emplace_back(count, 1);
      }
  visit_trials(first_trial, count, [&](int row, int t, const auto& reference, const auto& offsets) {
    std::size_t at = 0;
    for (std::size_t o = 0; o < offsets_.size(); ++o) {
      const Offset& own = offsets_[o];
      for (const Judgement& j : own.judgements) {
        const Truth& truth = own.truths[j.truth];
        for (std::size_t d = 0; d < j.at.size(); ++d, ++at) {
          const Vector3d x = truth.offset->error(offsets[o][j.truth], t, d) -
                             reference_->error(reference, t, own.depths[d]),
                         l = truth.offset->first_order(offsets[o][j.truth], t, d) -
                             reference_->first_order(reference, t, own.depths[d]);
          errors[at].row(row) = x.transpose() * j.at[d].directions;
          controls[at].row(row) = l.transpose() * j.at[d].directions;
          nees[at](row, 0) = x.dot(j.at[d].weight * x);
          const std::uint64_t trial = first_trial + static_cast<std::uint64_t>(row);
          if (trial < s_.drawing.save_samples && &j == &own.judgements.front())
            tally.samples.insert(tally.samples.end(), {static_cast<double>(o + 1), s_.report_md[own.depths[d]],
                                                       static_cast<double>(trial), x[0], x[1], x[2]});
        }
      }
    }
  });
  for (std::size_t at = 0; at < errors.size(); ++at) {
    tally.groups.push_back(stats::Moments::of(nees[at]));
    for (int q = 0; q < kDirections; ++q)
      tally.controlled.push_back(stats::Moments::of(
          stats::control_columns(errors[at].col(q), errors[at].col(q), controls[at].col(q), controls[at].col(q))));
  }
  return tally;
}

store::Table DrawnPairs::relative_position(const stats::Tally& tally) const {
  store::Table all;
  const auto add = [&](const Offset& o, const Judgement& j, double md,
                       const std::vector<compare::ComparisonRow>& rows) {
    store::Table t = compare::comparison_table(
        "relative_position",
        "the relative position by Monte Carlo, along the line between the wells and the axes of the predicted "
        "ellipsoid" +
            compare::at_confidence(s_.drawing.verdict.confidence),
        rows, tally.trials, tally.failed, true);
    const std::string drawn = o.truths.empty() ? "" : o.truths[j.truth].formulation;
    std::vector<store::Column> leading{
        {"md_m", "m", "measured depth on the reference", std::vector<double>(rows.size(), md)},
        {"offset", "", "name of the offset well", std::vector<std::string>(rows.size(), o.name)},
        {"drawn", "", "formulation by which the wells share draws", std::vector<std::string>(rows.size(), drawn)}};
    t.columns.insert(t.columns.begin(), leading.begin(), leading.end());
    store::append_rows(all, t);
  };
  add({}, {}, 0, {});  // the columns, even where there is no row
  std::size_t at = 0;
  for (const Offset& o : offsets_) {
    for (const Judgement& j : o.judgements)
      for (std::size_t d = 0; d < j.at.size(); ++d, ++at) {
        std::vector<compare::ComparisonRow> rows;
        for (int q = 0; q < kDirections; ++q) {
          const Vector3d a = j.at[d].directions.col(q);
          const double control = a.dot(o.truths[j.truth].control[d] * a);
          if (!(j.at[d].sd[q] > 0) || !(control > 0)) continue;
          const stats::ControlledEstimate e = stats::controlled_sd(
              tally.controlled[at * kDirections + static_cast<std::size_t>(q)], control, s_.drawing.verdict.confidence);
          rows.push_back(compare::compare_value(kRelativeQuantities[static_cast<std::size_t>(q)], "m",
                                                {e.controlled, e.controlled_interval}, j.at[d].sd[q],
                                                s_.drawing.verdict, tally.trials));
        }
        if (j.at[d].weight.allFinite())
          rows.push_back(compare::compare_nees("nees", stats::summarise(tally.groups[at], 0), 3, s_.drawing.verdict,
                                               tally.trials));
        for (compare::ComparisonRow& row : rows) row.formulation = j.formulation;
        s_.drawing.annotations.apply("relative_position", rows);
        add(o, j, s_.report_md[o.depths[d]], rows);
      }
  }
  return all;
}

store::Table DrawnPairs::realisations(const stats::Tally& tally) const {
  store::Table t{"relative_realisations",
                 "errors of the relative position of the first trials, by the draws of the first formulation"};
  t.columns = {compare::number_column("offset", "1", "number of the offset, from 1"),
               compare::number_column("md_m", "m", "measured depth on the reference"),
               compare::number_column("trial", "1", "number of the trial, from 0")};
  for (const char* d : {"north_m", "east_m", "down_m"})
    t.columns.push_back(compare::number_column(d, "m", "offset less reference, less the true difference"));
  return compare::table_of_numbers(std::move(t), tally.samples);
}

std::string DrawnPairs::replay(std::uint64_t trial) const {
  std::string text = fmt::format("trial {}\n", trial);
  const int lane = static_cast<int>(trial % simd::kGroup);
  visit_trials(trial - static_cast<std::uint64_t>(lane), simd::kGroup,
               [&](int, int t, const auto& reference, const auto& offsets) {
                 if (t != lane) return;
                 for (std::size_t o = 0; o < offsets_.size(); ++o)
                   for (std::size_t w = 0; w < offsets_[o].truths.size(); ++w)
                     for (std::size_t d = 0; d < offsets_[o].depths.size(); ++d) {
                       const Vector3d x = offsets_[o].truths[w].offset->error(offsets[o][w], t, d) -
                                          reference_->error(reference, t, offsets_[o].depths[d]);
                       text += fmt::format("  {}, {}, at {:.10g} m: north {:.17g} east {:.17g} down {:.17g} m\n",
                                           offsets_[o].name, offsets_[o].truths[w].formulation,
                                           s_.report_md[offsets_[o].depths[d]], x[0], x[1], x[2]);
                     }
               });
  return text;
}

}  // namespace surveymc::studies::clearance
