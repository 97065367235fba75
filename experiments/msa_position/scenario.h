#pragma once
/// The checked settings of a config of `msa_position`.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "compare/annotations.h"
#include "compare/calibration.h"
#include "compare/row.h"
#include "compare/tails.h"
#include "compare/trial_plan.h"
#include "estimate/observability.h"
#include "events/event_study.h"
#include "random/study_id.h"
#include "scenario/drawn_reference.h"
#include "scenario/prediction_orders.h"
#include "sensor/tool_spread.h"

namespace surveymc::studies::msa_position {

constexpr std::array<const char*, 3> kDirections{"north", "east", "vertical"};
constexpr std::array<const char*, 3> kHoleDirections{"high_side", "lateral", "along_hole"};
constexpr std::array<const char*, 3> kFormulations{"joint", "systematic", "random"};  // as in MsaPrediction
/// Hanak's convention, that of thesis table 6: b = (1 - S') m - offset, printed as scale = 1 + S' = 2 - 1 / gain;
/// offset = bias / gain.
constexpr std::array<const char*, 6> kHanakParameters{"scale_x",  "scale_y",  "scale_z",
                                                      "offset_x", "offset_y", "offset_z"};
constexpr std::array<const char*, 2> kReference{"reference_total", "reference_dip"};
constexpr std::array<const char*, 2> kReferenceUnits{"nT", "deg"};

constexpr std::array<const char*, 3> kAzimuths{"azimuth_first", "azimuth_middle", "azimuth_last"};

struct Scenario {
  random::StudySeed seed;
  std::uint64_t save_samples = 0;
  compare::TrialPlan trial_plan;
  bool with_position = true;    ///< false: parameters only, for throughput
  bool control_variate = true;  ///< tally the first-order prediction of every trial beside it
  survey::ReferenceField field;
  survey::Survey survey;
  config::ConfigPlace survey_place;  ///< of its file
  sensor::MagnetometerErrors errors;
  sensor::ToolSpread spread;
  sensor::NoiseModel noise;
  scenario::DrawnReference reference;
  compare::TailRule tails;
  estimate::EstimatorOptions estimator;
  sensor::AssumedNoise assumed_noise = sensor::AssumedNoise::constant;
  scenario::PredictionOrders orders;
  compare::VerdictRule verdict;
  compare::CalibrationRule calibration;
  compare::Annotations annotations;
  std::vector<events::EventRule> events;  ///< not empty: the run is one of events
  events::EventRun event_run;
};

/// Adds rows whose sds are shown as three of them.
class RowAdder {
 public:
  explicit RowAdder(std::vector<compare::Row>& rows) : rows_(rows) {}
  compare::Row& operator()(const char* table, const char* formulation, const std::string& quantity, const char* unit,
                           compare::Statistic statistic, int component, double prediction) const;

 private:
  std::vector<compare::Row>& rows_;
};

/// A direction without first-order error (plane wells have two, a straight hole one) has only the rounding of the
/// rotation: taken as zero.
double sd_above_rounding(double variance, const Eigen::Matrix3d& covariance);

/// Throws InputError.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

}  // namespace surveymc::studies::msa_position
