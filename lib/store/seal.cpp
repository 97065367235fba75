#include "store/seal.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc::store {
namespace {

constexpr std::string_view kMark = "SMCSEAL2", kEarlierMark = "SMCSEAL1";
constexpr std::size_t kSealSize = kMark.size() + sizeof(PageHash);

PageHash canonical(XXH128_hash_t hash) {
  XXH128_canonical_t digest;
  XXH128_canonicalFromHash(&digest, hash);
  PageHash bytes;
  static_assert(sizeof bytes == sizeof digest.digest);
  std::memcpy(bytes.data(), digest.digest, sizeof bytes);
  return bytes;
}

std::string seal_text(std::string_view mark, const PageHash& hash) {
  std::string seal(mark);
  seal.append(reinterpret_cast<const char*>(hash.data()), hash.size());
  return seal;
}

/// Calls use(bytes, size) for the next `size` bytes, page by page; false if they cannot be read.
template <class Use>
bool for_each_page(std::ifstream& in, std::uintmax_t size, const Use& use) {
  std::vector<char> page(kSealedPage);
  for (std::uintmax_t left = size; left > 0;) {
    const std::size_t n = std::min<std::uintmax_t>(left, page.size());
    if (!in.read(page.data(), static_cast<std::streamsize>(n))) return false;
    use(page.data(), n);
    left -= n;
  }
  return true;
}

/// The seal with this mark for the next `size` bytes; none if they cannot be read.
std::optional<std::string> seal_of_bytes(std::string_view mark, std::ifstream& in, std::uintmax_t size) {
  if (mark == kMark) {
    std::vector<PageHash> pages;
    const auto add = [&](const char* bytes, std::size_t n) { pages.push_back(page_hash(bytes, n)); };
    if (!for_each_page(in, size, add)) return std::nullopt;
    return seal_of(pages);
  }
  XXH3_state_t state;
  XXH3_128bits_reset(&state);
  const auto add = [&](const char* bytes, std::size_t n) { XXH3_128bits_update(&state, bytes, n); };
  if (!for_each_page(in, size, add)) return std::nullopt;
  return seal_text(mark, canonical(XXH3_128bits_digest(&state)));
}

}  // namespace

PageHash page_hash(const char* bytes, std::size_t size) { return canonical(XXH3_128bits(bytes, size)); }

std::string seal_of(const std::vector<PageHash>& pages) {
  return seal_text(kMark, canonical(XXH3_128bits(pages.data(), pages.size() * sizeof(PageHash))));
}

Seal seal_state(const std::filesystem::path& path) {
  const std::uintmax_t size = std::filesystem::file_size(path);
  if (size < kSealSize) return Seal::none;
  const std::uintmax_t sealed = size - kSealSize;
  std::ifstream in(path, std::ios::binary);
  std::string seal(kSealSize, '\0');
  in.seekg(static_cast<std::streamoff>(sealed));
  in.read(seal.data(), kSealSize);
  const std::string_view mark = std::string_view(seal).substr(0, kMark.size());
  if (!in || (mark != kMark && mark != kEarlierMark)) return Seal::none;

  in.seekg(0);
  const auto right = seal_of_bytes(mark, in, sealed);
  return right && seal == *right ? Seal::right : Seal::wrong;
}

}  // namespace surveymc::store
