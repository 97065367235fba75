#pragma once
/// Parts of the study `mwd_drift` (see study.cpp). SI: m/s2, nT, rad.
#include <array>
#include <string>
#include <vector>

#include "analysis/drift_run.h"
#include "compare/annotations.h"
#include "compare/comparison.h"
#include "scenario/scenario.h"

namespace surveymc::studies::mwd_drift {

inline constexpr std::array<const char*, 6> kSensors{"gx", "gy", "gz", "bx", "by", "bz"};

struct Scenario : analysis::DriftRunSetup {
  std::uint64_t trials = 0;
  double spacing = 30;  ///< m
  compare::VerdictRule verdict;
  compare::Annotations annotations;
  int sensor = -1;  ///< the drifting sensor

  /// A sweep may hold a drift of zero.
  bool drifts() const { return drift_at_td[sensor] != 0; }
};

/// Throws InputError.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

using Outcome = analysis::DriftResult;

/// The rows of all trials as they stand in a tally.
class Outcomes {
 public:
  explicit Outcomes(const std::vector<double>& rows) : rows_(rows) {}
  std::size_t trials() const { return rows_.size() / Outcome::kValues; }
  double operator()(std::size_t trial, Outcome::Value v) const { return rows_[trial * Outcome::kValues + v]; }

 private:
  const std::vector<double>& rows_;
};

std::vector<compare::ComparisonRow> comparison_rows(const Scenario& s, const Outcomes& o);
std::vector<compare::ComparisonRow> claim_rows(const Scenario& s, const Outcomes& o);
store::Table detection_table(const Scenario& s, const Outcomes& o);
/// Share of wells with an alarm up to each station.
store::Table alarm_curve_table(const Scenario& s, const Outcomes& o);
store::Table series_table(const Scenario& s);

}  // namespace surveymc::studies::mwd_drift
