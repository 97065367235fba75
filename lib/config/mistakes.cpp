#include "config/mistakes.h"

#include <algorithm>
#include <exception>

#include <fmt/format.h>

#include "base/error.h"
#include "config/suggest.h"
#include "config/toml_tree.h"

namespace surveymc::config {
namespace {

std::string top_level(const std::string& key) { return key.substr(0, key.find_first_of(".[")); }

std::string in_words(const std::string& place, const std::string& key, const std::string& rule) {
  return fmt::format("{}: {}: {}", place, key, rule);
}

}  // namespace

void ConfigReader::Mistakes::tell(const std::string& message) {
  if (std::find(told_.begin(), told_.end(), message) == told_.end()) told_.push_back(message);
}

void ConfigReader::Mistakes::add(const std::string& full_key, const std::string& message, bool is_missing,
                                 Decides decides) {
  const std::string table = top_level(full_key);
  if (!tables_.contains(table) && !(is_presence_decided_ && is_missing)) tell(message);
  has_stand_in_ = true;
  is_presence_decided_ = is_presence_decided_ || decides == Decides::presence;
  if (decides != Decides::nothing) tables_.insert(table);
}

void ConfigReader::Mistakes::add_unknown(const std::vector<Point::UnknownKey>& unknown) {
  if (is_presence_decided_) return;
  unknown_.insert(unknown_.end(), unknown.begin(), unknown.end());
  is_whole_ = true;
}

void ConfigReader::Mistakes::add_last(const std::string& message) {
  if (has_stand_in_) return;
  tell(message);
  last_ = message;
}

std::vector<std::string> ConfigReader::Mistakes::messages(const std::vector<Point::UnknownKey>& sure) const {
  std::vector<Point::UnknownKey> unknown = unknown_;  // these know which branch was taken: better suggestions
  for (const Point::UnknownKey& u : sure)
    if (std::none_of(unknown.begin(), unknown.end(), [&](const auto& k) { return k.node == u.node; }))
      unknown.push_back(u);
  std::stable_sort(unknown.begin(), unknown.end(),
                   [](const auto& a, const auto& b) { return a.node->line < b.node->line; });
  std::vector<std::string> out;
  for (const Point::UnknownKey& u : unknown) out.push_back(in_words(u.node->place, u.key, u.rule));
  // A key that is misspelt is missing under its right name, and study code may miss it, too.
  const auto follows = [&](const std::string& message) {
    return std::any_of(unknown.begin(), unknown.end(), [&](const Point::UnknownKey& u) {
      return message.find(fmt::format("(found {}", u.key)) != std::string::npos ||
             (message == last_ && message.find(top_level(u.key)) != std::string::npos);
    });
  };
  for (const std::string& message : told_)
    if (std::find(out.begin(), out.end(), message) == out.end() && !follows(message)) out.push_back(message);
  return out;
}

const InputTable& survey_stand_in() {
  static const InputTable table = [] {
    InputTable t;
    t.path = "stand-in";
    t.names = {"md_m", "inclination_deg", "azimuth_deg", "toolface_deg", "time_s"};
    t.columns.resize(t.names.size());
    constexpr int kStations = 534;  // to 16 km
    for (int k = 0; k < kStations; ++k) {
      const std::vector<double> row{30.0 * k, std::min(60.0, 1.0 * k), 45, 20.0 * (k % 18), 3600.0 * k};
      for (std::size_t c = 0; c < row.size(); ++c) t.columns[c].push_back(row[c]);
      t.lines.push_back(k + 2);
    }
    return t;
  }();
  return table;
}

/// Makes every known key one that was asked for. `full`: the key of `at`; `pattern`: the same without numbers of
/// elements.
static void ask_for_all(const TomlNode& at, const std::string& full, const std::string& pattern, const KeyTypes& known,
                        std::set<std::string>& asked, std::set<std::string>& whole, std::set<std::string>& arrays) {
  const std::string head = pattern.empty() ? "" : pattern + ".";
  for (auto it = known.lower_bound(head); it != known.end() && it->first.starts_with(head); ++it)
    if (const std::string rest = it->first.substr(head.size()); rest.find('[') == std::string::npos)
      asked.insert(join_key(full, rest));
  for (const auto& [k, v] : at.entries) {
    const std::string key = join_key(full, k), general = join_key(pattern, k);
    const auto found = known.find(general);
    if (found != known.end() && v.is_table() && found->second.find_first_of("{") != std::string::npos)
      whole.insert(key);
    if (found != known.end() && found->second.find("table of ") != std::string::npos) whole.insert(key);
    if (v.is_table()) ask_for_all(v, key, general, known, asked, whole, arrays);
    const auto element = known.lower_bound(general + "[].");
    if (!v.is_array() || element == known.end() || !element->first.starts_with(general + "[].")) continue;
    arrays.insert(key);
    for (std::size_t i = 0; i < v.items.size(); ++i)
      ask_for_all(v.items[i], fmt::format("{}[{}]", key, i), general + "[]", known, asked, whole, arrays);
  }
}

std::vector<std::string> ConfigReader::mistakes_of(Config& config, std::size_t point, const KnownKeys& known,
                                                   const std::function<void(ConfigReader&)>& read) {
  ConfigReader reader = config.reader(point);
  Point& p = *reader.point_;
  p.mistakes = std::make_shared<Mistakes>();
  try {
    read(reader);
  } catch (const InputError& e) {
    p.mistakes->add_last(e.what());
  } catch (const std::exception&) {  // a stand-in has led to what no config leads to
  }
  std::vector<Point::UnknownKey> unknown;
  p.find_unknown(p.root, "", unknown);
  for (const KeysOf which : {KeysOf::shipped_configs, KeysOf::all_branches}) {
    if (unknown.empty() || p.mistakes->is_whole()) break;
    ask_for_all(p.root, "", "", known(which), p.asked, p.whole, p.arrays);
    unknown.clear();
    p.find_unknown(p.root, "", unknown);
  }
  return p.mistakes->messages(unknown);
}

}  // namespace surveymc::config
