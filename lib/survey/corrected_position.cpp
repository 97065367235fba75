#include "survey/corrected_position.h"

#include <cmath>

#include "simd/instruction_set.h"
#include "survey/corrected_position_lanes.h"

namespace surveymc::survey {

void corrected_final_positions(const ReadingBlock& readings, const LaneArray& parameters, const std::vector<double>& md,
                               double declination, LaneArray& position) {
  const CorrectedPositionBatch batch{readings.magnetic.row(0, 0),
                                     readings.down.row(0, 0),
                                     parameters.row(0, 0),
                                     readings.magnetic.group_stride(),
                                     readings.down.group_stride(),
                                     parameters.group_stride(),
                                     position.row(0, 0),
                                     position.group_stride(),
                                     md.data(),
                                     static_cast<int>(md.size()),
                                     readings.groups(),
                                     std::sin(declination),
                                     std::cos(declination)};
  simd::run_kernel<isa_v3::corrected_positions, isa_v4::corrected_positions>(batch);
}

}  // namespace surveymc::survey
