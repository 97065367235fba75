#include "propagate/well_errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>

#include "base/units.h"
#include "propagate/tool_weights.h"
#include "simd/dual.h"
#include "survey/survey.h"

namespace surveymc::propagate {
namespace {

/// Numbers the draws of the sources while the stations are passed.
class DrawBook {
 public:
  explicit DrawBook(WellErrors& out) : out_(out) {}

  std::size_t source_of(const error_model::Term& term) {
    for (std::size_t s = 0; s < out_.sources.size(); ++s)
      if (out_.sources[s].code == term.code && out_.sources[s].mode == term.mode) return s;
    out_.sources.push_back({term.code, term.mode, {}, reference_element(term.code, term.function->name)});
    open_.emplace_back();
    return out_.sources.size() - 1;
  }
  /// The draw of a source at a station of a run; a new one after end().
  std::uint32_t draw(std::size_t source, std::size_t run, std::size_t station) {
    if (!open_[source]) {
      open_[source] = static_cast<std::uint32_t>(out_.draws.size());
      out_.draws.push_back({static_cast<std::uint32_t>(source), run, run, station, station});
    }
    ErrorDraw& d = out_.draws[*open_[source]];
    d.last_run = run;
    d.last = station;
    return *open_[source];
  }
  void end(std::size_t source) { open_[source].reset(); }

 private:
  WellErrors& out_;
  std::vector<std::optional<std::uint32_t>> open_;  ///< the draw at hand of each source
};

double value_at(const double* column, std::size_t i) { return column == nullptr ? 0 : column[i]; }

/// One sigma of a term at one station; nothing if it has no effect there.
std::optional<DrawEffect> effect_at(const error_model::Term& term, const BlockWeights& w, std::size_t i, double sigma,
                                    const StationDirections& d, std::size_t k, double length, bool is_vertical,
                                    VerticalRule rule) {
  const bool vertical_formulas = w.vertical_north != nullptr && is_vertical;
  double inclination = value_at(w.inclination, i), azimuth = value_at(w.azimuth, i), tilt = value_at(w.tilt, i),
         lateral = value_at(w.lateral, i);
  if (vertical_formulas) {
    inclination = w.vertical_north[i] * d.cos_a[k] + w.vertical_east[i] * d.sin_a[k];
    lateral = tilt = w.vertical_east[i] * d.cos_a[k] - w.vertical_north[i] * d.sin_a[k];
  }
  DrawEffect e;
  e.depth = sigma * value_at(w.depth, i);
  const bool is_finite = std::abs(e.depth) <= 1e300 && std::abs(sigma * inclination) <= kLargestAngle &&
                         std::abs(sigma * lateral) <= kLargestAngle;
  if (!is_finite) {
    e.depth = kNaN;
    return e;
  }
  if (term.function->kind == error_model::Kind::course) {
    const Eigen::Vector3d high_side =
        vertical_formulas ? Eigen::Vector3d(d.cos_a[k], d.sin_a[k], 0)
                          : Eigen::Vector3d(d.cos_i[k] * d.cos_a[k], d.cos_i[k] * d.sin_a[k], -d.sin_i[k]);
    e.course = sigma * length * (inclination * high_side + lateral * Eigen::Vector3d(-d.sin_a[k], d.cos_a[k], 0));
  } else {
    if (rule == VerticalRule::azimuth && !is_vertical) {
      azimuth = lateral / d.sin_i[k];
      tilt = 0;
    }
    e.inclination = sigma * inclination;
    e.azimuth = sigma * azimuth;
    e.tilt = sigma * tilt;
  }
  const bool acts = e.depth != 0 || e.inclination != 0 || e.azimuth != 0 || e.tilt != 0 || !e.course.isZero(0);
  return acts ? std::optional(e) : std::nullopt;
}

/// Draws of one station go behind the others, in the order of the stations.
void sort_draws(WellErrors& w) {
  for (ErrorSource& s : w.sources) s.draws.clear();
  const auto is_of_station = [](const ErrorDraw& d, const ErrorSource& s) {
    return d.first == d.last && s.mode == error_model::PropagationMode::random;
  };
  std::vector<std::uint32_t> order, place(w.draws.size());
  for (const bool of_station : {false, true}) {
    if (of_station) w.station_draws = order.size();
    for (std::size_t i = 0; i < w.draws.size(); ++i)
      if (is_of_station(w.draws[i], w.sources[w.draws[i].source]) == of_station)
        order.push_back(static_cast<std::uint32_t>(i));
  }
  std::stable_sort(order.begin() + static_cast<std::ptrdiff_t>(w.station_draws), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return w.draws[a].first < w.draws[b].first; });
  std::vector<ErrorDraw> sorted;
  for (std::size_t i = 0; i < order.size(); ++i) {
    place[order[i]] = static_cast<std::uint32_t>(i);
    sorted.push_back(w.draws[order[i]]);
    w.sources[sorted.back().source].draws.push_back(static_cast<std::uint32_t>(i));
  }
  w.draws = std::move(sorted);
  for (auto& effects : w.at) {
    for (DrawEffect& e : effects) e.draw = place[e.draw];
    std::stable_sort(effects.begin(), effects.end(),
                     [](const DrawEffect& a, const DrawEffect& b) { return a.draw < b.draw; });
  }
  for (ErrorSource& s : w.sources)
    std::stable_sort(s.draws.begin(), s.draws.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return w.draws[a].first < w.draws[b].first; });
}

}  // namespace

