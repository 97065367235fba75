#pragma once
/// The form in which values and names are stored, shared by the hash, the writer and the reader: that which HDF5 and
/// netCDF can hold. The hash is taken of the stored form, so that the hash of a result that was read back equals the
/// stored one.
#include <bit>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "store/table.h"

namespace surveymc::store {

static_assert(std::endian::native == std::endian::little, "hashes and native HDF5 types assume little endian");

inline constexpr const char* kFormat = "surveymc";
inline constexpr std::int64_t kFormatVersion = 1;
inline constexpr const char* kCost = "cost";                   // table in the group run
inline constexpr const char* kRow = "row";                     // dimension scale of every table
inline constexpr const char* kOriginalName = "original_name";  // where the link had to be named otherwise

/// Calls use(piece) with numbers in pieces that stay in the caches meanwhile. All NaNs are one missing value: others
/// become kNaN.
void for_each_stored(std::span<const double> values, const std::function<void(std::span<const double>)>& use);

/// The same for a list of any type; counts and texts come as they are, all at once.
template <class T, class Use>
void for_each_stored(const std::vector<T>& values, const Use& use) {
  if constexpr (std::is_same_v<T, double>)
    for_each_stored(std::span(values), std::function<void(std::span<const double>)>(std::ref(use)));
  else if (!values.empty())
    use(std::span(values));
}
/// The same for all values of a column, held or not.
template <class Use>
void for_each_stored(const Column& column, const Use& use) {
  column.for_each_piece(
      [&](const Values& piece) { std::visit([&](const auto& values) { for_each_stored(values, use); }, piece); });
}

/// Every byte that is not UTF-8 (a header line in Latin-1) becomes U+FFFD: Python readers refuse the file otherwise.
/// So does NUL, which would end a string in HDF5.
std::string canonical_text(const std::string& text);
/// True if canonical_text() does not change it.
bool is_canonical(const std::string& text);

/// `name` in a form that HDF5 and netCDF can store in a group with the links `taken`; adds it to `taken`. Users' column
/// names ("Inc/deg", "row", "") make this necessary. A name that can be stored does not change.
std::string link_name(const std::string& name, std::set<std::string>& taken);

/// Group of an input file: its stem, reduced to what every tool accepts, as a link_name().
std::string input_group_name(const std::string& path, std::set<std::string>& taken);

std::size_t axis_size(const Axis& axis);

}  // namespace surveymc::store
