#include "propagate/code_draws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "base/error.h"

namespace surveymc::propagate {

using error_model::PropagationMode;
using error_model::Term;

namespace {

/// The functions whose terms are one error of the sensors.
struct SensorPart {
  std::string_view function;
  survey::SensorTerm kind;
  bool cross_axis;  ///< of x and y; else of z
};
constexpr std::array<SensorPart, 14> kSensorParts{{
    {"ABXY-TI1", survey::kAccelerometerBias, true},
    {"ABXY-TI2", survey::kAccelerometerBias, true},
    {"ABZ", survey::kAccelerometerBias, false},
    {"ASXY-TI1", survey::kAccelerometerScale, true},
    {"ASXY-TI2", survey::kAccelerometerScale, true},
    {"ASXY-TI3", survey::kAccelerometerScale, true},
    {"ASZ", survey::kAccelerometerScale, false},
    {"MBXY-TI1", survey::kMagnetometerBias, true},
    {"MBXY-TI2", survey::kMagnetometerBias, true},
    {"MBZ", survey::kMagnetometerBias, false},
    {"MSXY-TI1", survey::kMagnetometerScale, true},
    {"MSXY-TI2", survey::kMagnetometerScale, true},
    {"MSXY-TI3", survey::kMagnetometerScale, true},
    {"MSZ", survey::kMagnetometerScale, false},
}};
constexpr std::array<std::string_view, 13> kCarried{"DREF", "DSF",  "DST",   "SAGE",  "SAG",  "XYM1", "XYM2",
                                                    "XYM3", "XYM4", "XYM3E", "XYM4E", "XCLA", "XCLH"};
/// Of magnetic codes, corrected ones among them, besides kSensorParts.
constexpr std::array<std::string_view, 18> kMagnetic{
    "AZ",        "DBH",       "AMIL",      "AMID", "MDI",       "MFI",       "ABIXY-TI1", "ABIXY-TI2", "ABIZ",
    "ASIXY-TI1", "ASIXY-TI2", "ASIXY-TI3", "ASIZ", "MBIXY-TI1", "MBIXY-TI2", "MSIXY-TI1", "MSIXY-TI2", "MSIXY-TI3"};

const SensorPart* sensor_part(const Term& term) {
  for (const SensorPart& p : kSensorParts)
    if (p.function == term.function->name) return &p;
  return nullptr;
}

bool is_magnetic(const Term& term) {
  return sensor_part(term) != nullptr ||
         std::find(kMagnetic.begin(), kMagnetic.end(), term.function->name) != kMagnetic.end();
}

const char* kind_text(survey::SensorTerm kind) {
  switch (kind) {
    case survey::kAccelerometerBias:
      return "accelerometer bias";
    case survey::kAccelerometerScale:
      return "accelerometer scale";
    case survey::kMagnetometerBias:
      return "magnetometer bias";
    case survey::kMagnetometerScale:
      return "magnetometer scale";
  }
  return "";
}

std::string named(const error_model::Model& model, const Term& term) {
  return model.name + ": term " + term.code + " (function " + term.function->name + ")";
}

/// The member of the reference that the terms of a function make up; null of another function.
double CodeDraws::Reference::*reference_part(std::string_view function) {
  using Reference = CodeDraws::Reference;
  if (function == "AZ") return &Reference::declination;
  if (function == "DBH") return &Reference::east;
  if (function == "MFI") return &Reference::total;
  if (function == "MDI") return &Reference::dip;
  return nullptr;
}

void add_reference(const error_model::Model& model, const Term& term, MappedCode& out) {
  const bool each = term.mode == PropagationMode::random;
  double& size = (each ? out.draws.station : out.draws.run).*reference_part(term.function->name);
  size = std::hypot(size, term.sigma);
  const std::string& f = term.function->name;
  out.terms.push_back({term.code, model.name,
                       f == "AZ"    ? "declination"
                       : f == "DBH" ? "declination, by the horizontal field"
                       : f == "MFI" ? "total field"
                                    : "dip",
                       error_model::mode_letter(term.mode), term.magnitude, term.unit});
}

}  // namespace

double CodeDraws::Reference::declination_in(const survey::ReferenceField& field) const {
  return std::hypot(declination, east / (field.total * std::cos(field.dip)));
}

double CodeDraws::axial_bias() const { return std::hypot(sensors[survey::kMagnetometerBias + 2], interference); }

CodeDraws CodeDraws::scaled(double factor) const {
  CodeDraws d = *this;
  for (double& s : d.sensors) s *= factor;
  d.interference *= factor;
  for (Reference* r : {&d.run, &d.station})
    *r = {factor * r->total, factor * r->dip, factor * r->declination, factor * r->east};
  return d;
}

bool is_carried(const Term& term) {
  return std::find(kCarried.begin(), kCarried.end(), term.function->name) != kCarried.end();
}

error_model::Model carried_part(const error_model::Model& model, bool carried) {
  error_model::Model part = model;
  part.terms.clear();
  for (const Term& term : model.terms) {
    require(is_carried(term) || is_magnetic(term), "{}: no term of a magnetic tool code", named(model, term));
    if (is_carried(term) == carried) part.terms.push_back(term);
  }
  return part;
}

MappedCode map_code(const error_model::Model& base, const error_model::Model* reference_of) {
  MappedCode out;
  std::array<std::optional<double>, kSensorParts.size()> sizes;
  for (const Term& term : base.terms) {
    const char mode = error_model::mode_letter(term.mode);
    if (is_carried(term)) {
      out.terms.push_back({term.code, base.name, "carried", mode, term.magnitude, term.unit, true});
      continue;
    }
    const std::string& f = term.function->name;
    if (f == "AZ" || f == "DBH") {
      add_reference(base, term, out);
      continue;
    }
    const SensorPart* part = sensor_part(term);
    require(part != nullptr || f == "AMIL",
            "{}: cannot be drawn as an error of six axes; the base must be a magnetic code without axial correction",
            named(base, term));
    require(term.mode != PropagationMode::random, "{}: mode R: errors of the sensors are drawn once a run",
            named(base, term));
    if (part == nullptr) {
      out.draws.interference = std::hypot(out.draws.interference, term.sigma);
      out.terms.push_back(
          {term.code, base.name, "magnetometer bias z, by a draw of its own", mode, term.magnitude, term.unit});
      continue;
    }
    std::optional<double>& size = sizes[static_cast<std::size_t>(part - kSensorParts.data())];
    require(!size, "{}: the function is there twice", named(base, term));
    size = term.sigma;
    out.terms.push_back({term.code, base.name, std::string(kind_text(part->kind)) + (part->cross_axis ? " x, y" : " z"),
                         mode, term.magnitude, term.unit});
  }
  for (std::size_t i = 0; i < kSensorParts.size(); ++i) {
    const SensorPart& p = kSensorParts[i];
    const double size = sizes[i].value_or(0);
    const auto at = static_cast<std::size_t>(p.kind);
    if (!p.cross_axis) {
      out.draws.sensors[at + 2] = size;
      continue;
    }
    const bool first = i == 0 || kSensorParts[i - 1].kind != p.kind;
    require(first || out.draws.sensors[at] == size,
            "{}: terms {} and {} differ in magnitude ({:g}, {:g}): they are one error of x and y and must be alike",
            base.name, kSensorParts[i - 1].function, p.function, out.draws.sensors[at], size);
    out.draws.sensors[at] = out.draws.sensors[at + 1] = size;
  }
  if (reference_of != nullptr)
    for (const Term& term : reference_of->terms)
      if (term.function->name == "MFI" || term.function->name == "MDI") add_reference(*reference_of, term, out);
  return out;
}

std::string axial_twin(const std::string& base, const std::vector<std::string>& all) {
  const auto parts = [](std::string_view name) {
    std::multiset<std::string> out;
    for (std::size_t from = 0; from <= name.size();) {
      const std::size_t to = std::min(name.find('+', from), name.size());
      out.emplace(name.substr(from, to - from));
      from = to + 1;
    }
    return out;
  };
  // "_Fl" belongs to the whole name.
  constexpr std::string_view kFloating = "_Fl";
  const auto whole = [&](std::string_view name) {
    const bool floating = name.ends_with(kFloating);
    std::multiset<std::string> p = parts(floating ? name.substr(0, name.size() - kFloating.size()) : name);
    if (floating) p.emplace(kFloating);
    return p;
  };
  std::multiset<std::string> wanted = whole(base);
  wanted.emplace("AX");
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const std::string& name) { return whole(name) == wanted; });
  return found == all.end() ? std::string() : *found;
}

}  // namespace surveymc::propagate
