#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::clearance {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows factors = Rows(result.tables, "least").where("quantity", "separation_factor");
  const Rows least = factors.at_least("continuous");
  if (least.empty()) {
    answer.say("No pair of wells has a separation factor: there is no covariance, or nothing stands opposite.");
    return;
  }
  answer.say("The least separation factor is {} at {}, {} from {}, by errors taken as {}{}: the rule is {}.",
             {least.figure("continuous"), least.figure("ref_md_m"), least.figure("distance_m"), least.word("offset"),
              least.word("formulation"), least.point(), least.word("rule")});
  const Rows same_pair = factors.where("offset", least.word("offset"));
  const Rows mildest = same_pair.at_largest("continuous");
  if (same_pair.words("formulation").size() > 1)
    answer.say("What the wells share decides how much: the factor is up to {} with errors taken as {}.",
               {mildest.figure("continuous"), mildest.word("formulation")});
  const Rows broken = factors.where("rule", "broken");
  if (!broken.empty()) answer.say("{} of {} least factors break the rule.", {broken.count(), factors.count()});
  answer.say_verdicts(Rows(result.tables, "relative_position"), "spreads of the relative position");
}

}  // namespace surveymc::studies::clearance
