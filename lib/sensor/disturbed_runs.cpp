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

void set_mixing(DisturbedRunSetup& s, const random::ReferenceLaws& laws, bool run, bool stations) {
  s.slots.clear();
  s.slot_of.clear();
  if (!laws.any()) return;
  for (int k = -1; k < s.stations(); ++k) {  // -1: the run
    std::int32_t shared = -1;
    for (std::uint32_t e = 0; e < 3; ++e) {
      const auto element = static_cast<random::ReferenceElement>(e);
      const auto& law = laws.of(element).law;
      if (!law || !(k < 0 ? run : stations)) {
        s.slot_of.push_back(-1);
        continue;
      }
      if (!laws.shared_mixing || shared < 0) {
        shared = static_cast<std::int32_t>(s.slots.size());
        const std::uint32_t slot = laws.slot(element);
        s.slots.push_back(
            k < 0 ? random::MixingSlot{law, random::kMixingRun, slot}
                  : random::MixingSlot{law, random::kMixingStation, 4 * static_cast<std::uint32_t>(k) + slot});
      }
      s.slot_of.push_back(shared);
    }
  }
}

survey::ReadingBlock make_disturbed_block(int trials, const DisturbedRunSetup& setup) {
  return {trials, setup.stations(), true, false};
}

namespace {

/// `mixing`: rows of draw_mixing(); without rows all errors are normal.
DisturbedRunBatch batch_of(const DisturbedRunSetup& s, std::uint64_t first_trial, const survey::LaneArray* mixing,
                           survey::ReadingBlock& out, const survey::LaneArray* made = nullptr,
                           survey::LaneArray* gravity = nullptr) {
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
          mixing == nullptr ? nullptr : mixing->row(0, 0),
          mixing == nullptr ? 0 : mixing->group_stride(),
          s.slot_of.data(),
          s.turned,
          first_trial,
          out.magnetic.row(0, 0),
          out.down.row(0, 0),
          out.reference.row(0, 0),
          out.magnetic.group_stride(),
          out.down.group_stride(),
          out.reference.group_stride(),
          made == nullptr ? nullptr : made->row(0, 0),
          made == nullptr ? 0 : made->group_stride(),
          gravity == nullptr ? nullptr : gravity->row(0, 0),
          gravity == nullptr ? 0 : gravity->group_stride()};
}

}  // namespace

void draw_disturbed_runs(const DisturbedRunSetup& s, const random::Stream& stream, std::uint64_t first_trial,
                         survey::ReadingBlock& out, const survey::LaneArray* made, survey::LaneArray* gravity) {
  survey::LaneArray mixing;
  const bool mixed = !s.slots.empty();
  if (mixed) {
    mixing = survey::LaneArray(out.groups(), 2 * static_cast<int>(s.slots.size()));
    random::draw_mixing(stream, s.slots, first_trial, false, out.groups(), mixing.row(0, 0), mixing.group_stride());
  }
  simd::run_kernel<isa_v3::disturbed_runs, isa_v4::disturbed_runs>(
      batch_of(s, first_trial, mixed ? &mixing : nullptr, out, made, gravity), stream);
}

void disturbed_readings(const DisturbedRunSetup& s, const survey::LaneArray& z, survey::ReadingBlock& out) {
  assert(!s.turned && s.slots.empty());
  simd::run_kernel<isa_v3::disturbed_readings, isa_v4::disturbed_readings>(batch_of(s, 0, nullptr, out), z.row(0, 0),
                                                                           z.group_stride());
}

}  // namespace surveymc::sensor
