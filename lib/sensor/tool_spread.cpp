#include "sensor/tool_spread.h"

#include <cassert>

#include "sensor/tool_spread_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

void spread_tools(const CleanReadings& clean, const ToolSpread& spread, bool antithetic, const random::Stream& stream,
                  std::uint64_t first_trial, survey::ReadingBlock& readings, survey::LaneArray& deviation,
                  const NoiseWeights* weights, survey::LaneArray* sums) {
  assert(first_trial % simd::kGroup == 0);
  ToolSpreadBatch batch{&clean.field_T.front().x,
                        readings.magnetic.row(0, 0),
                        deviation.row(0, 0),
                        weights ? sums->row(0, 0) : nullptr,
                        weights ? weights->tool.data() : nullptr,
                        readings.magnetic.group_stride(),
                        deviation.group_stride(),
                        weights ? sums->group_stride() : 0,
                        readings.stations,
                        readings.groups(),
                        first_trial,
                        {},
                        antithetic,
                        stream};
  for (std::size_t i = 0; i < 6; ++i) batch.sd[i] = spread.sd(i);
  simd::run_kernel<isa_v3::spread_tools, isa_v4::spread_tools>(batch);
}

void draw_assumed_sd(AssumedNoise law, double size, const random::Stream& stream, std::uint64_t first_trial,
                     survey::ReadingBlock& readings) {
  assert(first_trial % simd::kGroup == 0 && readings.has_assumed_sd && law != AssumedNoise::constant);
  const AssumedSdBatch batch{readings.assumed_sd.row(0, 0),
                             readings.assumed_sd.group_stride(),
                             3 * readings.stations,
                             readings.groups(),
                             first_trial,
                             law,
                             size,
                             stream};
  simd::run_kernel<isa_v3::draw_assumed_sd, isa_v4::draw_assumed_sd>(batch);
}

}  // namespace surveymc::sensor
