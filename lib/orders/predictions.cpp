#include "orders/predictions.h"

#include <map>

#include "orders/second.h"
#include "stats/linear_algebra.h"

namespace surveymc::orders {

std::optional<Moments> Predictions::of(const std::string& name) const {
  const auto moments = [](const std::optional<SigmaPointMoments>& m) {
    return m ? std::optional(m->moments) : std::nullopt;
  };
  if (name == "first") return first;
  if (name == "second") return second;
  if (name == "unscented") return moments(unscented && !unscented->is_definite ? cubature5 : unscented);
  if (name == "cubature5") return moments(cubature5);
  return profile ? std::optional(moments_of(profile->mixture)) : std::nullopt;
}

Predictions predict(const Chain& chain, const WantedOrders& wanted,
                    const std::function<Eigen::MatrixXd(const Centre&)>& directions) {
  const bool has_second = wanted.second || wanted.profile;
  ExpansionParts parts;
  parts.squares = has_second;
  Predictions p;
  p.centre = centre_of(chain, parts);
  p.first = first_order(p.centre);
  if (has_second) p.second = second_order(chain, p.centre);
  if (wanted.profile) p.profile = profile(chain, p.centre, wanted.options);
  if (!wanted.unscented && !wanted.cubature5) return p;
  const Eigen::MatrixXd v = directions(p.centre);
  if (wanted.unscented) p.unscented = unscented(chain, p.centre, v);
  if (wanted.cubature5 || !p.unscented->is_definite) p.cubature5 = cubature5(chain, p.centre, v);
  return p;
}

Eigen::MatrixXd first_order_directions(const Centre& centre) {
  const stats::SingularValues svd = stats::singular_values(centre.expansion.first);
  const auto moving = (svd.values.array() > 1e-9 * svd.values[0]).count();
  return svd.right.leftCols(moving);
}

DominantInput dominant_input(const Eigen::Matrix3Xd& first, const std::vector<std::string>& names,
                             const Eigen::Vector3d& direction) {
  std::map<std::string, double> variances;
  double all = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double effect = direction.dot(first.col(static_cast<Eigen::Index>(i)));
    all += effect * effect;
    if (!names[i].empty()) variances[names[i]] += effect * effect;
  }
  DominantInput most;
  for (const auto& [name, variance] : variances)
    if (variance > most.share * all) most = {name, variance / all};
  return most;
}

}  // namespace surveymc::orders
