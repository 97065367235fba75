#include "reliability/summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "compare/table_rows.h"
#include "montecarlo/block_queue.h"
#include "montecarlo/threads.h"
#include "stats/order_statistics.h"
#include "stats/size_counts.h"

namespace surveymc::studies::reliability {
namespace {

using stats::SizeCounts;
using LayerCounts = std::vector<SizeCounts>;

/// All layers of a subject, in pieces that stay in the caches.
LayerCounts counted(const LayerSource& source, std::size_t subject, std::size_t points, const LayerCounts& empty,
                    const montecarlo::RunOptions& options) {
  constexpr std::size_t kPiece = std::size_t{1} << 14;
  montecarlo::BlockQueue queue({montecarlo::all_blocks(points, kPiece)});
  const auto threads = static_cast<std::size_t>(montecarlo::threads_for(options.threads, queue.left()));
  std::vector<LayerCounts> by_thread(threads, empty);
  const auto stopped = [&] { return options.stop && *options.stop; };
  montecarlo::in_threads(static_cast<int>(threads), stopped, [&](int thread) {
    const std::optional<std::uint64_t> block = queue.take();
    if (!block) return false;
    const std::size_t first = *block * kPiece;
    const auto values = source(subject, first, std::min(kPiece, points - first));
    LayerCounts& counts = by_thread[static_cast<std::size_t>(thread)];
    for (std::size_t l = 0; l < values.size(); ++l) counts[l].add(values[l], first);
    return true;
  });
  if (queue.left() > 0) throw Interrupted("stopped before all maps were made");
  for (std::size_t t = 1; t < threads; ++t)
    for (std::size_t l = 0; l < empty.size(); ++l) by_thread[0][l].add(by_thread[t][l]);
  return std::move(by_thread[0]);
}

/// Some points in all parts of the grid.
LayerCounts some(const LayerSource& source, std::size_t subject, std::size_t points, std::size_t layers) {
  constexpr std::size_t kRuns = 4096, kRun = 8;
  LayerCounts sample(layers);
  for (std::size_t r = 0; r < kRuns; ++r) {
    const std::size_t first = points / kRuns * r;
    const auto values = source(subject, first, std::min(kRun, points - first));
    for (std::size_t l = 0; l < layers; ++l) sample[l].add(values[l], first);
  }
  return sample;
}

LayerCounts counts_of(const LayerSource& source, std::size_t subject, std::size_t points, std::size_t layers,
                      bool exact, const montecarlo::RunOptions& options) {
  const auto all = [&](const LayerCounts& empty) { return counted(source, subject, points, empty, options); };
  if (exact) return all(LayerCounts(layers));
  const auto near_medians_of = [](const LayerCounts& counts) {
    LayerCounts empty;
    for (const SizeCounts& c : counts) empty.push_back(SizeCounts::near(c.median()));
    return empty;
  };
  LayerCounts counts = all(near_medians_of(some(source, subject, points, layers)));
  if (std::all_of(counts.begin(), counts.end(), [](const SizeCounts& c) { return c.has_median(); })) return counts;
  return all(near_medians_of(all(LayerCounts(layers, SizeCounts::of_all()))));
}

void write_place(compare::TableRows& t, const std::string& which, const ReliabilityGrid& grid, double value,
                 std::size_t at) {
  t.number(which, "1", which + " of the finite |x|, in the row's unit", value);
  const GridPoint p = grid_point(grid, at);
  const auto place = [&](const char* axis, const char* unit, double x) {
    t.number(which + "_" + axis, unit, "where the " + which + " is", std::isnan(value) ? kNaN : x);
  };
  place("inclination_deg", "deg", p.inclination_deg);
  place("toolface_deg", "deg", p.toolface_deg);
  place("magnetic_azimuth_deg", "deg", p.magnetic_azimuth_deg);
  place("dip_deg", "deg", grid.dip_deg.size() > 1 ? p.dip_deg : kNaN);
  place("noise_scale", "1", grid.noise_scale.size() > 1 ? p.noise_scale : kNaN);
}

}  // namespace

store::Table summary_table(const ReliabilityGrid& grid, const std::vector<ErrorSubject>& subjects,
                           const std::vector<std::string>& layers, const LayerSource& source, bool exact,
                           const montecarlo::RunOptions& options) {
  compare::TableRows t("summary",
                       "sizes |x| over all points of the maps: extremes of the finite ones and where they are, median");
  const std::size_t points = grid.points();
  for (std::size_t o = 0; o < subjects.size(); ++o) {
    const LayerCounts counts = counts_of(source, o, points, layers.size(), exact, options);
    for (std::size_t l = 0; l < layers.size(); ++l) {
      const SizeCounts& c = counts[l];
      t.word("observation", "in which the error is", subject_name(subjects[o]));
      t.word("quantity", "map", layers[l]);
      t.word("unit", "of the sizes", layer_unit(layers[l], subjects[o]));
      t.count("points", "points of the map", points);
      t.count("infinite", "points where it is infinite", c.infinite());
      write_place(t, "minimum", grid, c.smallest(), c.smallest_at());
      write_place(t, "maximum", grid, c.largest(), c.largest_at());
      t.number("median", "1",
               exact ? "median of the finite |x|, in the row's unit"
                     : "median of the finite |x|, in the row's unit, to 1e-6",
               c.median());
    }
  }
  return t.take();
}

namespace {

using Part = std::vector<std::pair<std::string, double>>;

constexpr std::array kAxes{"inclination_deg", "toolface_deg", "magnetic_azimuth_deg", "dip_deg", "noise_scale"};

double on_axis(const GridPoint& p, const std::string& axis) {
  return axis == "inclination_deg"        ? p.inclination_deg
         : axis == "toolface_deg"         ? p.toolface_deg
         : axis == "magnetic_azimuth_deg" ? p.magnetic_azimuth_deg
         : axis == "dip_deg"              ? p.dip_deg
                                          : p.noise_scale;
}
bool same(double a, double b) { return std::abs(a - b) < 1e-9; }

bool is_in(const GridPoint& p, const Part& part) {
  return std::all_of(part.begin(), part.end(),
                     [&](const auto& key) { return same(on_axis(p, key.first), key.second); });
}

std::vector<GridPoint> points_in(const ReliabilityGrid& grid, const Part& part) {
  std::vector<GridPoint> points;
  for (std::size_t k = 0; k < grid.points(); ++k)
    if (const GridPoint p = grid_point(grid, k); is_in(p, part)) points.push_back(p);
  return points;
}

/// A crossing is one along the inclination alone.
bool one_per_inclination(const std::vector<GridPoint>& points) {
  std::vector<double> inclinations;
  for (const GridPoint& p : points) inclinations.push_back(p.inclination_deg);
  std::sort(inclinations.begin(), inclinations.end());
  return std::adjacent_find(inclinations.begin(), inclinations.end(), same) == inclinations.end();
}

/// Two parts whose points, in order, differ in the axes alone that either part names.
bool are_pairs(const std::vector<GridPoint>& a, const std::vector<GridPoint>& b, const Part& where,
               const Part& relative_to) {
  const auto named = [&](const std::string& axis) {
    const auto is_axis = [&](const auto& key) { return key.first == axis; };
    return std::any_of(where.begin(), where.end(), is_axis) ||
           std::any_of(relative_to.begin(), relative_to.end(), is_axis);
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const GridPoint& p, const GridPoint& q) {
    return std::all_of(kAxes.begin(), kAxes.end(), [&](const std::string& axis) {
      return named(axis) || same(on_axis(p, axis), on_axis(q, axis));
    });
  });
}

/// |x| and inclination of the points of a part, in order.
struct Sizes {
  std::vector<double> x, inclination;
};
Sizes sizes_in(const ReliabilityGrid& grid, const std::vector<double>& values, const Part& part) {
  Sizes s;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const GridPoint p = grid_point(grid, k);
    if (!is_in(p, part)) continue;
    s.x.push_back(std::abs(values[k]));
    s.inclination.push_back(p.inclination_deg);
  }
  return s;
}

