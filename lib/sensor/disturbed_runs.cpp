#include "sensor/disturbed_runs.h"

#include <cassert>

#include "sensor/disturbed_runs_lanes.h"
#include "survey/frames.h"

namespace surveymc::sensor {

DisturbedRunSetup disturbed_run_setup(const survey::Survey& survey, const survey::ReferenceField& field) {
  DisturbedRunSetup s;
  s.field = field;
  for (std::size_t k = 1; k < survey.stations.size(); ++k) {
    const survey::Attitude at = survey::magnetic_attitude(survey.stations[k], field.declination);
    // Of a level field: the axes do not depend on the dip.
    const survey::FieldFrame f = survey::field_frame({survey::magnetic_T(at, 1, 0), survey::down_T(at)});
    for (const Eigen::Vector3d* axis : {&f.north, &f.east, &f.down})
      s.frames.insert(s.frames.end(), axis->data(), axis->data() + 3);
  }
  return s;
}

survey::ReadingBlock make_disturbed_block(int trials, const DisturbedRunSetup& setup) {
  return {trials, setup.stations(), true, false};
}

namespace {

DisturbedRunBatch batch_of(const DisturbedRunSetup& s, std::uint64_t first_trial, survey::ReadingBlock& out) {
  return {s.frames.data(),
          s.stations(),
          out.groups(),
          s.sd,
          s.interference,
          s.noise,
          s.field.total,
          s.field.dip,
          s.field.gravity,
          s.run,
          s.station,
          s.turned,
          first_trial,
          out.magnetic.row(0, 0),
          out.down.row(0, 0),
          out.reference.row(0, 0),
          out.magnetic.group_stride(),
          out.down.group_stride(),
          out.reference.group_stride()};
}

}  // namespace

void draw_disturbed_runs(const DisturbedRunSetup& s, const random::Stream& stream, std::uint64_t first_trial,
                         survey::ReadingBlock& out) {
  simd::run_kernel<isa_v3::disturbed_runs, isa_v4::disturbed_runs>(batch_of(s, first_trial, out), stream);
}

void disturbed_readings(const DisturbedRunSetup& s, const survey::LaneArray& z, survey::ReadingBlock& out) {
  assert(!s.turned);
  simd::run_kernel<isa_v3::disturbed_readings, isa_v4::disturbed_readings>(batch_of(s, 0, out), z.row(0, 0),
                                                                           z.group_stride());
}

}  // namespace surveymc::sensor
