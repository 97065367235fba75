#include "compare/answer.h"
#include "events/event_study.h"
#include "store/result_file.h"

namespace surveymc::studies::msa_position {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows position(result.tables, "position_hla");
  if (position.empty()) {
    events::say_probabilities(answer, result);
    return;
  }
  const Rows joint = position.where("formulation", "joint");
  const Rows lateral = joint.where("quantity", "sigma3_lateral").at_largest("monte_carlo");
  const auto at = [&](const char* quantity) { return joint.where("quantity", quantity).at_point_of(lateral); };
  if (!lateral.empty())
    answer.say(
        "After the correction the last position is known to {} across the hole, {} along its high side and {} "
        "along it, at three sigma{}.",
        {lateral.figure("monte_carlo"), at("sigma3_high_side").figure("monte_carlo"),
         at("sigma3_along_hole").figure("monte_carlo"), lateral.point()});
  answer.say_formulations(position, "the spread of the position");
  answer.say_verdicts(joint, "spreads of the position", "The joint prediction");
}

}  // namespace surveymc::studies::msa_position
