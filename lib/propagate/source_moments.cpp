#include "propagate/source_moments.h"

#include <cassert>

#include "propagate/drawn_well.h"
#include "stats/gauss_hermite.h"

namespace surveymc::propagate {

std::vector<PointMoments> source_moments(const WellErrors& errors, const std::vector<WellPoint>& points,
                                         std::size_t source) {
  std::vector<bool> keep(errors.sources.size(), false);
  keep[source] = true;
  const WellErrors own = only_sources(errors, keep);
  const std::vector<std::uint32_t>& draws = errors.sources[source].draws;
  assert(!draws.empty() && draws.size() <= kMostQuadratureDraws);
  const stats::GaussHermite rule = stats::gauss_hermite(draws.size() < 3 ? 41 : 17);
  std::vector<PointMoments> out(points.size());
  std::vector<double> z(errors.draws.size(), 0.0);
  std::vector<std::size_t> node(draws.size(), 0);
  for (bool more = true; more;) {
    double weight = 1;
    for (std::size_t i = 0; i < draws.size(); ++i) {
      z[draws[i]] = rule.nodes[node[i]];
      weight *= rule.weights[node[i]];
    }
    const std::vector<double> r = drawn_positions(own, points, z);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Eigen::Vector3d at(r[3 * p], r[3 * p + 1], r[3 * p + 2]);
      out[p].mean += weight * at;
      out[p].covariance += weight * at * at.transpose();
    }
    std::size_t i = 0;
    while (i < node.size() && ++node[i] == rule.nodes.size()) node[i++] = 0;
    more = i < node.size();
  }
  for (PointMoments& m : out) m.covariance -= m.mean * m.mean.transpose();
  return out;
}

}  // namespace surveymc::propagate
