#include "error_model/model_graph.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "error_model/model.h"
#include "formulas.h"

using namespace surveymc;
using namespace surveymc::error_model;
using Catch::Matchers::StartsWith;

namespace {

using test::function_of;
std::shared_ptr<Function> function_of(const std::string& azimuth, Kind kind = Kind::station) {
  return function_of({{&Function::azimuth, azimuth}}, kind);
}

Term term_of(std::shared_ptr<const Function> f, double sigma = 1) {
  return {"F", std::move(f), sigma, "-", sigma, PropagationMode::systematic};
}

}  // namespace

TEST_CASE("Parts that formulas share are one node") {
  Graph graph;
  const std::size_t a = graph.add(parse_expression("Sin(Inc) * Sin(AzM) / (BField * Cos(Dip))"));
  const std::size_t before = graph.nodes().size();
  CHECK(graph.add(parse_expression("sin(inc) * SIN(AzM) / (bfield * cos(dip))")) == a);
  CHECK(graph.nodes().size() == before);
  graph.add(parse_expression("Sin(Inc) * Sin(AzM) / (BField * Cos(Dip)) * Tan(Dip)"));
  CHECK(graph.nodes().size() == before + 2);
  CHECK(graph.names(Variable::sin_inclination));
  CHECK_FALSE(graph.names(Variable::latitude));
}

TEST_CASE("A block gives what its stations give alone, and constants are there for all of them") {
  Graph graph;
  const std::size_t sum = graph.add(parse_expression("Max(Inc, 0.3) * Tan(Dip) + Cos(Inc / 2)"));
  const std::size_t constant = graph.add(parse_expression("Tan(Dip) * 2"));
  Evaluation block(graph, {.dip = 1.2});
  for (std::size_t i = 0; i < Evaluation::kBlock; ++i)
    block.input(Variable::inclination)[i] = 0.01 * static_cast<double>(i);
  block.run(Evaluation::kBlock);
  for (std::size_t i = 0; i < Evaluation::kBlock; ++i) {
    const double inc = 0.01 * static_cast<double>(i);
    CHECK(block.output(sum)[i] == std::max(inc, 0.3) * std::tan(1.2) + std::cos(inc / 2));
    CHECK(block.output(constant)[i] == std::tan(1.2) * 2);
  }
}

TEST_CASE("A running sum goes from station to station") {
  Graph graph;
  const std::size_t node = graph.add(parse_expression("Sqrt(Previous ^ 2 + (MD - MDPrev) / RunningSpeed)"));
  Evaluation e(graph, {});
  for (std::size_t i = 0; i < 3; ++i) {
    e.input(Variable::md)[i] = 30.0 * static_cast<double>(i + 1);
    e.input(Variable::md_before)[i] = 30.0 * static_cast<double>(i);
    e.input(Variable::running_speed)[i] = 2;
  }
  e.run(3);
  const auto chain = graph.chain_of(node);
  double x = 0;
  for (std::size_t i = 0; i < 3; ++i) x = e.step(chain, x, i);
  CHECK(x == Approx(std::sqrt(45.0)).epsilon(1e-15));
  // A formula that names no Previous is its value at the station.
  Graph plain;
  const std::size_t md = plain.add(parse_expression("MD - MDPrev"));
  Evaluation at(plain, {});
  at.input(Variable::md)[0] = 7;
  at.run(1);
  CHECK(at.step(plain.chain_of(md), 99, 0) == 7);
}

TEST_CASE("Terms that name the same function share it; sinI goes to the azimuth's weight") {
  const auto az = function_of("1"), dbh = function_of("1 / BField");
  const ModelGraph g = model_graph({term_of(az), term_of(dbh), term_of(az)});
  CHECK(g.functions.size() == 2);
  CHECK(g.function_of_term == std::vector<std::size_t>{0, 1, 0});
  Evaluation e(g.graph, {0, 50000, 9.8, 0, 10, 0});
  set_station(e, 0, {.inclination = 0.5, .azimuth = 1});
  e.run(1);
  CHECK(e.output(*g.functions[0].lateral)[0] == std::sin(0.5));
  CHECK(e.output(*g.functions[1].lateral)[0] == std::sin(0.5) * (1 / 50000.0));
  CHECK_FALSE(g.functions[0].depth);
  CHECK_FALSE(g.functions[0].inclination);
}

