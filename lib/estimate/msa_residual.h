#pragma once
/// The model of multi-station analysis (MSA), readable form. The hand-written Jacobian is in msa_kernel.h.
#include <array>

#include "survey/frames.h"

namespace surveymc::estimate {

/// Gains g and biases of a magnetometer triad in the form that makes the corrected field linear:
/// b = (m - bias) / gain = p m - q per axis, with p = 1 / gain and q = bias / gain.
template <class T>
struct MsaUnknowns {
  survey::Vec3<T> p, q;
};

/// Field residuals of one station for trial gains and biases (thesis eqs 16-17).
///   r[0] = Bh - Bh_ref,  r[1] = Bv - Bv_ref          (unit of the readings)
/// with b = p m - q per axis, Bv = u.b (u: down, tool frame, unit), Bh = |b - Bv u|.
/// Exactly zero for error-free readings and the true parameters.
/// T: double, Lanes, or Dual of either. No branches, no allocation.
template <class T>
std::array<T, 2> msa_residual(const survey::Vec3<T>& m, const survey::Vec3<T>& u, const T& bh_ref, const T& bv_ref,
                              const MsaUnknowns<T>& x) {
  const survey::Vec3<T> b{x.p.x * m.x - x.q.x, x.p.y * m.y - x.q.y, x.p.z * m.z - x.q.z};
  const T bv = dot(u, b);
  return {norm(b - scale(bv, u)) - bh_ref, bv - bv_ref};
}

}  // namespace surveymc::estimate
