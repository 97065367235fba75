#pragma once
/// What is left of the errors of a magnetic survey after its readings were corrected, to first order and without
/// trials: the prediction of the study `corrected_codes`.
///
/// Draws (propagate/code_draws.h): biases and scales of six axes and the interference of the drill string once a run;
/// the true total field, dip and declination less their reference once a run and anew at every station. An input d
/// moves the tangent t_k of station k directly, by the station's own reading, and through the estimate x:
///   dt_k/dd = D_k(d) + Y_k dx/dd,   Y_k = dt_k/dx
/// A change of the field's total and dip turns no hole directly, an error of declination no estimate. The position is
///   dr = sum_k L_k dt_k,   L_k = (D_k + D_k+1) / 2, D_k = md_k - md_k-1,
/// the balanced tangential sum of ISCWSA: the first leg counts twice if the code says so, the last station has D_k / 2.
/// An estimate of other parameters than six gains and biases has as x all parameters of the table, those that are not
/// estimated as 0; errors of the accelerometers then act through x alone.
/// Inputs of the run are added over the stations before they are squared. One of station j acts by L_j D_j directly and
/// by (sum_k L_k Y_k) dx/dd through the estimate, so that time is linear in stations times inputs. Of a robust loss its
/// variance through the estimate is v times as large (multistation/loss.h), what it has in common with the direct
/// effect the same.
#include <array>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "analysis/robust_limits.h"
#include "estimate/estimator.h"
#include "estimate/sensitivity.h"
#include "multistation/robust.h"
#include "propagate/code_draws.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::analysis {

/// The inputs. The first twelve are those of survey/sensor_terms.h.
enum CodeInput : std::size_t {
  kInterference = survey::kSensorTerms,
  kTotalField,
  kDip,
  kDeclination,
  kRunInputs,  ///< how many are drawn once a run
  kStationTotalField = kRunInputs,
  kStationDip,
  kStationDeclination,
  kMagnetometerNoise,
  kCodeInputs
};
inline constexpr std::array<const char*, kCodeInputs> kCodeInputNames{
    "accelerometer_bias_x",  "accelerometer_bias_y",  "accelerometer_bias_z",
    "accelerometer_scale_x", "accelerometer_scale_y", "accelerometer_scale_z",
    "magnetometer_bias_x",   "magnetometer_bias_y",   "magnetometer_bias_z",
    "magnetometer_scale_x",  "magnetometer_scale_y",  "magnetometer_scale_z",
    "interference",          "total_field",           "dip",
    "declination",           "station_total_field",   "station_dip",
    "station_declination",   "magnetometer_noise"};

/// How the readings are corrected.
struct Correction {
  enum class Kind {
    none,        ///< taken as they are
    run,         ///< by one estimate of the whole run: gains and biases of the magnetometers
    parameters,  ///< by one estimate of the whole run of any parameters of both triads (multistation/parameters.h)
    station,     ///< every station for itself: the bias of z that brings (Bh, Bv) nearest to the reference (axial)
  };
  Kind kind = Kind::none;
  estimate::EstimatorOptions estimator = {};  ///< of Kind::run
  // Of Kind::parameters:
  multistation::FitOptions parameters = {};
  multistation::RobustOptions robust = multistation::robust_options(multistation::Loss::least_squares);
  multistation::LossCost cost = {};  ///< of its loss
};

/// The options with the field about which errors of the reference are linear.
multistation::FitOptions in_field(multistation::FitOptions options, const survey::ReferenceField& field);

/// Names of the corrections of a survey that need no more than the sizes of its errors: none, axial, msa (six
/// parameters), msa3 (three biases), joint (msa_joint without priors of gains and biases), joint_priors.
const std::vector<std::string>& correction_names();
/// `sizes`: of the errors that a weighted estimator assumes: priors, covariance of (Bh, Bv). `noise`: nT, that it
/// assumes of a reading besides; above 0, because (Bh, Bv) would have no covariance where a code draws nothing at the
/// stations. Throws InputError on an unknown name.
Correction correction(const std::string& name, const propagate::CodeDraws& sizes, double noise = 1);
/// The sizes as an estimator takes them.
estimate::InputErrors assumed_errors(const propagate::CodeDraws& sizes, double noise);
/// The estimator of Kind::station, for one station.
estimate::EstimatorOptions axial_estimator();

/// A survey whose first station is the tie-on, which is not measured: entry k is of station k + 1.
struct MeasuredStations {
  survey::ReferenceField field;
  std::vector<survey::StationFields> fields;
  std::vector<Eigen::Matrix3d> by_field, by_down;  ///< of the tangent (true north), per nT and per unit; tool axes
  std::vector<Eigen::Vector3d> by_declination;     ///< of the tangent, per rad
  std::vector<Eigen::RowVector3d> right;           ///< across the hole, level
  std::vector<double> lever;                       ///< L_k, m
};
MeasuredStations measured_stations(const survey::Survey& survey, const survey::ReferenceField& field,
                                   bool first_leg_doubled);

/// Above this scaled condition (Sensitivity) a correction counts as undetermined.
inline constexpr double kUndetermined = 1e10;

/// Covariances by input; those of different inputs are independent.
struct CorrectedErrors {
  bool determined = true;                                     ///< false: no covariances
  double condition = 1;                                       ///< scaled; of Kind::station the largest of a station
  std::array<Eigen::Matrix3d, kCodeInputs> position;          ///< of the last station: N, E, V (true north), m2
  std::vector<std::array<double, kCodeInputs>> azimuth = {};  ///< of every measured station: (sinI dA)^2, rad2
  /// One sd of the reference's declination, dip and total field on the last position, m: of the run, of every station.
  std::array<Eigen::Vector3d, 3> run_reference = {};
  std::vector<std::array<Eigen::Vector3d, 3>> station_reference = {};
  RobustLimits limits = {};  ///< of a robust loss

  Eigen::Matrix3d covariance() const;
  double azimuth_variance(std::size_t station) const;
};

/// Correlation of the draws of two measured stations: E d_a(j) d_b(k), the inputs a and b being the true 0 total field,
/// 1 dip, 2 declination less their reference, in units of their sd.
using StationCorrelation = std::function<double(int a, std::size_t j, int b, std::size_t k)>;

/// `noise`: one sd of a magnetometer reading, nT. `correlation`: of what is drawn at the stations, which is else
/// independent; half of what two inputs have in common counts to each. Time is then quadratic in the stations. Not with
/// a robust loss, whose cost is that of independent stations.
CorrectedErrors corrected_errors(const MeasuredStations& stations, const propagate::CodeDraws& draws, double noise,
                                 const Correction& correction, const StationCorrelation& correlation = {});

/// Root of the largest generalised eigenvalue of (actual, claimed): the largest ratio of standard deviations in any
/// direction of the plane. `claimed` must be positive definite: else NaN.
double worst_ratio(const Eigen::Matrix2d& actual, const Eigen::Matrix2d& claimed);
/// A unit vector in whose direction it is.
Eigen::Vector2d worst_direction(const Eigen::Matrix2d& actual, const Eigen::Matrix2d& claimed);

}  // namespace surveymc::analysis
