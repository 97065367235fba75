/// Tails of sums of heavy and normal errors, against independent quadrature and draws of two million.
#include <cmath>
#include <memory>
#include <vector>

#include <catch2/catch.hpp>

#include "stats/heavy_tail.h"

using namespace surveymc;
using random::LawKind;
using random::LawOf;
using random::MixingLaw;
using stats::HeavyPart;

namespace {

std::shared_ptr<const MixingLaw> law_of(const LawOf& of) { return std::make_shared<MixingLaw>(of); }

struct TailLine {
  LawOf of;
  double percent[5][3];  // rho 1, .75, .5, .25, .1 by 2, 3, 3.5 sd
};
const std::vector<TailLine> kTailLines{
    {{.kind = LawKind::laplace},
     {{5.911, 1.437, .709}, {5.325, 1.040, .460}, {4.891, .674, .248}, {4.650, .387, .099}, {4.571, .290, .054}}},
    {{.kind = LawKind::student, .degrees = 5},
     {{4.931, 1.172, .629}, {4.712, .887, .436}, {4.611, .616, .258}, {4.578, .388, .114}, {4.561, .295, .060}}},
    {{.kind = LawKind::student, .degrees = 4},
     {{4.742, 1.324, .776}, {4.526, 1.015, .555}, {4.473, .709, .341}, {4.524, .435, .153}, {4.551, .311, .071}}},
    {{.kind = LawKind::nig, .shape = 1},
     {{5.445, 1.326, .677}, {5.038, .974, .447}, {4.775, .645, .247}, {4.627, .383, .100}, {4.568, .290, .055}}},
    {{.kind = LawKind::nig, .shape = 0.5},
     {{5.500, 1.710, .997}, {5.031, 1.279, .688}, {4.748, .846, .394}, {4.629, .464, .152}, {4.576, .308, .064}}},
    {{.kind = LawKind::nig, .shape = 0.2},
     {{5.202, 2.070, 1.373}, {4.734, 1.607, 1.008}, {4.506, 1.106, .628}, {4.549, .601, .259}, {4.574, .349, .090}}},
    {{.kind = LawKind::two_point, .share = 0.05, .ratio = 4},
     {{3.316, 1.612, 1.236}, {3.708, 1.328, .948}, {4.157, .982, .608}, {4.513, .568, .243}, {4.576, .335, .080}}}};
constexpr double kHeavyShares[] = {1, 0.75, 0.5, 0.25, 0.1};

}  // namespace

TEST_CASE("A heavy part of any share has the tails of the table, to 0.002 percent points") {
  const std::vector<double> normal = stats::beyond({}, {2, 3, 3.5});
  CHECK(std::abs(100 * normal[0] - 4.550) < 5e-4);
  CHECK(std::abs(100 * normal[1] - 0.270) < 5e-4);
  CHECK(std::abs(100 * normal[2] - 0.047) < 5e-4);
  for (const TailLine& line : kTailLines)
    for (int r = 0; r < 5; ++r) {
      CAPTURE(random::law_names()[static_cast<std::size_t>(line.of.kind)], line.of.shape, line.of.degrees,
              kHeavyShares[r]);
      const auto found = stats::beyond({{law_of(line.of), std::sqrt(kHeavyShares[r])}}, {2, 3, 3.5});
      for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(100 * found[k] - line.percent[r][k]) < 0.002);
    }
}

