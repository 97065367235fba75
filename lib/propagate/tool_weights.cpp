#include "propagate/tool_weights.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/units.h"

namespace surveymc::propagate {
namespace {

/// Where the parts of a lateral weight are taken from its values at both signs of Sin(Inc). Weights are smooth in
/// Sin(Inc): what the even and the odd part miss is of relative size kNearVertical^2.
constexpr double kNearVertical = 1e-4;

/// Infinite if one is not finite.
double largest_of(const double* x, std::size_t count) {
  if (x == nullptr) return 0;
  double most = 0;
  bool is_fine = true;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = std::abs(x[i]);
    is_fine = is_fine & (a <= 1e300);
    most = most < a ? a : most;
  }
  return is_fine ? most : HUGE_VAL;
}

/// Of the stretch that station k is in.
std::size_t stretch_index(const std::vector<GyroStretch>& stretches, std::size_t k) {
  const auto at =
      std::partition_point(stretches.begin(), stretches.end(), [&](const GyroStretch& s) { return s.end <= k; });
  return static_cast<std::size_t>(at - stretches.begin());
}

/// True if the value of a node depends on `v`.
bool depends_on(const error_model::Graph& graph, std::size_t node, error_model::Variable v) {
  const std::vector<bool> needed = graph.needed_by(node);
  for (std::size_t i = 0; i <= node; ++i) {
    const error_model::Graph::Node& n = graph.nodes()[i];
    if (needed[i] && n.operation == error_model::Operation::variable && n.variable == v) return true;
  }
  return false;
}

}  // namespace

StationDirections::StationDirections(const survey::Survey& survey, double declination) {
  const std::size_t n = survey.stations.size();
  for (auto* v : {&sin_i, &cos_i, &sin_a, &cos_a, &sin_am, &cos_am, &north, &east}) v->resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const survey::Station& s = survey.stations[k];
    sin_i[k] = std::sin(s.inclination);
    cos_i[k] = std::cos(s.inclination);
    sin_a[k] = std::sin(s.azimuth);
    cos_a[k] = std::cos(s.azimuth);
    const double magnetic = s.azimuth - declination;
    sin_am[k] = declination == 0 ? sin_a[k] : std::sin(magnetic);
    cos_am[k] = declination == 0 ? cos_a[k] : std::cos(magnetic);
    north[k] = sin_i[k] * cos_a[k];
    east[k] = sin_i[k] * sin_a[k];
  }
}

RunWeights::RunWeights(const error_model::Model& model, const error_model::ModelGraph& graph,
                       const survey::Survey& survey, const std::vector<double>& tvd,
                       const StationDirections& directions, const survey::ReferenceField& field, double latitude,
                       bool with_tilt)
    : model_(model),
      graph_(graph),
      survey_(survey),
      tvd_(tvd),
      directions_(directions),
      declination_(field.declination),
      surroundings_(error_model::surroundings_of(model.parameters, field.dip, field.total, field.gravity, latitude)),
      evaluation_(graph.graph, surroundings_),
      weights_(graph.functions.size()),
      modes_(graph.functions.size()),
      parts_(with_tilt ? graph.functions.size() : 0) {
  zeros_.fill(0);
  for (std::size_t f = 0; f < parts_.size(); ++f) parts_[f].parting = parting_of(graph.functions[f]);
}

void RunWeights::begin_run(const std::vector<GyroStretch>& stretches) {
  stretches_ = stretches;
  for (ByMode& m : modes_) m = {};
}

void RunWeights::evaluate(std::size_t first, std::size_t count) {
  fill_inputs(first, count);
  if (!parts_.empty()) evaluate_parts(first, count);
  evaluation_.run(count);
  for (std::size_t f = 0; f < weights_.size(); ++f) weights_[f] = weights_of(f, first, count);
}

void RunWeights::fill_inputs(std::size_t first, std::size_t count) {
  const error_model::Graph& g = graph_.graph;
  const auto fill = [&](error_model::Variable v, const auto& value_at) {
    if (!g.names(v)) return;
    double* x = evaluation_.input(v);
    for (std::size_t i = 0; i < count; ++i) x[i] = value_at(first + i);
  };
  const auto& s = survey_.stations;
  fill(error_model::Variable::md, [&](std::size_t k) { return s[k].md; });
  fill(error_model::Variable::md_before, [&](std::size_t k) { return s[k - 1].md; });
  fill(error_model::Variable::tvd, [&](std::size_t k) { return tvd_[k]; });
  fill(error_model::Variable::inclination, [&](std::size_t k) { return s[k].inclination; });
  fill(error_model::Variable::inclination_before, [&](std::size_t k) { return s[k - 1].inclination; });
  fill(error_model::Variable::azimuth, [&](std::size_t k) { return s[k].azimuth; });
  fill(error_model::Variable::azimuth_before, [&](std::size_t k) { return azimuth_before(s[k - 1], s[k]); });
  fill(error_model::Variable::azimuth_magnetic, [&](std::size_t k) { return s[k].azimuth - declination_; });
  const double noise = model_.gyro ? 1 : model_.parameters.noise_reduction;
  fill(error_model::Variable::noise_reduction, [&](std::size_t) { return noise; });
  fill(error_model::Variable::running_speed, [&](std::size_t k) { return speed_at(s[k].inclination); });
  const StationDirections& d = directions_;
  fill(error_model::Variable::sin_inclination, [&](std::size_t k) { return d.sin_i[k]; });
  fill(error_model::Variable::cos_inclination, [&](std::size_t k) { return d.cos_i[k]; });
  fill(error_model::Variable::sin_azimuth, [&](std::size_t k) { return d.sin_a[k]; });
  fill(error_model::Variable::cos_azimuth, [&](std::size_t k) { return d.cos_a[k]; });
  fill(error_model::Variable::sin_azimuth_magnetic, [&](std::size_t k) { return d.sin_am[k]; });
  fill(error_model::Variable::cos_azimuth_magnetic, [&](std::size_t k) { return d.cos_am[k]; });
}

