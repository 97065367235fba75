#include "sweep/refine.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "base/error.h"
#include "base/units.h"
#include "compare/family.h"
#include "compare/sensitivity.h"
#include "compare/warnings.h"
#include "config/suggest.h"
#include "stats/order_statistics.h"
#include "study/sweep_columns.h"

namespace surveymc::sweep {
namespace {

using Place = std::vector<std::uint64_t>;  // on the finest grid, one index an axis

/// Cells of the first grid, halved until they are small enough.
class Cells {
 public:
  Cells(const std::vector<std::string>& axes, const std::map<std::string, std::vector<double>>& grid, double cell) {
    for (const std::string& axis : axes) {
      const std::vector<double>& values = grid.at(axis);
      const double whole = values.back() - values.front();
      double largest = 0;
      for (std::size_t i = 1; i < values.size(); ++i) largest = std::max(largest, values[i] - values[i - 1]);
      unsigned levels = 0;
      constexpr unsigned kMostLevels = 30;
      constexpr double kRounding = 1e-9;
      while (levels < kMostLevels && std::ldexp(largest, -static_cast<int>(levels)) > cell * whole * (1 + kRounding))
        ++levels;
      axes_.push_back({values, levels});
    }
  }

  std::size_t count() const { return axes_.size(); }
  /// Value at an index of the finest grid: between two values of the first grid in equal steps.
  double value(std::size_t axis, std::uint64_t at) const {
    const Axis& a = axes_[axis];
    const std::uint64_t steps = std::uint64_t{1} << a.levels, i = at / steps, in = at % steps;
    if (in == 0) return a.values[i];
    return a.values[i] + (a.values[i + 1] - a.values[i]) * (static_cast<double>(in) / static_cast<double>(steps));
  }
  std::vector<double> values(const Place& at) const {
    std::vector<double> out;
    for (std::size_t d = 0; d < at.size(); ++d) out.push_back(value(d, at[d]));
    return out;
  }
  /// Sides of a cell of the first grid.
  std::uint64_t step(std::size_t axis) const { return std::uint64_t{1} << axes_[axis].levels; }
  std::uint64_t cells(std::size_t axis) const { return axes_[axis].values.size() - 1; }

 private:
  struct Axis {
    std::vector<double> values;
    unsigned levels = 0;  // halvings
  };
  std::vector<Axis> axes_;
};

/// Calls visit(k) for all k = 0 .. last of every axis.
template <class Visit>
void for_each_index(const Place& last, const Visit& visit) {
  Place k(last.size(), 0);
  for (;;) {
    visit(k);
    std::size_t d = last.size();
    while (d > 0 && k[d - 1] == last[d - 1]) k[--d] = 0;
    if (d == 0) return;
    ++k[d - 1];
  }
}

/// Calls visit(place, k) for all places low + k size / parts, k = 0 .. parts, of every axis; `parts` is 1 or 2.
template <class Visit>
void for_each_node(const Place& low, const Place& size, const Place& parts, const Visit& visit) {
  for_each_index(parts, [&](const Place& k) {
    Place at(low.size());
    for (std::size_t d = 0; d < low.size(); ++d) at[d] = low[d] + k[d] * (size[d] / parts[d]);
    visit(at, k);
  });
}

/// Follows a boundary through the cells of one slice; see next_points().
class Follower {
 public:
  Follower(const Cells& cells, const std::map<std::vector<double>, double>& known)
      : cells_(cells), known_(known), dims_(cells.count()) {
    for (std::size_t d = 0; d < dims_; ++d) {
      sizes_.front()[d] = cells.step(d);
      last_[d] = cells.cells(d) * cells.step(d);
    }
    while (std::any_of(sizes_.back().begin(), sizes_.back().end(), [](std::uint64_t n) { return n > 1; })) {
      Place half = sizes_.back();
      for (std::uint64_t& n : half) n = std::max<std::uint64_t>(1, n / 2);
      sizes_.push_back(std::move(half));
    }
    only_sides_ = std::all_of(known.begin(), known.end(),
                              [](const auto& k) { return std::isnan(k.second) || std::abs(k.second) == 1; });
    read_first_grid();
  }

