#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>

#include "base/error.h"
#include "base/units.h"
#include "multistation/robust.h"
#include "multistation/subsets.h"
#include "multistation/variance_components.h"

using namespace surveymc;
using namespace surveymc::multistation;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr std::array<Loss, 5> kLosses{Loss::least_squares, Loss::l1, Loss::huber, Loss::cauchy, Loss::tukey};

/// A linear model y = J x + noise, stations of two or three components.
struct Linear {
  int stations, components, parameters;
  Eigen::MatrixXd j;
  Eigen::VectorXd y;

  Linear(int stations_, int components_, int parameters_, unsigned seed)
      : stations(stations_),
        components(components_),
        parameters(parameters_),
        j(stations * components, parameters),
        y(stations * components) {
    std::mt19937 bits(seed);
    std::normal_distribution<double> normal;
    for (double& v : j.reshaped()) v = normal(bits);
    for (double& v : y.reshaped()) v = normal(bits);
  }
  void operator()(const double* x, double* residual, double* jacobian, bool) const {
    Eigen::Map<Eigen::VectorXd>(residual, y.size()) = j * Eigen::Map<const Eigen::VectorXd>(x, parameters) - y;
    for (Eigen::Index i = 0; i < j.rows(); ++i)
      for (Eigen::Index a = 0; a < parameters; ++a) jacobian[i * parameters + a] = j(i, a);
  }
};

struct Fitted {
  Eigen::VectorXd x, weights, residuals;
  RobustOutcome<double> outcome;
};

Fitted fit(const Linear& m, RobustOptions options, std::uint64_t group = 0) {
  const std::vector<double> unit(static_cast<std::size_t>(m.parameters), 1.0);
  RobustProblem p;
  p.shape = {m.stations, m.components, m.parameters};
  p.unit = unit.data();
  p.scale_of_median = scale_of_median(m.components);
  p.subset_size = subset_size(m.parameters, m.stations);
  p.subset_count = kSubsets;
  const std::vector<int> subsets = draw_subsets(random::Stream(7, 52), group, m.stations, p.subset_size);
  p.subsets = subsets.data();
  std::vector<double> memory(RobustMemory<double>::size(p.shape)), start(static_cast<std::size_t>(m.parameters));
  Fitted f;
  f.outcome = m.components == 2 ? reweight<double, 2>(p, options, m, start.data(), memory.data())
                                : reweight<double, 3>(p, options, m, start.data(), memory.data());
  const RobustMemory<double> at(memory.data(), p.shape);
  f.x = Eigen::Map<Eigen::VectorXd>(at.x, m.parameters);
  f.weights = Eigen::Map<Eigen::VectorXd>(at.weight, m.stations);
  f.residuals = Eigen::Map<Eigen::VectorXd>(at.residual, m.stations * m.components);
  return f;
}

}  // namespace

TEST_CASE("Weights fall from one, and meet where a loss has a corner") {
  for (const Loss loss : kLosses) {
    double last = station_weight<double>(loss, 0);
    CHECK_THAT(last, WithinRel(loss == Loss::l1 ? 1 / kL1Floor : 1.0, 1e-15));
    for (double t = 0.01; t < 20; t += 0.01) {
      const double w = station_weight<double>(loss, t * t);
      CHECK(w <= last);
      CHECK(w >= 0);
      last = w;
    }
  }
  CHECK_THAT(station_weight<double>(Loss::l1, 16), WithinRel(0.25, 1e-15));
  CHECK_THAT(station_weight<double>(Loss::huber, 3.4 * 3.4), WithinRel(0.5, 1e-15));
  CHECK_THAT(station_weight<double>(Loss::cauchy, 2.6 * 2.6), WithinRel(0.5, 1e-15));
  CHECK_THAT(station_weight<double>(Loss::tukey, 4.7 * 4.7 / 2), WithinRel(0.25, 1e-14));
  CHECK(station_weight<double>(Loss::tukey, 4.7 * 4.7 * 1.0001) == 0);
}

