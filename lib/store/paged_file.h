#pragma once
/// What HDF5 writes, on its way to the disk: long runs of values go there at once, all else waits in memory.
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "store/atomic_file.h"
#include "store/page_runs.h"

namespace surveymc::store {

/// A new file of pages, which ends in its seal. Whole pages of a long write go to `file` as they come, by a thread of
/// their own if there are many, and so does a page that the writes before have begun; pages of short writes, as those
/// of HDF5's own records, which change often, are held, some 16 MB at most. All members throw std::system_error.
class PagedFile {
 public:
  /// `past_cache`: the file is large, and goes past the system's page cache.
  /// `written` is called with the number of bytes of long writes so far; what it throws passes through.
  explicit PagedFile(AtomicFile& file, bool past_cache = false, std::function<void(std::uint64_t)> written = {})
      : file_(file), runs_(file, past_cache), written_(std::move(written)) {}
  PagedFile(const PagedFile&) = delete;
  PagedFile& operator=(const PagedFile&) = delete;

  void write(std::uint64_t at, const void* bytes, std::size_t size);
  /// Zeros where nothing was written.
  void read(std::uint64_t at, void* bytes, std::size_t size);
  /// Where the last byte that was written ends.
  std::uint64_t end() const { return end_; }
  /// Everything is in the file: `size` bytes, and their seal behind them.
  void finish(std::uint64_t size);

 private:
  struct Page {
    std::array<char, kSealedPage> bytes{};
    std::size_t filled = 0;  ///< so many from its begin were written one after the other
  };
  void write_through(std::uint64_t at, const char* bytes, std::size_t size);
  Page& held_page(std::uint64_t begin);
  void write_held();
  bool is_written(std::uint64_t begin) const;
  std::vector<PageHash> hashes(std::uint64_t size) const;

  AtomicFile& file_;
  PageRuns runs_;
  std::function<void(std::uint64_t)> written_;
  std::uint64_t long_writes_ = 0;
  std::map<std::uint64_t, std::unique_ptr<Page>> held_;  ///< by where they begin
  std::vector<bool> is_written_;                         ///< by number: pages that went to `runs_`, held since or not
  std::uint64_t end_ = 0;
};

}  // namespace surveymc::store
