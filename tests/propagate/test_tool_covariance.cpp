#include "propagate/tool_covariance.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "angles.h"
#include "base/units.h"
#include "config/error_model_file.h"
#include "error_model/model_graph.h"
#include "formulas.h"
#include "survey/minimum_curvature.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::config;
using namespace surveymc::propagate;
using namespace surveymc::survey;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using surveymc::test::field_of;
using surveymc::test::largest_difference;
using surveymc::test::survey_of;

namespace {

/// The shipped model: "rev4" or "rev5.10".
SharedModel shipped(const std::string& revision) { return test::shipped("iscwsa_mwd_" + revision); }

/// Inclinations beyond 90 deg, azimuths through north both ways, legs from 4 to 40 m; nowhere vertical.
Survey winding_well() {
  std::vector<std::array<double, 3>> a;
  double md = 1000;
  for (int k = 0; k < 24; ++k) {
    a.push_back({md, 20 + 5.0 * k, 320 + 9.0 * k - (k > 14 ? 20.0 * (k - 14) : 0)});
    md += k % 5 == 0 ? 4 : k % 3 == 0 ? 40 : 29;
  }
  return survey_of(a);
}

ToolCovariances covariances(const Survey& s, const std::vector<ToolRun>& legs, const ReferenceField& f,
                            SourceDetail detail = SourceDetail::all) {
  return tool_covariances(s, true_vertical_depths(s), legs, f, kNaN, detail);
}

/// Of a station function at station k.
error_model::Weights weights_at(const error_model::Function& function, const Survey& survey,
                                const std::vector<double>& tvd, const ReferenceField& f, std::size_t k) {
  const Station &at = survey.stations[k], &before = survey.stations[k - 1];
  return error_model::weights_at(function,
                                 {.inclination = at.inclination,
                                  .azimuth = at.azimuth,
                                  .declination = f.declination,
                                  .md = at.md,
                                  .dmd = at.md - before.md,
                                  .tvd = tvd[k]},
                                 error_model::surroundings_of({}, f.dip, f.total, f.gravity, kNaN));
}

/// Change of all positions for one unit of a source at one station, by moving the measured depth, inclination and
/// azimuth of that station and computing the well anew, with half of it added and taken away.
std::vector<Vector3d> moved_positions(const Survey& s, std::size_t k, const error_model::Weights& w) {
  constexpr double h = 1e-4;  // positions of 1000 m are good to 2e-13, so this to 1e-9 m; curvature costs h^2/6
  const double azimuth = w.lateral / std::sin(s.stations[k].inclination);
  const double step = h / std::max({1e-30, std::abs(w.inclination), std::abs(azimuth), 1e-4 * std::abs(w.depth)});
  const auto moved = [&](double by) {
    Survey m = s;
    m.stations[k].md += by * w.depth;
    m.stations[k].inclination += by * w.inclination;
    m.stations[k].azimuth += by * azimuth;
    return test::balanced_tangential_positions(m);
  };
  const auto plus = moved(step), minus = moved(-step);
  std::vector<Vector3d> d;
  for (std::size_t i = 0; i < plus.size(); ++i) d.push_back((plus[i] - minus[i]) / (2 * step));
  return d;
}

}  // namespace

TEST_CASE("Covariances are those of the positions that follow from measurements with errors") {
  const Survey s = winding_well();
  const auto tvd = true_vertical_depths(s);
  const ReferenceField f = field_of(48000, -58, 11);
  const std::vector<ToolRun> legs{{1, shipped("rev4")}, {9, shipped("rev4")}, {15, shipped("rev5.10")}};
  const auto result = covariances(s, legs, f);
  const auto leg_of = [&](std::size_t k) { return k < 9 ? 0u : k < 15 ? 1u : 2u; };
  const std::size_t n = s.stations.size();
  for (std::size_t row = 0; row < result.sources.size(); ++row) {
    // effects[k][K]: of the error of station k on position K; empty where the tool of k does not have the source
    std::vector<std::vector<Vector3d>> effects(n);
    error_model::PropagationMode mode{};
    bool course = false;
    for (std::size_t k = 1; k < n; ++k)
      for (const error_model::Term& t : legs[leg_of(k)].model->terms) {
        if (t.code != result.sources[row]) continue;
        mode = t.mode;
        course = t.function->kind == error_model::Kind::course;
        if (!course) effects[k] = moved_positions(s, k, weights_at(*t.function, s, tvd, f, k));
        for (Vector3d& e : effects[k]) e *= t.sigma;
      }
    if (course) continue;
    for (std::size_t K = 1; K < n; ++K) {
      Matrix3d expected = Matrix3d::Zero();
      for (std::size_t a = 1; a <= K; ++a)
        for (std::size_t b = 1; b <= K; ++b) {
          if (effects[a].empty() || effects[b].empty()) continue;
          const bool joined = mode == error_model::PropagationMode::random       ? a == b
                              : mode == error_model::PropagationMode::systematic ? leg_of(a) == leg_of(b)
                                                                                 : true;
          if (joined) expected += effects[a][K] * effects[b][K].transpose();
        }
      CAPTURE(result.sources[row], K);
      const Matrix3d& c = result.by_source[K * result.sources.size() + row];
      CHECK((c - expected).cwiseAbs().maxCoeff() <= 1e-7 * expected.trace() + 1e-14);
    }
  }
}

