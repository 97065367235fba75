#include "analysis/multistation_trials.h"

#include <cassert>
#include <cmath>

#include "analysis/multistation_trials_lanes.h"
#include "sensor/magnetometer.h"

namespace surveymc::analysis {

namespace {

std::vector<double> rows_of(const std::vector<Eigen::Vector3d>& vectors) {
  std::vector<double> rows;
  for (const Eigen::Vector3d& v : vectors) rows.insert(rows.end(), v.data(), v.data() + 3);
  return rows;
}

}  // namespace

MultistationRun multistation_run(const survey::Survey& survey, const survey::ReferenceField& field) {
  MultistationRun run;
  run.md = survey.md();
  run.field = field;
  const sensor::CleanReadings clean = sensor::clean_readings(survey, field, {});
  for (std::size_t k = 0; k < clean.field_T.size(); ++k) {
    run.gravity_T.push_back(survey::to_eigen(clean.gravity_T[k]));
    run.field_T.push_back(survey::to_eigen(clean.field_T[k]));
  }
  return run;
}

std::vector<multistation::StationReadings> clean_stations(const MultistationRun& run) {
  const multistation::Reference reference =
      multistation::reference_of(multistation::ResidualKind::survey, run.field.gravity, run.field.total, run.field.dip);
  std::vector<multistation::StationReadings> out;
  for (std::size_t k = 0; k < run.gravity_T.size(); ++k)
    out.push_back(multistation::readings_of(run.tool, run.gravity_T[k], run.field_T[k], reference));
  return out;
}

void simulate_multistation(const MultistationRun& run, const random::Stream& stream, std::uint64_t first_trial,
                           multistation::SixAxisBlock& out, survey::LaneArray& tools) {
  assert(first_trial % simd::kGroup == 0);
  const std::vector<double> gravity = rows_of(run.gravity_T), field = rows_of(run.field_T);
  const MultistationBatch batch{gravity.data(),
                                field.data(),
                                run.tool.data(),
                                run.tool_sd.data(),
                                run.accelerometer,
                                run.magnetometer,
                                run.field.gravity,
                                run.field.total,
                                run.field.dip,
                                run.reference.gravity,
                                run.reference.total,
                                run.reference.dip,
                                out.stations,
                                out.reference_stride > 0 ? out.stations : 1,
                                stream,
                                first_trial,
                                out.groups(),
                                out.gravity.row(0, 0),
                                out.magnetic.row(0, 0),
                                out.reference.row(0, 0),
                                tools.row(0, 0),
                                out.gravity.group_stride(),
                                out.magnetic.group_stride(),
                                out.reference.group_stride(),
                                tools.group_stride()};
  simd::run_kernel<isa_v3::simulate_multistation_batch, isa_v4::simulate_multistation_batch>(batch);
}

void multistation_positions(const multistation::SixAxisBlock& corrected, const std::vector<double>& md,
                            double declination, survey::LaneArray& position) {
  assert(md.size() == static_cast<std::size_t>(corrected.stations));
  const MultistationPositionBatch batch{corrected.gravity.row(0, 0),
                                        corrected.magnetic.row(0, 0),
                                        md.data(),
                                        corrected.gravity.group_stride(),
                                        corrected.magnetic.group_stride(),
                                        position.group_stride(),
                                        position.row(0, 0),
                                        corrected.stations,
                                        corrected.groups(),
                                        std::sin(declination),
                                        std::cos(declination)};
  simd::run_kernel<isa_v3::multistation_position_batch, isa_v4::multistation_position_batch>(batch);
}

}  // namespace surveymc::analysis
