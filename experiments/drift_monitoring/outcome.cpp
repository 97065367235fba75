/// The numbers and the series that drift_monitoring gathers from the rows of a realisation, block by block.
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "drift_monitoring/study.h"

namespace surveymc::studies::drift_monitoring {
namespace {

/// Samples of a block up to and including an alarm (h into the test); all of them without one.
double samples_until(double alarm_h, const MonitoredBlock& b) {
  const auto end = std::isnan(alarm_h) ? b.test_h.end() : std::upper_bound(b.test_h.begin(), b.test_h.end(), alarm_h);
  return static_cast<double>(end - b.test_h.begin());
}

}  // namespace

OutcomeSum::OutcomeSum(const Scenario& s) : s_(s), at_(s), skipped_(s.architectures.size(), 0) {
  for (std::size_t m = 0; m < s.method_count(); ++m) {
    const AlarmMethod& method = s.method(m);
    const auto same = std::find_if(families_.begin(), families_.end(), [&](const Family& f) {
      return f.test == method.test && f.architecture == method.architecture;
    });
    if (same == families_.end())
      families_.push_back({method.architecture, method.test, {m}});
    else
      same->methods.push_back(m);
  }
  for (Family& f : families_) {
    f.with = f.without = std::vector(s.data.sensors.size(), tests_of(f));
    f.quiet.assign(s.data.sensors.size() * f.methods.size(), 0);
  }
  errors_.assign(s.architectures.size() * OutcomeLayout::kErrors, monitoring::MeanSquareError(s.sensors()));
  sensitivities_.assign(s.architectures.size(), monitoring::Sensitivities(s.sensors()));
}

monitoring::AlarmTests OutcomeSum::tests_of(const Family& family) const {
  std::vector<monitoring::SprtOptions> sprt;
  std::vector<monitoring::CusumOptions> cusum;
  std::vector<double> thresholds;
  for (const std::size_t m : family.methods) {
    const double setting = s_.method(m).setting;
    sprt.push_back(s_.sprt);
    sprt.back().shift = setting;
    cusum.push_back(s_.cusum);
    cusum.back().threshold = setting;
    thresholds.push_back(setting);
  }
  if (family.test == AlarmMethod::Test::sprt) return monitoring::AlarmTests(sprt);
  if (family.test == AlarmMethod::Test::cusum) return monitoring::AlarmTests(cusum);
  return monitoring::AlarmTests(thresholds);
}

void OutcomeSum::add(const MonitoredBlock& b) {
  const std::size_t p = s_.data.sensors.size();
  const auto signal = [&](const monitoring::MonitorTrace& trace, std::size_t sensor) {
    return monitoring::AlarmSignal{trace.signal.data() + sensor, b.test_h.data(), p, b.test_h.size(), s_.start_h};
  };
  for (Family& f : families_)
    for (std::size_t j = 0; j < p; ++j) {
      f.with[j].update(signal(b.with[f.architecture], j));
      std::vector<double> before;
      for (std::size_t i = 0; i < f.methods.size(); ++i) before.push_back(f.without[j].times(i).first);
      f.without[j].update(signal(b.without[f.architecture], j));
      for (std::size_t i = 0; i < f.methods.size(); ++i)
        if (std::isnan(before[i])) f.quiet[j * f.methods.size() + i] += samples_until(f.without[j].times(i).first, b);
    }
  for (std::size_t a = 0; a < s_.architectures.size(); ++a) {
    monitoring::MeanSquareError* errors = errors_.data() + a * OutcomeLayout::kErrors;
    errors[OutcomeLayout::measured].add(b.without[a].prediction, b.readings);
    errors[OutcomeLayout::drift_measured].add(b.with[a].prediction, b.readings);
    if (b.truth.size() > 0) {
      errors[OutcomeLayout::truth].add(b.without[a].prediction, b.truth);
      errors[OutcomeLayout::drift_truth].add(b.with[a].prediction, b.truth);
    }
    sensitivities_[a].add(b.with[a].prediction, b.without[a].prediction, b.drift);
    skipped_[a] += static_cast<double>(b.with[a].skipped);
  }
}

std::vector<double> OutcomeSum::row(const TrainedModel& model) const {
  std::vector<double> row(at_.size(), kNaN);
  const std::size_t p = s_.data.sensors.size();
  for (const Family& f : families_)
    for (std::size_t i = 0; i < f.methods.size(); ++i)
      for (std::size_t j = 0; j < p; ++j) {
        const auto put = [&](OutcomeLayout::Alarm what, double x) { row[at_.alarm(f.methods[i], j, what)] = x; };
        const monitoring::AlarmTimes with = f.with[j].times(i);
        put(OutcomeLayout::first, with.first);
        put(OutcomeLayout::first_after_start, with.first_after_start);
        put(OutcomeLayout::count, with.count);
        put(OutcomeLayout::first_without_drift, f.without[j].times(i).first);
        put(OutcomeLayout::samples_without_drift, f.quiet[j * f.methods.size() + i]);
      }
  for (std::size_t a = 0; a < s_.architectures.size(); ++a) {
    row[at_.skipped(a)] = skipped_[a];
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
                                         b.truth.size() > 0 ? b.truth(row, c) : kNaN, b.drift(row, c)});
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
  compare::TableRows t("series",
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
