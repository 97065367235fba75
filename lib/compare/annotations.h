#pragma once
/// Published values and expected verdicts that a config gives for rows of its tables.
#include <string>
#include <vector>

#include "compare/comparison.h"
#include "compare/row.h"
#include "config/config.h"

namespace surveymc::compare {

/// The keys of an entry of `[[published]]` that every study reads: `source, table, values = { quantity = number }, at
/// (optional)`. `at = { "noise.scale" = 1.0 }` limits an entry to those points of the sweep.
struct PublishedEntry {
  std::string source, table;
  std::vector<std::pair<std::string, double>> values;
  bool here = true;  ///< the entry is for this point
};
PublishedEntry read_published(config::ConfigReader& entry);

/// `[[published]]` as above with `formulation (optional)`, and
/// `[[expect]] table, formulation (optional), quantities = [...], verdict, at (optional)`.
/// Later entries win.
class Annotations {
 public:
  /// Throws InputError for a table, formulation or quantity that is not among `rows`.
  static Annotations read(config::ConfigReader& config, const std::vector<Row>& rows);

  /// True if the config has published values, for this point or for another.
  bool has_published() const { return has_published_; }
  /// Fills published and expected of the rows of one table.
  void apply(const std::string& table, std::vector<ComparisonRow>& rows) const;
  /// Expected verdict of a row of a table that is not a comparison table; "" if none is given.
  std::string expected(const std::string& table, const std::string& formulation, const std::string& quantity) const;
  /// Formulations that expectations of this point name, each once.
  std::vector<std::string> expected_formulations(const std::string& table) const;

 private:
  struct Published {
    Row row;
    double value;
  };
  struct Expected {
    Row row;
    std::string verdict;
  };
  std::vector<Published> published_;
  std::vector<Expected> expected_;
  bool has_published_ = false;
};

}  // namespace surveymc::compare
