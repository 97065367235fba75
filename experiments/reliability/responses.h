#pragma once
/// Maps of the effects of an error of given size (figure 1 of Nyrnes et al.), and of errors in several observations at
/// once, by station_response.h. They take a microsecond a point.
#include <string>
#include <vector>

#include "reliability/layers.h"

namespace surveymc::studies::reliability {

/// "residual_gx_mps2", ..., "residual_dip_deg", "effect_inclination_deg", ..., "effect_dip_deg".
const std::vector<std::string>& response_layers();
/// Those layers that the mode has: an observation that the mode does not have has no residual.
std::vector<std::string> response_layers(AdjustmentMode mode);
bool is_response_layer(const std::string& layer);

/// "redundancy_number", "minimal_detectable_error", "external_inclination_deg", ..., "external_dip_deg"; for the
/// weakest combination also "direction_<observation>" of those combined, "test_dimension" and "test_alpha".
std::vector<std::string> combination_layers(const ErrorSubject& subject);

/// One line for a reader, and the unit, of a layer of a response, or of a combination that the kernel does not have. ""
/// for other layers.
std::string response_meaning(const std::string& layer);
std::string response_unit(const std::string& layer);

/// Responses to the gross error at a point: [subject][layer].
std::vector<std::vector<double>> response_values(const LayerModel& m, const GridPoint& p,
                                                 const std::vector<ErrorSubject>& subjects,
                                                 const std::vector<std::string>& layers);

/// Reliability of a combination at a point, by layer. An external reliability is infinite where the combination is
/// never detected, unless it has no effect on the parameter.
std::vector<double> combination_values(const LayerModel& m, const GridPoint& p, const ErrorSubject& subject,
                                       const std::vector<std::string>& layers);

}  // namespace surveymc::studies::reliability
