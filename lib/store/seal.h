#pragma once
/// The last bytes of a result file are its seal: a mark and the hash of all bytes before. HDF5 ignores what follows its
/// own data, but it follows damaged addresses and crashes; so a sealed file is compared with its seal before HDF5 sees
/// it. A file without one (rewritten by h5repack, extended by h5py) is read all the same.
#include <filesystem>
#include <vector>

namespace surveymc::store {

void append_seal(std::vector<char>& bytes);

/// The seal of what is in a file, which is read for it. Throws std::system_error.
std::vector<char> seal_of(const std::filesystem::path& path);

/// True if the file has no seal, or the right one.
bool is_intact(const std::filesystem::path& path);

}  // namespace surveymc::store
