#include "study/tally_sizes.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/error.h"

namespace surveymc::study {
namespace {

[[noreturn]] void refuse(const std::string& whose) {
  throw IoError(
      fmt::format("{}: its tallies have other sizes than trials of this config: of another build, or damaged; remove "
                  "it, and run it again",
                  whose));
}

}  // namespace

TallySizes::TallySizes(const StudyPoint& point, std::uint64_t trials) {
  if (trials > 0) ours_ = point.run_block({0, static_cast<int>(std::min(trials, kTrials))});
  ours_.proposal = 0;  // require_proposal() has the words for that
}

void TallySizes::require(const stats::Tally& part, const std::string& whose) const {
  if (!stats::can_merge(ours_, part)) refuse(whose);
}

void TallySizes::require_whole(const stats::Tally& whole, const std::string& whose) const {
  const auto covers = [](const auto& a, const auto& b) { return a.size() >= b.size(); };
  const auto holds = [](const stats::Moments& a, const stats::Moments& b) { return a.count > 0 || b.count == 0; };
  const bool is_whole = stats::can_merge(ours_, whole) && holds(whole.moments, ours_.moments) &&
                        holds(whole.pairs, ours_.pairs) && covers(whole.groups, ours_.groups) &&
                        covers(whole.controlled, ours_.controlled) &&
                        covers(whole.controlled_pairs, ours_.controlled_pairs) && covers(whole.counts, ours_.counts) &&
                        covers(whole.weighted, ours_.weighted);
  if (!is_whole) refuse(whose);
}

}  // namespace surveymc::study
