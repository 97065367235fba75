#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::reliability {

using compare::Rows;

void map_answer(compare::Answer& answer, const store::Result& result) {
  const Rows summary(result.tables, "summary");
  Rows azimuth = summary.where("quantity", "external_azimuth_deg");
  if (azimuth.empty()) azimuth = summary.where("quantity", "effect_azimuth_deg");
  const Rows worst = azimuth.at_largest("maximum");
  if (!worst.empty())
    answer.say(
        "An error of {} that the tests just miss turns the azimuth by up to {}, at inclination {} and magnetic "
        "azimuth {}; in the median by {}{}.",
        {worst.word("observation"), worst.figure("maximum"), worst.figure("maximum_inclination_deg"),
         worst.figure("maximum_magnetic_azimuth_deg"), worst.figure("median"), worst.point()});
  const Rows hidden = azimuth.at_largest("infinite");
  if (hidden.number("infinite") > 0)
    answer.say("At {} of {} points of the map no error of {} can be found, however large{}.",
               {hidden.figure("infinite"), hidden.figure("points"), hidden.word("observation"), hidden.point()});
  const Rows tolerance = Rows(result.tables, "tolerance").at_least("share_both");
  if (!tolerance.empty())
    answer.say("Undetected errors of {} stay within the tolerances at {} of the points{}.",
               {tolerance.word("observation"), tolerance.figure("share_both").percent(), tolerance.point()});
  answer.say_verdicts(Rows(result.tables, "statements"), "statements of the publication", "What was published");
}

void well_answer(compare::Answer& answer, const store::Result& result) {
  const Rows stations = Rows(result.tables, "worst_stations");
  const Rows worst = stations.at_largest("position_m");
  if (worst.empty()) {
    answer.say("Every station has an error that no test finds, however large.");
    return;
  }
  answer.say("The worst undetected error is that of {} at {}: {} there moves the end of the well by {}{}.",
             {worst.word("observation"), worst.figure("md_m"), worst.figure("minimal_detectable_error"),
              worst.figure("position_m"), worst.point()});
  const Rows everywhere = Rows(result.tables, "systematic").at_largest("position_m");
  if (!everywhere.empty())
    answer.say("The same error at all stations is found from {} of {} on, and moves the end by {}.",
               {everywhere.figure("minimal_detectable_error"), everywhere.word("observation"),
                everywhere.figure("position_m")});
}

}  // namespace surveymc::studies::reliability