double RunWeights::speed_at(double inclination) const {
  if (model_.gyro)
    for (const error_model::GyroZone& z : model_.gyro->zones)
      if (zone_at(*model_.gyro, z.axis, inclination) == &z) return z.speed;
  return 1;
}

BlockWeights RunWeights::weights_of(std::size_t f, std::size_t first, std::size_t count) {
  const error_model::FunctionNodes& n = graph_.functions[f];
  const auto output = [&](const std::optional<std::size_t>& node) {
    return node ? evaluation_.output(*node) : nullptr;
  };
  BlockWeights w;
  w.depth = output(n.depth);
  w.inclination = output(n.inclination);
  w.lateral = output(n.lateral);
  if (n.has_vertical()) {
    w.vertical_north = n.vertical_north ? output(n.vertical_north) : zeros_.data();
    w.vertical_east = n.vertical_east ? output(n.vertical_east) : zeros_.data();
  }
  if (!parts_.empty() && n.lateral) {
    w.azimuth = parts_[f].parting == Parting::azimuth_alone ? output(n.azimuth) : parts_[f].azimuth.data();
    w.tilt = parts_[f].tilt.data();
  }
  if (n.function->kind == error_model::Kind::continuous) run_sums(f, first, count, w);
  if (n.function->kind == error_model::Kind::stationary && model_.gyro) hold_values(f, first, count, w);
  w.largest_depth = largest_of(w.depth, count);
  w.largest_angle = std::max({largest_of(w.inclination, count), largest_of(w.lateral, count),
                              largest_of(w.vertical_north, count), largest_of(w.vertical_east, count)});
  return w;
}

const GyroStretch& RunWeights::stretch_at(std::size_t k) const { return stretches_[stretch_index(stretches_, k)]; }

void RunWeights::run_sums(std::size_t f, std::size_t first, std::size_t count, BlockWeights& w) {
  const error_model::FunctionNodes& n = graph_.functions[f];
  ByMode& m = modes_[f];
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = first + i;
    const GyroStretch& stretch = stretch_at(k);
    const bool begins_section = k == stretch.first && (k == stretches_.front().first || !stretch.is_continuous);
    if (begins_section) m.sum = 0;
    if (zone_at(*model_.gyro, n.function->axis, survey_.stations[k].inclination) != nullptr)
      m.sum = evaluation_.step(n.azimuth_chain, m.sum, i);
    m.azimuth[i] = stretch.is_continuous ? m.sum : 0;
    m.lateral[i] = stretch.is_continuous ? directions_.sin_i[k] * m.sum : 0;
  }
  w.lateral = m.lateral.data();
  if (parts_.empty()) return;
  w.azimuth = m.azimuth.data();
  w.tilt = zeros_.data();
}

void RunWeights::hold_values(std::size_t f, std::size_t first, std::size_t count, BlockWeights& w) {
  const error_model::FunctionNodes& n = graph_.functions[f];
  ByMode& m = modes_[f];
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = first + i;
    const GyroStretch& stretch = stretch_at(k);
    if (stretch.is_continuous && k == stretch.first) initialise(n, stretch, m);
    m.inclination[i] = stretch.is_continuous ? m.held_inclination : w.inclination ? w.inclination[i] : 0;
    m.lateral[i] = stretch.is_continuous ? directions_.sin_i[k] * m.held_azimuth : w.lateral ? w.lateral[i] : 0;
    m.azimuth[i] = stretch.is_continuous ? m.held_azimuth : w.azimuth ? w.azimuth[i] : 0;
    if (!parts_.empty() && stretch.is_continuous) parts_[f].tilt[i] = 0;
  }
  if (n.inclination) w.inclination = m.inclination.data();
  if (!n.lateral) return;
  w.lateral = m.lateral.data();
  if (!parts_.empty()) w.azimuth = m.azimuth.data();
}

