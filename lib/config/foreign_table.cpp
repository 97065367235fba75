#include "config/foreign_table.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <sstream>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "base/error.h"
#include "base/shell_word.h"
#include "config/config_document.h"
#include "config/csv_cells.h"
#include "config/python_side.h"
#include "config/readings_csv.h"
#include "config/survey_csv.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNorth = "azimuth-reference";  // with kUnusual the only options that our own form has, too
constexpr const char* kUnusual = "unusual";

std::string key_of(std::string option) {
  std::replace(option.begin(), option.end(), '-', '_');
  return option;
}

bool is_own_name(std::string_view name, ForeignKind kind) {
  constexpr std::array<std::string_view, 8> kSurvey{"md_m",         "md_ft", "inclination_deg", "azimuth_deg",
                                                    "toolface_deg", "tvd_m", "tvd_ft",          "time_s"};
  constexpr std::array<std::string_view, 6> kAxes{"gx", "gy", "gz", "bx", "by", "bz"};
  constexpr std::array<std::string_view, 4> kUnits{"_mps2", "_mg", "_nT", "_uT"};
  if (kind == ForeignKind::survey && std::find(kSurvey.begin(), kSurvey.end(), name) != kSurvey.end()) return true;
  if (kind == ForeignKind::survey && name.starts_with("azimuth_") && name.ends_with("_deg")) return true;
  if (name == "md_m" || name == "md_ft") return true;
  return kind == ForeignKind::readings && std::any_of(kAxes.begin(), kAxes.end(), [&](std::string_view axis) {
           return name.starts_with(axis) && std::find(kUnits.begin(), kUnits.end(), name.substr(2)) != kUnits.end();
         });
}

/// An anonymous file that a child writes and we read when it has ended: no pipe that could fill.
class Capture {
 public:
  Capture() : descriptor_(memfd_create("surveymc", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw IoError(std::generic_category().message(errno));
  }
  ~Capture() { close(descriptor_); }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;
  int descriptor() const { return descriptor_; }
  std::string text() const {
    std::string out;
    std::array<char, 1 << 16> buffer;
    for (ssize_t n = 0; (n = pread(descriptor_, buffer.data(), buffer.size(), static_cast<off_t>(out.size()))) > 0;)
      out.append(buffer.data(), static_cast<std::size_t>(n));
    return out;
  }

 private:
  int descriptor_;
};

struct Ended {
  int code = 0;  ///< exit code; negative: of a signal
  std::string out, errors;
};

Ended run_program(const std::vector<std::string>& arguments) {
  const Capture out, errors;
  std::vector<char*> argv;
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors.descriptor(), STDERR_FILENO);
  pid_t child = 0;
  const int fault = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (fault != 0)
    throw IoError(fmt::format("{}: cannot be started: {}", arguments[0], std::generic_category().message(fault)));
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw IoError(std::generic_category().message(errno));
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), out.text(), errors.text()};
}

/// The lines "word: text" that the Python side prints before the CSV.
struct Answer {
  std::string told, csv;
  std::vector<std::string> warnings;
  std::vector<int> lines;
};

Answer answer_of(const std::string& text) {
  constexpr std::string_view kTold = "told: ", kWarning = "warning: ", kLines = "lines: ", kCsv = "csv:\n";
  Answer answer;
  for (std::size_t at = 0; at < text.size();) {
    const std::string_view rest = std::string_view(text).substr(at);
    if (rest.starts_with(kCsv)) {
      answer.csv = rest.substr(kCsv.size());
      break;
    }
    const std::string_view line = rest.substr(0, rest.find('\n'));
    if (line.starts_with(kTold)) answer.told = line.substr(kTold.size());
    if (line.starts_with(kWarning)) answer.warnings.emplace_back(line.substr(kWarning.size()));
    if (line.starts_with(kLines)) {
      std::istringstream numbers{std::string(line.substr(kLines.size()))};
      for (int n = 0; numbers >> n;) answer.lines.push_back(n);
    }
    at += line.size() + 1;
  }
  return answer;
}

