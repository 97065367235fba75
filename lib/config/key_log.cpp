#include "config/key_log.h"

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
  const auto key = [](std::vector<std::string> types, const std::string& rule, const std::string& example, bool must) {
    return KeyUse{std::move(types), {rule}, {}, {}, !must, example, ""};
  };
  std::map<std::string, KeyUse> out{
      {"experiment", key({"text"}, "surveymc list has them", "", true)},
      {"seed", key({"integer"}, "in [0, 9223372036854775807]; needed where anything is drawn", "1", false)},
      {"title", key({"text"}, "any", "\"A well\"", false)},
      {"sweep.KEY",
       key({"list", "{ from, to, step }", "{ from, to, count, scale }"},
           "values of one kind: a point of the sweep each; { from, to, scale } is drawn from by a random design",
           "[1.0, 0.1]", false)},
      {"sweep.design",
       key({"text or table"},
           "product, zip, or { kind = latin_hypercube or sobol, points, seed } or { kind = table, file }", "\"zip\"",
           false)},
      {"refine.quantity", key({"text"}, "TABLE.COLUMN that surveymc refine looks at", "\"summary.ratio_best\"", false)},
      {"refine.level", key({"number"}, "the boundary; or refine.verdict", "1.0", false)},
      {"refine.verdict", key({"text"}, "the boundary is where rows begin to have it", "\"agrees\"", false)},
      {"refine.cell", key({"number"}, "in (0, 1): finest cell, as a share of an axis", "0.01", false)},
      {"refine.axes", key({"list of texts"}, "numeric keys of the sweep that are divided", "", false)},
      {"refine.where", key({"table of keys"}, "columns and the word that a row has in them", "", false)},
      {"refine.grid",
       key({"table of keys"}, "values of the axes in the first round; surveymc refine writes it", "", false)},
      {"sensitivity.quantity",
       key({"text", "list of texts"}, "TABLE.COLUMN: how much of it each key of the sweep explains",
           "\"covariance.semi_major_m\"", false)},
      {"sensitivity.where", key({"table of keys"}, "columns and the word that a row has in them", "", false)},
      {"sensitivity.scale", key({"text"}, "linear, log", "\"linear\"", false)},
      {"sensitivity.confidence", key({"number"}, "in (0, 1): of all intervals of a quantity together", "0.95", false)},
      {"sweep.case[].name", key({"text"}, "a point with keys of its own; all names differ", "\"a\"", false)},
      {"sweep.case[].KEY", key({"as of KEY"}, "its value in that case", "", false)}};
  if (asked.contains("error_model.name"))
    for (const char* pattern : {"match", "without"})
      out[std::string("sweep.error_model.name.") + pattern] = key(
          {"text or list of texts"}, "patterns of shipped error models; * stands for any text", "[\"MWD+*\"]", false);
  return out;
}

}  // namespace surveymc::config
