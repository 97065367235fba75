#include "sweep/config_keys.h"

#include <algorithm>
#include <deque>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "compare/table_rows.h"
#include "config/key_log.h"

namespace surveymc::sweep {
namespace {

/// A key, and what is supposed of it: a value as TOML, kSaid or kGone.
using Supposition = std::pair<std::string, std::string>;
constexpr const char* kSaid = "said";
constexpr const char* kGone = "gone";
constexpr const char* kMust = "must be given";

/// Reads one shipped config under suppositions, and finds the next ones.
class Explorer {
 public:
  Explorer(const study::Experiment& experiment, const config::InputText& file, std::shared_ptr<config::KeyLog> log)
      : experiment_(experiment), log_(std::move(log)), config_(config::config_with_log(file, log_)) {}

  /// Counts in `seen` the points that ask for a key; of keys in an array of tables the tables that do, and those tables
  /// ("leg[]"). The number of points.
  std::size_t read_points(std::map<std::string, std::size_t>& seen) {
    constexpr std::size_t kMost = 64;  // spread over a sweep that has more
    const std::size_t count = config_.point_count(), step = 1 + (count - 1) / kMost;
    std::size_t points = 0;
    for (std::size_t i = 0; i < count; i += step, ++points) {
      read(i);
      std::set<std::string> tables;
      for (const std::string& key : log_->asked) {
        ++seen[config::KeyLog::without_indices(key)];
        if (const std::size_t end = key.rfind(']'); end != std::string::npos) tables.insert(key.substr(0, end + 1));
      }
      for (const std::string& table : tables) ++seen[config::KeyLog::without_indices(table)];
    }
    return points;
  }

  /// `done`: suppositions that an example took; others are tried in every example.
  void explore(std::set<Supposition>& done) {
    constexpr int kMostReads = 2000, kDeepest = 12;
    std::set<Supposition> tried = done;
    std::set<std::vector<Supposition>> known;  // in order, but for the last, on which depends what comes next
    std::deque<std::vector<Supposition>> open{{}};
    for (int reads = 0; !open.empty() && reads < kMostReads; ++reads) {
      const std::vector<Supposition> now = std::move(open.front());
      open.pop_front();
      suppose(now);
      const bool is_taken = read(0);
      if (is_taken && !now.empty()) done.insert({config::KeyLog::without_indices(now.back().first), now.back().second});
      if (now.size() >= kDeepest) continue;
      for (const Supposition& s : next(now)) {
        // What a branch misses is tried in that branch; everything else once, wherever it shows first.
        const bool is_for_branch = s.first == log_->missing || s.first == log_->refused;
        if (!is_for_branch && !tried.insert({config::KeyLog::without_indices(s.first), s.second}).second) continue;
        std::vector<Supposition> more = now;
        std::erase_if(more, [&](const Supposition& old) { return old.first == s.first; });
        more.push_back(s);
        // Branches meet, and a key that is given, refused and left out in turn would lead round for ever.
        std::vector<Supposition> as_set = more;
        std::sort(as_set.begin(), as_set.end() - 1);
        if (known.insert(std::move(as_set)).second) open.push_back(std::move(more));
      }
    }
    suppose({});
  }

 private:
  void suppose(const std::vector<Supposition>& all) {
    log_->supposed.clear();
    log_->said.clear();
    log_->gone.clear();
    for (const auto& [key, what] : all) {
      if (what == kSaid)
        log_->said.insert(key);
      else if (what == kGone)
        log_->gone.insert(key);
      else
        log_->supposed[key] = what;
    }
  }

  /// False if the study refuses what it reads.
  bool read(std::size_t point) {
    try {
      config::ConfigReader reader = config_.reader(point);
      experiment_.read(reader, {0, experiment_.id});
      if (reader.has("field.model") && !reader.has("map.latitude_deg")) scenario::read_placed_field(reader);
      return true;
    } catch (const std::exception&) {  // what was asked until then counts
      return false;
    }
  }

