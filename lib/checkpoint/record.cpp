#include "checkpoint/record.h"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "base/bytes.h"
#include "base/error.h"
#include "base/input_path.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc::checkpoint {
namespace {

constexpr std::size_t kHead = 8 + sizeof(std::uint64_t), kChecksum = sizeof(XXH128_canonical_t);

}  // namespace

std::string checksum_of(std::string_view bytes) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits(bytes.data(), bytes.size()));
  return {reinterpret_cast<const char*>(canonical.digest), sizeof canonical.digest};
}

std::string sealed_record(std::string_view mark, std::string_view body) {
  ByteWriter out;
  out.put(mark.data(), mark.size());
  out.put(body);
  std::string bytes = out.take();
  return bytes + checksum_of(bytes);
}

std::optional<Record> record_at(std::string_view bytes, std::size_t begin, std::string_view mark) {
  const std::string_view here = bytes.substr(std::min(begin, bytes.size()));
  if (here.size() < kHead + kChecksum || !here.starts_with(mark)) return std::nullopt;
  const auto size = ByteReader(here.substr(mark.size())).get<std::uint64_t>();
  if (size > here.size() - kHead - kChecksum) return std::nullopt;
  const std::size_t sealed = kHead + static_cast<std::size_t>(size);
  if (here.substr(sealed, kChecksum) != checksum_of(here.substr(0, sealed))) return std::nullopt;
  return Record{here.substr(kHead, static_cast<std::size_t>(size)), begin + sealed + kChecksum};
}

void cannot_be_read(const std::filesystem::path& path, const std::string& why) {
  throw IoError(fmt::format("{}: cannot be read: {}", path.string(), why));
}

std::string read_bytes(const std::filesystem::path& path) {
  if (const std::string fault = input_fault(path); !fault.empty()) cannot_be_read(path, fault);
  std::ifstream in(path, std::ios::binary);
  if (!in) cannot_be_read(path);
  std::string bytes;
  std::array<char, std::size_t{1} << 16> piece;
  while (in.read(piece.data(), piece.size()), in.gcount() > 0)
    bytes.append(piece.data(), static_cast<std::size_t>(in.gcount()));
  if (in.bad()) cannot_be_read(path);
  return bytes;
}

}  // namespace surveymc::checkpoint
