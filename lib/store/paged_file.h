#pragma once
/// What HDF5 writes, on its way to the disk: long runs of values go there at once, all else waits in memory.
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "store/atomic_file.h"

namespace surveymc::store {

/// A new file of pages. Whole pages of a long write go to `file` as they come; pages of short writes, as those of
/// HDF5's own records, which change often, are held, some 16 MB at most. All members throw std::system_error.
class PagedFile {
 public:
  /// `written` is called with the number of bytes of long writes so far; what it throws passes through.
  explicit PagedFile(AtomicFile& file, std::function<void(std::uint64_t)> written = {})
      : file_(file), written_(std::move(written)) {}
  PagedFile(const PagedFile&) = delete;
  PagedFile& operator=(const PagedFile&) = delete;

  void write(std::uint64_t at, const void* bytes, std::size_t size);
  /// Zeros where nothing was written.
  void read(std::uint64_t at, void* bytes, std::size_t size) const;
  /// Where the last byte that was written ends.
  std::uint64_t end() const { return end_; }
  /// Everything is in the file, which has `size` bytes then.
  void finish(std::uint64_t size);

 private:
  using Page = std::array<char, 4096>;
  void write_through(std::uint64_t at, const char* bytes, std::size_t size);
  Page& held_page(std::uint64_t begin);
  void write_held();

  AtomicFile& file_;
  std::function<void(std::uint64_t)> written_;
  std::uint64_t long_writes_ = 0;
  std::map<std::uint64_t, std::unique_ptr<Page>> held_;  ///< by where they begin
  std::uint64_t end_ = 0;
  std::uint64_t on_disk_ = 0;      ///< nothing behind it was written to the file
  std::uint64_t handed_over_ = 0;  ///< what is in front of it the system has been asked to write to the disk
};

}  // namespace surveymc::store
