#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::mwd_drift {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows methods(result.tables, "detection");
  const Rows best = methods.at_largest("p_detected"), worst = methods.at_least("p_detected");
  if (!best.empty())
    answer.say("The drift of {} is detected in {} of the runs by {}; {} detects that of {} in {}.",
               {best.word("sensor"), best.figure("p_detected").percent(), best.word("method"), worst.word("method"),
                worst.word("sensor"), worst.figure("p_detected").percent()});
  answer.say_verdicts(Rows(result.tables, "claims"), "claims for the filter", "The claim");
  answer.say_verdicts(Rows(result.tables, "comparison"), "statistics of the filter", "Its prediction");
}

}  // namespace surveymc::studies::mwd_drift
