#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/command_words.h"

namespace surveymc::cli {
namespace {

std::vector<std::string> flags_of(const std::vector<OptionWords>& options, bool with_value_only = false) {
  std::vector<std::string> all;
  for (const OptionWords& o : options)
    if (!with_value_only || !o.value.empty()) all.insert(all.end(), o.flags.begin(), o.flags.end());
  return all;
}

std::vector<std::string> names_of(const std::vector<CommandWords>& commands) {
  std::vector<std::string> all;
  for (const CommandWords& c : commands) all.push_back(c.name);
  return all;
}

/// The command that offers values of a kind.
const char* offer_of(ValueKind kind) {
  switch (kind) {
    case ValueKind::any_file:
      return "_surveymc_files '*'";
    case ValueKind::config_file:
      return "_surveymc_files toml";
    case ValueKind::result_file:
      return "_surveymc_files h5";
    case ValueKind::folder:
      return "_surveymc_words \"$(compgen -d -- \"$cur\")\"";
    case ValueKind::table:
      return "_surveymc_words \"$(_surveymc_tables \"$first\")\"";
    case ValueKind::experiment:
      return "_surveymc_words \"$(_surveymc_experiments)\"";
    case ValueKind::shell:
      return "_surveymc_words bash";
    case ValueKind::none:
    case ValueKind::text:
      break;
  }
  return ":";
}

constexpr const char* kHelpers = R"(
# Offers the lines of $1 that begin with the current word. Not by compgen -W, which would expand them.
_surveymc_words() {
  local word
  while IFS= read -r word; do
    [[ -n $word && $word == "$cur"* ]] && COMPREPLY+=("$word")
  done <<<"$1"
}

# Offers files that end in .$1 (* for all), and folders.
_surveymc_files() {
  compopt -o filenames 2>/dev/null
  local IFS=$'\n'
  COMPREPLY=($(compgen -f -X "!*.$1" -- "$cur") $(compgen -d -- "$cur"))
}

# Names of the experiments.
_surveymc_experiments() {
  "${COMP_WORDS[0]}" list 2>/dev/null | grep -v '^ ' | cut -d' ' -f1
}

# Names of what is in the result file $1.
_surveymc_tables() {
  "${COMP_WORDS[0]}" show "$1" --csv 2>/dev/null | tail -n +2 | cut -d, -f2
}
)";

}  // namespace

std::string bash_completion(const ProgramWords& words) {
  const std::vector<CommandWords>& commands = words.commands;
  std::string with_value, offers, options, positionals;
  for (const CommandWords& c : commands) {
    for (const std::string& flag : flags_of(c.options, true))
      with_value += (with_value.empty() ? "" : "|") + c.name + ":" + flag;
    for (const OptionWords& o : c.options)
      if (!o.value.empty())
        for (const std::string& flag : o.flags)
          offers += fmt::format("    {}:{}) {}; return ;;\n", c.name, flag, offer_of(o.kind));
    options += fmt::format("      {}) _surveymc_words $'{}' ;;\n", c.name, fmt::join(flags_of(c.options), "\\n"));
    for (std::size_t i = 0; i < c.positionals.size(); ++i)
      positionals += fmt::format("    {}:{}) {} ;;\n", c.name, c.positionals[i].repeated ? "*" : fmt::format("{}", i),
                                 offer_of(c.positionals[i].kind));
  }
  return fmt::format(
      R"(# bash completion for surveymc; made by: surveymc completion bash
{helpers}
_surveymc() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command= first= count=0 i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    case $command:${{COMP_WORDS[i]}} in
      {with_value}) ((i++)) ;;
      *:-*) ;;
      :*) command=${{COMP_WORDS[i]}} ;;
      *) first=${{first:-${{COMP_WORDS[i]}}}}; ((count++)) ;;
    esac
  done
  if [ -z "$command" ]; then
    _surveymc_words $'{commands}\n{flags}'
    return
  fi
  case $command:$prev in
{offers}  esac
  if [[ $cur == -* ]]; then
    case $command in
{options}    esac
    return
  fi
  case $command:$count in
{positionals}  esac
}}
complete -F _surveymc surveymc
)",
      fmt::arg("helpers", kHelpers), fmt::arg("with_value", with_value), fmt::arg("offers", offers),
      fmt::arg("options", options), fmt::arg("positionals", positionals),
      fmt::arg("commands", fmt::join(names_of(commands), "\\n")),
      fmt::arg("flags", fmt::join(flags_of(words.options), "\\n")));
}

}  // namespace surveymc::cli
