#pragma once
/// Frames, and the readings of a perfect tool at an attitude. The notation table is docs/conventions.md.
///
///   N  navigation: x north, y east, z down (NEV). Azimuths are clockwise from north; `azimuth` in an Attitude is the
///      magnetic one (true azimuth - declination) wherever it meets a magnetic field.
///   T  tool: x, y, z right-handed, z down-hole. Toolface tau is measured from y.
///
/// Vectors carry their frame as a suffix: b_T. The frame is that of SPE 67616; with gravity G pointing down,
///
///   g_T = G (-sinI sin tau, -sinI cos tau, cosI)
///   b_T = B ( cosD cosI cosA sin tau + cosD sinA cos tau - sinD sinI sin tau,
///             cosD cosI cosA cos tau - cosD sinA sin tau - sinD sinI cos tau,
///             cosD sinI cosA + sinD cosI )
///
/// The thesis (Vis 2019) measures toolface from x: the axes are the same and tau = T + 90 deg.
#include <cmath>

#include <Eigen/Core>

#include "simd/lanes.h"

namespace surveymc::survey {

using namespace simd;

template <class T>
struct Vec3 {
  T x, y, z;

  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
};
template <class T>
Vec3<T> scale(const T& s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}
template <class T>
Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T norm(const Vec3<T>& a) {
  return sqrt(dot(a, a));
}
static_assert(sizeof(Vec3<double>) == 3 * sizeof(double), "kernels read a row of vectors as numbers");
inline Eigen::Vector3d to_eigen(const Vec3<double>& v) { return {v.x, v.y, v.z}; }
/// The matrix with which v x a = cross_matrix(v) a.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}
inline Vec3<double> from_eigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Error-free readings of a station, as the linearisations take them: without angles.
struct StationFields {
  Vec3<double> field_T;  ///< magnetic field, nT
  Vec3<double> down_T;   ///< direction of gravity, unit vector
};

/// Where a tool points: inclination, azimuth, toolface (from y), all in radians.
struct Attitude {
  double inclination = 0, azimuth = 0, toolface = 0;
};

/// Direction of gravity in the tool frame, a unit vector.
inline Vec3<double> down_T(const Attitude& at) {
  const double si = std::sin(at.inclination);
  return {-si * std::sin(at.toolface), -si * std::cos(at.toolface), std::cos(at.inclination)};
}

/// Field of strength `total` (any unit) and `dip` (rad, positive down) in the tool frame; at.azimuth is magnetic.
inline Vec3<double> magnetic_T(const Attitude& at, double total, double dip) {
  const double si = std::sin(at.inclination), ci = std::cos(at.inclination), sa = std::sin(at.azimuth),
               ca = std::cos(at.azimuth), st = std::sin(at.toolface), ct = std::cos(at.toolface), sd = std::sin(dip),
               cd = std::cos(dip);
  return {total * (cd * ci * ca * st + cd * sa * ct - sd * si * st),
          total * (cd * ci * ca * ct - cd * sa * st - sd * si * ct), total * (cd * si * ca + sd * ci)};
}

/// Unit vector along the hole in N, with azimuth from the same north as `at.azimuth`.
inline Vec3<double> tangent_N(const Attitude& at) {
  const double si = std::sin(at.inclination);
  return {si * std::cos(at.azimuth), si * std::sin(at.azimuth), std::cos(at.inclination)};
}

/// Unit vector along the hole in N from the directions that the tool sees: `u` down (unit), `b` field, any strength.
/// With n = (b - (u.b) u) / |..| (magnetic north) and e = u x n (east), the hole is (n.z, e.z, u.z).
/// North is magnetic. No angle appears, so nothing is singular in a vertical hole. b parallel to u gives NaN.
template <class T>
Vec3<T> tangent_from_fields(const Vec3<T>& u, const Vec3<T>& b) {
  const T bv = dot(u, b);
  const Vec3<T> h{fma(-bv, u.x, b.x), fma(-bv, u.y, b.y), fma(-bv, u.z, b.z)};
  const T per_bh = T(1.0) / norm(h);
  return {h.z * per_bh, (u.x * b.y - u.y * b.x) * per_bh, u.z};
}

/// Magnetic north, east and down as the tool sees them (unit vectors in T), and the field's parts along north and down
/// (nT). b parallel to u gives NaN.
struct FieldFrame {
  Eigen::Vector3d north, east, down;
  double horizontal = 0, vertical = 0;
};
FieldFrame field_frame(const StationFields& station);

/// Attitude from accelerometer (pointing down) and magnetometer triads; azimuth is magnetic, in [0, 2 pi).
/// In a vertical hole only the sum of azimuth and toolface (down) or their difference (up) exists: toolface is 0 there,
/// and azimuth is that angle.
Attitude attitude_from_fields(const Vec3<double>& g_T, const Vec3<double>& b_T);

/// Rotates the horizontal part of a vector from magnetic to true north: declination in rad, positive east.
template <class T>
Vec3<T> magnetic_to_true(const Vec3<T>& v, double sin_declination, double cos_declination) {
  return {v.x * T(cos_declination) - v.y * T(sin_declination), v.x * T(sin_declination) + v.y * T(cos_declination),
          v.z};
}

/// The matrix that does the same.
inline Eigen::Matrix3d true_from_magnetic(double declination) {
  const double s = std::sin(declination), c = std::cos(declination);
  Eigen::Matrix3d r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  return r;
}

/// Rows: high side, lateral (right), along hole, in N, of a hole at (inclination, azimuth). v_HLA = R v_N.
/// Thesis eq 49 with its (2,1) and (3,1) entries corrected.
inline Eigen::Matrix3d rotation_hla_from_nev(double inclination, double azimuth) {
  const double si = std::sin(inclination), ci = std::cos(inclination), sa = std::sin(azimuth), ca = std::cos(azimuth);
  Eigen::Matrix3d r;
  r << ci * ca, ci * sa, -si, -sa, ca, 0, si * ca, si * sa, ci;
  return r;
}

}  // namespace surveymc::survey
