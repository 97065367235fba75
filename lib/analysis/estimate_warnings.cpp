#include "analysis/estimate_warnings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/standard_deviation.h"
#include "base/units.h"

namespace surveymc::analysis {
namespace {

constexpr double kInseparable = 0.95;    // correlation: the sd of one triples when the other is not known
constexpr double kNonlinearGain = 0.05;  // sd above it: first order is off by some per cent, as in thesis test 1
constexpr double kPlausibleGain = 0.1;   // no healthy tool is further off
constexpr double kPlausibleBias = 0.05;  // of the total field
constexpr double kGravityShare = 0.002;  // of gravity: what a moving tool or a bad accelerometer exceeds

using Warnings = std::vector<Warning>;

std::string shown(int parameter, double x) { return fmt::format("{:.3g}{}", x, parameter < 3 ? "" : " nT"); }

void warn_of_stations(const survey::SixAxisReadings& r, const ReadingsAnalysis& a, Warnings& out) {
  if (a.tests.redundancy == 0)
    out.push_back({"severe", fmt::format("{} stations give {} residuals for 6 unknowns: nothing checks the estimate, "
                                         "and no gross error would show",
                                         r.size(), 2 * r.size())});
  else if (r.size() < 8)
    out.push_back({"warning", fmt::format("few stations: {} leave {} redundant residuals to find gross errors with",
                                          r.size(), a.tests.redundancy)});
  if (a.rotation_gap > 180 * kDegree)
    out.push_back({"warning", fmt::format("poor rotation: no station in {:.0f} deg of toolface; biases and gains of x "
                                          "and y come from their differences between toolfaces",
                                          a.rotation_gap / kDegree)});
}

double correlation(const estimate::Matrix6d& c, int i, int j) { return c(i, j) / std::sqrt(c(i, i) * c(j, j)); }

/// Parameters whose sd comes nearly alone from the reference's uncertainty, so that their errors are correlated.
std::vector<int> reference_bound(const ReadingsAnalysis& a) {
  std::vector<int> bound;
  for (int i = 0; i < 6; ++i)
    if (a.reference_covariance(i, i) > 0.9 * a.covariance(i, i)) bound.push_back(i);
  return bound;
}

/// True if a parameter is known so badly that first-order theory means little.
bool is_hardly_known(const ReadingsAnalysis& a, const survey::ReferenceField& field, int i) {
  return std::sqrt(a.covariance(i, i)) / (i < 3 ? 1 : field.total) > kNonlinearGain;
}

void warn_of_reference(const ReadingsAnalysis& a, Warnings& out) {
  std::vector<std::string> names;
  for (const int i : reference_bound(a))
    names.push_back(fmt::format("{} (sd {}, of it by noise {})", estimate::parameter_name(i),
                                shown(i, std::sqrt(a.covariance(i, i))),
                                shown(i, standard_deviation(a.noise_covariance()(i, i)))));
  if (!names.empty())
    out.push_back({"info", fmt::format("the reference field's uncertainty makes nearly all of the sd of {}: a better "
                                       "reference helps there, more stations do not",
                                       fmt::join(names, ", "))});
}

/// Warns of pairs that the stations' geometry does not separate. An error of the reference correlates parameters, too,
/// but not by geometry: warn_of_reference() covers it.
void warn_of_observability(const ReadingsAnalysis& a, const survey::ReferenceField& field, Warnings& out) {
  const std::vector<int> bound = reference_bound(a);
  const auto is_bound = [&](int i) { return std::find(bound.begin(), bound.end(), i) != bound.end(); };
  const estimate::Matrix6d not_by_reference = a.covariance - a.reference_covariance;
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j) {
      if (is_hardly_known(a, field, i) || is_hardly_known(a, field, j)) continue;  // and said to be
      const bool by_geometry = std::abs(correlation(not_by_reference, i, j)) >= kInseparable;
      const double r = correlation(a.covariance, i, j);
      if (std::abs(r) < kInseparable || (!by_geometry && (is_bound(i) || is_bound(j)))) continue;
      const auto sd = [&](int k) { return std::sqrt(a.covariance(k, k)); };
      const double left = std::sqrt(1 - r * r);
      out.push_back(
          {"warning",
           fmt::format("MSA cannot separate {} from {} here (correlation {:.3f}): sd {} and {}, but {} and {} "
                       "if the other were known. The covariance of the corrected survey counts that in; take "
                       "neither alone to another run",
                       estimate::parameter_name(i), estimate::parameter_name(j), r, shown(i, sd(i)), shown(j, sd(j)),
                       shown(i, sd(i) * left), shown(j, sd(j) * left))});
    }
  const estimate::Observability& o = a.observability;
  for (int j = 0; j < 6; ++j)
    if (o.condition_indices[j] > estimate::kWeakCondition)
      out.push_back(
          {o.condition_indices[j] > estimate::kSevereCondition ? "severe" : "warning",
           fmt::format("ill-conditioned: the stations hardly determine {} (condition index {:.3g}; above {:g} "
                       "is weak, above {:g} unusable)",
                       estimate::combination_name(o.directions.col(j)), o.condition_indices[j],
                       estimate::kWeakCondition, estimate::kSevereCondition)});
}

void warn_of_parameters(const ReadingsAnalysis& a, const survey::ReferenceField& field, Warnings& out) {
  for (int i = 0; i < 6; ++i) {
    const double sd = std::sqrt(a.covariance(i, i)), relative = i < 3 ? sd : sd / field.total;
    const double off = i < 3 ? a.parameters[i] - 1 : a.parameters[i] / field.total;
    if (is_hardly_known(a, field, i))
      out.push_back({"severe", fmt::format("{} is hardly known: {} with sd {}; intervals are first-order, and too "
                                           "narrow at this size",
                                           estimate::parameter_name(i), shown(i, a.parameters[i]), shown(i, sd))});
    if (std::abs(off) > (i < 3 ? kPlausibleGain : kPlausibleBias) && std::abs(off) > 3 * relative)
      out.push_back({"warning", fmt::format("{} = {} is implausible for a healthy tool: a bad sensor, or the readings' "
                                            "axes or unit",
                                            estimate::parameter_name(i), shown(i, a.parameters[i]))});
  }
}

/// "bz (w 16.0), not to be told from gy; without the station s0 is 0.98"
std::string likely_reading(const Suspect& s) {
  if (s.readings.empty()) return "no single reading";
  std::vector<std::string> others;
  for (std::size_t i = 1; i < s.readings.size(); ++i)
    if (s.readings[i].in_group) others.push_back(s.readings[i].reading);
  std::string text = fmt::format("{} (w {:.2f}, an error of {:.3g} {})", s.readings[0].reading, s.readings[0].w,
                                 s.readings[0].error, s.readings[0].unit);
  if (!others.empty()) text += fmt::format(", not to be told from {}", fmt::join(others, ", "));
  if (s.without)
    text += fmt::format("; without the station s0 is {:.3g}", std::sqrt(s.without->tests.variance_factor()));
  return text;
}

void warn_of_tests(const std::vector<ReadingsTest>& tests, const std::optional<Suspect>& examined, Warnings& out) {
  for (const ReadingsTest& t : tests) {
    if (t.test == "variance_factor" && t.decision == "rejected")
      out.push_back(
          {t.statistic > 1 ? "severe" : "info", fmt::format("variance factor {:.3g} (accepted {:.3g} .. {:.3g}): {}",
                                                            t.statistic, t.critical_low, t.critical_high, t.note)});
    if (t.test == "perfect_tool" && t.decision == "accepted")
      out.push_back({"info", t.note + ": the correction may add more error than it removes"});
  }
  const int s = suspect(tests);
  if (s < 0) return;
  const auto others =
      std::count_if(tests.begin(), tests.end(),
                    [](const ReadingsTest& t) { return t.test == "residual" && t.decision == "rejected"; }) -
      1;
  const ReadingsTest& t = tests[static_cast<std::size_t>(s)];
  out.push_back(
      {"warning",
       fmt::format("station {} (md {:.10g} m) is suspect: its {} field has w = {:.2f} (critical {:.2f}), an error of "
                   "{:.0f} nT (sd {:.0f}) if it is the only one{}; most likely reading {}; estimates without the "
                   "station are in "
                   "table without_suspect",
                   t.station + 1, t.md, t.component, t.statistic, t.critical_high, t.error, t.error_sd,
                   others > 0 ? fmt::format("; {} more residual{} beyond the critical value", others,
                                            others == 1 ? " is" : "s are")
                              : "",
                   examined ? likely_reading(*examined) : "unknown")});
}

void warn_of_accelerometers(const survey::SixAxisReadings& r, const survey::ReferenceField& field,
                            const sensor::NoiseModel& noise, const ReadingsAnalysis& a, Warnings& out) {
  if (a.vertical_field_reversed)
    out.push_back({"severe",
                   "the readings' dip has the other sign than the reference: the accelerometers may read the "
                   "other way round (key `accelerometers`), or field.dip_deg has the wrong sign"});
  std::vector<std::string> bad;
  double worst = 0;
  for (std::size_t k = 0; k < a.stations.size(); ++k) {
    const double off = a.stations[k].gravity_residual;
    if (std::abs(off) < std::max(kGravityShare * field.gravity, 4 * noise.accelerometer)) continue;
    if (std::abs(off) > std::abs(worst)) worst = off;
    bad.push_back(fmt::format("{:.10g}", r.md[k]));
  }
  if (bad.empty()) return;
  const std::size_t count = bad.size();
  if (count > 5) bad.resize(5);
  out.push_back(
      {"warning", fmt::format("gravity is off by up to {:+.3g} m/s2 at {} station{} (md {}{} m): moving tool, "
                              "accelerometer error, or field.gravity_mps2",
                              worst, count, count == 1 ? "" : "s", fmt::join(bad, ", "), count > 5 ? ", ..." : "")});
}

void warn_of_profile(const std::vector<ProfiledInterval>& profiled, Warnings& out) {
  std::vector<std::string> differ, undetermined;
  double jump = 0;
  for (const ProfiledInterval& x : profiled) {
    jump = std::max(jump, x.jump_probability);
    if (!x.is_determined()) undetermined.push_back(x.quantity);
    if (x.is_notable())
      differ.push_back(fmt::format("{} {:.4g} .. {:.4g} (covariance {:.4g} .. {:.4g})", x.quantity, x.profile_low,
                                   x.profile_high, x.first_low, x.first_high));
  }
  if (!differ.empty())
    out.push_back({"warning", fmt::format("the covariance does not hold: errors of the claimed size move the estimate "
                                          "out of proportion. Take the profile's intervals: {}",
                                          fmt::join(differ, ", "))});
  if (!undetermined.empty())
    out.push_back(
        {"warning", fmt::format("nothing tells whether the covariance holds of {}: errors of the claimed size "
                                "lead to readings without an estimate, and the profile has no value",
                                fmt::join(undetermined, ", "))});
  if (constexpr double kRare = 1e-4; jump > kRare)
    out.push_back({"warning", fmt::format("with a probability of {:.2g} the estimate is that of another minimum than "
                                          "the truth: no interval shows it",
                                          jump)});
}

}  // namespace

Warnings warnings_of_estimate(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                              const sensor::NoiseModel& noise, const ReadingsAnalysis& analysis,
                              const std::vector<ReadingsTest>& tests, const std::optional<Suspect>& examined,
                              const std::vector<ProfiledInterval>& profiled) {
  Warnings all;
  warn_of_accelerometers(readings, field, noise, analysis, all);
  warn_of_stations(readings, analysis, all);
  warn_of_parameters(analysis, field, all);
  warn_of_observability(analysis, field, all);
  warn_of_reference(analysis, all);
  warn_of_tests(tests, examined, all);
  warn_of_profile(profiled, all);
  const auto rank = [](const Warning& w) { return w.severity == "severe" ? 0 : w.severity == "warning" ? 1 : 2; };
  std::stable_sort(all.begin(), all.end(), [&](const Warning& a, const Warning& b) { return rank(a) < rank(b); });
  return all;
}

}  // namespace surveymc::analysis
