#include "sensor/disturbed_runs_lanes.h"

#include <tuple>

#include "base/units.h"
#include "simd/math.h"
#include "survey/frames.h"

namespace surveymc::sensor::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

survey::Vec3<T> vec(const double* p) { return {T(p[0]), T(p[1]), T(p[2])}; }

/// Of a tool that is turned about its axis: toolface larger by the angle.
survey::Vec3<T> turn(const survey::Vec3<T>& v, const T& sine, const T& cosine) {
  return {fma(cosine, v.x, sine * v.y), fma(cosine, v.y, -sine * v.x), v.z};
}

/// The normals of the trials of a group: 16 of the run; of every station four, of which the last is not used; of the
/// noise four neighbouring ones, from `row` on.
struct DrawnNormals {
  const random::Stream& stream;
  Bits<T> trial;
  const double* made;  ///< draws of the stations in place of the stream's, or null
  std::array<T, 16> run() const {
    std::array<T, 16> z;
    for (std::uint32_t call = 0; call < 4; ++call) {
      const auto draws = stream.normals<T>(trial, random::Channel::disturbed_run, Bits<T>(call));
      for (std::size_t i = 0; i < 4; ++i) z[4 * call + i] = draws[i];
    }
    return z;
  }
  T turn() const { return stream.uniforms<T>(trial, random::Channel::disturbed_run, Bits<T>(4))[0]; }
  std::array<T, 4> station(int k) const {
    if (made != nullptr) {
      const double* row = made + 3 * k * kGroup;
      return {load<T>(row), load<T>(row + kGroup), load<T>(row + 2 * kGroup), T(0.0)};
    }
    return stream.normals<T>(trial, random::Channel::disturbed_station, Bits<T>(static_cast<std::uint64_t>(k)));
  }
  std::array<T, 4> noise(int row) const {
    return stream.normals<T>(trial, random::Channel::magnetometer_noise, Bits<T>(static_cast<std::uint64_t>(row / 4)));
  }
};

/// Those that are given (disturbed_runs.h: disturbed_readings).
struct GivenNormals {
  const double* z;  ///< rows kGroup doubles apart
  int stations;
  T row(int i) const { return load<T>(z + i * kGroup); }
  std::array<T, 16> run() const {
    std::array<T, 16> out;
    for (int i = 0; i < 16; ++i) out[static_cast<std::size_t>(i)] = row(i);
    return out;
  }
  T turn() const { return T(0.0); }
  std::array<T, 4> station(int k) const {
    const int first = 16 + 3 * k;
    return {row(first), row(first + 1), row(first + 2), T(0.0)};
  }
  std::array<T, 4> noise(int from) const {
    std::array<T, 4> out{T(0.0), T(0.0), T(0.0), T(0.0)};
    for (int i = 0; i < 4 && from + i < 3 * stations; ++i)
      out[static_cast<std::size_t>(i)] = row(16 + 3 * stations + from + i);
    return out;
  }
};

