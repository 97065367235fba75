#pragma once
/// Strategies that look for the observations with gross errors (section 2.2.3). They work on the linear model of one
/// adjustment (parity.h), with the variance known (w-tests).
///
/// Tests that are fully correlated (|rho| = 1) cannot be told apart: they are a group, and what is found is the group,
/// never one index of it. To take out any one of a group takes out what all of it shows.
#include <vector>

#include "reliability/parity.h"

namespace surveymc::reliability {

/// Observations of which one, it cannot be said which, is in error; ascending. One element: identified.
using SuspectGroup = std::vector<Eigen::Index>;

struct SnoopingResult {
  std::vector<SuspectGroup> rejected;  ///< in the order of rejection
  bool accepted = false;               ///< the observations that are left pass their tests
  bool exhausted = false;              ///< no redundancy is left: nothing more can be said
  /// pair_search only: other sets that explain the observations as well (to 1e-9 of Omega), as group numbers of the
  /// same form as `rejected`. Not empty: the set in `rejected` is one of several and nothing is identified.
  std::vector<std::vector<SuspectGroup>> ties = {};
};

/// Groups of observations whose tests have |rho| > 1 - 1e-9; those that cannot be tested are in none.
std::vector<SuspectGroup> inseparable_groups(const ParityModel& model);

/// The group with the largest |w| if that is above `critical`, and no more.
SnoopingResult data_snooping(const ParityModel& model, double critical);

/// Rejects the largest |w| again and again until all that is left passes or the redundancy is exhausted.
SnoopingResult iterative_snooping(const ParityModel& model, double critical);

/// The same, but after every rejection each earlier one is put back on trial: with the others out, it is re-admitted if
/// its |w| is not above `critical`. Of a group, the member that lets most earlier ones back is taken. A set that was
/// seen before ends the search. Groups in the result are those of each rejection given the other ones.
SnoopingResult iterative_snooping_with_readmission(const ParityModel& model, double critical);

/// Nothing if no |w| is above `critical`; else the group with the largest |w|, if its rejection leaves all others
/// acceptable; else the pair of groups that takes most off Omega, out of all pairs.
SnoopingResult pair_search(const ParityModel& model, double critical);

}  // namespace surveymc::reliability
