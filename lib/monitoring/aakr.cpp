#include "monitoring/aakr.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "monitoring/aakr_lanes.h"
#include "simd/instruction_set.h"
#include "stats/linear_algebra.h"

namespace surveymc::monitoring {
namespace {

using Eigen::Index;

/// Of length 1: the direction in which the vectors differ most.
Eigen::VectorXd main_direction(const Samples& memory) {
  const Samples centred = memory.rowwise() - memory.colwise().mean();
  return stats::symmetric_eigen(centred.transpose() * centred).vectors.col(memory.cols() - 1);
}

constexpr double kLn2 = 0.69314718055994530942;

/// log2 of 2 m / kNegligibleShare. Without a logarithm of libm, whose last bit changes between machines: log2 m is
/// rounded up to an integer.
double negligible_log2(int vectors) {
  constexpr double kPerNegligible = 29.933606208922594;  // -ln kNegligibleShare
  return std::bit_width(static_cast<unsigned>(vectors)) + kPerNegligible / kLn2;
}

}  // namespace

Aakr::Aakr(const Samples& memory, double bandwidth)
    : sensors_(static_cast<int>(memory.cols())),
      vectors_(static_cast<int>(memory.rows())),
      bandwidth_(bandwidth),
      padded_((static_cast<std::size_t>(vectors_) + kTile - 1) / kTile * kTile) {
  require(vectors_ > 0 && sensors_ > 0, "AAKR: the memory is empty: must have at least one vector of one sensor");
  require(bandwidth > 0, "AAKR: bandwidth = {}: must be > 0", bandwidth);
  constexpr double kFar = 1e150;  // its square is finite, and weighs nothing
  scale_ = std::sqrt(0.5 / (bandwidth * bandwidth * kLn2));
  direction_ = main_direction(memory);
  largest_norm_ = scale_ * memory.rowwise().norm().maxCoeff();
  const Eigen::VectorXd projection = scale_ * (memory * direction_);
  std::vector<Index> order(static_cast<std::size_t>(vectors_));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return projection[a] < projection[b]; });
  memory_.assign(static_cast<std::size_t>(sensors_) * padded_, kFar);
  for (std::size_t j = 0; j < static_cast<std::size_t>(sensors_); ++j)
    for (std::size_t i = 0; i < order.size(); ++i)
      memory_[j * padded_ + i] = scale_ * memory(order[i], static_cast<Index>(j));
  for (std::size_t i = 0; i < order.size(); i += kTile) {
    low_.push_back(projection[order[i]]);
    high_.push_back(projection[order[std::min(i + kTile, order.size()) - 1]]);
  }
}

double Aakr::cutoff() const { return 2 * bandwidth_ * bandwidth_ * kLn2 * negligible_log2(vectors_); }

AakrBatch Aakr::batch(const double* queries, int count, double* predictions, double* nearest, Scratch& scratch) const {
  scratch.resize(padded_ + static_cast<std::size_t>(sensors_));
  return {.memory = memory_.data(),
          .direction = direction_.data(),
          .low = low_.data(),
          .high = high_.data(),
          .padded = padded_,
          .tiles = low_.size(),
          .sensors = sensors_,
          .cutoff = negligible_log2(vectors_),
          .rounding = 1e-12 * largest_norm_,
          .scale = scale_,
          .queries = queries,
          .count = count,
          .predictions = predictions,
          .nearest = nearest,
          .scaled = scratch.data() + padded_,
          .weights = scratch.data()};
}

void Aakr::predict(const double* queries, int count, double* predictions, double* nearest, Scratch& scratch) const {
  const AakrBatch b = batch(queries, count, predictions, nearest, scratch);
  simd::run_kernel<isa_v3::aakr_predict, isa_v4::aakr_predict>(b);
}

}  // namespace surveymc::monitoring