TEST_CASE("Sources add up to the total, and every one is a covariance") {
  const Survey s = winding_well();
  const auto result = covariances(s, {{1, shipped("rev5.10")}}, field_of(48000, -58, 11));
  CHECK(result.sources.size() == 35);
  for (std::size_t k = 0; k < result.total.size(); ++k) {
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t i = 0; i < result.sources.size(); ++i) {
      const Matrix3d& c = result.by_source[k * result.sources.size() + i];
      CHECK(c == c.transpose());
      CHECK(Eigen::SelfAdjointEigenSolver<Matrix3d>(c).eigenvalues()[0] >= -1e-14 * c.trace());
      sum += c;
    }
    CHECK((sum - result.total[k]).cwiseAbs().maxCoeff() <= 1e-14 * sum.trace());
  }
  CHECK(result.total[0] == Matrix3d::Zero());
  const auto without = covariances(s, {{1, shipped("rev5.10")}}, field_of(48000, -58, 11), SourceDetail::none);
  CHECK(without.by_source.empty());
  CHECK(without.total.back() == result.total.back());
  const auto last = covariances(s, {{1, shipped("rev5.10")}}, field_of(48000, -58, 11), SourceDetail::last);
  REQUIRE(last.by_source.size() == 35);
  for (std::size_t i = 0; i < 35; ++i) CHECK(last.by_source[i] == result.by_source[(result.total.size() - 1) * 35 + i]);
}

TEST_CASE("Published totals of ISCWSA example well 2, in feet") {
  const auto [s, tvd, field, latitude] = test::iscwsa_well(2);
  const auto result = tool_covariances(s, tvd, {{1, shipped("rev5.10")}}, field, kNaN, SourceDetail::none);
  const auto check = [&](double feet, const Vector3d& diagonal, const Vector3d& off) {
    for (std::size_t k = 0; k < s.stations.size(); ++k) {
      if (std::abs(s.stations[k].md - feet * kFoot) > 1e-9) continue;
      const Matrix3d& c = result.total[k];
      const double tolerance = 2e-7 * diagonal.sum();  // the workbook's least tortuosity has six digits
      CHECK((c.diagonal() - diagonal).cwiseAbs().maxCoeff() < tolerance);
      CHECK((Vector3d(c(0, 1), c(0, 2), c(1, 2)) - off).cwiseAbs().maxCoeff() < tolerance);
      return;
    }
    FAIL("no such station");
  };
  check(2000, {.741809819858, .741809819858, .247668548217}, {0, 0, 0});
  check(3600, {2.9320779644, 2.40092820675, .751537987219}, {.0178812311025, -.531263519419, -.0181072417269});
}

