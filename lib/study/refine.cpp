#include "study/refine.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "base/error.h"

namespace surveymc::study {
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

/// Calls visit(place, k) for all places low + k size / parts, k = 0 .. parts, of every axis; `parts` is 1 or 2.
template <class Visit>
void for_each_node(const Place& low, const Place& size, const std::vector<unsigned>& parts, const Visit& visit) {
  Place k(low.size(), 0);
  for (;;) {
    Place at(low.size());
    for (std::size_t d = 0; d < low.size(); ++d) at[d] = low[d] + k[d] * (size[d] / parts[d]);
    visit(at, k);
    std::size_t d = low.size();
    while (d > 0 && k[d - 1] == parts[d - 1]) k[--d] = 0;
    if (d == 0) return;
    ++k[d - 1];
  }
}

}  // namespace

NextPoints next_points(const std::vector<std::string>& axes, const std::map<std::string, std::vector<double>>& grid,
                       double cell, const std::map<std::vector<double>, int>& side) {
  const Cells cells(axes, grid, cell);
  NextPoints out;
  std::set<std::vector<double>> wanted;
  struct Cell {
    Place low, size;
  };
  std::vector<Cell> open;
  Place first(cells.count(), 0), size(cells.count());
  std::vector<unsigned> ones(cells.count());
  for (std::size_t d = 0; d < cells.count(); ++d) {
    size[d] = cells.step(d);
    ones[d] = static_cast<unsigned>(cells.cells(d)) - 1;
  }
  {  // the cells of the first grid
    Place k(cells.count(), 0);
    for (;;) {
      Place low(cells.count());
      for (std::size_t d = 0; d < low.size(); ++d) low[d] = k[d] * size[d];
      open.push_back({low, size});
      std::size_t d = low.size();
      while (d > 0 && k[d - 1] == ones[d - 1]) k[--d] = 0;
      if (d == 0) break;
      ++k[d - 1];
    }
  }
  std::map<Place, int> inferred;
  const auto known_side = [&](const Place& at) {
    const auto known = side.find(cells.values(at));
    if (known != side.end()) return known->second;
    const auto guessed = inferred.find(at);
    return guessed == inferred.end() ? 0 : guessed->second;
  };
  // The side of all corners of the edge or face of which a node is the middle; 0 if they differ.
  const auto side_around = [&](const Place& at, const Place& k, const std::vector<unsigned>& parts,
                               const Place& sides) {
    int all = 0;
    for (std::size_t corner = 0; corner < std::size_t{1} << at.size(); ++corner) {
      Place place = at;
      bool is_corner = true;
      for (std::size_t d = 0; d < at.size(); ++d) {
        const bool upper = (corner >> d & 1) != 0, is_middle = parts[d] == 2 && k[d] == 1;
        if (!is_middle && upper) is_corner = false;  // this axis has no two ends here
        if (is_middle) place[d] = upper ? at[d] + sides[d] / 2 : at[d] - sides[d] / 2;
      }
      if (!is_corner || place == at) continue;
      const int here = known_side(place);
      if (here == 0 || (all != 0 && here != all)) return 0;
      all = here;
    }
    return all;
  };
  while (!open.empty()) {
    const Cell c = std::move(open.back());
    open.pop_back();
    std::vector<unsigned> parts(cells.count());
    bool divides = false;
    for (std::size_t d = 0; d < parts.size(); ++d) {
      parts[d] = c.size[d] > 1 ? 2 : 1;
      divides = divides || parts[d] == 2;
    }
    bool above = false, below = false;
    std::vector<std::pair<Place, Place>> nodes;  // and which of the cell's nodes they are
    for_each_node(c.low, c.size, parts, [&](const Place& at, const Place& k) {
      const int here = known_side(at);
      above = above || here > 0;
      below = below || here < 0;
      nodes.emplace_back(at, k);
    });
    if (!above || !below) continue;
    std::vector<std::vector<double>> unknown;
    for (const auto& [at, k] : nodes) {
      const std::vector<double> values = cells.values(at);
      bool is_middle = false;
      for (std::size_t d = 0; d < k.size(); ++d) is_middle = is_middle || (parts[d] == 2 && k[d] == 1);
      if (side.contains(values) || (!is_middle && inferred.contains(at))) continue;
      // In the middle of an edge or face whose corners are all on one side, a point is taken to be on that side, too.
      const int around = side_around(at, k, parts, c.size);
      if (around != 0)
        inferred[at] = around;
      else
        unknown.push_back(values);
    }
    if (!divides) {
      ++out.crossed;
    } else if (!unknown.empty()) {
      wanted.insert(unknown.begin(), unknown.end());
    } else {
      Place half = c.size;
      for (std::size_t d = 0; d < half.size(); ++d) half[d] /= parts[d];
      std::vector<unsigned> last(parts.size());
      for (std::size_t d = 0; d < parts.size(); ++d) last[d] = parts[d] - 1;
      Place k(half.size(), 0);
      for (;;) {
        Place low = c.low;
        for (std::size_t d = 0; d < low.size(); ++d) low[d] += k[d] * half[d];
        open.push_back({low, half});
        std::size_t d = low.size();
        while (d > 0 && k[d - 1] == last[d - 1]) k[--d] = 0;
        if (d == 0) break;
        ++k[d - 1];
      }
    }
  }
  for (const std::vector<double>& values : wanted) {
    std::map<std::string, double> point;
    for (std::size_t d = 0; d < axes.size(); ++d) point[axes[d]] = values[d];
    out.points.push_back(std::move(point));
  }
  return out;
}

