/// `chained_multistation`, study "interference": a disturbed field over the first stations, ignored, and estimated as a
/// free vector or as an amplitude of known direction (slide 12, future work 3).
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "chained/attitude.h"
#include "chained/block_solver.h"
#include "chained_multistation/parts.h"
#include "chained_multistation/quantities.h"
#include "compare/comparison.h"
#include "random/study_stream.h"
#include "stats/layout.h"

namespace surveymc::studies::chained_multistation {
namespace {

enum InterferenceWay { kUndisturbed, kIgnored, kVector, kDirection, kInterferenceWays };
constexpr std::array<const char*, kInterferenceWays> kInterferenceWayNames{"undisturbed", "ignored", "free_vector",
                                                                           "known_direction"};
constexpr std::array<const char*, 3> kInterferenceQuantities{"azimuth_deg", "horizontal_nT", "rejected"};

struct InterferenceCounts : stats::Layout {
  stats::Slots rejected = slots(kInterferenceWays), ended = slots(kInterferenceWays, stats::kDescentStatuses);
};
constexpr InterferenceCounts kInterferenceCounts;

struct Interference : Scenario {
  double size = 800;  ///< nT, of each component
  bool drawn = true;  ///< components normal with sd `size`; otherwise each is `size`
  int reported = 3;   ///< stations whose errors count
  double prior_sd = 2000, alpha = 0.01;
};

class ChainedInterference final : public study::StudyPoint {
 public:
  explicit ChainedInterference(Interference in) : in_(std::move(in)), stream_(random::stream_of(in_.seed)) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally tally;
    tally.counts.assign(kInterferenceCounts.size(), 0);
    std::array<Eigen::MatrixXd, kInterferenceWays> numbers;
    numbers.fill(Eigen::MatrixXd(block.count, 3));
    std::array<Eigen::Index, kInterferenceWays> rows{};
    for (int t = 0; t < block.count; ++t) {
      ++tally.trials;
      const std::uint64_t trial = block.first + static_cast<std::uint64_t>(t);
      bool converged = true;
      for (std::size_t way = 0; way < kInterferenceWays; ++way) {  // each leaves out its own failures only
        const Outcome o = outcome(trial, static_cast<InterferenceWay>(way));
        ++tally.counts[kInterferenceCounts.ended(way, static_cast<std::size_t>(o.status))];
        converged = converged && o.converged();
        if (!o.converged()) continue;
        tally.counts[kInterferenceCounts.rejected(way)] += o.rejected;
        numbers[way].row(rows[way]++) << o.azimuth2, o.horizontal2, o.claimed2;
      }
      if (converged) continue;
      tally.add_failed(trial);
    }
    for (std::size_t way = 0; way < kInterferenceWays; ++way)
      tally.groups.push_back(stats::Moments::of(numbers[way].topRows(rows[way])));
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    std::vector<compare::ComparisonRow> rows;
    for (std::size_t way = 0; way < kInterferenceWays; ++way) {
      const stats::Moments m = tally.groups.empty() ? stats::Moments() : tally.groups[way];
      for (Eigen::Index i = 0; i < 2; ++i) {
        const double claimed = i == 0 && m.count >= 2 ? std::sqrt(m.mean[2]) : kNaN;
        rows.push_back(compare::labelled(
            kInterferenceWayNames[way],
            compare::compare_value(kInterferenceQuantities[static_cast<std::size_t>(i)], i == 0 ? "deg" : "nT",
                                   compare::rms_estimate(m, i, in_.verdict.confidence), claimed, in_.verdict,
                                   tally.trials)));
        rows.back().note.clear();  // this table does not say how many trials would decide
      }
      rows.push_back(compare::labelled(
          kInterferenceWayNames[way],
          compare::compare_rate("rejected", tally.counts.empty() ? 0 : tally.counts[kInterferenceCounts.rejected(way)],
                                m.count, way == kIgnored ? kNaN : in_.alpha, in_.verdict, tally.trials)));
      for (std::size_t i = rows.size() - 3; i < rows.size(); ++i) rows[i].failed = tally.trials - m.count;
    }
    in_.annotations.apply("interference", rows);
    study::PointResult r;
    r.tables = {
        compare::comparison_table(
            "interference",
            fmt::format(
                "RMS over the first {} stations with a disturbed field, and how often chi-squared of the whole run "
                "rejects at {:g} %",
                in_.reported, 100 * in_.alpha) +
                compare::at_confidence(in_.verdict.confidence),
            rows, tally.trials, tally.failed),
        failures_table(tally)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    std::string text = fmt::format("trial {}\n", trial);
    for (std::size_t way = 0; way < kInterferenceWays; ++way) {
      const Outcome o = outcome(trial, static_cast<InterferenceWay>(way));
      text += fmt::format("{}: {}, RMS azimuth {:.12g} deg, cost {:.12g}\n", kInterferenceWayNames[way],
                          o.converged() ? "converged" : "NOT converged", std::sqrt(o.azimuth2), o.cost);
    }
    return text;
  }

