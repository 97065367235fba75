#include "compare/annotations.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config/meanings.h"
#include "config/suggest.h"

namespace surveymc::compare {
namespace {

/// An entry without `formulation` is for every formulation.
bool covers(const Row& entry, const Row& row) {
  return entry.table == row.table && entry.quantity == row.quantity &&
         (entry.formulation.empty() || entry.formulation == row.formulation);
}

void require_known(const config::ConfigReader& entry, const std::string& key, const Row& name,
                   const std::vector<Row>& rows) {
  if (std::any_of(rows.begin(), rows.end(), [&](const Row& r) { return covers(name, r); })) return;
  std::vector<std::string> tables, quantities, formulations;
  const auto add = [](std::vector<std::string>& names, const std::string& other) {
    if (std::find(names.begin(), names.end(), other) == names.end()) names.push_back(other);
  };
  for (const Row& r : rows) {
    add(tables, r.table);
    if (r.table == name.table) add(quantities, r.quantity);
    if (r.table == name.table && r.quantity == name.quantity) add(formulations, r.formulation);
  }
  if (quantities.empty())
    entry.fail(key, fmt::format("no row of table \"{}\"; there is no such table{}", name.table,
                                config::suggestion(name.table, tables)));
  entry.fail(key, fmt::format("no row \"{}\"{}; the quantities of \"{}\" are {}{}", name.quantity,
                              name.formulation.empty() ? "" : " of \"" + name.formulation + "\"", name.table,
                              fmt::join(quantities, ", "),
                              formulations.empty() ? config::suggestion(name.quantity, quantities)
                                                   : config::suggestion(name.formulation, formulations)));
}

}  // namespace

PublishedEntry read_published(config::ConfigReader& entry) {
  PublishedEntry p;
  p.source = entry.text("source", "where the values were published");
  p.table = entry.text("table", config::meaning::kTableOfRow);
  p.values = entry.number_table("values", {}, "published values: { quantity = number }");
  p.here = entry.matches_point("at");
  return p;
}

Annotations Annotations::read(config::ConfigReader& config, const std::vector<Row>& rows) {
  Annotations a;
  for (config::ConfigReader& entry : config.tables("published", config::meaning::kPublished)) {
    const PublishedEntry published = read_published(entry);
    a.has_published_ = true;
    Row name{published.table,
             entry.has("formulation") ? entry.text("formulation", config::meaning::kFormulationOfRow) : "", ""};
    for (const auto& [quantity, value] : published.values) {
      name.quantity = quantity;
      require_known(entry, "values", name, rows);
      if (published.here) a.published_.push_back({name, value});
    }
  }
  for (config::ConfigReader& entry : config.tables("expect", "rows for which a verdict is expected")) {
    Row name{entry.text("table", config::meaning::kTableOfRow),
             entry.has("formulation") ? entry.text("formulation", config::meaning::kFormulationOfRow) : "", ""};
    const std::string verdict =
        entry.choice("verdict", {"agrees", "differs", "undecided"}, config::meaning::kExpectedVerdict);
    const bool here = entry.matches_point("at");
    for (const std::string& quantity : entry.texts("quantities", "quantities of the rows that are meant")) {
      name.quantity = quantity;
      require_known(entry, "quantities", name, rows);
      if (here) a.expected_.push_back({name, verdict});
    }
  }
  return a;
}

std::string Annotations::expected(const std::string& table, const std::string& formulation,
                                  const std::string& quantity) const {
  std::string verdict;
  for (const Expected& e : expected_)
    if (covers(e.row, {table, formulation, quantity})) verdict = e.verdict;
  return verdict;
}

std::vector<std::string> Annotations::expected_formulations(const std::string& table) const {
  std::vector<std::string> out;
  for (const Expected& e : expected_)
    if (e.row.table == table && !e.row.formulation.empty() &&
        std::find(out.begin(), out.end(), e.row.formulation) == out.end())
      out.push_back(e.row.formulation);
  return out;
}

void Annotations::apply(const std::string& table, std::vector<ComparisonRow>& rows) const {
  for (ComparisonRow& row : rows) {
    for (const Published& p : published_)
      if (covers(p.row, {table, row.formulation, row.quantity})) row.published = p.value;
    row.expected = expected(table, row.formulation, row.quantity);
  }
}

}  // namespace surveymc::compare
