#include "config/suggest.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/ranges.h>

#include "base/small_letters.h"
#include "config/key_log.h"
#include "config/text.h"
#include "config/toml_tree.h"

namespace surveymc::config {
namespace {

/// Endings of keys that are units, so that `total` or `total_uT` can be told from an unrelated key. In small letters:
/// total_nt is meant to have a unit.
constexpr std::string_view kUnits =
    " nt ut mt t gauss deg rad mrad arcmin arcsec turn m ft km cm mm in mi mps2 ms2 gal g mg ug s ms min h hr day d hz"
    " khz rpm pa kpa mpa bar psi k c f kg n kn pct percent ppm m2 nt2 deg2 m3 mps m3ps ";

bool is_unit(const std::string& name) {
  const std::string s = small_letters(name);
  return !s.empty() && kUnits.find(" " + s + " ") != std::string_view::npos;
}

struct Suffixed {
  std::string stem, suffix;  // of "total_nT": "total", "nT"
};
Suffixed split_suffix(const std::string& name) {
  const auto bar = name.rfind('_');
  if (bar == std::string::npos || bar == 0) return {name, ""};
  return {name.substr(0, bar), name.substr(bar + 1)};
}

/// Number of single typing errors (one letter more, less or other; two neighbours swapped) between two words, whatever
/// their case.
std::size_t typing_errors(const std::string& first, const std::string& second) {
  const std::string a = small_letters(first), b = small_letters(second);
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

std::string alternatives(const std::set<std::string>& words) { return fmt::format("{}", fmt::join(words, " or ")); }

/// The names with the fewest typing errors, of those that resemble the word; else those that begin with it. None if
/// they are many.
std::set<std::string> near_names(const std::string& word, const std::vector<std::string>& names) {
  std::set<std::string> alike, longer;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const std::string& name : names) {
    if (word.size() > 1 && small_letters(name).starts_with(small_letters(word))) longer.insert(name);
    if (!resembles(word, name)) continue;
    const std::size_t errors = typing_errors(word, name);
    if (errors < fewest) alike.clear();
    if (errors <= fewest) alike.insert(name);
    fewest = std::min(fewest, errors);
  }
  constexpr std::size_t kFew = 4;
  const std::set<std::string>& near = alike.empty() ? longer : alike;
  return near.size() <= kFew ? near : std::set<std::string>{};
}

}  // namespace

UnitFault unit_fault(const std::string& given, const std::string& known) {
  const auto k = split_suffix(known), g = split_suffix(given);
  if (is_unit(k.suffix)) {
    if (given == k.stem) return UnitFault::missing;
    if (g.stem == k.stem && is_unit(g.suffix)) return UnitFault::unknown;
  } else if (g.stem == known && is_unit(g.suffix)) {
    return UnitFault::unwanted;
  }
  return UnitFault::none;
}

std::string unit_of_key(const std::string& key) {
  const std::string suffix = split_suffix(key.substr(key.rfind('.') + 1)).suffix;
  return is_unit(suffix) ? suffix : "";
}

std::string describe(UnitFault fault) {
  return fault == UnitFault::missing   ? "the unit is missing"
         : fault == UnitFault::unknown ? "unknown unit"
                                       : "this key has no unit";
}

bool resembles(const std::string& a, const std::string& b) {
  if (small_letters(a) == small_letters(b)) return true;
  const auto [shortest, longest] = std::minmax({a.size(), b.size()});
  const std::size_t allowed = std::clamp<std::size_t>(shortest / 3, 1, 3);
  return shortest > 1 && longest <= 200 && longest - shortest <= allowed && typing_errors(a, b) <= allowed;
}

std::string nearest(const std::string& word, const std::vector<std::string>& names) {
  return alternatives(near_names(word, names));
}

std::string suggestion(const std::string& word, const std::vector<std::string>& names) {
  std::set<std::string> quoted;
  for (const std::string& name : near_names(word, names)) quoted.insert(in_quotes(name));
  return quoted.empty() ? "" : fmt::format("; did you mean {}?", alternatives(quoted));
}

std::string none_of(const std::string& word, const std::vector<std::string>& names) {
  return fmt::format("{} is none of {}{}", in_quotes(word), fmt::join(names, ", "), suggestion(word, names));
}

std::string unknown_key_rule(const std::string& path, const std::string& name, const std::set<std::string>& known) {
  // From the surest guess to the vaguest: the same key with another unit, a near name in the same table, the same stem
  // with an ending that is no unit we know, the same name in another table.
  std::set<std::string> unit_keys, siblings, stem_keys, elsewhere;
  std::optional<UnitFault> fault;
  const std::string prefix = join_key(path, "");
  if (known.contains(prefix + name)) return "unknown key here: this experiment has it beside other keys only";
  for (const auto& key : known) {
    if (key == name || key.substr(key.rfind('.') + 1) == name) elsewhere.insert(key);
    if (!key.starts_with(prefix)) continue;
    const std::string rest = key.substr(prefix.size());
    siblings.insert(rest.substr(0, rest.find_first_of(".[")));
    if (rest.find('.') != std::string::npos) continue;
    const UnitFault f = unit_fault(name, rest);
    if (f != UnitFault::none && (!fault || *fault == f)) {
      fault = f;
      unit_keys.insert(key);
    }
    const auto k = split_suffix(rest), g = split_suffix(name);
    if (is_unit(k.suffix) && g.stem == k.stem && g.suffix.size() <= 6) stem_keys.insert(key);
  }
  if (fault) return fmt::format("{}: write {}", describe(*fault), alternatives(unit_keys));

  std::string nearest;
  for (const auto& s : siblings) {
    if (s == name || !resembles(name, s)) continue;
    if (nearest.empty() || typing_errors(name, s) < typing_errors(name, nearest)) nearest = s;
  }
  if (!nearest.empty()) return fmt::format("unknown key: did you mean {}{}?", prefix, nearest);
  if (!stem_keys.empty()) return fmt::format("unknown unit: write {}", alternatives(stem_keys));
  if (!elsewhere.empty()) return fmt::format("unknown key: did you mean {}?", alternatives(elsewhere));
  return "unknown key";
}

}  // namespace surveymc::config
