/// Study: do the corrected tool codes hold? The errors of a base code are drawn as readings of six axes in a field that
/// is not its reference, the readings are corrected as is really done, and what is left is held against the covariance
/// that the corrected code claims. Every number is computed to first order without trials, too.
///
///   tool code -> sizes (propagate) -> readings (sensor) -> gains and biases (estimate) -> minimum curvature (survey)
#include "corrected_codes/study.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/order_rows.h"
#include "random/study_stream.h"
#include "scenario/disturbance.h"
#include "scenario/parameter_set.h"
#include "stats/sample_summary.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::corrected_codes {

using analysis::CodeQuantity;
using analysis::CodeScope;

namespace {

constexpr int kBatch = 64;  // trials: their readings stay in the cache
constexpr std::array<double, kTails> kBeyond{2, 3};
constexpr double kMostLost = 0.01;  // share of the trials without a solution

}  // namespace

/// Of a batch of trials: positions before and after (m), lateral parts of the directions before and after (rad).
struct CorrectedCodesPoint::Errors {
  Eigen::MatrixXd position, before, after;
  std::vector<bool> converged, ambiguous;
};

namespace {

std::vector<std::string> tail_names() {
  std::vector<std::string> names;
  for (const CodeQuantity q : kPositions) names.emplace_back(analysis::kCodeQuantities[static_cast<std::size_t>(q)]);
  return names;
}

}  // namespace

std::vector<compare::Row> rows_of(const Scenario& s, const analysis::CodeComparison* c,
                                  const orders::Predictions* orders) {
  std::vector<compare::Row> rows;
  const auto add = [&](CodeQuantity q, int component) {
    compare::Row row{.table = "prediction",
                     .quantity = std::string("ratio_") + analysis::kCodeQuantities[static_cast<std::size_t>(q)],
                     .unit = "1",
                     .statistic = compare::Statistic::sd,
                     .component = component,
                     .available = std::find(s.quantities.begin(), s.quantities.end(), q) != s.quantities.end()};
    if (c) {
      const analysis::CodeSds sds =
          analysis::code_sds(*c, *s.well, q, CodeScope::magnetic, c->stations.fields.size() - 1);
      row.sigmas = 1 / sds.claimed;
      row.prediction = sds.after;
    }
    rows.push_back(row);
  };
  for (std::size_t i = 0; i < kPositionCount; ++i) add(kPositions[i], static_cast<int>(kPositionCount + i));
  add(CodeQuantity::azimuth, -1);
  const std::vector<compare::Row> tails = compare::tail_rows(tail_names(), s.tails);
  if (!s.orders.any()) {
    rows.insert(rows.end(), tails.begin(), tails.end());
    return rows;
  }
  for (compare::Row& row : rows) row.formulation = "first";
  for (const std::string& name : s.orders.names) {
    if (name == "first") continue;
    const std::optional<orders::Moments> m = orders ? orders->of(name) : std::nullopt;
    for (std::size_t i = 0; i < kPositionCount; ++i) {
      if (kPositions[i] == CodeQuantity::worst) continue;
      compare::Row row = rows[i];
      row.formulation = name;
      row.prediction = kNaN;
      if (m) {
        const Eigen::RowVector3d along = analysis::code_direction(*c, *s.well, kPositions[i]);
        row.prediction = std::sqrt(along * m->covariance * along.transpose());
      }
      rows.push_back(row);
    }
  }
  rows.insert(rows.end(), tails.begin(), tails.end());
  return rows;
}

Judged judge(const Claim& c, double margin) {
  Judged j;
  j.predicted = analysis::code_verdict(c.sds.ratio(), margin);
  j.predicted_class = analysis::code_class(analysis::code_verdict(c.sds.ratio_before(), margin), j.predicted);
  if (std::isnan(c.after) && !c.lost) return j;
  const auto of = [&](const stats::Interval& i) {
    return analysis::code_verdict(i.lo / c.sds.claimed, i.hi / c.sds.claimed, margin);
  };
  j.verdict = c.lost ? "undetermined" : of(c.after_interval);
  j.judged_class = analysis::code_class(of(c.before_interval), j.verdict);
  return j;
}

