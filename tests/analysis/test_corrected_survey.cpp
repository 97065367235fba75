/// First order of corrected surveys against an independent program (its figures are in the spec's section 6), against
/// the codes with axial correction, and against differences of the nonlinear chain.
#include "analysis/corrected_survey.h"

#include <map>

#include <catch2/catch.hpp>

#include "analysis/well_design.h"
#include "propagate/code_claim.h"
#include "survey/minimum_curvature.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::analysis;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using test::field_of;
using test::shipped;

namespace {

struct Well {
  std::string name;
  survey::Survey survey;
  survey::ReferenceField field;
};

double even_toolface(std::size_t station) { return std::fmod(137.5 * static_cast<double>(station), 360) * kDegree; }

survey::Survey survey_file(const std::string& path, config::ToolfaceZero zero, std::size_t every = 1,
                           bool turned = false) {
  const survey::Survey all =
      config::survey_from_table(config::parse_csv(test::project_file(path), path), {.toolface_zero = zero}, false);
  survey::Survey s;
  for (std::size_t k = 0; k < all.stations.size(); k += every) {
    s.stations.push_back(all.stations[k]);
    if (turned) s.stations.back().toolface = even_toolface(s.stations.size() - 1);
  }
  return s;
}

survey::Survey built(double inclination_deg, double azimuth_deg, ToolfaceSequence toolface = ToolfaceSequence::even,
                     int stations = 61, WellKind kind = WellKind::building) {
  return make_well({.kind = kind, .stations = stations, .build_rate = 3 * kDegree / 30, .toolface = toolface},
                   inclination_deg * kDegree, azimuth_deg * kDegree);
}

/// The wells whose path the spec gives.
std::vector<Well> published_wells() {
  std::vector<Well> w;
  for (int i = 1; i <= 4; ++i)
    w.push_back({fmt::format("thesis {}", i),
                 survey_file(fmt::format("configs/thesis/traj{}.csv", i), config::ToolfaceZero::x),
                 field_of(51000, 72)});
  w.push_back(
      {"ISCWSA 1", survey_file("configs/iscwsa/well1.csv", config::ToolfaceZero::y, 3, true), field_of(50000, 72, -4)});
  w.push_back(
      {"ISCWSA 2", survey_file("configs/iscwsa/well2.csv", config::ToolfaceZero::y, 1, true), field_of(48000, 58, 2)});
  w.push_back({"horizontal east", built(90, 90), field_of(50500, 73)});
  w.push_back({"horizontal north-east", built(90, 45), field_of(50500, 73)});
  w.push_back({"horizontal north", built(90, 0), field_of(50500, 73)});
  w.push_back({"equator east", built(90, 90), field_of(33000, -5)});
  w.push_back({"equator north", built(90, 0), field_of(33000, -5)});
  w.push_back({"dip 82", built(60, 90), field_of(57000, 82)});
  w.push_back({"slide", built(30, 0, ToolfaceSequence::constant), field_of(50000, 72)});
  Well turn{"turn", {}, field_of(50000, 72)};
  for (std::size_t k = 0; k < 61; ++k)
    turn.survey.stations.push_back(
        {30 * static_cast<double>(k), 60 * kDegree, 3 * kDegree * static_cast<double>(k), even_toolface(k)});
  w.push_back(turn);
  return w;
}

Eigen::RowVector3d across_hole(const survey::Survey& s) {
  return survey::rotation_hla_from_nev(s.stations.back().inclination, s.stations.back().azimuth).row(1);
}

/// A code pair on a well.
struct Case {
  propagate::CodeDraws draws;
  propagate::ClaimedCode claimed;

