#pragma once
/// Errors of the points of two wells, and the errors that both share.
///
/// The error of station K is eps_K = sum_{k<K} e_k + e*_K (propagate/tool_covariance.h), summed over independent draws;
/// s_i is the part of draw i, one standard deviation. With C each well's own covariance,
///   C_rel = C_ref + C_off - K - K',  K = sum over shared draws i of s_i,ref s_i,off'.
/// Between stations k and k + 1, at the share f of the leg, either
///   covariance  C and s linear in measured depth (diagnostics of the ISCWSA), or
///   effects     eps = (1 - f) eps_k + f eps_k+1, as a drawn path does:
///               C = (1 - f)^2 C_k + f^2 C_k+1 + f (1 - f) (X + X'),  X = E[eps_k eps_k+1'].
/// The parts s_i are linear in both.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "disturbance/station_disturbance.h"
#include "propagate/tool_covariance.h"

namespace surveymc::proximity {

enum class Interpolation { covariance, effects };

/// A draw that another well may share.
struct JoiningSource {
  std::string code;
  error_model::PropagationMode mode = error_model::PropagationMode::global;
  std::string function;
};

/// Covariances (m2; N, E, V) and shared parts (m) of all stations of a well.
struct PositionErrors {
  std::vector<Eigen::Matrix3d> covariance;  ///< C_k, one a station
  std::vector<Eigen::Matrix3d> step;        ///< X_k, one a leg; empty: C is linear in measured depth
  std::vector<JoiningSource> sources;
  std::vector<Eigen::Vector3d> summed;  ///< s_i of source i at station k: summed[k * sources.size() + i]

  /// At the share `f` of leg `leg`.
  Eigen::Matrix3d covariance_at(std::size_t leg, double f) const;
  Eigen::Vector3d summed_at(std::size_t source, std::size_t leg, double f) const;
};

/// The well with its sources of modes W and G that are one draw along all of it. `tvd`, `runs`, `latitude` as for
/// tool_covariances(). `out`, if not null, gets what it returned, without sources. `disturbance`: errors of the
/// reference that are correlated in time, those of the runs that disturbed_runs() gave; null: none.
PositionErrors position_errors(const survey::Survey& survey, const std::vector<double>& tvd,
                               const std::vector<propagate::ToolRun>& runs, const survey::ReferenceField& field,
                               double latitude, Interpolation interpolation, propagate::ToolCovariances* out = nullptr,
                               const disturbance::Disturbance* disturbance = nullptr);

/// C_k and X_k from the effects, draw by draw: the readable form. Stations before `first` have none.
void sum_effects(const propagate::StationEffects& effects, std::size_t first, PositionErrors& out);

/// What two wells share.
struct CommonErrors {
  std::vector<std::pair<std::size_t, std::size_t>> sources;  ///< of the reference, of the offset
  Eigen::Matrix3d constant = Eigen::Matrix3d::Zero();        ///< the part of K that all points have alike, m2
};

/// Two wells of one formulation.
struct PairErrors {
  std::string formulation;
  std::shared_ptr<const PositionErrors> reference, offset;
  CommonErrors common;
  bool is_independent = true;  ///< nothing is shared
};

/// C_rel of two points, each at a share of a leg, from the covariances there, `c_reference` and `c_offset`.
Eigen::Matrix3d relative_covariance(const PairErrors& pair, const Eigen::Matrix3d& c_reference,
                                    const Eigen::Matrix3d& c_offset, std::size_t reference_leg, double reference_share,
                                    std::size_t offset_leg, double offset_share);

/// Which sources of modes W and G two wells share.
enum class Sharing {
  none,
  geomagnetic,  ///< G with the weighting functions AZ and DBH: the reference field
  global,       ///< all G
  pad,          ///< G and W: wells of one place
  listed        ///< those of the list
};
/// True if a source of one well is shared with another well that has one of the same code and mode.
bool is_shared(Sharing sharing, const std::vector<std::string>& codes, const JoiningSource& source);
/// Pairs of sources that are shared: of one code and mode in both wells. Magnitudes and functions may differ.
std::vector<std::pair<std::size_t, std::size_t>> shared_sources(Sharing sharing, const std::vector<std::string>& codes,
                                                                const PositionErrors& reference,
                                                                const PositionErrors& offset);

// ---- a well and its sidetrack, which has the well's stations down to station `kickoff` of both, and its own beyond.
// Effects of all sources; the sidetrack's tool runs are those of the well down to the kick-off, and begin anew beyond.

/// Every draw of the shared stations moves both wells: R of the stations down to the kick-off, S of the runs they were
/// measured in, and all of W and G. Exact to first order at points from the kick-off on; "effects" between stations.
PairErrors shared_hole(const propagate::StationEffects& reference, const propagate::StationEffects& offset,
                       std::size_t kickoff);

/// Common practice: both covariances begin at the kick-off and are taken as independent. The kick-off station has e* =
/// 0, e_0 = D_1/2 (h w_I + a sinI w_A) + w_D (t_0 - t_1)/2, and no doubling; depths count from the surface all the
/// same. `tangent`: of the hole at the kick-off. "effects" between stations.
PairErrors zeroed_at_kickoff(const propagate::StationEffects& reference, const propagate::StationEffects& offset,
                             std::size_t kickoff, const Eigen::Vector3d& tangent, Interpolation interpolation);

}  // namespace surveymc::proximity
