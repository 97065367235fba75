#include "random/study_id.h"

#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "random/study_stream.h"

using namespace surveymc;
using namespace surveymc::random;

TEST_CASE("A study keeps the number of its random numbers") {
  // Archived results hold draws at these numbers. vertical_well had 4 and msa_benefit drew toolfaces at 3 before every
  // study had a number of its own.
  const std::map<std::uint32_t, std::string> numbers{{1, "msa_position"},
                                                     {2, "msa_benefit"},
                                                     {3, "drift_monitoring"},
                                                     {4, "mwd_drift"},
                                                     {5, "sensor_monte_carlo"},
                                                     {6, "vertical_well"},
                                                     {7, "estimate"},
                                                     {8, "chained_multistation"},
                                                     {9, "axial_correction"},
                                                     {10, "position_covariance"},
                                                     {11, "reliability_map"},
                                                     {12, "reliability_well"},
                                                     {20, "gross_error_detection"},
                                                     {21, "error_model_monte_carlo"},
                                                     {23, "clearance"},
                                                     {50, "corrected_codes"},
                                                     {52, "robustness_map"}};
  std::map<std::uint32_t, std::string> found;
  std::map<std::string, int> times;
  for (std::uint32_t n = 0; n < 65536; ++n)
    if (const std::string name(name_of(StudyId{n})); !name.empty()) {
      found[n] = name;
      ++times[name];
    }
  for (const auto& [name, count] : times) CHECK(count == 1);
  for (const auto& [n, name] : numbers) CHECK(found[n] == name);
}

TEST_CASE("Seed and study address a stream") {
  const StudySeed at{7, StudyId::mwd_drift};
  CHECK(stream_of(at).normal(3, Channel::toolface, 5) == Stream(7, 4).normal(3, Channel::toolface, 5));
  CHECK(stream_of(at).normal(3, Channel::toolface, 5) !=
        stream_of({7, StudyId::vertical_well}).normal(3, Channel::toolface, 5));
}
