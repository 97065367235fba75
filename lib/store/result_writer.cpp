#include "store/result_hdf5.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "store/content_hash.h"
#include "store/hdf5_driver.h"
#include "store/hdf5_handle.h"
#include "store/map_boxes.h"
#include "store/row_spool.h"
#include "store/ruled_values.h"
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

/// Of a dataset in one piece, whose place is there before its values: we write them ourselves.
Handle contiguous_properties() {
  Handle properties = creation_properties(H5P_DATASET_CREATE);
  checked(H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY), "select when to make room");
  return properties;
}

/// An empty file.
Handle new_file(DriverTarget& target) {
  const Handle access = access_to(target);
  // HDF5 1.8 and later can read it
  checked(H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18), "select the format");
  return Handle(H5Fcreate("surveymc", H5F_ACC_TRUNC, creation_properties(H5P_FILE_CREATE), access), "start the file");
}

/// Of a dataset of these lengths in row-major order: as many whole trailing dimensions as there is room for. Values
/// come in this order, so that a chunk is compressed once, while it is in HDF5's cache of 1 MB.
std::vector<hsize_t> chunk_of(const std::vector<hsize_t>& dims) {
  hsize_t room = hsize_t{1} << 16;
  std::vector<hsize_t> chunk(dims.size(), 1);
  for (std::size_t i = dims.size(); i-- > 0 && room > 1; room /= chunk[i]) chunk[i] = std::min(dims[i], room);
  return chunk;
}

/// Calls use(pointers) with texts as HDF5 takes them.
void in_stored_texts(std::span<const std::string> values, const std::function<void(const void*)>& use) {
  std::deque<std::string> changed;
  std::vector<const char*> pointers;
  pointers.reserve(values.size());
  for (const std::string& s : values)
    pointers.push_back(is_canonical(s) ? s.c_str() : changed.emplace_back(canonical_text(s)).c_str());
  use(pointers.data());
}

/// Where the values of a dataset begin in the file; none if they are in chunks.
std::optional<std::uint64_t> begin_of(hid_t dataset) {
  const haddr_t begin = H5Dget_offset(dataset);
  return begin == HADDR_UNDEF ? std::nullopt : std::optional<std::uint64_t>(begin);
}

/// Properties of a transfer of texts. By default HDF5 clears a megabyte for each.
Handle text_transfer() {
  Handle transfer(H5Pcreate(H5P_DATASET_XFER), "make a property list");
  checked(H5Pset_buffer(transfer, std::size_t{1} << 14, nullptr, nullptr), "set a buffer");
  return transfer;
}

/// Lists that are as long are written by SharedTexts.
constexpr std::size_t kManyTexts = 1024;

/// A list of texts, many of which are the same, in pieces. An HDF5 text in a list is a reference to letters elsewhere
/// in the file. HDF5 writes the letters again for every text; here a text that has been there before has the reference
/// of the first. For all that read the file it is as any other list of texts.
class SharedTexts {
 public:
  SharedTexts(hid_t dataset, std::string link, hid_t type, PagedFile& pages)
      : dataset_(dataset), link_(std::move(link)), type_(type), pages_(pages) {}

  void write(const CycledWords& values) {
    const std::vector<std::string>& words = values.words();
    if (values.size() == 0) return;
    std::vector<hsize_t> places(words.size());
    std::iota(places.begin(), places.end(), hsize_t{0});
    forget();
    add(words, places);
    constexpr std::size_t kTogether = std::size_t{1} << 14;
    const std::size_t most = std::min(values.times(), kTogether / words.size() + 1);
    std::vector<Reference> cycles;
    for (std::size_t i = 0; i < most; ++i) cycles.insert(cycles.end(), references_.begin(), references_.end());
    for (std::size_t done = 0; done < values.times();) {
      const std::size_t times = std::min(most, values.times() - done);
      pages_.write(begin() + done * words.size() * kReference, cycles.data(), times * words.size() * kReference);
      done += times;
    }
    forget();
  }

