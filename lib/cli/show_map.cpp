#include "cli/show_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <fmt/format.h>

#include "base/units.h"
#include "cli/screen.h"
#include "render/json.h"
#include "render/text.h"

namespace surveymc::cli {
namespace {

std::size_t length(const store::Axis& axis) {
  return std::visit([](const auto& v) { return v.size(); }, axis.values);
}

void for_each_piece(const store::MapSource& source,
                    const std::function<void(std::size_t, const std::vector<double>&)>& use) {
  const std::size_t size = store::map_size(*source.map);
  for (std::size_t first = 0; first < size; first += store::kStreamPiece)
    use(first, source.values(first, std::min(store::kStreamPiece, size - first)));
}

/// Index on every axis of value number `at`.
std::vector<std::size_t> indices(const store::Map& map, std::size_t at) {
  std::vector<std::size_t> out(map.axes.size());
  for (std::size_t i = map.axes.size(); i-- > 0;) {
    out[i] = at % length(map.axes[i]);
    at /= length(map.axes[i]);
  }
  return out;
}

std::string coordinate(const store::Axis& axis, std::size_t i) {
  if (const auto* words = std::get_if<std::vector<std::string>>(&axis.values)) return render::printable((*words)[i]);
  return fmt::format("{:g}", std::get<std::vector<double>>(axis.values)[i]);
}

std::string place(const store::Map& map, std::size_t at) {
  const std::vector<std::size_t> index = indices(map, at);
  std::string out;
  for (std::size_t i = 0; i < index.size(); ++i)
    out += fmt::format("{}{} = {}", i > 0 ? ", " : "", render::printable(map.axes[i].name),
                       coordinate(map.axes[i], index[i]));
  return out;
}

std::string unit_text(const std::string& unit) {
  return unit.empty() || unit == "1" ? "" : fmt::format(" [{}]", render::printable(unit));
}

std::string axis_text(const store::Axis& axis) {
  const std::size_t n = length(axis);
  std::string out = fmt::format("  {}{}: {}", render::printable(axis.name), unit_text(axis.unit), counted(n, "value"));
  constexpr std::size_t kListed = 8;
  if (n > kListed) return out + fmt::format(", {} .. {}", coordinate(axis, 0), coordinate(axis, n - 1));
  for (std::size_t i = 0; i < n; ++i) out += (i > 0 ? ", " : ": ") + coordinate(axis, i);
  return out;
}

struct Range {
  double lowest = kInfinity, highest = -lowest;
  std::size_t lowest_at = 0, highest_at = 0, finite = 0, infinite = 0, missing = 0;
};

Range range_of(const store::MapSource& source) {
  Range r;
  for_each_piece(source, [&](std::size_t first, const std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double x = values[i];
      r.missing += std::isnan(x);
      r.infinite += std::isinf(x);
      if (!std::isfinite(x)) continue;
      ++r.finite;
      if (x < r.lowest) r.lowest = x, r.lowest_at = first + i;
      if (x > r.highest) r.highest = x, r.highest_at = first + i;
    }
  });
  return r;
}

/// Values first .. of a map as rows: a column an axis, and the value.
store::Table rows_of(const store::Map& map, std::size_t first, const std::vector<double>& values) {
  store::Table t{map.name, map.long_name, {}};
  std::size_t inner = store::map_size(map);
  for (const store::Axis& axis : map.axes) {
    inner /= length(axis);
    std::visit(
        [&](const auto& coordinates) {
          std::decay_t<decltype(coordinates)> column;
          for (std::size_t i = 0; i < values.size(); ++i)
            column.push_back(coordinates[(first + i) / inner % coordinates.size()]);
          t.columns.push_back({axis.name, axis.unit, axis.long_name, std::move(column)});
        },
        axis.values);
  }
  t.columns.push_back({map.name, map.unit, map.long_name, values});
  return t;
}

}  // namespace

std::string shape_text(const store::Map& map) {
  std::string out;
  for (const store::Axis& a : map.axes) out += (out.empty() ? "" : " x ") + fmt::format("{}", length(a));
  return out;
}

void print_map(const store::MapSource& source) {
  const store::Map& m = *source.map;
  fmt::print("{}{}: {}\n", render::printable(m.name), unit_text(m.unit), render::printable(m.long_name));
  for (const store::Axis& a : m.axes) fmt::print("{}\n", axis_text(a));
  const Range r = range_of(source);
  if (r.finite > 0)
    fmt::print("  smallest {:g} at {}\n  largest  {:g} at {}\n", r.lowest, place(m, r.lowest_at), r.highest,
               place(m, r.highest_at));
  fmt::print("  {} values: {} finite, {} infinite, {} missing\n", store::map_size(m), r.finite, r.infinite, r.missing);
}

void print_map_csv(const store::MapSource& source) {
  for_each_piece(source, [&](std::size_t first, const std::vector<double>& values) {
    print_csv(rows_of(*source.map, first, values), first == 0);
  });
}

void print_map_json(const store::MapSource& source) {
  fmt::print("{{{}, \"values\": [", render::map_members_json(*source.map));
  for_each_piece(source, [&](std::size_t first, const std::vector<double>& values) {
    std::string text;
    for (std::size_t i = 0; i < values.size(); ++i) text += (first + i > 0 ? "," : "") + render::json_number(values[i]);
    fmt::print("{}", text);
  });
  fmt::print("]}}");
}

}  // namespace surveymc::cli
