#pragma once
/// The form in which values and names are stored, shared by the hash, the writer and the reader: that which HDF5 and
/// netCDF can hold. The hash is taken of the stored form, so that the hash of a result that was read back equals the
/// stored one.
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/units.h"
#include "store/table.h"

namespace surveymc::store {

static_assert(std::endian::native == std::endian::little, "hashes and native HDF5 types assume little endian");

inline constexpr const char* kFormat = "surveymc";
inline constexpr std::int64_t kFormatVersion = 1;
inline constexpr const char* kCost = "cost";                   // table in the group run
inline constexpr const char* kRow = "row";                     // dimension scale of every table
inline constexpr const char* kOriginalName = "original_name";  // where the link had to be named otherwise

/// All NaNs are one missing value.
inline double canonical_number(double x) { return std::isnan(x) ? kNaN : x; }
/// True if canonical_number() changes none of them.
bool are_canonical(std::span<const double> values);
/// Calls use(piece) with all values in order, each canonical_number(), in pieces that stay in the caches meanwhile.
void in_canonical_pieces(std::span<const double> values, const std::function<void(std::span<const double>)>& use);

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