TEST_CASE("Who shares V decides: eight terms with one V, or one each") {
  // DEC-U, -OS, -OH, -OI and DBH-U, ... of the standard resolution reference at 15,450 nT, in degrees.
  const double bh = 15450;
  const double size[] = {0.16, 0.24, 0.21, 0.05, 2350 / bh, 3359 / bh, 2840 / bh, 356 / bh};
  double square = 0, fourth = 0;
  for (const double s : size) {
    square += s * s;
    fourth += s * s * s * s;
  }
  CHECK(std::abs(fourth / (square * square) - 0.179) < 0.0006);
  struct Case {
    LawOf of;
    double rho;
    std::vector<double> shared, each;  // percent at 2, 3, 3.5 sd; 10^6 draws of V: 1 % each
  };
  const std::vector<Case> cases{{{.kind = LawKind::nig, .shape = 0.2}, 0.69, {4.65, 1.49, .92}, {4.92, .83, .36}},
                                {{.kind = LawKind::nig, .shape = 0.5}, 0.69, {4.93, 1.17, .61}, {4.81, .56, .18}},
                                {{.kind = LawKind::laplace}, 0.69, {5.21, .95, .41}, {4.75, .43, .11}},
                                {{.kind = LawKind::nig, .shape = 0.2}, 0.27, {4.54, .64, .29}, {4.64, .39, .10}}};
  for (const Case& c : cases) {
    std::vector<HeavyPart> each;
    for (const double s : size) each.push_back({law_of(c.of), std::sqrt(c.rho / square) * s});
    const auto one = stats::beyond({{law_of(c.of), std::sqrt(c.rho)}}, {2, 3, 3.5}),
               many = stats::beyond(each, {2, 3, 3.5});
    CAPTURE(c.rho, c.of.shape);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(std::abs(100 * one[k] - c.shared[k]) < 0.01 * c.shared[k] + 0.005);
      CHECK(std::abs(100 * many[k] - c.each[k]) < 0.01 * c.each[k] + 0.005);
    }
  }
}

TEST_CASE("Several parts are the limit of one, and of their tensor quadrature") {
  for (const TailLine& line : kTailLines) {
    CAPTURE(random::law_names()[static_cast<std::size_t>(line.of.kind)], line.of.shape, line.of.degrees);
    const std::vector<double> k{2, 3, 3.5, 5};
    // A second part of no weight to speak of changes nothing: the other way of computing has to agree.
    const auto one = stats::beyond({{law_of(line.of), std::sqrt(0.5)}}, k),
               two = stats::beyond({{law_of(line.of), std::sqrt(0.5)}, {law_of(line.of), 1e-6}}, k);
    for (std::size_t i = 0; i < k.size(); ++i) CHECK(std::abs(one[i] - two[i]) < 2e-8);
    const MixingLaw mixing(line.of);
    const double a = 0.5, b = 0.3;
    const auto both = stats::beyond({{law_of(line.of), std::sqrt(a)}, {law_of(line.of), -std::sqrt(b)}}, k);
    for (std::size_t i = 0; i < k.size(); ++i) {
      double sum = 0;
      for (const random::MixingNode& x : mixing.nodes())
        for (const random::MixingNode& y : mixing.nodes())
          sum += x.weight * y.weight * std::erfc(k[i] / std::sqrt(2 * (a * x.variance + b * y.variance + 1 - a - b)));
      CHECK(std::abs(both[i] - sum) < 2e-8);
    }
  }
}

TEST_CASE("The k of a probability is the inverse of the probability of a k") {
  const std::vector<HeavyPart> parts{{law_of({.kind = LawKind::nig, .shape = 0.2}), std::sqrt(0.69)}};
  for (const double p : {0.3, 0.05, 4.65e-4, 1e-6})
    CHECK(std::abs(stats::beyond(parts, {stats::quantile_beyond(parts, p)})[0] / p - 1) < 1e-6);
  CHECK(std::abs(stats::quantile_beyond({}, 4.652581580e-4) - 3.5) < 1e-6);
  // Several parts are known to 1e-8 only.
  const std::vector<HeavyPart> two{{law_of({.kind = LawKind::nig, .shape = 5}), 0.3},
                                   {law_of({.kind = LawKind::nig, .shape = 5}), 0.2}};
  CHECK(std::isnan(stats::beyond(two, {9})[0]));
  CHECK(std::isnan(stats::quantile_beyond(two, 1e-9)));
  CHECK(std::abs(stats::beyond(two, {stats::quantile_beyond(two, 1e-6)})[0] / 1e-6 - 1) < 1e-2);
}
