#pragma once
/// `[prediction]`: the predictions beyond first order that a study makes.
#include <string>
#include <vector>

#include "config/config.h"
#include "estimate/estimator.h"
#include "orders/predictions.h"
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

}  // namespace surveymc::scenario
