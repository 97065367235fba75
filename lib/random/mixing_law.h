#pragma once
/// Laws of variance 1 and mean 0 whose tails are heavier than a normal's: mixtures of normals of different variance,
///
///   H = s (beta (V - 1) + sqrt(V) N),   V >= 0 of mean 1,   s = 1 / sqrt(1 + beta^2 Var V)
///
/// with V independent of the standard normal N, and beta 0 but for asymmetric_nig:
///   law            V                                                    excess kurtosis
///   normal         1                                                    0
///   laplace        exponential                                          3
///   student        nu/2 - 1 over gamma(nu/2)                            6 / (nu - 4), nu > 4
///   nig            inverse Gaussian of mean 1 and shape lambda          3 / lambda
///   two_point      (1 - e) of c, e of c r^2, c = 1 / (1 - e + e r^2)    3 ((1 - e) c^2 + e c^2 r^4 - 1)
///   asymmetric_nig inverse Gaussian                                     (3/l + 18 b^2/l^2 + 15 b^4/l^3) / (1 +
///   b^2/l)^2
/// nig is scipy's norminvgauss(lambda, 0, scale = sqrt(lambda)); asymmetric_nig of norminvgauss(a, b) has
/// lambda = sqrt(a^2 - b^2) and beta = b / sqrt(lambda). Source: Barndorff-Nielsen 1997; Gjerde, Eidsvik, Nyrnes and
/// Bruun, J. Geodetic Science 1 (2011) 158-169, use it for the geomagnetic reference.
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "base/units.h"

namespace surveymc::random {

enum class LawKind { normal, laplace, student, nig, two_point, asymmetric_nig };
/// In the order of LawKind. A function: kernels include this header, and may have no table that is made at the start.
inline const std::vector<std::string>& law_names() {
  static const std::vector<std::string> names{"normal", "laplace", "student", "nig", "two_point", "asymmetric_nig"};
  return names;
}

struct LawOf {
  LawKind kind = LawKind::normal;
  double degrees = 0;           ///< nu > 2, of student
  double shape = 0;             ///< lambda > 0, of nig and asymmetric_nig
  double share = 0, ratio = 1;  ///< e in (0, 1) and r > 0, of two_point
  double skew = 0;              ///< beta, of asymmetric_nig
  auto operator<=>(const LawOf&) const = default;
};

/// A value of V and its weight in a sum that stands for the expectation.
struct MixingNode {
  double variance = 1, weight = 1;
};

class MixingLaw {
 public:
  explicit MixingLaw(const LawOf& law = {});

  const LawOf& law() const { return law_; }
  bool is_normal() const { return law_.kind == LawKind::normal; }
  bool is_symmetric() const { return law_.kind != LawKind::asymmetric_nig || law_.skew == 0; }

  /// The value of V whose probability is that of a standard normal up to `z`, |z| <= kLargestNormal.
  double quantile(double z) const;
  /// H = factor N + shift for the V that belongs to `z`: from a table of quantiles, accurate to 1e-7.
  struct Draw {
    double factor = 1, shift = 0;
  };
  Draw draw(double z) const;

  /// Excess kurtosis and skewness of H; infinite or NaN where there is none (student: nu <= 4, nu <= 3).
  double excess_kurtosis() const;
  double skewness() const;
  /// s and beta.
  double scale() const { return scale_; }
  double skew() const { return law_.skew; }
  /// E exp(i t H).
  std::complex<double> characteristic(double t) const;

  /// E f(V) = sum weight f(variance): the trapezoidal rule in z, which is exact to rounding for smooth f. f must not
  /// grow faster than V^0 for student of few degrees.
  const std::vector<MixingNode>& nodes() const { return nodes_; }

  /// P(H > x), and P(|H| > k).
  double upper_tail(double x) const;
  double outside(double k) const { return upper_tail(k) + 1 - upper_tail(-k); }
  /// Half of the width of the central interval of H that holds this probability.
  double half_width(double probability) const;

 private:
  LawOf law_;
  double scale_ = 1;
  std::vector<double> root_;  ///< sqrt(V) at equidistant z; empty where V has one or two values
  std::vector<MixingNode> nodes_;
};

/// Normals of the stream are below 7.5 (stream.h); probabilities beyond are 1e-17.
inline constexpr double kLargestNormal = 8.5;

/// What a tabulated size of an error stands for.
enum class SizeMeaning {
  sd,
  ci68,  ///< half of the interval that holds as much as one sd of a normal distribution does, 68.3 %
  ci95   ///< a quarter of that of two sd: half of the half width of 95.4 %
};
/// In the order of SizeMeaning.
inline const std::vector<std::string>& size_names() {
  static const std::vector<std::string> names{"sd", "ci68", "ci95"};
  return names;
}

/// Standard deviation of an error of this law whose tabulated size is 1.
double sd_of_size(const MixingLaw& law, SizeMeaning size);

}  // namespace surveymc::random
