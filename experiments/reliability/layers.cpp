#include "reliability/layers.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/units.h"
#include "reliability/adjustment.h"
#include "reliability/nonlinear_detectable.h"
#include "reliability/responses.h"
#include "reliability/significance.h"

namespace surveymc::studies::reliability {
namespace {

struct SlowLayer {
  const char *name, *meaning;
};
constexpr std::array<SlowLayer, 10> kSlow{{
    {"max_correlation", "largest |correlation| of the test with another one; 1: not separable"},
    {"minimal_identifiable_error",
     "smallest error that is detected and has the larger |w| against every other "
     "observation in turn, each with probability `power`"},
    {"nonlinear_detectable_error_plus",
     "minimal detectable error without linearisation, positive sign, by the general test"},
    {"nonlinear_detectable_error_minus",
     "minimal detectable error without linearisation, negative sign, by the general test"},
    {"nonlinear_own_test_plus", "the same by the observation's own test, positive sign"},
    {"nonlinear_own_test_minus", "the same by the observation's own test, negative sign"},
    {"nonlinear_external_inclination_deg",
     "effect on the inclination of the nonlinear detectable error (general test) with the sign that turns it more"},
    {"nonlinear_external_toolface_deg", "the same on the toolface, at most 180"},
    {"nonlinear_external_azimuth_deg", "the same on the magnetic azimuth, at most 180"},
    {"linear_differs", "1 where nabla_0 of linear theory is off by more than 20 % for either sign (general test)"},
}};

/// Of the kernel's quantities, in their order.
constexpr std::array<const char*, kMapQuantities> kFastMeanings{
    "redundancy number r_ii",
    "minimal detectable error nabla_0; mps2, nT or deg, as the observation",
    "effect of +nabla_0 on the inclination",
    "effect of +nabla_0 on the toolface",
    "effect of +nabla_0 on the magnetic azimuth",
    "effect of +nabla_0 on the estimate of gravity",
    "effect of +nabla_0 on the estimate of the total field",
    "effect of +nabla_0 on the estimate of the dip"};

/// Number of a kernel quantity; kMapQuantities if it is none.
std::size_t fast_number(const std::string& layer) {
  const auto& names = map_quantity_names();
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), layer) - names.begin());
}

/// A linear effect beyond half a turn is no angle: no bound is known.
void without_impossible_angles(MapQuantity quantity, std::vector<double>& values) {
  if (quantity != MapQuantity::external_inclination && quantity != MapQuantity::external_toolface &&
      quantity != MapQuantity::external_azimuth)
    return;
  for (double& x : values)
    if (std::abs(x) > 180) x = std::copysign(kInfinity, x);
}

bool is_detectable_layer(const std::string& l) {
  return l.starts_with("nonlinear_detectable_error") || l.starts_with("nonlinear_own_test");
}
bool is_effect_layer(const std::string& l) { return l.starts_with("nonlinear_external") || l == "linear_differs"; }

/// The effect layers of one observation at one point.
class NonlinearEffects {
 public:
  NonlinearEffects(const AdjustmentModel& m, const survey::Attitude& at, std::size_t observation, double lambda0)
      : linear_(station_reliability(m, at, lambda0)[observation].detectable) {
    for (const int sign : {1, -1}) {
      const DetectedError e = detected_error(m, at, observation, lambda0, sign, DetectedBy::general_test);
      const AngleEffects a = angle_effects(at, e);
      const std::array<double, 3> angles{a.inclination, a.toolface, a.azimuth};
      for (std::size_t k = 0; k < 3; ++k)
        if (sign > 0 || std::abs(angles[k]) > std::abs(angles_[k])) angles_[k] = angles[k];
      const double size = std::abs(e.size);
      if (std::isinf(size) != std::isinf(linear_) ||
          (std::isfinite(size) && (size > 1.2 * linear_ || linear_ > 1.2 * size)))
        differs_ = true;
    }
  }
  double of(const std::string& layer) const {
    if (layer == "linear_differs") return differs_ ? 1 : 0;
    return angles_[layer.ends_with("inclination_deg") ? 0 : layer.ends_with("toolface_deg") ? 1 : 2] / kDegree;
  }

