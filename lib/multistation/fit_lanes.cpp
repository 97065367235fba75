#include "multistation/fit_lanes.h"

namespace surveymc::multistation::SURVEYMC_ISA {

using namespace simd;
using simd::store;

namespace {

using T = Lanes;

/// All unknowns in their units, from the estimates of a batch.
Correction<T> correction_at(const FitBatch& b, std::size_t group, std::size_t lane) {
  std::array<T, kUnknowns> value;
  for (T& v : value) v = T(0.0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(b.parameters); ++i) {
    const auto place = static_cast<std::size_t>(b.places[i]);
    value[static_cast<std::size_t>(b.plan->kinds[place / 3]) + place % 3] =
        load<T>(b.estimate + group * b.estimate_stride + i * kGroup + lane);
  }
  for (std::size_t i = 0; i < 3; ++i)
    value[kReferenceKind + i] = load<T>(b.reference + group * b.reference_out_stride + i * kGroup + lane);
  return correction_of(*b.plan, value);
}

void store3(double* out, const survey::Vec3<T>& v) {
  store(out, v.x);
  store(out + kGroup, v.y);
  store(out + 2 * kGroup, v.z);
}

template <class Work>
void each_register(const FitBatch& b, const Work& work) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) work(group, lane);
}

}  // namespace

void fit_batch(const FitBatch& b) {
  const FitPlan& plan = *b.plan;
  const auto n = static_cast<std::size_t>(plan.size());
  each_register(b, [&](std::size_t group, std::size_t lane) {
    std::array<T, kUnknowns> start;
    for (T& v : start) v = T(0.0);
    FitSolution<T> s;
    solve_fit<T>(plan, data_of(b, group, lane), start, s);
    std::array<T, kUnknowns> variance;
    if (b.variance) inverse_diagonal(n, s.factor.data(), variance.data());
    store_estimate(b, group, lane, s.x.data());
    for (std::size_t i = 0; b.variance && i < static_cast<std::size_t>(b.parameters); ++i)
      store(b.variance + group * b.variance_stride + i * kGroup + lane,
            T(unit_of(b, i) * unit_of(b, i)) * variance[static_cast<std::size_t>(b.places[i])]);
    const std::size_t at = group * b.scalar_stride + lane;
    store(b.cost + at, s.cost);
    store(b.iterations + at, s.iterations);
    store(b.converged + at, s.converged);
  });
}

void correct_batch(const FitBatch& b) {
  each_register(b, [&](std::size_t group, std::size_t lane) {
    const Correction<T> c = correction_at(b, group, lane);
    double *gravity = b.gravity_out + group * b.gravity_stride + lane,
           *magnetic = b.magnetic_out + group * b.magnetic_stride + lane;
    for (int k = 0; k < b.first.stations; ++k, gravity += 3 * kGroup, magnetic += 3 * kGroup) {
      store3(gravity, times(c.a_inverse, load3<T>(gravity) - c.a_bias));
      store3(magnetic, times(c.m_inverse, load3<T>(magnetic) - c.m_bias));
    }
  });
}

void residual_batch(const FitBatch& b) {
  each_register(b, [&](std::size_t group, std::size_t lane) {
    const Correction<T> c = correction_at(b, group, lane);
    FitData d = data_of(b, group, lane);
    double* out = b.residuals + group * b.residuals_stride + lane;
    for (int k = 0; k < d.stations; ++k, out += kResiduals * kGroup) {
      const StationTerms<T> s = station_terms<T>(*b.plan, c, d.gravity, d.magnetic, d.reference, T(1.0));
      for (std::size_t j = 0; j < kResiduals; ++j) store(out + j * kGroup, s.r[j]);
      d.gravity += 3 * kGroup;
      d.magnetic += 3 * kGroup;
      d.reference += d.reference_stride * kGroup;
    }
  });
}

}  // namespace surveymc::multistation::SURVEYMC_ISA
