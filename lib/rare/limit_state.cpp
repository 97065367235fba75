#include "rare/limit_state.h"

#include <vector>

namespace surveymc::rare {

Eigen::VectorXd values_at(const LimitState& state, const Eigen::MatrixXd& z) {
  const int count = static_cast<int>(z.cols()), groups = survey::groups_for(count);
  survey::LaneArray lanes(groups, state.dimension());
  for (int t = 0; t < groups * simd::kGroup; ++t)
    for (int i = 0; i < state.dimension(); ++i)
      lanes.row(t / simd::kGroup, i)[t % simd::kGroup] = z(i, std::min(t, count - 1));
  std::vector<double> g(static_cast<std::size_t>(groups * simd::kGroup));
  if (count > 0) state.evaluate(lanes, groups, g.data());
  return Eigen::Map<const Eigen::VectorXd>(g.data(), count);
}

}  // namespace surveymc::rare