namespace {

const store::Column* find_column(const store::Table& t, const std::string& name) {
  const auto it =
      std::find_if(t.columns.begin(), t.columns.end(), [&](const store::Column& c) { return c.name == name; });
  return it == t.columns.end() ? nullptr : &*it;
}

const store::Column& column_or_fail(const store::Table& t, const std::string& name, const config::RefineRule& rule) {
  if (const store::Column* c = find_column(t, name)) return *c;
  std::string names;
  for (const store::Column& c : t.columns) names += (names.empty() ? "" : ", ") + c.name;
  throw InputError(fmt::format("{}: refine: table {} has no column {}; it has {}", rule.place, t.name, name, names));
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

int side_of(const store::Column& c, std::size_t row, const config::RefineRule& rule) {
  if (!rule.verdict.empty()) return cell_text(c, row) == rule.verdict ? 1 : -1;
  const auto* x = std::get_if<std::vector<double>>(&c.values);
  const double value = x ? (*x)[row] : static_cast<double>(std::get<std::vector<std::int64_t>>(c.values)[row]);
  if (std::isnan(value)) return 0;
  return value >= rule.level ? 1 : -1;
}

}  // namespace

NextRound next_round(const store::Result& result, const std::string& label, const std::string& file) {
  config::RefineRule rule = config::refine_rule_of(result.provenance.config, label);
  const auto named = std::find_if(result.tables.begin(), result.tables.end(),
                                  [&](const store::Table& t) { return t.name == rule.table; });
  if (named == result.tables.end())
    throw InputError(fmt::format("{}: refine.quantity: the result has no table {}", rule.place, rule.table));
  const store::Table held = store::rows_of(*named, 0, named->rows());
  const store::Table* const table = &held;
  const store::Column& value = column_or_fail(*table, rule.column, rule);
  if (rule.verdict.empty() && std::holds_alternative<std::vector<std::string>>(value.values))
    throw InputError(fmt::format("{}: refine.quantity: {} is text: give verdict, not level", rule.place, rule.column));
  std::vector<const store::Column*> keys;
  std::vector<std::string> numeric;
  for (const store::Column& c : table->columns) {
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
  std::map<std::vector<std::string>, std::map<std::vector<double>, int>> slices;
  std::map<std::string, std::set<double>> seen;
  for (std::size_t row = 0; row < table->rows(); ++row) {
    if (!std::all_of(rule.where.begin(), rule.where.end(),
                     [&](const auto& w) { return cell_text(column_or_fail(*table, w.first, rule), row) == w.second; }))
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
    if (!slices[slice].emplace(at, side_of(value, row, rule)).second)
      throw InputError(fmt::format("{}: refine.quantity: a point has several rows in table {}: choose one by where",
                                   rule.place, rule.table));
  }
  if (slices.empty()) throw InputError(fmt::format("{}: refine.where: no row of {} has it", rule.place, rule.table));
  for (const std::string& axis : rule.axes) {
    if (!rule.grid.contains(axis)) rule.grid[axis] = {seen[axis].begin(), seen[axis].end()};
    if (rule.grid[axis].size() < 2)
      throw InputError(fmt::format("{}: refine: {} has a single value: nothing lies between", rule.place, axis));
  }

  NextRound next;
  std::vector<std::string> names;
  for (const store::Column* c : keys) names.push_back(c->name);
  next.points = csv_line(names);
  for (const auto& [slice, side] : slices) {
    const NextPoints more = next_points(rule.axes, rule.grid, rule.cell, side);
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

/// Adds the files of a round to those of the others, but for its table of points.
template <class File>
void add_files_of_round(std::vector<File>& all, const std::vector<File>& more, const std::string& points) {
  for (const File& f : more) {
    const auto same = std::find_if(all.begin(), all.end(), [&](const File& known) { return known.path == f.path; });
    if (f.path != points && same == all.end()) all.push_back(f);
  }
}

}  // namespace

store::Result merged_rounds(const Experiment& experiment, std::vector<Round> rounds, const std::string& file,
                            const std::string& folder) {
  const Round& first = rounds.front();
  const std::string base = config::text_without_sweep(first.result.provenance.config, first.label);
  std::string csv, with_rule = first.result.provenance.config;
  std::set<std::string> lines;
  std::map<std::string, std::vector<double>> grid;
  std::vector<config::InputTable> tables;
  std::vector<config::InputText> texts;
  std::vector<config::InputReference> references;
  for (const Round& r : rounds) {
    const std::string& text = r.result.provenance.config;
    require(r.result.maps.empty() && r.result.streams.empty(),
            "{}: has maps: rounds of a study with maps are not merged", r.label);
    require(config::text_without_sweep(text, r.label) == base,
            "{}: is no round of the sweep of {}: their configs differ in more than [sweep] and [refine]", r.label,
            first.label);
    const config::Config c = config::Config::from_text(text, r.label, r.tables, r.texts, r.references, folder);
    for (std::size_t point = 0; point < c.point_count(); ++point) {
      std::vector<std::string> names, cells;
      for (const config::SweepValue& v : c.sweep_values(point)) {
        require(v.key != "case", "{}: a sweep with cases has no rounds", r.label);
        names.push_back(v.key);
        cells.push_back(std::holds_alternative<double>(v.value) ? config::format_number(std::get<double>(v.value))
                                                                : std::get<std::string>(v.value));
      }
      const std::string line = csv_line(cells), header = csv_line(names);
      if (csv.empty()) csv = header;
      require(csv.starts_with(header), "{}: sweeps other keys than {}", r.label, first.label);
      require(lines.insert(line).second, "{}: has the point {}, as an earlier file has", r.label,
              line.substr(0, line.size() - 1));
      csv += line;
    }
    add_files_of_round(tables, r.tables, c.sweep_file());
    add_files_of_round(texts, r.texts, c.sweep_file());
    add_files_of_round(references, r.references, c.sweep_file());
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
  const RunPlan run = read_run(
      experiment, config::Config::from_text(config::text_with_points(with_rule, first.label, file, grid), first.label,
                                            std::move(tables), std::move(texts), std::move(references), folder));
  store::Result all = result_without_tables(run);
  for (Round& r : rounds) {
    const auto add = [&](std::vector<store::Table>& to, std::vector<store::Table>& from) {
      for (store::Table& t : from) {
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
  }
  return all;
}

}  // namespace surveymc::study
