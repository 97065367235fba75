/// Heavy-tailed laws against scipy, against the published factors of sizes, and their draws against both.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "random/mixing_draws.h"
#include "random/mixing_law.h"
#include "stats/intervals.h"

using namespace surveymc;
using namespace surveymc::random;

namespace {

LawOf student(double degrees) { return {.kind = LawKind::student, .degrees = degrees}; }
LawOf nig(double shape) { return {.kind = LawKind::nig, .shape = shape}; }
LawOf asymmetric(double shape, double skew) { return {.kind = LawKind::asymmetric_nig, .shape = shape, .skew = skew}; }
LawOf two_point(double share, double ratio) { return {.kind = LawKind::two_point, .share = share, .ratio = ratio}; }
const LawOf kLaplace{.kind = LawKind::laplace};

double outside(const MixingLaw& law, double k) { return law.upper_tail(k) + 1 - law.upper_tail(-k); }

std::vector<LawOf> all_laws() {
  return {{},     kLaplace,    student(5),         student(2.5),
          nig(1), nig(0.0565), two_point(0.05, 4), asymmetric(0.8, 0.670820393)};
}

}  // namespace

TEST_CASE("Sizes that are no sd become one by the law: factors and tails of the table to its digits") {
  struct Case {
    LawOf law;
    double per_ci68, ci95, outside_3;  // sd / ci68; ci95 in sd; % outside 3 ci95
  };
  // Independent: quadrature and draws of 2 million. Digits: three and three.
  for (const Case& c : std::vector<Case>{{{}, 1, 1, 0.270},
                                         {kLaplace, 1.232, 1.092, 0.971},
                                         {student(5), 1.162, 1.026, 1.060},
                                         {student(4), 1.239, 1.014, 1.261},
                                         {nig(1), 1.189, 1.062, 1.032},
                                         {nig(0.5), 1.330, 1.077, 1.330},
                                         {nig(0.2), 1.657, 1.067, 1.750}}) {
    const MixingLaw law(c.law);
    CAPTURE(law_names()[static_cast<std::size_t>(c.law.kind)], c.law.shape, c.law.degrees);
    CHECK(std::abs(sd_of_size(law, SizeMeaning::ci68) - c.per_ci68) < 0.00053);  // 1.16253 is printed as 1.162
    CHECK(std::abs(1 / sd_of_size(law, SizeMeaning::ci95) - c.ci95) < 0.00051);
    CHECK(sd_of_size(law, SizeMeaning::sd) == 1);
    CHECK(std::abs(100 * outside(law, 3 / sd_of_size(law, SizeMeaning::ci95)) - c.outside_3) < 0.00051);
  }
}

TEST_CASE("Laws that have the ratios of sd to the 68.3 % interval that Beggan found have his tails") {
  struct Case {
    double shape, degrees, ratio, outside[3];
  };
  for (const Case& c : {Case{0.2003, 2.64, 1.66, {5.20, 2.07, 1.37}}, Case{0.1362, 2.45, 1.86, {4.95, 2.13, 1.47}},
                        Case{0.0565, 2.20, 2.57, {4.15, 2.06, 1.53}}}) {
    const MixingLaw law(nig(c.shape));
    CHECK(std::abs(sd_of_size(law, SizeMeaning::ci68) - c.ratio) < 0.006);
    // nu has three digits; d ratio / d nu is about 3.
    CHECK(std::abs(sd_of_size(MixingLaw(student(c.degrees)), SizeMeaning::ci68) - c.ratio) < 0.03);
    const double at[] = {2, 3, 3.5};
    for (int i = 0; i < 3; ++i) CHECK(std::abs(100 * outside(law, at[i]) - c.outside[i]) < 0.0051);
  }
}

TEST_CASE("The inverse Gaussian laws are scipy's norminvgauss") {
  // scipy.stats.norminvgauss: skewness, excess kurtosis, sf at mean + x sd for x = -3, -1, 2, 3.5.
  struct Case {
    double a, b, skewness, kurtosis, sf[4];
  };
  for (const Case& c : {Case{1,
                             0.6,
                             2.0124611797498106,
                             9.15,
                             {0.9997407518414764, 0.9151625275863926, 0.04197686165173408, 0.010921150860935893}},
                        Case{0.5,
                             -0.3,
                             -2.846049894151541,
                             18.3,
                             {0.9818545633822079, 0.8985068936725148, 0.004995162342283783, 0.00020384991591306217}}}) {
    const double shape = std::sqrt(c.a * c.a - c.b * c.b);
    const MixingLaw law(asymmetric(shape, c.b / std::sqrt(shape)));
    CHECK(std::abs(law.skewness() - c.skewness) < 1e-12 * std::abs(c.skewness));
    CHECK(std::abs(law.excess_kurtosis() - c.kurtosis) < 1e-12 * c.kurtosis);
    const double at[] = {-3, -1, 2, 3.5};
    for (int i = 0; i < 4; ++i)
      CHECK(std::abs(law.upper_tail(at[i]) / c.sf[i] - 1) < 1e-7);  // what scipy integrates to
  }
  const MixingLaw symmetric(nig(0.2));
  CHECK(symmetric.excess_kurtosis() == Approx(15).epsilon(1e-14));
}

