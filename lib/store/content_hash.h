#pragma once
/// Hashes of what a result holds; input_hash() and content_hash() of a whole result are in result_file.h.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "store/result_file.h"
#include "store/table.h"

namespace surveymc::store {

/// Equal for axes that two maps can share: the same name, unit, long name and values.
std::string axis_hash(const Axis& axis);

/// Hash of every map by its name.
using MapHashes = std::map<std::string, std::string>;

MapHashes held_map_hashes(const std::vector<Map>& maps);

/// Hashes of the maps of a stream while their values pass by.
class StreamHash {
 public:
  explicit StreamHash(const std::vector<Map>& maps);
  ~StreamHash();
  StreamHash(const StreamHash&) = delete;
  StreamHash& operator=(const StreamHash&) = delete;
  /// Values of every map, in order, without gaps.
  void add(const std::vector<std::vector<double>>& piece);
  void finish(MapHashes& hashes) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  const std::vector<Map>& maps_;
};

/// content_hash() of a result whose maps were hashed elsewhere.
std::string content_hash(const Result& result, const MapHashes& maps);

}  // namespace surveymc::store
