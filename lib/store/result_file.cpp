#include "store/result_file.h"

#include <fcntl.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <new>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "base/error.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

// How a file comes to be: HDF5 builds it in memory (core driver), then plain write() puts it on the disk. So a full
// disk is an errno of ours, and not a library left with a file that it can neither flush nor close.

namespace surveymc {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "hashes and native HDF5 types assume little endian");

constexpr const char* kFormat = "surveymc";
constexpr std::int64_t kFormatVersion = 1;
constexpr const char* kRow = "row";                     // dimension scale of every table
constexpr const char* kOriginalName = "original_name";  // where the link had to be named otherwise

std::string error_text(int error_number) { return std::generic_category().message(error_number); }

// ---------------------------------------------------------------------------------------------------------------------
// What is stored of a value. Hash and file see the same, so that the hash of what is read back equals the stored one.

double canonical_number(double x) { return std::isnan(x) ? std::numeric_limits<double>::quiet_NaN() : x; }

/// Length of the UTF-8 sequence at `at`; 0 if it is none, and for NUL, which would end a string in HDF5.
std::size_t utf8_length(const std::string& s, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < s.size() ? static_cast<unsigned char>(s[i]) : 0u; };
  const unsigned lead = byte(at);
  if (lead == 0) return 0;
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xC2 && lead < 0xE0   ? 2
                             : lead >= 0xE0 && lead < 0xF0 ? 3
                             : lead >= 0xF0 && lead < 0xF5 ? 4
                                                           : 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  }
  const unsigned second = byte(at + 1);
  const bool overlong = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool surrogate = lead == 0xED && second >= 0xA0;
  const bool too_large = lead == 0xF4 && second >= 0x90;
  return overlong || surrogate || too_large ? 0 : length;
}

/// Every byte that is not UTF-8 (a header line in Latin-1) becomes U+FFFD: Python readers refuse the file otherwise.
std::string canonical_text(const std::string& s) {
  std::string out;
  out.reserve(s.size());
  for (std::size_t at = 0; at < s.size();) {
    const std::size_t length = utf8_length(s, at);
    if (length == 0)
      out += "\xEF\xBF\xBD";
    else
      out.append(s, at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

// ---------------------------------------------------------------------------------------------------------------------
// Hashes

/// XXH3-128 over a serialisation in which every list and text is preceded by its length: no two results share one.
class Hasher {
 public:
  Hasher() { XXH3_128bits_reset(&state_); }

  void add(std::uint64_t x) { XXH3_128bits_update(&state_, &x, sizeof x); }
  void add(const std::string& text) {
    const std::string canonical = canonical_text(text);
    add(std::uint64_t{canonical.size()});
    XXH3_128bits_update(&state_, canonical.data(), canonical.size());
  }
  void add(const std::vector<double>& values) {
    add(std::uint64_t{values.size()});
    for (const double x : values) add(std::bit_cast<std::uint64_t>(canonical_number(x)));
  }
  void add(const std::vector<std::int64_t>& values) {
    add(std::uint64_t{values.size()});
    for (const std::int64_t x : values) add(static_cast<std::uint64_t>(x));
  }
  void add(const std::vector<std::string>& values) {
    add(std::uint64_t{values.size()});
    for (const std::string& x : values) add(x);
  }
  template <class... T>
  void add(const std::variant<T...>& values) {
    add(std::uint64_t{values.index()});
    std::visit([&](const auto& v) { add(v); }, values);
  }
  void add(const Column& c) { add(c.name), add(c.unit), add(c.long_name), add(c.ancillary), add(c.values); }
  void add(const Axis& a) { add(a.name), add(a.unit), add(a.long_name), add(a.values); }
  void add(const Table& t) { add(t.name), add(t.long_name), add(t.columns); }
  void add(const Map& m) { add(m.name), add(m.unit), add(m.long_name), add(m.axes), add(m.values); }
  void add(const InputData& i) { add(i.path), add(i.hash), add(i.table.long_name), add(i.table.columns); }
  template <class T>
  void add(const std::vector<T>& list) {
    add(std::uint64_t{list.size()});
    for (const T& x : list) add(x);
  }

  std::string hex() const {
    const XXH128_hash_t h = XXH3_128bits_digest(&state_);
    return fmt::format("{:016x}{:016x}", h.high64, h.low64);
  }

 private:
  XXH3_state_t state_;
};

std::string axis_hash(const Axis& axis) {
  Hasher h;
  h.add(axis);
  return h.hex();
}

// ---------------------------------------------------------------------------------------------------------------------
// Seal: the last bytes of the file are a mark and the hash of all bytes before. HDF5 ignores what follows its own data,
// but it follows damaged addresses and crashes; so a sealed file is compared with its seal before HDF5 sees it. A file
// without one (rewritten by h5repack, extended by h5py) is read all the same.

constexpr std::size_t kMarkSize = 8;
constexpr char kMark[kMarkSize + 1] = "SMCSEAL1";
constexpr std::size_t kSealSize = kMarkSize + sizeof(XXH128_canonical_t);

std::string seal_text(XXH128_hash_t hash) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  std::string seal = kMark;
  seal.append(reinterpret_cast<const char*>(canonical.digest), sizeof canonical.digest);
  return seal;
}

void append_seal(std::vector<char>& bytes) {
  const std::string seal = seal_text(XXH3_128bits(bytes.data(), bytes.size()));
  bytes.insert(bytes.end(), seal.begin(), seal.end());
}

/// True if the file has no seal, or the right one.
bool is_intact(const fs::path& path, std::uintmax_t size) {
  if (size < kSealSize) return true;
  const std::uintmax_t sealed = size - kSealSize;
  std::ifstream in(path, std::ios::binary);
  std::string seal(kSealSize, '\0');
  in.seekg(static_cast<std::streamoff>(sealed));
  in.read(seal.data(), static_cast<std::streamsize>(seal.size()));
  if (!in || !seal.starts_with(kMark)) return true;
  in.seekg(0);
  XXH3_state_t state;
  XXH3_128bits_reset(&state);
  std::vector<char> chunk(std::size_t{1} << 20);
  for (std::uintmax_t left = sealed; left > 0;) {
    const std::size_t n = std::min<std::uintmax_t>(left, chunk.size());
    if (!in.read(chunk.data(), static_cast<std::streamsize>(n))) return false;
    XXH3_128bits_update(&state, chunk.data(), n);
    left -= n;
  }
  return seal == seal_text(XXH3_128bits_digest(&state));
}

// ---------------------------------------------------------------------------------------------------------------------
// HDF5 underneath

/// An HDF5 call failed. The functions of the header turn it into IoError with the path.
struct Hdf5Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The innermost message of HDF5's error stack: the cause ("truncated file: ..."), not the call that met it.
std::string hdf5_reason() {
  std::string reason = "unknown error";
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* e, void* out) -> herr_t {
        if (n == 0 && e->desc) *static_cast<std::string*>(out) = e->desc;
        return 0;
      },
      &reason);
  return reason;
}

