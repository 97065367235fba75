#pragma once
/// Horizontal position covariance of a vertical well from constant cross-axis accelerometer biases ABX and ABY, in
/// every formulation that C. Hanak compares ("Correct Vertical Well Weighting Functions for Cross-Axis Accelerometer
/// Bias Terms", Superior QC, 28 January 2016), balanced tangential method.
///
/// Each station k tilts the computed hole by bias / G and so moves the last position by w_k times that, w_k half of the
/// intervals that meet at the station (metres). All covariances are 2x2 (N, E) in m2, `tilt_sd` = sigma / G in rad.
/// Errata of the memo that matter here: eqs 23, 26, 29, 32 need dD^2 / 8; 24-26 and 30-32 are of the y bias; the limit
/// of eq 22 for a negative bias reverses the whole vector; eqs 36, 38, 40 lack transposes; eqs 45-46 lack dD/2.
#include <vector>

#include <Eigen/Core>

#include "survey/frames.h"

namespace surveymc::propagate {

/// w_k of `intervals` equal intervals: spacing / 2 at both ends, spacing between.
std::vector<double> vertical_station_weights(int intervals, double spacing);

/// Direction of the horizontal field in the tool, from y: Bx = |..| sin alpha_m, By = |..| cos alpha_m (eq 17).
double magnetic_toolface(const survey::Vec3<double>& field_T);

/// Eqs 19 and 20 for a given sequence of magnetic toolfaces:
///   dr/dABX = w (-sin alpha_m, cos alpha_m)/G,  dr/dABY = w (-cos alpha_m, -sin alpha_m)/G.
Eigen::Matrix2d toolface_dependent_covariance(const std::vector<double>& weights,
                                              const std::vector<double>& magnetic_toolfaces, double tilt_sd);

/// Correlation of a fictive error source at two toolfaces (Torkildsen and Bang 2000): 1 if they are the same (within
/// 1e-9 rad, on the circle), otherwise 0.
double fictive_correlation(double toolface_j, double toolface_m);

/// Fictive terms 4 and 5 of both biases: eq 38 with eq 37, plus eq 40 with eq 39, rho from `toolfaces`. These should
/// be the magnetic toolfaces: in a vertical hole the accelerometers read their bias alone, so their toolface is the
/// same at every station however the pipe was turned. Time is quadratic in the stations.
Eigen::Matrix2d fictive_terms_covariance(const std::vector<double>& weights,
                                         const std::vector<double>& magnetic_toolfaces,
                                         const std::vector<double>& toolfaces, double tilt_sd);

/// Effects of two error sources of unit variance at each station: column i is source i, (N, E) of the last position in
/// m.
using TwoSources = std::vector<Eigen::Matrix2d>;
/// ABXY-TI1 and TI2 of eqs 41 and 42: w (1, 0)/G and w (0, 1)/G.
TwoSources toolface_independent_sources(const std::vector<double>& weights, double tilt_sd);
/// SPE 67616's singular ABX and ABY with A = alpha = 0, as a program has it at zero inclination: eqs 19 and 20 at 0.
TwoSources spe_67616_sources(const std::vector<double>& weights, double tilt_sd);
/// Copegrove CDR-SM-03 rev 4: TI1 as eq 44; TI2 as eq 46, which lacks the factor dD/2 of each interval, or with it.
TwoSources copegrove_sources(const std::vector<double>& weights, double tilt_sd, bool with_half_leg);

/// The sources along the hole: the same at all stations (S), or independent from station to station (R).
Eigen::Matrix2d systematic_covariance(const TwoSources& sources);
Eigen::Matrix2d random_covariance(const TwoSources& sources);
/// S among stations of equal toolface (fictive_correlation), R between others: a slide as S, rotation as R.
Eigen::Matrix2d as_drilled_covariance(const TwoSources& sources, const std::vector<double>& toolfaces);

}  // namespace surveymc::propagate
