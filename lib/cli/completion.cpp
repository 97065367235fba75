#include <algorithm>
#include <array>

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

/// `text` in single quotes of a POSIX shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) c == '\'' ? out.append("'\\''") : out.append(1, c);
  return out + "'";
}

std::string escaped(const std::string& text, const std::string& special) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

/// What the shells offer for a value of a kind.
struct Offer {
  ValueKind kind;
  const char *bash, *zsh, *fish;
};

/// Of the kinds that have something to offer; the last one is of all others.
constexpr std::array<Offer, 7> kOffers{
    {{ValueKind::config_file, "_surveymc_files toml", "_files -g \"*.toml\"",
      " -k -a '(__fish_complete_suffix .toml)'"},
     {ValueKind::result_file, "_surveymc_files h5", "_files -g \"*.h5\"", " -k -a '(__fish_complete_suffix .h5)'"},
     {ValueKind::folder, "_surveymc_words \"$(compgen -d -- \"$cur\")\"", "_files -/",
      " -a '(__fish_complete_directories)'"},
     {ValueKind::table, "_surveymc_words \"$(_surveymc_tables \"$first\")\"", "_surveymc_tables",
      " -a '(__surveymc_tables)'"},
     {ValueKind::shell, "_surveymc_words $'bash\\nzsh\\nfish'", "(bash zsh fish)", " -a 'bash zsh fish'"},
     {ValueKind::experiment, "_surveymc_words \"$(_surveymc_experiments)\"", "_surveymc_experiments",
      " -a \"(surveymc list 2>/dev/null | grep -v '^ ' | cut -d' ' -f1)\""},
     {ValueKind::text, ":", " ", ""}}};

const Offer& offer_of(ValueKind kind) {
  return *std::find_if(kOffers.begin(), kOffers.end() - 1, [&](const Offer& o) { return o.kind == kind; });
}

// ---- bash ----

constexpr const char* kBashHelpers = R"(
# Offers the lines of $1 that begin with the current word. Not by compgen -W, which would expand them.
_surveymc_words() {
  local word
  while IFS= read -r word; do
    [[ -n $word && $word == "$cur"* ]] && COMPREPLY+=("$word")
  done <<<"$1"
}

# Offers files that end in .$1, and folders.
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

std::string bash(const ProgramWords& words) {
  const std::vector<CommandWords>& commands = words.commands;
  std::string with_value, offers, options, positionals;
  for (const CommandWords& c : commands) {
    for (const std::string& flag : flags_of(c.options, true))
      with_value += (with_value.empty() ? "" : "|") + c.name + ":" + flag;
    for (const OptionWords& o : c.options)
      if (!o.value.empty())
        for (const std::string& flag : o.flags)
          offers += fmt::format("    {}:{}) {}; return ;;\n", c.name, flag, offer_of(o.kind).bash);
    options += fmt::format("      {}) _surveymc_words $'{}' ;;\n", c.name, fmt::join(flags_of(c.options), "\\n"));
    for (std::size_t i = 0; i < c.positionals.size(); ++i)
      positionals += fmt::format("    {}:{}) {} ;;\n", c.name, c.positionals[i].repeated ? "*" : fmt::format("{}", i),
                                 offer_of(c.positionals[i].kind).bash);
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
      fmt::arg("helpers", kBashHelpers), fmt::arg("with_value", with_value), fmt::arg("offers", offers),
      fmt::arg("options", options), fmt::arg("positionals", positionals),
      fmt::arg("commands", fmt::join(names_of(commands), "\\n")),
      fmt::arg("flags", fmt::join(flags_of(words.options), "\\n")));
}

// ---- zsh ----

std::string zsh_option(const OptionWords& o) {
  const std::string says = fmt::format("[{}]", escaped(o.description, "[]\\:"));
  const std::string value = o.value.empty() ? "" : fmt::format(":{}:{}", escaped(o.value, ":"), offer_of(o.kind).zsh);
  std::string out;
  for (const std::string& flag : o.flags)
    out += fmt::format(" {}", quoted(fmt::format("{}{}{}{}", o.repeated ? "*" : "", flag, says, value)));
  return out;
}

