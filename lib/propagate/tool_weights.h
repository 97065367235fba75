#pragma once
/// Weighting functions of a tool at the stations of a well, block after block. The covariance (tool_covariance.h) and
/// drawn errors (well_errors.h) use them.
#include <array>
#include <cstddef>
#include <vector>

#include "error_model/model_graph.h"
#include "propagate/gyro_sections.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::propagate {

inline constexpr std::size_t kStationBlock = error_model::Evaluation::kBlock;
using StationColumn = std::array<double, kStationBlock>;

/// Sines and cosines of all stations, and tangents.
struct StationDirections {
  std::vector<double> sin_i, cos_i, sin_a, cos_a, sin_am, cos_am;
  std::vector<double> north, east;  ///< of the tangents; down is cos_i

  StationDirections(const survey::Survey& survey, double declination);
};

/// Weights of one function at the stations of a block; null where it has none.
struct BlockWeights {
  const double *depth = nullptr, *inclination = nullptr, *lateral = nullptr;
  const double *vertical_north = nullptr, *vertical_east = nullptr;  ///< both or neither
  double largest_depth = 0, largest_angle = 0;                       ///< absolute; infinite if one is no number
  /// The lateral weight in two parts, sinI azimuth + tilt, where RunWeights is asked for them; null with `lateral`.
  const double *azimuth = nullptr, *tilt = nullptr;
};

/// The functions of one tool run, evaluated block after block.
class RunWeights {
 public:
  /// `with_tilt`: also BlockWeights::azimuth and tilt. The tilt is the part of the lateral weight that stays as the
  /// hole becomes vertical, with everything but Sin(Inc) kept:
  ///   lateral formula                    tilt = its value with Sin(Inc) = 0,  azimuth = (lateral - tilt) / sinI;
  ///                                      the third kind of tilt, should it divide by Sin(Inc)
  ///   azimuth formula                    tilt = 0: the reader of models refuses one that is singular ...
  ///   ... but with vertical formulas     tilt = even part of lateral in Sin(Inc), at Sin(Inc) = 1e-4
  ///   one that names Inc outside of Sin(Inc), Cos(Inc), of the first or the third kind: tilt = lateral
  ///   of a hybrid gyro, kept or summed   tilt = 0
  /// At sinI < 1e-4 `azimuth` is the odd part of lateral over Sin(Inc), at Sin(Inc) = 1e-4.
  RunWeights(const error_model::Model& model, const error_model::ModelGraph& graph, const survey::Survey& survey,
             const std::vector<double>& tvd, const StationDirections& directions, const survey::ReferenceField& field,
             double latitude, bool with_tilt = false);

  /// Of a run with the stations first to end - 1, before its first block.
  void begin_run(const std::vector<GyroStretch>& stretches);
  /// The stations first to first + count - 1.
  void evaluate(std::size_t first, std::size_t count);
  const BlockWeights& of_term(std::size_t term) const { return weights_[graph_.function_of_term[term]]; }

 private:
  /// A stationary or continuous function of a tool with a gyro.
  struct ByMode {
    double sum = 0;                                 ///< of a continuous function, at the station before
    double held_inclination = 0, held_azimuth = 0;  ///< of a stationary function, since the initialisation
    StationColumn inclination, lateral, azimuth;
  };
  /// How the lateral weight of a function is split into azimuth and tilt.
  enum class Parting { none, azimuth_alone, at_zero_sine, even_part, tilt_alone };
  struct Parts {
    Parting parting = Parting::none;
    StationColumn azimuth, tilt;
  };

  void fill_inputs(std::size_t first, std::size_t count);
  /// Zones that overlap have one speed (the reader of models checks that); outside of all zones nothing grows.
  double speed_at(double inclination) const;
  BlockWeights weights_of(std::size_t f, std::size_t first, std::size_t count);
  const GyroStretch& stretch_at(std::size_t k) const;
  void run_sums(std::size_t f, std::size_t first, std::size_t count, BlockWeights& w);
  void hold_values(std::size_t f, std::size_t first, std::size_t count, BlockWeights& w);
  void initialise(const error_model::FunctionNodes& n, const GyroStretch& stretch, ByMode& m) const;
  Parting parting_of(const error_model::FunctionNodes& n) const;
  void evaluate_parts(std::size_t first, std::size_t count);

  const error_model::Model& model_;
  const error_model::ModelGraph& graph_;
  const survey::Survey& survey_;
  const std::vector<double>& tvd_;
  const StationDirections& directions_;
  double declination_;
  error_model::Surroundings surroundings_;
  error_model::Evaluation evaluation_;
  std::vector<BlockWeights> weights_;
  std::vector<ByMode> modes_;
  std::vector<Parts> parts_;  ///< empty: not asked for
  std::vector<GyroStretch> stretches_;
  StationColumn zeros_;
};

/// Which stations of a run share an error of a source.
enum class Grouping {
  station,  ///< none: an error of its own at every station
  run,      ///< all
  mixed     ///< those of a group; group_begins() says where a group begins
};
Grouping grouping_of(const error_model::Term& term, bool has_gyro);

/// True where an error of a gyro that is drawn anew begins: at every stationary station, and with every section.
std::array<bool, kStationBlock> group_begins(const std::vector<GyroStretch>& stretches, std::size_t first,
                                             std::size_t count);

/// The azimuth of the station before, within 180 deg of the azimuth of `at`; the latter itself if the station before
/// is vertical. rad
double azimuth_before(const survey::Station& before, const survey::Station& at);

}  // namespace surveymc::propagate
