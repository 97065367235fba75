#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::sensor_monte_carlo {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows ellipses(result.tables, "ellipse"), axes(result.tables, "axes");
  const Rows at = ellipses.where("formulation", "monte_carlo").at_largest("semi_major_m");
  if (!at.empty())
    answer.say("At {}{} constant sensor errors spread the position over an ellipse of {} by {} (one sigma).",
               {at.figure("md_m"), at.point(), at.figure("semi_major_m"), at.figure("semi_minor_m")});
  answer.say_formulations(axes, "spreads along the axes");
}

}  // namespace surveymc::studies::sensor_monte_carlo
