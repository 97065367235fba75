#include "study/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "base/error.h"
#include "stats/intervals.h"
#include "stats/variance_shares.h"
#include "study/table_rows.h"

namespace surveymc::study {
namespace {

using Groups = std::vector<std::uint32_t>;

const store::Table& table_of_quantity(const config::SensitivityRule& rule,
                                      const config::SensitivityRule::Quantity& quantity,
                                      const std::vector<store::Table>& tables) {
  for (const store::Table& t : tables)
    if (t.name == quantity.table) {
      const store::Column* c = t.find_column(quantity.column);
      std::string names;
      for (const store::Column& other : t.columns) names += (names.empty() ? "" : ", ") + other.name;
      require(c != nullptr, "sensitivity.quantity: table {} has no column {}; it has {}", t.name, quantity.column,
              names);
      require(std::holds_alternative<std::vector<double>>(c->values),
              "sensitivity.quantity: {}.{} must be a column of numbers", t.name, quantity.column);
      for (const auto& [column, word] : rule.where) {
        const store::Column* words = t.find_column(column);
        require(words != nullptr && std::holds_alternative<std::vector<std::string>>(words->values),
                "sensitivity.where: table {} has no column {} of words", t.name, column);
      }
      return t;
    }
  throw InputError(fmt::format("sensitivity.quantity: the result has no table {}", quantity.table));
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
};

template <class T>
Grouping grouped(const std::vector<T>& values, std::uint32_t most) {
  const std::set<T> distinct(values.begin(), values.end());
  Grouping g;
  const auto all = static_cast<double>(distinct.size());
  g.count = static_cast<std::uint32_t>(std::min<std::size_t>(distinct.size(), most));
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

struct Row {
  std::string order, input;
  std::uint64_t groups;
  double share, standard_error, trend = kNaN;
};

/// Within [0, 1], as the share itself is, but for an estimate beyond.
stats::Interval interval_of(double share, double half_width) {
  if (std::isnan(half_width)) return {kNaN, kNaN};
  return {std::min(share, std::clamp(share - half_width, 0.0, 1.0)),
          std::max(share, std::clamp(share + half_width, 0.0, 1.0))};
}

/// a + sign b, value by value.
void add(std::vector<double>& a, const std::vector<double>& b, double sign) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += sign * b[i];
}

std::vector<Row> rows_of(const Sample& s) {
  const double n = static_cast<double>(s.y.size());
  const bool is_whole = is_complete_product(s);
  const auto share_of = [&](const Groups& group, std::uint32_t count) {
    if (!is_whole) return stats::explained_share(s.y, group, count);
    return stats::ExplainedShare{stats::share_of_groups(s.y, group, count), std::vector<double>(s.y.size(), kNaN)};
  };
  // Of a whole product there is no error. Else not less than chance gives to a share of nothing.
  const auto error_of = [&](const stats::ExplainedShare& e, double freedom) {
    const double least = std::clamp(1 - e.share, 0.0, 1.0) * stats::chance_of_share(freedom, n);
    return std::max(stats::standard_error_of(e.influence), least);
  };
  const auto fine = is_whole ? kAllValues : static_cast<std::uint32_t>(std::clamp(std::round(std::cbrt(n)), 2.0, 32.0));
  const auto coarse =
      is_whole ? kAllValues : static_cast<std::uint32_t>(std::clamp(std::floor(std::sqrt(n / 16)), 2.0, 1.0 * fine));
  const std::size_t keys = s.keys.size();
  std::vector<Row> first, with_pairs, pairs;
  std::vector<stats::ExplainedShare> total, by_coarse;
  std::vector<double> freedom;  // of `total`
  std::vector<Grouping> coarsely;
  stats::ExplainedShare rest{1, std::vector<double>(s.y.size(), 0)};
  double freedom_of_all = 0;
  for (const Key& key : s.keys) {
    const Grouping finely = grouped(key, fine);
    coarsely.push_back(grouped(key, coarse));
    total.push_back(share_of(finely.group, finely.count));
    freedom.push_back(finely.count - 1.0);
    freedom_of_all += freedom.back();
    by_coarse.push_back(share_of(coarsely.back().group, coarsely.back().count));
    rest.share -= total.back().share;
    add(rest.influence, total.back().influence, -1);
    first.push_back({"first", key.name, finely.count, total.back().share, error_of(total.back(), freedom.back()),
                     key.words.empty() ? stats::rank_correlation(key.numbers, s.y) : kNaN});
  }
  for (std::size_t a = 0; a < keys; ++a)
    for (std::size_t b = a + 1; b < keys; ++b) {
      Groups both(s.y.size());
      for (std::size_t i = 0; i < both.size(); ++i)
        both[i] = coarsely[a].group[i] * coarsely[b].count + coarsely[b].group[i];
      const std::uint32_t cells = coarsely[a].count * coarsely[b].count;
      const double own = (coarsely[a].count - 1.0) * (coarsely[b].count - 1.0);
      freedom_of_all += own;
      stats::ExplainedShare pair = share_of(both, cells);
      for (const std::size_t one : {a, b}) {
        pair.share -= by_coarse[one].share;
        add(pair.influence, by_coarse[one].influence, -1);
      }
      pairs.push_back({"pair", s.keys[a].name + " x " + s.keys[b].name, cells, pair.share, error_of(pair, own)});
      for (const std::size_t one : {a, b}) {
        total[one].share += pair.share;
        freedom[one] += own;
        add(total[one].influence, pair.influence, 1);
      }
      rest.share -= pair.share;
      add(rest.influence, pair.influence, -1);
    }
  for (std::size_t a = 0; a < keys; ++a)
    with_pairs.push_back({"with pairs", s.keys[a].name, first[a].groups, total[a].share, error_of(total[a], freedom[a]),
                          first[a].trend});
  std::vector<Row> out;
  for (std::vector<Row>* rows : {&first, &with_pairs, &pairs}) {
    std::stable_sort(rows->begin(), rows->end(), [](const Row& a, const Row& b) { return a.share > b.share; });
    out.insert(out.end(), rows->begin(), rows->end());
  }
  const double least = stats::chance_of_share(freedom_of_all, n);
  out.push_back({"rest", "", 0, rest.share, std::max(stats::standard_error_of(rest.influence), least)});
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
    const std::vector<Row> rows = rows_of(s);
    const double z = stats::normal_quantile(1 - (1 - rule.confidence) / 2 / static_cast<double>(rows.size()));
    for (const Row& r : rows) {
      t.word("quantity", "what is explained", q.table + "." + q.column);
      t.word("order",
             "first: a key alone; pair: two keys beyond that; with pairs: a key and its pairs; rest: the others",
             r.order);
      t.word("input", "key of the sweep, or two", r.input);
      t.count("groups", "groups of its values", r.groups);
      t.estimate("share", "1", "of the variance; chance may make it less than 0", r.share,
                 interval_of(r.share, z * r.standard_error));
      t.number("trend", "1", "correlation of ranks: which way the quantity goes with the key", r.trend);
      t.count("points", "points that have the quantity", static_cast<std::uint64_t>(s.y.size()));
    }
  }
  return t.take();
}

}  // namespace surveymc::study
