#include "store/result_hdf5.h"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "base/error.h"
#include "store/hdf5_handle.h"
#include "store/isolated.h"
#include "store/map_boxes.h"
#include "store/result_file.h"
#include "store/seal.h"
#include "store/stored_form.h"

// The file may be damaged or made by others: types and sizes are checked before memory is filled.

namespace surveymc::store {
namespace {

namespace fs = std::filesystem;

// ---------------------------------------------------------------------------------------------------------------------
// Attributes, links and values. `link` is the object's name in messages.

Handle attribute(hid_t object, const std::string& name) {
  Handle a(H5Aopen(object, name.c_str(), H5P_DEFAULT), "find attribute", name);
  const Handle space(H5Aget_space(a), "read the shape of attribute", name);
  if (H5Sget_simple_extent_npoints(space) != 1) throw Hdf5Failure("attribute " + name + " is not one value");
  return a;
}

std::string text(hid_t object, const std::string& name) {
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

std::string text_or(hid_t object, const std::string& name, const std::string& fallback) {
  return H5Aexists(object, name.c_str()) > 0 ? text(object, name) : fallback;
}

std::int64_t integer(hid_t object, const std::string& name) {
  std::int64_t value = 0;
  checked(H5Aread(attribute(object, name), H5T_NATIVE_INT64, &value), "read attribute", name);
  return value;
}

double number(hid_t object, const std::string& name) {
  double value = 0;
  checked(H5Aread(attribute(object, name), H5T_NATIVE_DOUBLE, &value), "read attribute", name);
  return value;
}

Handle group(hid_t parent, const std::string& link) {
  return Handle(H5Gopen2(parent, link.c_str(), H5P_DEFAULT), "open group", link);
}

/// Throws Hdf5Failure if its values are elsewhere: in another file, or in other datasets.
Handle dataset(hid_t parent, const std::string& link) {
  Handle d(H5Dopen2(parent, link.c_str(), H5P_DEFAULT), "open dataset", link);
  const Handle made(H5Dget_create_plist(d), "read how it was made:", link);
  if (H5Pget_layout(made) == H5D_VIRTUAL || H5Pget_external_count(made) > 0)
    throw Hdf5Failure(link + " has its values elsewhere; they are not read");
  return d;
}

/// Names in a group, in the order in which they were written. Throws Hdf5Failure if one leads elsewhere, as into
/// another file: surveymc writes no such links.
std::vector<std::string> links(hid_t parent) {
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
    H5L_info_t link;
    checked(H5Lget_info(parent, name.c_str(), &link, H5P_DEFAULT), "look at link", name);
    if (link.type != H5L_TYPE_HARD) throw Hdf5Failure("has a link that leads elsewhere: " + name + "; it is not read");
    names.push_back(name);
  }
  return names;
}

H5T_class_t type_class(hid_t d, const std::string& link) {
  return H5Tget_class(Handle(H5Dget_type(d), "read the type of", link));
}

/// Values first .. first + count - 1 of a dataset, the last dimension fastest.
template <class T>
std::vector<T> values(hid_t d, hid_t type, std::size_t first, std::size_t count, const std::string& link) {
  std::vector<T> out(count);
  in_boxes(d, link, first, count, [&](hid_t memory, hid_t space, std::size_t at) {
    checked(H5Dread(d, type, memory, space, H5P_DEFAULT, out.data() + at), "read", link);
  });
  return out;
}

std::vector<std::string> texts(hid_t d, std::size_t first, std::size_t count, const std::string& link) {
  const Handle type(H5Dget_type(d), "read the type of", link);
  if (H5Tis_variable_str(type) <= 0) throw Hdf5Failure(link + " does not hold variable-length strings");
  if (count == 0) return {};
  std::vector<char*> pointers = values<char*>(d, type, first, count, link);
  std::vector<std::string> out;
  out.reserve(count);
  for (const char* p : pointers) out.emplace_back(p ? p : "");
  const hsize_t length = count;
  const Handle memory(H5Screate_simple(1, &length, nullptr), "make a dataspace");
  H5Dvlen_reclaim(type, memory, H5P_DEFAULT, pointers.data());
  return out;
}

std::vector<double> numbers(hid_t d, std::size_t first, std::size_t count, const std::string& link) {
  return values<double>(d, H5T_NATIVE_DOUBLE, first, count, link);
}

/// Values first .. first + count - 1 of a column.
Values column_values(hid_t d, H5T_class_t type, std::size_t first, std::size_t count, const std::string& link) {
  if (type == H5T_FLOAT) return numbers(d, first, count, link);
  if (type == H5T_INTEGER) return values<std::int64_t>(d, H5T_NATIVE_INT64, first, count, link);
  if (type == H5T_STRING) return texts(d, first, count, link);
  throw Hdf5Failure(link + " holds neither numbers nor text");
}

/// The dimension scale of one dimension of a map.
Handle scale(hid_t map, unsigned dimension, const std::string& map_name) {
  hid_t id = -1;
  const auto take_first = [](hid_t, unsigned, hid_t scale_id, void* out) -> herr_t {
    H5Iinc_ref(scale_id);  // the iteration closes its own reference
    *static_cast<hid_t*>(out) = scale_id;
    return 1;
  };
  checked(H5DSiterate_scales(map, dimension, nullptr, take_first, &id), "read the axes of", map_name);
  if (id < 0) throw Hdf5Failure("map " + map_name + " lacks an axis");
  return Handle(id, "open an axis of", map_name);
}

// ---------------------------------------------------------------------------------------------------------------------
// The result

class Reader {
 public:
  /// Throws Hdf5Failure if the file is not HDF5, or not whole.
  Reader(const fs::path& path, Seal seal)
      : path_(path),
        file_size_(fs::file_size(path)),
        open_file_(std::make_shared<Handle>(open(path, seal))),
        file_(*open_file_) {}

