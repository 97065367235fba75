/// What tool codes say of the tool and of its reference, and what they claim.
#include "propagate/code_draws.h"

#include <catch2/catch.hpp>

#include "base/error.h"
#include "message_of.h"
#include "propagate/code_claim.h"
#include "propagate/tool_covariance.h"
#include "survey/minimum_curvature.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::propagate;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using test::shipped;

namespace {

CodeDraws draws_of(const std::string& base, const std::string& twin) {
  return map_code(*shipped(base), shipped(twin).get()).draws;
}

/// The model with one term changed.
template <class Change>
error_model::Model changed(const std::string& name, const std::string& code, Change change) {
  error_model::Model m = *shipped(name);
  for (error_model::Term& t : m.terms)
    if (t.code == code) change(t);
  return m;
}

}  // namespace

TEST_CASE("Sizes of the draws are read from the code and from its twin with axial correction") {
  struct Expected {
    std::string base, twin;
    double total, dip_deg, station_total, station_dip_deg, station_declination_deg, station_east_deg_nT;
  };
  // corrected-codes, section 2: by an independent program from the same files.
  for (const Expected& e : {Expected{"MWD+SRGM", "MWD+SRGM+AX", 130.24, .2017, 60, .08, .1, 3000},
                            Expected{"MWD+HRGM", "MWD+HRGM+AX", 106.5, .161, 60, .08, .1, 3000},
                            Expected{"MWD+IFR1", "MWD+IFR1+AX", 49.98, .09695, 60, .08, .1, 3000},
                            Expected{"MWD+IFR2+SAG", "MWD+IFR2+AX+SAG", 44.6, .081, 15, .02, .05, 750},
                            Expected{"EMS+IFR1+SAG", "EMS+IFR1+AX+SAG", 49.98, .09695, 0, 0, 0, 0}}) {
    CAPTURE(e.base);
    const CodeDraws d = draws_of(e.base, e.twin);
    CHECK_THAT(d.run.total, WithinAbs(e.total, .05));
    CHECK_THAT(d.run.dip / kDegree, WithinAbs(e.dip_deg, 5e-4));
    CHECK_THAT(d.station.total, WithinAbs(e.station_total, 1e-9));
    CHECK_THAT(d.station.dip / kDegree, WithinAbs(e.station_dip_deg, 1e-9));
    CHECK_THAT(d.station.declination / kDegree, WithinAbs(e.station_declination_deg, 1e-9));
    CHECK_THAT(d.station.east / kDegree, WithinAbs(e.station_east_deg_nT, 1e-6));
    CHECK_THAT(d.axial_bias(), WithinAbs(std::hypot(70, 220), 1e-9));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK(d.sensors[survey::kAccelerometerBias + axis] == .004);
      CHECK(d.sensors[survey::kAccelerometerScale + axis] == .0005);
      CHECK(d.sensors[survey::kMagnetometerBias + axis] == 70);
      CHECK(d.sensors[survey::kMagnetometerScale + axis] == .0016);
    }
  }
  const CodeDraws d = draws_of("MWD+IFR1", "MWD+IFR1+AX"), half = d.scaled(.5);
  CHECK(half.sensors[survey::kMagnetometerBias] == 35);
  CHECK(half.station.dip == d.station.dip / 2);
  CHECK_THAT(d.run.declination_in(test::field_of(50000, 72)) / kDegree,
             WithinAbs(std::hypot(std::sqrt(.11 * .11 + .09 * .09 + .05 * .05),
                                  std::sqrt(1271. * 1271 + 712. * 712 + 356. * 356) / (50000 * std::cos(72 * kDegree))),
                       1e-12));
}

