#include "sensor/station_draws_lanes.h"

namespace surveymc::sensor::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;
constexpr int kDraws = 3 * kStationBatch;  // of a triad at all stations of a batch: three calls of four

struct TriadDraws {
  T z[kDraws];
};

TriadDraws triad(const StationDrawBatch& b, const Bits<T>& trial, random::Channel channel) {
  TriadDraws d;
  const auto first_call = static_cast<std::uint32_t>(b.first_station / 4 * 3);
  for (std::uint32_t call = 0; call < 3; ++call) {
    const auto z = b.stream.normals<T>(trial, channel, first_call + call);
    for (std::uint32_t i = 0; i < 4; ++i) d.z[4 * call + i] = z[i];
  }
  return d;
}

void put_triad(const survey::Vec3<double>& truth, double sd_xy, double sd_z, const T* z, double* out) {
  store(out, fma(T(sd_xy), z[0], T(truth.x)));
  store(out + kGroup, fma(T(sd_xy), z[1], T(truth.y)));
  store(out + 2 * kGroup, fma(T(sd_z), z[2], T(truth.z)));
}

}  // namespace

void draw_station_batch(const StationDrawBatch& b) {
  for (int group = 0; group < b.groups; ++group)
    for (int at = 0; at < kGroup; at += lane_count<T>) {
      const Bits<T> trial = consecutive<T>(b.first_trial + static_cast<std::uint64_t>(group * kGroup + at));
      const TriadDraws g = triad(b, trial, random::Channel::accelerometer_noise),
                       m = triad(b, trial, random::Channel::magnetometer_noise);
      const auto axial = b.stream.normals<T>(trial, random::Channel::axial_magnetisation,
                                             static_cast<std::uint32_t>(b.first_station / 4));
      for (int k = 0; k < b.count; ++k) {
        const StationTruth& s = b.stations[k];
        double* out = b.readings + (group * b.count + k) * survey::kStationReadingRows * kGroup + at;
        const auto reference = b.stream.normals<T>(trial, random::Channel::station_reference,
                                                   static_cast<std::uint32_t>(b.first_station + k));
        put_triad(s.gravity_T, b.sd.accelerometer_xy, b.sd.accelerometer_z, g.z + 3 * k,
                  out + survey::kGravityRow * kGroup);
        const T drawn_axial = T(b.sd.axial) * axial[static_cast<unsigned>(k)];
        put_triad(s.magnetic_T, b.sd.magnetometer_xy, b.sd.magnetometer_z, m.z + 3 * k,
                  out + survey::kFieldRow * kGroup);
        double* bz = out + (survey::kFieldRow + 2) * kGroup;
        store(bz, load<T>(bz) + drawn_axial);
        double* refs = out + survey::kReferenceRow * kGroup;
        store(refs, fma(T(b.sd.gravity), reference[0], T(s.reference_gravity)));
        store(refs + kGroup, fma(T(b.sd.horizontal), reference[1], T(s.horizontal)));
        store(refs + 2 * kGroup, fma(T(b.sd.vertical), reference[2], T(s.vertical)));
        store(out + survey::kAxialRow * kGroup, T(s.axial) + drawn_axial);
      }
    }
}

}  // namespace surveymc::sensor::SURVEYMC_ISA