 private:
  double linear_;
  std::array<double, 3> angles_{};
  bool differs_ = false;
};

/// Correlation and identifiable error of the observations of one point.
struct Separability {
  double correlation, identifiable;
};
std::vector<Separability> separability(const LayerModel& m, const GridPoint& p,
                                       const std::vector<std::size_t>& observations) {
  AdjustmentModel at = model_at(m, p);
  // Stations at one attitude: the tests of one station correlate as they do for many of them
  const std::size_t stations = at.mode == AdjustmentMode::mse_shared ? static_cast<std::size_t>(at.stations) : 1;
  const ParityModel parity = linear_model(at, std::vector<survey::Attitude>(stations, p.attitude()));
  const Eigen::VectorXd size = sensitivities(parity);
  const Eigen::MatrixXd rho = test_correlations(parity);
  std::vector<Separability> all;
  for (const std::size_t o : observations) {
    const Eigen::Index i = observation_number(at, stations, 0, o);
    Separability s{kNaN, kInfinity};
    if (size[i] > 0) {
      s.correlation = 0;
      for (Eigen::Index j = 0; j < parity.observations(); ++j)
        if (j != i && size[j] > 0) s.correlation = std::max(s.correlation, std::abs(rho(i, j)));
      if (s.correlation > 1 - 1e-9) s.correlation = 1;  // as inseparable_groups()
      const double shift = std::max(m.lambda0, identifiable_shift(s.correlation, m.power));
      s.identifiable = shift / size[i] * observation_scale(o);
    } else {
      s.correlation = 1;  // shows in no test: nothing can be told apart
    }
    all.push_back(s);
  }
  return all;
}

}  // namespace

bool has_gross_error(const LayerModel& m) {
  return std::any_of(m.gross_error.begin(), m.gross_error.end(), [](double x) { return !std::isnan(x); });
}

AdjustmentModel model_at(const LayerModel& m, const GridPoint& p) {
  AdjustmentModel at = m.model;
  at.field.dip = p.dip_deg * kDegree;
  at.sigma.accelerometer_noise *= p.noise_scale;
  at.sigma.magnetometer_noise *= p.noise_scale;
  return at;
}

std::vector<std::string> layer_names(const LayerModel& m, const ErrorSubject& subject) {
  if (subject.combined()) return combination_layers(subject);
  std::vector<std::string> names(map_quantity_names().begin(), map_quantity_names().end());
  for (const SlowLayer& s : kSlow) names.push_back(s.name);
  if (has_gross_error(m))
    for (const std::string& l : response_layers(m.model.mode)) names.push_back(l);
  return names;
}

