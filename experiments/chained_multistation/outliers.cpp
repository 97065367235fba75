/// `chained_multistation`, study "outliers": one wrong reading in a run. Is the error found? Is the right station
/// blamed, and the right reading? What is the effect of the remedies on the azimuth (slide 12, future work 2)?
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "analysis/outlier_event.h"
#include "base/units.h"
#include "chained/attitude.h"
#include "chained/block_solver.h"
#include "chained/reading_tests.h"
#include "chained_multistation/parts.h"
#include "chained_multistation/quantities.h"
#include "compare/comparison.h"
#include "compare/table_rows.h"
#include "config/readings_csv.h"
#include "events/event_study.h"
#include "random/rare_channels.h"
#include "random/study_stream.h"
#include "stats/layout.h"
#include "stats/normal_tail.h"
#include "stats/order_statistics.h"

namespace surveymc::studies::chained_multistation {
namespace {

constexpr std::array<const char*, 6> kReadingNames{"ax", "ay", "az", "hx", "hy", "hz"};

enum OutlierEvent {
  kFalseAlarm,    ///< some test is beyond the gate though no reading is wrong
  kOwnTest,       ///< the wrong reading's own test is beyond the gate
  kDetected,      ///< some test is beyond the gate
  kStationRight,  ///< detected, and the suspect station is the right one
  kReadingRight,  ///< detected, and the suspect reading is the right one
  kDeleted,       ///< one reading is clearly dominant
  kDeletedWrong,  ///< the dominant reading is not the wrong one
  kOutlierEvents
};
constexpr std::array<const char*, kOutlierEvents> kOutlierEventNames{
    "false_alarm", "own_test", "detected", "station_right", "reading_right", "deleted", "deleted_wrong"};
/// Squared azimuth errors (deg2) at the station of the error.
enum Remedy { kClean, kErrorIgnored, kLargestDeleted, kGated, kRemedies };
constexpr std::array<const char*, kRemedies> kRemedyNames{"azimuth_clean_deg", "azimuth_ignored_deg",
                                                          "azimuth_largest_deleted_deg", "azimuth_gated_deg"};
constexpr const char* kWronglyDeleted = "azimuth_wrong_deleted_deg";  // where the largest is not the wrong one
constexpr std::size_t kW = kRemedies;  // after them: the mean square of all w, without an error; shift of its own w
constexpr std::size_t kNumbers = kW + 5;

constexpr std::size_t kSolves = 3;
constexpr std::array<const char*, kSolves> kSolveNames{"clean", "wrong", "deleted"};

struct OutlierCounts : stats::Layout {
  stats::Slots events = slots(kOutlierEvents), ended = slots(kSolves, stats::kDescentStatuses);
};
constexpr OutlierCounts kOutlierCounts;

struct Outliers : Scenario {
  std::size_t axis = 0;
  int station = 0;  ///< from 0
  double size = 0;  ///< m/s2 or nT
  chained::Gate gate = {};
  double unit() const { return axis < 3 ? kMilliG : 1; }
  const char* unit_name() const { return axis < 3 ? "mg" : "nT"; }
};

constexpr int kBlockRuns = 32;

struct HeldEvent {
  Outliers of;
  chained::Model model;
};

struct HeldState {
  std::shared_ptr<const HeldEvent> held;
  analysis::OutlierDeletedWrong state;
};

std::vector<events::TrialEvent> events_of(const Outliers& o, const std::vector<events::EventRule>& rules) {
  const auto held = std::make_shared<const HeldEvent>(HeldEvent{o, o.model(chained::ChainReferences::chained)});
  std::vector<events::TrialEvent> events;
  for (const events::EventRule& rule : rules) {
    const auto own = std::make_shared<const HeldState>(HeldState{
        held, analysis::OutlierDeletedWrong(held->of.truth, held->model, {o.station, o.axis, o.size}, o.gate)});
    events::TrialEvent e;
    e.name = rule.name;
    e.state = {own, &own->state};
    e.from = own->state.addresses(random::kRareChoice);
    e.normals = own->state.names();
    e.place = rule.place;
    events.push_back(std::move(e));
  }
  return events;
}

class ChainedOutliers final : public study::StudyPoint {
 public:
  explicit ChainedOutliers(Outliers o)
      : o_(std::move(o)), model_(o_.model(chained::ChainReferences::chained)), stream_(random::stream_of(o_.seed)) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally tally;
    tally.counts.assign(kOutlierCounts.size(), 0);
    Eigen::MatrixXd numbers(block.count, kNumbers);
    Eigen::Index row = 0;
    for (int t = 0; t < block.count; ++t) {
      ++tally.trials;
      const std::uint64_t trial = block.first + static_cast<std::uint64_t>(t);
      Ends ends;
      const std::optional<RunOutcome> r = outcome(trial, ends);
      for (std::size_t i = 0; i < ends.size(); ++i)
        if (ends[i]) ++tally.counts[kOutlierCounts.ended(i, static_cast<std::size_t>(*ends[i]))];
      if (!r) {
        tally.add_failed(trial);
        continue;
      }
      for (std::size_t e = 0; e < kOutlierEvents; ++e) tally.counts[e] += r->events[e];
      numbers.row(row++) = Eigen::Map<const Eigen::RowVectorXd>(r->numbers.data(), kNumbers);
    }
    tally.moments = stats::Moments::of(numbers.topRows(row));
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    study::PointResult r;
    r.tables = {outliers_table(tally), detectable_table(), failures_table(tally)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    Ends ends;
    const std::optional<RunOutcome> r = outcome(trial, ends);
    std::string text = fmt::format("trial {}: {}\n", trial, r ? "converged" : "NOT converged");
    if (!r) return text;
    for (std::size_t e = 0; e < kOutlierEvents; ++e)
      text += fmt::format("  {} {}\n", kOutlierEventNames[e], r->events[e]);
    for (std::size_t k = 0; k < kRemedies; ++k)
      text += fmt::format("  {} {:.12g}\n", kRemedyNames[k], std::sqrt(r->numbers[k]));
    return text;
  }