std::optional<random::ReferenceElement> reference_element(const std::string& code, const std::string& function) {
  // Camera based tools, gyro orientation and magnetic interference: azimuths that are wrong for other reasons.
  for (const char* own : {"AZMR", "AZMS", "AZRF", "AMIC"})
    if (code == own) return std::nullopt;
  if (function == "AZ" || function == "DBH") return random::ReferenceElement::declination;
  if (function == "MDI") return random::ReferenceElement::dip;
  if (function == "MFI") return random::ReferenceElement::total;
  return std::nullopt;
}

WellErrors well_errors(const survey::Survey& survey, const std::vector<double>& tvd, const std::vector<ToolRun>& runs,
                       const survey::ReferenceField& field, double latitude, double multiplier, VerticalRule rule) {
  const std::size_t n = survey.stations.size();
  const StationDirections directions(survey, field.declination);
  WellErrors out;
  out.survey = survey;
  out.first_leg_doubled = runs.front().model->first_leg_doubled;
  out.at.resize(n);
  DrawBook book(out);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const error_model::Model& model = *runs[r].model;
    const auto begin = static_cast<std::size_t>(runs[r].first);
    const std::size_t end = r + 1 < runs.size() ? static_cast<std::size_t>(runs[r + 1].first) : n;
    const error_model::ModelGraph graph = error_model::model_graph(model.terms);
    RunWeights weights(model, graph, survey, tvd, directions, field, latitude, true);
    const std::vector<GyroStretch> stretches =
        model.gyro ? gyro_stretches(survey, begin, end, *model.gyro) : std::vector<GyroStretch>();
    weights.begin_run(stretches);
    std::vector<std::size_t> source_of_term;
    for (const error_model::Term& term : model.terms) source_of_term.push_back(book.source_of(term));
    for (std::size_t first = begin; first < end; first += kStationBlock) {
      const std::size_t count = std::min(kStationBlock, end - first);
      weights.evaluate(first, count);
      const auto begins_group = group_begins(stretches, first, count);
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t k = first + i;
        const double length = survey.stations[k].md - survey.stations[k - 1].md;
        const bool is_vertical = survey.stations[k].inclination < error_model::kVerticalLimit;
        for (std::size_t t = 0; t < model.terms.size(); ++t) {
          const error_model::Term& term = model.terms[t];
          const Grouping grouping = grouping_of(term, model.gyro.has_value());
          if (grouping == Grouping::station || (grouping == Grouping::mixed && begins_group[i]))
            book.end(source_of_term[t]);
          const double sigma = multiplier * term.sigma;
          if (sigma == 0) continue;
          if (auto e = effect_at(term, weights.of_term(t), i, sigma, directions, k, length, is_vertical, rule)) {
            e->draw = book.draw(source_of_term[t], r, k);
            out.at[k].push_back(*e);
          }
        }
      }
    }
    for (std::size_t t = 0; t < model.terms.size(); ++t) {
      const bool joins_runs = error_model::joins_legs(model.terms[t].mode);
      if (!joins_runs || model.terms[t].function->per_section) book.end(source_of_term[t]);
    }
  }
  sort_draws(out);
  return out;
}

