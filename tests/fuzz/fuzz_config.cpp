/// TOML configs and --set. Lines "#set KEY=VALUE" are overrides. What is accepted is written as a resolved config that
/// reads back to itself.
#include <algorithm>
#include <vector>

#include "config/config.h"
#include "config/config_document.h"
#include "config/toml_tree.h"
#include "fuzz_input.h"

using namespace surveymc;

namespace {

constexpr std::string_view kSet = "#set ";

std::vector<std::string> overrides_in(std::string_view text) {
  std::vector<std::string> found;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    if (line.starts_with(kSet)) found.emplace_back(line.substr(kSet.size()));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
  }
  return found;
}

/// Every getter on keys that the corpus has; each may refuse what it sees.
void read_point(config::ConfigReader in) {
  is_accepted([&] { in.integer("trials", 1, 1'000'000, "", 1000); });
  is_accepted([&] { in.number("field.dip_deg", config::Range::closed(-90, 90), "", 60); });
  is_accepted([&] { in.number("noise.scale", config::Range::positive(), "", 1); });
  is_accepted([&] { in.boolean("antithetic", "", false); });
  is_accepted([&] { in.choice("estimator", {"msa", "wls"}, "", "msa"); });
  is_accepted([&] { in.text("survey.file", "", "survey.csv"); });
  is_accepted([&] { in.numbers("list", config::Range::non_negative(), ""); });
  is_accepted([&] { in.finish(); });
}

void read_config(const std::string& text) {
  config::Config config = config::Config::from_text(text, "fuzz.toml", {});
  const std::size_t points = config.point_count();
  for (std::size_t i = 0; i < std::min<std::size_t>(points, 4); ++i) {
    config.sweep_values(i);
    read_point(config.reader(i));
  }
  if (points > 0) read_point(config.reader(points - 1));
  if (points > 1000) return;  // defaults are looked up by point
  const std::string resolved = config.resolved_text();
  try {
    config::Config again = config::Config::from_text(resolved, "resolved.toml", {});
    promise(again.point_count() == points, "a resolved config has the points of the config");
    promise(again.resolved_text() == resolved, "a resolved config is its own resolved config");
  } catch (const InputError& e) {
    promise(false, e.what());
  }
}

void read_with_overrides(const std::string& text) {
  config::ConfigDocument doc;
  doc.label = "fuzz.toml";
  doc.build(config::parse_document(text, doc.label), overrides_in(text));
  if (doc.sweep.point_count() <= 1000) doc.resolved_text();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(text_of(data, size));
  is_accepted([&] { read_config(text); });
  is_accepted([&] { read_with_overrides(text); });
  return 0;
}
