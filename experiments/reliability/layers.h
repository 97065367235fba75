#pragma once
/// The maps that a reliability_map can have, by name, each as a function of a range of grid points.
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "reliability/error_subject.h"
#include "reliability/reliability_grid.h"

namespace surveymc::studies::reliability {

/// What they are computed from.
struct LayerModel {
  surveymc::reliability::AdjustmentModel model;
  double lambda0 = 0, power = 0;
  std::array<double, 3> gross_error{};  ///< in mps2, nT and deg; NaN: not given
  std::shared_ptr<const surveymc::reliability::ReliabilityMaps> maps;
};

bool has_gross_error(const LayerModel& m);

/// Names of all maps of such an error, in order. One observation: those of the kernel (reliability_grid.h), those of
/// one point at a time ("max_correlation", ..., "nonlinear_detectable_error_minus"), and with a gross error its
/// responses
/// ("residual_gx_mps2", ..., "effect_azimuth_deg", ...). A combination: those of combination_layers.h.
std::vector<std::string> layer_names(const LayerModel& m, const ErrorSubject& subject);
/// Those that are made where the config names none.
std::vector<std::string> default_layers(const LayerModel& m, const ErrorSubject& subject);
/// One line for a reader.
std::string layer_meaning(const std::string& layer);
/// Unit for a subject.
std::string layer_unit(const std::string& layer, const ErrorSubject& subject);
/// True for the maps that take many microseconds a point, and are held in memory.
bool is_slow_layer(const std::string& layer);

/// Values of points first .. first + count - 1: [subject][layer][point]. Subjects are all combinations or none is.
std::vector<std::vector<std::vector<double>>> layer_values(const LayerModel& m,
                                                           const std::vector<ErrorSubject>& subjects,
                                                           const std::vector<std::string>& layers, std::size_t first,
                                                           std::size_t count);

/// Attitude, dip and noise of a point.
struct GridPoint {
  double noise_scale, dip_deg, inclination_deg, toolface_deg, magnetic_azimuth_deg;
};
GridPoint grid_point(const surveymc::reliability::ReliabilityGrid& grid, std::size_t point);
/// The model with dip and noise of a point.
surveymc::reliability::AdjustmentModel model_at(const LayerModel& m, const GridPoint& p);

}  // namespace surveymc::studies::reliability
