#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::corrected_codes {

using compare::Rows;

namespace {

/// What this correction does at a point: the ratio of the trials where there are some, else that of first order.
void say_lateral(compare::Answer& answer, const Rows& claims, const std::string& code) {
  const bool drawn = !claims.with("ratio").empty();
  const std::string ratio = drawn ? "ratio" : "predicted_ratio", verdict = drawn ? "claim" : "predicted_verdict";
  const Rows all = claims.where("quantity", "lateral").where("scope", "magnetic"),
             lateral = all.without(verdict, "undetermined");
  const Rows best = lateral.at_least(ratio), worst = lateral.at_largest(ratio);
  if (best.empty()) {
    if (!all.empty()) answer.say("No correction is determined by the stations of this well.");
    return;
  }
  const auto holds = [&](const Rows& row) {
    const std::string word = row.word(verdict);
    return word == "holds" ? "holds" : word == "broken" ? "does not hold" : "is " + word;
  };
  if (lateral.size() == 1) {
    answer.say(
        "{} {} on this well with correction {}: the lateral sd is {} of what is claimed, {} before the correction.",
        {code, holds(best), best.word("correction"), best.figure(ratio),
         best.figure(drawn ? "ratio_before" : "predicted_ratio_before")});
    const Rows azimuth = claims.where("quantity", "azimuth").where("scope", "magnetic");
    if (!azimuth.empty())
      answer.say("The azimuth is beyond what is claimed at {} of {} stations.",
                 {azimuth.where(verdict, "broken").count(), azimuth.count()});
    return;
  }
  answer.say("{} {} at best, with correction {}{}: the lateral sd is {} of what is claimed.",
             {code, holds(best), best.word("correction"), best.point(), best.figure(ratio)});
  answer.say("It {} at worst, with correction {}{}: {} of what is claimed, {} before the correction.",
             {holds(worst), worst.word("correction"), worst.point(), worst.figure(ratio),
              worst.figure(drawn ? "ratio_before" : "predicted_ratio_before")});
}

}  // namespace

void answer(compare::Answer& answer, const store::Result& result) {
  const Rows validity(result.tables, "validity");
  const std::string code = validity.first().word("claimed");
  say_lateral(answer, Rows(result.tables, "claims"), code);
  const Rows decides = Rows(result.tables, "budget").where("quantity", "lateral").at_largest("share");
  if (!decides.empty())
    answer.say("What decides most is {}, with {} of the variance, under correction {}{}.",
               {decides.word("input"), decides.figure("share").percent(), decides.word("correction"), decides.point()});
  const Rows shares(result.tables, "shares");
  if (!shares.empty()) {
    const Rows most = shares.at_largest("broken");
    answer.say(
        "Of the map {} keep the claim by the correction{}, {} break it, and {} would hold without "
        "one.",
        {most.figure("kept").percent(), most.point(), most.figure("broken").percent(), most.figure("free").percent()});
  }
}

}  // namespace surveymc::studies::corrected_codes
