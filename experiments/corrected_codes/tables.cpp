/// Tables and maps of the study `corrected_codes`.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/order_rows.h"
#include "compare/table_rows.h"
#include "corrected_codes/study.h"
#include "error_model/model.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::corrected_codes {

using analysis::CodeQuantity;
using analysis::CodeScope;

namespace {

const char* name_of(CodeQuantity q) { return analysis::kCodeQuantities[static_cast<std::size_t>(q)]; }
/// sinI dA is shown in degrees.
double unit_of(CodeQuantity q) { return q == CodeQuantity::azimuth ? 1 / kDegree : 1; }

constexpr double kFixedHalfAngle = 15;  // deg, of every code with axial correction

/// Quantities of a budget: those that are asked for.
constexpr std::array<CodeQuantity, 3> kBudget{CodeQuantity::lateral, CodeQuantity::worst, CodeQuantity::azimuth};

/// Those of maps, which stand before the class.
constexpr std::array<CodeQuantity, 3> kMapped{CodeQuantity::lateral, CodeQuantity::azimuth, CodeQuantity::worst};
constexpr std::size_t kClassMap = kMapped.size();

/// The fewest stations, evenly on the path of a made-up well, with which the code holds, for each quantity of the
/// budget; 0: not up to kMostStations.
constexpr int kMostStations = 400;
std::array<int, kBudget.size()> stations_needed(const Scenario& s) {
  const survey::Station& last = s.well->stations.back();
  const double length = last.md - s.well->stations.front().md;
  std::array<int, kBudget.size()> fewest{};
  for (int n = 3; n <= kMostStations && std::count(fewest.begin(), fewest.end(), 0) > 0; n += std::max(1, n / 20)) {
    analysis::WellDesign d = *s.design;
    d.stations = n;
    d.spacing = length / (n - 1);
    const survey::Survey well = analysis::make_well(d, last.inclination, last.azimuth);
    const analysis::CodeComparison c = analysis::compare_code(well, s.field, s.which, false);
    for (std::size_t q = 0; q < kBudget.size(); ++q) {
      const double ratio =
          analysis::code_sds(c, well, kBudget[q], CodeScope::magnetic, c.stations.fields.size() - 1).ratio();
      if (fewest[q] == 0 && ratio <= 1 + s.margin) fewest[q] = n;
    }
  }
  return fewest;
}

}  // namespace

store::Table claims_table(const Scenario& s, const std::vector<Claim>& claims, const stats::Tally& tally) {
  compare::TableRows t("claims",
                       fmt::format("what is left after the correction against what {} claims{}", s.claimed,
                                   compare::at_confidence(s.verdict)),
                       claims.size());
  for (const Claim& c : claims) {
    const double unit = unit_of(c.quantity);
    const std::string in = c.quantity == CodeQuantity::azimuth ? "deg" : "m";
    const Judged j = judge(c, s.margin);
    const auto scaled = [](const stats::Interval& i, double by) { return stats::Interval{i.lo * by, i.hi * by}; };
    t.number("md_m", "m", "measured depth of the station", c.md);
    t.word("quantity", "lateral, high side, north, east, worst direction of the last position; sinI dA of a station",
           name_of(c.quantity));
    t.word("scope", "terms that are compared: magnetic, or total",
           analysis::kCodeScopes[static_cast<std::size_t>(c.scope)]);
    t.word("correction", "of the readings", s.correction);
    t.word("unit", "of the standard deviations", in);
    t.number("claimed", "1", "sd that the code claims, in the row's unit", unit * c.sds.claimed);
    t.number("predicted", "1", "sd that is left, first order, in the row's unit", unit * c.sds.after);
    t.estimate("monte_carlo", "1", "sd that is left, of the trials, in the row's unit", unit * c.after,
               scaled(c.after_interval, unit));
    t.number("predicted_ratio", "1", "predicted over claimed", c.sds.ratio());
    t.estimate("ratio", "1", "Monte Carlo over claimed", c.after / c.sds.claimed,
               scaled(c.after_interval, 1 / c.sds.claimed));
    t.number("predicted_ratio_before", "1", "of the uncorrected survey: predicted over claimed", c.sds.ratio_before());
    t.estimate("ratio_before", "1", "of the uncorrected survey: Monte Carlo over claimed", c.before / c.sds.claimed,
               scaled(c.before_interval, 1 / c.sds.claimed));
    t.word("predicted_verdict", "holds, broken or undetermined, by first order", j.predicted);
    t.word("claim", "holds, broken, undecided or undetermined, by the trials", j.verdict);
    t.word("predicted_class", "free, kept, broken, harmful or undetermined, by first order", j.predicted_class);
    t.word("class", "the same by the trials", j.judged_class);
    t.number("mean_shift", "1", "mean error that is left, of the trials, in the row's unit", unit * c.mean);
    t.number("rms_ratio", "1", "root mean square of the error that is left, over claimed, of the trials",
             c.scope == CodeScope::magnetic ? std::hypot(c.after, c.mean) / c.sds.claimed : kNaN);
    t.number("kappa", "1",
             "s_h / (Bh sin^2 x), x from magnetic east or west: codes with axial correction hold below 0.12",
             analysis::axial_kappa(s.which.draws, s.field, s.well->stations[c.station + 1].inclination,
                                   s.well->stations[c.station + 1].azimuth));
    const std::uint64_t sound = c.beyond2 < 0 ? 0 : tally.trials - tally.failed;
    t.share("beyond_2_sd", "share of the trials beyond two claimed sd; 0.0455 of a normal distribution",
            static_cast<std::uint64_t>(std::max<std::int64_t>(0, c.beyond2)), sound, s.verdict.confidence);
    t.share("beyond_3_sd", "share of the trials beyond three claimed sd; 0.0027 of a normal distribution",
            static_cast<std::uint64_t>(std::max<std::int64_t>(0, c.beyond3)), sound, s.verdict.confidence);
    t.count("trials", "realisations", tally.trials);
    t.count("failed", "of them without a solution", tally.failed);
  }
  return t.take();
}

