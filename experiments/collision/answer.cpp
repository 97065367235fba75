#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::collision {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows all(result.tables, "probability");
  const Rows likely = all.at_largest("monte_carlo"), rare = all.at_least("monte_carlo");
  if (likely.empty()) {
    answer.say("No probability was found.");
    return;
  }
  answer.say(
      "The reference well touches {} with a probability of {} ({} to {}), where the separation factor is {}, by "
      "errors taken as {}{}.",
      {likely.word("offset"), likely.figure("monte_carlo"), likely.figure("monte_carlo_ci_low"),
       likely.figure("monte_carlo_ci_high"), likely.figure("separation_factor"), likely.word("correlation"),
       likely.point()});
  if (rare.number("monte_carlo") < likely.number("monte_carlo"))
    answer.say("The least of these probabilities is {}, with {} and errors taken as {}.",
               {rare.figure("monte_carlo"), rare.word("offset"), rare.word("correlation")});
  answer.say_formulations(all, "the probability");
}

}  // namespace surveymc::studies::collision
