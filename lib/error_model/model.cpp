#include "error_model/model.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace surveymc::error_model {

char mode_letter(PropagationMode mode) { return "RSWG"[static_cast<std::size_t>(mode)]; }

std::string kind_name(Kind kind) {
  constexpr std::array kNames{"station", "course", "stationary", "continuous"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::vector<std::pair<const char*, const Expression*>> Function::formulas() const {
  std::vector<std::pair<const char*, const Expression*>> out;
  const auto add = [&](const char* key, const Expression& e) {
    if (!e.empty()) out.emplace_back(key, &e);
  };
  add("depth", depth);
  add("inclination", inclination);
  add("azimuth", azimuth);
  add("lateral", lateral);
  add("vertical_north", vertical_north);
  add("vertical_east", vertical_east);
  return out;
}

bool Function::names(Variable v) const {
  const auto all = formulas();
  return std::any_of(all.begin(), all.end(), [&](const auto& f) { return f.second->names(v); });
}

bool Model::names(Variable v) const {
  return std::any_of(terms.begin(), terms.end(), [&](const Term& t) { return t.function->names(v); });
}

double angle_to_east_west(double inclination, double magnetic_azimuth) {
  return std::acos(std::min(1.0, std::abs(std::sin(inclination) * std::sin(magnetic_azimuth))));
}

// --------------------------------------------------------------------------------------------------------------- units

namespace {

struct Unit {
  const char* name;
  Dimension dimension;
  double factor;
  bool is_listed = true;  // false: another spelling of the one before
};

constexpr Dimension kPerRootSecond{{}, {-1, 2}, {}};
constexpr std::array kUnits = std::to_array<Unit>({
    {"m", kMetre, 1},
    {"ft", kMetre, kFoot},
    {"1/m", kPerMetre, 1},
    {"1/ft", kPerMetre, 1 / kFoot},
    {"-", kPure, 1},
    {"deg", kPure, kDegree},
    {"rad", kPure, 1},
    {"m/s2", kAcceleration, 1},
    {"nT", kNanotesla, 1},
    {"uT", kNanotesla, 1000},
    {"deg.nT", kNanotesla, kDegree},
    {"rad.nT", kNanotesla, 1},
    {"deg/hr", kPerSecond, kDegree / 3600},
    {"deg/sqr(hr)", kPerRootSecond, kDegree / 60},
    {"deg/sqrt(hr)", kPerRootSecond, kDegree / 60, false},
});

}  // namespace

Dimension magnitude_dimension(const Function& f) {
  std::optional<Dimension> wanted;
  const char* first = "";
  for (const auto& [key, formula] : f.formulas()) {
    if (formula->is_absent()) continue;
    const Dimension target = formula == &f.depth ? kMetre : kPure;
    const Dimension own = target / dimension_of(*formula);
    if (wanted && own != *wanted)
      throw FormulaError(1, fmt::format("{} wants a magnitude in {}, and {} one in {}", first, dimension_text(*wanted),
                                        key, dimension_text(own)));
    wanted = own;
    first = key;
  }
  return wanted.value_or(kPure);
}

double unit_factor(const Dimension& dimension, const std::string& unit) {
  for (const Unit& u : kUnits)
    if (u.dimension == dimension && unit == u.name) return u.factor;
  return 0;
}

std::string unit_names(const Dimension& dimension) {
  std::vector<std::string> names;
  for (const Unit& u : kUnits)
    if (u.dimension == dimension && u.is_listed) names.push_back(fmt::format("\"{}\"", u.name));
  if (names.empty()) return dimension_text(dimension);
  std::string out = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) out += (i + 1 < names.size() ? ", " : " or ") + names[i];
  return out;
}

}  // namespace surveymc::error_model
