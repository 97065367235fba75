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
  if (const Rows orders(result.tables, "orders"); orders.has("order")) {
    answer.say("Of {} components of the last position, first order suffices for {}, second order for {} more.",
               {orders.count(), orders.where("order", "first").count(), orders.where("order", "second").count()});
    const Rows jump = orders.between("jump_probability", 1e-12, 1).at_largest("jump_probability");
    if (!jump.empty())
      answer.say(
          "With a probability of {} the estimate goes over to another minimum, which moves the {} error by {}{}.",
          {jump.figure("jump_probability"), jump.word("quantity"), jump.figure("jump_m"), jump.point()});
  }
  answer.say_verdicts(joint, "spreads of the position", "The joint prediction");
}

}  // namespace surveymc::studies::msa_position
