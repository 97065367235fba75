#include "config/error_model_file.h"

#include <algorithm>

#include <fmt/format.h>

namespace surveymc::config {
namespace {

const propagate::WeightingFunction& function_named(ConfigReader& term) {
  std::vector<std::string> names;
  for (const propagate::WeightingFunction& f : propagate::weighting_functions()) names.emplace_back(f.name);
  return *propagate::find_weighting_function(term.choice("function", names));
}

propagate::PropagationMode mode_named(const std::string& letter) {
  return letter == "R"   ? propagate::PropagationMode::random
         : letter == "S" ? propagate::PropagationMode::systematic
         : letter == "W" ? propagate::PropagationMode::well
                         : propagate::PropagationMode::global;
}

propagate::ErrorTerm read_term(ConfigReader& entry) {
  propagate::ErrorTerm term;
  term.code = entry.text("code");
  entry.require(!term.code.empty(), "code", "must not be empty");
  term.function = &function_named(entry);
  term.magnitude = entry.number("magnitude", Range::non_negative());
  term.unit = entry.text("unit");
  const double factor = propagate::unit_factor(term.function->quantity, term.unit);
  entry.require(
      factor > 0, "unit",
      fmt::format("the unit of {} must be {}", term.function->name, propagate::unit_names(term.function->quantity)));
  term.sigma = factor * term.magnitude;
  term.mode = mode_named(entry.choice("mode", {"R", "S", "W", "G"}));
  return term;
}

}  // namespace

propagate::ErrorModel read_error_model(ConfigReader document) {
  propagate::ErrorModel model;
  model.title = document.text("title", "");
  model.source = document.text("source", "");
  model.first_leg_doubled = document.choice("first_leg", {"once", "doubled"}) == "doubled";
  for (ConfigReader& entry : document.tables("terms")) {
    const propagate::ErrorTerm term = read_term(entry);
    const auto same = [&](const propagate::ErrorTerm& other) { return other.code == term.code; };
    entry.require(std::none_of(model.terms.begin(), model.terms.end(), same), "code", "two terms have this code");
    model.terms.push_back(term);
  }
  document.require(!model.terms.empty(), "terms", "a model has at least one term");
  document.finish();
  return model;
}

}  // namespace surveymc::config
