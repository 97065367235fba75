#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::vertical_well {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows ellipses(result.tables, "ellipse");
  const Rows at = ellipses.where("formulation", "monte_carlo").at_largest("semi_major_m");
  if (!at.empty())
    answer.say("The cross-axis bias spreads the last position over an ellipse of {} by {} (one sigma){}.",
               {at.figure("semi_major_m"), at.figure("semi_minor_m"), at.point()});
  answer.say_formulations(ellipses, "the ellipse");
}

}  // namespace surveymc::studies::vertical_well
