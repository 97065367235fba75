#pragma once
/// `[disturbance]`: the geomagnetic reference's errors that are new at every station, as a function of time instead.
#include <optional>
#include <string>

#include "compare/tails.h"
#include "config/config.h"
#include "disturbance/station_disturbance.h"
#include "store/table.h"
#include "survey/survey.h"

namespace surveymc::scenario {

/// A well that a disturbance is read for.
struct DisturbedWell {
  config::ConfigReader* offset = nullptr;  ///< the [[offset]] that it is: its `file` may have the column `time_s`
  std::string name = {};                   ///< of several wells, for messages
  bool has_file = true;                    ///< the study has the key survey.file
  bool is_drawn = true;                    ///< in trials, of which there may be too few
};

/// The disturbance, if the config has one, at the stations of `survey`. Times: column `time_s` of survey.file, or
/// `drilling_m_per_h` and `connection_s`.
std::optional<disturbance::Disturbance> read_disturbance(config::ConfigReader& config, const survey::Survey& survey,
                                                         const DisturbedWell& well = {});

/// Throws InputError where errors of mode R have laws and a disturbance takes their place. Table `tails` has a
/// prediction beside "ar1" alone, whose sums are normal; else trials.
void set_beside_laws(config::ConfigReader& config, const std::optional<disturbance::Disturbance>& disturbance,
                     const random::ReferenceLaws& laws, compare::TailRule& tails);

/// Table `disturbance`: of each element sd, kurtosis, share beyond three sd and autocorrelation, as predicted and as
/// the first trials draw them; null: nothing is drawn. Of Disturbance::keeps_normals() the elements are in units of
/// their sd.
store::Table disturbance_table(const disturbance::Disturbance& disturbance, const survey::ReferenceField& field,
                               const random::Stream* stream);

}  // namespace surveymc::scenario
