#include "compare/answer.h"
#include "events/event_study.h"
#include "store/result_file.h"

namespace surveymc::studies::gross_error_detection {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows all(result.tables, "detection");
  if (all.empty()) {
    events::say_probabilities(answer, result);
    return;
  }
  const Rows found = all.where("quantity", "detection_any"), named = all.where("quantity", "identified");
  const Rows least_found = found.at_least("monte_carlo"), least_named = named.at_least("monte_carlo");
  if (!least_found.empty())
    answer.say(
        "The gross error is found in {} to {} of the runs.",
        {least_found.figure("monte_carlo").percent(), found.at_largest("monte_carlo").figure("monte_carlo").percent()});
  if (!least_named.empty())
    answer.say(
        "The wrong reading alone is blamed in {} to {} of the runs: to find is not to identify.",
        {least_named.figure("monte_carlo").percent(), named.at_largest("monte_carlo").figure("monte_carlo").percent()});
  answer.say_verdicts(all, "shares of runs");
}

}  // namespace surveymc::studies::gross_error_detection
