#include "rare/test_functions.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "base/units.h"
#include "stats/intervals.h"
#include "stats/normal_tail.h"

namespace surveymc::rare {
namespace {

const double kRoot2 = std::sqrt(2.0);

double norm_of(const double* x, int n) {
  double squares = 0;
  for (int i = 0; i < n; ++i) squares += x[i] * x[i];
  return std::sqrt(squares);
}

double sum_of(const double* x, int n) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += x[i];
  return sum;
}

double value_of(const TestProblem& p, const double* x) {
  if (p.name == "linear") return p.beta[0] - sum_of(x, p.dimension) / std::sqrt(p.dimension);
  if (p.name == "union") {
    double g = kInfinity;
    for (std::size_t k = 0; k < p.beta.size(); ++k) g = std::min(g, p.beta[k] - x[k]);
    return g;
  }
  if (p.name == "product") return p.level - std::abs(x[0] * x[1]);
  if (p.name == "sphere") return p.radius - norm_of(x, p.dimension);
  if (p.name == "disc") return std::hypot(p.mean[0] + p.sd[0] * x[0], p.mean[1] + p.sd[1] * x[1]) - p.radius;
  if (p.name == "rp77") {
    const double u = 10 + 0.5 * x[0], v = x[1], w = 4 + x[2];
    return w <= 5 ? u - v - w : w - v;
  }
  if (p.name == "rp107") return 5 * std::sqrt(10.0) - sum_of(x, 10);
  if (p.name == "rp110") {
    const double a = x[0] <= 3.5 ? 0.85 - 0.1 * x[0] : 4 - x[0];
    const double b = x[1] <= 2 ? 2.3 - x[1] : 0.5 - 0.1 * x[1];
    return std::min(a, b);
  }
  if (p.name == "rp111") return 12.5 - std::abs(x[0] * x[1]);
  if (p.name == "rp25") return std::max(x[0] * x[0] - 8 * x[1] + 16, -16 * x[0] + x[1] + 32);
  const double s = (x[0] + x[1]) / kRoot2, d = x[0] - x[1];  // four_branch
  return std::min({3 + 0.1 * d * d - s, 3 + 0.1 * d * d + s, 7 / kRoot2 - d, 7 / kRoot2 + d});
}

class TestFunction final : public LimitState {
 public:
  explicit TestFunction(TestProblem problem) : p_(std::move(problem)) {}
  int dimension() const override { return p_.dimension; }
  void evaluate(const survey::LaneArray& z, int groups, double* g) const override {
    std::vector<double> x(static_cast<std::size_t>(p_.dimension));
    for (int t = 0; t < groups * simd::kGroup; ++t) {
      for (int i = 0; i < p_.dimension; ++i) x[static_cast<std::size_t>(i)] = z.value(t, i);
      g[t] = value_of(p_, x.data());
    }
  }

 private:
  TestProblem p_;
};

double upper(double x) {
  const volatile double argument = x;  // a compiler that knew it would compute erfc itself, to another last digit
  return stats::normal_upper_tail(argument);
}
double density(double x) { return std::exp(-x * x / 2) / std::sqrt(2 * kPi); }

/// Integral of f in pieces of a quarter: smooth between `kinks`.
double integral(const std::function<double(double)>& f, double lo, double hi) {
  const int pieces = std::max(1, static_cast<int>(std::ceil((hi - lo) * 4)));
  double sum = 0;
  for (int i = 0; i < pieces; ++i)
    sum += boost::math::quadrature::gauss_kronrod<double, 15>::integrate(f, lo + (hi - lo) * i / pieces,
                                                                         lo + (hi - lo) * (i + 1) / pieces, 0);
  return sum;
}

constexpr double kFar = 38;  // the density is 0 beyond

/// P(|x1 x2| > level). With x the first, the second must lie beyond level / x: a step at x of about the level, whose
/// width is of its size. So the pieces double from level / kFar on, below which nothing is left, until they are as wide
/// as all others.
double product_beyond(double level) {
  const auto f = [&](double x) { return density(x) * upper(level / x); };
  double sum = 0, x = std::max(level / kFar, 1e-300);
  for (; 2 * x < 0.5; x *= 2) sum += integral(f, x, 2 * x);
  return 4 * (sum + integral(f, x, kFar));
}

/// P(lo < N < hi), from the side where it does not cancel.
double between(double lo, double hi) { return lo > 0 ? upper(lo) - upper(hi) : upper(-hi) - upper(-lo); }

/// Over the disc |r| <= R of the normal with this mean and sds: R sin t along the first axis.
double disc_probability(const TestProblem& p) {
  const auto chord = [&](double t) {
    const double x = p.radius * std::sin(t), half = p.radius * std::cos(t);
    return density((x - p.mean[0]) / p.sd[0]) / p.sd[0] *
           between((-half - p.mean[1]) / p.sd[1], (half - p.mean[1]) / p.sd[1]) * half;
  };
  // Narrow where an sd is small against the radius.
  const double step = std::max(1.0, p.radius / std::min(p.sd[0], p.sd[1]));
  double sum = 0;
  const int pieces = static_cast<int>(std::ceil(8 * step));
  for (int i = 0; i < pieces; ++i)
    sum += boost::math::quadrature::gauss_kronrod<double, 15>::integrate(chord, kPi * (double(i) / pieces - 0.5),
                                                                         kPi * (double(i + 1) / pieces - 0.5), 0);
  return sum;
}

}  // namespace

