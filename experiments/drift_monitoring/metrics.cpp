/// Tables `metrics` and `claims` of drift_monitoring.
#include <cmath>

#include "compare/claims.h"
#include "drift_monitoring/study.h"
#include "stats/skewed_mean.h"

namespace surveymc::studies::drift_monitoring {
namespace {

constexpr std::array<const char*, OutcomeLayout::kErrors> kErrorNames{"mse_measured", "mse_truth", "mse_drift_measured",
                                                                      "mse_drift_truth"};

bool is_as(monitoring::Architecture a) { return a == monitoring::Architecture::aakr_sprt; }

/// Metrics of one architecture by name: one number a realisation.
class Metrics {
 public:
  Metrics(const Scenario& s, const Outcomes& o, std::size_t a) : s_(s), o_(o), a_(a) {}

  std::vector<double> mean_error(OutcomeLayout::Error what) const {
    return averaged([&](std::size_t t, auto add) {
      for (std::size_t j = 0; j < p(); ++j) add(o_(t, o_.at.error(a_, j, what)));
    });
  }
  std::vector<double> auto_sensitivity() const {
    return averaged([&](std::size_t t, auto add) {
      for (std::size_t k = 0; k < p(); ++k)
        if (drifts(k)) add(o_(t, o_.at.sensitivity(a_, k, k)));
    });
  }
  std::vector<double> cross_sensitivity() const {
    return averaged([&](std::size_t t, auto add) {
      for (std::size_t k = 0; k < p(); ++k)
        for (std::size_t j = 0; j < p(); ++j)
          if (drifts(k) && !drifts(j)) add(o_(t, o_.at.sensitivity(a_, j, k)));
    });
  }

 private:
  std::size_t p() const { return s_.data.sensors.size(); }
  bool drifts(std::size_t j) const { return s_.drifts(static_cast<Eigen::Index>(j)); }
  /// The mean of what each(trial, add) adds, for every trial; nothing if it adds nothing.
  template <class Each>
  std::vector<double> averaged(Each each) const {
    std::vector<double> x;
    for (std::size_t t = 0; t < o_.trials(); ++t) {
      double sum = 0;
      int count = 0;
      each(t, [&](double v) {
        sum += v;
        ++count;
      });
      if (count > 0) x.push_back(sum / count);
    }
    return x;
  }