 private:
  struct RunOutcome {
    std::array<bool, kOutlierEvents> events{};
    std::array<double, kNumbers> numbers{};
  };

  double azimuth_error2(const sensor::ChainedRun& run, const chained::Solution& x) const {
    const auto k = static_cast<std::size_t>(o_.station);
    const double e =
        std::remainder(chained::attitude_of(x.stations[k].frame).azimuth - run.attitudes[k].azimuth, 2 * kPi);
    return (e / kDegree) * (e / kDegree);
  }

  /// How the solutions of a run ended; none: it was not needed.
  using Ends = std::array<std::optional<chained::Status>, kSolves>;

  static store::Table failures_table(const stats::Tally& tally) {
    std::vector<Endings> endings;
    for (std::size_t i = 0; i < kSolves; ++i) endings.push_back({kSolveNames[i], kOutlierCounts.ended(i)});
    return endings_table("how the solutions of the runs ended; a run is compared if all of its solutions converged",
                         "solution", "without the error, with it, or with the largest residual deleted", endings,
                         tally);
  }

  std::optional<RunOutcome> outcome(std::uint64_t trial, Ends& ends) const {
    const sensor::ChainedRun run = sensor::simulate_chained_run(o_.truth, stream_, trial);
    const auto k = static_cast<std::size_t>(o_.station);
    chained::Readings clean{run.readings, {}}, wrong = clean;
    wrong.y[k][o_.axis] += o_.size;
    const chained::Solution without = chained::solve_blocks(model_, clean), with = chained::solve_blocks(model_, wrong);
    ends[0] = without.status;
    ends[1] = with.status;
    if (!without.converged || !with.converged) return std::nullopt;
    const chained::ReadingTests clean_tests = chained::reading_tests(model_, clean, without),
                                tests = chained::reading_tests(model_, wrong, with);
    const chained::Suspect suspect = chained::find_suspect(tests, o_.gate);
    const bool station_right = suspect.station == o_.station, right = station_right && suspect.axis == o_.axis;
    RunOutcome r;
    r.events = {chained::find_suspect(clean_tests, o_.gate).found,
                std::abs(tests.w[k][o_.axis]) > o_.gate.gate,
                suspect.found,
                suspect.found && station_right,
                suspect.found && right,
                suspect.dominant,
                suspect.dominant && !right};
    r.numbers[kClean] = azimuth_error2(run, without);
    r.numbers[kErrorIgnored] = r.numbers[kLargestDeleted] = r.numbers[kGated] = azimuth_error2(run, with);
    if (suspect.found) {
      chained::Readings deleted = wrong;
      deleted.left_out.assign(run.readings.size(), {});
      deleted.left_out[static_cast<std::size_t>(suspect.station)][suspect.axis] = true;
      const chained::Solution again = chained::solve_blocks(model_, deleted);
      ends[2] = again.status;
      if (!again.converged) return std::nullopt;
      r.numbers[kLargestDeleted] = azimuth_error2(run, again);
      if (!right) {
        r.numbers[kW + 3] = 1;
        r.numbers[kW + 4] = r.numbers[kLargestDeleted];
      }
      if (suspect.dominant) r.numbers[kGated] = r.numbers[kLargestDeleted];
    }
    double squares = 0;
    for (const auto& station : clean_tests.w)
      for (const double w : station) squares += w * w;
    r.numbers[kW] = squares / (6 * static_cast<double>(clean_tests.w.size()));
    r.numbers[kW + 1] = tests.w[k][o_.axis] - clean_tests.w[k][o_.axis];
    r.numbers[kW + 2] = o_.size / model_.noise[o_.axis] * clean_tests.sensitivity[k][o_.axis];
    return r;
  }

