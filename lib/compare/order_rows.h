#pragma once
/// Tables `orders` and `order_coverage` of all studies: which order of prediction a quantity needs, and what the
/// first-order ellipse holds (orders/predictions.h).
#include <string>
#include <vector>

#include "compare/comparison.h"
#include "orders/predictions.h"

namespace surveymc::compare {

/// What the trials say of a quantity; NaN: nothing.
struct OrderSample {
  Estimate sd = {};
  double skewness = kNaN, kurtosis = kNaN;
};
OrderSample order_sample(const stats::SampleSummary& found, const VerdictRule& rule);

/// A row of table `orders` (docs/results-format.md): the component of the position along `direction`, m. The caller has
/// written the leading columns. `predictions` with `second`; `inputs`: names of the chain's normals.
void write_order(TableRows& t, const std::string& quantity, const Eigen::Vector3d& direction,
                 const orders::Predictions& predictions, const orders::WantedOrders& wanted,
                 const std::vector<std::string>& inputs, const OrderSample& found, const VerdictRule& rule);

/// Three rows of table `order_coverage`: what the horizontal ellipses of 1, 2 and 3 sigma of `first` hold, by the
/// mixture and by trials. `leading` writes the leading columns of each row. `inside`: trials in each; null: not
/// counted.
template <class Leading>
void write_order_coverage(TableRows& t, const orders::Mixture& mixture, const orders::Moments& first,
                          const std::uint64_t* inside, std::uint64_t trials, double confidence, Leading leading) {
  const std::vector<double> sigmas{1, 2, 3},
      shares = orders::inside_ellipse(mixture, first.mean, first.covariance, sigmas);
  for (std::size_t k = 0; k < sigmas.size(); ++k) {
    const bool is_counted = inside != nullptr && std::isfinite(shares[k]);
    leading();
    t.number("sigma", "1", "size of the ellipse", sigmas[k]);
    t.number("normal", "1", "share of a normal distribution in its own ellipse",
             1 - std::exp(-0.5 * sigmas[k] * sigmas[k]));
    t.number("profile", "1", "share by the profile; absent where the ellipse has no area", shares[k]);
    t.share("monte_carlo", "share of the converged trials", is_counted ? inside[k] : 0, is_counted ? trials : 0,
            confidence);
  }
}

/// Map `order_needed`: the order that a quantity needs, as a number, entry of orders::kOrderNames.
inline constexpr const char* kOrderMapMeaning =
    "order of prediction that the lateral needs: 0 first, 1 second, 2 profile, 3 sample; NaN where undetermined";
/// `predictions` with the profile; `margin`: of verdicts.
double order_value(const orders::Predictions& predictions, const Eigen::Vector3d& direction, double margin);
/// Table `order_shares` of such a map.
store::Table order_shares_table(const std::string& quantity, const std::vector<double>& orders);

}  // namespace surveymc::compare