/// Where x passes the levels, one a point.
double crossing(const Sizes& s, const std::vector<double>& levels) {
  for (std::size_t k = 1; k < s.x.size(); ++k) {
    const double before = s.x[k - 1] - levels[k - 1], after = s.x[k] - levels[k];
    if (std::isfinite(before) && std::isfinite(after) && (before <= 0) != (after <= 0))
      return s.inclination[k - 1] + (s.inclination[k] - s.inclination[k - 1]) * before / (before - after);
  }
  return kNaN;
}

double statistic_of(const Sizes& s, const Statement& statement) {
  std::vector<double> finite;
  std::copy_if(s.x.begin(), s.x.end(), std::back_inserter(finite), [](double x) { return std::isfinite(x); });
  if (statement.statistic == "infinite_points")
    return static_cast<double>(std::count_if(s.x.begin(), s.x.end(), [](double x) { return std::isinf(x); }));
  if (statement.statistic == "crossing") return crossing(s, std::vector<double>(s.x.size(), statement.level));
  if (finite.empty()) return kNaN;
  if (statement.statistic == "minimum") return *std::min_element(finite.begin(), finite.end());
  if (statement.statistic == "maximum") return *std::max_element(finite.begin(), finite.end());
  return stats::median(finite);
}

/// `values` and `crossed`: those of the quantity, and of the map that it crosses, if any.
double found_by(const ReliabilityGrid& grid, const std::vector<double>& values, const std::vector<double>& crossed,
                const Statement& s) {
  const Sizes here = sizes_in(grid, values, s.where);
  if (!s.crosses.empty()) return crossing(here, sizes_in(grid, crossed, s.where).x);
  if (s.relative_to.empty()) return statistic_of(here, s);
  const Sizes there = sizes_in(grid, values, s.relative_to);
  if (s.statistic != "largest_ratio") return statistic_of(here, s) / statistic_of(there, s);
  double largest = kNaN;
  for (std::size_t k = 0; k < std::min(here.x.size(), there.x.size()); ++k) {
    const double ratio = here.x[k] / there.x[k];
    if (std::isfinite(ratio) && !(ratio <= largest)) largest = ratio;
  }
  return largest;
}

