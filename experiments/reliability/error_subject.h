#pragma once
/// The observation, or several observations at once, that have the gross error of a reliability map.
#include <string>
#include <vector>

#include "reliability/observations.h"

namespace surveymc::studies::reliability {

/// The study is of that module alone.
using namespace surveymc::reliability;

/// Lengths of combinations are in standard deviations of their observations.
struct ErrorSubject {
  std::vector<std::size_t> observations;  ///< one; or those that are combined
  std::vector<double> direction;          ///< of a given combination: unit vector; empty for the weakest one

  bool combined() const { return observations.size() > 1; }
  bool weakest() const { return combined() && direction.empty(); }
};

/// "bx"; "0.8 bx - 0.6 bz"; "weakest of bx, bz".
std::string subject_name(const ErrorSubject& subject);
/// Unit of the error: "mps2", "nT" or "deg"; "1" for a combination (standard deviations).
std::string subject_unit(const ErrorSubject& subject);

}  // namespace surveymc::studies::reliability
