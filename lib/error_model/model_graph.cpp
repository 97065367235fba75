#include "error_model/model_graph.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace surveymc::error_model {
namespace {

FunctionNodes nodes_of(Graph& graph, const std::shared_ptr<const Function>& f) {
  FunctionNodes n;
  n.function = f;
  const auto add = [&](const Expression& e) {
    return e.is_absent() ? std::optional<std::size_t>() : std::optional<std::size_t>(graph.add(e));
  };
  n.depth = add(f->depth);
  n.inclination = add(f->inclination);
  n.azimuth = add(f->azimuth);
  if (f->kind == Kind::continuous) {
    if (n.azimuth) n.azimuth_chain = graph.chain_of(*n.azimuth);
    return n;
  }
  n.lateral = add(f->lateral);
  if (n.azimuth) n.lateral = graph.add_times_sin_inclination(*n.azimuth);
  n.vertical_north = add(f->vertical_north);
  n.vertical_east = add(f->vertical_east);
  return n;
}

}  // namespace

ModelGraph model_graph(const std::vector<Term>& terms) {
  ModelGraph g;
  for (const Term& term : terms) {
    const auto same = std::find_if(g.functions.begin(), g.functions.end(),
                                   [&](const FunctionNodes& n) { return n.function == term.function; });
    g.function_of_term.push_back(static_cast<std::size_t>(same - g.functions.begin()));
    if (same == g.functions.end()) g.functions.push_back(nodes_of(g.graph, term.function));
  }
  return g;
}

Surroundings surroundings_of(const Parameters& p, double dip, double total_field, double gravity, double latitude) {
  return {dip, total_field, gravity, latitude, p.min_course_length, p.tortuosity};
}

void set_station(Evaluation& evaluation, std::size_t i, const SampleStation& s) {
  const double magnetic = s.azimuth - s.declination;
  const std::array<std::pair<Variable, double>, kStationVariables> values{
      {{Variable::md, s.md},
       {Variable::md_before, s.md - s.dmd},
       {Variable::tvd, s.tvd},
       {Variable::inclination, s.inclination},
       {Variable::inclination_before, s.inclination_before.value_or(s.inclination)},
       {Variable::azimuth, s.azimuth},
       {Variable::azimuth_before, s.azimuth_before.value_or(s.azimuth)},
       {Variable::azimuth_magnetic, magnetic},
       {Variable::noise_reduction, s.noise_reduction},
       {Variable::running_speed, s.running_speed},
       {Variable::sin_inclination, std::sin(s.inclination)},
       {Variable::cos_inclination, std::cos(s.inclination)},
       {Variable::sin_azimuth, std::sin(s.azimuth)},
       {Variable::cos_azimuth, std::cos(s.azimuth)},
       {Variable::sin_azimuth_magnetic, std::sin(magnetic)},
       {Variable::cos_azimuth_magnetic, std::cos(magnetic)}}};
  for (const auto& [variable, value] : values) evaluation.input(variable)[i] = value;
}

// -------------------------------------------------------------------------------------------------------------- checks

namespace {

constexpr int kAzimuths = 24;

double value(const Evaluation& e, const std::optional<std::size_t>& node, std::size_t i) {
  return node ? e.output(*node)[i] : 0;
}

std::vector<Term> term_of(const Function& f) {
  return {{"", std::make_shared<const Function>(f), 1, "", 1, PropagationMode::random}};
}

/// A function alone, at 24 azimuths of one inclination, in a field like the North Sea's.
struct Ring {
  ModelGraph model;
  Evaluation evaluation;
  const FunctionNodes& f;

  Ring(const Function& function, const Parameters& p)
      : model(model_graph(term_of(function))),
        evaluation(model.graph, surroundings_of(p, 72 * kDegree, 50000, 9.80665, 60 * kDegree)),
        f(model.functions[0]) {}

  static double azimuth(int i) { return 2 * kPi * i / kAzimuths; }
  void at(double inclination) {
    for (int i = 0; i < kAzimuths; ++i) {
      SampleStation s;
      s.inclination = inclination;
      s.azimuth = azimuth(i);
      set_station(evaluation, static_cast<std::size_t>(i), s);
    }
    evaluation.run(kAzimuths);
  }
  /// Largest lateral weight; infinite if one is no number.
  double largest_lateral(double inclination) {
    at(inclination);
    double most = 0;
    for (std::size_t i = 0; i < kAzimuths; ++i) {
      const double x = std::abs(value(evaluation, f.lateral, i));
      if (!(x <= 1e300)) return HUGE_VAL;
      most = std::max(most, x);
    }
    return most;
  }
};

/// The vertical formulas act below kVerticalLimit, at 0 deg above all.
bool has_vertical_values(Ring& ring) {
  ring.at(0);
  for (std::size_t i = 0; i < kAzimuths; ++i)
    if (!(std::abs(value(ring.evaluation, ring.f.vertical_north, i)) <= 1e300 &&
          std::abs(value(ring.evaluation, ring.f.vertical_east, i)) <= 1e300))
      return false;
  return true;
}

/// Largest difference between the vertical formulas and the others at 0.001 deg, over the largest of both.
double vertical_difference(Ring& ring) {
  constexpr double kNear = 0.001 * kDegree;
  ring.at(kNear);
  double most = 0, difference = 0;
  for (int k = 0; k < kAzimuths; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double a = Ring::azimuth(k), w = value(ring.evaluation, ring.f.inclination, i),
                 lateral = value(ring.evaluation, ring.f.lateral, i),
                 north = w * std::cos(kNear) * std::cos(a) - lateral * std::sin(a),
                 east = w * std::cos(kNear) * std::sin(a) + lateral * std::cos(a),
                 vertical_north = value(ring.evaluation, ring.f.vertical_north, i),
                 vertical_east = value(ring.evaluation, ring.f.vertical_east, i);
    const double d = std::hypot(north - vertical_north, east - vertical_east);
    if (!(d <= 1e300)) return HUGE_VAL;
    difference = std::max(difference, d);
    most = std::max({most, std::hypot(north, east), std::hypot(vertical_north, vertical_east)});
  }
  return most > 0 ? difference / most : 0;
}

}  // namespace

