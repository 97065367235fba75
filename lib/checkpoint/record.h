#pragma once
/// Records with a checksum, of which journals and part files consist.
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "base/numerics.h"

namespace surveymc::checkpoint {

/// The config and the program to which a stored tally belongs. Tallies can be merged only if both are the same, because
/// another build may round differently.
struct RunKey {
  std::string config_hash;  ///< Config::hash()
  std::string program;      ///< version, revision and compiler of the program

  bool operator==(const RunKey&) const = default;
};

/// Tallies of both may be merged: they are of one config, and of programs whose numbers have the same bits.
inline bool same_numbers(const RunKey& a, const RunKey& b) {
  return a.config_hash == b.config_hash && numerics_of(a.program) == numerics_of(b.program);
}

/// XXH3-128 of the bytes, 16 bytes.
std::string checksum_of(std::string_view bytes);

/// mark (8 bytes), length of the body (8), body, XXH3-128 of all of them (16).
std::string sealed_record(std::string_view mark, std::string_view body);

struct Record {
  std::string_view body;  ///< within the bytes that were read
  std::size_t end = 0;    ///< where the next one begins
};

/// The record at `begin`; none if it is incomplete, damaged, or of another mark.
std::optional<Record> record_at(std::string_view bytes, std::size_t begin, std::string_view mark);

/// Throws the IoError of a file that cannot be read. `why`: by default, what errno says.
[[noreturn]] void cannot_be_read(const std::filesystem::path& path,
                                 const std::string& why = std::generic_category().message(errno));

/// All bytes of a file. Throws IoError.
std::string read_bytes(const std::filesystem::path& path);

}  // namespace surveymc::checkpoint