const std::vector<std::string>& test_problem_names() {
  static const std::vector<std::string> names{"linear", "union", "product", "sphere", "disc",       "rp77",
                                              "rp107",  "rp111", "rp110",   "rp25",   "four_branch"};
  return names;
}

TestProblem with_dimension(TestProblem p) {
  if (p.name == "rp77") p.dimension = 3;
  if (p.name == "rp107") p.dimension = 10;
  if (p.name != "linear" && p.name != "union" && p.name != "sphere" && p.name != "rp77" && p.name != "rp107")
    p.dimension = 2;
  return p;
}

std::unique_ptr<LimitState> test_limit_state(const TestProblem& problem) {
  return std::make_unique<TestFunction>(with_dimension(problem));
}

double exact_probability(const TestProblem& given) {
  const TestProblem p = with_dimension(given);
  if (p.name == "linear") return upper(p.beta[0]);
  if (p.name == "union") {
    std::vector<double> each;
    for (const double b : p.beta) each.push_back(upper(b));
    return any_of_independent(each);
  }
  if (p.name == "product") return product_beyond(p.level);
  if (p.name == "rp111") return product_beyond(12.5);
  if (p.name == "sphere") return stats::chi_squared_upper_tail(p.dimension, p.radius * p.radius);
  if (p.name == "disc") return disc_probability(p);
  if (p.name == "rp107") return upper(5);
  if (p.name == "rp77") {
    // w <= 5: u - v < w with u - v ~ N(10, sqrt 1.25); w > 5: v > w.
    const double sd = std::sqrt(1.25);
    return integral([&](double w) { return density(w - 4) * upper((10 - w) / sd); }, 4 - kFar, 5) +
           integral([&](double w) { return density(w - 4) * upper(w); }, 5, 4 + kFar);
  }
  if (p.name == "rp110") {
    // first: x1 >= 4, or 0.85 <= 0.1 x1 with x1 <= 3.5, which is never; second: 0.5 <= 0.1 x2 with x2 > 2, or 2.3 <= x2
    // <= 2.
    return any_of_independent({upper(4), upper(5)});
  }
  if (p.name == "rp25") {
    // x2 >= 2 + x1^2/8 and x2 <= 16 x1 - 32
    const double root = 64 - std::sqrt(64 * 64 - 272.0);  // x^2 - 128 x + 272 = 0
    return integral([](double x) { return density(x) * between(2 + x * x / 8, 16 * x - 32); }, root, kFar);
  }
  // four_branch, in s / sqrt 2 and c = d / sqrt 2: |c| >= 3.5, or |s| >= 3 + c^2/5
  return 2 * upper(3.5) + 2 * integral([](double c) { return density(c) * 2 * upper(3 + 0.2 * c * c); }, 0, 3.5);
}

std::vector<HalfSpace> half_spaces_of(const TestProblem& p) {
  std::vector<HalfSpace> all;
  if (p.name == "linear")
    all.push_back({Eigen::VectorXd::Constant(p.dimension, 1 / std::sqrt(p.dimension)), p.beta[0]});
  if (p.name == "union")
    for (std::size_t k = 0; k < p.beta.size(); ++k)
      all.push_back({Eigen::VectorXd::Unit(p.dimension, static_cast<Eigen::Index>(k)), p.beta[k]});
  return all;
}

}  // namespace surveymc::rare
