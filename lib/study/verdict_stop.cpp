#include "study/verdict_stop.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace surveymc::study {
namespace {

constexpr double kHeavyTail = 0.1;  // of the figure of merit

std::uint64_t units_of(const stats::Tally& tally) {
  return tally.pairs.count > 0 ? tally.pairs.count : tally.moments.count;
}

}  // namespace

VerdictStop::VerdictStop(const TrialPlan& plan, const VerdictRule& rule,
                         std::function<RowsOfTables(const stats::Tally&)> rows)
    : decisive_(plan.decisive), looks_(plan.looks), rule_(rule), rows_(std::move(rows)) {}

void VerdictStop::keep(montecarlo::TrialBlock block, stats::Tally& tally) const {
  if (!is_on()) return;
  const std::uint64_t end = block.first + static_cast<std::uint64_t>(block.count);
  const auto look = static_cast<std::size_t>(std::lower_bound(looks_.begin(), looks_.end(), end) - looks_.begin());
  tally.groups.resize(2 * look + 2);
  tally.groups[2 * look] = tally.moments;
  tally.groups[2 * look + 1] = tally.pairs;
}

stats::Tally VerdictStop::tally_at_look(const stats::Tally& tally, std::size_t look) const {
  stats::Tally at;
  at.trials = std::min(looks_.at(std::min(look, looks_.size() - 1)), tally.trials);
  for (std::size_t part = 0; part <= look && 2 * part + 1 < tally.groups.size(); ++part) {
    at.moments.merge(tally.groups[2 * part]);
    at.pairs.merge(tally.groups[2 * part + 1]);
  }
  return at;
}

bool VerdictStop::is_named(const std::string& table, const ComparisonRow& row) const {
  return std::any_of(decisive_.begin(), decisive_.end(), [&](const RowName& name) {
    return name.table == table && name.quantity == row.quantity && name.formulation == row.formulation;
  });
}

std::vector<VerdictStop::NamedRow> VerdictStop::named_rows(const stats::Tally& tally) const {
  std::vector<NamedRow> found;
  for (const auto& [table, rows] : rows_(tally))
    for (const ComparisonRow& row : rows)
      if (is_named(table, row)) found.push_back({table, row});
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
  for (const NamedRow& d : named_rows(tally_at_look(tally, look)))
    if (d.row.verdict == "undecided") most = std::max({most, d.row.trials_to_decide, tally.trials + 1});
  return most;
}

void VerdictStop::add_notes(const std::string& table, std::vector<ComparisonRow>& rows,
                            const stats::Tally& tally) const {
  if (!is_on() || std::none_of(rows.begin(), rows.end(), [&](const ComparisonRow& r) { return is_named(table, r); }))
    return;
  std::size_t look = 1;
  while (look < looks_.size() && looks_[look - 1] < tally.trials) ++look;
  const stats::Tally first = tally_at_look(tally, 0);
  const std::vector<NamedRow> before = units_of(first) < 2 ? std::vector<NamedRow>{} : named_rows(first);
  for (ComparisonRow& row : rows) {
    if (!is_named(table, row)) continue;
    const std::string said = row.note;
    row.note =
        fmt::format("{}{}the run ended at look {} of at most {}", said, said.empty() ? "" : "; ", look, looks_.size());
    for (const NamedRow& b : before)
      if (b.table == table && b.row.quantity == row.quantity && b.row.formulation == row.formulation)
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
  TableRows t("looks", "the rows that may end the run, at every look" + at_confidence(rule_));
  write_rows(t, rows, [&](const LookRow& x) {
    const ComparisonRow& row = x.named.row;
    t.count("look", "number of the look, from 1", x.look);
    t.count("trials", "trials at the look", x.trials);
    t.word("table", "where the row stands", x.named.table);
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

}  // namespace surveymc::study
