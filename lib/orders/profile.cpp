#include "orders/profile.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "stats/linear_algebra.h"
#include "stats/normal_tail.h"

namespace surveymc::orders {
namespace {

/// The rest of the normals at one node.
struct Node {
  double t;
  Eigen::Vector3d shift;
  Eigen::Matrix3Xd across;                                          ///< J (1 - v v')
  Eigen::Matrix3d covariance, with_next = Eigen::Matrix3d::Zero();  ///< across across', and with that of the next node
};

std::vector<double> even_grid(double reach, int count) {
  std::vector<double> t;
  for (int i = 0; i < count; ++i) t.push_back(reach * (2.0 * i / (count - 1) - 1));
  return t;
}

Node node_at(double t, const Expansion& e, const Eigen::VectorXd& v) {
  Node n{t, {}, e.first - (e.first * v) * v.transpose(), {}};
  n.covariance = n.across * n.across.transpose();
  for (Eigen::Index a = 0; a < 3; ++a)
    n.shift[a] = (e.trace[a] - v.dot(e.along[static_cast<std::size_t>(a)].col(0))) / 2;
  return n;
}

/// tr(H_a H_b) of the rest, P H P with P = 1 - v v'.
Eigen::Matrix3d squares_of_rest(const Expansion& e, const Eigen::VectorXd& v) {
  Eigen::Matrix3d s = e.squares;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      const auto ha = e.along[a].col(0), hb = e.along[b].col(0);
      s(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) += v.dot(ha) * v.dot(hb) - 2 * ha.dot(hb);
    }
  return s;
}

std::vector<Node> without_wild(std::vector<Node> nodes) {
  std::vector<double> variances;
  for (const Node& n : nodes)
    if (n.covariance.allFinite()) variances.push_back(n.covariance.trace());
  if (variances.empty()) return {};
  std::nth_element(variances.begin(), variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 2),
                   variances.end());
  const double most = kWildVariance * variances[variances.size() / 2];
  const auto is_wild = [most](const Node& n) {
    return !(n.covariance.allFinite() && n.shift.allFinite() && n.covariance.trace() <= most);
  };
  nodes.erase(std::remove_if(nodes.begin(), nodes.end(), is_wild), nodes.end());
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const Eigen::Matrix3d both = nodes[i - 1].across * nodes[i].across.transpose();
    nodes[i - 1].with_next = both + both.transpose();
  }
  return nodes;
}

struct Rest {
  Eigen::Vector3d shift;
  Eigen::Matrix3d covariance;
};
/// J linear between the nodes, constant beyond.
Rest between(const std::vector<Node>& nodes, double t) {
  if (t <= nodes.front().t) return {nodes.front().shift, nodes.front().covariance};
  for (std::size_t i = 1; i < nodes.size(); ++i)
    if (t <= nodes[i].t) {
      const Node &a = nodes[i - 1], &b = nodes[i];
      const double s = (t - a.t) / (b.t - a.t), r = 1 - s;
      return {r * a.shift + s * b.shift, r * r * a.covariance + s * s * b.covariance + r * s * a.with_next};
    }
  return {nodes.back().shift, nodes.back().covariance};
}

Mixture mixture_of(const Profile& p, const std::vector<Node>& nodes, const Eigen::Matrix3d& curvature) {
  Mixture mixture;
  for (std::size_t i = 0; i < p.t.size(); ++i) {
    const Rest rest = between(nodes, p.t[i]);
    mixture.push_back(
        {p.weights[i], p.path.col(static_cast<Eigen::Index>(i)) + rest.shift, rest.covariance + curvature / 2});
  }
  return mixture;
}

/// A leap is a step of more than three times both its neighbours; at a fold the step before it is some 1.5 to 2.4 times
/// the one before that.
std::vector<Jump> jumps_of(const Profile& p) {
  constexpr double kLeap = 3;
  std::vector<Jump> jumps;
  const auto step = [&p](std::size_t i) {
    return (p.path.col(static_cast<Eigen::Index>(i + 1)) - p.path.col(static_cast<Eigen::Index>(i))).norm();
  };
  for (std::size_t i = 1; i + 2 < p.t.size(); ++i) {
    if (!(step(i) > kLeap * std::max(step(i - 1), step(i + 1)))) continue;
    const bool is_right = p.t[i] + p.t[i + 1] > 0;
    const std::size_t from = is_right ? i : i + 1, to = is_right ? i + 1 : i;
    jumps.push_back({p.t[from], p.t[to],
                     p.path.col(static_cast<Eigen::Index>(to)) - p.path.col(static_cast<Eigen::Index>(from)),
                     stats::normal_upper_tail(std::abs(p.t[i] + p.t[i + 1]) / 2)});
  }
  return jumps;
}

}  // namespace