TEST_CASE("The cost of the sum of lengths is known in closed form") {
  // Without its floor l1 has E[w t]^2 = 1 and E[w + w' t / d] = (d - 1) / d E[1 / t]: v = 4 / pi of two components,
  // 3 pi / 8 of three. The floor of 0.05 changes it by about the chance of a residual below it, 0.00125.
  CHECK_THAT(loss_cost(Loss::l1, 2).variance, WithinRel(4 / kPi, 0.0025));
  CHECK_THAT(loss_cost(Loss::l1, 3).variance, WithinRel(3 * kPi / 8, 1e-4));
  // Huber's of two components, with c = 1.7: E[psi^2] = 2 (1 - exp(-c^2/2)), and
  // E[w + w' t / 2] = 1 - exp(-c^2/2) + c/2 int_c exp(-t^2/2) dt.
  const double c = kHuber, e = std::exp(-c * c / 2), tail = std::sqrt(kPi / 2) * std::erfc(c / std::sqrt(2.0));
  const double huber = (1 - e) / std::pow(1 - e + c / 2 * tail, 2);
  CHECK_THAT(loss_cost(Loss::huber, 2).variance, WithinRel(huber, 1e-6));
  // And what a station weighs against priors: E[w + w' t / d].
  CHECK_THAT(loss_cost(Loss::huber, 2).slope, WithinRel(1 - e + c / 2 * tail, 1e-6));
  CHECK_THAT(loss_cost(Loss::l1, 2).slope, WithinRel(std::sqrt(kPi / 2) / 2, 0.0025));  // E[1 / t] / 2
  for (const int d : {1, 2, 3})
    for (const Loss loss : kLosses) {
      CHECK(loss_cost(loss, d).variance >= 1);  // nothing beats least squares where noise is normal
      if (loss != Loss::l1) CHECK(loss_cost(loss, d).variance < 1.13);
    }
}

TEST_CASE("The median length is that of a chi distribution") {
  // P(t < median) = 1/2: erf(m / sqrt 2), 1 - exp(-m^2/2), erf(m / sqrt 2) - sqrt(2 / pi) m exp(-m^2/2).
  const double one = scale_of_median(1), two = scale_of_median(2), three = scale_of_median(3);
  CHECK_THAT(std::erf(one / std::sqrt(2.0)), WithinAbs(0.5, 1e-15));
  CHECK_THAT(1 - std::exp(-two * two / 2), WithinAbs(0.5, 1e-15));
  CHECK_THAT(std::erf(three / std::sqrt(2.0)) - std::sqrt(2 / kPi) * three * std::exp(-three * three / 2),
             WithinAbs(0.5, 1e-15));
}

TEST_CASE("Batcher's exchanges sort everything that has zeros and ones") {
  // The 0-1 principle: then they sort all values.
  for (int n = 1; n <= 13; ++n)
    for (unsigned pattern = 0; pattern < 1u << n; ++pattern) {
      std::vector<double> x;
      for (int i = 0; i < n; ++i) x.push_back((pattern >> i) & 1u);
      sort_lanes(x.data(), n);
      REQUIRE(std::is_sorted(x.begin(), x.end()));
    }
  std::vector<double> even{4, 1, 3, 2}, odd{5, 1, 9};
  CHECK(median_of(even.data(), 4) == 2.5);
  CHECK(median_of(odd.data(), 3) == 5);
}

TEST_CASE("A fit that ends at its most reweightings, while steps are large, has not converged") {
  Linear m(30, 2, 6, 11);
  m.y.head(12) *= 40;
  for (const Loss loss : {Loss::l1, Loss::huber, Loss::cauchy, Loss::tukey}) {
    RobustOptions o = robust_options(loss);
    o.reweightings = 2;
    CHECK(fit(m, o).outcome.converged == 0);
    o.reweightings = 1000;
    CHECK(fit(m, o).outcome.converged == 1);
  }
}

TEST_CASE("Without a loss the fit is that of the normal equations") {
  for (const int components : {2, 3}) {
    const Linear m(20, components, 6, 3);
    const Fitted f = fit(m, robust_options(Loss::least_squares));
    const Eigen::VectorXd exact = (m.j.transpose() * m.j).ldlt().solve(m.j.transpose() * m.y);
    CHECK(f.outcome.converged == 1);
    CHECK((f.x - exact).norm() < 1e-12 * exact.norm());
    CHECK(f.weights == Eigen::VectorXd::Ones(20));
  }
}

