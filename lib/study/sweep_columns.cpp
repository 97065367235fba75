#include "study/sweep_columns.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include <fmt/format.h>

namespace surveymc::study {

std::string unit_of_name(const std::string& name) {
  const std::string suffix = name.substr(name.rfind('_') + 1);  // all of it without an underscore
  for (const char* unit : {"m", "ft", "deg", "nT", "uT", "mps2", "mg", "s"})
    if (suffix == unit && suffix.size() < name.size()) return suffix;
  return "1";
}

namespace {

/// Column with the sweep value `value` on `rows` rows.
store::Column sweep_column(const config::SweepValue& value, std::size_t rows) {
  if (const double* number = std::get_if<double>(&value.value))
    return {value.key, unit_of_name(value.key), store::kSweepKey, std::vector<double>(rows, *number)};
  return {value.key, "", store::kSweepKey, std::vector<std::string>(rows, std::get<std::string>(value.value))};
}

}  // namespace

store::Table with_sweep_columns(store::Table t, const std::vector<config::SweepValue>& sweep) {
  if (sweep.empty()) return t;
  const auto with_keys = [&sweep](store::Table part) {
    std::vector<store::Column> columns;
    for (const config::SweepValue& v : sweep) columns.push_back(sweep_column(v, part.rows()));
    std::move(part.columns.begin(), part.columns.end(), std::back_inserter(columns));
    part.columns = std::move(columns);
    return part;
  };
  if (t.is_held()) return with_keys(std::move(t));
  store::Table all;
  store::for_each_piece(t, [&](const store::Table& piece, std::size_t) { store::append_rows(all, with_keys(piece)); });
  return all;
}

std::string point_in_words(const config::Config& config, std::size_t point) {
  std::string out;
  for (const config::SweepValue& v : config.sweep_values(point)) {
    const double* number = std::get_if<double>(&v.value);
    out += fmt::format("{}{} = {}", out.empty() ? "" : ", ", v.key,
                       number ? config::format_number(*number) : std::get<std::string>(v.value));
  }
  return out;
}

std::vector<store::Axis> sweep_axes(const config::Config& config) {
  std::vector<store::Axis> axes;
  const std::optional<std::vector<config::SweepDimension>> product = config.sweep_product();
  if (!product) {
    std::vector<double> numbers(config.point_count());
    std::iota(numbers.begin(), numbers.end(), 0.0);
    return {{"point", "1", "number of the point of the sweep", std::move(numbers)}};
  }
  for (const config::SweepDimension& d : *product) {
    const bool number = std::holds_alternative<std::vector<double>>(d.values);
    axes.push_back({d.key, number ? unit_of_name(d.key) : "", store::kSweepKey, d.values});
  }
  return axes;
}

store::Table table_of_point(std::size_t point) {
  return {kPointTable,
          "values of the sweep's keys at each point",
          {{"point", "1", "number of the point", std::vector<std::int64_t>{static_cast<std::int64_t>(point)}}}};
}

void drop_varying_axes(store::Map& all, std::size_t first, store::Map& more, std::size_t second) {
  const auto drop = [](store::Map& from, std::size_t own, const store::Map& other) {
    const auto varies = [&](const store::Axis& a) {
      const bool is_single = std::visit([](const auto& values) { return values.size() == 1; }, a.values);
      const auto alike = [&](const store::Axis& b) { return b.name == a.name && b.values == a.values; };
      return is_single && std::none_of(other.axes.begin(), other.axes.end(), alike);
    };
    from.axes.erase(std::remove_if(from.axes.begin() + static_cast<std::ptrdiff_t>(own), from.axes.end(), varies),
                    from.axes.end());
  };
  const store::Map before = {"", "", "", all.axes, {}};
  drop(all, first, more);
  drop(more, second, before);
}

}  // namespace surveymc::study
