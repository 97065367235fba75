#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::axial_correction {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows methods(result.tables, "failures");
  const Rows best = methods.at_least("share_sd"), worst = methods.at_largest("share_sd");
  if (!best.empty())
    answer.say("The azimuth is worse than {} (one sigma) in {} of the attitudes with {}{}, and in {} with {}{}.",
               {best.figure("tolerance_deg"), best.figure("share_sd").percent(), best.word("method"), best.point(),
                worst.figure("share_sd").percent(), worst.word("method"), worst.point()});
  answer.say_verdicts(Rows(result.tables, "verification"), "spreads at single attitudes", "First-order theory");
}

}  // namespace surveymc::studies::axial_correction
