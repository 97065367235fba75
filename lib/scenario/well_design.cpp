#include "scenario/well_design.h"

#include <fmt/format.h>

#include "base/units.h"

namespace surveymc::scenario {

analysis::WellDesign read_well_design(config::ConfigReader& c, random::StudySeed seed) {
  analysis::WellDesign w;
  w.seed = seed;
  w.kind = c.choice("well.kind", {"straight", "building"},
                    "'straight': one direction; 'building': vertical, then at the build rate to the last station") ==
                   "building"
               ? analysis::WellKind::building
               : analysis::WellKind::straight;
  w.stations = static_cast<int>(c.integer("well.stations", 2, 10000, "stations that MSA uses"));
  w.spacing = c.number("well.spacing_m", config::Range{0, 1000, true, false},
                       "distance of the stations; random errors depend on it", 30);
  // Given but unused values stay allowed, so that `kind` can be swept.
  const double per_30m =
      c.number("well.build_rate_deg_per_30m", config::Range{0, 90, true, false}, "build rate of the building well", 3);
  if (w.kind == analysis::WellKind::building) {
    w.build_rate = per_30m * kDegree / 30;
    c.require(w.build_rate * w.spacing <= kPi / 2, "well.build_rate_deg_per_30m",
              fmt::format("with well.spacing_m = {} there is more than 90 deg between two stations", w.spacing));
  }
  const std::string toolface = c.choice(
      "well.toolface", {"even", "random", "constant"},
      "'even': turns by 137.50776 deg a station; 'random': by the seed, the same for all directions; 'constant'",
      "even");
  w.toolface = toolface == "random"     ? analysis::ToolfaceSequence::random
               : toolface == "constant" ? analysis::ToolfaceSequence::constant
                                        : analysis::ToolfaceSequence::even;
  if (w.toolface == analysis::ToolfaceSequence::random && !c.has("seed"))
    c.fail("well.toolface", "\"random\" is drawn by the config's seed: give it, in the file's first lines");
  return w;
}

}  // namespace surveymc::scenario
