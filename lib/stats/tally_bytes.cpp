#include "stats/tally_bytes.h"

#include "base/bytes.h"

namespace surveymc::stats {
namespace {

// Fields for both directions, a ByteWriter or a ByteReader. Each function names all members, and fails to compile when
// one is added: then it must list that one, too, and kTallyVersion must rise.

void size_field(ByteWriter& out, const Moments& m) { out.put(static_cast<std::uint64_t>(m.mean.size())); }
void size_field(ByteReader& in, Moments& m) {
  const std::size_t size = in.length(3 * sizeof(double));
  if (size > 0 && in.left() / sizeof(double) / size < size) throw IoError("damaged: a length is larger than the data");
  const std::uint64_t count = m.count;
  m = Moments(static_cast<Eigen::Index>(size));
  m.count = count;
}

/// The elements of a vector or matrix that has its size.
template <class X>
void elements(ByteWriter& out, const X& x) {
  out.put(x.data(), static_cast<std::size_t>(x.size()) * sizeof(double));
}
template <class X>
void elements(ByteReader& in, X& x) {
  in.get(x.data(), static_cast<std::size_t>(x.size()) * sizeof(double));
}

constexpr auto kMomentsFields = [](auto& bytes, auto& m) {
  auto& [count, mean, squares, cubes, fourths] = m;
  bytes.fields(count);
  size_field(bytes, m);
  elements(bytes, mean);
  elements(bytes, squares);
  elements(bytes, cubes);
  elements(bytes, fourths);
};

constexpr auto kMomentsListFields = [](auto& bytes, auto& list) {
  bytes.length_of(2 * sizeof(std::uint64_t), list);
  for (auto& m : list) kMomentsFields(bytes, m);
};

constexpr auto kTallyFields = [](auto& bytes, auto& tally) {
  auto& [trials, failed, left_out, moments, groups, controlled, pairs, controlled_pairs, counts, failed_trials, samples,
         weighted, proposal] = tally;
  bytes.fields(trials, failed, left_out);
  kMomentsFields(bytes, moments);
  kMomentsListFields(bytes, groups);
  kMomentsListFields(bytes, controlled);
  kMomentsFields(bytes, pairs);
  kMomentsListFields(bytes, controlled_pairs);
  bytes.fields(counts, failed_trials, samples);
  bytes.length_of(sizeof(WeightedHits), weighted);
  for (auto& [count, sum, squares, largest] : weighted) bytes.fields(count, sum, squares, largest);
  bytes.fields(proposal);
};

}  // namespace

std::string tally_to_bytes(const Tally& t) {
  ByteWriter out;
  out.put(kTallyVersion);
  kTallyFields(out, t);
  return out.take();
}

Tally tally_from_bytes(std::string_view bytes) {
  ByteReader in(bytes);
  if (in.get<std::uint32_t>() != kTallyVersion) throw IoError("a tally of another version of surveymc");
  Tally t;
  kTallyFields(in, t);
  if (in.left() != 0) throw IoError("damaged: data behind the tally");
  return t;
}

}  // namespace surveymc::stats
