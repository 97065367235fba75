#pragma once
/// Config of the study collision as checked values (docs/keys.md has the keys).
#include <array>
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "events/event_sampling.h"
#include "random/reference_laws.h"
#include "random/study_id.h"
#include "scenario/well_pairs.h"

namespace surveymc::studies::collision {

/// What a well of the study has besides those of scenario::WellPairs.
struct WellExtras {
  /// Of the place of the reference and of this well: north, east, down, m. Zero for a sidetrack: one hole, one place,
  /// which moves both wells alike.
  Eigen::Vector3d reference_slot_sd = Eigen::Vector3d::Zero(), slot_sd = Eigen::Vector3d::Zero();
  std::size_t first = 0;  ///< station of both wells from which on the pair counts
};

struct Scenario : scenario::WellPairs {
  random::StudySeed seed;
  events::EventRun run;
  compare::Annotations annotations;
  propagate::VerticalRule vertical = propagate::VerticalRule::tilt;
  std::vector<WellExtras> extras;  ///< of the offsets
  random::ReferenceLaws laws;
};

Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

/// Predictions of the table probability.
inline constexpr std::array<const char*, 6> kFormulations{"half_space", "half_space_least_sf", "slab", "disc", "point",
                                                          "form"};

}  // namespace surveymc::studies::collision