  /// Nodes that are wanted, and the smallest cells that the boundary crosses.
  std::set<std::vector<double>> wanted;
  std::size_t crossed = 0;

  /// Divides cells until a pass tells no cell that its neighbours are rougher than it knew.
  void follow() {
    while (divide_all() && take_over_roughness()) {
    }
  }

 private:
  using Curvature = std::vector<double>;  // per axis: second difference over a cell's side, the largest in the cell
  struct Open {
    std::size_t generation;
    Place low;
    Curvature curvature;
  };

  /// The value at a node, known or inferred; NaN: neither, or it has none.
  double value(const Place& at) {
    if (const auto it = values_.find(at); it != values_.end()) return it->second;
    const auto known = known_.find(cells_.values(at));
    if (known == known_.end()) return kNaN;
    return values_[at] = known->second;
  }
  bool is_known(const Place& at) { return values_.contains(at) || known_.contains(cells_.values(at)); }

  /// Curvature of the cells of the first grid: from their corners and the next nodes on both sides.
  void read_first_grid() {
    Place last_cell(dims_);
    for (std::size_t d = 0; d < dims_; ++d) last_cell[d] = cells_.cells(d) - 1;
    for_each_index(last_cell, [&](const Place& k) {
      Place low(dims_);
      for (std::size_t d = 0; d < dims_; ++d) low[d] = k[d] * sizes_.front()[d];
      Curvature c(dims_, 0);
      for_each_node(low, sizes_.front(), Place(dims_, 1), [&](const Place& at, const Place&) {
        for (std::size_t d = 0; d < dims_ && !only_sides_; ++d) {
          const std::uint64_t n = sizes_.front()[d];
          if (last_[d] < 2 * n) continue;
          Place middle = at;  // at the rim the next line of three
          middle[d] = std::clamp(at[d], n, last_[d] - n);
          Place before = middle, behind = middle;
          before[d] -= n;
          behind[d] += n;
          const double left = cells_.value(d, middle[d]) - cells_.value(d, before[d]),
                       right = cells_.value(d, behind[d]) - cells_.value(d, middle[d]),
                       width = cells_.value(d, low[d] + n) - cells_.value(d, low[d]);
          const double second = 2 * ((value(behind) - value(middle)) / right - (value(middle) - value(before)) / left) /
                                (left + right) * width * width;
          if (!std::isnan(second)) c[d] = std::max(c[d], std::abs(second));
        }
      });
      first_[low] = std::move(c);
    });
  }

  /// One pass over the cells, from large ones to small ones. False if nothing is left to be told to neighbours.
  bool divide_all() {
    values_.clear();
    inferred_.clear();
    open_.clear();
    wanted.clear();
    crossed = 0;
    generations_.assign(sizes_.size(), {});
    generations_.front() = first_;
    for (std::size_t g = 0; g < sizes_.size(); ++g)
      for (const auto& [low, own] : generations_[g]) visit(g, low, own);
    return !open_.empty();
  }

  void visit(std::size_t g, const Place& low, const Curvature& own) {
    Curvature curvature = own;
    if (const auto told = told_.find({g, low}); told != told_.end())
      for (std::size_t d = 0; d < dims_; ++d) curvature[d] = std::max(curvature[d], told->second[d]);
    bool above = false, below = false;
    double least = kInfinity, bent = 0;
    for_each_node(low, sizes_[g], parts_of(g), [&](const Place& at, const Place&) {
      const double v = value(at);
      above = above || v >= 0;
      below = below || v < 0;
      if (!std::isnan(v)) least = std::min(least, std::abs(v));
    });
    for (const double c : curvature) bent += c / 8;  // what a chord misses of an arc
    const bool crosses = above && below, smallest = g + 1 == sizes_.size();
    if (!crosses && !(least < kDoubt * bent)) return;
    open_.push_back({g, low, curvature});
    if (smallest) {
      crossed += crosses;
      return;
    }
    if (fill(g, low, curvature)) halve(g, low, curvature);
  }

