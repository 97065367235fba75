#include "montecarlo/blocks.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <latch>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "montecarlo/block_queue.h"

namespace surveymc::montecarlo {

std::vector<BlockRange> gaps(BlockRange all, const std::vector<BlockRange>& covered) {
  std::vector<BlockRange> left;
  std::uint64_t reached = all.first;
  for (const BlockRange& c : covered) {
    if (c.first > reached && reached < all.end) left.push_back({reached, std::min(c.first, all.end)});
    reached = std::max(reached, c.end);
  }
  if (reached < all.end) left.push_back({reached, all.end});
  return left;
}

std::uint64_t count_of(const std::vector<BlockRange>& blocks) {
  std::uint64_t n = 0;
  for (const BlockRange& r : blocks) n += r.end - r.first;
  return n;
}

std::vector<std::vector<BlockRange>> divided(const std::vector<BlockRange>& blocks, std::size_t shares) {
  const std::uint64_t all = count_of(blocks);
  std::vector<std::vector<BlockRange>> lists(shares);
  std::uint64_t before = 0;  // blocks in front of the range
  for (const BlockRange& r : blocks) {
    for (std::size_t s = 0; s < shares; ++s) {
      const std::uint64_t begin = std::max(all * s / shares, before),
                          end = std::min(all * (s + 1) / shares, before + (r.end - r.first));
      if (begin < end) lists[s].push_back({r.first + (begin - before), r.first + (end - before)});
    }
    before += r.end - r.first;
  }
  return lists;
}

int available_threads() {
  if (const char* text = std::getenv("OMP_NUM_THREADS")) {
    const std::string_view number = text;
    int threads = 0;
    std::from_chars(number.data(), number.data() + number.size(), threads);  // stays 0 where it is none
    if (threads > 0) return threads;
  }
  if (cpu_set_t cores; sched_getaffinity(0, sizeof cores, &cores) == 0) return CPU_COUNT(&cores);
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));  // more cores than a cpu_set_t has
}

std::vector<BlockRange> BlockQueue::take_first(std::uint64_t count) {
  std::vector<BlockRange> piece;
  while (count > 0 && next_ < open_.size()) {
    BlockRange& range = open_[next_];
    const std::uint64_t n = std::min(count, range.end - range.first);
    if (n > 0) piece.push_back({range.first, range.first + n});
    range.first += n;
    count -= n;
    left_ -= n;
    if (range.first == range.end) ++next_;
  }
  return piece;
}

std::optional<std::uint64_t> BlockQueue::take() {
  const std::scoped_lock lock(taking_);
  const std::vector<BlockRange> one = take_first(1);
  return one.empty() ? std::nullopt : std::optional(one.front().first);
}

std::vector<BlockRange> BlockQueue::take_piece(double share, std::uint64_t least, std::uint64_t most) {
  const std::scoped_lock lock(taking_);
  const auto own = static_cast<std::uint64_t>(std::ceil(static_cast<double>(left_) * share));
  return take_first(std::min(most, std::max(own / 4, std::min(least, own))));
}

std::uint64_t BlockQueue::left() const {
  const std::scoped_lock lock(taking_);
  return left_;
}

bool compute_blocks(const BlockWork& work, const BlockKernel& kernel, const std::function<bool()>& stopped,
                    const std::function<void(std::uint64_t, stats::Tally)>& take) {
  BlockQueue queue(work.blocks);
  return compute_blocks(queue, work, kernel, stopped, take);
}

void in_threads(int threads, const std::function<bool()>& stopped, const std::function<bool(int)>& next) {
  if (threads <= 0) threads = available_threads();
  std::exception_ptr error;
  std::mutex failing;
  std::atomic<bool> abandon = false;
  const auto work = [&](int thread) {
    while (!abandon && !stopped()) try {
        if (!next(thread)) break;
      } catch (...) {
        abandon = true;
        const std::scoped_lock lock(failing);
        if (!error) error = std::current_exception();
      }
  };
  std::latch all_started(1);
  std::vector<std::jthread> others;  // beside this one
  try {
    others.reserve(static_cast<std::size_t>(threads) - 1);
    for (int thread = 1; thread < threads; ++thread)
      others.emplace_back([&, thread] {
        all_started.wait();
        work(thread);
      });
  } catch (const std::system_error& e) {
    error = std::make_exception_ptr(NoThreads(fmt::format(
        "the system starts only {} of {} threads ({}): give fewer with --threads, or raise the limit (ulimit -u, -v)",
        others.size() + 1, threads, e.code().message())));
  } catch (...) {
    error = std::current_exception();
  }
  if (error) abandon = true;
  all_started.count_down();
  work(0);
  others.clear();  // waits for them
  if (error) std::rethrow_exception(error);
}

bool compute_blocks(BlockQueue& queue, const BlockWork& work, const BlockKernel& kernel,
                    const std::function<bool()>& stopped,
                    const std::function<void(std::uint64_t, stats::Tally)>& take) {
  const auto size = static_cast<std::uint64_t>(work.block_trials);
  std::mutex taking;
  in_threads(work.threads, stopped, [&](int) {
    const std::optional<std::uint64_t> block = queue.take();
    if (!block) return false;
    const std::uint64_t first = *block * size;
    stats::Tally tally = kernel({first, static_cast<int>(std::min(size, work.trials - first))});
    const std::scoped_lock lock(taking);
    take(*block, std::move(tally));
    return true;
  });
  return queue.left() == 0;
}

}  // namespace surveymc::montecarlo
