#pragma once
/// Everything that is wrong with a config, told at once.
#include <string>
#include <vector>

#include "study/experiment.h"

namespace surveymc::study {

/// Reads the config again, which read_run() has refused with `first`, and collects: unknown keys first, then what
/// getters refuse, at the points of a sweep that are tried. The messages, each once; `first` alone where nothing more
/// is found. `known` gives the keys of the experiment (sweep/config_keys.h).
std::vector<std::string> all_mistakes(const Experiment& experiment, config::Config config,
                                      const config::KnownKeys& known, const std::string& first);

}  // namespace surveymc::study