  store::Table outliers_table(const stats::Tally& tally) const {
    std::vector<compare::ComparisonRow> rows;
    const std::uint64_t runs = tally.trials - tally.failed;
    // Linear theory: its own test is normal about the shift, averaged over the drawn toolfaces by its mean only
    const double shift = tally.moments.count > 0 ? tally.moments.mean[kW + 2] : kNaN;
    const double power =
        stats::normal_upper_tail(o_.gate.gate - shift) + stats::normal_upper_tail(o_.gate.gate + shift);
    for (std::size_t e = 0; e < kOutlierEvents; ++e) {
      rows.push_back(compare::compare_rate(kOutlierEventNames[e], tally.counts.empty() ? 0 : tally.counts[e], runs,
                                           e == kOwnTest ? power : kNaN, o_.verdict, tally.trials));
      // The toolfaces scatter the shift: only a rough prediction.
      if (e == kOwnTest) compare::leave_unjudged(rows.back(), "analytic at the mean shift of its test");
    }
    const auto rms = [&](const std::string& quantity, const std::string& unit, std::size_t i, double analytic) {
      rows.push_back(compare::compare_value(
          quantity, unit, compare::rms_estimate(tally.moments, static_cast<Eigen::Index>(i), o_.verdict.confidence),
          analytic, o_.verdict, tally.trials));
      rows.back().note.clear();  // this table does not say how many trials would decide
    };
    for (std::size_t i = 0; i < kRemedies; ++i) rms(kRemedyNames[i], "deg", i, kNaN);
    compare::ComparisonRow wrong;
    wrong.quantity = kWronglyDeleted;
    wrong.unit = "deg";
    if (tally.moments.count > 0 && tally.moments.mean[kW + 3] > 0) {
      wrong.monte_carlo = std::sqrt(tally.moments.mean[kW + 4] / tally.moments.mean[kW + 3]);
      wrong.note = fmt::format("{:.0f} runs", tally.moments.mean[kW + 3] * static_cast<double>(tally.moments.count));
    }
    rows.push_back(wrong);
    rms("w_rms", "1", kW, 1);
    o_.annotations.apply("outliers", rows);
    return compare::comparison_table(
        "outliers",
        fmt::format("{} {:+g} {} at station {}: found, blamed, and what the remedies do to its "
                    "azimuth (RMS)",
                    kReadingNames[o_.axis], o_.size / o_.unit(), o_.unit_name(), o_.station + 1) +
            compare::at_confidence(o_.verdict.confidence),
        rows, tally.trials, tally.failed);
  }