  bool is_surveymc() const { return H5Aexists(file_, "format") > 0 && text(file_, "format") == kFormat; }

  void check_format() const {
    if (!is_surveymc()) throw Hdf5Failure("is an HDF5 file, but not a surveymc result");
    const std::int64_t version = integer(file_, "format_version");
    if (version == kFormatVersion) return;
    throw Hdf5Failure(
        fmt::format("has result format version {}; this program knows version {}", version, kFormatVersion));
  }

  std::string stored_hash() const { return text(file_, "content_hash"); }

  Result result() const {
    links(file_);
    Result r;
    r.provenance = provenance();
    r.run = run();
    r.cost = cost();
    r.tables = tables("tables");
    r.samples = tables("samples");
    for (Map& m : maps()) {
      if (m.values.empty() && map_size(m) > 0)
        r.streams.push_back(stream_of(std::move(m)));
      else
        r.maps.push_back(std::move(m));
    }
    r.inputs = inputs();
    return r;
  }

 private:
  static Handle open(const fs::path& path, Seal seal) {
    Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, file_access()), "read it as an HDF5 file");
    haddr_t end = 0;  // of what HDF5 has written: behind it stands a seal or nothing
    checked(H5Fget_eoa(file, &end), "find the end of the file");
    if (seal == Seal::none && fs::file_size(path) > end) throw Hdf5Failure("is damaged: its checksum is not whole");
    return file;
  }

  /// A function that reads a part of a dataset after this reader is gone; it holds the file open.
  template <class Read>
  auto later(const std::string& name, const Read& read) const {
    return [file = open_file_, path = path_.string(), name, read](std::size_t first, std::size_t count) {
      try {
        return read(dataset(*file, name), first, count, name);
      } catch (const Hdf5Failure& e) {
        throw IoError(fmt::format("{}: {}", path, e.what()));
      }
    };
  }