store::Table budget_table(const Scenario& s, const analysis::CodeComparison& c) {
  compare::TableRows t("budget", "share of the variance by input at the last station, first order");
  for (const CodeQuantity q : kBudget) {
    const std::array<double, analysis::kCodeInputs> after = analysis::code_budget(c.after, c, *s.well, q),
                                                    before = analysis::code_budget(c.before, c, *s.well, q);
    for (std::size_t i = 0; i < analysis::kCodeInputs; ++i) {
      t.word("quantity", "lateral or worst direction of the last position, sinI dA of the last station", name_of(q));
      t.word("input", "what is drawn", analysis::kCodeInputNames[i]);
      t.word("correction", "of the readings", s.correction);
      t.number("share", "1", "of the variance after the correction", after[i]);
      t.number("share_before", "1", "of the variance of the uncorrected survey", before[i]);
    }
  }
  return t.take();
}

store::Table requirement_table(const Scenario& s, const analysis::CodeComparison& c) {
  compare::TableRows t("requirement", "what would have to be for the claim to hold just yet, first order");
  const bool is_counted = s.design && !s.disturbance;  // other stations would have other times
  const std::array<int, kBudget.size()> stations = is_counted ? stations_needed(s) : std::array<int, kBudget.size()>{};
  for (std::size_t i = 0; i < kBudget.size(); ++i) {
    const CodeQuantity q = kBudget[i];
    const analysis::CodeRequirement r = analysis::code_requirement(c, *s.well, q, s.margin);
    const propagate::CodeDraws& d = s.which.draws;
    const double ratio = analysis::code_sds(c, *s.well, q, CodeScope::magnetic, c.stations.fields.size() - 1).ratio();
    t.word("quantity", "lateral or worst direction of the last position, sinI dA of the last station", name_of(q));
    t.word("correction", "of the readings", s.correction);
    t.number("predicted_ratio", "1", "predicted over claimed", ratio);
    t.number("reference_factor", "1",
             "largest factor on the errors of total field and dip once a run; NaN: none is small enough", r.reference);
    t.number("dip_deg", "deg", "sd of the dip at this factor", r.reference * d.run.dip / kDegree);
    t.number("total_nT", "nT", "sd of the total field at this factor", r.reference * d.run.total);
    t.number("interference_factor", "1", "largest factor on the interference of the drill string", r.interference);
    t.number("interference_nT", "nT", "sd of the interference at this factor", r.interference * d.interference);
    t.count("stations",
            "fewest stations on the path of a made-up well; 0: more than 400, a survey, or with a disturbance",
            stations[i]);
  }
  return t.take();
}

