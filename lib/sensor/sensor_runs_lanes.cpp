#include "sensor/sensor_runs_lanes.h"

namespace surveymc::sensor::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

void store_turn(double* rows, const T& cosine, const T& sine) {
  store(rows, cosine);
  store(rows + kGroup, sine);
}

/// cos and sin of a toolface from its uniform draw.
void store_drawn(double* rows, const T& uniform) {
  const auto [s, c] = sincos(T(2 * kPi) * uniform);
  store_turn(rows, c, s);
}

void draw_errors(const SensorRunBatch& b, const random::Stream& stream, const Bits<T>& trial, double* out) {
  for (int term = 0; term < survey::kSensorTerms; term += 4) {
    const auto z = stream.normals<T>(trial, random::Channel::sensor_term, static_cast<std::uint32_t>(term / 4));
    for (int i = 0; i < 4; ++i)
      store(out + (term + i) * kGroup, T(b.sd[static_cast<std::size_t>(term + i)]) * z[static_cast<std::size_t>(i)]);
  }
}

void draw_toolfaces(const SensorRunBatch& b, const random::Stream& stream, const Bits<T>& trial, double* out) {
  T slide(0.0);
  if (b.first_slid >= 0)
    slide =
        stream.uniforms<T>(trial, random::Channel::toolface,
                           static_cast<std::uint32_t>(b.first_slid / 4))[static_cast<std::size_t>(b.first_slid % 4)];
  for (int first = 0; first < b.stations; first += 4) {
    const int end = first + 4 < b.stations ? first + 4 : b.stations;
    bool own = false;
    for (int k = first; k < end; ++k) own = own || b.source[k] == survey::ToolfaceSource::own;
    std::array<T, 4> u{T(0.0), T(0.0), T(0.0), T(0.0)};
    if (own) u = stream.uniforms<T>(trial, random::Channel::toolface, static_cast<std::uint32_t>(first / 4));
    for (int k = first; k < end; ++k) {
      double* rows = out + 2 * k * kGroup;
      if (b.source[k] == survey::ToolfaceSource::given)
        store_turn(rows, T(b.given_cos[k]), T(b.given_sin[k]));
      else if (b.source[k] == survey::ToolfaceSource::own)
        store_drawn(rows, u[static_cast<std::size_t>(k - first)]);
      else if (k == b.first_slid)
        store_drawn(rows, slide);
      else
        store_turn(rows, load<T>(out + 2 * b.first_slid * kGroup), load<T>(out + (2 * b.first_slid + 1) * kGroup));
    }
  }
}

/// Reading of v_H by a triad with these errors at a toolface (head of frames.h: x' = x cos + y sin, y' = y cos - x
/// sin).
survey::Vec3<T> reading(const double* v_H, const T& c, const T& s, const survey::Vec3<T>& gain,
                        const survey::Vec3<T>& bias) {
  const T x(v_H[0]), y(v_H[1]), z(v_H[2]);
  return {fma(gain.x, fma(x, c, y * s), bias.x), fma(gain.y, fms(y, c, x * s), bias.y), fma(gain.z, z, bias.z)};
}

survey::Vec3<T> load3(const double* p) { return {load<T>(p), load<T>(p + kGroup), load<T>(p + 2 * kGroup)}; }

survey::Vec3<T> gains(const double* p) {
  const survey::Vec3<T> scale_error = load3(p);
  return {T(1.0) + scale_error.x, T(1.0) + scale_error.y, T(1.0) + scale_error.z};
}

/// One run: all reported positions in one pass over the stations.
void positions_of(const SensorRunBatch& b, const double* errors, const double* toolface, double* out) {
  const survey::Vec3<T> g_bias = load3(errors + survey::kAccelerometerBias * kGroup),
                        b_bias = load3(errors + survey::kMagnetometerBias * kGroup);
  const survey::Vec3<T> g_gain = gains(errors + survey::kAccelerometerScale * kGroup),
                        b_gain = gains(errors + survey::kMagnetometerScale * kGroup);
  survey::Vec3<T> position{T(0.0), T(0.0), T(0.0)}, before{};
  int next = 0;
  for (int k = 0; k < b.stations && next < b.reported_count; ++k) {
    const T c = load<T>(toolface + 2 * k * kGroup), s = load<T>(toolface + (2 * k + 1) * kGroup);
    const bool exact = k == 0 && b.first_is_tie_on;
    const survey::Vec3<T> one{T(1.0), T(1.0), T(1.0)}, none{T(0.0), T(0.0), T(0.0)};
    const survey::Vec3<T> g = reading(b.gravity + 3 * k, c, s, exact ? one : g_gain, exact ? none : g_bias);
    const survey::Vec3<T> m = reading(b.field + 3 * k, c, s, exact ? one : b_gain, exact ? none : b_bias);
    const survey::Vec3<T> tangent = survey::tangent_from_fields(scale(T(1.0) / norm(g), g), m);
    if (k > 0) position = position + survey::interval_displacement(b.method, T(b.md[k] - b.md[k - 1]), before, tangent);
    before = tangent;
    if (b.reported[next] != k) continue;
    // Position is linear in the tangents' horizontal parts, so north is turned here and not at every station.
    const survey::Vec3<T> r = survey::magnetic_to_true(position, b.sin_declination, b.cos_declination);
    store(out + 3 * next * kGroup, r.x);
    store(out + (3 * next + 1) * kGroup, r.y);
    store(out + (3 * next + 2) * kGroup, r.z);
    ++next;
  }
}

}  // namespace

void draw_sensor_runs(const SensorRunBatch& b, const random::Stream& stream) {
  for (int group = 0; group < b.groups; ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      const Bits<T> trial = consecutive<T>(b.first_trial + static_cast<std::uint64_t>(group * kGroup + lane));
      const auto g = static_cast<std::size_t>(group);
      draw_errors(b, stream, trial, b.errors + g * b.errors_stride + lane);
      if (group == 0 || b.toolface_stride > 0)
        draw_toolfaces(b, stream, trial, b.toolface + g * b.toolface_stride + lane);
    }
}

void sensor_run_positions(const SensorRunBatch& b) {
  for (std::size_t g = 0; g < static_cast<std::size_t>(b.groups); ++g)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>)
      positions_of(b, b.errors + g * b.errors_stride + lane, b.toolface + g * b.toolface_stride + lane,
                   b.positions + g * b.positions_stride + lane);
}

}  // namespace surveymc::sensor::SURVEYMC_ISA
