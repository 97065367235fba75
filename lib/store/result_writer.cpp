#include "store/result_hdf5.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "store/content_hash.h"
#include "store/hdf5_handle.h"
#include "store/map_boxes.h"
#include "store/row_spool.h"
#include "store/stored_form.h"

namespace surveymc::store {
namespace {

/// Variable-length UTF-8.
Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), "make a type");
  checked(H5Tset_size(type, H5T_VARIABLE), "make a type");
  checked(H5Tset_cset(type, H5T_CSET_UTF8), "make a type");
  return type;
}

/// Properties with which files, groups and datasets are made: links and attributes keep their order. Times are not
/// stored, because then no two files would have the same bytes.
Handle creation_properties(hid_t list_class) {
  constexpr unsigned kOrder = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
  Handle properties(H5Pcreate(list_class), "make a property list");
  const bool has_links = list_class != H5P_DATASET_CREATE;
  if (has_links) checked(H5Pset_link_creation_order(properties, kOrder), "track link order");
  checked(H5Pset_attr_creation_order(properties, kOrder), "track attribute order");
  checked(H5Pset_obj_track_times(properties, false), "turn times off");
  return properties;
}

/// Places in a node of the index of chunks, half of them at least in use; HDF5 makes nodes of 2 kB otherwise, most of
/// them of one chunk.
constexpr unsigned kChunksOfNode = 4;

/// An empty file with these properties of access.
Handle new_file(const std::filesystem::path& path, const Handle& access) {
  // HDF5 1.8 and later can read it
  checked(H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18), "select the format");
  const Handle made_with = creation_properties(H5P_FILE_CREATE);
  checked(H5Pset_istore_k(made_with, kChunksOfNode), "select the size of the index of chunks");
  return Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, made_with, access), "start the file");
}

/// Values in a chunk at most: 512 kB, of which HDF5 holds two of a dataset.
constexpr std::size_t kChunkValues = std::size_t{1} << 16;
/// Of smaller datasets deflate would save less than a reader's time.
constexpr hsize_t kLeastCompressed = 1024;

/// Of a dataset of these lengths in row-major order: as many whole trailing dimensions as there is room for. Values
/// come in this order, so that a chunk is compressed once, while it is in HDF5's cache of 1 MB.
std::vector<hsize_t> chunk_of(const std::vector<hsize_t>& dims) {
  hsize_t room = kChunkValues;
  std::vector<hsize_t> chunk(dims.size(), 1);
  for (std::size_t i = dims.size(); i-- > 0 && room > 1; room /= chunk[i]) {
    const hsize_t pieces = (dims[i] + room - 1) / room;
    chunk[i] = (dims[i] + pieces - 1) / pieces;  // equally long: HDF5 stores the last one whole
  }
  return chunk;
}

/// Texts in a chunk. Longer columns are in chunks; pieces that come (kPieceRows) are whole ones.
constexpr std::size_t kTextChunk = 1024;
static_assert(kPieceRows % kTextChunk == 0);

/// What HDF5 has in the place of a text: where its letters are in the file.
using Reference = std::array<char, 16>;

/// Properties of a transfer of texts. By default HDF5 clears a megabyte for each.
Handle text_transfer() {
  Handle transfer(H5Pcreate(H5P_DATASET_XFER), "make a property list");
  checked(H5Pset_buffer(transfer, std::size_t{1} << 14, nullptr, nullptr), "set a buffer");
  return transfer;
}

class Writer {
 public:
  Writer(int compression, const Written& written) : compression_(compression), written_(written) {
    if (compression > 0 && H5Zfilter_avail(H5Z_FILTER_DEFLATE) <= 0)
      throw Hdf5Failure("cannot be compressed: the HDF5 library has no deflate");
  }

  void write(hid_t file, const Result& result) {
    Hasher hash;  // of what is written, while it is written
    add_head(hash, result.provenance);
    write_tables(file, "tables", result.tables, hash);
    const MapHashes maps = write_maps(file, map_streams(result));
    write_tables(file, "samples", result.samples, hash);
    add(hash, maps);
    write_inputs(file, result.inputs, hash);
    write_run(file, result.run, result.cost);
    write_provenance(file, result.provenance, hash.hex());
    checked(H5Fflush(file, H5F_SCOPE_GLOBAL), "flush");
  }

 private:
  using Dims = std::vector<hsize_t>;

