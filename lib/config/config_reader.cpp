#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config/checked_numbers.h"
#include "config/config.h"
#include "config/reader_state.h"
#include "config/text.h"
#include "config/toml_tree.h"

namespace surveymc::config {
namespace {

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string choice_rule(const std::vector<std::string>& allowed) {
  std::string list;
  for (const auto& a : allowed) list += (list.empty() ? "" : ", ") + in_quotes(a);
  return (allowed.size() == 1 ? "must be " : "must be one of ") + list;
}

/// The word of a choice. TOML, --set and tables of points read true without quotes as no text; as a choice it is the
/// word.
std::string choice_word(const TomlNode& n) {
  return n.is_text() ? n.text : n.kind == TomlNode::Kind::boolean ? plain_text(n) : "";
}

std::string integer_rule(std::int64_t lo, std::int64_t hi) {
  using Limits = std::numeric_limits<std::int64_t>;
  if (hi == Limits::max()) return fmt::format("must be >= {}", lo);
  if (lo == Limits::min()) return fmt::format("must be <= {}", hi);
  return fmt::format("must be in [{}, {}]", lo, hi);
}

// ---- for the log

/// "" where every finite number is right.
std::string number_rule(const Range& range) {
  return range.lo > -kInfinity || range.hi < kInfinity ? rule_of(range) : "";
}

/// A number of the range, as TOML: 0, or one near the lower end.
std::string sample_of(const Range& range) {
  const bool lo = range.lo > -kInfinity, hi = range.hi < kInfinity;
  const double step = lo && hi ? std::min(1.0, (range.hi - range.lo) / 2) : 1.0;
  const double sample = range.lo < 0 && range.hi > 0 ? 0.0 : lo ? range.lo + step : hi ? range.hi - step : 1.0;
  const std::string text = format_number(sample);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

/// "numbers", or so many of them.
std::string count_in_words(int count) {
  return count < 0 ? "numbers" : fmt::format("{} number{}", count, count == 1 ? "" : "s");
}

std::string list_of(const std::string& sample, int count) {
  return fmt::format("[{}]", fmt::join(std::vector<std::string>(static_cast<std::size_t>(count), sample), ", "));
}

}  // namespace

ConfigReader::ConfigReader(std::shared_ptr<State> state) : state_(std::move(state)) {}

bool ConfigReader::has(const std::string& key) const {
  const std::string full = state_->full_key(key);
  state_->point->asked.insert(full);
  const bool found = static_cast<bool>(state_->look_up(key));
  if (KeyLog* log = state_->point->doc->log.get()) {
    log->use(full).may_be_absent = true;
    if (!found && log->said.contains(full)) return true;
    if (!found) log->denied.insert(full);
  }
  if (!found) state_->point->doc->known_absent.insert(full);
  return found;
}

// ----------------------------------------------------------------------------------------------------- single values

double ConfigReader::number(const std::string& key, const Range& range, const std::optional<double>& fallback) {
  const bool is_value = fallback && is_in(range, *fallback);
  state_->log_fallback(key, fallback, is_value);
  if (state_->has_log()) state_->log_use(key, "number", number_rule(range), sample_of(range));
  const auto found = state_->need_or(key, fallback, is_value);
  return found ? checked_number(*found.node, found.key, range) : *fallback;
}

std::int64_t ConfigReader::integer(const std::string& key, std::int64_t lo, std::int64_t hi,
                                   const std::optional<std::int64_t>& fallback) {
  const bool is_value = fallback && lo <= *fallback && *fallback <= hi;
  state_->log_fallback(key, fallback, is_value);
  if (state_->has_log())
    state_->log_use(key, "integer", integer_rule(lo, hi), fmt::format("{}", std::min(hi, lo + (lo < hi))));
  const auto found = state_->need_or(key, fallback, is_value);
  if (!found) return *fallback;
  const TomlNode& n = *found.node;
  if (n.kind != TomlNode::Kind::integer) refuse_kind(n, found.key, "must be an integer");
  if (n.integer < lo || n.integer > hi) refuse(n, found.key, integer_rule(lo, hi));
  return n.integer;
}

bool ConfigReader::boolean(const std::string& key, bool fallback) {
  state_->log_fallback<bool>(key, fallback, true);
  if (state_->has_log()) state_->log_use(key, "true or false");
  const auto found = state_->need_or<bool>(key, fallback, true);
  if (!found) return fallback;
  if (found.node->kind != TomlNode::Kind::boolean) refuse_kind(*found.node, found.key, "must be true or false");
  return found.node->flag;
}

std::string ConfigReader::text(const std::string& key, const std::optional<std::string>& fallback) {
  const bool is_value = fallback && !fallback->empty();
  state_->log_fallback(key, fallback, is_value);
  if (state_->has_log()) state_->log_use(key, "text");
  const auto found = state_->its_name(state_->need_or(key, fallback, is_value));
  if (!found) return *fallback;
  if (!found.node->is_text()) refuse_kind(*found.node, found.key, "must be a string");
  return found.node->text;
}

bool ConfigReader::is_text(const std::string& key) const {
  const auto found = state_->look_up(key);
  return found && (found.node->is_text() || found.node->kind == TomlNode::Kind::boolean);
}

std::string ConfigReader::choice(const std::string& key, const std::vector<std::string>& allowed,
                                 const std::optional<std::string>& fallback) {
  const bool is_value = fallback && contains(allowed, *fallback);
  state_->log_fallback(key, fallback, is_value);
  if (state_->has_log()) state_->log_choices(key, allowed);
  const auto found = state_->its_name(state_->need_or(key, fallback, is_value));
  if (!found) return *fallback;
  const std::string word = choice_word(*found.node);
  if (!contains(allowed, word)) refuse_kind(*found.node, found.key, choice_rule(allowed));
  return word;
}

namespace {

/// Of "2026-07-01"; nothing if it is no such date.
std::optional<double> decimal_year_of(const std::string& text) {
  int year = 0, month = 0, day = 0, used = 0;
  if (text.size() != 10 || std::sscanf(text.c_str(), "%4d-%2d-%2d%n", &year, &month, &day, &used) != 3 || used != 10)
    return std::nullopt;
  using namespace std::chrono;
  const year_month_day date{std::chrono::year{year}, std::chrono::month{static_cast<unsigned>(month)},
                            std::chrono::day{static_cast<unsigned>(day)}};
  if (!date.ok() || year < 1600) return std::nullopt;
  const sys_days first{date.year() / January / 1}, next{(date.year() + years{1}) / January / 1};
  return year + static_cast<double>((sys_days{date} - first).count()) / static_cast<double>((next - first).count());
}

}  // namespace

double ConfigReader::decimal_year(const std::string& key) {
  if (state_->has_log()) state_->log_use(key, "date", "a date, 2026-07-01, or a decimal year, 2026.5", "2026.5");
  const auto found = state_->need(key);
  const TomlNode& n = *found.node;
  if (n.is_number()) return checked_number(n, found.key, {});
  const bool may_be = n.is_text() || n.kind == TomlNode::Kind::date;
  const std::optional<double> year = may_be ? decimal_year_of(n.text) : std::nullopt;
  if (!year) refuse_kind(n, found.key, "must be a date, 2026-07-01, or a decimal year, 2026.5");
  return *year;
}

// ------------------------------------------------------------------------------------------------------------- lists

std::vector<double> ConfigReader::numbers(const std::string& key, const Range& range, int count,
                                          const std::optional<std::vector<double>>& fallback) {
  const auto fits = [&](std::size_t size) { return count < 0 ? size > 0 : size == static_cast<std::size_t>(count); };
  const bool is_value = fallback && fits(fallback->size()) &&
                        std::all_of(fallback->begin(), fallback->end(), [&](double x) { return is_in(range, x); });
  const std::string size = count_in_words(count);
  state_->log_fallback(key, fallback, is_value);
  if (state_->has_log())
    state_->log_use(key, "list of " + size, number_rule(range), list_of(sample_of(range), std::max(count, 1)));
  const auto found = state_->need_or(key, fallback, is_value);
  if (!found) return *fallback;
  const TomlNode& n = *found.node;
  if (!n.is_array()) refuse_kind(n, found.key, "must be a list of " + size);
  if (!fits(n.items.size())) refuse(n, found.key, count < 0 ? "must not be empty" : "must have " + size);
  return checked_numbers(n, found.key, range);
}

std::vector<double> ConfigReader::number_or_list(const std::string& key, const Range& range) {
  if (state_->has_log()) state_->log_use(key, "number or list", number_rule(range), sample_of(range));
  const auto found = state_->need(key);
  const TomlNode& n = *found.node;
  if (n.is_number()) return {checked_number(n, found.key, range)};
  if (!n.is_array()) refuse_kind(n, found.key, "must be a number or a list of numbers");
  return numbers(key, range, -1);
}

std::vector<double> ConfigReader::grid(const std::string& key, const Range& range) {
  if (state_->has_log())
    state_->log_use(key, "number, list or { from, to, step }", number_rule(range), sample_of(range));
  const auto found = state_->need(key);
  const TomlNode& n = *found.node;
  if (n.is_number()) return {checked_number(n, found.key, range)};
  if (n.is_table()) {
    state_->point->whole.insert(state_->full_key(key));
    return expand_steps(n, found.key, range);
  }
  if (!n.is_array()) refuse_kind(n, found.key, "must be a number, a list of numbers or { from, to, step }");
  if (n.items.empty()) refuse(n, found.key, "must not be empty");
  const auto x = checked_numbers(n, found.key, range);
  for (std::size_t i = 1; i < x.size(); ++i) {
    const bool rises = x[1] > x[0];
    if (rises ? !(x[i] > x[i - 1]) : !(x[i] < x[i - 1])) {
      refuse(n.items[i], fmt::format("{}[{}]", found.key, i),
             x[i] == x[i - 1] ? "is in the list twice" : "the list must rise or fall throughout");
    }
  }
  return x;
}

std::vector<std::string> ConfigReader::texts(const std::string& key) {
  if (state_->has_log()) state_->log_use(key, "text or list of texts");
  const auto found = state_->its_name(state_->need(key));
  const TomlNode& n = *found.node;
  if (n.is_text()) return {n.text};
  if (!n.is_array()) refuse_kind(n, found.key, "must be a string or a list of strings");
  if (n.items.empty()) refuse(n, found.key, "must not be empty");
  std::vector<std::string> out;
  for (std::size_t i = 0; i < n.items.size(); ++i) {
    if (!n.items[i].is_text()) refuse_kind(n.items[i], fmt::format("{}[{}]", found.key, i), "must be a string");
    out.push_back(n.items[i].text);
  }
  return out;
}

// --------------------------------------------------------------------------------------------------- tables and files

std::vector<std::pair<std::string, double>> ConfigReader::number_table(const std::string& key, const Range& range) {
  if (state_->has_log()) state_->log_use(key, "table of numbers", number_rule(range));
  const auto found = state_->need(key);
  if (!found.node->is_table()) refuse_kind(*found.node, found.key, "must be a table of numbers");
  state_->point->whole.insert(state_->full_key(key));
  std::vector<std::pair<std::string, double>> out;
  for (const auto& [k, v] : found.node->entries) {
    out.emplace_back(k, checked_number(v, join_key(found.key, key_text(k)), range));
  }
  return out;
}

std::vector<ConfigReader> ConfigReader::tables(const std::string& key) {
  if (state_->has_log()) state_->log_default(key, TomlNode{}, false);
  if (state_->has_log()) state_->log_use(key, "array of tables", "", "[{}]");
  const auto found = state_->find(key);
  if (!found) return {};
  const TomlNode& n = *found.node;
  if (!n.is_tables() && !(n.is_array() && n.items.empty())) {
    refuse_kind(n, found.key, fmt::format("must be an array of tables: write [[{}]]", found.key));
  }
  const std::string full = state_->full_key(key);
  state_->point->arrays.insert(full);
  std::vector<ConfigReader> out;
  for (std::size_t i = 0; i < n.items.size(); ++i) {
    out.emplace_back(std::make_shared<State>(State{state_->point, &n.items[i], fmt::format("{}[{}]", full, i)}));
  }
  return out;
}

std::vector<std::variant<std::string, ConfigReader>> ConfigReader::texts_or_tables(
    const std::string& key, const std::vector<std::string>& fallback) {
  std::vector<std::variant<std::string, ConfigReader>> out;
  TomlNode list;
  list.kind = TomlNode::Kind::array;
  for (const std::string& text : fallback) list.items.push_back(node_of(text));
  if (state_->has_log()) state_->log_default(key, list, true);
  if (state_->has_log()) state_->log_use(key, "list of texts or tables");
  const auto found = state_->find(key);
  if (!found) {
    state_->use_default(key, list, true);
    out.assign(fallback.begin(), fallback.end());
    return out;
  }
  const TomlNode& n = *found.node;
  if (!n.is_array()) refuse_kind(n, found.key, "must be a list of strings or tables");
  if (n.items.empty()) refuse(n, found.key, "must not be empty");
  const std::string full = state_->full_key(key);
  state_->point->arrays.insert(full);
  for (std::size_t i = 0; i < n.items.size(); ++i) {
    const std::string element = fmt::format("{}[{}]", full, i);
    if (n.items[i].is_text())
      out.emplace_back(n.items[i].text);
    else if (n.items[i].is_table())
      out.emplace_back(ConfigReader(std::make_shared<State>(State{state_->point, &n.items[i], element})));
    else
      refuse_kind(n.items[i], element, "must be a string or a table");
  }
  return out;
}

bool ConfigReader::matches_point(const std::string& key) {
  if (state_->has_log()) state_->log_default(key, TomlNode{}, false);
  if (state_->has_log()) state_->log_use(key, "table of keys", "values of keys at the points that are meant");
  const auto found = state_->find(key);
  if (!found) return true;
  if (!found.node->is_table()) refuse_kind(*found.node, found.key, "must be a table of keys and their values");
  const std::string full = state_->full_key(key);
  state_->point->whole.insert(full);
  const bool matches = state_->entries_match(found.key, *found.node, "");
  if (!matches && !state_->path.empty()) state_->point->unmatched[state_->path] = full;
  return matches;
}

InputTable ConfigReader::csv(const std::string& key) {
  if (state_->has_log()) state_->log_use(key, "CSV file", "relative to the config");
  const auto found = state_->need(key);
  return state_->point->doc->input(*found.node, found.key);
}

InputText ConfigReader::file_text(const std::string& key) {
  if (state_->has_log()) state_->log_use(key, "file", "relative to the config");
  const auto found = state_->need(key);
  return state_->point->doc->text(*found.node, found.key, nullptr);
}

InputText ConfigReader::file_text(const std::string& key, const InputText& shipped) {
  if (state_->has_log()) state_->log_use(key, "text");
  const auto found = state_->its_name(state_->need(key));
  return state_->point->doc->text(*found.node, found.key, &shipped);
}

InputFile ConfigReader::file(const std::string& key) {
  if (state_->has_log()) state_->log_use(key, "CSV file", "relative to the config");
  const auto found = state_->need(key);
  return state_->point->doc->file(*found.node, found.key);
}

InputTable ConfigReader::table(const std::string& key,
                               const std::function<InputTable(const std::filesystem::path&)>& load,
                               const std::string& reading) {
  if (state_->has_log()) state_->log_use(key, "file", "relative to the config");
  const auto found = state_->need(key);
  return state_->point->doc->table(*found.node, found.key, load, reading);
}

namespace {

/// A document of its own: messages name it, and its defaults do not enter the config's resolved text.
ConfigReader reader_of_document(const InputText& document, std::shared_ptr<ConfigDocument> parent) {
  auto point = std::make_shared<ConfigPoint>();
  point->doc = std::make_shared<ConfigDocument>();
  point->doc->parent = std::move(parent);
  point->doc->label = document.path;
  point->root = parse_document(document.text, document.path);
  const TomlNode* root = &point->root;
  return ConfigReader(std::make_shared<ConfigReader::State>(ConfigReader::State{std::move(point), root, ""}));
}

}  // namespace

ConfigReader ConfigReader::toml(const std::string& key) {
  if (state_->has_log()) state_->log_use(key, "TOML file", "relative to the config");
  const auto found = state_->need(key);
  return reader_of_document(state_->point->doc->text(*found.node, found.key, nullptr), state_->point->doc);
}

ConfigReader ConfigReader::toml(const std::string& key, const InputText& shipped) {
  if (state_->has_log()) state_->log_use(key, "text");
  const auto found = state_->its_name(state_->need(key));
  return reader_of_document(state_->point->doc->text(*found.node, found.key, &shipped), state_->point->doc);
}

ConfigReader ConfigReader::of_file(const std::string& path) {
  const auto parent = std::make_shared<ConfigDocument>();
  TomlNode name = node_of(path);
  name.place = path;
  return reader_of_document(parent->text(name, "file", nullptr), parent);
}

// ------------------------------------------------------------------------------------------------------------- checks

void ConfigPlace::fail(const std::string& rule) const { refuse(place_, key_, rule); }

std::string ConfigPlace::remark(const std::string& text) const { return fmt::format("{}: {}: {}", place_, key_, text); }

ConfigPlace ConfigReader::place(const std::string& key) const {
  if (const auto found = State::name_or_self(state_->look_up(key)))
    return {found.node->place, shown_key(*found.node, found.key)};
  const std::string full = state_->full_key(key);
  const auto& defaults = state_->point->defaults;
  const auto it = defaults.find(full);
  if (it == defaults.end()) return {state_->place(), full};
  return {state_->place(), fmt::format("{} = {} (the default)", full, shortened(plain_text(it->second)))};
}

void ConfigReader::fail(const std::string& key, const std::string& rule) const {
  if (KeyLog* log = state_->point->doc->log.get()) {
    log->refused = state_->full_key(key);
    if (rule.starts_with("missing")) log->use(log->refused).is_needed = true;
  }
  place(key).fail(rule);
}

void ConfigReader::note(const std::string& text) const { state_->point->doc->remark(false, text); }

void ConfigReader::warn(const std::string& key, const std::string& text) const {
  state_->point->doc->remark(true, key.empty() ? text : place(key).remark(text));
}

void ConfigReader::finish() const {
  std::vector<State::UnknownKey> unknown;
  state_->find_unknown(*state_->table, state_->path, unknown);
  if (unknown.empty()) return;
  const auto first = std::min_element(unknown.begin(), unknown.end(),
                                      [](const auto& a, const auto& b) { return a.node->line < b.node->line; });
  refuse(first->node->place, first->key, first->rule);
}

}  // namespace surveymc::config
