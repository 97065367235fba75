#pragma once
/// Hashes of the contents of a result; input_hash() and content_hash() of a whole result are in result_file.h.
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "store/result_file.h"
#include "store/table.h"

namespace surveymc::store {

class Hasher;

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
  /// The next values of one map, as they are stored.
  void add(std::size_t map, std::span<const double> canonical);
  void finish(MapHashes& hashes);

 private:
  std::vector<Hasher> of_maps_;
  const std::vector<Map>& maps_;
};

/// The content hash of a result whose parts pass by, one behind the other: all tables, all samples, the maps, all
/// inputs.
class ContentHash {
 public:
  explicit ContentHash(const Provenance& provenance);
  ~ContentHash();
  ContentHash(const ContentHash&) = delete;
  ContentHash& operator=(const ContentHash&) = delete;
  /// So many tables, samples or inputs follow.
  void begin_list(std::size_t size);
  /// Its columns follow.
  void begin(const Table& table);
  void begin(const InputData& input);
  /// Its values follow, in pieces.
  void begin(const Column& column);
  void add(std::span<const double> canonical);  ///< see stored_form.h
  void add(std::span<const std::int64_t> values);
  void add(std::span<const std::string> values);
  void add(const MapHashes& maps);
  std::string hex();

 private:
  std::unique_ptr<Hasher> hasher_;
};

/// content_hash() of a result whose maps were hashed elsewhere.
std::string content_hash(const Result& result, const MapHashes& maps);

}  // namespace surveymc::store