  Place parts_of(std::size_t g) const {
    Place parts(dims_);
    for (std::size_t d = 0; d < dims_; ++d) parts[d] = sizes_[g][d] > 1 ? 2 : 1;
    return parts;
  }

  /// Infers the midpoints of a cell where its corners leave no doubt of their side, and wants the others. False if any
  /// is wanted.
  bool fill(std::size_t g, const Place& low, const Curvature& curvature) {
    bool whole = true;
    for_each_node(low, sizes_[g], parts_of(g), [&](const Place& at, const Place& k) {
      double bent = 0;
      std::vector<std::size_t> middles;
      for (std::size_t d = 0; d < dims_; ++d)
        if (sizes_[g][d] > 1 && k[d] == 1) {
          middles.push_back(d);
          bent += curvature[d] / 8;
        }
      if (middles.empty() || is_known(at)) return;
      double sum = 0, sides = 0;
      const std::size_t corners = std::size_t{1} << middles.size();
      for (std::size_t c = 0; c < corners; ++c) {
        Place corner = at;
        for (std::size_t m = 0; m < middles.size(); ++m) {
          const std::size_t d = middles[m];
          corner[d] = (c >> m & 1) != 0 ? low[d] + sizes_[g][d] : low[d];
        }
        const double v = value(corner);
        sum += v;
        sides += v >= 0 ? 1 : -1;
      }
      const double between = sum / static_cast<double>(corners);
      const bool one_side = std::abs(sides) == static_cast<double>(corners);
      if (std::abs(between) > kSure * bent && (one_side || bent > 0)) {
        values_[at] = between;
        inferred_.insert(at);
      } else {
        wanted.insert(cells_.values(at));
        whole = false;
      }
    });
    return whole;
  }

  /// The halves of a cell become cells, with the curvature that its nodes show now.
  void halve(std::size_t g, const Place& low, const Curvature& curvature) {
    const Place parts = parts_of(g);
    Curvature seen(dims_, 0);
    for (std::size_t d = 0; d < dims_; ++d) {
      if (parts[d] == 1 || only_sides_) {
        seen[d] = curvature[d];
        continue;
      }
      bool guessed = false;
      for_each_node(low, sizes_[g], parts, [&](const Place& at, const Place& k) {
        if (k[d] != 1) return;
        Place before = at, behind = at;
        before[d] = low[d];
        behind[d] = low[d] + sizes_[g][d];
        const double second = value(before) - 2 * value(at) + value(behind);
        if (!std::isnan(second)) seen[d] = std::max(seen[d], std::abs(second));
        guessed = guessed || inferred_.contains(before) || inferred_.contains(at) || inferred_.contains(behind);
      });
      // What was inferred shows no curvature: that of a smooth function falls by four.
      if (guessed) seen[d] = std::max(seen[d], curvature[d] / 4);
    }
    for_each_node(low, sizes_[g], parts, [&](const Place& at, const Place& k) {
      for (std::size_t d = 0; d < dims_; ++d)
        if (k[d] == parts[d]) return;
      generations_[g + 1][at] = seen;
    });
  }

  /// A larger cell beside one that is divided takes over its curvature, as that of a fold: in proportion to its side.
  /// So a valley that is narrower than the cells is followed along. True if any cell learns something.
  bool take_over_roughness() {
    bool learned = false;
    for (const Open& c : open_)
      for (std::size_t d = 0; d < dims_; ++d)
        for (const bool up : {false, true}) {
          if (c.generation == 0) continue;
          Place beside = c.low;
          if (up ? beside[d] + sizes_[c.generation][d] >= last_[d] : beside[d] == 0) continue;
          beside[d] = up ? beside[d] + sizes_[c.generation][d] : beside[d] - sizes_[c.generation][d];
          std::size_t g = c.generation;
          while (!generations_[g].contains(beside)) {
            --g;
            for (std::size_t e = 0; e < dims_; ++e) beside[e] -= beside[e] % sizes_[g][e];
          }
          if (g == c.generation) continue;
          Curvature& told = told_.try_emplace({g, beside}, Curvature(dims_, 0)).first->second;
          for (std::size_t e = 0; e < dims_; ++e) {
            const double larger =
                c.curvature[e] * static_cast<double>(sizes_[g][e]) / static_cast<double>(sizes_[c.generation][e]);
            if (!(larger > told[e])) continue;
            told[e] = larger;
            learned = true;
          }
        }
    return learned;
  }

