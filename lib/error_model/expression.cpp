#include "error_model/expression.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "base/units.h"
#include "error_model/graph.h"

namespace surveymc::error_model {

bool Expression::is_absent() const {
  return nodes.empty() || (nodes.size() == 1 && nodes[0].operation == Operation::number && nodes[0].number == 0);
}

bool Expression::names(Variable v) const {
  return std::any_of(nodes.begin(), nodes.end(),
                     [&](const ExpressionNode& n) { return n.operation == Operation::variable && n.variable == v; });
}

FormulaError::FormulaError(std::size_t at, const std::string& rule, std::string unknown_name,
                           std::vector<std::string> known_names)
    : InputError(fmt::format("column {}: {}", at, rule)),
      column(at),
      unknown(std::move(unknown_name)),
      known(std::move(known_names)) {}

namespace {

struct NamedOperation {
  std::string_view name;
  Operation operation;
  bool takes_many = false;  // two or more arguments; else one
};
constexpr std::array kOperations = std::to_array<NamedOperation>({
    {"Sin", Operation::sine},
    {"Cos", Operation::cosine},
    {"Tan", Operation::tangent},
    {"Abs", Operation::absolute},
    {"Sqrt", Operation::square_root},
    {"Sqr", Operation::square_root},
    {"Sign", Operation::sign},
    {"Max", Operation::maximum, true},
    {"Min", Operation::minimum, true},
});

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool begins_name(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_'; }

/// Recursive descent over the text; nodes are appended after their arguments.
class Parser {
 public:
  explicit Parser(const std::string& text) : text_(text) {}

  Expression whole() {
    nested(&Parser::expr);
    skip_blanks();
    if (at_ < text_.size())
      fail(text_[at_] == ')' ? "this bracket closes nothing"
                             : fmt::format("nothing is expected here, but \"{}\" stands: an operator is missing",
                                           std::string_view(text_).substr(at_, 12)));
    out_.text = text_;
    return std::move(out_);
  }

 private:
  static constexpr int kDeepest = 100;

  [[noreturn]] void fail(const std::string& rule) const { throw FormulaError(at_ + 1, rule); }

  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  char next() {
    skip_blanks();
    return at_ < text_.size() ? text_[at_] : '\0';
  }

  std::size_t add(Operation operation, std::size_t column, std::vector<std::size_t> arguments, double number = 0,
                  Variable variable = Variable::md) {
    out_.nodes.push_back({operation, column, number, variable, std::move(arguments)});
    return out_.nodes.size() - 1;
  }

  /// Reads a part that brackets or signs hold.
  std::size_t nested(std::size_t (Parser::*part)()) {
    if (++depth_ > kDeepest) fail(fmt::format("brackets and signs are nested more than {} deep", kDeepest));
    const std::size_t node = (this->*part)();
    --depth_;
    return node;
  }

  std::size_t expr() {
    std::size_t left = term();
    for (char c = next(); c == '+' || c == '-'; c = next()) {
      const std::size_t column = ++at_;
      left = add(c == '+' ? Operation::add : Operation::subtract, column, {left, term()});
    }
    return left;
  }

  std::size_t term() {
    std::size_t left = unary();
    for (char c = next(); c == '*' || c == '/'; c = next()) {
      const std::size_t column = ++at_;
      left = add(c == '*' ? Operation::multiply : Operation::divide, column, {left, unary()});
    }
    return left;
  }

  std::size_t unary() {
    if (next() != '-') return power();
    const std::size_t column = ++at_;
    return add(Operation::negate, column, {nested(&Parser::unary)});
  }

  std::size_t power() {
    const std::size_t base = atom();
    if (next() != '^') return base;
    const std::size_t column = ++at_;
    return add(Operation::power, column, {base, nested(&Parser::unary)});
  }

  std::size_t atom() {
    const char c = next();
    if (c == '(') return bracket();
    if (is_digit(c) || c == '.') return number();
    if (begins_name(c)) return name();
    if (c == '\0') fail("the formula ends where a value is expected");
    fail(fmt::format("a value is expected, not \"{}\"", c));
  }

  std::size_t bracket() {
    const std::size_t open = ++at_;
    const std::size_t inside = nested(&Parser::expr);
    close(open);
    return inside;
  }

  /// `open`: column of the bracket that is to be closed.
  void close(std::size_t open) {
    if (next() != ')') throw FormulaError(open, "this bracket is never closed");
    ++at_;
  }

  std::size_t number() {
    double x = 0;
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), x);
    if (error != std::errc() || !std::isfinite(x)) fail("this is no number");
    const std::size_t column = at_ + 1;
    at_ += static_cast<std::size_t>(end - begin);
    return add(Operation::number, column, {}, x);
  }