std::string words_of(const Part& part) {
  std::string text;
  for (const auto& [key, value] : part) text += fmt::format("{}{} = {:g}", text.empty() ? "" : ", ", key, value);
  return text;
}

}  // namespace

std::vector<Statement> read_statements(config::ConfigReader& config, const ReliabilityGrid& grid,
                                       const std::vector<ErrorSubject>& subjects,
                                       const std::vector<std::string>& layers) {
  std::vector<Statement> all;
  for (config::ConfigReader& c : config.tables("statement", "published statements on the maps")) {
    Statement s;
    s.text = c.text("text", "the statement, in its words");
    s.quantity = c.listed_name("quantity", layers, "the name of a map of the result", "map that it is about");
    std::vector<std::string> names;
    for (const ErrorSubject& subject : subjects) names.push_back(subject_name(subject));
    const std::string name = c.listed_name("observation", names, "an observation of the maps, as they name it",
                                           "observation that it is about", names.front());
    s.subject = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    s.statistic =
        c.choice("statistic", {"minimum", "maximum", "median", "infinite_points", "largest_ratio", "crossing"},
                 "what it says of the map: 'crossing': the inclination where the size passes `level`, or the size in "
                 "the map `crosses`; 'largest_ratio': point by point over `relative_to`");
    for (auto [key, part] : {std::pair{"where", &s.where}, std::pair{"relative_to", &s.relative_to}}) {
      if (!c.has(key)) continue;
      *part = c.number_table(key, {}, "points of the grid: those with these values of the axes");
      for (const auto& [axis, value] : *part) {
        const bool known = std::find(kAxes.begin(), kAxes.end(), axis) != kAxes.end();
        c.require(known, key, axis + " is no axis of the maps");
      }
      std::size_t points = 0;
      for (std::size_t k = 0; k < grid.points() && points == 0; ++k) points += is_in(grid_point(grid, k), *part);
      c.require(points > 0, key, "no point of the grid is there");
    }
    c.require(s.statistic != "largest_ratio" || !s.relative_to.empty(), "statistic", "largest_ratio needs relative_to");
    if (s.statistic == "largest_ratio")
      c.require(are_pairs(points_in(grid, s.where), points_in(grid, s.relative_to), s.where, s.relative_to),
                "relative_to",
                "largest_ratio divides point by point, and these are other points than those of where: name the same "
                "keys in both");
    if (s.statistic == "crossing")
      c.require(one_per_inclination(points_in(grid, s.where)), "statistic",
                "a crossing is along the inclination, and there are several points at one: name the other axes in "
                "where");
    if (c.has("crosses")) {
      s.crosses =
          c.listed_name("crosses", layers, "the name of a map of the result", "map whose sizes the crossing meets");
      c.require(s.statistic == "crossing" && s.relative_to.empty(), "crosses", "only with a crossing of its own");
      c.require(!c.has("level"), "level", "not together with crosses");
      c.require(layer_unit(s.crosses, subjects[s.subject]) == layer_unit(s.quantity, subjects[s.subject]), "crosses",
                "has another unit than " + s.quantity);
    } else if (s.statistic == "crossing") {
      s.level = c.number("level", config::Range::positive(), "size at the crossing");
    }
    s.published = c.number("published", {}, "the published number");
    s.tolerance =
        c.number("tolerance", config::Range::positive(), "largest distance of the ratio from 1 that agrees", 0.02);
    s.expected = c.choice("expected", {"agrees", "differs"}, "verdict that is expected", "agrees");
    if (c.matches_point("at")) all.push_back(std::move(s));
  }
  return all;
}

