#pragma once
/// `surveymc show`: what is in a result file, for a terminal, as CSV, as JSON (docs/results-format.md).
#include <optional>
#include <string>

namespace surveymc::cli {

struct ShowArguments {
  std::string file;
  std::string name;  ///< of a table, samples or map; "": all of them
  bool list = false, csv = false, json = false;
  bool cost = false;        ///< what the rows cost, instead
  std::string units = "m";  ///< "ft": lengths of tables in feet
  std::optional<int> rows;  ///< most of a table; 0: all
  bool unchecked = false;   ///< the file is not verified: no more of it is read than is shown
};

/// Prints. Throws InputError where there is nothing of that name, IoError where the file cannot be read.
void show(const ShowArguments& a);

}  // namespace surveymc::cli
