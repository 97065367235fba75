#include "scenario/disturbance.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/table_rows.h"
#include "config/observatory.h"
#include "config/survey_csv.h"
#include "stats/intervals.h"
#include "survey/interpolated_survey.h"

namespace surveymc::scenario {

using disturbance::Disturbance;
using disturbance::Kind;
using disturbance::Process;

namespace {

constexpr double kHour = 3600;
constexpr std::uint64_t kTableTrials = 10'000;
constexpr double kMostStorms = 1e5, kRareKurtosis = 1000;

/// North, east, down in nT.
Eigen::Vector3d read_sizes(config::ConfigReader& c, double fallback) {
  const auto size = [&](const char* key, std::string_view meaning) {
    return c.number(key, config::Range::non_negative(), meaning, fallback);
  };
  return {
      size("disturbance.north_nT", "of 'ar1' and 'storm': one sd along magnetic north; of a storm that of its height"),
      size("disturbance.east_nT", "the same along magnetic east"), size("disturbance.down_nT", "the same down")};
}

/// Component times wave of 24, 12 and 8 h.
Eigen::Matrix3d read_waves(config::ConfigReader& c, const std::array<const char*, 3>& keys, const config::Range& range,
                           std::string_view meaning) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i) {
    const std::vector<double> row =
        c.numbers(keys[static_cast<std::size_t>(i)], range, meaning, 3, std::vector<double>{0, 0, 0});
    m.row(i) = Eigen::RowVector3d(row[0], row[1], row[2]);
  }
  return m;
}

std::shared_ptr<const disturbance::Series> read_series(config::ConfigReader& c) {
  // Before the file: `surveymc keys` has none, and asks no further where it is missing.
  const std::string level =
      c.choice("disturbance.quiet_level", {"mean", "daily"},
               "what is taken off the series: 'mean': its mean; 'daily': the mean of each minute of the day over its "
               "days, the regular daily variation",
               "mean");
  disturbance::Series s = config::observatory_series(
      c.file("disturbance.file",
             "of 'series': minutes of an observatory in IAGA-2002 (XYZ, HEZ or HDZ), or CSV with the columns time (ISO "
             "8601), x_nT, y_nT and z_nT; at equal steps, without gaps"));
  const double per_day = 86400 / s.step;
  if (level == "daily")
    c.require(std::abs(per_day - std::round(per_day)) < 1e-9 && static_cast<double>(s.field.cols()) >= 2 * per_day,
              "disturbance.quiet_level",
              "\"daily\" needs a series of two days or more, with a whole number of steps a day");
  disturbance::take_off_quiet_level(s,
                                    level == "daily" ? disturbance::QuietLevel::daily : disturbance::QuietLevel::mean);
  return std::make_shared<const disturbance::Series>(std::move(s));
}

Process read_process(config::ConfigReader& c, const std::string& kind, bool match) {
  Process p;
  if (kind == "ar1") {
    p.kind = Kind::ar1;
    p.tau = c.number("disturbance.tau_s", config::Range::non_negative(),
                     "of 'ar1': correlation time; two stations dt apart have exp(-dt / tau_s); 0: none");
    if (!match) p.sd = read_sizes(c, 0);
  } else if (kind == "storm") {
    p.kind = Kind::storm;
    p.storms = c.number("disturbance.storms_per_day", config::Range::positive(),
                        "of 'storm': onsets a day, a Poisson process") /
               86400;
    p.rise = c.number("disturbance.rise_s", config::Range::non_negative(), "time in which a storm rises, straight");
    p.decay = c.number("disturbance.decay_s", config::Range::positive(), "time in which it then falls to 1 / e");
    p.mixing = c.choice("disturbance.mixing", {"none", "exponential"},
                        "V of a storm, of which its height is sqrt(V) times a normal: 'none': 1; 'exponential': of "
                        "mean 1, which makes heights Laplace",
                        "exponential") == "exponential";
    p.sd = read_sizes(c, match ? 1 : 0);
  } else {
    p.kind = Kind::series;
    if (kind == "series") {
      p.series = read_series(c);
    } else {
      const Eigen::Matrix3d amplitude =
          read_waves(c, {"disturbance.waves_north_nT", "disturbance.waves_east_nT", "disturbance.waves_down_nT"},
                     config::Range::non_negative(),
                     "of 'diurnal': amplitudes of the waves of 24, 12 and 8 h; the run begins at any time of the day");
      const Eigen::Matrix3d maximum =
          read_waves(c, {"disturbance.maximum_north_h", "disturbance.maximum_east_h", "disturbance.maximum_down_h"},
                     config::Range::closed(-24, 24), "hours of the day at which these waves have a maximum");
      p.series = std::make_shared<const disturbance::Series>(disturbance::daily_waves(amplitude, maximum));
    }
  }
  return p;
}