CorrectedCodesPoint::CorrectedCodesPoint(Scenario scenario) : s_(std::move(scenario)) {
  if (!s_.well || !s_.latitude_deg.empty()) return;  // a map over places has many fields
  comparison_ = analysis::compare_code(*s_.well, s_.field, s_.which, s_.wants(CodeScope::total));
  if (s_.trials > 0 || s_.orders.any()) {
    runs_.emplace(s_.which, *s_.well, s_.field, *comparison_);
    runs_->set_laws(s_.laws);
  }
  if (s_.orders.any() && comparison_->after.determined)
    orders_ = orders::predict(runs_->chain(), s_.orders.wanted, orders::first_order_directions);
  rows_ = rows_of(s_, &*comparison_, orders_ ? &*orders_ : nullptr);
  for (std::size_t i = 0; i < kPositionCount; ++i) {
    directions_[i] = analysis::code_direction(*comparison_, *s_.well, kPositions[i]);
    claimed_[i] = std::sqrt(directions_[i] * comparison_->magnetic.position * directions_[i].transpose());
  }
  for (std::size_t k = 1; k < comparison_->magnetic.azimuth.size(); ++k)
    claimed_azimuth_.push_back(std::sqrt(comparison_->magnetic.azimuth[k]));
  predict_tails();
}

void CorrectedCodesPoint::predict_tails() {
  constexpr std::array<std::uint32_t, 3> kRunDraws{15, 14, 13};  // of Channel::disturbed_run
  const analysis::CorrectedErrors& after = comparison_->after;
  for (std::size_t e = 0; e < 3; ++e)
    if (s_.laws.elements[e].law && s_.laws.global && runs_)
      law_draws_.push_back({static_cast<random::ReferenceElement>(e),
                            runs_->setup().slots[static_cast<std::size_t>(runs_->setup().slot_of[e])],
                            random::Channel::disturbed_run, kRunDraws[e]});
  if (!s_.tails.wanted) return;
  // Shares V as the draws do: of one time one slot an element, or one for all.
  const auto add = [&](const std::array<Eigen::Vector3d, 3>& effects, const Eigen::RowVector3d& u, double sd,
                       std::vector<stats::HeavyPart>& parts) {
    double all = 0;
    std::shared_ptr<const random::MixingLaw> shared;
    for (std::size_t e = 0; e < 3; ++e) {
      const auto& law = s_.laws.elements[e].law;
      const double x = u * effects[e];
      if (!law || x == 0) continue;
      if (s_.laws.shared_mixing) {
        all += x * x;
        shared = law;
      } else {
        parts.push_back({law, x / sd});
      }
    }
    if (shared) parts.push_back({shared, std::sqrt(all) / sd});
  };
  for (std::size_t i = 0; i < kPositionCount; ++i) {
    compare::TailQuantity q;
    q.name = analysis::kCodeQuantities[static_cast<std::size_t>(kPositions[i])];
    if (after.determined) {
      q.sd = std::sqrt(directions_[i] * after.covariance() * directions_[i].transpose());
      if (s_.laws.global) add(after.run_reference, directions_[i], q.sd, q.parts);
      for (const auto& station : after.station_reference)
        if (s_.laws.random) add(station, directions_[i], q.sd, q.parts);
    }
    tails_.push_back(q);
  }
}

CorrectedCodesPoint::Errors CorrectedCodesPoint::simulate(std::uint64_t first, int count) const {
  const int stations = runs_->stations();
  const random::Stream stream = random::stream_of(s_.seed);
  survey::LaneArray made;
  if (s_.disturbed) {
    made = survey::LaneArray(survey::groups_for(count), 3 * stations);
    s_.disturbed->fill(stream, first, false, survey::groups_for(count), made);
  }
  const CorrectedRun run = runs_->run(stream, first, count, s_.disturbed ? &made : nullptr);
  Errors out{Eigen::MatrixXd(count, 2 * static_cast<int>(kPositionCount)),
             Eigen::MatrixXd(count, stations),
             Eigen::MatrixXd(count, stations),
             {},
             {}};
  for (int t = 0; t < count; ++t) {
    bool sound = run.converged.value(t, 0) != 0;
    for (std::size_t state = 0; state < 2; ++state) {
      const survey::LaneArray& p = run.position[state];
      const Eigen::Vector3d error = Eigen::Vector3d(p.value(t, 0), p.value(t, 1), p.value(t, 2)) - runs_->position();
      for (std::size_t i = 0; i < kPositionCount; ++i)
        out.position(t, static_cast<int>(state * kPositionCount + i)) = directions_[i] * error;
      Eigen::MatrixXd& turned = state == 0 ? out.before : out.after;
      for (int k = 0; k < stations; ++k) turned(t, k) = run.lateral[state].value(t, k);
      sound = sound && error.allFinite();
    }
    out.converged.push_back(sound);
    out.ambiguous.push_back(run.ambiguous.value(t, 0) != 0);
  }
  return out;
}

