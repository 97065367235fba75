#include "config/shipped_models.h"

#include <algorithm>

#include <fmt/format.h>

#include "config/config.h"
#include "config/error_model_file.h"
#include "config/suggest.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

constexpr std::string_view kHeader = "[[model]]\n";

/// The text of `key = "text"` at the beginning of a line; empty if there is none.
std::string text_of_key(std::string_view toml, std::string_view key) {
  const std::string line = fmt::format("\n{} = \"", key);
  const auto at = toml.find(line);
  if (at == std::string_view::npos) return "";
  const auto begin = at + line.size();
  return std::string(toml.substr(begin, toml.find('"', begin) - begin));
}

/// Tables of the shipped files begin with their header in a line of its own (held by a test).
void add_models(const InputText& file, std::vector<ShippedModel>& out) {
  const std::string_view text = file.text;
  std::size_t at = text.find(kHeader);
  if (at == std::string_view::npos) {
    if (text.find("\nterms = ") != std::string_view::npos) out.push_back({file.path, file.path, "", text});
    return;
  }
  while (at != std::string_view::npos) {
    const std::size_t next = text.find(kHeader, at + 1);
    const std::string_view one = text.substr(at, next == std::string_view::npos ? next : next - at);
    out.push_back({text_of_key(one, "name"), file.path, text_of_key(one, "extends"), one});
    at = next;
  }
}

/// `*` in the pattern stands for any text. The first place where a piece fits leaves most of the name to the others, so
/// no other place is tried.
bool fits(std::string_view pattern, std::string_view name) {
  auto star = pattern.find('*');
  if (star == std::string_view::npos) return pattern == name;
  if (!name.starts_with(pattern.substr(0, star))) return false;
  for (;;) {
    name.remove_prefix(star);
    pattern.remove_prefix(star + 1);
    star = pattern.find('*');
    if (star == std::string_view::npos) return name.ends_with(pattern);
    const auto at = name.find(pattern.substr(0, star));
    if (at == std::string_view::npos) return false;
    name.remove_prefix(at);
  }
}

}  // namespace

const std::vector<ShippedModel>& shipped_models() {
  static const std::vector<ShippedModel> models = [] {
    std::vector<ShippedModel> out;
    for (const InputText& file : shipped_error_model_files()) add_models(file, out);
    return out;
  }();
  return models;
}

const ShippedModel* find_shipped_model(const std::string& name) {
  const auto slash = name.find('/');
  const std::string catalogue = slash == std::string::npos ? "" : name.substr(0, slash), own = name.substr(slash + 1);
  for (const ShippedModel& m : shipped_models())
    if (m.name == own && (catalogue.empty() || m.catalogue == catalogue)) return &m;
  return nullptr;
}

InputText shipped_document(const ShippedModel& model) {
  return {fmt::format("<shipped>/{}.toml", model.name), std::string(model.text)};
}

std::string shipped_model_suggestion(const std::string& name) {
  std::vector<std::string> names;
  for (const ShippedModel& m : shipped_models()) names.push_back(m.name);
  if (const std::string near = suggestion(name, names); !near.empty()) return near.substr(2);  // without "; "
  std::string begin;
  for (const ShippedModel& m : shipped_models())
    if (begin.size() < 60 && !name.empty() && m.name.starts_with(name))
      begin += (begin.empty() ? "" : ", ") + in_quotes(m.name);
  return begin.empty() ? "surveymc models lists them"
                       : fmt::format("there are {} ...; surveymc models lists them", begin);
}

std::vector<std::string> matching_shipped_models(const std::vector<std::string>& match,
                                                 const std::vector<std::string>& without) {
  const auto any_fits = [](const std::vector<std::string>& patterns, const std::string& name) {
    return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& p) { return fits(p, name); });
  };
  std::vector<std::string> out;
  for (const ShippedModel& m : shipped_models())
    if (any_fits(match, m.name) && !any_fits(without, m.name)) out.push_back(m.name);
  return out;
}

const FunctionTable& shipped_functions() {
  static const FunctionTable functions = [] {
    for (const InputText& file : shipped_error_model_files())
      if (file.path == "functions") {
        Config config = Config::from_text("experiment = \"functions\"\nfile = \"functions.toml\"\n", "functions", {},
                                          {{"functions.toml", file.text}});
        return read_functions(config.reader(0).toml("file", kMeaningElsewhere));
      }
    return FunctionTable();
  }();
  return functions;
}

}  // namespace surveymc::config
