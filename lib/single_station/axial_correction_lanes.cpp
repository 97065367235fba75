#include "single_station/axial_correction_lanes.h"

#include "single_station/axial_correction.h"

namespace surveymc::single_station::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

survey::Vec3<T> load3(const double* p) { return {load<T>(p), load<T>(p + kGroup), load<T>(p + 2 * kGroup)}; }

}  // namespace

void solve_station_batch(const StationSolveBatch& b) {
  for (int k = 0; k < b.count; ++k)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      const double* in = b.readings + k * survey::kStationReadingRows * kGroup + lane;
      double* out = b.solutions + k * kStationSolutionRows * kGroup + lane;
      const survey::Vec3<T> reference = load3(in + survey::kReferenceRow * kGroup);
      const ToolAxes<T> at = axes_from_accelerometers(load3(in + survey::kGravityRow * kGroup),
                                                      b.method == StationMethod::optimising, reference.x, b.sigmas);
      const FieldSolution<T> f =
          solve_field(at, load3(in + survey::kFieldRow * kGroup), reference.y, reference.z, b.sigmas, b.method);
      const T rows[kStationSolutionRows] = {at.si,  at.ci,      at.st,   at.ct,  at.gravity, f.north,
                                            f.east, f.vertical, f.axial, f.cost, f.found};
      for (int r = 0; r < kStationSolutionRows; ++r) store(out + r * kGroup, rows[r]);
    }
}

}  // namespace surveymc::single_station::SURVEYMC_ISA
