#pragma once
/// Tables of the study position_covariance (docs/results-format.md).
#include <string>
#include <vector>

#include "propagate/iscwsa_covariance.h"
#include "store/table.h"
#include "study/error_models.h"

namespace surveymc::studies::position_covariance {

/// A published element of a covariance beside our own, m2.
struct PublishedElement {
  double md;             ///< m
  std::string source;    ///< code of the error source, or "total"
  std::string quantity;  ///< nn_m2 ...
  double own, published;
  double trace;  ///< of our own covariance: what differences are measured against
  std::string origin;
};

/// One row a station: covariance in NEV and HLA, standard deviations, horizontal ellipse.
store::Table covariance_table(const survey::Survey& survey, const propagate::PositionCovariances& result);
/// One row a station: where it is, and the ellipsoid of its covariance.
store::Table ellipsoid_table(const survey::Survey& survey, const std::vector<double>& tvd,
                             const propagate::PositionCovariances& result);
/// One row a station and source.
store::Table covariance_by_source_table(const survey::Survey& survey, const propagate::PositionCovariances& result);
/// One row a leg and term: the models as they were used.
store::Table error_terms_table(const study::ToolRuns& legs);
/// One row an element; verdict "agrees" where the difference is within `margin` of the trace.
store::Table published_table(const std::vector<PublishedElement>& elements, double margin);

}  // namespace surveymc::studies::position_covariance
