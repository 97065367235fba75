#pragma once
/// Tables and maps as JSON (RFC 8259, docs/results-format.md): a missing value (NaN) is null, infinities are the
/// strings "Infinity" and "-Infinity", which JavaScript's Number() and Python's float() read. Numbers have the fewest
/// digits that read back to the same bits.
#include <string>

#include "store/table.h"

namespace surveymc::render {

/// `text` in quotes, escaped. Bytes that are not UTF-8 become U+FFFD.
std::string json_string(const std::string& text);
std::string json_number(double x);

/// {"name", "long_name", "rows", "columns": [{"name", "unit", "long_name", "values": [...]}, ...]}; `unit` is "1" for a
/// pure number and "" for text. A column with an interval also has "ancillary": the names of its ends. `with_values`:
/// false leaves "values" out.
std::string to_json(const store::Table& table, bool with_values = true);
/// The same in pieces, of which none is a long table's whole.
void to_json(const store::Table& table, bool with_values, const std::function<void(const std::string& text)>& write);

/// All members of a map but its values: "name": ..., "unit", "long_name", "axes": [{"name", "unit", "long_name",
/// "values"}, ...], "shape": [...]; without the braces around them, because values may follow.
std::string map_members_json(const store::Map& map);

}  // namespace surveymc::render
