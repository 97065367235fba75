#include "survey/toolface_plan.h"

#include <algorithm>

#include "survey/survey.h"

namespace surveymc::survey {

namespace {

ToolfacePlan all_of(ToolfaceSource source, int stations) {
  const auto n = static_cast<std::size_t>(stations);
  return {std::vector<ToolfaceSource>(n, source), std::vector<double>(n, 0.0)};
}

}  // namespace

bool ToolfacePlan::has(ToolfaceSource s) const { return std::find(source.begin(), source.end(), s) != source.end(); }

int ToolfacePlan::first_slid() const {
  const auto at = std::find(source.begin(), source.end(), ToolfaceSource::slide);
  return at == source.end() ? -1 : static_cast<int>(at - source.begin());
}

ToolfacePlan surveyed_toolfaces(const Survey& survey) {
  ToolfacePlan plan = all_of(ToolfaceSource::given, survey.size());
  for (std::size_t k = 0; k < survey.stations.size(); ++k) plan.given[k] = survey.stations[k].toolface;
  return plan;
}

ToolfacePlan constant_toolface(int stations, double toolface) {
  ToolfacePlan plan = all_of(ToolfaceSource::given, stations);
  std::fill(plan.given.begin(), plan.given.end(), toolface);
  return plan;
}

ToolfacePlan slid(int stations) { return all_of(ToolfaceSource::slide, stations); }

ToolfacePlan rotated(int stations) { return all_of(ToolfaceSource::own, stations); }

ToolfacePlan partly_slid(const std::vector<double>& md, double slide_from, double slide_to) {
  ToolfacePlan plan = rotated(static_cast<int>(md.size()));
  for (std::size_t k = 0; k < md.size(); ++k)
    if (!is_deeper(slide_from, md[k]) && !is_deeper(md[k], slide_to)) plan.source[k] = ToolfaceSource::slide;
  return plan;
}

}  // namespace surveymc::survey
