#pragma once
/// Tests on the residual or drift of one sensor, sample by sample: SPRT, and for comparison CUSUM and a plain
/// threshold.
namespace surveymc::monitoring {

struct SprtOptions {
  double false_alarm = 0.05, missed_alarm = 0.10;  ///< alpha and beta: per decision, not per hour
  double shift = 3;                                ///< M, of the mean under H1, z
  double variance = 0.09;                          ///< sigma^2 of the sensor's noise, as the test assumes it, z squared
  bool operator==(const SprtOptions&) const = default;
};

/// Bounds of eq 9, A being the lower one: ln A = ln(beta / (1 - alpha)), ln B = ln((1 - beta) / alpha).
double sprt_lower(const SprtOptions& options);
double sprt_upper(const SprtOptions& options);

/// Wald's sequential probability ratio test of mean 0 against +M and, in a sum of its own, against -M:
///   S += M / sigma^2 (+-d - M / 2);  S <= ln A: H0, S = 0;  S >= ln B: H1, S = 0
/// Boechat, Moreno and Haramura, eqs 7-11 with the restart that eq 8 needs. Each side holds its last decision.
class Sprt {
 public:
  explicit Sprt(const SprtOptions& options);
  /// +1 or -1 if this sample completes an acceptance of H1 on that side, else 0.
  int update(double d) {
    int accepted = 0;
    for (int side = 0; side < 2; ++side) {
      sum_[side] += slope_ * ((side == 0 ? d : -d) - half_shift_);
      if (sum_[side] <= lower_) {
        decided_[side] = false;
        sum_[side] = 0;
      } else if (sum_[side] >= upper_) {
        decided_[side] = true;
        sum_[side] = 0;
        accepted = side == 0 ? 1 : -1;
      }
    }
    return accepted;
  }
  /// The last decision: 0 (H0 on both sides), +1 or -1 (H1).
  int decision() const { return decided_[0] ? 1 : decided_[1] ? -1 : 0; }

 private:
  double slope_, half_shift_, lower_, upper_;
  double sum_[2] = {0, 0};
  bool decided_[2] = {false, false};
};

struct CusumOptions {
  double allowance = 0.5;  ///< z subtracted from every sample
  double threshold = 5;    ///< of the sum, z
  bool operator==(const CusumOptions&) const = default;
};

/// Page's cumulative sums, C = max(0, C +- d - allowance); an alarm at the threshold, and C = 0.
class Cusum {
 public:
  explicit Cusum(const CusumOptions& options) : options_(options) {}
  int update(double d) {
    int alarm = 0;
    for (int side = 0; side < 2; ++side) {
      const double sum = sum_[side] + (side == 0 ? d : -d) - options_.allowance;
      sum_[side] = sum > 0 ? sum : 0;
      if (sum_[side] >= options_.threshold) {
        sum_[side] = 0;
        alarm = side == 0 ? 1 : -1;
      }
    }
    return alarm;
  }
  double largest() const { return sum_[0] > sum_[1] ? sum_[0] : sum_[1]; }  ///< of the two present sums

 private:
  CusumOptions options_;
  double sum_[2] = {0, 0};
};

/// An alarm for every sample with |d| >= threshold.
class Threshold {
 public:
  explicit Threshold(double threshold) : threshold_(threshold) {}
  int update(double d) const { return d >= threshold_ ? 1 : d <= -threshold_ ? -1 : 0; }

 private:
  double threshold_;
};

}  // namespace surveymc::monitoring
