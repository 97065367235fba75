#include "compare/tails.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "base/units.h"
#include "config/config.h"
#include "propagate/ellipse.h"
#include "stats/normal_tail.h"
#include "stats/sample_summary.h"
#include "survey/readings.h"

namespace surveymc::compare {
namespace {

constexpr const char* kMixture = "mixture";
constexpr const char* kNormal = "normal";

std::string formulation_name(const std::string& place, const char* name) {
  return place.empty() ? name : place + " " + name;
}

std::string row_name(const std::string& quantity, double k) { return fmt::format("{}_beyond_{:g}", quantity, k); }

}  // namespace

TailRule read_tail_rule(config::ConfigReader& c, const random::ReferenceLaws& laws) {
  TailRule rule;
  rule.wanted = laws.any() || c.has("tails.k") || c.has("tails.margin");
  if (!rule.wanted) return rule;
  rule.k = c.numbers("tails.k", config::Range::closed(0.1, 10),
                     "table `tails`: how often errors are beyond so many predicted sd", -1, rule.k);
  for (std::size_t i = 1; i < rule.k.size(); ++i)
    c.require(rule.k[i] > rule.k[i - 1] && row_name("", rule.k[i]) != row_name("", rule.k[i - 1]), "tails.k",
              "must increase, and differ in the first six digits");
  rule.margin = c.number("tails.margin", config::Range::closed(0, 10),
                         "margin of the ratio of predicted to drawn probability in table `tails`", rule.margin);
  return rule;
}

WellTails well_tails(const propagate::WellMixing& mixing, const Eigen::Matrix3Xd& effects, const Eigen::Matrix3d& hla) {
  WellTails out;
  const Eigen::Matrix3d covariance = propagate::covariance_of(effects);
  out.directions << Eigen::Matrix3d::Identity(), hla.transpose(), propagate::ellipsoid(covariance).axes;
  for (std::size_t i = 0; i < kWellDirections.size(); ++i) {
    const Eigen::Vector3d u = out.directions.col(static_cast<Eigen::Index>(i));
    const double variance = u.dot(covariance * u);
    const bool is_reached = variance > 1e-24 * covariance.trace();
    out.quantities.push_back(
        {kWellDirections[i], is_reached ? std::sqrt(variance) : 0,
         is_reached ? propagate::heavy_parts(mixing, effects, u) : std::vector<stats::HeavyPart>()});
  }
  return out;
}

std::vector<Row> tail_rows(const std::vector<std::string>& names, const TailRule& rule, const std::string& place) {
  std::vector<Row> rows;
  for (const std::string& name : names)
    for (const double k : rule.k)
      for (const char* formulation : {kMixture, kNormal})
        rows.push_back({.table = "tails",
                        .formulation = formulation_name(place, formulation),
                        .quantity = row_name(name, k),
                        .unit = "1",
                        .predicted = false,
                        .available = rule.wanted});
  return rows;
}

void count_beyond(double error, double sd, const TailRule& rule, std::uint64_t* counts) {
  for (std::size_t i = 0; i < rule.k.size(); ++i) counts[i] += std::abs(error) > rule.k[i] * sd;
}

store::Table tails_table(const std::vector<TailQuantity>& quantities, const TailRule& rule, const std::uint64_t* counts,
                         std::uint64_t runs, const VerdictRule& verdict, const Annotations& annotations,
                         std::uint64_t trials, std::uint64_t failed) {
  std::vector<ComparisonRow> rows;
  std::vector<double> ks, sds, predicted, normal, share;
  VerdictRule judged = verdict.with_margin(rule.margin);
  judged.at_all_looks = false;  // no look at these rows ends a run
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    const TailQuantity& x = quantities[q];
    const std::vector<double> mixture =
        rule.predicted ? stats::beyond(x.parts, rule.k) : std::vector<double>(rule.k.size(), kNaN);
    double heavy = 0;
    for (const stats::HeavyPart& p : x.parts) heavy += p.weight * p.weight;
    for (std::size_t i = 0; i < rule.k.size(); ++i)
      for (const char* formulation : {kMixture, kNormal}) {
        const double of_normal = 2 * stats::normal_upper_tail(rule.k[i]);
        const bool is_mixture = formulation == kMixture, has_error = x.sd > 0;
        rows.push_back(labelled(formulation_name(x.place, formulation),
                                compare_rate(row_name(x.name, rule.k[i]),
                                             counts != nullptr && has_error ? counts[q * rule.k.size() + i] : 0,
                                             counts != nullptr && has_error ? runs : 0,
                                             is_mixture ? mixture[i] : of_normal, judged, trials)));
        if (counts == nullptr) rows.back().note = "no trials";
        if (is_mixture && !rule.predicted) rows.back().note = "no prediction: a disturbance here is not normal";
        if (!has_error) rows.back().note = "no error in this direction";
        ks.push_back(rule.k[i]);
        sds.push_back(x.sd);
        predicted.push_back(has_error ? mixture[i] : kNaN);
        normal.push_back(of_normal);
        share.push_back(heavy);
      }
  }
  annotations.apply("tails", rows);
  store::Table t = comparison_table("tails", "probability of an error beyond k predicted sd" + at_confidence(judged),
                                    rows, trials, failed, true);
  t.columns.push_back({"k", "1", "predicted standard deviations", ks});
  t.columns.push_back({"sd_m", "m", "the predicted one", sds});
  t.columns.push_back({"predicted", "1", "probability by the laws of what is drawn", predicted});
  t.columns.push_back({"normal", "1", "probability of a normal distribution", normal});
  t.columns.push_back({"heavy_share", "1", "share of the variance that is not normal", share});
  return t;
}

