#include "sweep/difference.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "base/error.h"
#include "compare/answer.h"
#include "compare/family.h"
#include "compare/table_rows.h"
#include "config/toml_tree.h"
#include "stats/intervals.h"
#include "stats/normal_tail.h"

namespace surveymc::sweep {

double same_rate_p(std::uint64_t k1, std::uint64_t n1, std::uint64_t k2, std::uint64_t n2) {
  const auto k = static_cast<double>(k1 + k2), a = static_cast<double>(n1), b = static_cast<double>(n2);
  const auto ln_choose = [](double n, double r) {
    return std::lgamma(n + 1) - std::lgamma(r + 1) - std::lgamma(n - r + 1);
  };
  const auto ln_p = [&](double x) { return ln_choose(a, x) + ln_choose(b, k - x) - ln_choose(a + b, k); };
  const double lo = std::max(0.0, k - b), hi = std::min(a, k), at = ln_p(static_cast<double>(k1));
  const double mode = std::clamp(std::floor((k + 1) * (a + 1) / (a + b + 2)), lo, hi);
  constexpr double kAlike = 1e-7, kNegligible = 45;  // of ln p: rounding; nothing farther adds to the sum
  double inside = 0, all = 0;                        // of terms relative to the largest
  const double top = ln_p(mode);
  const auto take = [&](double x) {
    const double ln = ln_p(x);
    all += std::exp(ln - top);
    if (ln > at + kAlike) inside += std::exp(ln - top);
    return ln > top - kNegligible;
  };
  for (double x = mode; x <= hi && take(x); ++x) {
  }
  for (double x = mode - 1; x >= lo && take(x); --x) {
  }
  return std::clamp(1 - inside / all, 0.0, 1.0);
}

bool Differences::any() const {
  return std::any_of(rows.begin(), rows.end(), [](const DifferenceRow& r) { return r.counts(); });
}

namespace {

using Words = std::vector<std::string>;

/// Words that are results, not names of a row.
bool is_result_word(const std::string& name) {
  static const std::set<std::string> kResults = {"verdict",  "expected",       "note",     "unit",
                                                 "family",   "reason",         "message",  "shape",
                                                 "decision", "wishart_family", "judgement"};
  return kResults.contains(name);
}

bool is_prediction(const std::string& name) {
  return name == "analytic" || name == "published" || name == "predicted" || name.starts_with("predicted_");
}

/// Tables that list what happened to the trials of one run: looks of its stopping rule, numbers of its failed trials.
bool is_course_of_run(const std::string& table) { return table == "looks" || table == "failed_trials"; }

/// What names a row, with the number of the row among those of that name.
std::vector<std::string> row_names(const store::Table& t) {
  std::vector<std::string> names(t.rows());
  for (const store::Column& c : t.columns) {
    const bool is_key = c.long_name == "sweep key";
    if (const auto* words = std::get_if<Words>(&c.values)) {
      if (is_result_word(c.name)) continue;
      for (std::size_t i = 0; i < names.size(); ++i) {
        if ((*words)[i].empty()) continue;
        names[i] += (names[i].empty() ? "" : " ") + (is_key ? c.name + " = " : "") + (*words)[i];
      }
    } else if (const auto* x = std::get_if<std::vector<double>>(&c.values); x && is_key) {
      for (std::size_t i = 0; i < names.size(); ++i)
        names[i] += fmt::format("{}{} = {}", names[i].empty() ? "" : " ", c.name, (*x)[i]);
    }
  }
  std::map<std::string, int> seen;
  for (std::string& name : names)
    if (const int n = ++seen[name]; n > 1 || name.empty()) name += fmt::format("{}#{}", name.empty() ? "" : " ", n);
  return names;
}

/// The confidence that the title of a table says; 0.95 without.
double confidence_of(const store::Table& t) {
  const std::string words = "intervals at ";
  const auto at = t.long_name.find(words);
  if (at == std::string::npos) return 0.95;
  double percent = 95;
  std::istringstream(t.long_name.substr(at + words.size())) >> percent;
  return percent > 0 && percent < 100 ? percent / 100 : 0.95;
}

struct Value {
  double value = kNaN, lo = kNaN, hi = kNaN, quantile = 1.96;
  std::uint64_t trials = 0, failed = 0;
  double confidence = 0.95;

