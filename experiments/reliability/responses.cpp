#include "reliability/responses.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "reliability/significance.h"
#include "reliability/station_response.h"

namespace surveymc::studies::reliability {
namespace {

constexpr std::size_t kParameters = 6;
const std::string kResidual = "residual_", kDirection = "direction_";

struct Parameter {
  const char *name, *unit, *words;
};
constexpr std::array<Parameter, kParameters> kParameter{{{"effect_inclination_deg", "deg", "inclination"},
                                                         {"effect_toolface_deg", "deg", "toolface"},
                                                         {"effect_azimuth_deg", "deg", "magnetic azimuth"},
                                                         {"effect_gravity_mps2", "mps2", "estimate of gravity"},
                                                         {"effect_total_field_nT", "nT", "estimate of the total field"},
                                                         {"effect_dip_deg", "deg", "estimate of the dip"}}};

std::string residual_layer(std::size_t o) { return kResidual + observation_names()[o] + "_" + observation_unit(o); }

/// Effects on the parameters in the units of tables.
std::array<double, kParameters> effects(const ErrorResponse& r) {
  return {r.inclination / kDegree, r.toolface / kDegree, r.azimuth / kDegree, r.gravity,
          r.total_field,           r.dip / kDegree};
}

StationResponse response_at(const LayerModel& m, const GridPoint& p) {
  return {model_at(m, p), station_sines(p.inclination_deg, p.toolface_deg, p.magnetic_azimuth_deg, p.dip_deg)};
}

}  // namespace

const std::vector<std::string>& response_layers() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (std::size_t o = 0; o < kObservations; ++o) all.push_back(residual_layer(o));
    for (const Parameter& p : kParameter) all.push_back(p.name);
    return all;
  }();
  return names;
}

std::vector<std::string> response_layers(AdjustmentMode mode) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < response_layers().size(); ++k)
    if (k >= kObservations || is_observed(mode, k)) names.push_back(response_layers()[k]);
  return names;
}

bool is_response_layer(const std::string& layer) {
  return std::find(response_layers().begin(), response_layers().end(), layer) != response_layers().end();
}

std::vector<std::string> combination_layers(const ErrorSubject& s) {
  std::vector<std::string> names(map_quantity_names().begin(), map_quantity_names().end());
  if (!s.weakest()) return names;
  for (const std::size_t o : s.observations) names.push_back(kDirection + observation_names()[o]);
  names.insert(names.end(), {"test_dimension", "test_alpha"});
  return names;
}

std::string response_meaning(const std::string& layer) {
  if (layer.starts_with(kResidual)) return "residual e = y - adjusted y that the gross error causes";
  if (layer.starts_with(kDirection))
    return "entry of the weakest combination: a unit vector, in standard deviations of the observations";
  if (layer == "test_dimension") return "dimensions r of the test of all these observations together (eq 4)";
  if (layer == "test_alpha")
    return "false-alarm probability of that test that finds the same noncentrality with the same power (B-method)";
  for (const Parameter& p : kParameter)
    if (layer == p.name) return std::string("effect of the gross error on the ") + p.words;
  return "";
}

std::string response_unit(const std::string& layer) {
  for (std::size_t o = 0; o < kObservations; ++o)
    if (layer == residual_layer(o)) return observation_unit(o);
  for (const Parameter& p : kParameter)
    if (layer == p.name) return p.unit;
  return response_meaning(layer).empty() ? "" : "1";
}

std::vector<std::vector<double>> response_values(const LayerModel& m, const GridPoint& p,
                                                 const std::vector<ErrorSubject>& subjects,
                                                 const std::vector<std::string>& layers) {
  const StationResponse response = response_at(m, p);
  std::vector<std::vector<double>> values;
  for (const ErrorSubject& s : subjects) {
    const std::size_t o = s.observations.front();
    const std::string unit = subject_unit(s);
    Observations error{};
    error[o] = m.gross_error[unit == "mps2" ? 0 : unit == "nT" ? 1 : 2] / observation_scale(o);
    const ErrorResponse r = response.of(error);
    const auto of_parameters = effects(r);
    std::vector<double>& of_subject = values.emplace_back();
    for (const std::string& l : layers) {
      const auto k = static_cast<std::size_t>(std::find(response_layers().begin(), response_layers().end(), l) -
                                              response_layers().begin());
      of_subject.push_back(k < kObservations ? r.residuals[k] * observation_scale(k)
                                             : of_parameters[k - kObservations]);
    }
  }
  return values;
}

std::vector<double> combination_values(const LayerModel& m, const GridPoint& p, const ErrorSubject& s,
                                       const std::vector<std::string>& layers) {
  const StationResponse response = response_at(m, p);
  const StationResponse::Matrix9 all = response.information();
  const auto count = static_cast<Eigen::Index>(s.observations.size());
  Eigen::MatrixXd information(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      information(i, j) = all(static_cast<Eigen::Index>(s.observations[static_cast<std::size_t>(i)]),
                              static_cast<Eigen::Index>(s.observations[static_cast<std::size_t>(j)]));
  WeakestDirection w;
  if (s.weakest()) {
    w = weakest_direction(information);
  } else {
    w.direction = Eigen::Map<const Eigen::VectorXd>(s.direction.data(), count);
    const double shown = w.direction.dot(information * w.direction);
    w.redundancy = shown < kLeastRedundancy ? 0 : shown;
    w.dimensions = shown < kLeastRedundancy ? 0 : 1;
  }

  const double detectable = w.redundancy > 0 ? m.lambda0 / std::sqrt(w.redundancy) : kInfinity;
  const Observations sd = response.sd();
  Observations error{};  // of length 1
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t o = s.observations[static_cast<std::size_t>(k)];
    error[o] = w.direction[k] * sd[o];
  }
  const ErrorResponse r = response.of(error);
  const auto per_length = effects(r);
  // Rounding of an effect of 0, which an infinite error must not enlarge: 1e-12 of the angle, or of the field
  const std::array<double, kParameters> nothing{
      1e-12 / kDegree, 1e-12 / kDegree, 1e-12 / kDegree, 1e-12 * m.model.field.gravity, 1e-12 * m.model.field.total,
      1e-12 / kDegree};
  const auto external = [&](std::size_t k) {
    const double effect =
        std::abs(per_length[k]) <= nothing[k] && std::isinf(detectable) ? 0 : per_length[k] * detectable;
    return k < 3 && std::abs(effect) > 180 ? std::copysign(kInfinity, effect) : effect;  // no angle: no bound known
  };
  std::vector<double> values;
  for (const std::string& l : layers) {
    const auto& names = map_quantity_names();
    const auto k = static_cast<std::size_t>(std::find(names.begin(), names.end(), l) - names.begin());
    if (k == index_of(MapQuantity::redundancy_number))
      values.push_back(w.redundancy);
    else if (k == index_of(MapQuantity::minimal_detectable_error))
      values.push_back(detectable);
    else if (k < kMapQuantities)
      values.push_back(external(k - index_of(MapQuantity::external_inclination)));
    else if (l == "test_dimension")
      values.push_back(static_cast<double>(w.dimensions));
    else if (l == "test_alpha")
      values.push_back(w.dimensions > 0
                           ? b_method_level(static_cast<double>(w.dimensions), m.lambda0 * m.lambda0, m.power).alpha
                           : 0);
    else
      for (std::size_t j = 0; j < s.observations.size(); ++j)
        if (l == kDirection + observation_names()[s.observations[j]])
          values.push_back(w.direction[static_cast<Eigen::Index>(j)]);
  }
  return values;
}

}  // namespace surveymc::studies::reliability
