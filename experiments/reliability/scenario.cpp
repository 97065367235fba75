#include "reliability/scenario.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/units.h"
#include "config/meanings.h"
#include "config/suggest.h"

namespace surveymc::studies::reliability {

namespace {

/// Number of the observation `name` under `key`, which must be observed and not be in `before`.
std::size_t read_observation(const config::ConfigReader& c, const std::string& key, const std::string& name,
                             AdjustmentMode mode, const std::vector<std::size_t>& before, const char* or_all) {
  const auto& names = observation_names();
  const auto at = std::find(names.begin(), names.end(), name);
  c.require(at != names.end(), key,
            fmt::format("\"{}\" is none of {}{}{}", name, fmt::join(names, ", "), or_all,
                        config::suggestion(name, {names.begin(), names.end()})));
  const auto o = static_cast<std::size_t>(at - names.begin());
  c.require(
      is_observed(mode, o), key,
      fmt::format("{} is not observed in mode {}", name, adjustment_mode_names()[static_cast<std::size_t>(mode)]));
  c.require(std::find(before.begin(), before.end(), o) == before.end(), key, name + " is in the list twice");
  return o;
}

}  // namespace

std::vector<std::size_t> read_observations(config::ConfigReader& c, AdjustmentMode mode) {
  const std::vector<std::string> wanted =
      c.texts("observation", "the reading or reference in error: one, a list, or 'all'");
  if (wanted == std::vector<std::string>{"all"}) return observed(mode);
  std::vector<std::size_t> all;
  for (const std::string& name : wanted)
    all.push_back(read_observation(c, "observation", name, mode, all, ", nor is it \"all\" alone"));
  return all;
}

std::vector<ErrorSubject> read_subjects(config::ConfigReader& c, AdjustmentMode mode) {
  for (const char* other : {"direction", "weakest_of"})
    c.require(!c.has(other) || !c.has("observation"), other, "not together with observation");
  c.require(!c.has("direction") || !c.has("weakest_of"), "weakest_of", "not together with direction");
  std::vector<ErrorSubject> subjects;
  if (c.has("direction")) {
    std::vector<std::pair<std::size_t, double>> entries;
    std::vector<std::size_t> numbers;
    double square = 0;
    for (const auto& [name, length] :
         c.number_table("direction", config::Range::closed(-1e6, 1e6),
                        "in place of `observation`: an error in two or more at once, in sd; of any length")) {
      numbers.push_back(read_observation(c, "direction", name, mode, numbers, ""));
      entries.emplace_back(numbers.back(), length);
      c.require(std::abs(length) >= 1e-6, "direction", name + " must not be 0, nor below 1e-6");
      square += length * length;
    }
    c.require(entries.size() > 1, "direction", "takes two observations or more; one alone is an observation");
    std::sort(entries.begin(), entries.end());
    ErrorSubject s;
    for (const auto& [o, length] : entries) {
      s.observations.push_back(o);
      s.direction.push_back(length / std::sqrt(square));
    }
    subjects.push_back(std::move(s));
  } else if (c.has("weakest_of")) {
    ErrorSubject s;
    for (const std::string& name :
         c.texts("weakest_of",
                 "in place of `observation`: two or more; of all combinations of one length the one that shows least"))
      s.observations.push_back(read_observation(c, "weakest_of", name, mode, s.observations, ""));
    c.require(s.observations.size() > 1, "weakest_of", "takes two observations or more; one alone is an observation");
    subjects.push_back(std::move(s));
  } else {
    for (const std::size_t o : read_observations(c, mode)) subjects.push_back({{o}, {}});
  }
  return subjects;
}

std::array<double, 3> read_gross_error(config::ConfigReader& c, const std::vector<ErrorSubject>& subjects) {
  const std::array<std::string, 3> units{"mps2", "nT", "deg"};
  std::array<double, 3> sizes;
  bool any = false;
  for (std::size_t u = 0; u < units.size(); ++u) {
    const std::string key = "gross_error_" + units[u];
    sizes[u] = kNaN;
    if (!c.has(key)) continue;
    any = true;
    sizes[u] = c.number(
        key, config::Range::closed(-1e6, 1e6),
        "size of the gross error in the observations of this unit; if any is given, every observation needs one");
    c.require(sizes[u] != 0, key, "must not be 0");
    c.require(std::any_of(subjects.begin(), subjects.end(),
                          [&](const ErrorSubject& s) { return subject_unit(s) == units[u]; }),
              key, "no observation of the maps has this unit");
  }
  for (const ErrorSubject& s : subjects) {
    const auto u = static_cast<std::size_t>(std::find(units.begin(), units.end(), subject_unit(s)) - units.begin());
    c.require(!any || !std::isnan(sizes[u]), "observation",
              fmt::format("{} needs gross_error_{}, as the other observations have a gross error", subject_name(s),
                          subject_unit(s)));
  }
  return sizes;
}

ReliabilityGrid read_grid(config::ConfigReader& c, double dip_of_place) {
  ReliabilityGrid g;
  const config::Range dip = config::Range::closed(-89, 89);
  g.dip_deg = c.has("field.model") ? std::vector<double>{dip_of_place / kDegree}
              : c.has("field.dip_deg")
                  ? c.grid("field.dip_deg", dip, config::meaning::kDip)
                  : std::vector<double>{c.number("field.dip_deg", dip, config::kMeaningElsewhere, 75)};
  const config::Range factor{0, 1000, true, false};
  g.noise_scale = c.has("noise_scale")
                      ? c.grid("noise_scale", factor, "multiplies the noise sigmas of both sensors")
                      : std::vector<double>{c.number("noise_scale", factor, config::kMeaningElsewhere, 1)};
  g.inclination_deg = c.grid("inclination_deg", config::Range::closed(0, 180), "inclinations of the grid");
  g.toolface_deg = c.grid("toolface_deg", config::Range::closed(-360, 360), "toolfaces of the grid, from y");
  g.magnetic_azimuth_deg =
      c.grid("magnetic_azimuth_deg", config::Range::closed(-360, 360), "magnetic azimuths of the grid");
  return g;
}

}  // namespace surveymc::studies::reliability
