#include "store/paged_file.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace surveymc::store {
namespace {

constexpr std::size_t kPage = kSealedPage;
constexpr std::size_t kMostHeldPages = std::size_t{1} << 8;

std::uint64_t page_begin(std::uint64_t at) { return at / kPage * kPage; }

std::size_t page_number(std::uint64_t at) { return static_cast<std::size_t>(at / kPage); }

bool is_zero(const char* bytes, std::size_t size) {
  return size == 0 || (bytes[0] == 0 && std::memcmp(bytes, bytes + 1, size - 1) == 0);
}

}  // namespace

bool PagedFile::is_written(std::uint64_t begin) const {
  return page_number(begin) < is_written_.size() && is_written_[page_number(begin)];
}

void PagedFile::write(std::uint64_t at, const void* bytes, std::size_t size) {
  const auto* next = static_cast<const char*>(bytes);
  end_ = std::max(end_, at + size);
  for (const std::uint64_t stop = at + size; at < stop;) {
    const std::uint64_t begin = page_begin(at), whole = page_begin(stop);
    std::size_t count = 0;
    if (at == begin && at < whole) {
      count = static_cast<std::size_t>(whole - at);
      held_.erase(held_.lower_bound(at), held_.lower_bound(whole));
      write_through(at, next, count);
    } else {
      count = static_cast<std::size_t>(std::min<std::uint64_t>(stop, begin + kPage) - at);
      Page& page = held_page(begin);
      std::memcpy(page.bytes.data() + (at - begin), next, count);
      if (at - begin == page.filled) page.filled += count;
      if (page.filled == kPage && size >= kPage) {
        write_through(begin, page.bytes.data(), kPage);
        held_.erase(begin);
      }
    }
    at += count;
    next += count;
  }
  if (held_.size() > kMostHeldPages) write_held();
  if (size < kPage) return;
  long_writes_ += size;
  if (written_) written_(long_writes_);
}

/// HDF5 fills the place of texts with zeros first, which the end of a file has anyway.
void PagedFile::write_through(std::uint64_t at, const char* bytes, std::size_t size) {
  if (page_number(at) >= is_written_.size() && is_zero(bytes, size)) return;
  runs_.add(at, bytes, size);
  if (is_written_.size() < page_number(at + size)) is_written_.resize(page_number(at + size));
  std::fill(is_written_.begin() + static_cast<std::ptrdiff_t>(page_number(at)),
            is_written_.begin() + static_cast<std::ptrdiff_t>(page_number(at + size)), true);
}

PagedFile::Page& PagedFile::held_page(std::uint64_t begin) {
  const auto found = held_.lower_bound(begin);
  if (found != held_.end() && found->first == begin) return *found->second;
  auto page = std::make_unique<Page>();  // zeros
  if (is_written(begin)) {
    runs_.finish();
    file_.read_at(begin, page->bytes);
  }
  return *held_.emplace_hint(found, begin, std::move(page))->second;
}

void PagedFile::read(std::uint64_t at, void* bytes, std::size_t size) {
  auto* next = static_cast<char*>(bytes);
  for (const std::uint64_t stop = at + size; at < stop;) {
    const std::uint64_t begin = page_begin(at);
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(stop, begin + kPage) - at);
    if (const auto page = held_.find(begin); page != held_.end()) {
      std::memcpy(next, page->second->bytes.data() + (at - begin), count);
    } else if (is_written(begin)) {
      runs_.finish();
      file_.read_at(at, {next, count});
    } else {
      std::memset(next, 0, count);
    }
    at += count;
    next += count;
  }
}

void PagedFile::write_held() {
  for (const auto& [at, page] : held_) write_through(at, page->bytes.data(), kPage);
  runs_.finish();
  held_.clear();
}

/// Of all pages of a file of `size` bytes; all that was written has arrived.
std::vector<PageHash> PagedFile::hashes(std::uint64_t size) const {
  std::vector<PageHash> out(page_number(size + kPage - 1));
  const std::vector<char> zeros(kPage);
  const PageHash of_zeros = page_hash(zeros.data(), kPage);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint64_t begin = i * std::uint64_t{kPage};
    const auto length = static_cast<std::size_t>(std::min<std::uint64_t>(kPage, size - begin));
    if (const auto page = held_.find(begin); page != held_.end())
      out[i] = page_hash(page->second->bytes.data(), length);
    else if (is_written(begin))
      out[i] = runs_.hashes()[i];
    else
      out[i] = length == kPage ? of_zeros : page_hash(zeros.data(), length);
  }
  return out;
}

void PagedFile::finish(std::uint64_t size) {
  runs_.finish();
  if (size % kPage != 0) held_page(page_begin(size));  // the last page is hashed as far as it goes
  const std::string seal = seal_of(hashes(size));
  write(size, seal.data(), seal.size());
  write_held();
  file_.set_size(size + seal.size());
}

}  // namespace surveymc::store
