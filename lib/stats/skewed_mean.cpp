#include "stats/skewed_mean.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace surveymc::stats {
namespace {

constexpr std::size_t kResamples = 1999, kFewest = 5, kMost = 400;

struct MeanAndVariance {
  double mean = 0, variance = 0;
};

/// Of n values, the i-th of which is value(i); exact where all are alike.
template <class Value>
MeanAndVariance moments_of(std::size_t n, const Value& value) {
  MeanAndVariance m;
  for (std::size_t i = 0; i < n; ++i) m.mean += (value(i) - value(0)) / static_cast<double>(n);
  m.mean += value(0);
  for (std::size_t i = 0; i < n; ++i) m.variance += (value(i) - m.mean) * (value(i) - m.mean);
  m.variance /= static_cast<double>(n - 1);
  return m;
}

/// (mean* - mean) / sd* of resamples, sorted; without those that hardly vary. The numbers of the engine are those of
/// the C++ standard, the same everywhere.
std::vector<double> studentised(const std::vector<double>& x, const MeanAndVariance& m) {
  std::mt19937_64 engine(1993);
  std::vector<double> resample(x.size()), t;
  t.reserve(kResamples);
  for (std::size_t b = 0; b < kResamples; ++b) {
    for (double& v : resample) v = x[static_cast<std::size_t>(((engine() >> 32) * x.size()) >> 32)];
    const MeanAndVariance r = moments_of(x.size(), [&](std::size_t i) { return resample[i]; });
    if (r.variance > 1e-12 * m.variance) t.push_back((r.mean - m.mean) / std::sqrt(r.variance));
  }
  std::sort(t.begin(), t.end());
  return t;
}

}  // namespace

Interval skewed_mean_interval(const std::vector<double>& x, double confidence) {
  const MeanAndVariance m = moments_of(x.size(), [&](std::size_t i) { return x[i]; });
  const Interval student = student_mean_interval(m.mean, m.variance, x.size(), confidence);
  if (x.size() < kFewest || x.size() > kMost || !(m.variance > 0)) return student;
  const std::vector<double> t = studentised(x, m);
  if (t.empty()) return student;
  const double tail = (1 - confidence) / 2 * static_cast<double>(t.size() + 1);
  const std::size_t from_end = std::max<std::size_t>(static_cast<std::size_t>(tail), 1) - 1;
  const double sd = std::sqrt(m.variance);
  return {std::min(student.lo, m.mean - t[t.size() - 1 - from_end] * sd),
          std::max(student.hi, m.mean - t[from_end] * sd)};
}

}  // namespace surveymc::stats
