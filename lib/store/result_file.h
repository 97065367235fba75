#pragma once
/// The result file: HDF5, netCDF-4 clean (docs/results-format.md). The only user of the HDF5 library.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "store/atomic_file.h"
#include "store/table.h"

namespace surveymc::store {

/// With which a file of HDF5 begins.
inline constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1a\n";

/// The identity of a result and the data that repeat it. Written as root attributes; all of it but `command`,
/// `surveymc_version`, `git_revision` and `compiler` enters the content hash.
struct Provenance {
  std::string title = {}, experiment = {};
  std::string config = {};       ///< resolved TOML, whole
  std::string config_hash = {};  ///< see config/config.h
  std::uint64_t seed = 0, trials = 0;
  std::string surveymc_version = {}, git_revision = {}, compiler = {}, command = {};
};

/// How this run went. Written to the group /run, outside of the content hash.
struct RunInfo {
  std::string created;  ///< ISO 8601, UTC
  std::string host;
  double elapsed_s = 0;
  std::int64_t threads = 1, ranks = 1;
};

/// A user's file as it was read: columns named and in the units of the file.
struct InputData {
  std::string path;  ///< as written in the config, relative to it
  std::string hash;  ///< of names and values, see input_hash()
  Table table;       ///< the table's own name is not used: the group is named after the path
};

struct Result {
  Provenance provenance = {};
  RunInfo run = {};
  std::vector<Table> tables = {};       ///< `/tables/<name>`
  std::vector<Table> samples = {};      ///< `/samples/<name>`
  std::vector<Map> maps = {};           ///< `/maps/<name>`
  std::vector<MapStream> streams = {};  ///< `/maps/<name>` as well, behind `maps`
  std::vector<InputData> inputs = {};
  Table cost = {};  ///< `/run/cost`, outside of the content hash: processor time is no part of a result; may be absent
};

/// Values of a stream that are made, hashed and written at a time, at most: 2 MB.
inline constexpr std::size_t kStreamPiece = std::size_t{1} << 18;

/// A map and the source of its values.
struct MapSource {
  const Map* map = nullptr;  ///< its values may be empty
  std::function<std::vector<double>(std::size_t first, std::size_t count)> values;
};

/// All maps of a result, held and streamed. They refer to `result`.
std::vector<MapSource> maps_of(const Result& result);

/// read_result() leaves longer tables on the disk.
inline constexpr std::size_t kMostHeldRows = std::size_t{1} << 16;
/// read_result() returns a map as a stream if it has more values than this (128 MB).
inline constexpr std::size_t kMostHeldValues = std::size_t{1} << 24;

/// 128-bit XXH3 in hex over column names, units and values (bit patterns, little endian).
std::string input_hash(const Table& table);

/// 128-bit XXH3 in hex over tables, samples, maps, inputs and provenance; not over time, host, threads or versions.
/// Runs through the values of streams; the same for a map that is streamed and one that is held.
std::string content_hash(const Result& result);

/// Throws IoError, before anything is computed, if `path` could not be written: its folder is missing or read-only,
/// it is a folder, or it is an existing file that is not a surveymc result (such a file is never overwritten).
/// Removes temporary files of writers that no longer run. Leaves no file behind.
void check_output_path(const std::filesystem::path& path);

/// Writes the file whole or not at all: temporary name in the same folder, flush, fsync, rename, fsync of the folder.
/// An existing file stays untouched on any error. Throws IoError with path and reason, also if that file is not a
/// surveymc result, and std::logic_error if the result is malformed (columns of different length, a name twice).
/// NaN is a missing value; bytes that are not UTF-8 are stored as U+FFFD.
/// A result with streams or with rows on the disk is written in pieces and needs no more memory than one piece of each.
/// Exceptions of the streams (Interrupted) pass through and leave no file. Streamed maps are computed once.
void write_result(const std::filesystem::path& path, const Result& result);

inline constexpr int kMostCompression = 9;

struct WriteOptions {
  /// 1 to 9: the numbers of tables and maps (from 1024 on) are compressed by HDF5's shuffle and deflate. Contents and
  /// content_hash are the same. Texts are not compressed: HDF5 keeps them outside of what its filters see. 0: none.
  int compression = 0;
  /// Called while a result is written, with the bytes of values so far and about all that there will be. What it throws
  /// leaves no file.
  std::function<void(std::uint64_t written, std::uint64_t expected)> progress = {};
  OldFile old = OldFile::replaced;  ///< an older result of the same name
};
/// Returns the new names of older results. Throws IoError also if the HDF5 library has no deflate.
std::vector<std::filesystem::path> write_result(const std::filesystem::path& path, const Result& result,
                                                const WriteOptions& options);

/// Reads a file written by write_result. Throws IoError if it is missing, truncated, or not a surveymc result of a
/// known format version, or if it is damaged or edited: its contents do not match its content_hash or its checksum.
/// Large maps come as one stream each, and long tables stay on the disk: both read from the file, which must not change
/// meanwhile.
Result read_result(const std::filesystem::path& path);

/// As read_result, but looks neither at the seal nor at the content_hash: of a long table or a large map no more is
/// read than is asked for afterwards. Damage is then found only where HDF5 notices it.
Result read_unchecked_result(const std::filesystem::path& path);

/// Version of the HDF5 library that the program runs with, "1.10.8".
std::string hdf5_version();

/// The content_hash attribute stored in the file.
std::string stored_content_hash(const std::filesystem::path& path);

}  // namespace surveymc::store
