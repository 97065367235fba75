#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <boost/math/special_functions/beta.hpp>
#include <catch2/catch.hpp>

#include "stats/beta_quantile.h"
#include "stats/intervals.h"

using namespace surveymc::stats;

namespace {

constexpr double kLastDigits = 2e-14;

/// Whether the share with this tail probability is within a relative `width` of `share`: Boost's distribution function
/// in long double is right where its inverse fails.
bool is_near(double a, double b, double share, double probability, bool below, double width) {
  const auto tail = [&](long double x) {
    const long double la = a, lb = b, at = std::min(x, 1.0L);
    return below ? boost::math::ibeta(la, lb, at) : boost::math::ibetac(la, lb, at);
  };
  const long double low = tail(share * (1 - static_cast<long double>(width))),
                    high = tail(share * (1 + static_cast<long double>(width)));
  return below ? low <= probability && probability <= high : high <= probability && probability <= low;
}

}  // namespace

TEST_CASE("Quantiles of beta, F and t are those of mpmath, also where Boost's fail") {
  // mpmath 1.3 with 60 digits: bisection of betainc(a, b, 0, 1 / (1 + exp(-t)), regularized=True) in t.
  struct Beta {
    double a, b, probability, share, rest;
  };
  const std::array betas{Beta{.5, 2, 1e-9, 4.444444444444445e-19, 1},
                         Beta{.5, 2, 1e-12, 4.4444444444444443e-25, 1},
                         Beta{.5, 3, 1e-10, 2.8444444444444447e-21, 1},
                         Beta{2, 5.5, 1e-100, 2.3652495839563305e-51, 1},
                         Beta{2, 133, 1e-30, 1.0593434317257455e-17, 1},
                         Beta{.5, 1, 1e-15, 1.0000000000000002e-30, 1},
                         Beta{3, 6, 1e-100, 1.2132137516012933e-34, 1},
                         Beta{10, 1000, .025, 0.0047625570313961105, 0.99523744296860389},
                         Beta{1000, 5.5, 1e-12, 0.96045677165766363, 0.039543228342336373},
                         Beta{33.3, .5, .05, 0.94354419237565552, 0.056455807624344482},
                         Beta{1.5, 1.5, .975, 0.93916972407990261, 0.06083027592009739}};
  for (const Beta& q : betas) {
    CAPTURE(q.a, q.b, q.probability);
    const BetaPoint below = beta_quantile(q.a, q.b, q.probability),
                    above = beta_upper_quantile(q.b, q.a, q.probability);
    CHECK(below.share == Approx(q.share).epsilon(kLastDigits));
    CHECK(below.rest == Approx(q.rest).epsilon(kLastDigits));
    CHECK(above.rest == below.share);  // the mirror image, to the bit
    CHECK(above.share == below.rest);
  }
  struct Ratio {
    double above, below, probability, value;
  };
  const std::array ratios{Ratio{2, 2, 1e-15, 999999999999998.92},      Ratio{6, 1, 1e-9, 5.8593749999999993e17},
                          Ratio{6, 1, 1e-12, 5.8593750000000002e23},   Ratio{3, 11.5, 1e-100, 1.134277979336286e18},
                          Ratio{12, 6, 1e-100, 4.1212852998085568e33}, Ratio{1, 171, 1e-4, 15.874931720708279},
                          Ratio{5, 100000, 1e-30, 30.140173083915838}, Ratio{30, 4, 1e-100, 1.460593486680443e50}};
  for (const Ratio& q : ratios) {
    CAPTURE(q.above, q.below, q.probability);
    CHECK(fisher_upper_quantile(q.above, q.below, q.probability) == Approx(q.value).epsilon(kLastDigits));
  }
  CHECK(student_upper_quantile(6, 1e-12) == Approx(179.75335991079196).epsilon(kLastDigits));
  CHECK(student_upper_quantile(1e5, .025) == Approx(1.9599877075346096).epsilon(kLastDigits));
  CHECK(student_upper_quantile(10, .25) == Approx(0.69981206131243163).epsilon(kLastDigits));
  CHECK(student_upper_quantile(3, 1e-300) == Approx(1.0331108360446529e100).epsilon(kLastDigits));
}

TEST_CASE("Quantiles of beta have their tail probability over all tails and shapes") {
  for (const double a : {0.3, 0.5, 1.0, 1.5, 2.0, 3.7, 10.0, 33.3, 100.0, 1e3, 1e6})
    for (const double b : {0.5, 1.0, 2.0, 5.5, 20.0, 133.0, 1e3, 1e5, 1e8}) {
      // The distribution function in double rounds 1 - x, before it takes its power of the order of a or b.
      const double width = kLastDigits + 0.5 * std::numeric_limits<double>::epsilon() * std::max(a, b);
      for (const double p : {1e-100, 1e-30, 1e-15, 1e-12, 1e-10, 2e-9, 1e-9, 1e-6, 1e-3, .025, .3, .5, .975})
        for (const bool below : {true, false}) {
          const BetaPoint q = below ? beta_quantile(a, b, p) : beta_upper_quantile(a, b, p);
          CAPTURE(a, b, p, below, q.share, q.rest);
          if (std::min(q.share, q.rest) < 1e-300)
            CHECK(std::min(q.share, q.rest) >= 0);
          else if (q.share < q.rest)
            CHECK(is_near(a, b, q.share, p, below, width));
          else
            CHECK(is_near(b, a, q.rest, p, !below, width));
        }
    }
}

TEST_CASE("Quantiles of beta at the ends") {
  CHECK(beta_quantile(2, 3, 0).share == 0);
  CHECK(beta_quantile(2, 3, 1).share == 1);
  CHECK(beta_upper_quantile(2, 3, 0).share == 1);
  CHECK(beta_upper_quantile(2, 3, 1).share == 0);
  CHECK(beta_quantile(0.01, 2, 1e-15).share == 0);  // 2e-1499
  CHECK(binomial_interval(0, 10, .95).lo == 0);
  CHECK(binomial_interval(10, 10, .95).hi == 1);
  // (1 - p)^10 = 0.025
  CHECK(binomial_interval(0, 10, .95).hi == Approx(-std::expm1(std::log(.025) / 10)).epsilon(kLastDigits));
}
