#include "config/key_log.h"

#include <algorithm>
#include <charconv>

#include "config/config_document.h"
#include "config/shipped_models.h"
#include "config/suggest.h"
#include "config/toml_tree.h"

namespace surveymc::config {

std::string KeyLog::without_indices(const std::string& full_key) {
  std::string out;
  bool inside = false;
  for (const char c : full_key) {
    if (c == ']') inside = false;
    if (!inside) out += c;
    if (c == '[') inside = true;
  }
  return out;
}

namespace {

void add(std::vector<std::string>& list, std::string_view word) {
  if (std::find(list.begin(), list.end(), word) == list.end()) list.emplace_back(word);
}

}  // namespace

void KeyLog::note(const std::string& full_key, std::string_view meaning, const KeyQuestion& question,
                  const std::string& example, const std::optional<std::string>& fallback) {
  asked.insert(full_key);
  KeyUse& key = use(full_key);
  if (fallback) {
    with_default = full_key;
    add(key.defaults, *fallback);
  } else if (with_default != full_key) {
    with_default = "";
    key.is_needed = true;
  }
  add(key.types, question.type);
  constexpr std::string_view kMustBe = "must be ";
  const std::string_view rule = question.rule;
  if (!rule.empty()) add(key.rules, rule.starts_with(kMustBe) ? rule.substr(kMustBe.size()) : rule);
  for (const std::string& word : question.choices) add(key.choices, word);
  if (question.range && std::find(key.ranges.begin(), key.ranges.end(), *question.range) == key.ranges.end())
    key.ranges.push_back(*question.range);
  // A name that was chosen among those shipped is asked for again, for its text, and then without a meaning.
  const bool is_word = question.type.starts_with("text") && question.choices.empty();
  key.has_other_words = key.has_other_words || (is_word && meaning != kMeaningElsewhere);
  if (!meaning.empty()) add(key.meanings, meaning);
  if (key.sample.empty()) key.sample = question.sample;
  if (key.example.empty() && !supposed.contains(full_key)) key.example = example;
}

namespace {

/// The table or array element that holds the last part of a full key, and that part; null if there is none.
TomlNode* holder_of(TomlNode& root, std::string_view key, std::string& last) {
  TomlNode* at = &root;
  for (;;) {
    const std::size_t bracket = key.find('['), close = key.find(']');
    const std::vector<std::string> parts = split_key(key.substr(0, bracket));
    const std::size_t tables = bracket == std::string_view::npos ? parts.size() - 1 : parts.size();
    for (std::size_t i = 0; i < tables; ++i) {
      const auto it = at->entries.find(parts[i]);
      if (it == at->entries.end()) return nullptr;
      at = &it->second;
    }
    if (bracket == std::string_view::npos) {
      last = parts.back();
      return at;
    }
    std::size_t i = 0;
    std::from_chars(key.data() + bracket + 1, key.data() + close, i);
    if (i >= at->items.size() || close + 2 > key.size()) return nullptr;
    at = &at->items[i];
    key.remove_prefix(close + 2);
  }
}

}  // namespace

void apply_suppositions(const KeyLog& log, TomlNode& root) {
  for (const std::string& key : log.gone) {
    std::string last;
    if (TomlNode* at = holder_of(root, key, last)) {
      if (at->is_text() && last == "name") continue;
      at->entries.erase(last);
    }
  }
  for (const auto& [key, text] : log.supposed) {
    TomlNode value = parse_value(text, key, "supposed");
    assign_default(root, key, value);
  }
}

std::optional<std::string> shipped_text(const std::filesystem::path& path) {
  const std::string name = path.lexically_normal().string();
  for (const InputText& f : shipped_config_files())
    if (f.path == name) return f.text;
  for (const InputText& f : shipped_error_model_files())
    if ("configs/error_models/" + f.path + ".toml" == name) return f.text;
  return std::nullopt;
}

std::map<std::string, KeyUse> keys_of_every_file(const std::map<std::string, KeyUse>& asked) {
  const auto key = [](std::vector<std::string> types, const char* rule, const char* example, const char* meaning,
                      bool is_needed = false) {
    return KeyUse{.types = std::move(types),
                  .rules = {rule},
                  .defaults = {},
                  .choices = {},
                  .ranges = {},
                  .meanings = {meaning},
                  .may_be_absent = !is_needed,
                  .has_other_words = true,
                  .example = example,
                  .sample = "",
                  .is_needed = is_needed};
  };
  constexpr const char* kWhere = "columns and the word that a row has in them";
  constexpr const char* kWhichRow = "which row of a point, where the table has several";
  std::map<std::string, KeyUse> out{
      {"experiment", key({"text"}, "surveymc list has them", "", "name of the study", true)},
      {"seed", key({"integer"}, "in [0, 9223372036854775807]; needed where anything is drawn", "1",
                   "addresses every draw: equal seeds give equal draws")},
      {"title", key({"text"}, "any", "\"A well\"", "title of the result")},
      {"sweep.KEY",
       key({"list", "{ from, to, step }", "{ from, to, count, scale }"},
           "values of one kind: a point of the sweep each; { from, to, scale } is drawn from by a random design",
           "[1.0, 0.1]", "values of a key: a point for each combination, or what `sweep.design` says")},
      {"sweep.design",
       key({"text or table"},
           "product, zip, or { kind = latin_hypercube or sobol, points, seed } or { kind = table, file }", "\"zip\"",
           "which combinations of values are points; 'product' without it")},
      {"refine.quantity", key({"text"}, "TABLE.COLUMN that surveymc refine looks at", "\"summary.ratio_best\"",
                              "the quantity whose boundary is followed")},
      {"refine.level", key({"number"}, "the boundary; or refine.verdict", "1.0",
                           "the boundary is where the column crosses this number")},
      {"refine.verdict",
       key({"text"}, "the boundary is where rows begin to have it", "\"agrees\"",
           "in place of a level: the boundary is where the column's word changes from or to this one")},
      {"refine.cell", key({"number"}, "in (0, 1): finest cell, as a share of an axis", "0.01",
                          "size of the cells at the end; 0.01 without it")},
      {"refine.axes", key({"list of texts"}, "numeric keys of the sweep that are divided", "",
                          "axes along which cells are divided, the others make slices; all numeric keys without it")},
      {"refine.where", key({"table of keys"}, kWhere, "", kWhichRow)},
      {"refine.grid", key({"table of keys"}, "values of the axes in the first round; surveymc refine writes it", "",
                          "axes of the first round")},
      {"sensitivity.quantity",
       key({"text", "list of texts"}, "TABLE.COLUMN: how much of it each key of the sweep explains",
           "\"covariance.semi_major_m\"", "quantities of the table `sensitivity`")},
      {"sensitivity.where", key({"table of keys"}, kWhere, "", kWhichRow)},
      {"sensitivity.scale", key({"text"}, "linear, log", "\"linear\"",
                                "'log': shares of the variance of the quantity's logarithm; 'linear' without it")},
      {"sensitivity.confidence", key({"number"}, "in (0, 1): of all intervals of a quantity together", "0.95",
                                     "confidence of the intervals; 0.95 without it")},
      {"sweep.case[].name", key({"text"}, "a point with keys of its own; all names differ", "\"a\"",
                                "name of a case, which is a point, or one for each combination with `[sweep]`")},
      {"sweep.case[].KEY", key({"as of KEY"}, "its value in that case", "", "value of a key in the case")}};
  out.at("seed").ranges = {Range::non_negative()};
  out.at("refine.cell").ranges = out.at("sensitivity.confidence").ranges = {Range::open(0, 1)};
  if (asked.contains("error_model.name"))
    for (const char* pattern : {"match", "without"})
      out[std::string("sweep.error_model.name.") + pattern] =
          key({"text or list of texts"}, "patterns of shipped error models; * stands for any text", "[\"MWD+*\"]",
              pattern == std::string("match")
                  ? "shipped error models that are swept, in the order of the catalogues; `surveymc check` prints them"
                  : "shipped error models that are left out of the sweep");
  return out;
}

}  // namespace surveymc::config