stats::Tally CorrectedCodesPoint::run_block(montecarlo::TrialBlock block) const {
  const int stations = runs_->stations();
  Eigen::MatrixXd position(block.count, 2 * static_cast<int>(kPositionCount)), before(block.count, stations),
      after(block.count, stations);
  stats::Tally tally;
  Eigen::Index kept = 0;
  std::uint64_t ambiguous = 0;
  for (int from = 0; from < block.count; from += kBatch) {
    const int count = std::min(kBatch, block.count - from);
    const std::uint64_t first = block.first + static_cast<std::uint64_t>(from);
    const Errors e = simulate(first, count);
    for (int t = 0; t < count; ++t) {
      ++tally.trials;
      ambiguous += e.ambiguous[static_cast<std::size_t>(t)];
      if (!e.converged[static_cast<std::size_t>(t)]) {
        tally.add_failed(first + static_cast<std::uint64_t>(t));
        continue;
      }
      position.row(kept) = e.position.row(t);
      before.row(kept) = e.before.row(t);
      after.row(kept++) = e.after.row(t);
    }
  }
  tally.moments = stats::Moments::of(position.topRows(kept));
  const auto outside = [&](const auto& values, double claimed) {
    for (const double n : kBeyond)
      tally.counts.push_back(static_cast<std::uint64_t>((values.head(kept).array().abs() > n * claimed).count()));
  };
  for (std::size_t i = 0; i < kPositionCount; ++i)
    outside(position.col(static_cast<Eigen::Index>(kPositionCount + i)), claimed_[i]);
  for (int k = 0; k < stations; ++k) {
    Eigen::MatrixXd both(kept, 2);
    both << before.col(k).head(kept), after.col(k).head(kept);
    tally.groups.push_back(stats::Moments::of(both));
    outside(after.col(k), claimed_azimuth_[static_cast<std::size_t>(k)]);
  }
  tally.counts.push_back(ambiguous);
  if (s_.tails.wanted) {
    tally.counts.resize(tail_counts() + kPositionCount * s_.tails.k.size());
    for (std::size_t i = 0; i < kPositionCount; ++i)
      for (Eigen::Index t = 0; t < kept; ++t)
        compare::count_beyond(position(t, static_cast<Eigen::Index>(kPositionCount + i)), tails_[i].sd, s_.tails,
                              tally.counts.data() + tail_counts() + i * s_.tails.k.size());
  }
  compare::DrawnLaws::add(random::stream_of(s_.seed), law_draws_, block, false, tally);
  return tally;
}