  Case(const std::string& base, const std::string& twin, const std::string& code)
      : draws(propagate::map_code(*shipped(base), shipped(twin).get()).draws), claimed(*shipped(code)) {}
  double claimed_lateral(const Well& w) const {
    const Eigen::RowVector3d right = across_hole(w.survey);
    return std::sqrt(right * claimed.magnetic(w.survey, w.field).position * right.transpose());
  }
  CorrectedErrors errors(const Well& w, const std::string& kind) const {
    return corrected_errors(measured_stations(w.survey, w.field, claimed.first_leg_doubled()), draws, 0,
                            correction(kind, draws));
  }
  /// sd lateral over the claimed one; NaN where undetermined.
  double rho(const Well& w, const std::string& kind) const {
    const Eigen::RowVector3d right = across_hole(w.survey);
    const CorrectedErrors e = errors(w, kind);
    return e.determined ? std::sqrt(right * e.covariance() * right.transpose()) / claimed_lateral(w) : kNaN;
  }
};

}  // namespace

TEST_CASE("MWD+IFR1+MS on wells whose figures an independent program gives") {
  struct Row {
    double claimed, none, msa, msa3, joint, joint_priors;
  };
  const std::map<std::string, Row> expected{
      {"thesis 1", {21.73, 1.967, 3.411, 2.209, 1.614, 1.123}},
      {"thesis 2", {4.326, 1.652, 3.131, .793, 1.866, .678}},
      {"thesis 3", {4.676, 1.508, 1.396, .773, .840, .693}},
      {"thesis 4", {6.271, 1.325, 1.062, .773, .709, .702}},
      {"ISCWSA 1", {42.12, 1.950, 1.420, .876, .563, .537}},
      {"ISCWSA 2", {3.835, 1.493, .756, .631, .470, .468}},
      {"horizontal east", {3.986, 1.861, 3.516, .783, .864, .629}},
      {"horizontal north-east", {3.288, 1.667, .675, .731, .600, .596}},
      {"horizontal north", {2.386, .785, .785, .785, .785, .785}},
      {"equator east", {2.264, 1.564, 1.082, .797, .806, .716}},
      {"equator north", {1.826, .875, .875, .875, .875, .875}},
      {"dip 82", {3.241, 1.734, 6.800, .706, 3.062, .607}},
      {"slide", {.706, 1.087, kNaN, kNaN, kNaN, 1.087}},
      {"turn", {2.35, .335, .736, .331, .275, .268}},
  };
  const Case c("MWD+IFR1", "MWD+IFR1+AX", "MWD+IFR1+MS");
  for (const Well& w : published_wells()) {
    CAPTURE(w.name);
    const Row& row = expected.at(w.name);
    CHECK_THAT(c.claimed_lateral(w), WithinRel(row.claimed, 2e-3));
    const auto check = [&](const std::string& kind, double value) {
      CAPTURE(kind);
      const double rho = c.rho(w, kind);
      if (std::isnan(value))
        CHECK(std::isnan(rho));
      else
        CHECK_THAT(rho, WithinAbs(value, .002));
    };
    check("none", row.none);
    check("msa", row.msa);
    check("msa3", row.msa3);
    check("joint", row.joint);
    check("joint_priors", row.joint_priors);
  }
}

