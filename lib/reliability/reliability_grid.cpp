#include "reliability/reliability_grid.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>

#include "base/huge_pages.h"
#include "base/units.h"
#include "simd/instruction_set.h"

namespace surveymc::reliability {
namespace {

double squared(double x) { return x * x; }

StationVariances relative_variances(const AdjustmentModel& model, double lambda0) {
  const SigmaModel& s = model.sigma;
  const double g = model.field.gravity, b = model.field.total;
  return {
      squared(s.accelerometer_noise / g),  squared(s.accelerometer_bias / g),
      squared(s.accelerometer_scale),      squared(s.magnetometer_noise / b),
      squared(s.magnetometer_bias / b),    (squared(s.magnetometer_bias) + squared(s.axial_interference)) / squared(b),
      squared(s.magnetometer_scale),       squared(s.gravity / g),
      squared(s.total_field / b),          squared(s.dip),
      static_cast<double>(model.stations), lambda0};
}

/// Without systematic terms, kernels stand in the order of the modes.
static_assert(static_cast<int>(StationKernel::sse_axial) == static_cast<int>(AdjustmentMode::sse_axial) &&
              static_cast<int>(StationKernel::mse_fixed) == static_cast<int>(AdjustmentMode::mse_fixed) &&
              static_cast<int>(StationKernel::mse_shared) == static_cast<int>(AdjustmentMode::mse_shared));
StationKernel kernel_of(const AdjustmentModel& model) {
  const bool systematic = model.mode == AdjustmentMode::mse_shared && model.systematic_terms;
  return systematic ? StationKernel::mse_systematic : static_cast<StationKernel>(model.mode);
}

/// From the kernel's relative units and radians to internal ones, for the error of one observation.
double internal_unit(std::size_t quantity, std::size_t observation, const survey::ReferenceField& field) {
  switch (static_cast<MapQuantity>(quantity)) {
    case MapQuantity::minimal_detectable_error:
      return relative_unit(observation, field);
    case MapQuantity::external_gravity:
      return field.gravity;
    case MapQuantity::external_total_field:
      return field.total;
    default:
      return 1;
  }
}

double degrees_of(std::size_t quantity, std::size_t observation) {
  return map_quantity_unit(quantity, observation) == "deg" ? 1 / kDegree : 1;
}

}  // namespace

const std::array<std::string, kMapQuantities>& map_quantity_names() {
  static const std::array<std::string, kMapQuantities> names{
      "redundancy_number",    "minimal_detectable_error", "external_inclination_deg", "external_toolface_deg",
      "external_azimuth_deg", "external_gravity_mps2",    "external_total_field_nT",  "external_dip_deg"};
  return names;
}

std::string map_quantity_unit(std::size_t quantity, std::size_t observation) {
  constexpr std::array<const char*, kMapQuantities> kUnits{"1", "", "deg", "deg", "deg", "mps2", "nT", "deg"};
  const bool is_of_observation = quantity == index_of(MapQuantity::minimal_detectable_error);
  return is_of_observation ? observation_unit(observation) : kUnits[quantity];
}

std::size_t ReliabilityGrid::points() const {
  return noise_scale.size() * dip_deg.size() * inclination_deg.size() * toolface_deg.size() *
         magnetic_azimuth_deg.size();
}

std::pair<double, double> sincos_degrees(double degrees) {
  int quarters = 0;
  const double rest = std::remquo(degrees, 90.0, &quarters) * kDegree;  // remquo is exact
  const double s = std::sin(rest), c = std::cos(rest);
  const std::array<std::pair<double, double>, 4> by_quarters{{{s, c}, {c, -s}, {-s, -c}, {-c, s}}};
  return by_quarters[static_cast<std::size_t>(quarters & 3)];
}

ReliabilityMaps::ReliabilityMaps(const AdjustmentModel& model, ReliabilityGrid grid, double lambda0)
    : model_(model), grid_(std::move(grid)), kernel_(kernel_of(model)), variances_(relative_variances(model, lambda0)) {
  const std::array<const std::vector<double>*, 4> axes{&grid_.inclination_deg, &grid_.toolface_deg,
                                                       &grid_.magnetic_azimuth_deg, &grid_.dip_deg};
  for (std::size_t a = 0; a < axes.size(); ++a)
    for (const double x : *axes[a]) {
      const auto [s, c] = sincos_degrees(x);
      sines_[a].sin.push_back(s);
      sines_[a].cos.push_back(c);
    }
}

void ReliabilityMaps::fill_points(std::size_t first, std::size_t count, std::vector<double>* columns) const {
  const std::size_t azimuths = sines_[2].sin.size(), toolfaces = sines_[1].sin.size(),
                    inclinations = sines_[0].sin.size(), dips = sines_[3].sin.size();
  for (std::size_t p = 0; p < count;) {  // one run along the azimuths at a time
    std::size_t rest = (first + p) / azimuths;
    const std::size_t a = (first + p) % azimuths, run = std::min(azimuths - a, count - p);
    const std::size_t t = rest % toolfaces;
    rest /= toolfaces;
    const std::size_t i = rest % inclinations;
    rest /= inclinations;
    const std::size_t d = rest % dips;
    const double noise = grid_.noise_scale[rest / dips];
    const auto fill = [&](std::size_t column, double x) { std::fill_n(columns[column].data() + p, run, x); };
    const auto fill_both = [&](std::size_t column, const Sines& s, std::size_t at) {
      fill(column, s.sin[at]);
      fill(column + 1, s.cos[at]);
    };
    // What has one value in the whole grid stands there already (compute).
    if (inclinations > 1) fill_both(0, sines_[0], i);
    if (toolfaces > 1) fill_both(2, sines_[1], t);
    std::copy_n(sines_[2].sin.data() + a, run, columns[4].data() + p);
    std::copy_n(sines_[2].cos.data() + a, run, columns[5].data() + p);
    if (dips > 1) fill_both(6, sines_[3], d);
    if (grid_.noise_scale.size() > 1) fill(8, noise * noise);
    p += run;
  }
}

void MapValues::resize(std::size_t observations, std::size_t quantities, std::size_t points) {
  constexpr std::size_t kLine = simd::kGroup;  // doubles: the kernel writes whole groups
  quantities_ = quantities;
  points_ = points;
  stride_ = (((points + kLine - 1) / kLine) | 1) * kLine;  // an odd number of lines
  const std::size_t needed = observations * quantities * stride_;
  if (needed <= room_) return;
  // Every value of a point goes to another page: in small ones the stores wait for the addresses of pages.
  const std::size_t alignment = needed * sizeof(double) < kHugePage ? kLine * sizeof(double) : kHugePage;
  const std::size_t bytes = (needed * sizeof(double) + alignment - 1) / alignment * alignment;
  memory_.reset(static_cast<double*>(std::aligned_alloc(alignment, bytes)));
  if (!memory_) throw std::bad_alloc();
  prefer_huge_pages(memory_.get(), bytes);
  room_ = needed;
}

void ReliabilityMaps::check(const std::vector<std::size_t>& which) const {
  for (const std::size_t o : which)
    if (!is_observed(model_.mode, o)) throw std::invalid_argument(observation_names()[o] + " is not observed");
}

void ReliabilityMaps::compute(const std::vector<std::size_t>& which, const std::vector<MapQuantity>& quantities,
                              std::size_t first, std::size_t count, bool long_columns,
                              const std::function<double*(std::size_t, std::size_t)>& column) const {
  constexpr std::size_t kBlock = 512;  // points whose sines stay in the caches
  std::vector<double> columns[9];
  StationBatch batch{};
  batch.variances = variances_;
  batch.long_columns = long_columns;
  for (std::size_t k = 0; k < 9; ++k) {
    // Where a group has no point, the kernel computes with sines of harmless angles, and the results are not kept.
    const Sines* axis = k < 8 ? &sines_[k / 2] : nullptr;
    double everywhere = 0.6;
    if (axis && axis->sin.size() == 1) everywhere = k % 2 == 0 ? axis->sin[0] : axis->cos[0];
    if (!axis && grid_.noise_scale.size() == 1) everywhere = grid_.noise_scale[0] * grid_.noise_scale[0];
    columns[k].assign(kBlock, everywhere);
    batch.points[k] = columns[k].data();
  }
  for (const std::size_t o : which)
    for (const MapQuantity q : quantities) {
      const std::size_t quantity = index_of(q);
      batch.units[o][quantity] = internal_unit(quantity, o, model_.field) * degrees_of(quantity, o);
    }
  batch.angle_unit = 1 / kDegree;
  for (std::size_t at = 0; at < count; at += kBlock) {
    const std::size_t n = std::min(kBlock, count - at);
    fill_points(first + at, n, columns);
    for (std::size_t w = 0; w < which.size(); ++w)
      for (std::size_t q = 0; q < quantities.size(); ++q)
        batch.outputs[which[w]][index_of(quantities[q])] = column(w, q) + at;
    batch.groups = static_cast<int>((n + simd::kGroup - 1) / simd::kGroup);
    simd::run_kernel<isa_v3::station_batch, isa_v4::station_batch>(kernel_, batch);
  }
}

void ReliabilityMaps::fill(const std::vector<std::size_t>& which, const std::vector<MapQuantity>& quantities,
                           std::size_t first, std::size_t count, MapValues& out) const {
  check(which);
  out.resize(which.size(), quantities.size(), count);
  compute(which, quantities, first, count, true, [&](std::size_t w, std::size_t q) { return out.column(w, q); });
}

std::vector<std::vector<std::vector<double>>> ReliabilityMaps::values(const std::vector<std::size_t>& which,
                                                                      const std::vector<MapQuantity>& quantities,
                                                                      std::size_t first, std::size_t count) const {
  check(which);
  const std::size_t room = (count + simd::kGroup - 1) / simd::kGroup * simd::kGroup;
  std::vector<std::vector<std::vector<double>>> out(
      which.size(), std::vector<std::vector<double>>(quantities.size(), std::vector<double>(room)));
  compute(which, quantities, first, count, false, [&](std::size_t w, std::size_t q) { return out[w][q].data(); });
  for (auto& of_observation : out)
    for (auto& values : of_observation) values.resize(count);
  return out;
}

std::array<ObservationReliability<double>, kObservations> station_reliability(const AdjustmentModel& model,
                                                                              const survey::Attitude& at,
                                                                              double lambda0) {
  const StationSines<double> s{std::sin(at.inclination),  std::cos(at.inclination), std::sin(at.toolface),
                               std::cos(at.toolface),     std::sin(at.azimuth),     std::cos(at.azimuth),
                               std::sin(model.field.dip), std::cos(model.field.dip)};
  constexpr double nan = kNaN;
  std::array<ObservationReliability<double>, kObservations> all;
  all.fill({nan, nan, nan, nan, nan, nan, nan, nan});
  unsigned wanted = 0;
  for (const std::size_t o : observed(model.mode)) wanted |= 1u << o;
  const auto keep = [&](std::size_t o, const ObservationReliability<double>& r) {
    all[o] = r;
    all[o].detectable *= relative_unit(o, model.field);
    all[o].gravity *= model.field.gravity;
    all[o].total_field *= model.field.total;
  };
  with_model(kernel_of(model), [&](auto variant) {
    station_reliability<double, variant.value>(s, 1.0, relative_variances(model, lambda0), wanted, true, 1.0, keep);
  });
  return all;
}

}  // namespace surveymc::reliability
