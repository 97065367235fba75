#include "estimate/run_tables.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/standard_deviation.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "compare/verdict.h"
#include "compare/warnings.h"
#include "stats/intervals.h"

namespace surveymc::studies::estimate {
namespace {

std::string quantity(int parameter) {
  return std::string(surveymc::estimate::parameter_name(parameter)) + (parameter < 3 ? "" : "_nT");
}

store::Table parameters_table(const analysis::ReadingsAnalysis& a, const analysis::TestLevels& levels) {
  compare::TableRows t("parameters",
                       "gains and biases of the magnetometers" + compare::at_confidence(levels.confidence));
  const double z = stats::normal_quantile((1 + levels.confidence) / 2), s0 = std::sqrt(a.tests.variance_factor());
  for (int i = 0; i < 6; ++i) {
    const double x = a.parameters[i], sd = std::sqrt(a.covariance(i, i));
    int other = i == 0 ? 1 : 0;
    const auto correlation = [&](int j) { return a.covariance(i, j) / std::sqrt(a.covariance(j, j)) / sd; };
    for (int j = 0; j < 6; ++j)
      if (j != i && std::abs(correlation(j)) > std::abs(correlation(other))) other = j;
    t.word("quantity", "gain (1) or bias (nT)", quantity(i));
    t.number("estimate", "1", "estimate, in the unit of the quantity", x, "ci_low ci_high");
    t.number("sd", "1", "standard deviation by the a-priori noise, reference included", sd);
    t.number("ci_low", "1", "lower bound of the confidence interval", x - z * sd);
    t.number("ci_high", "1", "upper bound of the confidence interval", x + z * sd);
    t.number("sd_noise", "1", "part of sd that the sensors' noise makes",
             standard_deviation(a.noise_covariance()(i, i)));
    t.number("sd_reference", "1", "part of sd that the reference field's uncertainty makes",
             std::sqrt(a.reference_covariance(i, i)));
    t.number("sd_prior", "1", "part of sd that tools make which vary as the estimator's priors say",
             standard_deviation(a.prior_covariance()(i, i)));
    t.number("sd_a_posteriori", "1", "sd times the root of the variance factor of the residuals", s0 * sd);
    t.number("deviation_sd", "1", "estimate less that of a perfect tool, over sd", (x - (i < 3 ? 1 : 0)) / sd);
    t.number("variance_inflation", "1", "variance over what it were, were the parameters uncorrelated",
             a.observability.variance_inflation[i]);
    t.word("most_correlated", "the parameter it can least be told from", surveymc::estimate::parameter_name(other));
    t.number("correlation", "1", "correlation of the two estimates", correlation(other));
  }
  return t.take();
}

store::Table covariance_table(const analysis::ReadingsAnalysis& a) {
  compare::TableRows t("parameter_covariance", "covariance and correlation of the estimates by the a-priori noise");
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) {
      t.word("parameter_a", "first parameter", surveymc::estimate::parameter_name(j));
      t.word("parameter_b", "second parameter", surveymc::estimate::parameter_name(i));
      t.number("covariance", "1", "covariance, in the product of the two units", a.covariance(i, j));
      t.word("unit", "unit of the covariance", j >= 3 ? "nT2" : i >= 3 ? "nT" : "1");
      t.number("correlation", "1", "near -1 or 1: the two can hardly be told apart",
               a.covariance(i, j) / std::sqrt(a.covariance(i, i) * a.covariance(j, j)));
    }
  return t.take();
}

store::Table observability_table(const analysis::ReadingsAnalysis& a) {
  const surveymc::estimate::Observability& o = a.observability;
  compare::TableRows t(
      "observability",
      "combinations of parameters, weakest first: singular vectors of the Jacobian with columns of unit length");
  for (int j = 0; j < 6; ++j) {
    const double index = o.condition_indices[j];
    Eigen::Index first = 0, second = 0;
    surveymc::estimate::Vector6d size = o.directions.col(j).cwiseAbs();
    size.maxCoeff(&first);
    size[first] = 0;
    size.maxCoeff(&second);
    t.word("combination", "the parameters that matter in it, and whether their errors go with or against",
           surveymc::estimate::combination_name(o.directions.col(j)));
    t.number("singular_value", "1", "how strongly the residuals answer; 1 if no parameters are alike",
             o.singular_values[j]);
    t.number("condition_index", "1", "largest singular value over this; above 30 weak, above 100 severe", index);
    t.word("judgement", "determined, weak or severe",
           index > surveymc::estimate::kSevereCondition ? "severe"
           : index > surveymc::estimate::kWeakCondition ? "weak"
                                                        : "determined");
    t.number("correlation", "1", "of the estimates of the two parameters with the largest entries",
             a.covariance(first, second) / std::sqrt(a.covariance(first, first) * a.covariance(second, second)));
    for (int i = 0; i < 6; ++i)
      t.number(surveymc::estimate::parameter_name(i), "1",
               "entry of the singular vector, parameters in units of 1 / column length", o.directions(i, j));
  }
  return t.take();
}

double degrees(double x) { return x / kDegree; }

store::Table stations_table(const survey::SixAxisReadings& r, const survey::ReferenceField& field,
                            const analysis::ReadingsAnalysis& a) {
  compare::TableRows t("stations", "the survey before and after the correction, its covariance, and its residuals");
  const auto angle = [&](const char* name, const char* meaning, double x) { t.number(name, "deg", meaning, x); };
  for (std::size_t k = 0; k < a.stations.size(); ++k) {
    const analysis::StationAnalysis& s = a.stations[k];
    const double raw_true = s.raw.azimuth + field.declination, corrected_true = s.corrected.azimuth + field.declination;
    t.number("md_m", "m", "measured depth", r.md[k]);
    angle("inclination_deg", "from the accelerometers: not corrected", degrees(s.corrected.inclination));
    angle("toolface_deg", "from the accelerometers, from the tool's y axis", degrees(s.corrected.toolface));
    angle("raw_azimuth_magnetic_deg", "of the readings as they are, from magnetic north",
          compare::turn_in_degrees(s.raw.azimuth));
    angle("azimuth_magnetic_deg", "corrected, from magnetic north", compare::turn_in_degrees(s.corrected.azimuth));
    angle("raw_azimuth_true_deg", "of the readings as they are, from true north", compare::turn_in_degrees(raw_true));
    angle("azimuth_true_deg", "corrected, from true north", compare::turn_in_degrees(corrected_true));
    angle("azimuth_grid_deg", "corrected, from grid north",
          compare::turn_in_degrees(corrected_true - field.convergence));
    angle("azimuth_change_deg", "corrected less raw",
          std::remainder(degrees(s.corrected.azimuth - s.raw.azimuth), 360.0));
    angle("sd_azimuth_deg", "standard deviation of the corrected azimuth; declination is taken as exact",
          degrees(s.azimuth_sd));
    for (const bool raw : {true, false}) {
      const analysis::FieldResiduals& f = raw ? s.before : s.after;
      const std::string when = raw ? "raw_" : "";
      const char* meaning =
          raw ? "of the readings, less the reference" : "of the corrected readings, less the reference";
      t.number(when + "horizontal_residual_nT", "nT", meaning, f.horizontal);
      t.number(when + "vertical_residual_nT", "nT", meaning, f.vertical);
      t.number(when + "total_field_residual_nT", "nT", meaning, f.total);
      t.number(when + "dip_residual_deg", "deg", meaning, degrees(f.dip));
    }
    t.number("w_horizontal", "1", "normalised horizontal residual: standard normal if nothing but noise is wrong",
             a.tests.w[k][0]);
    t.number("w_vertical", "1", "normalised vertical residual: standard normal if nothing but noise is wrong",
             a.tests.w[k][1]);
    t.number("gravity_residual_mps2", "mps2", "length of the accelerometer readings less the reference",
             s.gravity_residual);
    constexpr std::array<const char*, 3> kNames{"north_m", "east_m", "vertical_m"};
    for (std::size_t i = 0; i < 3; ++i)
      t.number(std::string("raw_") + kNames[i], "m", "of the readings as they are, from the first station, true north",
               s.raw_position[static_cast<Eigen::Index>(i)]);
    for (std::size_t i = 0; i < 3; ++i)
      t.number(kNames[i], "m", "corrected, from the first station, true north",
               s.position[static_cast<Eigen::Index>(i)]);
    t.covariance("nev", "covariance of the corrected position", s.position_covariance);
  }
  return t.take();
}

/// Mean, rms and largest of the stations' residuals before and after the correction.
store::Table residuals_table(const analysis::ReadingsAnalysis& a) {
  compare::TableRows t("residuals", "the stations' field less the reference, before and after the correction");
  const auto row = [&](const char* name, const char* unit, double factor, double analysis::FieldResiduals::*member) {
    t.word("quantity", "horizontal, vertical and total field (nT), dip (deg)", name);
    t.word("unit", "unit of the values in this row", unit);
    for (const bool raw : {true, false}) {
      double sum = 0, squares = 0, largest = 0;
      for (const analysis::StationAnalysis& s : a.stations) {
        const double x = factor * (raw ? s.before : s.after).*member;
        sum += x;
        squares += x * x;
        largest = std::max(largest, std::abs(x));
      }
      const auto n = static_cast<double>(a.stations.size());
      const std::string of = raw ? "raw_" : "", when = raw ? " before the correction" : " after the correction";
      t.number(of + "mean", "1", "mean" + when, sum / n);
      t.number(of + "rms", "1", "root mean square" + when, std::sqrt(squares / n));
      t.number(of + "largest", "1", "largest magnitude" + when, largest);
    }
  };
  row("horizontal", "nT", 1, &analysis::FieldResiduals::horizontal);
  row("vertical", "nT", 1, &analysis::FieldResiduals::vertical);
  row("total_field", "nT", 1, &analysis::FieldResiduals::total);
  row("dip", "deg", 1 / kDegree, &analysis::FieldResiduals::dip);
  return t.take();
}

/// The reference field of an estimator that estimates it.
store::Table reference_table(const analysis::ReadingsAnalysis& a, const survey::ReferenceField& field,
                             const analysis::TestLevels& levels) {
  compare::TableRows t(
      "reference", "the reference field, estimated together with the tool" + compare::at_confidence(levels.confidence));
  const double z = stats::normal_quantile((1 + levels.confidence) / 2);
  const auto row = [&](const char* name, double given, int i, double unit) {
    const double x = (*a.reference)[i] / unit, sd = std::sqrt(a.reference_estimate_covariance(i, i)) / unit;
    t.word("quantity", "total field (nT) or dip (deg)", name);
    t.number("given", "1", "what the config says, in the unit of the quantity", given / unit);
    t.number("estimate", "1", "what the readings and the given value say together", x, "ci_low ci_high");
    t.number("sd", "1", "standard deviation of the estimate by the a-priori noise", sd);
    t.number("ci_low", "1", "lower bound of the confidence interval", x - z * sd);
    t.number("ci_high", "1", "upper bound of the confidence interval", x + z * sd);
  };
  row("total_field_nT", field.total, 0, 1);
  row("dip_deg", field.dip, 1, kDegree);
  return t.take();
}

/// One row: squares and residual sd of the solution, and the variance factor that follows.
store::Table fit_table(const analysis::ReadingsAnalysis& a) {
  compare::TableRows t("fit", "the estimator's minimum, and the noise that its residuals speak of");
  const double left = a.tests.redundancy > 0 ? a.squares / a.tests.redundancy : kNaN;
  t.count("stations", "stations of the run", a.stations.size());
  t.count("redundancy", "residuals less unknowns", a.tests.redundancy);
  t.number("cost_nT2", "nT2",
           "sum of the squared horizontal and vertical residuals at the minimum; msa_joint: less its own reference",
           a.squares);
  t.number("residual_sd_nT", "nT", "root of cost over redundancy", std::sqrt(left));
  t.number("chi_squared", "1", "of the residuals with their whole a-priori covariance", a.tests.statistic);
  t.number("variance_factor", "1", "chi_squared over redundancy: 1 if the noise is as claimed",
           a.tests.variance_factor());
  t.number("s0", "1", "its root: residuals over what the noise would make", std::sqrt(a.tests.variance_factor()));
  t.number("condition", "1", "largest condition index of the scaled Jacobian", a.observability.condition_indices[0]);
  t.number("rotation_gap_deg", "deg", "widest range of toolfaces without a station", degrees(a.rotation_gap));
  t.count("evaluations", "of the model, by the solver", a.evaluations);
  return t.take();
}

store::Table tests_table(const std::vector<analysis::ReadingsTest>& tests) {
  compare::TableRows t("tests", "does the run as a whole, and does every residual, fit the noise that was claimed");
  compare::write_rows(t, tests, [&](const analysis::ReadingsTest& x) {
    t.word("test",
           "variance_factor (chi-squared over redundancy), perfect_tool (chi-squared of the "
           "estimate), residual (w, standard normal)",
           x.test);
    t.count("station", "number of the station, from 1; 0 for the run as a whole", x.station + 1);
    t.number("md_m", "m", "measured depth of the station", x.md);
    t.word("component", "horizontal or vertical field", x.component);
    t.test(x.statistic, x.critical_low, x.critical_high, x.p_value);
    t.number("error_nT", "nT", "size of the error in this residual, if it is the only one", x.error);
    t.number("sd_error_nT", "nT", "standard deviation of error_nT", x.error_sd);
    t.word("decision", "accepted, rejected or not tested", x.decision);
    t.word("note", "what follows", x.note);
  });
  return t.take();
}

store::Table suspect_readings_table(const survey::SixAxisReadings& readings, const analysis::Suspect& s) {
  compare::TableRows t("suspect_readings",
                       "the six readings of the suspect station, each tested as the only wrong one");
  const double md = readings.md[static_cast<std::size_t>(s.station)];
  bool first = true;
  compare::write_rows(t, s.readings, [&](const analysis::SuspectReading& r) {
    t.count("station", "number of the station, from 1", s.station + 1);
    t.number("md_m", "m", "measured depth of the station", md);
    t.word("reading", "accelerometer or magnetometer axis", r.reading);
    t.number("w", "1", "standard normal under the claimed noise", r.w);
    t.number("error", "1", "size of the error in the sign of the file, if it is the only one, in the row's unit",
             r.error);
    t.number("sd_error", "1", "its standard deviation", r.error_sd);
    t.word("unit", "unit of error and sd_error", r.unit);
    t.number("correlation", "1", "of this test with the first: near -1 or 1, the two cannot be told apart",
             r.correlation);
    t.word("judgement", "most likely, inseparable from it, or less likely",
           first        ? "most likely"
           : r.in_group ? "inseparable"
                        : "less likely");
    first = false;
  });
  return t.take();
}

store::Table without_suspect_table(const analysis::ReadingsAnalysis& a, const analysis::Suspect& s) {
  compare::TableRows t("without_suspect", "gains and biases without the suspect station");
  for (int i = 0; i < 6; ++i) {
    const double x = s.without->parameters[i];
    t.word("quantity", "gain (1) or bias (nT)", quantity(i));
    t.number("estimate", "1", "estimate without the station, in the unit of the quantity", x);
    t.number("sd", "1", "standard deviation by the a-priori noise", std::sqrt(s.without->covariance(i, i)));
    t.number("change", "1", "less the estimate with the station", x - a.parameters[i]);
    t.number("s0", "1", "root of the variance factor without the station",
             std::sqrt(s.without->tests.variance_factor()));
  }
  return t.take();
}

store::Table intervals_table(const std::vector<analysis::ProfiledInterval>& intervals,
                             const analysis::TestLevels& levels) {
  compare::TableRows t("intervals", "intervals that hold where first order does not, beside those of the covariance" +
                                        compare::at_confidence(levels.confidence));
  compare::write_rows(t, intervals, [&](const analysis::ProfiledInterval& x) {
    t.word("quantity", "gain (1), bias (nT), or coordinate of the last station (m)", x.quantity);
    t.number("estimate", "1", "in the unit of the quantity", x.estimate, "first_low first_high");
    t.number("sd", "1", "by the covariance", x.sd);
    t.number("first_low", "1", "lower bound by the covariance", x.first_low);
    t.number("first_high", "1", "upper bound by the covariance", x.first_high);
    t.number("profile_sd", "1", "by the profile", x.profile_sd);
    t.number("profile_low", "1", "lower bound by the profile", x.profile_low);
    t.number("profile_high", "1", "upper bound by the profile", x.profile_high);
    t.number("shift", "1", "how far an end moves at most, in half widths of the covariance's interval", x.shift());
    t.word("covariance", "holds; differs: shift above 0.05; or undetermined: the profile has no value",
           !x.is_determined() ? "undetermined"
           : x.is_notable()   ? "differs"
                              : "holds");
    t.number("jump_probability", "1", "of errors beyond which the estimate is that of another minimum",
             x.jump_probability);
  });
  return t.take();
}

}  // namespace

