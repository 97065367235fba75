#pragma once
/// Reliability of every reading of a well, each station at its own attitude: how large an error may pass the tests, and
/// its effect on the position of the last station.
///
/// Station k has three misclosures w_k = B_k e_k + D_k z. All stations share z: the errors of the references, and the
/// twelve systematic terms if they are estimated (D_k = [-1 | B_k F_k]). With M_k = B_k Q_k B_k' and the
/// information P^-1 = S_z^-1 + sum_l D_l' M_l^-1 D_l,
///   c' (Cov w)^-1 c = sum_k c_k' M_k^-1 c_k - s' P s,  s = sum_k D_k' M_k^-1 c_k
/// for an error that moves the misclosures by c: 3x3 and 3x3 (15x15) systems only, linear in the stations. For one
/// station this is the formula of a single station with reference covariance S_k = (S_ref^-1 + sum_{l != k} M_l^-1)^-1.
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "reliability/nonlinear_detectable.h"
#include "survey/survey.h"

namespace surveymc::reliability {

/// One observation of one station, with +1 minimal detectable error in it. Internal units.
struct StationEffect {
  double redundancy = 0, detectable = 0;
  double inclination = 0, toolface = 0, azimuth = 0;   ///< of that station
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the last station, N frame, m; infinite like `detectable`
};

/// The same error in one observation of all stations, that is, a systematic error that the model does not know.
struct CommonEffect {
  double detectable = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

struct WellReliability {
  std::vector<std::array<StationEffect, kObservations>> stations;  ///< references: in `references`
  std::array<CommonEffect, kReadings> common;
  std::array<StationEffect, 3> references;  ///< mse_shared only: redundancy, detectable, position
};

/// `survey`: azimuths true; the field's declination makes them magnetic. In sse, sse_axial and mse_fixed every station
/// is on its own (its references too, in StationEffect of that station). Positions by minimum curvature; first order in
/// the error. In a vertical station the effects on toolface and azimuth are infinite. The effect on the position is
/// finite, because the position depends on the direction of the hole, which is defined there. In sse_axial a horizontal
/// station east or west has no azimuth to first order: its effects on azimuth are infinite, and those on the position
/// where the azimuth moves the last station.
WellReliability reliability_along_well(const AdjustmentModel& model, const survey::Survey& survey, double lambda0);

/// The smallest error in one reading that a test finds, without linearisation, and its effects.
struct FoundError {
  double size = 0;                        ///< with its sign, internal units; infinite: none is found up to 1e4 sd
  double inclination, toolface, azimuth;  ///< of that station, in (-pi, pi]; NaN: the angle has no value there
  Eigen::Vector3d position;               ///< of the last station, N frame, m; infinite like `size`
};

/// Errors of single readings (and, where stations do not share them, references) of a well. The station in error is
/// adjusted without linearisation, and its attitude goes through minimum curvature. In mse_shared the other stations
/// are free of error. They enter by their linear information on the references (and systematic terms). The error moves
/// the references by some tenths of their sd only, so that this information, and the attitudes of the other stations,
/// are good to first order.
class WellErrors {
 public:
  /// `survey` as of reliability_along_well.
  WellErrors(const AdjustmentModel& model, const survey::Survey& survey, double lambda0, DetectedBy test);
  ~WellErrors();

  /// Throws std::invalid_argument for an observation that the model does not have, and for a reference in mse_shared.
  FoundError of(std::size_t station, std::size_t observation, int sign) const;

 private:
  struct Shared;
  AdjustmentModel model_;
  survey::Survey survey_;
  double lambda0_;
  DetectedBy test_;
  std::unique_ptr<Shared> shared_;  ///< mse_shared only
};

}  // namespace surveymc::reliability
