#pragma once
/// `[reference_law]`: laws of the errors of the reference field.
#include "config/config.h"
#include "random/reference_laws.h"
#include "scenario/error_models.h"

namespace surveymc::scenario {

/// What a study draws of the reference, and how the laws may go with it.
struct ReferenceDraws {
  bool declination = true;  ///< else total field and dip alone
  bool modes = true;        ///< errors of several modes, G, W and R: `reference_law.modes` chooses
  bool sizes = true;        ///< else the sizes of the models are sds
  bool terms = true;        ///< several terms of one element, which may share a V
};

/// `[reference_law] declination, dip, total = { law, size, degrees | shape | share, ratio | shape, skew }`, and, as
/// `draws` has it, `modes`, `shared_mixing`, `each_term`. Without an element its errors are normal. Notes the standard
/// deviation that follows from the size.
random::ReferenceLaws read_reference_laws(config::ConfigReader& config, const ReferenceDraws& draws);

/// Warns of elements whose law changes nothing: no tool has a term of them in the modes that have the laws.
/// `with_random`: errors of mode R can have them in this study.
void warn_of_idle_laws(config::ConfigReader& config, const random::ReferenceLaws& laws,
                       const std::vector<const ToolRuns*>& tools, bool with_random = true);

}  // namespace surveymc::scenario
