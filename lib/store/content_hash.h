#pragma once
/// Hashes of the contents of a result; input_hash() and content_hash() of a whole result are in result_file.h.
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "store/result_file.h"
#include "store/stored_form.h"
#include "store/table.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace surveymc::store {

/// XXH3-128 over a serialisation in which every list and text is preceded by its length: no two results share one.
class Hasher {
 public:
  Hasher() { XXH3_128bits_reset(&state_); }

  void add(std::uint64_t x) { add_bytes(&x, sizeof x); }
  void add(std::int64_t x) { add(static_cast<std::uint64_t>(x)); }
  void add(const std::string& text);
  /// The length of a list, then its values.
  template <class T>
  void add(const std::vector<T>& list) {
    add(std::uint64_t{list.size()});
    for_each_stored(list, [&](const auto& values) { this->add_values(values); });
  }
  template <class... T>
  void add(const std::variant<T...>& values) {
    add(std::uint64_t{values.index()});
    std::visit([&](const auto& v) { add(v); }, values);
  }
  template <class First, class Second, class... More>
  void add(const First& first, const Second& second, const More&... more) {
    add(first), add(second), (add(more), ...);
  }

  /// Values as they are stored, of a list whose length was added.
  template <class T>
  void add_values(std::span<const T> values) {
    if constexpr (std::is_same_v<T, std::string>)
      for (const std::string& text : values) add(text);
    else
      add_bytes(values.data(), values.size_bytes());
  }

  std::string hex();

 private:
  void add_bytes(const void* bytes, std::size_t count);
  void flush();

  XXH3_state_t state_;
  std::array<char, 4096> gathered_;
  std::size_t used_ = 0;
};

/// Hashes of a result's content begin with these; what is listed in each follows.
void add_head(Hasher& hash, const Provenance& provenance);
void add_head(Hasher& hash, const Table& table);
void add_head(Hasher& hash, const InputData& input);
void add_head(Hasher& hash, const Column& column);

/// Equal for axes that two maps can share: the same name, unit, long name and values.
std::string axis_hash(const Axis& axis);

/// Hash of every map by its name: it does not matter which maps are held and which are streamed.
using MapHashes = std::map<std::string, std::string>;
void add(Hasher& hash, const MapHashes& maps);

/// Adds the hashes of all maps of a stream. use(map, first, values) is called with their values, as they are stored, in
/// pieces.
using UseOfMap = std::function<void(std::size_t map, std::size_t first, std::span<const double> values)>;
void hash_maps(const MapStream& stream, MapHashes& hashes, const UseOfMap& use);

/// All maps of a result, also those that are held. They refer to `result`.
std::vector<MapStream> map_streams(const Result& result);

}  // namespace surveymc::store
