#pragma once
/// Strict TOML. A config is one file; a sweep makes several points of it; an experiment reads each point through a
/// ConfigReader and gets checked values. The only user of toml++.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/units.h"
#include "config/input_file.h"
#include "config/input_table.h"

namespace surveymc::config {

struct KeyLog;

/// Closed or open interval of allowed numbers.
struct Range {
  double lo = -kInfinity;
  double hi = kInfinity;
  bool lo_open = false, hi_open = false;

  static Range closed(double lo, double hi) { return {lo, hi, false, false}; }
  static Range positive() { return {0, kInfinity, true, false}; }
  static Range non_negative() { return {0, kInfinity, false, false}; }
  static Range open(double lo, double hi) { return {lo, hi, true, true}; }

  bool operator==(const Range&) const = default;
};

/// One value of a sweep at one point: the key (or `case`) and what it is there, as number or text.
struct SweepValue {
  std::string key;
  std::variant<double, std::string> value;
};

/// One key of a sweep (or `case`) with its values in order of the points.
struct SweepDimension {
  std::string key;
  std::variant<std::vector<double>, std::vector<std::string>> values;
};

/// A remark for the user from reading a config, besides errors.
struct Remark {
  bool is_warning = false;
  std::string message;       ///< of a warning: what is unusual
  std::string place = {};    ///< the key; or in which line of which file, with its column, "survey.csv:12"
  std::string value = {};    ///< what stands there; with names of columns where it is of several, or of a file
  std::string way_out = {};  ///< what to do if it is not meant
  std::string line = {};     ///< of a key of the config: "file:line", which a result that is run again does not know
  std::uint64_t points = 1;  ///< how many points of the sweep it is about,
  std::size_t point = 0;     ///< and the first of them

  /// "file:line: key = value: what is unusual; what to do".
  std::string text() const;
};

/// "place = value: message; way out"; what is empty is left out.
std::string remark_text(const std::string& place, const std::string& value, const std::string& message,
                        const std::string& way_out);

/// A value and its place, for a rule that only computing can check. Outlives the reader.
class ConfigPlace {
 public:
  ConfigPlace() = default;
  /// `place`: "file:line". `key`: with its value, "key = value".
  ConfigPlace(std::string place, std::string key) : place_(std::move(place)), key_(std::move(key)) {}
  /// Throws InputError "file:line: key = value: rule".
  [[noreturn]] void fail(const std::string& rule) const;
  void require(bool ok, const std::string& rule) const {
    if (!ok) fail(rule);
  }
  /// Returns make(). An InputError of make(), which knows no config, gets this place.
  template <class Make>
  auto with_place(Make make) const {
    try {
      return make();
    } catch (const InputError& e) {
      fail(e.what());
    }
  }
  /// "file:line"
  const std::string& text() const { return place_; }

 private:
  std::string place_, key_;
};

/// Keys, those of elements of arrays alike ("leg[].name"), and the types of value that their getters take.
using KeyTypes = std::map<std::string, std::string>;

/// Which keys of a study: those that the configs that come with the program use, which is known at once, or all.
enum class KeysOf { shipped_configs, all_branches };
using KnownKeys = std::function<KeyTypes(KeysOf)>;

class Config;
struct ConfigDocument;
enum class Decides;

struct TomlNode;
struct ConfigValue;

/// Stands for the meaning of a key that is read again: the first getter has it.
inline constexpr std::string_view kMeaningElsewhere = "";

/// Strict, typed view of one point's config, or of one table inside it.
///
/// Keys are dotted ("field.dip_deg") and end in their unit. A getter names type, rule, default and meaning of its key;
/// `surveymc keys` and docs/keys.md are made of these (key_log.h). It throws InputError
/// "file.toml:12: field.dip_deg = 95: must be in [-90, 90]". Getters with a fallback write it into the resolved config;
/// a fallback that the rule would refuse, such as an empty text or a number out of range, stands for "absent" and is
/// not written. NaN and infinity are never accepted. finish() throws on any key that nobody asked for, with the nearest
/// known key ("did you mean ...", "the unit is missing: ...").
/// A string where a table is expected stands for that table's `name`: `estimator = "msa"` is `estimator.name = "msa"`.
///
/// `meaning`: a phrase or sentence for users, in Markdown without links; it must outlive the program's configs, as
/// string literals do.
class ConfigReader {
 public:
  /// True if the key is there.
  bool has(const std::string& key) const;
  /// True if the key is there and has a word (true is one to choice()): for keys that may have a number or a word.
  bool is_text(const std::string& key) const;