/// One run. `mixing`: of these trials.
template <class Normals>
void run(const DisturbedRunBatch& b, const Normals& normals, const double* mixing, double* magnetic, double* down,
         double* gravity) {
  // The error of an element (declination, dip, total) of the run, station -1, or of a station.
  const auto mixed = [&](int station, int element, const T& z) {
    if (mixing == nullptr) return z;
    const std::int32_t slot = b.slot_of[3 * (station + 1) + element];
    if (slot < 0) return z;
    const double* v = mixing + 2 * slot * kGroup;
    return fma(load<T>(v), z, load<T>(v + kGroup));
  };
  const std::array<T, 16> z = normals.run();
  const auto term = [&](std::size_t i) { return T(b.sd[i]) * z[i]; };
  const auto three = [&](std::size_t from) { return survey::Vec3<T>{term(from), term(from + 1), term(from + 2)}; };
  const T per_gravity(1 / b.gravity), one(1.0);
  const survey::Vec3<T> a_bias = scale(per_gravity, three(survey::kAccelerometerBias)),
                        a_scale = three(survey::kAccelerometerScale), m_scale = three(survey::kMagnetometerScale);
  survey::Vec3<T> m_bias = three(survey::kMagnetometerBias);
  m_bias.z = fma(T(b.interference), z[12], m_bias.z);
  const T total = fma(T(b.run.total), mixed(-1, 2, z[13]), T(b.total)),
          dip = fma(T(b.run.dip), mixed(-1, 1, z[14]), T(b.dip)),
          declination = T(b.run.declination) * mixed(-1, 0, z[15]);
  T sin_tool(0.0), cos_tool(1.0);
  if (b.turned) std::tie(sin_tool, cos_tool) = sincos(T(2 * kPi) * normals.turn());
  for (int k = 0; k < b.stations; ++k) {
    const std::array<T, 4> draws = normals.station(k);
    const T field = fma(T(b.station.total), mixed(k, 2, draws[0]), total);
    const auto [sin_dip, cos_dip] = sincos(fma(T(b.station.dip), mixed(k, 1, draws[1]), dip));
    const auto [sin_turn, cos_turn] = sincos(fma(T(b.station.declination), mixed(k, 0, draws[2]), declination));
    const T horizontal = field * cos_dip, vertical = field * sin_dip;
    const T along_north = horizontal * cos_turn, along_east = horizontal * sin_turn;
    const double* frame = b.frames + 9 * k;
    survey::Vec3<T> n = vec(frame), e = vec(frame + 3), u = vec(frame + 6);
    if (b.turned)
      for (survey::Vec3<T>* axis : {&n, &e, &u}) *axis = turn(*axis, sin_tool, cos_tool);
    const auto reading = [&](const T& nc, const T& ec, const T& uc, const T& gain, const T& bias) {
      const T x = fma(nc, along_north, fma(ec, along_east, uc * vertical));
      return fma(gain, x, x) + bias;
    };
    store(magnetic + 3 * k * kGroup, reading(n.x, e.x, u.x, m_scale.x, m_bias.x));
    store(magnetic + (3 * k + 1) * kGroup, reading(n.y, e.y, u.y, m_scale.y, m_bias.y));
    store(magnetic + (3 * k + 2) * kGroup, reading(n.z, e.z, u.z, m_scale.z, m_bias.z));
    const survey::Vec3<T> g{fma(a_scale.x, u.x, u.x) + a_bias.x, fma(a_scale.y, u.y, u.y) + a_bias.y,
                            fma(a_scale.z, u.z, u.z) + a_bias.z};
    const T length = norm(g);
    if (gravity) store(gravity + k * kGroup, T(b.gravity) * length);
    const survey::Vec3<T> direction = scale(one / length, g);
    store(down + 3 * k * kGroup, direction.x);
    store(down + (3 * k + 1) * kGroup, direction.y);
    store(down + (3 * k + 2) * kGroup, direction.z);
  }
  if (!(b.noise > 0)) return;
  for (int row = 0; row < 3 * b.stations; row += 4) {
    const std::array<T, 4> draws = normals.noise(row);
    for (int i = 0; i < 4 && row + i < 3 * b.stations; ++i) {
      double* at = magnetic + (row + i) * kGroup;
      store(at, fma(T(b.noise), draws[static_cast<std::size_t>(i)], load<T>(at)));
    }
  }
}

/// Every group of trials, with the normals that `normals_of` gives for its first trial.
template <class NormalsOf>
void run_all(const DisturbedRunBatch& b, const NormalsOf& normals_of) {
  const auto [sin_dip, cos_dip] = sincos(T(b.dip));
  for (int group = 0; group < b.groups; ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      const auto g = static_cast<std::size_t>(group);
      run(b, normals_of(group, lane), b.mixing == nullptr ? nullptr : b.mixing + g * b.mixing_stride + lane,
          b.magnetic + g * b.magnetic_stride + lane, b.down + g * b.down_stride + lane,
          b.gravity_size ? b.gravity_size + g * b.gravity_size_stride + lane : nullptr);
      double* reference = b.reference + g * b.reference_stride + lane;
      store(reference, T(b.total) * cos_dip);
      store(reference + kGroup, T(b.total) * sin_dip);
    }
}

}  // namespace

void disturbed_runs(const DisturbedRunBatch& b, const random::Stream& stream) {
  run_all(b, [&](int group, int lane) {
    return DrawnNormals{stream, consecutive<T>(b.first_trial + static_cast<std::uint64_t>(group * kGroup + lane)),
                        b.made == nullptr ? nullptr : b.made + static_cast<std::size_t>(group) * b.made_stride + lane};
  });
}

void disturbed_readings(const DisturbedRunBatch& b, const double* z, std::size_t stride) {
  run_all(b, [&](int group, int lane) {
    return GivenNormals{z + static_cast<std::size_t>(group) * stride + lane, b.stations};
  });
}

}  // namespace surveymc::sensor::SURVEYMC_ISA
