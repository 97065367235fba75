/// AAKR, memory selection, bandwidth search.
#include <random>

#include <catch2/catch.hpp>

#include "base/error.h"
#include "monitoring/aakr.h"
#include "monitoring/aakr_lanes.h"
#include "monitoring/bandwidth.h"
#include "monitoring/training.h"
#include "simd/instruction_set.h"

using namespace surveymc;
using namespace surveymc::monitoring;
using Catch::Matchers::WithinAbs;

namespace {

Samples random_samples(int n, int p, unsigned seed) {
  std::mt19937_64 g(seed);
  std::normal_distribution<double> normal;
  return Samples::NullaryExpr(n, p, [&] { return normal(g); });
}

/// The equations as they stand, with libm and in long double.
std::vector<double> oracle(const Samples& memory, const Eigen::RowVectorXd& query, double h) {
  std::vector<long double> u2;
  for (Eigen::Index i = 0; i < memory.rows(); ++i) {
    long double s = 0;
    for (Eigen::Index j = 0; j < memory.cols(); ++j) {
      const long double d = static_cast<long double>(memory(i, j)) - static_cast<long double>(query[j]);
      s += d * d;
    }
    u2.push_back(s);
  }
  const long double least = *std::min_element(u2.begin(), u2.end()), hl = h;
  std::vector<long double> sum(static_cast<std::size_t>(memory.cols()), 0);
  long double weight = 0;
  for (std::size_t i = 0; i < u2.size(); ++i) {
    const long double w = expl(-(u2[i] - least) / (2 * hl * hl));
    weight += w;
    for (std::size_t j = 0; j < sum.size(); ++j)
      sum[j] += w * static_cast<long double>(memory(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
  }
  std::vector<double> out;
  for (const long double s : sum) out.push_back(static_cast<double>(s / weight));
  return out;
}

Eigen::RowVectorXd predict_one(const Aakr& model, const Eigen::RowVectorXd& query, double* nearest = nullptr) {
  Eigen::RowVectorXd out(query.size());
  Aakr::Scratch scratch;
  double distance = 0;
  model.predict(query.data(), 1, out.data(), &distance, scratch);
  if (nearest) *nearest = distance;
  return out;
}

}  // namespace

TEST_CASE("AAKR of three vectors gives the values computed by hand", "[monitoring]") {
  Samples memory(3, 2);
  memory << 0, 0, 1, 1, 2, 0;
  double nearest = 0;
  const auto x = predict_one(Aakr(memory, 0.5), Eigen::RowVector2d(0.5, 0.25), &nearest);
  // Weights are right to 8e-14 of their values, and the vectors at most 2 apart.
  CHECK_THAT(x[0], WithinAbs(.2918137026798208, 2 * 8e-14));
  CHECK_THAT(x[1], WithinAbs(.265387928772242, 2 * 8e-14));
  CHECK(nearest == std::sqrt(0.3125));
}

TEST_CASE("AAKR equals its equations for any number of sensors and vectors", "[monitoring]") {
  for (const int p : {1, 2, 3, 4, 5, 7, 9})
    for (const int m : {1, 2, 7, 8, 9, 100, 1350}) {
      const Samples memory = random_samples(m, p, 10), queries = random_samples(5, p, 11);
      for (const double h : {0.05, 0.2, 1.0, 50.0}) {
        const Aakr model(memory, h);
        for (Eigen::Index q = 0; q < queries.rows(); ++q) {
          const Eigen::RowVectorXd query = queries.row(q);
          const auto expected = oracle(memory, query, h);
          const auto x = predict_one(model, query);
          // Exponents up to u^2 / 2h^2 = 20 / 0.005 carry 1e-16 of themselves: 4e-13 of a weight, times values up to 4.
          for (Eigen::Index j = 0; j < p; ++j)
            REQUIRE_THAT(x[j], WithinAbs(expected[static_cast<std::size_t>(j)], 2e-12));
        }
      }
    }
}

TEST_CASE("Vectors that are left out weigh less than is said", "[monitoring]") {
  // Long and thin, in a direction that is no axis: most of the memory is outside of the window of any query. Of queries
  // on the line, beside it and beyond its ends.
  constexpr int kVectors = 1350, kQueries = 60;
  const Samples noise = random_samples(kVectors + kQueries, 4, 20);
  const Eigen::RowVector4d along(.7, -.4, .5, .3);
  Samples memory(kVectors, 4), queries(kQueries, 4);
  for (Eigen::Index i = 0; i < kVectors; ++i)
    memory.row(i) = (static_cast<double>(i * 7919 % kVectors) / 10 - 60) * along + .3 * noise.row(i);
  for (Eigen::Index q = 0; q < kQueries; ++q)
    queries.row(q) = (3.0 * static_cast<double>(q) - 75) * along + noise.row(kVectors + q);
  for (const double h : {.1, .3, 1.0}) {
    const Aakr model(memory, h);
    for (Eigen::Index q = 0; q < kQueries; ++q) {
      const Eigen::RowVectorXd query = queries.row(q);
      const auto expected = oracle(memory, query, h);
      double nearest = 0;
      const auto x = predict_one(model, query, &nearest);
      const double closest = std::sqrt((memory.rowwise() - query).rowwise().squaredNorm().minCoeff());
      CHECK(std::abs(nearest - closest) <= 1e-14 * closest);
      // kNegligibleShare of an extent of 140, and exponents of 15^2 / 2h^2 to 1e-16 where the query is that far
      const double bound = 140 * Aakr::kNegligibleShare + 2e-15 * (1 + closest * closest / (h * h));
      for (std::size_t j = 0; j < 4; ++j) REQUIRE(std::abs(x[static_cast<Eigen::Index>(j)] - expected[j]) <= bound);
    }
  }
  const Samples same = Samples::Constant(100, 3, .25);  // no direction at all
  CHECK((predict_one(Aakr(same, .2), Eigen::RowVector3d(1, 2, 3)).array() - .25).abs().maxCoeff() < 1e-15);
}

TEST_CASE("A query far from the memory gets the nearest vector, not 0 / 0", "[monitoring]") {
  const Samples memory = random_samples(50, 3, 12);
  double nearest = 0;
  const auto x = predict_one(Aakr(memory, 0.2), Eigen::RowVector3d(1e3, 1e3, 1e3), &nearest);
  Eigen::Index closest = 0;
  (memory.rowwise() - Eigen::RowVector3d(1e3, 1e3, 1e3)).rowwise().squaredNorm().minCoeff(&closest);
  // Exponents differ by 1e3 dz / h^2: the next vector has no weight left.
  CHECK((x - memory.row(closest)).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(nearest > 1e3);
}

TEST_CASE("Both instruction sets give the same bits, whatever else is predicted with a query", "[monitoring]") {
  const Samples memory = random_samples(1350, 6, 13), queries = random_samples(40, 6, 14);
  const Aakr model(memory, 0.3);
  Samples together(40, 6);
  Eigen::VectorXd nearest(40);
  Aakr::Scratch scratch;
  model.predict(queries.data(), 40, together.data(), nearest.data(), scratch);
  for (Eigen::Index q = 0; q < 40; ++q) CHECK(predict_one(model, queries.row(q)) == together.row(q));

  if (simd::instruction_set() == simd::InstructionSet::v4) {
    Samples narrow(40, 6);
    isa_v3::aakr_predict(model.batch(queries.data(), 40, narrow.data(), nearest.data(), scratch));
    CHECK(narrow == together);
  }
}

TEST_CASE("Memory selection takes extremes first, then ranks of the norm", "[monitoring]") {
  Samples z(200, 3);
  for (Eigen::Index i = 0; i < 200; ++i) {
    const double t = static_cast<double>(i);
    z.row(i) << std::sin(.1 * t), 1.5 * std::cos(.037 * t), static_cast<double>(i % 17) / 8 - 1;
  }
  CHECK(select_memory(z, 20) == std::vector<Eigen::Index>{16,  110, 0,  85,  127, 38,  58,  45, 192, 115,
                                                          144, 22,  96, 161, 184, 104, 179, 11, 13,  17});
  auto all = select_memory(z, 200);
  std::sort(all.begin(), all.end());
  for (Eigen::Index i = 0; i < 200; ++i) CHECK(all[static_cast<std::size_t>(i)] == i);
  CHECK_THROWS_AS(select_memory(z, 5), InputError);
  CHECK_THROWS_AS(select_memory(z, 201), InputError);
}

TEST_CASE("Scaling is by population sd and comes back; a constant sensor is refused by number", "[monitoring]") {
  Samples x(4, 2);
  x << 1, 10, 3, 10, 5, 30, 7, 30;
  const Scaling s = fit_scaling(x);
  CHECK(s.mean == Eigen::RowVector2d(4, 20));
  CHECK(s.sd == Eigen::RowVector2d(std::sqrt(5.0), 10));
  CHECK((s.from_z(s.to_z(x)) - x).cwiseAbs().maxCoeff() < 1e-14);
  x.col(1).setConstant(3e7);
  CHECK_THROWS_WITH(fit_scaling(x), Catch::Contains("sensor 2 does not vary"));
}

TEST_CASE("Against noisy readings the bandwidth search is drawn to narrow kernels, against the truth it is not",
          "[monitoring]") {
  // Two sensors on a line, so that a wide kernel averages noise away along it.
  Samples truth(600, 2);
  for (Eigen::Index i = 0; i < 600; ++i) {
    const double t = 2 * std::sin(.05 * static_cast<double>(i));
    truth.row(i) << t, -t;
  }
  const Samples z = truth + 0.3 * random_samples(600, 2, 15);
  const auto scores = search_bandwidth(z, truth, 200, {.05, .1, .2, .3, .5, .8}, 5);
  const auto best = [&](auto key) {
    return std::min_element(scores.begin(), scores.end(), [&](auto& a, auto& b) { return a.*key < b.*key; })->bandwidth;
  };
  CHECK(best(&BandwidthScore::mse_measured) < best(&BandwidthScore::mse_truth));
  CHECK(std::isnan(search_bandwidth(z, {}, 200, {.2}, 5)[0].mse_truth));
  CHECK_THROWS_AS(search_bandwidth(z, truth, 200, {.2}, 1), InputError);
}
