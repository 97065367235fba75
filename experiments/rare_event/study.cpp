/// Study: limit states with known probabilities, to try the methods for rare events on.
///
///   problem (config) -> preparing (rare/preparing.h) -> weighted trials -> probability with its interval,
///   held against the exact value and against FORM, and beside replicates of subset simulation
#include <cmath>

#include <fmt/format.h>

#include "events/event_study.h"
#include "random/rare_channels.h"
#include "random/study_stream.h"
#include "rare/test_functions.h"

namespace surveymc::studies::rare_event {
namespace {

constexpr int kMostNormals = 10'000;

rare::TestProblem read_problem(config::ConfigReader& c) {
  rare::TestProblem p;
  const std::vector<std::string>& names = rare::test_problem_names();
  p.name = c.choice(
      "problem.name", names,
      "the problem: 'linear' { dimension, beta }, 'union' { dimension, beta, a list }, 'product' { level }, 'sphere' { "
      "dimension, radius }, 'disc' { mean, sd, radius }, or one of the literature without further keys");
  const auto size = [&](int usual) {
    p.dimension = static_cast<int>(c.integer("problem.dimension", 1, kMostNormals, "number of normals", usual));
  };
  constexpr double kMostBeta = 35;  // its probability is 1e-268
  const config::Range distance = config::Range{0, kMostBeta, true, false};
  if (p.name == "linear") {
    size(2);
    p.beta = {
        c.number("problem.beta", distance, "distance of the event from the origin, in sd; of 'union' a list of them")};
  } else if (p.name == "union") {
    p.beta = c.numbers("problem.beta", distance, config::kMeaningElsewhere);
    size(static_cast<int>(p.beta.size()));
    c.require(p.beta.size() <= static_cast<std::size_t>(p.dimension), "problem.beta",
              fmt::format("has {} values: must have at most problem.dimension = {}", p.beta.size(), p.dimension));
  } else if (p.name == "product") {
    p.level = c.number("problem.level", config::Range{0, 600, true, false}, "the event is a product above this level");
  } else if (p.name == "sphere") {
    size(2);
    p.radius = c.number("problem.radius", distance, "radius of the sphere");
  } else if (p.name == "disc") {
    p.mean = c.numbers("problem.mean", {}, "mean of the two normals", 2);
    p.sd = c.numbers("problem.sd", config::Range::positive(), "sd of the two normals", 2);
    p.radius = c.number("problem.radius", config::Range::positive(), "radius of the disc");
    c.require(std::hypot(p.mean[0], p.mean[1]) > p.radius, "problem.mean",
              "lies on the disc: the event holds at z = 0, and is not rare");
  }
  return rare::with_dimension(p);
}

std::vector<events::TrialEvent> event_of(const rare::TestProblem& problem) {
  events::TrialEvent e;
  e.name = problem.name;
  e.state = rare::test_limit_state(problem);
  e.from = rare::addresses_in(random::kRareNormal, random::kRareChoice, problem.dimension);
  e.predictions = {{"exact", rare::exact_probability(problem)}};
  e.half_spaces = rare::half_spaces_of(problem);
  return {e};
}

std::unique_ptr<study::PointPlan> read_plan(config::ConfigReader& c, random::StudySeed seed) {
  const rare::TestProblem problem = read_problem(c);
  events::EventRun run = events::read_event_run(c, {"union"});
  c.require(run.sampling.method != "union" || !rare::half_spaces_of(problem).empty(), "sampling.method",
            "the event is no union of half spaces: must be of another method, or the problem \"linear\" or \"union\"");
  compare::Annotations annotations = events::read_event_annotations(c, {"exact"});
  c.finish();
  return events::event_plan(std::move(run), std::move(annotations), random::stream_of(seed),
                            [problem] { return event_of(problem); });
}

}  // namespace

study::Experiment experiment() {
  study::Experiment e{random::StudyId::rare_event,
                      "Test functions of rare events: importance sampling against exact probabilities",
                      "black-box reliability challenge 2019; Waarts 2000; Owen, Maximov and Chertkov 2019", read_plan};
  e.approximations = {"form"};
  return e;
}

}  // namespace surveymc::studies::rare_event