store::Table warnings_table(const std::vector<analysis::Warning>& warnings) {
  std::vector<compare::Warning> all;
  for (const analysis::Warning& w : warnings) all.push_back({w.severity, "", "", w.message});
  return compare::warnings_table(all);
}

std::vector<store::Table> result_tables(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                                        const analysis::ReadingsAnalysis& analysis, const analysis::TestLevels& levels,
                                        const std::vector<analysis::ReadingsTest>& tests,
                                        const std::optional<analysis::Suspect>& examined,
                                        const std::vector<analysis::ProfiledInterval>& profiled,
                                        const std::vector<analysis::Warning>& warnings) {
  std::vector<store::Table> tables{parameters_table(analysis, levels),
                                   covariance_table(analysis),
                                   observability_table(analysis),
                                   fit_table(analysis),
                                   residuals_table(analysis),
                                   stations_table(readings, field, analysis),
                                   tests_table(tests),
                                   warnings_table(warnings)};
  if (!profiled.empty()) tables.insert(tables.end() - 1, intervals_table(profiled, levels));
  if (analysis.reference) tables.insert(tables.begin() + 1, reference_table(analysis, field, levels));
  if (examined) {
    tables.insert(tables.end() - 1, suspect_readings_table(readings, *examined));
    if (examined->without) tables.insert(tables.end() - 1, without_suspect_table(analysis, *examined));
  }
  return tables;
}

}  // namespace surveymc::studies::estimate
