#include "error_model/graph.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace surveymc::error_model {

// --------------------------------------------------------------------------------------------------------------- graph

std::size_t Graph::insert(const Node& n) {
  const auto [at, is_new] = known_.try_emplace({n.operation, n.a, n.b, n.number, n.variable}, nodes_.size());
  if (is_new) nodes_.push_back(n);
  return at->second;
}

std::size_t Graph::number(double x) {
  // -0 and 0 are the same key, and the same in every formula but 1 / x.
  return insert({.number = x});
}

std::size_t Graph::variable(Variable v) {
  is_named_[index_of(v)] = true;
  const bool is_of_previous = v == Variable::previous;
  return insert({.operation = Operation::variable,
                 .variable = v,
                 .is_of_station = is_of_station(v) || is_of_previous,
                 .is_of_previous = is_of_previous});
}

std::size_t Graph::node(Operation operation, std::size_t a, std::size_t b) {
  return insert({.operation = operation,
                 .a = a,
                 .b = b,
                 .is_of_station = nodes_[a].is_of_station || nodes_[b].is_of_station,
                 .is_of_previous = nodes_[a].is_of_previous || nodes_[b].is_of_previous});
}

std::size_t Graph::power(std::size_t base, std::size_t exponent) {
  // The exponent as it is written: -1 is the negative of 1.
  const Node& e = nodes_[exponent];
  const bool is_negative = e.operation == Operation::negate && nodes_[e.a].operation == Operation::number;
  if (e.operation != Operation::number && !is_negative) return node(Operation::power, base, exponent);
  const double x = is_negative ? -nodes_[e.a].number : e.number;
  if (x == 1) return base;
  if (x == 2) return node(Operation::multiply, base, base);
  if (x == 3) return node(Operation::multiply, node(Operation::multiply, base, base), base);
  if (x == 0.5) return node(Operation::square_root, base, base);
  if (x == 0.25) {
    const std::size_t root = node(Operation::square_root, base, base);
    return node(Operation::square_root, root, root);
  }
  if (x == -1) return node(Operation::divide, number(1), base);
  return node(Operation::power, base, exponent);
}

namespace {

/// Sine and cosine of the three directions come with the geometry of a station.
std::optional<Variable> given_by_geometry(Operation operation, Variable v) {
  const bool is_sine = operation == Operation::sine;
  if (!is_sine && operation != Operation::cosine) return {};
  switch (v) {
    case Variable::inclination:
      return is_sine ? Variable::sin_inclination : Variable::cos_inclination;
    case Variable::azimuth:
      return is_sine ? Variable::sin_azimuth : Variable::cos_azimuth;
    case Variable::azimuth_magnetic:
      return is_sine ? Variable::sin_azimuth_magnetic : Variable::cos_azimuth_magnetic;
    default:
      return {};
  }
}

}  // namespace

std::size_t Graph::step_of(const Expression& e, const ExpressionNode& n, const std::vector<std::size_t>& made) {
  const auto argument = [&](std::size_t i) { return made[n.arguments[i]]; };
  switch (n.operation) {
    case Operation::number:
      return number(n.number);
    case Operation::variable:
      return variable(n.variable);
    case Operation::power:
      return power(argument(0), argument(1));
    case Operation::sine:
    case Operation::cosine: {
      const ExpressionNode& angle = e.nodes[n.arguments[0]];
      if (angle.operation == Operation::variable)
        if (const auto given = given_by_geometry(n.operation, angle.variable)) return variable(*given);
      return node(n.operation, argument(0), argument(0));
    }
    case Operation::maximum:
    case Operation::minimum: {
      std::size_t all = argument(0);
      for (std::size_t i = 1; i < n.arguments.size(); ++i) all = node(n.operation, all, argument(i));
      return all;
    }
    default:
      return node(n.operation, argument(0), argument(n.arguments.size() - 1));
  }
}

std::size_t Graph::add(const Expression& e) {
  std::vector<std::size_t> made;
  for (const ExpressionNode& n : e.nodes) made.push_back(step_of(e, n, made));
  return made.back();
}

std::size_t Graph::add_times_sin_inclination(std::size_t factor) {
  return node(Operation::multiply, variable(Variable::sin_inclination), factor);
}

