#pragma once
/// One config: the file with its overrides, and the results of its readers. Internal to the module.
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/point_set.h"
#include "config/config.h"
#include "config/input_file.h"
#include "config/input_table.h"
#include "config/key_log.h"
#include "config/sweep.h"
#include "config/toml_tree.h"

namespace surveymc::config {

/// A default that readers used: its value, and by which points.
struct UsedDefault {
  TomlNode value;
  PointSet points;
  bool is_alike = true;  // the same value at all of them
};

/// The bytes of a file, or why it cannot be read.
struct FileText {
  std::string text, fault;
};
/// The largest files that are read whole: configs and models, which are parsed value by value, and tables.
inline constexpr std::uint64_t kLargestDocument = std::uint64_t{1} << 24, kLargestTable = std::uint64_t{1} << 28;
inline constexpr const char* kSmallerTable = "give only the rows and columns that are needed";
FileText read_file(const std::filesystem::path& path, std::uint64_t most, const std::string& way_out);

/// Gives a point's config the values that the log supposes.
void apply_suppositions(const KeyLog& log, TomlNode& root);
/// Text of a file embedded in the program, by its path "configs/thesis/traj1.csv"; empty optional if there is none.
std::optional<std::string> shipped_text(const std::filesystem::path& path);

/// Everything that the points of one config share. Readers keep it alive.
struct ConfigDocument {
  std::string label;             // the path as given, for messages
  std::filesystem::path folder;  // files are relative to it
  /// Of a TOML file that a config names: the config. Files are read through it, relative to this file.
  std::shared_ptr<ConfigDocument> parent;
  bool is_from_result = false;  // files are those in `stored_files`, not on disk; large ones are in `folder`
  std::map<std::string, InputTable> stored_files;
  std::map<std::string, std::string> stored_texts;
  std::map<std::string, InputReference> stored_references;

  std::shared_ptr<KeyLog> log;  // null, but for keys_of()

  TomlNode base;  // without [sweep], with overrides
  Sweep sweep;
  std::optional<TomlNode> refine, sensitivity;  // [refine] and [sensitivity], which are of the sweep as a whole

  // What reading has shown, for resolved_text() and Config::inputs(). Several threads read points.
  std::recursive_mutex showing;
  std::map<std::string, UsedDefault> defaults;
  std::set<std::string> named;         // strings that were read as the name of a table
  std::set<std::string> known_absent;  // has() has said no: a default must not make it say yes
  std::map<std::string, InputTable> inputs;
  std::map<std::string, std::string> readings;  // how those of them were read that table() has loaded
  std::map<std::string, std::string> texts;
  std::map<std::string, InputReference> references;  // files that are too large to be stored
  std::vector<Remark> remarks;                       // in order of their first points
  std::map<std::string, PointSet> remarked;          // by what they say: their points

  void remark(std::size_t point, Remark remark);

  /// Takes the parsed file apart and checks the keys that every file has. Set the members above `base` before.
  void build(TomlNode root, const std::vector<std::string>& overrides);
  /// Throws InputError if there is none.
  std::uint64_t seed() const;
  /// The config of one point. Throws InputError if there is no such point.
  TomlNode point_root(std::size_t point) const;
  void require_point(std::size_t point) const;
  void use_default(const std::string& key, const TomlNode& value, std::size_t point);
  /// The CSV file that `n`, the value of `key`, names; read once.
  const InputTable& input(const TomlNode& n, const std::string& key);
  /// The table that `load` makes of the file that `n`, the value of `key`, names; read once, and in one way
  /// (`reading`).
  const InputTable& table(const TomlNode& n, const std::string& key,
                          const std::function<InputTable(const std::filesystem::path&)>& load,
                          const std::string& reading);
  /// A file other than a table that `n`, the value of `key`, names; `shipped` stands for it if it is not null.
  InputText text(const TomlNode& n, const std::string& key, const InputText* shipped);
  /// The same for a file that may be too large to be held.
  InputFile file(const TomlNode& n, const std::string& key);
  /// The bytes of a file; with a log, of one that came with the program.
  FileText read(const std::filesystem::path& path, std::uint64_t most, const std::string& way_out) const;
  /// See Config.
  std::string resolved_text() const;
  /// True of a config that surveymc refine has written, from the resolved text of the first round. A default that is
  /// not in it differs among the points of the sweep, also where the few points of this round have the same.
  bool is_later_round() const;
  /// `root`, [refine] and [sensitivity] as TOML.
  std::string text_with_refine(TomlNode root) const;
};

}  // namespace surveymc::config