  /// Values `first` and following.
  void write(const std::vector<std::string>& values, hsize_t first) {
    constexpr std::size_t kTogether = std::size_t{1} << 16;
    for (std::size_t from = 0; from < values.size(); from += kTogether) {
      const std::span<const std::string> some(values.data() + from, std::min(kTogether, values.size() - from));
      if (!write_shared(some, first + from)) write_each(some, first + from);
    }
  }

 private:
  static constexpr std::size_t kReference = 16;  // length, address of a heap, number in it
  using Reference = std::array<char, kReference>;

  /// False, and nothing is written, if too many of them are new.
  bool write_shared(std::span<const std::string> values, hsize_t first) {
    constexpr std::size_t kMostKnown = std::size_t{1} << 16;  // some MB
    if (known_.size() > kMostKnown) forget();
    std::vector<std::size_t> codes(values.size());
    std::vector<std::string> fresh;
    std::vector<hsize_t> places;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i > 0 && values[i] == values[i - 1]) {
        codes[i] = codes[i - 1];
        continue;
      }
      const auto [it, is_new] = known_.try_emplace(values[i], references_.size() + fresh.size());
      codes[i] = it->second;
      if (!is_new) continue;
      fresh.push_back(values[i]);
      places.push_back(first + i);
      if (fresh.size() * 8 > values.size()) {
        forget();
        return false;
      }
    }
    add(fresh, places);
    std::vector<Reference> stored(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) stored[i] = references_[codes[i]];
    pages_.write(begin() + first * kReference, stored.data(), stored.size() * kReference);
    return true;
  }

  void write_each(std::span<const std::string> values, hsize_t first) {
    const hsize_t count = values.size();
    const Handle space(H5Dget_space(dataset_), "read the shape of", link_);
    checked(H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, nullptr, &count, nullptr), "select a part of", link_);
    const Handle memory(H5Screate_simple(1, &count, nullptr), "make a dataspace");
    in_stored_texts(values, [&](const void* stored) {
      checked(H5Dwrite(dataset_, type_, memory, space, transfer_, stored), "write", link_);
    });
  }

  void forget() {
    known_.clear();
    references_.clear();
  }

  /// Has HDF5 write texts that are new, each to its place, and looks at the references that it made.
  void add(const std::vector<std::string>& texts, const std::vector<hsize_t>& places) {
    if (texts.empty()) return;
    const hsize_t count = texts.size();
    const Handle space(H5Dget_space(dataset_), "read the shape of", link_);
    checked(H5Sselect_elements(space, H5S_SELECT_SET, count, places.data()), "select a part of", link_);
    const Handle memory(H5Screate_simple(1, &count, nullptr), "make a dataspace");
    in_stored_texts(texts, [&](const void* stored) {
      checked(H5Dwrite(dataset_, type_, memory, space, transfer_, stored), "write", link_);
    });
    checked(H5Dflush(dataset_), "write", link_);
    for (const hsize_t place : places)
      pages_.read(begin() + place * kReference, references_.emplace_back().data(), kReference);
  }

  std::uint64_t begin() const {
    const std::optional<std::uint64_t> begin = begin_of(dataset_);
    if (!begin) throw Hdf5Failure("cannot find the place of " + link_);
    return *begin;
  }

  hid_t dataset_;
  std::string link_;
  hid_t type_;
  PagedFile& pages_;
  const Handle transfer_ = text_transfer();
  std::unordered_map<std::string, std::size_t> known_;  ///< text: number of its reference
  std::vector<Reference> references_;
};

