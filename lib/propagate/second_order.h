#pragma once
/// Beyond first order, without sampling: mean shift and covariance of a drawn well's point by the derivatives of its
/// path.
///
/// With x the four numbers of all stations (well_errors.h), normal with covariance S, the displacement of the point is
/// l + q + c + ...: g'x, x'Hx / 2, T[x, x, x] / 6. Then
///   mean        tr(H S) / 2                                              errors of fourth order in the sizes
///   covariance  cov(l_a, l_b) + tr(H_a S H_b S) / 2 + (T_b[v_a, S] + T_a[v_b, S]) / 2,  v_a = cov(x, l_a)
/// which is complete to fourth order. H and T have blocks of neighbouring stations alone, and S is low rank (errors of
/// several stations) plus blocks (errors of one): the time is linear in stations.
#include "propagate/source_moments.h"
#include "propagate/well_errors.h"

namespace surveymc::propagate {

PointMoments second_order_moments(const WellErrors& errors, const WellPoint& point);

}  // namespace surveymc::propagate
