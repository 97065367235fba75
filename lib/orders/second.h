#pragma once
/// Second order, complete: the mean to second and the covariance to fourth order in the sizes of the errors.
///
/// With F(z) = F(0) + J z + z'Hz / 2 + T[z, z, z] / 6 + ... and z standard normal
///   mean        F(0) + tr H_a / 2
///   covariance  J J' + tr(H_a H_b) / 2 + (T_b[v_a, 1] + T_a[v_b, 1]) / 2,   v_a = row a of J
/// T_b[v, 1] is the change of tr H_b along v.
#include "orders/chain.h"

namespace surveymc::orders {

/// `centre` with squares.
Moments second_order(const Chain& chain, const Centre& centre);
Moments second_order(const Chain& chain);

}  // namespace surveymc::orders