std::vector<Claim> CorrectedCodesPoint::claims_of(const stats::Tally& tally) const {
  std::vector<Claim> claims;
  const double confidence = s_.verdict.confidence;
  // What first order does not determine is no correction, whatever the trials' descent ends at.
  const bool lost =
      tally.trials > 0 && (!comparison_->after.determined ||
                           static_cast<double>(tally.failed) > kMostLost * static_cast<double>(tally.trials));
  // Of a component of moments with the variance of what was not drawn.
  const auto fill = [&](Claim& c, const stats::Moments& m, Eigen::Index before, Eigen::Index after, double carried,
                        std::size_t counts) {
    c.lost = lost;
    if (m.count < 2) return;
    const auto with_carried = [&](double sd) { return std::sqrt(sd * sd + carried); };
    const auto set = [&](Eigen::Index i, double& value, stats::Interval& interval) {
      const stats::SampleSummary x = stats::summarise(m, i);
      const stats::Interval ci = stats::sd_interval(x, confidence);
      value = with_carried(std::sqrt(x.variance));
      interval = {with_carried(ci.lo), with_carried(ci.hi)};
    };
    set(before, c.before, c.before_interval);
    set(after, c.after, c.after_interval);
    c.mean = m.mean[after];
    if (c.scope == CodeScope::total) return;  // what is carried is in no trial
    c.beyond2 = static_cast<std::int64_t>(tally.counts[counts]);
    c.beyond3 = static_cast<std::int64_t>(tally.counts[counts + 1]);
  };
  const std::size_t stations = comparison_->stations.fields.size();
  for (const CodeScope scope : s_.scopes) {
    const bool all = scope == CodeScope::total;
    for (const CodeQuantity q : s_.quantities) {
      const bool azimuth = q == CodeQuantity::azimuth;
      for (std::size_t k = azimuth ? 0 : stations - 1; k < stations; ++k) {
        Claim c;
        c.quantity = q;
        c.scope = scope;
        c.station = k;
        c.md = s_.well->stations[k + 1].md;
        c.sds = analysis::code_sds(*comparison_, *s_.well, q, scope, k);
        if (azimuth) {
          if (tally.trials > 0)
            fill(c, tally.groups[k], 0, 1, all ? comparison_->carried.azimuth[k + 1] : 0,
                 kTails * (kPositionCount + k));
        } else if (tally.trials > 0) {
          const auto i =
              static_cast<std::size_t>(std::find(kPositions.begin(), kPositions.end(), q) - kPositions.begin());
          const double carried =
              all ? double(directions_[i] * comparison_->carried.position * directions_[i].transpose()) : 0;
          fill(c, tally.moments, static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(kPositionCount + i), carried,
               kTails * i);
          if (q == CodeQuantity::worst) {
            // The largest ratio that the trials have, with the relative width of that in the predicted direction. North
            // and east are components 2 and 3.
            const Eigen::Matrix2d claimed =
                (comparison_->magnetic.position + (all ? 1 : 0) * comparison_->carried.position).topLeftCorner<2, 2>();
            const auto rescale = [&](Eigen::Index from, double& value, stats::Interval& interval) {
              if (tally.moments.count < 2) return;
              Eigen::Matrix2d found = tally.moments.covariance().block<2, 2>(from, from);
              if (all) found += comparison_->carried.position.topLeftCorner<2, 2>();
              const double worst = c.sds.claimed * analysis::worst_ratio(found, claimed), factor = worst / value;
              value = worst;
              interval = {factor * interval.lo, factor * interval.hi};
            };
            rescale(2, c.before, c.before_interval);
            rescale(2 + static_cast<Eigen::Index>(kPositionCount), c.after, c.after_interval);
          }
        }
        claims.push_back(c);
      }
    }
  }
  return claims;
}

store::Table CorrectedCodesPoint::orders_table(const stats::Tally& tally) const {
  compare::TableRows t("orders",
                       "which order of prediction the last position after the correction needs, without a trial" +
                           compare::at_confidence(s_.verdict));
  for (std::size_t i = 0; i < kPositionCount; ++i) {
    if (kPositions[i] == CodeQuantity::worst) continue;
    const auto component = static_cast<Eigen::Index>(kPositionCount + i);
    t.word("correction", "of the readings", s_.correction);
    compare::write_order(t, analysis::kCodeQuantities[static_cast<std::size_t>(kPositions[i])],
                         directions_[i].transpose(), *orders_, s_.orders.wanted, runs_->inputs(),
                         tally.moments.count < 2
                             ? compare::OrderSample{}
                             : compare::order_sample(stats::summarise(tally.moments, component), s_.verdict),
                         s_.verdict);
  }
  return t.take();
}

