#pragma once
/// The last bytes of a result file are its seal: the mark SMCSEAL2 and a hash of all bytes before, XXH3-128 over the
/// XXH3-128 of each 64 KiB, canonical. HDF5 ignores bytes after its own data. But HDF5 follows damaged addresses,
/// without end or until it crashes, so a sealed file is compared with its seal before HDF5 reads it. A file without a
/// seal (rewritten by h5repack, extended by h5py) is read all the same.
#include <filesystem>
#include <string>

namespace surveymc::store {

/// The seal for these bytes.
std::string seal_of(const std::string& bytes);

/// The seal for the bytes that a file has. Throws std::system_error if they cannot be read.
std::string seal_of_file(const std::filesystem::path& path);

/// The seal at the end of a file: none, the right one, of other bytes, or nobody has looked at it.
enum class Seal { none, right, wrong, unknown };
/// Never `unknown`.
Seal seal_state(const std::filesystem::path& path);

}  // namespace surveymc::store