/// True if the first line that is neither blank nor a comment (#) names a column of our own form of a survey or of
/// readings, or if the text can be no other form (empty, or bytes that are no text and no Excel): such a file is read
/// by parse_csv(), and its mistakes are told by it.
bool is_own_form(const std::string& text, ForeignKind kind) {
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  if (trimmed(rest).empty()) return true;
  constexpr std::size_t kHead = 1000;
  const std::string_view head = rest.substr(0, kHead);
  const auto zeros = static_cast<std::size_t>(std::count(head.begin(), head.end(), '\0'));
  const bool is_wide = head.starts_with("\xFF\xFE") || head.starts_with("\xFE\xFF") || 5 * zeros > 2 * head.size();
  if (zeros > 0) return !is_wide && !head.starts_with("PK\x03\x04");  // UTF-16 and UTF-32, or Excel
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = trimmed(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (is_no_row(line)) continue;
    for (std::size_t at = 0; at <= line.size();) {
      const std::size_t comma = std::min(line.find(',', at), line.size());
      std::string_view cell = trimmed(line.substr(at, comma - at));
      if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
      if (is_own_name(cell, kind)) return true;
      at = comma + 1;
    }
    return false;
  }
  return true;
}

}  // namespace

ReadTable read_any_form(const fs::path& place, const std::string& path, ForeignKind kind, const ImportOptions& options,
                        const std::string& key_prefix) {
  if (place.native().find('\0') != std::string::npos) throw IoError("is not the name of a file");
  const auto [text, fault] = read_file(place, kLargestTable, kSmallerTable);
  if (!fault.empty()) throw IoError(fmt::format("cannot be read: {} (looked for {})", fault, place.string()));
  if (is_own_form(text, kind)) {
    for (const auto& [name, value] : options)
      require(name == kNorth || name == kUnusual,
              "{}: has the columns that surveymc writes and needs no import: must be without {}{}", path, key_prefix,
              key_of(name));
    return {parse_csv(text, path, kind == ForeignKind::survey ? require_survey_names : require_readings_names), "", {}};
  }
  std::vector<std::string> arguments;
  try {
    arguments =
        python_command({"import", fs::absolute(place).string(), "--for-program=" + path, "--key-prefix=" + key_prefix});
  } catch (const IoError& e) {
    throw InputError(fmt::format(
        "{}: is no CSV of our own form ({} ...), and what reads other forms is not there: {}; or write "
        "such a CSV",
        path, kind == ForeignKind::survey ? "md_m, inclination_deg, azimuth_deg" : "md_m, gx_mps2, bx_nT", e.what()));
  }
  if (kind == ForeignKind::readings) arguments.emplace_back("--readings");
  for (const auto& [name, value] : options) arguments.push_back(fmt::format("--{}={}", name, value));
  const Ended ended = run_program(arguments);
  if (ended.code != 0) {
    const std::string said = ended.errors.substr(0, ended.errors.find_last_not_of(" \n") + 1);
    std::string command = fmt::format("surveymc import {}", shell_word(place.string()));
    if (kind == ForeignKind::readings) command += " --readings";
    for (const auto& [name, value] : options)
      if (name != kUnusual)
        command += fmt::format(" --{} {}", name, shell_quoted(value));  // the command itself refuses nothing for it
    // Readings have no keys: only the command takes an option, and its message names that.
    const bool has_keys = kind == ForeignKind::survey;
    throw InputError(
        fmt::format("{}; {}make a CSV of it: {} -o {}.csv",
                    said.empty() ? fmt::format("{}: surveymc import ended with {}", path, ended.code) : said,
                    has_keys ? "or " : "", command, has_keys ? "survey" : "readings"));
  }
  Answer answer = answer_of(ended.out);
  InputTable table = parse_csv(answer.csv, path);
  if (answer.lines.size() == table.rows()) table.lines = std::move(answer.lines);
  return {std::move(table), std::move(answer.told), std::move(answer.warnings)};
}

}  // namespace surveymc::config
