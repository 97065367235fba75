#include "disturbance/station_disturbance.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace surveymc::disturbance {
StationDisturbance::StationDisturbance(Disturbance disturbance, const survey::ReferenceField& field,
                                       std::vector<StationDraw> draws)
    : d_(std::move(disturbance)), draws_(std::move(draws)) {
  // A series has values at its steps alone. Stations are put on steps once: lags that are rounded one by one need not
  // be differences of any times, and their correlations then no correlation matrix.
  if (d_.process.kind == Kind::series && !d_.times.empty()) {
    const double first = d_.times.front(), step = d_.process.series->step;
    for (double& t : d_.times) t = std::round((t - first) / step) * step;
  }
  if (d_.keeps_normals()) {
    std::map<std::uint32_t, std::size_t> last;
    for (std::size_t i = 0; i < draws_.size(); ++i) {
      const auto found = last.find(draws_[i].source);
      before_.push_back(found == last.end() ? -1 : static_cast<std::ptrdiff_t>(found->second));
      memory_.push_back(found == last.end() ? 0 : correlation(draws_[found->second], draws_[i]));
      last[draws_[i].source] = i;
    }
    return;
  }
  unit_ = elements_by_field(field);
  const Eigen::Vector3d variance = (unit_ * covariance(d_.process, 0) * unit_.transpose()).diagonal();
  for (int e = 0; e < kElements; ++e) {
    const double sd = std::sqrt(variance[e]);
    sizes_[static_cast<std::size_t>(e)] = sd;
    unit_.row(e) *= sd > 0 ? 1 / sd : 0;
  }
  if (d_.process.kind != Kind::series) return;
  // A sum over all values for each lag that there is, once.
  std::vector<double> lags;
  for (const double a : d_.times)
    for (const double b : d_.times)
      if (b >= a) lags.push_back(std::round((b - a) / d_.process.series->step));
  std::sort(lags.begin(), lags.end());
  lags.erase(std::unique(lags.begin(), lags.end()), lags.end());
  for (const double lag : lags)
    lags_.emplace_back(lag, unit_ * covariance(d_.process, lag * d_.process.series->step) * unit_.transpose());
}

double StationDisturbance::correlation(const StationDraw& a, const StationDraw& b) const {
  if (a.station == b.station && a.element == b.element && a.source == b.source) return 1;
  const double lag = d_.times[b.station] - d_.times[a.station];
  if (d_.keeps_normals()) {
    if (a.source != b.source || d_.process.tau == 0) return 0;
    return std::exp(-std::abs(lag) / d_.process.tau);
  }
  if (lag < 0) return correlation(b, a);
  if (d_.process.kind != Kind::series)
    return (unit_.row(a.element) * covariance(d_.process, lag) * unit_.row(b.element).transpose()).value();
  const double steps = std::round(lag / d_.process.series->step);
  const auto at =
      std::lower_bound(lags_.begin(), lags_.end(), steps, [](const auto& x, double s) { return x.first < s; });
  return at->second(a.element, b.element);
}

Eigen::MatrixXd StationDisturbance::correlation() const {
  const auto n = static_cast<Eigen::Index>(draws_.size());
  Eigen::MatrixXd c(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      c(i, j) = c(j, i) = correlation(static_cast<std::size_t>(j), static_cast<std::size_t>(i));
  return c;
}

std::vector<double> StationDisturbance::values(const random::Stream& stream, std::uint64_t trial,
                                               bool antithetic) const {
  const std::uint64_t from = antithetic ? trial / 2 : trial;
  const double sign = antithetic && trial % 2 == 1 ? -1 : 1;
  std::vector<double> x(draws_.size());
  if (d_.keeps_normals()) {
    for (std::size_t i = 0; i < draws_.size(); ++i) {
      const double z = stream.normal(from, draws_[i].channel, draws_[i].index), r = memory_[i];
      // Without memory the normal itself, to its bits.
      x[i] = r == 0 ? z : r * x[static_cast<std::size_t>(before_[i])] + std::sqrt(1 - r * r) * z;
    }
  } else {
    const Eigen::Matrix3Xd elements = unit_ * draw(d_.process, d_.times, stream, from);
    for (std::size_t i = 0; i < draws_.size(); ++i)
      x[i] = elements(draws_[i].element, static_cast<Eigen::Index>(draws_[i].station));
  }
  for (double& value : x) value *= sign;
  return x;
}

void StationDisturbance::fill(const random::Stream& stream, std::uint64_t first_trial, bool antithetic, int groups,
                              survey::LaneArray& rows) const {
  for (int g = 0; g < groups; ++g)
    for (int lane = 0; lane < simd::kGroup; ++lane) {
      const std::vector<double> x =
          values(stream, first_trial + static_cast<std::uint64_t>(g * simd::kGroup + lane), antithetic);
      for (std::size_t i = 0; i < x.size(); ++i) rows.row(g, static_cast<int>(i))[lane] = x[i];
    }
}

}  // namespace surveymc::disturbance
