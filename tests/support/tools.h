#pragma once
/// Shipped tool models and reference fields, as tests of propagation and of pairs of wells use them.
#include <string>

#include "base/units.h"
#include "config/error_model_file.h"
#include "survey/reference_field.h"

namespace surveymc::test {

inline config::SharedModel shipped(const std::string& name) {
  return config::load_shipped_model(*config::find_shipped_model(name));
}

/// nT, degrees.
inline survey::ReferenceField field_of(double total, double dip, double declination = 0) {
  survey::ReferenceField f;
  f.total = total;
  f.dip = dip * kDegree;
  f.declination = declination * kDegree;
  return f;
}

}  // namespace surveymc::test
