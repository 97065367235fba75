#include "store/content_hash.h"

#include <bit>
#include <cstdint>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "store/result_file.h"
#include "store/stored_form.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc {
namespace {

/// XXH3-128 over a serialisation in which every list and text is preceded by its length: no two results share one.
class Hasher {
 public:
  Hasher() { XXH3_128bits_reset(&state_); }

  void add(std::uint64_t x) { XXH3_128bits_update(&state_, &x, sizeof x); }
  void add(std::int64_t x) { add(static_cast<std::uint64_t>(x)); }
  void add(double x) { add(std::bit_cast<std::uint64_t>(canonical_number(x))); }
  void add(const std::string& text) {
    const std::string canonical = canonical_text(text);
    add(std::uint64_t{canonical.size()});
    XXH3_128bits_update(&state_, canonical.data(), canonical.size());
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
  void add(const Column& c) { add(c.name, c.unit, c.long_name, c.ancillary, c.values); }
  void add(const Axis& a) { add(a.name, a.unit, a.long_name, a.values); }
  void add(const Table& t) { add(t.name, t.long_name, t.columns); }
  void add(const Map& m) { add(m.name, m.unit, m.long_name, m.axes, m.values); }
  void add(const InputData& i) { add(i.path, i.hash, i.table.long_name, i.table.columns); }
  template <class First, class Second, class... More>
  void add(const First& first, const Second& second, const More&... more) {
    add(first), add(second), (add(more), ...);
  }

  std::string hex() const {
    const XXH128_hash_t h = XXH3_128bits_digest(&state_);
    return fmt::format("{:016x}{:016x}", h.high64, h.low64);
  }

 private:
  XXH3_state_t state_;
};

}  // namespace

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

std::string content_hash(const Result& result) {
  const Provenance& p = result.provenance;
  Hasher h;
  h.add(std::string("surveymc result 1"));
  h.add(p.title, p.experiment, p.config, p.config_hash, p.seed, p.trials);
  h.add(result.tables, result.samples, result.maps, result.inputs);
  return h.hex();
}

}  // namespace surveymc
