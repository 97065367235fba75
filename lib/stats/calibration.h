#pragma once
/// Is a claimed distribution right as a whole? For every trial u = F(error), F the claimed distribution function; u is
/// uniform if the claim is right (Talts, Betancourt, Simpson, Vehtari and Gelman 2018, with the claimed law in place of
/// ranks among draws of it). A tally counts u in 100 equal bins; all here is a function of these counts.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/units.h"
#include "stats/intervals.h"

namespace surveymc::stats {

inline constexpr int kPitBins = 100;
/// Counts of one quantity: bins of u, of which the third and the 98th are cut at 0.025 and 0.975 for the central 95 %,
/// and at the end the trials whose claim is not a positive finite sd.
inline constexpr std::size_t kPitSlots = kPitBins + 3, kPitUnjudged = kPitBins + 2;

/// Finds the slot of an error. Edges are quantiles of the claimed law at i / 100, 0.025 and 0.975; u = 1 is in the
/// last.
class PitCells {
 public:
  /// Normal errors with mean 0; sd in the unit of the errors. A sd that is not positive and finite leaves all unjudged.
  static PitCells normal(double sd = 1);
  /// The same of an angle, given by its tangent: the distribution function of both is one. sd in rad. Where 98 % of the
  /// angles do not lie within a right angle, all are left unjudged.
  static PitCells normal_angle(double sd);
  /// Squared distances, chi-squared with so many degrees.
  static PitCells chi_squared(double degrees);

  /// Slot of x: < kPitSlots.
  std::size_t of(double x) const {
    const double place = (x - first_) * per_unit_;
    if (!(place < kLookUp)) return place >= kLookUp ? beyond_ : kPitUnjudged;  // also NaN
    std::size_t i = start_[place > 0 ? static_cast<std::size_t>(place) : 0];
    while (x >= edges_[i]) ++i;
    return i;
  }

  /// Adds to the kPitSlots counts at `slots` the `n` errors x[t] + offset: of() of each, without a branch.
  void count(const double* x, std::size_t n, double offset, std::uint64_t* slots) const;

 private:
  static constexpr int kLookUp = 1024;
  explicit PitCells(const std::array<double, kPitBins + 1>& edges);
  PitCells() = default;

  std::array<double, kPitBins + 2> edges_{};  // rising; NaN behind the last, which nothing reaches
  /// Slot in which an equal part of the range of edges begins; the last one is for all beyond.
  std::array<std::uint8_t, kLookUp + 1> start_{};
  double first_ = kNaN, per_unit_ = 0;  // NaN leaves all unjudged
  bool has_single_edges_ = false;       // no part of the way has two edges
  std::size_t beyond_ = kPitUnjudged;   // slot of what lies beyond the last edge
};

/// The counts of one quantity, put together.
struct PitCounts {
  std::array<std::uint64_t, kPitBins> bins{};
  std::uint64_t total = 0, central95 = 0, unjudged = 0;
};
/// `slots`: kPitSlots of them.
PitCounts pit_counts(std::span<const std::uint64_t> slots);

/// The claimed law of a quantity, which decides with which shapes a deviation is compared.
struct ClaimedLaw {
  double degrees = 0;  ///< 0: normal; else chi-squared with as many
};

/// Result of a calibration. D_i = F_i - i / 100, F_i the share of trials in the first i bins.
struct CalibrationResult {
  double largest = 0, at = 0;  ///< D with the largest magnitude, and its u
  Interval interval;           ///< of it, simultaneous
  double quantile = 0;         ///< half width of the band = quantile sqrt(u (1 - u) / n)
  double p_band = 1, p_chi_squared = 1;
  std::string verdict;                 ///< "agrees", "differs", "undecided"
  double p_differs = 1, p_agrees = 1;  ///< p_agrees is NaN where the margin is 0
  std::uint64_t trials_to_decide = 0;  ///< trials, not pairs; 0: decided
  /// The shape that D resembles most, by least squares: "sd" (the errors' sd is (1 + size) times the claimed one),
  /// "shift" (their mean is `size` claimed sds), "skewness", "kurtosis" (excess). Chi-squared laws have "sd" only.
  std::string shape;
  double size = 0;
};

/// `units`: independent values behind the counts: trials, or antithetic pairs, which have two counts each. At least one
/// value. `margin` 0: "differs" if p_band < 1 - confidence, else "agrees".
CalibrationResult judge_calibration(const PitCounts& counts, std::uint64_t units, ClaimedLaw law, double margin,
                                    double confidence);

/// The largest-deviation shape of `size` at u = i / 100, i = 1 .. 99, for figures: zero for an unknown shape.
std::vector<double> calibration_shape(const std::string& shape, double size, ClaimedLaw law);

}  // namespace surveymc::stats
