#pragma once
/// The weighting functions of a model as one graph of shared formulas.
#include <memory>
#include <optional>
#include <vector>

#include "error_model/graph.h"
#include "error_model/model.h"

namespace surveymc::error_model {

/// Nodes of one function's formulas; nothing where there is none.
struct FunctionNodes {
  std::shared_ptr<const Function> function;
  std::optional<std::size_t> depth, inclination;
  std::optional<std::size_t> lateral;  ///< sinI times the azimuth's weight; not of a continuous function
  std::optional<std::size_t> azimuth;  ///< as written; of a stationary or continuous function
  std::optional<std::size_t> vertical_north, vertical_east;
  std::vector<std::size_t> azimuth_chain;  ///< of a continuous function: Evaluation::step

  bool has_vertical() const { return vertical_north || vertical_east; }
};

struct ModelGraph {
  Graph graph;
  std::vector<FunctionNodes> functions;       ///< each once
  std::vector<std::size_t> function_of_term;  ///< index into `functions`
};
ModelGraph model_graph(const std::vector<Term>& terms);

/// What the formulas of a model take for constant. `latitude` in rad; NaN where no formula needs it.
Surroundings surroundings_of(const Parameters& p, double dip, double total_field, double gravity, double latitude);

/// A station for a formula alone, outside of a survey.
struct SampleStation {
  double inclination = 0, azimuth = 0;    ///< rad
  double declination = 0;                 ///< rad
  double md = 1000, dmd = 30, tvd = 900;  ///< m
  double noise_reduction = 1;
  double running_speed = 1;  ///< m/s
  /// rad, of the station before; without them it has the same.
  std::optional<double> inclination_before = {}, azimuth_before = {};
};
void set_station(Evaluation& evaluation, std::size_t i, const SampleStation& s);

/// Effect of one unit of an error source. Of a course function: over metres of the course.
struct Weights {
  double depth = 0;        ///< m
  double inclination = 0;  ///< rad
  double lateral = 0;      ///< sinI w_A, rad
};
/// Of a station or stationary function at one station.
Weights weights_at(const Function& f, const SampleStation& s, const Surroundings& surroundings);

// ---------------------------------------------------------------------------------------------- checks of a function

/// What is wrong with a function in a vertical hole, for a message; empty if nothing is.
///   - sinI times its azimuth weight does not vanish as I -> 0, and there are no vertical formulas
///   - its vertical formulas are not finite at 0 deg
///   - they are not the limit of the others: compared at I = 0.001 deg, 24 azimuths, 1e-3 of the largest
/// A continuous function is not looked at: its zone keeps it from a vertical hole.
std::string vertical_fault(const Function& f, const Parameters& parameters);

/// True if both functions have the same formulas, whatever their names and however they are written.
bool have_same_formulas(const std::shared_ptr<const Function>& a, const std::shared_ptr<const Function>& b);

/// True if one standard deviation of the term moves nothing by more than 1e-15 (m or rad), at any inclination and
/// azimuth, whether the hole turns from the station before or not.
bool is_without_effect(const Term& term, const Surroundings& surroundings);

}  // namespace surveymc::error_model
