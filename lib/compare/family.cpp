#include "compare/family.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "base/units.h"
#include "compare/table_rows.h"

namespace surveymc::compare {
namespace {

using Words = std::vector<std::string>;

constexpr const char *kFamilyColumn = "family", *kWishartColumn = "wishart_family";

/// The columns of a table that belong to a family.
struct FamilyColumns {
  const Words *verdict = nullptr, *expected = nullptr;
  const std::vector<double>*p_differs = nullptr, *p_agrees = nullptr, *wishart_p = nullptr;
  bool has_family = false, has_wishart_family = false;

  bool has_verdicts() const { return verdict && p_differs && p_agrees && has_family; }
  bool has_tests() const { return wishart_p && has_wishart_family; }
};

FamilyColumns family_columns(const store::Table& t) {
  FamilyColumns f;
  for (const store::Column& c : t.columns) {
    if (c.name == "verdict") f.verdict = std::get_if<Words>(&c.values);
    if (c.name == "expected") f.expected = std::get_if<Words>(&c.values);
    if (c.name == "p_differs") f.p_differs = std::get_if<std::vector<double>>(&c.values);
    if (c.name == "p_agrees") f.p_agrees = std::get_if<std::vector<double>>(&c.values);
    if (c.name == "wishart_p") f.wishart_p = std::get_if<std::vector<double>>(&c.values);
    f.has_family = f.has_family || c.name == kFamilyColumn;
    f.has_wishart_family = f.has_wishart_family || c.name == kWishartColumn;
  }
  return f;
}

/// Words by row, of one column.
using WordsByRow = std::map<std::size_t, const char*>;

/// The table with these words in these columns; the other rows as they are.
store::Table with_words(const store::Table& t, const std::map<std::string, WordsByRow>& words) {
  store::Table out;
  store::for_each_piece(t, [&](const store::Table& piece, std::size_t first) {
    store::Table part = piece;
    for (store::Column& c : part.columns)
      if (const auto of = words.find(c.name); of != words.end())
        for (auto w = of->second.lower_bound(first); w != of->second.end() && w->first < first + piece.rows(); ++w)
          std::get<Words>(c.values)[w->first - first] = w->second;
    store::append_rows(out, part);
  });
  return out;
}

}  // namespace

std::vector<bool> holm(const std::vector<double>& p, double level) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!std::isnan(p[i])) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });
  std::vector<bool> rejected(p.size(), false);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (!(p[order[k]] <= level / static_cast<double>(order.size() - k))) break;
    rejected[order[k]] = true;
  }
  return rejected;
}

double benjamini_hochberg_share(const std::vector<double>& p, double accepted) {
  std::vector<double> rising = p;
  std::sort(rising.begin(), rising.end());
  const auto k = std::upper_bound(rising.begin(), rising.end(), accepted) - rising.begin();
  if (k == 0) return 0;
  // q of one row is the smallest n p / k of it and of those behind it.
  double share = 1;
  for (auto i = static_cast<std::size_t>(k); i <= rising.size(); ++i)
    share = std::min(share, static_cast<double>(rising.size()) * rising[i - 1] / static_cast<double>(i));
  return share;
}

void apply_family(std::vector<store::Table>& tables) {
  struct Place {
    std::size_t table, row;
    const char* column;
    bool accuses;  ///< a row that differs; a test whose p is below the level
  };
  std::vector<Place> places;
  std::vector<double> p_differs, p_agrees;
  std::size_t verdicts = 0, agrees = 0, differs = 0, undecided = 0;
  double last_agreed = kNaN;  // largest p of a row that agrees
  const auto collect = [&](std::size_t table, const store::Table& piece, std::size_t first) {
    const FamilyColumns f = family_columns(piece);
    for (std::size_t i = 0; i < piece.rows(); ++i) {
      if (f.expected && (*f.expected)[i] == "differs") continue;
      if (const double p = f.has_tests() ? (*f.wishart_p)[i] : kNaN; !std::isnan(p)) {
        places.push_back({table, first + i, kWishartColumn, p < kFamilyLevel});
        p_differs.push_back(p);
      }
      if (!f.has_verdicts()) continue;
      const std::string& verdict = (*f.verdict)[i];
      const double p = (*f.p_differs)[i], q = (*f.p_agrees)[i];
      if (verdict.empty() || std::isnan(p)) continue;
      places.push_back({table, first + i, kFamilyColumn, verdict == "differs"});
      p_differs.push_back(p);
      ++verdicts;
      agrees += verdict == "agrees";
      differs += verdict == "differs";
      undecided += verdict == "undecided";
      if (std::isnan(q)) continue;  // a test without a margin says nothing for "agrees"
      p_agrees.push_back(q);
      if (verdict == "agrees") last_agreed = std::fmax(last_agreed, q);
    }
  };
  for (std::size_t table = 0; table < tables.size(); ++table)
    if (const FamilyColumns f = family_columns(tables[table]); f.has_verdicts() || f.has_tests())
      store::for_each_piece(tables[table],
                            [&](const store::Table& piece, std::size_t first) { collect(table, piece, first); });
  if (places.empty()) return;
  const std::vector<bool> rejected = holm(p_differs, kFamilyLevel);
  std::size_t surviving = 0, tests_surviving = 0;
  std::map<std::size_t, std::map<std::string, WordsByRow>> words;  // by table
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i].accuses) continue;
    (places[i].column == kFamilyColumn ? surviving : tests_surviving) += rejected[i];
    words[places[i].table][places[i].column][places[i].row] = rejected[i] ? kDiffersInFamily : kMayBeChance;
  }
  for (const auto& [table, of_columns] : words) tables[table] = with_words(tables[table], of_columns);
  TableRows t(kFamilyTable,
              "the verdicts of all rows of this file together; those that are expected to differ stay out");
  t.count("verdicts", "rows with a verdict and a p-value", verdicts);
  t.count("agrees", "of them, rows that agree", agrees);
  t.count("differs", "of them, rows that differ", differs);
  t.count("undecided", "of them, rows that are undecided", undecided);
  t.count("differs_holm", "rows that differ among all of them, and the tests: Holm at 5 %", surviving);
  t.number("agrees_q", "1", "share of the rows that agree which may be wrong (Benjamini and Hochberg)",
           agrees == 0               ? 0
           : std::isnan(last_agreed) ? kNaN  // no row that agrees has a p
                                     : benjamini_hochberg_share(p_agrees, last_agreed));
  t.count("tests", "Wishart tests of whole covariances, which join with their own p", p_differs.size() - verdicts);
  t.count("tests_holm", "of them, those that find a difference among all: Holm at 5 %", tests_surviving);
  tables.push_back(t.take());
}

}  // namespace surveymc::compare
