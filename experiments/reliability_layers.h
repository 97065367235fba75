#pragma once
/// The maps that a reliability_map can have, by name, each as a function of a range of grid points.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "reliability/reliability_grid.h"

namespace surveymc {

/// Names of all maps, in order: those of the kernel (reliability_grid.h), then those of one point at a time:
/// "max_correlation", "minimal_identifiable_error", "nonlinear_detectable_error_plus", "..._minus".
std::vector<std::string> layer_names();
/// One line for a reader.
std::string layer_meaning(const std::string& layer);
/// Unit for an observation.
std::string layer_unit(const std::string& layer, std::size_t observation);
/// True for the maps that take microseconds a point or more, and are held in memory.
bool is_slow_layer(const std::string& layer);

/// What they are computed from.
struct LayerModel {
  AdjustmentModel model;
  double lambda0 = 0, power = 0;
  std::shared_ptr<const ReliabilityMaps> maps;
};

/// Values of points first .. first + count - 1: [observation][layer][point].
std::vector<std::vector<std::vector<double>>> layer_values(const LayerModel& m,
                                                           const std::vector<std::size_t>& observations,
                                                           const std::vector<std::string>& layers, std::size_t first,
                                                           std::size_t count);

/// Attitude, dip and noise of a point.
struct GridPoint {
  double noise_scale, dip_deg, inclination_deg, toolface_deg, magnetic_azimuth_deg;
};
GridPoint grid_point(const ReliabilityGrid& grid, std::size_t point);

}  // namespace surveymc
