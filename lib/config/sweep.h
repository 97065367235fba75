#pragma once
/// [sweep] and [[sweep.case]]: the points of a config. Internal to the module.
#include <map>
#include <string>
#include <vector>

#include "config/config.h"
#include "config/toml_tree.h"

namespace surveymc::config {

/// Keys of the file as a whole (experiment, seed, title): Config reads them, and they cannot vary.
bool is_config_key(const std::string& key);

/// The dimensions of a sweep. Points are numbered from 0; cases vary slowest, then the keys of [sweep] in alphabetical
/// order, the last one fastest. Without any dimension there is one point.
///
/// Made in this order: read() the file's table, set_list() and fix() for --set arguments, expand(). Only then are there
/// points. The functions up to expand() throw InputError.
class Sweep {
 public:
  /// `table`: the value of `sweep` in the file.
  void read(const TomlNode& table);
  /// `sweep.KEY = list`, in place of the list that the file may have.
  void set_list(const std::string& key, const TomlNode& list);
  /// Takes `key`, fixed by the user, out of the sweep. A string sets only the name of a table, so it leaves alone what
  /// the sweep does to the table's other keys.
  void fix(const std::string& key, const TomlNode& value);
  /// Checks the lists and finds their values.
  void expand();

  std::size_t point_count() const;
  /// The dimensions and their values at a point.
  std::vector<SweepValue> values(std::size_t point) const;
  /// Empty without cases.
  std::string case_name(std::size_t point) const;
  bool has_cases() const { return !cases_.empty(); }
  /// Sets the keys that the sweep gives to a point.
  void apply(TomlNode& root, std::size_t point) const;
  /// True if some points have `key`, or a value that holds it, from the sweep.
  bool varies(const std::string& key) const;
  /// As the end of a TOML file. Empty without a sweep.
  std::string toml() const;

 private:
  struct Case {
    std::string name;
    std::map<std::string, TomlNode> values;
  };
  /// One key of [sweep]: the list as written (or from --set), and its values.
  struct Axis {
    TomlNode list;
    std::vector<TomlNode> values;
  };

  void read_lists(const TomlNode& table, const std::string& path);
  void add_list(const std::string& key, const TomlNode& list);
  static void read_case(Case& c, const TomlNode& table, const std::string& path, const std::string& shown);
  static void refuse_twins(const Case& c, const std::string& shown);
  void refuse_twins(const std::string& key, const Axis& axis) const;
  /// Index of the case (0 without cases), then of every axis in order.
  std::vector<std::size_t> indices(std::size_t point) const;

  std::vector<Case> cases_;
  std::map<std::string, Axis> axes_;
};

}  // namespace surveymc::config
