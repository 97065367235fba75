#pragma once
/// The keys of a sweep in a result: first columns of its tables, first axes of its maps.
#include <string>
#include <vector>

#include "config/config.h"
#include "store/result_file.h"

namespace surveymc::study {

/// The unit that a name ends in (`field.total_nT` -> "nT"); "1" if it ends in none that we know.
std::string unit_of_name(const std::string& name);

/// The table with these values as first columns, the same in every row. Without any: as it is.
store::Table with_sweep_columns(store::Table table, const std::vector<config::SweepValue>& sweep);

/// The first axes of every map of a sweep: its keys in column order with their values in order of the points; of a
/// design that is no product the number of the point.
/// "noise.scale = 1, estimator.name = msa"; "" without a sweep.
std::string point_in_words(const config::Config& config, std::size_t point);

std::vector<store::Axis> sweep_axes(const config::Config& config);
/// Name of the table that gives each point of such a design its keys.
inline constexpr const char* kPointTable = "sweep_points";
store::Table table_of_point(std::size_t point);
/// Takes from two maps of one name the axes of length one that only one of them has, or that differ: the sweep's keys
/// say what they did. `first`, `second`: how many axes are of the sweep.
void drop_varying_axes(store::Map& all, std::size_t first, store::Map& more, std::size_t second);

}  // namespace surveymc::study