/// Passes on the result of an HDF5 call; throws if it is negative. `action` completes "cannot ...".
template <class T>
T checked(T result, const char* action, const std::string& object = {}) {
  if (result < 0)
    throw Hdf5Failure(fmt::format("cannot {}{}{}: {}", action, object.empty() ? "" : " ", object, hdf5_reason()));
  return result;
}

/// Owns one HDF5 identifier of any kind.
class Handle {
 public:
  Handle(hid_t id, const char* action, const std::string& object = {}) : id_(checked(id, action, object)) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
};

/// We report errors ourselves; HDF5 would print its stack to stderr.
void silence_hdf5() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), "make a type");
  checked(H5Tset_size(type, H5T_VARIABLE), "make a type");
  checked(H5Tset_cset(type, H5T_CSET_UTF8), "make a type");
  return type;
}

Handle file_access() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), "make a property list");
  checked(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG), "set the close degree");
  // Readers see finished files only, so a lock protects nothing; on many cluster file systems it just fails.
  checked(H5Pset_file_locking(access, false, true), "turn locking off");
  return access;
}

// ---------------------------------------------------------------------------------------------------------------------
// Names of links

/// `name` as HDF5 and netCDF can store it in a group that has the links `taken`; adds it to them. Users' column names
/// ("Inc/deg", "row", "") are the reason; a name that can stay as it is does.
std::string link_name(const std::string& name, std::set<std::string>& taken) {
  std::string link = canonical_text(name);
  for (char& c : link) {
    if (c == '/' || static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '_';
  }
  while (link.ends_with(' ')) link.pop_back();
  if (link.empty() || link[0] == '.' || link[0] == ' ') link.insert(0, "_");
  std::string unique = link;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = fmt::format("{}_{}", link, i);
  return unique;
}

/// Group of an input file: its stem, reduced to what every tool accepts.
std::string input_group_name(const std::string& path, std::set<std::string>& taken) {
  std::string stem = canonical_text(fs::path(path).stem().string());
  for (char& c : stem) {
    const auto u = static_cast<unsigned char>(c);
    const bool letter = (u | 0x20) >= 'a' && (u | 0x20) <= 'z';
    if (!letter && !(u >= '0' && u <= '9') && u < 0x80 && c != '-' && c != '.') c = '_';
  }
  return link_name(stem.empty() ? "input" : stem, taken);
}

// ---------------------------------------------------------------------------------------------------------------------
// Writing

/// A malformed result is a bug of the study that made it.
void check_shape(const Result& result) {
  const auto demand = [](bool ok, const std::string& what) {
    if (!ok) throw std::logic_error("malformed result: " + what);
  };
  const auto demand_columns = [&](const Table& t) {
    for (const Column& c : t.columns)
      demand(c.size() == t.rows(), "columns of " + t.name + " differ in length at " + c.name);
  };
  const auto demand_name = [&](const std::string& name, std::set<std::string>& taken) {
    demand(link_name(name, taken) == name, fmt::format("\"{}\" cannot name a table or map, or does so twice", name));
  };
  for (const auto* tables : {&result.tables, &result.samples}) {
    std::set<std::string> taken;
    for (const Table& t : *tables) demand_name(t.name, taken), demand_columns(t);
  }
  for (const InputData& i : result.inputs) demand_columns(i.table);
  std::set<std::string> taken;
  for (const Map& m : result.maps) {
    demand_name(m.name, taken);
    std::size_t n = 1;
    for (const Axis& a : m.axes) n *= std::visit([](const auto& v) { return v.size(); }, a.values);
    demand(n == m.values.size(), "map " + m.name + " is not the product of its axes");
  }
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  demand(result.provenance.seed <= kMax && result.provenance.trials <= kMax, "seed or trials above 2^63 - 1");
}

class Writer {
 public:
  Writer()
      : text_(text_type()),
        group_properties_(H5Pcreate(H5P_GROUP_CREATE), "make a property list"),
        dataset_properties_(H5Pcreate(H5P_DATASET_CREATE), "make a property list") {
    constexpr unsigned kOrder = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
    checked(H5Pset_link_creation_order(group_properties_, kOrder), "track link order");
    for (const Handle* p : {&group_properties_, &dataset_properties_}) {
      checked(H5Pset_attr_creation_order(*p, kOrder), "track attribute order");
      checked(H5Pset_obj_track_times(*p, false), "turn times off");  // or no two files have the same bytes
    }
  }

  /// The bytes of the whole file. `name` must not exist: HDF5 looks for it although nothing is written there.
  std::vector<char> file_image(const std::string& name, const Result& result) {
    const Handle access = file_access();
    checked(H5Pset_fapl_core(access, std::size_t{1} << 20, false), "select the memory driver");
    // HDF5 1.8 and later can read it. Not V18 as the lower bound: with its superblock, H5Fget_file_image of 1.10.8
    // clears a flag and leaves the checksum as it was. Object headers get checksums all the same, as they track an
    // order.
    checked(H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18), "select the format");
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), "make a property list");
    checked(H5Pset_link_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED), "track link order");
    checked(H5Pset_attr_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
            "track attribute order");
    checked(H5Pset_obj_track_times(creation, false), "turn times off");

    const Handle file(H5Fcreate(name.c_str(), H5F_ACC_EXCL, creation, access), "start the file");
    write_provenance(file, result);
    write_tables(file, "tables", result.tables);
    write_maps(file, result.maps);
    write_tables(file, "samples", result.samples);
    write_inputs(file, result.inputs);
    write_run(file, result.run);
    checked(H5Fflush(file, H5F_SCOPE_GLOBAL), "flush");
    const auto size = checked(H5Fget_file_image(file, nullptr, 0), "size the file");
    std::vector<char> image(static_cast<std::size_t>(size));
    checked(H5Fget_file_image(file, image.data(), image.size()), "copy the file");
    return image;
  }

 private:
  void attribute(hid_t object, const char* name, const std::string& value) {
    const std::string canonical = canonical_text(value);
    const char* pointer = canonical.c_str();
    write_attribute(object, name, text_, &pointer);
  }
  void attribute(hid_t object, const char* name, std::int64_t value) {
    write_attribute(object, name, H5T_NATIVE_INT64, &value);
  }
  void attribute(hid_t object, const char* name, double value) {
    write_attribute(object, name, H5T_NATIVE_DOUBLE, &value);
  }
  void write_attribute(hid_t object, const char* name, hid_t type, const void* value) {
    const Handle space(H5Screate(H5S_SCALAR), "make a dataspace");
    const Handle a(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), "create attribute", name);
    checked(H5Awrite(a, type, value), "write attribute", name);
  }
  /// Unit and long name. A label has no unit, and a `units` of "" would call it a pure number.
  void describe(hid_t object, const std::string& link, const std::string& name, const std::string& unit,
                const std::string& long_name) {
    if (!unit.empty()) attribute(object, "units", unit);
    attribute(object, "long_name", long_name);
    if (link != canonical_text(name)) attribute(object, kOriginalName, name);
  }

  Handle group(hid_t parent, const std::string& link) {
    return Handle(H5Gcreate2(parent, link.c_str(), H5P_DEFAULT, group_properties_, H5P_DEFAULT), "create group", link);
  }
  Handle dataset(hid_t parent, const std::string& link, hid_t type, const std::vector<hsize_t>& dims,
                 const void* values) {
    const Handle space(
        dims.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
        "make a dataspace for", link);
    Handle d(H5Dcreate2(parent, link.c_str(), type, space, H5P_DEFAULT, dataset_properties_, H5P_DEFAULT),
             "create dataset", link);
    if (H5Sget_simple_extent_npoints(space) > 0) {  // without any, `values` may be null, which H5Dwrite refuses
      checked(H5Dwrite(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "write dataset", link);
    }
    return d;
  }
  Handle dataset(hid_t parent, const std::string& link, const std::vector<hsize_t>& dims,
                 const std::vector<double>& values) {
    std::vector<double> canonical(values.size());
    std::transform(values.begin(), values.end(), canonical.begin(), canonical_number);
    return dataset(parent, link, H5T_NATIVE_DOUBLE, dims, canonical.data());
  }
  Handle dataset(hid_t parent, const std::string& link, const std::vector<hsize_t>& dims,
                 const std::vector<std::int64_t>& values) {
    return dataset(parent, link, H5T_NATIVE_INT64, dims, values.data());
  }
  Handle dataset(hid_t parent, const std::string& link, const std::vector<hsize_t>& dims,
                 const std::vector<std::string>& values) {
    std::vector<std::string> canonical(values.size());
    std::transform(values.begin(), values.end(), canonical.begin(), canonical_text);
    std::vector<const char*> pointers;
    for (const std::string& s : canonical) pointers.push_back(s.c_str());
    return dataset(parent, link, text_, dims, pointers.data());
  }

  void write_provenance(hid_t file, const Result& result) {
    const Provenance& p = result.provenance;
    attribute(file, "title", p.title);
    attribute(file, "format", kFormat);
    attribute(file, "format_version", kFormatVersion);
    attribute(file, "experiment", p.experiment);
    attribute(file, "surveymc_version", p.surveymc_version);
    attribute(file, "git_revision", p.git_revision);
    attribute(file, "config", p.config);
    attribute(file, "config_hash", p.config_hash);
    attribute(file, "command", p.command);
    attribute(file, "seed", static_cast<std::int64_t>(p.seed));
    attribute(file, "trials", static_cast<std::int64_t>(p.trials));
    attribute(file, "compiler", p.compiler);
    attribute(file, "content_hash", content_hash(result));
  }

  void write_run(hid_t file, const RunInfo& run) {
    const Handle g = group(file, "run");
    attribute(g, "created", run.created);
    attribute(g, "host", run.host);
    attribute(g, "elapsed_s", run.elapsed_s);
    attribute(g, "threads", run.threads);
    attribute(g, "ranks", run.ranks);
  }

  void write_columns(hid_t g, const Table& table) {
    attribute(g, "long_name", table.long_name);
    const std::vector<hsize_t> dims = {table.rows()};
    std::vector<std::int64_t> numbers(table.rows());
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::int64_t>(i);
    const Handle row = dataset(g, kRow, dims, numbers);
    describe(row, kRow, kRow, "1", "row number, from 0");
    checked(H5DSset_scale(row, kRow), "make the dimension scale of", table.name);

    std::set<std::string> taken = {kRow};
    for (const Column& c : table.columns) {
      const std::string link = link_name(c.name, taken);
      const Handle d = std::visit([&](const auto& values) { return dataset(g, link, dims, values); }, c.values);
      describe(d, link, c.name, c.unit, c.long_name);
      if (!c.ancillary.empty()) attribute(d, "ancillary_variables", c.ancillary);
      checked(H5DSattach_scale(d, row, 0), "attach the dimension scale to", link);
    }
  }

  void write_tables(hid_t file, const char* parent, const std::vector<Table>& tables) {
    const Handle all = group(file, parent);
    for (const Table& t : tables) write_columns(group(all, t.name), t);
  }

  void write_inputs(hid_t file, const std::vector<InputData>& inputs) {
    const Handle all = group(file, "inputs");
    std::set<std::string> taken;
    for (const InputData& input : inputs) {
      const Handle g = group(all, input_group_name(input.path, taken));
      attribute(g, "path", input.path);
      attribute(g, "hash", input.hash);
      write_columns(g, input.table);
    }
  }

  /// All maps are in one group, so that one xr.open_dataset() has them. Maps share an axis that is the same in name,
  /// unit and values; another axis of that name gets a number behind it.
  void write_maps(hid_t file, const std::vector<Map>& maps) {
    const Handle all = group(file, "maps");
    std::set<std::string> taken;
    for (const Map& m : maps) taken.insert(m.name);
    std::vector<std::pair<std::string, Handle>> axes;  // axis_hash(), dimension scale

    for (const Map& m : maps) {
      std::vector<hsize_t> dims;
      std::vector<std::size_t> used;  // netCDF readers want no dimension twice in a variable
      for (const Axis& a : m.axes) {
        dims.push_back(std::visit([](const auto& v) { return v.size(); }, a.values));
        const std::string hash = axis_hash(a);
        std::size_t i = 0;
        while (i < axes.size() && (axes[i].first != hash || std::count(used.begin(), used.end(), i) > 0)) ++i;
        if (i == axes.size()) {
          const std::string link = link_name(a.name, taken);
          Handle d =
              std::visit([&](const auto& values) { return dataset(all, link, {dims.back()}, values); }, a.values);
          describe(d, link, a.name, a.unit, a.long_name);
          checked(H5DSset_scale(d, link.c_str()), "make the dimension scale", link);
          axes.emplace_back(hash, std::move(d));
        }
        used.push_back(i);
      }
      const Handle d = dataset(all, m.name, dims, m.values);
      describe(d, m.name, m.name, m.unit, m.long_name);
      for (std::size_t i = 0; i < used.size(); ++i) {
        checked(H5DSattach_scale(d, axes[used[i]].second, static_cast<unsigned>(i)), "attach a dimension scale to",
                m.name);
      }
    }
  }

  Handle text_, group_properties_, dataset_properties_;
};

