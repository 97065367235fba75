#pragma once
/// Merging of block tallies along a fixed tree, so that the bits do not depend on which thread, rank or part computed a
/// block.
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "stats/tally.h"

namespace surveymc::montecarlo {

/// A node of the fixed binary tree over the block number: (level, index) holds blocks index 2^level to
/// (index + 1) 2^level - 1. Any two nodes are nested or apart.
struct Subtree {
  int level = 0;
  std::uint64_t index = 0;
  stats::Tally tally;

  std::uint64_t first_block() const { return index << level; }
  std::uint64_t end_block() const { return (index + 1) << level; }
};

/// level, index, tally as bytes, and back. Throws IoError, also where the numbers are those of no node.
std::string subtree_to_bytes(const Subtree& node);
Subtree subtree_from_bytes(std::string_view bytes);

/// A list of nodes among the fields of more bytes (bytes_of(), value_from()).
void subtree_fields(ByteWriter& out, const std::vector<Subtree>& nodes);
void subtree_fields(ByteReader& in, std::vector<Subtree>& nodes);

/// Nodes that hold every block of `nodes` once, in order of the blocks: nodes within another node are left out.
std::vector<Subtree> disjoint_subtrees(std::vector<Subtree> nodes);

/// Merges block tallies along the tree, in whatever order they arrive. Holds a few tallies per level at a time, not one
/// per block.
class OrderedMerge {
 public:
  void add(std::uint64_t block, stats::Tally tally) { add(Subtree{0, block, std::move(tally)}, false); }
  /// A node whose blocks were not added before; `saved`: take_unsaved() leaves it out.
  void add(Subtree node, bool saved);
  /// The tally of blocks 0 .. n - 1, all of which have been added. Nodes without a sibling at the right end are merged
  /// from left to right. More blocks may be added afterwards.
  stats::Tally whole() const;
  /// Largest nodes that were made since the last call and were not added as saved.
  void take_unsaved(const std::function<void(const Subtree&)>& save);
  /// All largest nodes, in order of the blocks. The merge is empty afterwards.
  std::vector<Subtree> take();

 private:
  struct Node {
    Subtree subtree;
    bool saved = false;
  };
  std::map<std::pair<int, std::uint64_t>, Node> waiting_;  // (level, index) whose sibling has not come yet
};

}  // namespace surveymc::montecarlo
