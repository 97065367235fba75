#pragma once
/// surveymc diff A.h5 B.h5: what differs beyond chance between two results.
#include <string>

namespace surveymc::cli {

struct DiffArguments {
  std::string a, b;
  double level = 0.05, tolerance = 0;
  bool csv = false, json = false;
};

/// Prints the differences; 0 if there are none, 1 if there are. Throws IoError, InputError.
int diff_results(const DiffArguments& arguments);

}  // namespace surveymc::cli
