#include "compare/answer.h"
#include "events/event_study.h"
#include "store/result_file.h"

namespace surveymc::studies::error_model_monte_carlo {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows position(result.tables, "position");
  if (position.empty()) {
    events::say_probabilities(answer, result);
    return;
  }
  const Rows ellipse = Rows(result.tables, "ellipse").where("formulation", "monte_carlo").at_largest("semi_major_m");
  if (!ellipse.empty())
    answer.say(
        "At {}{} the drawn errors spread the position over an ellipse of {} by {} (one sigma), the long axis "
        "towards {}.",
        {ellipse.figure("md_m"), ellipse.point(), ellipse.figure("semi_major_m"), ellipse.figure("semi_minor_m"),
         ellipse.figure("major_azimuth_deg")});
  answer.say_formulations(position, "the standard deviations");
}

}  // namespace surveymc::studies::error_model_monte_carlo
