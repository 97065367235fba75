#include "reliability/snooping.h"

#include <algorithm>
#include <cmath>
#include <set>

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
Largest largest_w(const ParityModel& m) {
  const Eigen::VectorXd w = w_statistics(m).cwiseAbs();
  Largest best;
  for (const SuspectGroup& g : inseparable_groups(m))
    if (best.group.empty() || w[g.front()] > best.size) best = {g, w[g.front()]};
  return best;
}

bool passes(const ParityModel& m, double critical) { return !(largest_w(m).size > critical); }

SnoopingResult finished(Groups rejected, const ParityModel& left, double critical) {
  SnoopingResult r;
  r.rejected = std::move(rejected);
  r.exhausted = left.redundancy == 0;
  r.accepted = !r.exhausted && passes(left, critical);
  return r;
}

/// Tests the earlier ones of `rejected` again, the oldest first: those that pass with the others rejected are removed
/// from `rejected`.
void readmit(const ParityModel& m, double critical, std::vector<Index>& rejected) {
  for (std::size_t k = 0; k + 1 < rejected.size();) {
    std::vector<Index> others = rejected;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    if (std::abs(w_statistics(without(m, others))[rejected[k]]) > critical)
      ++k;
    else
      rejected = std::move(others);
  }
}

/// The observations that could take the place of rejected[k], given the others.
SuspectGroup group_of(const ParityModel& m, const std::vector<Index>& rejected, std::size_t k) {
  std::vector<Index> others = rejected;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
  for (const SuspectGroup& g : inseparable_groups(without(m, others)))
    if (std::find(g.begin(), g.end(), rejected[k]) != g.end()) return g;
  return {rejected[k]};
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

SnoopingResult data_snooping(const ParityModel& m, double critical) {
  const Largest worst = largest_w(m);
  if (!(worst.size > critical)) return finished({}, m, critical);
  return finished({worst.group}, without(m, {worst.group.front()}), critical);
}

SnoopingResult iterative_snooping(const ParityModel& m, double critical) {
  Groups rejected;
  for (;;) {
    const ParityModel left = without(m, representatives(rejected));
    const Largest worst = largest_w(left);
    if (left.redundancy == 0 || !(worst.size > critical)) return finished(rejected, left, critical);
    rejected.push_back(worst.group);
  }
}

SnoopingResult iterative_snooping_with_readmission(const ParityModel& m, double critical) {
  std::vector<Index> rejected;  // in the order of rejection
  std::set<std::vector<Index>> seen;
  for (;;) {
    const ParityModel left = without(m, rejected);
    const Largest worst = largest_w(left);
    std::vector<Index> state = rejected;
    std::sort(state.begin(), state.end());
    if (left.redundancy == 0 || !(worst.size > critical) || !seen.insert(state).second) {
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

SnoopingResult pair_search(const ParityModel& m, double critical) {
  if (passes(m, critical)) return finished({}, m, critical);
  const Largest worst = largest_w(m);
  const ParityModel one_less = without(m, {worst.group.front()});
  if (one_less.redundancy == 0 || passes(one_less, critical)) return finished({worst.group}, one_less, critical);

  const std::vector<SuspectGroup> groups = inseparable_groups(m);
  std::vector<std::pair<double, Groups>> pairs;
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (std::size_t j = i + 1; j < groups.size(); ++j) {
      const GeneralTest t = general_test(m, std::vector<Index>{groups[i].front(), groups[j].front()});
      pairs.push_back({t.chi_squared, {groups[i], groups[j]}});
    }
  if (pairs.empty()) return finished({worst.group}, one_less, critical);
  const auto best =
      std::max_element(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  SnoopingResult r = finished(best->second, without(m, representatives(best->second)), critical);
  for (auto p = pairs.begin(); p != pairs.end(); ++p)
    if (p != best && p->first > best->first - 1e-9 * m.omega()) r.ties.push_back(p->second);
  return r;
}

}  // namespace surveymc::reliability