  // Of a fold between two nodes a quarter of the second difference may be missed, twice what an arc's chord misses.
  // The other was chosen on one map (docs/cluster.md).
  static constexpr double kDoubt = 2, kSure = 6;

  const Cells& cells_;
  const std::map<std::vector<double>, double>& known_;
  std::size_t dims_;
  bool only_sides_ = false;                    // there are no distances, of which a curvature could be told
  std::vector<Place> sizes_ = {Place(dims_)};  // [generation] sides of its cells, on the finest grid
  Place last_ = Place(dims_);                  // index of the last node
  std::map<Place, Curvature> first_;
  std::vector<std::map<Place, Curvature>> generations_;  // [generation] cells by their lowest node
  std::map<std::pair<std::size_t, Place>, Curvature> told_;
  std::map<Place, double> values_;
  std::set<Place> inferred_;
  std::vector<Open> open_;
};

}  // namespace

NextPoints next_points(const std::vector<std::string>& axes, const std::map<std::string, std::vector<double>>& grid,
                       double cell, const std::map<std::vector<double>, double>& distance) {
  const Cells cells(axes, grid, cell);
  Follower follower(cells, distance);
  follower.follow();
  NextPoints out;
  out.crossed = follower.crossed;
  for (const std::vector<double>& values : follower.wanted) {
    std::map<std::string, double> point;
    for (std::size_t d = 0; d < axes.size(); ++d) point[axes[d]] = values[d];
    out.points.push_back(std::move(point));
  }
  return out;
}

namespace {

const store::Column& column_or_fail(const store::Table& t, const std::string& name, const config::RefineRule& rule) {
  if (const store::Column* c = t.find_column(name)) return *c;
  std::vector<std::string> names;
  for (const store::Column& c : t.columns) names.push_back(c.name);
  throw InputError(fmt::format("{}: refine: table {} has no column {}; it has {}{}", rule.place, t.name, name,
                               fmt::join(names, ", "), config::suggestion(name, names)));
}

std::string cell_text(const store::Column& c, std::size_t row) {
  if (const auto* words = std::get_if<std::vector<std::string>>(&c.values)) return (*words)[row];
  if (const auto* x = std::get_if<std::vector<double>>(&c.values)) return config::format_number((*x)[row]);
  return fmt::format("{}", std::get<std::vector<std::int64_t>>(c.values)[row]);
}

/// A cell of a CSV file that reads back as this text.
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"") == std::string::npos && text.find_first_of(" \t#") != 0) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i > 0 ? "," : "") + csv_cell(cells[i]);
  return line + "\n";
}

/// True of a point of the first round.
bool is_in_grid(const std::vector<double>& at, const config::RefineRule& rule) {
  for (std::size_t d = 0; d < at.size(); ++d) {
    const std::vector<double>& values = rule.grid.at(rule.axes[d]);
    if (!std::binary_search(values.begin(), values.end(), at[d])) return false;
  }
  return true;
}

/// Distance from the level, in (-1, 1): a share of value and level, so that a ratio of 10 and one of 20 are about as
/// far from 1. `scale` stands for a level of 0.
double distance_from_level(double value, double level, double scale) {
  if (std::isinf(value)) return value > 0 ? 1 : -1;
  const double width = std::abs(value) + (level != 0 ? std::abs(level) : scale);
  return width > 0 ? (value - level) / width : 0;
}

}  // namespace

