#include "store/seal.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc::store {
namespace {

constexpr std::size_t kMarkSize = 8;
constexpr char kMark[kMarkSize + 1] = "SMCSEAL1";
constexpr std::size_t kChunk = std::size_t{1} << 18;  // stays in the caches
constexpr std::size_t kSealSize = kMarkSize + sizeof(XXH128_canonical_t);

std::string seal_text(XXH128_hash_t hash) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  std::string seal = kMark;
  seal.append(reinterpret_cast<const char*>(canonical.digest), sizeof canonical.digest);
  return seal;
}

/// Of the next `size` bytes; none if they cannot be read.
std::optional<XXH128_hash_t> hash_of(std::ifstream& in, std::uintmax_t size) {
  XXH3_state_t state;
  XXH3_128bits_reset(&state);
  std::vector<char> chunk(kChunk);
  for (std::uintmax_t left = size; left > 0;) {
    const std::size_t n = std::min<std::uintmax_t>(left, chunk.size());
    if (!in.read(chunk.data(), static_cast<std::streamsize>(n))) return std::nullopt;
    XXH3_128bits_update(&state, chunk.data(), n);
    left -= n;
  }
  return XXH3_128bits_digest(&state);
}

}  // namespace

std::vector<char> seal_of(const AtomicFile& file, std::uint64_t size) {
  XXH3_state_t state;
  XXH3_128bits_reset(&state);
  std::vector<char> chunk(kChunk);
  for (std::uint64_t at = 0; at < size;) {
    const std::size_t n = std::min<std::uint64_t>(size - at, chunk.size());
    file.read_at(at, {chunk.data(), n});
    XXH3_128bits_update(&state, chunk.data(), n);
    at += n;
  }
  const std::string seal = seal_text(XXH3_128bits_digest(&state));
  return {seal.begin(), seal.end()};
}

Seal seal_state(const std::filesystem::path& path) {
  const std::uintmax_t size = std::filesystem::file_size(path);
  if (size < kSealSize) return Seal::none;
  const std::uintmax_t sealed = size - kSealSize;
  std::ifstream in(path, std::ios::binary);
  std::string seal(kSealSize, '\0');
  in.seekg(static_cast<std::streamoff>(sealed));
  in.read(seal.data(), kSealSize);
  if (!in || !seal.starts_with(kMark)) return Seal::none;

  in.seekg(0);
  const auto hash = hash_of(in, sealed);
  return hash && seal == seal_text(*hash) ? Seal::right : Seal::wrong;
}

}  // namespace surveymc::store
