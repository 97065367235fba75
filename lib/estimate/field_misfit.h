#pragma once
/// How the field of a station misses the reference, and what moves it: the residuals of MSA, linearised.
#include <array>
#include <vector>

#include <Eigen/Core>

#include "survey/frames.h"

namespace surveymc::estimate {

/// Residuals (Bh - Bh_ref, Bv - Bv_ref) of one station in nT, and their derivatives. Model: msa_residual.h.
struct FieldMisfit {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 6> by_parameters;    ///< per unit of gain x, y, z, per nT of bias x, y, z
  Eigen::Matrix<double, 2, 3> by_magnetometer;  ///< per nT of a reading
  Eigen::Matrix<double, 2, 3> by_down;          ///< per unit of the down direction, perpendicular to it
  Eigen::Matrix2d by_reference;                 ///< per nT of total field, per rad of dip
};

/// `station`: corrected field and down direction; `gain` the gains it was corrected with; `total` (nT) and `dip` (rad)
/// the reference. The field must not be parallel to gravity.
FieldMisfit field_misfit(const survey::StationFields& station, const std::array<double, 3>& gain, double total,
                         double dip);
std::vector<FieldMisfit> field_misfits(const std::vector<survey::StationFields>& stations,
                                       const std::array<double, 3>& gain, double total, double dip);

/// (m - bias) / gain per axis (thesis eq 16).
survey::Vec3<double> corrected_field(const survey::Vec3<double>& reading, const std::array<double, 3>& gain,
                                     const std::array<double, 3>& bias);

/// All residuals by the parameters: two rows a station.
Eigen::Matrix<double, Eigen::Dynamic, 6> misfit_jacobian(const std::vector<FieldMisfit>& misfits);

}  // namespace surveymc::estimate
