#include "multistation/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"

namespace surveymc::multistation {

namespace {

struct NamedSet {
  std::string_view name;
  std::vector<int> kinds;
};
const std::vector<NamedSet>& named_sets() {
  static const std::vector<NamedSet> sets = [] {
    const std::vector<int> six{kMagnetometerBias, kMagnetometerScale},
        twelve{kAccelerometerBias, kAccelerometerScale, kMagnetometerBias, kMagnetometerScale};
    const auto with = [](std::vector<int> kinds, int one_more) {
      kinds.push_back(one_more);
      return kinds;
    };
    const std::vector<int> fifteen = with(twelve, kRotation), eighteen = with(fifteen, kMagnetometerSkew);
    return std::vector<NamedSet>{{"6", six},       {"9", with(six, kRotation)},
                                 {"12", twelve},   {"15", fifteen},
                                 {"18", eighteen}, {"21", with(eighteen, kAccelerometerSkew)}};
  }();
  return sets;
}

}  // namespace

PerParameter<double> default_priors() {
  PerParameter<double> sd{};
  for (std::size_t i = 0; i < sd.size(); ++i) sd[i] = kTable[i].prior_sd;
  return sd;
}

int find_parameter(std::string_view name) {
  for (int i = 0; i < kParameters; ++i)
    if (name == parameter(i).name) return i;
  return -1;
}

const std::vector<std::string>& set_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const NamedSet& s : named_sets()) all.emplace_back(s.name);
    return all;
  }();
  return names;
}

ParameterSet ParameterSet::named(std::string_view name) {
  for (const NamedSet& s : named_sets())
    if (s.name == name) {
      std::vector<std::string> parameters;
      for (const int kind : s.kinds)
        for (int i = kind; i < kind + 3; ++i) parameters.emplace_back(parameter(i).name);
      return of(parameters);
    }
  require(false, "parameters = \"{}\": must be one of {}, or a list of names", name, fmt::join(set_names(), ", "));
  return {};
}

ParameterSet ParameterSet::of(const std::vector<std::string>& parameters) {
  require(!parameters.empty(), "parameters = []: must name at least one");
  ParameterSet s;
  for (const std::string& name : parameters) {
    const int i = find_parameter(name);
    std::vector<std::string_view> all;
    for (const Parameter& p : kTable) all.emplace_back(p.name);
    require(i >= 0, "parameters: \"{}\": must be one of {}", name, fmt::join(all, ", "));
    require(!s.contains(i), "parameters: \"{}\" is there twice", name);
    s.contained_[static_cast<std::size_t>(i)] = true;
  }
  for (int i = 0; i < kParameters; ++i)
    if (s.contains(i)) s.indices_.push_back(i);
  return s;
}

std::vector<std::string_view> ParameterSet::names() const {
  std::vector<std::string_view> out;
  for (const int i : indices_) out.emplace_back(parameter(i).name);
  return out;
}

std::string ParameterSet::name() const {
  for (const NamedSet& s : named_sets()) {
    bool same = size() == 3 * static_cast<int>(s.kinds.size());
    for (const int kind : s.kinds)
      for (int i = kind; i < kind + 3; ++i) same = same && contains(i);
    if (same) return std::string(s.name);
  }
  return fmt::format("{}", fmt::join(names(), ", "));
}

}  // namespace surveymc::multistation
