#include "store/result_file.h"

#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "base/error.h"
#include "store/atomic_file.h"
#include "store/hdf5_handle.h"
#include "store/result_hdf5.h"
#include "store/seal.h"

// How a file is made: HDF5 makes a small one in memory and writes a large one itself, under a temporary name
// (atomic_file.h). It gets a seal of all its bytes (seal.h), is read back, and is renamed. result_reader.cpp reads
// files.

namespace surveymc::store {
namespace {

namespace fs = std::filesystem;

std::string error_text(int error_number) { return std::generic_category().message(error_number); }

[[noreturn]] void refuse(const fs::path& path, const std::string& reason) {
  throw IoError(fmt::format("{}: {}", path.string(), reason));
}

/// The file that is made by writing to `path`.
fs::path target_of(const fs::path& path) {
  if (!path.has_filename()) refuse(path, "is a folder; name a file");
  return resolved(path);
}

void refuse_what_is_foreign(const fs::path& path, const fs::path& target) {
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (status.type() == fs::file_type::none) refuse(path, "cannot be looked at: " + error.message());
  if (!fs::exists(status)) return;
  if (fs::is_directory(status)) refuse(path, "is a folder; name a file");
  if (fs::is_regular_file(status) && access(target.c_str(), W_OK) != 0) {
    refuse(path, "exists and cannot be replaced: " + error_text(errno));
  }
  const ResultFileState state = result_file_state(target);
  if (state.is == ResultFile::other)
    refuse(path, "exists and is not a surveymc result: refusing to overwrite it; choose another name with -o");
  if (state.is == ResultFile::unreadable)
    refuse(path,
           fmt::format("exists and cannot be read ({}): refusing to overwrite it; choose another name with -o, or "
                       "move it away",
                       state.reason));
}

/// Throws IoError if `target` exists and is anything else than a surveymc result that we may replace.
void refuse_foreign_file(const fs::path& path, const fs::path& target) {
  look_at(target, [&](const fs::path& there) { refuse_what_is_foreign(path, there); });
}

/// About as many bytes as the file has: values, numbers of rows, references of texts, and what HDF5 says of a column.
std::uintmax_t size_of(const Result& result) {
  constexpr std::uintmax_t kColumn = 2000;
  const auto of_table = [](const Table& t) {
    std::uintmax_t value_bytes = sizeof(std::int64_t);
    for (const Column& c : t.columns)
      value_bytes += std::holds_alternative<std::vector<std::string>>(c.values) ? 2 * sizeof(double) : sizeof(double);
    return t.rows() * value_bytes + (t.columns.size() + 1) * kColumn;
  };
  std::uintmax_t bytes = 0;
  for (const auto* tables : {&result.tables, &result.samples})
    for (const Table& t : *tables) bytes += of_table(t);
  for (const InputData& i : result.inputs) bytes += of_table(i.table);
  for (const Map& m : result.maps) bytes += m.values.size() * sizeof(double);
  for (const MapStream& s : result.streams)
    for (const Map& m : s.maps) bytes += map_size(m) * sizeof(double);
  return bytes;
}

/// True if it takes little to read the file again: the run that made it took ten times as long. A signal is not looked
/// at meanwhile: so it takes no longer than about a second.
bool is_read_back(std::uintmax_t size, double elapsed_s) {
  constexpr double kBytesPerSecond = 2e8, kShare = 0.1;
  constexpr std::uintmax_t kMost = std::uintmax_t{256} << 20;
  return size <= kMost && static_cast<double>(size) <= kShare * elapsed_s * kBytesPerSecond;
}

[[noreturn]] void refuse_what_was_written(const fs::path& path, const std::string& reason) {
  refuse(path, fmt::format("cannot be written: the file does not read back as what was written ({}): memory or disk "
                           "may be faulty",
                           reason));
}

/// Files that are not larger are made in memory: then the bytes are known that must be on the disk.
constexpr std::uintmax_t kMadeInMemory = std::uintmax_t{16} << 20;

/// Writes the file under its temporary name, with its seal, and reads it back. `size`: about what it will have.
void write_and_read_back(const fs::path& path, AtomicFile& file, const Result& result, int compression,
                         std::uintmax_t size, const Written& written) {
  const fs::path& temporary = file.temporary_path();
  if (size <= kMadeInMemory) {
    const std::string bytes = hdf5_bytes(result, compression, written);
    file.write(bytes);
    file.write(seal_of(bytes));
    if (seal_state(temporary) != Seal::right) refuse_what_was_written(path, "its checksum does not match");
    return;
  }
  write_hdf5(temporary, result, compression, written);
  file.write(seal_of_file(temporary));
  if (!is_read_back(fs::file_size(temporary), result.run.elapsed_s)) return;
  try {
    read_result(temporary);
  } catch (const IoError& e) {
    refuse_what_was_written(path, std::string(e.what()).substr(temporary.string().size() + 2));
  }
}

/// Throws IoError if the disk is too full, before hours of streaming.
void require_space(const fs::path& target, const Result& result) {
  std::error_code error;
  const fs::space_info space = fs::space(folder_of(target), error);
  if (error || space.available >= size_of(result)) return;
  throw std::system_error(ENOSPC, std::generic_category());
}

}  // namespace

void check_output_path(const fs::path& path) {
  const fs::path target = target_of(path);
  const fs::path folder = folder_of(target);
  std::error_code error;
  if (!fs::exists(folder, error)) refuse(path, fmt::format("the folder {} does not exist", folder.string()));
  if (!fs::is_directory(folder, error)) refuse(path, fmt::format("{} is not a folder", folder.string()));
  const auto refuse_folder = [&](int reason) {
    refuse(path, fmt::format("cannot write into the folder {}: {}", folder.string(), error_text(reason)));
  };
  if (access(folder.c_str(), W_OK | X_OK) != 0) refuse_folder(errno);
  refuse_foreign_file(path, target);
  remove_stale_temporaries(target);

  try {
    AtomicFile(target).write(std::vector<char>(4096));  // only this tells a full disk, a quota, a name too long
  } catch (const std::system_error& e) {
    refuse_folder(e.code().value());
  }
}

void write_result(const fs::path& path, const Result& result) { write_result(path, result, {}); }

std::vector<fs::path> write_result(const fs::path& path, const Result& result, const WriteOptions& options) {
  if (options.compression < 0 || options.compression > kMostCompression)
    throw std::logic_error("no such level of compression");
  check_shape(result);
  const fs::path target = target_of(path);
  refuse_foreign_file(path, target);
  try {
    require_space(target, result);
    AtomicFile file(target);
    const std::uintmax_t size = size_of(result);
    const auto written = [&](std::uint64_t bytes) {
      if (options.progress) options.progress(bytes, size);
    };
    write_and_read_back(path, file, result, options.compression, size, written);
    return file.commit(options.old, [&](const fs::path& old) { refuse_foreign_file(path, old); });
  } catch (const Hdf5Failure& e) {
    refuse(path, fmt::format("cannot be written: {}", e.what()));
  } catch (const std::system_error& e) {
    refuse(path, fmt::format("cannot be written: {}", e.code().message()));
  }
}

std::vector<MapSource> maps_of(const Result& result) {
  std::vector<MapSource> all;
  for (const Map& m : result.maps)
    all.push_back({&m, [&m](std::size_t first, std::size_t count) {
                     const auto begin = m.values.begin() + static_cast<std::ptrdiff_t>(first);
                     return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(count));
                   }});
  for (const MapStream& s : result.streams)
    for (std::size_t i = 0; i < s.maps.size(); ++i)
      all.push_back({&s.maps[i], [&s, i](std::size_t first, std::size_t count) { return s.values(first, count)[i]; }});
  return all;
}

std::string hdf5_version() {
  silence_hdf5();  // before the library registers what it does at the program's end
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  return fmt::format("{}.{}.{}", major, minor, release);
}

}  // namespace surveymc::store
