/// Monte-Carlo MSA with Ceres, one trial after the other, on one thread.
///
///   ceres_msa GEOMETRY SOLVER --runs N --seed S     prints one line of JSON
///   ceres_msa GEOMETRY SOLVER --readings FILE       solves given readings (3 x stations numbers in nT a trial, all
///                                                   x, then y, then z) and prints six estimates a line
///
/// SOLVER: normal_cholesky or qr (ceres::Solver, dense), tiny (ceres::TinySolver). GEOMETRY is what
/// `scipy_msa.py --geometry` writes.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>
#include <ceres/tiny_solver.h>
#include <ceres/version.h>
#include <boost/random/normal_distribution.hpp>

namespace {

constexpr int kStations = 53;  // known at compile time: fixed-size matrices, unrolled loops
constexpr int kResiduals = 2 * kStations;
constexpr int kReadings = 3 * kStations;

/// Readings and directions by axis, station contiguous. Fields are in units of the total field.
using Triads = std::array<std::array<double, kStations>, 3>;

struct Geometry {
  Triads clean, down;
  double total, bh, bv, noise;
  double step_tolerance;
};

Geometry read_geometry(const char* path) {
  std::ifstream in(path);
  Geometry g;
  int stations = 0;
  in >> stations >> g.total >> g.bh >> g.bv >> g.noise >> g.step_tolerance;
  if (!in || stations != kStations) {
    std::cerr << path << ": cannot read, or not of " << kStations << " stations\n";
    std::exit(65);
  }
  for (std::size_t k = 0; k < kStations; ++k) {
    for (auto& axis : g.clean) in >> axis[k];
    for (auto& axis : g.down) in >> axis[k];
    for (auto& axis : g.clean) axis[k] /= g.total;
  }
  if (!in) {
    std::cerr << path << ": too short\n";
    std::exit(65);
  }
  g.bh /= g.total;
  g.bv /= g.total;
  g.noise /= g.total;
  return g;
}

/// Residuals of one trial at x = (p, q / total):
///   b = p m - q,  Bv = u.b,  Bh = |b - Bv u|,  r = (Bh - Bh_ref, Bv - Bv_ref)
///   dBh/dp = n m,  dBh/dq = -n,  dBv/dp = u m,  dBv/dq = -u,  n = (b - Bv u) / Bh
/// Row-major (ceres::Solver): the two residuals of a station follow each other. Column-major (TinySolver): all Bh, then
/// all Bv, so that every column is written contiguously. `jacobian` may be null.
template <bool kRowMajor>
void evaluate(const Geometry& g, const Triads& m, const double* x, double* __restrict r, double* __restrict jacobian) {
  const auto row_h = [](std::size_t k) { return kRowMajor ? 2 * k : k; };
  const auto row_v = [](std::size_t k) { return kRowMajor ? 2 * k + 1 : kStations + k; };
  const auto at = [](std::size_t row, std::size_t column) {
    return kRowMajor ? 6 * row + column : column * kResiduals + row;
  };
  const Triads& u = g.down;
  const double px = x[0], py = x[1], pz = x[2], qx = x[3], qy = x[4], qz = x[5];
  for (std::size_t k = 0; k < kStations; ++k) {
    const double bx = px * m[0][k] - qx, by = py * m[1][k] - qy, bz = pz * m[2][k] - qz;
    const double bv = u[0][k] * bx + u[1][k] * by + u[2][k] * bz;
    const double hx = bx - bv * u[0][k], hy = by - bv * u[1][k], hz = bz - bv * u[2][k];
    const double bh = std::sqrt(hx * hx + hy * hy + hz * hz);
    r[row_h(k)] = bh - g.bh;
    r[row_v(k)] = bv - g.bv;
    if (jacobian != nullptr) {
      const double per_bh = 1 / bh;
      const double n[3] = {hx * per_bh, hy * per_bh, hz * per_bh};
      for (std::size_t i = 0; i < 3; ++i) {
        jacobian[at(row_h(k), i)] = n[i] * m[i][k];
        jacobian[at(row_h(k), 3 + i)] = -n[i];
        jacobian[at(row_v(k), i)] = u[i][k] * m[i][k];
        jacobian[at(row_v(k), 3 + i)] = -u[i][k];
      }
    }
  }
}

using Unknowns = std::array<double, 6>;
constexpr Unknowns kStart{1, 1, 1, 0, 0, 0};

struct Solution {
  Unknowns x;
  int evaluations;  ///< calls of the model, with or without Jacobian
  bool converged;
};

/// The peers stop when |dx| <= tolerance |x|, |x| = sqrt(3). With this tolerance no step is demanded that is shorter
/// than max_i |dx_i| <= step_tolerance would demand.
double parameter_tolerance(const Geometry& g) { return std::sqrt(6.0 / 3) * g.step_tolerance; }

class CeresPeer {
 public:
  CeresPeer(const Geometry& g, ceres::LinearSolverType linear_solver) : cost_(g), problem_(problem_options()) {
    problem_.AddResidualBlock(&cost_, nullptr, x_.data());
    options_.linear_solver_type = linear_solver;
    options_.num_threads = 1;
    options_.logging_type = ceres::SILENT;
    options_.minimizer_progress_to_stdout = false;
    options_.parameter_tolerance = parameter_tolerance(g);
    options_.function_tolerance = 0;  // only the step counts
    options_.gradient_tolerance = 0;
    options_.initial_trust_region_radius = 1e12;  // the start is close: Gauss-Newton from the first step on
    options_.max_trust_region_radius = 1e16;
    options_.jacobi_scaling = false;  // the unknowns are of order one
  }