TEST_CASE("A robust fit is a fixed point: the weighted residuals have no gradient, and the weights are theirs") {
  for (const int components : {2, 3})
    for (const Loss loss : {Loss::huber, Loss::cauchy, Loss::tukey}) {
      Linear m(30, components, 6, 11);
      m.y.head(6 * components) *= 40;  // six stations in error
      RobustOptions o = robust_options(loss);
      o.reweightings = 1000;
      o.tolerance = 1e-13;
      const Fitted f = fit(m, o);
      REQUIRE(f.outcome.converged == 1);
      Eigen::VectorXd gradient = Eigen::VectorXd::Zero(6), lengths(30);
      for (int k = 0; k < 30; ++k) {
        const auto r = f.residuals.segment(k * components, components);
        lengths[k] = r.norm();
        CHECK_THAT(f.weights[k],
                   WithinAbs(station_weight<double>(loss, std::pow(r.norm() / f.outcome.scale, 2)), 1e-9));
        gradient += f.weights[k] * m.j.middleRows(k * components, components).transpose() * r;
      }
      CHECK(gradient.norm() < 1e-8);
      if (o.scale == RobustScale::reweighted) {
        std::sort(lengths.begin(), lengths.end());
        CHECK_THAT(f.outcome.scale, WithinRel((lengths[14] + lengths[15]) / 2 / scale_of_median(components), 1e-9));
      }
    }
}

TEST_CASE("The unit of the residuals does not matter to a scale that is taken from them") {
  for (const Loss loss : kLosses) {
    Linear m(25, 2, 3, 5), large = m;
    m.y.head(8) *= 30;
    large.y = 1024 * m.y;
    RobustOptions o = robust_options(loss);
    o.tolerance = 1e-6;
    CHECK((fit(large, o).x - 1024 * fit(m, o).x).norm() < 1e-4 * fit(large, o).x.norm());
  }
}

TEST_CASE("LMedS and Tukey give the fit of the right stations where 45 % are wrong; least squares does not") {
  double robust = 0, plain = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    Linear m(40, 2, 3, 100 + seed);
    Linear right = m;
    for (int i = 0; i < 36; ++i) m.y[i] += 1000;  // all alike: the worst there is
    const int n = 2 * 22;
    const Eigen::MatrixXd j = right.j.bottomRows(n);
    const Eigen::VectorXd exact = (j.transpose() * j).ldlt().solve(j.transpose() * right.y.tail(n));
    robust = std::max(robust, (fit(m, robust_options(Loss::tukey), seed).x - exact).norm());
    plain = std::max(plain, (fit(m, robust_options(Loss::least_squares)).x - exact).norm());
  }
  CHECK(robust < 1);  // noise of 1 over 44 observations: an sd of 0.15 a parameter
  CHECK(plain > 100);
}

namespace {

/// Readings of 21 stations in all directions by a tool with biases 120, -60, 90 nT; the first `wrong` are in error by
/// some 1500 nT.
std::vector<StationReadings> readings_with_errors(int wrong, unsigned seed) {
  std::mt19937 bits(seed);
  std::normal_distribution<double> normal;
  const double gravity = 9.81, bh = 20000, bv = 45000;
  std::vector<StationReadings> all;
  for (int k = 0; k < 21; ++k) {
    Eigen::Vector3d u(normal(bits), normal(bits), normal(bits)), h(normal(bits), normal(bits), normal(bits));
    u.normalize();
    h = (h - h.dot(u) * u).normalized();
    Eigen::Vector3d m = bh * h + bv * u + Eigen::Vector3d(120, -60, 90);
    for (int i = 0; i < 3; ++i) m[i] += 60 * normal(bits) + (k < wrong ? 1500 * normal(bits) : 0);
    all.push_back({survey::from_eigen(gravity * u), survey::from_eigen(m), {gravity, bh, bv}});
  }
  return all;
}

void put(const std::vector<StationReadings>& run, int lane, SixAxisBlock& block) {
  const SixAxisBlock one = block_of(run);
  for (int r = 0; r < 3 * one.stations; ++r) {
    block.gravity.row(0, r)[lane] = one.gravity.row(0, r)[0];
    block.magnetic.row(0, r)[lane] = one.magnetic.row(0, r)[0];
    block.reference.row(0, r)[lane] = one.reference.row(0, r)[0];
  }
}

FitOptions options_of_set(const std::string& set) {
  FitOptions o;
  o.parameters = set == "3" ? ParameterSet::of({"mbx", "mby", "mbz"}) : ParameterSet::named(set);
  if (set == "3") o.prior_sd.fill(std::numeric_limits<double>::infinity());
  return o;
}

}  // namespace

