#pragma once
/// Covariance of every position of a surveyed well from the error models of its tools (ISCWSA).
#include <string>
#include <vector>

#include <Eigen/Core>

#include "propagate/error_model.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::propagate {

/// A part of a survey that was measured with one tool: the stations `first` (index, at least 1: the tie-on belongs to
/// no leg) and after, up to the next leg.
struct ToolRun {
  int first = 1;
  ErrorModel model;
};

struct PositionCovariances {
  std::vector<Eigen::Matrix3d> total;  ///< one per station: N, E, V (true north), m2; zero at the tie-on
  std::vector<std::string> sources;    ///< codes of all models, in order of their first appearance
  /// Of source i at station k: by_source[k * sources.size() + i]. Empty unless asked for.
  std::vector<Eigen::Matrix3d> by_source;
};

/// Balanced tangential effects of station k's measurement errors (ISCWSA; thesis eqs 36-38), with t the tangents, h the
/// derivatives of t_k by inclination and a that by azimuth over sinI:
///   on position k       dr_k     depth (t_{k-1} + t_k)/2,   angles D_k/2 (h w_I + a sinI w_A),   D_k = md_k - md_{k-1}
///   on all beyond       + dr_k+1 depth -(t_k + t_{k+1})/2,  angles D_k+1/2 (same)
/// The tie-on has no error. Sources of one code and mode W or G are one error throughout the well; S and R follow
/// ErrorSum. `tvd`: true vertical depth of every station in metres, of which depth-stretch sources make use.
/// Legs in order, the first with first = 1. Time is linear in stations times terms.
PositionCovariances position_covariances(const survey::Survey& survey, const std::vector<double>& tvd,
                                         const std::vector<ToolRun>& legs, const survey::ReferenceField& field,
                                         bool with_sources);

/// Geometry of station `k` >= 1, as the weighting functions take it.
StationGeometry station_geometry(const survey::Survey& survey, const std::vector<double>& tvd,
                                 const survey::ReferenceField& field, std::size_t k);

}  // namespace surveymc::propagate
