#include "compare/verdict_stop.h"
#include "config/meanings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace surveymc::compare {
namespace {

constexpr double kHeavyTail = 0.1;  // of the figure of merit

/// Of whichever moments a study keeps.
std::uint64_t units_of(const stats::Tally& tally) {
  if (tally.pairs.count > 0) return tally.pairs.count;
  if (tally.moments.count > 0) return tally.moments.count;
  for (const auto* list : {&tally.controlled_pairs, &tally.controlled, &tally.groups})
    if (!list->empty() && list->front().count > 0) return list->front().count;
  return 0;
}

stats::Moments number_of_events(std::uint64_t events) {
  stats::Moments m;
  m.count = events;
  return m;
}

}  // namespace

TrialPlan read_verdict_plan(config::ConfigReader& c, const std::vector<Row>& rows, VerdictRule& verdict,
                            const TrialLimits& limits) {
  if (c.has("stop")) {
    TrialPlan plan = read_trial_plan(c, rows, verdict);
    c.require(plan.trials <= static_cast<std::uint64_t>(limits.most), "stop.max_trials",
              fmt::format("must be at most {}", limits.most));
    return plan;
  }
  TrialPlan plan;
  plan.trials = static_cast<std::uint64_t>(c.integer("trials", limits.fewest, limits.most, config::meaning::kTrials));
  return plan;
}

VerdictStop::VerdictStop(const TrialPlan& plan, const VerdictRule& rule,
                         std::function<RowsOfTables(const stats::Tally&)> rows, const KeptParts& kept)
    : decisive_(plan.decisive), looks_(plan.looks), rule_(rule), rows_(std::move(rows)), kept_(kept) {}

std::size_t VerdictStop::size_of_look() const {
  return 2 + kept_.groups + kept_.controlled + kept_.controlled_pairs + kept_.counts + (kept_.failed ? 2 : 0);
}

void VerdictStop::keep(montecarlo::TrialBlock block, stats::Tally& tally) const {
  if (!is_on()) return;
  const std::uint64_t end = block.first + static_cast<std::uint64_t>(block.count);
  const auto look = static_cast<std::size_t>(std::lower_bound(looks_.begin(), looks_.end(), end) - looks_.begin());
  std::vector<stats::Moments> parts{tally.moments, tally.pairs};
  const auto add = [&](const std::vector<stats::Moments>& list, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) parts.push_back(list.at(i));
  };
  add(tally.groups, kept_.groups);
  add(tally.controlled, kept_.controlled);
  add(tally.controlled_pairs, kept_.controlled_pairs);
  for (std::size_t i = 0; i < kept_.counts; ++i) parts.push_back(number_of_events(tally.counts.at(i)));
  if (kept_.failed) {
    parts.push_back(number_of_events(tally.failed));
    parts.push_back(number_of_events(tally.left_out));
  }
  tally.groups.resize(kept_.own_groups + look * size_of_look());
  tally.groups.insert(tally.groups.end(), parts.begin(), parts.end());
}

stats::Tally VerdictStop::tally_at_look(const stats::Tally& tally, std::size_t look) const {
  stats::Tally at;
  at.trials = std::min(looks_.at(std::min(look, looks_.size() - 1)), tally.trials);
  at.groups.resize(kept_.groups);
  at.controlled.resize(kept_.controlled);
  at.controlled_pairs.resize(kept_.controlled_pairs);
  at.counts.resize(kept_.counts, 0);
  const std::size_t size = size_of_look();
  for (std::size_t part = 0; part <= look && kept_.own_groups + (part + 1) * size <= tally.groups.size(); ++part) {
    auto next = tally.groups.begin() + static_cast<std::ptrdiff_t>(kept_.own_groups + part * size);
    at.moments.merge(*next++);
    at.pairs.merge(*next++);
    for (auto* list : {&at.groups, &at.controlled, &at.controlled_pairs})
      for (stats::Moments& m : *list) m.merge(*next++);
    for (std::uint64_t& events : at.counts) events += (next++)->count;
    if (kept_.failed) {
      at.failed += (next++)->count;
      at.left_out += (next++)->count;
    }
  }
  return at;
}

bool VerdictStop::is_named(const std::string& table, const ComparisonRow& row) const {
  return std::any_of(decisive_.begin(), decisive_.end(), [&](const Row& name) {
    return name.table == table && name.quantity == row.quantity && name.formulation == row.formulation;
  });
}

std::vector<VerdictStop::NamedRow> VerdictStop::named_rows(const stats::Tally& tally) const {
  std::vector<NamedRow> found;
  for (const auto& [table, rows, place] : rows_(tally))
    for (const ComparisonRow& row : rows)
      if (is_named(table, row)) found.push_back({table, row, place});
  return found;
}

