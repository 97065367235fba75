/// Events of a gross-error study, where the config has `[[event]]`.
#include <cmath>

#include "analysis/gross_error_event.h"
#include "gross_error_detection/scenario.h"
#include "random/rare_channels.h"
#include "random/study_stream.h"
#include "stats/normal_tail.h"

namespace surveymc::studies::gross_error_detection {
namespace {

using EventKind = analysis::GrossErrorEventKind;

struct EventInputs {
  reliability::GrossErrorTrials trials;
  analysis::GrossErrorPrediction prediction;
};

struct HeldEvent {
  std::shared_ptr<const EventInputs> inputs;
  analysis::GrossErrorEvent state;
};

/// linear_rates is good to 2e-4: too little for small rates.
double known(double rate) { return rate >= 0.01 ? rate : kNaN; }

std::vector<std::pair<std::string, double>> predictions_of(const analysis::GrossErrorPrediction& p, EventKind kind,
                                                           const std::vector<rare::HalfSpace>& tests, bool pope) {
  switch (kind) {
    case EventKind::missed: {
      // Of the one test of the first error: all tests together miss it no more often.
      const double shift = p.linear.w.front();
      const double own = stats::normal_upper_tail(-p.critical - shift) - stats::normal_upper_tail(p.critical - shift);
      return {{"linear", known(1 - p.linear_any)}, {"nonlinear", known(1 - p.any)}, {"single_test", pope ? kNaN : own}};
    }
    case EventKind::false_alarm_any: {
      std::vector<double> each;
      double sum = 0;
      for (std::size_t i = 0; i < tests.size(); i += 2) {
        each.push_back(2 * stats::normal_upper_tail(tests[i].distance));
        sum += each.back();
      }
      return {{"linear", known(p.false_alarm_any)},
              {"independent", pope ? kNaN : rare::any_of_independent(each)},
              {"bonferroni", pope ? kNaN : sum}};
    }
    case EventKind::identified_wrong:
      return {{"nonlinear", known(p.any - p.identified)}};
  }
  return {};
}

std::vector<std::string> names_of(const Scenario& s, int rows, int observations) {
  std::vector<std::string> names(static_cast<std::size_t>(rows));
  const auto readings = static_cast<int>(reliability::kReadings * s.attitudes.size());
  for (int i = 0; i < observations; ++i)
    names[static_cast<std::size_t>(i)] =
        i >= readings + 3 ? "systematic_term"
                          : reliability::observation_names()[static_cast<std::size_t>(
                                i < readings ? i % static_cast<int>(reliability::kReadings)
                                             : static_cast<int>(reliability::kReadings) + i - readings)];
  return names;
}

}  // namespace

std::vector<events::TrialEvent> events_of(const Scenario& s) {
  reliability::GrossErrorTrials trials(s.model, s.attitudes, s.errors(), random::stream_of(s.seed));
  analysis::GrossErrorPrediction prediction = analysis::predict_gross_errors(trials, s.levels, s.pope);
  const auto inputs = std::make_shared<const EventInputs>(EventInputs{std::move(trials), std::move(prediction)});
  const std::vector<rare::HalfSpace> tests = analysis::test_half_spaces(inputs->trials, inputs->prediction);
  std::vector<events::TrialEvent> events;
  for (const events::EventRule& rule : s.events) {
    const auto kind = static_cast<EventKind>(rule.quantity);
    const auto held = std::make_shared<const HeldEvent>(
        HeldEvent{inputs, analysis::GrossErrorEvent(inputs->trials, inputs->prediction, s.pope, kind)});
    events::TrialEvent e;
    e.name = rule.name;
    e.state = {held, &held->state};
    const int n = held->state.dimension();
    e.from = rare::addresses_in(random::Channel::gross_error_study, random::kRareChoice, n);
    e.normals = names_of(s, n, inputs->trials.observations());
    e.predictions = predictions_of(inputs->prediction, kind, tests, s.pope);
    if (kind == EventKind::false_alarm_any && !s.pope) e.half_spaces = tests;
    e.place = rule.place;
    events.push_back(std::move(e));
  }
  return events;
}

}  // namespace surveymc::studies::gross_error_detection
