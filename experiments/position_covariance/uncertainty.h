#pragma once
/// How uncertain the well is at the depths that a user asks for: the table that a run prints.
#include <vector>

#include "config/config.h"
#include "propagate/hole_direction.h"
#include "propagate/tool_covariance.h"
#include "store/table.h"
#include "survey/survey.h"

namespace surveymc::studies::position_covariance {

/// What `[report]` asks for.
struct UncertaintyReport {
  std::vector<double> sigmas;   ///< multiples of the standard deviation
  std::vector<double> percent;  ///< what the interval, and what the ellipse, holds of a normal error, in (0, 100)
  std::vector<double> md;       ///< m, rising; the last is that of the last station
};

/// Reads `report.sigmas`, `report.percent` and `report_md_m`; refuses depths beyond the survey.
UncertaintyReport read_uncertainty_report(config::ConfigReader& c, const survey::Survey& survey);

/// Covariance and direction of the hole at a measured depth within the survey. Between stations the covariance is
/// linear in measured depth, and the hole turns along the arc of minimum curvature at a constant rate.
///   C = (1 - f) C0 + f C1,   f = (md - md0) / (md1 - md0)
/// Errors that were linear in measured depth would have f (1 - f) cov(e1 - e0) less: what is reported is not less than
/// that, and is the covariance itself at a station.
struct PlaceInHole {
  Eigen::Matrix3d covariance;  ///< N, E, V (true north), m2
  propagate::HoleDirection direction;
};
PlaceInHole place_at(const survey::Survey& survey, const std::vector<Eigen::Matrix3d>& covariances, double md);

/// Table `uncertainty`: rows north, east, vertical, high_side, lateral, along_hole, semi_major and semi_minor of each
/// depth; columns for one sigma and for what the report asks for.
store::Table uncertainty_table(const survey::Survey& survey, const propagate::ToolCovariances& result,
                               const UncertaintyReport& report);

}  // namespace surveymc::studies::position_covariance
