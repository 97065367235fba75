#include "store/content_hash.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "store/result_file.h"
#include "store/stored_form.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc::store {
/// XXH3-128 over a serialisation in which every list and text is preceded by its length: no two results share one.
class Hasher {
 public:
  Hasher() { XXH3_128bits_reset(&state_); }

  void add(std::uint64_t x) { add_bytes(&x, sizeof x); }
  void add(std::int64_t x) { add(static_cast<std::uint64_t>(x)); }
  void add(double x) { add(std::bit_cast<std::uint64_t>(canonical_number(x))); }
  void add(const std::string& text) {
    if (!is_canonical(text)) return add(canonical_text(text));
    add(std::uint64_t{text.size()});
    add_bytes(text.data(), text.size());
  }
  void add(const std::vector<double>& list) {
    add(std::uint64_t{list.size()});
    in_canonical_pieces(list, [this](std::span<const double> piece) { add(piece); });
  }
  /// Numbers of a list whose length was added.
  void add(std::span<const double> canonical) { add_bytes(canonical.data(), canonical.size_bytes()); }
  void add(const std::vector<std::int64_t>& list) {
    add(std::uint64_t{list.size()});
    add_bytes(list.data(), list.size() * sizeof(std::int64_t));
  }
  template <class T>
  void add(const std::vector<T>& list) {
    add(std::uint64_t{list.size()});
    for (const T& x : list) add(x);
  }
  template <class... T>
  void add(const std::variant<T...>& values) {
    add(std::uint64_t{values.index()});
    std::visit([&](const auto& v) { add(v); }, values);
  }
  void add(const Axis& a) { add(a.name, a.unit, a.long_name, a.values); }
  template <class First, class Second, class... More>
  void add(const First& first, const Second& second, const More&... more) {
    add(first), add(second), (add(more), ...);
  }

  /// Few bytes are gathered: a call of the hash function for each number takes longer than the hash. How the bytes are
  /// divided does not change the hash.
  void add_bytes(const void* bytes, std::size_t count) {
    if (count > gathered_.size() - used_) flush();
    if (count > gathered_.size()) {
      XXH3_128bits_update(&state_, bytes, count);
      return;
    }
    if (count > 0) std::memcpy(gathered_.data() + used_, bytes, count);
    used_ += count;
  }

  std::string hex() {
    flush();
    const XXH128_hash_t h = XXH3_128bits_digest(&state_);
    return fmt::format("{:016x}{:016x}", h.high64, h.low64);
  }

 private:
  void flush() {
    XXH3_128bits_update(&state_, gathered_.data(), used_);
    used_ = 0;
  }

  XXH3_state_t state_;
  std::array<char, 4096> gathered_;
  std::size_t used_ = 0;
};

namespace {

/// Hash of one map, whose values follow in pieces.
Hasher hasher_of(const Map& m) {
  Hasher h;
  h.add(m.name, m.unit, m.long_name, m.axes, std::uint64_t{map_size(m)});
  return h;
}

}  // namespace

StreamHash::StreamHash(const std::vector<Map>& maps) : maps_(maps) {
  for (const Map& m : maps) of_maps_.push_back(hasher_of(m));
}
StreamHash::~StreamHash() = default;
void StreamHash::add(std::size_t map, std::span<const double> canonical) { of_maps_[map].add(canonical); }
void StreamHash::finish(MapHashes& hashes) {
  for (std::size_t i = 0; i < maps_.size(); ++i) hashes[maps_[i].name] = of_maps_[i].hex();
}

MapHashes held_map_hashes(const std::vector<Map>& maps) {
  MapHashes hashes;
  for (const Map& m : maps) {
    Hasher h = hasher_of(m);
    in_canonical_pieces(m.values, [&](std::span<const double> canonical) { h.add(canonical); });
    hashes[m.name] = h.hex();
  }
  return hashes;
}

std::string axis_hash(const Axis& axis) {
  Hasher h;
  h.add(axis);
  return h.hex();
}

std::string input_hash(const Table& table) {
  Hasher h;
  h.add(std::uint64_t{table.columns.size()});
  for (const Column& c : table.columns) h.add(c.name, c.unit, c.values);
  return h.hex();
}

ContentHash::ContentHash(const Provenance& p) : hasher_(std::make_unique<Hasher>()) {
  hasher_->add(std::string("surveymc result 1"));
  hasher_->add(p.title, p.experiment, p.config, p.config_hash, p.seed, p.trials);
}
ContentHash::~ContentHash() = default;
void ContentHash::begin_list(std::size_t size) { hasher_->add(std::uint64_t{size}); }
void ContentHash::begin(const Table& t) { hasher_->add(t.name, t.long_name, std::uint64_t{t.columns.size()}); }
void ContentHash::begin(const InputData& i) {
  hasher_->add(i.path, i.hash, i.table.long_name, std::uint64_t{i.table.columns.size()});
}
void ContentHash::begin(const Column& c) {
  hasher_->add(c.name, c.unit, c.long_name, c.ancillary);
  hasher_->add(std::uint64_t{c.values.index()}, std::uint64_t{c.size()});
}
void ContentHash::add(std::span<const double> canonical) { hasher_->add(canonical); }
void ContentHash::add(std::span<const std::int64_t> values) { hasher_->add_bytes(values.data(), values.size_bytes()); }
void ContentHash::add(std::span<const std::string> values) {
  for (const std::string& text : values) hasher_->add(text);
}
/// By name, so that it does not matter which are held and which are streamed.
void ContentHash::add(const MapHashes& maps) {
  hasher_->add(std::uint64_t{maps.size()});
  for (const auto& [name, hash] : maps) hasher_->add(name, hash);
}
std::string ContentHash::hex() { return hasher_->hex(); }

namespace {

void add_columns(ContentHash& h, const std::vector<Column>& columns) {
  for (const Column& c : columns) {
    h.begin(c);
    c.for_each_piece([&](const Values& piece) {
      if (const auto* numbers = std::get_if<std::vector<double>>(&piece))
        in_canonical_pieces(*numbers, [&](std::span<const double> canonical) { h.add(canonical); });
      else if (const auto* counts = std::get_if<std::vector<std::int64_t>>(&piece))
        h.add(std::span(*counts));
      else
        h.add(std::span(std::get<std::vector<std::string>>(piece)));
    });
  }
}

}  // namespace

std::string content_hash(const Result& result, const MapHashes& maps) {
  ContentHash h(result.provenance);
  for (const auto* tables : {&result.tables, &result.samples}) {
    h.begin_list(tables->size());
    for (const Table& t : *tables) {
      h.begin(t);
      add_columns(h, t.columns);
    }
  }
  h.add(maps);
  h.begin_list(result.inputs.size());
  for (const InputData& i : result.inputs) {
    h.begin(i);
    add_columns(h, i.table.columns);
  }
  return h.hex();
}

std::string content_hash(const Result& result) {
  MapHashes hashes = held_map_hashes(result.maps);
  for (const MapStream& s : result.streams) {
    StreamHash hash(s.maps);
    const std::size_t size = s.maps.empty() ? 0 : map_size(s.maps.front());
    for (std::size_t at = 0; at < size; at += kStreamPiece) {
      const std::vector<std::vector<double>> piece = s.values(at, std::min(kStreamPiece, size - at));
      for (std::size_t i = 0; i < piece.size(); ++i)
        in_canonical_pieces(piece[i], [&](std::span<const double> canonical) { hash.add(i, canonical); });
    }
    hash.finish(hashes);
  }
  return content_hash(result, hashes);
}

}  // namespace surveymc::store
