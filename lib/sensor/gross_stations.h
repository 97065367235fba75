#pragma once
/// Stations whose magnetometer readings are in error by much more than any tool is: near a casing, a fish or another
/// well, at a tool that moved, by transmission.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "random/stream.h"
#include "survey/readings.h"

namespace surveymc::sensor {

enum class GrossKind {
  scattered,  ///< stations by chance; every one has an error of its own, in tool axes
  casing,     ///< the first stations: a field fixed in the earth, one a run, which decays: (1 + .35 k)^-2 at station k
  stretch     ///< neighbouring stations anywhere: a field fixed in the earth, one a run, the same at each
};
/// "scattered", "casing", "stretch".
const std::vector<std::string>& gross_kind_names();

struct GrossStations {
  GrossKind kind = GrossKind::scattered;
  int count = 0;    ///< stations in error
  double size = 0;  ///< nT, one sd of an error along each axis
};

/// How much of the error a station k of those in error has.
double gross_decay(GrossKind kind, int k);

/// Adds the errors to trials first_trial, first_trial + 1, ... (a multiple of kGroup) of `readings`. `frames`: of every
/// station nine numbers: magnetic north, east and down, in tool axes. The result says of each trial (spare lanes
/// included) which stations are in error: stations numbers a trial, 1 or 0. Channels gross_choice, gross_size.
std::vector<char> add_gross_errors(const GrossStations& gross, const random::Stream& stream, std::uint64_t first_trial,
                                   const std::vector<double>& frames, survey::ReadingBlock& readings);

}  // namespace surveymc::sensor