  /// What is worth trying after the last read.
  std::vector<Supposition> next(const std::vector<Supposition>& now) const {
    const auto is_supposed = [&](const std::string& key) {
      return std::any_of(now.begin(), now.end(), [&](const Supposition& s) { return s.first == key; });
    };
    std::vector<Supposition> out;
    // A key that was supposed first may be what does not go together with the one that has just been said to be there.
    const bool may_go = !is_supposed(log_->refused) || now.back().second == kSaid;
    if (!log_->refused.empty() && may_go) out.emplace_back(log_->refused, kGone);
    if (const std::string& key = log_->missing; !key.empty()) {
      for (const std::string& value : values_of(key)) out.emplace_back(key, value);
      return out;
    }
    for (const std::string& key : log_->denied) out.emplace_back(key, kSaid);
    for (const std::string& key : log_->asked)
      for (const std::string& value : values_of(key))
        if (!is_supposed(key)) out.emplace_back(key, value);
    return out;
  }

  /// Values of a key that lead to branches of their own, or one that its getter takes.
  std::vector<std::string> values_of(const std::string& key) const {
    const config::KeyUse& use = log_->use(key);
    std::vector<std::string> out;
    for (const std::string& word : use.choices) out.push_back("\"" + word + "\"");
    for (const std::string& type : use.types) {
      if (type == "true or false") out.insert(out.end(), {"true", "false"});
      if (type == "array of tables" && use.example.empty()) out.push_back(use.sample);
    }
    const bool is_needed = key == log_->missing;
    if (out.empty() && is_needed && !use.sample.empty()) out.push_back(use.sample);
    if (out.empty() && is_needed && !use.example.empty()) out.push_back(use.example);
    if (out.empty() && is_needed) out.push_back("\"a\"");
    return out;
  }