// ---------------------------------------------------------------------------------------------------------------------
// Reading. The file may be damaged or made by others: types and sizes are checked before memory is filled.

class Reader {
 public:
  /// Throws Hdf5Failure if the file is not HDF5, or not whole.
  explicit Reader(const fs::path& path) : file_size_(fs::file_size(path)), file_(open(path, file_size_)) {}

  bool is_surveymc() const { return H5Aexists(file_, "format") > 0 && text(file_, "format") == kFormat; }
  std::int64_t format_version() const { return integer(file_, "format_version"); }
  std::string stored_hash() const { return text(file_, "content_hash"); }

  Result result() const {
    Result r;
    r.provenance.title = text(file_, "title");
    r.provenance.experiment = text(file_, "experiment");
    r.provenance.surveymc_version = text(file_, "surveymc_version");
    r.provenance.git_revision = text(file_, "git_revision");
    r.provenance.config = text(file_, "config");
    r.provenance.config_hash = text(file_, "config_hash");
    r.provenance.command = text(file_, "command");
    r.provenance.seed = static_cast<std::uint64_t>(integer(file_, "seed"));
    r.provenance.trials = static_cast<std::uint64_t>(integer(file_, "trials"));
    r.provenance.compiler = text(file_, "compiler");

    const Handle run = group(file_, "run");
    r.run.created = text(run, "created");
    r.run.host = text(run, "host");
    r.run.elapsed_s = number(run, "elapsed_s");
    r.run.threads = integer(run, "threads");
    r.run.ranks = integer(run, "ranks");

    r.tables = tables("tables");
    r.samples = tables("samples");
    const Handle maps = group(file_, "maps");
    for (const std::string& link : links(maps)) {
      const Handle d = dataset(maps, link);
      if (H5DSis_scale(d) <= 0) r.maps.push_back(map(d, link));
    }
    const Handle inputs = group(file_, "inputs");
    for (const std::string& link : links(inputs)) {
      const Handle g = group(inputs, link);
      r.inputs.push_back({text(g, "path"), text(g, "hash"), table(g, link)});
    }
    return r;
  }