double VerdictStop::merit_of(const ComparisonRow& row, const stats::Tally& tally) const {
  const std::uint64_t units = units_of(tally);
  const double half = (row.judged_interval.hi - row.judged_interval.lo) / 2,
               error = half / stats::sequence_quantile(units, rule_.confidence) / row.judged;
  return 1 / (error * error * static_cast<double>(units));
}

std::uint64_t VerdictStop::trials_needed(const stats::Tally& tally) const {
  const auto look =
      static_cast<std::size_t>(std::lower_bound(looks_.begin(), looks_.end(), tally.trials) - looks_.begin());
  std::uint64_t most = tally.trials;
  bool any_verdict = false;
  for (const NamedRow& d : named_rows(tally_at_look(tally, look))) {
    any_verdict = any_verdict || !d.row.verdict.empty();
    if (d.row.verdict == "undecided") most = std::max({most, d.row.trials_to_decide, tally.trials + 1});
  }
  return any_verdict ? most : tally.trials + 1;
}

void VerdictStop::add_notes(const std::string& table, std::vector<ComparisonRow>& rows, const stats::Tally& tally,
                            const std::string& place) const {
  if (!is_on() || std::none_of(rows.begin(), rows.end(), [&](const ComparisonRow& r) { return is_named(table, r); }))
    return;
  std::size_t look = 1;
  while (look < looks_.size() && looks_[look - 1] < tally.trials) ++look;
  const stats::Tally first = tally_at_look(tally, 0);
  const std::vector<NamedRow> before = units_of(first) < 2 ? std::vector<NamedRow>{} : named_rows(first);
  for (ComparisonRow& row : rows) {
    if (!is_named(table, row)) continue;
    const std::string said = row.note;
    row.note = fmt::format("{}{}the run ended at look {} of at most {}{}", said, said.empty() ? "" : "; ", look,
                           looks_.size(), row.verdict.empty() ? ", not by this row, which has no verdict" : "");
    for (const NamedRow& b : before)
      if (kept_.counts == 0 &&  // a rate has no tail, but few events at its first look
          b.table == table && b.place == place && b.row.quantity == row.quantity &&
          b.row.formulation == row.formulation)
        if (const double ratio = merit_of(row, tally) / merit_of(b.row, first); ratio < 1 - kHeavyTail)
          row.note +=
              fmt::format("; figure of merit {:.0f} % below that of the first look: a heavy tail?", 100 * (1 - ratio));
  }
}

store::Table VerdictStop::looks_table(const stats::Tally& tally) const {
  struct LookRow {
    std::size_t look = 0;
    std::uint64_t trials = 0;
    double merit = 0, of_first = 0;
    NamedRow named;
  };
  std::vector<LookRow> rows;
  std::vector<double> of_first;
  for (std::size_t look = 0; look < looks_.size() && looks_[look] <= tally.trials; ++look) {
    const stats::Tally at = tally_at_look(tally, look);
    if (units_of(at) < 2) continue;
    std::vector<NamedRow> named = named_rows(at);
    of_first.resize(named.size(), kNaN);
    for (std::size_t i = 0; i < named.size(); ++i) {
      const double merit = merit_of(named[i].row, at);
      if (std::isnan(of_first[i])) of_first[i] = merit;
      rows.push_back({look + 1, at.trials, merit, of_first[i], std::move(named[i])});
    }
  }
  const bool placed = std::any_of(rows.begin(), rows.end(), [](const LookRow& x) { return !x.named.place.empty(); });
  TableRows t("looks", "the rows that may end the run, at every look" + at_confidence(rule_));
  write_rows(t, rows, [&](const LookRow& x) {
    const ComparisonRow& row = x.named.row;
    t.count("look", "number of the look, from 1", x.look);
    t.count("trials", "trials at the look", x.trials);
    t.word("table", "where the row stands", x.named.table);
    if (placed) t.word("place", "measured depth, where the table has the row at several", x.named.place);
    t.word("formulation", "which analytic prediction", row.formulation);
    t.word("quantity", "what is compared", row.quantity);
    t.estimate("ratio", "1", "analytic / Monte Carlo; of a mean, one plus its shift in sd", row.judged,
               row.judged_interval);
    t.number("margin", "1", "what agrees: within 1 -+ margin", row.margin);
    t.word("decision", "verdict at this look", row.verdict);
    t.number("relative_merit", "1",
             "1 / (standard error^2 x trials) over that of the first look: constant, unless the tail is heavy",
             x.merit / x.of_first);
  });
  return t.take();
}

}  // namespace surveymc::compare
