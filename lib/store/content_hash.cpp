#include "store/content_hash.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

namespace surveymc::store {

void Hasher::add(const std::string& text) {
  if (!is_canonical(text)) return add(canonical_text(text));
  add(std::uint64_t{text.size()});
  add_bytes(text.data(), text.size());
}

/// Few bytes are gathered: a call of the hash function for each number takes longer than the hash. How the bytes are
/// divided does not change the hash.
void Hasher::add_bytes(const void* bytes, std::size_t count) {
  if (count > gathered_.size() - used_) flush();
  if (count > gathered_.size()) {
    XXH3_128bits_update(&state_, bytes, count);
    return;
  }
  if (count > 0) std::memcpy(gathered_.data() + used_, bytes, count);
  used_ += count;
}

void Hasher::flush() {
  XXH3_128bits_update(&state_, gathered_.data(), used_);
  used_ = 0;
}

std::string Hasher::hex() {
  flush();
  const XXH128_hash_t h = XXH3_128bits_digest(&state_);
  return fmt::format("{:016x}{:016x}", h.high64, h.low64);
}

void add_head(Hasher& hash, const Provenance& p) {
  hash.add(std::string("surveymc result 1"), p.title, p.experiment, p.config, p.config_hash, p.seed, p.trials);
}
void add_head(Hasher& hash, const Table& t) { hash.add(t.name, t.long_name, std::uint64_t{t.columns.size()}); }
void add_head(Hasher& hash, const InputData& i) {
  hash.add(i.path, i.hash, i.table.long_name, std::uint64_t{i.table.columns.size()});
}
void add_head(Hasher& hash, const Column& c) {
  hash.add(c.name, c.unit, c.long_name, c.ancillary, std::uint64_t{c.values.index()}, std::uint64_t{c.size()});
}

std::string axis_hash(const Axis& a) {
  Hasher hash;
  hash.add(a.name, a.unit, a.long_name, a.values);
  return hash.hex();
}

void add(Hasher& hash, const MapHashes& maps) {
  hash.add(std::uint64_t{maps.size()});
  for (const auto& [name, of_map] : maps) hash.add(name, of_map);
}

void hash_maps(const MapStream& stream, MapHashes& hashes, const UseOfMap& use) {
  std::vector<Hasher> of_maps;
  for (const Map& m : stream.maps) {
    Hasher& hash = of_maps.emplace_back();
    hash.add(m.name, m.unit, m.long_name, std::uint64_t{m.axes.size()});
    for (const Axis& a : m.axes) hash.add(a.name, a.unit, a.long_name, a.values);
    hash.add(std::uint64_t{map_size(m)});
  }
  const std::size_t size = stream.maps.empty() ? 0 : map_size(stream.maps.front());
  for (std::size_t at = 0; at < size; at += kStreamPiece) {
    const std::vector<std::vector<double>> pieces = stream.values(at, std::min(kStreamPiece, size - at));
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      std::size_t first = at;
      for_each_stored(pieces[i], [&](std::span<const double> values) {
        of_maps[i].add_values(values);
        if (use) use(i, first, values);
        first += values.size();
      });
    }
  }
  for (std::size_t i = 0; i < of_maps.size(); ++i) hashes[stream.maps[i].name] = of_maps[i].hex();
}

std::vector<MapStream> map_streams(const Result& result) {
  std::vector<MapStream> all;
  for (const Map& m : result.maps)
    all.push_back({{Map{m.name, m.unit, m.long_name, m.axes, {}}}, [&m](std::size_t first, std::size_t count) {
                     const auto begin = m.values.begin() + static_cast<std::ptrdiff_t>(first);
                     return std::vector<std::vector<double>>{{begin, begin + static_cast<std::ptrdiff_t>(count)}};
                   }});
  all.insert(all.end(), result.streams.begin(), result.streams.end());
  return all;
}

std::string input_hash(const Table& table) {
  Hasher hash;
  hash.add(std::uint64_t{table.columns.size()});
  for (const Column& c : table.columns) hash.add(c.name, c.unit, c.values);
  return hash.hex();
}

std::string content_hash(const Result& result) {
  Hasher hash;
  add_head(hash, result.provenance);
  const auto add_columns = [&](const Table& table) {
    for (const Column& c : table.columns) {
      add_head(hash, c);
      for_each_stored(c, [&](const auto& values) { hash.add_values(values); });
    }
  };
  for (const auto* tables : {&result.tables, &result.samples}) {
    hash.add(std::uint64_t{tables->size()});
    for (const Table& t : *tables) add_head(hash, t), add_columns(t);
  }
  MapHashes maps;
  for (const MapStream& s : map_streams(result)) hash_maps(s, maps, {});
  add(hash, maps);
  hash.add(std::uint64_t{result.inputs.size()});
  for (const InputData& i : result.inputs) add_head(hash, i), add_columns(i.table);
  return hash.hex();
}

}  // namespace surveymc::store
