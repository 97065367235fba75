#include "survey/corrected_position.h"

#include <cassert>
#include <cmath>

#include "simd/instruction_set.h"
#include "survey/corrected_position_lanes.h"

namespace surveymc::survey {

namespace {

CorrectedPositionBatch batch_of(const ReadingBlock& readings, const LaneArray& parameters,
                                const std::vector<double>& md, double declination, LaneArray& position) {
  return {readings.magnetic.row(0, 0),
          readings.down.row(0, 0),
          parameters.row(0, 0),
          readings.magnetic.group_stride(),
          readings.down.group_stride(),
          parameters.group_stride(),
          position.row(0, 0),
          position.group_stride(),
          md.data(),
          readings.stations,
          readings.groups(),
          std::sin(declination),
          std::cos(declination)};
}

}  // namespace

void corrected_final_positions(const ReadingBlock& readings, const LaneArray& parameters, const std::vector<double>& md,
                               double declination, LaneArray& position) {
  assert(md.size() == static_cast<std::size_t>(readings.stations));
  const CorrectedPositionBatch batch = batch_of(readings, parameters, md, declination, position);
  simd::run_kernel<isa_v3::corrected_positions, isa_v4::corrected_positions>(batch);
}

TiedSurvey tied_survey(const Survey& survey, double declination, bool first_leg_doubled) {
  TiedSurvey t{survey.md(), {}, {}, declination, first_leg_doubled};
  for (const Station& s : survey.stations) {
    const Attitude at = magnetic_attitude(s, declination);
    t.tangents.push_back(tangent_N(at));
    if (t.tangents.size() > 1) t.right.push_back({-std::sin(at.azimuth), std::cos(at.azimuth), 0});
  }
  return t;
}

void corrected_tied_positions(const ReadingBlock& readings, const LaneArray& parameters, const TiedSurvey& survey,
                              LaneArray& position, LaneArray& lateral) {
  assert(survey.md.size() == static_cast<std::size_t>(readings.stations) + 1);
  const TiedPositionBatch batch{batch_of(readings, parameters, survey.md, survey.declination, position),
                                &survey.tangents[0].x,
                                &survey.right[0].x,
                                survey.first_leg_doubled,
                                lateral.row(0, 0),
                                lateral.group_stride()};
  simd::run_kernel<isa_v3::tied_positions, isa_v4::tied_positions>(batch);
}

}  // namespace surveymc::survey
