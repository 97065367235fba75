#include "store/page_runs.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

namespace surveymc::store {
namespace {

constexpr std::size_t kAlignment = 4096;  // for AtomicFile::write_past_cache()

}  // namespace

void PageRuns::Run::Free::operator()(char* bytes) const { std::free(bytes); }

PageRuns::Run::Run() : bytes(static_cast<char*>(std::aligned_alloc(kAlignment, kRun))) {
  if (!bytes) throw std::bad_alloc();
}

PageRuns::~PageRuns() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    full_.clear();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PageRuns::add(std::uint64_t at, const char* bytes, std::size_t size) {
  while (size > 0) {
    if (filled_ && (filled_->at + filled_->size != at || filled_->size == kRun)) submit();
    if (!filled_) {
      filled_ = empty_run();
      filled_->at = at;
      filled_->size = 0;
    }
    const std::size_t count = std::min(size, kRun - filled_->size);
    std::memcpy(filled_->bytes.get() + filled_->size, bytes, count);
    filled_->size += count;
    at += count;
    bytes += count;
    size -= count;
  }
}

void PageRuns::finish() {
  if (filled_) submit();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return (full_.empty() && !is_writing_) || error_; });
  if (error_) std::rethrow_exception(error_);
}

std::unique_ptr<PageRuns::Run> PageRuns::empty_run() {
  std::unique_lock lock(mutex_);
  if (error_) std::rethrow_exception(error_);
  if (empty_.empty() && runs_ < kMostRuns) {
    ++runs_;
    return std::make_unique<Run>();
  }
  changed_.wait(lock, [&] { return !empty_.empty() || error_; });
  if (error_) std::rethrow_exception(error_);
  std::unique_ptr<Run> run = std::move(empty_.back());
  empty_.pop_back();
  return run;
}

void PageRuns::submit() {
  const bool by_thread = thread_.joinable() || (++written_alone_ > kAlone && start_thread());
  if (!by_thread) {
    try {
      write(*filled_);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      error_ = std::current_exception();
    }
  }
  {
    const std::lock_guard lock(mutex_);
    (by_thread ? full_ : empty_).push_back(std::move(filled_));
    if (!by_thread && error_) std::rethrow_exception(error_);
  }
  changed_.notify_all();
}

bool PageRuns::start_thread() {
  if (has_no_thread_) return false;
  try {
    thread_ = std::thread([this] { work(); });
  } catch (const std::system_error&) {
    has_no_thread_ = true;
  }
  return !has_no_thread_;
}

void PageRuns::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return !full_.empty() || is_over_; });
    if (is_over_ || error_) return;
    std::unique_ptr<Run> run = std::move(full_.front());
    full_.pop_front();
    is_writing_ = true;
    lock.unlock();
    std::exception_ptr error;
    try {
      write(*run);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    is_writing_ = false;
    error_ = error;
    empty_.push_back(std::move(run));
    changed_.notify_all();
  }
}

void PageRuns::write(const Run& run) {
  std::vector<PageHash> hashes;
  for (std::size_t at = 0; at < run.size; at += kSealedPage)
    hashes.push_back(page_hash(run.bytes.get() + at, kSealedPage));
  const std::span<const char> bytes(run.bytes.get(), run.size);
  if (past_cache_) {
    file_.write_past_cache(run.at, bytes);
  } else {
    file_.write_at(run.at, bytes);
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
