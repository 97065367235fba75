#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::drift_monitoring {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows delays = Rows(result.tables, "delay").with("delay_q50_h");
  const Rows fastest = delays.at_least("delay_q50_h"), slowest = delays.at_largest("delay_q50_h");
  if (!fastest.empty())
    answer.say("A drift of {} is found after {} in the median by {}{}; the slowest is {} on {}, after {}.",
               {fastest.word("sensor"), fastest.figure("delay_q50_h"), fastest.word("architecture"), fastest.point(),
                slowest.word("architecture"), slowest.word("sensor"), slowest.figure("delay_q50_h")});
  const Rows blame(result.tables, "blame");
  const Rows worst = blame.at_largest("p_healthy_blamed"), best = blame.at_least("p_healthy_blamed");
  if (!best.empty())
    answer.say("A healthy sensor is blamed in {} of the runs by {}, and in {} by {}.",
               {best.figure("p_healthy_blamed").percent(), best.word("architecture"),
                worst.figure("p_healthy_blamed").percent(), worst.word("architecture")});
  answer.say_verdicts(Rows(result.tables, "claims"), "statements", "What the source says");
}

}  // namespace surveymc::studies::drift_monitoring
