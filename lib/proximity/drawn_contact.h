#pragma once
/// The least distance of two drawn wells over all of both paths.
///
/// A leg is an arc of minimum curvature; course errors and a doubled first leg displace it linearly along its length.
/// Spheres about the middles of the chords bound the legs, first eight together and then one by one. The remaining
/// pairs of legs are compared by pieces of chords, with the sagitta of the arc as bound of the error, halved until the
/// error is below kContactError.
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace surveymc::proximity {

/// A drawn path: the place and the tangent of every station, coordinate by coordinate, and the length of the leg that
/// ends there (m, it may be negative; that of station 0 is not read).
struct DrawnPath {
  std::vector<double> x, y, z, tx, ty, tz, length;

  std::size_t stations() const { return x.size(); }
  void resize(std::size_t stations);
  Eigen::Vector3d p(std::size_t k) const { return {x[k], y[k], z[k]}; }
  Eigen::Vector3d t(std::size_t k) const { return {tx[k], ty[k], tz[k]}; }
  void set(std::size_t k, const Eigen::Vector3d& place, const Eigen::Vector3d& tangent, double leg);
};

/// Spheres about the legs of a path and about eight of them together; memory that is used again from trial to trial.
struct LegSpheres {
  std::vector<double> x, y, z, radius, cx, cy, cz, cradius;
};
struct ContactScratch {
  struct Candidate {
    double bound;
    std::size_t i, j;
  };
  LegSpheres reference, offset;
  std::vector<Candidate> candidates;
};

/// Where two paths are nearest.
struct Contact {
  double distance = 0;                            ///< of the centre lines, m
  std::size_t reference_leg = 0, offset_leg = 0;  ///< from station `leg` to the next
  double reference_share = 0, offset_share = 0;   ///< of the legs
};

inline constexpr double kContactError = 1e-5;  // m

/// The nearest pair of points of the paths from station `first` of each on, if it is nearer than `below` (m); otherwise
/// `below` itself as the distance. Accurate to kContactError.
Contact nearest_contact(const DrawnPath& reference, std::size_t first_reference, const DrawnPath& offset,
                        std::size_t first_offset, double below, ContactScratch& scratch);

}  // namespace surveymc::proximity
