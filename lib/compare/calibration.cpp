#include "compare/calibration.h"

#include <algorithm>
#include <cmath>

#include <fmt/ranges.h>

#include "base/units.h"
#include "compare/table_rows.h"
#include "compare/trial_plan.h"
#include "config/suggest.h"
#include "estimate/estimators.h"

namespace surveymc::compare {
namespace {

constexpr std::uint64_t kFewest = 1000;  // units: trials or pairs
constexpr const char* kAsIs = "or set calibration.truth = \"as_is\"";

/// One quantity with what its counts say.
struct CalibratedRow {
  std::string formulation, quantity, expected;
  stats::ClaimedLaw law;
  stats::PitCounts counts;
  std::uint64_t units = 0;
  stats::CalibrationResult result;
  bool judged = false;  ///< there are counts at all
  bool paired = false;  ///< a unit is an antithetic pair of two trials

  std::uint64_t fewest_trials() const { return paired ? 2 * kFewest : kFewest; }
};

std::string note_of(const CalibratedRow& row, double confidence) {
  if (!row.judged) return row.counts.unjudged > 0 ? "the claimed sd is 0 or not finite" : "no converged trial";
  const stats::CalibrationResult& r = row.result;
  std::string note;
  const auto add = [&](const std::string& text) { note += (note.empty() ? "" : "; ") + text; };
  if (row.units < kFewest)
    add(fmt::format("at least {} trials{} are needed", row.fewest_trials(),
                    row.paired ? fmt::format(" ({} pairs)", kFewest) : ""));
  if (r.p_band < 1 - confidence)
    add(r.shape == "sd" ? fmt::format("sd of the errors {:+.2g} % against the claim", 100 * r.size)
        : r.shape == "shift"
            ? fmt::format("errors shifted by {:+.2g} claimed sd", r.size)
            : fmt::format("{} {:+.2g}{}", r.shape, r.size, r.shape == "kurtosis" ? " more than normal" : ""));
  if (row.counts.unjudged > 0) add(fmt::format("{} trials without a claimed sd", row.counts.unjudged));
  if (r.trials_to_decide > 0 && row.units >= kFewest)
    add(fmt::format("about {:.2g} trials would decide", static_cast<double>(r.trials_to_decide)));
  return note;
}

CalibratedRow judged_row(const CalibrationRule& rule, const CalibratedQuantity& q, std::span<const std::uint64_t> slots,
                         bool paired, const Annotations& annotations) {
  CalibratedRow row{q.formulation,
                    q.quantity,
                    annotations.expected("calibration", q.formulation, q.quantity),
                    q.law,
                    stats::pit_counts(slots),
                    0,
                    {}};
  row.paired = paired;
  row.units = paired ? row.counts.total / 2 : row.counts.total;
  row.judged = row.units > 0;
  if (!row.judged) return row;
  row.result = stats::judge_calibration(row.counts, row.units, q.law, rule.margin, rule.confidence);
  if (row.units < kFewest) {
    row.result.verdict = "undecided";
    row.result.p_differs = row.result.p_agrees = kNaN;
    row.result.trials_to_decide = std::max(row.result.trials_to_decide, row.fewest_trials());
  }
  return row;
}

store::Table calibration_table(const CalibrationRule& rule, const std::vector<CalibratedRow>& rows) {
  TableRows t(
      "calibration",
      fmt::format("is the claimed distribution of every error right as a whole: deviation of the distribution of "
                  "u = F(error) from uniform, simultaneous intervals at {:.6g} %",
                  100 * rule.confidence));
  write_rows(t, rows, [&](const CalibratedRow& row) {
    const stats::CalibrationResult& r = row.result;
    const auto number = [&](double x) { return row.judged ? x : kNaN; };
    const bool shaped = row.judged && r.p_band < 1 - rule.confidence;
    t.word("formulation", "whose claim", row.formulation);
    t.word("quantity", "whose error", row.quantity);
    t.estimate("deviation", "1", "largest deviation: share of trials with u below `at`, less `at`", number(r.largest),
               {number(r.interval.lo), number(r.interval.hi)});
    t.number("at", "1", "the u of the largest deviation", number(r.at));
    t.number("p_band", "1", "probability of such a distribution function, by noise alone", number(r.p_band));
    t.number("p_chi_squared", "1", "the same by chi-squared of 20 bins", number(r.p_chi_squared));
    t.word("shape", "what the deviation resembles most, where p_band is small: sd, shift, skewness, kurtosis",
           shaped ? r.shape : "");
    t.number("size", "1", "of the shape: relative error of the sd, shift in sd, skewness, excess kurtosis",
             shaped ? r.size : kNaN);
    t.number("margin", "1", "what agrees: every deviation within +- margin; 0: the band's own test",
             row.judged ? rule.margin : kNaN);
    t.word("verdict", "agrees, differs or undecided", row.judged ? r.verdict : "");
    t.word("expected", "the verdict this row should have", row.expected);
    write_evidence(t, {number(r.p_differs), number(r.p_agrees)}, row.judged ? r.trials_to_decide : 0);
    t.word("note", "what else there is to say", note_of(row, rule.confidence));
    t.count("trials", "trials that are counted", row.counts.total);
    t.count("unjudged", "trials whose claimed sd is 0 or not finite", row.counts.unjudged);
  });
  return t.take();
}

store::Table pit_table(const CalibrationRule& rule, const std::vector<CalibratedRow>& rows) {
  TableRows t("pit",
              fmt::format("distribution of u = F(error), with the band that holds all of a uniform one at {:.6g} %",
                          100 * rule.confidence));
  write_rows(t, rows, [&](const CalibratedRow& row) {
    const std::vector<double> shape =
        stats::calibration_shape(row.judged ? row.result.shape : "", row.result.size, row.law);
    std::uint64_t below = 0;
    for (int i = 1; i <= stats::kPitBins; ++i) {
      const double u = i / double(stats::kPitBins), n = static_cast<double>(row.units);
      below += row.counts.bins[static_cast<std::size_t>(i - 1)];
      const double half = row.judged ? row.result.quantile * std::sqrt(u * (1 - u) / n) : kNaN;
      t.word("formulation", "whose claim", row.formulation);
      t.word("quantity", "whose error", row.quantity);
      t.number("upto", "1", "u", u);
      t.number("share", "1", "share of trials below u",
               row.judged ? static_cast<double>(below) / static_cast<double>(row.counts.total) : kNaN);
      t.number("band_low", "1", "lower edge of the band", u - half);
      t.number("band_high", "1", "upper edge of the band", u + half);
      t.number("shape", "1", "share by the shape of table calibration",
               i < stats::kPitBins ? u + shape[static_cast<std::size_t>(i - 1)] : 1);
    }
  });
  return t.take();
}

store::Table coverage_table(const CalibrationRule& rule, const std::vector<CalibratedRow>& rows) {
  TableRows t("coverage", fmt::format("how often the central intervals of the claimed distributions hold the truth, "
                                      "intervals at {:.6g} %",
                                      100 * rule.confidence));
  write_rows(t, rows, [&](const CalibratedRow& row) {
    for (const int level : {50, 80, 90, 95, 98}) {
      std::uint64_t inside = row.counts.central95;
      if (level != 95) {  // edges are those of bins
        const int tail = (100 - level) / 2;
        inside = 0;
        for (int i = tail; i < stats::kPitBins - tail; ++i) inside += row.counts.bins[static_cast<std::size_t>(i)];
      }
      t.word("formulation", "whose claim", row.formulation);
      t.word("quantity", "whose error", row.quantity);
      t.number("level", "1", "what the claim holds with this probability", level / 100.0);
      const std::uint64_t counted = row.units == row.counts.total ? inside : (inside + 1) / 2;
      t.estimate(
          "share", "1", "share of trials",
          row.judged ? static_cast<double>(inside) / static_cast<double>(row.counts.total) : kNaN,
          row.judged ? stats::binomial_interval(counted, row.units, rule.confidence) : stats::Interval{kNaN, kNaN});
    }
  });
  return t.take();
}

}  // namespace

bool CalibrationRule::wants(const std::string& quantity) const {
  return quantities.empty() || std::find(quantities.begin(), quantities.end(), quantity) != quantities.end();
}

CalibrationRule read_calibration(config::ConfigReader& c, const std::vector<Row>& rows) {
  CalibrationRule rule;
  rule.on = c.has("calibration");
  if (!rule.on) return rule;
  rule.margin =
      c.number("calibration.margin", config::Range{0, 0.5, false, true},
               "largest deviation of a share that agrees; 0: the band's own test at `confidence`", rule.margin);
  rule.confidence = c.number("calibration.confidence", kConfidences, "confidence of the whole band", rule.confidence);
  rule.truth_as_is =
      c.choice("calibration.truth", {"prior", "as_is"},
               "'prior': an estimator with priors is tested with truths drawn from them; 'as_is': with any truth",
               "prior") == "as_is";
  if (!c.has("calibration.quantities")) return rule;
  rule.quantities = c.texts("calibration.quantities", "quantities that are tested; without it all");
  std::vector<std::string> once;
  for (const Row& row : rows)
    if (row.calibrated && row.available && std::find(once.begin(), once.end(), row.quantity) == once.end())
      once.push_back(row.quantity);
  for (const std::string& q : rule.quantities)
    if (std::find(once.begin(), once.end(), q) == once.end())
      c.fail("calibration.quantities", config::none_of(q, once));
  return rule;
}

void require_calibrated_inputs(config::ConfigReader& c, const CalibrationRule& rule,
                               const estimate::EstimatorOptions& estimator, const estimate::InputErrors& truth,
                               const sensor::MagnetometerErrors& tool) {
  if (!rule.on) return;
  const estimate::EstimatorKind& kind = estimate::estimator_kind(estimator.name);
  std::vector<std::string_view> claiming;
  for (const estimate::EstimatorKind& k : estimate::estimators())
    if (k.weighs) claiming.push_back(k.name);
  c.require(kind.weighs, "estimator.name",
            fmt::format("claims no covariance, so that there is nothing to calibrate: must be one of {}, or leave out "
                        "[calibration]",
                        fmt::join(claiming, ", ")));
  if (rule.truth_as_is) return;
  const estimate::InputErrors& prior = estimator.assumed;
  const auto same = [&](double assumed, double drawn, const char* key, const char* other) {
    c.require(std::abs(assumed - drawn) <= 1e-12 * drawn, key,
              fmt::format("with [calibration] must be {} = {:g}, because priors are right on average over truths drawn "
                          "from them; {}",
                          other, drawn, kAsIs));
  };
  if (prior.gain == 0 && prior.bias == 0 && prior.axial_bias == 0 && !kind.estimates_reference) return;
  if (prior.gain > 0 || prior.bias > 0 || prior.axial_bias > 0) {
    same(prior.gain, truth.gain, "estimator.prior.gain", "sensor.spread.gain");
    same(prior.bias, truth.bias, "estimator.prior.bias_nT", "sensor.spread.bias_nT");
    same(prior.axial_bias, truth.axial_bias, "estimator.prior.axial_bias_nT", "sensor.spread.axial_bias_nT");
    for (const double gain : tool.gain)
      c.require(gain == 1, "sensor.gain",
                fmt::format("with [calibration] must be 1, the middle of the priors; {}", kAsIs));
    for (const double bias : tool.bias)
      c.require(bias == 0, "sensor.bias_nT",
                fmt::format("with [calibration] must be 0, the middle of the priors; {}", kAsIs));
  }
  if (kind.estimates_reference) {
    same(prior.total, truth.total, "estimator.reference.total_nT", "noise.reference.total_nT");
    same(prior.dip / kDegree, truth.dip / kDegree, "estimator.reference.dip_deg", "noise.reference.dip_deg");
  }
}

CalibratedQuantity normal_quantity(const std::string& formulation, const std::string& quantity, double sd) {
  return {formulation, quantity, {}, stats::PitCells::normal(sd)};
}

CalibratedQuantity angle_quantity(const std::string& formulation, const std::string& quantity, double sd) {
  return {formulation, quantity, {}, stats::PitCells::normal_angle(sd)};
}

CalibratedQuantity chi_squared_quantity(const std::string& formulation, const std::string& quantity, double degrees) {
  return {formulation, quantity, {degrees}, stats::PitCells::chi_squared(degrees)};
}

std::vector<Row> calibrated_rows(const std::vector<Row>& rows, const CalibrationRule& rule) {
  std::vector<Row> wanted;
  for (const Row& row : rows)
    if (rule.on && row.calibrated && row.available && rule.wants(row.quantity)) wanted.push_back(row);
  return wanted;
}

std::vector<Row> annotated_rows(std::vector<Row> rows, const CalibrationRule& rule) {
  std::erase_if(rows, [&](const Row& row) { return row.calibrated && !(rule.on && row.available); });
  return rows;
}

std::vector<store::Table> calibration_tables(const CalibrationRule& rule,
                                             const std::vector<CalibratedQuantity>& quantities,
                                             const std::vector<std::uint64_t>& counts, std::size_t first, bool paired,
                                             const Annotations& annotations) {
  if (!rule.on) return {};
  std::vector<CalibratedRow> rows;
  for (std::size_t q = 0; q < quantities.size() && !counts.empty(); ++q)
    rows.push_back(
        judged_row(rule, quantities[q],
                   std::span<const std::uint64_t>(counts).subspan(first + q * stats::kPitSlots, stats::kPitSlots),
                   paired, annotations));
  return {calibration_table(rule, rows), pit_table(rule, rows), coverage_table(rule, rows)};
}

}  // namespace surveymc::compare