TEST_CASE("Other codes, noise of the magnetometers, and no interference") {
  const std::vector<Well> all = published_wells();
  const Well &thesis1 = all[0], &iscwsa1 = all[4], &east = all[6];
  const Case hrgm("MWD+HRGM+SAG", "MWD+HRGM+AX+SAG", "MWD+HRGM+SAG+MS");
  CHECK_THAT(hrgm.rho(thesis1, "msa"), WithinAbs(4.33, .006));
  CHECK_THAT(hrgm.rho(thesis1, "msa3"), WithinAbs(2.77, .006));
  CHECK_THAT(hrgm.rho(east, "msa"), WithinAbs(4.30, .006));
  CHECK_THAT(hrgm.rho(iscwsa1, "joint_priors"), WithinAbs(.78, .006));
  const Case ifr2("MWD+IFR2+SAG", "MWD+IFR2+AX+SAG", "MWD+IFR2+SAG+MS");
  CHECK_THAT(ifr2.rho(thesis1, "msa"), WithinAbs(2.85, .006));
  CHECK_THAT(ifr2.rho(iscwsa1, "msa3"), WithinAbs(.83, .006));
  // The independent program leaves out DECS and DBHS, which are in the claim: errors of declination all the same.
  error_model::Model ems_base = *shipped("EMS+IFR1+SAG");
  std::erase_if(ems_base.terms, [](const error_model::Term& e) { return e.code == "DECS" || e.code == "DBHS"; });
  Case ems("EMS+IFR1+SAG", "EMS+IFR1+AX+SAG", "EMS+IFR1+SAG+MS");
  CHECK(ems.rho(iscwsa1, "msa") > 1.3);
  ems.draws = propagate::map_code(ems_base, shipped("EMS+IFR1+AX+SAG").get()).draws;
  CHECK_THAT(ems.rho(iscwsa1, "msa"), WithinAbs(1.23, .006));
  CHECK_THAT(ems.rho(thesis1, "joint"), WithinAbs(.42, .006));

  Case c("MWD+IFR1", "MWD+IFR1+AX", "MWD+IFR1+MS");
  const auto with_noise = [&](const Well& w, const std::string& kind, double noise) {
    const Eigen::RowVector3d right = across_hole(w.survey);
    const CorrectedErrors e =
        corrected_errors(measured_stations(w.survey, w.field, true), c.draws, noise, correction(kind, c.draws));
    return std::sqrt(right * e.covariance() * right.transpose()) / c.claimed_lateral(w);
  };
  CHECK_THAT(with_noise(iscwsa1, "msa", 30), WithinAbs(1.427, .002));
  CHECK_THAT(with_noise(iscwsa1, "msa", 70), WithinAbs(1.456, .002));
  CHECK_THAT(with_noise(thesis1, "joint_priors", 30), WithinAbs(1.18, .006));
  CHECK_THAT(with_noise(thesis1, "joint_priors", 70), WithinAbs(1.41, .006));

  // What breaks it: the dip of the reference; of the uncorrected survey, the interference.
  const auto share = [&](const Well& w, const std::string& kind, std::size_t input) {
    const Eigen::RowVector3d right = across_hole(w.survey);
    const CorrectedErrors e = c.errors(w, kind);
    return double(right * e.position[input] * right.transpose()) / double(right * e.covariance() * right.transpose());
  };
  CHECK_THAT(share(thesis1, "msa", kDip), WithinAbs(.96, .006));
  CHECK_THAT(share(iscwsa1, "msa", kDip), WithinAbs(.85, .006));
  CHECK_THAT(share(thesis1, "none", kInterference), WithinAbs(.85, .006));

  c.draws.interference = 0;
  for (const Well* w : {&thesis1, &iscwsa1, &east}) {
    CHECK(c.rho(*w, "none") < .87);
    CHECK(c.rho(*w, "msa") > 1.05);
  }
}

TEST_CASE("Three biases in a straight hole are the code with axial correction, but for its cross-axis terms") {
  // Both see the axial bias through the same condition: its own terms of z, of the reference, and cross-axis scale.
  error_model::Model axial = *shipped("MWD+IFR1+AX");
  const std::vector<std::string> kept{"ABIZ", "ASIZ", "ASIXY-TI1S", "MSIXY-TI1S"};
  std::erase_if(axial.terms, [&](const error_model::Term& t) {
    const std::string& f = t.function->name;
    const bool is_reference = f == "MDI" || f == "MFI" || f == "AZ" || f == "DBH";
    return !is_reference && std::find(kept.begin(), kept.end(), t.code) == kept.end();
  });
  const propagate::ClaimedCode claimed(axial);
  const Case c("MWD+IFR1", "MWD+IFR1+AX", "MWD+IFR1+MS");
  struct Direction {
    double inclination, azimuth, lateral;  // deg; m, of the independent program
  };
  for (const Direction& d :
       {Direction{20, 30, 2.032}, Direction{60, 90, 14.457}, Direction{90, 60, 17.931}, Direction{85, 85, 73.12}}) {
    CAPTURE(d.inclination, d.azimuth);
    const Well w{"", built(d.inclination, d.azimuth, ToolfaceSequence::even, 61, WellKind::straight),
                 field_of(50000, 72)};
    const Eigen::RowVector3d right = across_hole(w.survey);
    const double code = std::sqrt(right * claimed.magnetic(w.survey, w.field).position * right.transpose());
    const double three = std::sqrt(right * c.errors(w, "msa3").covariance() * right.transpose());
    CHECK_THAT(three, WithinRel(d.lateral, 1e-3));
    CHECK_THAT(three, WithinRel(code, .006));
  }
}

