#include "drift_monitoring/shared_predictions.h"

#include <atomic>

namespace surveymc::studies::drift_monitoring {
namespace {

std::atomic<std::size_t> bytes_of_all{0};

std::size_t bytes_of(const Predictions& predictions) {
  std::size_t bytes = 0;
  for (const monitoring::Samples& x : predictions) bytes += static_cast<std::size_t>(x.size()) * sizeof(double);
  return bytes;
}

}  // namespace

std::shared_ptr<SharedPredictions> SharedPredictions::of(const PredictionInput& input) {
  static std::mutex mutex;
  static std::map<PredictionInput, std::weak_ptr<SharedPredictions>> all;
  const std::lock_guard lock(mutex);
  std::weak_ptr<SharedPredictions>& known = all[input];
  std::shared_ptr<SharedPredictions> shared = known.lock();
  if (!shared) known = shared = std::make_shared<SharedPredictions>();
  const std::lock_guard own(shared->mutex_);
  ++shared->points_;
  return shared;
}

SharedPredictions::~SharedPredictions() { bytes_of_all -= bytes_; }

bool SharedPredictions::are_shared() const {
  const std::lock_guard lock(mutex_);
  return points_ > 1;
}

std::shared_ptr<const Predictions> SharedPredictions::find(std::uint64_t trial) const {
  const std::lock_guard lock(mutex_);
  const auto at = by_trial_.find(trial);
  return at == by_trial_.end() ? nullptr : at->second;
}

void SharedPredictions::keep(std::uint64_t trial, Predictions predictions) {
  const std::size_t bytes = bytes_of(predictions);
  const std::lock_guard lock(mutex_);
  if (by_trial_.contains(trial)) return;
  if (bytes_of_all.fetch_add(bytes) + bytes > kMostBytes) {
    bytes_of_all -= bytes;
    return;
  }
  bytes_ += bytes;
  by_trial_.emplace(trial, std::make_shared<const Predictions>(std::move(predictions)));
}

}  // namespace surveymc::studies::drift_monitoring