Weights weights_at(const Function& f, const SampleStation& s, const Surroundings& surroundings) {
  const ModelGraph model = model_graph(term_of(f));
  Evaluation evaluation(model.graph, surroundings);
  set_station(evaluation, 0, s);
  evaluation.run(1);
  const FunctionNodes& n = model.functions[0];
  return {value(evaluation, n.depth, 0), value(evaluation, n.inclination, 0), value(evaluation, n.lateral, 0)};
}

std::string vertical_fault(const Function& f, const Parameters& parameters) {
  if (f.kind == Kind::continuous || f.azimuth_or_lateral().is_absent()) {
    if (f.vertical_north.empty() && f.vertical_east.empty()) return "";
  }
  Ring ring(f, parameters);
  if (ring.f.has_vertical()) {
    if (!has_vertical_values(ring)) return "the vertical formulas are not finite at 0 deg, where they are used";
    const double d = vertical_difference(ring);
    return d <= 1e-3 ? ""
                     : fmt::format(
                           "the vertical formulas are not the limit of the others: at 0.001 deg they differ by {:.2g}"
                           " of the largest",
                           d);
  }
  if (f.azimuth.is_absent()) return "";
  // A weight that stays finite makes sinI w_A a hundred times smaller from 1e-4 to 1e-6 rad, a root ten times.
  const double far = ring.largest_lateral(1e-4), near = ring.largest_lateral(1e-6);
  if (near < 0.3 * far || near == 0) return "";
  return "is singular in a vertical hole, sinI times it does not vanish: give lateral (sinI times the azimuth's "
         "weight) "
         "instead, or vertical_north and vertical_east";
}

bool have_same_formulas(const std::shared_ptr<const Function>& a, const std::shared_ptr<const Function>& b) {
  if (a == b) return true;
  if (a->kind != b->kind || a->axis != b->axis || a->per_section != b->per_section) return false;
  // Every running sum is a node of its own.
  if (a->kind == Kind::continuous) return a->azimuth.text == b->azimuth.text;
  Graph graph;
  const FunctionNodes x = nodes_of(graph, a), y = nodes_of(graph, b);
  return x.depth == y.depth && x.inclination == y.inclination && x.lateral == y.lateral &&
         x.vertical_north == y.vertical_north && x.vertical_east == y.vertical_east;
}

bool is_without_effect(const Term& term, const Surroundings& surroundings) {
  constexpr int kInclinations = 25;
  constexpr double kTurn = 3 * kDegree;
  const ModelGraph model = model_graph({term});
  const FunctionNodes& f = model.functions[0];
  Evaluation evaluation(model.graph, surroundings);
  // Every attitude with the same one before, then with another one: course errors may need a turn.
  for (int k = 0; k < 2 * kInclinations; ++k) {
    for (int j = 0; j < kAzimuths; ++j) {
      SampleStation s;
      s.inclination = kPi * (k % kInclinations) / (kInclinations - 1);
      s.azimuth = Ring::azimuth(j);
      if (k >= kInclinations) {
        s.inclination_before = std::abs(s.inclination - kTurn);
        s.azimuth_before = s.azimuth - kTurn;
      }
      set_station(evaluation, static_cast<std::size_t>(j), s);
    }
    evaluation.run(kAzimuths);
    for (std::size_t i = 0; i < kAzimuths; ++i) {
      const double azimuth = f.azimuth_chain.empty() ? 0 : evaluation.step(f.azimuth_chain, 0, i);
      for (const double w :
           {value(evaluation, f.depth, i), value(evaluation, f.inclination, i), value(evaluation, f.lateral, i),
            value(evaluation, f.vertical_north, i), value(evaluation, f.vertical_east, i), azimuth})
        if (!(std::abs(term.sigma * w) <= 1e-15)) return false;
    }
  }
  return true;
}

}  // namespace surveymc::error_model