TEST_CASE("A correction that the stations do not determine has no covariance") {
  const Case c("MWD+IFR1", "MWD+IFR1+AX", "MWD+IFR1+MS");
  const Well straight{"", built(60, 45, ToolfaceSequence::even, 31, WellKind::straight), field_of(50000, 72)};
  CHECK_FALSE(c.errors(straight, "msa").determined);
  CHECK(c.errors(straight, "msa3").determined);
  CHECK(c.errors(straight, "msa3").condition < 1e4);
  CHECK(c.errors(straight, "joint_priors").determined);
  CHECK(std::isnan(c.errors(straight, "msa").covariance()(0, 0)));
  CHECK_THROWS_AS(correction("msa4", c.draws), InputError);
}

TEST_CASE("Six parameters of the table, without priors and of equal weight, are those of msa") {
  const Case c("MWD+IFR1", "MWD+IFR1+AX", "MWD+IFR1+MS");
  for (const Well& w : published_wells()) {
    CAPTURE(w.name);
    const MeasuredStations stations = measured_stations(w.survey, w.field, true);
    Correction six{.kind = Correction::Kind::parameters};
    six.parameters.prior_sd.fill(kInfinity);
    const CorrectedErrors by_table = corrected_errors(stations, c.draws, 20, six),
                          by_msa = corrected_errors(stations, c.draws, 20, correction("msa", c.draws));
    REQUIRE(by_table.determined == by_msa.determined);
    if (!by_msa.determined) continue;
    for (std::size_t i = 0; i < kCodeInputs; ++i) {
      CAPTURE(kCodeInputNames[i]);
      CHECK((by_table.position[i] - by_msa.position[i]).norm() < 1e-5 * by_msa.position[i].norm() + 1e-9);
      CHECK_THAT(by_table.azimuth.back()[i], WithinRel(by_msa.azimuth.back()[i], 1e-5) || WithinAbs(0, 1e-14));
    }
  }
}

TEST_CASE("Priors so narrow that nothing is estimated leave the uncorrected survey") {
  const Case c("MWD+IFR1", "MWD+IFR1+AX", "MWD+IFR1+MS");
  const Well w = published_wells().front();
  const MeasuredStations stations = measured_stations(w.survey, w.field, true);
  Correction all{.kind = Correction::Kind::parameters};
  all.parameters.parameters = multistation::ParameterSet::named("21");
  for (double& sd : all.parameters.prior_sd) sd *= 1e-6;
  const Eigen::Matrix3d left = corrected_errors(stations, c.draws, 20, all).covariance(),
                        raw = corrected_errors(stations, c.draws, 20, {}).covariance();
  CHECK(left.isApprox(raw, 1e-6));
}

TEST_CASE("The worst direction is where the ratio of the standard deviations is largest") {
  Eigen::Matrix2d actual, claimed;
  actual << 4, 1, 1, 2;
  claimed << 1, -.3, -.3, 2;
  const double worst = worst_ratio(actual, claimed);
  double most = 0;
  for (int i = 0; i < 3600; ++i) {
    const Eigen::Vector2d u(std::cos(i * kPi / 3600), std::sin(i * kPi / 3600));
    most = std::max(most, std::sqrt(double(u.transpose() * actual * u) / double(u.transpose() * claimed * u)));
  }
  CHECK_THAT(worst, WithinRel(most, 1e-5));
  const Eigen::Vector2d u = worst_direction(actual, claimed);
  CHECK_THAT(std::sqrt(double(u.transpose() * actual * u) / double(u.transpose() * claimed * u)),
             WithinRel(worst, 1e-12));
  CHECK(std::isnan(worst_ratio(actual, Eigen::Matrix2d::Zero())));
}

