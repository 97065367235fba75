#pragma once
/// [sweep] and [[sweep.case]]: the points of a config. Internal to the module.
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/config.h"
#include "config/sweep_axis.h"
#include "config/sweep_table.h"
#include "config/toml_tree.h"

namespace surveymc::config {

/// Keys of the file as a whole (experiment, seed, title): Config reads them, and they cannot vary.
bool is_config_key(const std::string& key);

/// The dimensions of a sweep. Points are numbered from 0, and are a function of their number: cases vary slowest;
/// within each of them the points of the design,
///   product            of the keys of [sweep] in alphabetical order, the last one fastest
///   zip                the i-th value of every key
///   latin_hypercube    one random point in every stratum of every axis; axes are the keys in alphabetical order
///   sobol              scrambled Sobol' points (random/design_points.h)
///   table              the rows of a CSV file, whose columns are keys
/// Without any dimension there is one point.
///
/// Made in this order: read() the file's table, set_list() and fix() for --set arguments, expand(). Only then are there
/// points. The functions up to expand() throw InputError.
class Sweep {
 public:
  /// `table`: the value of `sweep` in the file.
  void read(const TomlNode& table);
  /// `sweep.KEY = list`, in place of the list that the file may have; of `design`, the design.
  void set_list(const std::string& key, const TomlNode& list);
  /// Takes `key`, fixed by the user, out of the sweep. A string sets only the name of a table, so it leaves alone what
  /// the sweep does to the table's other keys.
  void fix(const std::string& key, const TomlNode& value);
  /// Checks the lists and finds the number of points. `file_of` opens the file that a node, the value of a key, names.
  void expand(const std::function<InputFile(const TomlNode&, const std::string&)>& file_of);
  /// Reads every row of a table of points, if there is one; calls `between` now and then.
  void check_table(const std::function<void()>& between) const;

  std::size_t point_count() const { return count_; }
  /// The dimensions and their values at a point.
  std::vector<SweepValue> values(std::size_t point) const;
  /// Empty without cases.
  std::string case_name(std::size_t point) const;
  bool has_cases() const { return !cases_.empty(); }
  /// Sets the keys that the sweep gives to a point.
  void apply(TomlNode& root, std::size_t point) const;
  /// True if some points have `key`, or a value that holds it, from the sweep.
  bool varies(const std::string& key) const;
  /// False if what a key is at a point says something of the other keys: of a table, and of lists that go together.
  bool has_independent_keys() const { return design_.kind != Kind::table && design_.kind != Kind::zip; }
  /// True if every value of a dimension goes with every value of the others.
  bool is_product() const { return design_.kind == Kind::product; }
  /// Values of the dimensions of a product, in order of the points.
  std::vector<SweepDimension> dimensions() const;
  /// See Config::sample_points().
  std::vector<std::size_t> sample(std::size_t most_of_axis, std::size_t random) const;
  /// The file with the table of points; "" without.
  std::string table_file() const { return table_ ? table_->path() : ""; }
  /// As the end of a TOML file. Empty without a sweep.
  std::string toml() const;

 private:
  enum class Kind { product, zip, latin_hypercube, sobol, table };
  struct Design {
    Kind kind = Kind::product;
    std::uint64_t points = 0, seed = 0;
    TomlNode written = {};
    bool is_given = false;
  };
  struct Case {
    std::string name;
    std::map<std::string, TomlNode> values;
  };
  /// One key of [sweep]: the list as written (or from --set), and its values.
  struct Axis {
    TomlNode list;
    SweepAxis values;
  };

  void read_lists(const TomlNode& table, const std::string& path);
  void add_list(const std::string& key, const TomlNode& list);
  void read_design(const TomlNode& n);
  static void read_case(Case& c, const TomlNode& table, const std::string& path, const std::string& shown);
  static void refuse_twins(const Case& c, const std::string& shown);
  void refuse_twins(const std::string& key, const TomlNode& value, const std::string& place) const;
  void expand_table(const std::function<InputFile(const TomlNode&, const std::string&)>& file_of);
  void expand_axes();
  std::size_t cases_or_one() const { return cases_.empty() ? 1 : cases_.size(); }
  /// What the design gives to its point `at`, by key, in order of the keys.
  std::vector<std::pair<std::string, TomlNode>> design_values(std::size_t at) const;
  /// Index of the case (0 without cases).
  std::size_t case_of(std::size_t point) const { return point / in_design_; }
  std::size_t in_case(std::size_t point) const { return point % in_design_; }

  std::vector<Case> cases_;
  std::map<std::string, Axis> axes_;
  Design design_;
  std::unique_ptr<SweepTable> table_;
  std::vector<std::pair<std::string, std::size_t>> columns_;  // of the table: key, number
  std::map<std::string, TomlNode> first_row_;
  std::vector<std::pair<std::string, TomlNode>> fixed_;  // by --set, beside a table
  std::size_t count_ = 1, in_design_ = 1;
};

}  // namespace surveymc::config