  bool is_positive() const { return lo > 0 && std::isfinite(hi); }
  /// A mean: its interval is even.
  bool is_even() const {
    return std::abs((hi - value) - (value - lo)) <= 1e-9 * std::max(hi - lo, std::abs(value) * 1e-6);
  }
};

Value value_at(const store::Table& t, const store::Column& c, std::size_t row) {
  Value v;
  std::istringstream names(c.ancillary);
  std::string lo, hi;
  names >> lo >> hi;
  v.value = std::get<std::vector<double>>(c.values)[row];
  v.lo = t.number(lo, row);
  v.hi = t.number(hi, row);
  v.confidence = confidence_of(t);
  v.quantile = stats::normal_quantile((1 + v.confidence) / 2);
  const double trials = t.number("trials", row), failed = t.number("failed", row);
  v.trials = trials > 0 ? static_cast<std::uint64_t>(trials) : 0;
  v.failed = failed > 0 ? static_cast<std::uint64_t>(failed) : 0;
  return v;
}

/// Failed trials as a rate of all trials of a row; of no trials without a value.
Value failure_rate(const store::Table& t, std::size_t row, double failed) {
  Value v;
  v.trials = static_cast<std::uint64_t>(std::max(0.0, t.number("trials", row)));
  if (v.trials == 0) return v;
  v.value = failed / static_cast<double>(v.trials);
  const stats::Interval ci = stats::binomial_interval(static_cast<std::uint64_t>(failed), v.trials, v.confidence);
  v.lo = ci.lo;
  v.hi = ci.hi;
  return v;
}

/// The events of a rate, if the value is one of counts: its interval is Clopper and Pearson's.
std::optional<std::uint64_t> events_of(const Value& v) {
  if (v.trials <= v.failed || !(v.value >= 0 && v.value <= 1)) return std::nullopt;  // NaN: no value
  const std::uint64_t n = v.trials - v.failed;
  const double k = v.value * static_cast<double>(n);
  if (std::abs(k - std::round(k)) > 1e-6) return std::nullopt;
  const auto events = static_cast<std::uint64_t>(std::llround(k));
  const stats::Interval ci = stats::binomial_interval(events, n, v.confidence);
  if (std::abs(ci.lo - v.lo) > 1e-9 || std::abs(ci.hi - v.hi) > 1e-9) return std::nullopt;
  return events;
}

DifferenceRow row_of(const std::string& table, const std::string& row, const std::string& finding,
                     const std::string& note = "") {
  DifferenceRow r;
  r.table = table;
  r.row = row;
  r.finding = finding;
  r.note = note;
  return r;
}

struct Comparer {
  const DifferenceRule& rule;
  Differences out;
  bool has_trials = true;

  DifferenceRow estimated(DifferenceRow row, const Value& a, const Value& b) const {
    row.a = a.value;
    row.b = b.value;
    if (a.value == b.value || (std::isnan(a.value) && std::isnan(b.value))) {
      row.finding = "equal";
      // Of other seeds the same value by chance: all trials failed, or none. It stays in the family.
      return row;
    }
    const std::optional<std::uint64_t> ka = events_of(a), kb = events_of(b);
    const bool is_log = a.is_positive() && b.is_positive() && !(a.is_even() && b.is_even());
    const auto f = [&](double x) { return is_log ? std::log(x) : x; };
    row.difference = f(b.value) - f(a.value);
    const bool up = b.value > a.value;
    const double se_a = std::abs(f(up ? a.hi : a.lo) - f(a.value)) / a.quantile,
                 se_b = std::abs(f(up ? b.lo : b.hi) - f(b.value)) / b.quantile;
    row.standard_error = std::hypot(se_a, se_b);
    if (out.same_seed && out.same_trials && a.trials == b.trials) {  // a stopping rule may end with others
      row.standard_error = std::max(se_a, se_b);
      const double z = std::abs(row.difference) / row.standard_error;
      row.finding = z <= rule.tolerance ? "chance" : "changed";
      row.note = "the same draws";
      return row;
    }
    if (out.same_seed) row.standard_error = std::sqrt(std::abs(se_b * se_b - se_a * se_a));  // one holds the other
    const bool few_events = ka && kb && *ka + *kb < rule.hits;
    const bool few_trials = (a.trials > 0 && a.trials < rule.least) || (b.trials > 0 && b.trials < rule.least);
    if (!std::isfinite(row.difference) || !(row.standard_error > 0) || few_events || few_trials) {
      row.finding = std::isnan(a.value) != std::isnan(b.value) ? "changed" : "few";
      if (row.finding == "changed") row.note = "there is a value in one of them only";
      return row;
    }
    row.p = ka && kb && !out.same_seed ? same_rate_p(*ka, a.trials - a.failed, *kb, b.trials - b.failed)
                                       : 2 * stats::normal_upper_tail(std::abs(row.difference) / row.standard_error);
    row.finding = "chance";
    return row;
  }

