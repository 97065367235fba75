#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::tool_code_map {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows tools(result.tables, "summary");
  const Rows best = tools.at_least("sd_lateral_median_m"), worst = tools.at_largest("sd_lateral_median_m");
  if (best.empty()) {
    answer.say("No error model has a covariance in any of these directions.");
    return;
  }
  answer.say(
      "Of {} error models {}{} is best across the hole: {} in the median of the directions, and at most {} (one "
      "sigma).",
      {tools.count(), best.word("error_model"), best.point(), best.figure("sd_lateral_median_m"),
       best.figure("sd_lateral_largest_m")});
  if (tools.size() > 1)
    answer.say("{}{} is worst: {} in the median, and at most {}.",
               {worst.word("error_model"), worst.point(), worst.figure("sd_lateral_median_m"),
                worst.figure("sd_lateral_largest_m")});
}

}  // namespace surveymc::studies::tool_code_map
