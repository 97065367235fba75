#include "bench_kernels.h"

#include "simd/pack.h"

namespace surveymc::bench::SURVEYMC_ISA {
namespace {

using T = Lanes;
constexpr std::size_t kMatrix = 21, kGradient = 6;

/// Calls side by side, as simulate_readings has them.
void normals(const Stream& stream, std::uint32_t calls, double* out) {
  constexpr std::size_t kCalls = lane_count<T> == 8 ? 5 : 2;
  using Calls = Pack<T, kCalls>;
  for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
    const Bits<T> trial = consecutive<T>(static_cast<std::uint64_t>(lane));
    double* to = out + lane;
    for (std::uint64_t first = 0; first < calls; first += kCalls) {
      const auto call = Bits<Calls>::each([&](std::size_t j) { return Bits<T>(first + j); });
      for (const Calls& z : stream.normals<Calls>(trial, Channel::magnetometer_noise, call))
        for (const T& x : z.v) {
          store(to, x);
          to += kGroup;
        }
    }
  }
}

MsaData from_lane(MsaData d, int lane) {
  d.magnetic += lane;
  d.down += lane;
  d.reference += lane;
  return d;
}

void msa_sums(const MsaData& group, double* out) {
  for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
    const MsaReadingSums<T> s = msa_reading_sums<T>(from_lane(group, lane));
    for (std::size_t i = 0; i < 3; ++i) {
      store(out + i * kGroup + lane, s.m[i]);
      store(out + (3 + i) * kGroup + lane, s.mm[i]);
    }
  }
}

template <bool WithMatrix>
void evaluate(const MsaData& data, const double* sums, const double* x, double* out) {
  MsaReadingSums<T> s;
  std::array<T, 6> at;
  for (std::size_t i = 0; i < 3; ++i) {
    s.m[i] = load<T>(sums + i * kGroup);
    s.mm[i] = load<T>(sums + (3 + i) * kGroup);
  }
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = T(x[i]);
  const auto e = msa_normal_equations<T, WithMatrix>(data, s, at, T(x[6]));
  for (std::size_t i = 0; i < kMatrix && WithMatrix; ++i) store(out + i * kGroup, e.matrix[i]);
  for (std::size_t i = 0; i < kGradient; ++i) store(out + (kMatrix + i) * kGroup, e.gradient[i]);
  store(out + (kMatrix + kGradient) * kGroup, e.cost);
}

void msa_evaluate(const MsaData& group, const double* sums, const double* x, bool with_matrix, double* out) {
  for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
    if (with_matrix)
      evaluate<true>(from_lane(group, lane), sums + lane, x, out + lane);
    else
      evaluate<false>(from_lane(group, lane), sums + lane, x, out + lane);
  }
}

template <bool Series>
void gradient(const MsaData& data, const double* x, double* out) {
  const auto e = surveymc::msa_gradient<T, Series>(data, {T(x[0]), T(x[1]), T(x[2]), T(x[3]), T(x[4]), T(x[5])});
  for (std::size_t i = 0; i < kGradient; ++i) store(out + i * kGroup, e.gradient[i]);
  store(out + kGradient * kGroup, e.cost);
}

void msa_gradient(const MsaData& group, const double* x, bool series, double* out) {
  for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
    if (series)
      gradient<true>(from_lane(group, lane), x, out + lane);
    else
      gradient<false>(from_lane(group, lane), x, out + lane);
  }
}

void msa_step(const double* in, int count, double* out) {
  Symmetric<T, 6> matrix;
  std::array<T, 6> gradient, x;
  for (std::size_t i = 0; i < kMatrix; ++i) matrix[i] = load<T>(in + i * kGroup);
  for (std::size_t i = 0; i < kGradient; ++i) gradient[i] = x[i] = load<T>(in + (kMatrix + i) * kGroup);
  for (int c = 0; c < count; ++c) {
    Symmetric<T, 6> m = matrix;
    m[0] = fma(x[0], T(0.0), m[0]);  // no change, but m is not known before x
    x = ldlt_solve<T, 6>(ldlt<T, 6>(m), gradient);
  }
  for (std::size_t i = 0; i < kGradient; ++i) store(out + i * kGroup, x[i]);
}

}  // namespace

const Kernels kernels{surveymc::SURVEYMC_ISA::simulate,
                      surveymc::SURVEYMC_ISA::msa_solve_batch,
                      surveymc::SURVEYMC_ISA::corrected_positions,
                      normals,
                      msa_sums,
                      msa_evaluate,
                      msa_gradient,
                      msa_step};

}  // namespace surveymc::bench::SURVEYMC_ISA