TEST_CASE("A trial's robust fit does not depend on the trials beside it, and finds the tool") {
  for (const std::string set : {"3", "6", "12", "18"})
    for (const Loss loss : kLosses) {
      const FitOptions o = options_of_set(set);
      const FitPlan plan = fit_plan(o);
      const random::Stream stream(3, 52);
      SixAxisBlock mixed(8, 21, true);
      for (int lane = 0; lane < 8; ++lane) put(readings_with_errors(6, static_cast<unsigned>(lane)), lane, mixed);
      FitBlock a(8, o), b(8, o);
      RobustBlock of_a(8, 21), of_b(8, 21);
      robust_fit_block(mixed, plan, o.parameters, robust_options(loss), stream, 16, a, of_a);
      for (int lane = 0; lane < 8; ++lane) {
        CHECK(a.converged.value(lane, 0) == 1);
        SixAxisBlock alike(8, 21, true);
        for (int other = 0; other < 8; ++other) put(readings_with_errors(6, static_cast<unsigned>(lane)), other, alike);
        robust_fit_block(alike, plan, o.parameters, robust_options(loss), stream, 16, b, of_b);
        for (int i = 0; i < o.parameters.size(); ++i) CHECK(a.estimate.value(lane, i) == b.estimate.value(lane, i));
        for (int k = 0; k < 21; ++k) CHECK(of_a.weights.value(lane, k) == of_b.weights.value(lane, k));
        // What a robust fit is for. A bias has an sd of some 25 nT without errors.
        if (set == "3" && loss != Loss::least_squares)
          for (int i = 0; i < 3; ++i)
            CHECK_THAT(a.estimate.value(lane, i),
                       WithinAbs(std::array<double, 3>{120, -60, 90}[static_cast<std::size_t>(i)], 200));
      }
    }
}

TEST_CASE("One run's robust fit is least squares with its weights, and its covariance that of the loss") {
  const std::vector<StationReadings> run = readings_with_errors(4, 77);
  const random::Stream stream(3, 52);
  for (const std::string set : {"3", "6", "12"})
    for (const Loss loss : kLosses) {
      const FitOptions o = options_of_set(set);
      RobustOptions robust = robust_options(loss);
      robust.reweightings = 500;
      robust.tolerance = 1e-10;
      const RobustFit r = robust_fit(run, o, robust, stream);
      CHECK((r.fit.estimate - fit(run, o, r.weights).estimate).norm() <= 1e-12 * r.fit.estimate.norm());
      const int components = set == "12" ? 3 : 2;
      const LossCost cost = loss_cost(loss, components);
      std::vector<double> information;
      for (const double w : r.weights) information.push_back(cost.slope / cost.mean_trust * std::min(w, 1.0));
      const Fit plain = fit(run, o, information);
      const double factor = cost.variance * cost.slope;
      if (set == "3") CHECK((r.fit.posterior - factor * plain.posterior).norm() < 1e-9 * plain.posterior.norm());
      // With priors the covariance lies between theirs and that of no prior.
      for (int i = 0; i < o.parameters.size(); ++i) {
        const double ratio = r.fit.posterior(i, i) / plain.posterior(i, i);
        CHECK(ratio <= std::max(1.0, factor) + 1e-9);
        CHECK(ratio >= std::min(1.0, factor) - 1e-9);
      }
      for (int k = 0; k < 21; ++k) {
        const double t2 = r.fit.residuals.col(k).tail(components).squaredNorm() / (r.scale * r.scale);
        if (loss != Loss::l1)  // whose weights converge too slowly to be compared
          CHECK_THAT(r.weights[static_cast<std::size_t>(k)], WithinAbs(station_weight<double>(loss, t2), 1e-4));
        if (k < 4 && (loss == Loss::cauchy || loss == Loss::tukey)) CHECK(r.weights[static_cast<std::size_t>(k)] < 0.3);
      }
    }
}

