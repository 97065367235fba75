#pragma once
/// The model of all estimators that fit the horizontal and vertical field of the stations to the reference: weighted
/// multi-station analysis, joint estimation of sensors and reference, and weighted least squares with considered
/// reference. Readable form; the hand-written Jacobian is in field_fit_kernel.h.
///
///   minimise  sum_k r_k' W r_k + s0^2 (z' z + ((p - 1) / sd_p)^2 + (q / sd_q)^2)
///   r_k = (Bh_k - Bh'_k, Bv_k - Bv'_k),   b_k = p m_k - q   (thesis eqs 16-17)
/// with W = s0^2 R^-1, R the covariance of (Bh, Bv) at a station. For a joint estimate the reference is
///   (Bh', Bv') = (1 + z0 sd_total / B) rotation(z1 sd_dip) (Bh_ref, Bv_ref),
/// that is B' = B + z0 sd_total, dip' = dip + z1 sd_dip with z ~ N(0, 1); else z = 0. Where a prior's sd is given as 0,
/// that prior of p or q is absent.
/// With W = 1, z = 0 and no priors this is MSA.
///
/// The equation of a gain at this minimum is  sum_k a_i'W r_k m_i + prior = 0,  a_i = d(Bh, Bv)/db_i: the derivative by
/// a gain is the reading m_i, whose noise is in r_k too. So at the truth its expectation is not zero but
/// s0^2 sum_k a_i'W a_i, and the estimated gains are too large, by some (stations) sd(gain)^2: errors in variables
/// (Fuller 1987, Measurement Error Models, 2.2). With `fitted_derivative` the fitted field replaces the reading m_i
/// there: the horizontal direction of the corrected reading times Bh' plus u times Bv'. The shift then vanishes to
/// first order of the noise squared. These equations are no gradient of a cost; the search for their root begins at the
/// minimum.
#include <array>

#include <Eigen/Core>

#include "estimate/input_errors.h"
#include "estimate/msa_residual.h"
#include "simd/math.h"
#include "survey/reference_field.h"

namespace surveymc::estimate {

using namespace simd;

/// All in units of the total field, so that the unknowns p, q / total, z and their columns are of order one.
struct FieldFitModel {
  double total = 1;                     ///< nT
  double w_hh = 1, w_hv = 0, w_vv = 1;  ///< W, symmetric
  bool joint = false;                   ///< z are unknowns
  double total_sd = 0, dip_sd = 0;      ///< of the reference: in units of the total field, rad
  double unit_weight = 0;               ///< (s0 / total)^2
  double gain_prior = 0;                ///< weight (s0 / total)^2 / sd^2 of p - 1; 0: no prior
  std::array<double, 3> bias_prior{};   ///< the same of q / total, per axis
  std::array<bool, 6> estimated{true, true, true, true, true, true};  ///< which of p, q; others stay at p = 1, q = 0
  bool fitted_derivative = false;                                     ///< see above; else the minimum
};

/// Covariance of (Bh, Bv) at a station (nT^2), for unit gains: magnetometer noise s^2 1, a tilt of the down direction
/// (dBh, dBv) = (-Bv, Bh) per rad towards north, the disturbance of a station's field by (B, dip), and the reference
/// by (B, dip) if `with_reference`. No angle of the tool enters.
Eigen::Matrix2d field_covariance(const InputErrors& assumed, const survey::ReferenceField& field, bool with_reference);

struct EstimatorOptions;  // of estimator.h, which no kernel includes

/// The model that msa, msa_weighted, msa_joint and wls_consider minimise. Throws InputError on any other name, and, for
/// all but msa, unless assumed.magnetometer > 0 (weights are relative to it).
FieldFitModel field_fit_model(const EstimatorOptions& options, const survey::ReferenceField& field);

/// Residuals of one station before weighting, in units of the total field; m, bh_ref, bv_ref in the same unit.
/// T: double or Dual.
template <class T>
std::array<T, 2> field_fit_residual(const FieldFitModel& model, const survey::Vec3<T>& m, const survey::Vec3<T>& u,
                                    double bh_ref, double bv_ref, const MsaUnknowns<T>& x, const std::array<T, 2>& z) {
  const T stretch = T(1.0) + z[0] * T(model.total_sd / std::hypot(bh_ref, bv_ref));
  const auto [s, c] = sincos(z[1] * T(model.dip_sd));
  return msa_residual<T>(m, u, stretch * (c * T(bh_ref) - s * T(bv_ref)), stretch * (s * T(bh_ref) + c * T(bv_ref)), x);
}

}  // namespace surveymc::estimate
