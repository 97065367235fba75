#include "cli/load_run.h"

#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "study/input_tables.h"

namespace surveymc::cli {
namespace {

/// Throws IoError unless `ok`: the file says that surveymc has written it, but this is not how surveymc writes.
void require_form(bool ok, const store::InputData& in) {
  if (!ok) throw IoError(fmt::format("the file {} that is stored in it is not as surveymc stores files", in.path));
}

/// The values of the column with this name, of this type.
template <class T>
const std::vector<T>& values_of(const store::InputData& in, const std::string& name) {
  for (const store::Column& c : in.table.columns)
    if (const auto* values = std::get_if<std::vector<T>>(&c.values); c.name == name && values && !values->empty())
      return *values;
  throw IoError(fmt::format("the file {} that is stored in it has no column {}", in.path, name));
}

}  // namespace

config::StoredInputs stored_inputs(const store::Result& result) {
  config::StoredInputs files;
  for (const store::InputData& in : result.inputs) {
    const store::Table& t = in.table;
    require_form(!t.columns.empty(), in);
    if (std::holds_alternative<std::vector<std::string>>(t.columns.front().values)) {
      if (t.columns.front().name == "line")
        files.texts.push_back({in.path, fmt::format("{}", fmt::join(values_of<std::string>(in, "line"), "\n"))});
      else
        files.references.push_back({in.path, static_cast<std::uint64_t>(values_of<std::int64_t>(in, "size_bytes")[0]),
                                    values_of<std::string>(in, "file_hash")[0],
                                    values_of<std::string>(in, "header")[0]});
      continue;
    }
    config::InputTable read;
    read.path = in.path;
    const std::vector<std::int64_t>* lines = nullptr;
    for (const store::Column& c : t.columns) {
      if (c.name == study::kLineColumn && (lines = std::get_if<std::vector<std::int64_t>>(&c.values))) continue;
      const auto* numbers = std::get_if<std::vector<double>>(&c.values);
      require_form(numbers != nullptr, in);
      read.names.push_back(c.name);
      read.columns.push_back(*numbers);
    }
    for (std::size_t row = 0; row < t.rows(); ++row)
      read.lines.push_back(lines ? static_cast<int>((*lines)[row]) : static_cast<int>(row) + 2);
    files.tables.push_back(std::move(read));
  }
  return files;
}

}  // namespace surveymc::cli