TEST_CASE("Covariances are continuous through the vertical") {
  // Vertical, a build, a tangent, back to vertical and on; the vertical stations nearly so, at the azimuth they list.
  for (const char* revision : {"rev4", "rev5.10"})
    for (const double azimuth : {0.0, 75.0, 200.0}) {
      const auto well = [&](double nearly) {
        std::vector<std::array<double, 3>> a;
        for (int k = 0; k < 40; ++k) {
          const double inclination = k < 8    ? 0
                                     : k < 16 ? 2.0 * (k - 7)
                                     : k < 24 ? 16
                                     : k < 31 ? 16 - 2.0 * (k - 23)
                                              : 0;
          a.push_back({30.0 * k, inclination > 0 ? inclination : nearly, azimuth});
        }
        return survey_of(a);
      };
      const ReferenceField f = field_of(50000, 72, -4);
      const std::vector<ToolRun> legs{{1, shipped(revision)}};
      const auto vertical = covariances(well(0), legs, f);
      for (const double nearly : {1e-9, 1e-6}) {
        // Weights change by at most (1 + tanD) times the inclination, squares of their sums by twice that.
        const double tolerance = 2 * (1 + std::tan(f.dip)) * nearly * kDegree;
        CAPTURE(revision, azimuth, nearly);
        auto tilted = covariances(well(nearly), legs, f);
        // Sag with the fourth root of sinI is no longer zero there: the model's own, and apart from it all is smooth.
        for (std::size_t row = 0; row < tilted.sources.size(); ++row)
          if (tilted.sources[row] == "SAGE")
            for (std::size_t k = 0; k < tilted.total.size(); ++k) {
              const std::size_t i = k * tilted.sources.size() + row;
              tilted.total[k] += vertical.by_source[i] - tilted.by_source[i];
            }
        CHECK(largest_difference(tilted.total, vertical.total) < tolerance);
      }
    }
}

TEST_CASE("In a vertical well the azimuth that is listed does not matter") {
  for (const char* revision : {"rev4", "rev5.10"}) {
    const auto well = [](double azimuth) {
      return survey_of(30, [&](int k) { return Station{25.0 * k + (k % 4 == 0 ? 0 : 5), 0, azimuth * kDegree, 0}; });
    };
    const auto at_zero = covariances(well(0), {{1, shipped(revision)}}, field_of(50000, 72, -4));
    for (const double azimuth : {1e-9, 75.0, 180.0, 359.0}) {
      const auto c = covariances(well(azimuth), {{1, shipped(revision)}}, field_of(50000, 72, -4));
      CHECK(largest_difference(c.total, at_zero.total) < 1e-15 * 30);
    }
    CHECK(at_zero.total.back()(0, 0) == Approx(at_zero.total.back()(1, 1)).epsilon(1e-13));
  }
}

TEST_CASE("A full turn of azimuth changes nothing") {
  Survey s = winding_well();
  const std::vector<ToolRun> legs{{1, shipped("rev5.10")}};
  const ReferenceField f = field_of(52000, 65, 20);
  const auto before = covariances(s, legs, f);
  for (std::size_t k = 0; k < s.stations.size(); ++k)
    s.stations[k].azimuth += (k % 3 == 0 ? 2 : k % 3 == 1 ? -2 : 0) * kPi;
  CHECK(largest_difference(covariances(s, legs, f).total, before.total) < 1e-13);
}

TEST_CASE("Turning well and magnetic north together turns the covariance") {
  // DREF and the like do not care, and misalignments that are fixed to N and E (XYM3, XYM4) come in pairs.
  const Survey s = winding_well();
  Survey turned = s;
  const double by = 40 * kDegree;
  for (Station& x : turned.stations) x.azimuth += by;
  const ReferenceField f = field_of(52000, 65, 20), g = field_of(52000, 65, 60);
  Matrix3d r = Matrix3d::Identity();
  r.topLeftCorner<2, 2>() << std::cos(by), -std::sin(by), std::sin(by), std::cos(by);
  for (const char* revision : {"rev4", "rev5.10"}) {
    const auto a = covariances(s, {{1, shipped(revision)}}, f), b = covariances(turned, {{1, shipped(revision)}}, g);
    for (std::size_t k = 1; k < a.total.size(); ++k)
      CHECK((r * a.total[k] * r.transpose() - b.total[k]).cwiseAbs().maxCoeff() < 1e-13 * a.total[k].trace());
  }
}

TEST_CASE("Another tool of the same kind makes the well more certain, by its systematic terms only") {
  const Survey s = winding_well();
  const SharedModel model = shipped("rev5.10");
  const ReferenceField f = field_of(50000, 72, -4);
  const auto one = covariances(s, {{1, model}}, f), two = covariances(s, {{1, model}, {12, model}}, f);
  const std::size_t last = s.stations.size() - 1;
  for (std::size_t i = 0; i < model->terms.size(); ++i) {
    const Matrix3d &a = one.by_source[last * 35 + i], &b = two.by_source[last * 35 + i];
    CAPTURE(model->terms[i].code);
    if (model->terms[i].mode == error_model::PropagationMode::systematic)
      CHECK((a - b).norm() > 1e-3 * a.norm());
    else
      CHECK(a == b);
  }
  // Until the second tool's first station nothing differs.
  for (std::size_t k = 0; k < 12; ++k) CHECK(one.total[k] == two.total[k]);
}

