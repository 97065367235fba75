#pragma once
#include <string>
#include <vector>

namespace surveymc::simd {

/// Eight hexadecimal digits that tell apart machines and builds on which the same program gives other last bits: other
/// orders of Eigen's sums, products and sums that a compiler fuses, elementary functions that do not come with the
/// program (third_party/elementary) as they should, and `more`, what the libraries of other modules compute. A hash of
/// their values at some thousand arguments.
/// Tallies of two such machines must not mix.
std::string numerics_probe(const std::vector<double>& more = {});

/// Lets Eigen cut large products into the same blocks on every processor. It takes their length from the size of the
/// first cache, and sums of products with more than some 250 terms follow the blocks. Before anything is computed.
void fix_block_sizes();

}  // namespace surveymc::simd
