#pragma once
/// Tables of the study collision (docs/results-format.md).
#include <vector>

#include "collision/pair_event.h"
#include "store/table.h"

namespace surveymc::studies::collision {

/// An event with what was found of it.
struct JudgedEvent {
  const PairEvent* event;
  events::EventEstimate found;
  stats::Tally tally;  ///< its part of the tally
  PairEvent::SizeSlope slope = {};
};

std::vector<store::Table> tables_of(const Scenario& scenario, const std::vector<JudgedEvent>& events);

/// Samples: the hits among the first trials.
store::Table hits_table(const stats::Tally& tally);

}  // namespace surveymc::studies::collision
