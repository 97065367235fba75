#include "scenario/prediction_orders.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "estimate/estimators.h"

namespace surveymc::scenario {

PredictionOrders read_prediction_orders(config::ConfigReader& c) {
  PredictionOrders p;
  if (!c.has("prediction.orders")) return p;
  const std::vector<std::string> given = c.texts(
      "prediction.orders",
      "predictions of the position: 'first', 'second', 'unscented', 'cubature5', 'profile'; without it the first");
  const auto& all = orders::kFormulationNames;
  for (const std::string& name : given)
    c.require(std::find(all.begin(), all.end(), name) != all.end(), "prediction.orders",
              fmt::format("must be a list of \"{}\"", fmt::join(all, "\", \"")));
  const auto has = [&given](const char* name) { return std::find(given.begin(), given.end(), name) != given.end(); };
  p.names.clear();
  for (const char* name : all)
    if (has(name) || std::string(name) == "first") p.names.emplace_back(name);
  p.wanted.second = has("second");
  p.wanted.unscented = has("unscented");
  p.wanted.cubature5 = has("cubature5");
  p.wanted.profile = has("profile");
  if (!p.wanted.profile) return p;
  p.wanted.options.grid =
      static_cast<int>(c.integer("prediction.grid", 25, 24001, "points of the profile's path, within 6 sigma", 241));
  p.wanted.options.nodes = static_cast<int>(
      c.integer("prediction.nodes", 3, 241, "nodes of first order around the profile's path, within 4 sigma", 9));
  c.require(p.wanted.options.grid % 2 == 1, "prediction.grid", "must be odd: one point is the centre");
  c.require(p.wanted.options.nodes % 4 == 1, "prediction.nodes", "must be 5, 9, 13, ...: every other node is a check");
  return p;
}

PredictionOrders read_msa_orders(config::ConfigReader& c, const sensor::NoiseModel& noise,
                                 const std::string& estimator) {
  PredictionOrders p = read_prediction_orders(c);
  if (!p.any()) return p;
  c.require(noise.law == sensor::NoiseLaw::gaussian, "prediction.orders",
            "beyond \"first\" are made of normals: noise.law must be \"gaussian\"");
  c.require(estimate::estimator_kind(estimator).takes_subset, "prediction.orders",
            fmt::format("beyond \"first\" have no derivatives of estimator.name = \"{}\", which does not fit (Bh, Bv)",
                        estimator));
  return p;
}

void require_orders_of(config::ConfigReader& c, const random::ReferenceLaws& laws, bool disturbed,
                       const PredictionOrders& orders) {
  c.require(!orders.any() || !laws.any(), "prediction.orders",
            "beyond \"first\" are expansions in normals, and the variance V of a law is too far from one: leave them "
            "out, trials and the table `tails` have the laws; or leave out reference_law");
  c.require(!orders.any() || !disturbed, "prediction.orders", "beyond \"first\" have no [disturbance]");
}

}  // namespace surveymc::scenario
