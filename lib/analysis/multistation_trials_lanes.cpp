#include "analysis/multistation_trials_lanes.h"

#include "multistation/fit_kernel.h"
#include "simd/math.h"
#include "survey/minimum_curvature.h"

namespace surveymc::analysis::SURVEYMC_ISA {

using namespace simd;
using simd::store;
using namespace multistation;

namespace {

using T = Lanes;
using Vec = survey::Vec3<T>;

/// size * draw for `rows` rows.
void draw_rows(const random::Stream& stream, const Bits<T>& trial, random::Channel channel, int rows, double size,
               double* out) {
  for (int first = 0; first < rows; first += 4) {
    const auto z = stream.normals<T>(trial, channel, Bits<T>(static_cast<std::uint64_t>(first / 4)));
    for (int i = 0; i < 4 && first + i < rows; ++i)
      store(out + (first + i) * kGroup, T(size) * z[static_cast<std::size_t>(i)]);
  }
}

/// Adds matrix v + bias to three rows.
void add_reading(const std::array<T, 9>& matrix, const Vec& bias, const double* v, double* out) {
  const Vec r = times(matrix, Vec{T(v[0]), T(v[1]), T(v[2])}) + bias + load3<T>(out);
  store(out, r.x);
  store(out + kGroup, r.y);
  store(out + 2 * kGroup, r.z);
}

}  // namespace

void simulate_multistation_batch(const MultistationBatch& b) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) {
      const Bits<T> trial = consecutive<T>(b.first_trial + group * kGroup + lane);
      std::array<T, kUnknowns> e;
      for (std::size_t call = 0; call < kUnknowns / 4; ++call) {
        const auto z = b.stream.normals<T>(trial, random::Channel::tool_errors, Bits<T>(std::uint64_t{call}));
        for (std::size_t i = 0; i < 4; ++i) {
          const std::size_t at = 4 * call + i;
          if (at >= kParameters) break;
          e[at] = fma(T(b.tool_sd[at]), z[i], T(b.tool[at]));
          store(b.tools_out + group * b.tools_stride + at * kGroup + lane, e[at]);
        }
      }
      double *gravity = b.gravity_out + group * b.gravity_stride + lane,
             *magnetic = b.magnetic_out + group * b.magnetic_stride + lane;
      draw_rows(b.stream, trial, random::Channel::accelerometer_noise, 3 * b.stations, b.accelerometer, gravity);
      draw_rows(b.stream, trial, random::Channel::magnetometer_noise, 3 * b.stations, b.magnetometer, magnetic);
      const std::array<T, 9> a = accelerometer_matrix(e), m = magnetometer_matrix(e);
      const Vec a_bias{e[kAccelerometerBias], e[kAccelerometerBias + 1], e[kAccelerometerBias + 2]},
          m_bias{e[kMagnetometerBias], e[kMagnetometerBias + 1], e[kMagnetometerBias + 2]};
      for (int k = 0; k < b.stations; ++k) {
        add_reading(a, a_bias, b.gravity + 3 * k, gravity + 3 * k * kGroup);
        add_reading(m, m_bias, b.field + 3 * k, magnetic + 3 * k * kGroup);
      }
      double* reference = b.reference_out + group * b.reference_stride + lane;
      for (int k = 0; k < b.references; ++k, reference += kResiduals * kGroup) {
        const auto z =
            b.stream.normals<T>(trial, random::Channel::station_reference, Bits<T>(static_cast<std::uint64_t>(k)));
        const T total = fma(T(b.total_sd), z[1], T(b.total));
        const auto [s, c] = sincos(fma(T(b.dip_sd), z[2], T(b.dip)));
        store(reference, fma(T(b.gravity_sd), z[0], T(b.gravity_reference)));
        store(reference + kGroup, total * c);
        store(reference + 2 * kGroup, total * s);
      }
    }
}

void multistation_position_batch(const MultistationPositionBatch& b) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) {
      const double *gravity = b.gravity + group * b.gravity_stride + lane,
                   *magnetic = b.magnetic + group * b.magnetic_stride + lane;
      Vec position{T(0.0), T(0.0), T(0.0)}, before{};
      for (int k = 0; k < b.stations; ++k, gravity += 3 * kGroup, magnetic += 3 * kGroup) {
        const Vec g = load3<T>(gravity);
        const Vec t = survey::tangent_from_fields(survey::scale(T(1.0) / survey::norm(g), g), load3<T>(magnetic));
        if (k > 0) position = position + survey::minimum_curvature_interval(T(b.md[k] - b.md[k - 1]), before, t);
        before = t;
      }
      const Vec r = survey::magnetic_to_true(position, b.sin_declination, b.cos_declination);
      double* out = b.position + group * b.position_stride + lane;
      store(out, r.x);
      store(out + kGroup, r.y);
      store(out + 2 * kGroup, r.z);
    }
}

}  // namespace surveymc::analysis::SURVEYMC_ISA