  const Scenario& s_;
  const Outcomes& o_;
  std::size_t a_;
};

/// Mean squared errors are skew, the more so where a filter follows few realisations badly.
compare::ComparisonRow error_row(const std::string& formulation, const std::string& quantity, const std::string& unit,
                                 const std::vector<double>& x, double confidence) {
  compare::ComparisonRow row = compare::mean_row(formulation, quantity, unit, x, confidence);
  if (std::isfinite(row.interval.lo)) row.interval = stats::skewed_mean_interval(x, confidence);
  return row;
}

std::vector<double> ratios(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> r;
  for (std::size_t i = 0; i < a.size(); ++i) r.push_back(a[i] / b[i]);
  return r;
}

/// In how many realisations a healthy sensor was blamed for the drift of another. Empty if none drifts.
compare::ComparisonRow blamed(const Scenario& s, const Outcomes& o, std::size_t method, const std::string& quantity) {
  const std::uint64_t count = count_blames(s, o, method);
  compare::ComparisonRow row = compare::empty_row(s.methods[method].name, quantity, "1");
  if (!s.any_healthy() || !s.any_drifts()) return row;
  row.monte_carlo = static_cast<double>(count) / static_cast<double>(o.trials());
  if (o.trials() > 1) row.interval = stats::binomial_interval(count, o.trials(), s.verdict.confidence);
  return row;
}

constexpr const char* kBoth = "aakr_kf_sprt / aakr_sprt";

}  // namespace

std::vector<compare::ComparisonRow> metric_rows(const Scenario& s, const Outcomes& o) {
  std::vector<compare::ComparisonRow> rows;
  const double confidence = s.verdict.confidence;
  const auto& sensors = s.data.sensors;
  for (std::size_t a = 0; a < s.architectures.size(); ++a) {
    const std::string of = monitoring::name(s.architectures[a]);
    const Metrics m(s, o, a);
    for (std::size_t e = 0; e < kErrorNames.size(); ++e)
      rows.push_back(
          error_row(of, kErrorNames[e], "z2", m.mean_error(static_cast<OutcomeLayout::Error>(e)), confidence));
    rows.push_back(compare::mean_row(of, "auto_sensitivity", "1", m.auto_sensitivity(), confidence));
    rows.push_back(compare::mean_row(of, "cross_sensitivity", "1", m.cross_sensitivity(), confidence));
    rows.push_back(compare::mean_row(of, "rows_skipped_by_gate", "1", o.all(o.at.skipped(a)), confidence));
    for (std::size_t j = 0; j < sensors.size(); ++j) {
      for (std::size_t e = 0; e < kErrorNames.size(); ++e) {
        std::vector<double> x = o.all(o.at.error(a, j, static_cast<OutcomeLayout::Error>(e)));
        rows.push_back(error_row(of, std::string(kErrorNames[e]) + "_" + sensors[j], "z2", x, confidence));
        for (std::size_t t = 0; t < x.size(); ++t) x[t] *= o(t, o.at.sd(j)) * o(t, o.at.sd(j));
        rows.push_back(
            error_row(of, std::string(kErrorNames[e]) + "_raw_" + sensors[j], s.data.units[j] + "2", x, confidence));
      }
      if (s.drifts(static_cast<Eigen::Index>(j)))
        rows.push_back(
            compare::mean_row(of, "auto_sensitivity_" + sensors[j], "1", o.all(o.at.sensitivity(a, j, j)), confidence));
      for (std::size_t k = 0; k < sensors.size(); ++k)
        if (k != j && s.drifts(static_cast<Eigen::Index>(k)))
          rows.push_back(compare::mean_row(of, "cross_sensitivity_" + sensors[j] + "_to_" + sensors[k], "1",
                                           o.all(o.at.sensitivity(a, j, k)), confidence));
    }
  }
  return rows;
}

std::vector<compare::ComparisonRow> claim_rows(const Scenario& s, const Outcomes& o) {
  std::vector<compare::ComparisonRow> rows;
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    if (s.methods[m].test != AlarmMethod::Test::sprt) continue;
    const bool as = is_as(s.architectures[s.methods[m].architecture]);
    const compare::ComparisonRow row = blamed(s, o, m, as ? "blames_a_healthy_sensor" : "blames_no_healthy_sensor");
    rows.push_back(
        as ? compare::judge_claim(row, 0.5, false, s.verdict.confidence, "in more than half of the realisations")
           : compare::judge_claim(row, 0.05, true, s.verdict.confidence, "in less than 5 % of the realisations"));
  }
  if (s.architectures.size() < 2) return rows;
  const Metrics as(s, o, 0), aks(s, o, 1);
  const auto add = [&](const char* quantity, const std::vector<double>& of_aks, const std::vector<double>& of_as,
                       bool below) {
    rows.push_back(compare::judge_mean_claim(kBoth, quantity, ratios(of_aks, of_as), 1, below, s.verdict.confidence,
                                             below ? "ratio below 1" : "ratio above 1"));
  };
  add("auto_sensitivity_is_lower", aks.auto_sensitivity(), as.auto_sensitivity(), true);
  add("cross_sensitivity_is_lower", aks.cross_sensitivity(), as.cross_sensitivity(), true);
  add("unfaulted_mse_is_higher", aks.mean_error(OutcomeLayout::measured), as.mean_error(OutcomeLayout::measured),
      false);
  const auto with_drift = s.data.simulated() ? OutcomeLayout::drift_truth : OutcomeLayout::drift_measured;
  const auto drifting_error = [&](const Metrics& m) {
    return s.any_drifts() ? m.mean_error(with_drift) : std::vector<double>{};
  };
  add("drifting_mse_is_lower", drifting_error(aks), drifting_error(as), true);
  return rows;
}

std::vector<compare::Row> row_names(const Scenario& s) {
  const std::vector<double> row(OutcomeLayout(s).size(), 0.0);
  const Outcomes one(s, row);
  std::vector<compare::Row> names;
  for (const compare::ComparisonRow& r : metric_rows(s, one)) names.push_back({"metrics", r.formulation, r.quantity});
  for (const compare::ComparisonRow& r : claim_rows(s, one)) names.push_back({"claims", r.formulation, r.quantity});
  return names;
}

}  // namespace surveymc::studies::drift_monitoring
