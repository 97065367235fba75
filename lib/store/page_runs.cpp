#include "store/page_runs.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

#include "base/huge_pages.h"

namespace surveymc::store {
namespace {

constexpr std::size_t kAlignment = 4096;  // for AtomicFile::write_past_cache()

}  // namespace

void PageRuns::Free::operator()(char* bytes) const { std::free(bytes); }

/// Throws std::bad_alloc, and then has changed nothing.
void PageRuns::make_places(std::size_t count) {
  const std::size_t size = count * kRun;
  const std::size_t alignment = size % kHugePage == 0 ? kHugePage : kAlignment;
  std::unique_ptr<char, Free> memory(static_cast<char*>(std::aligned_alloc(alignment, size)));
  if (!memory) throw std::bad_alloc();
  prefer_huge_pages(memory.get(), size);
  memory_ = std::move(memory);
  places_ = count;
  runs_ = {};
}

PageRuns::~PageRuns() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PageRuns::add(std::uint64_t at, const char* bytes, std::size_t size) {
  if (!memory_ && past_cache_) start_thread();
  if (!memory_) make_places(1);
  while (size > 0) {
    // The caller alone counts runs that are submitted.
    if (const Run& run = runs_[place(submitted_)]; run.size > 0 && (run.at + run.size != at || run.size == kRun))
      submit();
    Run& run = runs_[place(submitted_)];
    if (run.size == 0) run.at = at;
    const std::size_t count = std::min(size, kRun - run.size);
    std::memcpy(memory_.get() + place(submitted_) * kRun + run.size, bytes, count);
    run.size += count;
    at += count;
    bytes += count;
    size -= count;
  }
}

void PageRuns::finish() {
  if (memory_ && runs_[place(submitted_)].size > 0) submit();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return written_ == submitted_ || error_; });
  if (error_) std::rethrow_exception(error_);
}

/// The run that is filled is on its way, and there is a place for the next one.
void PageRuns::submit() {
  if (!thread_.joinable()) {
    try {
      write(runs_[place(submitted_)], memory_.get() + place(submitted_) * kRun);
    } catch (...) {
      error_ = std::current_exception();
    }
    ++written_;
  }
  {
    std::unique_lock lock(mutex_);
    ++submitted_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return submitted_ - written_ < places_ || error_; });
    if (error_) std::rethrow_exception(error_);
    runs_[place(submitted_)].size = 0;
  }
  if (submitted_ == kAlone && !past_cache_) start_thread();
}

/// All runs are written, and none is filled.
void PageRuns::start_thread() {
  try {
    make_places(kMostRuns);
    thread_ = std::thread([this] { work(); });
  } catch (const std::bad_alloc&) {
  } catch (const std::system_error&) {
  }
}

void PageRuns::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return written_ < submitted_ || is_over_; });
    if (is_over_ || error_) return;
    Run together = runs_[place(written_)];
    std::uint64_t end = written_ + 1;
    // What follows a run is in a run of its own only if that one is full, or was waited for: places are neighbours,
    // too.
    for (; end < submitted_ && end - written_ < kMostAtOnce && place(end) > 0 &&
           runs_[place(end)].at == together.at + together.size;
         ++end)
      together.size += runs_[place(end)].size;
    lock.unlock();
    std::exception_ptr error;
    try {
      write(together, memory_.get() + place(written_) * kRun);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    written_ = end;
    error_ = error;
    changed_.notify_all();
  }
}

void PageRuns::write(const Run& run, const char* bytes) {
  std::vector<PageHash> hashes;
  for (std::size_t at = 0; at < run.size; at += kSealedPage) hashes.push_back(page_hash(bytes + at, kSealedPage));
  if (past_cache_) {
    file_.write_past_cache(run.at, {bytes, run.size});
  } else {
    file_.write_at(run.at, {bytes, run.size});
    // The disk is put to work now and then, not only at the end
    constexpr std::uint64_t kApart = std::uint64_t{1} << 23;
    if (const std::uint64_t end = run.at + run.size; end >= started_ + kApart) {
      file_.start_writing(started_, end - started_);
      started_ = end;
    }
  }
  const std::lock_guard lock(mutex_);
  const std::size_t first = static_cast<std::size_t>(run.at / kSealedPage);
  if (hashes_.size() < first + hashes.size()) hashes_.resize(first + hashes.size());
  std::copy(hashes.begin(), hashes.end(), hashes_.begin() + static_cast<std::ptrdiff_t>(first));
}

}  // namespace surveymc::store
