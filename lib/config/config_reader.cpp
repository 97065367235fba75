#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/count.h"
#include "config/config.h"
#include "config/config_point.h"
#include "config/config_value.h"
#include "config/mistakes.h"
#include "config/suggest.h"
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

/// The same for the log: ends that a double cannot hold are none.
Range integer_range(std::int64_t lo, std::int64_t hi) {
  const auto bound = [](std::int64_t x) { return static_cast<double>(x); };
  constexpr double kExact = 0x1p53;
  return {bound(lo) < -kExact ? -kInfinity : bound(lo), bound(hi) > kExact ? kInfinity : bound(hi)};
}

/// The integer of a node, which may be written as 1e6.
std::optional<std::int64_t> whole(const TomlNode& n) {
  if (n.kind == TomlNode::Kind::integer) return n.integer;
  if (n.kind != TomlNode::Kind::real || n.real != std::floor(n.real) || std::abs(n.real) >= 0x1p53) return std::nullopt;
  return static_cast<std::int64_t>(n.real);
}

/// TOML has no 10k.
std::string count_hint(const TomlNode& n) {
  const std::optional<std::uint64_t> count = n.is_text() ? count_of(n.text) : std::nullopt;
  return count ? fmt::format(": write {} without quotes", *count) : "";
}

/// Of a table with a name, `[estimator] name = ...` asked for as `estimator`, the name; else `value`.
ConfigValue name_or_self(const ConfigValue& value) {
  const TomlNode* name = value && value.node->is_table() ? value.node->entry("name") : nullptr;
  return name ? ConfigValue{name, value.key + ".name"} : value;
}

// ---- for the log

/// "" where every finite number is right.
std::string number_rule(const Range& range) {
  return range.lo > -kInfinity || range.hi < kInfinity ? rule_of(range) : "";
}

/// A number of the range: 0, or one near the lower end.
double sample_number(const Range& range) {
  const bool lo = range.lo > -kInfinity, hi = range.hi < kInfinity;
  const double step = lo && hi ? std::min(1.0, (range.hi - range.lo) / 2) : 1.0;
  return range.lo < 0 && range.hi > 0 ? 0.0 : lo ? range.lo + step : hi ? range.hi - step : 1.0;
}