std::vector<bool> Graph::needed_by(std::size_t whole) const {
  std::vector<bool> wanted(nodes_.size(), false);
  wanted[whole] = true;
  for (std::size_t i = whole + 1; i-- > 0;) {  // arguments stand before what takes them
    if (!wanted[i] || nodes_[i].operation == Operation::number || nodes_[i].operation == Operation::variable) continue;
    wanted[nodes_[i].a] = wanted[nodes_[i].b] = true;
  }
  return wanted;
}

std::vector<std::size_t> Graph::chain_of(std::size_t whole) const {
  const std::vector<bool> wanted = needed_by(whole);
  std::vector<std::size_t> chain;
  for (std::size_t i = 0; i <= whole; ++i)
    if (wanted[i] && (nodes_[i].is_of_previous || i == whole)) chain.push_back(i);
  return chain;
}

// ---------------------------------------------------------------------------------------------------------- evaluation

double computed(Operation operation, double a, double b) {
  switch (operation) {
    case Operation::negate:
      return -a;
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return a * b;
    case Operation::divide:
      return a / b;
    case Operation::power:
      return std::pow(a, b);
    case Operation::sine:
      return std::sin(a);
    case Operation::cosine:
      return std::cos(a);
    case Operation::tangent:
      return std::tan(a);
    case Operation::absolute:
      return std::abs(a);
    case Operation::square_root:
      return std::sqrt(a);
    case Operation::sign:
      return a < 0 ? -1 : a >= 0 ? 1 : a;  // what is not a number stays
    case Operation::maximum:
      return a < b || b != b ? b : a;  // one that is not a number stays
    case Operation::minimum:
      return b < a || b != b ? b : a;
    default:
      return a;
  }
}

namespace {

template <Operation operation>
void compute_block(std::size_t count, const double* __restrict a, const double* __restrict b, double* __restrict out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = computed(operation, a[i], b[i]);
}

/// compute_block() of every operation, in their order.
constexpr auto kComputeBlock = []<std::size_t... i>(std::index_sequence<i...>) {
  return std::array{&compute_block<static_cast<Operation>(i)>...};
}
(std::make_index_sequence<static_cast<std::size_t>(Operation::minimum) + 1>());

double constant_of(Variable v, const Surroundings& s) {
  // In the order of the variables, behind those of the station.
  const std::array constants{s.dip,      s.total_field,       s.gravity,   s.latitude,
                             kEarthRate, s.min_course_length, s.tortuosity};
  static_assert(constants.size() == index_of(Variable::previous) - kStationVariables);
  return constants[index_of(v) - kStationVariables];
}

}  // namespace

Evaluation::Evaluation(const Graph& graph, const Surroundings& surroundings)
    : graph_(graph), inputs_(kStationVariables), values_(graph.nodes().size()) {
  for (Block& b : inputs_) b.fill(0);
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const Graph::Node& n = graph.nodes()[i];
    double x = 0;
    if (!n.is_of_station)
      x = n.operation == Operation::number     ? n.number
          : n.operation == Operation::variable ? constant_of(n.variable, surroundings)
                                               : computed(n.operation, values_[n.a][0], values_[n.b][0]);
    values_[i].fill(x);
  }
}

void Evaluation::run(std::size_t count) {
  const auto& nodes = graph_.nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Graph::Node& n = nodes[i];
    if (!n.is_of_station || n.is_of_previous) continue;
    if (n.operation == Operation::variable)
      std::copy_n(inputs_[index_of(n.variable)].data(), count, values_[i].data());
    else
      kComputeBlock[static_cast<std::size_t>(n.operation)](count, values_[n.a].data(), values_[n.b].data(),
                                                           values_[i].data());
  }
}

double Evaluation::step(const std::vector<std::size_t>& chain, double previous, std::size_t i) {
  for (const std::size_t k : chain) {
    const Graph::Node& n = graph_.nodes()[k];
    if (!n.is_of_previous) continue;  // a whole that names no Previous is there already
    values_[k][i] =
        n.operation == Operation::variable ? previous : computed(n.operation, values_[n.a][i], values_[n.b][i]);
  }
  return values_[chain.back()][i];
}

}  // namespace surveymc::error_model
