#pragma once
/// Readings of six axes of runs in which nothing is as the reference says: the tool has biases and scales, and the true
/// field differs from the reference, by one draw for the run and by another at every station.
///
///   B_k = B + dB + dB_k,  dip_k = dip + dd + dd_k,  magnetic north is turned by de + de_k
///   g = G u (1 + scale) + bias,   m = (1 + scale) b_k + bias + noise,   b_k the field B_k, dip_k in the tool frame
/// The reading block's `down` is the direction of g; its reference is (B, dip), what an estimator is told.
#include <cstdint>
#include <vector>

#include "random/reference_laws.h"
#include "random/stream.h"
#include "survey/readings.h"
#include "survey/reference_field.h"
#include "survey/sensor_terms.h"
#include "survey/survey.h"

namespace surveymc::sensor {

/// One standard deviation of an error of the reference: nT, rad, rad.
struct ReferenceErrors {
  double total = 0, dip = 0, declination = 0;
};

struct DisturbedRunSetup {
  survey::ReferenceField field;
  /// Of every measured station, nine numbers: magnetic north by the reference, east and down, in tool axes.
  std::vector<double> frames;
  survey::SensorTermArray sd{};  ///< once a run
  double interference = 0;       ///< nT, once a run, added to the bias of z
  ReferenceErrors run, station;  ///< once a run; new at every station
  double noise = 0;              ///< nT, of a magnetometer reading
  /// V of errors of the reference that are not normal (mixing_of); numbers of slots of declination, dip and total, of
  /// the run and then of every station; -1: normal. Empty: all are.
  std::vector<random::MixingSlot> slots = {};
  std::vector<std::int32_t> slot_of = {};
  bool turned = false;  ///< the tool of the whole run is turned about its axis by an angle, uniform, once a run

  int stations() const { return static_cast<int>(frames.size() / 9); }
};
/// The stations of `survey` but the first, which is the tie-on. Sizes are zero.
DisturbedRunSetup disturbed_run_setup(const survey::Survey& survey, const survey::ReferenceField& field);

/// Sets slots of the laws: `run` and `stations` say whose errors have them.
void set_mixing(DisturbedRunSetup& setup, const random::ReferenceLaws& laws, bool run, bool stations);

/// A block of the right shape.
survey::ReadingBlock make_disturbed_block(int trials, const DisturbedRunSetup& setup);

/// Fills `out` with trials first_trial, first_trial + 1, ... (first_trial a multiple of kGroup). Channels:
/// disturbed_run (index 16: the turn), disturbed_station, and magnetometer_noise with noise. `made`: the draws of
/// `setup.station` in place of the stream's, rows 3 station + {total field, dip, declination}, in units of their sd.
/// `gravity`: null, or room for |g| of every station as it is read (m/s2), a row a station.
void draw_disturbed_runs(const DisturbedRunSetup& setup, const random::Stream& stream, std::uint64_t first_trial,
                         survey::ReadingBlock& out, const survey::LaneArray* made = nullptr,
                         survey::LaneArray* gravity = nullptr);

/// The same of given normals, rows of `z` (groups of `out` or more): 16 of the run in the order of SensorTerms,
/// interference, total field, dip, declination; then three of every station: total field, dip, declination; then three
/// of every station's noise, read where there is noise. The tool is not turned (asserted).
void disturbed_readings(const DisturbedRunSetup& setup, const survey::LaneArray& z, survey::ReadingBlock& out);

}  // namespace surveymc::sensor
