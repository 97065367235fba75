#include <cmath>

#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::estimate {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows stations = Rows(result.tables, "stations").with("sd_azimuth_deg");
  const Rows last = stations.last();
  const Rows corrected = stations.at_largest("azimuth_change_deg", [](double x) { return std::abs(x); });
  if (!last.empty())
    answer.say("At {}{} the azimuth is {} from magnetic north, with an sd of {}.",
               {last.figure("md_m"), last.point(), last.figure("azimuth_magnetic_deg"), last.figure("sd_azimuth_deg")});
  const double sign = corrected.number("azimuth_change_deg") < 0 ? -1 : 1;
  if (!corrected.empty())
    answer.say("The correction turns the azimuth by at most {}, at {}{}.",
               {corrected.figure("azimuth_change_deg").times(sign), corrected.figure("md_m"), corrected.point()});
  const Rows tests(result.tables, "tests"), rejected = tests.where("decision", "rejected");
  if (!tests.empty()) answer.say("{} of {} tests of the readings reject.", {rejected.count(), tests.count()});
  const Rows suspect = Rows(result.tables, "suspect_readings").where("judgement", "most likely").first();
  if (!suspect.empty())
    answer.say("The reading {} at {}{} is most likely wrong, by {}.",
               {suspect.word("reading"), suspect.figure("md_m"), suspect.point(), suspect.figure("error")});
}

}  // namespace surveymc::studies::estimate
