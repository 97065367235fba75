#include "store/seal.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc::store {
namespace {

constexpr std::string_view kMark = "SMCSEAL2";
constexpr std::size_t kSealSize = kMark.size() + sizeof(XXH128_canonical_t);
constexpr std::size_t kPage = std::size_t{1} << 16;

std::string canonical(XXH128_hash_t hash) {
  XXH128_canonical_t digest;
  XXH128_canonicalFromHash(&digest, hash);
  return {reinterpret_cast<const char*>(digest.digest), sizeof digest.digest};
}

/// The seal for the first `size` bytes; "" if they cannot be read.
std::string seal_of_bytes(std::istream& in, std::uintmax_t size) {
  XXH3_state_t state;
  XXH3_128bits_reset(&state);
  std::string page(kPage, '\0');
  in.seekg(0);
  for (std::uintmax_t left = size; left > 0; left -= page.size()) {
    page.resize(std::min<std::uintmax_t>(left, kPage));
    if (!in.read(page.data(), static_cast<std::streamsize>(page.size()))) return "";
    const std::string hash = canonical(XXH3_128bits(page.data(), page.size()));
    XXH3_128bits_update(&state, hash.data(), hash.size());
  }
  return std::string(kMark) + canonical(XXH3_128bits_digest(&state));
}

}  // namespace

std::string seal_of(const std::string& bytes) {
  std::istringstream in(bytes);
  return seal_of_bytes(in, bytes.size());
}

std::string seal_of_file(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  std::string seal = seal_of_bytes(in, std::filesystem::file_size(path));
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
  if (!in || !seal.starts_with(kMark)) return Seal::none;
  return seal == seal_of_bytes(in, size - kSealSize) ? Seal::right : Seal::wrong;
}

}  // namespace surveymc::store
