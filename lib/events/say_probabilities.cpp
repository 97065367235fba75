#include "events/event_study.h"

namespace surveymc::events {

using compare::Rows;

void say_probabilities(compare::Answer& answer, const store::Result& result) {
  const Rows all(result.tables, "probability");
  const Rows rarest = all.at_least("monte_carlo"), likeliest = all.at_largest("monte_carlo");
  if (rarest.empty()) {
    if (!all.empty()) answer.say("No event has happened, so that none has a probability.");
    return;
  }
  answer.say("The event \"{}\" has a probability of {} ({} to {}){}.",
             {rarest.word("event"), rarest.figure("monte_carlo"), rarest.figure("monte_carlo_ci_low"),
              rarest.figure("monte_carlo_ci_high"), rarest.point()});
  if (likeliest.number("monte_carlo") > rarest.number("monte_carlo"))
    answer.say("The likeliest event is \"{}\", with {}{}.",
               {likeliest.word("event"), likeliest.figure("monte_carlo"), likeliest.point()});
  const Rows sampling(result.tables, "sampling"), doubtful = sampling.between("trusted", 0, 0);
  if (!doubtful.empty())
    answer.say("{} of {} probabilities are not to be trusted: see the notes of table sampling.",
               {doubtful.count(), sampling.count()});
  answer.say_formulations(all, "the probability");
}

}  // namespace surveymc::events
