/// Events of `error_model_monte_carlo`: the error at a station beyond a limit, where the config has `[[event]]`.
#include <algorithm>
#include <cmath>

#include "error_model_monte_carlo/study.h"
#include "events/linear_event.h"
#include "random/rare_channels.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::error_model_monte_carlo {
namespace {

constexpr double kNoVariance = 1e-14;  // of the trace: such a variance is none

/// A well, drawn by the normals of plain trials. With a disturbance by others: its correlated draws are sums of
/// independent ones here, some of which last, and the draws are numbered anew.
class EventWell {
 public:
  EventWell(const Scenario& s, const propagate::WellErrors& errors)
      : point_(propagate::point_at(s.survey, s.report_md.front())),
        truth_(survey::minimum_curvature_positions(s.survey)[point_.station]),
        effects_(propagate::draw_effects(errors, point_, propagate::FirstOrder::minimum_curvature)),
        well_(propagate::drawn_well(errors, {point_}, propagate::draw_places(errors), false,
                                    propagate::well_mixing(errors, s.laws, propagate::draw_places(errors)))) {
    const std::vector<propagate::DrawPlace> places = propagate::draw_places(errors);
    const propagate::WellMixing mixing = propagate::well_mixing(errors, s.laws, places);
    const survey::Station& at = s.survey.stations[point_.station];
    directions_ << Eigen::Matrix3d::Identity(), survey::rotation_hla_from_nev(at.inclination, at.azimuth).transpose();
    for (const propagate::DrawCall& c : well_.calls()) rows_.push_back(row_of(c.channel, 4 * c.call));
    const std::size_t of_errors = calls_.size();
    for (const random::MixingSlot& slot : well_.slots()) slot_rows_.push_back(row_of(slot.channel, slot.index));
    for (std::size_t d = 0; d < places.size(); ++d) {
      const auto call = std::find_if(
          calls_.begin(), calls_.begin() + static_cast<std::ptrdiff_t>(of_errors),
          [&](const rare::NormalCall& c) { return c.channel == places[d].channel && c.call == places[d].index / 4; });
      // A draw of a deeper station may share the call of one that counts.
      if (call == calls_.begin() + static_cast<std::ptrdiff_t>(of_errors) ||
          effects_.col(static_cast<Eigen::Index>(d)).isZero(0))
        continue;  // without effect down to the point
      const std::uint32_t row = row_of(places[d].channel, places[d].index);
      draws_.emplace_back(row, d);
      names_[row] = errors.sources[errors.draws[d].source].code;
      if (mixing.slot_of_draw[d] < 0) continue;
      const random::MixingSlot& slot = mixing.slots[static_cast<std::size_t>(mixing.slot_of_draw[d])];
      const std::uint32_t v = row_of(slot.channel, slot.index);
      auto at_v = std::find_if(mixing_.begin(), mixing_.end(), [&](const rare::MixingNormal& m) { return m.row == v; });
      if (at_v == mixing_.end()) at_v = mixing_.insert(at_v, {v, slot.law, {}});
      at_v->of.push_back(row);
      names_[v] = "variance of the reference";
    }
  }

  int dimension() const { return static_cast<int>(4 * calls_.size()); }
  const std::vector<rare::NormalCall>& calls() const { return calls_; }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<rare::MixingNormal>& mixing() const { return mixing_; }
  /// N, E, V of high side, lateral, along hole after those of north, east, vertical.
  Eigen::Vector3d direction(std::size_t i) const { return directions_.col(static_cast<Eigen::Index>(i)); }
  Eigen::Matrix3d covariance() const { return propagate::covariance_of(effects_); }
  /// Change of the error along a direction by every normal.
  Eigen::VectorXd slope(const Eigen::Vector3d& direction) const {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(dimension());
    for (const auto& [row, draw] : draws_) out[row] = direction.dot(effects_.col(static_cast<Eigen::Index>(draw)));
    return out;
  }
  /// The error along a direction, m.
  void errors(const survey::LaneArray& z, int groups, const Eigen::Vector3d& direction, double* out) const {
    survey::LaneArray path(groups, static_cast<int>(propagate::kPathRows * well_.stations()));
    well_.draw_path(z, rows_, slot_rows_, groups, path);
    const int first = static_cast<int>(propagate::kPathRows * point_.station);
    for (int t = 0; t < groups * simd::kGroup; ++t)
      out[t] = direction.dot(Eigen::Vector3d(path.value(t, first), path.value(t, first + 1), path.value(t, first + 2)) -
                             truth_);
  }