study::PointResult CorrectedCodesPoint::report(const stats::Tally& tally, const montecarlo::RunOptions& options) const {
  study::PointResult r;
  analysis::RobustLimits limits;
  if (comparison_) {
    limits = comparison_->after.limits;
    std::vector<compare::ComparisonRow> rows = compare::compare_rows(
        rows_, "prediction", s_.verdict, tally.trials, [&](const compare::Row& row) -> stats::SampleSummary {
          const stats::Moments& m = row.component < 0 && tally.trials > 0
                                        ? tally.groups[static_cast<std::size_t>(runs_->stations()) - 1]
                                        : tally.moments;
          return m.count < 2 ? stats::SampleSummary{} : stats::summarise(m, row.component < 0 ? 1 : row.component);
        });
    if (tally.trials == 0)
      for (compare::ComparisonRow& row : rows) row.note = "no trials";
    compare::leave_undecided(rows, tally.failed, tally.trials, kMostLost, "estimates");
    s_.annotations.apply("prediction", rows);
    r.tables.push_back(claims_table(s_, claims_of(tally), tally));
    r.tables.push_back(
        compare::comparison_table("prediction",
                                  "sd of what is left over sd that the code claims: Monte Carlo against first order" +
                                      compare::at_confidence(s_.verdict),
                                  rows, tally.trials, tally.failed));
    const bool drawn = tally.trials > 0;
    if (s_.tails.wanted) {
      r.tables.push_back(compare::tails_table(tails_, s_.tails, drawn ? tally.counts.data() + tail_counts() : nullptr,
                                              tally.trials - tally.failed, s_.verdict, s_.annotations, tally.trials,
                                              tally.failed));
      r.tables.push_back(compare::laws_table(
          s_.laws, law_draws_, drawn && !law_draws_.empty() ? &tally.groups.back() : nullptr,
          drawn && !law_draws_.empty() ? tally.counts.data() + tail_counts() + kPositionCount * s_.tails.k.size()
                                       : nullptr,
          s_.verdict.confidence));
    }
    r.tables.push_back(budget_table(s_, *comparison_));
    r.tables.push_back(requirement_table(s_, *comparison_));
    if (orders_ && orders_->second) r.tables.push_back(orders_table(tally));
  }
  if (s_.has_map()) {
    r.maps = code_maps(s_, options, limits);
    r.tables.push_back(shares_table(s_, r.maps));
    if (s_.orders.wanted.profile)
      r.tables.push_back(compare::order_shares_table("the lateral position", r.maps.back().values));
  }
  if (s_.latitude_deg.empty()) r.tables.push_back(zone_table(s_));
  r.tables.push_back(terms_table(s_));
  if (s_.disturbance) {
    const random::Stream stream = random::stream_of(s_.seed);
    r.tables.push_back(scenario::disturbance_table(*s_.disturbance, s_.field, s_.trials > 0 ? &stream : nullptr));
  }
  r.tables.push_back(validity_table(s_, comparison_ ? &*comparison_ : nullptr, tally));
  if (const auto warnings = scenario::warn_of_limits(limits); !warnings.empty())
    r.tables.push_back(compare::warnings_table(warnings));
  return r;
}

std::string CorrectedCodesPoint::replay(std::uint64_t trial) const {
  const auto lane = static_cast<Eigen::Index>(trial % simd::kGroup);
  const Errors e = simulate(trial / simd::kGroup * simd::kGroup, simd::kGroup);
  std::string text = fmt::format("trial {}\n", trial);
  for (std::size_t i = 0; i < kPositionCount; ++i)
    text += fmt::format("  {:<10} before {:.17g} m, after {:.17g} m, claimed sd {:.17g} m\n",
                        analysis::kCodeQuantities[static_cast<std::size_t>(kPositions[i])],
                        e.position(lane, static_cast<Eigen::Index>(i)),
                        e.position(lane, static_cast<Eigen::Index>(kPositionCount + i)), claimed_[i]);
  return text + (e.converged[static_cast<std::size_t>(lane)] ? "  converged\n" : "  NOT converged\n");
}

namespace {

class CorrectedCodesPlan final : public study::PlanOfPoint<Scenario, CorrectedCodesPoint> {
 public:
  using PlanOfPoint::PlanOfPoint;
  /// A cell of a map costs about as much as ten trials, and ten thousand with its order.
  double cost() const override {
    const double stations = s_.well ? s_.well->size() : s_.design->stations;
    const double cell = s_.orders.wanted.profile ? 10'000 : 10;
    return stations * (cell * static_cast<double>(1 + s_.cells()) + static_cast<double>(s_.trials));
  }
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::corrected_codes,
          "Where a corrected tool code (+MS, +AX) keeps what it claims, and what breaks it",
          "OWSG tool codes; S. Vis, TU Delft 2019 (MSA); SPE 125677 (requirements)",
          study::plan_of<CorrectedCodesPlan, read_scenario>};
}

}  // namespace surveymc::studies::corrected_codes
