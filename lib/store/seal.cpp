#include "store/seal.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc::store {
namespace {

constexpr std::string_view kMark = "SMCSEAL2", kEarlierMark = "SMCSEAL1";
constexpr std::size_t kSealSize = kMark.size() + sizeof(XXH128_canonical_t);
constexpr std::size_t kPage = std::size_t{1} << 16;

std::string canonical(XXH128_hash_t hash) {
  XXH128_canonical_t digest;
  XXH128_canonicalFromHash(&digest, hash);
  return {reinterpret_cast<const char*>(digest.digest), sizeof digest.digest};
}

/// The seal of pages that pass by: kPage bytes each, but for the last one.
class SealOfPages {
 public:
  explicit SealOfPages(std::string_view mark) : mark_(mark) { XXH3_128bits_reset(&state_); }
  void add(std::string_view page) {
    const std::string hash = mark_ == kMark ? canonical(XXH3_128bits(page.data(), page.size())) : std::string();
    if (mark_ == kMark) page = hash;
    XXH3_128bits_update(&state_, page.data(), page.size());
  }
  std::string text() const { return std::string(mark_) + canonical(XXH3_128bits_digest(&state_)); }

 private:
  std::string_view mark_;
  XXH3_state_t state_;
};

/// The seal for the first `size` bytes; "" if they cannot be read.
std::string seal_of_bytes(std::string_view mark, std::ifstream& in, std::uintmax_t size) {
  SealOfPages seal(mark);
  std::string page(kPage, '\0');
  in.seekg(0);
  for (std::uintmax_t left = size; left > 0; left -= page.size()) {
    page.resize(std::min<std::uintmax_t>(left, kPage));
    if (!in.read(page.data(), static_cast<std::streamsize>(page.size()))) return "";
    seal.add(page);
  }
  return seal.text();
}

}  // namespace

std::string seal_of(std::string_view bytes) {
  SealOfPages seal(kMark);
  for (std::size_t at = 0; at < bytes.size(); at += kPage) seal.add(bytes.substr(at, kPage));
  return seal.text();
}

std::string seal_of_file(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  std::string seal = seal_of_bytes(kMark, in, std::filesystem::file_size(path));
  if (seal.empty()) throw std::system_error(errno != 0 ? errno : EIO, std::generic_category());
  return seal;
}

Seal seal_state(const std::filesystem::path& path) {
  const std::uintmax_t size = std::filesystem::file_size(path);
  if (size < kSealSize) return Seal::none;
  std::ifstream in(path, std::ios::binary);
  std::string seal(kSealSize, '\0');
  in.seekg(static_cast<std::streamoff>(size - kSealSize));
  in.read(seal.data(), kSealSize);
  const std::string_view mark = std::string_view(seal).substr(0, kMark.size());
  if (!in || (mark != kMark && mark != kEarlierMark)) return Seal::none;
  return seal == seal_of_bytes(mark, in, size - kSealSize) ? Seal::right : Seal::wrong;
}

}  // namespace surveymc::store
