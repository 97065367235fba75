#include "chained/linearised_station.h"

#include <Eigen/Geometry>

#include "chained/reading_residual.h"

namespace surveymc::chained {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Vector3d interference_N(const Model& m, const Point& at, int k) {
  if (m.interference.states() == 0) return Vector3d::Zero();
  return m.interference.weight(k) * (m.interference.directions * at.interference);
}

ToolFrame<double> tool_frame(const Matrix3d& frame) {
  return {survey::from_eigen(Vector3d(frame.col(0))), survey::from_eigen(Vector3d(frame.col(2)))};
}

/// Of a station's readings, not weighted.
std::array<double, 6> residual_at(const Model& m, const Readings& readings, const Point& at, int k) {
  const auto i = static_cast<std::size_t>(k);
  ChainArray c;
  Eigen::Map<ChainVector>(c.data()) = at.chain[i];
  return reading_residual<double>(m.gravity, m.horizontal, m.down, readings.y[i], tool_frame(at.frames[i]), c,
                                  survey::from_eigen(interference_N(m, at, k)));
}

}  // namespace

StationLinear linearise(const Model& m, const Readings& readings, const Point& at, int k) {
  const auto i = static_cast<std::size_t>(k);
  const Matrix3d& frame = at.frames[i];
  const Vector3d n = frame.col(0), d = frame.col(2), a = interference_N(m, at, k);
  const ChainVector& c = at.chain[i];
  const std::array<double, 6> e = residual_at(m, readings, at, k);
  const Vector3d f = -(m.gravity + c[0]) * d;
  const Vector3d h = frame * (Vector3d(m.horizontal + c[1], 0, m.down + c[2]) + a);
  StationLinear s;
  s.residual = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(e.data());
  s.by_delta.topRows<3>() = -survey::cross_matrix(f);
  s.by_delta.bottomRows<3>() = -survey::cross_matrix(h);
  s.by_chain.setZero();
  for (Index axis = 0; axis < 3; ++axis) {
    s.by_chain(axis, kGravityError) = -d[axis];
    s.by_chain(axis, kAccelerometerOffset + axis) = 1;
    s.by_chain(3 + axis, kHorizontalError) = n[axis];
    s.by_chain(3 + axis, kDownError) = d[axis];
    s.by_chain(3 + axis, kMagnetometerOffset + axis) = 1;
  }
  s.by_interference.setZero(6, m.interference.states());
  s.by_interference.bottomRows<3>() = m.interference.weight(k) * frame * m.interference.directions;
  for (std::size_t r = 0; r < 6; ++r) {
    const double w = readings.used(k, r) ? 1 / m.noise[r] : 0;
    const auto row = static_cast<Index>(r);
    s.residual[row] *= w;
    s.by_delta.row(row) *= w;
    s.by_chain.row(row) *= w;
    s.by_interference.row(row) *= w;
  }
  return s;
}

StationCurvature curvature(const Model& m, const StationLinear& s, const Point& at, int k) {
  const auto i = static_cast<std::size_t>(k);
  const Matrix3d& frame = at.frames[i];
  const Vector3d n = frame.col(0), d = frame.col(2), a = interference_N(m, at, k);
  const Vector3d f = -(m.gravity + at.chain[i][kGravityError]) * d;
  const Vector3d north_down(m.horizontal + at.chain[i][kHorizontalError], 0, m.down + at.chain[i][kDownError]);
  const Vector3d h = frame * (north_down + a);
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> noise(m.noise.data());
  const Eigen::Matrix<double, 6, 1> u = s.residual.cwiseQuotient(noise);  // 0 for readings left out
  const Vector3d uf = u.head<3>(), uh = u.tail<3>();
  const auto turn = [](const Vector3d& w, const Vector3d& v) -> Matrix3d {
    return (w * v.transpose() + v * w.transpose()) / 2 - w.dot(v) * Matrix3d::Identity();
  };
  StationCurvature c;
  c.delta_delta = turn(uf, f) + turn(uh, h);
  c.delta_chain.col(kGravityError) = -d.cross(uf);
  c.delta_chain.col(kHorizontalError) = n.cross(uh);
  c.delta_chain.col(kDownError) = d.cross(uh);
  c.delta_interference.setZero(3, m.interference.states());
  for (Index q = 0; q < m.interference.states(); ++q)
    c.delta_interference.col(q) = m.interference.weight(k) * (frame * m.interference.directions.col(q)).cross(uh);
  return c;
}

void step_station(Point& point, int k, const Vector3d& delta, const ChainVector& dc) {
  const auto i = static_cast<std::size_t>(k);
  Matrix3d& m = point.frames[i];
  const ToolFrame<double> next = turned<double>(survey::from_eigen(delta), tool_frame(m));
  m.col(0) = survey::to_eigen(next.n);
  m.col(1) = survey::to_eigen(cross(next.d, next.n));
  m.col(2) = survey::to_eigen(next.d);
  point.chain[i] += dc;
}

double readings_cost(const Model& m, const Readings& readings, const Point& at) {
  double sum = 0;
  for (int k = 0; k < readings.stations(); ++k) {
    const std::array<double, 6> e = residual_at(m, readings, at, k);
    for (std::size_t r = 0; r < 6; ++r)
      if (readings.used(k, r)) sum += (e[r] / m.noise[r]) * (e[r] / m.noise[r]);
  }
  return sum;
}

double chain_cost(const Model& m, const Readings& readings, const Point& at) {
  double sum = readings_cost(m, readings, at);
  const auto square = [&](double x, double sd) { sum += (x / sd) * (x / sd); };
  for (int k = 0; k < readings.stations(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const ChainVector& c = at.chain[i];
    for (std::size_t s = 0; s < kChainStates; ++s) {
      const auto state = static_cast<Eigen::Index>(s);
      if (m.independent() && s < kReferenceStates)
        square(c[state], m.reference_sd[s]);
      else if (k == 0)
        square(c[state], m.prior_sd[s]);
      else
        square(c[state] - at.chain[i - 1][state], m.link_sd[s]);
    }
  }
  for (const double a : at.interference) square(a, m.interference.prior_sd);
  for (const KnownState& known : readings.known)
    square(at.chain[static_cast<std::size_t>(known.station)][known.state] - known.value, known.sd);
  return sum;
}

Point point_of(const Solution& solution) {
  Point p;
  for (const StationEstimate& s : solution.stations) {
    p.frames.push_back(s.frame);
    p.chain.push_back(s.chain);
  }
  p.interference = solution.interference;
  return p;
}

double step_size2(const Model& m, const std::vector<Vector3d>& delta, const std::vector<ChainVector>& dc,
                  const Eigen::VectorXd& da) {
  const Eigen::Map<const ChainVector> sd(m.prior_sd.data());
  double sum = 0;
  for (std::size_t k = 0; k < delta.size(); ++k)
    sum += 1e6 * delta[k].squaredNorm() + dc[k].cwiseQuotient(sd).squaredNorm();
  return sum / static_cast<double>(delta.size()) + (da / m.interference.prior_sd).squaredNorm();
}

}  // namespace surveymc::chained
