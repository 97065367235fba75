#pragma once
/// The event that an error along a direction exceeds a limit, as linear theory has it: how likely, and where it begins.
#include <vector>

#include <Eigen/Core>

#include "events/event_study.h"
#include "rare/mixing_normal.h"

namespace surveymc::events {

struct LinearEvent {
  Eigen::VectorXd slope;  ///< change of the error by every normal, in any unit; errors that are no normals at V = 1
  double limit = 0;       ///< standard deviations of the error
  bool is_two_sided = false;
  std::vector<rare::MixingNormal> mixing = {};
};

/// Sets predictions, starts and is_two_sided of `event`: "first_order" from the laws of the errors
/// (stats/heavy_tail.h), NaN where that has no number (several V below 1e-8, a limit that is not positive, one side of
/// a law that is not symmetric); and with laws "normal", the tail of a normal distribution of the same variance.
/// Starts: the nearest points of each side with all V at their medians, and near each of the four V with most of the
/// variance alone being large, with all V of more than a fiftieth of it, at most eight, as large as it takes.
void predict(TrialEvent& event, const LinearEvent& linear);

/// The formulations that predict() may give: "normal" only with laws.
inline std::vector<std::string> linear_formulations(bool has_laws) {
  if (!has_laws) return {"first_order"};
  return {"first_order", "normal"};
}

}  // namespace surveymc::events
