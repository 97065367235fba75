#pragma once
/// Formulas of weighting functions as trees.
///
///   expr  = term { ("+" | "-") term }           term = unary { ("*" | "/") unary }
///   unary = "-" unary | power                   power = atom [ "^" unary ]
///   atom  = number | name | name "(" expr { "," expr } ")" | "(" expr ")"
///
/// ^ binds tighter than the minus before it (-2^2 = -4), and to the right. Capital and small letters are the same.
/// Functions: Sin Cos Tan Abs Sqrt (= Sqr, VBA's square root) Sign (of 0: 1) Max Min (two or more). Constants: pi, RAD.
#include <cstddef>
#include <string>
#include <vector>

#include "base/error.h"
#include "error_model/variable.h"

namespace surveymc::error_model {

enum class Operation {
  number,
  variable,
  negate,
  add,
  subtract,
  multiply,
  divide,
  power,
  sine,
  cosine,
  tangent,
  absolute,
  square_root,
  sign,
  maximum,
  minimum
};

/// A node of a tree: a number, a variable, or an operation on nodes that stand before it.
struct ExpressionNode {
  Operation operation = Operation::number;
  std::size_t column = 1;              ///< where it stands in the text, from 1: of an operation, its sign or its name
  double number = 0;                   ///< of Operation::number
  Variable variable = Variable::md;    ///< of Operation::variable
  std::vector<std::size_t> arguments;  ///< indices of nodes
};

struct Expression {
  std::string text;                   ///< as written; empty: there is no formula
  std::vector<ExpressionNode> nodes;  ///< arguments before what takes them; the last one is the whole

  bool empty() const { return nodes.empty(); }
  /// True if there is no formula, or the number 0 stands for none.
  bool is_absent() const;
  bool names(Variable v) const;
};

/// A formula is wrong. what() is "column 16: rule".
class FormulaError : public InputError {
 public:
  /// `unknown`: the name that nobody knows, if that is the fault; `known`: those that might have been meant.
  FormulaError(std::size_t column, const std::string& rule, std::string unknown_name = {},
               std::vector<std::string> known_names = {});
  std::size_t column;
  std::string unknown;
  std::vector<std::string> known;
};

/// Throws FormulaError for what is not in the grammar: an unknown name, a wrong number of arguments, an open bracket,
/// text behind the end, a number out of range, brackets more than 100 deep.
Expression parse_expression(const std::string& text);

/// "Sin(...)" ...: names of functions, for messages.
const std::vector<std::string>& function_names();

/// The dimension of a formula. Both sides of + and - agree, and all arguments of Max and Min; arguments of Sin, Cos and
/// Tan are pure, and so is an exponent, which is a number if its base is not pure. `Previous` has the dimension that
/// makes its own formula so: that of the whole. Throws FormulaError that names both sides: "m + pure number".
Dimension dimension_of(const Expression& e);

}  // namespace surveymc::error_model
