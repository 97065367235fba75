#include "msa_benefit_scenario.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "base/units.h"
#include "estimate/estimators.h"
#include "estimate/observability.h"
#include "msa_prediction.h"

namespace surveymc {
namespace {

WellDesign read_well(ConfigReader& c, StudySeed seed) {
  WellDesign w;
  w.seed = seed;
  w.kind = c.choice("well.kind", {"straight", "building"}) == "building" ? WellKind::building : WellKind::straight;
  w.stations = static_cast<int>(c.integer("well.stations", 2, 10000));
  w.spacing = c.number("well.spacing_m", Range{0, 1000, true, false}, 30);
  // Given but unused values stay allowed, so that `kind` can be swept.
  const double per_30m = c.number("well.build_rate_deg_per_30m", Range{0, 90, true, false}, 3);
  if (w.kind == WellKind::building) {
    w.build_rate = per_30m * kDegree / 30;
    c.require(w.build_rate * w.spacing <= kPi / 2, "well.build_rate_deg_per_30m",
              fmt::format("with well.spacing_m = {} there is more than 90 deg between two stations", w.spacing));
  }
  const std::string toolface = c.choice("well.toolface", {"even", "random", "constant"}, "even");
  w.toolface = toolface == "random"     ? ToolfaceSequence::random
               : toolface == "constant" ? ToolfaceSequence::constant
                                        : ToolfaceSequence::even;
  if (w.toolface == ToolfaceSequence::random && !c.has("seed"))
    c.fail("well.toolface", "\"random\" is drawn by the config's seed: give it, in the file's first lines");
  return w;
}

std::array<bool, 6> read_estimated(ConfigReader& c) {
  std::array<bool, 6> estimated{true, true, true, true, true, true};
  if (!c.has("estimator.estimated")) return estimated;
  estimated.fill(false);
  for (const std::string& name : c.texts("estimator.estimated")) {
    const auto* at = std::find(kParameterNames.begin(), kParameterNames.end(), name);
    if (at == kParameterNames.end())
      c.fail("estimator.estimated", fmt::format("\"{}\" is none of {}", name, fmt::join(kParameterNames, ", ")));
    bool& flag = estimated[static_cast<std::size_t>(at - kParameterNames.begin())];
    c.require(!flag, "estimator.estimated", "\"" + name + "\" is there twice");
    flag = true;
  }
  return estimated;
}

std::vector<RowName> row_names() {
  std::vector<RowName> rows;
  for (const char* quantity : kBenefits)
    for (const char* when : {"before", "after"})
      rows.push_back({"verification", "", fmt::format("sd_{}_{}", quantity, when)});
  return rows;
}

void read_verified(ConfigReader& c, BenefitScenario& s) {
  for (ConfigReader& entry : c.tables("verify")) {
    VerifiedDirection v{entry.number("inclination_deg", Range::closed(0, 180)),
                        entry.number("azimuth_deg", Range::closed(0, 360))};
    // Nothing is asked of a vertical hole that could be compared: its azimuth is that of the tool.
    entry.require(v.inclination_deg >= 1 && v.inclination_deg <= 179, "inclination_deg",
                  "must be in [1, 179]: closer to the vertical an azimuth is not nearly linear in the readings");
    v.place = entry.place("inclination_deg");
    s.verify.push_back(std::move(v));
  }
  const bool given = c.has("trials");
  if (s.verify.empty()) {
    if (given) c.fail("trials", "without [[verify]] there is nothing to simulate: leave it out");
    return;
  }
  s.trials = static_cast<std::uint64_t>(c.integer("trials", 2, 1'000'000'000'000));
}

}  // namespace

Survey benefit_well(const BenefitScenario& s, double inclination_deg, double azimuth_deg) {
  constexpr double kOffVertical = 1e-6;
  return make_well(s.well, std::clamp(inclination_deg * kDegree, kOffVertical, kPi - kOffVertical),
                   azimuth_deg * kDegree);
}

BenefitScenario read_benefit_scenario(ConfigReader& c, StudySeed seed) {
  BenefitScenario s;
  s.seed = seed;
  s.inclination_deg = c.grid("inclination_deg", Range::closed(0, 180));
  s.azimuth_deg = c.grid("azimuth_deg", Range::closed(0, 360));
  s.field = read_field(c);
  s.well = read_well(c, seed);
  s.spread = read_tool_spread(c);
  s.noise = read_noise(c);
  c.require(symmetric(s.noise.law), "noise.law", "must be symmetric about zero (\"gaussian\", \"uniform\")");
  s.errors = input_errors(s.noise, s.spread, s.field);
  s.estimator = read_estimator(c, s.errors, s.field);
  c.require(!estimator_kind(s.estimator.name).needs_attitude, "estimator.name",
            "must be one that compares with a reference: " + s.estimator.name + " takes the true attitude as known");
  s.estimator.estimated = read_estimated(c);
  s.verdict = read_verdict_rule(c);
  read_verified(c, s);
  s.annotations = Annotations::read(c, row_names());
  c.finish();
  return s;
}

}  // namespace surveymc
