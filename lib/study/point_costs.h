#pragma once
/// Predicted costs of the points of a run, summed, for tasks of about the same cost.
#include <cstdint>
#include <vector>

#include "checkpoint/part_file.h"
#include "study/experiment.h"

namespace surveymc::study {

/// Reads every point of a sweep of up to kMostReadWhole points. Of a larger one:
/// * The cost of a product is taken to be a product of functions of one key each. They are found with the first values
///   of the other keys. Where random points do not agree with that, and of another design:
/// * A random point of each of kMostReadWhole ranges of the same length stands for its range.
/// Points that cannot be read cost nothing. The same points are read each time.
class PointCosts {
 public:
  explicit PointCosts(const RunPlan& run);

  /// Total cost of the points before `end`, in the unit of PointPlan::cost().
  double before(std::uint64_t end) const;
  /// Divides the points into `count` ranges (fewer if there are fewer points) of nearly equal cost, in order, none of
  /// them empty.
  std::vector<checkpoint::PointRange> ranges(std::uint64_t count) const;

 private:
  /// Factors of `size` values of a key, equal within ranges.
  struct Axis {
    std::uint64_t size = 1;
    std::vector<double> factors, upto;  ///< of each range; sum of the values before it, and of all

    explicit Axis(std::uint64_t of_size, std::vector<double> of_ranges);
    std::uint64_t first_of(std::uint64_t range) const { return first(range, size, factors.size()); }
    static std::uint64_t first(std::uint64_t range, std::uint64_t of_size, std::uint64_t ranges);
    std::uint64_t range_of(std::uint64_t value) const;
    double before(std::uint64_t value) const;
    double at(std::uint64_t value) const { return factors[range_of(value)]; }
  };

  bool read_product(const RunPlan& run);
  void read_ranges(const RunPlan& run);
  double at(std::uint64_t point) const;

  std::uint64_t points_;
  std::vector<Axis> axes_;  // the slowest first
};

}  // namespace surveymc::study
