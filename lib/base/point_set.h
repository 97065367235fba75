#pragma once
/// A set of whole numbers as ranges: the points of a sweep that were read, done or are missing. Its memory is that of
/// the ranges, however many points they hold.
#include <cstdint>
#include <iterator>
#include <map>

namespace surveymc {

class PointSet {
 public:
  void add(std::uint64_t point) { add(point, point + 1); }
  /// first .. end - 1.
  void add(std::uint64_t first, std::uint64_t end) {
    if (first >= end) return;
    auto it = ranges_.upper_bound(first);
    if (it != ranges_.begin() && std::prev(it)->second >= first) --it;
    while (it != ranges_.end() && it->first <= end) {
      first = it->first < first ? it->first : first;
      end = it->second > end ? it->second : end;
      it = ranges_.erase(it);
    }
    ranges_.emplace(first, end);
  }
  bool contains(std::uint64_t point) const { return covers(point, point + 1); }
  /// True if all of first .. end - 1 are in the set.
  bool covers(std::uint64_t first, std::uint64_t end) const {
    if (first >= end) return true;
    const auto it = ranges_.upper_bound(first);
    return it != ranges_.begin() && std::prev(it)->second >= end;
  }
  /// True if any of first .. end - 1 is in the set.
  bool meets(std::uint64_t first, std::uint64_t end) const {
    if (first >= end) return false;
    const auto it = ranges_.lower_bound(end);
    return it != ranges_.begin() && std::prev(it)->second > first;
  }
  std::uint64_t count() const {
    std::uint64_t n = 0;
    for (const auto& [first, end] : ranges_) n += end - first;
    return n;
  }
  bool empty() const { return ranges_.empty(); }
  /// Those of 0 .. count - 1 that are not in the set.
  PointSet others(std::uint64_t count) const {
    PointSet out;
    std::uint64_t at = 0;
    for (const auto& [first, end] : ranges_) {
      if (first >= count) break;
      out.add(at, first);
      at = end;
    }
    out.add(at, count);
    return out;
  }
  /// First and end of every range, rising and apart.
  const std::map<std::uint64_t, std::uint64_t>& ranges() const { return ranges_; }

 private:
  std::map<std::uint64_t, std::uint64_t> ranges_;
};

}  // namespace surveymc
