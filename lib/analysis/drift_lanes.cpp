#include "analysis/drift_lanes.h"

#include "simd/math.h"
#include "simd/solve.h"

namespace surveymc::analysis::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;
using Mask = LaneMask;
using Three = std::array<T, 3>;
using Six = std::array<T, 6>;

T dot(const Three& a, const Three& b) { return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2])); }

/// Channels |g|, |b|, dip less the reference, the rows of their Jacobian (survey_drift.h), and the covariance R.
/// Gravity's and field's part of a row stand apart: the first row has no field, the second no gravity.
struct Channels {
  Three y, u, v, dip_g, dip_b;
  T r00, r11, r22, r20, r21;
  Mask in_range;
};

Channels channels(const DriftBatch& s, const Three& g, const Three& b, const std::array<T, 4>& scatter) {
  Channels c;
  const T gravity = sqrt(dot(g, g)), total = sqrt(dot(b, b)), per_g = T(1.0) / gravity, per_b = T(1.0) / total;
  c.u = {g[0] * per_g, g[1] * per_g, g[2] * per_g};
  c.v = {b[0] * per_b, b[1] * per_b, b[2] * per_b};
  const T sine = dot(c.u, c.v);
  const Three cross{fma(c.u[1], c.v[2], -(c.u[2] * c.v[1])), fma(c.u[2], c.v[0], -(c.u[0] * c.v[2])),
                    fma(c.u[0], c.v[1], -(c.u[1] * c.v[0]))};
  const T cosine = sqrt(dot(cross, cross)), per_cosine = T(1.0) / cosine;
  const T of_g = per_cosine * per_g, of_b = per_cosine * per_b;
  T variance_g(0.0), variance_b(0.0), variance_dip(0.0), with_g(0.0), with_b(0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    c.dip_g[i] = fma(-sine, c.u[i], c.v[i]) * of_g;
    c.dip_b[i] = fma(-sine, c.v[i], c.u[i]) * of_b;
    const T ng(s.noise[i] * s.noise[i]), nb(s.noise[3 + i] * s.noise[3 + i]);
    const T u = ng * c.u[i], v = nb * c.v[i];
    variance_g = fma(u, c.u[i], variance_g);
    variance_b = fma(v, c.v[i], variance_b);
    with_g = fma(u, c.dip_g[i], with_g);
    with_b = fma(v, c.dip_b[i], with_b);
    variance_dip = fma(ng * c.dip_g[i], c.dip_g[i], fma(nb * c.dip_b[i], c.dip_b[i], variance_dip));
  }
  c.r00 = variance_g + T(s.scatter[0] * s.scatter[0]);
  c.r11 = variance_b + T(s.scatter[1] * s.scatter[1]);
  c.r22 = variance_dip + T(s.scatter[2] * s.scatter[2]);
  c.r20 = with_g;
  c.r21 = with_b;
  // Dip less its reference, by the sine of the difference
  const auto [sd, cd] = sincos(T(s.scatter[2]) * scatter[2]);
  const T sin_reference = fma(T(s.sin_dip), cd, T(s.cos_dip) * sd),
          cos_reference = fma(T(s.cos_dip), cd, -(T(s.sin_dip) * sd));
  const T difference = fma(sine, cos_reference, -(cosine * sin_reference)), square = difference * difference;
  c.in_range = (square < T(0.25)) & (T(0.0) < fma(cosine, cos_reference, sine * sin_reference));
  c.y = {fma(T(-s.scatter[0]), scatter[0], gravity - T(s.gravity)),
         fma(T(-s.scatter[1]), scatter[1], total - T(s.total)), difference * asin_ratio(square)};
  return c;
}

/// BiasFilter of survey_drift.h: of P its lower triangle, and P' - B' D^-1 B with L D L' = H P' H' + R, B = L^-1 H P'.
struct Filter {
  Six bias;
  Symmetric<T, 6> covariance;

