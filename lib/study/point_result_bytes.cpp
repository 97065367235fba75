#include "study/point_result_bytes.h"

#include <algorithm>
#include <memory>

#include "base/bytes.h"

namespace surveymc::study {
namespace {

template <class... T>
void put(ByteWriter& out, const std::variant<T...>& values) {
  out.put(std::uint64_t{values.index()});
  std::visit([&](const auto& v) { out.put(v); }, values);
}

/// As a list of all its values, wherever they are.
void values_field(ByteWriter& out, const store::Column& c) {
  if (!c.on_disk) return put(out, c.values);
  store::Values all = c.values;
  std::visit([](auto& values) { values.clear(); }, all);
  c.for_each_piece([&](const store::Values& piece) {
    std::visit(
        [&](auto& values) {
          const auto& more = std::get<std::decay_t<decltype(values)>>(piece);
          values.insert(values.end(), more.begin(), more.end());
        },
        all);
  });
  put(out, all);
}

void values_field(ByteReader& in, store::Column& c) {
  const auto kind = in.get<std::uint64_t>();
  if (kind == 0) in.fields(c.values.emplace<0>());
  if (kind == 1) in.fields(c.values.emplace<1>());
  if (kind == 2) in.fields(c.values.emplace<2>());
}

void values_field(ByteWriter& out, const store::Axis& a) { put(out, a.values); }
void values_field(ByteReader& in, store::Axis& a) {
  if (in.get<std::uint64_t>() == 0)
    in.fields(a.values.emplace<0>());
  else
    in.fields(a.values.emplace<1>());
}

// For a ByteWriter and a ByteReader.

constexpr auto kTablesFields = [](auto& bytes, auto& tables) {
  bytes.length_of(24, tables);
  for (auto& t : tables) {
    bytes.fields(t.name, t.long_name);
    bytes.length_of(48, t.columns);
    for (auto& c : t.columns) {
      bytes.fields(c.name, c.unit, c.long_name, c.ancillary);
      values_field(bytes, c);
    }
  }
};

constexpr auto kMapsFields = [](auto& bytes, auto& maps) {
  bytes.length_of(40, maps);
  for (auto& m : maps) {
    bytes.fields(m.name, m.unit, m.long_name);
    bytes.length_of(40, m.axes);
    for (auto& a : m.axes) {
      bytes.fields(a.name, a.unit, a.long_name);
      values_field(bytes, a);
    }
    bytes.fields(m.values);
  }
};

/// The maps of a stream with all their values.
std::vector<store::Map> held(const store::MapStream& stream) {
  std::vector<store::Map> all = stream.maps;
  const std::size_t size = all.empty() ? 0 : store::map_size(all.front());
  for (std::size_t at = 0; at < size; at += store::kStreamPiece) {
    const auto piece = stream.values(at, std::min(store::kStreamPiece, size - at));
    for (std::size_t m = 0; m < all.size(); ++m)
      all[m].values.insert(all[m].values.end(), piece[m].begin(), piece[m].end());
  }
  return all;
}

store::MapStream stream_of(std::vector<store::Map> all) {
  const auto values = std::make_shared<std::vector<std::vector<double>>>();
  for (store::Map& m : all) values->push_back(std::move(m.values));
  for (store::Map& m : all) m.values.clear();
  return {std::move(all), [values](std::size_t first, std::size_t count) {
            std::vector<std::vector<double>> piece;
            for (const std::vector<double>& v : *values) {
              const auto begin = v.begin() + static_cast<std::ptrdiff_t>(first);
              piece.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(count));
            }
            return piece;
          }};
}

}  // namespace

std::string point_result_to_bytes(const PointResult& result) {
  std::size_t values = 0;
  for (const store::MapStream& s : result.streams)
    for (const store::Map& m : s.maps) values += store::map_size(m);
  if (values > kMostPartValues)
    throw IoError(
        fmt::format("the maps of this point have {} values; a part file holds at most {}: run the config as "
                    "a whole, or give it fewer points or maps",
                    values, kMostPartValues));
  ByteWriter out;
  kTablesFields(out, result.tables);
  kTablesFields(out, result.samples);
  kMapsFields(out, result.maps);
  out.put(std::uint64_t{result.streams.size()});
  for (const store::MapStream& s : result.streams) {
    const std::vector<store::Map> all = held(s);
    kMapsFields(out, all);
  }
  return out.take();
}

PointResult point_result_from_bytes(std::string_view bytes) {
  ByteReader in(bytes);
  PointResult r;
  kTablesFields(in, r.tables);
  kTablesFields(in, r.samples);
  kMapsFields(in, r.maps);
  in.length_of(8, r.streams);
  for (store::MapStream& s : r.streams) {
    std::vector<store::Map> all;
    kMapsFields(in, all);
    s = stream_of(std::move(all));
  }
  if (in.left() != 0) throw IoError("damaged: data behind the maps");
  return r;
}

}  // namespace surveymc::study