TEST_CASE("Units have the dimension that a function's magnitude needs") {
  const auto units = [](const char* key, const char* formula) {
    Function f;
    (std::string(key) == "depth" ? f.depth : f.azimuth) = parse_expression(formula);
    return unit_names(magnitude_dimension(f));
  };
  CHECK(units("depth", "1") == "\"m\" or \"ft\"");
  CHECK(units("depth", "MD") == "\"-\", \"deg\" or \"rad\"");
  CHECK(units("depth", "MD * TVD") == "\"1/m\" or \"1/ft\"");
  CHECK(units("azimuth", "1 / GField") == "\"m/s2\"");
  CHECK(units("azimuth", "1 / BField") == "\"nT\", \"uT\", \"deg.nT\" or \"rad.nT\"");
  CHECK(units("azimuth", "1 / EarthRate") == "\"deg/hr\"");
  CHECK(units("azimuth", "Sqrt(MD / RunningSpeed)") == "\"deg/sqr(hr)\"");
  CHECK(units("azimuth", "MD * BField") == "1/m/nT");

  const Dimension rate = kPure / kSecond;
  CHECK(unit_factor(rate, "deg/hr") == Approx(kDegree / 3600).epsilon(1e-15));
  CHECK(unit_factor(rate.to_power({1, 2}), "deg/sqr(hr)") == Approx(kDegree / 60).epsilon(1e-15));
  CHECK(unit_factor(rate.to_power({1, 2}), "deg/sqrt(hr)") == unit_factor(rate.to_power({1, 2}), "deg/sqr(hr)"));
  CHECK(unit_factor(rate, "deg") == 0);
  CHECK(unit_factor(kMetre, "ft") == 0.3048);
  CHECK(unit_factor(kNanotesla, "deg.nT") == Approx(kDegree).epsilon(1e-15));

  Function mixed = *function_of({{&Function::depth, "1"}, {&Function::inclination, "Sin(Inc)"}});
  CHECK_THROWS_WITH(magnitude_dimension(mixed),
                    StartsWith("column 1: depth wants a magnitude in m, and inclination one"));
  mixed.inclination = parse_expression("0");  // stands for none
  CHECK(magnitude_dimension(mixed) == kMetre);
}

TEST_CASE("A weight that is singular in a vertical hole is found, whatever hides it") {
  const auto fault = [](const std::string& azimuth) { return vertical_fault(*function_of(azimuth), {}); };
  for (const char* good : {"1", "Sin(Inc) * Sin(AzM)", "Tan(Inc)", "1 / Cos(Inc)", "-Cos(AzM) / (BField * Cos(Dip))",
                           "1 / Sqrt(Sin(Inc))", "0"})
    CHECK(fault(good) == "");
  for (const char* bad : {"1 / Sin(Inc)", "1 / Tan(Inc) - Cos(AzM)", "Tan(pi / 2 - Inc)", "1 / (1 - Cos(Inc))",
                          "Max(Sin(Abs(AzT - AzPrev)), XCLTortuosity * (MD - MDPrev) / Sin(Inc))"})
    CHECK_THAT(fault(bad), StartsWith("is singular in a vertical hole"));
  CHECK(vertical_fault(*function_of("Previous + 1 / Sin(Inc)", Kind::continuous), {}) == "");
}

TEST_CASE("Vertical formulas must be the limit of the others") {
  const char* kFactor = "Max(1, Sqrt(MinCourseLength / (MD - MDPrev)))";
  Function xym3 = *function_of({{&Function::inclination, fmt::format("Abs(Cos(Inc)) * Cos(AzT) * {}", kFactor)},
                                {&Function::azimuth, fmt::format("-Abs(Cos(Inc)) * Sin(AzT) / Sin(Inc) * {}", kFactor)},
                                {&Function::vertical_north, kFactor}});
  CHECK(vertical_fault(xym3, {}) == "");
  // As printed: the azimuth lacks its minus sign.
  xym3.azimuth = parse_expression(fmt::format("Cos(Inc) * Sin(AzT) / Sin(Inc) * {}", kFactor));
  CHECK_THAT(vertical_fault(xym3, {}), StartsWith("the vertical formulas are not the limit of the others"));
  // As printed: the same displacement north and east, and a factor RAD that the azimuth does not have.
  Function xcla;
  xcla.kind = Kind::course;
  xcla.azimuth = parse_expression("Max(Sin(Abs(AzT - AzPrev)), XCLTortuosity * (MD - MDPrev) / Sin(Inc))");
  xcla.vertical_north = xcla.vertical_east = parse_expression("XCLTortuosity * RAD * (MD - MDPrev)");
  CHECK_THAT(vertical_fault(xcla, {}), StartsWith("the vertical formulas are not the limit"));
  // Fine at 0.001 deg, and no number where it is used.
  Function tilt = *function_of({{&Function::azimuth, "-Sin(AzT) / Sin(Inc)"}, {&Function::inclination, "Cos(AzT)"}});
  for (const char* bad : {"Sin(Inc) / Inc", "Tan(Inc) / Sin(Inc)"}) {
    tilt.vertical_north = parse_expression(bad);
    CHECK_THAT(vertical_fault(tilt, {}), StartsWith("the vertical formulas are not finite at 0 deg"));
  }
  tilt.vertical_north = parse_expression("1");
  CHECK(vertical_fault(tilt, {}) == "");
  const auto cna = function_of({{&Function::azimuth, "1 / Sin(Inc)"},
                                {&Function::vertical_north, "-Sin(AzT)"},
                                {&Function::vertical_east, "Cos(AzT)"}});
  CHECK(vertical_fault(*cna, {}) == "");
}