  Solution solve(const Triads& m) {
    cost_.m = &m;
    cost_.evaluations = 0;
    x_ = kStart;
    ceres::Solve(options_, &problem_, &summary_);
    return {x_, cost_.evaluations, summary_.termination_type == ceres::CONVERGENCE};
  }

 private:
  struct Cost final : ceres::SizedCostFunction<kResiduals, 6> {
    explicit Cost(const Geometry& geometry) : g(geometry) {}
    bool Evaluate(const double* const* x, double* r, double** jacobians) const override {
      ++evaluations;
      if (jacobians != nullptr && jacobians[0] != nullptr)
        evaluate<true>(g, *m, x[0], r, jacobians[0]);
      else
        evaluate<true>(g, *m, x[0], r, nullptr);
      return true;
    }
    const Geometry& g;
    const Triads* m = nullptr;
    mutable int evaluations = 0;
  };

  static ceres::Problem::Options problem_options() {
    ceres::Problem::Options o;
    o.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    o.disable_all_safety_checks = true;
    return o;
  }

  Cost cost_;
  Unknowns x_ = kStart;
  ceres::Problem problem_;
  ceres::Solver::Options options_;
  ceres::Solver::Summary summary_;
};

class TinyPeer {
 public:
  explicit TinyPeer(const Geometry& g) : cost_{&g} {
    solver_.options.parameter_tolerance = parameter_tolerance(g);
    solver_.options.function_tolerance = 0;  // only the step counts
    solver_.options.gradient_tolerance = 0;
    solver_.options.cost_threshold = 0;
    solver_.options.initial_trust_region_radius = 1e12;
  }

  Solution solve(const Triads& m) {
    cost_.m = &m;
    cost_.evaluations = 0;
    Solver::Parameters x(kStart.data());
    const bool converged = solver_.Solve(cost_, &x).status == Solver::RELATIVE_STEP_SIZE_TOO_SMALL;
    Solution s{{}, cost_.evaluations, converged};
    std::copy_n(x.data(), 6, s.x.begin());
    return s;
  }

 private:
  struct Cost {
    using Scalar = double;
    enum { NUM_RESIDUALS = kResiduals, NUM_PARAMETERS = 6 };
    bool operator()(const double* x, double* r, double* jacobian) const {
      ++evaluations;
      if (jacobian != nullptr)
        evaluate<false>(*g, *m, x, r, jacobian);
      else
        evaluate<false>(*g, *m, x, r, nullptr);
      return true;
    }
    const Geometry* g;
    const Triads* m = nullptr;
    mutable int evaluations = 0;
  };
  using Solver = ceres::TinySolver<Cost>;

