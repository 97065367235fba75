#pragma once
/// The config of the study `error_model_monte_carlo` as values (see study.cpp).
#include <optional>
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "compare/tails.h"
#include "compare/trial_plan.h"
#include "compare/verdict.h"
#include "disturbance/station_disturbance.h"
#include "events/event_study.h"
#include "propagate/well_errors.h"
#include "random/study_id.h"
#include "scenario/error_models.h"

namespace surveymc::studies::error_model_monte_carlo {

/// `errors.sources`.
enum class Sources {
  total,       ///< the whole model
  each,        ///< and every source alone
  listed,      ///< and some of them
  quadrature,  ///< sources alone, without trials
};

struct Scenario {
  random::StudySeed seed;
  compare::TrialPlan trial_plan;  ///< no trials by quadrature
  std::uint64_t save_samples = 0;
  bool antithetic = false;
  survey::ReferenceField field;
  double latitude = 0;  ///< rad; NaN where no model needs it
  survey::Survey survey;
  std::vector<double> tvd;  ///< m
  scenario::ToolRuns tools;
  std::optional<disturbance::Disturbance> disturbance;  ///< its terms are in the models of `tools`
  std::vector<propagate::Validity> validity;
  double multiplier = 1;
  propagate::VerticalRule vertical = propagate::VerticalRule::tilt;
  Sources sources = Sources::total;
  std::vector<std::string> listed;  ///< codes, with Sources::listed
  std::vector<std::string> formulations;
  random::ReferenceLaws laws;
  compare::TailRule tails;
  std::vector<double> report_md;  ///< m, rising
  compare::VerdictRule verdict;
  compare::Annotations annotations;
  config::ConfigPlace model_place;
  std::vector<events::EventRule> events;  ///< not empty: the run is one of events, and report_md one station
  events::EventRun event_run;

  bool samples() const { return sources != Sources::quadrature; }
};
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

/// True of the sources that Sources::quadrature takes: not random, and of few draws.
bool is_for_quadrature(const propagate::ErrorSource& source);

/// Two of first order, and those of orders::kFormulationNames beyond it.
inline const std::vector<std::string> kFormulations{"iscwsa",    "minimum_curvature", "second",
                                                    "unscented", "cubature5",         "profile"};
/// What an event may be about: the error at the reported depth along a direction, and its size in predicted sds.
inline const std::vector<std::string> kEventQuantities{
    "north_m",     "east_m",     "vertical_m",     "high_side_m",     "lateral_m",     "along_hole_m",
    "north_in_sd", "east_in_sd", "vertical_in_sd", "high_side_in_sd", "lateral_in_sd", "along_hole_in_sd"};
constexpr std::size_t kFirstInSd = 6;

inline bool is_first_order(const std::string& formulation) {
  return formulation == "iscwsa" || formulation == "minimum_curvature";
}

}  // namespace surveymc::studies::error_model_monte_carlo
