#include "montecarlo/threads.h"

#include <omp.h>

#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <list>
#include <mutex>

namespace surveymc::montecarlo {
namespace {

/// Before the first call of OpenMP. LLVM's runtime reads the environment then, and aborts where OMP_NUM_THREADS is no
/// number. GCC's has read it when it was loaded.
void prepare_environment() {
  static const bool once = [] {
    setenv("OMP_WAIT_POLICY", "passive", /*overwrite=*/0);
    if (const char* number = std::getenv("OMP_NUM_THREADS"); number && std::atoi(number) < 1)
      unsetenv("OMP_NUM_THREADS");
    return true;
  }();
  (void)once;
}

/// Calls work() in so many threads, or in as many as OpenMP gives.
void in_team(int threads, const std::function<void()>& work) {
  prepare_environment();
  omp_set_dynamic(0);
#pragma omp parallel num_threads(threads)
  work();
}

/// The exception of the lowest number.
class FirstError {
 public:
  bool is_before(std::size_t number) const { return lowest_.load(std::memory_order_relaxed) <= number; }
  explicit operator bool() const { return is_before(kNone - 1); }
  void set(std::size_t number) {
    const std::scoped_lock lock(changing_);
    if (is_before(number)) return;
    error_ = std::current_exception();
    lowest_ = number;
  }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::atomic<std::size_t> lowest_ = kNone;
  std::exception_ptr error_;
  std::mutex changing_;
};

/// The threads of in_order(). Each computes the next item, or helps with the shares of an item that is being computed.
class Team {
 public:
  using Call = std::function<void(std::size_t, std::size_t)>;
  Team(std::size_t count, std::size_t places, const Call& compute, const Call& take)
      : count_(count), compute_(compute), take_(take), is_computed_(std::min(count, places), 0) {}

  /// What each thread does. Shares come first: memory holds fewer items at a time then.
  void work() {
    std::unique_lock lock(changing_);
    while (!is_done()) {
      if (Shared* const shared = with_open_share())
        help(*shared, lock);
      else if (next_ < count_ && next_ < taken_ + is_computed_.size() && !error_)
        compute_next(lock);
      else
        changed_.wait(lock);
    }
    changed_.notify_all();
  }

  /// share_work(0) here, the other shares in threads that become idle meanwhile, or here behind it.
  void share_out(int shares, const std::function<void(int)>& share_work) {
    std::unique_lock lock(changing_);
    const auto shared = shared_.insert(shared_.end(), {share_work, shares});
    changed_.notify_all();
    lock.unlock();
    share_work(0);
    lock.lock();
    while (shared->next < shared->shares) {
      const int share = shared->next++;
      lock.unlock();
      share_work(share);
      lock.lock();
    }
    changed_.wait(lock, [&] { return shared->running == 0; });
    shared_.erase(shared);
  }

  void rethrow() const { error_.rethrow(); }

 private:
  struct Shared {
    const std::function<void(int)>& work;
    int shares, next = 1, running = 0;
  };

  bool is_done() const { return taken_ == count_ || (error_ && computing_ == 0 && !is_taking_); }

  Shared* with_open_share() {
    for (Shared& s : shared_)
      if (s.next < s.shares) return &s;
    return nullptr;
  }

  void help(Shared& shared, std::unique_lock<std::mutex>& lock) {
    const int share = shared.next++;
    ++shared.running;
    lock.unlock();
    shared.work(share);
    lock.lock();
    if (--shared.running == 0) changed_.notify_all();
  }

  void compute_next(std::unique_lock<std::mutex>& lock) {
    const std::size_t i = next_++;
    ++computing_;
    lock.unlock();
    try {
      compute_(i, i % is_computed_.size());
    } catch (...) {
      error_.set(i);
    }
    lock.lock();
    --computing_;
    is_computed_[i % is_computed_.size()] = 1;
    take_computed(lock);
  }

  /// Takes all that is there and in turn, unless another thread does so: that one takes this item, too.
  void take_computed(std::unique_lock<std::mutex>& lock) {
    if (is_taking_) return;
    is_taking_ = true;
    for (; taken_ < count_ && is_computed_[taken_ % is_computed_.size()]; ++taken_, changed_.notify_all()) {
      const std::size_t now = taken_, place = now % is_computed_.size();
      is_computed_[place] = 0;
      if (error_.is_before(now)) continue;
      lock.unlock();
      try {
        take_(now, place);
      } catch (...) {
        error_.set(now);
      }
      lock.lock();
    }
    is_taking_ = false;
    if (is_done()) changed_.notify_all();
  }

  const std::size_t count_;
  const Call &compute_, &take_;
  FirstError error_;
  std::mutex changing_;  // of what follows
  std::condition_variable changed_;
  std::size_t next_ = 0, taken_ = 0, computing_ = 0;
  std::vector<char> is_computed_;  // by place
  bool is_taking_ = false;
  std::list<Shared> shared_;
};

thread_local Team* own_team = nullptr;  // whose items this thread computes

}  // namespace

int available_threads() {
  prepare_environment();
  return std::max(1, std::min(omp_get_max_threads(), omp_get_thread_limit()));
}

int threads_for(int threads, std::size_t work) {
  if (work <= 1) return 1;
  if (threads <= 0) threads = available_threads();
  return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(threads), work));
}

void in_threads(int threads, const std::function<bool()>& stopped, const std::function<bool(int)>& next) {
  if (threads <= 0) threads = available_threads();
  FirstError error;
  const auto work = [&](int share) {
    try {
      while (!error && !stopped() && next(share)) {
      }
    } catch (...) {
      error.set(0);
    }
  };
  if (threads == 1)
    work(0);
  else if (own_team)
    own_team->share_out(threads, work);
  else {
    std::atomic<int> next_share = 0;  // OpenMP may give fewer threads
    in_team(threads, [&] {
      for (int share = next_share++; share < threads; share = next_share++) work(share);
    });
  }
  error.rethrow();
}

void in_order(std::size_t count, int threads, const std::function<void(std::size_t, std::size_t)>& compute,
              const std::function<void(std::size_t, std::size_t)>& take) {
  Team team(count, most_in_flight(threads), compute, take);
  in_team(threads, [&] {
    own_team = &team;
    team.work();
    own_team = nullptr;
  });
  team.rethrow();
}

}  // namespace surveymc::montecarlo
