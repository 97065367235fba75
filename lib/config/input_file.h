#pragma once
/// A user's file that may be larger than the memory: its bytes are read line by line, as often as they are wanted.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/input_table.h"

namespace surveymc::config {

/// Files up to this size are stored whole in the result; of larger ones it has name, size, hash and header only.
inline constexpr std::uint64_t kLargestStoredFile = std::uint64_t{1} << 24;

/// What identifies a file that is too large to be stored in a result.
struct InputReference {
  std::string path;        ///< as the config names it
  std::uint64_t size = 0;  ///< bytes
  std::string hash;        ///< 128-bit XXH3 of the bytes, in hex
  std::string header;      ///< first line that is neither blank nor a comment (#), at most 1000 bytes of it
};

/// The input files that a result stores beside its config.
struct StoredInputs {
  std::vector<InputTable> tables;
  std::vector<InputText> texts;
  std::vector<InputReference> references;  ///< too large to be stored: what identifies them
};

/// 128-bit XXH3 of bytes that come in pieces.
class BytesHash {
 public:
  BytesHash();
  void add(std::string_view bytes);
  std::string hex() const;

 private:
  struct Free {
    void operator()(void* state) const;
  };
  std::unique_ptr<void, Free> state_;
};

struct InputFile {
  std::string path;                              ///< as the config names it, for messages
  std::shared_ptr<const std::string> text = {};  ///< all of it; null if it is too large to be held
  std::filesystem::path place = {};              ///< where it is on the disk, if it is not held
  std::uint64_t size = 0;                        ///< bytes
  std::string hash = {};                         ///< of InputReference, if it is not held: what every reading must give
};

/// Throws InputError: the bytes of the file are not those that the result names by their hash.
[[noreturn]] void refuse_changed_file(const InputFile& file);

/// Reads the whole file once, in pieces. Throws IoError with the reason.
InputReference describe_file(const std::string& path, const std::filesystem::path& place);

/// The same of a text that was read as the file `path`.
InputReference describe_text(const std::string& path, const std::string& text);

/// The lines of a file, without their ends (LF or CRLF) and without a UTF-8 byte order mark. Holds 1 MiB of it. Who has
/// read a file to its end has read the bytes of InputFile::hash, or got an InputError.
class LineReader {
 public:
  /// Throws IoError if the file cannot be opened.
  explicit LineReader(const InputFile& file);

  /// The next line, valid until the next call; false at the end. InputError for a line of more than 1 MiB, or if the
  /// file was changed; IoError if it cannot be read. What is appended to it meanwhile is not read.
  bool next(std::string_view& line);
  /// Reads the rest for its bytes alone.
  void skip_to_end();
  /// Of the line that was read last, from 1.
  std::int64_t number() const { return number_; }

 private:
  struct Close {
    void operator()(std::FILE* f) const { std::fclose(f); }
  };
  bool fill();

  InputFile file_;
  BytesHash hash_;
  std::unique_ptr<std::FILE, Close> open_;
  std::vector<char> buffer_;
  std::string_view rest_;   // not yet given out
  std::uint64_t left_ = 0;  // bytes that are still on the disk
  std::int64_t number_ = 0;
};

}  // namespace surveymc::config