/// Begins a message.
std::string of_well(const DisturbedWell& well) {
  return well.name.empty() ? "" : fmt::format("of the well \"{}\": ", well.name);
}

std::vector<double> read_times(config::ConfigReader& c, const survey::Survey& survey, const DisturbedWell& well) {
  config::ConfigReader& of_file = well.offset != nullptr ? *well.offset : c;
  const char* const file = well.offset != nullptr ? "file" : "survey.file";
  const bool has_rate = c.has("disturbance.drilling_m_per_h") || c.has("disturbance.connection_s");
  const bool is_listed = well.has_file && of_file.has(file);
  if (has_rate && is_listed && of_file.csv(file, config::kMeaningElsewhere).find("time_s") >= 0)
    c.warn(
        "disturbance.drilling_m_per_h",
        fmt::format("{}gives the times of the stations, and the column time_s of {} is not used", of_well(well), file),
        "leave drilling_m_per_h and connection_s out, or the column");
  if (!has_rate && is_listed) {
    const config::InputTable table = of_file.csv(file, config::kMeaningElsewhere);
    const std::vector<double> listed = config::times_from_table(table);
    if (listed.size() == survey.stations.size()) return listed;
    if (!listed.empty()) {  // stations were put between those of the file
      survey::InterpolatedSurvey dense{survey, {}};
      for (const double md : config::survey_from_table(table, {}, false).md())
        dense.given.push_back(survey::station_at(survey, md).value());
      return survey::interpolated_values(dense, listed, std::vector<double>(survey.stations.size(), 0));
    }
  }
  const double rate = c.number("disturbance.drilling_m_per_h", config::Range::positive(),
                               "speed of drilling, which gives the stations their times where the survey has no column "
                               "time_s"),
               connection = c.number("disturbance.connection_s", config::Range::non_negative(),
                                     "time of a connection, one at every station", 0);
  std::vector<double> times{0};
  for (std::size_t k = 1; k < survey.stations.size(); ++k)
    times.push_back(times.back() + (survey.stations[k].md - survey.stations[k - 1].md) / rate * kHour + connection);
  return times;
}

/// Series that would repeat within the run, and storms that are too many to draw or too rare to be seen.
void check_times(config::ConfigReader& c, const std::string& kind, const Disturbance& d, const DisturbedWell& well) {
  const double run = d.times.back() - d.times.front();
  const Process& p = d.process;
  if (kind == "series") {
    const double record = p.series->step * static_cast<double>(p.series->field.cols());
    c.require(run <= record, "disturbance.file",
              fmt::format("{}has {:.3g} h, and the run takes {:.3g} h: a series would repeat itself; must be as long "
                          "as the run",
                          of_well(well), record / kHour, run / kHour));
  }
  if (kind != "storm") return;
  const double storms = disturbance::storms_of_run(p, run);
  c.require(storms <= kMostStorms, "disturbance.storms_per_day",
            fmt::format("{}some {:.3g} storms a run: must be at most {:g}; so many together are normal: \"ar1\"",
                        of_well(well), storms, kMostStorms));
  if (!well.is_drawn) return;
  const double kurtosis = disturbance::kurtosis(p, Eigen::RowVector3d(p.sd.transpose().cwiseSign()));
  if (kurtosis > kRareKurtosis)
    c.warn(
        "disturbance.storms_per_day",
        fmt::format("some {:.2g} storms a trial, a kurtosis of {:.2g}: fewer trials than some {:.0e} see too few, and "
                    "their sds, intervals and verdicts say nothing",
                    storms, kurtosis, 100 * kurtosis),
        "the prediction needs no trials; or more storms, which last longer");
}

}  // namespace

