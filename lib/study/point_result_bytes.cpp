#include "study/point_result_bytes.h"

#include <algorithm>
#include <memory>

#include "base/bytes.h"

namespace surveymc::study {
namespace {

void put(ByteWriter& out, const std::vector<std::string>& list) {
  out.put(std::uint64_t{list.size()});
  for (const std::string& s : list) out.put(s);
}

template <class T>
void put(ByteWriter& out, const std::vector<T>& list) {
  out.put(list);
}

template <class... T>
void put(ByteWriter& out, const std::variant<T...>& values) {
  out.put(std::uint64_t{values.index()});
  std::visit([&](const auto& v) { put(out, v); }, values);
}

std::vector<std::string> texts(ByteReader& in) {
  std::vector<std::string> list(in.length(8));
  for (std::string& s : list) s = in.text();
  return list;
}

/// As a list of all its values, wherever they are.
void put_values(ByteWriter& out, const store::Column& c) {
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

void put_tables(ByteWriter& out, const std::vector<store::Table>& tables) {
  out.put(std::uint64_t{tables.size()});
  for (const store::Table& t : tables) {
    out.put(t.name);
    out.put(t.long_name);
    out.put(std::uint64_t{t.columns.size()});
    for (const store::Column& c : t.columns) {
      for (const std::string* s : {&c.name, &c.unit, &c.long_name, &c.ancillary}) out.put(*s);
      put_values(out, c);
    }
  }
}

std::vector<store::Table> tables(ByteReader& in) {
  std::vector<store::Table> all(in.length(24));
  for (store::Table& t : all) {
    t.name = in.text();
    t.long_name = in.text();
    t.columns.resize(in.length(48));
    for (store::Column& c : t.columns) {
      for (std::string* s : {&c.name, &c.unit, &c.long_name, &c.ancillary}) *s = in.text();
      const auto kind = in.get<std::uint64_t>();
      if (kind == 0) c.values = in.list<double>();
      if (kind == 1) c.values = in.list<std::int64_t>();
      if (kind == 2) c.values = texts(in);
    }
  }
  return all;
}

void put_maps(ByteWriter& out, const std::vector<store::Map>& maps) {
  out.put(std::uint64_t{maps.size()});
  for (const store::Map& m : maps) {
    for (const std::string* s : {&m.name, &m.unit, &m.long_name}) out.put(*s);
    out.put(std::uint64_t{m.axes.size()});
    for (const store::Axis& a : m.axes) {
      for (const std::string* s : {&a.name, &a.unit, &a.long_name}) out.put(*s);
      put(out, a.values);
    }
    out.put(m.values);
  }
}

std::vector<store::Map> maps(ByteReader& in) {
  std::vector<store::Map> all(in.length(40));
  for (store::Map& m : all) {
    for (std::string* s : {&m.name, &m.unit, &m.long_name}) *s = in.text();
    m.axes.resize(in.length(40));
    for (store::Axis& a : m.axes) {
      for (std::string* s : {&a.name, &a.unit, &a.long_name}) *s = in.text();
      if (in.get<std::uint64_t>() == 0)
        a.values = in.list<double>();
      else
        a.values = texts(in);
    }
    m.values = in.list<double>();
  }
  return all;
}

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
  put_tables(out, result.tables);
  put_tables(out, result.samples);
  put_maps(out, result.maps);
  out.put(std::uint64_t{result.streams.size()});
  for (const store::MapStream& s : result.streams) put_maps(out, held(s));
  return out.take();
}

PointResult point_result_from_bytes(std::string_view bytes) {
  ByteReader in(bytes);
  PointResult r;
  r.tables = tables(in);
  r.samples = tables(in);
  r.maps = maps(in);
  const std::size_t streams = in.length(8);
  for (std::size_t i = 0; i < streams; ++i) r.streams.push_back(stream_of(maps(in)));
  if (in.left() != 0) throw IoError("damaged: data behind the maps");
  return r;
}

}  // namespace surveymc::study