store::Table statements_table(const ReliabilityGrid& grid, const std::vector<ErrorSubject>& subjects,
                              const std::vector<std::string>& layers, const std::vector<Statement>& statements,
                              const LayerSource& source) {
  compare::TableRows t("statements", "statements of the publication, held against the maps");
  for (const Statement& s : statements) {
    const auto number = [&](const std::string& layer) {
      return static_cast<std::size_t>(std::find(layers.begin(), layers.end(), layer) - layers.begin());
    };
    const auto values = source(s.subject, 0, grid.points());
    const double found = found_by(grid, values[number(s.quantity)],
                                  s.crosses.empty() ? std::vector<double>{} : values[number(s.crosses)], s);
    const double ratio = found == s.published ? 1 : s.published / found;
    const bool pure = !s.relative_to.empty() || s.statistic == "infinite_points";
    t.word("observation", "in which the error is", subject_name(subjects[s.subject]));
    t.word("quantity", "map", s.quantity);
    t.word("statistic", "of the sizes |x|", s.statistic);
    t.word("where", "part of the map; and what it is divided by",
           words_of(s.where) + (s.relative_to.empty() ? "" : " / " + words_of(s.relative_to)));
    t.word("unit", "of found and published",
           pure                        ? "1"
           : s.statistic == "crossing" ? "deg"
                                       : layer_unit(s.quantity, subjects[s.subject]));
    t.number("found", "1", "here, in the row's unit", found);
    t.number("published", "1", "there, in the row's unit", s.published);
    t.number("published_ratio", "1", "published over found", ratio);
    t.number("tolerance", "1", "of the ratio from 1 that counts as agreement", s.tolerance);
    t.word("verdict", "agrees or differs", std::abs(ratio - 1) <= s.tolerance ? "agrees" : "differs");
    t.word("expected", "verdict that the config asks for", s.expected);
    t.word("note", "the statement", s.text);
  }
  return t.take();
}

}  // namespace surveymc::studies::reliability
