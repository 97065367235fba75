#include <map>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "config/error_model_file.h"
#include "proximity/pair_errors.h"
#include "survey/minimum_curvature.h"
#include "wells.h"

using namespace surveymc;
using namespace surveymc::proximity;
using namespace surveymc::test;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using error_model::PropagationMode;
using propagate::StationEffects;

namespace {

StationEffects effects_of(const survey::Survey& s, const std::vector<propagate::ToolRun>& runs) {
  StationEffects e;
  propagate::tool_covariances(s, survey::true_vertical_depths(s), runs, field(), 60 * kDegree,
                              propagate::SourceDetail::none, &e);
  return e;
}
PositionErrors errors_of(const survey::Survey& s, const std::vector<propagate::ToolRun>& runs, Interpolation how) {
  return position_errors(s, survey::true_vertical_depths(s), runs, field(), 60 * kDegree, how);
}

/// The error of a station, draw by draw: one column each, named by code, mode and draw.
using Draws = std::map<std::string, Vector3d>;
Draws draws_at(const StationEffects& e, std::size_t station) {
  Draws out;
  for (std::size_t s = 0; s < e.sources.size(); ++s)
    for (std::size_t k = 0; k <= station; ++k) {
      const std::size_t at = s * e.stations + k;
      if (e.draw[at] == StationEffects::kNone) continue;
      const std::string name =
          e.sources[s].code + error_model::mode_letter(e.sources[s].mode) + std::to_string(e.draw[at]);
      out.try_emplace(name, Vector3d::Zero()).first->second += k == station ? e.star[at] : e.full[at];
    }
  return out;
}
Matrix3d product(const Draws& a, const Draws& b) {
  Matrix3d c = Matrix3d::Zero();
  for (const auto& [name, x] : a)
    if (const auto y = b.find(name); y != b.end()) c += x * y->second.transpose();
  return c;
}
Draws between(const Draws& a, const Draws& b, double f) {
  Draws out;
  for (const auto& [name, x] : a) out.try_emplace(name, Vector3d::Zero()).first->second += (1 - f) * x;
  for (const auto& [name, x] : b) out.try_emplace(name, Vector3d::Zero()).first->second += f * x;
  return out;
}

bool is_close(const Matrix3d& a, const Matrix3d& b) { return (a - b).norm() <= 1e-11 * (a.norm() + b.norm()); }

}  // namespace

TEST_CASE("Effects of the draws add up to the covariance of the well, whatever its tools") {
  const survey::Survey s = well(40, 30, 4);
  const auto mwd = shipped("iscwsa_mwd_rev5.10"), gyro = shipped("GYRO-NS-CT"), ifr = shipped("MWD+IFR1");
  for (const std::vector<propagate::ToolRun>& runs : {std::vector<propagate::ToolRun>{{1, mwd}},
                                                      {{1, mwd}, {17, ifr}, {30, mwd}},
                                                      {{1, gyro}},
                                                      {{1, ifr}, {9, gyro}}}) {
    const StationEffects e = effects_of(s, runs);
    const auto total = propagate::tool_covariances(s, survey::true_vertical_depths(s), runs, field(), 60 * kDegree,
                                                   propagate::SourceDetail::none)
                           .total;
    PositionErrors w;
    sum_effects(e, 0, w);
    for (std::size_t k = 0; k < e.stations; ++k) {
      const Draws own = draws_at(e, k);
      CAPTURE(runs.size(), k);
      CHECK(is_close(total[k], product(own, own)));
      CHECK(is_close(w.covariance[k], total[k]));
      if (k > 0) CHECK(is_close(w.step[k - 1], product(draws_at(e, k - 1), own)));
    }
  }
}

TEST_CASE("Between stations, effects are those of a path whose errors are linear in depth") {
  const survey::Survey s = well(30, 200, 3);
  const std::vector<propagate::ToolRun> runs{{1, shipped("iscwsa_mwd_rev5.10")}};
  const StationEffects e = effects_of(s, runs);
  const PositionErrors effects = errors_of(s, runs, Interpolation::effects),
                       linear = errors_of(s, runs, Interpolation::covariance);
  for (const std::size_t leg : {0u, 5u, 14u, 28u})
    for (const double f : {0.0, 0.2, 0.5, 1.0}) {
      const Draws at = between(draws_at(e, leg), draws_at(e, leg + 1), f);
      CAPTURE(leg, f);
      CHECK(is_close(effects.covariance_at(leg, f), product(at, at)));
      CHECK(is_close(linear.covariance_at(leg, f), (1 - f) * linear.covariance[leg] + f * linear.covariance[leg + 1]));
      // Linear covariances are never smaller: f (1 - f) (eps_k - eps_k+1)(..)' lies between.
      const Matrix3d more = linear.covariance_at(leg, f) - effects.covariance_at(leg, f);
      CHECK(more.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() > -1e-9);
      for (std::size_t i = 0; i < effects.sources.size(); ++i)
        CHECK((linear.summed_at(i, leg, f) - effects.summed_at(i, leg, f)).norm() < 1e-12);
    }
}