TEST_CASE("Doubling the first leg doubles inclination and azimuth errors of the first station, not those of depth") {
  const Survey s = survey_of({{0, 30, 40}, {30, 30, 40}});
  const SharedModel doubled = shipped("rev5.10");
  const auto once = std::make_shared<error_model::Model>(*doubled);
  once->first_leg_doubled = false;
  const ReferenceField f = field_of(50000, 72, -4);
  const auto a = covariances(s, {{1, once}}, f), b = covariances(s, {{1, doubled}}, f);
  for (std::size_t i = 0; i < once->terms.size(); ++i) {
    CAPTURE(once->terms[i].code);
    const error_model::Function& w = *once->terms[i].function;
    const bool depth = !w.depth.empty(), course = w.kind == error_model::Kind::course;
    const Matrix3d &x = a.by_source[35 + i], &y = b.by_source[35 + i];
    CHECK((y - (depth || course ? 1 : 4) * x).cwiseAbs().maxCoeff() <= 1e-15 * y.trace());
  }
}

TEST_CASE("Blocks of stations do not show: a long well is what its stations give one by one") {
  // More than two blocks of 256 stations; a leg that begins inside of one, and one at its edge.
  const Survey s = survey_of(700, [](int k) { return Station{10.0 * k, 0.002 * k, 0.5 + 0.004 * k, 0}; });
  const SharedModel model = shipped("rev5.10");
  const ReferenceField f = field_of(50000, 72, -4);
  const auto whole = covariances(s, {{1, model}, {300, model}, {513, model}}, f, SourceDetail::none);
  for (const std::size_t n : {200u, 257u, 258u, 400u, 514u, 600u}) {
    const Survey part{{s.stations.begin(), s.stations.begin() + static_cast<std::ptrdiff_t>(n)}};
    std::vector<ToolRun> runs{{1, model}};
    if (n > 300) runs.push_back({300, model});
    if (n > 513) runs.push_back({513, model});
    const auto c = covariances(part, runs, f, SourceDetail::none);
    CHECK(c.total.back() == whole.total[n - 1]);
  }
}

TEST_CASE("A term with a pole makes the covariance NaN from there on, and is named") {
  // 90 deg at k = 11
  const Survey s = survey_of(12, [](int k) { return Station{30.0 * k, (35 + 5.0 * k) * kDegree, 1, 0}; });
  const SharedModel gyro = test::shipped("GYRO-NS");
  const auto c =
      tool_covariances(s, true_vertical_depths(s), {{1, gyro}}, field_of(50000, 72, -4), 1, SourceDetail::none);
  CHECK(c.total[10].allFinite());
  CHECK(std::isnan(c.total[11](0, 0)));
  REQUIRE_FALSE(c.non_finite.empty());
  CHECK(c.non_finite[0].first == 11);
  CHECK(c.non_finite[0].stations == 1);
  CHECK(c.non_finite[0].formula.find("Cos(Inc)") != std::string::npos);
}

TEST_CASE("A vertical formula without a finite value is named as the others are") {
  const Survey s = survey_of({{0, 0, 0}, {30, 0, 0}, {60, 0, 0}, {90, 5, 30}, {120, 10, 30}});
  using error_model::Function;
  const auto f =
      test::function_of({{&Function::inclination, "Cos(AzT)"}, {&Function::azimuth, "-Sin(AzT) / Sin(Inc)"}});
  const auto model = std::make_shared<error_model::Model>();
  model->terms.push_back({"A", f, 0.001, "-", 0.001, error_model::PropagationMode::systematic});
  f->vertical_north = error_model::parse_expression("Sin(Inc) / Inc");  // finite below, where it does not act
  const auto c = covariances(s, {{1, model}}, field_of(50000, 72, 0));
  CHECK(std::isnan(c.total[1](0, 0)));
  REQUIRE(c.non_finite.size() == 1);
  CHECK(c.non_finite[0].first == 1);
  CHECK(c.non_finite[0].last == 2);
  CHECK(c.non_finite[0].stations == 2);
  CHECK(c.non_finite[0].formula == "vertical_north = \"Sin(Inc) / Inc\"");
  f->vertical_north = error_model::parse_expression("1 + 0 / Sin(Inc - 5 * RAD)");
  CHECK(covariances(s, {{1, model}}, field_of(50000, 72, 0)).non_finite.empty());  // a pole at 5 deg does no harm
}