  std::size_t name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (begins_name(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string word = text_.substr(begin, at_ - begin);
    const std::size_t column = begin + 1;
    const auto function = std::find_if(kOperations.begin(), kOperations.end(),
                                       [&](const NamedOperation& f) { return same_name(f.name, word); });
    if (next() == '(') {
      if (function == kOperations.end())
        throw FormulaError(column, fmt::format("unknown function \"{}\"", word), word, function_names());
      return call(*function, column);
    }
    if (function != kOperations.end())
      throw FormulaError(column, fmt::format("{} is a function: its arguments are missing", function->name));
    if (same_name(word, "pi")) return add(Operation::number, column, {}, kPi);
    if (same_name(word, "RAD")) return add(Operation::number, column, {}, kDegree);
    const auto variable = find_variable(word);
    if (!variable) throw FormulaError(column, fmt::format("unknown variable \"{}\"", word), word, variable_names());
    return add(Operation::variable, column, {}, 0, *variable);
  }

  std::size_t call(const NamedOperation& function, std::size_t column) {
    const std::size_t open = ++at_;
    std::vector<std::size_t> arguments{nested(&Parser::expr)};
    while (next() == ',') {
      ++at_;
      arguments.push_back(nested(&Parser::expr));
    }
    close(open);
    const std::size_t count = arguments.size();
    if (function.takes_many ? count < 2 : count != 1)
      throw FormulaError(column, fmt::format("{} takes {}, not {}", function.name,
                                             function.takes_many ? "two or more arguments" : "one argument", count));
    return add(function.operation, column, std::move(arguments));
  }

  const std::string& text_;
  std::size_t at_ = 0;
  int depth_ = 0;
  Expression out_;
};

// ---------------------------------------------------------------------------------------------------------- dimensions

/// A dimension, or nothing where that of Previous would decide it and is not known yet.
using Guess = std::optional<Dimension>;

/// The number that a part without variables stands for; nothing for others.
std::optional<double> constant_value(const Expression& e, std::size_t i) {
  const ExpressionNode& n = e.nodes[i];
  std::vector<double> x;
  for (const std::size_t a : n.arguments) {
    const auto value = constant_value(e, a);
    if (!value) return {};
    x.push_back(*value);
  }
  if (n.operation == Operation::number) return n.number;
  constexpr std::array kArithmetic{Operation::negate, Operation::add, Operation::subtract, Operation::multiply,
                                   Operation::divide};
  if (std::find(kArithmetic.begin(), kArithmetic.end(), n.operation) == kArithmetic.end()) return {};
  return computed(n.operation, x.front(), x.back());
}

class DimensionCheck {
 public:
  DimensionCheck(const Expression& e, Guess previous) : e_(e), previous_(previous) {}

  Guess whole() {
    for (const ExpressionNode& n : e_.nodes) {
      found_.push_back(of(n));
      if (found_.back() && !is_modest(*found_.back())) throw FormulaError(n.column, "exponents grow beyond 1000 here");
    }
    return found_.back();
  }

