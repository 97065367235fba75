#include "config/input_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/error.h"
#include "base/retry.h"
#include "config/csv_cells.h"
#include "config/text.h"

namespace surveymc::config {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;

[[noreturn]] void fail(const std::filesystem::path& place, const std::string& reason) {
  throw IoError(fmt::format("{}: {}", place.string(), reason));
}

std::FILE* opened(const std::filesystem::path& place) {
  std::FILE* f = uninterrupted([&] { return std::fopen(place.c_str(), "rb"); });
  if (!f) fail(place, std::generic_category().message(errno));
  return f;
}

std::string header_of(const InputFile& file) {
  constexpr std::size_t kLongestHeader = 1000;
  LineReader lines(file);
  std::string_view line;
  while (lines.next(line))
    if (!is_no_row(line)) return std::string(trimmed(line).substr(0, kLongestHeader));
  return "";
}

std::string hex_of(const XXH128_hash_t& h) { return fmt::format("{:016x}{:016x}", h.high64, h.low64); }

XXH3_state_t* state_of(void* state) { return static_cast<XXH3_state_t*>(state); }

}  // namespace

void BytesHash::Free::operator()(void* state) const { XXH3_freeState(state_of(state)); }

BytesHash::BytesHash() : state_(XXH3_createState()) {
  if (!state_) throw std::bad_alloc();
  XXH3_128bits_reset(state_of(state_.get()));
}

void BytesHash::add(std::string_view bytes) { XXH3_128bits_update(state_of(state_.get()), bytes.data(), bytes.size()); }

std::string BytesHash::hex() const { return hex_of(XXH3_128bits_digest(state_of(state_.get()))); }

void refuse_changed_file(const InputFile& file) {
  throw InputError(fmt::format("{}: was changed while it was read: run again when nothing writes to it", file.path));
}

InputReference describe_file(const std::string& path, const std::filesystem::path& place) {
  InputReference r;
  r.path = path;
  BytesHash hash;
  {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(opened(place), &std::fclose);
    std::vector<char> piece(kPiece);
    while (const std::size_t n = std::fread(piece.data(), 1, piece.size(), file.get())) {
      hash.add({piece.data(), n});
      r.size += n;
    }
    if (std::ferror(file.get())) fail(place, std::generic_category().message(errno));
  }
  r.hash = hash.hex();
  r.header = header_of({path, nullptr, place, r.size});
  return r;
}

InputReference describe_text(const std::string& path, const std::string& text) {
  return {path, text.size(), hex_of(XXH3_128bits(text.data(), text.size())),
          header_of({path, std::make_shared<const std::string>(text), {}, text.size()})};
}

LineReader::LineReader(const InputFile& file) : file_(file) {
  if (file_.text) {
    rest_ = *file_.text;
  } else {
    open_.reset(opened(file_.place));
    buffer_.resize(kPiece);
    left_ = file_.size;
    fill();
  }
  if (rest_.substr(0, 3) == "\xEF\xBB\xBF") rest_.remove_prefix(3);
}

/// Moves the rest to the front of the buffer and reads behind it; false if there is nothing left, or no room.
bool LineReader::fill() {
  if (left_ == 0 || rest_.size() == buffer_.size()) return false;
  if (!rest_.empty()) std::memmove(buffer_.data(), rest_.data(), rest_.size());
  const std::size_t room = static_cast<std::size_t>(std::min<std::uint64_t>(buffer_.size() - rest_.size(), left_));
  const std::size_t n = std::fread(buffer_.data() + rest_.size(), 1, room, open_.get());
  if (n == 0) {
    if (std::ferror(open_.get())) fail(file_.place, std::generic_category().message(errno));
    refuse_changed_file(file_);  // it became shorter
  }
  hash_.add({buffer_.data() + rest_.size(), n});
  rest_ = {buffer_.data(), rest_.size() + n};
  left_ -= n;
  if (left_ == 0 && !file_.hash.empty() && hash_.hex() != file_.hash) refuse_changed_file(file_);
  return true;
}

void LineReader::skip_to_end() {
  do rest_ = {};
  while (fill());
}

bool LineReader::next(std::string_view& line) {
  std::size_t end = rest_.find('\n');
  while (end == std::string_view::npos && fill()) end = rest_.find('\n');
  if (end == std::string_view::npos) {
    require(left_ == 0, "{}:{}: is longer than {} bytes: must be a text file with a row a line", file_.path,
            number_ + 1, kPiece);
    if (rest_.empty()) return false;
    end = rest_.size();
  }
  line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  ++number_;
  return true;
}

}  // namespace surveymc::config