  double number(const std::string& key, const Range& range, std::string_view meaning,
                const std::optional<double>& fallback = std::nullopt);
  std::int64_t integer(const std::string& key, std::int64_t lo, std::int64_t hi, std::string_view meaning,
                       const std::optional<std::int64_t>& fallback = std::nullopt);
  bool boolean(const std::string& key, std::string_view meaning, bool fallback);
  std::string text(const std::string& key, std::string_view meaning,
                   const std::optional<std::string>& fallback = std::nullopt);
  std::string choice(const std::string& key, const std::vector<std::string>& allowed, std::string_view meaning,
                     const std::optional<std::string>& fallback = std::nullopt);
  /// A choice among names that the config itself gives. `what`: what they are, which is the key's rule for `surveymc
  /// keys`: "the name of an [[offset]]".
  std::string listed_name(const std::string& key, const std::vector<std::string>& names, const std::string& what,
                          std::string_view meaning, const std::optional<std::string>& fallback = std::nullopt);
  /// A date as decimal year, years of 365 or 366 days: 2026-07-01 (with or without quotes, from the year 1600 on) or
  /// the number 2026.4959.
  double decimal_year(const std::string& key, std::string_view meaning);
  /// Array of exactly `count` numbers; any number of them, but at least one, if count < 0.
  std::vector<double> numbers(const std::string& key, const Range& range, std::string_view meaning, int count = -1,
                              const std::optional<std::vector<double>>& fallback = std::nullopt);
  /// A number, or a list of at least one in any order.
  std::vector<double> number_or_list(const std::string& key, const Range& range, std::string_view meaning);
  /// A number, a list, or { from, to, step } (both ends included when they fit; strictly monotone, never empty).
  std::vector<double> grid(const std::string& key, const Range& range, std::string_view meaning);
  /// A string or an array of strings.
  std::vector<std::string> texts(const std::string& key, std::string_view meaning);
  /// An inline table of numbers: { a = 1.0, b = 2.0 }, in alphabetical order of the names.
  std::vector<std::pair<std::string, double>> number_table(const std::string& key, const Range& range,
                                                           std::string_view meaning);
  /// A list whose elements are strings or tables ("none", { name = "own", codes = ["A"] }), in order: the string, or
  /// the reader of the table. finish() of this reader covers them. `fallback`: strings.
  std::vector<std::variant<std::string, ConfigReader>> texts_or_tables(const std::string& key, std::string_view meaning,
                                                                       const std::vector<std::string>& fallback);
  /// One reader per element of an array of tables; none if the key is absent. finish() of this reader covers them.
  std::vector<ConfigReader> tables(const std::string& key, std::string_view meaning);
  /// True if every entry of the inline table `key` equals this point's value of the dotted key it names
  /// (`at = { "noise.scale" = 1.0 }`). True if `key` is absent. Call it on a reader from tables(), when the keys of the
  /// point were read (defaults count as values). If it is false and nothing else of that table was asked for, finish()
  /// does not check the table: read its values first to have typing errors found at every point.
  bool matches_point(const std::string& key);
  /// Reads the CSV file that `key` names, relative to the config's folder.
  InputTable csv(const std::string& key, std::string_view meaning);
  /// The text of the file that `key` names, relative to the config's folder, for a format of the study's own.
  InputText file_text(const std::string& key, std::string_view meaning);
  /// The same for a text that the program brings with it; `key` has chosen it. Of a result that is run again, the text
  /// that is stored there.
  InputText file_text(const std::string& key, const InputText& shipped);
  /// The same for a file of any size, to be read line by line. One of more than kLargestStoredFile bytes is read once
  /// for its hash, and is not stored.
  InputFile file(const std::string& key, std::string_view meaning);
  /// A table of numbers out of the file that `key` names: load(path) reads it, unless the result that is run again has
  /// it. IoError of load becomes the message of an InputError. `reading`: how load reads it, in words; a file is stored
  /// once, so that a config which has it read in two ways is refused.
  InputTable table(const std::string& key, std::string_view meaning,
                   const std::function<InputTable(const std::filesystem::path&)>& load,
                   const std::string& reading = {});
  /// A strict reader of the TOML file that `key` names, relative to the config's folder; its messages name that file's
  /// lines. Call its finish(), too.
  ConfigReader toml(const std::string& key, std::string_view meaning);
  /// The same for a document that the program brings with it; `key` has chosen it. Its path must be none of a file.
  ConfigReader toml(const std::string& key, const InputText& shipped);