  Provenance provenance() const {
    Provenance p;
    p.title = text(file_, "title");
    p.experiment = text(file_, "experiment");
    p.surveymc_version = text(file_, "surveymc_version");
    p.git_revision = text(file_, "git_revision");
    p.config = text(file_, "config");
    p.config_hash = text(file_, "config_hash");
    p.command = text(file_, "command");
    p.seed = static_cast<std::uint64_t>(integer(file_, "seed"));
    p.trials = static_cast<std::uint64_t>(integer(file_, "trials"));
    p.compiler = text(file_, "compiler");
    return p;
  }

  RunInfo run() const {
    const Handle g = group(file_, "run");
    return {text(g, "created"), text(g, "host"), number(g, "elapsed_s"), integer(g, "threads"), integer(g, "ranks")};
  }

  Table cost() const {
    const Handle g = group(file_, "run");
    for (const std::string& link : links(g))
      if (link == kCost) return table(group(g, link), link);
    return {};
  }

  std::vector<Table> tables(const std::string& parent) const {
    const Handle all = group(file_, parent);
    std::vector<Table> out;
    for (const std::string& link : links(all)) out.push_back(table(group(all, link), link, "/" + parent + "/" + link));
    return out;
  }

  std::vector<Map> maps() const {
    const Handle all = group(file_, "maps");
    std::vector<Map> out;
    for (const std::string& link : links(all)) {
      const Handle d = dataset(all, link);
      if (H5DSis_scale(d) <= 0) out.push_back(map(d, link));
    }
    return out;
  }

  std::vector<InputData> inputs() const {
    const Handle all = group(file_, "inputs");
    std::vector<InputData> out;
    for (const std::string& link : links(all)) {
      const Handle g = group(all, link);
      out.push_back({text(g, "path"), text(g, "hash"), table(g, link)});
    }
    return out;
  }

  /// With a path in the file, long columns stay on the disk.
  Table table(hid_t g, const std::string& name, const std::string& path = "") const {
    Table t{name, text_or(g, "long_name", "")};
    for (const std::string& link : links(g)) {
      if (link == kRow) continue;
      t.columns.push_back(column(g, link, path));
      if (t.columns.back().size() != t.rows()) throw Hdf5Failure("columns of " + name + " differ in length");
    }
    return t;
  }

  Column column(hid_t g, const std::string& link, const std::string& path) const {
    const Handle d = dataset(g, link);
    Column c{text_or(d, kOriginalName, link),
             text_or(d, "units", ""),
             text_or(d, "long_name", ""),
             {},
             text_or(d, "ancillary_variables", "")};
    const std::size_t count = length(d, link);
    const H5T_class_t type = type_class(d, link);
    const bool stays = !path.empty() && count > kMostHeldRows;
    if (stays)
      c.on_disk = std::make_shared<MadeValues>(
          count, later(path + "/" + link, [type](hid_t later_d, std::size_t first, std::size_t n, const auto& name) {
            return column_values(later_d, type, first, n, name);
          }));
    c.values = column_values(d, type, 0, stays ? 0 : count, link);
    return c;
  }

  Map map(hid_t d, const std::string& link) const {
    Map m{link, text_or(d, "units", ""), text_or(d, "long_name", ""), {}, {}};
    const std::vector<hsize_t> dims = shape(d, link);
    std::size_t count = 1;
    for (std::size_t i = 0; i < dims.size(); ++i) {
      m.axes.push_back(axis(scale(d, static_cast<unsigned>(i), link), link));
      if (axis_size(m.axes.back()) != dims[i]) {
        throw Hdf5Failure("map " + link + " does not have the length of its axis " + m.axes.back().name);
      }
      count *= dims[i];
    }
    if (count <= kMostHeldValues) m.values = numbers(d, 0, count, link);
    return m;
  }

  /// A map that is read in pieces.
  MapStream stream_of(Map m) const {
    const auto read = later("/maps/" + m.name, [](hid_t d, std::size_t first, std::size_t n, const auto& name) {
      return std::vector<std::vector<double>>{numbers(d, first, n, name)};
    });
    return {{std::move(m)}, read};
  }