NextRound next_round(const store::Result& result, const std::string& label, const std::string& file) {
  config::RefineRule rule = config::refine_rule_of(result.provenance.config, label);
  const auto named = std::find_if(result.tables.begin(), result.tables.end(),
                                  [&](const store::Table& t) { return t.name == rule.table; });
  if (named == result.tables.end()) {
    std::vector<std::string> names;
    for (const store::Table& t : result.tables) names.push_back(t.name);
    throw InputError(fmt::format("{}: refine.quantity: the result has no table {}{}", rule.place, rule.table,
                                 config::suggestion(rule.table, names)));
  }
  const store::Table held = store::rows_of(*named, 0, named->rows());
  const store::Column& value = column_or_fail(held, rule.column, rule);
  if (rule.verdict.empty() && std::holds_alternative<std::vector<std::string>>(value.values))
    throw InputError(fmt::format("{}: refine.quantity: {} is text: give verdict, not level", rule.place, rule.column));
  std::vector<const store::Column*> keys;
  std::vector<std::string> numeric;
  for (const store::Column& c : held.columns) {
    if (c.long_name != "sweep key") continue;
    keys.push_back(&c);
    if (c.name == "case") throw InputError(fmt::format("{}: a sweep with cases is not refined: run them apart", label));
    if (std::holds_alternative<std::vector<double>>(c.values)) numeric.push_back(c.name);
  }
  if (rule.axes.empty()) rule.axes = numeric;
  std::sort(rule.axes.begin(), rule.axes.end());
  for (const std::string& axis : rule.axes)
    if (std::find(numeric.begin(), numeric.end(), axis) == numeric.end())
      throw InputError(fmt::format("{}: refine.axes: {} is no numeric key of the sweep", rule.place, axis));
  if (rule.axes.empty()) throw InputError(fmt::format("{}: the sweep has no numeric key to refine", label));

  // Slices: rows with the same values of the other keys
  std::map<std::vector<std::string>, std::map<std::vector<double>, double>> slices;
  std::map<std::string, std::set<double>> seen;
  std::vector<double> sizes;  // of a quantity in the first grid
  for (std::size_t row = 0; row < held.rows(); ++row) {
    if (!std::all_of(rule.where.begin(), rule.where.end(),
                     [&](const auto& w) { return cell_text(column_or_fail(held, w.first, rule), row) == w.second; }))
      continue;
    std::vector<std::string> slice;
    std::vector<double> at;
    for (const store::Column* c : keys) {
      if (std::find(rule.axes.begin(), rule.axes.end(), c->name) == rule.axes.end()) {
        slice.push_back(cell_text(*c, row));
        continue;
      }
      at.push_back(std::get<std::vector<double>>(c->values)[row]);
      seen[c->name].insert(at.back());
    }
    const double here = rule.verdict.empty()                    ? held.number(rule.column, row)
                        : cell_text(value, row) == rule.verdict ? 1
                                                                : -1;
    if (!slices[slice].emplace(at, here).second)
      throw InputError(fmt::format("{}: refine.quantity: a point has several rows in table {}: choose one by where",
                                   rule.place, rule.table));
  }
  if (slices.empty()) throw InputError(fmt::format("{}: refine.where: no row of {} has it", rule.place, rule.table));
  for (const std::string& axis : rule.axes) {
    if (!rule.grid.contains(axis)) rule.grid[axis] = {seen[axis].begin(), seen[axis].end()};
    if (rule.grid[axis].size() < 2)
      throw InputError(fmt::format("{}: refine: {} has a single value: nothing lies between", rule.place, axis));
  }

  if (rule.verdict.empty()) {
    for (const auto& [slice, points] : slices)
      for (const auto& [at, v] : points)
        if (std::isfinite(v) && is_in_grid(at, rule)) sizes.push_back(std::abs(v));
    const double scale = stats::median(std::move(sizes));
    for (auto& [slice, points] : slices)
      for (auto& [at, v] : points) v = distance_from_level(v, rule.level, scale);
  }

  NextRound next;
  std::vector<std::string> names;
  for (const store::Column* c : keys) names.push_back(c->name);
  next.points = csv_line(names);
  for (const auto& [slice, distance] : slices) {
    const NextPoints more = next_points(rule.axes, rule.grid, rule.cell, distance);
    next.crossed += more.crossed;
    for (const std::map<std::string, double>& p : more.points) {
      std::vector<std::string> cells;
      std::size_t other = 0;
      for (const store::Column* c : keys) {
        const auto at = p.find(c->name);
        cells.push_back(at != p.end() ? config::format_number(at->second) : slice[other++]);
      }
      next.points += csv_line(cells);
      ++next.count;
    }
  }
  next.config = config::text_with_points(result.provenance.config, label, file, rule.grid);
  return next;
}

