#pragma once
/// Reliability over a grid of attitudes: the values of a reliability map (sections 3 and 5 of the paper).
#include <array>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "reliability/observations.h"
#include "reliability/station_lanes.h"

namespace surveymc::reliability {

/// Quantities of an observation that a map can show, in the units of tables. External reliability: the effect of an
/// error of +1 minimal detectable error on a parameter, (X'PX)^-1 X'P c_i nabla_0, with its sign.
enum class MapQuantity : std::size_t {
  redundancy_number,         ///< r_i, eq 21
  minimal_detectable_error,  ///< nabla_0, eq 19; mps2, nT or deg, as the observation
  external_inclination,      ///< deg
  external_toolface,         ///< deg
  external_azimuth,          ///< deg
  external_gravity,          ///< mps2; 0 where references are free of error
  external_total_field,      ///< nT
  external_dip               ///< deg
};
constexpr std::size_t index_of(MapQuantity q) { return static_cast<std::size_t>(q); }

/// Name of a map: "redundancy_number", "external_azimuth_deg", ...
const std::array<std::string, kMapQuantities>& map_quantity_names();
/// Unit of a quantity of an observation: "1", "mps2", "nT" or "deg".
std::string map_quantity_unit(std::size_t quantity, std::size_t observation);

/// Points are the product of these lists, the last one fastest. Angles are in degrees, so that right angles are exact:
/// a sine of 1e-16 for 180 degrees would give a finite value where there is none. The other stations of mse_shared are
/// at the attitude of the point.
struct ReliabilityGrid {
  std::vector<double> noise_scale{1};  ///< factor on the sd of the noise
  std::vector<double> dip_deg, inclination_deg, toolface_deg, magnetic_azimuth_deg;

  std::size_t points() const;
};

/// Values of maps as the kernel writes them: a column for every quantity of every observation. A column begins a line
/// of memory, as stores across two lines take twice the time, and no two begin at the same place of a page, where they
/// would drive each other from the cache.
class MapValues {
 public:
  /// Keeps the memory where it is large enough; values are then without meaning.
  void resize(std::size_t observations, std::size_t quantities, std::size_t points);
  std::size_t points() const { return points_; }
  double* column(std::size_t observation, std::size_t quantity) {
    return memory_.get() + (observation * quantities_ + quantity) * stride_;
  }
  const double* column(std::size_t observation, std::size_t quantity) const {
    return memory_.get() + (observation * quantities_ + quantity) * stride_;
  }

 private:
  struct Free {
    void operator()(double* p) const { std::free(p); }
  };
  std::unique_ptr<double[], Free> memory_;
  std::size_t room_ = 0, quantities_ = 0, points_ = 0, stride_ = 0;
};

/// {sin, cos} of an angle in degrees, exact at multiples of 90.
std::pair<double, double> sincos_degrees(double degrees);

/// Values are infinite where an observation is not controlled (r < 1e-10, which counts as 0). An external reliability
/// is also infinite where the parameter has no value (toolface and azimuth of a vertical hole, azimuth without bz in a
/// horizontal hole to the east or west), unless the error has no effect on the parameter. Never NaN. The inclination of
/// a vertical hole changes by the tilt to any side: from 0 upwards, from 180 degrees downwards.
class ReliabilityMaps {
 public:
  ReliabilityMaps(const AdjustmentModel& model, ReliabilityGrid grid, double lambda0);

  const ReliabilityGrid& grid() const { return grid_; }

  /// Values of points first .. first + count - 1 for the observations whose numbers are in `which`, and `quantities`:
  /// [i of which][j of quantities][point]. Throws std::invalid_argument for one that the model does not observe.
  std::vector<std::vector<std::vector<double>>> values(const std::vector<std::size_t>& which,
                                                       const std::vector<MapQuantity>& quantities, std::size_t first,
                                                       std::size_t count) const;
  /// The same, the same bits, into `out` in less than half the time.
  void fill(const std::vector<std::size_t>& which, const std::vector<MapQuantity>& quantities, std::size_t first,
            std::size_t count, MapValues& out) const;

 private:
  void check(const std::vector<std::size_t>& which) const;
  /// column(i of which, j of quantities): room for whole groups.
  void compute(const std::vector<std::size_t>& which, const std::vector<MapQuantity>& quantities, std::size_t first,
               std::size_t count, bool long_columns,
               const std::function<double*(std::size_t, std::size_t)>& column) const;
  void fill_points(std::size_t first, std::size_t count, std::vector<double>* columns) const;

  struct Sines {
    std::vector<double> sin, cos;
  };
  AdjustmentModel model_;
  ReliabilityGrid grid_;
  std::array<Sines, 4> sines_;  ///< of inclination, toolface, azimuth, dip
  StationKernel kernel_;
  StationVariances variances_;
};

/// All observations at one attitude (magnetic azimuth), by the same arithmetic on one scalar, in internal units (m/s2,
/// nT, rad); unobserved ones are NaN throughout. Tests compare with readable least squares by the 9 x 6 design matrix.
std::array<ObservationReliability<double>, kObservations> station_reliability(const AdjustmentModel& model,
                                                                              const survey::Attitude& at,
                                                                              double lambda0);

}  // namespace surveymc::reliability