TEST_CASE("Two wells share what the formulation says, and the relative covariance is that of the difference") {
  const survey::Survey a = well(40, 0), b = well(40, 170, 5);
  const auto mwd = shipped("iscwsa_mwd_rev5.10"), ifr = shipped("MWD+IFR1");
  const std::vector<propagate::ToolRun> of_a{{1, mwd}}, of_b{{1, ifr}};
  const auto ra = std::make_shared<const PositionErrors>(errors_of(a, of_a, Interpolation::effects)),
             rb = std::make_shared<const PositionErrors>(errors_of(b, of_b, Interpolation::effects));
  const StationEffects ea = effects_of(a, of_a), eb = effects_of(b, of_b);
  struct Case {
    Sharing sharing;
    std::vector<std::string> listed, shared;
  };
  // IFR measures the field of the place: of its declination and dip, only the instrument's terms are the model's.
  for (const Case& x : {Case{Sharing::none, {}, {}}, Case{Sharing::geomagnetic, {}, {"DEC-OI", "DBH-OI"}},
                        Case{Sharing::listed, {"DSTG"}, {"DSTG"}}}) {
    PairErrors pair{"", ra, rb, {shared_sources(x.sharing, x.listed, *ra, *rb), Matrix3d::Zero()}, false};
    std::vector<std::string> found;
    for (const auto& [i, j] : pair.common.sources) {
      found.push_back(ra->sources[i].code);
      CHECK(rb->sources[j].code == ra->sources[i].code);
    }
    std::sort(found.begin(), found.end());
    std::vector<std::string> wanted = x.shared;
    std::sort(wanted.begin(), wanted.end());
    CHECK(found == wanted);
    // The difference of the errors, draw by draw: draws that are not shared get another name.
    Draws da = between(draws_at(ea, 30), draws_at(ea, 31), 0.4), db = between(draws_at(eb, 38), draws_at(eb, 39), 0.9);
    Draws difference = da;
    for (const auto& [name, effect] : db) {
      const bool is_shared = std::any_of(x.shared.begin(), x.shared.end(),
                                         [&draw = name](const std::string& c) { return draw == c + "G1"; });
      difference.try_emplace(is_shared ? name : "offset " + name, Vector3d::Zero()).first->second -= effect;
    }
    const Matrix3d c =
        relative_covariance(pair, ra->covariance_at(30, 0.4), rb->covariance_at(38, 0.9), 30, 0.4, 38, 0.9);
    CHECK(is_close(c, product(difference, difference)));
  }
  // Twins: with all of W and G shared, only R and S are left, twice.
  const std::vector<propagate::ToolRun> twins{{1, mwd}};
  const auto twin = std::make_shared<const PositionErrors>(errors_of(a, twins, Interpolation::covariance));
  PairErrors pad{"pad", twin, twin, {shared_sources(Sharing::pad, {}, *twin, *twin), Matrix3d::Zero()}, false};
  Matrix3d rest = Matrix3d::Zero();
  for (const auto& [name, effect] : draws_at(ea, 39))
    if (name.find("W1") == std::string::npos && name.find("G1") == std::string::npos)
      rest += effect * effect.transpose();
  CHECK(is_close(relative_covariance(pad, twin->covariance[39], twin->covariance[39], 38, 1, 38, 1), 2 * rest));
  CHECK(pad.common.sources.size() > 8);
}