  void fixed(DifferenceRow row, double a, double b, double tolerance) {
    row.a = a;
    row.b = b;
    const bool same = a == b || (std::isnan(a) && std::isnan(b));
    const double scale = std::max(std::abs(a), std::abs(b));
    row.difference = same ? 0 : b / a - 1;
    row.finding = same || std::abs(b - a) <= tolerance * scale ? "equal" : "changed";
    out.rows.push_back(std::move(row));
  }
};

void compare_rows(Comparer& c, const store::Table& ta, std::size_t i, const store::Table& tb, std::size_t j,
                  const std::string& name) {
  DifferenceRow row = row_of(ta.name, name, "");
  const auto misfit = [&](const char* finding, const std::string& a, const std::string& b) {
    c.out.rows.push_back(row_of(ta.name, name, finding, fmt::format("{} and {}", a, b)));
  };
  if (ta.word("unit", i) != tb.word("unit", j)) {
    misfit("other unit", ta.word("unit", i), tb.word("unit", j));
    return;
  }
  const double margin_a = ta.number("margin", i), margin_b = tb.number("margin", j);
  if (std::isfinite(margin_a) && std::isfinite(margin_b) && margin_a != margin_b)
    misfit("other margin", fmt::format("{}", margin_a), fmt::format("{}", margin_b));
  const bool no_chance = !c.has_trials || (c.out.same_seed && c.out.same_trials);
  std::set<std::string> ends;
  for (const store::Column& col : ta.columns) {
    std::istringstream names(col.ancillary);
    for (std::string end; names >> end;) ends.insert(end);
  }
  const bool compares = ta.find_column("monte_carlo") != nullptr;
  for (const store::Column& col : ta.columns) {
    const store::Column* other = tb.find_column(col.name);
    if (!other || other->values.index() != col.values.index() || col.long_name == "sweep key") continue;
    row.column = col.name;
    if (!col.ancillary.empty() && !other->ancillary.empty()) {
      if (compares && col.name == "ratio") continue;  // says nothing that monte_carlo and analytic do not
      // The largest of many deviations, of either sign, is not normal; table coverage has shares that can be compared.
      if (col.name == "deviation" && !c.out.same_seed) continue;
      c.out.rows.push_back(c.estimated(row, value_at(ta, col, i), value_at(tb, *other, j)));
      continue;
    }
    if (ends.contains(col.name) || col.name == "margin" || col.name == "trials") continue;
    if (std::holds_alternative<Words>(col.values)) continue;
    const double a = ta.number(col.name, i), b = tb.number(col.name, j);
    if (col.name == "failed" && !no_chance && !c.out.same_seed) {  // a rate of all trials
      const Value va = failure_rate(ta, i, a), vb = failure_rate(tb, j, b);
      if (va.trials > 0 && vb.trials > 0) c.out.rows.push_back(c.estimated(row, va, vb));
      continue;
    }
    if (is_prediction(col.name))
      c.fixed(row, a, b, c.rule.analytic);
    else if (no_chance)
      c.fixed(row, a, b, c.has_trials ? 0 : c.rule.analytic);
  }
  const std::string va = ta.word("verdict", i), vb = tb.word("verdict", j);
  if (va == vb) return;
  row.column = "verdict";
  row.finding = "verdict";
  row.note = fmt::format("{} -> {}", va.empty() ? "none" : va, vb.empty() ? "none" : vb);
  c.out.rows.push_back(row);
}

void compare_tables(Comparer& c, const store::Table& a, const store::Table& b) {
  const bool other_draws = c.has_trials && !(c.out.same_seed && c.out.same_trials);
  if (other_draws && is_course_of_run(a.name)) return;
  const std::vector<std::string> in_a = row_names(a), in_b = row_names(b);
  std::map<std::string, std::size_t> of_b;
  for (std::size_t j = 0; j < in_b.size(); ++j) of_b.emplace(in_b[j], j);
  std::vector<bool> seen(in_b.size());
  const auto alone = [&](const std::string& name, const char* finding) {
    // A list without names may be longer by chance.
    if (other_draws && name.find('#') != std::string::npos) return;
    c.out.rows.push_back(row_of(a.name, name, finding));
  };
  for (std::size_t i = 0; i < in_a.size(); ++i) {
    const auto found = of_b.find(in_a[i]);
    if (found == of_b.end()) {
      alone(in_a[i], "only in A");
      continue;
    }
    seen[found->second] = true;
    compare_rows(c, a, i, b, found->second, in_a[i]);
  }
  for (std::size_t j = 0; j < in_b.size(); ++j)
    if (!seen[j]) alone(in_b[j], "only in B");
}

std::map<std::string, store::MapSource> maps_in(const store::Result& r) {
  std::map<std::string, store::MapSource> out;
  for (const store::MapSource& m : store::maps_of(r)) out[m.map->name] = m;
  return out;
}

void compare_maps(Comparer& c, const store::Result& a, const store::Result& b) {
  const std::map<std::string, store::MapSource> in_a = maps_in(a), in_b = maps_in(b);
  const auto add = [&](const std::string& name, const std::string& finding, const std::string& note, double size) {
    c.out.rows.push_back(row_of("maps", name, finding, note));
    c.out.rows.back().difference = size;
  };
  for (const auto& [name, m] : in_b)
    if (!in_a.contains(name)) add(name, "only in B", "", kNaN);
  for (const auto& [name, m] : in_a) {
    const auto found = in_b.find(name);
    if (found == in_b.end()) {
      add(name, "only in A", "", kNaN);
      continue;
    }
    const store::MapSource& other = found->second;
    const auto same_axes = [](const store::Map& x, const store::Map& y) {
      return std::equal(x.axes.begin(), x.axes.end(), y.axes.begin(), y.axes.end(),
                        [](const auto& p, const auto& q) { return p.name == q.name && p.values == q.values; });
    };
    if (!same_axes(*m.map, *other.map) || m.map->unit != other.map->unit) {
      add(name, "changed", "has other axes or another unit", kNaN);
      continue;
    }
    if (c.has_trials && !(c.out.same_seed && c.out.same_trials)) continue;  // chance moves it, and it has no interval
    std::size_t differing = 0;
    double largest = 0;
    const std::size_t size = store::map_size(*m.map);
    for (std::size_t at = 0; at < size; at += store::kStreamPiece) {
      const std::size_t n = std::min(store::kStreamPiece, size - at);
      const std::vector<double> x = m.values(at, n), y = other.values(at, n);
      for (std::size_t i = 0; i < n; ++i) {
        if (x[i] == y[i] || (std::isnan(x[i]) && std::isnan(y[i]))) continue;
        const double relative = std::abs(x[i] - y[i]) / std::max(std::abs(x[i]), std::abs(y[i]));
        if (relative <= c.rule.analytic) continue;
        ++differing;
        largest = std::isnan(relative) ? kInfinity : std::max(largest, relative);
      }
    }
    add(name, differing > 0 ? "changed" : "equal",
        differing > 0 ? fmt::format("{} of {} values, at most by the relative difference shown", differing, size) : "",
        largest);
  }
}

}  // namespace

Differences compare_results(const store::Result& a, const store::Result& b, const DifferenceRule& rule) {
  require(a.provenance.experiment == b.provenance.experiment,
          "the results are of different experiments: {} and {}: nothing to compare", a.provenance.experiment,
          b.provenance.experiment);
  Comparer c{rule, {}, a.provenance.trials > 0 || b.provenance.trials > 0};
  c.out.same_seed = a.provenance.seed == b.provenance.seed;
  c.out.same_trials = a.provenance.trials == b.provenance.trials;
  const auto find = [](const std::vector<store::Table>& tables, const std::string& name) {
    return std::find_if(tables.begin(), tables.end(), [&](const store::Table& t) { return t.name == name; });
  };
  const auto alone = [&](const store::Table& t, const char* finding) {
    c.out.rows.push_back(row_of(t.name, "", finding, "the whole table"));
  };
  for (const store::Table& t : a.tables) {
    if (t.name == compare::kAnswerTable) continue;  // its numbers are of the other tables
    const auto other = find(b.tables, t.name);
    if (other == b.tables.end())
      alone(t, "only in A");
    else
      compare_tables(c, store::rows_of(t, 0, t.rows()), store::rows_of(*other, 0, other->rows()));
  }
  for (const store::Table& t : b.tables)
    if (t.name != compare::kAnswerTable && find(a.tables, t.name) == a.tables.end()) alone(t, "only in B");
  compare_maps(c, a, b);

  // One value against several predictions is one hypothesis.
  std::vector<double> p;
  std::set<std::tuple<std::string, double, double, double>> seen;
  std::vector<std::size_t> of_row;
  for (std::size_t i = 0; i < c.out.rows.size(); ++i) {
    const DifferenceRow& r = c.out.rows[i];
    if (std::isnan(r.p)) continue;
    if (seen.emplace(r.table, r.a, r.b, r.standard_error).second) {
      p.push_back(r.p);
      of_row.push_back(i);
    }
  }
  c.out.judged = p.size();
  const std::vector<bool> rejected = compare::holm(p, rule.level);
  std::set<std::tuple<std::string, double, double, double>> differing;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const DifferenceRow& r = c.out.rows[of_row[k]];
    if (rejected[k]) differing.emplace(r.table, r.a, r.b, r.standard_error);
  }
  const double power = stats::normal_quantile(0.9);
  const double limit = p.empty() ? kNaN : stats::normal_quantile(1 - rule.level / (2 * static_cast<double>(p.size())));
  for (DifferenceRow& r : c.out.rows) {
    if (std::isnan(r.p)) continue;
    r.detectable = (limit + power) * r.standard_error;
    if (differing.contains({r.table, r.a, r.b, r.standard_error})) r.finding = "differs";
  }
  std::set<std::pair<std::string, std::string>> other_value;
  for (const DifferenceRow& r : c.out.rows)
    if (r.counts()) other_value.emplace(r.table, r.row);
  for (DifferenceRow& r : c.out.rows)
    if (r.finding == "verdict" && !other_value.contains({r.table, r.row}))
      r.note += ", by chance: the value does not differ beyond it";
  return std::move(c.out);
}