TEST_CASE("V has mean 1 and its fourth moment of H, and rises with the normal that draws it") {
  for (const LawOf& of : all_laws()) {
    const MixingLaw law(of);
    CAPTURE(law_names()[static_cast<std::size_t>(of.kind)], of.shape, of.degrees);
    double weight = 0, mean = 0, square = 0;
    for (const MixingNode& n : law.nodes()) {
      weight += n.weight;
      mean += n.weight * n.variance;
      square += n.weight * n.variance * n.variance;
    }
    CHECK(std::abs(weight - 1) < 1e-14);
    // A Student law of 2.5 degrees has 2 % of its variance beyond 8.5 standard normal units.
    if (of.degrees == 0 || of.degrees > 4) {
      CHECK(std::abs(mean - 1) < 1e-7);
      if (law.is_symmetric() && of.degrees == 0)
        CHECK(std::abs(3 * (square - 1) - law.excess_kurtosis()) < 1e-6 * (1 + law.excess_kurtosis()));
    }
    double last = 0;
    for (double z = -8; z <= 8; z += 0.37) {
      const MixingLaw::Draw d = law.draw(z);
      const double exact = law.quantile(z);
      CHECK(std::abs(d.factor / (law.scale() * std::sqrt(exact)) - 1) < 1e-7);
      CHECK(std::abs(d.shift - law.scale() * law.skew() * (exact - 1)) < 1e-6 * (1 + exact));
      CHECK(d.factor >= last);
      last = d.factor;
    }
  }
}

TEST_CASE("Characteristic functions are those of the mixture") {
  for (const LawOf& of : all_laws()) {
    const MixingLaw law(of);
    for (const double t : {0.1, 1.0, 5.0}) {
      std::complex<double> sum = 0;
      for (const MixingNode& n : law.nodes()) {
        const double u = law.scale() * t;
        sum += n.weight * std::exp(std::complex<double>(-0.5 * u * u * n.variance, u * law.skew() * (n.variance - 1)));
      }
      CHECK(std::abs(law.characteristic(t) - sum) < 1e-12);
    }
  }
}

/// Calls use(slot, H) for the first `trials` draws of every law.
template <class Use>
void each_draw(const std::vector<MixingSlot>& slots, int trials, const Use& use) {
  const Stream stream(7, 1);
  const std::size_t stride = 2 * slots.size() * simd::kGroup;
  constexpr int kAtOnce = 500;  // groups
  std::vector<double> rows(stride * kAtOnce + 8);
  double* aligned = rows.data() + (64 - reinterpret_cast<std::uintptr_t>(rows.data()) % 64) % 64 / sizeof(double);
  for (int first = 0; first < trials; first += 8 * kAtOnce) {
    draw_mixing(stream, slots, static_cast<std::uint64_t>(first), false, kAtOnce, aligned, stride);
    for (int t = 0; t < 8 * kAtOnce; ++t) {
      const double z = stream.normal(static_cast<std::uint64_t>(first + t), Channel::error_source, 0);
      for (std::size_t s = 0; s < slots.size(); ++s) {
        const double* row = aligned + static_cast<std::size_t>(t / 8) * stride + 2 * s * 8 + t % 8;
        use(s, row[0] * z + row[8]);
      }
    }
  }
}

std::vector<MixingSlot> slots_of(const std::vector<LawOf>& laws) {
  std::vector<MixingSlot> slots;
  for (const LawOf& of : laws) slots.push_back({std::make_shared<MixingLaw>(of), kMixingTerm, 5});
  return slots;
}

TEST_CASE("Drawn values have the moments and quantiles of their law") {
  // A million draws of H; bands of 4.5 standard errors, some 40 of them: a chance of 3e-4 that any is missed.
  constexpr int kTrials = 1'000'000;
  const std::vector<MixingSlot> slots = slots_of(all_laws());
  std::vector<std::size_t> above(5 * slots.size());
  std::vector<double> sum(slots.size());
  const double at[] = {0.6744897501962755, 1, 2, 3, 3.5};
  each_draw(slots, kTrials, [&](std::size_t s, double h) {
    sum[s] += h;
    for (std::size_t i = 0; i < 5; ++i) above[5 * s + i] += std::abs(h) > at[i];
  });
  for (std::size_t s = 0; s < slots.size(); ++s) {
    CAPTURE(s);
    CHECK(std::abs(sum[s] / kTrials) < 4.5 / std::sqrt(kTrials));  // variance 1
    for (std::size_t i = 0; i < 5; ++i) {
      const double p = outside(*slots[s].law, at[i]);
      CHECK(std::abs(static_cast<double>(above[5 * s + i]) / kTrials - p) < 4.5 * std::sqrt(p * (1 - p) / kTrials));
    }
  }
}

