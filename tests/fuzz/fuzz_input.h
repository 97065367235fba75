#pragma once
/// What the fuzz targets share. A target must take any bytes: refuse them with InputError or IoError, or read them.
/// Anything else (a crash, a sanitizer's finding, another exception, a broken promise) ends the program.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <unistd.h>

#include "base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace surveymc {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Ends the program, which libFuzzer reports with the input, unless the reader keeps a promise.
inline void promise(bool kept, const char* what) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

/// True if `read` took the input, false if it refused it as it should.
template <class Read>
bool is_accepted(const Read& read) {
  try {
    read();
    return true;
  } catch (const InputError&) {
  } catch (const IoError&) {
  }
  return false;
}

/// A folder of this process in memory, for readers of files.
class MemoryFolder {
 public:
  MemoryFolder() : path_("/dev/shm/surveymc-fuzz-" + std::to_string(getpid())) {
    std::filesystem::create_directory(path_);
  }
  ~MemoryFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline void write_bytes(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace surveymc
