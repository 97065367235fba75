#include "study/kept_points.h"

#include "study/point_result_bytes.h"

namespace surveymc::study {
namespace {

std::size_t stream_values(const PointResult& r) {
  std::size_t n = 0;
  for (const store::MapStream& s : r.streams)
    for (const store::Map& m : s.maps) n += store::map_size(m);
  return n;
}

/// About what the result has as bytes: eight a value.
std::size_t bytes_of(const PointResult& r) {
  std::size_t values = stream_values(r);
  for (const std::vector<store::Table>* tables : {&r.tables, &r.samples})
    for (const store::Table& t : *tables) values += t.rows() * t.columns.size();
  for (const store::Map& m : r.maps) values += m.values.size();
  return sizeof(double) * values;
}

}  // namespace

void keep_point(checkpoint::Journal* journal, std::uint64_t point, std::string_view bytes) {
  if (!journal || bytes.size() > kMostKeptBytes) return;
  journal->add_point(point, bytes);
  if (journal->due()) journal->write();
}

std::optional<PointResult> KeptPoints::find(std::uint64_t point) {
  const auto kept = checkpoint_.points.find(point);
  if (kept == checkpoint_.points.end()) return std::nullopt;
  PointResult r = point_result_from_bytes(kept->second);
  streamed_ += stream_values(r);
  return r;
}

PointResult KeptPoints::keep(std::uint64_t point, PointResult r) {
  if (!checkpoint_.journal || points_ == 1 || bytes_of(r) > kMostKeptBytes) return r;
  const std::size_t streamed = stream_values(r);
  if (streamed_ + streamed > kMostKeptStreams) return r;
  const std::string bytes = point_result_to_bytes(r);
  keep_point(checkpoint_.journal, point, bytes);
  if (streamed == 0) return r;
  streamed_ += streamed;
  return point_result_from_bytes(bytes);
}

}  // namespace surveymc::study
