#include "render/json.h"

#include <cmath>

#include <fmt/format.h>

#include "render/text.h"
#include "store/stored_form.h"

namespace surveymc::render {
namespace {

std::string element(double x) { return json_number(x); }
std::string element(std::int64_t x) { return fmt::format("{}", x); }
std::string element(const std::string& x) { return json_string(x); }

/// Values with commas between them.
template <class Variant>
std::string elements(const Variant& values) {
  return std::visit(
      [](const auto& list) {
        std::string out;
        for (std::size_t i = 0; i < list.size(); ++i) {
          if (i > 0) out += ',';
          out += element(list[i]);
        }
        return out;
      },
      values);
}

std::string described(const std::string& name, const std::string& unit, const std::string& long_name) {
  return fmt::format("\"name\": {}, \"unit\": {}, \"long_name\": {}", json_string(name), json_string(unit),
                     json_string(long_name));
}

}  // namespace

std::string json_string(const std::string& text) {
  std::string quoted;
  for (const char c : store::canonical_text(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return '"' + escaped_controls(quoted) + '"';
}

std::string json_number(double x) {
  if (std::isnan(x)) return "null";
  if (std::isinf(x)) return x > 0 ? "\"Infinity\"" : "\"-Infinity\"";
  return fmt::format("{}", x);
}

void to_json(const store::Table& table, bool with_values, const std::function<void(const std::string&)>& write) {
  write(fmt::format("{{\"name\": {}, \"long_name\": {}, \"rows\": {}, \"columns\": [", json_string(table.name),
                    json_string(table.long_name), table.rows()));
  for (const store::Column& c : table.columns) {
    write(fmt::format("{}\n  {{{}", &c == &table.columns.front() ? "" : ",", described(c.name, c.unit, c.long_name)));
    if (!c.ancillary.empty()) write(", \"ancillary\": " + json_string(c.ancillary));
    if (with_values) {
      write(", \"values\": [");
      bool any = false;
      c.for_each_piece([&](const store::Values& piece) {
        const std::string text = elements(piece);
        if (any && !text.empty()) write(",");
        any = any || !text.empty();
        write(text);
      });
      write("]");
    }
    write("}");
  }
  write("]}");
}

std::string to_json(const store::Table& table, bool with_values) {
  std::string all;
  to_json(table, with_values, [&](const std::string& text) { all += text; });
  return all;
}

std::string map_members_json(const store::Map& map) {
  std::string axes, shape;
  for (const store::Axis& a : map.axes) {
    const std::string separator = axes.empty() ? "" : ", ";
    axes +=
        separator + fmt::format("{{{}, \"values\": [{}]}}", described(a.name, a.unit, a.long_name), elements(a.values));
    shape += separator + fmt::format("{}", std::visit([](const auto& v) { return v.size(); }, a.values));
  }
  return fmt::format("{}, \"shape\": [{}], \"axes\": [{}]", described(map.name, map.unit, map.long_name), shape, axes);
}

}  // namespace surveymc::render