TEST_CASE("What a loss costs is a share of what stations say, not of priors of tool or reference") {
  const std::vector<StationReadings> run = readings_with_errors(2, 3);
  FitOptions o = options_of_set("9");
  o.estimates_reference = true;
  o.reference = {0, 300, 0.003};  // gravity is taken as exact
  for (const Loss loss : {Loss::huber, Loss::l1}) {
    const RobustFit r = robust_fit(run, o, robust_options(loss), random::Stream(3, 52));
    const Eigen::MatrixXd& joint = r.fit.joint;
    REQUIRE(joint.rows() == 12);
    CHECK(joint.row(9).norm() == 0);
    std::vector<int> moves(12);
    std::iota(moves.begin(), moves.end(), 0);
    moves.erase(moves.begin() + 9);
    Eigen::VectorXd precision(11), unit(11);
    for (int i = 0; i < 9; ++i)
      precision[i] = std::pow(o.prior_sd[static_cast<std::size_t>(o.parameters.index(i))], -2);
    precision.tail(2) << std::pow(300, -2), std::pow(0.003, -2);
    unit = precision.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd inverse = unit.cwiseInverse().asDiagonal() * r.fit.inverse(moves, moves) *
                                    unit.cwiseInverse().asDiagonal(),
                          normal = inverse.inverse(), one = Eigen::MatrixXd::Identity(11, 11);
    const Eigen::MatrixXd expected = inverse * (r.factor * (normal - one) + one) * inverse;
    const Eigen::MatrixXd found =
        unit.cwiseInverse().asDiagonal() * joint(moves, moves) * unit.cwiseInverse().asDiagonal();
    CHECK((found - expected).norm() < 1e-8);
    CHECK((joint - r.fit.inverse).norm() > 0.01 * joint.norm());
    CHECK((r.fit.posterior - joint.topLeftCorner(9, 9)).norm() == 0);
    CHECK_THAT(r.fit.reference_sd.total, WithinRel(std::sqrt(joint(10, 10)), 1e-14));
  }
}

TEST_CASE("Robust fits of an instrument begin near enough, where its biases are as large as the field") {
  // From zero, whole steps of Gauss and Newton do not get there.
  std::mt19937 bits(24);
  std::normal_distribution<double> normal;
  FitOptions o;
  o.parameters = ParameterSet::named("18");
  o.prior_sd.fill(std::numeric_limits<double>::infinity());
  o.residuals = ResidualKind::calibration;
  o.estimates_reference = true;
  o.reference.dip = std::numeric_limits<double>::infinity();
  o.sizes = {0.02, 200, 0.004};
  const double gravity = 9.81, total = 49000, sine = 0.9;
  const Eigen::Vector3d bias(25000, -30000, 20000);
  std::vector<StationReadings> shots;
  for (int k = 0; k < 40; ++k) {
    Eigen::Vector3d u(normal(bits), normal(bits), normal(bits)), h(normal(bits), normal(bits), normal(bits));
    u.normalize();
    h = (h - h.dot(u) * u).normalized();
    Eigen::Vector3d m = total * (std::sqrt(1 - sine * sine) * h + sine * u) + bias, g = gravity * u;
    for (int i = 0; i < 3; ++i) {
      m[i] += 100 * normal(bits) + (k < 3 ? 5000 * normal(bits) : 0);
      g[i] += 0.01 * normal(bits);
    }
    shots.push_back({survey::from_eigen(g), survey::from_eigen(m), {gravity, total, sine}});
  }
  o.total = total;
  o.dip = std::asin(sine);
  for (const Loss loss : {Loss::l1, Loss::huber, Loss::cauchy, Loss::tukey}) {
    RobustOptions robust = robust_options(loss);
    robust.reweightings = 200;
    robust.newton_steps = 100;
    const RobustFit r = robust_fit(shots, o, robust, random::Stream(3, 52));
    for (int i = 0; i < 3; ++i) {
      // 111 observations of 100 nT for 18 unknowns: an sd of some 50 nT a bias.
      CHECK_THAT(r.fit.tool[static_cast<std::size_t>(kMagnetometerBias + i)], WithinAbs(bias[i], 300));
      if (loss == Loss::cauchy || loss == Loss::tukey) CHECK(r.weights[static_cast<std::size_t>(i)] < 0.3);
    }
  }
}

TEST_CASE("A fit with the weights of a loss that does not converge is no answer") {
  FitOptions o = options_of_set("6");
  o.max_iterations = 1;
  CHECK_THROWS_AS(robust_fit(readings_with_errors(2, 3), o, robust_options(Loss::huber), random::Stream(3, 52)),
                  InputError);
}