 private:
  struct Outcome {
    chained::Status status = chained::Status::iteration_limit;
    bool rejected = false;
    bool converged() const { return status == chained::Status::converged; }
    double azimuth2 = 0, horizontal2 = 0, claimed2 = 0, cost = 0;  ///< mean squares: deg2, nT2, deg2 claimed
  };

  static store::Table failures_table(const stats::Tally& tally) {
    std::vector<Endings> endings;
    for (std::size_t way = 0; way < kInterferenceWays; ++way)
      endings.push_back({kInterferenceWayNames[way], kInterferenceCounts.ended(way)});
    return endings_table("how the trials of every formulation ended; each leaves out its own failures only",
                         "formulation", "what is made of the interference", endings, tally);
  }

  Outcome outcome(std::uint64_t trial, InterferenceWay way) const {
    sensor::ChainedRunSetup setup = in_.truth;
    chained::Model m = in_.model(chained::ChainReferences::chained);
    m.interference.rate = setup.interference_rate;
    m.interference.prior_sd = in_.prior_sd;
    const auto z = stream_.normals<double>(trial, random::Channel::chained_profile, std::uint64_t{0});
    Eigen::Vector3d a = Eigen::Vector3d::Constant(in_.size);
    if (in_.drawn) a = in_.size * Eigen::Vector3d(z[0], z[1], z[2]);
    if (way != kUndisturbed) setup.interference = survey::from_eigen(a);
    if (way == kVector) m.interference.directions.setIdentity(3, 3);
    if (way == kDirection) {
      m.interference.directions.setZero(3, 1);
      m.interference.directions.col(0) = a.normalized();
    }
    const sensor::ChainedRun run = sensor::simulate_chained_run(setup, stream_, trial);
    const chained::Solution x = chained::solve_blocks(m, {run.readings, {}});
    Outcome o;
    o.status = x.status;
    o.cost = x.cost;
    o.rejected = stats::chi_squared_upper_tail(3.0 * in_.stations(), x.cost) < in_.alpha;
    if (!o.converged()) return o;
    const RunCheck check = check_chained(in_, run, x);
    for (int k = 0; k < in_.reported; ++k) {
      const StationCheck& c = check.stations[static_cast<std::size_t>(k)];
      o.azimuth2 += c.error[0] * c.error[0] / in_.reported;
      o.horizontal2 += c.error[4] * c.error[4] / in_.reported;
      o.claimed2 += c.claimed_sd[0] * c.claimed_sd[0] / in_.reported;
    }
    return o;
  }

  Interference in_;
  random::Stream stream_;
};

}  // namespace

std::unique_ptr<study::PointPlan> interference_plan(config::ConfigReader& c, random::StudySeed seed) {
  Interference in{read_scenario_of_fixed_length(c, seed)};
  c.require(in.stations() <= 200, "profile.stations", "at most 200: every run is solved several times");
  in.size = c.number("interference.size_nT", config::Range::closed(0, 1e5),
                     "size of the disturbing field at the first station", 800);
  in.drawn = c.choice("interference.law", {"normal", "constant"},
                      "'normal': components in north, east and vertical are drawn; 'constant': each has the size",
                      "normal") == "normal";
  in.truth.interference_rate =
      c.number("interference.rate", config::Range::non_negative(), "decay: times (1 + rate k)^-2 at station k", 0.35);
  in.prior_sd = c.number("interference.prior_sd_nT", config::Range::positive(),
                         "one sd of the disturbance that the estimators assume", 2000);
  in.alpha = c.number("interference.alpha", config::Range::open(0, 1), "level of the test of a run", 0.01);
  in.reported = static_cast<int>(
      c.integer("interference.stations", 1, in.stations(), "stations that are disturbed and looked at", 3));
  c.require(in.size > 0, "interference.size_nT", "must be > 0: a direction has to be known");
  std::vector<compare::Row> rows;
  for (const char* way : kInterferenceWayNames)
    for (const char* q : kInterferenceQuantities) rows.push_back({"interference", way, q});
  in.annotations = compare::Annotations::read(c, rows);
  c.finish();
  return std::make_unique<study::PlanOfPoint<Interference, ChainedInterference, 32>>(std::move(in));
}

}  // namespace surveymc::studies::chained_multistation
