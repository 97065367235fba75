#include "store/paged_file.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace surveymc::store {
namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kLongWrite = std::size_t{1} << 16;
constexpr std::size_t kMostHeldPages = std::size_t{1} << 12;
/// The disk is put to work whenever so much more waits for it, not only at the end.
constexpr std::uint64_t kHandedOver = std::uint64_t{1} << 23;

std::uint64_t page_begin(std::uint64_t at) { return at / kPage * kPage; }

bool is_zero(const char* bytes, std::size_t size) {
  return size == 0 || (bytes[0] == 0 && std::memcmp(bytes, bytes + 1, size - 1) == 0);
}

}  // namespace

void PagedFile::write(std::uint64_t at, const void* bytes, std::size_t size) {
  const auto* next = static_cast<const char*>(bytes);
  end_ = std::max(end_, at + size);
  for (const std::uint64_t stop = at + size; at < stop;) {
    const std::uint64_t begin = page_begin(at), whole = page_begin(stop);
    std::size_t count = 0;
    if (size >= kLongWrite && at == begin && at < whole) {
      count = static_cast<std::size_t>(whole - at);
      held_.erase(held_.lower_bound(at), held_.lower_bound(whole));
      write_through(at, next, count);
    } else {
      count = static_cast<std::size_t>(std::min<std::uint64_t>(stop, begin + kPage) - at);
      std::memcpy(held_page(begin).data() + (at - begin), next, count);
    }
    at += count;
    next += count;
  }
  if (held_.size() > kMostHeldPages) write_held();
}

/// HDF5 fills the place of texts with zeros first, which the end of a file has anyway.
void PagedFile::write_through(std::uint64_t at, const char* bytes, std::size_t size) {
  if (at >= on_disk_ && is_zero(bytes, size)) return;
  file_.write_at(at, {bytes, size});
  on_disk_ = std::max(on_disk_, at + size);
  if (on_disk_ >= handed_over_ + kHandedOver) {
    file_.start_writing(handed_over_, on_disk_ - handed_over_);
    handed_over_ = on_disk_;
  }
  long_writes_ += size;
  if (written_) written_(long_writes_);
}

PagedFile::Page& PagedFile::held_page(std::uint64_t begin) {
  const auto found = held_.lower_bound(begin);
  if (found != held_.end() && found->first == begin) return *found->second;
  auto page = std::make_unique<Page>();  // zeros
  if (begin < on_disk_) file_.read_at(begin, *page);
  return *held_.emplace_hint(found, begin, std::move(page))->second;
}

void PagedFile::read(std::uint64_t at, void* bytes, std::size_t size) const {
  auto* next = static_cast<char*>(bytes);
  for (const std::uint64_t stop = at + size; at < stop;) {
    const std::uint64_t begin = page_begin(at);
    const auto page = held_.lower_bound(begin);
    const bool is_held = page != held_.end() && page->first == begin;
    const std::uint64_t until = is_held ? begin + kPage : page != held_.end() ? page->first : stop;
    const auto count = static_cast<std::size_t>(std::min(stop, until) - at);
    if (is_held)
      std::memcpy(next, page->second->data() + (at - begin), count);
    else
      file_.read_at(at, {next, count});
    at += count;
    next += count;
  }
}

/// Neighbours together.
void PagedFile::write_held() {
  constexpr std::size_t kMostTogether = std::size_t{1} << 20;
  std::string run;
  std::uint64_t begin = 0;
  const auto write_run = [&] {
    if (run.empty()) return;
    file_.write_at(begin, run);
    on_disk_ = std::max<std::uint64_t>(on_disk_, begin + run.size());
    run.clear();
  };
  for (const auto& [at, page] : held_) {
    if (at != begin + run.size() || run.size() >= kMostTogether) write_run();
    if (run.empty()) begin = at;
    run.append(page->data(), page->size());
  }
  write_run();
  held_.clear();
}

void PagedFile::finish(std::uint64_t size) {
  write_held();
  file_.set_size(size);
}

}  // namespace surveymc::store