Mixture without_gaps(const Profile& p) {
  Mixture mixture = p.mixture;
  const auto step = [&p](std::size_t i) -> Eigen::Vector3d {
    return p.path.col(static_cast<Eigen::Index>(i + 1)) - p.path.col(static_cast<Eigen::Index>(i));
  };
  for (std::size_t i = 0; i < mixture.size() && mixture.size() > 1; ++i) {
    // The shorter of the steps beside it: the longer one may be a jump.
    Eigen::Vector3d own = step(std::min(i, mixture.size() - 2));
    if (i > 0 && step(i - 1).norm() < own.norm()) own = step(i - 1);
    mixture[i].covariance += own * own.transpose() / 4;
  }
  return mixture;
}

Profile profile(const PathChain& chain, const Centre& centre, const ProfileOptions& options) {
  assert(options.grid >= 3 && options.nodes >= 3 && options.nodes % 2 == 1);
  const Eigen::Index d = chain.dimension();
  const Expansion& e = centre.expansion;
  Profile p;
  const Eigen::Matrix2d horizontal = (e.first * e.first.transpose()).topLeftCorner<2, 2>();
  p.axis << stats::symmetric_eigen<2>(horizontal).vectors.col(1), 0;
  p.direction = e.first.transpose() * p.axis;
  const double length = p.direction.norm();
  if (!(length > 0)) {
    p.direction = Eigen::VectorXd::Zero(d);
    p.t = {0};
    p.weights = {1};
    p.path = centre.value;
    p.mixture = p.coarse = {{1, centre.value + e.trace / 2, e.first * e.first.transpose() + e.squares / 2}};
    return p;
  }
  p.direction /= length;

  const std::vector<double> grid = even_grid(kGridReach, options.grid);
  const Path path = chain.path(p.direction, grid);
  std::vector<Eigen::Index> found;
  for (Eigen::Index i = 0; i < path.at.cols(); ++i)
    if (path.at.col(i).allFinite()) found.push_back(i);
  p.points_left_out = static_cast<int>(path.at.cols()) - static_cast<int>(found.size());
  p.path = path.at(Eigen::all, found);
  double sum = 0;
  for (const Eigen::Index i : found) {
    p.t.push_back(grid[static_cast<std::size_t>(i)]);
    p.weights.push_back(std::exp(-0.5 * p.t.back() * p.t.back()));
    sum += p.weights.back();
  }
  for (double& w : p.weights) w /= sum;
  p.jumps = jumps_of(p);

  ExpansionParts parts;
  parts.directions = p.direction;
  std::vector<Node> nodes, every_other;
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();  // of the rest, at the middle node, which is the centre
  for (const double t : even_grid(kNodeReach, options.nodes)) {
    const auto nearest = std::min_element(found.begin(), found.end(), [&](Eigen::Index a, Eigen::Index b) {
      return std::abs(grid[static_cast<std::size_t>(a)] - t) < std::abs(grid[static_cast<std::size_t>(b)] - t);
    });
    if (nearest == found.end()) break;
    const Eigen::VectorXd state =
        path.states.rows() > 0 ? Eigen::VectorXd(path.states.col(*nearest)) : Eigen::VectorXd();
    Expansion at = chain.expand(t * p.direction, state, parts);
    nodes.push_back(node_at(t, at, p.direction));
    if (nodes.size() % 2 == 1) every_other.push_back(nodes.back());
    if (t != 0) continue;
    at.squares = e.squares;
    curvature = squares_of_rest(at, p.direction);
  }
  const std::size_t all = nodes.size();
  nodes = without_wild(nodes);
  every_other = without_wild(every_other);
  p.nodes_left_out = static_cast<int>(all - nodes.size());
  if (nodes.empty() || every_other.empty()) return p;

  p.mixture = mixture_of(p, nodes, curvature);
  p.coarse = mixture_of(p, every_other, curvature);
  return p;
}

}  // namespace surveymc::orders