  const study::Experiment& experiment_;
  std::shared_ptr<config::KeyLog> log_;
  config::Config config_;
};

std::string type_of(const config::KeyUse& use) {
  const auto is_file = [](const std::string& type) { return type.ends_with("file"); };
  std::vector<std::string> types = use.types;
  if (std::any_of(types.begin(), types.end(), is_file))
    std::erase_if(types, [&](const std::string& type) { return !is_file(type); });
  if (types.size() > 1) std::erase_if(types, [](const std::string& type) { return type == "text"; });
  return fmt::format("{}", fmt::join(types, " or "));
}

/// The table above a key that a config need not have: "[stop]", "[[leg]]"; "" if there is none.
std::string optional_table(const std::string& key, const std::map<std::string, config::KeyUse>& keys) {
  for (std::size_t dot = key.rfind('.'); dot != std::string::npos && dot > 0; dot = key.rfind('.', dot - 1)) {
    const std::string above = key.substr(0, dot);
    if (above.ends_with("[]")) return "[[" + above.substr(0, above.size() - 2) + "]]";
    const auto table = keys.find(above);
    if (table != keys.end() && table->second.may_be_absent) return "[" + above + "]";
  }
  return "";
}

/// False for a key that may be absent wherever it is asked for.
bool must_be_there(const config::KeyUse& use) { return use.defaults.empty() && !use.may_be_absent; }

std::string default_of(const std::string& key, const std::map<std::string, config::KeyUse>& keys) {
  const config::KeyUse& use = keys.at(key);
  if (must_be_there(use)) {
    const std::string table = optional_table(key, keys);
    return table.empty() ? kMust : "needed in " + table;
  }
  if (use.defaults.empty()) return "-";
  constexpr std::size_t kMost = 2;
  std::vector<std::string> values = use.defaults;
  for (std::string& v : values)
    if (v.empty()) v = "-";
  const bool are_numbers = std::none_of(values.begin(), values.end(), [](const std::string& v) { return v[0] == '"'; });
  if (values.size() > (are_numbers ? 1 : kMost)) return "by other keys";
  const bool is_needed_sometimes = use.is_needed && !use.may_be_absent;
  return fmt::format("{}{}", fmt::join(values, " or "), is_needed_sometimes ? ", or needed by other keys" : "");
}

/// Several intervals whose upper ends differ are those of the examples: stations of a survey, depths of a well.
void join_intervals(std::vector<std::string>& rules) {
  const auto is_interval = [](const std::string& rule) { return rule.starts_with("in [") && rule.ends_with("]"); };
  std::set<std::string> lows, highs;
  for (const std::string& rule : rules)
    if (const std::size_t comma = rule.find(", "); is_interval(rule) && comma != std::string::npos) {
      lows.insert(rule.substr(4, comma - 4));
      highs.insert(rule.substr(comma));
    }
  if (highs.size() < 2) return;
  std::erase_if(rules, is_interval);
  rules.push_back(lows.size() == 1 ? fmt::format("in [{}, N], N by other keys", *lows.begin())
                                   : "in an interval by other keys");
}

std::string rule_of(const config::KeyUse& use) {
  std::vector<std::string> rules = use.rules;
  join_intervals(rules);
  if (!use.choices.empty()) {
    std::vector<std::string> words;
    for (const std::string& w : use.choices) words.push_back("\"" + w + "\"");
    rules.push_back(fmt::format("{}{}", words.size() > 1 ? "one of " : "", fmt::join(words, ", ")));
  }
  return fmt::format("{}", fmt::join(rules, "; or "));
}

std::string shortened_example(const std::string& key, const config::KeyUse& use) {
  constexpr std::size_t kLongest = 60;
  const std::string type = use.types.empty() ? "" : use.types.front();
  if (type == "array of tables") return "[[" + key + "]]";
  const std::string text = !use.example.empty()      ? use.example
                           : !use.choices.empty()    ? "\"" + use.choices.back() + "\""
                           : type == "true or false" ? "true"
                                                     : use.sample;
  if (text.size() <= kLongest) return text;
  const std::size_t comma = text.rfind(',', kLongest - 4);
  return (comma == std::string::npos ? text.substr(0, kLongest - 4) : text.substr(0, comma + 1)) + " ...";
}

}  // namespace

std::vector<ListedKey> listed_keys(const study::Experiment& experiment, config::KeysOf which) {
  const auto log = std::make_shared<config::KeyLog>();
  std::vector<Explorer> examples;
  const std::string line = fmt::format("\nexperiment = \"{}\"\n", experiment.name());
  for (const config::InputText& file : config::shipped_config_files())
    if (("\n" + file.text).find(line) != std::string::npos) examples.emplace_back(experiment, file, log);
  std::map<std::string, std::size_t> seen;
  std::size_t points = 0;
  for (Explorer& e : examples) points += e.read_points(seen);
  std::set<Supposition> done;
  if (which == config::KeysOf::all_branches)
    for (Explorer& e : examples) e.explore(done);

  std::vector<ListedKey> listed;
  const std::map<std::string, config::KeyUse> general = config::keys_of_every_file(log->keys);
  for (const auto& [key, use] : general) listed.push_back({key, default_of(key, general), use, key == "experiment"});
  for (const auto& [key, use] : log->keys) {
    if (use.types.empty() || general.contains(key)) continue;
    const std::string usual = default_of(key, log->keys);
    const bool is_sometimes = usual == kMust && seen[key] < points;
    const std::string table = key.substr(0, key.rfind(']') + 1);  // "leg[]"; "" outside of arrays
    const bool is_required =
        usual == kMust ? !is_sometimes : !table.empty() && must_be_there(use) && seen[key] == seen[table];
    listed.push_back({key, is_sometimes ? "needed by other keys" : usual, use, is_required});
  }
  return listed;
}

store::Table config_keys(const study::Experiment& experiment, config::KeysOf which) {
  compare::TableRows t(experiment.name(), "keys of its configs: " + experiment.summary);
  for (const auto& [key, usual, use, is_required] : listed_keys(experiment, which)) {
    t.word("key", "with the names of its tables; [] in an array of tables", key);
    t.word("type", "", type_of(use));
    t.word("unit", "", config::unit_of_key(key));
    t.word("default", "", usual);
    t.word("rule", "", rule_of(use));
    t.word("example", "as TOML", shortened_example(key, use));
    t.word("meaning", "several: it depends on other keys", fmt::format("{}", fmt::join(use.meanings, "; or ")));
  }
  return t.take();
}

}  // namespace surveymc::sweep
