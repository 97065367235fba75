#pragma once
/// What points of a task have in common: the costly parts of preparing them, each made once for equal inputs.
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

namespace surveymc {

/// Results with the inputs that they were made of: the latest ones, as many as `most_bytes` hold. For one thread at a
/// time.
class SharedWork {
 public:
  explicit SharedWork(std::size_t most_bytes = std::size_t{64} << 20) : most_bytes_(most_bytes) {}

  /// make(input, stop), or what it gave for an input that equals this one. `make` is a plain function, so that its
  /// result depends on the input alone; equality (operator==) must be that of all bits that it reads. `bytes`: what
  /// input and result hold in memory, about.
  template <class Input, class Result>
  std::shared_ptr<const Result> get(const Input& input, Result (*make)(const Input&, const std::atomic<bool>*),
                                    std::size_t bytes, const std::atomic<bool>* stop) {
    const auto name = reinterpret_cast<Function>(make);
    for (std::size_t i = kept_.size(); i-- > 0;) {
      if (kept_[i].make != name || !(*static_cast<const Input*>(kept_[i].input.get()) == input)) continue;
      std::rotate(kept_.begin() + static_cast<std::ptrdiff_t>(i), kept_.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                  kept_.end());  // the latest one is the last
      return std::static_pointer_cast<const Result>(kept_.back().result);
    }
    auto result = std::make_shared<const Result>(make(input, stop));
    ++made_;
    if (bytes > most_bytes_) return result;
    bytes_ += bytes;
    while (bytes_ > most_bytes_) {
      bytes_ -= kept_.front().bytes;
      kept_.erase(kept_.begin());
    }
    kept_.push_back({name, std::make_shared<const Input>(input), result, bytes});
    return result;
  }

  /// How often something was made.
  std::size_t made() const { return made_; }
  std::size_t bytes() const { return bytes_; }

 private:
  using Function = void (*)();
  struct Kept {
    Function make;
    std::shared_ptr<const void> input, result;
    std::size_t bytes;
  };
  std::size_t most_bytes_, bytes_ = 0, made_ = 0;
  std::vector<Kept> kept_;
};

/// The same where nothing may be shared (null).
template <class Input, class Result>
std::shared_ptr<const Result> shared_work(SharedWork* shared, const Input& input,
                                          Result (*make)(const Input&, const std::atomic<bool>*), std::size_t bytes,
                                          const std::atomic<bool>* stop) {
  return shared ? shared->get(input, make, bytes, stop) : std::make_shared<const Result>(make(input, stop));
}

}  // namespace surveymc
