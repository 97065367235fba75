#include "compare/answer.h"
#include "events/event_study.h"
#include "store/result_file.h"

namespace surveymc::studies::chained_multistation {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows errors = Rows(result.tables, "rms").where("quantity", "azimuth_deg");
  const Rows single = errors.where("formulation", "single").first(),
             all = errors.where("formulation", "smoother").first();
  if (!single.empty() && !all.empty())
    answer.say("The RMS error of the azimuth is {} by single stations, and {} by the smoother over the whole run{}.",
               {single.figure("monte_carlo"), all.figure("monte_carlo"), all.point()});
  answer.say_verdicts(Rows(result.tables, "consistency"), "statistics", "What the covariances claim");

  const Rows disturbed = Rows(result.tables, "interference").where("quantity", "azimuth_deg");
  const Rows ignored = disturbed.where("formulation", "ignored").first();
  const Rows least = disturbed.without("formulation", "undisturbed").at_least("monte_carlo");
  if (!ignored.empty())
    answer.say("Where the field is disturbed, the RMS error of the azimuth is {} if that is ignored, and {} with {}.",
               {ignored.figure("monte_carlo"), least.figure("monte_carlo"), least.word("formulation")});
  answer.say_verdicts(Rows(result.tables, "interference"), "RMS errors");

  const Rows readings(result.tables, "outliers");
  const Rows detected = readings.where("quantity", "detected"), right = readings.where("quantity", "reading_right");
  if (!detected.empty() && !right.empty())
    answer.say("The gross error{} is found in {} of the runs, and the right reading is blamed in {}.",
               {detected.point(), detected.figure("monte_carlo").percent(), right.figure("monte_carlo").percent()});

  const Rows starts = Rows(result.tables, "unstart").where("quantity", "higher_minimum");
  const Rows worst = starts.at_largest("monte_carlo"), best = starts.at_least("monte_carlo");
  if (worst.number("monte_carlo") == 0)
    answer.say("No solution ended in a higher minimum.");
  else if (!worst.empty())
    answer.say("{} ends in a higher minimum in {} of the runs, {} in {}.",
               {worst.word("formulation"), worst.figure("monte_carlo").percent(), best.word("formulation"),
                best.figure("monte_carlo").percent()});
  events::say_probabilities(answer, result);
}

}  // namespace surveymc::studies::chained_multistation
