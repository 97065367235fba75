#include "stats/tally_bytes.h"

#include "base/bytes.h"

namespace surveymc::stats {
namespace {

using Eigen::Index;

void put(ByteWriter& out, const Moments& m) {
  [[maybe_unused]] const auto& [count, mean, squares, cubes, fourths] =
      m;  // fails when a member is added: write it, too
  const Index d = m.mean.size();
  out.put(m.count);
  out.put(static_cast<std::uint64_t>(d));
  const auto numbers = [&](const double* x, Index n) { out.put(x, static_cast<std::size_t>(n) * sizeof(double)); };
  numbers(m.mean.data(), d);
  numbers(m.squares.data(), d * d);
  numbers(m.cubes.data(), d);
  numbers(m.fourths.data(), d);
}

void put(ByteWriter& out, const std::vector<Moments>& list) {
  out.put(std::uint64_t{list.size()});
  for (const Moments& m : list) put(out, m);
}

Moments moments(ByteReader& in) {
  const auto count = in.get<std::uint64_t>();
  const std::size_t size = in.length(3 * sizeof(double));
  if (size > 0 && in.left() / sizeof(double) / size < size) throw IoError("damaged: a length is larger than the data");
  const auto d = static_cast<Index>(size);
  Moments m(d);
  m.count = count;
  const auto numbers = [&](double* x, Index n) { in.get(x, static_cast<std::size_t>(n) * sizeof(double)); };
  numbers(m.mean.data(), d);
  numbers(m.squares.data(), d * d);
  numbers(m.cubes.data(), d);
  numbers(m.fourths.data(), d);
  return m;
}

std::vector<Moments> moments_list(ByteReader& in) {
  std::vector<Moments> list(in.length(2 * sizeof(std::uint64_t)));
  for (Moments& m : list) m = moments(in);
  return list;
}

void put(ByteWriter& out, const std::vector<WeightedHits>& list) {
  out.put(std::uint64_t{list.size()});
  for (const auto& [count, sum, squares, largest] : list) {  // fails when a member is added: write it, too
    out.put(count);
    out.put(sum);
    out.put(squares);
    out.put(largest);
  }
}

std::vector<WeightedHits> weighted_list(ByteReader& in) {
  std::vector<WeightedHits> list(in.length(sizeof(WeightedHits)));
  for (WeightedHits& h : list) {
    h.count = in.get<std::uint64_t>();
    h.sum = in.get<double>();
    h.squares = in.get<double>();
    h.largest = in.get<double>();
  }
  return list;
}

}  // namespace

std::string tally_to_bytes(const Tally& t) {
  // Fails to compile when a member is added: then write it below, read it in tally_from_bytes, and raise kTallyVersion.
  [[maybe_unused]] const auto& [trials, failed, left_out, moments_, groups, controlled, pairs, controlled_pairs, counts,
                                failed_trials, samples, weighted, proposal] = t;
  ByteWriter out;
  out.put(kTallyVersion);
  out.put(t.trials);
  out.put(t.failed);
  out.put(t.left_out);
  put(out, t.moments);
  put(out, t.groups);
  put(out, t.controlled);
  put(out, t.pairs);
  put(out, t.controlled_pairs);
  out.put(t.counts);
  out.put(t.failed_trials);
  out.put(t.samples);
  put(out, t.weighted);
  out.put(t.proposal);
  return out.take();
}

Tally tally_from_bytes(std::string_view bytes) {
  ByteReader in(bytes);
  if (in.get<std::uint32_t>() != kTallyVersion) throw IoError("a tally of another version of surveymc");
  Tally t;
  t.trials = in.get<std::uint64_t>();
  t.failed = in.get<std::uint64_t>();
  t.left_out = in.get<std::uint64_t>();
  t.moments = moments(in);
  t.groups = moments_list(in);
  t.controlled = moments_list(in);
  t.pairs = moments(in);
  t.controlled_pairs = moments_list(in);
  t.counts = in.list<std::uint64_t>();
  t.failed_trials = in.list<std::uint64_t>();
  t.samples = in.list<double>();
  t.weighted = weighted_list(in);
  t.proposal = in.get<std::uint64_t>();
  if (in.left() != 0) throw IoError("damaged: data behind the tally");
  return t;
}

}  // namespace surveymc::stats