 private:
  static Handle open(const fs::path& path, std::uintmax_t size) {
    if (!is_intact(path, size)) throw Hdf5Failure("is damaged or was edited: its checksum does not match");
    return Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, file_access()), "read it as an HDF5 file");
  }
  static std::string text(hid_t object, const std::string& name) {
    const Handle a = attribute(object, name);
    const Handle type(H5Aget_type(a), "read the type of attribute", name);
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) <= 0) {
      throw Hdf5Failure("attribute " + name + " is not a variable-length string");
    }
    char* value = nullptr;
    checked(H5Aread(a, type, &value), "read attribute", name);
    if (!value) return "";
    const std::string copy = value;
    H5free_memory(value);
    return copy;
  }
  static std::string text_or(hid_t object, const std::string& name, const std::string& fallback) {
    return H5Aexists(object, name.c_str()) > 0 ? text(object, name) : fallback;
  }
  static std::int64_t integer(hid_t object, const std::string& name) {
    std::int64_t value = 0;
    checked(H5Aread(attribute(object, name), H5T_NATIVE_INT64, &value), "read attribute", name);
    return value;
  }
  static double number(hid_t object, const std::string& name) {
    double value = 0;
    checked(H5Aread(attribute(object, name), H5T_NATIVE_DOUBLE, &value), "read attribute", name);
    return value;
  }
  static Handle attribute(hid_t object, const std::string& name) {
    Handle a(H5Aopen(object, name.c_str(), H5P_DEFAULT), "find attribute", name);
    const Handle space(H5Aget_space(a), "read the shape of attribute", name);
    if (H5Sget_simple_extent_npoints(space) != 1) throw Hdf5Failure("attribute " + name + " is not one value");
    return a;
  }
  static Handle group(hid_t parent, const std::string& link) {
    return Handle(H5Gopen2(parent, link.c_str(), H5P_DEFAULT), "open group", link);
  }
  static Handle dataset(hid_t parent, const std::string& link) {
    return Handle(H5Dopen2(parent, link.c_str(), H5P_DEFAULT), "open dataset", link);
  }

  /// Names in a group, in the order in which they were written.
  static std::vector<std::string> links(hid_t parent) {
    H5G_info_t info;
    checked(H5Gget_info(parent, &info), "list a group");
    std::vector<std::string> names;
    for (hsize_t i = 0; i < info.nlinks; ++i) {
      const auto name_at = [&](char* buffer, std::size_t size) {
        return static_cast<std::size_t>(
            checked(H5Lget_name_by_idx(parent, ".", H5_INDEX_CRT_ORDER, H5_ITER_INC, i, buffer, size, H5P_DEFAULT),
                    "list a group"));
      };
      std::string name(name_at(nullptr, 0), '\0');
      name_at(name.data(), name.size() + 1);
      names.push_back(name);
    }
    return names;
  }

  std::vector<hsize_t> shape(hid_t d, const std::string& link) const {
    const Handle space(H5Dget_space(d), "read the shape of", link);
    std::vector<hsize_t> dims(
        static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space), "read the shape of", link)));
    checked(H5Sget_simple_extent_dims(space, dims.data(), nullptr), "read the shape of", link);
    // A damaged size must not ask for all the memory. 128: no compression makes a value smaller than 1/128 byte.
    long double count = 1;
    for (const hsize_t n : dims) count *= static_cast<long double>(n);
    if (count > 128.0L * static_cast<long double>(file_size_)) {
      throw Hdf5Failure(link + " claims more values than the file can hold");
    }
    return dims;
  }
  std::size_t length(hid_t d, const std::string& link) const {
    const std::vector<hsize_t> dims = shape(d, link);
    if (dims.size() != 1) throw Hdf5Failure(link + " is not one-dimensional");
    return dims[0];
  }

  template <class T>
  static std::vector<T> values(hid_t d, hid_t type, std::size_t count, const std::string& link) {
    std::vector<T> out(count);
    if (count > 0) checked(H5Dread(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.data()), "read", link);
    return out;
  }
  static std::vector<std::string> texts(hid_t d, hid_t type, std::size_t count, const std::string& link) {
    if (H5Tis_variable_str(type) <= 0) throw Hdf5Failure(link + " does not hold variable-length strings");
    std::vector<char*> pointers = values<char*>(d, type, count, link);
    std::vector<std::string> out;
    out.reserve(count);
    for (const char* p : pointers) out.emplace_back(p ? p : "");
    const Handle space(H5Dget_space(d), "read the shape of", link);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
    return out;
  }

  Column column(hid_t g, const std::string& link) const {
    const Handle d = dataset(g, link);
    Column c{text_or(d, kOriginalName, link),
             text_or(d, "units", ""),
             text_or(d, "long_name", ""),
             {},
             text_or(d, "ancillary_variables", "")};
    const std::size_t count = length(d, link);
    const Handle type(H5Dget_type(d), "read the type of", link);
    switch (H5Tget_class(type)) {
      case H5T_FLOAT:
        c.values = values<double>(d, H5T_NATIVE_DOUBLE, count, link);
        break;
      case H5T_INTEGER:
        c.values = values<std::int64_t>(d, H5T_NATIVE_INT64, count, link);
        break;
      case H5T_STRING:
        c.values = texts(d, type, count, link);
        break;
      default:
        throw Hdf5Failure(link + " holds neither numbers nor text");
    }
    return c;
  }

  Table table(hid_t g, const std::string& name) const {
    Table t{name, text_or(g, "long_name", "")};
    for (const std::string& link : links(g)) {
      if (link == kRow) continue;
      t.columns.push_back(column(g, link));
      if (t.columns.back().size() != t.rows()) throw Hdf5Failure("columns of " + name + " differ in length");
    }
    return t;
  }

  std::vector<Table> tables(const std::string& parent) const {
    const Handle all = group(file_, parent);
    std::vector<Table> out;
    for (const std::string& link : links(all)) out.push_back(table(group(all, link), link));
    return out;
  }

  Axis axis(hid_t map, unsigned dimension, const std::string& map_name) const {
    hid_t scale_id = -1;
    checked(H5DSiterate_scales(
                map, dimension, nullptr,
                [](hid_t, unsigned, hid_t scale, void* out) -> herr_t {
                  H5Iinc_ref(scale);  // the iteration closes its own reference
                  *static_cast<hid_t*>(out) = scale;
                  return 1;
                },
                &scale_id),
            "read the axes of", map_name);
    if (scale_id < 0) throw Hdf5Failure("map " + map_name + " lacks an axis");
    const Handle d(scale_id, "open an axis of", map_name);
    std::array<char, 512> name{};
    checked(H5DSget_scale_name(d, name.data(), name.size() - 1), "read the name of an axis of", map_name);

    Axis a{text_or(d, kOriginalName, name.data()), text_or(d, "units", ""), text_or(d, "long_name", ""), {}};
    const std::size_t count = length(d, a.name);
    const Handle type(H5Dget_type(d), "read the type of", a.name);
    if (H5Tget_class(type) == H5T_STRING)
      a.values = texts(d, type, count, a.name);
    else
      a.values = values<double>(d, H5T_NATIVE_DOUBLE, count, a.name);
    return a;
  }

  Map map(hid_t d, const std::string& link) const {
    Map m{link, text_or(d, "units", ""), text_or(d, "long_name", ""), {}, {}};
    const std::vector<hsize_t> dims = shape(d, link);
    std::size_t count = 1;
    for (std::size_t i = 0; i < dims.size(); ++i) {
      m.axes.push_back(axis(d, static_cast<unsigned>(i), link));
      if (std::visit([](const auto& v) { return v.size(); }, m.axes.back().values) != dims[i]) {
        throw Hdf5Failure("map " + link + " does not have the length of its axis " + m.axes.back().name);
      }
      count *= dims[i];
    }
    m.values = values<double>(d, H5T_NATIVE_DOUBLE, count, link);
    return m;
  }

  std::uintmax_t file_size_;
  Handle file_;
};

