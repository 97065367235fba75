#pragma once
/// All errors of a surveyed well as standard normal draws, with the effect of each draw at each station: the models of
/// the well's tools (R, S, W, G) in a form for nonlinear Monte Carlo and for its linearisation.
///
/// The draws of a station add up to four numbers, and the drawn well follows from these of all stations:
///   dD    depth, m
///   dI    inclination, rad
///   dA    the part of the azimuth error that stays finite in a vertical hole, rad
///   tau   tilt to the right, rad: the part that does not, sinI w_A = sinI a + tau (RunWeights parts the two)
/// The tangent is t = cos(tau) d + sin(tau) (-sinA', cosA', 0), d the direction of I' = I + dI and A' = A + dA, I' of
/// either sign; the depth is D + dD. Legs are of minimum curvature, of the length that the drawn depths have, which
/// may be negative. Where the first leg is doubled, (D_1 - D_0) / 2 (t_1 drawn - t_1 true) is added to it. Course
/// functions displace the end of a leg by the draw times the one-sigma displacement at the true attitude. The tie-on
/// has no error. A point between stations lies on the drawn arc at its share of the drawn leg, displaced by that share
/// of the rest. Weights are those of the true survey.
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "error_model/model.h"
#include "propagate/drawn_leg.h"
#include "propagate/tool_covariance.h"
#include "random/reference_laws.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::propagate {

/// Treatment of a lateral error where the hole is nearly vertical.
enum class VerticalRule {
  tilt,    ///< as above
  azimuth  ///< all of it is an azimuth error w / sinI, tau = 0, from kVerticalLimit on: wrong, turns the hole by
           ///< radians
};

/// What a term is an error of, by its weighting function: AZ and DBH declination, MDI dip, MFI total field; none: of
/// something else. Of function AZ are errors of the tool and of its alignment, too: the codes AZMR, AZMS, AZRF and AMIC
/// of OWSG are none of the reference.
std::optional<random::ReferenceElement> reference_element(const std::string& code, const std::string& function);

/// Errors of one code and mode. R: one draw a station; S: one a leg; W and G: one; a gyro's by its sections.
struct ErrorSource {
  std::string code;
  error_model::PropagationMode mode = error_model::PropagationMode::random;
  std::vector<std::uint32_t> draws = {};                 ///< in the order of their stations
  std::optional<random::ReferenceElement> element = {};  ///< of the reference field; none: another error
};

struct ErrorDraw {
  std::uint32_t source = 0;
  std::size_t first_run = 0, last_run = 0;  ///< the legs (index into the runs) in which it acts
  std::size_t first = 0, last = 0;          ///< the stations at which it acts
};

/// One standard deviation of a draw at one station.
struct DrawEffect {
  std::uint32_t draw = 0;
  double depth = 0, inclination = 0, azimuth = 0, tilt = 0;  ///< dD (m), dI, dA, tau (rad)
  Eigen::Vector3d course = Eigen::Vector3d::Zero();          ///< NEV, m: of the end of the leg before the station
};

struct WellErrors {
  survey::Survey survey;
  bool first_leg_doubled = false;
  std::vector<ErrorSource> sources;  ///< in order of their first appearance in the models
  /// First those that act at several stations (all of S, W and G, and the sections of a gyro); then those of one
  /// station, `station_draws` and after, in the order of the stations.
  std::vector<ErrorDraw> draws;
  std::size_t station_draws = 0;
  /// Of every station, in the order of the draws. Terms without effect are not there. NaN where a term has no finite
  /// effect (NonFiniteTerm).
  std::vector<std::vector<DrawEffect>> at;
};

/// The errors of a well. Arguments as of tool_covariances(). `multiplier`: of all sizes.
WellErrors well_errors(const survey::Survey& survey, const std::vector<double>& tvd, const std::vector<ToolRun>& runs,
                       const survey::ReferenceField& field, double latitude, double multiplier = 1,
                       VerticalRule rule = VerticalRule::tilt);

/// The same with the draws of some sources alone: `keep` has one flag a source. Draws keep their numbers.
WellErrors only_sources(const WellErrors& errors, const std::vector<bool>& keep);

/// The same errors with the draws `draws` made of as many independent ones, x = `factor` z, factor lower triangular:
/// they then act at several stations, and draws are numbered anew. Draws of the same source keep it.
WellErrors mixed_draws(const WellErrors& errors, const std::vector<std::uint32_t>& draws,
                       const Eigen::MatrixXd& factor);

/// The leg that ends at `station`, of the true well.
LegGeometry leg_geometry(const WellErrors& errors, std::size_t station);

// ------------------------------------------------------------------------------------------------ first order

/// A point of the well: at `share` (0, 1] of the leg that ends at `station` >= 1.
struct WellPoint {
  std::size_t station = 0;
  double share = 1;
};
/// The point at a measured depth (m); depths beyond the ends of the survey have none (assert).
WellPoint point_at(const survey::Survey& survey, double md);

/// How the end of a leg, or a point of it, follows the four numbers (dD, dI, dA, tau; columns) of the station before it
/// and of that at its end: N, E, V in metres, relative to the beginning of the leg.
struct LegDerivatives {
  Eigen::Matrix<double, 3, 4> from, to;
};
enum class FirstOrder {
  iscwsa,            ///< balanced tangential effects: the sums are those of tool_covariances()
  minimum_curvature  ///< exact derivatives of the drawn well, by dual numbers
};
LegDerivatives leg_derivatives(const WellErrors& errors, std::size_t station, double share, FirstOrder which);

/// First-order effect of every draw on a point: 3 x draws, N, E, V in metres, one sigma. C = M M'.
Eigen::Matrix3Xd draw_effects(const WellErrors& errors, const WellPoint& point, FirstOrder which);

/// Standard deviation of the position in all directions together (root of the trace, m) by every source, code and mode,
/// at the stations up to `last`: sources x stations. Time is linear in the effects.
Eigen::MatrixXd source_sds(const WellErrors& errors, std::size_t last, FirstOrder which);

/// Covariance of a point (m2) whole, or of one source.
Eigen::Matrix3d covariance_of(const Eigen::Matrix3Xd& effects);
Eigen::Matrix3d covariance_of(const Eigen::Matrix3Xd& effects, const ErrorSource& source);

}  // namespace surveymc::propagate
