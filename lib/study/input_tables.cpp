#include "study/input_tables.h"

#include "study/sweep_columns.h"

namespace surveymc::study {
namespace {

store::Table table_of(const config::InputTable& in) {
  store::Table t{in.path, "as read from " + in.path};
  for (std::size_t c = 0; c < in.names.size(); ++c) {
    t.columns.push_back({in.names[c], unit_of_name(in.names[c]), "column of the user's file", in.columns[c]});
  }
  // Blank lines and comments are not kept: messages about the rows name their lines all the same.
  const std::vector<std::int64_t> lines(in.lines.begin(), in.lines.end());
  bool is_regular = true;
  for (std::size_t row = 0; row < lines.size(); ++row)
    is_regular = is_regular && lines[row] == static_cast<std::int64_t>(row) + 2;
  if (!is_regular && in.find(kLineColumn) < 0)
    t.columns.push_back({kLineColumn, "1", "line of the row in the user's file", lines});
  return t;
}

/// One row a line of the text; joined by line feeds, the rows are the text again.
store::Table table_of(const config::InputText& in) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
    end = in.text.find('\n', begin);
    lines.push_back(in.text.substr(begin, end - begin));
  }
  return {in.path, "as read from " + in.path, {{"line", "", "line of the file", std::move(lines)}}};
}

/// One row: hash, size and header, which identify the file.
store::Table table_of(const config::InputReference& in) {
  return {in.path,
          "not stored, as it is too large: what identifies " + in.path,
          {{"file_hash", "", "128-bit XXH3 of the bytes of the file, in hex", std::vector<std::string>{in.hash}},
           {"size_bytes", "1", "bytes of the file", std::vector<std::int64_t>{static_cast<std::int64_t>(in.size)}},
           {"header", "", "its first line that is no comment", std::vector<std::string>{in.header}}}};
}

}  // namespace

std::vector<store::InputData> input_tables(const config::Config& config) {
  std::vector<store::InputData> inputs;
  const auto add = [&](const auto& files) {
    for (const auto& in : files) {
      const store::Table t = table_of(in);
      inputs.push_back({in.path, store::input_hash(t), t});
    }
  };
  add(config.inputs());
  add(config.input_texts());
  add(config.input_references());
  return inputs;
}

}  // namespace surveymc::study
