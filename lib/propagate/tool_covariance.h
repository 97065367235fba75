#pragma once
/// Covariance of every position of a surveyed well from the error models of its tools (ISCWSA).
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "error_model/model.h"
#include "propagate/gyro_sections.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::propagate {

/// A part of a survey that was measured with one tool: the stations `first` (index, at least 1: the tie-on belongs to
/// no run) and after, up to the next run.
struct ToolRun {
  int first = 1;
  std::shared_ptr<const error_model::Model> model;
};

/// Stations whose covariance is also given by source.
enum class SourceDetail { none, last, all };

/// Stations at which a term has no finite effect, or moves an angle by more than kLargestAngle.
struct NonFiniteTerm {
  std::size_t run = 0, term = 0;
  std::size_t stations = 0, first = 0, last = 0;  ///< how many, and which
  std::string formula;                            ///< "azimuth = ..."
};

/// rad: a standard deviation of an angle beyond it is no linear error but a pole (1 / cosI at 90 deg).
inline constexpr double kLargestAngle = 1000;

/// Many covariances, element by element, as in a table: three quarters of the memory of matrices.
struct CovarianceColumns {
  std::array<std::vector<double>, 6> elements;  ///< nn, ee, vv, ne, nv, ev

  std::size_t size() const { return elements[0].size(); }
  bool empty() const { return elements[0].empty(); }
  Eigen::Matrix3d operator[](std::size_t i) const;
};

struct ToolCovariances {
  std::vector<Eigen::Matrix3d> total;  ///< one per station: N, E, V (true north), m2; zero at the tie-on
  std::vector<std::string> sources;    ///< codes of all models, in order of their first appearance
  /// Of source i at station k: by_source[k * sources.size() + i] for SourceDetail::all; of the last station alone,
  /// by_source[i], for SourceDetail::last; else empty.
  CovarianceColumns by_source;
  std::vector<NonFiniteTerm> non_finite;
  std::vector<std::vector<GyroStretch>> gyro;  ///< of each run; empty for a tool without modes
};

/// Effects of the sources at the stations, one standard deviation each, as tool_covariances() sums them: for what needs
/// the draws themselves (several wells, sidetracks). Element s * stations + k is that of source s at station k.
struct StationEffects {
  struct Source {
    std::string code;
    error_model::PropagationMode mode;
    std::string function;  ///< name of its first weighting function
  };
  static constexpr int kNone = -1;

  std::size_t stations = 0;
  std::vector<Source> sources;              ///< in order of their first appearance; code and mode are unique
  std::vector<Eigen::Vector3d> star, full;  ///< e*_k and e_k: N, E, V in metres; zero at the tie-on
  std::vector<double> depth;                ///< the error of the measured depth alone, m
  /// Stations with the same number share one draw, which has the number of the first of them; 1 for a source that is
  /// common to all legs. kNone: the tool of the station does not have the source.
  std::vector<int> draw;
};

/// Balanced tangential effects of station k's measurement errors (ISCWSA; thesis eqs 36-38), with t the tangents, h the
/// derivatives of t_k by inclination and a that by azimuth over sinI:
///   on position k       e*_k = depth (t_{k-1} + t_k)/2,     angles D_k/2 (h w_I + a sinI w_A),   D_k = md_k - md_{k-1}
///   on all beyond       e_k  = e*_k + depth -(t_k + t_{k+1})/2,  angles D_k+1/2 (same)
/// Below kVerticalLimit the vertical formulas of a function replace h w_I + a sinI w_A. A course function displaces the
/// end of the interval by D_k (h w_I + a sinI w_A): e* = e. The tie-on has no error. Sources of one code and mode W or
/// G are one error throughout the well; S and R follow ErrorSum.
///
/// A tool with a gyro (gyro_sections.h): its stationary functions act by themselves at stationary stations, and by the
/// value of the initialisation beyond; mode S is one error a leg, mode R is drawn anew at every stationary station and
/// is one error within a section. Its continuous functions act while initialised: mode S is one error a leg, mode R or
/// per_section one a section.
///
/// A term without a finite effect at a station makes the covariance NaN from that station on (non_finite says which).
///
/// `tvd`: true vertical depth of every station, m. `latitude`: rad, NaN where no formula needs it. Runs in order, the
/// first with first = 1. Time is linear in stations times terms; a function is evaluated once a station.
/// `effects`, if not null, gets the effects of all sources, or of those with modes W and G alone (`joining_alone`).
/// `at_station` is called now and then with the number of stations that are done; what it throws passes through.
ToolCovariances tool_covariances(const survey::Survey& survey, const std::vector<double>& tvd,
                                 const std::vector<ToolRun>& runs, const survey::ReferenceField& field, double latitude,
                                 SourceDetail detail, StationEffects* effects = nullptr, bool joining_alone = false,
                                 const std::function<void(std::size_t)>& at_station = {});

}  // namespace surveymc::propagate
