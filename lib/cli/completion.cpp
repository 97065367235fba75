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
    case ValueKind::model:
      return "_surveymc_words \"$(_surveymc_models)\"";
    case ValueKind::command:
      return "_surveymc_words \"$commands\"";
    case ValueKind::key_value:
      return "_surveymc_keys \"$first\"";
    case ValueKind::shell:
      return "_surveymc_words bash";
    case ValueKind::none:
    case ValueKind::text:
      break;
  }
  return ":";
}

constexpr const char* kHelpers = R"bash(
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

# Names of the error models that come with the program.
_surveymc_models() {
  "${COMP_WORDS[0]}" models 2>/dev/null | sed -n 's/^  \([^ ]*\) .*/\1/p'
}

# Keys of the config $1 with their unit, type and words: a line of CSV each.
_surveymc_rows() {
  local name
  name=$(sed -n 's/^experiment *= *"\([a-z_]*\)".*/\1/p' "$1" 2>/dev/null | head -n 1)
  [ -n "$name" ] && "${COMP_WORDS[0]}" keys "$name" --csv 2>/dev/null | tail -n +2
}

# Offers what --set may replace in the config $1: KEY=.
_surveymc_keys() {
  compopt -o nospace 2>/dev/null
  _surveymc_words "$(_surveymc_rows "$1" | grep -v '^[^,]*\(KEY\|\[\]\|[.]match,\|[.]without,\|,array of tables\)\|^experiment,' | cut -d, -f1 | sed 's/$/=/')"
}

# Offers values of the key $2 of the config $1: error models, or the words that are listed for it.
_surveymc_values() {
  case $2 in
    error_model|*.error_model|error_model.name|*.error_model.name) _surveymc_words "$(_surveymc_models)" ;;
    *) _surveymc_words "$(_surveymc_rows "$1" | grep "^$2\(\.name\)\?," | grep -o '""[A-Za-z0-9_]*""' | tr -d '"' | sort -u)" ;;
  esac
}

# Names of what is in the result file $1.
_surveymc_tables() {
  "${COMP_WORDS[0]}" show "$1" --csv 2>/dev/null | tail -n +2 | cut -d, -f2
}
)bash";

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
      R"bash(# bash completion for surveymc; made by: surveymc completion bash
{helpers}
_surveymc() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command= first= count=0 key= i
  local commands=$'{commands}'
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    case $command:${{COMP_WORDS[i]}} in
      {with_value}) ((i++))
        # Bash parts KEY=VALUE into three words, and KEY= into two.
        if [[ $COMP_WORDBREAKS == *=* && ${{COMP_WORDS[i+1]-}} == = ]]; then
          ((i + 1 == COMP_CWORD)) && key=${{COMP_WORDS[i]}} cur=
          ((i + 2 == COMP_CWORD)) && key=${{COMP_WORDS[i]}}
          ((i += 2))
        fi ;;
      *:-*) ;;
      :*) command=${{COMP_WORDS[i]}} ;;
      *) first=${{first:-${{COMP_WORDS[i]}}}}; ((count++)) ;;
    esac
  done
  if [ -z "$command" ]; then
    _surveymc_words "$commands"$'\n{flags}'
    return
  fi
  if [ -n "$key" ]; then
    _surveymc_values "$first" "$key"
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
)bash",
      fmt::arg("helpers", kHelpers), fmt::arg("with_value", with_value), fmt::arg("offers", offers),
      fmt::arg("options", options), fmt::arg("positionals", positionals),
      fmt::arg("commands", fmt::join(names_of(commands), "\\n")),
      fmt::arg("flags", fmt::join(flags_of(words.options), "\\n")));
}

}  // namespace surveymc::cli
