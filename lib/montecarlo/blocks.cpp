#include "montecarlo/blocks.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <latch>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

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

int available_threads() { return omp_get_max_threads(); }

namespace {

// GCC's OpenMP ends the program with code 1 where a thread cannot be started. So as many are tried before; and should
// one fail between that and OpenMP's own start, the program ends with the right code.
constexpr int kExitNoThreads = 71;  // cli/run_setup.h
std::atomic<bool> g_starting = false;

void end_while_starting() {
  if (!g_starting) return;
  constexpr char kText[] = "error: the system starts no more threads: give fewer with --threads\n";
  [[maybe_unused]] const ssize_t n = write(STDERR_FILENO, kText, sizeof kText - 1);
  _exit(kExitNoThreads);
}

/// Those that OpenMP has started it keeps, and they need no try again.
void require_threads(int threads) {
  static std::mutex trying;
  static int tried = 1;
  const std::scoped_lock lock(trying);
  if (threads <= tried) return;
  const int more = threads - tried;
  std::latch all_tried(1);
  std::vector<std::thread> started;
  std::string fault;
  try {
    for (int i = 0; i < more; ++i) started.emplace_back([&] { all_tried.wait(); });
  } catch (const std::system_error& e) {
    fault = e.code().message();
  }
  all_tried.count_down();
  for (std::thread& t : started) t.join();
  if (!fault.empty())
    throw NoThreads(
        fmt::format("the system starts only {} of {} threads ({}): give fewer with --threads, or raise the "
                    "limit (ulimit -u)",
                    tried + static_cast<int>(started.size()), threads, fault));
  if (tried == 1) std::atexit(end_while_starting);
  tried = threads;
}

}  // namespace

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
  require_threads(threads);
  std::exception_ptr error;
  std::mutex failing;                 // not omp critical: thread sanitizers know a mutex, but not GCC's OpenMP
  std::atomic<bool> abandon = false;  // our own dynamic schedule: a stop leaves the loop at once
  g_starting = threads > 1;
#pragma omp parallel num_threads(threads)
  for (g_starting = false; !abandon && !stopped();) {
    try {
      if (!next(omp_get_thread_num())) break;
    } catch (...) {
      abandon = true;
      const std::scoped_lock lock(failing);
      if (!error) error = std::current_exception();
    }
  }
  const std::scoped_lock lock(failing);
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
