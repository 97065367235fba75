#include "store/row_spool.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "base/error.h"
#include "base/retry.h"

namespace surveymc::store {
namespace {

std::string spool_folder() {
  const char* named = std::getenv("TMPDIR");
  return named && *named ? named : "/var/tmp";
}

/// A file that is gone when nothing refers to it any more.
class SpoolFile {
 public:
  static std::shared_ptr<SpoolFile> open() {
    const std::string folder = spool_folder();
    std::string name = folder + "/surveymc_rows_XXXXXX";
    const int file = mkostemp(name.data(), O_CLOEXEC);
    if (file < 0) refuse(folder, errno);
    unlink(name.c_str());
    return std::shared_ptr<SpoolFile>(new SpoolFile(folder, file));
  }
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;
  ~SpoolFile() { close(file_); }

  /// Where the bytes begin.
  std::uint64_t append(const void* bytes, std::size_t size) {
    transfer(pwrite, static_cast<const char*>(bytes), size, end_, ENOSPC);
    end_ += size;
    return end_ - size;
  }

  void read(std::uint64_t begin, void* bytes, std::size_t size) const {
    transfer(pread, static_cast<char*>(bytes), size, begin, EIO);
  }

 private:
  SpoolFile(std::string folder, int file) : folder_(std::move(folder)), file_(file) {}

  /// Calls pread or pwrite until all bytes are done. `end`: the error where nothing more is done.
  template <class Call, class Byte>
  void transfer(const Call& call, Byte* next, std::size_t left, std::uint64_t at, int end) const {
    while (left > 0) {
      const ssize_t n = uninterrupted([&] { return call(file_, next, left, static_cast<off_t>(at)); });
      if (n <= 0) refuse(folder_, n < 0 ? errno : end);
      next += n;
      left -= static_cast<std::size_t>(n);
      at += static_cast<std::uint64_t>(n);
    }
  }

  [[noreturn]] static void refuse(const std::string& folder, int error_number) {
    throw IoError(
        fmt::format("{}: rows that do not fit in memory cannot be kept there: {}: name a folder with room by "
                    "the environment variable TMPDIR",
                    folder, std::generic_category().message(error_number)));
  }

  std::string folder_;
  int file_;
  std::uint64_t end_ = 0;
};

/// Values that were moved together: numbers as they are; of texts the lengths, then the letters.
struct Extent {
  std::size_t values = 0;
  std::uint64_t begin = 0, bytes = 0;  ///< `bytes` of the letters
};

/// Immutable: more values make another one, which shares the file.
class SpooledValues final : public DiskValues {
 public:
  SpooledValues(std::shared_ptr<SpoolFile> file, std::size_t kind) : file_(std::move(file)), kind_(kind) {}

  std::shared_ptr<const SpooledValues> with(const Values& more) const {
    auto longer = std::make_shared<SpooledValues>(*this);
    std::visit([&](const auto& v) { longer->extents_.push_back(longer->written(v)); }, more);
    longer->size_ += longer->extents_.back().values;
    return longer;
  }

  std::size_t size() const override { return size_; }

  Values read(std::size_t first, std::size_t count) const override {
    if (kind_ == 0) return read_list<double>(first, count);
    if (kind_ == 1) return read_list<std::int64_t>(first, count);
    return read_list<std::string>(first, count);
  }

 private:
  template <class T>
  Extent written(const std::vector<T>& values) {
    return {values.size(), file_->append(values.data(), values.size() * sizeof(T)), 0};
  }
  Extent written(const std::vector<std::string>& values) {
    std::vector<std::uint64_t> lengths;
    std::string letters;
    for (const std::string& s : values) {
      lengths.push_back(s.size());
      letters += s;
    }
    const std::uint64_t begin = file_->append(lengths.data(), lengths.size() * sizeof(std::uint64_t));
    file_->append(letters.data(), letters.size());
    return {values.size(), begin, letters.size()};
  }

  template <class T>
  std::vector<T> read_list(std::size_t first, std::size_t count) const {
    std::vector<T> out;
    out.reserve(count);
    std::size_t begin = 0;  // of the extent, in values
    for (const Extent& e : extents_) {
      const std::size_t from = std::max(first, begin), to = std::min(first + count, begin + e.values);
      if (from < to) add_values(e, from - begin, to - from, out);
      begin += e.values;
    }
    return out;
  }
  template <class T>
  void add_values(const Extent& e, std::size_t from, std::size_t count, std::vector<T>& out) const {
    const std::size_t at = out.size();
    out.resize(at + count);
    file_->read(e.begin + from * sizeof(T), out.data() + at, count * sizeof(T));
  }
  void add_values(const Extent& e, std::size_t from, std::size_t count, std::vector<std::string>& out) const {
    std::vector<std::uint64_t> lengths(e.values);
    file_->read(e.begin, lengths.data(), e.values * sizeof(std::uint64_t));
    std::string letters(e.bytes, '\0');
    file_->read(e.begin + e.values * sizeof(std::uint64_t), letters.data(), letters.size());
    std::size_t at = 0;
    for (std::size_t i = 0; i < from + count; at += lengths[i++])
      if (i >= from) out.push_back(letters.substr(at, lengths[i]));
  }

  std::shared_ptr<SpoolFile> file_;
  std::size_t kind_, size_ = 0;
  std::vector<Extent> extents_;
};

}  // namespace

void move_to_disk(Table& table) {
  std::shared_ptr<SpoolFile> file;
  std::vector<std::shared_ptr<const DiskValues>> moved;  // the table changes when all have been written
  for (const Column& c : table.columns) {
    if (const auto kept = std::dynamic_pointer_cast<const SpooledValues>(c.on_disk)) {
      moved.push_back(kept->with(c.values));
      continue;
    }
    if (!file) file = SpoolFile::open();
    auto all = std::make_shared<const SpooledValues>(file, c.values.index());
    c.for_each_piece([&](const Values& piece) { all = all->with(piece); });
    moved.push_back(std::move(all));
  }
  for (std::size_t i = 0; i < moved.size(); ++i) {
    table.columns[i].on_disk = std::move(moved[i]);
    std::visit([](auto& values) { values = std::decay_t<decltype(values)>(); }, table.columns[i].values);
  }
}

void hold_less(Table& table) {
  std::size_t bytes = 0;
  for (const Column& c : table.columns)
    bytes += std::visit(
        [](const auto& values) {
          constexpr bool is_text = std::is_same_v<std::decay_t<decltype(values)>, std::vector<std::string>>;
          return values.size() * (is_text ? sizeof(std::string) : sizeof(double));
        },
        c.values);
  if (bytes > kMostHeldBytes) move_to_disk(table);
}

}  // namespace surveymc::store
