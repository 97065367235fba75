#include <string>

#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::robustness_map {

using compare::Phrase;
using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows all(result.tables, "breakdown");
  const Rows most = all.at_point_of(all.at_largest("wrong").first());
  const auto ratio = [](const Rows& of, const char* loss) { return of.where("loss", loss).figure("ratio"); };
  const Rows plain = most.where("loss", "least_squares");
  if (plain.empty()) return;
  answer.say(
      "With {} of {} stations wrong{}, least squares leaves {} times the error of a fit that knows the right stations.",
      {most.first().figure("wrong"), most.first().figure("stations"), most.point(), ratio(most, "least_squares")});
  Phrase robust("");
  for (const char* loss : {"l1", "huber", "cauchy", "tukey"}) {
    if (most.where("loss", loss).empty()) continue;
    const Phrase item("{} times with {}", {ratio(most, loss), std::string(loss)});
    robust = robust.text.empty() ? item : Phrase("{}, {}", {robust, item});
  }
  if (!robust.text.empty()) answer.say("Robust losses: {}.", {robust});
  answer.say_verdicts(Rows(result.tables, "prediction"), "values");
}

}  // namespace surveymc::studies::robustness_map