 private:
  /// Products of two modest exponents are within an int.
  static bool is_modest(const Dimension& d) {
    const auto modest = [](const Exponent& e) { return std::abs(e.over) <= 1000 && e.under <= 1000; };
    return modest(d.metre) && modest(d.second) && modest(d.nanotesla);
  }

  Guess of(const ExpressionNode& n) const {
    switch (n.operation) {
      case Operation::number:
        return kPure;
      case Operation::variable:
        return n.variable == Variable::previous ? previous_ : Guess(error_model::dimension_of(n.variable));
      case Operation::negate:
      case Operation::absolute:
        return argument(n, 0);
      case Operation::sign:
        return kPure;
      case Operation::add:
        return alike(n, " + ");
      case Operation::subtract:
        return alike(n, " - ");
      case Operation::maximum:
      case Operation::minimum:
        return alike(n, " and ");
      case Operation::multiply:
        return both(n, [](const Dimension& a, const Dimension& b) { return a * b; });
      case Operation::divide:
        return both(n, [](const Dimension& a, const Dimension& b) { return a / b; });
      case Operation::square_root:
        return argument(n, 0) ? Guess(argument(n, 0)->to_power({1, 2})) : Guess();
      case Operation::power:
        return power(n);
      case Operation::sine:
      case Operation::cosine:
      case Operation::tangent:
        break;
    }
    const Guess a = argument(n, 0);
    if (a && !a->is_pure())
      throw FormulaError(n.column, fmt::format("the angle must be a pure number, not {}", dimension_text(*a)));
    return kPure;
  }

  const Guess& argument(const ExpressionNode& n, std::size_t i) const { return found_[n.arguments[i]]; }

  template <class Combine>
  Guess both(const ExpressionNode& n, const Combine& combine) const {
    const Guess &a = argument(n, 0), &b = argument(n, 1);
    return a && b ? Guess(combine(*a, *b)) : Guess();
  }

  Guess alike(const ExpressionNode& n, const char* between) const {
    Guess first;
    for (std::size_t i = 0; i < n.arguments.size(); ++i) {
      const Guess& a = argument(n, i);
      if (!a) continue;
      if (first && *a != *first)
        throw FormulaError(
            n.column, fmt::format("dimensions differ: {}{}{}", dimension_text(*first), between, dimension_text(*a)));
      first = a;
    }
    return first;
  }

  Guess power(const ExpressionNode& n) const {
    const Guess &base = argument(n, 0), &exponent = argument(n, 1);
    if (exponent && !exponent->is_pure())
      throw FormulaError(n.column, fmt::format("an exponent must be a pure number, not {}", dimension_text(*exponent)));
    if (!base || base->is_pure()) return base;
    const auto value = constant_value(e_, n.arguments[1]);
    const auto fraction = value ? exponent_of(*value) : std::nullopt;
    if (!fraction)
      throw FormulaError(n.column,
                         fmt::format("the exponent of {} must be a number such as 2 or 0.5", dimension_text(*base)));
    return base->to_power(*fraction);
  }

  const Expression& e_;
  Guess previous_;
  std::vector<Guess> found_;
};

}  // namespace

Expression parse_expression(const std::string& text) { return Parser(text).whole(); }

const std::vector<std::string>& function_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const NamedOperation& f : kOperations) out.emplace_back(f.name);
    return out;
  }();
  return names;
}

Dimension dimension_of(const Expression& e) {
  const Guess whole = DimensionCheck(e, {}).whole();
  if (!e.names(Variable::previous)) return *whole;
  // What the other summands say is what Previous must have: then the whole has it, too.
  const Dimension own = whole.value_or(kPure);
  const Dimension again = DimensionCheck(e, own).whole().value_or(kPure);
  if (again != own)
    throw FormulaError(1, fmt::format("no dimension of Previous makes its own formula so: {} gives {}",
                                      dimension_text(own), dimension_text(again)));
  return own;
}

}  // namespace surveymc::error_model