/// The same as TOML.
std::string sample_of(const Range& range) {
  const std::string text = format_number(sample_number(range));
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

// ------------------------------------------------------------------------------------------------------------ asking

ConfigReader::ConfigReader(std::shared_ptr<Point> point, const TomlNode* table, std::string path)
    : point_(std::move(point)), table_(table), path_(std::move(path)) {}

ConfigReader ConfigReader::of_point(std::shared_ptr<ConfigDocument> doc, std::size_t index, TomlNode root) {
  auto point = std::make_shared<Point>();
  point->doc = std::move(doc);
  point->index = index;
  point->root = std::move(root);
  const TomlNode* table = &point->root;
  return {std::move(point), table, ""};
}

/// A document of its own: messages name it, and its defaults do not enter the config's resolved text.
ConfigReader ConfigReader::of_document(const InputText& document, std::shared_ptr<ConfigDocument> parent,
                                       std::size_t index) {
  auto doc = std::make_shared<ConfigDocument>();
  doc->parent = std::move(parent);
  doc->label = document.path;
  return of_point(std::move(doc), index, parse_document(document.text, document.path));
}

ConfigReader ConfigReader::of_file(const std::string& path) {
  const auto parent = std::make_shared<ConfigDocument>();
  TomlNode name = node_of(path);
  name.place = path;
  return of_document(parent->text(name, "file", nullptr), parent);
}

ConfigReader ConfigReader::element(const std::string& key, const TomlNode& array, std::size_t i) const {
  return {point_, &array.items[i], fmt::format("{}[{}]", full_key(key), i)};
}

std::string ConfigReader::full_key(const std::string& key) const { return join_key(path_, key); }

const std::string& ConfigReader::place_of_table() const { return path_.empty() ? point_->doc->label : table_->place; }

ConfigValue ConfigReader::look_up(const std::string& key) const { return point_->look_up(*table_, path_, key); }

/// `node`: null where a key must be there. `is_value`: false if the getter's rule would refuse it.
struct ConfigReader::Fallback {
  std::optional<TomlNode> node;
  bool is_value = false;

  Fallback() = default;
  Fallback(TomlNode value, bool is_allowed) : node(std::move(value)), is_value(is_allowed) {}
  template <class T>
  Fallback(const std::optional<T>& value, bool is_allowed) : is_value(is_allowed) {
    if (value) node = node_of(*value);
  }
};

template <class Describe>
ConfigValue ConfigReader::ask(const std::string& key, std::string_view meaning, const Fallback& fallback,
                              const Describe& describe) {
  ConfigDocument& doc = *point_->doc;
  const std::string full = full_key(key);
  if (doc.log) {
    const ConfigValue value = name_or_self(look_up(key));
    const bool is_example = value && !value.node->is_tables();
    doc.log->note(full, meaning, describe(), is_example ? toml_text(*value.node) : "",
                  fallback.node ? std::optional(fallback.is_value ? toml_text(*fallback.node) : "") : std::nullopt);
  }
  point_->asked.insert(full);
  const ConfigValue value = look_up(key);
  if (value.is_blocked && !value.node->is_text())
    refuse(*value.node, value.key, fmt::format("must be a table: write [{}]", value.key));
  if (value) return value;
  if (!fallback.node) refuse_missing(key);
  if (fallback.is_value) {
    point_->defaults[full] = *fallback.node;
    doc.use_default(full, *fallback.node, point_->index);
  }
  return {};
}

template <class Describe>
ConfigValue ConfigReader::ask_name(const std::string& key, std::string_view meaning, const Fallback& fallback,
                                   const Describe& describe) {
  const ConfigValue name = name_or_self(ask(key, meaning, fallback, describe));
  if (name) point_->asked.insert(name.key);
  return name;
}

/// Mentions the first key of the table that looks as if it was meant.
void ConfigReader::refuse_missing(const std::string& key) const {
  const std::string full = full_key(key);
  if (KeyLog* log = point_->doc->log.get()) log->missing = full;
  const auto parts = split_key(key);
  const TomlNode* at = table_;
  std::string at_key = path_;
  std::size_t i = 0;
  while (const TomlNode* next = at->entry(parts[i])) {  // ends at the part that is missing
    at_key = join_key(at_key, parts[i++]);
    if (!next->is_table()) refuse(next->place, full, fmt::format("missing ({} is only a name)", at_key));
    at = next;
  }
  const bool is_last = i + 1 == parts.size();
  for (const auto& [k, v] : at->entries) {
    const std::string other = join_key(at_key, k);
    if (point_->asked.contains(other) || point_->asked_below(other) || is_config_key(other)) continue;
    if (const UnitFault fault = unit_fault(k, parts[i]); is_last && fault != UnitFault::none) {
      refuse(v.place, full, fmt::format("missing (found {}: {})", other, describe(fault)));
    }
    if (resembles(k, parts[i])) refuse(v.place, full, fmt::format("missing (found {})", other));
  }
  refuse(place_of_table(), full, "missing");
}

bool ConfigReader::has(const std::string& key) const {
  const std::string full = full_key(key);
  point_->asked.insert(full);
  const bool found = static_cast<bool>(look_up(key));
  if (KeyLog* log = point_->doc->log.get()) {
    log->use(full).may_be_absent = true;
    if (!found && log->said.contains(full)) return true;
    if (!found) log->denied.insert(full);
  }
  if (!found) {
    const std::scoped_lock lock(point_->doc->showing);
    point_->doc->known_absent.insert(full);
  }
  return found;
}

bool ConfigReader::is_text(const std::string& key) const {
  const ConfigValue value = look_up(key);
  return value && (value.node->is_text() || value.node->kind == TomlNode::Kind::boolean);
}

// ----------------------------------------------------------------------------------------------------- single values

double ConfigReader::number(const std::string& key, const Range& range, std::string_view meaning,
                            const std::optional<double>& fallback) {
  return or_stand_in(key, Decides::nothing, fallback.value_or(sample_number(range)), [&] {
    const ConfigValue value = ask(key, meaning, Fallback(fallback, fallback && is_in(range, *fallback)), [&] {
      return KeyQuestion{"number", number_rule(range), sample_of(range), {}, range};
    });
    return value ? value.number(range) : *fallback;
  });
}

std::int64_t ConfigReader::integer(const std::string& key, std::int64_t lo, std::int64_t hi, std::string_view meaning,
                                   const std::optional<std::int64_t>& fallback) {
  const std::int64_t sample = std::min(hi, lo + (lo < hi));
  return or_stand_in(key, Decides::nothing, fallback.value_or(sample), [&] {
    const ConfigValue value =
        ask(key, meaning, Fallback(fallback, fallback && lo <= *fallback && *fallback <= hi), [&] {
          return KeyQuestion{"integer", integer_rule(lo, hi), fmt::format("{}", sample), {}, integer_range(lo, hi)};
        });
    if (!value) return *fallback;
    const std::optional<std::int64_t> x = whole(*value.node);
    if (!x) value.fail_type(fmt::format("must be an integer{}", count_hint(*value.node)));
    if (*x < lo || *x > hi) value.fail(integer_rule(lo, hi));
    return *x;
  });
}

bool ConfigReader::boolean(const std::string& key, std::string_view meaning, bool fallback) {
  return or_stand_in(key, Decides::presence, fallback, [&] {
    const ConfigValue value =
        ask(key, meaning, Fallback(node_of(fallback), true), [] { return KeyQuestion{"true or false"}; });
    if (!value) return fallback;
    if (value.node->kind != TomlNode::Kind::boolean) value.fail_type("must be true or false");
    return value.node->flag;
  });
}

std::string ConfigReader::text(const std::string& key, std::string_view meaning,
                               const std::optional<std::string>& fallback) {
  return or_stand_in(key, Decides::its_table, fallback.value_or("a"), [&] {
    const ConfigValue value =
        ask_name(key, meaning, Fallback(fallback, fallback && !fallback->empty()), [] { return KeyQuestion{"text"}; });
    if (!value) return *fallback;
    if (!value.node->is_text()) value.fail_type("must be a string");
    return value.node->text;
  });
}

template <class Describe>
std::string ConfigReader::word_among(const std::string& key, const std::vector<std::string>& allowed,
                                     std::string_view meaning, const std::optional<std::string>& fallback,
                                     const Describe& describe) {
  return or_stand_in(key, Decides::presence, fallback.value_or(allowed.front()), [&] {
    const ConfigValue value =
        ask_name(key, meaning, Fallback(fallback, fallback && contains(allowed, *fallback)), describe);
    if (!value) return *fallback;
    std::string word = choice_word(*value.node);
    if (!contains(allowed, word)) value.fail_type(choice_rule(allowed) + suggestion(word, allowed));
    return word;
  });
}

std::string ConfigReader::choice(const std::string& key, const std::vector<std::string>& allowed,
                                 std::string_view meaning, const std::optional<std::string>& fallback) {
  return word_among(key, allowed, meaning, fallback, [&] { return KeyQuestion{"text", "", "", allowed}; });
}

std::string ConfigReader::listed_name(const std::string& key, const std::vector<std::string>& names,
                                      const std::string& what, std::string_view meaning,
                                      const std::optional<std::string>& fallback) {
  return word_among(key, names, meaning, fallback, [&] {
    return KeyQuestion{"text", "must be " + what, in_quotes(names.front())};
  });
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

double ConfigReader::decimal_year(const std::string& key, std::string_view meaning) {
  constexpr const char* kRule = "must be a date, 2026-07-01, or a decimal year, 2026.5";
  constexpr double kSample = 2026.5;
  return or_stand_in(key, Decides::nothing, kSample, [&] {
    const ConfigValue value = ask(key, meaning, {}, [&] { return KeyQuestion{"date", kRule, format_number(kSample)}; });
    if (value.node->is_number()) return value.number({});
    const bool may_be = value.node->is_text() || value.node->kind == TomlNode::Kind::date;
    const std::optional<double> year = may_be ? decimal_year_of(value.node->text) : std::nullopt;
    if (!year) value.fail_type(kRule);
    return *year;
  });
}

// ------------------------------------------------------------------------------------------------------------- lists

std::vector<double> ConfigReader::numbers(const std::string& key, const Range& range, std::string_view meaning,
                                          int count, const std::optional<std::vector<double>>& fallback) {
  const auto fits = [&](std::size_t size) { return count < 0 ? size > 0 : size == static_cast<std::size_t>(count); };
  const bool is_value = fallback && fits(fallback->size()) &&
                        std::all_of(fallback->begin(), fallback->end(), [&](double x) { return is_in(range, x); });
  const std::string size = count_in_words(count);
  const std::vector<double> sample(static_cast<std::size_t>(std::max(count, 1)), sample_number(range));
  return or_stand_in(key, Decides::nothing, fallback.value_or(sample), [&] {
    const ConfigValue value = ask(key, meaning, Fallback(fallback, is_value), [&] {
      return KeyQuestion{
          "list of " + size, number_rule(range), list_of(sample_of(range), std::max(count, 1)), {}, range};
    });
    if (!value) return *fallback;
    if (!value.node->is_array()) value.fail_type("must be a list of " + size);
    if (!fits(value.node->items.size())) value.fail(count < 0 ? "must not be empty" : "must have " + size);
    return value.numbers(range);
  });
}

std::vector<double> ConfigReader::number_or_list(const std::string& key, const Range& range, std::string_view meaning) {
  return or_stand_in(key, Decides::nothing, std::vector<double>{sample_number(range)}, [&]() -> std::vector<double> {
    const ConfigValue value = ask(key, meaning, {}, [&] {
      return KeyQuestion{"number or list", number_rule(range), sample_of(range), {}, range};
    });
    if (value.node->is_number()) return {value.number(range)};
    if (!value.node->is_array()) value.fail_type("must be a number or a list of numbers");
    return numbers(key, range, meaning);
  });
}

std::vector<double> ConfigReader::grid(const std::string& key, const Range& range, std::string_view meaning) {
  return or_stand_in(key, Decides::nothing, std::vector<double>{sample_number(range)}, [&]() -> std::vector<double> {
    const ConfigValue value = ask(key, meaning, {}, [&] {
      return KeyQuestion{"number, list or { from, to, step }", number_rule(range), sample_of(range), {}, range};
    });
    if (value.node->is_number()) return {value.number(range)};
    if (value.node->is_table()) {
      point_->whole.insert(full_key(key));
      return value.steps(range).values();
    }
    if (!value.node->is_array()) value.fail_type("must be a number, a list of numbers or { from, to, step }");
    if (value.node->items.empty()) value.fail("must not be empty");
    const auto x = value.numbers(range);
    for (std::size_t i = 1; i < x.size(); ++i) {
      const bool rises = x[1] > x[0];
      if (rises ? !(x[i] > x[i - 1]) : !(x[i] < x[i - 1]))
        value.item(i).fail(x[i] == x[i - 1] ? "is in the list twice" : "the list must rise or fall throughout");
    }
    return x;
  });
}

std::vector<std::string> ConfigReader::texts(const std::string& key, std::string_view meaning) {
  return or_stand_in(key, Decides::its_table, std::vector<std::string>{"a"}, [&]() -> std::vector<std::string> {
    const ConfigValue value = ask_name(key, meaning, {}, [] { return KeyQuestion{"text or list of texts"}; });
    if (value.node->is_text()) return {value.node->text};
    if (!value.node->is_array()) value.fail_type("must be a string or a list of strings");
    if (value.node->items.empty()) value.fail("must not be empty");
    std::vector<std::string> out;
    for (std::size_t i = 0; i < value.node->items.size(); ++i) {
      const ConfigValue item = value.item(i);
      if (!item.node->is_text()) item.fail_type("must be a string");
      out.push_back(item.node->text);
    }
    return out;
  });
}

// --------------------------------------------------------------------------------------------------- tables and files

std::vector<std::pair<std::string, double>> ConfigReader::number_table(const std::string& key, const Range& range,
                                                                       std::string_view meaning) {
  return or_stand_in(key, Decides::presence, std::vector<std::pair<std::string, double>>{}, [&] {
    const ConfigValue value = ask(key, meaning, {}, [&] {
      return KeyQuestion{"table of numbers", number_rule(range), "", {}, range};
    });
    if (!value.node->is_table()) value.fail_type("must be a table of numbers");
    point_->whole.insert(full_key(key));
    std::vector<std::pair<std::string, double>> out;
    for (const auto& [k, v] : value.node->entries)
      out.emplace_back(k, ConfigValue{&v, join_key(value.key, key_text(k))}.number(range));
    return out;
  });
}

std::vector<ConfigReader> ConfigReader::tables(const std::string& key, std::string_view meaning) {
  const ConfigValue value = ask(key, meaning, Fallback(TomlNode{}, false), [] {
    return KeyQuestion{"array of tables", "", "[{}]"};
  });
  if (!value) return {};
  const TomlNode& n = *value.node;
  if (!n.is_tables() && !(n.is_array() && n.items.empty()))
    value.fail_type(fmt::format("must be an array of tables: write [[{}]]", value.key));
  point_->arrays.insert(full_key(key));
  std::vector<ConfigReader> out;
  for (std::size_t i = 0; i < n.items.size(); ++i) out.push_back(element(key, n, i));
  return out;
}

std::vector<std::variant<std::string, ConfigReader>> ConfigReader::texts_or_tables(
    const std::string& key, std::string_view meaning, const std::vector<std::string>& fallback) {
  TomlNode list;
  list.kind = TomlNode::Kind::array;
  for (const std::string& text : fallback) list.items.push_back(node_of(text));
  const ConfigValue value =
      ask(key, meaning, Fallback(std::move(list), true), [] { return KeyQuestion{"list of texts or tables"}; });
  if (!value) return {fallback.begin(), fallback.end()};
  if (!value.node->is_array()) value.fail_type("must be a list of strings or tables");
  if (value.node->items.empty()) value.fail("must not be empty");
  point_->arrays.insert(full_key(key));
  std::vector<std::variant<std::string, ConfigReader>> out;
  for (std::size_t i = 0; i < value.node->items.size(); ++i) {
    const TomlNode& item = value.node->items[i];
    if (item.is_text())
      out.emplace_back(item.text);
    else if (item.is_table())
      out.emplace_back(element(key, *value.node, i));
    else
      refuse_kind(item, fmt::format("{}[{}]", full_key(key), i), "must be a string or a table");
  }
  return out;
}

bool ConfigReader::matches_point(const std::string& key) {
  const ConfigValue value =
      ask(key, "the points of a sweep that are meant: those with these values; all points without it",
          Fallback(TomlNode{}, false), [] {
            return KeyQuestion{"table of keys", "values of keys at the points that are meant"};
          });
  if (!value) return true;
  if (!value.node->is_table()) value.fail_type("must be a table of keys and their values");
  const std::string full = full_key(key);
  point_->whole.insert(full);
  const bool matches = point_->has_values(value.key, *value.node);
  if (!matches && !path_.empty()) point_->unmatched[path_] = full;
  return matches;
}

namespace {

/// A file that the config names: "CSV file", "file", "TOML file".
auto question_of_file(const char* type) {
  return [type] { return KeyQuestion{type, "relative to the config"}; };
}

constexpr auto kQuestionOfShipped = [] { return KeyQuestion{"text"}; };

}  // namespace

InputTable ConfigReader::csv(const std::string& key, std::string_view meaning) {
  return or_stand_in(key, Decides::its_table, survey_stand_in(), [&] {
    const ConfigValue value = ask(key, meaning, {}, question_of_file("CSV file"));
    return point_->doc->input(*value.node, value.key);
  });
}

InputText ConfigReader::file_text(const std::string& key, std::string_view meaning) {
  const ConfigValue value = ask(key, meaning, {}, question_of_file("file"));
  return point_->doc->text(*value.node, value.key, nullptr);
}

InputText ConfigReader::file_text(const std::string& key, const InputText& shipped) {
  const ConfigValue value = ask_name(key, kMeaningElsewhere, {}, kQuestionOfShipped);
  return point_->doc->text(*value.node, value.key, &shipped);
}

InputFile ConfigReader::file(const std::string& key, std::string_view meaning) {
  const ConfigValue value = ask(key, meaning, {}, question_of_file("CSV file"));
  return point_->doc->file(*value.node, value.key);
}

InputTable ConfigReader::table(const std::string& key, std::string_view meaning,
                               const std::function<InputTable(const std::filesystem::path&)>& load,
                               const std::string& reading) {
  return or_stand_in(key, Decides::its_table, survey_stand_in(), [&] {
    const ConfigValue value = ask(key, meaning, {}, question_of_file("file"));
    return point_->doc->table(*value.node, value.key, load, reading);
  });
}

ConfigReader ConfigReader::toml(const std::string& key, std::string_view meaning) {
  const ConfigValue value = ask(key, meaning, {}, question_of_file("TOML file"));
  return of_document(point_->doc->text(*value.node, value.key, nullptr), point_->doc, point_->index);
}

ConfigReader ConfigReader::toml(const std::string& key, const InputText& shipped) {
  const ConfigValue value = ask_name(key, kMeaningElsewhere, {}, kQuestionOfShipped);
  return of_document(point_->doc->text(*value.node, value.key, &shipped), point_->doc, point_->index);
}

// ------------------------------------------------------------------------------------------------------------- checks

void ConfigPlace::fail(const std::string& rule) const { refuse(place_, key_, rule); }

std::string remark_text(const std::string& place, const std::string& value, const std::string& message,
                        const std::string& way_out) {
  std::string out = place;
  const auto add = [&](const char* between, const std::string& more) {
    if (!more.empty()) out += (out.empty() ? "" : between) + more;
  };
  add(value.find(" = ") == std::string::npos ? " = " : ": ", value);
  add(": ", message);
  add("; ", way_out);
  return out;
}

std::string Remark::text() const {
  return (line.empty() ? "" : line + ": ") + remark_text(place, value, message, way_out);
}

ConfigPlace ConfigReader::place(const std::string& key) const {
  if (const ConfigValue value = name_or_self(look_up(key)))
    return {value.node->place, shown_key(*value.node, value.key)};
  const std::string full = full_key(key);
  const auto it = point_->defaults.find(full);
  if (it == point_->defaults.end()) return {place_of_table(), full};
  return {place_of_table(), fmt::format("{} = {} (the default)", full, shortened(plain_text(it->second)))};
}

void ConfigReader::fail(const std::string& key, const std::string& rule) const {
  if (KeyLog* log = point_->doc->log.get()) {
    log->refused = full_key(key);
    if (rule.starts_with("missing")) log->use(log->refused).is_needed = true;
  }
  place(key).fail(rule);
}

void ConfigReader::note(const std::string& text) const { point_->doc->remark(point_->index, {false, text}); }

void ConfigReader::warn(const std::string& key, const std::string& message, const std::string& way_out) const {
  Remark r{true, message, full_key(key), "", way_out, place_of_table()};
  if (const ConfigValue value = name_or_self(look_up(key))) {
    r.line = value.node->place;
    if (!value.node->is_table() && !value.node->is_tables()) r.value = shortened(plain_text(*value.node));
  } else if (const auto it = point_->defaults.find(r.place); it != point_->defaults.end()) {
    r.value = shortened(plain_text(it->second));  // not called a default: in the resolved config it is written
  }
  if (point_->doc->parent) {  // a file that the config names has its lines in a result, too
    r.place = fmt::format("{}: {}", r.line, r.place);
    r.line.clear();
  }
  point_->doc->remark(point_->index, std::move(r));
}

void ConfigReader::warn_at(const std::string& place, const std::string& value, const std::string& message,
                           const std::string& way_out) const {
  point_->doc->remark(point_->index, {true, message, place, value, way_out});
}

void ConfigReader::finish() const {
  std::vector<Point::UnknownKey> unknown;
  point_->find_unknown(*table_, path_, unknown);
  std::sort(unknown.begin(), unknown.end(), [](const auto& a, const auto& b) { return a.node->line < b.node->line; });
  if (point_->mistakes) return point_->mistakes->add_unknown(unknown);
  if (!unknown.empty()) refuse(unknown.front().node->place, unknown.front().key, unknown.front().rule);
}

}  // namespace surveymc::config
