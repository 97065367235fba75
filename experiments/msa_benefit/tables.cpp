/// Maps and summary of the study `msa_benefit`.
#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/order_rows.h"
#include "msa_benefit/study.h"
#include "stats/heavy_tail.h"
#include "stats/normal_tail.h"
#include "stats/order_statistics.h"

namespace surveymc::studies::msa_benefit {
namespace {

constexpr double kWorse = 1.01;  // directions that MSA does not touch have 1, but for rounding

double sd_of(const analysis::BenefitSd& sd, std::size_t quantity) {
  return quantity == 0 ? sd.azimuth / kDegree : sd.lateral;
}

/// NaN where the sd before is: benefit_ratio() takes what is not above 0 for 0.
double ratio_of(const analysis::Benefit& b, std::size_t quantity) {
  const double before = sd_of(b.before, quantity);
  return std::isnan(before) ? kNaN : analysis::benefit_ratio(before, sd_of(b.after, quantity));
}

std::vector<store::Axis> axes_of(const Scenario& s) {
  return {{"inclination", "deg", "inclination of the last station", s.inclination_deg},
          {"azimuth", "deg", "azimuth of the last station, from true north", s.azimuth_deg}};
}

}  // namespace

std::vector<store::Map> benefit_maps(const Scenario& s, const std::vector<analysis::Benefit>& benefits,
                                     const std::vector<double>& orders) {
  const std::vector<store::Axis> axes = axes_of(s);
  std::vector<store::Map> maps;
  const auto add = [&](const std::string& name, const std::string& unit, const std::string& meaning,
                       const std::function<double(const analysis::Benefit&)>& value) {
    store::Map m{name, unit, meaning, axes, {}};
    for (const analysis::Benefit& b : benefits) m.values.push_back(value(b));
    maps.push_back(std::move(m));
  };
  const std::array<std::string, 2> meaning{"azimuth of the last station", "last position to the side of the hole"};
  for (std::size_t q = 0; q < 2; ++q) {
    const std::string name = kBenefits[q], unit = kBenefitUnits[q];
    add(name + "_ratio", "1", meaning[q] + ": sd after MSA over sd before; inf where MSA is not determined",
        [q](const analysis::Benefit& b) { return ratio_of(b, q); });
    add(name + "_sd_before_" + unit, unit, meaning[q] + ": sd before MSA",
        [q](const analysis::Benefit& b) { return sd_of(b.before, q); });
    add(name + "_sd_after_" + unit, unit, meaning[q] + ": sd after MSA; inf where it is not determined",
        [q](const analysis::Benefit& b) { return sd_of(b.after, q); });
  }
  add("condition", "1", "condition of the normal matrix of the estimated parameters",
      [](const analysis::Benefit& b) { return b.condition; });
  add("gain_z_bias_z_correlation", "1", "correlation of the errors of gain_z and bias_z; NaN unless both are estimated",
      [](const analysis::Benefit& b) { return b.gain_bias_correlation; });
  if (!orders.empty()) maps.push_back({"order_needed", "1", compare::kOrderMapMeaning, axes, orders});
  return maps;
}

std::vector<compare::TailQuantity> tails_after(const analysis::Benefit& b, const sensor::ReferenceMixing& mixing) {
  std::vector<compare::TailQuantity> out;
  for (std::size_t q = 0; q < kBenefits.size(); ++q) {
    const double sd = q == 0 ? b.after.azimuth : b.after.lateral;  // rad, m
    compare::TailQuantity tail{kTailNames[q], std::isfinite(sd) ? sd_of(b.after, q) : 0, {}};
    if (tail.sd > 0 && !mixing.slots.empty())
      tail.parts = stats::heavy_parts(mixing.slots, mixing.slot_of,
                                      b.after_by_reference.row(static_cast<Eigen::Index>(q)).transpose(), sd * sd);
    out.push_back(std::move(tail));
  }
  return out;
}

std::vector<store::Map> tail_maps(const Scenario& s, const std::vector<analysis::Benefit>& benefits,
                                  const sensor::ReferenceMixing& mixing) {
  std::vector<store::Map> maps;
  for (std::size_t q = 0; q < kBenefits.size(); ++q)
    for (const double k : s.tails.k)
      maps.push_back({fmt::format("{}_beyond_{:g}", kTailNames[q], k),
                      "1",
                      fmt::format("probability of an error beyond {:g} predicted sd after MSA; of a normal one {:.3g}",
                                  k, 2 * stats::normal_upper_tail(k)),
                      axes_of(s),
                      {}});
  for (const analysis::Benefit& b : benefits) {
    const std::vector<compare::TailQuantity> tails = tails_after(b, mixing);
    for (std::size_t q = 0; q < tails.size(); ++q) {
      const std::vector<double> p = stats::beyond(tails[q].parts, s.tails.k);
      for (std::size_t i = 0; i < p.size(); ++i)
        maps[q * s.tails.k.size() + i].values.push_back(tails[q].sd > 0 ? p[i] : kNaN);
    }
  }
  return maps;
}

store::Table benefit_summary(const Scenario& s, const std::vector<analysis::Benefit>& benefits) {
  compare::TableRows t("summary", "sd after MSA over sd before, over all directions of the map");
  for (std::size_t q = 0; q < 2; ++q) {
    std::vector<double> ratio;
    std::int64_t undetermined = 0, worse = 0;
    std::size_t best = benefits.size(), worst = benefits.size();
    std::vector<double> defined;  // a vertical hole may have no azimuth that could be better or worse
    for (std::size_t i = 0; i < benefits.size(); ++i) {
      ratio.push_back(ratio_of(benefits[i], q));
      if (std::isnan(ratio[i])) continue;
      defined.push_back(ratio[i]);
      worse += ratio[i] > kWorse;
      if (!std::isfinite(benefits[i].condition)) {
        ++undetermined;
        continue;
      }
      if (best == benefits.size() || ratio[i] < ratio[best]) best = i;
      if (worst == benefits.size() || ratio[i] > ratio[worst]) worst = i;
    }
    t.word("quantity", "azimuth of the last station, or last position to the side of the hole", kBenefits[q]);
    t.count("directions", "of the map", defined.size());
    t.count("undetermined", "directions whose stations do not determine the estimated parameters", undetermined);
    t.number("worse_share", "1", "share of the directions with a ratio above 1.01, or undetermined",
             static_cast<double>(worse) / static_cast<double>(defined.size()));
    t.number("ratio_median", "1", "median of the ratio; inf if most are undetermined", stats::median(defined));
    const auto extreme = [&](const std::string& which, const char* meaning, std::size_t i) {
      const bool there = i < benefits.size();
      const std::size_t azimuths = s.azimuth_deg.size();
      t.number("ratio_" + which, "1", meaning, there ? ratio[i] : kNaN);
      t.number(which + "_inclination_deg", "deg", "where: inclination", there ? s.inclination_deg[i / azimuths] : kNaN);
      t.number(which + "_azimuth_deg", "deg", "where: azimuth", there ? s.azimuth_deg[i % azimuths] : kNaN);
    };
    extreme("best", "smallest ratio, of determined directions", best);
    extreme("worst", "largest ratio, of determined directions", worst);
  }
  return t.take();
}

}  // namespace surveymc::studies::msa_benefit