store::Table terms_table(const Scenario& s) {
  compare::TableRows t("terms", "terms of the base code, and of its twin for the reference, and how they are drawn");
  for (const propagate::CodeTerm& term : s.terms) {
    t.word("code", "of the term", term.code);
    t.word("model", "tool code", term.model);
    t.word("mode", "R: anew at every station; S, W, G: once a run", std::string(1, term.mode));
    t.number("magnitude", "1", "one standard deviation, in the row's unit", term.magnitude);
    t.word("unit", "of the magnitude", term.unit);
    t.word("drawn_as", "error of the six axes or of the reference; carried: not drawn", term.drawn_as);
  }
  return t.take();
}

store::Table zone_table(const Scenario& s) {
  compare::TableRows t("zone", "angle about magnetic east and west that a level hole must keep for axial correction");
  const double angle = analysis::axial_half_angle(s.which.draws, s.field);
  t.number("horizontal_field_nT", "nT", "of the reference", s.field.total * std::cos(s.field.dip));
  t.number("dip_deg", "deg", "of the reference", s.field.dip / kDegree);
  t.number("sd_horizontal_nT", "nT", "s_h: sd of the error of the horizontal field that is matched",
           analysis::horizontal_field_sd(s.which.draws, s.field));
  t.number("half_angle_deg", "deg", "asin sqrt(s_h / (0.12 Bh))", angle / kDegree);
  t.number("fixed_deg", "deg", "what the codes with axial correction exclude", kFixedHalfAngle);
  t.word("fixed_is", "enough, or too small", angle <= kFixedHalfAngle * kDegree ? "enough" : "too small");
  return t.take();
}

store::Table validity_table(const Scenario& s, const analysis::CodeComparison* c, const stats::Tally& tally) {
  compare::TableRows t("validity", "whether the correction is determined, and what the codes were read from");
  t.word("base", "tool code whose errors are drawn", s.base);
  t.word("claimed", "tool code of the corrected survey", s.claimed);
  t.word("reference_of", "tool code of the sizes of total field and dip", s.reference_of);
  t.word("correction", "of the readings", s.correction);
  t.count("stations", "that are measured", c ? c->stations.fields.size() : std::size_t{0});
  t.number("condition", "1", "of the normal matrix, scaled to a unit diagonal; above 1e10: undetermined",
           c ? c->after.condition : kNaN);
  t.count("determined", "1 where the correction is determined to first order", c && c->after.determined ? 1 : 0);
  t.count("trials", "realisations", tally.trials);
  t.count("failed", "of them without a solution: above 1 % undetermined", tally.failed);
  t.count("ambiguous",
          "of them, under axial correction, with a station whose other minimum is lower, at an axial error of at most "
          "four sd",
          tally.counts.empty() ? std::uint64_t{0} : tally.counts.back());
  return t.take();
}