std::optional<Disturbance> read_disturbance(config::ConfigReader& c, const survey::Survey& survey,
                                            const DisturbedWell& well) {
  if (!c.has("disturbance.kind")) return std::nullopt;
  Disturbance d;
  const std::string kind = c.choice(
      "disturbance.kind", {"ar1", "diurnal", "storm", "series"},
      "the reference's errors of mode R as a function of time: 'ar1': correlation that falls exponentially; "
      "'diurnal': waves of a day; 'storm': storms at random times; 'series': minutes of an observatory, from a "
      "random one on");
  d.match_variance =
      c.choice(
          "disturbance.match", {"none", "variance"},
          "'variance': declination, dip and total field have the variance of the terms of mode R in whose place they "
          "are, and of the disturbance its time alone; 'none': that of the disturbance, in nT") == "variance";
  d.scale = c.number("disturbance.scale", config::Range::positive(), "multiplies the disturbance", 1);
  d.process = read_process(c, kind, d.match_variance);
  c.require(d.keeps_normals() || !disturbance::covariance(d.process, 0).isZero(0), "disturbance.kind",
            "the disturbance is 0 everywhere: give its sizes in nT, or a series that varies");
  d.times = read_times(c, survey, well);
  check_times(c, kind, d, well);
  for (const double minutes :
       c.numbers("disturbance.lags_min", config::Range::positive(), "lags of the table `disturbance`, minutes", -1,
                 std::vector<double>{10, 30, 60, 120, 240}))
    d.lags.push_back(60 * minutes);
  return d;
}

void set_beside_laws(config::ConfigReader& c, const std::optional<Disturbance>& d, const random::ReferenceLaws& laws,
                     compare::TailRule& tails) {
  if (!d) return;
  c.require(!laws.any() || !laws.random, "reference_law.modes",
            "must be of \"G\", \"W\" where a disturbance takes the place of the errors of mode R: what lasts has the "
            "laws, what is new at every station the disturbance");
  tails.predicted = d->process.kind == Kind::ar1;
}

