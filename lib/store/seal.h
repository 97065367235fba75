#pragma once
/// The last bytes of a result file are its seal: a mark and the hash of all bytes before. HDF5 ignores bytes after its
/// own data. But HDF5 follows damaged addresses and crashes, so a sealed file is compared with its seal before HDF5
/// reads it. A file without a seal (rewritten by h5repack, extended by h5py) is read all the same.
#include <cstdint>
#include <filesystem>
#include <vector>

#include "store/atomic_file.h"

namespace surveymc::store {

/// The seal for the first `size` bytes of a file. Throws std::system_error.
std::vector<char> seal_of(const AtomicFile& file, std::uint64_t size);

/// The seal at the end of a file: none, the right one, or of other bytes.
enum class Seal { none, right, wrong };
Seal seal_state(const std::filesystem::path& path);

}  // namespace surveymc::store
