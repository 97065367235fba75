#pragma once
/// `[prediction]`: the predictions beyond first order that a study makes.
#include <string>
#include <vector>

#include "config/config.h"
#include "estimate/estimator.h"
#include "orders/predictions.h"
#include "random/reference_laws.h"
#include "sensor/magnetometer.h"

namespace surveymc::scenario {

/// Of orders::kFormulationNames, in their order; "first" is the study's own prediction.
struct PredictionOrders {
  std::vector<std::string> names{"first"};
  orders::WantedOrders wanted = {};
  bool any() const { return names.size() > 1; }
};

/// Reads prediction.orders, grid and nodes; without `orders`, first order alone. Throws InputError.
PredictionOrders read_prediction_orders(config::ConfigReader& config);
/// The same of positions after multi-station analysis (analysis/msa_chain.h), which need Gaussian noise and an
/// estimator that fits (Bh, Bv).
PredictionOrders read_msa_orders(config::ConfigReader& config, const sensor::NoiseModel& noise,
                                 const std::string& estimator);

/// Throws InputError where the reference is not normal, or its errors last from station to station. Predictions beyond
/// first order are expansions in independent normals about their means: the V of a law would be one through its
/// quantile, but sqrt(V) is far from linear or quadratic in it (docs/tails.md).
void require_orders_of(config::ConfigReader& config, const random::ReferenceLaws& laws, bool disturbed,
                       const PredictionOrders& orders);

}  // namespace surveymc::scenario
