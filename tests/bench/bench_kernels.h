#pragma once
/// What is measured on both instruction sets: the library's kernels, parts of them, and the machine's ceilings.
#include <cstddef>

#include "estimate/msa_lanes.h"
#include "random/stream.h"
#include "sensor/simulate_lanes.h"
#include "survey/corrected_position_lanes.h"

namespace surveymc::bench {

struct Kernels {
  void (*simulate)(const sensor::SimulateBatch&);
  void (*msa_solve)(const estimate::MsaBatch&);
  void (*corrected_positions)(const survey::CorrectedPositionBatch&);

  /// 4 calls x kGroup standard normals to `out`, in some order; `calls` is a multiple of 4.
  void (*normals)(const random::Stream&, std::uint32_t calls, double* out);
  /// Sums over the readings of one group of trials, once a solve. out: rows m (3), m^2 (3), of kGroup each.
  void (*msa_sums)(const estimate::MsaData&, double* out);
  /// Normal equations of one group of trials at x = (p, q / total), x[6] = second_order, with what msa_sums gave.
  /// out: rows matrix (21), gradient (6), cost (1).
  void (*msa_evaluate)(const estimate::MsaData&, const double* sums, const double* x, bool with_matrix, double* out);
  /// Gradient of the chord iteration of one group of trials at x = (p, q / total), exact or by series.
  /// out: rows gradient (6), cost (1).
  void (*msa_gradient)(const estimate::MsaData&, const double* x, bool series, double* out);
  /// The sums of a trial's valley for one group, whose down directions have no noise. out: MsaValley::kSums rows.
  void (*msa_valley_sums)(const estimate::MsaData&, const estimate::MsaValley&, double* out);
  /// `count` times in a chain, each waiting for the one before as in a solve: factor and solution of the equations
  /// that msa_evaluate left in `in`, for one register of trials. out: 6 rows.
  void (*msa_step)(const double* in, int count, double* out);
};

/// Each does `count` rounds of kPerRound instructions on full registers that do not wait for each other.
struct Ceilings {
  static constexpr int kPerRound = 24;
  int lanes;
  void (*fused_multiply_add)(int count);
  void (*fused_and_add)(int count);  ///< half fma, half add
  void (*divide)(int count);
  void (*square_root)(int count);
  void (*multiply_integers)(int count);              ///< 32 x 32 -> 64 bit, as Philox does
  void (*load_all)(const double* p, std::size_t n);  ///< n is a multiple of 64
  void (*triad)(double* a, const double* b, const double* c, std::size_t n);
};

namespace isa_v3 {
extern const Kernels kernels;
extern const Ceilings ceilings;
}  // namespace isa_v3
namespace isa_v4 {
extern const Kernels kernels;
extern const Ceilings ceilings;
}  // namespace isa_v4

}  // namespace surveymc::bench
