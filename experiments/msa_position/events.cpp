/// Events of `msa_position`: an estimate or the final error beyond a limit, where the config has `[[event]]`.
#include <cmath>

#include "analysis/msa_event.h"
#include "base/units.h"
#include "msa_position/study.h"
#include "random/rare_channels.h"
#include "stats/normal_tail.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::msa_position {
namespace {

/// What the events of a point share.
struct EventInputs {
  analysis::MsaTrials trials;
  Model model;
};

struct HeldEvent {
  std::shared_ptr<const EventInputs> inputs;
  analysis::MsaEvent state;
};

}  // namespace

std::vector<events::TrialEvent> events_of(const Scenario& s) {
  Model model = model_of(s);
  const sensor::CleanReadings clean = model.clean;
  const auto inputs =
      std::make_shared<const EventInputs>(EventInputs{{s.survey, s.field, clean, s.noise, s.spread}, std::move(model)});
  const analysis::MsaPrediction& p = inputs->model.prediction;
  const Eigen::Vector3d truth = survey::minimum_curvature_positions(s.survey).back();
  std::vector<events::TrialEvent> events;
  for (const events::EventRule& rule : s.events) {
    const auto held = std::make_shared<const HeldEvent>(HeldEvent{
        inputs,
        analysis::MsaEvent(inputs->trials, *inputs->model.estimator, {rule.quantity, rule.limit, rule.is_above})});
    const sensor::ReadingNormals& normals = held->state.normals();
    events::TrialEvent e;
    e.name = rule.name;
    e.state = {held, &held->state};
    e.from = analysis::addresses_of(normals, random::kRareChoice);
    e.normals = sensor::names_of(normals, s.survey.size());
    e.place = rule.place;
    const bool is_parameter = rule.quantity < analysis::kMsaNorth;
    // A length is no linear function of the draws; and what is predicted of an estimate is its error, without the tool.
    if (rule.quantity != analysis::kMsaDistance && !(is_parameter && s.spread.any())) {
      const auto q = static_cast<int>(rule.quantity);
      const double mean = is_parameter ? p.parameters[q] : p.position[q - 6] - truth[q - 6],
                   sd = std::sqrt(p.linear.covariance(q, q));
      const double beta = held->state.g_of(mean) / sd;
      e.predictions = {{"first_order", stats::normal_upper_tail(beta)}};
      const Eigen::VectorXd slope = analysis::gradient_of(p.weights, q, normals);
      e.starts = {(rule.is_above ? 1 : -1) * beta * slope / slope.norm()};
    }
    events.push_back(std::move(e));
  }
  return events;
}

}  // namespace surveymc::studies::msa_position
