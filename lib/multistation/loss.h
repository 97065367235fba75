#pragma once
/// Losses that make a fit robust against stations in error: the weight of a station by the length of its residual.
///
///   t = |r_k| / s,  s = median |r_k| / scale_of_median(d),  d components a station, normal where nothing is wrong
///   l1 1 / max(t, .05);  huber min(1, 1.7 / t);  cauchy 1 / (1 + (t / 2.6)^2);  tukey (1 - (t / 4.7)^2)^2, 0 from 4.7
/// One weight for all components of a station: weights of single components would bias the dip. Tuning constants are
/// those of regression with some 0.95 of the efficiency of least squares. Sources: P. Huber, Robust Statistics, 1981;
/// GROOPS, robustLeastSquares (T. Mayer-Guerr et al.), whose weight beyond h sigma is a power of h sigma / |e|: huber
/// here with power 1; P. Holland and R. Welsch, Comm. Stat. A6, 1977 (cauchy, tukey).
#include <string>
#include <vector>

#include "simd/lanes.h"

namespace surveymc::multistation {

enum class Loss { least_squares, l1, huber, cauchy, tukey };
/// "least_squares", "l1", "huber", "cauchy", "tukey".
const std::vector<std::string>& loss_names();

inline constexpr double kL1Floor = 0.05, kHuber = 1.7, kCauchy = 2.6, kTukey = 4.7;

/// Weight of a station whose residual is t scales long. At least 0, at most 1 (l1: 1 / kL1Floor), and falling in t.
/// `t2`: t^2.
template <class T>
[[gnu::always_inline]] inline T station_weight(Loss loss, const T& t2) {
  const T one(1.0), zero(0.0);
  switch (loss) {
    case Loss::least_squares:
      return one;
    case Loss::l1:
      return one / simd::max(simd::sqrt(t2), T(kL1Floor));
    case Loss::huber:
      return T(kHuber) / simd::max(simd::sqrt(t2), T(kHuber));
    case Loss::cauchy:
      return one / simd::fma(t2, T(1 / (kCauchy * kCauchy)), one);
    case Loss::tukey: {
      const T inside = simd::max(simd::fma(t2, T(-1 / (kTukey * kTukey)), one), zero);
      return inside * inside;
    }
  }
  return one;
}

/// Median length of a vector of `components` standard normals: 1.1774 of two, 1.5382 of three.
double scale_of_median(int components);

/// How far a station counts in a claimed covariance: its weight, but no more than one. Weights above one (l1) say that
/// the fit goes through a station, not that the station tells more than others.
inline double station_trust(double weight) { return weight < 1 ? weight : 1; }

/// What a loss costs where nothing is wrong: residuals normal with unit sd, `components` a station, many stations.
///   k = E[w + w' t / d],  v = E[(w t)^2] / d / k^2
/// To first order a robust fit is least squares with the weight k of every station, whose residual e counts as
/// psi(e) / k = e + h: h has the covariance v - 1 in units of that of e, and nothing in common with e, as E[psi e'] =
/// k. A small residual that stations share, of the reference or of an error that is not estimated, counts as it is.
/// Source: P. Huber, Robust Statistics, 1981, 6.3 (v); k and E[psi e'] by parts.
struct LossCost {
  double slope = 1;       ///< k: how much a station weighs against priors
  double variance = 1;    ///< v: variance of an estimate without priors over that of least squares
  double mean_trust = 1;  ///< m = E min(w, 1)

  /// How much a station with the weight w tells a claimed covariance: k min(w, 1) / m, k where nothing is wrong.
  ///   N = sum (k min(w, 1) / m) J'J + P,   C = N^-1 (v k sum (k min(w, 1) / m) J'J + P) N^-1
  /// Without priors v m (sum min(w, 1) J'J)^-1.
  double information(double weight) const { return slope * station_trust(weight) / mean_trust; }
  double claimed_variance() const { return variance * slope; }  ///< v k
};
LossCost loss_cost(Loss loss, int components);

}  // namespace surveymc::multistation
