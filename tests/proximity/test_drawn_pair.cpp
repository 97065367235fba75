#include "proximity/drawn_pair.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "config/error_model_file.h"
#include "random/study_stream.h"
#include "stats/tests.h"
#include "survey/minimum_curvature.h"
#include "wells.h"

using namespace surveymc;
using namespace surveymc::proximity;
using namespace surveymc::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

propagate::WellErrors errors_of(const survey::Survey& s, const std::vector<propagate::ToolRun>& runs,
                                double multiplier) {
  return propagate::well_errors(s, survey::true_vertical_depths(s), runs, field(), 60 * kDegree, multiplier);
}
PositionErrors positions_of(const survey::Survey& s, const std::vector<propagate::ToolRun>& runs) {
  return position_errors(s, survey::true_vertical_depths(s), runs, field(), 60 * kDegree, Interpolation::effects);
}

/// Sample covariance of the offset's error less the reference's at one pair of points.
Matrix3d drawn_covariance(const propagate::WellErrors& a, const propagate::WellErrors& b, const SharedDraws& shared,
                          const propagate::WellPoint& at_a, const propagate::WellPoint& at_b, int trials) {
  const DrawnPoints reference = drawn_points(a, {at_a}, propagate::draw_places(a)),
                    offset = drawn_points(b, {at_b}, offset_places(a, b, shared));
  const random::Stream stream = random::stream_of({4, random::StudyId::clearance});
  const int groups = survey::groups_for(trials);
  survey::LaneArray x(groups, reference.well().rows()), y(groups, offset.well().rows());
  reference.well().draw(stream, 0, false, groups, x);
  offset.well().draw(stream, 0, false, groups, y);
  Matrix3d c = Matrix3d::Zero();
  for (int t = 0; t < trials; ++t) {
    const Vector3d d = offset.error(y, t, 0) - reference.error(x, t, 0);
    c += d * d.transpose() / trials;
  }
  return c;
}

}  // namespace

TEST_CASE("Predictions from draws are those from summed effects, for every way to share") {
  const survey::Survey a = well(50, 0), b = well(55, 200);
  const std::vector<propagate::ToolRun> of_a{{1, shipped("MWD+SRGM")}}, of_b{{1, shipped("iscwsa_mwd_rev5.10")}};
  const auto ra = std::make_shared<const PositionErrors>(positions_of(a, of_a)),
             rb = std::make_shared<const PositionErrors>(positions_of(b, of_b));
  const propagate::WellErrors ea = errors_of(a, of_a, 1), eb = errors_of(b, of_b, 1);
  for (const Sharing sharing : {Sharing::none, Sharing::geomagnetic, Sharing::global, Sharing::pad}) {
    PairErrors pair{"", ra, rb, {shared_sources(sharing, {}, *ra, *rb), Matrix3d::Zero()}, false};
    const SharedDraws shared = shared_draws(ea, eb, pair);
    CHECK(shared.size() == pair.common.sources.size());
    const Matrix3d c =
        relative_covariance(pair, ra->covariance_at(40, 0.3), rb->covariance_at(50, 0.8), 40, 0.3, 50, 0.8);
    const Matrix3d d = relative_covariance(ea, eb, shared, {41, 0.3}, {51, 0.8}, propagate::FirstOrder::iscwsa);
    CHECK((c - d).norm() < 1e-9 * c.norm());
  }
  // A sidetrack from station 30 on.
  survey::Survey side = a;
  for (std::size_t k = 31; k < side.stations.size(); ++k)
    side.stations[k].azimuth = 4 * kDegree * static_cast<double>(k - 30);
  const std::vector<propagate::ToolRun> of_side{{1, shipped("MWD+SRGM")}, {31, shipped("MWD+SRGM")}};
  propagate::StationEffects fa, fs;
  propagate::tool_covariances(a, survey::true_vertical_depths(a), of_a, field(), 1, propagate::SourceDetail::none, &fa);
  propagate::tool_covariances(side, survey::true_vertical_depths(side), of_side, field(), 1,
                              propagate::SourceDetail::none, &fs);
  const PairErrors pair = shared_hole(fa, fs, 30);
  const propagate::WellErrors es = errors_of(side, of_side, 1);
  const Matrix3d c = relative_covariance(pair, pair.reference->covariance_at(44, 0.5),
                                         pair.offset->covariance_at(40, 0.1), 44, 0.5, 40, 0.1),
                 d = relative_covariance(ea, es, draws_of_shared_hole(ea, es, 30), {45, 0.5}, {41, 0.1},
                                         propagate::FirstOrder::iscwsa);
  CHECK((c - d).norm() < 1e-9 * pair.reference->covariance[45].norm());
}

TEST_CASE("Two wells drawn together have the covariance of what they share", "[long]") {
  const survey::Survey a = well(60, 0), b = well(60, 180);
  const std::vector<propagate::ToolRun> runs{{1, shipped("MWD+SRGM")}};
  const auto ra = std::make_shared<const PositionErrors>(positions_of(a, runs)),
             rb = std::make_shared<const PositionErrors>(positions_of(b, runs));
  const propagate::WellErrors ea = errors_of(a, runs, 0.1), eb = errors_of(b, runs, 0.1);
  constexpr int kTrials = 8000;
  const auto draws = [&](Sharing sharing) {
    PairErrors pair{"", ra, rb, {shared_sources(sharing, {}, *ra, *rb), Matrix3d::Zero()}, false};
    return shared_draws(ea, eb, pair);
  };
  const auto predicted = [&](const SharedDraws& shared) {
    return relative_covariance(ea, eb, shared, {59, 1}, {59, 1}, propagate::FirstOrder::minimum_curvature);
  };
  const auto p_value = [&](const SharedDraws& drawn, const SharedDraws& assumed) {
    return stats::wishart_test(drawn_covariance(ea, eb, drawn, {59, 1}, {59, 1}, kTrials), predicted(assumed), kTrials)
        .p_value;
  };
  const SharedDraws none = draws(Sharing::none), fields = draws(Sharing::geomagnetic), pad = draws(Sharing::pad);
  // At a tenth of the sizes the wells are linear to 1e-3 of their sds, far below what 8000 trials tell. One in 10^4.
  CHECK(p_value(none, none) > 1e-4);
  CHECK(p_value(fields, fields) > 1e-4);
  CHECK(p_value(pad, pad) > 1e-4);
  // A wrong sharing is found.
  CHECK(p_value(fields, none) < 1e-12);
  CHECK(p_value(none, fields) < 1e-12);
  CHECK(p_value(pad, none) < 1e-12);
}
