#pragma once
/// Which order a quantity needs, without a trial.
///
///   first    |e2| < margin / 2, |m2| < 0.1 and |e4| < margin / 2
///   second   |e4| < margin / 2 and |kurtosis of the profile - 3| < 0.5
///   profile  what is left of the profile is small: its sd by half of the nodes differs by less than margin / 2
///   sample   none of these
/// with e2 = sd_second / sd_first - 1, m2 = mean_second / sd_first, e4 = sd_profile / sd_second - 1. A jump within 4.5
/// normals that moves the quantity by more than its sd needs the profile at least.
#include <array>
#include <optional>

#include "orders/profile.h"

namespace surveymc::orders {

enum class Order { first, second, profile, sample };
inline constexpr std::array<const char*, 4> kOrderNames{"first", "second", "profile", "sample"};
inline constexpr double kJumpReach = 4.5;

struct OrderVerdict {
  double e2 = 0, m2 = 0, e4 = 0;
  double remainder = 0;      ///< sd of the profile by half of its nodes over that by all, less 1
  double kurtosis = 3;       ///< of the profile
  std::optional<Jump> jump;  ///< the likeliest that counts for the quantity
  Order order = Order::first;
};

/// Of the component along `direction`. A component that first order does not move needs the second order: e2 and m2
/// are infinite.
OrderVerdict order_needed(const Moments& first, const Moments& second, const Profile& profile,
                          const Eigen::Vector3d& direction, double margin);

}  // namespace surveymc::orders
