#pragma once
/// What a fit is worth for stations that it has not seen, and which parameters a run justifies. Both are functions of
/// fits: for readings whose truth nobody knows.
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "multistation/robust.h"
#include "multistation/variance_components.h"

namespace surveymc::multistation {

using Stations = std::vector<StationReadings>;

/// A fit of some stations, by least squares or by a loss that finds weights.
struct FittedStations {
  Fit fit;                      ///< its claims are those for residuals of size s0 (claim_for_variance())
  std::vector<double> weights;  ///< one a station; empty: all 1
  double s0 = 1;                ///< residuals over their sizes: the root of the variance factor, or a robust scale
};
using Fitter = std::function<FittedStations(const Stations&)>;

/// Least squares; s0 by the redundancy that learnt parameters leave. NaN where they leave none.
FittedStations fit_by_least_squares(const Stations& stations, const FitOptions& options);

/// By a robust loss; s0 is the scale of the residuals, corrected for what the fit has taken of them.
FittedStations fit_robustly(const Stations& stations, const FitOptions& options, const RobustOptions& robust,
                            const random::Stream& stream);

/// Variance components of the three residuals of a station (model.h: gravity; horizontal or total field; vertical field
/// or angle) over the squares of options.sizes, by least squares. Errors of a reference that is not estimated count as
/// residuals. Throws InputError as fit(), and where a fit does not converge.
VarianceComponents residual_components(const Stations& stations, const FitOptions& options);

/// `options` with the sizes of these components.
FitOptions with_components(FitOptions options, const VarianceComponents& components);

/// How many parameters the stations say more of than priors do: the trace of what is learnt, of parameters of the set
/// and of an estimated reference. By the claimed sizes of the residuals, as the fit weighs them.
double learnt_parameters(const Fit& fit, const FitOptions& options);

/// Information criterion of a least-squares fit, least for the set that the run justifies:
///   m ln(cost / m) + p ln m
/// (G. Schwarz, Ann. Statist. 6, 1978) with m residuals and the size of their noise estimated; cost with the penalty of
/// the priors, and p = learnt_parameters(): a parameter that the run says nothing of costs nothing and gains nothing.
double information_criterion(const Fit& fit, const FitOptions& options, std::size_t stations);

/// What is the same at all stations of a run in a good field: lengths of gravity (m/s2) and field (nT), dip (rad).
struct FieldNumbers {
  double gravity = 0, total = 0, dip = 0;
};
FieldNumbers field_numbers(const StationReadings& station, const PerParameter<double>& tool);

/// A station that the fit has not seen.
struct HeldStation {
  /// r' S^-1 r of its residuals, chi-squared(3) if all is as claimed: S = s0^2 + J C J' and the errors of a reference
  /// that is not estimated, which have a size of their own; C = fit.joint.
  double distance = 0;
  FieldNumbers before, after;  ///< the correction
};
/// In the order of `held`. A fit that did not converge is not to be passed.
std::vector<HeldStation> judge_held_out(const FittedStations& fitted, const Stations& held, const FitOptions& options);

/// Earth from tool (rows: magnetic north, east, down) by the corrected readings.
Eigen::Matrix3d earth_from_tool(const StationReadings& station, const PerParameter<double>& tool);

/// Stations that point in one direction; weights as those of a fit, empty for 1.
struct Group {
  Stations stations;
  std::vector<double> weights = {};
};
/// The direction in the tool that varies least on the earth within each group: the axis that a user turned the
/// instrument about. Unit vector.
Eigen::Vector3d turning_axis(const std::vector<Group>& groups, const PerParameter<double>& tool);

/// Root mean square angle (rad) of a direction of the tool with its mean on the earth.
double scatter_of_axis(const Stations& group, const PerParameter<double>& tool, const Eigen::Vector3d& axis);

/// Each fold is held out once and judged by the fit of all other stations.
struct CrossValidation {
  std::vector<HeldStation> stations;  ///< of all folds, one after the other
  double nees = 0;                    ///< mean distance by the number of residuals of a station: 1 if all is as claimed
  double nees_median = 0;  ///< median distance over that of chi-squared(3): of most stations, whatever a few are
  double coverage = 0;     ///< share of stations within their 95 % ellipsoid
  FieldNumbers spread_before, spread_after;  ///< sd over the stations of a fold, root mean square of all folds
  /// Of folds that are groups of one direction: rms angle of the axis, which the other groups tell (rad); NaN where
  /// there are no two groups. By fold, and of all.
  std::vector<double> axis_scatter;
  double axis_rms = 0;
  /// The same of readings as they are: the instrument without calibration.
  double axis_rms_before = 0;
};
/// `folds`: indices of stations. `are_groups`: each fold has one direction. Throws InputError as fit(), and where a fit
/// does not converge.
CrossValidation cross_validate(const Stations& stations, const std::vector<std::vector<int>>& folds, bool are_groups,
                               const FitOptions& options, const Fitter& fitter);

}  // namespace surveymc::multistation
