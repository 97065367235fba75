#include "propagate/weighting_functions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.h"

namespace surveymc::propagate {

const double kLeastTortuosity = kDegree / (100 * kFoot);
const double kVerticalLimit = 0.0001 * kDegree;

namespace {

using S = StationGeometry;
constexpr double kSqrt2 = 1.41421356237309505;

/// Misalignment that is drawn anew at every station: stations closer than 10 m are not independent (Rev 5).
double short_leg_factor(const S& s) { return std::max(1.0, std::sqrt(10 / s.dmd)); }

Weights xym3(const S& s) { return {0, std::abs(s.cos_i) * s.cos_a, -std::abs(s.cos_i) * s.sin_a}; }
Weights xym4(const S& s) { return {0, std::abs(s.cos_i) * s.sin_a, std::abs(s.cos_i) * s.cos_a}; }
Weights scaled(double f, const Weights& w) { return {f * w.depth, f * w.inclination, f * w.lateral}; }

/// Errors of accelerometers that change only the measured inclination, by w, and with it the azimuth: an inclination
/// error w turns the azimuth by -w tanD sinAm.
Weights tilt(const S& s, double w) { return {0, w, -w * s.tan_dip * s.sin_i * s.sin_am}; }
/// Errors of the measured azimuth alone.
Weights turn(double lateral) { return {0, 0, lateral}; }

double course(double angle, const S& s) { return s.dmd * std::max(angle, kLeastTortuosity * s.dmd); }

using Q = Quantity;
constexpr std::array kFunctions = std::to_array<WeightingFunction>({
    // depth
    {"DREF", Q::length, false, [](const S&) { return Weights{1, 0, 0}; }},
    {"DSF", Q::ratio, false, [](const S& s) { return Weights{s.md, 0, 0}; }},
    {"DST", Q::per_length, false, [](const S& s) { return Weights{s.md * s.tvd, 0, 0}; }},
    // accelerometers: bias, scale factor
    {"ABXY-TI1", Q::acceleration, false, [](const S& s) { return tilt(s, -s.cos_i / s.gravity); }},
    {"ABXY-TI2", Q::acceleration, false,
     [](const S& s) { return turn((s.cos_i - s.tan_dip * s.sin_i * s.cos_am) / s.gravity); }},
    {"ABZ", Q::acceleration, false, [](const S& s) { return tilt(s, -s.sin_i / s.gravity); }},
    {"ASXY-TI1", Q::ratio, false, [](const S& s) { return tilt(s, s.sin_i * s.cos_i / kSqrt2); }},
    {"ASXY-TI2", Q::ratio, false, [](const S& s) { return tilt(s, s.sin_i * s.cos_i / 2); }},
    {"ASXY-TI3", Q::ratio, false,
     [](const S& s) { return turn(s.sin_i * (s.tan_dip * s.sin_i * s.cos_am - s.cos_i) / 2); }},
    {"ASZ", Q::ratio, false, [](const S& s) { return tilt(s, -s.sin_i * s.cos_i); }},
    // magnetometers: bias, scale factor
    {"MBXY-TI1", Q::magnetic_field, false,
     [](const S& s) { return turn(-s.sin_i * s.cos_i * s.sin_am / s.horizontal_field); }},
    {"MBXY-TI2", Q::magnetic_field, false, [](const S& s) { return turn(s.sin_i * s.cos_am / s.horizontal_field); }},
    {"MBZ", Q::magnetic_field, false,
     [](const S& s) { return turn(-s.sin_i * s.sin_i * s.sin_am / s.horizontal_field); }},
    {"MSXY-TI1", Q::ratio, false,
     [](const S& s) {
       return turn(s.sin_i * s.sin_i * s.sin_am * (s.tan_dip * s.cos_i + s.sin_i * s.cos_am) / kSqrt2);
     }},
    {"MSXY-TI2", Q::ratio, false,
     [](const S& s) {
       return turn(s.sin_i * s.sin_am * (s.tan_dip * s.sin_i * s.cos_i - s.cos_i * s.cos_i * s.cos_am - s.cos_am) / 2);
     }},
    {"MSXY-TI3", Q::ratio, false,
     [](const S& s) {
       return turn(s.sin_i *
                   (s.cos_i * (s.cos_am * s.cos_am - s.sin_am * s.sin_am) - s.tan_dip * s.sin_i * s.cos_am) / 2);
     }},
    {"MSZ", Q::ratio, false,
     [](const S& s) { return turn(-s.sin_i * s.sin_i * s.sin_am * (s.sin_i * s.cos_am + s.tan_dip * s.cos_i)); }},
    // reference field and axial interference
    {"AZ", Q::angle, false, [](const S& s) { return turn(s.sin_i); }},
    {"DBH", Q::angle_by_field, false, [](const S& s) { return turn(s.sin_i / s.horizontal_field); }},
    {"AMIL", Q::magnetic_field, false,
     [](const S& s) { return turn(s.sin_i * s.sin_i * s.sin_am / s.horizontal_field); }},
    // sag and misalignment
    {"SAG", Q::angle, false, [](const S& s) { return Weights{0, s.sin_i, 0}; }},
    {"SAGE", Q::angle, false, [](const S& s) { return Weights{0, std::sqrt(std::sqrt(std::abs(s.sin_i))), 0}; }},
    {"XYM1", Q::angle, false, [](const S& s) { return Weights{0, std::abs(s.sin_i), 0}; }},
    {"XYM2", Q::angle, false, [](const S& s) { return turn(-s.sin_i); }},
    {"XYM3", Q::angle, false, xym3},
    {"XYM4", Q::angle, false, xym4},
    {"XYM3E", Q::angle, false, [](const S& s) { return scaled(short_leg_factor(s), xym3(s)); }},
    {"XYM4E", Q::angle, false, [](const S& s) { return scaled(short_leg_factor(s), xym4(s)); }},
    // course between stations: lateral and high side
    {"XCLA", Q::ratio, true, [](const S& s) { return Weights{0, 0, course(s.azimuth_turn, s)}; }},
    {"XCLH", Q::ratio, true, [](const S& s) { return Weights{0, course(s.inclination_change, s), 0}; }},
});

}  // namespace

std::span<const WeightingFunction> weighting_functions() { return kFunctions; }

const WeightingFunction* find_weighting_function(const std::string& name) {
  for (const WeightingFunction& f : kFunctions)
    if (name == f.name) return &f;
  return nullptr;
}

}  // namespace surveymc::propagate