WellErrors only_sources(const WellErrors& errors, const std::vector<bool>& keep) {
  WellErrors out = errors;
  for (auto& effects : out.at)
    effects.erase(std::remove_if(effects.begin(), effects.end(),
                                 [&](const DrawEffect& e) { return !keep[errors.draws[e.draw].source]; }),
                  effects.end());
  return out;
}

WellErrors mixed_draws(const WellErrors& errors, const std::vector<std::uint32_t>& draws,
                       const Eigen::MatrixXd& factor) {
  WellErrors out = errors;
  std::map<std::uint32_t, std::size_t> row;
  for (std::size_t i = 0; i < draws.size(); ++i) row.emplace(draws[i], i);
  for (std::size_t k = 0; k < out.at.size(); ++k) {
    std::map<std::uint32_t, DrawEffect> mixed;  // by the independent draw
    std::vector<DrawEffect> kept;
    for (const DrawEffect& e : errors.at[k]) {
      const auto found = row.find(e.draw);
      if (found == row.end()) {
        kept.push_back(e);
        continue;
      }
      const auto i = static_cast<Eigen::Index>(found->second);
      for (Eigen::Index j = 0; j <= i; ++j) {
        const double f = factor(i, j);
        if (f == 0) continue;
        const std::uint32_t draw = draws[static_cast<std::size_t>(j)];
        DrawEffect& sum = mixed[draw];
        sum.draw = draw;
        sum.depth += f * e.depth;
        sum.inclination += f * e.inclination;
        sum.azimuth += f * e.azimuth;
        sum.tilt += f * e.tilt;
        sum.course += f * e.course;
        ErrorDraw& d = out.draws[draw];
        const ErrorDraw& own = errors.draws[e.draw];
        d.first = std::min(d.first, own.first);
        d.last = std::max(d.last, own.last);
        d.first_run = std::min(d.first_run, own.first_run);
        d.last_run = std::max(d.last_run, own.last_run);
      }
    }
    for (const auto& [draw, effect] : mixed) kept.push_back(effect);
    out.at[k] = std::move(kept);
  }
  sort_draws(out);
  return out;
}

LegGeometry leg_geometry(const WellErrors& errors, std::size_t station) {
  const survey::Station &from = errors.survey.stations[station - 1], &to = errors.survey.stations[station];
  const auto attitude = [](const survey::Station& s) {
    return StationAttitude{std::sin(s.inclination), std::cos(s.inclination), std::sin(s.azimuth), std::cos(s.azimuth)};
  };
  const double length = to.md - from.md;
  return {attitude(from), attitude(to), length, station == 1 && errors.first_leg_doubled ? 0.5 * length : 0};
}

// ------------------------------------------------------------------------------------------------ first order

WellPoint point_at(const survey::Survey& survey, double md) {
  const auto& s = survey.stations;
  assert(survey::is_deeper(md, s.front().md) && !survey::is_deeper(md, s.back().md));
  if (const auto k = survey::station_at(survey, md)) return {*k, 1};
  std::size_t k = 1;
  while (s[k].md < md) ++k;
  return {k, (md - s[k - 1].md) / (s[k].md - s[k - 1].md)};
}

