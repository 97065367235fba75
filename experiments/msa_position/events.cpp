/// Events of `msa_position`: an estimate or the final error beyond a limit, where the config has `[[event]]`.
#include <cmath>

#include "analysis/msa_event.h"
#include "base/units.h"
#include "events/linear_event.h"
#include "msa_position/study.h"
#include "random/rare_channels.h"
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

constexpr std::size_t kNorth = 6;      // of the sums of NoiseWeights
constexpr double kNoVariance = 1e-14;  // of the trace: such a variance is none

/// Of a quantity in standard deviations: N, E, V over the first-order sd, 1/m.
Eigen::Vector3d direction_of(const Model& model, const events::EventRule& rule) {
  const std::size_t i = rule.quantity - analysis::kMsaInSd;
  Eigen::Matrix<double, 3, 6> directions;
  directions << Eigen::Matrix3d::Identity(), model.hla_from_nev.transpose();
  const Eigen::Vector3d u = directions.col(static_cast<Eigen::Index>(i));
  const Eigen::Matrix3d& covariance = model.prediction.position_covariance[0];
  const double variance = u.dot(covariance * u);
  if (!(variance > kNoVariance * covariance.trace())) rule.place.fail("the error has no part in this direction");
  return u / std::sqrt(variance);
}

}  // namespace

std::vector<events::TrialEvent> events_of(const Scenario& s) {
  Model model = model_of(s);
  const sensor::CleanReadings clean = model.clean;
  const auto inputs =
      std::make_shared<const EventInputs>(EventInputs{{s.survey, s.field, clean, s.noise, s.spread}, std::move(model)});
  const analysis::MsaPrediction& p = inputs->model.prediction;
  const Eigen::Vector3d truth = survey::minimum_curvature_positions(s.survey).back();
  const sensor::ReferenceMixing mixing = sensor::reference_mixing(s.reference.laws, s.noise, s.survey.size());
  std::vector<events::TrialEvent> events;
  for (const events::EventRule& rule : s.events) {
    const bool is_in_sd = rule.quantity >= analysis::kMsaInSd;
    const Eigen::Vector3d direction = is_in_sd ? direction_of(inputs->model, rule) : Eigen::Vector3d::Zero();
    const auto held = std::make_shared<const HeldEvent>(
        HeldEvent{inputs, analysis::MsaEvent(inputs->trials, *inputs->model.estimator,
                                             {rule.quantity, rule.limit, rule.is_above, direction}, mixing)});
    const sensor::ReadingNormals& normals = held->state.normals();
    events::TrialEvent e;
    e.name = rule.name;
    e.state = {held, &held->state};
    e.from = analysis::addresses_of(normals, random::kRareChoice);
    e.normals = sensor::names_of(normals, s.survey.size());
    for (const sensor::NormalAddress& a : held->state.mixing_calls()) e.from.calls.push_back({a.channel, a.call});
    e.normals.resize(static_cast<std::size_t>(held->state.dimension()));
    for (const rare::MixingNormal& m : held->state.mixing()) e.normals[m.row] = "variance of the reference";
    e.place = rule.place;
    const bool is_parameter = rule.quantity < analysis::kMsaNorth;
    // A length is no linear function of the draws; and what is predicted of an estimate is its error, without the tool.
    if (rule.quantity != analysis::kMsaDistance && !(is_parameter && s.spread.any())) {
      const auto q = static_cast<int>(rule.quantity);
      events::LinearEvent linear{Eigen::VectorXd::Zero(held->state.dimension()), 0, is_in_sd, held->state.mixing()};
      auto slope = linear.slope.head(normals.rows());
      if (is_in_sd) {
        for (int axis = 0; axis < 3; ++axis)
          slope += direction[axis] * analysis::gradient_of(p.weights, static_cast<int>(kNorth) + axis, normals);
        linear.limit = rule.limit;
      } else {
        const double mean = is_parameter ? p.parameters[q] : p.position[q - 6] - truth[q - 6],
                     sd = std::sqrt(p.linear.covariance(q, q));
        slope = (rule.is_above ? 1 : -1) * analysis::gradient_of(p.weights, q, normals);
        linear.limit = held->state.g_of(mean) / sd;
      }
      events::predict(e, linear);
    }
    events.push_back(std::move(e));
  }
  return events;
}

}  // namespace surveymc::studies::msa_position
