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

/// A column of as many texts is in chunks, of so many at most: of pieces that come (kPieceRows) whole ones.
constexpr std::size_t kManyTexts = 1024, kTextChunk = 4096;
static_assert(kPieceRows % kTextChunk == 0);

/// What HDF5 has in the place of a text: where its letters are in the file.
using Reference = std::array<char, 16>;

/// Calls use(pointers) with texts as HDF5 takes them.
void in_stored_texts(std::span<const std::string> values, const std::function<void(const void*)>& use) {
  std::deque<std::string> changed;
  std::vector<const char*> pointers;
  pointers.reserve(values.size());
  for (const std::string& s : values)
    pointers.push_back(is_canonical(s) ? s.c_str() : changed.emplace_back(canonical_text(s)).c_str());
  use(pointers.data());
}

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
    ContentHash hash(result.provenance);  // of what is written, while it is written
    MapHashes maps = held_map_hashes(result.maps);
    write_tables(file, "tables", result.tables, hash);
    write_maps(file, result.maps, result.streams, maps);
    write_tables(file, "samples", result.samples, hash);
    hash.add(maps);
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

  hid_t type_of(const std::vector<double>&) const { return H5T_NATIVE_DOUBLE; }
  hid_t type_of(const std::vector<std::int64_t>&) const { return H5T_NATIVE_INT64; }
  hid_t type_of(const std::vector<std::string>&) const { return text_; }

  /// Calls use(memory, space, offset) for values first .. first + count - 1 of a dataset, in row-major order: for each
  /// box of them, which begins at `offset` in the list.
  template <class Use>
  void in_boxes(hid_t d, const std::string& link, hsize_t first, hsize_t count, const Use& use) {
    const Handle space(H5Dget_space(d), "read the shape of", link);
    Dims dims(static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space), "read the shape of", link)));
    if (dims.empty()) return use(H5S_ALL, H5S_ALL, 0);
    checked(H5Sget_simple_extent_dims(space, dims.data(), nullptr), "read the shape of", link);
    for (const Box& box : boxes_in(dims, first, count)) {
      const Handle memory(H5Screate_simple(static_cast<int>(box.count.size()), box.count.data(), nullptr),
                          "make a dataspace");
      checked(H5Sselect_hyperslab(space, H5S_SELECT_SET, box.start.data(), nullptr, box.count.data(), nullptr),
              "select a part of", link);
      use(memory, space, static_cast<std::size_t>(box.first - first));
    }
  }
  void write_boxes(hid_t d, const std::string& link, hsize_t first, hid_t type, const char* values, std::size_t count,
                   std::size_t size) {
    in_boxes(d, link, first, count, [&](hid_t memory, hid_t space, std::size_t at) {
      checked(H5Dwrite(d, type, memory, space, text_transfer_, values + at * size), "write", link);
    });
  }
  void put(hid_t d, const std::string& link, hsize_t first, hid_t type, const void* values, std::size_t count,
           std::size_t size) {
    write_boxes(d, link, first, type, static_cast<const char*>(values), count, size);
    bytes_ += count * size;
    if (written_) written_(bytes_);
  }

  /// Writes values `first` and following, in row-major order. Calls show(piece) for all of them, as they are stored,
  /// just before.
  template <class Show>
  void put(hid_t d, const std::string& link, hsize_t first, const std::vector<double>& values, const Show& show) {
    in_canonical_pieces(values, [&](std::span<const double> piece) {
      show(piece);
      put(d, link, first, H5T_NATIVE_DOUBLE, piece.data(), piece.size(), sizeof(double));
      first += piece.size();
    });
  }
  template <class Show>
  void put(hid_t d, const std::string& link, hsize_t first, const std::vector<std::int64_t>& values, const Show& show) {
    if (values.empty()) return;
    show(std::span(values));
    put(d, link, first, H5T_NATIVE_INT64, values.data(), values.size(), sizeof values[0]);
  }
  template <class Show>
  void put(hid_t d, const std::string& link, hsize_t first, const std::vector<std::string>& values, const Show& show) {
    if (values.empty()) return;
    show(std::span(values));
    const hsize_t chunk = text_chunk(d, link), end = first + values.size();
    while (first < end) {
      const hsize_t next = chunk == 0 ? end : std::min(end, (first / chunk + 1) * chunk);
      const std::span some(values.data() + (values.size() - (end - first)), next - first);
      const bool is_whole = some.size() == chunk;
      if (!is_whole || !put_shared(d, link, first, some)) put_each(d, link, first, some);
      bytes_ += some.size() * sizeof(Reference);
      first = next;
    }
    if (written_) written_(bytes_);
  }

  /// How many texts are in a chunk of a list; 0 if it has none.
  static hsize_t text_chunk(hid_t d, const std::string& link) {
    const Handle made(H5Dget_create_plist(d), "read how it was made:", link);
    hsize_t chunk = 0;
    if (H5Pget_layout(made) == H5D_CHUNKED) checked(H5Pget_chunk(made, 1, &chunk), "read the chunks of", link);
    return chunk;
  }

  void put_each(hid_t d, const std::string& link, hsize_t first, std::span<const std::string> values) {
    constexpr std::size_t kTogether = std::size_t{1} << 15;
    for (std::size_t at = 0; at < values.size(); at += kTogether) {
      const auto some = values.subspan(at, std::min(kTogether, values.size() - at));
      in_stored_texts(some, [&](const void* stored) {
        write_boxes(d, link, first + at, text_, static_cast<const char*>(stored), some.size(), sizeof(const char*));
      });
    }
  }

  /// Writes a whole chunk of texts, many of which are equal. HDF5 would store every one again, and spend a good part of
  /// the time of all writing on that. Here it stores each text once, and its reference is written for all that are
  /// equal. Returns false, and writes nothing, if too many of them are new.
  bool put_shared(hid_t d, const std::string& link, hsize_t first, std::span<const std::string> values) {
    constexpr std::size_t kMostKnown = std::size_t{1} << 16;  // some MB
    if (references_.size() > kMostKnown) forget_texts();
    std::vector<std::size_t> codes;
    std::vector<std::string> fresh;
    codes.reserve(values.size());
    for (const std::string& text : values) {
      const auto [known, is_new] = known_.try_emplace(text, references_.size() + fresh.size());
      codes.push_back(known->second);
      if (is_new) fresh.push_back(text);
      if (fresh.size() > values.size() / 8) {
        forget_texts();
        return false;
      }
    }
    std::vector<Reference> chunk(values.size());
    if (!fresh.empty()) {
      put_each(d, link, first, fresh);
      std::uint32_t skipped_filters = 0;
      checked(H5Dread_chunk(d, H5P_DEFAULT, &first, &skipped_filters, chunk.data()), "read back", link);
      references_.insert(references_.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(fresh.size()));
    }
    for (std::size_t i = 0; i < codes.size(); ++i) chunk[i] = references_[codes[i]];
    checked(H5Dwrite_chunk(d, H5P_DEFAULT, 0, &first, chunk.size() * sizeof(Reference), chunk.data()), "write", link);
    return true;
  }

  void forget_texts() {
    known_.clear();
    references_.clear();
  }

  template <class... V>
  Handle dataset(hid_t parent, const std::string& link, const Dims& dims, const std::variant<V...>& values) {
    return std::visit([&](const auto& v) { return dataset(parent, link, dims, v); }, values);
  }
  template <class T>
  Handle dataset(hid_t parent, const std::string& link, const Dims& dims, const std::vector<T>& values) {
    Handle d = empty_dataset(parent, link, dims, type_of(values));
    put(d, link, 0, values, [](const auto&) {});
    return d;
  }
  /// Numbers are in chunks with a Fletcher32 checksum each. HDF5 filters no texts, which are elsewhere, and no dataset
  /// without dimensions or values.
  Handle empty_dataset(hid_t parent, const std::string& link, const Dims& dims, hid_t type) {
    const Handle space(
        dims.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
        "make a dataspace for", link);
    const Handle properties = creation_properties(H5P_DATASET_CREATE);
    hsize_t size = dims.empty() ? 0 : 1;
    for (const hsize_t d : dims) size *= d;
    const bool is_text = type == text_;
    if (size >= (is_text ? kManyTexts : 1)) {
      const Dims chunk = is_text ? Dims{std::min<hsize_t>(size, kTextChunk)} : chunk_of(dims);
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
    return Handle(H5Dcreate2(parent, link.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), "create dataset",
                  link);
  }

  /// A column, in pieces if it is not held, and its share of the hash.
  Handle column_dataset(hid_t parent, const std::string& link, const Column& c, ContentHash* hash) {
    if (hash) hash->begin(c);
    Handle d = empty_dataset(parent, link, {c.size()}, std::visit([&](const auto& v) { return type_of(v); }, c.values));
    hsize_t at = 0;
    c.for_each_piece([&](const Values& piece) {
      std::visit(
          [&](const auto& values) {
            put(d, link, at, values, [&](const auto& stored) {
              if (hash) hash->add(stored);
            });
            at += values.size();
          },
          piece);
    });
    return d;
  }

  /// A Column, Axis or Map as a dataset that says what it is.
  template <class Quantity>
  Handle described(hid_t parent, const std::string& link, const Dims& dims, const Quantity& q,
                   ContentHash* hash = nullptr) {
    Handle d = [&] {
      if constexpr (std::is_same_v<Quantity, Column>)
        return column_dataset(parent, link, q, hash);
      else
        return dataset(parent, link, dims, q.values);
    }();
    if (!q.unit.empty()) attribute(d, "units", q.unit);  // none for a label: `units` of "" would call it a pure number
    attribute(d, "long_name", q.long_name);
    if (link != canonical_text(q.name)) attribute(d, kOriginalName, q.name);
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

  void write_columns(hid_t g, const Table& table, ContentHash* hash) {
    attribute(g, "long_name", table.long_name);
    const Dims dims = {table.rows()};
    Column row_numbers{kRow, "1", "row number, from 0", std::vector<std::int64_t>{}};
    row_numbers.on_disk = std::make_shared<MadeValues>(table.rows(), [](std::size_t first, std::size_t count) {
      std::vector<std::int64_t> numbers(count);
      std::iota(numbers.begin(), numbers.end(), static_cast<std::int64_t>(first));
      return numbers;
    });
    const Handle row = described(g, kRow, dims, row_numbers);
    checked(H5DSset_scale(row, kRow), "make the dimension scale of", table.name);

    std::set<std::string> taken = {kRow};
    for (const Column& c : table.columns) {
      const std::string link = link_name(c.name, taken);
      const Handle d = described(g, link, dims, c, hash);
      if (!c.ancillary.empty()) attribute(d, "ancillary_variables", c.ancillary);
      checked(H5DSattach_scale(d, row, 0), "attach the dimension scale to", link);
    }
  }

  void write_tables(hid_t file, const char* parent, const std::vector<Table>& tables, ContentHash& hash) {
    const Handle all = group(file, parent);
    hash.begin_list(tables.size());
    for (const Table& t : tables) {
      hash.begin(t);
      write_columns(group(all, t.name), t, &hash);
    }
  }

  void write_inputs(hid_t file, const std::vector<InputData>& inputs, ContentHash& hash) {
    const Handle all = group(file, "inputs");
    hash.begin_list(inputs.size());
    std::set<std::string> taken;
    for (const InputData& input : inputs) {
      const Handle g = group(all, input_group_name(input.path, taken));
      attribute(g, "path", input.path);
      attribute(g, "hash", input.hash);
      hash.begin(input);
      write_columns(g, input.table, &hash);
    }
  }

  /// All maps are in one group, so that one xr.open_dataset() has them. Maps share an axis that is the same in name,
  /// unit and values; another axis of that name gets a number behind it. Adds the hashes of streamed maps.
  void write_maps(hid_t file, const std::vector<Map>& maps, const std::vector<MapStream>& streams, MapHashes& hashes) {
    const Handle all = group(file, "maps");
    Axes axes;
    for (const Map& m : maps) axes.taken.insert(m.name);
    for (const MapStream& s : streams)
      for (const Map& m : s.maps) axes.taken.insert(m.name);
    for (const Map& m : maps) {
      const std::vector<std::size_t> used = axes_of(all, m, axes);
      const Handle d = described(all, m.name, shape(m), m);
      attach_axes(d, m, used, axes);
    }
    for (const MapStream& s : streams) {
      std::vector<Handle> datasets;
      for (const Map& m : s.maps) {
        const std::vector<std::size_t> used = axes_of(all, m, axes);
        datasets.push_back(empty_dataset(all, m));
        attach_axes(datasets.back(), m, used, axes);
      }
      write_values(s, datasets, hashes);
    }
  }

  struct Axes {
    std::set<std::string> taken;
    std::vector<std::pair<std::string, Handle>> scales;  // axis_hash(), dimension scale
  };

  static Dims shape(const Map& m) {
    Dims dims;
    for (const Axis& a : m.axes) dims.push_back(axis_size(a));
    return dims;
  }

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
        Handle d = described(all, link, {axis_size(a)}, a);
        checked(H5DSset_scale(d, link.c_str()), "make the dimension scale", link);
        axes.scales.emplace_back(hash, std::move(d));
      }
      used.push_back(i);
    }
    return used;
  }

  void attach_axes(hid_t d, const Map& m, const std::vector<std::size_t>& used, const Axes& axes) {
    for (std::size_t i = 0; i < used.size(); ++i) {
      checked(H5DSattach_scale(d, axes.scales[used[i]].second, static_cast<unsigned>(i)), "attach a dimension scale to",
              m.name);
    }
  }

  Handle empty_dataset(hid_t all, const Map& m) {
    Handle d = empty_dataset(all, m.name, shape(m), H5T_NATIVE_DOUBLE);
    if (!m.unit.empty()) attribute(d, "units", m.unit);
    attribute(d, "long_name", m.long_name);
    return d;
  }

  void write_values(const MapStream& s, const std::vector<Handle>& datasets, MapHashes& hashes) {
    if (s.maps.empty()) return;
    StreamHash hash(s.maps);
    const std::size_t size = map_size(s.maps.front());
    for (std::size_t at = 0; at < size; at += kStreamPiece) {
      const std::vector<std::vector<double>> piece = s.values(at, std::min(kStreamPiece, size - at));
      for (std::size_t i = 0; i < datasets.size(); ++i)
        put(datasets[i], s.maps[i].name, at, piece[i], [&](std::span<const double> stored) { hash.add(i, stored); });
    }
    hash.finish(hashes);
  }

  const int compression_;
  const Written& written_;
  std::uint64_t bytes_ = 0;
  std::unordered_map<std::string, std::size_t> known_;  // texts that are in the file, and places in references_
  std::vector<Reference> references_;
  const Handle text_ = text_type();
  const Handle text_transfer_ = text_transfer();
  const Handle group_properties_ = creation_properties(H5P_GROUP_CREATE);
};

}  // namespace

void check_shape(const Result& result) {
  const auto same_shape = [](const Map& a, const Map& b) {
    return std::equal(a.axes.begin(), a.axes.end(), b.axes.begin(), b.axes.end(),
                      [](const Axis& x, const Axis& y) { return axis_size(x) == axis_size(y); });
  };
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
    demand(map_size(m) == m.values.size(), "map " + m.name + " is not the product of its axes");
  }
  for (const MapStream& s : result.streams)
    for (const Map& m : s.maps) {
      demand_name(m.name, taken);
      demand(!m.axes.empty() && m.values.empty(), "streamed map " + m.name + " has no axes, or values of its own");
      demand(same_shape(m, s.maps.front()), "maps of one stream differ in shape: " + m.name);
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
