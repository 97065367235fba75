#pragma once
#include <string>

#include "stats/tally.h"
#include "study/experiment.h"

namespace surveymc::study {

/// The sizes of tallies of a point's trials, to check tallies that come from files: report() indexes them without a
/// check.
class TallySizes {
 public:
  static constexpr std::uint64_t kTrials = 2;  ///< an antithetic pair

  /// Runs two trials at most; none for a study without trials.
  TallySizes(const StudyPoint& point, std::uint64_t trials);

  /// Throws IoError if this tally cannot be merged with those of the point. `whose`: the file, or what it is.
  void require(const stats::Tally& part, const std::string& whose) const;

  /// Throws IoError if the tally of all trials, which may have come from files, has less than report() may ask for.
  void require_whole(const stats::Tally& whole, const std::string& whose) const;

 private:
  stats::Tally ours_;
};

}  // namespace surveymc::study
