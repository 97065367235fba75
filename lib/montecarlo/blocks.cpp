#include "montecarlo/blocks.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>
#include <latch>
#include <mutex>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

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

bool compute_blocks(const BlockWork& work, const BlockKernel& kernel, const std::function<bool()>& stopped,
                    const std::function<void(std::uint64_t, stats::Tally)>& take) {
  std::vector<std::uint64_t> ends;  // of the ranges, counted in blocks of this work
  for (const BlockRange& r : work.blocks) ends.push_back((ends.empty() ? 0 : ends.back()) + (r.end - r.first));
  const std::uint64_t all = ends.empty() ? 0 : ends.back();
  const auto number_of = [&](std::uint64_t n) {
    const auto range = static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), n) - ends.begin());
    return work.blocks[range].end - (ends[range] - n);
  };
  const auto size = static_cast<std::uint64_t>(work.block_trials);
  const int threads = work.threads > 0 ? work.threads : available_threads();
  require_threads(threads);
  std::exception_ptr error;
  std::mutex taking;  // not omp critical: thread sanitizers know a mutex, but not GCC's OpenMP
  std::atomic<bool> abandon = false;
  std::atomic<std::uint64_t> next = 0;  // our own dynamic schedule: a stop leaves the loop, however many blocks remain
  g_starting = threads > 1;
#pragma omp parallel num_threads(threads)
  for (g_starting = false; !abandon && next < all && !stopped();) {
    const std::uint64_t n = next++;
    if (n >= all) break;
    try {
      const std::uint64_t block = number_of(n), first = block * size;
      stats::Tally tally = kernel({first, static_cast<int>(std::min(size, work.trials - first))});
      const std::scoped_lock lock(taking);
      take(block, std::move(tally));
    } catch (...) {
      abandon = true;
      const std::scoped_lock lock(taking);
      if (!error) error = std::current_exception();
    }
  }
  const std::scoped_lock lock(taking);
  if (error) std::rethrow_exception(error);
  return next >= all;
}

}  // namespace surveymc::montecarlo
