#include "events/event_sampling.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "base/units.h"

using namespace surveymc;
using namespace surveymc::compare;
using namespace surveymc::events;

namespace {

/// Beyond 2 along the first normal; no result where the second is above `edge`.
class LostBeyond final : public rare::LimitState {
 public:
  explicit LostBeyond(double edge) : edge_(edge) {}
  int dimension() const override { return 2; }
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override {
    for (int t = 0; t < groups * simd::kGroup; ++t) g[t] = z.value(t, 1) > edge_ ? kNaN : 2 - z.value(t, 0);
  }

 private:
  double edge_;
};

EventEstimate by_subsets(double edge, stats::Tally* tally = nullptr) {
  const stats::Tally t = rare::run_subset_replicates(LostBeyond(edge), random::Stream(3, 27), 0, 20, 500);
  if (tally) *tally = t;
  return estimate_event({.method = "subset"}, t, {}, 0.95, 2);
}

}  // namespace

TEST_CASE("Evaluations of subset simulation without a result are weighed, and too many of them are not trusted") {
  stats::Tally tally;
  const EventEstimate all = by_subsets(9, &tally);
  CHECK(all.trusted);
  CHECK(all.note.empty());
  CHECK(tally.failed == 0);
  // P(z2 > 2) = P(z1 > 2): as many trials have no result as there are hits. 20 x 500 first samples: sd 7 %.
  const EventEstimate half = by_subsets(2, &tally);
  CHECK_FALSE(half.trusted);
  CHECK(half.note.find("evaluations without a result weigh ") != std::string::npos);
  CHECK(tally.counts[rare::kLostEvaluations] > 0);
  CHECK(tally.failed == 20);
  // The larger of both levels of a replicate: 11 +- 3 of 500, or about 7 % of that more.
  CHECK(tally.moments.mean[1] == Approx(0.0228).epsilon(0.25));
  // P(z2 > 4) is 1.4e-3 of the hits: less than one per cent.
  CHECK(by_subsets(4).trusted);
}

TEST_CASE("Subset simulation has no count of hits, and its rows count the replicates without a result") {
  TableRows t("sampling", "");
  put_sampling(t, {.method = "subset"}, by_subsets(2));
  const store::Table table = t.take();
  for (const char* column : {"hits", "effective_hits", "largest_share"}) CHECK(std::isnan(table.number(column, 0)));
  stats::Tally all, one = rare::run_subset_replicates(LostBeyond(2), random::Stream(3, 27), 0, 1, 500);
  all.trials = 1;
  for (int event_number = 0; event_number < 2; ++event_number) {
    all.groups.push_back(one.moments);
    all.counts.insert(all.counts.end(), one.counts.begin(), one.counts.end());
    one.counts[rare::kLostReplicates] = 0;
  }
  CHECK(rare::subset_part(all, 0).failed == 1);
  CHECK(rare::subset_part(all, 1).failed == 0);
  CHECK(rare::subset_part({}, 1).moments.count == 0);
}
