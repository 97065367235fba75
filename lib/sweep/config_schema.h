#pragma once
/// JSON Schema of the configs of an experiment, for editors: the keys of config_keys() in another form.
#include <string>

#include "study/experiment.h"

namespace surveymc::sweep {

/// A JSON Schema (draft 2020-12) of the experiment's configs: types, ranges, words, defaults and meanings of its keys,
/// lists of any of them in [sweep], and cases. It refuses a key that no reader of the experiment asks for, a value of
/// another type, and a number or word that is never right. What depends on other keys or on data (the number of
/// stations, the name of a well) it lets pass: `surveymc check` has the last word.
/// Dates are strings, as readers of TOML hand them on.
std::string config_schema(const study::Experiment& experiment);

}  // namespace surveymc::sweep
