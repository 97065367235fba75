#pragma once
/// Shipped tool models, reference fields and surveys, as tests of propagation and of pairs of wells use them.
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "config/error_model_file.h"
#include "config/survey_csv.h"
#include "survey/reference_field.h"
#include "thesis_cases.h"

namespace surveymc::test {

inline config::SharedModel shipped(const std::string& name) {
  const config::ShippedModel* m = config::find_shipped_model(name);
  if (!m) throw std::logic_error("no such model: " + name);  // benchmarks use it too, and have no REQUIRE
  return config::load_shipped_model(*m);
}

/// nT, degrees.
inline survey::ReferenceField field_of(double total, double dip, double declination = 0) {
  return {.total = total, .dip = dip * kDegree, .declination = declination * kDegree};
}

/// m, degrees: measured depth, inclination, azimuth.
inline survey::Survey survey_of(const std::vector<std::array<double, 3>>& stations) {
  survey::Survey s;
  for (const auto& [md, inclination, azimuth] : stations)
    s.stations.push_back({md, inclination * kDegree, azimuth * kDegree, 0});
  return s;
}

/// A survey of so many stations: `station_at` makes each from its number.
template <class StationAt>
survey::Survey survey_of(int stations, const StationAt& station_at) {
  survey::Survey s;
  for (int k = 0; k < stations; ++k) s.stations.push_back(station_at(k));
  return s;
}

/// An example well of ISCWSA with the depths of its table, where it is, and the field there.
struct IscwsaWell {
  survey::Survey survey;
  std::vector<double> tvd;
  survey::ReferenceField field;
  double latitude = 0;
};
/// number: 1 or 2.
inline IscwsaWell iscwsa_well(int number) {
  const std::string path = fmt::format("configs/iscwsa/well{}.csv", number);
  const config::InputTable table = config::parse_csv(project_file(path), path);
  const bool is_first = number == 1;
  return {config::survey_from_table(table, {}, false), config::tvd_from_table(table),
          is_first ? field_of(50000, 72, -4) : field_of(48000, 58, 2), (is_first ? 60 : 28) * kDegree};
}

/// Largest difference of covariances, relative to their trace.
inline double largest_difference(const std::vector<Eigen::Matrix3d>& a, const std::vector<Eigen::Matrix3d>& b) {
  double worst = 0;
  for (std::size_t k = 1; k < a.size(); ++k)
    worst = std::max(worst, (a[k] - b[k]).cwiseAbs().maxCoeff() / std::max(1e-300, b[k].trace()));
  return worst;
}

}  // namespace surveymc::test