TEST_CASE("Ten million draws of every law have its quantiles and moments, within bands of 95 % for all",
          "[.law_draws]") {
  constexpr int kTrials = 10'000'000;
  const std::vector<LawOf> laws{{},
                                kLaplace,
                                student(4),
                                student(5),
                                student(9),
                                nig(1),
                                nig(0.5),
                                nig(0.2),
                                nig(0.0565),
                                two_point(0.05, 4),
                                asymmetric(0.8, 0.670820393)};
  const std::vector<MixingSlot> slots = slots_of(laws);
  const double probability[] = {0.5, 0.683, 0.954, 0.9973};
  std::vector<double> width;  // half, of the interval about 0
  for (const MixingSlot& s : slots)
    for (const double p : probability) {
      double lo = 0, hi = 64;
      for (int step = 0; step < 60; ++step) (outside(*s.law, (lo + hi) / 2) > 1 - p ? lo : hi) = (lo + hi) / 2;
      width.push_back(lo);
    }
  std::vector<std::size_t> above(width.size());
  std::vector<std::array<double, 8>> power(slots.size());  // sums of H^1 .. H^8
  each_draw(slots, kTrials, [&](std::size_t s, double h) {
    for (std::size_t i = 0; i < 4; ++i) above[4 * s + i] += std::abs(h) > width[4 * s + i];
    double x = 1;
    for (double& sum : power[s]) sum += x *= h;
  });
  struct Found {
    std::size_t law;
    std::string what;
    double in_errors;  // difference over its standard error
  };
  std::vector<Found> all;
  for (std::size_t s = 0; s < slots.size(); ++s) {
    for (std::size_t i = 0; i < 4; ++i) {
      const double p = 1 - probability[i], share = static_cast<double>(above[4 * s + i]) / kTrials;
      all.push_back({s, "quantile", (share - p) / std::sqrt(p * (1 - p) / kTrials)});
    }
    // Of moment m the error needs moment 2 m: by the law where there are four, by the draws beyond.
    const MixingLaw& law = *slots[s].law;
    const auto moment = [&](int m) { return power[s][static_cast<std::size_t>(m - 1)] / kTrials; };
    all.push_back({s, "mean", moment(1) * std::sqrt(kTrials)});
    const double kurtosis = law.excess_kurtosis();
    if (!std::isfinite(kurtosis)) continue;
    all.push_back({s, "variance", (moment(2) - 1) / std::sqrt((kurtosis + 2) / kTrials)});
    if (laws[s].kind == LawKind::student && laws[s].degrees <= 8) continue;
    all.push_back(
        {s, "kurtosis", (moment(4) - 3 - kurtosis) / std::sqrt((moment(8) - moment(4) * moment(4)) / kTrials)});
    if (!law.is_symmetric())
      all.push_back(
          {s, "skewness", (moment(3) - law.skewness()) / std::sqrt((moment(6) - moment(3) * moment(3)) / kTrials)});
  }
  const double bound = stats::normal_quantile(1 - 0.05 / (2 * static_cast<double>(all.size())));
  for (const Found& f : all) {
    CAPTURE(f.law, f.what, bound);
    CHECK(std::abs(f.in_errors) < bound);
  }
}

TEST_CASE("Both trials of an antithetic pair have one V, and a block is where its address says") {
  const Stream stream(3, 2);
  const std::vector<MixingSlot> slots{{std::make_shared<MixingLaw>(nig(0.5)), kMixingRun, 2}};
  alignas(64) double pairs[64], alone[64];
  draw_mixing(stream, slots, 16, true, 4, pairs, 16);
  draw_mixing(stream, slots, 8, false, 2, alone, 16);
  for (int t = 0; t < 32; ++t) {
    const double factor = pairs[t / 8 * 16 + t % 8];
    CHECK(factor == pairs[(t ^ 1) / 8 * 16 + (t ^ 1) % 8]);
    if (t < 32) CHECK(factor == alone[t / 2 / 8 * 16 + t / 2 % 8]);
    CHECK(factor == slots[0].law->draw(stream.normal(8 + static_cast<std::uint64_t>(t) / 2, kMixingRun, 2)).factor);
  }
}
