#include "sensor/chained_runs.h"

#include <Eigen/Geometry>

#include "base/units.h"

namespace surveymc::sensor {
namespace {

/// Normals first .. of one channel, four to a call.
template <std::size_t N>
std::vector<std::array<double, N>> normals(const random::Stream& stream, std::uint64_t trial, random::Channel channel,
                                           std::size_t rows) {
  std::vector<double> z;
  for (std::uint32_t call = 0; z.size() < N * rows; ++call)
    for (const double x : stream.normals<double>(trial, channel, std::uint64_t{call})) z.push_back(x);
  std::vector<std::array<double, N>> out(rows);
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t i = 0; i < N; ++i) out[k][i] = z[N * k + i];
  return out;
}

}  // namespace

ChainedDraws draw_chained_run(const ChainedRunSetup& s, const random::Stream& stream, std::uint64_t trial) {
  const std::size_t n = s.attitudes.size();
  ChainedDraws draws{normals<9>(stream, trial, random::Channel::chained_state, n),
                     normals<6>(stream, trial, random::Channel::chained_noise, n),
                     {}};
  for (std::size_t k = 0; k < n && s.random_toolface; ++k)
    draws.toolface.push_back(
        stream.uniforms<double>(trial, random::Channel::chained_toolface, static_cast<std::uint64_t>(k / 4))[k % 4]);
  return draws;
}

ChainedRun chained_run_of(const ChainedRunSetup& s, const ChainedDraws& draws) {
  const std::size_t n = s.attitudes.size();
  const auto& steps = draws.steps;
  const auto& noise = draws.noise;
  ChainedRun run;
  std::array<double, 9> walk{};
  for (std::size_t k = 0; k < n; ++k) {
    survey::Attitude at = s.attitudes[k];
    if (s.random_toolface) at.toolface = 2 * kPi * draws.toolface[k];
    run.attitudes.push_back(at);
    Eigen::Matrix3d m;
    m.col(0) = survey::to_eigen(survey::magnetic_T(at, 1, 0));
    m.col(2) = survey::to_eigen(survey::down_T(at));
    m.col(1) = m.col(2).cross(m.col(0));
    run.frames.push_back(m);

    std::array<double, 9> c;
    for (std::size_t i = 0; i < 9; ++i) {
      walk[i] += (k == 0 ? s.first_sd : s.step_sd)[i] * steps[k][i];
      c[i] = walk[i] + s.constant_state[i];
    }
    run.states.push_back(c);

    const double fade = 1 + s.interference_rate * static_cast<double>(k), weight = 1 / (fade * fade);
    const Eigen::Vector3d field_N =
        Eigen::Vector3d(s.horizontal + c[1], 0, s.down + c[2]) + weight * survey::to_eigen(s.interference);
    const Eigen::Vector3d f = -(s.gravity + c[0]) * m.col(2), h = m * field_N;
    std::array<double, 6> y;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      y[i] = f[axis] + c[3 + i] + s.noise[i] * noise[k][i];
      y[3 + i] = h[axis] + c[6 + i] + s.noise[3 + i] * noise[k][3 + i];
    }
    run.readings.push_back(y);
  }
  return run;
}

ChainedRun simulate_chained_run(const ChainedRunSetup& s, const random::Stream& stream, std::uint64_t trial) {
  return chained_run_of(s, draw_chained_run(s, stream, trial));
}

}  // namespace surveymc::sensor
