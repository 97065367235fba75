#include "compare/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "base/error.h"
#include "compare/table_rows.h"
#include "config/suggest.h"
#include "stats/intervals.h"
#include "stats/variance_shares.h"

namespace surveymc::compare {
namespace {

using Groups = std::vector<std::uint32_t>;

const store::Table& table_of_quantity(const config::SensitivityRule& rule,
                                      const config::SensitivityRule::Quantity& quantity,
                                      const std::vector<store::Table>& tables) {
  for (const store::Table& t : tables)
    if (t.name == quantity.table) {
      const store::Column* c = t.find_column(quantity.column);
      std::vector<std::string> names;
      for (const store::Column& other : t.columns) names.push_back(other.name);
      require(c != nullptr, "sensitivity.quantity: table {} has no column {}; it has {}{}", t.name, quantity.column,
              fmt::join(names, ", "), config::suggestion(quantity.column, names));
      require(std::holds_alternative<std::vector<double>>(c->values),
              "sensitivity.quantity: {}.{} must be a column of numbers", t.name, quantity.column);
      for (const auto& [column, word] : rule.where) {
        const store::Column* words = t.find_column(column);
        require(words != nullptr && std::holds_alternative<std::vector<std::string>>(words->values),
                "sensitivity.where: table {} has no column {} of words", t.name, column);
      }
      return t;
    }
  std::vector<std::string> names;
  for (const store::Table& t : tables) names.push_back(t.name);
  throw InputError(fmt::format("sensitivity.quantity: the result has no table {}{}", quantity.table,
                               config::suggestion(quantity.table, names)));
}

/// A key of the sweep with its value at every point that counts.
struct Key {
  std::string name;
  std::vector<double> numbers = {};     ///< of a numeric key
  std::vector<std::string> words = {};  ///< of another
};

struct Sample {
  std::vector<double> y;
  std::vector<Key> keys;
};

Sample sample_of(const config::SensitivityRule& rule, const config::SensitivityRule::Quantity& quantity,
                 const store::Table& table, std::size_t points) {
  Sample s;
  for (const store::Column& c : table.columns)
    if (c.long_name == "sweep key") s.keys.push_back({c.name});
  std::size_t rows = 0;
  store::for_each_piece(table, [&](const store::Table& piece, std::size_t) {
    const auto& values = std::get<std::vector<double>>(piece.column(quantity.column).values);
    for (std::size_t row = 0; row < piece.rows(); ++row) {
      const bool chosen = std::all_of(rule.where.begin(), rule.where.end(), [&](const auto& w) {
        return std::get<std::vector<std::string>>(piece.column(w.first).values)[row] == w.second;
      });
      if (!chosen) continue;
      ++rows;
      const double y = rule.of_logarithm ? std::log(values[row]) : values[row];
      if (!std::isfinite(y)) continue;
      s.y.push_back(y);
      for (Key& key : s.keys) {
        const store::Values& v = piece.column(key.name).values;
        if (const auto* numbers = std::get_if<std::vector<double>>(&v))
          key.numbers.push_back((*numbers)[row]);
        else
          key.words.push_back(std::get<std::vector<std::string>>(v)[row]);
      }
    }
  });
  require(rows <= points, "sensitivity.quantity: a point has several rows in table {}: choose one by where",
          table.name);
  require(s.y.size() >= 20, "sensitivity.quantity: {} points have a finite {}.{}: must be at least 20", s.y.size(),
          quantity.table, quantity.column);
  return s;
}

constexpr std::uint32_t kAllValues = std::numeric_limits<std::uint32_t>::max();

struct Grouping {
  Groups group;
  std::uint32_t count = 0;
  bool has_slopes = false;  ///< numbers that vary within the groups
};

template <class T>
Grouping grouped(const std::vector<T>& values, std::uint32_t most) {
  const std::set<T> distinct(values.begin(), values.end());
  Grouping g;
  const auto all = static_cast<double>(distinct.size());
  g.count = static_cast<std::uint32_t>(std::min<std::size_t>(distinct.size(), most));
  g.has_slopes = g.count < distinct.size();
  std::map<T, std::uint32_t> of_value;
  double rank = 0;
  for (const T& v : distinct) of_value[v] = static_cast<std::uint32_t>(rank++ * g.count / all);
  for (const T& v : values) g.group.push_back(of_value.at(v));
  return g;
}

Grouping grouped(const Key& key, std::uint32_t most) {
  return key.words.empty() ? grouped(key.numbers, most) : grouped(key.words, kAllValues);
}

/// True if every value of every key stands once with all values of the others: then the points are all that there is.
/// Of a single key with a point a value its groups tell more.
bool is_complete_product(const Sample& s) {
  if (s.keys.size() < 2) return false;
  std::set<std::vector<std::uint32_t>> places;
  std::vector<std::vector<std::uint32_t>> place(s.y.size());
  double product = 1;
  for (const Key& key : s.keys) {
    const Grouping g = grouped(key, kAllValues);
    product *= g.count;
    for (std::size_t i = 0; i < place.size(); ++i) place[i].push_back(g.group[i]);
  }
  if (product != static_cast<double>(s.y.size())) return false;
  places.insert(place.begin(), place.end());
  return places.size() == s.y.size();
}

/// An estimate with what may have to be added to it, which is below 0 of what others are taken from: `missed`, as a key
/// varies within its groups, and `even`, as a design fills them more evenly than chance.
struct Estimated {
  double value = 0, missed = 0, even = 0;
};
struct Share : Estimated {
  std::vector<double> influence;  ///< of the values
};

struct ShareRow {
  std::string order, input;
  std::uint64_t groups;
  Estimated share;
  double standard_error, trend = kNaN;
};

/// Within [0, 1], as the share itself is, but where the estimate lies beyond.
stats::Interval interval_of(const ShareRow& r, double z) {
  const Estimated& s = r.share;
  const double half = z * r.standard_error, lo = s.value - half + std::min(0.0, s.missed) + std::min(0.0, s.even),
               hi = s.value + half + std::max(0.0, s.missed) + std::max(0.0, s.even);
  if (std::isnan(half)) return {kNaN, kNaN};
  return {s.value < 0 ? lo : std::max(lo, 0.0), s.value > 1 ? hi : std::min(hi, 1.0)};
}

void add(Share& a, const Share& b, double sign) {
  a.value += sign * b.value;
  a.missed += sign * b.missed;
  a.even += sign * b.even;
  for (std::size_t i = 0; i < a.influence.size(); ++i) a.influence[i] += sign * b.influence[i];
}

/// True if a design such as Sobol's fills the cells of two keys more evenly than chance: chi-squared below half of its
/// mean.
bool is_even(const std::vector<Grouping>& keys) {
  double squares = 0, freedom = 0;
  for (std::size_t a = 0; a < keys.size(); ++a)
    for (std::size_t b = a + 1; b < keys.size(); ++b) {
      std::vector<double> of_a(keys[a].count, 0), of_b(keys[b].count, 0), of_both(keys[a].count * keys[b].count, 0);
      for (std::size_t i = 0; i < keys[a].group.size(); ++i) {
        of_a[keys[a].group[i]] += 1;
        of_b[keys[b].group[i]] += 1;
        of_both[keys[a].group[i] * keys[b].count + keys[b].group[i]] += 1;
      }
      for (std::uint32_t i = 0; i < keys[a].count; ++i)
        for (std::uint32_t k = 0; k < keys[b].count; ++k) {
          const double expected = of_a[i] * of_b[k] / static_cast<double>(keys[a].group.size()),
                       d = of_both[i * keys[b].count + k] - expected;
          squares += d * d / expected;
        }
      freedom += (keys[a].count - 1.0) * (keys[b].count - 1.0);
    }
  return freedom > 0 && squares < freedom / 2;
}

std::vector<ShareRow> rows_of(const Sample& s) {
  const double n = static_cast<double>(s.y.size());
  const bool is_whole = is_complete_product(s);
  const auto fine = is_whole ? kAllValues : static_cast<std::uint32_t>(std::clamp(std::round(std::cbrt(n)), 3.0, 32.0));
  const auto coarse =
      is_whole ? kAllValues : static_cast<std::uint32_t>(std::clamp(std::floor(std::sqrt(n / 16)), 3.0, 1.0 * fine));
  std::vector<Grouping> coarsely;
  for (const Key& key : s.keys) coarsely.push_back(grouped(key, coarse));
  const bool even = !is_whole && is_even(coarsely);
  /// Of a whole product every value is a group. Else a slope by each numeric key within each group shows what the group
  /// leaves out; it joins the estimate of a key alone (`with_slopes`), where it costs no precision.
  const auto share_of = [&](const Grouping& g, const std::vector<const Key*>& of, bool with_slopes) {
    if (is_whole) return Share{{stats::share_of_groups(s.y, g.group, g.count)}, std::vector<double>(s.y.size(), kNaN)};
    std::vector<const std::vector<double>*> slopes;
    for (const Key* key : of)
      if (!key->numbers.empty()) slopes.push_back(&key->numbers);
    const auto result = [&](stats::ExplainedShare e, double missed) {
      return Share{{e.share, missed, even ? e.of_squares - e.share : 0}, std::move(e.influence)};
    };
    stats::ExplainedShare level = stats::explained_share(s.y, g.group, g.count),
                          sloped = stats::explained_share(s.y, g.group, g.count, slopes);
    const double missed = std::isnan(sloped.share) ? 0 : sloped.share - level.share;
    if (with_slopes && !std::isnan(sloped.share)) return result(std::move(sloped), missed);
    return result(std::move(level), 2 * missed);
  };
  // Of a whole product there is no error. Else not less than chance gives to a share of nothing.
  const auto error_of = [&](const Share& e, double freedom) {
    const double least = std::clamp(1 - e.value, 0.0, 1.0) * stats::chance_of_share(freedom, n);
    return std::max(stats::standard_error_of(e.influence), least);
  };
  const std::size_t keys = s.keys.size();
  std::vector<ShareRow> first, with_pairs, pairs;
  std::vector<Share> total, by_coarse;
  std::vector<double> freedom;  // of `total`
  Share rest{{1}, std::vector<double>(s.y.size(), 0)};
  double freedom_of_all = 0;
  for (const Key& key : s.keys) {
    const Grouping finely = grouped(key, fine);
    total.push_back(share_of(finely, {&key}, true));
    freedom.push_back(finely.count - 1.0 + (finely.has_slopes ? finely.count : 0));
    freedom_of_all += freedom.back();
    by_coarse.push_back(share_of(coarsely[by_coarse.size()], {&key}, false));
    add(rest, total.back(), -1);
    first.push_back({"first", key.name, finely.count, total.back(), error_of(total.back(), freedom.back()),
                     key.words.empty() ? stats::rank_correlation(key.numbers, s.y) : kNaN});
  }
  for (std::size_t a = 0; a < keys; ++a)
    for (std::size_t b = a + 1; b < keys; ++b) {
      Grouping both{Groups(s.y.size()), coarsely[a].count * coarsely[b].count};
      for (std::size_t i = 0; i < both.group.size(); ++i)
        both.group[i] = coarsely[a].group[i] * coarsely[b].count + coarsely[b].group[i];
      const double own = (coarsely[a].count - 1.0) * (coarsely[b].count - 1.0);
      freedom_of_all += own;
      Share pair = share_of(both, {&s.keys[a], &s.keys[b]}, false);
      for (const std::size_t one : {a, b}) add(pair, by_coarse[one], -1);
      pairs.push_back({"pair", s.keys[a].name + " x " + s.keys[b].name, both.count, pair, error_of(pair, own)});
      for (const std::size_t one : {a, b}) {
        add(total[one], pair, 1);
        freedom[one] += own;
      }
      add(rest, pair, -1);
    }
  for (std::size_t a = 0; a < keys; ++a)
    with_pairs.push_back(
        {"with pairs", s.keys[a].name, first[a].groups, total[a], error_of(total[a], freedom[a]), first[a].trend});
  std::vector<ShareRow> out;
  for (std::vector<ShareRow>* rows : {&first, &with_pairs, &pairs}) {
    std::stable_sort(rows->begin(), rows->end(),
                     [](const ShareRow& a, const ShareRow& b) { return a.share.value > b.share.value; });
    out.insert(out.end(), rows->begin(), rows->end());
  }
  const double least = stats::chance_of_share(freedom_of_all, n);
  out.push_back({"rest", "", 0, rest, std::max(stats::standard_error_of(rest.influence), least)});
  return out;
}

}  // namespace

void check_sensitivity(const config::SensitivityRule& rule, const std::vector<store::Table>& tables) {
  for (const config::SensitivityRule::Quantity& q : rule.quantities) table_of_quantity(rule, q, tables);
}

store::Table sensitivity_table(const config::SensitivityRule& rule, const std::vector<store::Table>& tables,
                               std::size_t points) {
  TableRows t(kSensitivityTable,
              fmt::format("which keys of the sweep explain the variance of a quantity{}; intervals at {:g} % for all "
                          "rows of a quantity together",
                          rule.of_logarithm ? "'s logarithm" : "", 100 * rule.confidence));
  for (const config::SensitivityRule::Quantity& q : rule.quantities) {
    const Sample s = sample_of(rule, q, table_of_quantity(rule, q, tables), points);
    const std::vector<ShareRow> rows = rows_of(s);
    const double z = stats::normal_quantile(1 - (1 - rule.confidence) / 2 / static_cast<double>(rows.size()));
    for (const ShareRow& r : rows) {
      t.word("quantity", "what is explained", q.table + "." + q.column);
      t.word("order",
             "first: a key alone; pair: two keys beyond that; with pairs: a key and its pairs; rest: the others",
             r.order);
      t.word("input", "key of the sweep, or two", r.input);
      t.count("groups", "groups of its values", r.groups);
      t.estimate("share", "1", "of the variance; chance may make it less than 0", r.share.value, interval_of(r, z));
      t.number("trend", "1", "correlation of ranks: which way the quantity goes with the key", r.trend);
      t.count("points", "points that have the quantity", static_cast<std::uint64_t>(s.y.size()));
    }
  }
  return t.take();
}

}  // namespace surveymc::compare
