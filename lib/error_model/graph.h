#pragma once
/// All formulas of a model as one graph: a part that several of them have is one node, and is computed once a station.
/// Stations are evaluated in blocks, node after node, in structures of arrays.
///
/// A formula keeps its order of operations. x ^ 2, ^ 3, ^ 0.5, ^ 0.25 and ^ -1 are products, roots and a quotient: no
/// libm pow is called for them. What no station changes (Dip, BField, ...) is computed once.
#include <array>
#include <cstddef>
#include <map>
#include <tuple>
#include <vector>

#include "error_model/expression.h"

namespace surveymc::error_model {

/// One operation on numbers; of one argument, b is not looked at.
double computed(Operation operation, double a, double b);

/// What no station changes.
struct Surroundings {
  double dip = 0;          ///< rad, positive down
  double total_field = 0;  ///< nT
  double gravity = 0;      ///< m/s2
  double latitude = 0;     ///< rad; NaN where no formula needs it
  double min_course_length = 10;
  double tortuosity = 0;  ///< rad/m
};

class Graph {
 public:
  struct Node {
    Operation operation = Operation::number;
    std::size_t a = 0, b = 0;  ///< arguments; a node with one has it twice
    double number = 0;
    Variable variable = Variable::md;
    bool is_of_station = false;   ///< its value changes from station to station
    bool is_of_previous = false;  ///< it needs the value of a running sum one station before
  };

  /// Adds a formula; its node. A formula that names Previous is a running sum of its own.
  std::size_t add(const Expression& e);
  /// The node of Sin(Inc) times `factor`.
  std::size_t add_times_sin_inclination(std::size_t factor);

  const std::vector<Node>& nodes() const { return nodes_; }
  /// True if some formula names `v`.
  bool names(Variable v) const { return is_named_[index_of(v)]; }
  /// True for every node that the value of `node` is computed from, and for itself.
  std::vector<bool> needed_by(std::size_t node) const;
  /// Nodes that Evaluation::step computes for the running sum `node`, arguments first.
  std::vector<std::size_t> chain_of(std::size_t node) const;

 private:
  using Key = std::tuple<Operation, std::size_t, std::size_t, double, Variable>;
  std::size_t node(Operation operation, std::size_t a, std::size_t b);
  std::size_t number(double x);
  std::size_t variable(Variable v);
  std::size_t power(std::size_t base, std::size_t exponent);
  std::size_t insert(const Node& n);
  std::size_t step_of(const Expression& e, const ExpressionNode& n, const std::vector<std::size_t>& made);

  std::vector<Node> nodes_;
  std::map<Key, std::size_t> known_;
  std::array<bool, kVariables> is_named_{};
};

/// The values of a graph's nodes at a block of stations; scratch of one thread.
///   Evaluation e(graph, surroundings);
///   fill e.input(v) for every station variable v; e.run(count); read e.output(node)
class Evaluation {
 public:
  static constexpr std::size_t kBlock = 256;

  /// The graph must outlive the evaluation.
  Evaluation(const Graph& graph, const Surroundings& surroundings);

  /// kBlock values, to be filled before run().
  double* input(Variable v) { return inputs_[index_of(v)].data(); }
  /// Computes all nodes but those of running sums at the first `count` stations of the block; count <= kBlock.
  void run(std::size_t count);
  /// kBlock values; a constant is there kBlock times.
  const double* output(std::size_t node) const { return values_[node].data(); }
  /// The value of a running sum at station `i` of the block, whose value one station before is `previous`. `chain` is
  /// graph.chain_of(node).
  double step(const std::vector<std::size_t>& chain, double previous, std::size_t i);

 private:
  using Block = std::array<double, kBlock>;
  const Graph& graph_;
  std::vector<Block> inputs_;
  std::vector<Block> values_;
};

}  // namespace surveymc::error_model
