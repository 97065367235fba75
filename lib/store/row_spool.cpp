#include "store/row_spool.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "base/bytes.h"
#include "base/error.h"

namespace surveymc::store {
namespace {

/// A file that is gone when nothing refers to it any more.
class SpoolFile {
 public:
  SpoolFile() {
    const char* named = std::getenv("TMPDIR");
    folder_ = named && *named ? named : "/var/tmp";
    std::string name = folder_ + "/surveymc_rows_XXXXXX";
    const int file = mkostemp(name.data(), O_CLOEXEC);
    require(file >= 0);
    unlink(name.c_str());
    file_.reset(fdopen(file, "w+b"));
    require(file_ != nullptr);
  }

  /// Where the bytes begin.
  std::uint64_t append(const std::string& bytes) {
    go_to(end_);
    require(std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size());
    end_ += bytes.size();
    return end_ - bytes.size();
  }
  std::string read(std::uint64_t begin, std::size_t size) const {
    std::string bytes(size, '\0');
    go_to(begin);
    require(std::fread(bytes.data(), 1, size, file_.get()) == size);
    return bytes;
  }

 private:
  /// Also writes what was gathered: an append that went wrong is found before anything is read.
  void go_to(std::uint64_t at) const { require(fseeko(file_.get(), static_cast<off_t>(at), SEEK_SET) == 0); }
  void require(bool ok) const {
    if (!ok)
      throw IoError(
          fmt::format("{}: rows that do not fit in memory cannot be kept there: {}: name a folder with room by "
                      "the environment variable TMPDIR",
                      folder_, std::generic_category().message(errno)));
  }

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string folder_;
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t end_ = 0;
};

/// Values of a column in records of at most kPieceRows values. Immutable: more values make another one, which shares
/// the file.
class SpooledValues final : public DiskValues {
 public:
  SpooledValues(std::shared_ptr<SpoolFile> file, Values none) : file_(std::move(file)), none_(std::move(none)) {}

  void add(const Values& values) {
    std::visit(
        [&](const auto& list) {
          for (std::size_t at = 0; at < list.size(); at += kPieceRows) {
            const auto begin = list.begin() + static_cast<std::ptrdiff_t>(at);
            const std::size_t count = std::min(kPieceRows, list.size() - at);
            ByteWriter out;
            out.put(std::decay_t<decltype(list)>(begin, begin + static_cast<std::ptrdiff_t>(count)));
            const std::string bytes = out.take();
            records_.push_back({size_, count, file_->append(bytes), bytes.size()});
            size_ += count;
          }
        },
        values);
  }

  std::size_t size() const override { return size_; }

  Values read(std::size_t first, std::size_t count) const override {
    Values out = none_;
    std::visit(
        [&](auto& list) {
          for (const Record& r : records_) {
            const std::size_t from = std::max(first, r.first), to = std::min(first + count, r.first + r.count);
            if (from >= to) continue;
            const std::string bytes = file_->read(r.begin, r.bytes);
            std::decay_t<decltype(list)> all;
            ByteReader(bytes).fields(all);
            list.insert(list.end(), all.begin() + static_cast<std::ptrdiff_t>(from - r.first),
                        all.begin() + static_cast<std::ptrdiff_t>(to - r.first));
          }
        },
        out);
    return out;
  }

 private:
  struct Record {
    std::size_t first, count;
    std::uint64_t begin;
    std::size_t bytes;
  };
  std::shared_ptr<SpoolFile> file_;
  Values none_;
  std::size_t size_ = 0;
  std::vector<Record> records_;
};

}  // namespace

void move_to_disk(Table& table) {
  std::shared_ptr<SpoolFile> file;
  std::vector<std::shared_ptr<const DiskValues>> moved;  // the table changes when all have been written
  for (const Column& c : table.columns) {
    std::shared_ptr<SpooledValues> all;
    if (const auto kept = std::dynamic_pointer_cast<const SpooledValues>(c.on_disk)) {
      all = std::make_shared<SpooledValues>(*kept);
      all->add(c.values);
    } else {
      if (!file) file = std::make_shared<SpoolFile>();
      all = std::make_shared<SpooledValues>(
          file, std::visit([](const auto& v) { return Values(std::decay_t<decltype(v)>()); }, c.values));
      c.for_each_piece([&](const Values& piece) { all->add(piece); });
    }
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
    bytes += std::visit([](const auto& values) { return values.size() * sizeof(values[0]); }, c.values);
  if (bytes > kMostHeldBytes) move_to_disk(table);
}

}  // namespace surveymc::store
