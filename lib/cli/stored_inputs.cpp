#include "cli/stored_inputs.h"

#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace surveymc::cli {

StoredInputs stored_inputs(const store::Result& result) {
  StoredInputs files;
  for (const store::InputData& in : result.inputs) {
    const store::Table& t = in.table;
    if (const auto* words = std::get_if<std::vector<std::string>>(&t.columns.front().values)) {
      if (t.columns.front().name == "line")
        files.texts.push_back({in.path, fmt::format("{}", fmt::join(*words, "\n"))});
      else
        files.references.push_back(
            {in.path, static_cast<std::uint64_t>(std::get<std::vector<std::int64_t>>(t.column("size_bytes").values)[0]),
             words->front(), std::get<std::vector<std::string>>(t.column("header").values)[0]});
      continue;
    }
    config::InputTable read;
    read.path = in.path;
    for (const store::Column& c : t.columns) {
      read.names.push_back(c.name);
      read.columns.push_back(std::get<std::vector<double>>(c.values));
    }
    for (std::size_t row = 0; row < t.rows(); ++row) read.lines.push_back(static_cast<int>(row) + 2);
    files.tables.push_back(std::move(read));
  }
  return files;
}

}  // namespace surveymc::cli