std::vector<store::Map> code_maps(const Scenario& s, const montecarlo::RunOptions& options,
                                  analysis::RobustLimits& limits) {
  const bool places = !s.latitude_deg.empty();
  const std::vector<store::Axis> axes =
      places
          ? std::vector<store::Axis>{{"latitude", "deg", "geodetic latitude, north positive", s.latitude_deg},
                                     {"longitude", "deg", "longitude, east positive", s.longitude_deg}}
          : std::vector<store::Axis>{{"inclination", "deg", "inclination of the last station", s.inclination_deg},
                                     {"azimuth", "deg", "azimuth of the last station, from true north", s.azimuth_deg}};
  std::vector<store::Map> maps;
  for (const CodeQuantity q : kMapped)
    maps.push_back({std::string("ratio_") + name_of(q),
                    "1",
                    "sd that is left over sd claimed, of the last station; NaN where undetermined",
                    axes,
                    {}});
  maps.push_back({"class", "1", "of lateral: 0 free, 1 kept, 2 broken, 3 harmful, 4 undetermined", axes, {}});
  maps.push_back({"kappa",
                  "1",
                  "of the last station, s_h / (Bh sin^2 x), x from magnetic east or west: codes with axial correction "
                  "hold below 0.12",
                  axes,
                  {}});
  maps.push_back({"half_angle", "deg", "about magnetic east and west, below which kappa is above 0.12", axes, {}});
  store::Map orders{"order_needed", "1", compare::kOrderMapMeaning, axes, {}};
  const auto order_of = [&](const survey::Survey& well, const survey::ReferenceField& field,
                            const analysis::CodeComparison& c) {
    if (!c.after.determined) return kNaN;
    orders::WantedOrders wanted;
    wanted.profile = true;
    wanted.options = s.orders.wanted.options;
    const CorrectedRuns runs(s.which, well, field, c);
    return compare::order_value(orders::predict(runs.chain(), wanted, orders::first_order_directions),
                                analysis::code_direction(c, well, CodeQuantity::lateral), s.verdict.margin);
  };
  const auto add_cell = [&](const survey::Survey& well, const survey::ReferenceField& field) {
    const analysis::CodeComparison c = analysis::compare_code(well, field, s.which, false);
    limits = analysis::worse_of(limits, c.after.limits);
    for (std::size_t i = 0; i < kMapped.size(); ++i) {
      const analysis::CodeSds sds =
          analysis::code_sds(c, well, kMapped[i], CodeScope::magnetic, c.stations.fields.size() - 1);
      maps[i].values.push_back(sds.ratio());
      if (i > 0) continue;
      const std::string cls = analysis::code_class(analysis::code_verdict(sds.ratio_before(), s.margin),
                                                   analysis::code_verdict(sds.ratio(), s.margin));
      maps[kClassMap].values.push_back(
          static_cast<double>(std::find(analysis::kCodeClasses.begin(), analysis::kCodeClasses.end(), cls) -
                              analysis::kCodeClasses.begin()));
    }
    const survey::Station& last = well.stations.back();
    maps[kClassMap + 1].values.push_back(analysis::axial_kappa(s.which.draws, field, last.inclination, last.azimuth));
    maps[kClassMap + 2].values.push_back(analysis::axial_half_angle(s.which.draws, field) / kDegree);
    if (s.orders.wanted.profile) orders.values.push_back(order_of(well, field, c));
  };
  const auto look_for_stop = [&] {
    if (options.stop && *options.stop) throw Interrupted("stopped before all maps were made");
  };
  for (const double latitude : s.latitude_deg) {
    look_for_stop();
    for (const double longitude : s.longitude_deg)
      add_cell(*s.well, s.places.at(latitude * kDegree, longitude * kDegree));
  }
  for (const double inclination : s.inclination_deg) {
    look_for_stop();
    for (const double azimuth : s.azimuth_deg)
      add_cell(analysis::make_well(*s.design, inclination * kDegree, azimuth * kDegree), s.field);
  }
  if (s.orders.wanted.profile) maps.push_back(std::move(orders));
  return maps;
}

store::Table shares_table(const Scenario& s, const std::vector<store::Map>& maps) {
  compare::TableRows t("shares", "share of the map by class of the lateral position, first order");
  const std::vector<double>& classes = maps[kClassMap].values;
  // A cell of a map over places has an area.
  const auto weight = [&](std::size_t cell) {
    return s.latitude_deg.empty() ? 1.0 : std::cos(s.latitude_deg[cell / s.longitude_deg.size()] * kDegree);
  };
  std::array<double, analysis::kCodeClasses.size()> parts{};
  double all = 0;
  for (std::size_t cell = 0; cell < classes.size(); ++cell) {
    parts[static_cast<std::size_t>(classes[cell])] += weight(cell);
    all += weight(cell);
  }
  t.word("correction", "of the readings", s.correction);
  t.count("cells", "directions or places of the map", classes.size());
  for (std::size_t i = 0; i < analysis::kCodeClasses.size(); ++i)
    t.number(analysis::kCodeClasses[i], "1", "share of the directions, or of the area", parts[i] / all);
  double most = kNaN;
  for (const double ratio : maps.front().values)
    if (!(ratio <= most)) most = std::isnan(ratio) ? most : ratio;
  t.number("largest_ratio", "1", "of the lateral position, where determined", most);
  return t.take();
}

}  // namespace surveymc::studies::corrected_codes
