/// The numbers and the series that drift_monitoring gathers from the rows of a realisation, block by block.
#include <cmath>

#include "base/units.h"
#include "drift_monitoring/study.h"

namespace surveymc::studies::drift_monitoring {
namespace {

constexpr double kNone = kNaN;

void keep_first(double& first, double time_h) {
  if (std::isnan(first)) first = time_h;
}

}  // namespace

AlarmTest make_test(const Scenario& s, const AlarmMethod& method) {
  if (method.test == AlarmMethod::Test::threshold) return monitoring::Threshold(method.setting);
  if (method.test == AlarmMethod::Test::cusum) {
    monitoring::CusumOptions options = s.cusum;
    options.threshold = method.setting;
    return monitoring::Cusum(options);
  }
  monitoring::SprtOptions options = s.sprt;
  options.shift = method.setting;
  return monitoring::Sprt(options);
}

OutcomeSum::OutcomeSum(const Scenario& s) : s_(s), at_(s), row_(at_.size(), kNone) {
  const Eigen::Index p = s.sensors();
  for (std::size_t m = 0; m < s.method_count(); ++m)
    for (std::size_t j = 0; j < s.data.sensors.size(); ++j) {
      with_.push_back(make_test(s, s.method(m)));
      without_.push_back(make_test(s, s.method(m)));
      row_[at_.alarm(m, j, OutcomeLayout::count)] = 0;
    }
  errors_.assign(s.architectures.size() * OutcomeLayout::kErrors, monitoring::MeanSquareError(p));
  sensitivities_.assign(s.architectures.size(), monitoring::Sensitivities(p));
  for (std::size_t a = 0; a < s.architectures.size(); ++a) row_[at_.skipped(a)] = 0;
}

template <class Test, class Signal>
void OutcomeSum::add_alarms(const MonitoredBlock& b, std::size_t m, std::size_t j, Test& test, const Signal& signal) {
  for (std::size_t i = 0; i < b.test_h.size(); ++i) {
    if (test.update(signal[static_cast<Eigen::Index>(i)]) == 0) continue;
    keep_first(row_[at_.alarm(m, j, OutcomeLayout::first)], b.test_h[i]);
    if (b.test_h[i] >= s_.start_h) keep_first(row_[at_.alarm(m, j, OutcomeLayout::first_after_start)], b.test_h[i]);
    row_[at_.alarm(m, j, OutcomeLayout::count)] += 1;
  }
}

void OutcomeSum::add_alarms(const MonitoredBlock& b) {
  const std::size_t p = s_.data.sensors.size();
  for (std::size_t m = 0; m < s_.method_count(); ++m)
    for (std::size_t j = 0; j < p; ++j) {
      const std::size_t a = s_.method(m).architecture;
      const auto c = static_cast<Eigen::Index>(j);
      // The kind of test is asked for once, not at every sample
      std::visit([&](auto& test) { add_alarms(b, m, j, test, b.with[a].signal.col(c)); }, with_[m * p + j]);
      std::visit(
          [&](auto& test) {
            const auto signal = b.without[a].signal.col(c);
            for (std::size_t i = 0; i < b.test_h.size(); ++i)
              if (test.update(signal[static_cast<Eigen::Index>(i)]) != 0)
                keep_first(row_[at_.alarm(m, j, OutcomeLayout::first_without_drift)], b.test_h[i]);
          },
          without_[m * p + j]);
    }
}

void OutcomeSum::add(const MonitoredBlock& b) {
  add_alarms(b);
  for (std::size_t a = 0; a < s_.architectures.size(); ++a) {
    monitoring::MeanSquareError* errors = errors_.data() + a * OutcomeLayout::kErrors;
    errors[OutcomeLayout::measured].add(b.without[a].prediction, b.readings);
    errors[OutcomeLayout::drift_measured].add(b.with[a].prediction, b.readings);
    if (b.truth.size() > 0) {
      errors[OutcomeLayout::truth].add(b.without[a].prediction, b.truth);
      errors[OutcomeLayout::drift_truth].add(b.with[a].prediction, b.truth);
    }
    sensitivities_[a].add(b.with[a].prediction, b.without[a].prediction, b.drift);
    row_[at_.skipped(a)] += static_cast<double>(b.with[a].skipped);
  }
}

std::vector<double> OutcomeSum::row(const TrainedModel& model) const {
  std::vector<double> row = row_;
  const std::size_t p = s_.data.sensors.size();
  for (std::size_t a = 0; a < s_.architectures.size(); ++a) {
    const Eigen::MatrixXd sensitivity = sensitivities_[a].value();
    for (std::size_t j = 0; j < p; ++j) {
      const auto c = static_cast<Eigen::Index>(j);
      for (int e = 0; e < OutcomeLayout::kErrors; ++e)
        row[at_.error(a, j, static_cast<OutcomeLayout::Error>(e))] =
            errors_[a * OutcomeLayout::kErrors + static_cast<std::size_t>(e)].value()[c];
      for (std::size_t k = 0; k < p; ++k) row[at_.sensitivity(a, j, k)] = sensitivity(c, static_cast<Eigen::Index>(k));
    }
  }
  for (std::size_t j = 0; j < p; ++j) row[at_.sd(j)] = model.scaling.sd[static_cast<Eigen::Index>(j)];
  return row;
}

SeriesSum::SeriesSum(const Scenario& s) : s_(s), kept_(s.data.sensors.size()) {
  tests_.assign(s.architectures.size() * s.data.sensors.size(), monitoring::Sprt(s.sprt));
  held_.assign(tests_.size(), 0);
}

void SeriesSum::add(const MonitoredBlock& b) {
  const std::size_t p = s_.data.sensors.size();
  for (std::size_t i = 0; i < b.test_h.size(); ++i, ++row_) {
    const auto row = static_cast<Eigen::Index>(i);
    const bool keep = row_ % s_.series_every == 0 || row_ == s_.data.tested() - 1;
    for (std::size_t j = 0; j < p; ++j) {
      const auto c = static_cast<Eigen::Index>(j);
      if (keep)
        kept_[j].insert(kept_[j].end(), {b.test_h[i], b.readings(row, c) + b.drift(row, c),
                                         b.truth.size() > 0 ? b.truth(row, c) : kNone, b.drift(row, c)});
      for (std::size_t a = 0; a < s_.architectures.size(); ++a) {
        monitoring::Sprt& test = tests_[a * p + j];
        int& held = held_[a * p + j];
        test.update(b.with[a].signal(row, c));
        if (test.decision() != 0) held = test.decision();
        if (!keep) continue;
        kept_[j].insert(kept_[j].end(), {b.with[a].prediction(row, c), b.with[a].signal(row, c),
                                         static_cast<double>(held), b.with[a].nearest[row]});
        held = 0;
      }
    }
  }
}

store::Table SeriesSum::take() {
  study::TableRows t("series",
                     "first realisation, with drift: what each monitor sees; scaled by the model's mean and sd (z)");
  const std::size_t width = 4 + 4 * s_.architectures.size();
  for (std::size_t j = 0; j < kept_.size(); ++j) {
    for (auto x = kept_[j].begin(); x != kept_[j].end(); x += static_cast<std::ptrdiff_t>(width)) {
      t.word("sensor", "gauge", s_.data.sensors[j]);
      t.number("time_h", "h", "hours into the test", x[0]);
      t.number("reading_z", "1", "with drift", x[1]);
      t.number("truth_z", "1", "without noise and drift, where it is known", x[2]);
      t.number("drift_z", "1", "added to the reading", x[3]);
      auto seen = x + 4;
      for (const monitoring::Architecture a : s_.architectures) {
        const std::string of = std::string("_") + monitoring::name(a);
        t.number("prediction" + of, "1", "AAKR, z", seen[0]);
        t.number("signal" + of, "1",
                 a == monitoring::Architecture::aakr_sprt ? "residual of the reading, z" : "estimated drift, z",
                 seen[1]);
        t.count("decision" + of,
                "of the SPRT: 0, or the sign of the drift if it was held since the sample that was kept before",
                static_cast<int>(seen[2]));
        t.number("nearest" + of, "1", "distance to the nearest memory vector, z", seen[3]);
        seen += 4;
      }
    }
    kept_[j] = {};
  }
  return t.take();
}

}  // namespace surveymc::studies::drift_monitoring