TEST_CASE("A term without any effect is found") {
  Surroundings s{72 * kDegree, 50000, 9.8, 1, 10, 0};
  CHECK_FALSE(is_without_effect(term_of(function_of("1")), s));
  CHECK(is_without_effect(term_of(function_of("1"), 0), s));
  CHECK(is_without_effect(term_of(function_of("Sin(Inc) - Sin(Inc)")), s));
  CHECK(is_without_effect(term_of(function_of("Sin(Inc) ^ 2 + Cos(Inc) ^ 2 - 1"), 0.001), s));
  CHECK_FALSE(is_without_effect(term_of(function_of("Max(0, Cos(Inc) - 0.99)")), s));
  s.dip = 0;
  CHECK(is_without_effect(term_of(function_of("Tan(Dip)")), s));
}

TEST_CASE("A course error that needs a turn of the hole has an effect") {
  const Surroundings s{72 * kDegree, 50000, 9.8, 1, 10, 0};  // without tortuosity
  const auto turn =
      function_of({{&Function::inclination, "Max(Abs(Inc - IncPrev), XCLTortuosity * (MD - MDPrev))"}}, Kind::course);
  CHECK_FALSE(is_without_effect(term_of(turn), s));
  const auto sideways = function_of({{&Function::lateral, "Sin(Inc) * Sin(Abs(AzT - AzPrev))"}}, Kind::course);
  CHECK_FALSE(is_without_effect(term_of(sideways), s));
  sideways->lateral = parse_expression("Sin(Inc) * (AzT - AzPrev - (AzT - AzPrev))");
  CHECK(is_without_effect(term_of(sideways), s));
}

TEST_CASE("Functions are the same by their formulas, not by their names or how they are written") {
  const auto same = [](const std::shared_ptr<Function>& a, const std::shared_ptr<Function>& b) {
    CHECK(have_same_formulas(a, b) == have_same_formulas(b, a));
    return have_same_formulas(a, b);
  };
  auto renamed = function_of("sin( INC )*AzM");
  renamed->name = "G";
  CHECK(same(function_of("Sin(Inc) * AzM"), renamed));
  CHECK_FALSE(same(function_of("Sin(Inc)"), function_of("Sin(Inc) + 1")));
  CHECK_FALSE(same(function_of("1"), function_of("1", Kind::course)));
  // A lateral formula is sinI times the azimuth's.
  const auto lateral = function_of({{&Function::lateral, "Sin(Inc) * AzM"}});
  CHECK(same(function_of("AzM"), lateral));
  lateral->depth = parse_expression("MD");
  CHECK_FALSE(same(function_of("AzM"), lateral));
  CHECK(same(function_of("Previous + MD", Kind::continuous), function_of("Previous + MD", Kind::continuous)));
  CHECK_FALSE(same(function_of("Previous + MD", Kind::continuous), function_of("Previous - MD", Kind::continuous)));
}

TEST_CASE("The angle to magnetic east or west is that between the directions") {
  CHECK(angle_to_east_west(90 * kDegree, 90 * kDegree) == Approx(0).margin(1e-7));
  CHECK(angle_to_east_west(90 * kDegree, 270 * kDegree) == Approx(0).margin(1e-7));
  CHECK(angle_to_east_west(90 * kDegree, 60 * kDegree) == Approx(30 * kDegree).epsilon(1e-13));
  CHECK(angle_to_east_west(75 * kDegree, 90 * kDegree) == Approx(15 * kDegree).epsilon(1e-13));
  CHECK(angle_to_east_west(0, 90 * kDegree) == Approx(90 * kDegree).epsilon(1e-13));
}
