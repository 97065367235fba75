#pragma once
/// Strategies that look for the observations with gross errors (section 2.2.3). They work on the linear model of one
/// adjustment (parity.h), with the variance known (w-tests).
///
/// Tests that are fully correlated (|rho| = 1) cannot be told apart: they are a group, and a search finds the group,
/// never one observation of it. Taking out any one observation removes the misclosure that all of the group show.
#include <vector>

#include "reliability/parity.h"

namespace surveymc::reliability {

/// Observations one of which is in error, but the tests cannot say which; ascending. One element: identified.
using SuspectGroup = std::vector<Eigen::Index>;

struct SnoopingResult {
  std::vector<SuspectGroup> rejected;  ///< in the order of rejection
  bool accepted = false;               ///< the observations that are left pass their tests
  bool exhausted = false;              ///< no redundancy is left: no more tests are possible
  /// pair_search only: other sets that explain the observations as well (to 1e-9 of Omega), as group numbers of the
  /// same form as `rejected`. Not empty: the set in `rejected` is one of several and nothing is identified.
  std::vector<std::vector<SuspectGroup>> ties = {};
};

/// Groups of observations whose tests have |rho| > 1 - 1e-9; those that cannot be tested are in none.
std::vector<SuspectGroup> inseparable_groups(const ParityModel& model);

/// The group with the largest |w| if this |w| is above `critical`, and no more.
SnoopingResult data_snooping(const ParityModel& model, double critical);

/// Rejects the largest |w| again and again until all that is left passes or the redundancy is exhausted.
SnoopingResult iterative_snooping(const ParityModel& model, double critical);

/// Iterative snooping that tests each earlier rejection again after every new one: with the others out, an observation
/// is re-admitted if its |w| is not above `critical`. Of a group, the member that lets most earlier ones back is taken.
/// The search ends when a set of rejections occurs again. Groups in the result are those of each rejection given the
/// others.
SnoopingResult iterative_snooping_with_readmission(const ParityModel& model, double critical);

/// Nothing if no |w| is above `critical`; else the group with the largest |w|, if its rejection leaves all others
/// acceptable; else the pair of groups, out of all pairs, that lowers Omega most.
SnoopingResult pair_search(const ParityModel& model, double critical);

}  // namespace surveymc::reliability
