#pragma once
/// Disturbances of the reference in time in place of the errors of error models that are new at every station (R): of
/// the drawn well (well_errors.h), and of its covariances (tool_covariance.h).
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "disturbance/station_disturbance.h"
#include "propagate/tool_covariance.h"
#include "propagate/well_errors.h"

namespace surveymc::propagate {

/// The element of the reference that a term of mode R changes: functions AZ and DBH the declination, MDI the dip, MFI
/// the total field.
std::optional<disturbance::Element> disturbed_element(const error_model::Term& term);

/// The models with the errors that the disturbance makes. With Disturbance::keeps_normals() their terms, `scale` times
/// as large; else one term an element in their place, DISTURBANCE-DECLINATION, -DIP and -TOTAL, where the model has a
/// function of it: of the size of the terms that it replaces, sqrt(DECR^2 + (DBHR / H)^2), or of the process.
/// Throws InputError where no model has a term that is replaced, or none of these functions.
std::vector<ToolRun> disturbed_runs(const std::vector<ToolRun>& runs, const disturbance::Disturbance& disturbance,
                                    const survey::ReferenceField& field);

/// Throws InputError where disturbed_draws() and with_independent_draws() would: there are more than 3000 draws, one of
/// each disturbed source at every station behind the first.
void require_few_draws(const std::vector<ToolRun>& runs, std::size_t stations);

/// Draws of `errors` that a disturbance makes.
struct DisturbedDraws {
  disturbance::StationDisturbance disturbance;
  std::vector<std::uint32_t> draws;  ///< number of each in WellErrors
};
/// `errors`: of the runs that disturbed_runs() gave.
DisturbedDraws disturbed_draws(const WellErrors& errors, const std::vector<ToolRun>& runs,
                               const disturbance::Disturbance& disturbance, const survey::ReferenceField& field);
/// The same errors to second moments by independent draws, for predictions (mixed_draws). Throws InputError where the
/// correlation of the disturbance's draws has no factor to 1e-6: it is then no correlation matrix.
WellErrors with_independent_draws(const WellErrors& errors, const DisturbedDraws& disturbed);

/// The same effects to second moments by independent draws: each draw of a disturbed source becomes a source of its
/// own, of mode R and with one draw along the well. Memory: a factor of D^2 numbers and 7 D n of effects, D the number
/// of draws, at most that of disturbed sources times that of stations n.
StationEffects with_independent_draws(const StationEffects& effects, const std::vector<ToolRun>& runs,
                                      const disturbance::Disturbance& disturbance, const survey::ReferenceField& field);

/// Adds to covariances what the correlation of the station's errors gives them: with v_k the effect of a term at
/// station k on a position, the sum of v_j v_k' rho(j, k) in place of that of v_k v_k'. That between two elements is in
/// the total alone, not in that of a source. `effects`: of all sources. Time is quadratic in the stations.
void add_correlation(ToolCovariances& covariances, const StationEffects& effects, const std::vector<ToolRun>& runs,
                     const disturbance::Disturbance& disturbance, const survey::ReferenceField& field,
                     SourceDetail detail);

}  // namespace surveymc::propagate