void DrawnLaws::add(const random::Stream& stream, const std::vector<LawDraw>& draws, montecarlo::TrialBlock block,
                    bool antithetic, stats::Tally& tally) {
  const int groups = survey::groups_for(block.count), step = antithetic ? 2 : 1;
  std::vector<std::vector<double>> values;
  for (const LawDraw& d : draws) {
    survey::LaneArray v(groups, 2);
    random::draw_mixing(stream, {d.slot}, block.first, antithetic, groups, v.row(0, 0), v.group_stride());
    values.emplace_back();
    for (int t = 0; t < block.count; t += step) {
      const std::uint64_t trial = (block.first + static_cast<std::uint64_t>(t)) / static_cast<std::uint64_t>(step);
      values.back().push_back(v.value(t, 0) * stream.normal(trial, d.channel, d.index) + v.value(t, 1));
    }
  }
  add(values, tally);
}

void DrawnLaws::add(const std::vector<std::vector<double>>& draws, stats::Tally& tally) {
  if (draws.empty()) return;
  Eigen::MatrixXd values(static_cast<Eigen::Index>(draws[0].size()), static_cast<Eigen::Index>(draws.size()));
  const std::size_t first = tally.counts.size();
  tally.counts.resize(first + counts(draws.size()));
  for (std::size_t e = 0; e < draws.size(); ++e)
    for (std::size_t t = 0; t < draws[e].size(); ++t) {
      values(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(e)) = draws[e][t];
      ++tally.counts[first + e * bins().bins + bins().bin(std::abs(draws[e][t]))];
    }
  tally.groups.push_back(stats::Moments::of(values));
}

store::Table laws_table(const random::ReferenceLaws& laws, const std::vector<LawDraw>& drawn,
                        const stats::Moments* moments, const std::uint64_t* counts, double confidence) {
  TableRows t("laws", "laws of the errors of the reference, by their formulas and as drawn");
  const double p68 = 1 - 2 * stats::normal_upper_tail(1), p95 = 1 - 2 * stats::normal_upper_tail(2);
  // `number`: of the element among those that are drawn; none: nothing draws it.
  const auto write = [&](const std::string& name, const random::ReferenceLaws::Element& element,
                         const random::MixingLaw& law, std::optional<std::size_t> number) {
    t.word("element", "declination, dip or total field", name);
    t.word("law", "its law", random::law_names()[static_cast<std::size_t>(law.law().kind)]);
    t.word("size", "what the tabulated size is", element.size);
    t.number("sd_per_size", "1", "standard deviation of an error whose tabulated size is 1", element.sd);
    t.number("ci68", "1", "half of the interval that has 68.3 %, in sd", law.half_width(p68));
    t.number("ci95", "1", "a quarter of the interval that has 95.4 %, in sd", law.half_width(p95) / 2);
    t.number("kurtosis", "1", "excess kurtosis; infinite where there is none", law.excess_kurtosis());
    stats::SampleSummary x;
    if (number && moments != nullptr && moments->count > 1)
      x = stats::summarise(*moments, static_cast<Eigen::Index>(*number));
    const std::uint64_t* of = number && counts != nullptr ? counts + *number * DrawnLaws::bins().bins : nullptr;
    const auto quantile = [&](const char* column, double p, double per) {
      const stats::Interval ci =
          of ? stats::histogram_quantile_interval(DrawnLaws::bins(), of, p, confidence) : stats::Interval{kNaN, kNaN};
      t.estimate(column, "1", "the same interval of the draws",
                 of ? stats::histogram_quantile(DrawnLaws::bins(), of, p) / per : kNaN, {ci.lo / per, ci.hi / per});
    };
    const bool sampled = x.units > 1;
    t.estimate("drawn_sd", "1", "sd of the draws", sampled ? std::sqrt(x.variance) : kNaN,
               sampled ? stats::sd_interval(x, confidence) : stats::Interval{kNaN, kNaN});
    quantile("drawn_ci68", p68, 1);
    quantile("drawn_ci95", p95, 2);
    t.number("drawn_kurtosis", "1", "excess kurtosis of the draws", sampled ? x.kurtosis - 3 : kNaN);
    t.count("draws", "draws looked at", sampled ? x.units : 0);
  };
  for (std::size_t e = 0; e < laws.elements.size(); ++e) {
    if (!laws.elements[e].law) continue;
    const auto at = std::find_if(drawn.begin(), drawn.end(), [e](const LawDraw& d) {
      return d.element == static_cast<random::ReferenceElement>(e);
    });
    const auto number = at == drawn.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - drawn.begin()));
    write(random::reference_elements()[e], laws.elements[e], *laws.elements[e].law, number);
  }
  return t.take([&] { write("", {}, random::MixingLaw(), std::nullopt); });
}

}  // namespace surveymc::compare