/// Runs `read` on the open file; every failure becomes IoError with the path.
template <class Read>
auto reading(const fs::path& path, const Read& read) {
  silence_hdf5();
  try {
    std::error_code error;
    if (fs::is_directory(path, error)) throw Hdf5Failure("is a folder");
    if (access(path.c_str(), R_OK) != 0) throw Hdf5Failure(error_text(errno));
    if (!fs::is_regular_file(path, error)) throw Hdf5Failure("is not a regular file");
    return read(Reader(path));
  } catch (const Hdf5Failure& e) {
    throw IoError(fmt::format("{}: {}", path.string(), e.what()));
  } catch (const fs::filesystem_error& e) {
    throw IoError(fmt::format("{}: {}", path.string(), e.code().message()));
  } catch (const std::bad_alloc&) {
    throw IoError(fmt::format("{}: too large for the memory, or damaged", path.string()));
  }
}

void check_format(const Reader& reader) {
  if (!reader.is_surveymc()) throw Hdf5Failure("is an HDF5 file, but not a surveymc result");
  if (reader.format_version() != kFormatVersion) {
    throw Hdf5Failure(fmt::format("has result format version {}; this program knows version {}",
                                  reader.format_version(), kFormatVersion));
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Paths and temporary files

/// Where a symbolic link points: renaming onto the link would replace it and leave the file it names as it was.
fs::path resolved(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path target = fs::weakly_canonical(path, error);
  return error ? path : target;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

/// ".<name>.<host>." in front of "<pid>.tmp"; the host, because pids mean nothing on another one.
std::string temporary_prefix(const fs::path& target) {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host = {"localhost"};
  return fmt::format(".{}.{}.", target.filename().string(), host.data());
}
constexpr const char* kTemporarySuffix = ".tmp";

/// Throws IoError if `target` exists and is anything else than a surveymc result that we may replace.
void refuse_foreign_file(const fs::path& path, const fs::path& target) {
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (!fs::exists(status)) return;
  if (fs::is_directory(status)) throw IoError(fmt::format("{}: is a folder; name a file", path.string()));
  if (fs::is_regular_file(status) && access(target.c_str(), W_OK) != 0) {
    throw IoError(fmt::format("{}: exists and cannot be replaced: {}", path.string(), error_text(errno)));
  }
  bool ours = false;
  try {
    ours = reading(target, [](const Reader& reader) { return reader.is_surveymc(); });
  } catch (const IoError&) {
    // not HDF5, or damaged: not recognisable as ours
  }
  if (!ours) {
    throw IoError(
        fmt::format("{}: exists and is not a surveymc result: refusing to overwrite it; choose another name with -o",
                    path.string()));
  }
}

/// Removes what writers of `target` on this host left behind when they were killed.
void remove_stale_temporaries(const fs::path& target) {
  const std::string prefix = temporary_prefix(target);
  const std::string suffix = kTemporarySuffix;
  std::error_code error;
  for (fs::directory_iterator it(folder_of(target), error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with(prefix) || !name.ends_with(suffix) || name.size() <= prefix.size() + suffix.size()) continue;
    const std::string pid = name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
    if (pid.size() > 9 || pid.find_first_not_of("0123456789") != std::string::npos || pid[0] == '0') continue;
    if (kill(std::stoi(pid), 0) != 0 && errno == ESRCH) unlink(it->path().c_str());
  }
}

/// A file under its temporary name until commit(); gone if that is never reached.
class TemporaryFile {
 public:
  /// Throws std::system_error like all of this class.
  explicit TemporaryFile(const fs::path& target)
      : target_(target),
        path_(folder_of(target) / fmt::format("{}{}{}", temporary_prefix(target), getpid(), kTemporarySuffix)) {
    unlink(path_.c_str());  // no living process but this one has our pid, so this is a dead writer's
    file_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0) fail();
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (file_ >= 0) close(file_);
    if (!committed_) unlink(path_.c_str());
  }

  void write(const std::vector<char>& bytes) {
    constexpr std::size_t kMost = std::size_t{1} << 30;  // one write() takes less than 2^31 bytes
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t n = ::write(file_, bytes.data() + done, std::min(bytes.size() - done, kMost));
      if (n < 0 && errno != EINTR) fail();
      if (n > 0) done += static_cast<std::size_t>(n);
    }
  }

  /// Makes it durable and gives it its name. After the rename nothing fails any more but the disk itself.
  void commit() {
    if (fsync(file_) != 0) fail();
    if (close(std::exchange(file_, -1)) != 0) fail();
    if (rename(path_.c_str(), target_.c_str()) != 0) fail();
    committed_ = true;
    const int folder = open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return;  // a folder that we may write but not read: its entry gets to the disk a little later
    const bool failed = fsync(folder) != 0 && errno == EIO;  // other errors: a file system that has no such thing
    close(folder);
    if (failed) throw std::system_error(EIO, std::generic_category());
  }

 private:
  [[noreturn]] static void fail() { throw std::system_error(errno, std::generic_category()); }

  fs::path target_, path_;
  int file_ = -1;
  bool committed_ = false;
};

}  // namespace

