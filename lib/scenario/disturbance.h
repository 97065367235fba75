#pragma once
/// `[disturbance]`: the geomagnetic reference's errors that are new at every station, as a function of time instead.
#include <optional>

#include "compare/tails.h"
#include "config/config.h"
#include "disturbance/station_disturbance.h"
#include "store/table.h"
#include "survey/survey.h"

namespace surveymc::scenario {

/// The disturbance, if the config has one, at the stations of `survey`. Times: column `time_s` of survey.file, or
/// `drilling_m_per_h` and `connection_s`. `offset`: the [[offset]] whose survey it is, and whose `file` may have the
/// column. `has_file`: the study has the key survey.file.
std::optional<disturbance::Disturbance> read_disturbance(config::ConfigReader& config, const survey::Survey& survey,
                                                         config::ConfigReader* offset = nullptr, bool has_file = true);

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