TEST_CASE("Errors of the stations that do not change along the run are those of the run") {
  const Well w{"north-east", built(80, 45), field_of(50500, 73)};
  Case c("MWD+IFR1", "MWD+IFR1+AX", "MWD+IFR1+MS");
  c.draws = {};
  c.draws.run.total = c.draws.station.total = 60;
  c.draws.run.dip = c.draws.station.dip = 0.08 * kDegree;
  c.draws.run.declination = c.draws.station.declination = 0.17 * kDegree;
  const auto errors = [&](const std::string& kind, const StationCorrelation& rho) {
    return corrected_errors(measured_stations(w.survey, w.field, true), c.draws, 0, correction(kind, c.draws), rho);
  };
  for (const char* kind : {"none", "msa", "msa3", "axial"}) {
    CAPTURE(kind);
    const CorrectedErrors lasting = errors(kind, [](int a, std::size_t, int b, std::size_t) { return a == b; }),
                          independent =
                              errors(kind, [](int a, std::size_t j, int b, std::size_t k) { return a == b && j == k; }),
                          plain = errors(kind, {});
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t run = kTotalField + i, station = kStationTotalField + i;
      // Effects of one input may cancel: rounding is that of all.
      const double size = lasting.covariance().trace();
      CHECK((lasting.position[station] - lasting.position[run]).norm() < 1e-9 * size);
      CHECK((independent.position[station] - plain.position[station]).norm() < 1e-12 * size);
      for (std::size_t k = 0; k < lasting.azimuth.size(); ++k) {
        CHECK_THAT(lasting.azimuth[k][station], WithinAbs(lasting.azimuth[k][run], 1e-9 * lasting.azimuth_variance(k)));
        CHECK_THAT(independent.azimuth[k][station],
                   WithinAbs(plain.azimuth[k][station], 1e-12 * plain.azimuth_variance(k)));
      }
    }
  }
}

TEST_CASE("What two inputs of the stations have in common is counted once, half to each") {
  // dip = rho declination + ...: the variance of a sum, by the inputs one at a time and together.
  const Well w{"north-east", built(80, 45), field_of(50500, 73)};
  Case c("MWD+IFR1", "MWD+IFR1+AX", "MWD+IFR1+MS");
  const auto total = [&](double sign) {
    c.draws = {};
    c.draws.station.total = 60;
    c.draws.station.dip = 0.08 * kDegree;
    c.draws.station.declination = 0.17 * kDegree;
    return corrected_errors(measured_stations(w.survey, w.field, true), c.draws, 0, correction("msa", c.draws),
                            [sign](int a, std::size_t j, int b, std::size_t k) {
                              const double memory = std::exp(-0.1 * std::abs(double(j) - double(k)));
                              return (a == b ? 1 : 0.4 * sign) * memory;
                            });
  };
  const CorrectedErrors plus = total(1), none = total(0), minus = total(-1);
  const double common = (plus.covariance() - none.covariance()).norm();
  CHECK(common > 0.05 * none.covariance().norm());
  // Linear in the correlation.
  CHECK((plus.covariance() + minus.covariance() - 2 * none.covariance()).norm() < 1e-9 * common);
  for (std::size_t k : {std::size_t{45}, std::size_t{59}}) {
    const double change = plus.azimuth_variance(k) - none.azimuth_variance(k);
    CHECK(std::abs(change) > 1e-3 * none.azimuth_variance(k));
    CHECK_THAT(none.azimuth_variance(k) - minus.azimuth_variance(k), WithinRel(change, 1e-6));
  }
}
