#pragma once
/// Runs of a well under a base code, and what their correction leaves.
#include <memory>

#include "analysis/code_comparison.h"
#include "orders/difference_chain.h"
#include "random/stream.h"
#include "sensor/disturbed_runs.h"
#include "survey/corrected_position.h"
#include "survey/readings.h"

namespace surveymc::studies::corrected_codes {

/// Of a block of runs, before (0) and after (1) the correction.
struct CorrectedRun {
  survey::LaneArray position[2];           ///< of the last station: N, E, V, m
  survey::LaneArray lateral[2];            ///< of the direction at every measured station, rad
  survey::LaneArray converged, ambiguous;  ///< 1 or 0; ambiguous: some station's minimum is not the lowest
};

class CorrectedRuns {
 public:
  /// `comparison`: of this well in this field.
  CorrectedRuns(const analysis::CodeCase& which, const survey::Survey& well, const survey::ReferenceField& field,
                const analysis::CodeComparison& comparison);

  /// Draws the reference by these laws, but not where the normals of a run are given (chain).
  void set_laws(const random::ReferenceLaws& laws) { sensor::set_mixing(setup_, laws, laws.global, laws.random); }
  const sensor::DisturbedRunSetup& setup() const { return setup_; }
  int stations() const { return setup_.stations(); }
  const Eigen::Vector3d& position() const { return position_; }  ///< the true one of the last station
  /// Trials first, first + 1, ...; `made`: as of sensor::draw_disturbed_runs().
  CorrectedRun run(const random::Stream& stream, std::uint64_t first, int count,
                   const survey::LaneArray* made = nullptr) const;

  /// The error of the last position after the correction as a function of the normals of a run: those of the errors
  /// that are drawn. The tool is not turned. `this` must outlive it. Not of Kind::parameters: given normals leave |g|
  /// out.
  orders::DifferenceChain chain() const;
  /// Names of these normals: analysis::kCodeInputNames.
  std::vector<std::string> inputs() const;

 private:
  /// `gravity`: |g| of every station as it is read (m/s2), a row a station. `stream` and `first` address the subsets of
  /// a robust fit. Only Kind::parameters looks at them.
  CorrectedRun correct(survey::ReadingBlock readings, const survey::LaneArray& gravity, const random::Stream& stream,
                       std::uint64_t first) const;
  bool reads_gravity() const { return which_.correction.kind == analysis::Correction::Kind::parameters; }
  /// Corrects the readings of both triads.
  void correct_parameters(survey::ReadingBlock& readings, const survey::LaneArray& gravity,
                          const random::Stream& stream, std::uint64_t first, survey::LaneArray& converged) const;
  /// Corrects readings station by station: what is left of each is an uncorrected reading.
  void correct_stations(survey::ReadingBlock& readings, survey::LaneArray& converged,
                        survey::LaneArray& ambiguous) const;
  /// Rows of sensor::disturbed_readings() whose errors have a size, and the input of each.
  struct DrawnRow {
    int row;
    std::size_t input;
  };
  std::vector<DrawnRow> drawn_rows() const;

  analysis::CodeCase which_;
  std::unique_ptr<estimate::Estimator> estimator_;
  multistation::FitPlan plan_;  ///< of Kind::parameters
  sensor::DisturbedRunSetup setup_;
  survey::TiedSurvey tied_;
  survey::LaneArray uncorrected_;  ///< parameters that leave readings as they are
  Eigen::Vector3d position_;
};

}  // namespace surveymc::studies::corrected_codes
