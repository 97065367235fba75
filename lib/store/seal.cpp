#include "store/seal.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc {
namespace {

constexpr std::size_t kMarkSize = 8;
constexpr char kMark[kMarkSize + 1] = "SMCSEAL1";
constexpr std::size_t kSealSize = kMarkSize + sizeof(XXH128_canonical_t);

std::string seal_text(XXH128_hash_t hash) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  std::string seal = kMark;
  seal.append(reinterpret_cast<const char*>(canonical.digest), sizeof canonical.digest);
  return seal;
}

}  // namespace

void append_seal(std::vector<char>& bytes) {
  const std::string seal = seal_text(XXH3_128bits(bytes.data(), bytes.size()));
  bytes.insert(bytes.end(), seal.begin(), seal.end());
}

bool is_intact(const std::filesystem::path& path) {
  const std::uintmax_t size = std::filesystem::file_size(path);
  if (size < kSealSize) return true;
  const std::uintmax_t sealed = size - kSealSize;
  std::ifstream in(path, std::ios::binary);
  std::string seal(kSealSize, '\0');
  in.seekg(static_cast<std::streamoff>(sealed));
  in.read(seal.data(), kSealSize);
  if (!in || !seal.starts_with(kMark)) return true;

  in.seekg(0);
  XXH3_state_t state;
  XXH3_128bits_reset(&state);
  std::vector<char> chunk(std::size_t{1} << 20);
  for (std::uintmax_t left = sealed; left > 0;) {
    const std::size_t n = std::min<std::uintmax_t>(left, chunk.size());
    if (!in.read(chunk.data(), static_cast<std::streamsize>(n))) return false;
    XXH3_128bits_update(&state, chunk.data(), n);
    left -= n;
  }
  return seal == seal_text(XXH3_128bits_digest(&state));
}

}  // namespace surveymc