  /// Throws InputError "file:line: key = value: rule" for a rule that only the caller can check.
  [[noreturn]] void fail(const std::string& key, const std::string& rule) const;
  void require(bool ok, const std::string& key, const std::string& rule) const {
    if (!ok) fail(key, rule);
  }
  /// The place that fail() would name.
  ConfigPlace place(const std::string& key) const;

  /// Tells the user what was read, or warns of what may be a mistake but need not be one: see Config::remarks().
  /// Warnings are rows of the result. `way_out`: "set field.grid", in words that go on behind a semicolon.
  void note(const std::string& text) const;
  void warn(const std::string& key, const std::string& message, const std::string& way_out = {}) const;
  /// The same of what is no key of a config: `place` and `value` as in Remark.
  void warn_at(const std::string& place, const std::string& value, const std::string& message,
               const std::string& way_out = {}) const;
  /// Throws InputError if a key was never asked for. Call it when everything was read.
  void finish() const;

  /// Everything that is wrong with the point that `read` reads, for who has seen that it cannot be read: unknown keys
  /// first, then what getters refuse. A getter gives its default or a sample then, and the reading goes on; what such a
  /// stand-in may be to blame for is left out. `known` gives keys of the study; it is called where the reading ends
  /// early, for all branches where others than those of shipped configs are left.
  static std::vector<std::string> mistakes_of(Config& config, std::size_t point, const KnownKeys& known,
                                              const std::function<void(ConfigReader&)>& read);

  /// A strict reader of a TOML file that no config names, relative to the working folder. Call its finish(), too.
  static ConfigReader of_file(const std::string& path);

 private:
  friend class Config;
  struct Point;     // one point of a config, shared by the readers of its tables
  struct Fallback;  // what a getter takes where the key is absent
  struct Mistakes;  // what mistakes_of() has found
  ConfigReader(std::shared_ptr<Point> point, const TomlNode* table, std::string path);
  static ConfigReader of_point(std::shared_ptr<ConfigDocument> doc, std::size_t index, TomlNode root);
  static ConfigReader of_document(const InputText& document, std::shared_ptr<ConfigDocument> parent,
                                  std::size_t index = 0);

  std::string full_key(const std::string& key) const;
  /// For messages about keys that are absent: the line of an element of an array of tables, else the file.
  const std::string& place_of_table() const;
  /// The value of a key. Does not make it known.
  ConfigValue look_up(const std::string& key) const;
  /// The first step of every getter: logs type, rule, sample and choices, as describe() has them, and the meaning;
  /// makes the key known; returns its value. Without a value the caller takes the fallback, which is remembered. Throws
  /// InputError if there is neither.
  template <class Describe>
  ConfigValue ask(const std::string& key, std::string_view meaning, const Fallback& fallback, const Describe& describe);
  /// The same for a string that may be written as the `name` of a table.
  template <class Describe>
  ConfigValue ask_name(const std::string& key, std::string_view meaning, const Fallback& fallback,
                       const Describe& describe);
  template <class Describe>
  std::string word_among(const std::string& key, const std::vector<std::string>& allowed, std::string_view meaning,
                         const std::optional<std::string>& fallback, const Describe& describe);
  [[noreturn]] void refuse_missing(const std::string& key) const;
  /// What get() returns. While mistakes are collected, one of get() is noted, and `stand_in` takes its place.
  /// `decides`: what may depend on the value (mistakes.h).
  template <class Value, class Get>
  Value or_stand_in(const std::string& key, Decides decides, const Value& stand_in, const Get& get) const;
  /// The reader of item `i` of an array of tables.
  ConfigReader element(const std::string& key, const TomlNode& array, std::size_t i) const;

