#include "monitoring/aakr.h"

#include "base/error.h"
#include "monitoring/aakr_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::monitoring {

Aakr::Aakr(const Samples& memory, double bandwidth)
    : sensors_(static_cast<int>(memory.cols())),
      vectors_(static_cast<int>(memory.rows())),
      bandwidth_(bandwidth),
      padded_((static_cast<std::size_t>(vectors_) + simd::kGroup - 1) / simd::kGroup * simd::kGroup) {
  require(vectors_ > 0 && sensors_ > 0, "AAKR: the memory is empty: must have at least one vector of one sensor");
  require(bandwidth > 0, "AAKR: bandwidth = {}: must be > 0", bandwidth);
  valid_.assign(padded_, 0.0);
  for (int i = 0; i < vectors_; ++i) valid_[static_cast<std::size_t>(i)] = 1;
  memory_.resize(padded_ * static_cast<std::size_t>(sensors_));
  for (std::size_t i = 0; i < padded_; ++i)
    for (int j = 0; j < sensors_; ++j)
      memory_[static_cast<std::size_t>(j) * padded_ + i] = memory(std::min(static_cast<int>(i), vectors_ - 1), j);
}

void Aakr::predict(const double* queries, int count, double* predictions, double* nearest, Scratch& scratch) const {
  scratch.resize(padded_);
  const AakrBatch batch{.memory = memory_.data(),
                        .valid = valid_.data(),
                        .padded = padded_,
                        .sensors = sensors_,
                        .minus_half_per_h2 = -0.5 / (bandwidth_ * bandwidth_),
                        .queries = queries,
                        .count = count,
                        .predictions = predictions,
                        .nearest = nearest,
                        .scratch = scratch.data()};
  if (simd::instruction_set() == simd::InstructionSet::v4)
    isa_v4::aakr_predict(batch);
  else
    isa_v3::aakr_predict(batch);
}

}  // namespace surveymc::monitoring
