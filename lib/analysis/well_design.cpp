#include "analysis/well_design.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "random/study_stream.h"

namespace surveymc::analysis {
namespace {

double toolface(const WellDesign& w, int station) {
  switch (w.toolface) {
    case ToolfaceSequence::even:
      return std::fmod(station * kPi * (3 - std::sqrt(5.0)), 2 * kPi);
    case ToolfaceSequence::random: {  // the study's trials draw nothing of this channel
      const auto call = static_cast<std::uint32_t>(station / 4);
      return 2 * kPi *
             random::stream_of(w.seed).uniforms<double>(0, random::Channel::toolface,
                                                        call)[static_cast<std::size_t>(station % 4)];
    }
    case ToolfaceSequence::constant:
      break;
  }
  return 0;
}

}  // namespace

survey::Survey make_well(const WellDesign& w, double inclination, double azimuth) {
  survey::Survey survey;
  for (int k = 0; k < w.stations; ++k) {
    const double to_go = (w.stations - 1 - k) * w.spacing;
    const double built = w.kind == WellKind::building ? w.build_rate * to_go : 0;
    survey.stations.push_back({k * w.spacing, std::max(0.0, inclination - built), azimuth, toolface(w, k)});
  }
  return survey;
}

}  // namespace surveymc::analysis
