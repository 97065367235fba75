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
  answer.say("The least separation factor is {} at {}, {} from {}, with {} errors{}: the rule is {}.",
             {least.figure("continuous"), least.figure("ref_md_m"), least.figure("distance_m"), least.word("offset"),
              least.word("formulation"), least.point(), least.word("rule")});
  const Rows nearest = Rows(result.tables, "least").where("quantity", "distance").at_least("continuous");
  if (!nearest.empty())
    answer.say("The wells come as near as {}, at {}, to {}.",
               {nearest.figure("continuous"), nearest.figure("ref_md_m"), nearest.word("offset")});
  const Rows same_pair = factors.where("offset", least.word("offset")).at_point_of(least);
  const Rows mildest = same_pair.at_largest("continuous");
  constexpr double kSame = 1.005;  // the same three digits, nearly
  if (mildest.number("continuous") > kSame * least.number("continuous"))
    answer.say("What the wells share decides how much: the factor is {} with {} errors.",
               {mildest.figure("continuous"), mildest.word("formulation")});
  answer.say_verdicts(Rows(result.tables, "relative_position"), "spreads of the relative position");
}

}  // namespace surveymc::studies::clearance
