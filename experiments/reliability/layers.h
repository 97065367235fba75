#pragma once
/// The maps that a reliability_map can have, by name, each as a function of a range of grid points.
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/units.h"
#include "reliability/error_subject.h"
#include "reliability/reliability_grid.h"

namespace surveymc::studies::reliability {

/// The inputs from which the maps are computed.
struct LayerModel {
  AdjustmentModel model;
  double lambda0 = 0, power = 0;
  std::array<double, 3> gross_error{};  ///< in mps2, nT and deg; NaN: not given
  std::shared_ptr<const ReliabilityMaps> maps;
};

bool has_gross_error(const LayerModel& m);

/// Names of all maps of such an error, in order. For one observation: those of the kernel (reliability_grid.h), those
/// that are computed point by point ("max_correlation", ..., "nonlinear_detectable_error_minus"), and with a gross
/// error its responses ("residual_gx_mps2", ..., "effect_azimuth_deg", ...). For a combination: those of
/// combination_layers() in responses.h.
std::vector<std::string> layer_names(const LayerModel& m, const ErrorSubject& subject);
/// The maps that are made where the config names none.
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

  survey::Attitude attitude() const {
    return {inclination_deg * kDegree, magnetic_azimuth_deg * kDegree, toolface_deg * kDegree};
  }
};
GridPoint grid_point(const ReliabilityGrid& grid, std::size_t point);
/// The model with dip and noise of a point.
AdjustmentModel model_at(const LayerModel& m, const GridPoint& p);

}  // namespace surveymc::studies::reliability
