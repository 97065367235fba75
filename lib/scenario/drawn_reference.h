#pragma once
/// The reference that studies of multi-station analysis draw, `noise.reference`: laws of its errors and, where they are
/// new at every station, a disturbance in time in their place.
#include <memory>
#include <optional>

#include <Eigen/Core>

#include "compare/calibration.h"
#include "compare/tails.h"
#include "config/config.h"
#include "disturbance/station_disturbance.h"
#include "random/reference_laws.h"
#include "scenario/disturbance.h"
#include "scenario/prediction_orders.h"
#include "sensor/magnetometer.h"
#include "survey/survey.h"

namespace surveymc::scenario {

struct DrawnReference {
  random::ReferenceLaws laws;
  std::optional<disturbance::Disturbance> disturbance;               ///< of the reference of each station
  std::shared_ptr<const disturbance::StationDisturbance> disturbed;  ///< draw 2 station + {total field, dip} of it

  /// Correlation of the reference's draws; nothing where they are independent.
  std::optional<Eigen::MatrixXd> correlation() const {
    return disturbed ? std::optional(disturbed->correlation()) : std::nullopt;
  }
  /// The disturbance's draws, for simulate_readings(); no rows without a disturbance.
  survey::LaneArray made(const random::Stream& stream, std::uint64_t first_trial, bool antithetic, int groups) const;
};

/// `[reference_law]` of total field and dip: the reference's sizes in `noise` become the standard deviations that
/// follow. Throws InputError.
random::ReferenceLaws read_drawn_laws(config::ConfigReader& config, sensor::NoiseModel& noise);

/// The same, and `[disturbance]` at the stations of `survey`, of which the depths or
/// the times are used, and whose sizes the reference's may become. `well`: of read_disturbance(). Throws InputError.
DrawnReference read_drawn_reference(config::ConfigReader& config, const survey::Survey& survey,
                                    const DisturbedWell& well, const survey::ReferenceField& field,
                                    sensor::NoiseModel& noise);

/// The errors of the first station, or of the run, that have a law: dip, then total field.
std::vector<compare::LawDraw> law_draws(const sensor::ReferenceMixing& mixing);

/// Throws InputError where a table would be of a normal reference that the config does not have; `tails` have no
/// prediction beside a disturbance that is not normal.
void require_tables_of(config::ConfigReader& config, const DrawnReference& reference, compare::TailRule& tails,
                       const PredictionOrders& orders, const compare::CalibrationRule& calibration);

}  // namespace surveymc::scenario
