#include "reliability/error_subject.h"

#include <cmath>

#include <fmt/format.h>

namespace surveymc::studies::reliability {

std::string subject_name(const ErrorSubject& s) {
  const auto name = [&](std::size_t k) { return observation_names()[s.observations[k]]; };
  if (!s.combined()) return name(0);
  std::string text = s.weakest() ? "weakest of " : "";
  for (std::size_t k = 0; k < s.observations.size(); ++k) {
    if (s.weakest()) {
      text += (k > 0 ? ", " : "") + name(k);
    } else {
      const char* sign = s.direction[k] < 0 ? (k > 0 ? " - " : "-") : (k > 0 ? " + " : "");
      text += fmt::format("{}{:.4g} {}", sign, std::abs(s.direction[k]), name(k));
    }
  }
  return text;
}

std::string subject_unit(const ErrorSubject& s) { return s.combined() ? "1" : observation_unit(s.observations[0]); }

}  // namespace surveymc::studies::reliability