std::string input_hash(const Table& table) {
  Hasher h;
  h.add(std::uint64_t{table.columns.size()});
  for (const Column& c : table.columns) h.add(c.name), h.add(c.unit), h.add(c.values);
  return h.hex();
}

std::string content_hash(const Result& result) {
  const Provenance& p = result.provenance;
  Hasher h;
  h.add(std::string("surveymc result 1"));
  h.add(p.title), h.add(p.experiment), h.add(p.config), h.add(p.config_hash), h.add(p.seed), h.add(p.trials);
  h.add(result.tables), h.add(result.samples), h.add(result.maps), h.add(result.inputs);
  return h.hex();
}

void check_output_path(const fs::path& path) {
  if (!path.has_filename()) throw IoError(fmt::format("{}: is a folder; name a file", path.string()));
  const fs::path target = resolved(path);
  const fs::path folder = folder_of(target);
  std::error_code error;
  if (!fs::exists(folder, error)) {
    throw IoError(fmt::format("{}: the folder {} does not exist", path.string(), folder.string()));
  }
  if (!fs::is_directory(folder, error)) {
    throw IoError(fmt::format("{}: {} is not a folder", path.string(), folder.string()));
  }
  const auto fail = [&](int reason) {
    throw IoError(
        fmt::format("{}: cannot write into the folder {}: {}", path.string(), folder.string(), error_text(reason)));
  };
  if (access(folder.c_str(), W_OK | X_OK) != 0) fail(errno);
  refuse_foreign_file(path, target);
  remove_stale_temporaries(target);

  try {
    TemporaryFile(target).write(std::vector<char>(4096));  // only this tells a full disk, a quota, a name too long
  } catch (const std::system_error& e) {
    fail(e.code().value());
  }
}