  /// Of every reading of the station, at the first trial's toolfaces.
  store::Table detectable_table() const {
    std::array<std::vector<double>, 6> sizes;
    constexpr int kRuns = 201;
    for (std::uint64_t trial = 0; trial < kRuns; ++trial) {
      const chained::Readings y{sensor::simulate_chained_run(o_.truth, stream_, trial).readings, {}};
      const chained::ReadingTests tests = chained::reading_tests(model_, y, chained::solve_blocks(model_, y));
      for (std::size_t i = 0; i < 6; ++i)
        sizes[i].push_back(
            chained::minimal_detectable(model_, tests, static_cast<std::size_t>(o_.station), i, o_.gate.gate));
    }
    compare::TableRows t("detectable",
                         "minimal detectable errors of the station's readings, 80 % power at the gate; median over the "
                         "toolfaces of the first 201 runs");
    for (std::size_t i = 0; i < 6; ++i) {
      t.word("reading", "accelerometer a, magnetometer h", kReadingNames[i]);
      t.word("unit", "of the error", i < 3 ? "mg" : "nT");
      t.number("minimal_detectable_error", "1", "in the row's unit", stats::median(sizes[i]) / (i < 3 ? kMilliG : 1.0));
    }
    return t.take();
  }

  Outliers o_;
  chained::Model model_;
  random::Stream stream_;
};

}  // namespace

std::unique_ptr<study::PointPlan> outliers_plan(config::ConfigReader& c, random::StudySeed seed) {
  const bool of_events = events::has_events(c);
  Outliers o{of_events ? read_scenario(c, seed, Purpose::events) : read_scenario_of_fixed_length(c, seed)};
  c.require(o.stations() <= 200, "profile.stations", "at most 200: every run is solved several times");
  const std::string reading =
      c.choice("outliers.reading", {kReadingNames.begin(), kReadingNames.end()}, "the reading in error");
  o.axis =
      static_cast<std::size_t>(std::find(kReadingNames.begin(), kReadingNames.end(), reading) - kReadingNames.begin());
  o.station =
      static_cast<int>(c.integer("outliers.station", 1, o.stations(),
                                 "the station in error, from 1; without it the middle one", (o.stations() + 1) / 2)) -
      1;
  o.size = o.unit() * c.number(fmt::format("outliers.size_{}", o.unit_name()),
                               o.axis < 3 ? config::Range::closed(-500, 500) : config::Range::closed(-1e5, 1e5),
                               "size of the gross error");
  o.gate.gate = c.number("outliers.gate", config::Range::open(0, 100),
                         "a reading is rejected beyond this normalised residual", o.gate.gate);
  o.gate.dominance = c.number("outliers.dominance", config::Range::non_negative(),
                              "a reading is deleted if its squared residual is so much above the next of its station",
                              o.gate.dominance);
  if (of_events) {
    const events::EventRun run = events::read_event_run(c);
    const compare::Annotations annotations = events::read_event_annotations(c, {});
    const std::vector<events::EventRule> events =
        events::read_events(c, {{kOutlierEventNames[kDeletedWrong], events::EventLimits::none}});
    c.finish();
    return events::event_plan(
        run, annotations, random::stream_of(seed), [o, events] { return events_of(o, events); }, kBlockRuns);
  }
  std::vector<compare::Row> rows;
  for (const char* e : kOutlierEventNames) rows.push_back({"outliers", "", e});
  for (const char* k : kRemedyNames) rows.push_back({"outliers", "", k});
  for (const char* q : {kWronglyDeleted, "w_rms"}) rows.push_back({"outliers", "", q});
  o.annotations = compare::Annotations::read(c, rows);
  c.finish();
  return std::make_unique<study::PlanOfPoint<Outliers, ChainedOutliers, kBlockRuns>>(std::move(o));
}

}  // namespace surveymc::studies::chained_multistation