namespace {

/// Keys and their values, as TOML; tables of an array are numbered: "leg[0].from_md_m".
void add_leaves(const config::TomlNode& node, const std::string& key, std::map<std::string, std::string>& leaves) {
  if (node.is_table()) {
    for (const auto& [name, value] : node.entries) add_leaves(value, config::join_key(key, name), leaves);
  } else if (node.is_tables()) {
    for (std::size_t i = 0; i < node.items.size(); ++i)
      add_leaves(node.items[i], fmt::format("{}[{}]", key, i), leaves);
  } else {
    leaves[key] = config::toml_text(node);
  }
}

std::map<std::string, std::string> settings_of(const store::Result& r) {
  std::map<std::string, std::string> leaves;
  add_leaves(config::parse_document(r.provenance.config, "config"), "", leaves);
  for (const store::InputData& in : r.inputs) {
    if (in.path.starts_with("<shipped>")) continue;  // a key names it
    constexpr std::size_t kShortHash = 8;
    leaves["rows of " + in.path] = fmt::format("{} ({})", in.table.rows(), in.hash.substr(0, kShortHash));
  }
  return leaves;
}

}  // namespace

std::vector<KeyDifference> differing_keys(const store::Result& a, const store::Result& b) {
  const std::map<std::string, std::string> first = settings_of(a), second = settings_of(b);
  std::map<std::string, KeyDifference> all;
  for (const auto& [key, value] : first) all[key] = {key, value, ""};
  for (const auto& [key, value] : second) {
    all[key].key = key;
    all[key].b = value;
  }
  std::vector<KeyDifference> out;
  for (auto& [key, values] : all)
    if (values.a != values.b) out.push_back(std::move(values));
  return out;
}