std::string zsh(const ProgramWords& words) {
  const std::vector<CommandWords>& commands = words.commands;
  std::string list, cases;
  for (const CommandWords& c : commands) {
    list += fmt::format(" {}", quoted(fmt::format("{}:{}", c.name, c.description)));
    std::string arguments;
    for (const OptionWords& o : c.options) arguments += zsh_option(o);
    for (std::size_t i = 0; i < c.positionals.size(); ++i) {
      const OptionWords& p = c.positionals[i];
      arguments +=
          fmt::format(" {}", quoted(fmt::format("{}{}:{}:{}", p.repeated ? "*" : fmt::format("{}", i + 1),
                                                p.required || p.repeated ? "" : ":", p.name, offer_of(p.kind).zsh)));
    }
    cases += fmt::format("    {}) _arguments{} ;;\n", c.name, arguments);
  }
  std::string program;
  for (const OptionWords& o : words.options) program += zsh_option(o);
  return fmt::format(R"ZSH(#compdef surveymc
# zsh completion for surveymc; made by: surveymc completion zsh

_surveymc_tables() {{
  local -a names
  names=(${{(f)"$(surveymc show $words[2] --csv 2>/dev/null | tail -n +2 | cut -d, -f2)"}})
  compadd -a names
}}

_surveymc_experiments() {{
  local -a names
  names=(${{(f)"$(surveymc list 2>/dev/null | grep -v '^ ' | cut -d' ' -f1)"}})
  compadd -a names
}}

_surveymc_commands() {{
  local -a commands
  commands=({list})
  _describe command commands
}}

_surveymc() {{
  local curcontext=$curcontext state line
  _arguments -C{program} '1: :_surveymc_commands' '*::argument:->arguments'
  [[ $state == arguments ]] || return
  case $line[1] in
{cases}  esac
}}

if [[ $zsh_eval_context[-1] == loadautofunc ]]; then
  _surveymc "$@"
else
  compdef _surveymc surveymc
fi
)ZSH",
                     fmt::arg("list", list), fmt::arg("cases", cases), fmt::arg("program", program));
}

// ---- fish ----

std::string fish_option(const OptionWords& o, const std::string& condition) {
  std::string out = "complete -c surveymc -n " + quoted(condition);
  for (const std::string& flag : o.flags)
    out += flag.starts_with("--") ? " -l " + flag.substr(2) : " -s " + flag.substr(1);
  if (!o.value.empty()) out += std::string(" -x") + offer_of(o.kind).fish;
  return out + " -d " + quoted(o.description) + "\n";
}

std::string fish(const ProgramWords& words) {
  std::string out = R"(# fish completion for surveymc; made by: surveymc completion fish
function __surveymc_tables
  set -l words (commandline -opc)
  for file in (string match -- '*.h5' $words)
    surveymc show $file --csv 2>/dev/null | tail -n +2 | cut -d, -f2
  end
end
complete -c surveymc -f
)";
  for (const OptionWords& o : words.options) out += fish_option(o, "__fish_use_subcommand");
  for (const CommandWords& c : words.commands) {
    const std::string condition = "__fish_seen_subcommand_from " + c.name;
    out += fmt::format("complete -c surveymc -n __fish_use_subcommand -a {} -d {}\n", c.name, quoted(c.description));
    for (const OptionWords& o : c.options) out += fish_option(o, condition);
    for (const OptionWords& p : c.positionals)
      if (*offer_of(p.kind).fish)
        out += fmt::format("complete -c surveymc -n {}{}\n", quoted(condition), offer_of(p.kind).fish);
  }
  return out;
}

}  // namespace

std::string completion(const ProgramWords& words, const std::string& shell) {
  if (shell == "bash") return bash(words);
  return shell == "zsh" ? zsh(words) : fish(words);
}

}  // namespace surveymc::cli
