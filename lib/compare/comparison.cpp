#include "compare/comparison.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/family.h"
#include "compare/table_rows.h"
#include "stats/normal_tail.h"

namespace surveymc::compare {

Verdict judge(const stats::Interval& r, double margin, std::uint64_t trials) {
  // An end at infinity bounds nothing, but the other end may exclude the margin; no bound at all says nothing.
  if (!std::isfinite(r.lo) || !(r.hi >= r.lo) || (r.lo <= 0 && r.hi == kInfinity)) return {};
  const double lo = 1 - margin, hi = 1 + margin;
  if (r.lo >= lo && r.hi <= hi) return {"agrees"};
  if (r.hi < lo || r.lo > hi) return {"differs"};
  if (r.hi == kInfinity) return {"undecided"};
  // The nearer edge of the margin decides; the half width shrinks like 1 / sqrt(trials).
  const double middle = (r.lo + r.hi) / 2, half = (r.hi - r.lo) / 2;
  const double distance = std::max(std::abs(std::abs(middle - 1) - margin), 1e-3 * margin);
  const double factor = half / distance;
  return {"undecided", static_cast<std::uint64_t>(std::ceil(static_cast<double>(trials) * factor * factor * 1.1))};
}

namespace {

/// Two-sided p of what lies z standard errors away.
double two_sided_p(double z, const VerdictRule& rule, std::uint64_t units) {
  if (z <= 0) return 1;
  return rule.at_all_looks ? stats::sequence_p(units, z) : std::min(1.0, 2 * stats::normal_upper_tail(z));
}

}  // namespace

Evidence evidence_of(double value, const stats::Interval& interval, const VerdictRule& rule, std::uint64_t units,
                     bool logarithmic) {
  if (!std::isfinite(interval.lo) || !(interval.hi >= interval.lo)) return {};
  if (logarithmic && !(interval.lo > 0)) return {};  // a prediction of 0 differs for certain
  const double quantile = rule.at_all_looks ? stats::sequence_quantile(units, rule.confidence)
                                            : stats::normal_quantile((1 + rule.confidence) / 2);
  const auto scaled = [&](double x) { return logarithmic ? std::log(x) : x; };
  const double at = scaled(value), lo = scaled(1 - rule.margin), hi = scaled(1 + rule.margin);
  // In the direction of increasing values, how many standard errors from the value to the edge.
  const auto errors_to = [&](double edge) {
    const double half = edge > at ? scaled(interval.hi) - at : at - scaled(interval.lo);
    return edge == at ? 0 : quantile * (edge - at) / half;
  };
  const double to_lo = errors_to(lo), to_hi = errors_to(hi);
  return {two_sided_p(std::max(to_lo, -to_hi), rule, units), two_sided_p(std::min(-to_lo, to_hi), rule, units)};
}

std::string at_confidence(double confidence) { return fmt::format(", intervals at {:.6g} %", 100 * confidence); }

std::string at_confidence(const VerdictRule& rule) {
  return rule.at_all_looks ? fmt::format(", intervals at all looks at {:.6g} %", 100 * rule.confidence)
                           : at_confidence(rule.confidence);
}

namespace {

ComparisonRow row_of(const std::string& quantity, const std::string& unit, double predicted) {
  ComparisonRow row = empty_row("", quantity, unit);
  row.analytic = predicted;
  return row;
}

/// The verdict on `value`, a ratio (`logarithmic`) or one plus the shift of a mean.
void set_verdict(ComparisonRow& row, double value, const stats::Interval& interval, const VerdictRule& rule,
                 std::uint64_t trials, std::uint64_t units, bool logarithmic = true) {
  const Verdict v = judge(interval, rule.margin, trials);
  row.verdict = v.word;
  row.margin = v.word.empty() ? kNaN : rule.margin;
  row.judged = value;
  row.judged_interval = interval;
  row.evidence = evidence_of(value, interval, rule, units, logarithmic);
  row.trials_to_decide = v.trials_to_decide;
  if (v.trials_to_decide > 0) {
    if (!row.note.empty()) row.note += "; ";
    row.note += fmt::format("about {:.2g} trials would decide", static_cast<double>(v.trials_to_decide));
  }
}

}  // namespace

ComparisonRow empty_row(const std::string& formulation, const std::string& quantity, const std::string& unit) {
  ComparisonRow row;
  row.formulation = formulation;
  row.quantity = quantity;
  row.unit = unit;
  return row;
}

Estimate mean_estimate(const stats::Moments& m, Eigen::Index i, double confidence) {
  if (m.count < 2) return {};
  return {m.mean[i], stats::mean_interval(m.mean[i], m.variance(i), m.count, confidence)};
}

Estimate rms_estimate(const stats::Moments& m, Eigen::Index i, double confidence) {
  return m.count < 2 ? Estimate{} : rms_estimate(m.mean[i], m.variance(i), m.count, confidence);
}

Estimate rms_estimate(double mean_square, double variance, std::uint64_t count, double confidence) {
  if (count < 2) return {};
  const stats::Interval ci = stats::mean_square_interval(mean_square, variance, count, confidence);
  return {std::sqrt(mean_square), {std::sqrt(ci.lo), std::sqrt(ci.hi)}};
}

ComparisonRow compare_value(const std::string& quantity, const std::string& unit, const Estimate& found,
                            double predicted, const VerdictRule& rule, std::uint64_t trials, std::uint64_t units) {
  ComparisonRow row = row_of(quantity, unit, predicted);
  row.monte_carlo = found.value;
  row.interval = found.interval;
  if (!std::isfinite(predicted) || !(found.value > 0)) return row;
  row.ratio = predicted / found.value;
  row.ratio_interval = {predicted / found.interval.hi,
                        found.interval.lo > 0 ? predicted / found.interval.lo : kInfinity};
  set_verdict(row, row.ratio, row.ratio_interval, rule, trials, units > 0 ? units : trials);
  return row;
}

ComparisonRow compare_sd(const std::string& quantity, const std::string& unit, double sigmas, const stats::Moments& m,
                         Eigen::Index i, double predicted_sd, const VerdictRule& rule, std::uint64_t trials) {
  return compare_sd(quantity, unit, sigmas, m.count < 2 ? stats::SampleSummary{} : stats::summarise(m, i), predicted_sd,
                    rule, trials);
}

ComparisonRow compare_sd(const std::string& quantity, const std::string& unit, double sigmas,
                         const stats::SampleSummary& s, double predicted_sd, const VerdictRule& rule,
                         std::uint64_t trials) {
  ComparisonRow row = row_of(quantity, unit, sigmas * predicted_sd);
  if (s.units < 2) {
    row.note = "fewer than two converged trials";
    return row;
  }
  const double sd = std::sqrt(s.variance);
  const stats::Interval ci =
      rule.at_all_looks ? stats::sd_sequence(s, rule.confidence) : stats::sd_interval(s, rule.confidence);
  row.monte_carlo = sigmas * sd;
  row.interval = {sigmas * ci.lo, sigmas * ci.hi};
  if (!(sd > 0)) {
    row.note = "every trial gave the same";
    return row;
  }
  row.ratio = predicted_sd / sd;
  row.ratio_interval = {predicted_sd / ci.hi, predicted_sd / ci.lo};
  // Beyond four standard errors of a normal sample's skewness (sqrt(6/n)) and kurtosis (sqrt(24/n)), and visible.
  const double n = static_cast<double>(s.units), skew = s.skewness, kurt = s.kurtosis;
  if ((std::abs(skew) > 4 * std::sqrt(6 / n) && std::abs(skew) > 0.1) ||
      (std::abs(kurt - 3) > 4 * std::sqrt(24 / n) && std::abs(kurt - 3) > 0.2))
    row.note = fmt::format("not normal: skewness {:.2f}, kurtosis {:.2f}", skew, kurt);
  set_verdict(row, row.ratio, row.ratio_interval, rule, trials, s.units);
  return row;
}

ComparisonRow compare_mean(const std::string& quantity, const std::string& unit, const stats::Moments& m,
                           Eigen::Index i, double offset, double predicted, const VerdictRule& rule,
                           std::uint64_t trials) {
  return compare_mean(quantity, unit, m.count < 2 ? stats::SampleSummary{} : stats::summarise(m, i), offset, predicted,
                      rule, trials);
}

ComparisonRow compare_mean(const std::string& quantity, const std::string& unit, const stats::SampleSummary& s,
                           double offset, double predicted, const VerdictRule& rule, std::uint64_t trials) {
  ComparisonRow row = row_of(quantity, unit, predicted);
  if (s.units < 2) {
    row.note = "fewer than two converged trials";
    return row;
  }
  const double sd = std::sqrt(s.variance);
  row.monte_carlo = s.mean + offset;
  row.interval = stats::mean_interval(row.monte_carlo, s.unit_variance, s.units, rule.interval_confidence(s.units));
  if (!(sd > 0)) {
    row.note = "every trial gave the same";
    return row;
  }
  if (!std::isfinite(predicted)) return row;
  const auto shift = [&](double x) { return (x - predicted) / sd; };
  row.note = fmt::format("mean is {:+.3f} sd ({:+.3f} .. {:+.3f}) from the prediction", shift(row.monte_carlo),
                         shift(row.interval.lo), shift(row.interval.hi));
  set_verdict(row, 1 + shift(row.monte_carlo), {1 + shift(row.interval.lo), 1 + shift(row.interval.hi)}, rule, trials,
              s.units, false);
  return row;
}

void leave_unjudged(ComparisonRow& row, const std::string& why) {
  row.verdict.clear();
  row.margin = kNaN;
  row.evidence = {};
  row.trials_to_decide = 0;
  row.note = why;
}

void leave_undecided(std::vector<ComparisonRow>& rows, std::uint64_t failed, std::uint64_t trials, double most,
                     const std::string& what, const std::string& did) {
  if (static_cast<double>(failed) <= most * static_cast<double>(trials)) return;
  const std::string why = fmt::format("{} of {} {} {} (more than {:g} %)", failed, trials, what, did, 100 * most);
  for (ComparisonRow& row : rows) {
    if (!row.verdict.empty() || std::isfinite(row.analytic)) row.verdict = "undecided";
    row.evidence = {};
    row.trials_to_decide = 0;  // more trials do not help
    row.note = row.note.empty() ? why : why + "; " + row.note;
  }
}

namespace {

/// One-sided p-values of the hypotheses that a value lies at an edge of the margin, or below; or above.
struct EdgeTails {
  double below = 1, above = 1;
};

/// From the tails at both edges, in the unit of the value.
Evidence evidence_of_tails(const EdgeTails& lo, const EdgeTails& hi, const VerdictRule& rule, std::uint64_t units) {
  const auto p = [&](double tail) {
    if (!rule.at_all_looks) return std::min(1.0, 2 * tail);
    return tail > 0 ? two_sided_p(-stats::normal_quantile(std::min(tail, 0.5)), rule, units) : 0;
  };
  return {p(std::min(lo.above, hi.below)), p(std::max(lo.below, hi.above))};
}

/// The values whose ratio of the prediction to them is at an edge of the margin.
stats::Interval margin_of(double predicted, const VerdictRule& rule) {
  return {predicted / (1 + rule.margin), predicted / (1 - rule.margin)};
}

/// Exact, as the intervals of a rate are, at the rates whose ratio is at an edge: by the binomial tails, as Clopper and
/// Pearson's interval is, or by the mixture of the sequence.
Evidence rate_evidence(std::uint64_t events, std::uint64_t runs, double predicted, const VerdictRule& rule) {
  const stats::Interval edges = margin_of(predicted, rule);
  const double lo = std::min(1.0, edges.lo), hi = std::min(1.0, edges.hi);
  if (rule.at_all_looks) {
    const double rate = static_cast<double>(events) / static_cast<double>(runs);
    const double p_lo = stats::rate_sequence_p(events, runs, lo), p_hi = stats::rate_sequence_p(events, runs, hi);
    if (rate < lo) return {p_lo, 1};
    if (rate > hi) return {p_hi, 1};
    return {1, std::max(p_lo, p_hi)};
  }
  const auto tails = [&](double edge) {
    const stats::BinomialTails t = stats::binomial_tails(events, runs, edge);
    return EdgeTails{t.at_least, t.at_most};
  };
  return evidence_of_tails(tails(lo), tails(hi), rule, runs);
}

}  // namespace

ComparisonRow compare_rate(const std::string& quantity, std::uint64_t events, std::uint64_t runs, double predicted,
                           const VerdictRule& rule, std::uint64_t trials) {
  predicted = std::clamp(predicted, 0.0, 1.0);  // sums of tails round; NaN stays
  ComparisonRow row = row_of(quantity, "1", predicted);
  if (runs == 0) {
    row.note = "no converged trial";
    return row;
  }
  row.monte_carlo = static_cast<double>(events) / static_cast<double>(runs);
  row.interval = rule.at_all_looks ? stats::rate_sequence(events, runs, rule.confidence)
                                   : stats::binomial_interval(events, runs, rule.confidence);
  if (std::isnan(predicted)) return row;
  if (events == 0 && predicted == 0) {  // no ratio either: within the margin of 0 itself
    row.note = "never seen";
    row.verdict = row.interval.hi <= rule.margin ? "agrees" : "undecided";
    row.margin = rule.margin;
    const double p = rule.at_all_looks ? stats::rate_sequence_p(0, runs, rule.margin)
                                       : 2 * stats::binomial_tails(0, runs, rule.margin).at_most;
    row.evidence = {1, std::min(1.0, p)};
    return row;
  }
  if (events == 0) {  // no ratio, but perhaps a verdict: the prediction may lie above all that is possible
    row.note = "never seen";
    const bool differs = predicted > (1 + rule.margin) * row.interval.hi;
    if (!differs && !(rule.at_all_looks && predicted > 0)) return row;
    row.verdict = differs ? "differs" : "undecided";  // undecided: the run goes on
    row.margin = rule.margin;
    row.evidence = rate_evidence(events, runs, predicted, rule);
    return row;
  }
  row.ratio = predicted / row.monte_carlo;
  row.ratio_interval = {predicted / row.interval.hi, predicted / row.interval.lo};
  set_verdict(row, row.ratio, row.ratio_interval, rule, trials, runs);
  if (!row.verdict.empty()) row.evidence = rate_evidence(events, runs, predicted, rule);
  return row;
}

ComparisonRow compare_quantile(const std::string& quantity, const std::string& unit, const stats::HistogramBins& bins,
                               const std::uint64_t* counts, double probability, double predicted,
                               const VerdictRule& rule, std::uint64_t trials) {
  const std::uint64_t values = stats::histogram_total(bins, counts);
  const Estimate found{stats::histogram_quantile(bins, counts, probability),
                       stats::histogram_quantile_interval(bins, counts, probability, rule.interval_confidence(values))};
  ComparisonRow row = compare_value(quantity, unit, found, predicted, rule, trials, values);
  if (row.verdict.empty()) return row;
  // A quantile lies above an edge if few values lie below it.
  const auto tails = [&](double edge) {
    const stats::BinomialTails t =
        stats::binomial_tails(stats::histogram_count(bins, counts, edge), values, probability);
    return EdgeTails{t.at_most, t.at_least};
  };
  const stats::Interval edges = margin_of(predicted, rule);
  row.evidence = evidence_of_tails(tails(edges.lo), tails(edges.hi), rule, values);
  return row;
}

ComparisonRow labelled(const std::string& formulation, ComparisonRow row) {
  row.formulation = formulation;
  return row;
}

void write_evidence(TableRows& t, const Evidence& evidence, std::uint64_t trials_to_decide) {
  t.number("p_differs", "1", "p-value of the hypothesis that the value lies within the margin", evidence.p_differs);
  t.number("p_agrees", "1", "p-value of the hypothesis that it lies outside", evidence.p_agrees);
  t.word("family", "differs: so among all rows of the file (Holm at 5 %); may be chance: not so", "");
  t.number("trials_to_decide", "1", "roughly how many trials would decide an undecided row",
           trials_to_decide > 0 ? static_cast<double>(trials_to_decide) : kNaN);
}

store::Table comparison_table(const std::string& name, const std::string& long_name,
                              const std::vector<ComparisonRow>& rows, std::uint64_t trials, std::uint64_t failed,
                              bool with_formulation) {
  TableRows t(name, long_name);
  bool labelled = with_formulation;
  for (const ComparisonRow& r : rows) labelled = labelled || !r.formulation.empty();
  write_rows(t, rows, [&](const ComparisonRow& r) {
    if (labelled) t.word("formulation", "which analytic prediction", r.formulation);
    t.word("quantity", "what is compared", r.quantity);
    t.word("unit", "unit of the values in this row", r.unit);
    t.estimate("monte_carlo", "1", "Monte-Carlo value, in the row's unit", r.monte_carlo, r.interval);
    t.number("analytic", "1", "analytic value, in the row's unit", r.analytic);
    t.estimate("ratio", "1", "analytic / Monte Carlo; absent for means, which are judged on their shift in sd", r.ratio,
               r.ratio_interval);
    t.number("published", "1", "published value, in the row's unit", r.published);
    t.number("published_ratio", "1", "published / Monte Carlo",
             r.monte_carlo != 0 ? r.published / r.monte_carlo : kNaN);
    t.number("margin", "1", "what agrees: the ratio within 1 -+ margin; of a mean, its shift in sd within it",
             r.margin);
    t.word("verdict", "agrees, differs or undecided", r.verdict);
    t.word("expected", "the verdict this row should have; differs: known to be wrong; either: an approximation",
           r.expected);
    write_evidence(t, r.evidence, r.trials_to_decide);
    t.word("note", "what else there is to say", r.note);
    t.count("trials", "trials run", trials);
    t.count("failed", "trials without a converged estimate, not in the statistics", r.failed.value_or(failed));
  });
  return t.take();
}

store::Table published_fit_table(const std::vector<ComparisonRow>& rows) {
  double squares = 0, lowest = kInfinity, highest = 0;
  std::int64_t count = 0;
  std::set<std::string> seen;  // a published value stands beside each formulation: once is enough
  for (const ComparisonRow& row : rows) {
    const double ratio = row.published / row.monte_carlo;
    // Means have no ratio.
    if (!std::isfinite(row.ratio) || !(ratio > 0) || !seen.insert(row.quantity).second) continue;
    ++count;
    squares += std::log(ratio) * std::log(ratio);
    lowest = std::min(lowest, ratio);
    highest = std::max(highest, ratio);
  }
  TableRows t("published_fit", "published over Monte-Carlo standard deviations, over all rows that have both");
  const auto number = [&](const char* name, const char* what, double value) {
    t.number(name, "1", what, count > 0 ? value : kNaN);
  };
  t.count("quantities", "rows with a published standard deviation", count);
  number("rms_log_ratio", "root mean square of ln(published / Monte Carlo)",
         std::sqrt(squares / static_cast<double>(std::max<std::int64_t>(count, 1))));
  number("ratio_min", "smallest published / Monte Carlo", lowest);
  number("ratio_max", "largest published / Monte Carlo", highest);
  return t.take();
}

namespace {

void add_unexpected(const store::Table& t, std::vector<std::string>& found) {
  const auto& v = std::get<std::vector<std::string>>(t.column("verdict").values);
  const auto& e = std::get<std::vector<std::string>>(t.column("expected").values);
  const auto may_be_chance = [&](std::size_t i) { return v[i] == "differs" && t.word("family", i) == kMayBeChance; };
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (e[i].empty() || e[i] == v[i] || e[i] == store::kEither || may_be_chance(i)) continue;
    std::string place = t.name;  // the columns up to `quantity` say which row it is
    for (const store::Column& c : t.columns) {
      if (c.name == "unit" || c.name == "semi_major_m") break;
      if (const auto* words = std::get_if<std::vector<std::string>>(&c.values))
        place += " " + (*words)[i];
      else if (const auto* values = std::get_if<std::vector<double>>(&c.values))
        place += fmt::format(" {} = {:g}", c.name, (*values)[i]);
    }
    found.push_back(fmt::format("{}: {}, expected {}", place, v[i].empty() ? "no verdict" : v[i], e[i]));
  }
}

}  // namespace

std::vector<std::string> unexpected_verdicts(const std::vector<store::Table>& tables) {
  std::vector<std::string> found;
  for (const store::Table& t : tables) {
    if (t.find_column("verdict") && t.find_column("expected"))
      store::for_each_piece(t, [&](const store::Table& piece, std::size_t) { add_unexpected(piece, found); });
  }
  return found;
}

}  // namespace surveymc::compare
