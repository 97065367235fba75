#pragma once
/// How far a run is, by the work that it has kept: journals beside its output, or part files.
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/point_set.h"
#include "base/units.h"
#include "checkpoint/journal.h"
#include "cli/part_files.h"
#include "cli/verdict_counts.h"
#include "study/experiment.h"
#include "study/point_costs.h"

namespace surveymc::cli {

/// What is kept of a run at one moment.
struct SweepStatus {
  std::string title, experiment, config_hash;
  std::uint64_t points = 0;                     ///< of the whole run
  PointSet done;                                ///< whole points
  std::map<std::uint64_t, double> begun;        ///< of other points, the share of their trials that is kept
  std::map<std::uint64_t, std::string> failed;  ///< points that cannot be run, the first ones, with the reason
  std::size_t failed_count = 0;
  bool may_end_early = false;  ///< a stopping rule ends points before their largest number of trials
  double share = 0;            ///< of the work, by its predicted cost
  double computed_s = 0;       ///< time in which somebody worked at it
  double left_s = kNaN;        ///< at the same pace; NaN: not known
  double age_s = kNaN;         ///< since something was kept; NaN: nothing is
  VerdictCounts verdicts;      ///< of the points that were looked at
  std::size_t judged = 0;      ///< how many these are
  std::vector<std::pair<std::string, double>> slowest;  ///< parts or points that took longest, s
  std::map<std::uint64_t, std::string> names;           ///< "noise.scale = 0.5": of the points named above
  bool finished = false;                                ///< the result is written
};

/// Lines for a terminal, without the title.
std::vector<std::string> status_lines(const SweepStatus& status);

/// A page of its own for a browser. `refresh_s`: it loads itself again after this time; 0: never.
std::string status_page(const std::vector<SweepStatus>& runs, double refresh_s);

/// The mark of such a page, which only another one may replace.
inline constexpr const char* kStatusPageMark = "<!-- surveymc status -->";

/// Looks at one run again and again. What a point's verdicts are is computed once.
class SweepWatch {
 public:
  explicit SweepWatch(study::RunPlan run);
  const study::RunPlan& run() const { return run_; }

  /// The run by its parts and by these journals, all of which are of this run. Verdicts of points that are done are
  /// looked at for about `seconds`, the rest in a later call. Throws Interrupted where the program is stopped.
  SweepStatus look(const std::vector<ListedPart>& parts, const std::vector<std::filesystem::path>& journals,
                   double seconds);

 private:
  using Clock = std::chrono::steady_clock;
  struct Seen {
    double begun_s = kNaN, done_s = kNaN;  ///< since the first look; NaN: before it, or not yet
  };
  struct Kept;

  double cost(std::uint64_t first, std::uint64_t end) const;
  void judge(std::uint64_t point, const store::Result& tables);
  void judge_journals(Kept& kept, Clock::time_point until);
  void judge_parts(const std::vector<ListedPart>& parts, const study::Coverage& there, Clock::time_point until);
  void note_times(const SweepStatus& status);
  void add_slowest(SweepStatus& status, const std::vector<ListedPart>& parts) const;

  study::RunPlan run_;
  std::optional<study::PointCosts> costs_;  ///< none of a large sweep: all points count the same there
  std::set<std::uint64_t> judged_;
  std::set<std::string> judged_parts_;  ///< all of whose whole points are
  std::map<std::uint64_t, std::uint64_t>
      not_whole_;  ///< trials with which a point was looked at and was not at its end
  std::map<std::uint64_t, std::string> failed_;
  std::size_t failed_count_ = 0;
  VerdictCounts verdicts_;
  Clock::time_point start_ = Clock::now();
  bool is_first_ = true;
  std::map<std::uint64_t, Seen> seen_;
  double first_work_ = 0, last_work_ = 0, last_work_s_ = 0;  ///< at the first look; now, and since when, s after it
};

}  // namespace surveymc::cli
