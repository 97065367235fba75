#include "error_model/variable.h"

#include <algorithm>

#include "base/units.h"

namespace surveymc::error_model {

const double kEarthRate = 15.041067 * kDegree / 3600;

namespace {

struct Name {
  std::string_view text;
  Variable variable;
  bool is_alias = false;
  Dimension dimension = kPure;
};
using V = Variable;
constexpr std::array kNames = std::to_array<Name>({
    {"MD", V::md, false, kMetre},
    {"MDPrev", V::md_before, false, kMetre},
    {"TVD", V::tvd, false, kMetre},
    {"Inc", V::inclination},
    {"IncPrev", V::inclination_before},
    {"AzM", V::azimuth_magnetic},
    {"AzT", V::azimuth},
    {"Az", V::azimuth, true},
    {"AzPrev", V::azimuth_before},
    {"Dip", V::dip},
    {"BField", V::total_field, false, kNanotesla},
    {"GField", V::gravity, false, kAcceleration},
    {"Latitude", V::latitude},
    {"EarthRate", V::earth_rate, false, kPerSecond},
    {"MinCourseLength", V::min_course_length, false, kMetre},
    {"XCLTortuosity", V::tortuosity, false, kPerMetre},
    {"NoiseReductionFactor", V::noise_reduction},
    {"RunningSpeed", V::running_speed, false, kSpeed},
    {"GXYRunningSpeed", V::running_speed, true},
    {"GZRunningSpeed", V::running_speed, true},
    {"GXYZRunningSpeed", V::running_speed, true},
    {"Previous", V::previous},
    {"XY_Gyro_Drift", V::previous, true},
    {"XY_Gyro_Random_Walk", V::previous, true},
    {"Z_Gyro_Drift", V::previous, true},
    {"Z_Gyro_Random_Walk", V::previous, true},
    {"XYZ_Gyro_Drift", V::previous, true},
    {"XYZ_Gyro_Random_Walk", V::previous, true},
});

constexpr char small_letter(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

}  // namespace

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return small_letter(x) == small_letter(y); });
}

std::optional<Variable> find_variable(std::string_view name) {
  for (const Name& n : kNames)
    if (same_name(n.text, name)) return n.variable;
  return {};
}

std::string variable_name(Variable v) {
  for (const Name& n : kNames)
    if (n.variable == v) return std::string(n.text);
  return "";
}

const std::vector<std::string>& variable_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Name& n : kNames)
      if (!n.is_alias) out.emplace_back(n.text);
    return out;
  }();
  return names;
}

Dimension dimension_of(Variable v) {
  for (const Name& n : kNames)
    if (n.variable == v) return n.dimension;
  return kPure;
}

}  // namespace surveymc::error_model
