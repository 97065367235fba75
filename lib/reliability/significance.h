#pragma once
/// Levels, critical values and powers of the tests for gross errors (sections 2.1, 2.2; Baarda's B-method).
namespace surveymc::reliability {

/// Whether alpha is the false-alarm probability of one tail (the paper's alpha_i, section 5.3) or of both together.
enum class Tails { one, two };

/// How a single observation is tested. Probabilities in (0, 1).
struct TestLevels {
  double alpha = 1e-4;
  Tails tails = Tails::one;
  double power = 0.8;  ///< the paper's beta: probability of detecting the minimal detectable error
};

/// False-alarm probability of the two-sided w-test: 2 alpha with Tails::one, alpha with Tails::two.
double two_sided_alpha(const TestLevels& levels);

/// k with P(|w| > k) = two_sided_alpha, eq 14.
double w_critical(const TestLevels& levels);

/// Shift of w that is found with probability `power`: lambda_0 = k + z_power, eqs 12, 13. (The far tail adds less than
/// alpha times 1e-8 to the power and is left out.) Must come out positive: power > alpha of one tail.
double lambda0(const TestLevels& levels);

/// P(|w| > k) for w ~ N(lambda, 1).
double w_power(double lambda, double critical);

/// P(T > critical) for T ~ chi2 with r degrees of freedom and this noncentrality (eq 4; the square of the shift).
double chi_squared_power(double r, double noncentrality, double critical);

/// P(|tau| > pope_critical) where w ~ N(lambda, 1) and the rest of Omega is free of errors: Student's noncentral t by
/// relation 18. 0 where nothing can be rejected (redundancy of 1).
double pope_power(double lambda, double redundancy, double alpha);

/// Upper critical value of chi2 with r degrees of freedom (eq 4), of Fisher's F(r, n-u-r) (eq 5), of tau2 (eq 6) and of
/// Pope's |tau| (eq 15, by its relation 18 to Student's t with n-u-1 degrees of freedom) at a total false-alarm
/// probability `alpha`. `redundancy` is n-u. F and tau2 need n-u > r; otherwise +infinity (nothing can be rejected;
/// tau2 then cannot exceed its bound n-u over r).
double chi_squared_critical(double r, double alpha);
double fisher_critical(double r, double redundancy, double alpha);
double tau_squared_critical(double r, double redundancy, double alpha);
double pope_critical(double redundancy, double alpha);

/// Probability of a statistic at least as large, if there is no gross error. NaN of NaN: it speaks against nothing.
double chi_squared_p_value(double r, double statistic);
double w_p_value(double w);  ///< two-sided

/// B-method: levels of tests of r dimensions that find the same noncentrality lambda_0^2 with the same power.
struct DimensionLevel {
  double alpha, critical;  ///< of chi2 with r degrees of freedom
};
DimensionLevel b_method_level(double r, double lambda0_squared, double power);

/// Shift lambda of w_i that makes |w_i| > |w_j| with probability `power`, for two tests of correlation rho: with
/// a = lambda sqrt((1 - rho)/2), b = lambda sqrt((1 + rho)/2), w_i^2 - w_j^2 = (w_i - w_j)(w_i + w_j) is a product of
/// independent normals, and P = Phi(a) Phi(b) + Phi(-a) Phi(-b). +infinity for |rho| = 1; else 0 for a power of up to
/// 1/2.
double identifiable_shift(double rho, double power);
double identification_probability(double lambda, double rho);

}  // namespace surveymc::reliability
