#include "reliability/snooping.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include "reliability/redundancy_model.h"

namespace surveymc::reliability {
namespace {

using Eigen::Index;
using Groups = std::vector<SuspectGroup>;

/// One member of each group, as all members have the same direction.
std::vector<Index> representatives(const Groups& groups) {
  std::vector<Index> all;
  for (const SuspectGroup& g : groups) all.push_back(g.front());
  return all;
}

struct Largest {
  SuspectGroup group;
  double size = 0;  ///< |w|
};

// What the searches ask of a model: parity.h is the plain one, redundancy_model.h the fast one.
Index redundancy_of(const ParityModel& m) { return m.redundancy; }
double w_of(const ParityModel& m, Index i) { return w_statistics(m)[i]; }
ParityModel left_of(const ParityModel& m, const std::vector<Index>& out) { return without(m, out); }
double pair_statistic(const ParityModel& m, Index i, Index j) {
  return general_test(m, std::vector<Index>{i, j}).chi_squared;
}
Largest largest_w(const ParityModel& m) {
  const Eigen::VectorXd w = w_statistics(m).cwiseAbs();
  Largest best;
  for (const SuspectGroup& g : inseparable_groups(m))
    if (best.group.empty() || w[g.front()] > best.size) best = {g, w[g.front()]};
  return best;
}

Index redundancy_of(const RedundancyModel& m) { return m.redundancy(); }
double w_of(const RedundancyModel& m, Index i) { return m.w(i); }
RedundancyModel left_of(const RedundancyModel& m, const std::vector<Index>& out) { return m.without(out); }
double pair_statistic(const RedundancyModel& m, Index i, Index j) { return m.pair_statistic(i, j); }
/// Calls each(first, bits of the members) for all groups, in order of their first members.
template <class Each>
void for_groups(const RedundancyModel& m, Each each) {
  std::uint64_t taken = 0;
  for (Index i = 0; i < m.observations(); ++i) {
    if (!m.is_testable(i) || (taken >> i & 1) != 0) continue;
    std::uint64_t members = std::uint64_t{1} << i;
    for (Index j = i + 1; j < m.observations(); ++j)  // of one that cannot be tested all products are 0
      members |= std::uint64_t{m.are_inseparable(i, j)} << j;
    taken |= members;
    each(i, members);
  }
}
SuspectGroup group_of_bits(std::uint64_t members) {
  SuspectGroup g;
  for (Index i = 0; members != 0; ++i, members >>= 1)
    if ((members & 1) != 0) g.push_back(i);
  return g;
}
/// The group of the largest |w|, without the other groups: its first member is the first observation that cannot be
/// told apart from the largest.
Largest largest_w(const RedundancyModel& m) {
  Index best = -1;
  double size = 0;
  for (Index i = 0; i < m.observations(); ++i) {
    const double w = std::abs(m.w(i));
    if (!m.is_testable(i) || !(best < 0 || w > size)) continue;
    best = i;
    size = w;
  }
  if (best < 0) return {};
  Index first = 0;
  while (first < best && !m.are_inseparable(first, best)) ++first;
  Largest out{{first}, std::abs(m.w(first))};
  for (Index j = first + 1; j < m.observations(); ++j)
    if (m.are_inseparable(first, j)) out.group.push_back(j);
  return out;
}
/// No group is needed to see whether any test fails.
bool passes(const RedundancyModel& m, double critical) {
  double size = 0;
  for (Index i = 0; i < m.observations(); ++i) size = std::max(size, m.is_testable(i) ? std::abs(m.w(i)) : 0);
  return !(size > critical);
}

template <class Model>
bool passes(const Model& m, double critical) {
  return !(largest_w(m).size > critical);
}

template <class Model>
SnoopingResult finished(Groups rejected, const Model& left, double critical) {
  SnoopingResult r;
  r.rejected = std::move(rejected);
  r.exhausted = redundancy_of(left) == 0;
  r.accepted = !r.exhausted && passes(left, critical);
  return r;
}

/// Tests the earlier ones of `rejected` again, the oldest first: those that pass with the others rejected are removed
/// from `rejected`.
template <class Model>
void readmit(const Model& m, double critical, std::vector<Index>& rejected) {
  for (std::size_t k = 0; k + 1 < rejected.size();) {
    std::vector<Index> others = rejected;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    if (std::abs(w_of(left_of(m, others), rejected[k])) > critical)
      ++k;
    else
      rejected = std::move(others);
  }
}

/// The observations that could take the place of rejected[k], given the others.
template <class Model>
SuspectGroup group_of(const Model& m, const std::vector<Index>& rejected, std::size_t k) {
  std::vector<Index> others = rejected;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
  for (const SuspectGroup& g : inseparable_groups(left_of(m, others)))
    if (std::find(g.begin(), g.end(), rejected[k]) != g.end()) return g;
  return {rejected[k]};
}

template <class Model>
SnoopingResult snooped_once(const Model& m, double critical) {
  const Largest worst = largest_w(m);
  if (!(worst.size > critical)) return finished({}, m, critical);
  return finished({worst.group}, left_of(m, {worst.group.front()}), critical);
}

template <class Model>
SnoopingResult snooped_again(const Model& m, double critical) {
  Groups rejected;
  for (;;) {
    const Model left = left_of(m, representatives(rejected));
    const Largest worst = largest_w(left);
    if (redundancy_of(left) == 0 || !(worst.size > critical)) return finished(rejected, left, critical);
    rejected.push_back(worst.group);
  }
}

template <class Model>
SnoopingResult snooped_with_readmission(const Model& m, double critical) {
  std::vector<Index> rejected;  // in the order of rejection
  std::set<std::vector<Index>> seen;
  for (;;) {
    const Model left = left_of(m, rejected);
    const Largest worst = largest_w(left);
    std::vector<Index> state = rejected;
    std::sort(state.begin(), state.end());
    if (redundancy_of(left) == 0 || !(worst.size > critical) || !seen.insert(state).second) {
      Groups groups;
      for (std::size_t k = 0; k < rejected.size(); ++k) groups.push_back(group_of(m, rejected, k));
      return finished(std::move(groups), left, critical);
    }
    // Members of a group are equivalent as long as all earlier rejections are out, but not when these are tested again:
    // the member that lets most of them back explains the observations with the fewest errors.
    std::vector<Index> best;
    for (const Index member : worst.group) {
      std::vector<Index> kept = rejected;
      kept.push_back(member);
      readmit(m, critical, kept);
      if (best.empty() || kept.size() < best.size()) best = std::move(kept);
    }
    rejected = std::move(best);
  }
}

template <class Model>
SnoopingResult searched_pairs(const Model& m, double critical) {
  const Largest worst = largest_w(m);
  if (!(worst.size > critical)) return finished({}, m, critical);
  const Model one_less = left_of(m, {worst.group.front()});
  if (redundancy_of(one_less) == 0 || passes(one_less, critical)) return finished({worst.group}, one_less, critical);

  const std::vector<SuspectGroup> groups = inseparable_groups(m);
  struct Pair {
    double statistic;
    std::size_t i, j;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (std::size_t j = i + 1; j < groups.size(); ++j)
      pairs.push_back({pair_statistic(m, groups[i].front(), groups[j].front()), i, j});
  if (pairs.empty()) return finished({worst.group}, one_less, critical);
  const auto best = std::max_element(pairs.begin(), pairs.end(),
                                     [](const Pair& a, const Pair& b) { return a.statistic < b.statistic; });
  const auto groups_of = [&](const Pair& p) { return Groups{groups[p.i], groups[p.j]}; };
  SnoopingResult r = finished(groups_of(*best), left_of(m, representatives(groups_of(*best))), critical);
  for (auto p = pairs.begin(); p != pairs.end(); ++p)
    if (p != best && p->statistic > best->statistic - 1e-9 * m.omega()) r.ties.push_back(groups_of(*p));
  return r;
}

}  // namespace

std::vector<SuspectGroup> inseparable_groups(const ParityModel& m) {
  const Eigen::MatrixXd rho = test_correlations(m);
  const Eigen::VectorXd size = sensitivities(m);
  std::vector<SuspectGroup> groups;
  std::vector<bool> taken(static_cast<std::size_t>(m.observations()), false);
  for (Index i = 0; i < m.observations(); ++i) {
    if (!(size[i] > 0) || taken[static_cast<std::size_t>(i)]) continue;
    groups.push_back({i});
    for (Index j = i + 1; j < m.observations(); ++j)
      if (size[j] > 0 && std::abs(rho(i, j)) > 1 - 1e-9) {
        groups.back().push_back(j);
        taken[static_cast<std::size_t>(j)] = true;
      }
  }
  return groups;
}

std::vector<SuspectGroup> inseparable_groups(const RedundancyModel& m) {
  std::vector<SuspectGroup> groups;
  for_groups(m, [&](Index, std::uint64_t members) { groups.push_back(group_of_bits(members)); });
  return groups;
}

SnoopingResult data_snooping(const ParityModel& m, double critical) { return snooped_once(m, critical); }
SnoopingResult data_snooping(const RedundancyModel& m, double critical) { return snooped_once(m, critical); }

SnoopingResult iterative_snooping(const ParityModel& m, double critical) { return snooped_again(m, critical); }
SnoopingResult iterative_snooping(const RedundancyModel& m, double critical) { return snooped_again(m, critical); }

SnoopingResult iterative_snooping_with_readmission(const ParityModel& m, double critical) {
  return snooped_with_readmission(m, critical);
}
SnoopingResult iterative_snooping_with_readmission(const RedundancyModel& m, double critical) {
  return snooped_with_readmission(m, critical);
}

SnoopingResult pair_search(const ParityModel& m, double critical) { return searched_pairs(m, critical); }
SnoopingResult pair_search(const RedundancyModel& m, double critical) { return searched_pairs(m, critical); }

}  // namespace surveymc::reliability