namespace {

Eigen::Vector3d direction(const survey::Station& s) {
  return survey::to_eigen(survey::tangent_N({s.inclination, s.azimuth, 0}));
}

LegDerivatives balanced_derivatives(const WellErrors& errors, std::size_t k, double share) {
  const auto& stations = errors.survey.stations;
  LegDerivatives d;
  const double half = 0.5 * share * (stations[k].md - stations[k - 1].md);
  const bool doubled = k == 1 && errors.first_leg_doubled;
  const Eigen::Vector3d mean = 0.5 * share * (direction(stations[k - 1]) + direction(stations[k]));
  for (const bool at_end : {false, true}) {
    const survey::Station& s = stations[at_end ? k : k - 1];
    const double si = std::sin(s.inclination), ci = std::cos(s.inclination), sa = std::sin(s.azimuth),
                 ca = std::cos(s.azimuth), reach = at_end && doubled ? 2 * half : half;
    auto& m = at_end ? d.to : d.from;
    m.col(0) = at_end ? mean : Eigen::Vector3d(-mean);
    m.col(1) = reach * Eigen::Vector3d(ci * ca, ci * sa, -si);
    m.col(3) = reach * Eigen::Vector3d(-sa, ca, 0);
    m.col(2) = si * m.col(3);
  }
  return d;
}

}  // namespace

LegDerivatives leg_derivatives(const WellErrors& errors, std::size_t station, double share, FirstOrder which) {
  if (which == FirstOrder::iscwsa) return balanced_derivatives(errors, station, share);
  using D = simd::Dual<double, 8>;
  std::array<D, 8> x;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = D::variable(0, i);
  const survey::Vec3<D> r =
      drawn_leg_point<D>(leg_geometry(errors, station), {x[0], x[1], x[2], x[3]}, {x[4], x[5], x[6], x[7]}, share);
  LegDerivatives d;
  for (int i = 0; i < 4; ++i) {
    const auto a = static_cast<std::size_t>(i);
    d.from.col(i) << r.x.d[a], r.y.d[a], r.z.d[a];
    d.to.col(i) << r.x.d[a + 4], r.y.d[a + 4], r.z.d[a + 4];
  }
  return d;
}

namespace {

/// What every draw adds to the position, in metres, on the part `share` of the leg that ends at station k.
template <class Add>
void add_leg_effects(const WellErrors& errors, std::size_t k, double share, FirstOrder which, const Add& add) {
  const LegDerivatives d = leg_derivatives(errors, k, share, which);
  const auto add_all = [&](std::size_t station, const Eigen::Matrix<double, 3, 4>& m, double course) {
    for (const DrawEffect& e : errors.at[station])
      add(e.draw, m * Eigen::Vector4d(e.depth, e.inclination, e.azimuth, e.tilt) + course * e.course);
  };
  add_all(k - 1, d.from, 0);
  add_all(k, d.to, share);
}

}  // namespace

Eigen::Matrix3Xd draw_effects(const WellErrors& errors, const WellPoint& point, FirstOrder which) {
  Eigen::Matrix3Xd out = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(errors.draws.size()));
  for (std::size_t k = 1; k <= point.station; ++k)
    add_leg_effects(errors, k, k == point.station ? point.share : 1, which,
                    [&](std::uint32_t draw, const Eigen::Vector3d& e) { out.col(draw) += e; });
  return out;
}

Eigen::MatrixXd source_sds(const WellErrors& errors, std::size_t last, FirstOrder which) {
  Eigen::MatrixXd sd =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(errors.sources.size()), static_cast<Eigen::Index>(last + 1));
  Eigen::Matrix3Xd effects = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(errors.draws.size()));
  Eigen::VectorXd trace = Eigen::VectorXd::Zero(sd.rows());
  for (std::size_t k = 1; k <= last; ++k) {
    add_leg_effects(errors, k, 1, which, [&](std::uint32_t draw, const Eigen::Vector3d& e) {
      auto sum = effects.col(draw);
      double& of_source = trace[errors.draws[draw].source];
      of_source -= sum.squaredNorm();
      sum += e;
      of_source += sum.squaredNorm();
    });
    sd.col(static_cast<Eigen::Index>(k)) = trace.cwiseMax(0).cwiseSqrt();  // rounding may be below zero
  }
  return sd;
}

Eigen::Matrix3d covariance_of(const Eigen::Matrix3Xd& effects) { return effects * effects.transpose(); }

Eigen::Matrix3d covariance_of(const Eigen::Matrix3Xd& effects, const ErrorSource& source) {
  Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
  for (const std::uint32_t draw : source.draws) c += effects.col(draw) * effects.col(draw).transpose();
  return c;
}

}  // namespace surveymc::propagate
