#include "compare/position_comparison.h"

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::compare;

namespace {

/// The table of one prediction against a sample of 100,000 normal trials with this covariance.
store::Table table_of(const Eigen::Matrix2d& predicted, const Eigen::Matrix2d& sampled,
                      const Eigen::Vector2d& kurtosis = {3, 3}) {
  const HorizontalSample sample{100000, 0, 100000, false, Eigen::Vector2d::Zero(), sampled};
  TableRows w("ellipse", "test");
  write_sample_ellipse(w, sample);
  EllipseRow row{"theory", Eigen::Vector2d(7, 8), predicted};
  row.inside = {39000, 86000, 98900};
  const auto summary = [](double mean, double variance, double fourth) {
    return stats::SampleSummary{100000, mean, variance, variance, fourth, 0, fourth};
  };
  row.nees = summary(2.01, 4, 9);
  const Eigen::Matrix2d axes = propagate::ellipse(predicted).axes;
  for (int a = 0; a < 2; ++a)
    row.along[static_cast<std::size_t>(a)] = summary(0, axes.col(a).dot(sampled * axes.col(a)), kurtosis[a]);
  row.expected = "agrees";
  write_ellipse(w, row, sample, {});
  return w.take();
}

Eigen::Matrix2d diagonal(double a, double b) { return Eigen::Vector2d(a * a, b * b).asDiagonal(); }

}  // namespace

TEST_CASE("A prediction is judged along its own axes") {
  const store::Table t = table_of(diagonal(2, 1), diagonal(2, 1.25));
  CHECK(t.word("formulation", 0) == "monte_carlo");
  CHECK(t.number("center_north_m", 1) == 7);
  CHECK(t.number("semi_major_m", 1) == Approx(2).epsilon(1e-15));
  CHECK(t.number("major_azimuth_deg", 1) == Approx(0).margin(1e-12));
  CHECK(t.number("ratio_major", 1) == Approx(1).epsilon(1e-15));
  CHECK(t.number("ratio_minor", 1) == Approx(0.8).epsilon(1e-15));
  CHECK(t.number("ratio_minor_ci_low", 1) < 0.8);
  CHECK(t.number("ratio_minor_ci_high", 1) > 0.8);
  CHECK(t.number("coverage_1sigma", 1) == Approx(0.39).epsilon(1e-15));
  CHECK(t.number("nees", 1) == 2.01);
  CHECK(t.word("verdict", 1) == "differs");  // one axis is enough
  CHECK(table_of(diagonal(2, 1), diagonal(2, 1)).word("verdict", 1) == "agrees");
  CHECK(table_of(diagonal(2, 1), diagonal(2, 1.02)).word("verdict", 1) == "undecided");
  CHECK(unexpected_verdicts({t}).size() == 1);
}

TEST_CASE("Each axis has the interval of its own kurtosis") {
  const auto width = [](const store::Table& t, const std::string& axis) {
    return t.number("mc_sd_" + axis + "_m_ci_high", 1) - t.number("mc_sd_" + axis + "_m_ci_low", 1);
  };
  const store::Table normal = table_of(diagonal(2, 1), diagonal(2, 1)),
                     heavy = table_of(diagonal(2, 1), diagonal(2, 1), {3, 12});
  CHECK(width(heavy, "major") == width(normal, "major"));
  // Of a variance: sqrt((kurtosis - 1) / n)
  CHECK(width(heavy, "minor") / width(normal, "minor") == Approx(std::sqrt(11.0 / 2)).epsilon(0.01));
}

TEST_CASE("A line has neither coverage nor distance") {
  const store::Table t = table_of(diagonal(2, 0), diagonal(2, 0.001));
  CHECK(t.number("semi_minor_m", 1) == 0);
  for (const char* column : {"coverage_1sigma", "coverage_3sigma", "nees", "wishart_p"})
    CHECK(std::isnan(t.number(column, 1)));
}

TEST_CASE("An axis that is zero to first order has no part in the verdict") {
  const store::Table agrees = table_of(diagonal(2, 0), diagonal(2, 0.001)),
                     differs = table_of(diagonal(2, 0), diagonal(2.5, 0.001)),
                     point = table_of(diagonal(0, 0), diagonal(0.001, 0.001));
  CHECK(agrees.word("verdict", 1) == "agrees");
  CHECK(agrees.number("p_agrees", 1) < 1e-6);
  CHECK(agrees.number("p_differs", 1) == 1);
  CHECK(agrees.number("margin", 1) == 0.02);
  CHECK(agrees.number("mc_sd_minor_m", 1) == Approx(0.001).epsilon(1e-12));
  for (const char* column : {"ratio_minor", "ratio_minor_ci_low", "ratio_minor_ci_high"})
    CHECK(std::isnan(agrees.number(column, 1)));
  CHECK_THAT(agrees.word("note", 1), Catch::Matchers::Contains("minor axis: zero to first order"));
  CHECK(differs.word("verdict", 1) == "differs");
  CHECK(differs.number("p_differs", 1) < 1e-6);
  CHECK(point.word("verdict", 1).empty());
  CHECK(std::isnan(point.number("margin", 1)));
  CHECK(std::isnan(point.number("ratio_major", 1)));
}

TEST_CASE("Mean squared distances are held to the dimension by a margin of their own, which the row shows") {
  stats::SampleSummary distance{100000, 3.05, 6, 6, 7, 0, 7};  // variance of a chi-squared of 3 degrees
  CHECK(compare_nees("nees", distance, 3, {}, 100000).verdict == "agrees");
  distance.mean = 3.3;
  const ComparisonRow row = compare_nees("nees", distance, 3, {}, 100000);
  CHECK(row.verdict == "differs");
  CHECK(row.ratio == Approx(3 / 3.3).epsilon(1e-15));
  CHECK(row.margin == .06);
  // Thesis test 1, 400,000 trials: 8.37 against 6 is no agreement, however wide the margin of sds is.
  const stats::SampleSummary far{400000, 8.37, 60, 60, 30, 0, 30};
  CHECK(compare_nees("nees", far, 6, {.15, .95}, 400000).verdict == "differs");
  CHECK(compare_nees("nees", far, 6, {.15, .95, .3}, 400000).margin == .3);
}

TEST_CASE("Points are counted in every ellipse that holds them") {
  std::array<std::uint64_t, 3> counts{};
  for (const double squared : {0.5, 1.0, 3.9, 8.9, 9.1}) count_inside(squared, counts.data());
  CHECK(counts == std::array<std::uint64_t, 3>{2, 3, 4});
}
