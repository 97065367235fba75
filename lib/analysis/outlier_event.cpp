#include "analysis/outlier_event.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "chained/block_solver.h"
#include "stats/normal_tail.h"

namespace surveymc::analysis {

void OutlierDeletedWrong::evaluate(const survey::LaneArray& z, int groups, double* g) const {
  const int n = stations(), noise = 4 * state_calls(), toolface = noise + 4 * noise_calls();
  const auto wrong = static_cast<std::size_t>(wrong_.station);
  for (int t = 0; t < groups * simd::kGroup; ++t) {
    sensor::ChainedDraws draws;
    for (int k = 0; k < n; ++k) {
      std::array<double, 9> steps;
      std::array<double, 6> errors;
      for (int i = 0; i < 9; ++i) steps[static_cast<std::size_t>(i)] = z.value(t, 9 * k + i);
      for (int i = 0; i < 6; ++i) errors[static_cast<std::size_t>(i)] = z.value(t, noise + 6 * k + i);
      draws.steps.push_back(steps);
      draws.noise.push_back(errors);
      if (truth_.random_toolface) draws.toolface.push_back(stats::normal_upper_tail(-z.value(t, toolface + k)));
    }
    chained::Readings y{sensor::chained_run_of(truth_, draws).readings, {}};
    y.y[wrong][wrong_.axis] += wrong_.size;
    const chained::Solution solution = chained::solve_blocks(model_, y);
    if (!solution.converged) {
      g[t] = kNaN;
      continue;
    }
    const chained::ReadingTests tests = chained::reading_tests(model_, y, solution);
    // The largest of the readings that are right, and the second of its station.
    double largest = 0, second = 0;
    std::size_t station = 0, axis = 0;
    for (std::size_t k = 0; k < tests.w.size(); ++k)
      for (std::size_t i = 0; i < 6; ++i)
        if (std::abs(tests.w[k][i]) > largest && !(k == wrong && i == wrong_.axis)) {
          largest = std::abs(tests.w[k][i]);
          station = k;
          axis = i;
        }
    for (std::size_t i = 0; i < 6; ++i)
      if (i != axis) second = std::fmax(second, std::abs(tests.w[station][i]));
    const double own = std::abs(tests.w[wrong][wrong_.axis]),
                 dominance = gate_.dominance - largest * largest + second * second;
    const chained::Suspect suspect = chained::find_suspect(tests, gate_);
    const bool is_deleted = suspect.dominant && !(suspect.station == wrong_.station && suspect.axis == wrong_.axis);
    const double distance = std::max({own - largest, gate_.gate - largest, dominance / (2 * std::max(1.0, largest))});
    constexpr double kOutside = 1e-9;
    g[t] = is_deleted ? std::min(distance, 0.0) : std::max(distance, kOutside);
  }
}

rare::TrialAddresses OutlierDeletedWrong::addresses(random::Channel choice) const {
  rare::TrialAddresses from{{}, choice};
  const auto add = [&from](random::Channel channel, int calls) {
    for (std::uint32_t c = 0; c < static_cast<std::uint32_t>(calls); ++c) from.calls.push_back({channel, c});
  };
  add(random::Channel::chained_state, state_calls());
  add(random::Channel::chained_noise, noise_calls());
  add(random::Channel::chained_toolface, toolface_calls());
  return from;
}

std::vector<std::string> OutlierDeletedWrong::names() const {
  std::vector<std::string> names(static_cast<std::size_t>(dimension()));
  const auto set = [&names](int first, int count, const char* name) {
    std::fill_n(names.begin() + first, count, name);
  };
  const char* const readings[]{"noise_ax", "noise_ay", "noise_az", "noise_hx", "noise_hy", "noise_hz"};
  const char* const states[]{"gravity",   "horizontal_field", "down_field", "offset_ax", "offset_ay",
                             "offset_az", "offset_hx",        "offset_hy",  "offset_hz"};
  for (int k = 0; k < stations(); ++k) {
    for (int i = 0; i < 9; ++i) set(9 * k + i, 1, states[i]);
    for (int i = 0; i < 6; ++i) set(4 * state_calls() + 6 * k + i, 1, readings[i]);
  }
  if (truth_.random_toolface) set(4 * (state_calls() + noise_calls()), stations(), "toolface");
  return names;
}

}  // namespace surveymc::analysis