namespace {

/// Adds the values of a round's maps, which are in order of its points, to those of the rounds before. `own`: how many
/// axes are of its sweep, which `points` takes the place of.
void add_maps_of_round(std::vector<store::Map>& all, std::vector<store::Map>&& maps, std::size_t own,
                       const std::vector<store::Axis>& points, const std::string& label) {
  for (store::Map& m : maps) {
    m.axes.erase(m.axes.begin(), m.axes.begin() + static_cast<std::ptrdiff_t>(own));
    m.axes.insert(m.axes.begin(), points.begin(), points.end());
    const auto same = std::find_if(all.begin(), all.end(), [&](const store::Map& o) { return o.name == m.name; });
    if (same == all.end()) {
      all.push_back(std::move(m));
      continue;
    }
    study::drop_varying_axes(*same, points.size(), m, points.size());
    const auto alike = [](const store::Axis& a, const store::Axis& b) {
      return a.name == b.name && a.values == b.values;
    };
    require(std::equal(m.axes.begin(), m.axes.end(), same->axes.begin(), same->axes.end(), alike),
            "{}: the map {} has other axes", label, m.name);
    if (same->unit != m.unit) same->unit = "mixed";
    same->values.insert(same->values.end(), m.values.begin(), m.values.end());
  }
}

bool same_contents(const config::InputTable& a, const config::InputTable& b) {
  return a.names == b.names && a.columns == b.columns;
}
bool same_contents(const config::InputText& a, const config::InputText& b) { return a.text == b.text; }
bool same_contents(const config::InputReference& a, const config::InputReference& b) { return a.hash == b.hash; }

/// Adds the files of a round to those of the others, but for its table of points. A file of one name must be the same.
template <class File>
void add_files_of_round(std::vector<File>& all, const std::vector<File>& more, const std::string& points,
                        const std::string& label, const std::string& first) {
  for (const File& f : more) {
    if (f.path == points) continue;
    const auto same = std::find_if(all.begin(), all.end(), [&](const File& known) { return known.path == f.path; });
    if (same == all.end())
      all.push_back(f);
    else
      require(same_contents(*same, f), "{}: is no round of the sweep of {}: {} had other contents; run the round again",
              label, first, f.path);
  }
}

}  // namespace

