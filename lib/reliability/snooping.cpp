#include "reliability/snooping.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

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

/// A pair of groups, by their first members.
struct Pair {
  Index i, j;
};
/// The pair without which Omega falls most, and those that are as good to 1e-9 of Omega; none: there is no pair.
struct BestPairs {
  std::vector<Pair> best, ties;
};

// What the searches ask of a model: parity.h is the plain one, redundancy_model.h the fast one.
Index redundancy_of(const ParityModel& m) { return m.redundancy; }
double w_of(const ParityModel& m, Index i) { return w_statistics(m)[i]; }
const ParityModel& whole_of(const ParityModel& m) { return m; }
ParityModel left_of(const ParityModel& m, const std::vector<Index>& out) { return without(m, out); }
BestPairs best_pairs(const ParityModel& m, const std::vector<Index>& firsts) {
  std::vector<std::pair<double, Pair>> all;
  for (std::size_t a = 0; a < firsts.size(); ++a)
    for (std::size_t b = a + 1; b < firsts.size(); ++b)
      all.push_back({general_test(m, std::vector<Index>{firsts[a], firsts[b]}).chi_squared, {firsts[a], firsts[b]}});
  BestPairs p;
  if (all.empty()) return p;
  const auto best =
      std::max_element(all.begin(), all.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  p.best = {best->second};
  for (auto i = all.begin(); i != all.end(); ++i)
    if (i != best && i->first > best->first - 1e-9 * m.omega()) p.ties.push_back(i->second);
  return p;
}
/// Observations that cannot be told apart from i, with it.
SuspectGroup group_with(const ParityModel& m, Index i) {
  for (const SuspectGroup& g : inseparable_groups(m))
    if (std::find(g.begin(), g.end(), i) != g.end()) return g;
  return {i};
}
std::vector<Index> first_of_groups(const ParityModel& m) { return representatives(inseparable_groups(m)); }
Largest largest_w(const ParityModel& m) {
  const Eigen::VectorXd w = w_statistics(m).cwiseAbs();
  Largest best;
  for (const SuspectGroup& g : inseparable_groups(m))
    if (best.group.empty() || w[g.front()] > best.size) best = {g, w[g.front()]};
  return best;
}

Index redundancy_of(const RedundancyModel& m) { return m.redundancy(); }
double w_of(const RedundancyModel& m, Index i) { return m.w(i); }
const RedundancyModel& whole_of(const RedundancyFamily& m) { return m.whole(); }
const RedundancyModel& left_of(RedundancyFamily& m, const std::vector<Index>& out) { return m.without(out); }
BestPairs best_pairs(const RedundancyModel& m, const std::vector<Index>& firsts) {
  constexpr std::size_t kMost = RedundancyModel::kMost;
  if (firsts.size() < 2) return {};
  // Row a has the pairs of first a with later ones. Those of others are 0, below any pair that lowers Omega.
  RedundancyModel::Row is_first{};
  for (const Index i : firsts) is_first[static_cast<std::size_t>(i)] = 1;
  std::array<RedundancyModel::Row, kMost> statistics;
  RedundancyModel::Row largest;
  double most = -1;
  for (std::size_t a = 0; a + 1 < firsts.size(); ++a) {
    RedundancyModel::Row& row = statistics[a];
    is_first[static_cast<std::size_t>(firsts[a])] = 0;
    row.fill(0);
    m.pair_statistics(firsts[a], row);
    std::array<double, 4> of_four{-1, -1, -1, -1};  // side by side
    for (std::size_t j = 0; j < kMost; j += 4)
      for (std::size_t k = 0; k < 4; ++k) {
        row[j + k] = is_first[j + k] > 0 ? row[j + k] : -1;
        of_four[k] = row[j + k] > of_four[k] ? row[j + k] : of_four[k];
      }
    largest[a] = *std::max_element(of_four.begin(), of_four.end());
    most = std::max(most, largest[a]);
  }
  const double least = most - 1e-9 * m.omega();
  BestPairs p;
  for (std::size_t a = 0; a + 1 < firsts.size(); ++a) {
    if (!(largest[a] > least) && largest[a] != most) continue;
    for (std::size_t b = a + 1; b < firsts.size(); ++b) {
      const double statistic = statistics[a][static_cast<std::size_t>(firsts[b])];
      if (p.best.empty() && statistic == most)
        p.best = {{firsts[a], firsts[b]}};
      else if (statistic > least)
        p.ties.push_back({firsts[a], firsts[b]});
    }
  }
  return p;
}
/// Calls each(first, bits of the members) for all groups, in order of their first members.
template <class Each>
void for_groups(const RedundancyModel& m, Each each) {
  std::uint64_t taken = 0;
  for (Index i = 0; i < m.observations(); ++i) {
    if (!m.is_testable(i) || (taken >> i & 1) != 0) continue;
    const std::uint64_t members = m.inseparable_from(i) >> i << i;
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
std::vector<Index> first_of_groups(const RedundancyModel& m) {
  std::vector<Index> all;
  for_groups(m, [&](Index first, std::uint64_t) { all.push_back(first); });
  return all;
}
/// Without the other groups: its first member is the first observation that cannot be told apart from i.
SuspectGroup group_with(const RedundancyModel& m, Index i) {
  const std::uint64_t all = m.inseparable_from(i);
  if (all == 0) return {i};
  const Index first = std::countr_zero(all);
  return group_of_bits((first == i ? all : m.inseparable_from(first)) >> first << first);
}
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
  Largest out{group_with(m, best), 0};
  out.size = std::abs(m.w(out.group.front()));
  return out;
}
/// No group is needed to see whether any test fails.
bool passes(const RedundancyModel& m, double critical) {
  double size = 0;
  for (Index i = 0; i < m.observations(); ++i) size = std::max(size, m.is_testable(i) ? std::abs(m.w(i)) : 0);
  return !(size > critical);
}

bool passes(const ParityModel& m, double critical) { return !(largest_w(m).size > critical); }

template <class Left>
SnoopingResult finished(Groups rejected, const Left& left, double critical) {
  SnoopingResult r;
  r.rejected = std::move(rejected);
  r.exhausted = redundancy_of(left) == 0;
  r.accepted = !r.exhausted && passes(left, critical);
  return r;
}

/// Tests the earlier ones of `rejected` again, the oldest first: those that pass with the others rejected are removed
/// from `rejected`.
template <class Model>
void readmit(Model& m, double critical, std::vector<Index>& rejected) {
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
SuspectGroup group_of(Model& m, const std::vector<Index>& rejected, std::size_t k) {
  std::vector<Index> others = rejected;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
  return group_with(left_of(m, others), rejected[k]);
}

template <class Model>
SnoopingResult snooped_once(Model& m, double critical) {
  const auto& whole = whole_of(m);
  const Largest worst = largest_w(whole);
  if (!(worst.size > critical)) return finished({}, whole, critical);
  return finished({worst.group}, left_of(m, {worst.group.front()}), critical);
}

template <class Model>
SnoopingResult snooped_again(Model& m, double critical) {
  Groups rejected;
  for (;;) {
    const auto& left = left_of(m, representatives(rejected));
    const Largest worst = largest_w(left);
    if (redundancy_of(left) == 0 || !(worst.size > critical)) return finished(rejected, left, critical);
    rejected.push_back(worst.group);
  }
}

template <class Model>
SnoopingResult snooped_with_readmission(Model& m, double critical) {
  std::vector<Index> rejected;  // in the order of rejection
  std::vector<std::vector<Index>> seen;
  for (;;) {
    const auto& left = left_of(m, rejected);
    const Largest worst = largest_w(left);
    std::vector<Index> state = rejected;
    std::sort(state.begin(), state.end());
    if (redundancy_of(left) == 0 || !(worst.size > critical) ||
        std::find(seen.begin(), seen.end(), state) != seen.end()) {
      Groups groups;
      for (std::size_t k = 0; k < rejected.size(); ++k) groups.push_back(group_of(m, rejected, k));
      return finished(std::move(groups), left, critical);
    }
    seen.push_back(std::move(state));
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
SnoopingResult searched_pairs(Model& m, double critical) {
  const auto& whole = whole_of(m);
  const Largest worst = largest_w(whole);
  if (!(worst.size > critical)) return finished({}, whole, critical);
  const auto& one_less = left_of(m, {worst.group.front()});
  if (redundancy_of(one_less) == 0 || passes(one_less, critical)) return finished({worst.group}, one_less, critical);

  const std::vector<Index> firsts = first_of_groups(whole);
  const BestPairs pairs = best_pairs(whole, firsts);
  if (pairs.best.empty()) return finished({worst.group}, one_less, critical);
  const auto groups_of = [&](const Pair& p) { return Groups{group_with(whole, p.i), group_with(whole, p.j)}; };
  const Pair& best = pairs.best.front();
  SnoopingResult r = finished(groups_of(best), left_of(m, {best.i, best.j}), critical);
  for (const Pair& p : pairs.ties) r.ties.push_back(groups_of(p));
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
SnoopingResult data_snooping(RedundancyFamily& m, double critical) { return snooped_once(m, critical); }

SnoopingResult iterative_snooping(const ParityModel& m, double critical) { return snooped_again(m, critical); }
SnoopingResult iterative_snooping(RedundancyFamily& m, double critical) { return snooped_again(m, critical); }

SnoopingResult iterative_snooping_with_readmission(const ParityModel& m, double critical) {
  return snooped_with_readmission(m, critical);
}
SnoopingResult iterative_snooping_with_readmission(RedundancyFamily& m, double critical) {
  return snooped_with_readmission(m, critical);
}

SnoopingResult pair_search(const ParityModel& m, double critical) { return searched_pairs(m, critical); }
SnoopingResult pair_search(RedundancyFamily& m, double critical) { return searched_pairs(m, critical); }

}  // namespace surveymc::reliability
