#include "propagate/iscwsa_covariance.h"

#include <algorithm>
#include <cmath>

#include "survey/minimum_curvature.h"

namespace surveymc::propagate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What a unit of depth and of angle at a station does to its own position (star) and to all beyond it (full).
struct Displacements {
  Vector3d star_depth, full_depth;
  double star_angle, full_angle;  ///< metres per rad along the two directions below
  Vector3d high_side, right;      ///< dt/dI, and dt/dA over sinI
};

Vector3d tangent(const survey::Station& s) {
  return survey::to_eigen(survey::tangent_N({s.inclination, s.azimuth, 0}));
}

Displacements displacements(const survey::Survey& survey, std::size_t k, const StationGeometry& s, bool doubled) {
  const bool is_last = k + 1 == survey.stations.size();  // then nothing asks for the full ones
  const survey::Station &before = survey.stations[k - 1], &at = survey.stations[k],
                        &after = survey.stations[is_last ? k : k + 1];
  Displacements d;
  d.star_depth = 0.5 * (tangent(before) + tangent(at));
  d.full_depth = d.star_depth - 0.5 * (tangent(at) + tangent(after));
  d.star_angle = (doubled ? 1 : 0.5) * s.dmd;
  d.full_angle = d.star_angle + 0.5 * (after.md - at.md);
  d.high_side = Vector3d(s.cos_i * s.cos_a, s.cos_i * s.sin_a, -s.sin_i);
  d.right = Vector3d(-s.sin_a, s.cos_a, 0);
  return d;
}

/// An error source of the well, with what has summed up so far and its effects at the present station.
struct Source {
  std::string code;
  PropagationMode mode;
  std::size_t row;  ///< of the code among PositionCovariances::sources
  ErrorSum sum;
  Vector3d star, full;

  void set_effect(const ErrorTerm& term, const StationGeometry& s, const Displacements& d) {
    const Weights w = term.function->weights(s);
    const Vector3d across = term.sigma * (w.inclination * d.high_side + w.lateral * d.right);
    if (term.function->is_course) {
      star = full = across;
      return;
    }
    const double depth = term.sigma * w.depth;
    star = depth * d.star_depth + d.star_angle * across;
    full = depth * d.full_depth + d.full_angle * across;
  }
  /// The tool of this leg does not have it: what there is remains, and stays in the covariance.
  void set_no_effect() {
    star.setZero();
    full.setZero();
  }
};

/// All sources of a well, and which of them each term of each leg is.
struct Sources {
  std::vector<std::string> codes;
  std::vector<Source> all;
  std::vector<std::vector<std::size_t>> of_leg;

  explicit Sources(const std::vector<ToolRun>& legs) {
    for (const ToolRun& leg : legs) {
      of_leg.emplace_back();
      for (const ErrorTerm& term : leg.model.terms) of_leg.back().push_back(index_of(term));
    }
  }

 private:
  std::size_t index_of(const ErrorTerm& term) {
    const auto same = std::find_if(all.begin(), all.end(),
                                   [&](const Source& s) { return s.code == term.code && s.mode == term.mode; });
    if (same != all.end()) return static_cast<std::size_t>(same - all.begin());
    const auto code = std::find(codes.begin(), codes.end(), term.code);
    const auto row = static_cast<std::size_t>(code - codes.begin());
    if (code == codes.end()) codes.push_back(term.code);
    all.push_back({term.code, term.mode, row, ErrorSum(term.mode), Vector3d::Zero(), Vector3d::Zero()});
    return all.size() - 1;
  }
};

}  // namespace

StationGeometry station_geometry(const survey::Survey& survey, const std::vector<double>& tvd,
                                 const survey::ReferenceField& field, std::size_t k) {
  const survey::Station &at = survey.stations[k], &before = survey.stations[k - 1];
  const double magnetic = at.azimuth - field.declination;
  StationGeometry s{};
  s.sin_i = std::sin(at.inclination);
  s.cos_i = std::cos(at.inclination);
  s.sin_a = std::sin(at.azimuth);
  s.cos_a = std::cos(at.azimuth);
  s.sin_am = std::sin(magnetic);
  s.cos_am = std::cos(magnetic);
  s.gravity = field.gravity;
  s.tan_dip = std::tan(field.dip);
  s.horizontal_field = field.total * std::cos(field.dip);
  s.md = at.md;
  s.tvd = tvd[k];
  s.dmd = at.md - before.md;
  s.inclination_change = std::abs(at.inclination - before.inclination);
  s.azimuth_turn = before.inclination < kVerticalLimit ? 0 : std::abs(s.sin_i * std::sin(at.azimuth - before.azimuth));
  return s;
}

PositionCovariances position_covariances(const survey::Survey& survey, const std::vector<double>& tvd,
                                         const std::vector<ToolRun>& legs, const survey::ReferenceField& field,
                                         bool with_sources) {
  const std::size_t n = survey.stations.size();
  Sources sources(legs);
  PositionCovariances out;
  out.sources = sources.codes;
  out.total.assign(n, Matrix3d::Zero());
  if (with_sources) out.by_source.assign(n * out.sources.size(), Matrix3d::Zero());

  std::size_t leg = 0;
  for (std::size_t k = 1; k < n; ++k) {
    while (leg + 1 < legs.size() && k >= static_cast<std::size_t>(legs[leg + 1].first)) {
      for (Source& s : sources.all) {
        s.sum.end_leg();
        s.set_no_effect();
      }
      ++leg;
    }
    const ErrorModel& model = legs[leg].model;
    const StationGeometry geometry = station_geometry(survey, tvd, field, k);
    const Displacements d = displacements(survey, k, geometry, k == 1 && model.first_leg_doubled);
    for (std::size_t i = 0; i < model.terms.size(); ++i)
      sources.all[sources.of_leg[leg][i]].set_effect(model.terms[i], geometry, d);
    for (Source& s : sources.all) {
      const Matrix3d c = s.sum.covariance(s.star);
      out.total[k] += c;
      if (with_sources) out.by_source[k * out.sources.size() + s.row] += c;
      s.sum.add(s.full);
    }
  }
  return out;
}

}  // namespace surveymc::propagate