store::Result merged_rounds(const study::Experiment& experiment, std::vector<Round> rounds, const std::string& file,
                            const std::string& folder) {
  const Round& first = rounds.front();
  const std::string base = config::text_without_sweep(first.result.provenance.config, first.label);
  std::string csv, with_rule = first.result.provenance.config;
  std::set<std::string> lines;
  std::map<std::string, std::vector<double>> grid;
  std::vector<config::InputTable> tables;
  std::vector<config::InputText> texts;
  std::vector<config::InputReference> references;
  std::vector<std::size_t> axes_of_sweep;  // of each round
  for (const Round& r : rounds) {
    const std::string& text = r.result.provenance.config;
    require(r.result.streams.empty(), "{}: has maps that are too large to be merged", r.label);
    require(config::text_without_sweep(text, r.label) == base,
            "{}: is no round of the sweep of {}: their configs differ in more than [sweep] and [refine]", r.label,
            first.label);
    const config::Config c =
        config::Config::from_text(text, r.label, r.inputs.tables, r.inputs.texts, r.inputs.references, folder);
    axes_of_sweep.push_back(study::sweep_axes(c).size());
    for (std::size_t point = 0; point < c.point_count(); ++point) {
      std::vector<std::string> names, cells;
      for (const config::SweepValue& v : c.sweep_values(point)) {
        require(v.key != "case", "{}: a sweep with cases has no rounds", r.label);
        names.push_back(v.key);
        cells.push_back(std::holds_alternative<double>(v.value) ? config::format_number(std::get<double>(v.value))
                                                                : std::get<std::string>(v.value));
      }
      require(!names.empty(), "{}: has no [sweep]: only rounds of a sweep are merged", r.label);
      const std::string line = csv_line(cells), header = csv_line(names);
      if (csv.empty()) csv = header;
      require(csv.starts_with(header), "{}: sweeps other keys than {}", r.label, first.label);
      require(lines.insert(line).second, "{}: has the point {}, as an earlier file has", r.label,
              line.substr(0, line.size() - 1));
      csv += line;
    }
    add_files_of_round(tables, r.inputs.tables, c.sweep_file(), r.label, first.label);
    add_files_of_round(texts, r.inputs.texts, c.sweep_file(), r.label, first.label);
    add_files_of_round(references, r.inputs.references, c.sweep_file(), r.label, first.label);
    if (text.find("\n[refine") == std::string::npos) continue;  // a sweep that is not refined can be merged, too
    const config::RefineRule rule = config::refine_rule_of(text, r.label);
    if (!rule.grid.empty()) {  // the later rounds know the first grid
      grid = rule.grid;
      with_rule = text;
    }
  }
  if (grid.empty() && with_rule.find("\n[refine") != std::string::npos)
    throw InputError(
        fmt::format("{}: none of the files is of a later round: surveymc refine writes its config", first.label));
  texts.push_back({file, csv});
  const study::RunPlan run = study::read_run(
      experiment, config::Config::from_text(config::text_with_points(with_rule, first.label, file, grid), first.label,
                                            std::move(tables), std::move(texts), std::move(references), folder));
  store::Result all = study::result_without_tables(run);
  compare::WarningList warnings;
  const std::vector<store::Axis> points = study::sweep_axes(run.config);
  for (std::size_t i = 0; i < rounds.size(); ++i) {
    Round& r = rounds[i];
    const auto add = [&](std::vector<store::Table>& to, std::vector<store::Table>& from) {
      for (store::Table& t : from) {
        if (t.name == compare::kWarningsTable) {
          for (compare::Warning& w : compare::warnings_of(t)) warnings.add(std::move(w));
          continue;
        }
        // Of the rows of one round, or numbered there.
        if (t.name == compare::kAnswerTable || t.name == compare::kFamilyTable ||
            t.name == compare::kSensitivityTable || t.name == study::kPointTable)
          continue;
        const auto same = std::find_if(to.begin(), to.end(), [&](const store::Table& o) { return o.name == t.name; });
        if (same == to.end()) {
          to.push_back(std::move(t));
          continue;
        }
        require(same->columns.size() == t.columns.size(), "{}: fills the table {} with other columns", r.label, t.name);
        store::append_rows(*same, t);
      }
    };
    add(all.tables, r.result.tables);
    add(all.samples, r.result.samples);
    add_maps_of_round(all.maps, std::move(r.result.maps), axes_of_sweep[i], points, r.label);
  }
  for (const store::Map& m : all.maps)
    require(store::map_size(m) == m.values.size(), "{}: the map {} is not that of all rounds", first.label, m.name);
  if (!all.maps.empty()) {
    std::vector<store::Table> of_points;
    for (std::size_t i = 0; i < run.point_count(); ++i)
      of_points.push_back(study::with_sweep_columns(study::table_of_point(i), run.config.sweep_values(i)));
    for (std::size_t i = 1; i < of_points.size(); ++i) store::append_rows(of_points.front(), of_points[i]);
    all.tables.push_back(std::move(of_points.front()));
  }
  all.tables.push_back(warnings.table());
  // As a run of all points does; the points of a table have no sensitivity.
  if (run.is_family()) compare::apply_family(all.tables);
  study::add_answer(experiment, all);
  return all;
}

}  // namespace surveymc::sweep
