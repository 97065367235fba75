#include <cmath>

#include <catch2/catch.hpp>

#include "compare/tails.h"

using namespace surveymc;

TEST_CASE("The table of laws gives an element its own draws, and none to one that nothing draws") {
  random::ReferenceLaws laws;
  const auto law = std::make_shared<const random::MixingLaw>(random::LawOf{.kind = random::LawKind::laplace});
  for (auto& element : laws.elements) element.law = law;
  std::vector<double> total;
  for (int i = 0; i < 200; ++i) total.push_back(i % 2 == 0 ? 2 : -2);
  stats::Tally tally;
  compare::DrawnLaws::add({total}, tally);
  const store::Table t =
      compare::laws_table(laws, {{random::ReferenceElement::total}}, &tally.groups[0], tally.counts.data(), 0.95);
  const auto column = [&](const std::string& name) {
    for (const store::Column& c : t.columns)
      if (c.name == name) return std::get<std::vector<double>>(c.values);
    return std::vector<double>();
  };
  const std::vector<double> sd = column("drawn_sd"), ci68 = column("drawn_ci68"), by_law = column("sd_per_size");
  REQUIRE(sd.size() == 3);
  for (const std::size_t idle : {0u, 1u}) {
    CHECK(std::isnan(sd[idle]));
    CHECK(std::isnan(ci68[idle]));
    CHECK(std::isfinite(by_law[idle]));
  }
  CHECK(std::abs(sd[2] - 2) < 0.01);
  CHECK(std::abs(ci68[2] - 2) < 0.01);
}
