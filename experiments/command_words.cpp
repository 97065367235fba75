#include "command_words.h"

#include <algorithm>
#include <cctype>
#include <map>

namespace surveymc {
namespace {

/// What the arguments of these names are; any other is text.
ValueKind kind_of(const std::string& name) {
  static const std::map<std::string, ValueKind> kKinds = {
      {"config", ValueKind::config_file}, {"file", ValueKind::result_file}, {"parts", ValueKind::result_file},
      {"output", ValueKind::result_file}, {"inputs", ValueKind::folder},    {"folder", ValueKind::folder},
      {"missing", ValueKind::folder},     {"table", ValueKind::table},      {"shell", ValueKind::shell}};
  const auto found = kKinds.find(name);
  return found == kKinds.end() ? ValueKind::text : found->second;
}

/// "KEY=VALUE" of "KEY=VALUE: replaces a key": capitals and signs before a colon name the value.
std::string placeholder_in(const std::string& description) {
  const std::string head = description.substr(0, description.find(':'));
  const bool capitals = std::all_of(head.begin(), head.end(), [](char c) {
    return std::isupper(static_cast<unsigned char>(c)) || std::ispunct(static_cast<unsigned char>(c));
  });
  return head.size() < description.size() && capitals ? head : "";
}

std::string placeholder(const CLI::Option& option, ValueKind kind, const std::string& name) {
  const std::string said = placeholder_in(option.get_description());
  if (!said.empty()) return said;
  if (kind == ValueKind::config_file || kind == ValueKind::result_file) return "FILE";
  if (kind == ValueKind::folder) return "FOLDER";
  if (option.get_type_name().starts_with("INT") || option.get_type_name().starts_with("UINT")) return "N";
  std::string capitals = name;
  for (char& c : capitals) c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return capitals;
}

OptionWords words_of(const CLI::Option& option) {
  OptionWords words;
  for (const std::string& s : option.get_snames()) words.flags.push_back("-" + s);
  for (const std::string& l : option.get_lnames()) words.flags.push_back("--" + l);
  const std::string name = option.get_positional()       ? option.get_name(true)
                           : option.get_lnames().empty() ? option.get_snames().front()
                                                         : option.get_lnames().front();
  if (option.get_positional()) words.name = name;
  if (option.get_items_expected_max() > 0) {
    words.kind = kind_of(name);
    words.value = placeholder(option, words.kind, name);
  }
  words.required = option.get_required();
  words.repeated = option.get_items_expected_max() > 1;
  words.description = option.get_description();
  return words;
}

CommandWords words_of(const CLI::App& app) {
  CommandWords words{app.get_name(), app.get_description(), {}, {}};
  for (const CLI::Option* option : app.get_options())
    (option->nonpositional() ? words.options : words.positionals).push_back(words_of(*option));
  return words;
}

}  // namespace

CommandWords program_words(const CLI::App& app) {
  CommandWords words = words_of(app);
  words.name.clear();
  return words;
}

std::vector<CommandWords> command_words(const CLI::App& app) {
  std::vector<CommandWords> all;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) all.push_back(words_of(*sub));
  return all;
}

}  // namespace surveymc