store::Table disturbance_table(const Disturbance& d, const survey::ReferenceField& field,
                               const random::Stream* stream) {
  compare::TableRows t("disturbance",
                       "the disturbance of the reference in time: as predicted, and as the first 10000 trials draw it");
  const bool is_unit = d.keeps_normals();
  Disturbance at_lags = d;
  at_lags.times = {0};
  at_lags.times.insert(at_lags.times.end(), d.lags.begin(), d.lags.end());
  std::sort(at_lags.times.begin(), at_lags.times.end());
  if (is_unit) at_lags.process.sd = {0, 1, 0};    // of one element; all are alike
  std::vector<disturbance::StationDraw> normals;  // those that are kept, at the stations of one source
  for (std::size_t k = 0; k < at_lags.times.size(); ++k)
    normals.push_back({k, disturbance::kDeclination, 0, random::Channel::station_error, static_cast<std::uint32_t>(k)});
  const disturbance::StationDisturbance kept(at_lags, field,
                                             is_unit ? normals : std::vector<disturbance::StationDraw>());
  const Eigen::Matrix3d elements =
      d.scale * (is_unit ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : disturbance::elements_by_field(field));
  std::vector<Eigen::Matrix3Xd> draws;
  for (std::uint64_t trial = 0; trial < (stream == nullptr ? 0 : kTableTrials); ++trial) {
    if (!is_unit) {
      draws.push_back(elements * disturbance::draw(at_lags.process, at_lags.times, *stream, trial));
      continue;
    }
    const std::vector<double> values = kept.values(*stream, trial);
    draws.push_back(Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(values.size())));
    for (std::size_t k = 0; k < values.size(); ++k) draws.back()(1, static_cast<Eigen::Index>(k)) = d.scale * values[k];
  }
  const double n = static_cast<double>(draws.size()), wide = stats::normal_quantile(0.975);
  for (int e = 0; e < disturbance::kElements; ++e) {
    const Eigen::RowVector3d by_field =
        is_unit ? Eigen::RowVector3d(0, d.scale, 0) : Eigen::RowVector3d(elements.row(e));
    const int row = is_unit ? 1 : e;
    const double variance = (by_field * disturbance::covariance(at_lags.process, 0) * by_field.transpose()).value();
    if (!(variance > 0) || (is_unit && e > 0)) continue;
    const double unit = is_unit || e == disturbance::kTotal ? 1 : kDegree;
    const auto mean_of = [&](const auto& value) {
      double sum = 0, square = 0;
      for (const Eigen::Matrix3Xd& x : draws) {
        const double v = value(x);
        sum += v;
        square += v * v;
      }
      if (draws.empty()) return std::pair(kNaN, kNaN);
      return std::pair(sum / n, std::sqrt(std::max(0.0, square / n - sum * sum / n / n) / n));
    };
    const auto add = [&](const std::string& quantity, double lag, const char* unit_name, double predicted, double drawn,
                         double half) {
      t.word("element", "of the reference; 'each': all are alike, in units of their terms' sd",
             is_unit ? "each" : random::reference_elements()[static_cast<std::size_t>(e)]);
      t.word("quantity", "sd, kurtosis (3 of a normal), share beyond three sd, autocorrelation at a lag", quantity);
      t.number("lag_min", "min", "of the autocorrelation", lag / 60);
      t.word("unit", "of the values", unit_name);
      t.number("predicted", "1", "exact, of all times; absent where it has no formula", predicted);
      t.estimate("drawn", "1", "of 10000 trials", drawn, {drawn - half, drawn + half});
    };
    const auto [second, second_error] = mean_of([&](const Eigen::Matrix3Xd& x) { return x(row, 0) * x(row, 0); });
    const double sd = std::sqrt(second);
    add("sd", kNaN,
        is_unit                    ? "sd"
        : e == disturbance::kTotal ? "nT"
                                   : "deg",
        std::sqrt(variance) / unit, sd / unit, wide * second_error / (2 * sd) / unit);
    const auto [fourth, fourth_error] = mean_of([&](const Eigen::Matrix3Xd& x) { return std::pow(x(row, 0), 4); });
    add("kurtosis", kNaN, "1", disturbance::kurtosis(at_lags.process, by_field), fourth / (variance * variance),
        wide * fourth_error / (variance * variance));
    const auto [beyond, beyond_error] =
        mean_of([&](const Eigen::Matrix3Xd& x) { return x(row, 0) * x(row, 0) > 9 * variance ? 1.0 : 0.0; });
    add("outside_3_sd", kNaN, "1", disturbance::outside_three_sd(at_lags.process, by_field), beyond,
        wide * beyond_error);
    for (std::size_t k = 1; k < at_lags.times.size(); ++k) {
      const auto [product, error] =
          mean_of([&](const Eigen::Matrix3Xd& x) { return x(row, 0) * x(row, static_cast<Eigen::Index>(k)); });
      const double lag = at_lags.times[k],
                   predicted =
                       (by_field * disturbance::covariance(at_lags.process, lag) * by_field.transpose()).value();
      add("autocorrelation", lag, "1", predicted / variance, product / variance, wide * error / variance);
    }
  }
  return t.take();
}

}  // namespace surveymc::scenario