  Filter() {
    bias.fill(T(0.0));
    covariance.fill(T(0.0));
  }
  /// Returns NIS. in_range: see DriftBatch.
  T update(const DriftBatch& s, const Channels& c, Mask& in_range) {
    Symmetric<T, 6> p = covariance;
    for (std::size_t j = 0; j < 6; ++j) p[packed(j, j)] = p[packed(j, j)] + T(s.walk[j] * s.walk[j]);
    const auto at = [&](std::size_t i, std::size_t j) { return p[i > j ? packed(i, j) : packed(j, i)]; };
    Six b0, b1, b2;  // H P', and then B
    for (std::size_t j = 0; j < 6; ++j) {
      b0[j] = dot(c.u, {at(0, j), at(1, j), at(2, j)});
      b1[j] = dot(c.v, {at(3, j), at(4, j), at(5, j)});
      b2[j] = dot(c.dip_g, {at(0, j), at(1, j), at(2, j)}) + dot(c.dip_b, {at(3, j), at(4, j), at(5, j)});
    }
    const auto gravity_part = [](const Six& x) { return Three{x[0], x[1], x[2]}; };
    const auto field_part = [](const Six& x) { return Three{x[3], x[4], x[5]}; };
    const T s00 = dot(c.u, gravity_part(b0)) + c.r00, s10 = dot(c.v, field_part(b0)),
            s11 = dot(c.v, field_part(b1)) + c.r11;
    const T s20 = dot(c.dip_g, gravity_part(b0)) + dot(c.dip_b, field_part(b0)) + c.r20;
    const T s21 = dot(c.dip_g, gravity_part(b1)) + dot(c.dip_b, field_part(b1)) + c.r21;
    const T s22 = dot(c.dip_g, gravity_part(b2)) + dot(c.dip_b, field_part(b2)) + c.r22;
    const T i0 = T(1.0) / s00, l10 = s10 * i0, l20 = s20 * i0;
    const T i1 = T(1.0) / fma(-l10, s10, s11), t21 = fma(-l20, s10, s21), l21 = t21 * i1;
    const T i2 = T(1.0) / fma(-l21, t21, fma(-l20, s20, s22));
    const T v0 = c.y[0] - dot(c.u, gravity_part(bias));
    const T v1 = fma(-l10, v0, c.y[1] - dot(c.v, field_part(bias)));
    const T v2 =
        fma(-l21, v1, fma(-l20, v0, c.y[2] - (dot(c.dip_g, gravity_part(bias)) + dot(c.dip_b, field_part(bias)))));
    const T z0 = v0 * i0, z1 = v1 * i1, z2 = v2 * i2;
    for (std::size_t j = 0; j < 6; ++j) {
      b1[j] = fma(-l10, b0[j], b1[j]);
      b2[j] = fma(-l21, b1[j], fma(-l20, b0[j], b2[j]));
      bias[j] = fma(b0[j], z0, fma(b1[j], z1, fma(b2[j], z2, bias[j])));
    }
    for (std::size_t i = 0; i < 6; ++i) {
      const T g0 = b0[i] * i0, g1 = b1[i] * i1, g2 = b2[i] * i2;
      for (std::size_t j = 0; j <= i; ++j)
        covariance[packed(i, j)] = fma(-g0, b0[j], fma(-g1, b1[j], fma(-g2, b2[j], p[packed(i, j)])));
      in_range = in_range & (T(1e-9) * p[packed(i, i)] < covariance[packed(i, i)]);
    }
    return fma(z0, v0, fma(z1, v1, z2 * v2));
  }
  /// NEES of an error of the biases.
  T normalised_error(const Six& e) const {
    const Symmetric<T, 6> f = ldlt<T, 6>(covariance);
    Six x = e;
    T sum(0.0);
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < i; ++k) x[i] = fma(-f[packed(i, k)], x[k], x[i]);
      sum = fma(x[i] * x[i], f[packed(i, i)], sum);
    }
    return sum;
  }
  /// Largest bias over its sd is an alarm; `named`: which.
  Mask alarms(double alarm_sd, T& named) const {
    T most = bias[0] * bias[0], variance = covariance[0];
    named = T(0.0);
    for (std::size_t j = 1; j < 6; ++j) {
      const T square = bias[j] * bias[j], own = covariance[packed(j, j)];
      const Mask larger = square * variance > most * own;
      most = select(larger, square, most);
      variance = select(larger, own, variance);
      named = select(larger, T(static_cast<double>(j)), named);
    }
    return T(alarm_sd * alarm_sd) * variance <= most;
  }
};

/// The Sprt of sequential_tests.h on each channel, without the decisions that hold.
struct Sprts {
  T sum[3][2];
  Sprts() {
    for (auto& of_channel : sum) of_channel[0] = of_channel[1] = T(0.0);
  }
  Mask update(const DriftBatch& s, std::size_t channel, const T& d) {
    Mask accepted = T(1.0) < T(0.0);
    for (int side = 0; side < 2; ++side) {
      T& x = sum[channel][side];
      x = x + T(s.sprt_slope) * ((side == 0 ? d : -d) - T(s.sprt_half_shift));
      const Mask none = x <= T(s.sprt_lower), alarm = T(s.sprt_upper) <= x;
      x = select(none | alarm, T(0.0), x);
      accepted = accepted | (alarm & !none);
    }
    return accepted;
  }
};

/// The wells with a ramp and without drift: monitors, and when they first raised an alarm.
struct Monitored {
  Filter filter;
  Sprts sprts;
  T sprt_alarm = T(-1.0), filter_alarm = T(-1.0), named = T(-1.0);

  void add(const DriftBatch& s, int station, bool counts, const Channels& c, Mask& in_range) {
    filter.update(s, c, in_range);
    const T r[3] = {c.r00, c.r11, c.r22};
    Mask alarm = T(1.0) < T(0.0);
    for (std::size_t i = 0; i < 3; ++i) alarm = alarm | sprts.update(s, i, c.y[i] / sqrt(r[i]));
    if (!counts) return;
    const T now(static_cast<double>(station));
    sprt_alarm = select(alarm & (sprt_alarm < T(0.0)), now, sprt_alarm);
    T largest;
    const Mask first = filter.alarms(s.alarm_sd, largest) & (filter_alarm < T(0.0));
    filter_alarm = select(first, now, filter_alarm);
    named = select(first, largest, named);
  }
};

