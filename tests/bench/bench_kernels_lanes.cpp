#include "bench_kernels.h"

#include "simd/pack.h"

namespace surveymc::bench::SURVEYMC_ISA {
namespace {

using T = simd::Lanes;
constexpr std::size_t kMatrix = 21, kGradient = 6;

/// Calls side by side, as simulate_readings has them.
void normals(const random::Stream& stream, std::uint32_t calls, double* out) {
  constexpr std::size_t kCalls = simd::lane_count<T> == 8 ? 5 : 2;
  using Calls = simd::Pack<T, kCalls>;
  for (int lane = 0; lane < simd::kGroup; lane += simd::lane_count<T>) {
    const simd::Bits<T> trial = simd::consecutive<T>(static_cast<std::uint64_t>(lane));
    double* to = out + lane;
    for (std::uint64_t first = 0; first < calls; first += kCalls) {
      const auto call = simd::Bits<Calls>::each([&](std::size_t j) { return simd::Bits<T>(first + j); });
      for (const Calls& z : stream.normals<Calls>(trial, random::Channel::magnetometer_noise, call))
        for (const T& x : z.v) {
          simd::store(to, x);
          to += simd::kGroup;
        }
    }
  }
}

estimate::MsaData from_lane(estimate::MsaData d, int lane) {
  d.magnetic += lane;
  d.down += lane;
  d.reference += lane;
  return d;
}

void msa_sums(const estimate::MsaData& group, double* out) {
  for (int lane = 0; lane < simd::kGroup; lane += simd::lane_count<T>) {
    const estimate::MsaReadingSums<T> s = estimate::msa_reading_sums<T>(from_lane(group, lane));
    for (std::size_t i = 0; i < 3; ++i) {
      simd::store(out + i * simd::kGroup + lane, s.m[i]);
      simd::store(out + (3 + i) * simd::kGroup + lane, s.mm[i]);
    }
  }
}

template <bool WithMatrix>
void evaluate(const estimate::MsaData& data, const double* sums, const double* x, double* out) {
  estimate::MsaReadingSums<T> s;
  std::array<T, 6> at;
  for (std::size_t i = 0; i < 3; ++i) {
    s.m[i] = simd::load<T>(sums + i * simd::kGroup);
    s.mm[i] = simd::load<T>(sums + (3 + i) * simd::kGroup);
  }
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = T(x[i]);
  const auto e = estimate::msa_normal_equations<T, WithMatrix>(data, s, at, T(x[6]));
  for (std::size_t i = 0; i < kMatrix && WithMatrix; ++i) simd::store(out + i * simd::kGroup, e.matrix[i]);
  for (std::size_t i = 0; i < kGradient; ++i) simd::store(out + (kMatrix + i) * simd::kGroup, e.gradient[i]);
  simd::store(out + (kMatrix + kGradient) * simd::kGroup, e.cost);
}

void msa_evaluate(const estimate::MsaData& group, const double* sums, const double* x, bool with_matrix, double* out) {
  for (int lane = 0; lane < simd::kGroup; lane += simd::lane_count<T>) {
    if (with_matrix)
      evaluate<true>(from_lane(group, lane), sums + lane, x, out + lane);
    else
      evaluate<false>(from_lane(group, lane), sums + lane, x, out + lane);
  }
}

template <bool Series>
void gradient(const estimate::MsaData& data, const double* x, double* out) {
  const auto e =
      surveymc::estimate::msa_gradient<T, Series>(data, {T(x[0]), T(x[1]), T(x[2]), T(x[3]), T(x[4]), T(x[5])});
  for (std::size_t i = 0; i < kGradient; ++i) simd::store(out + i * simd::kGroup, e.gradient[i]);
  simd::store(out + kGradient * simd::kGroup, e.cost);
}

void msa_gradient(const estimate::MsaData& group, const double* x, bool series, double* out) {
  for (int lane = 0; lane < simd::kGroup; lane += simd::lane_count<T>) {
    if (series)
      gradient<true>(from_lane(group, lane), x, out + lane);
    else
      gradient<false>(from_lane(group, lane), x, out + lane);
  }
}

void msa_valley_sums(const estimate::MsaData& group, const estimate::MsaValley& valley, double* out) {
  for (int lane = 0; lane < simd::kGroup; lane += simd::lane_count<T>) {
    const auto sums = estimate::msa_valley_sums<T>(from_lane(group, lane), false, valley);
    for (std::size_t i = 0; i < sums.size(); ++i) simd::store(out + i * simd::kGroup + lane, sums[i]);
  }
}

void msa_step(const double* in, int count, double* out) {
  simd::Symmetric<T, 6> matrix;
  std::array<T, 6> gradient, x;
  for (std::size_t i = 0; i < kMatrix; ++i) matrix[i] = simd::load<T>(in + i * simd::kGroup);
  for (std::size_t i = 0; i < kGradient; ++i) gradient[i] = x[i] = simd::load<T>(in + (kMatrix + i) * simd::kGroup);
  for (int c = 0; c < count; ++c) {
    simd::Symmetric<T, 6> m = matrix;
    m[0] = simd::fma(x[0], T(0.0), m[0]);  // no change, but m is not known before x
    x = simd::ldlt_solve<T, 6>(simd::ldlt<T, 6>(m), gradient);
  }
  for (std::size_t i = 0; i < kGradient; ++i) simd::store(out + i * simd::kGroup, x[i]);
}

}  // namespace

const Kernels kernels{sensor::SURVEYMC_ISA::simulate,
                      estimate::SURVEYMC_ISA::msa_solve_batch,
                      survey::SURVEYMC_ISA::corrected_positions,
                      normals,
                      msa_sums,
                      msa_evaluate,
                      msa_gradient,
                      msa_valley_sums,
                      msa_step};

}  // namespace surveymc::bench::SURVEYMC_ISA
