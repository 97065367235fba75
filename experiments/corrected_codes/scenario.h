#pragma once
/// The checked settings of a config of `corrected_codes`.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/code_comparison.h"
#include "analysis/well_design.h"
#include "compare/annotations.h"
#include "compare/tails.h"
#include "compare/verdict.h"
#include "disturbance/station_disturbance.h"
#include "random/study_id.h"
#include "scenario/prediction_orders.h"
#include "scenario/reference_field.h"

namespace surveymc::studies::corrected_codes {

struct Scenario {
  random::StudySeed seed;
  std::uint64_t trials = 0;  ///< 0: first order alone
  std::string base, claimed, reference_of, correction;
  std::vector<propagate::CodeTerm> terms;
  analysis::CodeCase which;
  survey::ReferenceField field;
  std::optional<disturbance::Disturbance> disturbance;
  std::shared_ptr<const disturbance::StationDisturbance> disturbed;  ///< draws 3 measured station + CodeInput of it
  std::optional<survey::Survey> well;                                ///< none: maps of directions alone
  std::optional<analysis::WellDesign> design;                        ///< of a made-up well
  std::vector<double> inclination_deg, azimuth_deg;                  ///< of the maps; empty: none
  std::vector<double> latitude_deg, longitude_deg;                   ///< of maps over places, of one well; empty: none
  scenario::FieldOfPlaces places;                                    ///< what the places' fields are
  std::vector<analysis::CodeScope> scopes;
  std::vector<analysis::CodeQuantity> quantities;
  scenario::PredictionOrders orders;  ///< of the last position
  double margin = 0.05;               ///< a ratio up to 1 + margin holds
  random::ReferenceLaws laws;
  compare::TailRule tails;
  compare::VerdictRule verdict;
  compare::Annotations annotations;

  bool wants(analysis::CodeScope scope) const;
  bool wants_azimuth() const;
  bool has_map() const { return !inclination_deg.empty() || !latitude_deg.empty(); }
  std::size_t cells() const {
    return inclination_deg.size() * azimuth_deg.size() + latitude_deg.size() * longitude_deg.size();
  }
};

/// Throws InputError.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

}  // namespace surveymc::studies::corrected_codes
