#pragma once
/// Config of the study clearance as checked values (docs/keys.md has the keys).
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "config/config.h"
#include "propagate/well_errors.h"
#include "proximity/pair_scan.h"
#include "random/reference_laws.h"
#include "random/study_id.h"
#include "scenario/well_pairs.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::studies::clearance {

using Well = scenario::SurveyedWell;
using Formulation = scenario::PairFormulation;
using Reference = scenario::PairReference;
using Pair = scenario::WellPair;  ///< ready to be compared in every formulation

/// An entry of `[[published]]`.
struct Published {
  std::string source, offset, formulation;
  proximity::ScanDirection direction = proximity::ScanDirection::reference;
  double md = 0;         ///< of the scanned well, m
  double tolerance = 0;  ///< in the units of the values
  std::vector<std::pair<std::string, double>> values;
};

/// Monte Carlo of pairs of wells.
struct Drawing {
  std::uint64_t trials = 0, save_samples = 0;
  propagate::VerticalRule vertical = propagate::VerticalRule::tilt;
  std::string formulation;  ///< whose draws the wells share; empty: every formulation is held against its own
  compare::VerdictRule verdict;
  compare::Annotations annotations;
};

struct Scenario : scenario::WellPairs {
  random::StudySeed seed;
  std::vector<proximity::ScanDirection> directions;
  double step = 0, keep = 1;
  bool with_rows = true;          ///< tables clearance and paths
  std::vector<double> report_md;  ///< of the reference, m
  std::vector<Published> published;
  Drawing drawing;
  random::ReferenceLaws laws;
};

Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

/// Rows of the table relative_position.
inline constexpr std::array<const char*, 5> kRelativeQuantities{"sd_relative", "sd_axis_1", "sd_axis_2", "sd_axis_3",
                                                                "nees"};

/// Columns of the table clearance that `[[published]]` may name.
const std::vector<std::string>& published_quantities();

}  // namespace surveymc::studies::clearance