TEST_CASE("A sidetrack shares every draw of the hole above its kick-off, and W and G beyond it") {
  // The same hole for 25 stations; tools change at station 15, and the sidetrack has a run of its own.
  constexpr std::size_t kKickoff = 24;
  const survey::Survey a = well(45, 0);
  survey::Survey b = a;
  for (std::size_t k = kKickoff + 1; k < b.stations.size(); ++k) {
    b.stations[k].azimuth += 8 * kDegree * static_cast<double>(k - kKickoff);
    b.stations[k].md += 10;  // stations elsewhere, too
  }
  const auto mwd = shipped("iscwsa_mwd_rev5.10"), ifr = shipped("MWD+IFR1");
  const StationEffects ea = effects_of(a, {{1, ifr}, {15, mwd}}),
                       eb = effects_of(b, {{1, ifr}, {15, mwd}, {kKickoff + 1, mwd}});
  const PairErrors pair = shared_hole(ea, eb, kKickoff);
  const auto shared_name = [](const std::string& name) {
    // Of the draw's number, which is that of its first station; W and G are one draw.
    const auto number = static_cast<std::size_t>(std::stoi(name.substr(name.find_last_of("RSWG") + 1)));
    return number <= kKickoff;
  };
  const auto check = [&](std::size_t leg_a, double fa, std::size_t leg_b, double fb) {
    Draws difference = between(draws_at(ea, leg_a), draws_at(ea, leg_a + 1), fa);
    for (const auto& [name, effect] : between(draws_at(eb, leg_b), draws_at(eb, leg_b + 1), fb))
      difference.try_emplace(shared_name(name) ? name : "offset " + name, Vector3d::Zero()).first->second -= effect;
    const Matrix3d c = relative_covariance(pair, pair.reference->covariance_at(leg_a, fa),
                                           pair.offset->covariance_at(leg_b, fb), leg_a, fa, leg_b, fb);
    CAPTURE(leg_a, fa, leg_b, fb);
    // Two covariances of nearly the same errors: the difference carries the rounding of the sum.
    CHECK((c - product(difference, difference)).norm() <= 1e-11 * pair.reference->covariance_at(leg_a, fa).norm());
    return c;
  };
  check(kKickoff, 0.3, kKickoff, 0.7);
  check(kKickoff + 1, 0, kKickoff + 3, 0.5);
  check(40, 0.25, 38, 1);
  // At the kick-off both are one point.
  CHECK(check(kKickoff, 0, kKickoff, 0).norm() <= 1e-11 * pair.reference->covariance[kKickoff].norm());
}

TEST_CASE("Covariances that begin at the kick-off have the kick-off's own error over half of the leg below it") {
  constexpr std::size_t kKickoff = 24;
  const survey::Survey a = well(30, 40, 2);
  const auto tangent = [&](std::size_t k) -> Vector3d {
    const survey::Station& s = a.stations[k];
    return {std::sin(s.inclination) * std::cos(s.azimuth), std::sin(s.inclination) * std::sin(s.azimuth),
            std::cos(s.inclination)};
  };
  error_model::Model model = *shipped("iscwsa_mwd_rev5.10");
  const std::vector<error_model::Term> all = model.terms;
  const auto with = [&](const std::string& code) {
    model.terms.clear();
    for (const error_model::Term& t : all)
      if (t.code == code) model.terms.push_back(t);
    REQUIRE(model.terms.size() == 1);
    return effects_of(a, {{1, std::make_shared<const error_model::Model>(model)}});
  };
  const survey::Station& s = a.stations[kKickoff];
  {  // Azimuth, random: 0.1 deg. e_0 = D/2 sinI w, then the station below has its e*.
    const StationEffects e = with("DECR");
    const PairErrors pair = zeroed_at_kickoff(e, e, kKickoff, tangent(kKickoff), Interpolation::effects);
    const Vector3d e0 = 15 * std::sin(s.inclination) * 0.1 * kDegree *
                        Vector3d(-std::sin(s.azimuth), std::cos(s.azimuth), 0),
                   star = e.star[kKickoff + 1];
    CHECK(pair.is_independent);
    CHECK(pair.reference->covariance[kKickoff] == Matrix3d::Zero());
    CHECK(is_close(pair.reference->covariance[kKickoff + 1], e0 * e0.transpose() + star * star.transpose()));
  }
  {  // Depth, random: 0.35 m. e_0 = w (t_0 - t_1)/2.
    const StationEffects e = with("DRFR");
    const PairErrors pair = zeroed_at_kickoff(e, e, kKickoff, tangent(kKickoff), Interpolation::effects);
    const Vector3d e0 = 0.35 * (tangent(kKickoff) - tangent(kKickoff + 1)) / 2, star = e.star[kKickoff + 1];
    CHECK(is_close(pair.reference->covariance[kKickoff + 1], e0 * e0.transpose() + star * star.transpose()));
  }
  {  // A depth scale counts from the surface: one draw, 5.6e-4 of the whole measured depth.
    const StationEffects e = with("DSFS");
    const PairErrors pair = zeroed_at_kickoff(e, e, kKickoff, tangent(kKickoff), Interpolation::effects);
    const Vector3d e0 = 0.00056 * s.md * (tangent(kKickoff) - tangent(kKickoff + 1)) / 2,
                   one = e0 + e.star[kKickoff + 1];
    CHECK(is_close(pair.reference->covariance[kKickoff + 1], one * one.transpose()));
  }
}
