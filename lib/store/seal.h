#pragma once
/// The last bytes of a result file are its seal: a mark and a hash of all bytes before. HDF5 ignores bytes after its
/// own data. But HDF5 follows damaged addresses and crashes, so a sealed file is compared with its seal before HDF5
/// reads it. A file without a seal (rewritten by h5repack, extended by h5py) is read all the same.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace surveymc::store {

/// The hash of the seal is XXH3-128 over those of all pages, in order: pages can be hashed as they are written, in any
/// order. The last page may be shorter.
inline constexpr std::size_t kSealedPage = std::size_t{1} << 16;
using PageHash = std::array<unsigned char, 16>;  ///< canonical (big endian) XXH3-128
PageHash page_hash(const char* bytes, std::size_t size);

/// The seal for a file of pages with these hashes.
std::string seal_of(const std::vector<PageHash>& pages);

/// The seal at the end of a file: none, the right one, or of other bytes. Seals of earlier revisions (SMCSEAL1:
/// XXH3-128 of all bytes at once) are known.
enum class Seal { none, right, wrong };
Seal seal_state(const std::filesystem::path& path);

}  // namespace surveymc::store
