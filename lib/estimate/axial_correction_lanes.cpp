#include "estimate/axial_correction_lanes.h"

#include "estimate/axial_correction.h"

namespace surveymc::SURVEYMC_ISA {
namespace {

using T = Lanes;

Vec3<T> load3(const double* p) { return {load<T>(p), load<T>(p + kGroup), load<T>(p + 2 * kGroup)}; }

}  // namespace

void solve_station_batch(const StationSolveBatch& b) {
  for (int k = 0; k < b.count; ++k)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      const double* in = b.readings + k * kStationReadingRows * kGroup + lane;
      double* out = b.solutions + k * kStationSolutionRows * kGroup + lane;
      const Vec3<T> reference = load3(in + kReferenceRow * kGroup);
      const ToolAxes<T> at = axes_from_accelerometers(load3(in + kGravityRow * kGroup),
                                                      b.method == StationMethod::optimising, reference.x, b.sigmas);
      const FieldSolution<T> f =
          solve_field(at, load3(in + kFieldRow * kGroup), reference.y, reference.z, b.sigmas, b.method);
      const T rows[kStationSolutionRows] = {at.si,  at.ci,      at.st,   at.ct,  at.gravity, f.north,
                                            f.east, f.vertical, f.axial, f.cost, f.found};
      for (int r = 0; r < kStationSolutionRows; ++r) store(out + r * kGroup, rows[r]);
    }
}

}  // namespace surveymc::SURVEYMC_ISA
