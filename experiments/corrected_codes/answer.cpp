#include <string>
#include <vector>

#include "compare/answer.h"
#include "store/result_file.h"

namespace surveymc::studies::corrected_codes {

using compare::Phrase;
using compare::Rows;

namespace {

std::string in_words(const std::string& correction) {
  if (correction == "none") return "no correction";
  if (correction == "msa") return "six parameters (msa)";
  if (correction == "msa3") return "three biases (msa3)";
  return correction;
}

/// `item` behind those that `list` has; nothing is in it as long as it is empty.
void add(Phrase& list, const Phrase& item) { list = list.text.empty() ? item : Phrase("{}, {}", {list, item}); }

/// The ratio of the trials where there are some, else that of first order, and the verdict by it.
struct Columns {
  std::string ratio, verdict, before;
  explicit Columns(const Rows& claims)
      : ratio(claims.with("ratio").empty() ? "predicted_ratio" : "ratio"),
        verdict(claims.with("ratio").empty() ? "predicted_verdict" : "claim"),
        before(ratio + "_before") {}
};

/// One well with one correction.
void say_correction(compare::Answer& answer, const Rows& lateral, const Columns& of, const std::string& code) {
  const std::string verdict = lateral.word(of.verdict);
  const char* const holds = verdict == "holds" ? "holds" : verdict == "broken" ? "does not hold" : "is undecided";
  answer.say("{} {} on this well with {}: the lateral sd is {} of what is claimed, {} before the correction.",
             {code, holds, in_words(lateral.word("correction")), lateral.figure(of.ratio), lateral.figure(of.before)});
}

/// One well with several corrections: those that hold, and those that do not.
void say_corrections(compare::Answer& answer, const Rows& lateral, const Columns& of, const std::string& code) {
  Phrase holds(""), broken(""), open("");
  for (const std::string& correction : lateral.words("correction")) {
    const Rows row = lateral.where("correction", correction);
    const std::string verdict = row.word(of.verdict);
    const Phrase item("{} with {}", {row.figure(of.ratio), in_words(correction)});
    add(verdict == "holds"    ? holds
        : verdict == "broken" ? broken
                              : open,
        verdict == "undetermined" ? Phrase("undetermined with {}", {in_words(correction)}) : item);
  }
  const char* const ratio_is = "the lateral sd over what is claimed is";
  if (!broken.text.empty()) answer.say("{} does not hold on this well: {} {}.", {code, ratio_is, broken});
  if (!holds.text.empty()) answer.say("{} holds on this well: {} {}.", {code, ratio_is, holds});
  if (!open.text.empty()) answer.say("It cannot be told whether {} holds on this well: {}.", {code, open});
}

/// Many wells: how often each correction does not hold.
void say_wells(compare::Answer& answer, const Rows& lateral, const Columns& of, const std::string& code) {
  Phrase counts("");
  for (const std::string& correction : lateral.words("correction")) {
    const Rows rows = lateral.where("correction", correction);
    add(counts, Phrase("{} of {} with {}", {rows.where(of.verdict, "broken").count(),
                                            rows.without(of.verdict, "undetermined").count(), in_words(correction)}));
  }
  answer.say("The lateral sd is beyond what {} claims at so many of the points where it can be told: {}.",
             {code, counts});
}

}  // namespace

void answer(compare::Answer& answer, const store::Result& result) {
  const std::vector<std::string> codes = Rows(result.tables, "validity").words("claimed");
  const std::string code = codes.size() == 1 ? codes.front() : "the corrected code";
  const Rows claims = Rows(result.tables, "claims").where("scope", "magnetic");
  const Columns of(claims);
  const Rows lateral = claims.where("quantity", "lateral");
  const bool one_well = lateral.size() == lateral.words("correction").size();
  const Rows determined = lateral.without(of.verdict, "undetermined"),
             corrected = determined.without("correction", "none");
  const Rows worst = (corrected.empty() ? determined : corrected).at_largest(of.ratio);
  if (worst.empty() && !lateral.empty()) answer.say("No correction is determined by the stations of this well.");
  if (!worst.empty() && lateral.size() == 1) say_correction(answer, lateral, of, code);
  if (!worst.empty() && lateral.size() > 1 && one_well) say_corrections(answer, lateral, of, code);
  if (!worst.empty() && lateral.size() > 1 && !one_well) say_wells(answer, lateral, of, code);
  const Rows azimuth = claims.where("quantity", "azimuth").where("correction", worst.word("correction"));
  if (one_well && !worst.empty() && !azimuth.empty())
    answer.say("The azimuth is beyond what is claimed at {} of {} stations with {}.",
               {azimuth.where(of.verdict, "broken").count(), azimuth.count(), in_words(worst.word("correction"))});
  const Rows budget = Rows(result.tables, "budget").where("quantity", "lateral");
  const Rows decides = (one_well ? budget.where("correction", worst.word("correction")) : budget).at_largest("share");
  if (!decides.empty())
    answer.say("What decides most is {}, with {} of the variance, with {}{}.",
               {decides.word("input"), decides.figure("share").percent(), in_words(decides.word("correction")),
                one_well ? Phrase("") : decides.point()});
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
