#pragma once
/// Finished points of a study without trials in the journal, so that a killed run does not compute them again.
#include <atomic>
#include <optional>
#include <string_view>

#include "study/experiment.h"

namespace surveymc::study {

/// Larger results of a point are not kept but computed again: they would be in memory twice.
inline constexpr std::size_t kMostKeptBytes = std::size_t{64} << 20;

/// Keeps point_result_to_bytes() of a point, if there is a journal and the bytes are not too many.
void keep_point(checkpoint::Journal* journal, std::uint64_t point, std::string_view bytes);

/// The points of a run in one go. Values of streams that were kept are in memory from then on, and no longer computed
/// while the result is written; beyond kMostKeptStreams of them in all, streams stay as they are.
class KeptPoints {
 public:
  static constexpr std::size_t kMostKeptStreams = std::size_t{1} << 25;  // values: 256 MiB

  /// `checkpoint` outlives it. A run of one point keeps nothing: it is done when its point is.
  KeptPoints(const Checkpoint& checkpoint, std::size_t points) : checkpoint_(checkpoint), points_(points) {}
  /// The result that an earlier attempt has kept.
  std::optional<PointResult> find(std::uint64_t point);
  /// Keeps the result of a point, and gives it back.
  PointResult keep(std::uint64_t point, PointResult result);

 private:
  const Checkpoint& checkpoint_;
  const std::size_t points_;
  std::atomic<std::size_t> streamed_ = 0;  // several threads find and keep points
};

}  // namespace surveymc::study
