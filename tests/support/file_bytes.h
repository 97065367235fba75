#pragma once
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace surveymc {

/// All bytes of a file.
inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A file of these bytes, in the place of one that may be there.
inline void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

/// `bytes`, damaged: some bits of the byte at `at` are the other way round.
inline std::string flipped(std::string bytes, std::size_t at, int bits) {
  bytes[at] = static_cast<char>(bytes[at] ^ bits);
  return bytes;
}

}  // namespace surveymc
