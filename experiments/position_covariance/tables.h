#pragma once
/// Tables of the study position_covariance (docs/results-format.md).
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "scenario/error_models.h"
#include "store/table.h"

namespace surveymc::studies::position_covariance {

/// A published element of a covariance beside our own, m2.
struct PublishedElement {
  double md;             ///< m
  std::string source;    ///< code of the error source, or "total"
  std::string quantity;  ///< nn_m2 ...
  double own, published;
  double trace;  ///< of our own covariance, the unit of differences
  std::string origin;
};

/// One row a station: covariance in NEV and HLA, standard deviations, horizontal ellipse.
/// Here and below: at_station is called with the number of every station that is done.
store::Table covariance_table(const survey::Survey& survey, const propagate::ToolCovariances& result,
                              const std::function<void(std::size_t)>& at_station);
/// One row a station: where it is, and the ellipsoid of its covariance.
store::Table ellipsoid_table(const survey::Survey& survey, const std::vector<double>& tvd,
                             const std::vector<Eigen::Matrix3d>& covariances,
                             const std::function<void(std::size_t)>& at_station);
/// One row a station and source; of the last station alone for SourceDetail::last. Takes `by_source` out of the result.
store::Table covariance_by_source_table(const survey::Survey& survey, propagate::ToolCovariances& result,
                                        propagate::SourceDetail detail);
/// One row a leg: its model and where that holds.
store::Table tool_codes_table(const scenario::ToolRuns& tools);
/// One row a leg and term: the models as they were used.
store::Table error_terms_table(const scenario::ToolRuns& tools);
/// One row a leg and stretch of a hybrid gyro.
store::Table gyro_table(const survey::Survey& survey, const scenario::ToolRuns& tools,
                        const propagate::ToolCovariances& result);
/// One row an element; verdict "agrees" where the difference is within `margin` of the trace.
store::Table published_table(const std::vector<PublishedElement>& elements, double margin);

}  // namespace surveymc::studies::position_covariance