store::Table difference_table(const Differences& d, bool all) {
  compare::TableRows t("differences",
                       fmt::format("B against A: {}", d.same_seed ? "common draws" : "independent draws"));
  std::vector<DifferenceRow> rows;
  for (const DifferenceRow& r : d.rows)
    if (all || r.counts() || r.finding == "verdict") rows.push_back(r);
  compare::write_rows(t, rows, [&](const DifferenceRow& r) {
    t.word("table", "table, or maps", r.table);
    t.word("row", "what names the row", r.row);
    t.word("column", "which value", r.column);
    t.word("finding", "differs, changed, only in A, only in B, other unit, other margin, verdict; equal, chance, few",
           r.finding);
    t.number("a", "1", "value in the first file", r.a);
    t.number("b", "1", "value in the second file", r.b);
    t.number("difference", "1", "ln(b / a) of sds, ratios and probabilities; b - a of means; b / a - 1 of predictions",
             r.difference);
    t.number("standard_error", "1", "of the difference", r.standard_error);
    t.number("p_value", "1", "two-sided, of this row alone", r.p);
    t.number("detectable", "1", "difference that would be found beside all rows with probability 0.9", r.detectable);
    t.word("note", "what else there is to say", r.note);
  });
  return t.take();
}

}  // namespace surveymc::sweep
