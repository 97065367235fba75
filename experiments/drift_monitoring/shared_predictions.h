#pragma once
/// Predictions that several points of a sweep have in common are computed once.
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "monitoring/samples.h"

namespace surveymc::studies::drift_monitoring {

/// Of all tested samples of a realisation, by architecture.
using Predictions = std::vector<monitoring::Samples>;

/// Predictions by realisation for all points of this process that compute the same. They take at most kMostBytes in
/// all; what finds no place is computed again. Which point comes first changes nothing, as all would compute the same
/// bits.
class SharedPredictions {
 public:
  /// `what`: everything that the predictions depend on. One object for equal texts, as long as anyone holds it.
  static std::shared_ptr<SharedPredictions> of(const std::string& what);
  ~SharedPredictions();

  /// More than one point has asked for them.
  bool are_shared() const;
  /// Null: not there.
  std::shared_ptr<const Predictions> find(std::uint64_t trial) const;
  void keep(std::uint64_t trial, Predictions predictions);

  static constexpr std::size_t kMostBytes = std::size_t{256} << 20;

 private:
  mutable std::mutex mutex_;
  int points_ = 0;
  std::size_t bytes_ = 0;
  std::map<std::uint64_t, std::shared_ptr<const Predictions>> by_trial_;
};

}  // namespace surveymc::studies::drift_monitoring