  Axis axis(hid_t d, const std::string& map_name) const {
    const auto name_length = checked(H5DSget_scale_name(d, nullptr, 0), "read the name of an axis of", map_name);
    std::string link(static_cast<std::size_t>(name_length) + 1, '\0');
    checked(H5DSget_scale_name(d, link.data(), link.size()), "read the name of an axis of", map_name);
    link.pop_back();
    Axis a{text_or(d, kOriginalName, link.data()), text_or(d, "units", ""), text_or(d, "long_name", ""), {}};
    const std::size_t count = length(d, a.name);
    if (type_class(d, a.name) == H5T_STRING)
      a.values = texts(d, 0, count, a.name);
    else
      a.values = numbers(d, 0, count, a.name);
    return a;
  }

  std::size_t length(hid_t d, const std::string& link) const {
    const std::vector<hsize_t> dims = shape(d, link);
    if (dims.size() != 1) throw Hdf5Failure(link + " is not one-dimensional");
    return dims[0];
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

  fs::path path_;
  std::uintmax_t file_size_;
  std::shared_ptr<Handle> open_file_;  // streams of the result share it
  hid_t file_;
};

/// Runs `read` on the open file; every failure becomes IoError with the path. HDF5 follows what a file says, to a crash
/// or without end, and a seal can be made by anyone: a child process looks first. In it `look` does for a file that has
/// its seal, and so does all of `read` for another one.
template <class Read, class Look>
auto reading(const fs::path& path, const Read& read, const Look& look, bool is_checked = true) {
  silence_hdf5();
  try {
    std::error_code error;
    if (fs::is_directory(path, error)) throw Hdf5Failure("is a folder");
    if (access(path.c_str(), R_OK) != 0) throw Hdf5Failure(std::generic_category().message(errno));
    if (!fs::is_regular_file(path, error)) throw Hdf5Failure("is not a regular file");
    const Seal seal = is_checked ? seal_state(path) : Seal::unknown;
    if (seal == Seal::wrong) throw Hdf5Failure("is damaged or was edited: its checksum does not match");
    const std::string harm = harm_in_child(fs::file_size(path), [&] {
      const Reader reader(path, seal);
      if (seal == Seal::right)
        look(reader);
      else
        read(reader);
    });
    if (!harm.empty()) throw Hdf5Failure(harm);
    return read(Reader(path, seal));
  } catch (const Hdf5Failure& e) {
    throw IoError(fmt::format("{}: {}", path.string(), e.what()));
  } catch (const std::system_error& e) {
    throw IoError(fmt::format("{}: {}", path.string(), e.code().message()));
  } catch (const std::bad_alloc&) {
    throw IoError(fmt::format("{}: too large for the memory, or damaged", path.string()));
  }
}

}  // namespace

ResultFileState result_file_state(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  std::string head(kHdf5Signature.size(), '\0');
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in || (!in.read(head.data(), static_cast<std::streamsize>(head.size())) && !in.eof()))
    return {ResultFile::unreadable, std::generic_category().message(errno != 0 ? errno : EIO)};
  if (head != kHdf5Signature) return {};
  try {
    const auto read = [](const Reader& reader) { return reader.is_surveymc(); };
    return {reading(path, read, read) ? ResultFile::yes : ResultFile::other};
  } catch (const IoError& e) {
    return {ResultFile::unreadable, std::string(e.what()).substr(path.string().size() + 2)};
  }
}

namespace {

Result stored_result(const Reader& reader) {
  reader.check_format();
  return reader.result();
}

Result checked_result(const Reader& reader) {
  Result result = stored_result(reader);
  if (content_hash(result) != reader.stored_hash()) {
    throw Hdf5Failure("is damaged or was edited: its contents do not match its content_hash");
  }
  return result;
}

}  // namespace

Result read_result(const fs::path& path) { return reading(path, checked_result, stored_result); }

Result read_unchecked_result(const fs::path& path) { return reading(path, stored_result, stored_result, false); }

std::string stored_content_hash(const fs::path& path) {
  const auto read = [](const Reader& reader) {
    reader.check_format();
    return reader.stored_hash();
  };
  return reading(path, read, read);
}

}  // namespace surveymc::store
