#pragma once
/// Pages of a new file on their way to the disk.
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "store/atomic_file.h"
#include "store/seal.h"

namespace surveymc::store {

/// Gathers pages that follow each other in runs of 1 MiB, hashes and writes them. Behind the first 64 MiB, for which
/// that takes less processor time, a thread does this while the next run is filled, in the order in which they came.
/// Where the system starts no thread, the caller goes on. All members throw what the disk did: std::system_error; after
/// the first one all do.
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
  static constexpr std::size_t kMostRuns = 4;
  static constexpr std::size_t kAlone = 64;  ///< runs that the caller writes itself
  struct Run {
    Run();
    struct Free {
      void operator()(char* bytes) const;
    };
    std::unique_ptr<char, Free> bytes;
    std::uint64_t at = 0;
    std::size_t size = 0;
  };

  void submit();
  std::unique_ptr<Run> empty_run();
  void write(const Run& run);
  bool start_thread();
  void work();

  AtomicFile& file_;
  const bool past_cache_;
  std::unique_ptr<Run> filled_;  ///< at present
  std::size_t runs_ = 0;         ///< that have memory
  std::size_t written_alone_ = 0;
  std::uint64_t started_ = 0;  ///< what is in front of it the system has been asked to write to the disk

  std::thread thread_;
  bool has_no_thread_ = false;  ///< there is none to be had
  std::mutex mutex_;            ///< of all below
  std::condition_variable changed_;
  std::deque<std::unique_ptr<Run>> full_, empty_;
  bool is_writing_ = false, is_over_ = false;
  std::exception_ptr error_;
  std::vector<PageHash> hashes_;
};

}  // namespace surveymc::store
