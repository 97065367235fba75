#include "montecarlo/ordered_merge.h"

#include <algorithm>

#include "base/error.h"
#include "stats/tally_bytes.h"

namespace surveymc::montecarlo {

std::string subtree_to_bytes(const Subtree& node) {
  ByteWriter out;
  out.fields(node.level, node.index);
  const std::string tally = stats::tally_to_bytes(node.tally);
  out.put(tally.data(), tally.size());
  return out.take();
}

Subtree subtree_from_bytes(std::string_view bytes) {
  constexpr int kHighest = 62;
  ByteReader in(bytes);
  Subtree node;
  in.fields(node.level, node.index);
  if (node.level < 0 || node.level > kHighest || node.index >= (std::uint64_t{1} << (kHighest - node.level)))
    throw IoError("damaged: no such block");
  node.tally = stats::tally_from_bytes(in.raw(in.left()));
  return node;
}

void subtree_fields(ByteWriter& out, const std::vector<Subtree>& nodes) {
  out.length_of(16, nodes);
  for (const Subtree& n : nodes) out.put(subtree_to_bytes(n));
}

void subtree_fields(ByteReader& in, std::vector<Subtree>& nodes) {
  in.length_of(16, nodes);
  for (Subtree& n : nodes) n = subtree_from_bytes(in.text());
}

std::vector<Subtree> disjoint_subtrees(std::vector<Subtree> nodes) {
  // By first block, the largest first: a node that begins before the end of the node before lies within it.
  std::stable_sort(nodes.begin(), nodes.end(), [](const Subtree& a, const Subtree& b) {
    return std::pair{a.first_block(), -a.level} < std::pair{b.first_block(), -b.level};
  });
  std::vector<Subtree> kept;
  for (Subtree& n : nodes)
    if (kept.empty() || n.first_block() >= kept.back().end_block()) kept.push_back(std::move(n));
  return kept;
}

void OrderedMerge::add(Subtree node, bool saved) {
  for (;;) {
    const auto sibling = waiting_.find({node.level, node.index ^ 1});
    if (sibling == waiting_.end()) break;
    stats::Tally& other = sibling->second.subtree.tally;
    if (node.index % 2 == 0) {
      node.tally.merge(other);
    } else {
      other.merge(node.tally);
      node.tally = std::move(other);
    }
    saved = saved && sibling->second.saved;
    waiting_.erase(sibling);
    node.index /= 2;
    ++node.level;
  }
  const std::pair key{node.level, node.index};
  waiting_.emplace(key, Node{std::move(node), saved});
}

stats::Tally OrderedMerge::whole() const {
  // Without gaps the complete subtrees left over have falling levels from left to right.
  stats::Tally sum;
  for (auto node = waiting_.rbegin(); node != waiting_.rend(); ++node) sum.merge(node->second.subtree.tally);
  return sum;
}

void OrderedMerge::take_unsaved(const std::function<void(const Subtree&)>& save) {
  for (auto& [key, node] : waiting_) {
    if (!node.saved) save(node.subtree);
    node.saved = true;
  }
}

std::vector<Subtree> OrderedMerge::take() {
  std::vector<Subtree> nodes;
  for (auto& [key, node] : waiting_) nodes.push_back(std::move(node.subtree));
  waiting_.clear();
  return disjoint_subtrees(std::move(nodes));
}

}  // namespace surveymc::montecarlo