std::vector<std::string> default_layers(const LayerModel& m, const ErrorSubject& subject) {
  std::vector<std::string> names(map_quantity_names().begin(), map_quantity_names().begin() + 5);
  std::vector<std::string> more;
  if (subject.combined()) {
    more = combination_layers(subject);
    more.erase(more.begin(), more.begin() + kMapQuantities);
  } else if (has_gross_error(m)) {
    more = response_layers(m.model.mode);
    more.resize(more.size() - 3);  // without the effects on the references
  }
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

std::string layer_meaning(const std::string& layer) {
  for (const SlowLayer& s : kSlow)
    if (layer == s.name) return s.meaning;
  const std::string response = response_meaning(layer);
  return response.empty() ? kFastMeanings[fast_number(layer)] : response;
}

std::string layer_unit(const std::string& layer, const ErrorSubject& subject) {
  if (layer == "max_correlation" || layer == "linear_differs") return "1";
  if (layer.starts_with("nonlinear_external")) return "deg";
  const std::string response = response_unit(layer);
  if (!response.empty()) return response;
  if (is_slow_layer(layer) || layer == "minimal_detectable_error") return subject_unit(subject);
  return map_quantity_unit(fast_number(layer), subject.observations.front());
}

bool is_slow_layer(const std::string& layer) {
  return std::any_of(kSlow.begin(), kSlow.end(), [&](const SlowLayer& s) { return layer == s.name; });
}

GridPoint grid_point(const ReliabilityGrid& g, std::size_t point) {
  const auto take = [&](const std::vector<double>& axis) {
    const double x = axis[point % axis.size()];
    point /= axis.size();
    return x;
  };
  GridPoint p;
  p.magnetic_azimuth_deg = take(g.magnetic_azimuth_deg);
  p.toolface_deg = take(g.toolface_deg);
  p.inclination_deg = take(g.inclination_deg);
  p.dip_deg = take(g.dip_deg);
  p.noise_scale = take(g.noise_scale);
  return p;
}

std::vector<std::vector<std::vector<double>>> layer_values(const LayerModel& m,
                                                           const std::vector<ErrorSubject>& subjects,
                                                           const std::vector<std::string>& layers, std::size_t first,
                                                           std::size_t count) {
  std::vector<std::vector<std::vector<double>>> out(subjects.size(), std::vector<std::vector<double>>(layers.size()));
  if (subjects.front().combined()) {
    for (auto& of_subject : out)
      for (auto& values : of_subject) values.resize(count);
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t s = 0; s < subjects.size(); ++s) {
        const auto values = combination_values(m, grid_point(m.maps->grid(), first + k), subjects[s], layers);
        for (std::size_t l = 0; l < layers.size(); ++l) out[s][l][k] = values[l];
      }
    return out;
  }

  std::vector<std::size_t> observations;
  for (const ErrorSubject& s : subjects) observations.push_back(s.observations.front());
  std::vector<MapQuantity> fast;
  std::vector<std::string> responses;
  bool tells_apart = false, has_effects = false;
  for (const std::string& l : layers) {
    if (fast_number(l) < kMapQuantities) fast.push_back(static_cast<MapQuantity>(fast_number(l)));
    if (is_response_layer(l)) responses.push_back(l);
    tells_apart |= l == "max_correlation" || l == "minimal_identifiable_error";
    has_effects |= is_effect_layer(l);
  }
  MapValues from_kernel;
  if (!fast.empty()) m.maps->fill(observations, fast, first, count, from_kernel);
  for (std::size_t o = 0; o < observations.size(); ++o) {
    std::size_t next = 0;
    for (std::size_t l = 0; l < layers.size(); ++l) {
      if (fast_number(layers[l]) == kMapQuantities) {
        out[o][l].resize(count);
        continue;
      }
      const double* column = from_kernel.column(o, next++);
      out[o][l].assign(column, column + count);
      without_impossible_angles(static_cast<MapQuantity>(fast_number(layers[l])), out[o][l]);
    }
  }
  if (fast.size() == layers.size()) return out;
  for (std::size_t k = 0; k < count; ++k) {
    const GridPoint p = grid_point(m.maps->grid(), first + k);
    std::vector<Separability> apart(observations.size());
    if (tells_apart) apart = separability(m, p, observations);
    std::vector<std::vector<double>> response;
    if (!responses.empty()) response = response_values(m, p, subjects, responses);
    const AdjustmentModel at = model_at(m, p);
    for (std::size_t o = 0; o < observations.size(); ++o) {
      std::size_t next = 0;
      std::optional<NonlinearEffects> effects;
      if (has_effects) effects.emplace(at, p.attitude(), observations[o], m.lambda0);
      for (std::size_t l = 0; l < layers.size(); ++l) {
        if (is_effect_layer(layers[l])) out[o][l][k] = effects->of(layers[l]);
        if (layers[l] == "max_correlation") out[o][l][k] = apart[o].correlation;
        if (layers[l] == "minimal_identifiable_error") out[o][l][k] = apart[o].identifiable;
        if (is_response_layer(layers[l])) out[o][l][k] = response[o][next++];
        if (is_detectable_layer(layers[l]))
          out[o][l][k] =
              nonlinear_detectable_error(
                  at, p.attitude(), observations[o], m.lambda0, layers[l].ends_with("plus") ? 1 : -1,
                  layers[l].starts_with("nonlinear_own_test") ? DetectedBy::own_test : DetectedBy::general_test) *
              observation_scale(observations[o]);
      }
    }
  }
  return out;
}

}  // namespace surveymc::studies::reliability