  Cost cost_;
  Solver solver_;
};

/// Gains g = 1 / p and biases q / p in nT.
Unknowns gains_and_biases(const Unknowns& x, double total) {
  return {1 / x[0], 1 / x[1], 1 / x[2], total * x[3] / x[0], total * x[4] / x[1], total * x[5] / x[2]};
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
double cpu_now() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void print_list(const char* name, const Unknowns& values, const char* end) {
  std::printf("\"%s\": [", name);
  for (std::size_t i = 0; i < 6; ++i) std::printf("%s%.17g", i > 0 ? ", " : "", values[i]);
  std::printf("]%s", end);
}

/// Draws, solves, accumulates; prints times and statistics.
template <class Peer>
void monte_carlo(Peer& peer, const std::string& name, const Geometry& g, std::size_t runs, std::uint64_t seed) {
  constexpr std::size_t kBatch = 64;  // trials whose noise is drawn together: they fit the second-level cache
  std::mt19937_64 engine(seed);
  boost::random::normal_distribution<double> normal(0, g.noise);  // ziggurat; std:: has the slower polar method
  std::vector<Triads> readings(kBatch);
  std::vector<Unknowns> estimates;
  estimates.reserve(runs);
  std::uint64_t evaluations = 0;
  double noise_seconds = 0;
  const double start = now(), cpu_start = cpu_now();
  for (std::size_t first = 0; first < runs; first += kBatch) {
    const std::size_t count = std::min(kBatch, runs - first);
    const double before = now();
    for (std::size_t t = 0; t < count; ++t)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < kStations; ++k) readings[t][i][k] = g.clean[i][k] + normal(engine);
    noise_seconds += now() - before;
    for (std::size_t t = 0; t < count; ++t) {
      const Solution s = peer.solve(readings[t]);
      evaluations += static_cast<std::uint64_t>(s.evaluations);
      if (s.converged) estimates.push_back(gains_and_biases(s.x, g.total));
    }
  }
  const double n = static_cast<double>(estimates.size());
  Unknowns mean{}, sd{}, kurtosis{};
  for (std::size_t i = 0; i < 6; ++i) {
    double square = 0, fourth = 0;
    for (const Unknowns& e : estimates) mean[i] += e[i] / n;
    for (const Unknowns& e : estimates) square += (e[i] - mean[i]) * (e[i] - mean[i]);
    for (const Unknowns& e : estimates) fourth += std::pow(e[i] - mean[i], 4);
    sd[i] = std::sqrt(square / (n - 1));
    kurtosis[i] = fourth * n / (square * square);
  }
  const double seconds = now() - start, cpu_seconds = cpu_now() - cpu_start;
  std::printf("{\"peer\": \"%s\", \"runs\": %zu, \"seconds\": %.9g, \"cpu_seconds\": %.9g, \"noise_seconds\": %.9g, ",
              name.c_str(), runs, seconds, cpu_seconds, noise_seconds);
  std::printf("\"version\": \"Ceres %s\", ", CERES_VERSION_STRING);
  std::printf("\"failed\": %zu, \"evaluations\": %.9g, ", runs - estimates.size(),
              static_cast<double>(evaluations) / static_cast<double>(runs));
  print_list("mean", mean, ", ");
  print_list("sd", sd, ", ");
  print_list("kurtosis", kurtosis, "}\n");
}

template <class Peer>
void solve_given(Peer& peer, const Geometry& g, const char* path) {
  std::ifstream in(path);
  if (!in) {
    std::cerr << path << ": cannot read\n";
    std::exit(65);
  }
  Triads m;
  while (true) {
    int count = 0;
    for (auto& axis : m)
      for (double& v : axis)
        if (in >> v) {
          v /= g.total;
          ++count;
        }
    if (count < kReadings) return;
    const Solution s = peer.solve(m);
    const Unknowns e = gains_and_biases(s.x, g.total);
    for (std::size_t i = 0; i < 6; ++i) std::printf("%.17g%s", s.converged ? e[i] : std::nan(""), i < 5 ? " " : "\n");
  }
}

[[noreturn]] void usage() {
  std::cerr << "usage: ceres_msa GEOMETRY normal_cholesky|qr|tiny (--runs N --seed S | --readings FILE)\n";
  std::exit(64);
}

template <class Peer>
int run(Peer peer, const Geometry& g, int argc, char** argv) {
  std::size_t runs = 20000;
  std::uint64_t seed = 1;
  for (int i = 3; i + 1 < argc; i += 2) {
    const std::string key = argv[i];
    if (key == "--readings") {
      solve_given(peer, g, argv[i + 1]);
      return 0;
    }
    if (key == "--runs")
      runs = std::strtoull(argv[i + 1], nullptr, 10);
    else if (key == "--seed")
      seed = std::strtoull(argv[i + 1], nullptr, 10);
    else
      usage();
  }
  if (runs < 2) usage();
  monte_carlo(peer, argv[2], g, runs, seed);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc % 2 == 0) usage();
  const Geometry g = read_geometry(argv[1]);
  const std::string solver = argv[2];
  if (solver == "tiny") return run(TinyPeer(g), g, argc, argv);
  // Ceres' problem keeps the address of the unknowns: built in place, not copied.
  struct InPlace {
    std::unique_ptr<CeresPeer> peer;
    Solution solve(const Triads& m) { return peer->solve(m); }
  };
  if (solver == "normal_cholesky")
    return run(InPlace{std::make_unique<CeresPeer>(g, ceres::DENSE_NORMAL_CHOLESKY)}, g, argc, argv);
  if (solver == "qr") return run(InPlace{std::make_unique<CeresPeer>(g, ceres::DENSE_QR)}, g, argc, argv);
  usage();
}
