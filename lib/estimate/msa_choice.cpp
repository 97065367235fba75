#include <algorithm>
#include <utility>

#include "base/units.h"
#include "estimate/msa.h"

namespace surveymc::estimate {
namespace {

/// Processor time of the parts of a solve, relative to a gradient by series, which takes 0.82 ns a station and trial.
/// Measured by surveymc_bench, 53 stations, AVX-512 on a Xeon of 2.7 GHz, the least of seven repetitions; in brackets
/// the same by AVX2. They are constants, and of one instruction set, so that the choice is the same on every machine.
constexpr double kSeries = 1;          // msa_gradient_by_series
constexpr double kExact = 2.3;         // msa_gradient_exact (1.5)
constexpr double kGradient = 2.3;      // msa_evaluation_gradient_only (1.3)
constexpr double kMatrix = 4.6;        // msa_evaluation_with_matrix and msa_factor_and_solve (4.0)
constexpr double kReadingSums = 0.23;  // msa_reading_sums (0.21)
constexpr double kValleySums = 2.4;    // msa_valley_sums (1.9)
constexpr double kCopy = 6.6;          // msa_trials_that_go_on without two gradients and msa_trials_that_begin

/// The normal equations, with what their evaluations cost.
struct CostedEquations {
  const MsaEquations<double>& equations;
  double& cost;
  template <bool WithMatrix>
  MsaNormalEquations<double> operator()(const std::array<double, 6>& x, double second_order) const {
    cost += WithMatrix ? kMatrix : kGradient;
    return equations.operator()<WithMatrix>(x, second_order);
  }
};

double newton_cost(const std::array<double, 6>& start, const MsaData& data, const NewtonOptions& options) {
  double cost = kReadingSums;
  const MsaEquations<double> equations{data, msa_reading_sums<double>(data)};
  newton_minimum<double, 6>(CostedEquations{equations, cost}, start, options);
  return cost;
}

double chord_cost(bool one_reference, double evaluations) {
  const double series = one_reference ? std::min<double>(evaluations, kMsaSeriesSteps) : 0;
  return kSeries * series + kExact * (evaluations - series);
}

/// Trials go side by side, and the slowest of a group holds the others up.
double cost_of_groups(const std::vector<double>& trials) {
  double sum = 0, slowest = 0;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    if (t % simd::kGroup == 0) sum += std::exchange(slowest, 0.0);
    slowest = std::max(slowest, trials[t]);
  }
  return sum + slowest;
}

/// Of what the estimator with this start does with the trials (Msa::solve), both null for unit gains; of some of them,
/// where these cost more than `enough`.
double cost_of(const MsaExpansion* expansion, const MsaValley* valley, const survey::ReadingBlock& in, double total,
               const NewtonOptions& options, double enough) {
  const bool one_reference = in.reference_stride == 0, known = expansion || valley;
  std::vector<double> near, whole;
  const auto cost = [&] { return cost_of_groups(near) + cost_of_groups(whole); };
  for (int t = 0; t < in.trials && cost() <= enough; ++t) {
    const int group = t / simd::kGroup, lane = t % simd::kGroup;
    const MsaData data{in.magnetic.row(group, 0) + lane,
                       in.down.row(group, 0) + lane,
                       in.reference.row(group, 0) + lane,
                       in.stations,
                       in.reference_stride,
                       1 / total};
    std::array<double, 6> start{1, 1, 1, 0, 0, 0};
    if (known) {
      const MsaSolution<double> s = expansion ? msa_solve_near<double>(data, *expansion, options)
                                              : msa_solve_in_valley<double>(data, !in.down.shared(), *valley, options);
      near.push_back(expansion ? chord_cost(one_reference, s.iterations)
                               : kValleySums + chord_cost(one_reference, s.iterations - 1));
      if (s.converged != 0) continue;
      if (valley) start = s.x;
    }
    whole.push_back((known ? kCopy : 0) + newton_cost(start, data, options));
  }
  return cost();
}

}  // namespace

std::unique_ptr<Estimator> make_cheapest_msa(const NewtonOptions& options, const survey::ReferenceField& field,
                                             const std::vector<survey::StationFields>& truth,
                                             const std::vector<survey::Vec3<double>>& expected,
                                             const survey::ReadingBlock& readings) {
  const double groups = readings.groups();
  const bool one_reference = readings.reference_stride == 0;
  const double least_in_valley = kValleySums + chord_cost(one_reference, one_reference ? kMsaSeriesSteps + 1 : 1);
  double least = kInfinity;
  const auto cost = [&](const MsaExpansion* expansion, const MsaValley* valley) {
    return cost_of(expansion, valley, readings, field.total, options, least);
  };
  std::optional<MsaValley> valley;
  std::optional<MsaExpansion> expansion = msa_expansion(truth, expected, field);
  if (expansion) least = cost(&*expansion, nullptr);
  // What is never less than the least so far need not be made.
  if (groups * least_in_valley < least) {
    valley = msa_valley(truth, expected, field);
    const double in_valley = valley ? cost(nullptr, &*valley) : kInfinity;
    if (in_valley < least) {
      least = in_valley;
      expansion.reset();
    } else {
      valley.reset();
    }
  }
  if (groups * (kReadingSums + kMatrix) < least && cost(nullptr, nullptr) < least) {
    expansion.reset();
    valley.reset();
  }
  return make_msa_from(options, field.total, expansion, std::move(valley));
}

}  // namespace surveymc::estimate