TEST_CASE("A fit that knows the wrong stations is that of the others") {
  const std::vector<StationReadings> run = readings_with_errors(5, 5);
  const FitOptions o = options_of_set("6");
  SixAxisBlock block(8, 21, true);
  survey::LaneArray given(1, 21);
  for (int lane = 0; lane < 8; ++lane) put(run, lane, block);
  for (int k = 0; k < 21; ++k) given.fill(0, k, k < 5 ? 0 : 1);
  FitBlock found(8, o);
  RobustBlock robust(8, 21);
  RobustOptions options = robust_options(Loss::least_squares);
  options.tolerance = 1e-6;
  robust_fit_block(block, fit_plan(o), o.parameters, options, random::Stream(3, 52), 0, found, robust, &given);
  const Fit others = fit({run.begin() + 5, run.end()}, o);
  // Steps within 0.03 priors are linear: what they leave out is some 1e-6 of a prior.
  for (int i = 0; i < 6; ++i) {
    const double prior = o.prior_sd[static_cast<std::size_t>(o.parameters.index(i))];
    CHECK_THAT(found.estimate.value(3, i), WithinAbs(others.estimate[i], 5e-6 * prior));
  }
}

TEST_CASE("The variance component of a single group is e'Pe over redundancy, exactly") {
  const Linear m(15, 2, 4, 9);
  const Eigen::VectorXd x = (m.j.transpose() * m.j).ldlt().solve(m.j.transpose() * m.y), e = m.j * x - m.y;
  const VarianceComponents v = variance_components(std::vector<int>(30, 0), 1, [&](const std::vector<double>& factors) {
    return GroupedFit{e, m.j, Eigen::VectorXd::Ones(30), factors[0] * (m.j.transpose() * m.j).inverse()};
  });
  CHECK(v.converged);
  CHECK_THAT(v.groups[0].redundancy, WithinAbs(26, 1e-10));
  CHECK_THAT(v.groups[0].factor, WithinRel(e.squaredNorm() / 26, 1e-12));
}

TEST_CASE("Variance components of three groups come back, and one of too few observations keeps its own") {
  // Factors 4, 1, 0.25; over 400 runs the mean lies within four standard errors. The last group has two observations.
  const std::array<double, 4> sd{2, 1, 0.5, 3};
  std::array<double, 3> sum{}, squares{};
  const int runs = 400, n = 60;
  std::vector<int> group;
  for (int i = 0; i < n; ++i) group.push_back(i < 2 ? 3 : i % 3);
  for (int run = 0; run < runs; ++run) {
    Linear m(30, 2, 5, 1000 + static_cast<unsigned>(run));
    for (int i = 0; i < n; ++i) m.y[i] *= sd[static_cast<std::size_t>(group[static_cast<std::size_t>(i)])];
    const VarianceComponents v = variance_components(group, 4, [&](const std::vector<double>& factors) {
      Eigen::VectorXd w(n);
      for (int i = 0; i < n; ++i) w[i] = 1 / factors[static_cast<std::size_t>(group[static_cast<std::size_t>(i)])];
      const Eigen::MatrixXd inverse = (m.j.transpose() * w.asDiagonal() * m.j).inverse();
      const Eigen::VectorXd x = inverse * (m.j.transpose() * w.asDiagonal() * m.y);
      return GroupedFit{m.j * x - m.y, m.j, Eigen::VectorXd::Ones(n), inverse};
    });
    CHECK(v.converged);
    CHECK_FALSE(v.groups[3].estimated);
    CHECK(v.groups[3].factor == 1);
    double redundancy = 0;
    for (std::size_t g = 0; g < 4; ++g) redundancy += v.groups[g].redundancy;
    CHECK_THAT(redundancy, WithinAbs(n - 5, 1e-9));
    for (std::size_t g = 0; g < 3; ++g) {
      sum[g] += v.groups[g].factor;
      squares[g] += v.groups[g].factor * v.groups[g].factor;
    }
  }
  for (std::size_t g = 0; g < 3; ++g) {
    const double mean = sum[g] / runs, error = std::sqrt((squares[g] / runs - mean * mean) / runs);
    CHECK_THAT(mean, WithinAbs(sd[g] * sd[g], 4 * error));
  }
}
