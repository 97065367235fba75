#include "cli/file_kind.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/shell_word.h"
#include "base/small_letters.h"
#include "checkpoint/journal.h"
#include "checkpoint/part_file.h"
#include "cli/exit_codes.h"
#include "render/text.h"
#include "store/result_file.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

bool has_any(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return text.find(w) != std::string::npos; });
}

std::string head_of(const fs::path& path) {
  std::string head(std::size_t{1} << 16, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head;
}

/// Lines without blanks in front that are neither empty nor comments.
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const std::size_t begin = line.find_first_not_of(" \t\r\xEF\xBB\xBF");
    if (begin != std::string::npos && line[begin] != '#') lines.push_back(line.substr(begin));
  }
  return lines;
}

/// A line of TOML that gives this key its value.
bool begins_with_key(const std::string& line, std::string_view key) {
  return line.starts_with(key) && line.find_first_not_of(" \t", key.size()) == line.find('=');
}

/// TOML begins with a table or a key and its value.
FileKind kind_of_toml(const std::vector<std::string>& lines) {
  for (const std::string& line : lines)
    if (begins_with_key(line, "experiment")) return FileKind::config;
  for (const std::string& line : lines)
    if (line.starts_with("[[terms]]") || begins_with_key(line, "first_leg")) return FileKind::error_models;
  return FileKind::unknown;
}

FileKind kind_of_rows(const std::string& header, const std::string& ending) {
  const std::string names = small_letters(header);
  if (has_any(names, {"gx_", "bx_"})) return FileKind::readings;
  if (has_any(names, {"timestamp", "time_s", "time_min", "time_h"})) return FileKind::gauges;
  if (has_any(names, {"inc", "azi"})) return FileKind::survey;
  constexpr std::array<std::string_view, 3> kTables = {".csv", ".las", ".xlsx"};
  return std::find(kTables.begin(), kTables.end(), ending) != kTables.end() ? FileKind::survey : FileKind::unknown;
}

/// Where it is, as a word of a command.
std::string folder_of(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return shell_word(folder.empty() ? "." : folder);
}

const char* noun_of(FileKind kind) {
  switch (kind) {
    case FileKind::config:
      return "a config";
    case FileKind::error_models:
      return "a file of error models";
    case FileKind::result:
      return "a result";
    case FileKind::part:
      return "a part of a run";
    case FileKind::journal:
      return "the finished work of an interrupted run";
    case FileKind::survey:
      return "a survey";
    case FileKind::readings:
      return "a table of readings";
    case FileKind::gauges:
      return "a table of gauges over time";
    case FileKind::unknown:
      break;
  }
  return "";
}

/// Commands that take the file.
std::vector<std::string> commands_for(const std::string& path, FileKind kind) {
  const std::string file = shell_word(path);
  switch (kind) {
    case FileKind::config:
      return {"check " + file, "run " + file};
    case FileKind::error_models:
      return {"models --file " + file, "run CONFIG --set error_model.file=" + file};
    case FileKind::result:
      return {"show " + file, "plot " + file, "rerun " + file};
    case FileKind::part:
      return {"status " + folder_of(path), fmt::format("merge {} -o result.h5", folder_of(path))};
    case FileKind::journal:
      return {
          fmt::format("run CONFIG --resume -o {}", shell_word(path.substr(0, path.rfind(checkpoint::kJournalInfix))))};
    case FileKind::survey:
      return {"new position_covariance -o well.toml", "run well.toml --set survey.file=" + file};
    case FileKind::readings:
      return {"new estimate -o readings.toml", "run readings.toml --set readings=" + file};
    case FileKind::gauges:
      return {"new drift_monitoring -o gauges.toml", "check gauges.toml --set source.file=" + file};
    case FileKind::unknown:
      break;
  }
  return {};
}

}  // namespace

FileKind kind_of_file(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return FileKind::unknown;
  const fs::path name = fs::path(path).filename();
  if (name.string().find(checkpoint::kJournalInfix) != std::string::npos) return FileKind::journal;
  if (checkpoint::has_part_mark(path)) return FileKind::part;
  const std::string head = head_of(path), ending = small_letters(name.extension().string());
  if (head.starts_with(store::kHdf5Signature)) return FileKind::result;
  const std::vector<std::string> lines = lines_of(head);
  const bool is_text = head.find('\0') == std::string::npos;
  if (lines.empty() || (!is_text && ending != ".xlsx")) return FileKind::unknown;
  const bool is_toml =
      ending == ".toml" || lines.front().starts_with('[') || lines.front().find('=') != std::string::npos;
  return is_toml ? kind_of_toml(lines) : kind_of_rows(lines.front(), ending);
}

std::string experiment_of_config(const std::string& path) {
  if (kind_of_file(path) != FileKind::config) return "";
  for (const std::string& line : lines_of(head_of(path))) {
    if (!begins_with_key(line, "experiment")) continue;
    const std::size_t begin = line.find_first_of("\"'"), end = line.find_first_of("\"'", begin + 1);
    if (begin != std::string::npos && end != std::string::npos) return line.substr(begin + 1, end - begin - 1);
  }
  return "";
}

std::string what_to_do(const std::string& path, FileKind kind) {
  if (kind == FileKind::unknown) return "";
  std::string out = fmt::format("{}; commands for it:", noun_of(kind));
  for (const std::string& command : commands_for(path, kind)) out += "\n  surveymc " + render::printable(command);
  return out;
}

void refuse_other_kind(const std::string& command, const std::string& path, FileKind wanted) {
  const FileKind kind = kind_of_file(path);
  std::error_code error;
  if (fs::is_regular_file(path, error) && fs::file_size(path, error) == 0) {
    const std::string text = fmt::format("{}: is empty: must be {}", render::printable(path), noun_of(wanted));
    if (wanted == FileKind::config || wanted == FileKind::error_models) throw InputError(text);
    throw IoError(text);
  }
  require_usage(kind == FileKind::unknown || kind == wanted, "{} {}: must be {}, but this is {}", command,
                render::printable(path), noun_of(wanted), what_to_do(path, kind));
}

}  // namespace surveymc::cli
