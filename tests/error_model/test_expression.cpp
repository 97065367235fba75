#include "error_model/expression.h"

#include <muParser.h>

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "error_model/model_graph.h"

using namespace surveymc;
using namespace surveymc::error_model;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

namespace {

/// Value of a formula of one station variable, x = MD.
double value(const std::string& text, double x = 0) {
  Graph graph;
  const std::size_t node = graph.add(parse_expression(text));
  Evaluation e(graph, {});
  e.input(Variable::md)[0] = x;
  e.run(1);
  return e.output(node)[0];
}

std::string fault(const std::string& text) {
  try {
    dimension_of(parse_expression(text));
  } catch (const FormulaError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("Operators bind as the grammar says") {
  CHECK(value("-2^2") == -4);
  CHECK(value("(-2)^2") == 4);
  CHECK(value("2^3^2") == 512);
  CHECK(value("2^-1") == 0.5);
  CHECK(value("7 - 4 - 2") == 1);
  CHECK(value("8 / 4 / 2") == 1);
  CHECK(value("2 * -3") == -6);
  CHECK(value("--3") == 3);
  CHECK(value("1 + 2 * 3 ^ 2") == 19);
  CHECK(value("1.5e1 + .5") == 15.5);
  CHECK(value("pi") == kPi);
  CHECK(value("90 * RAD") == 90 * kDegree);
}

TEST_CASE("Functions and names ignore case; Sqr is the square root; the sign of zero is 1") {
  CHECK(value("SQR(16)") == 4);
  CHECK(value("sqrt(16)") == 4);
  CHECK(value("sign(0)") == 1);
  CHECK(value("Sign(-1e-300)") == -1);
  CHECK(value("Max(1, 3, 2)") == 3);
  CHECK(value("min(1, 3, -2)") == -2);
  CHECK(value("Abs(-3) + abs(md)", -2) == 5);
  CHECK(value("Sin(PI/2)") == 1);
  CHECK(find_variable("az") == Variable::azimuth);
  CHECK(find_variable("AZT") == Variable::azimuth);
  CHECK(find_variable("xy_gyro_drift") == Variable::previous);
  CHECK(find_variable("GZRunningSpeed") == Variable::running_speed);
  CHECK_FALSE(find_variable("AzX"));
}

TEST_CASE("What is not a number stays so through Max, Min and Sign") {
  CHECK(std::isnan(value("Sign(Sqrt(MD))", -1)));
  CHECK(std::isnan(value("Max(1, Sqrt(MD))", -1)));
  CHECK(std::isnan(value("Max(Sqrt(MD), 1)", -1)));
  CHECK(std::isnan(value("Min(1, Sqrt(MD))", -1)));
}

TEST_CASE("Small powers are products and roots, with the bits of these") {
  for (const double x : {0.3, 1.7, 123.456}) {
    CHECK(value("MD ^ 2", x) == x * x);
    CHECK(value("MD ^ 3", x) == x * x * x);
    CHECK(value("MD ^ 0.5", x) == std::sqrt(x));
    CHECK(value("MD ^ 0.25", x) == std::sqrt(std::sqrt(x)));
    CHECK(value("MD ^ -1", x) == 1 / x);
    CHECK(value("MD ^ 1", x) == x);
    CHECK(value("MD ^ 1.3", x) == std::pow(x, 1.3));
  }
}

TEST_CASE("Wrong formulas are refused with the column and the rule") {
  CHECK_THAT(fault("Sin(Inc) * Cos(AzX)"), Equals("column 16: unknown variable \"AzX\""));
  CHECK_THAT(fault("Sinn(Inc)"), Equals("column 1: unknown function \"Sinn\""));
  CHECK_THAT(fault("Sin(Inc"), Equals("column 4: this bracket is never closed"));
  CHECK_THAT(fault("2 * (Inc + 1"), Equals("column 5: this bracket is never closed"));
  CHECK_THAT(fault("Inc)"), Equals("column 4: this bracket closes nothing"));
  CHECK_THAT(fault("Inc Inc"), StartsWith("column 5: nothing is expected here"));
  CHECK_THAT(fault("2Inc"), StartsWith("column 2: nothing is expected here"));
  CHECK_THAT(fault("Sin(Inc, 2)"), Equals("column 1: Sin takes one argument, not 2"));
  CHECK_THAT(fault("Max(Inc)"), Equals("column 1: Max takes two or more arguments, not 1"));
  CHECK_THAT(fault(""), Equals("column 1: the formula ends where a value is expected"));
  CHECK_THAT(fault("1 +"), Equals("column 4: the formula ends where a value is expected"));
  CHECK_THAT(fault("1 + * 2"), Equals("column 5: a value is expected, not \"*\""));
  CHECK_THAT(fault("+1"), Equals("column 1: a value is expected, not \"+\""));
  CHECK_THAT(fault("Sin"), Equals("column 1: Sin is a function: its arguments are missing"));
  CHECK_THAT(fault("Sin()"), StartsWith("column 5: a value is expected"));
  CHECK_THAT(fault("1e999"), Equals("column 1: this is no number"));
  CHECK_THAT(fault("If(Inc, 1, 2)"), Equals("column 1: unknown function \"If\""));
  CHECK_THAT(fault("Inc > 1"), StartsWith("column 5: nothing is expected here"));
  CHECK_THAT(fault(std::string(100000, '(')), StartsWith("column 101: brackets"));
  CHECK_THAT(fault(std::string(100000, '-') + "1"), StartsWith("column 1"));
  CHECK_THAT(fault("1" + std::string(200000, '^')), StartsWith("column 3: a value"));
}

TEST_CASE("An unknown name comes with those that might be meant") {
  try {
    parse_expression("Cos(AzX)");
    FAIL();
  } catch (const FormulaError& e) {
    CHECK(e.column == 5);
    CHECK(e.unknown == "AzX");
    CHECK(std::find(e.known.begin(), e.known.end(), "AzM") != e.known.end());
  }
}

TEST_CASE("Dimensions are found, with rational exponents") {
  const auto text = [](const std::string& formula) { return dimension_text(dimension_of(parse_expression(formula))); };
  CHECK(text("1") == "pure number");
  CHECK(text("MD * TVD") == "m2");
  CHECK(text("1 / GField") == "s2/m");
  CHECK(text("GField") == "m/s2");
  CHECK(text("1 / (BField * Cos(Dip))") == "1/nT");
  CHECK(text("MD * BField") == "m.nT");
  CHECK(text("Sqrt(MD)") == "m^(1/2)");
  CHECK(text("MD ^ 0.25") == "m^(1/4)");
  CHECK(text("MD ^ (2 / 3)") == "m^(2/3)");
  CHECK(text("MD ^ -2") == "1/m2");
  CHECK(text("1 / (EarthRate * Cos(Latitude))") == "s");
  CHECK(text("XCLTortuosity * (MD - MDPrev)") == "pure number");
  CHECK(text("Max(1, Sqrt(MinCourseLength / (MD - MDPrev)))") == "pure number");
  CHECK(text("2 ^ Inc") == "pure number");
  CHECK(text("Sign(MD)") == "pure number");
}

TEST_CASE("Previous has the dimension that makes its own formula so") {
  const auto text = [](const std::string& formula) { return dimension_text(dimension_of(parse_expression(formula))); };
  CHECK(text("Previous + (MD - MDPrev) / RunningSpeed") == "s");
  CHECK(text("Sqrt(Previous ^ 2 + (MD - MDPrev) / RunningSpeed)") == "s^(1/2)");
  CHECK(text("Max(Previous, MD)") == "m");
  CHECK(text("Previous") == "pure number");
  CHECK_THAT(fault("Sqrt(Previous) + MD"), StartsWith("column 16: dimensions differ: m^(1/2) + m"));
}

TEST_CASE("Dimensions that do not agree are refused, and both sides are named") {
  CHECK_THAT(fault("MD + 1"), Equals("column 4: dimensions differ: m + pure number"));
  CHECK_THAT(fault("1 - GField"), Equals("column 3: dimensions differ: pure number - m/s2"));
  CHECK_THAT(fault("Max(1, 10 / (MD - MDPrev))"), Equals("column 1: dimensions differ: pure number and 1/m"));
  CHECK_THAT(fault("Sin(MD)"), Equals("column 1: the angle must be a pure number, not m"));
  CHECK_THAT(fault("2 ^ MD"), Equals("column 3: an exponent must be a pure number, not m"));
  CHECK_THAT(fault("MD ^ Inc"), StartsWith("column 4: the exponent of m must be a number"));
  std::string deep = "MD";
  for (int i = 0; i < 60; ++i) deep = "Sqrt(" + deep + ")";
  CHECK_THAT(fault(deep), Equals("column 251: exponents grow beyond 1000 here"));
}

namespace {

double mu_sign(double x) { return x < 0 ? -1 : 1; }

/// A formula at random: every operation and name of the grammar, in muParser's spelling.
std::string random_formula(std::mt19937& g, int depth) {
  const auto pick = [&](int n) { return static_cast<int>(g() % static_cast<unsigned>(n)); };
  const auto inside = [&] { return random_formula(g, depth - 1); };
  static const char* kNames[] = {"MD", "TVD", "Inc", "AzT", "AzM", "Dip", "BField", "GField", "Latitude"};
  if (depth == 0 || pick(6) == 0)
    return pick(3) == 0 ? fmt::format("{:.3f}", 0.1 + pick(3000) / 1000.0) : kNames[pick(9)];
  switch (pick(10)) {
    case 0:
      return fmt::format("({} + {})", inside(), inside());
    case 1:
      return fmt::format("({} - {})", inside(), inside());
    case 2:
      return fmt::format("{} * {}", inside(), inside());
    case 3:
      return fmt::format("{} / ({})", inside(), inside());
    case 4:
      return fmt::format("-({})", inside());
    case 5:
      return fmt::format("({}) ^ {}", inside(), pick(4));
    case 6:
      return fmt::format("Max({}, {}, {})", inside(), inside(), inside());
    case 7:
      return fmt::format("Min({}, {})", inside(), inside());
    case 8:
      return fmt::format("Sqrt(Abs({}))", inside());
    default:
      static const char* kFunctions[] = {"Sin", "Cos", "Tan", "Sign"};
      return fmt::format("{}({})", kFunctions[pick(4)], inside());
  }
}

}  // namespace

TEST_CASE("Random formulas have the values that muParser gives them") {
  std::mt19937 g(18);
  int compared = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const std::string text = random_formula(g, 4);
    const double declination = -0.07;
    double md = 1200.5, tvd = 1100.25, inc = 0.61, azt = 2.2, azm = azt - declination, dip = 1.25, field = 5.1,
           gravity = 9.8, latitude = 1.0;
    mu::Parser p;
    for (const auto& [name, at] : {std::pair{"MD", &md},
                                   {"TVD", &tvd},
                                   {"Inc", &inc},
                                   {"AzT", &azt},
                                   {"AzM", &azm},
                                   {"Dip", &dip},
                                   {"BField", &field},
                                   {"GField", &gravity},
                                   {"Latitude", &latitude}})
      p.DefineVar(name, at);
    p.DefineFun("Sin", static_cast<double (*)(double)>(std::sin));
    p.DefineFun("Cos", static_cast<double (*)(double)>(std::cos));
    p.DefineFun("Tan", static_cast<double (*)(double)>(std::tan));
    p.DefineFun("Sqrt", static_cast<double (*)(double)>(std::sqrt));
    p.DefineFun("Abs", static_cast<double (*)(double)>(std::fabs));
    p.DefineFun("Sign", mu_sign);
    p.DefineFun(
        "Max", +[](const double* x, int n) { return *std::max_element(x, x + n); });
    p.DefineFun(
        "Min", +[](const double* x, int n) { return *std::min_element(x, x + n); });
    p.SetExpr(text);
    const double theirs = p.Eval();

    Graph graph;
    const std::size_t node = graph.add(parse_expression(text));
    Evaluation e(graph, {dip, field, gravity, latitude, 10, 0});
    set_station(e, 0, {.inclination = inc, .azimuth = azt, .declination = declination, .md = md, .tvd = tvd});
    e.run(1);
    const double ours = e.output(node)[0];
    if (!std::isfinite(theirs) || std::abs(theirs) > 1e12) continue;  // next to a pole, rounding decides
    CAPTURE(text);
    // muParser folds constants and takes powers by pow: the same to rounding, which differences may magnify.
    CHECK(ours == Approx(theirs).epsilon(1e-9).margin(1e-9));
    ++compared;
  }
  CHECK(compared > 2000);
}
