#include "propagate/disturbed_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "base/error.h"
#include "base/units.h"
#include "propagate/well_errors.h"
#include "stats/linear_algebra.h"

namespace surveymc::propagate {

using disturbance::Disturbance;
using disturbance::Element;
using disturbance::StationDraw;

namespace {

constexpr std::array<const char*, disturbance::kElements> kCodes{"DISTURBANCE-DECLINATION", "DISTURBANCE-DIP",
                                                                 "DISTURBANCE-TOTAL"};
constexpr std::size_t kMostDraws = 3000;

std::optional<Element> element_of(const error_model::Term& t) {
  const auto element = reference_element(t.code, t.function->name);
  return element ? std::optional(static_cast<Element>(*element)) : std::nullopt;
}

/// One standard deviation of the element by a term: rad, nT.
double size_of(const error_model::Term& t, const survey::ReferenceField& field) {
  return t.function->name == "DBH" ? t.sigma / (field.total * std::cos(field.dip)) : t.sigma;
}

/// The model with its disturbed terms; null if it has none.
std::shared_ptr<const error_model::Model> disturbed_model(const error_model::Model& model, const Disturbance& d,
                                                          const std::array<double, disturbance::kElements>& sizes,
                                                          const survey::ReferenceField& field) {
  auto out = std::make_shared<error_model::Model>(model);
  bool any = false;
  if (d.keeps_normals()) {
    for (error_model::Term& t : out->terms)
      if (disturbed_element(t)) {
        t.magnitude *= d.scale;
        t.sigma *= d.scale;
        any = true;
      }
    return any ? out : nullptr;
  }
  std::erase_if(out->terms, [](const error_model::Term& t) { return disturbed_element(t).has_value(); });
  for (int e = 0; e < disturbance::kElements; ++e) {
    double variance = 0;
    std::shared_ptr<const error_model::Function> function;
    for (const error_model::Term& t : model.terms) {
      if (element_of(t) != static_cast<Element>(e)) continue;
      if (!function || t.function->name == "AZ") function = t.function;
      if (disturbed_element(t)) variance += std::pow(size_of(t, field), 2);
    }
    require(!d.match_variance || variance == 0 || sizes[static_cast<std::size_t>(e)] > 0,
            "the disturbance does not change the {}, of which the error model has a term of mode R",
            random::reference_elements()[static_cast<std::size_t>(e)]);
    const double size = d.scale * (d.match_variance ? std::sqrt(variance) : sizes[static_cast<std::size_t>(e)]);
    if (!function || size == 0) continue;
    error_model::Term t;
    t.code = kCodes[static_cast<std::size_t>(e)];
    t.function = function;
    t.sigma = function->name == "DBH" ? size * field.total * std::cos(field.dip) : size;
    t.unit = function->name == "DBH" ? "deg.nT" : e == disturbance::kTotal ? "nT" : "deg";
    t.magnitude = e == disturbance::kTotal ? size : t.sigma / kDegree;
    out->terms.push_back(t);
    any = true;
  }
  return any ? out : nullptr;
}

/// Codes of disturbed sources, and their elements.
std::map<std::string, Element> disturbed_codes(const std::vector<ToolRun>& runs) {
  std::map<std::string, Element> codes;
  for (const ToolRun& run : runs)
    for (const error_model::Term& t : run.model->terms)
      if (const auto e = disturbed_element(t)) codes.emplace(t.code, *e);
  return codes;
}

void require_few(std::size_t draws) {
  require(draws <= kMostDraws,
          "{} draws of the disturbance, one of each of its terms at every station: must be at most {}; fewer stations, "
          "by a larger interpolate_m",
          draws, kMostDraws);
}

}  // namespace

std::optional<Element> disturbed_element(const error_model::Term& term) {
  if (term.mode != error_model::PropagationMode::random) return std::nullopt;
  return element_of(term);
}

std::vector<ToolRun> disturbed_runs(const std::vector<ToolRun>& runs, const Disturbance& d,
                                    const survey::ReferenceField& field) {
  std::array<double, disturbance::kElements> sizes{};
  if (!d.keeps_normals()) sizes = disturbance::StationDisturbance(d, field, {}).sizes();
  std::vector<ToolRun> out = runs;
  std::map<const error_model::Model*, std::shared_ptr<const error_model::Model>> made;  // runs share their models
  bool any = false;
  for (ToolRun& run : out) {
    auto [at, is_new] = made.try_emplace(run.model.get());
    if (is_new) at->second = disturbed_model(*run.model, d, sizes, field);
    any = any || at->second;
    if (at->second) run.model = at->second;
  }
  require(any,
          "the error model has no term {}of the reference (functions AZ, DBH, MDI, MFI) that the disturbance changes",
          d.match_variance ? "of mode R " : "");
  return out;
}

void require_few_draws(const std::vector<ToolRun>& runs, std::size_t stations) {
  std::size_t draws = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    std::set<std::string> codes;
    for (const error_model::Term& t : runs[r].model->terms)
      if (disturbed_element(t)) codes.insert(t.code);
    const std::size_t end = r + 1 < runs.size() ? static_cast<std::size_t>(runs[r + 1].first) : stations;
    draws += codes.size() * (end - static_cast<std::size_t>(runs[r].first));
  }
  require_few(draws);
}

