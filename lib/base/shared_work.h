#pragma once
/// Costly parts of preparing that points of a task share: each is made once for equal inputs.
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace surveymc {

/// Keeps the latest results with their inputs, as many as fit into `most_bytes`. Several threads may ask: while one
/// makes a result, the others wait for it.
class SharedWork {
 public:
  explicit SharedWork(std::size_t most_bytes = std::size_t{64} << 20) : most_bytes_(most_bytes) {}

  /// Returns make(input, stop), or what it returned for an equal input. `make` is a plain function, so that its result
  /// depends on the input alone; equality (operator==) must be that of all bits that it reads. `bytes`: the approximate
  /// size of input and result in memory.
  template <class Input, class Result>
  std::shared_ptr<const Result> get(const Input& input, Result (*make)(const Input&, const std::atomic<bool>*),
                                    std::size_t bytes, const std::atomic<bool>* stop) {
    const auto name = reinterpret_cast<Function>(make);
    const auto is_this = [&](const Entry& e) { return e.make == name && *static_cast<const Input*>(e.input) == input; };
    std::unique_lock lock(changing_);
    while (std::any_of(now_made_.begin(), now_made_.end(), is_this)) made_one_.wait(lock);
    if (const auto kept = std::find_if(kept_.rbegin(), kept_.rend(), is_this); kept != kept_.rend()) {
      std::rotate(std::prev(kept.base()), kept.base(), kept_.end());  // the latest one is the last
      return std::static_pointer_cast<const Result>(kept_.back().result);
    }
    now_made_.push_back({name, &input});
    const auto end_making = [&] {
      now_made_.erase(
          std::find_if(now_made_.begin(), now_made_.end(), [&](const Entry& e) { return e.input == &input; }));
      made_one_.notify_all();
    };
    lock.unlock();
    std::shared_ptr<const Result> result;
    std::shared_ptr<const Input> own;
    try {
      result = std::make_shared<const Result>(make(input, stop));
      if (bytes <= most_bytes_) own = std::make_shared<const Input>(input);
    } catch (...) {
      lock.lock();
      end_making();  // who waits for it tries it again, and gets an exception of its own
      throw;
    }
    lock.lock();
    end_making();
    ++made_;
    if (!own) return result;
    bytes_ += bytes;
    while (bytes_ > most_bytes_) {
      bytes_ -= kept_.front().bytes;
      kept_.erase(kept_.begin());
    }
    kept_.push_back({{name, own.get()}, own, result, bytes});
    return result;
  }

  /// How often something was made.
  std::size_t made() const { return locked(made_); }
  std::size_t bytes() const { return locked(bytes_); }

 private:
  using Function = void (*)();
  struct Entry {
    Function make;
    const void* input;
  };
  struct Kept : Entry {
    std::shared_ptr<const void> own_input, result;
    std::size_t bytes;
  };
  std::size_t locked(const std::size_t& number) const {
    const std::scoped_lock lock(changing_);
    return number;
  }

  mutable std::mutex changing_;
  std::condition_variable made_one_;
  std::size_t most_bytes_, bytes_ = 0, made_ = 0;
  std::vector<Entry> now_made_;
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
