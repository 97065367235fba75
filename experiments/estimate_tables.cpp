#include "estimate_tables.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "stats/intervals.h"
#include "study/table_writer.h"
#include "study/verdict.h"

namespace surveymc {
namespace {

std::string quantity(int parameter) { return std::string(parameter_name(parameter)) + (parameter < 3 ? "" : "_nT"); }

Table parameters_table(const ReadingsAnalysis& a, const TestLevels& levels) {
  Table t{"parameters", fmt::format("gains and biases of the magnetometers{}", at_confidence(levels.confidence))};
  t.columns = {word_column("quantity", "gain (1) or bias (nT)"),
               number_column("estimate", "1", "estimate, in the unit of the quantity", "ci_low ci_high"),
               number_column("sd", "1", "standard deviation by the a-priori noise, reference included"),
               number_column("ci_low", "1", "lower bound of the confidence interval"),
               number_column("ci_high", "1", "upper bound of the confidence interval"),
               number_column("sd_noise", "1", "part of sd that the sensors' noise makes"),
               number_column("sd_reference", "1", "part of sd that the reference field's uncertainty makes"),
               number_column("sd_a_posteriori", "1", "sd times the root of the variance factor of the residuals"),
               number_column("deviation_sd", "1", "estimate less that of a perfect tool, over sd"),
               number_column("variance_inflation", "1", "variance over what it were, were the parameters uncorrelated"),
               word_column("most_correlated", "the parameter it can least be told from"),
               number_column("correlation", "1", "correlation of the two estimates")};
  TableWriter w(std::move(t));
  const double z = normal_quantile((1 + levels.confidence) / 2), s0 = std::sqrt(a.tests.variance_factor());
  for (int i = 0; i < 6; ++i) {
    const double x = a.parameters[i], sd = std::sqrt(a.covariance(i, i));
    int other = i == 0 ? 1 : 0;
    const auto correlation = [&](int j) { return a.covariance(i, j) / std::sqrt(a.covariance(j, j)) / sd; };
    for (int j = 0; j < 6; ++j)
      if (j != i && std::abs(correlation(j)) > std::abs(correlation(other))) other = j;
    w << quantity(i) << x << sd << x - z * sd << x + z * sd
      << std::sqrt(std::max(0.0, a.covariance(i, i) - a.reference_covariance(i, i)))
      << std::sqrt(a.reference_covariance(i, i)) << s0 * sd << (x - (i < 3 ? 1 : 0)) / sd
      << a.observability.variance_inflation[i] << std::string(parameter_name(other)) << correlation(other);
  }
  return w.take();
}

Table covariance_table(const ReadingsAnalysis& a) {
  Table t{"parameter_covariance", "covariance and correlation of the estimates by the a-priori noise"};
  t.columns = {word_column("parameter_a", "first parameter"), word_column("parameter_b", "second parameter"),
               number_column("covariance", "1", "covariance, in the product of the two units"),
               word_column("unit", "unit of the covariance"),
               number_column("correlation", "1", "near -1 or 1: the two can hardly be told apart")};
  TableWriter w(std::move(t));
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j)
      w << std::string(parameter_name(j)) << std::string(parameter_name(i)) << a.covariance(i, j)
        << std::string(j >= 3   ? "nT2"
                       : i >= 3 ? "nT"
                                : "1")
        << a.covariance(i, j) / std::sqrt(a.covariance(i, i) * a.covariance(j, j));
  return w.take();
}

Table observability_table(const ReadingsAnalysis& a) {
  const Observability& o = a.observability;
  Table t{"observability",
          "combinations of parameters, weakest first: singular vectors of the Jacobian with columns of unit length"};
  t.columns = {
      word_column("combination", "the parameters that matter in it, and whether their errors go with or against"),
      number_column("singular_value", "1", "how strongly the residuals answer; 1 if no parameters are alike"),
      number_column("condition_index", "1", "largest singular value over this; above 30 weak, above 100 severe"),
      word_column("judgement", "determined, weak or severe"),
      number_column("correlation", "1", "of the estimates of the two parameters with the largest entries")};
  for (int i = 0; i < 6; ++i)
    t.columns.push_back(number_column(parameter_name(i), "1",
                                      "entry of the singular vector, parameters in units of 1 / column length"));
  TableWriter w(std::move(t));
  for (int j = 0; j < 6; ++j) {
    const double index = o.condition_indices[j];
    Eigen::Index first = 0, second = 0;
    Vector6d size = o.directions.col(j).cwiseAbs();
    size.maxCoeff(&first);
    size[first] = 0;
    size.maxCoeff(&second);
    w << combination_name(o.directions.col(j)) << o.singular_values[j] << index
      << std::string(index > kSevereCondition ? "severe"
                     : index > kWeakCondition ? "weak"
                                              : "determined")
      << a.covariance(first, second) / std::sqrt(a.covariance(first, first) * a.covariance(second, second));
    for (int i = 0; i < 6; ++i) w << o.directions(i, j);
  }
  return w.take();
}

double degrees(double x) { return x / kDegree; }
double degrees_of_azimuth(double x) {
  const double turn = std::fmod(degrees(x), 360.0);
  return turn < 0 ? turn + 360 : turn;
}

Table stations_table(const SixAxisReadings& r, const ReferenceField& field, const ReadingsAnalysis& a) {
  Table t{"stations", "the survey before and after the correction, its covariance, and its residuals"};
  const auto number = [&](const char* name, const char* unit, const char* meaning) {
    t.columns.push_back(number_column(name, unit, meaning));
  };
  number("md_m", "m", "measured depth");
  number("inclination_deg", "deg", "from the accelerometers: not corrected");
  number("toolface_deg", "deg", "from the accelerometers, from the tool's y axis");
  number("raw_azimuth_magnetic_deg", "deg", "of the readings as they are, from magnetic north");
  number("azimuth_magnetic_deg", "deg", "corrected, from magnetic north");
  number("raw_azimuth_true_deg", "deg", "of the readings as they are, from true north");
  number("azimuth_true_deg", "deg", "corrected, from true north");
  number("azimuth_grid_deg", "deg", "corrected, from grid north");
  number("azimuth_change_deg", "deg", "corrected less raw");
  number("sd_azimuth_deg", "deg", "standard deviation of the corrected azimuth; declination is taken as exact");
  for (const std::string when : {"raw_", ""}) {
    const char* meaning =
        when.empty() ? "of the corrected readings, less the reference" : "of the readings, less the reference";
    number((when + "horizontal_residual_nT").c_str(), "nT", meaning);
    number((when + "vertical_residual_nT").c_str(), "nT", meaning);
    number((when + "total_field_residual_nT").c_str(), "nT", meaning);
    number((when + "dip_residual_deg").c_str(), "deg", meaning);
  }
  number("w_horizontal", "1", "normalised horizontal residual: standard normal if nothing but noise is wrong");
  number("w_vertical", "1", "normalised vertical residual: standard normal if nothing but noise is wrong");
  number("gravity_residual_mps2", "mps2", "length of the accelerometer readings less the reference");
  for (const char* name : {"raw_north_m", "raw_east_m", "raw_vertical_m"})
    number(name, "m", "of the readings as they are, from the first station, true north");
  for (const char* name : {"north_m", "east_m", "vertical_m"})
    number(name, "m", "corrected, from the first station, true north");
  for (const char* name : {"nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2"})
    number(name, "m2", "covariance of the corrected position");

  TableWriter w(std::move(t));
  for (std::size_t k = 0; k < a.stations.size(); ++k) {
    const StationAnalysis& s = a.stations[k];
    const double raw_true = s.raw.azimuth + field.declination, corrected_true = s.corrected.azimuth + field.declination;
    w << r.md[k] << degrees(s.corrected.inclination) << degrees(s.corrected.toolface)
      << degrees_of_azimuth(s.raw.azimuth) << degrees_of_azimuth(s.corrected.azimuth) << degrees_of_azimuth(raw_true)
      << degrees_of_azimuth(corrected_true) << degrees_of_azimuth(corrected_true - field.convergence)
      << std::remainder(degrees(s.corrected.azimuth - s.raw.azimuth), 360.0) << degrees(s.azimuth_sd);
    for (const FieldResiduals* f : {&s.before, &s.after})
      w << f->horizontal << f->vertical << f->total << degrees(f->dip);
    w << a.tests.w[k][0] << a.tests.w[k][1] << s.gravity_residual;
    for (const Eigen::Vector3d* p : {&s.raw_position, &s.position}) w << p->x() << p->y() << p->z();
    const Eigen::Matrix3d& c = s.position_covariance;
    w << c(0, 0) << c(1, 1) << c(2, 2) << c(0, 1) << c(0, 2) << c(1, 2);
  }
  return w.take();
}

/// Mean, rms and largest of what the stations' residuals were and are, and the estimator's own figures.
Table residuals_table(const ReadingsAnalysis& a) {
  Table t{"residuals", "the stations' field less the reference, before and after the correction"};
  t.columns = {word_column("quantity", "horizontal, vertical and total field (nT), dip (deg)"),
               word_column("unit", "unit of the values in this row"),
               number_column("raw_mean", "1", "mean before the correction"),
               number_column("raw_rms", "1", "root mean square before the correction"),
               number_column("raw_largest", "1", "largest magnitude before the correction"),
               number_column("mean", "1", "mean after the correction"),
               number_column("rms", "1", "root mean square after the correction"),
               number_column("largest", "1", "largest magnitude after the correction")};
  TableWriter w(std::move(t));
  const auto row = [&](const char* name, const char* unit, double factor, double FieldResiduals::*member) {
    w << std::string(name) << std::string(unit);
    for (const auto when : {&StationAnalysis::before, &StationAnalysis::after}) {
      double sum = 0, squares = 0, largest = 0;
      for (const StationAnalysis& s : a.stations) {
        const double x = factor * s.*when.*member;
        sum += x;
        squares += x * x;
        largest = std::max(largest, std::abs(x));
      }
      const auto n = static_cast<double>(a.stations.size());
      w << sum / n << std::sqrt(squares / n) << largest;
    }
  };
  row("horizontal", "nT", 1, &FieldResiduals::horizontal);
  row("vertical", "nT", 1, &FieldResiduals::vertical);
  row("total_field", "nT", 1, &FieldResiduals::total);
  row("dip", "deg", 1 / kDegree, &FieldResiduals::dip);
  return w.take();
}

/// The reference field of an estimator that estimates it.
Table reference_table(const ReadingsAnalysis& a, const ReferenceField& field, const TestLevels& levels) {
  Table t{"reference",
          fmt::format("the reference field, estimated together with the tool{}", at_confidence(levels.confidence))};
  t.columns = {word_column("quantity", "total field (nT) or dip (deg)"),
               number_column("given", "1", "what the config says, in the unit of the quantity"),
               number_column("estimate", "1", "what the readings and the given value say together", "ci_low ci_high"),
               number_column("sd", "1", "standard deviation of the estimate by the a-priori noise"),
               number_column("ci_low", "1", "lower bound of the confidence interval"),
               number_column("ci_high", "1", "upper bound of the confidence interval")};
  TableWriter w(std::move(t));
  const double z = normal_quantile((1 + levels.confidence) / 2);
  const auto row = [&](const char* name, double given, int i, double unit) {
    const double x = (*a.reference)[i] / unit, sd = std::sqrt(a.reference_estimate_covariance(i, i)) / unit;
    w << std::string(name) << given / unit << x << sd << x - z * sd << x + z * sd;
  };
  row("total_field_nT", field.total, 0, 1);
  row("dip_deg", field.dip, 1, kDegree);
  return w.take();
}

/// One row: what the solver left, and the variance factor that follows.
Table fit_table(const ReadingsAnalysis& a) {
  Table t{"fit", "the estimator's minimum, and the noise that its residuals speak of"};
  t.columns = {count_column("stations", "stations of the run"),
               count_column("redundancy", "residuals less unknowns"),
               number_column("cost_nT2", "nT2", "sum of the squared horizontal and vertical residuals at the minimum"),
               number_column("residual_sd_nT", "nT", "root of cost over redundancy"),
               number_column("chi_squared", "1", "of the residuals with their whole a-priori covariance"),
               number_column("variance_factor", "1", "chi_squared over redundancy: 1 if the noise is as claimed"),
               number_column("s0", "1", "its root: residuals over what the noise would make"),
               number_column("condition", "1", "largest condition index of the scaled Jacobian"),
               number_column("rotation_gap_deg", "deg", "widest range of toolfaces without a station"),
               count_column("evaluations", "of the model, by the solver")};
  TableWriter w(std::move(t));
  const double left = a.tests.redundancy > 0 ? a.cost / a.tests.redundancy : std::nan("");
  w << static_cast<std::int64_t>(a.stations.size()) << static_cast<std::int64_t>(a.tests.redundancy) << a.cost
    << std::sqrt(left) << a.tests.statistic << a.tests.variance_factor() << std::sqrt(a.tests.variance_factor())
    << a.observability.condition_indices[0] << degrees(a.rotation_gap) << static_cast<std::int64_t>(a.evaluations);
  return w.take();
}

Table tests_table(const std::vector<ReadingsTest>& tests) {
  Table t{"tests", "does the run as a whole, and does every residual, fit the noise that was claimed"};
  t.columns = {word_column("test",
                           "variance_factor (chi-squared over redundancy), perfect_tool (chi-squared of the "
                           "estimate), residual (w, standard normal)"),
               count_column("station", "number of the station, from 1; 0 for the run as a whole"),
               number_column("md_m", "m", "measured depth of the station"),
               word_column("component", "horizontal or vertical field"),
               number_column("statistic", "1", "what is tested"),
               number_column("critical_low", "1", "rejected below"),
               number_column("critical_high", "1", "rejected above"),
               number_column("p_value", "1", "probability of a statistic as extreme, by noise alone"),
               number_column("error_nT", "nT", "size of the error in this residual, if it is the only one"),
               number_column("sd_error_nT", "nT", "standard deviation of error_nT"),
               word_column("decision", "accepted, rejected or not tested"),
               word_column("note", "what follows")};
  TableWriter w(std::move(t));
  for (const ReadingsTest& x : tests)
    w << x.test << x.station + 1 << x.md << x.component << x.statistic << x.critical_low << x.critical_high << x.p_value
      << x.error << x.error_sd << x.decision << x.note;
  return w.take();
}

Table suspect_readings_table(const SixAxisReadings& readings, const Suspect& s) {
  Table t{"suspect_readings", "the six readings of the suspect station, each tested as the only wrong one"};
  t.columns = {
      count_column("station", "number of the station, from 1"),
      number_column("md_m", "m", "measured depth of the station"),
      word_column("reading", "accelerometer or magnetometer axis"),
      number_column("w", "1", "standard normal under the claimed noise"),
      number_column("error", "1", "size of the error, if it is the only one"),
      number_column("sd_error", "1", "its standard deviation"),
      word_column("unit", "unit of error and sd_error"),
      number_column("correlation", "1", "of this test with the first: near -1 or 1, the two cannot be told apart"),
      word_column("judgement", "most likely, inseparable from it, or less likely")};
  TableWriter w(std::move(t));
  for (std::size_t i = 0; i < s.readings.size(); ++i) {
    const SuspectReading& r = s.readings[i];
    w << static_cast<std::int64_t>(s.station + 1) << readings.md[static_cast<std::size_t>(s.station)] << r.reading
      << r.w << r.error << r.error_sd << r.unit << r.correlation
      << std::string(i == 0       ? "most likely"
                     : r.in_group ? "inseparable"
                                  : "less likely");
  }
  return w.take();
}

Table without_suspect_table(const ReadingsAnalysis& a, const Suspect& s) {
  Table t{"without_suspect", "gains and biases without the suspect station"};
  t.columns = {word_column("quantity", "gain (1) or bias (nT)"),
               number_column("estimate", "1", "estimate without the station, in the unit of the quantity"),
               number_column("sd", "1", "standard deviation by the a-priori noise"),
               number_column("change", "1", "less the estimate with the station"),
               number_column("s0", "1", "root of the variance factor without the station")};
  TableWriter w(std::move(t));
  for (int i = 0; i < 6; ++i)
    w << quantity(i) << s.without->parameters[i] << std::sqrt(s.without->covariance(i, i))
      << s.without->parameters[i] - a.parameters[i] << std::sqrt(s.without->tests.variance_factor());
  return w.take();
}

Table warnings_table(const std::vector<EstimateWarning>& warnings) {
  Table t{"warnings", "what to know before the estimate is used"};
  t.columns = {word_column("severity", "severe, warning or info"),
               word_column("message", "what is wrong, and what to do")};
  TableWriter w(std::move(t));
  for (const EstimateWarning& x : warnings) w << x.severity << x.message;
  return w.take();
}

}  // namespace

std::vector<Table> estimate_tables(const SixAxisReadings& readings, const ReferenceField& field,
                                   const ReadingsAnalysis& analysis, const TestLevels& levels,
                                   const std::vector<ReadingsTest>& tests, const std::optional<Suspect>& examined,
                                   const std::vector<EstimateWarning>& warnings) {
  std::vector<Table> tables{parameters_table(analysis, levels),
                            covariance_table(analysis),
                            observability_table(analysis),
                            fit_table(analysis),
                            residuals_table(analysis),
                            stations_table(readings, field, analysis),
                            tests_table(tests),
                            warnings_table(warnings)};
  if (analysis.reference) tables.insert(tables.begin() + 1, reference_table(analysis, field, levels));
  if (examined) {
    tables.insert(tables.end() - 1, suspect_readings_table(readings, *examined));
    if (examined->without) tables.insert(tables.end() - 1, without_suspect_table(analysis, *examined));
  }
  return tables;
}

}  // namespace surveymc
