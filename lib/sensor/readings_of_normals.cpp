#include "sensor/readings_of_normals.h"

#include <cassert>

#include "sensor/simulate_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

ReadingNormals reading_normals(int stations, const NoiseModel& noise, const ToolSpread& spread) {
  ReadingNormals n;
  const auto add = [&n](random::Channel channel, int count) {
    const int first = n.rows();
    for (std::uint32_t call = 0; 4 * static_cast<int>(call) < count; ++call) n.calls.push_back({channel, call});
    return first;
  };
  n.magnetometer = add(random::Channel::magnetometer_noise, 3 * stations);
  if (noise.accelerometer > 0) n.accelerometer = add(random::Channel::accelerometer_noise, 3 * stations);
  if (noise.reference != ReferenceNoise::none)
    n.reference =
        add(random::Channel::reference_field, noise.reference == ReferenceNoise::per_station ? 2 * stations : 2);
  if (spread.any()) n.tool = add(random::Channel::tool_errors, 6);
  return n;
}

std::vector<std::string> names_of(const ReadingNormals& n, int stations) {
  std::vector<std::string> names(static_cast<std::size_t>(n.rows()));
  const auto set = [&](int row, const std::string& name) { names[static_cast<std::size_t>(row)] = name; };
  const char* const axes[]{"x", "y", "z"};
  for (int r = 0; r < 3 * stations; ++r) {
    set(n.magnetometer + r, std::string("magnetometer_") + axes[r % 3]);
    if (n.accelerometer >= 0) set(n.accelerometer + r, std::string("accelerometer_") + axes[r % 3]);
  }
  if (n.reference >= 0) {  // one call: a pair a run, and two normals that nothing reads (two stations have no MSA)
    const bool is_per_run = (n.tool >= 0 ? n.tool : n.rows()) - n.reference == 4;
    for (int i = 0; i < (is_per_run ? 2 : 2 * stations); ++i)
      set(n.reference + i, i % 2 == 0 ? "reference_total" : "reference_dip");
  }
  for (int i = 0; i < 6 && n.tool >= 0; ++i)
    set(n.tool + i, std::string(i < 3 ? "tool_gain_" : "tool_bias_") + axes[i % 3]);
  return names;
}

void readings_of_normals(const CleanReadings& clean, const survey::ReferenceField& field, const NoiseModel& noise,
                         const ToolSpread& spread, const ReadingNormals& normals, const survey::LaneArray& z,
                         int groups, survey::ReadingBlock& out) {
  assert(noise.law == NoiseLaw::gaussian && !noise.antithetic);
  const auto rows = [&z](int first) { return first < 0 ? nullptr : z.row(0, first); };
  GivenNormalsBatch b{reading_rows(clean, field, out),
                      groups,
                      noise.magnetometer,
                      noise.accelerometer,
                      noise.reference_total,
                      noise.reference_dip,
                      rows(normals.magnetometer),
                      rows(normals.accelerometer),
                      rows(normals.reference),
                      rows(normals.tool),
                      z.group_stride(),
                      {}};
  for (std::size_t i = 0; i < 6; ++i) b.tool_sd[i] = spread.sd(i);
  simd::run_kernel<isa_v3::readings_of_normals, isa_v4::readings_of_normals>(b);
}

}  // namespace surveymc::sensor
