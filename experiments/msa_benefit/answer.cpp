#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::msa_benefit {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  if (const Rows sets(result.tables, "summary"); sets.has("learnt_least")) {
    const Rows least = sets.at_least("learnt_least"), most = sets.at_largest("learnt_most");
    answer.say(
        "In the direction that tells least a run knows {} combinations of {} parameters better than its priors do{}, "
        "in "
        "the one that tells most {} of {}{}.",
        {least.figure("learnt_least"), least.figure("size"), least.point(), most.figure("learnt_most"),
         most.figure("size"), most.point()});
    return;
  }
  const Rows azimuth = Rows(result.tables, "summary").where("quantity", "azimuth");
  const Rows least = azimuth.at_least("worse_share"), most = azimuth.at_largest("worse_share");
  const Rows best = azimuth.at_least("ratio_best"), worst = azimuth.at_largest("ratio_worst");
  if (!least.empty() && azimuth.size() == 1)
    answer.say("Multi-station analysis makes the azimuth worse, or fails, in {} of {} directions of the hole.",
               {least.figure("worse_share").percent(), least.figure("directions")});
  if (!least.empty() && azimuth.size() > 1)
    answer.say(
        "Multi-station analysis makes the azimuth worse, or fails, in {} of the directions of the hole{}, and in {} of "
        "them{}.",
        {least.figure("worse_share").percent(), least.point(), most.figure("worse_share").percent(), most.point()});
  if (!best.empty())
    answer.say("Its sd becomes {} times that before at best, and {} times at worst, at inclination {} and azimuth {}.",
               {best.figure("ratio_best"), worst.figure("ratio_worst"), worst.figure("worst_inclination_deg"),
                worst.figure("worst_azimuth_deg")});
  const Rows orders = Rows(result.tables, "order_shares").at_least("first");
  if (!orders.empty())
    answer.say("First order suffices for its lateral sd in {} of the directions{}; {} need trials.",
               {orders.figure("first").percent(), orders.point(), orders.figure("sample").percent()});
  const Rows verification(result.tables, "verification");
  if (verification.has("formulation")) {
    answer.say_formulations(verification, "means and standard deviations");
  } else {
    answer.say_verdicts(verification, "standard deviations", "First-order theory");
  }
}

}  // namespace surveymc::studies::msa_benefit