  std::shared_ptr<Point> point_;
  const TomlNode* table_ = nullptr;  // in the point
  std::string path_;                 // of this table: "published[1]", or empty at the root
};

/// See key_log.h.
Config config_with_log(const InputText& file, std::shared_ptr<KeyLog> log);

/// A config file with its overrides, expanded to the points of its sweep.
///
/// `[sweep]` holds lists or ranges under dotted keys; the points are their product, or what `design` says.
/// `[[sweep.case]]` is an array of tables, each with a `name` and any dotted keys: one more dimension, whose value is
/// the name. Points are numbered from 0; cases vary slowest, then the points of the design: of a product the keys in
/// alphabetical order, the last one fastest. A point is a function of its number; nothing lists them all. An empty list
/// is an error, and so is a key that two of these set. experiment, seed, title and trials cannot vary.
class Config {
 public:
  /// `overrides` are KEY=VALUE texts from --set (VALUE in TOML; a bare word is taken as a string), later ones win.
  /// A key named there is taken out of [sweep] and of every case, because the user has fixed it; `sweep.KEY=[...]`
  /// gives KEY's list anew. Throws InputError.
  static Config load(const std::filesystem::path& path, const std::vector<std::string>& overrides);
  /// The config stored in a result, with the files that were stored beside it. `references` are files that were too
  /// large for that: they are looked for in `folder`, and must be the same bytes.
  static Config from_text(const std::string& text, const std::string& label, std::vector<InputTable> files,
                          std::vector<InputText> texts = {}, std::vector<InputReference> references = {},
                          const std::filesystem::path& folder = {});

  Config(Config&&) noexcept = default;

  /// experiment, required, seed (0 .. 2^63 - 1) and title ("" if absent) of the file. No reader has to ask for them.
  /// seed() throws InputError where there is none: a file without is right where nothing is drawn.
  std::string experiment() const;
  bool has_seed() const;
  std::uint64_t seed() const;
  std::string title() const;

  std::size_t point_count() const;
  /// Sweep keys in column order, then point I's values for them. Empty without a sweep.
  std::vector<SweepValue> sweep_values(std::size_t point) const;
  /// True if each value of a key goes with all values of the others.
  bool is_product() const;
  /// The keys of the sweep with all their values if each value goes with all of the others; none of another design.
  std::optional<std::vector<SweepDimension>> sweep_product() const;
  /// Points that show what there is to check of a sweep that is too large to be read whole: of a product every value of
  /// every key, but at most 1000 of a key, and 1000 random points, the same ones for every reader. Rising.
  std::vector<std::size_t> sample_points() const;
  /// Reads every row of a table of points, if the sweep has one; calls `between` now and then. Throws InputError.
  void check_sweep(const std::function<void()>& between) const;
  /// The file that has the sweep's points; "" without one.
  std::string sweep_file() const;
  /// A fresh reader for point I; it may outlive the Config. Reading it records defaults and input files for
  /// resolved_text() and inputs().
  ConfigReader reader(std::size_t point);
  /// ConfigReader::fail() for a key of the file or of --set that does not vary, such as experiment.
  [[noreturn]] void fail(const std::string& key, const std::string& rule) const;

  /// The config as TOML with overrides and the defaults that every point read alike. Keys sorted; round-trip exact.
  /// Reads back to the same points. Call it after all points were read.
  std::string resolved_text() const;
  /// The config as TOML with overrides, before any point was read: the same whichever points are read.
  std::string source_text() const;
  /// 128-bit XXH3 in hex of source_text() and the file of points: what all tasks of a sweep have in common.
  std::string source_hash() const;
  /// The same of source_text() and of the files that the points that were read name.
  std::string hash_as_read() const;
  /// Every CSV file that was read, once each, in order of path.
  std::vector<InputTable> inputs() const;
  /// Every TOML file that was read besides the config (toml()), shipped ones too, once each, in order of path.
  std::vector<InputText> input_texts() const;
  /// Every file that was read and is too large to be stored, once each, in order of path.
  std::vector<InputReference> input_references() const;
  /// The remarks of the readers of all points, once each, in order. No part of hash().
  std::vector<Remark> remarks() const;
  /// 128-bit XXH3 in hex of resolved_text() and the input files' contents (of large files, their hash).
  std::string hash() const;

 private:
  friend Config config_with_log(const InputText& file, std::shared_ptr<KeyLog> log);
  Config();
  std::shared_ptr<ConfigDocument> doc_;
};

/// Shortest decimal text that reads back to the same double ("0.1", "51000").
std::string format_number(double x);

}  // namespace surveymc::config
