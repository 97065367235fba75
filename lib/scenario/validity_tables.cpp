#include "scenario/validity_tables.h"

#include <fmt/format.h>

#include "compare/table_rows.h"

namespace surveymc::scenario {
namespace {

double md_of(const survey::Survey& survey, std::size_t station) { return survey.stations[station].md; }

}  // namespace

store::Table validity_table(const survey::Survey& survey, const ToolRuns& tools,
                            const std::vector<propagate::Validity>& validity) {
  compare::TableRows t("validity", "where the error models do not hold, and what else to know of them");
  compare::write_rows(t, validity, [&](const propagate::Validity& v) {
    t.count("leg", "number of the survey leg, from 1", v.run + 1);
    t.word("model", "error model of the leg", tools.model_names[v.run]);
    t.word("rule", "inclination range, east-west exclusion, not finite, zero term, function differs, or a note",
           propagate::rule_name(v.rule));
    t.count("stations", "number of stations that it is about", v.stations);
    t.number("first_md_m", "m", "measured depth of the first of them", md_of(survey, v.first));
    t.number("last_md_m", "m", "measured depth of the last of them", md_of(survey, v.last));
    t.word("detail", "in words", v.detail);
  });
  return t.take();
}

std::vector<compare::Warning> validity_warnings(const survey::Survey& survey, const ToolRuns& tools,
                                                const std::vector<propagate::Validity>& validity,
                                                const std::string& well) {
  std::vector<compare::Warning> out;
  for (const propagate::Validity& v : validity) {
    if (v.rule == propagate::ValidityRule::note) continue;
    out.push_back({v.rule == propagate::ValidityRule::not_finite ? "severe" : "warning",
                   fmt::format("{}{}{}", well, well.empty() ? "" : ": ", tools.model_names[v.run]), "",
                   fmt::format("{}: {} station{}, md {:g} to {:g} m: {}", propagate::rule_name(v.rule), v.stations,
                               v.stations == 1 ? "" : "s", md_of(survey, v.first), md_of(survey, v.last), v.detail)});
  }
  return out;
}

}  // namespace surveymc::scenario
