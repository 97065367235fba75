#pragma once
/// All predictions of one chain, as a study shows them beside each other.
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "orders/order_needed.h"
#include "orders/profile.h"
#include "orders/sigma_points.h"

namespace surveymc::orders {

/// Which are wanted. First order, which costs next to nothing, always is.
struct WantedOrders {
  bool second = false, unscented = false, cubature5 = false, profile = false;
  ProfileOptions options = {};
};
inline constexpr std::array<const char*, 5> kFormulationNames{"first", "second", "unscented", "cubature5", "profile"};

struct Predictions {
  Centre centre;
  Moments first;
  std::optional<Moments> second;
  std::optional<SigmaPointMoments> unscented, cubature5;
  std::optional<Profile> profile;

  /// Of one of kFormulationNames; none where it is not wanted. A covariance of `unscented` that is none is replaced by
  /// that of cubature5.
  std::optional<Moments> of(const std::string& name) const;
};

/// `directions`: those of the sigma points (d x r, orthonormal), read where these are wanted. With the profile comes
/// the second order, without which it has no verdict.
Predictions predict(const Chain& chain, const WantedOrders& wanted,
                    const std::function<Eigen::MatrixXd(const Centre&)>& directions);

/// The directions that move the position to first order, at most three: right singular vectors of J.
Eigen::MatrixXd first_order_directions(const Centre& centre);

/// The input with the largest share in the first-order variance of a component: `names` has one a normal; normals of
/// one name count together, those without ("") not at all.
struct DominantInput {
  std::string name;
  double share = 0;
};
DominantInput dominant_input(const Eigen::Matrix3Xd& first, const std::vector<std::string>& names,
                             const Eigen::Vector3d& direction);

}  // namespace surveymc::orders
