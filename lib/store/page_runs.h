#pragma once
/// Pages of a new file on their way to the disk.
#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "store/atomic_file.h"
#include "store/seal.h"

namespace surveymc::store {

/// Gathers pages that follow each other in runs of 1 MiB, hashes and writes them. A thread does this while further runs
/// are filled, in the order in which they came; up to four that follow each other it writes at once. Through the
/// system's page cache, where a write is a copy, the caller does it alone for the first 32 MiB, which takes less
/// processor time. Where the system starts no thread, or has no memory for it, the caller goes on. All members throw
/// what the disk did: std::system_error; after the first one all do.
class PageRuns {
 public:
  /// `past_cache`: by AtomicFile::write_past_cache().
  PageRuns(AtomicFile& file, bool past_cache) : file_(file), past_cache_(past_cache) {}
  PageRuns(const PageRuns&) = delete;
  PageRuns& operator=(const PageRuns&) = delete;
  /// What is not written yet stays out.
  ~PageRuns();

  /// `at` and `size` are multiples of kSealedPage. Copies the bytes.
  void add(std::uint64_t at, const char* bytes, std::size_t size);
  /// All that was added is in the file.
  void finish();
  /// By the number of the page; of those that were added, behind finish().
  const std::vector<PageHash>& hashes() const { return hashes_; }

 private:
  static constexpr std::size_t kRun = std::size_t{1} << 20;
  static constexpr std::size_t kMostRuns = 8;
  static constexpr std::size_t kMostAtOnce = 4;
  static constexpr std::size_t kAlone = 32;  ///< runs that the caller writes itself through the page cache
  struct Free {
    void operator()(char* bytes) const;
  };
  struct Run {
    std::uint64_t at = 0;
    std::size_t size = 0;
  };

  std::size_t place(std::uint64_t run) const { return static_cast<std::size_t>(run % places_); }
  void make_places(std::size_t count);
  void submit();
  void write(const Run& run, const char* bytes);
  void start_thread();
  void work();

  AtomicFile& file_;
  const bool past_cache_;
  std::unique_ptr<char, Free> memory_;  ///< of the places, one behind the other
  std::size_t places_ = 0;              ///< run k is in place k modulo this number
  std::array<Run, kMostRuns> runs_;     ///< by place
  std::uint64_t started_ = 0;           ///< what is in front of it the system has been asked to write to the disk

  std::thread thread_;
  std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  std::uint64_t submitted_ = 0, written_ = 0;  ///< numbers of runs; run `submitted_` is being filled
  bool is_over_ = false;
  std::exception_ptr error_;
  std::vector<PageHash> hashes_;
};

}  // namespace surveymc::store