DisturbedDraws disturbed_draws(const WellErrors& errors, const std::vector<ToolRun>& runs, const Disturbance& d,
                               const survey::ReferenceField& field) {
  const std::map<std::string, Element> codes = disturbed_codes(runs);
  std::vector<StationDraw> draws;
  std::vector<std::uint32_t> numbers;
  for (std::size_t i = errors.station_draws; i < errors.draws.size(); ++i) {
    const ErrorDraw& draw = errors.draws[i];
    const auto found = codes.find(errors.sources[draw.source].code);
    if (found == codes.end()) continue;
    draws.push_back({draw.first, found->second, draw.source, random::Channel::station_error,
                     static_cast<std::uint32_t>(i - errors.station_draws)});
    numbers.push_back(static_cast<std::uint32_t>(i));
  }
  require_few(draws.size());
  return {disturbance::StationDisturbance(d, field, std::move(draws)), std::move(numbers)};
}

WellErrors with_independent_draws(const WellErrors& errors, const DisturbedDraws& disturbed) {
  return mixed_draws(errors, disturbed.draws, stats::lower_factor(disturbed.disturbance.correlation()));
}

StationEffects with_independent_draws(const StationEffects& effects, const std::vector<ToolRun>& runs,
                                      const Disturbance& d, const survey::ReferenceField& field) {
  const std::map<std::string, Element> codes = disturbed_codes(runs);
  const std::size_t n = effects.stations;
  StationEffects out;
  out.stations = n;
  std::vector<std::size_t> disturbed;
  for (std::size_t s = 0; s < effects.sources.size(); ++s) {
    const StationEffects::Source& source = effects.sources[s];
    if (source.mode == error_model::PropagationMode::random && codes.count(source.code) > 0) {
      disturbed.push_back(s);
      continue;
    }
    out.sources.push_back(source);
    for (std::size_t k = s * n; k < (s + 1) * n; ++k) {
      out.star.push_back(effects.star[k]);
      out.full.push_back(effects.full[k]);
      out.depth.push_back(effects.depth[k]);
      out.draw.push_back(effects.draw[k]);
    }
  }
  std::vector<StationDraw> draws;
  for (std::size_t k = 1; k < n; ++k)
    for (const std::size_t s : disturbed)
      if (effects.draw[s * n + k] != StationEffects::kNone)
        draws.push_back({k, codes.at(effects.sources[s].code), static_cast<std::uint32_t>(s)});
  require_few(draws.size());
  const Eigen::MatrixXd factor = stats::lower_factor(disturbance::StationDisturbance(d, field, draws).correlation());
  for (std::size_t j = 0; j < draws.size(); ++j) {
    out.sources.push_back(effects.sources[draws[j].source]);
    const std::size_t first = out.star.size();
    out.star.resize(first + n, Eigen::Vector3d::Zero());
    out.full.resize(first + n, Eigen::Vector3d::Zero());
    out.depth.resize(first + n, 0);
    out.draw.resize(first + n, 1);
    for (std::size_t i = j; i < draws.size(); ++i) {
      const double x = factor(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      const std::size_t from = draws[i].source * n + draws[i].station, to = first + draws[i].station;
      out.star[to] += x * effects.star[from];
      out.full[to] += x * effects.full[from];
      out.depth[to] += x * effects.depth[from];
    }
  }
  return out;
}

void add_correlation(ToolCovariances& covariances, const StationEffects& effects, const std::vector<ToolRun>& runs,
                     const Disturbance& disturbance, const survey::ReferenceField& field, SourceDetail detail) {
  const std::map<std::string, Element> codes = disturbed_codes(runs);
  struct Source {
    std::uint32_t number;  // in effects
    std::size_t row;       // in covariances
    Element element;
  };
  std::vector<Source> sources;
  for (std::size_t s = 0; s < effects.sources.size(); ++s) {
    const StationEffects::Source& source = effects.sources[s];
    const auto found = codes.find(source.code);
    if (found == codes.end() || source.mode != error_model::PropagationMode::random) continue;
    const auto row = std::find(covariances.sources.begin(), covariances.sources.end(), source.code);
    sources.push_back(
        {static_cast<std::uint32_t>(s), static_cast<std::size_t>(row - covariances.sources.begin()), found->second});
  }
  const disturbance::StationDisturbance process(disturbance, field, {});
  const std::size_t n = effects.stations;
  const auto draw_of = [&](const Source& s, std::size_t k) { return StationDraw{k, s.element, s.number}; };
  const auto add = [](CovarianceColumns& c, std::size_t at, const Eigen::Matrix3d& m) {
    const std::array<double, 6> parts{m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
    for (std::size_t i = 0; i < parts.size(); ++i) c.elements[i][at] += parts[i];
  };
  for (const Source& a : sources)
    for (const Source& b : sources) {
      // Pairs (j of a, k of b), j and k before the station at hand, without j = k where a is b.
      Eigen::Matrix3d past = Eigen::Matrix3d::Zero();
      const double together = a.number == b.number ? 0 : process.correlation(draw_of(a, 0), draw_of(b, 0));
      const auto star = [&](const Source& s, std::size_t k) -> const Eigen::Vector3d& {
        return effects.star[s.number * n + k];
      };
      const auto full = [&](const Source& s, std::size_t k) -> const Eigen::Vector3d& {
        return effects.full[s.number * n + k];
      };
      for (std::size_t k = 1; k < n; ++k) {
        Eigen::Vector3d of_a = Eigen::Vector3d::Zero(), of_b = of_a;  // sums over the stations before
        for (std::size_t j = 1; j < k; ++j) {
          of_a += process.correlation(draw_of(a, j), draw_of(b, k)) * full(a, j);
          of_b += process.correlation(draw_of(a, k), draw_of(b, j)) * full(b, j);
        }
        const auto with = [&](const Eigen::Vector3d& at_a, const Eigen::Vector3d& at_b) {
          return Eigen::Matrix3d(of_a * at_b.transpose() + at_a * of_b.transpose() +
                                 together * at_a * at_b.transpose());
        };
        const Eigen::Matrix3d here = past + with(star(a, k), star(b, k));
        covariances.total[k] += a.number == b.number ? here : Eigen::Matrix3d(0.5 * (here + here.transpose()));
        if (a.number == b.number && detail == SourceDetail::all)
          add(covariances.by_source, k * covariances.sources.size() + a.row, here);
        if (a.number == b.number && detail == SourceDetail::last && k + 1 == n) add(covariances.by_source, a.row, here);
        past += with(full(a, k), full(b, k));
      }
    }
}

}  // namespace surveymc::propagate