TEST_CASE("Every term of a code is drawn or carried, and what is neither is refused by name") {
  const MappedCode m = map_code(*shipped("MWD+IFR1"), shipped("MWD+IFR1+AX").get());
  std::string carried;
  for (const CodeTerm& t : m.terms)
    if (t.carried) carried += t.code + " ";
  CHECK(carried == "DRFR DSFS DSTG SAGE XYM1 XYM2 XYM3E XYM4E XCLA XCLH ");
  CHECK(m.terms.size() == shipped("MWD+IFR1")->terms.size() + 8);  // with MFI, MDI of the twin

  const auto message = [](const error_model::Model& base) { return message_of([&] { map_code(base, nullptr); }); };
  CHECK_THAT(message(*shipped("MWD+IFR1+AX")), Contains("ABIXY-TI1S") && Contains("without axial correction"));
  CHECK_THAT(message(*shipped("GYRO-NS")), Contains("term"));
  CHECK_THAT(message(changed("MWD+IFR1", "MSXY-TI2S", [](auto& t) { t.sigma = .0015; })),
             Contains("MSXY-TI1 and MSXY-TI2 differ"));
  CHECK_THAT(message(changed("MWD+IFR1", "MBZ", [](auto& t) { t.mode = error_model::PropagationMode::random; })),
             Contains("MBZ") && Contains("mode R"));
  CHECK_THROWS_AS(ClaimedCode(*shipped("GYRO-NS")), InputError);
}

TEST_CASE("The twin with axial correction has the same parts, in any order") {
  std::vector<std::string> names;
  for (const config::ShippedModel& m : config::shipped_models()) names.push_back(m.name);
  CHECK(axial_twin("MWD+IFR1", names) == "MWD+IFR1+AX");
  CHECK(axial_twin("MWD+IFR2+SAG", names) == "MWD+IFR2+AX+SAG");
  CHECK(axial_twin("MWD+SRGM+SAG_Fl", names) == "MWD+SRGM+AX+SAG_Fl");
  CHECK(axial_twin("GYRO-NS", names).empty());
}

TEST_CASE("What a code claims is the sum of its magnetic and of its carried terms") {
  const test::IscwsaWell well = test::iscwsa_well(1);
  for (const std::string name : {"MWD+IFR1+MS", "MWD+SRGM+AX", "MWD+HRGM+SAG+MS"}) {
    CAPTURE(name);
    const ClaimedCode code(*shipped(name));
    const std::vector<double> tvd = survey::true_vertical_depths(well.survey);
    const Eigen::Matrix3d whole =
        tool_covariances(well.survey, tvd, {{1, shipped(name)}}, well.field, kNaN, SourceDetail::none).total.back();
    const ClaimedErrors magnetic = code.magnetic(well.survey, well.field),
                        carried = code.carried(well.survey, well.field);
    CHECK((magnetic.position + carried.position - whole).cwiseAbs().maxCoeff() <= 1e-9 * whole.trace());
    CHECK(carried.position.trace() > 0);
    // A code's azimuth: of declination alone at first, sinI times the square sum of its terms.
    const std::size_t last = well.survey.stations.size() - 1;
    CHECK(magnetic.azimuth[last] > 0);
    CHECK(magnetic.azimuth[0] == 0);
    // In a straight hole that of every station, the first measured one among them, whose leg counts twice.
    const survey::Survey straight = test::survey_of(5, [](int k) {
      return survey::Station{30. * k, 60 * kDegree, 75 * kDegree, 0};
    });
    const ClaimedErrors alike = code.magnetic(straight, well.field);
    for (std::size_t k = 1; k < 5; ++k) CHECK_THAT(alike.azimuth[k] / alike.azimuth[4], WithinAbs(1, 1e-12));
  }
}

TEST_CASE("A code claims the same azimuth at every station of a straight hole") {
  const survey::Survey straight = test::survey_of(4, [](int k) {
    return survey::Station{30. * k, 60 * kDegree, 50 * kDegree, 0};
  });
  for (const std::string name : {"MWD+IFR1+MS", "MWD+SRGM+AX"}) {
    const std::vector<double> azimuth =
        ClaimedCode(*shipped(name)).magnetic(straight, test::field_of(50000, 72, 0)).azimuth;
    // The codes count the first leg twice for the position; the direction of its station is measured once.
    for (const std::size_t k : {1u, 2u}) CHECK_THAT(azimuth[k], Catch::Matchers::WithinRel(azimuth[3], 1e-12));
  }
}