  void attribute(hid_t object, const char* name, const std::string& value) {
    const std::string canonical = canonical_text(value);
    const char* pointer = canonical.c_str();
    attribute(object, name, text_, &pointer);
  }
  void attribute(hid_t object, const char* name, std::int64_t value) {
    attribute(object, name, H5T_NATIVE_INT64, &value);
  }
  void attribute(hid_t object, const char* name, double value) { attribute(object, name, H5T_NATIVE_DOUBLE, &value); }
  void attribute(hid_t object, const char* name, hid_t type, const void* value) {
    const Handle space(H5Screate(H5S_SCALAR), "make a dataspace");
    const Handle a(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), "create attribute", name);
    checked(H5Awrite(a, type, value), "write attribute", name);
  }

  Handle group(hid_t parent, const std::string& link) {
    return Handle(H5Gcreate2(parent, link.c_str(), H5P_DEFAULT, group_properties_, H5P_DEFAULT), "create group", link);
  }

  hid_t type_of(double) const { return H5T_NATIVE_DOUBLE; }
  hid_t type_of(std::int64_t) const { return H5T_NATIVE_INT64; }
  hid_t type_of(const std::string&) const { return text_; }
  template <class... T>
  hid_t type_of(const std::variant<std::vector<T>...>& values) const {
    return std::visit([&](const auto& v) { return type_of(typename std::decay_t<decltype(v)>::value_type()); }, values);
  }

  /// Writes values `first` and following, in row-major order, as they are stored.
  template <class T>
  void put(hid_t d, const std::string& link, hsize_t first, std::span<const T> values) {
    if constexpr (std::is_same_v<T, std::string>)
      put_texts(d, link, first, values);
    else
      put_boxes(d, link, first, values);
    bytes_ += values.size() * (std::is_same_v<T, std::string> ? sizeof(Reference) : sizeof(T));
    if (written_) written_(bytes_);
  }

  template <class T>
  void put_boxes(hid_t d, const std::string& link, hsize_t first, std::span<const T> values) {
    const hid_t type = std::is_same_v<T, const char*> ? static_cast<hid_t>(text_) : type_of(values[0]);
    in_boxes(d, link, first, values.size(), [&](hid_t memory, hid_t space, std::size_t at) {
      checked(H5Dwrite(d, type, memory, space, text_transfer_, &values[at]), "write", link);
    });
  }

  void put_texts(hid_t d, const std::string& link, hsize_t first, std::span<const std::string> values) {
    for (std::size_t n = 0; !values.empty(); values = values.subspan(n), first += n) {
      n = std::min(values.size(), kTextChunk);
      const bool is_chunk = n == kTextChunk && first % kTextChunk == 0;
      if (!is_chunk || !put_shared(d, link, first, values.first(n))) put_each(d, link, first, values.first(n));
    }
  }

  void put_each(hid_t d, const std::string& link, hsize_t first, std::span<const std::string> values) {
    std::deque<std::string> changed;
    std::vector<const char*> pointers;
    for (const std::string& s : values)
      pointers.push_back(is_canonical(s) ? s.c_str() : changed.emplace_back(canonical_text(s)).c_str());
    put_boxes(d, link, first, std::span<const char* const>(pointers));
  }

  /// Writes a whole chunk of texts, many of which are equal. HDF5 would store every one again, and spend a good part of
  /// the time of all writing on that. Here it stores each text once, and its reference is written for all that are
  /// equal. Returns false, and writes nothing, if too many of them are new.
  bool put_shared(hid_t d, const std::string& link, hsize_t first, std::span<const std::string> values) {
    constexpr std::size_t kMostKnown = std::size_t{1} << 16;  // some MB
    if (known_.size() > kMostKnown) known_.clear();
    std::vector<std::string> fresh;
    std::vector<Reference*> of_values, of_fresh;
    for (const std::string& text : values) {
      const auto [known, is_new] = known_.try_emplace(text);
      of_values.push_back(&known->second);
      if (is_new) fresh.push_back(text), of_fresh.push_back(&known->second);
    }
    if (fresh.size() > values.size() / 8) {
      known_.clear();
      return false;
    }
    std::vector<Reference> chunk(values.size());
    if (!fresh.empty()) {
      put_each(d, link, first, fresh);
      std::uint32_t skipped_filters = 0;
      checked(H5Dread_chunk(d, H5P_DEFAULT, &first, &skipped_filters, chunk.data()), "read back", link);
      for (std::size_t i = 0; i < fresh.size(); ++i) *of_fresh[i] = chunk[i];
    }
    for (std::size_t i = 0; i < chunk.size(); ++i) chunk[i] = *of_values[i];
    checked(H5Dwrite_chunk(d, H5P_DEFAULT, 0, &first, chunk.size() * sizeof(Reference), chunk.data()), "write", link);
    return true;
  }

  /// A dataset without values, which says what it is. Numbers are in chunks with a Fletcher32 checksum each. HDF5
  /// filters no texts, which are elsewhere, and no dataset without dimensions or values. Quantity: Column, Axis or Map.
  template <class Quantity>
  Handle dataset(hid_t parent, const std::string& link, const Dims& dims, hid_t type, const Quantity& q) {
    const Handle space(
        dims.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
        "make a dataspace for", link);
    const Handle properties = creation_properties(H5P_DATASET_CREATE);
    const hsize_t size = std::accumulate(dims.begin(), dims.end(), hsize_t{!dims.empty()}, std::multiplies<>());
    const bool is_text = type == text_;
    if (size >= (is_text ? kTextChunk : 1)) {
      const Dims chunk = is_text ? Dims{kTextChunk} : chunk_of(dims);
      checked(H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data()), "set the chunks of", link);
    }
    if (!is_text && size > 0) {
      checked(H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER), "leave out fill values of", link);
      if (compression_ > 0 && size >= kLeastCompressed) {
        checked(H5Pset_shuffle(properties), "shuffle", link);
        checked(H5Pset_deflate(properties, static_cast<unsigned>(compression_)), "compress", link);
      }
      checked(H5Pset_fletcher32(properties), "add checksums to", link);
    }
    Handle d(H5Dcreate2(parent, link.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), "create dataset",
             link);
    if (!q.unit.empty()) attribute(d, "units", q.unit);  // none for a label: `units` of "" would call it a pure number
    attribute(d, "long_name", q.long_name);
    if (link != canonical_text(q.name)) attribute(d, kOriginalName, q.name);
    return d;
  }

  /// A column and its share of the hash.
  Handle column(hid_t parent, const std::string& link, const Column& c, Hasher* hash) {
    if (hash) add_head(*hash, c);
    Handle d = dataset(parent, link, {c.size()}, type_of(c.values), c);
    hsize_t at = 0;
    for_each_stored(c, [&](const auto& values) {
      if (hash) hash->add_values(values);
      put(d, link, at, values);
      at += values.size();
    });
    return d;
  }

  void write_provenance(hid_t file, const Provenance& p, const std::string& content_hash) {
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
    attribute(file, "content_hash", content_hash);
  }

  void write_run(hid_t file, const RunInfo& run, const Table& cost) {
    const Handle g = group(file, "run");
    attribute(g, "created", run.created);
    attribute(g, "host", run.host);
    attribute(g, "elapsed_s", run.elapsed_s);
    attribute(g, "threads", run.threads);
    attribute(g, "ranks", run.ranks);
    if (!cost.columns.empty()) write_columns(group(g, kCost), cost, nullptr);
  }

  void write_columns(hid_t g, const Table& table, Hasher* hash) {
    attribute(g, "long_name", table.long_name);
    Column row_numbers{kRow, "1", "row number, from 0", std::vector<std::int64_t>{}};
    row_numbers.on_disk = std::make_shared<MadeValues>(table.rows(), [](std::size_t first, std::size_t count) {
      std::vector<std::int64_t> numbers(count);
      std::iota(numbers.begin(), numbers.end(), static_cast<std::int64_t>(first));
      return numbers;
    });
    const Handle row = column(g, kRow, row_numbers, nullptr);
    checked(H5DSset_scale(row, kRow), "make the dimension scale of", table.name);

    std::set<std::string> taken = {kRow};
    for (const Column& c : table.columns) {
      const std::string link = link_name(c.name, taken);
      const Handle d = column(g, link, c, hash);
      if (!c.ancillary.empty()) attribute(d, "ancillary_variables", c.ancillary);
      checked(H5DSattach_scale(d, row, 0), "attach the dimension scale to", link);
    }
  }

  void write_tables(hid_t file, const char* parent, const std::vector<Table>& tables, Hasher& hash) {
    const Handle all = group(file, parent);
    hash.add(std::uint64_t{tables.size()});
    for (const Table& t : tables) {
      add_head(hash, t);
      write_columns(group(all, t.name), t, &hash);
    }
  }

  void write_inputs(hid_t file, const std::vector<InputData>& inputs, Hasher& hash) {
    const Handle all = group(file, "inputs");
    hash.add(std::uint64_t{inputs.size()});
    std::set<std::string> taken;
    for (const InputData& input : inputs) {
      const Handle g = group(all, input_group_name(input.path, taken));
      attribute(g, "path", input.path);
      attribute(g, "hash", input.hash);
      add_head(hash, input);
      write_columns(g, input.table, &hash);
    }
  }

  /// All maps are in one group, so that one xr.open_dataset() has them. Maps share an axis that is the same in name,
  /// unit and values; another axis of that name gets a number behind it.
  MapHashes write_maps(hid_t file, const std::vector<MapStream>& streams) {
    const Handle all = group(file, "maps");
    Axes axes;
    for (const MapStream& s : streams)
      for (const Map& m : s.maps) axes.taken.insert(m.name);
    MapHashes hashes;
    for (const MapStream& s : streams) {
      std::vector<Handle> datasets;
      for (const Map& m : s.maps) {
        const std::vector<std::size_t> used = axes_of(all, m, axes);
        Dims dims;
        for (const Axis& a : m.axes) dims.push_back(axis_size(a));
        const Handle& d = datasets.emplace_back(dataset(all, m.name, dims, H5T_NATIVE_DOUBLE, m));
        for (std::size_t i = 0; i < used.size(); ++i)
          checked(H5DSattach_scale(d, axes.scales[used[i]].second, static_cast<unsigned>(i)),
                  "attach a dimension scale to", m.name);
      }
      hash_maps(s, hashes, [&](std::size_t map, std::size_t first, std::span<const double> values) {
        put(datasets[map], s.maps[map].name, first, values);
      });
    }
    return hashes;
  }

  struct Axes {
    std::set<std::string> taken;
    std::vector<std::pair<std::string, Handle>> scales;  // axis_hash(), dimension scale
  };

  /// Numbers of the dimension scales of a map; makes those that are not there yet.
  std::vector<std::size_t> axes_of(hid_t all, const Map& m, Axes& axes) {
    std::vector<std::size_t> used;  // netCDF readers want no dimension twice in a variable
    for (const Axis& a : m.axes) {
      const std::string hash = axis_hash(a);
      std::size_t i = 0;
      while (i < axes.scales.size() && (axes.scales[i].first != hash || std::count(used.begin(), used.end(), i) > 0)) {
        ++i;
      }
      if (i == axes.scales.size()) {
        const std::string link = link_name(a.name, axes.taken);
        Handle d = dataset(all, link, {axis_size(a)}, type_of(a.values), a);
        hsize_t at = 0;
        const auto write = [&](const auto& values) {
          put(d, link, at, values);
          at += values.size();
        };
        std::visit([&](const auto& values) { for_each_stored(values, write); }, a.values);
        checked(H5DSset_scale(d, link.c_str()), "make the dimension scale", link);
        axes.scales.emplace_back(hash, std::move(d));
      }
      used.push_back(i);
    }
    return used;
  }

  const int compression_;
  const Written& written_;
  std::uint64_t bytes_ = 0;
  std::unordered_map<std::string, Reference> known_;  // texts that are in the file
  const Handle text_ = text_type();
  const Handle text_transfer_ = text_transfer();
  const Handle group_properties_ = creation_properties(H5P_GROUP_CREATE);
};

}  // namespace

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
  for (const Map& m : result.maps)
    demand(map_size(m) == m.values.size(), "map " + m.name + " is not the product of its axes");
  std::set<std::string> taken;
  for (const MapStream& s : map_streams(result))
    for (const Map& m : s.maps) {
      demand_name(m.name, taken);
      demand(map_size(m) == map_size(s.maps.front()), "maps of one stream differ in size: " + m.name);
    }
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  demand(result.provenance.seed <= kMax && result.provenance.trials <= kMax, "seed or trials above 2^63 - 1");
}

namespace {

/// Calls write(), which closes all that it opens; throws Hdf5Failure if something could not be closed.
void closing(const std::function<void()>& write) {
  silence_hdf5();
  close_fault().clear();
  write();
  if (!close_fault().empty()) throw Hdf5Failure(close_fault());
}

}  // namespace

void write_hdf5(const std::filesystem::path& path, const Result& result, int compression, const Written& written) {
  closing([&] { Writer(compression, written).write(new_file(path, file_access()), result); });
}

std::string hdf5_bytes(const Result& result, int compression, const Written& written) {
  constexpr std::size_t kIncrement = std::size_t{1} << 20;
  std::string bytes;
  closing([&] {
    const Handle access = file_access();
    checked(H5Pset_fapl_core(access, kIncrement, false), "make a file in memory");
    const Handle file = new_file("in memory", access);
    Writer(compression, written).write(file, result);
    bytes.resize(static_cast<std::size_t>(checked(H5Fget_file_image(file, nullptr, 0), "find the size of the file")));
    checked(H5Fget_file_image(file, bytes.data(), bytes.size()), "read the file in memory");
  });
  return bytes;
}

}  // namespace surveymc::store
