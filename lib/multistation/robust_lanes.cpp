#include "multistation/robust_lanes.h"

namespace surveymc::multistation::SURVEYMC_ISA {

using namespace simd;
using simd::store;

namespace {

using T = Lanes;

template <int C>
RobustOutcome<T> reweighted(const FitPlan& plan, const FitData& data, const RobustProblem& problem,
                            const RobustOptions& options, const double* from, T* memory) {
  std::array<T, kUnknowns> start;
  for (int i = 0; i < plan.size(); ++i) start[static_cast<std::size_t>(i)] = T(from[i]);
  return reweight<T, C>(problem, options, FitRows<T, C>{plan, data}, start.data(), memory);
}

}  // namespace

void robust_batch(const RobustBatch& b) {
  const FitPlan& plan = *b.fit.plan;
  const RobustShape& shape = b.problem.shape;
  T* const memory = reinterpret_cast<T*>(b.scratch);
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.fit.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) {
      const FitData data = data_of(b.fit, group, lane);
      RobustProblem problem = b.problem;
      if (problem.subsets) problem.subsets += group * b.subsets_stride;
      problem.given_weights = data.weight;
      const RobustOutcome<T> out = shape.components == 2
                                       ? reweighted<2>(plan, data, problem, b.options, b.start, memory)
                                       : reweighted<3>(plan, data, problem, b.options, b.start, memory);
      const RobustMemory<T> m(memory, shape);
      store_estimate(b.fit, group, lane, m.x);
      for (int k = 0; k < shape.stations; ++k)
        store(b.weights + group * b.weights_stride + static_cast<std::size_t>(k) * kGroup + lane, m.weight[k]);
      store(b.fit.converged + group * b.fit.scalar_stride + lane, out.converged);
      store(b.scale + group * b.scalar_stride + lane, out.scale);
      store(b.reweightings + group * b.scalar_stride + lane, out.reweightings);
    }
}

}  // namespace surveymc::multistation::SURVEYMC_ISA
