#pragma once
/// One error source through the drawn well without sampling.
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "orders/chain.h"
#include "propagate/well_errors.h"

namespace surveymc::propagate {

/// Mean shift and covariance of a point.
using PointMoments = orders::Moments;

/// Quadrature takes sources of at most so many draws: 41 nodes for one, 41^2 and 17^3 nodes for two and three.
inline constexpr std::size_t kMostQuadratureDraws = 3;

/// Moments of every point when source number `source` alone is in error, by Gauss-Hermite quadrature over its draws:
/// 1e-9 of the sd. A source of mode S has a draw for each leg, so that it takes a product rule. Needs 1 to
/// kMostQuadratureDraws draws (assert).
std::vector<PointMoments> source_moments(const WellErrors& errors, const std::vector<WellPoint>& points,
                                         std::size_t source);

}  // namespace surveymc::propagate