/// Six normals of a station from two or three calls of four.
class SixNormals {
 public:
  SixNormals(const DriftBatch& s, const LaneBits& trial, std::uint32_t first)
      : stream_(s.stream), trial_(trial), call_(first / 4) {}
  Six next() {
    const auto four = [&] {
      return stream_.normals<T>(trial_, random::Channel::survey_sensor_noise, LaneBits(std::uint64_t{call_++}));
    };
    if (half_) {
      half_ = false;
      const std::array<T, 4> a = four();
      return {left_[0], left_[1], a[0], a[1], a[2], a[3]};
    }
    half_ = true;
    const std::array<T, 4> a = four(), b = four();
    left_[0] = b[2];
    left_[1] = b[3];
    return {a[0], a[1], a[2], a[3], b[0], b[1]};
  }

 private:
  const random::Stream& stream_;
  LaneBits trial_;
  std::uint32_t call_;
  bool half_ = false;
  T left_[2];
};

void run_lanes(DriftBatch& s, std::size_t lane) {
  const LaneBits trial = consecutive<T>(s.first_trial + lane);
  SixNormals noise(s, trial, 0), steps(s, trial, kFirstDriftStep);
  Monitored with, without;
  Filter walking;
  Six truth;
  truth.fill(T(0.0));
  T nis_sum(0.0), inside(0.0), nees_sum(0.0);
  Mask in_range = T(0.0) < T(1.0);
  std::array<T, 4> toolfaces;
  for (int k = 0; k < s.stations; ++k) {
    const auto station = static_cast<std::uint64_t>(k);
    if (k % 4 == 0) toolfaces = s.stream.uniforms<T>(trial, random::Channel::survey_toolface, LaneBits(station / 4));
    const auto [st, ct] = sincos(T(2 * kPi) * toolfaces[station % 4]);
    const T ga(s.gravity_across[k]), fa(s.field_across[k]), fe(s.field_east);
    const Six n = noise.next();
    Three g{fma(-ga, st, T(s.noise[0]) * n[0]), fma(-ga, ct, T(s.noise[1]) * n[1]),
            fma(T(s.noise[2]), n[2], T(s.gravity_along[k]))};
    Three b{fma(fa, st, fma(fe, ct, T(s.noise[3]) * n[3])), fma(fa, ct, fma(-fe, st, T(s.noise[4]) * n[4])),
            fma(T(s.noise[5]), n[5], T(s.field_along[k]))};
    const std::array<T, 4> scatter = s.stream.normals<T>(trial, random::Channel::survey_reference, LaneBits(station));

    const Channels clean = channels(s, g, b, scatter);
    in_range = in_range & clean.in_range;
    without.add(s, k, true, clean, in_range);

    const T ramp(s.ramp[k]);
    Three g1, b1;
    for (std::size_t i = 0; i < 3; ++i) {
      g1[i] = fma(ramp, T(s.drift[i]), g[i]);
      b1[i] = fma(ramp, T(s.drift[3 + i]), b[i]);
    }
    const Channels drifted = channels(s, g1, b1, scatter);
    in_range = in_range & drifted.in_range;
    with.add(s, k, k >= s.from_station, drifted, in_range);

    const Six step = steps.next();
    for (std::size_t j = 0; j < 6; ++j) truth[j] = fma(T(s.walk[j]), step[j], truth[j]);
    for (std::size_t i = 0; i < 3; ++i) {
      g[i] = g[i] + truth[i];
      b[i] = b[i] + truth[3 + i];
    }
    const Channels walked = channels(s, g, b, scatter);
    in_range = in_range & walked.in_range;
    const T nis = walking.update(s, walked, in_range);
    nis_sum = nis_sum + nis;
    inside = inside + select(nis <= T(s.nis_quantile), T(1.0), T(0.0));
    Six error;
    for (std::size_t j = 0; j < 6; ++j) error[j] = walking.bias[j] - truth[j];
    nees_sum = nees_sum + walking.normalised_error(error);
  }
  const T per(1.0 / s.stations);
  const T values[DriftResult::kValues] = {with.sprt_alarm,      with.filter_alarm, with.named,   without.sprt_alarm,
                                          without.filter_alarm, nis_sum * per,     inside * per, nees_sum * per};
  for (std::size_t v = 0; v < DriftResult::kValues; ++v) store(s.values[v] + lane, values[v]);
  store(s.in_range + lane, select(in_range, T(1.0), T(0.0)));
}

}  // namespace

void drift_trials(DriftBatch& batch) {
  for (std::size_t lane = 0; lane < kGroup; lane += lane_count<T>) run_lanes(batch, lane);
}

}  // namespace surveymc::analysis::SURVEYMC_ISA