void write_result(const fs::path& path, const Result& result) {
  check_shape(result);
  if (!path.has_filename()) throw IoError(fmt::format("{}: is a folder; name a file", path.string()));
  const fs::path target = resolved(path);
  refuse_foreign_file(path, target);
  silence_hdf5();
  try {
    const std::string nowhere = fmt::format("{}{}.image", temporary_prefix(target), getpid());
    std::vector<char> image = Writer().file_image(nowhere, result);
    append_seal(image);
    TemporaryFile file(target);
    file.write(image);
    file.commit();
  } catch (const Hdf5Failure& e) {
    throw IoError(fmt::format("{}: cannot be written: {}", path.string(), e.what()));
  } catch (const std::system_error& e) {
    throw IoError(fmt::format("{}: cannot be written: {}", path.string(), e.code().message()));
  }
}

Result read_result(const fs::path& path) {
  return reading(path, [](const Reader& reader) {
    check_format(reader);
    Result result = reader.result();
    if (content_hash(result) != reader.stored_hash()) {
      throw Hdf5Failure("is damaged or was edited: its contents do not match its content_hash");
    }
    return result;
  });
}

std::string stored_content_hash(const fs::path& path) {
  return reading(path, [](const Reader& reader) {
    check_format(reader);
    return reader.stored_hash();
  });
}

}  // namespace surveymc
