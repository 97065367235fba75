#pragma once
/// A run of events: replaces a study's point if its config has `[[event]]`; also the study `rare_event`.
///
///   events as limit states -> proposals (event_sampling.h) -> weighted trials -> tables probability, sampling,
///   design_points, importance; samples hits
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "compare/annotations.h"
#include "events/event_sampling.h"
#include "study/experiment.h"

namespace surveymc::events {

/// An entry of `[[event]] name, quantity, below or above, at (optional)`.
struct EventRule {
  std::string name;
  std::size_t quantity = 0;  ///< in the list that read_events() got
  double limit = kNaN;       ///< NaN: a quantity that happens or not
  bool is_above = false;
  config::ConfigPlace place;
};

/// The limits that an event of a quantity may have.
enum class EventLimits {
  none,        // it happens or not: neither `below` nor `above`
  either,      // of any sign
  positive,    // a size: `below` or `above`, > 0
  only_above,  // a size that is 0 where nothing is drawn: `above`, > 0
};

/// A quantity that an event may be about.
struct EventQuantity {
  std::string name;
  EventLimits limits = EventLimits::either;
};

/// True if the config's run is one of events.
bool has_events(const config::ConfigReader& config);

/// The events of this point of the sweep, at least one. Call it when the other keys were read. Throws InputError.
std::vector<EventRule> read_events(config::ConfigReader& config, const std::vector<EventQuantity>& quantities);

/// Refuses keys of the tables that a run of events has not. Throws InputError.
void refuse_beside_events(const config::ConfigReader& config, const std::vector<std::string>& keys);

/// The rows that `[[published]]` and `[[expect]]` may name: the quantity "probability" of each formulation, and "form".
/// A formulation that an expectation names and no event has becomes a row without a verdict: not as expected.
compare::Annotations read_event_annotations(config::ConfigReader& config, const std::vector<std::string>& formulations);

/// One event, ready to be prepared.
struct TrialEvent {
  std::string name;
  std::shared_ptr<const rare::LimitState> state;  ///< keeps what it refers to
  rare::TrialAddresses from;
  std::vector<std::string> normals = {};                         ///< name of each; "": not drawn. None: no importance
  std::vector<std::pair<std::string, double>> predictions = {};  ///< formulation, probability; NaN: not known
  std::vector<rare::HalfSpace> half_spaces = {};                 ///< for method "union"; none: the event is no union
  std::vector<Eigen::VectorXd> starts = {};                      ///< of the preparing (rare::prepare_proposal)
  bool is_two_sided = false;                                     ///< FORM has half of it, and no row "form"
  bool has_designs = false;  ///< the starts are all of its design points, to first order: no pilots look for others
  config::ConfigPlace place = {};
};

/// The plan of a point whose events `events()` makes in the task that runs it, and once before. Throws InputError, with
/// the place of the event, where one holds without any draw; preparing throws Interrupted at options.stop.
/// `trial_cost`: of a trial here, compared with those of the other points (PointPlan::cost).
std::unique_ptr<study::PointPlan> event_plan(EventRun run, compare::Annotations annotations, random::Stream stream,
                                             std::function<std::vector<TrialEvent>()> events,
                                             int block_trials = montecarlo::kBlockTrials, double trial_cost = 1);

/// Says how likely the events of a result are; nothing without the table probability.
void say_probabilities(compare::Answer& answer, const store::Result& result);

}  // namespace surveymc::events