 private:
  std::uint32_t row_of(random::Channel channel, std::uint32_t index) {
    const auto at = std::find_if(calls_.begin(), calls_.end(), [&](const rare::NormalCall& c) {
      return c.channel == channel && c.call == index / 4;
    });
    const auto number = static_cast<std::uint32_t>(at - calls_.begin());
    if (at == calls_.end()) calls_.push_back({channel, index / 4});
    names_.resize(4 * calls_.size());
    return 4 * number + index % 4;
  }

  propagate::WellPoint point_;
  Eigen::Vector3d truth_;
  Eigen::Matrix3Xd effects_;
  propagate::DrawnWell well_;
  Eigen::Matrix<double, 3, 6> directions_;
  std::vector<rare::NormalCall> calls_;
  std::vector<std::string> names_;
  std::vector<rare::MixingNormal> mixing_;
  std::vector<std::uint32_t> rows_, slot_rows_;
  std::vector<std::pair<std::uint32_t, std::size_t>> draws_;  ///< row, draw
};

class WellEvent final : public rare::LimitState {
 public:
  /// `direction`: over the standard deviation where the quantity is in sds.
  WellEvent(std::shared_ptr<const EventWell> well, const events::EventRule& rule, const Eigen::Vector3d& direction)
      : well_(std::move(well)), rule_(rule), direction_(direction) {}

  int dimension() const override { return well_->dimension(); }
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override {
    well_->errors(z, groups, direction_, g);
    for (int t = 0; t < groups * simd::kGroup; ++t) {
      const double quantity = rule_.quantity >= kFirstInSd ? std::abs(g[t]) : g[t];
      g[t] = !std::isfinite(g[t]) ? kNaN : rule_.is_above ? rule_.limit - quantity : quantity - rule_.limit;
    }
  }

 private:
  std::shared_ptr<const EventWell> well_;
  events::EventRule rule_;
  Eigen::Vector3d direction_;
};

propagate::WellErrors errors_of(const Scenario& s) {
  propagate::WellErrors errors = propagate::resized(
      propagate::well_errors(s.survey, s.tvd, s.tools.runs, s.field, s.latitude, s.multiplier, s.vertical), s.laws);
  if (!s.disturbance) return errors;
  return propagate::with_independent_draws(errors,
                                           propagate::disturbed_draws(errors, s.tools.runs, *s.disturbance, s.field));
}

}  // namespace

std::vector<events::TrialEvent> events_of(const Scenario& s) {
  const propagate::WellErrors errors = errors_of(s);
  scenario::require_drawable(s.model_place, errors, propagate::point_at(s.survey, s.report_md.front()).station);
  const auto well = std::make_shared<const EventWell>(s, errors);
  std::vector<events::TrialEvent> events;
  for (const events::EventRule& rule : s.events) {
    const bool is_in_sd = rule.quantity >= kFirstInSd;
    const Eigen::Vector3d u = well->direction(rule.quantity % kFirstInSd);
    const double variance = u.dot(well->covariance() * u);
    rule.place.require(variance > kNoVariance * well->covariance().trace(), "the error has no part in this direction");
    const double sd = std::sqrt(variance), side = rule.is_above || is_in_sd ? 1 : -1;
    events::TrialEvent e;
    e.name = rule.name;
    e.state = std::make_shared<const WellEvent>(well, rule, is_in_sd ? Eigen::Vector3d(u / sd) : u);
    e.from = {well->calls(), random::kRareChoice};
    e.normals = well->names();
    e.place = rule.place;
    e.has_designs = true;
    events::predict(e, {side * well->slope(u), side * rule.limit / (is_in_sd ? 1 : sd), is_in_sd, well->mixing()});
    events.push_back(std::move(e));
  }
  return events;
}

}  // namespace surveymc::studies::error_model_monte_carlo