void RunWeights::initialise(const error_model::FunctionNodes& n, const GyroStretch& stretch, ByMode& m) const {
  const std::size_t k = stretch.initialised_from;
  error_model::SampleStation s;
  s.inclination = stretch.initialised_inclination;
  s.azimuth = stretch.initialised_azimuth;
  s.declination = declination_;
  s.md = survey_.stations[k].md;
  s.dmd = survey_.stations[k + 1].md - s.md;
  s.tvd = tvd_[k];
  s.noise_reduction = model_.parameters.noise_reduction;
  error_model::Evaluation at(graph_.graph, surroundings_);
  error_model::set_station(at, 0, s);
  at.run(1);
  m.held_inclination = n.inclination ? at.output(*n.inclination)[0] : 0;
  m.held_azimuth = n.azimuth   ? at.output(*n.azimuth)[0]
                   : n.lateral ? at.output(*n.lateral)[0] / std::sin(s.inclination)
                               : 0;
}

RunWeights::Parting RunWeights::parting_of(const error_model::FunctionNodes& n) const {
  if (!n.lateral) return Parting::none;
  const bool is_azimuth = n.azimuth.has_value();
  if (is_azimuth && !n.has_vertical()) return Parting::azimuth_alone;
  if (depends_on(graph_.graph, *n.lateral, error_model::Variable::inclination)) return Parting::tilt_alone;
  return is_azimuth ? Parting::even_part : Parting::at_zero_sine;
}

void RunWeights::evaluate_parts(std::size_t first, std::size_t count) {
  const auto is = [&](std::size_t f, Parting parting) { return parts_[f].parting == parting; };
  const auto parted = [&](std::size_t f) { return is(f, Parting::at_zero_sine) || is(f, Parting::even_part); };
  for (Parts& p : parts_) p.tilt.fill(0);
  bool any_parted = false, any_lateral = false;
  for (std::size_t f = 0; f < parts_.size(); ++f) {
    any_parted = any_parted || parted(f);
    any_lateral = any_lateral || is(f, Parting::tilt_alone);
  }
  if (!any_parted && !any_lateral) return;
  double* sine = evaluation_.input(error_model::Variable::sin_inclination);
  const auto lateral_with = [&](double sin_inclination) {
    std::vector<StationColumn> out(parts_.size());
    std::fill_n(sine, count, sin_inclination);
    evaluation_.run(count);
    for (std::size_t f = 0; f < parts_.size(); ++f)
      if (parted(f)) std::copy_n(evaluation_.output(*graph_.functions[f].lateral), count, out[f].begin());
    return out;
  };
  const auto plus = lateral_with(kNearVertical), minus = lateral_with(-kNearVertical), zero = lateral_with(0);
  std::copy_n(directions_.sin_i.begin() + static_cast<std::ptrdiff_t>(first), count, sine);
  evaluation_.run(count);
  for (std::size_t f = 0; f < parts_.size(); ++f) {
    Parts& p = parts_[f];
    if (!parted(f) && !is(f, Parting::tilt_alone)) continue;
    const double* lateral = evaluation_.output(*graph_.functions[f].lateral);
    for (std::size_t i = 0; i < count; ++i) {
      if (is(f, Parting::tilt_alone)) {
        p.tilt[i] = lateral[i];
        p.azimuth[i] = 0;
        continue;
      }
      const bool has_value = is(f, Parting::at_zero_sine) && std::isfinite(zero[f][i]);
      p.tilt[i] = has_value ? zero[f][i] : 0.5 * (plus[f][i] + minus[f][i]);
      p.azimuth[i] = sine[i] < kNearVertical ? (plus[f][i] - minus[f][i]) / (2 * kNearVertical)
                                             : (lateral[i] - p.tilt[i]) / sine[i];
    }
  }
}

Grouping grouping_of(const error_model::Term& term, bool has_gyro) {
  const error_model::Kind kind = term.function->kind;
  const bool is_of_gyro = has_gyro && (kind == error_model::Kind::stationary || kind == error_model::Kind::continuous);
  if (is_of_gyro && (term.mode == error_model::PropagationMode::random || term.function->per_section))
    return Grouping::mixed;
  return term.mode == error_model::PropagationMode::random ? Grouping::station : Grouping::run;
}

std::array<bool, kStationBlock> group_begins(const std::vector<GyroStretch>& stretches, std::size_t first,
                                             std::size_t count) {
  std::array<bool, kStationBlock> out{};
  if (stretches.empty()) return out;
  std::size_t at = stretch_index(stretches, first);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = first + i;
    if (k == stretches[at].end) ++at;
    out[i] = k == stretches[at].first || !stretches[at].is_continuous;
  }
  return out;
}

double azimuth_before(const survey::Station& before, const survey::Station& at) {
  if (before.inclination < error_model::kVerticalLimit) return at.azimuth;
  const double turn = at.azimuth - before.azimuth;
  return std::abs(turn) <= kPi ? before.azimuth : at.azimuth - std::remainder(turn, 2 * kPi);
}

}  // namespace surveymc::propagate
