#pragma once
/// `[prediction]`: the predictions beyond first order that a study makes.
#include <string>
#include <vector>

#include "config/config.h"
#include "orders/predictions.h"

namespace surveymc::scenario {

/// Of orders::kFormulationNames, in their order; "first" is the study's own prediction.
struct PredictionOrders {
  std::vector<std::string> names{"first"};
  orders::WantedOrders wanted = {};
  bool any() const { return names.size() > 1; }
};

/// Reads prediction.orders, grid and nodes; without `orders`, first order alone. Throws InputError.
PredictionOrders read_prediction_orders(config::ConfigReader& config);

}  // namespace surveymc::scenario