class Writer {
 public:
  Writer(PagedFile& pages, int compression) : pages_(pages), compression_(compression) {
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

  /// Where the values of a dataset go.
  struct Place {
    hid_t dataset;
    const std::string& link;
    std::optional<std::uint64_t> begin;  ///< in the file; none: in chunks, which HDF5 writes
  };
  static Place place_of(hid_t d, const std::string& link) { return {d, link, begin_of(d)}; }

  /// Numbers `first` and following, in row-major order, as they are stored.
  template <class T>
  void put(const Place& to, hsize_t first, std::span<const T> stored) {
    if (to.begin) return pages_.write(*to.begin + first * sizeof(T), stored.data(), stored.size_bytes());
    const Handle space(H5Dget_space(to.dataset), "read the shape of", to.link);
    Dims dims(static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space), "read the shape of", to.link)));
    checked(H5Sget_simple_extent_dims(space, dims.data(), nullptr), "read the shape of", to.link);
    for (const Box& box : boxes_in(dims, first, stored.size())) {
      const Handle memory(H5Screate_simple(1, &box.size, nullptr), "make a dataspace");
      checked(H5Sselect_hyperslab(space, H5S_SELECT_SET, box.start.data(), nullptr, box.count.data(), nullptr),
              "select a part of", to.link);
      const hid_t type = std::is_same_v<T, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
      checked(H5Dwrite(to.dataset, type, memory, space, H5P_DEFAULT, stored.data() + (box.first - first)), "write",
              to.link);
    }
  }

  /// Writes values `first` and following, and adds them to the hash if there is one.
  void put(const Place& to, hsize_t first, const std::vector<double>& values, ContentHash* hash) {
    put_and_show(to, first, values, [&](std::span<const double> piece) {
      if (hash) hash->add(piece);
    });
  }
  /// Calls show(piece) for all values as they are stored, just before they are written.
  template <class Show>
  void put_and_show(const Place& to, hsize_t first, const std::vector<double>& values, const Show& show) {
    in_canonical_pieces(values, [&](std::span<const double> piece) {
      show(piece);
      put(to, first, piece);
      first += piece.size();
    });
  }
  void put(const Place& to, hsize_t first, const std::vector<std::int64_t>& values, ContentHash* hash) {
    if (values.empty()) return;
    if (hash) hash->add(std::span(values));
    put(to, first, std::span(values));
  }

  Handle dataset(hid_t parent, const std::string& link, const Dims& dims, const std::vector<double>& values) {
    Handle d = empty_dataset(parent, link, dims, type_of(values));
    put(place_of(d, link), 0, values, nullptr);
    return d;
  }
  Handle dataset(hid_t parent, const std::string& link, const Dims& dims, const std::vector<std::string>& values) {
    Handle d = empty_dataset(parent, link, dims, text_);
    if (values.empty()) return d;  // H5Dwrite refuses a null pointer
    if (dims.size() == 1 && values.size() >= kManyTexts) {
      SharedTexts(d, link, text_, pages_).write(values, 0);
      return d;
    }
    in_stored_texts(values, [&](const void* stored) {
      checked(H5Dwrite(d, text_, H5S_ALL, H5S_ALL, text_transfer_, stored), "write dataset", link);
    });
    return d;
  }
  template <class... V>
  Handle dataset(hid_t parent, const std::string& link, const Dims& dims, const std::variant<V...>& values) {
    return std::visit([&](const auto& v) { return dataset(parent, link, dims, v); }, values);
  }
  Handle empty_dataset(hid_t parent, const std::string& link, const Dims& dims, hid_t type) {
    const Handle space(
        dims.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
        "make a dataspace for", link);
    const auto made_with = [&](hid_t properties) {
      return Handle(H5Dcreate2(parent, link.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT),
                    "create dataset", link);
    };
    if (!is_compressed(dims, type)) return made_with(contiguous_);
    const Handle packed = creation_properties(H5P_DATASET_CREATE);
    const Dims chunk = chunk_of(dims);
    checked(H5Pset_chunk(packed, static_cast<int>(chunk.size()), chunk.data()), "set the chunks of", link);
    checked(H5Pset_shuffle(packed), "shuffle", link);
    checked(H5Pset_deflate(packed, static_cast<unsigned>(compression_)), "compress", link);
    return made_with(packed);
  }

  /// A column, in pieces if it is not held, and its share of the hash.
  Handle column_dataset(hid_t parent, const std::string& link, const Column& c, ContentHash* hash) {
    if (hash) hash->begin(c);
    if (!c.on_disk && std::holds_alternative<std::vector<std::string>>(c.values)) {
      const auto& words = std::get<std::vector<std::string>>(c.values);
      if (hash) hash->add(std::span(words));
      return dataset(parent, link, {c.size()}, words);
    }
    Handle d = empty_dataset(parent, link, {c.size()}, std::visit([&](const auto& v) { return type_of(v); }, c.values));
    const Place place = place_of(d, link);
    SharedTexts texts(d, link, text_, pages_);
    const auto* cycled = dynamic_cast<const CycledWords*>(c.on_disk.get());
    if (cycled && c.size() == cycled->size()) {
      if (hash) hash->add(*cycled);
      texts.write(*cycled);
      return d;
    }
    hsize_t at = 0;
    c.for_each_piece([&](const Values& piece) {
      if (const auto* numbers = std::get_if<std::vector<double>>(&piece)) {
        put(place, at, *numbers, hash);
      } else if (const auto* counts = std::get_if<std::vector<std::int64_t>>(&piece)) {
        put(place, at, *counts, hash);
      } else if (const auto& words = std::get<std::vector<std::string>>(piece); !words.empty()) {
        if (hash) hash->add(std::span(words));
        texts.write(words, at);
      }
      at += std::visit([](const auto& v) { return v.size(); }, piece);
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
    const auto numbers = std::make_shared<RowNumbers>(table.rows());
    Column row_numbers{kRow, "1", "row number, from 0", std::vector<std::int64_t>{}};
    if (table.rows() <= kPieceRows)
      row_numbers.values = numbers->read(0, table.rows());
    else
      row_numbers.on_disk = numbers;
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
    std::vector<Place> places;
    for (std::size_t i = 0; i < datasets.size(); ++i) places.push_back(place_of(datasets[i], s.maps[i].name));
    const std::size_t size = map_size(s.maps.front());
    for (std::size_t at = 0; at < size; at += kStreamPiece) {
      const std::vector<std::vector<double>> piece = s.values(at, std::min(kStreamPiece, size - at));
      for (std::size_t i = 0; i < places.size(); ++i)
        put_and_show(places[i], at, piece[i], [&](std::span<const double> stored) { hash.add(i, stored); });
    }
    hash.finish(hashes);
  }

  /// Of small datasets the index of the chunks would be larger than what is saved.
  bool is_compressed(const Dims& dims, hid_t type) const {
    constexpr hsize_t kLeast = 1024;
    if (compression_ == 0 || type == text_) return false;
    hsize_t size = dims.empty() ? 0 : 1;
    for (const hsize_t d : dims) size *= d;
    return size >= kLeast;
  }

  PagedFile& pages_;
  const int compression_;
  const Handle text_ = text_type();
  const Handle text_transfer_ = text_transfer();
  const Handle group_properties_ = creation_properties(H5P_GROUP_CREATE);
  const Handle contiguous_ = contiguous_properties();
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

void write_hdf5(AtomicFile& file, const Result& result, int compression, bool past_cache,
                const std::function<void(std::uint64_t)>& written) {
  silence_hdf5();
  close_fault().clear();
  DriverTarget target(file, past_cache, written);
  try {
    const Handle hdf5 = new_file(target);
    Writer(target.pages, compression).write(hdf5, result);
  } catch (const Hdf5Failure&) {
    if (target.error) std::rethrow_exception(target.error);
    throw;
  }
  if (target.error) std::rethrow_exception(target.error);
  if (!close_fault().empty()) throw Hdf5Failure("cannot close the file: " + close_fault());
  target.pages.finish(target.allocated);
}

}  // namespace surveymc::store
