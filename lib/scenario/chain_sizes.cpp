#include "scenario/chain_sizes.h"

#include <cmath>

#include "base/units.h"

namespace surveymc::scenario {
namespace {

chained::ChainSize read_size(config::ConfigReader& c, const std::string& name, const std::string& unit, double random,
                             double walk) {
  const double si = unit == "mg" ? kMilliG : 1;
  const std::string key = "model." + name + ".";
  const config::Range range = config::Range::positive();
  return {
      si * c.number(key + "random_" + unit, range,
                    "one sd of the random error of a reading (of the reference), anew at every station", random),
      si * c.number(key + "walk_" + unit, range, "one sd of the step from station to station", walk),
      si * c.number(key + "offset_" + unit, config::Range::non_negative(),
                    "one sd of the bias at the start, 0: the expected offset of slide 7; of `gravity` and `field` one "
                    "sd of a reference that is observed anew at every station, 0: there is none",
                    0)};
}

}  // namespace

chained::ChainSizes read_chain_sizes(config::ConfigReader& c, const survey::ReferenceField& field,
                                     bool references_anew) {
  chained::ChainSizes s;
  s.accelerometer_xy = read_size(c, "accelerometer_xy", "mg", 0.3, 0.2);
  s.accelerometer_z = read_size(c, "accelerometer_z", "mg", 0.3, 0.2);
  s.magnetometer_xy = read_size(c, "magnetometer_xy", "nT", 80, 50);
  s.magnetometer_z = read_size(c, "magnetometer_z", "nT", 80, 80);
  s.gravity = read_size(c, "gravity", "mg", 0.1, 0.02);
  s.field = read_size(c, "field", "nT", 80, 20);
  for (const char* key : {"model.gravity.offset_mg", "model.field.offset_nT"})  // 0: the default, which results list
    c.require(references_anew || c.number(key, config::Range::non_negative(), config::kMeaningElsewhere, 0) == 0, key,
              "the sd of a reference that is observed anew at every station; here references are chained, and that of "
              "the first station is by random_ and walk_");
  s.gravity_reference = field.gravity;
  s.horizontal = field.total * std::cos(field.dip);
  s.down = field.total * std::sin(field.dip);
  return s;
}

}  // namespace surveymc::scenario
