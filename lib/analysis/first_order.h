#pragma once
/// First-order effect of every input of a run on quantities that are computed from corrected readings.
///
/// An input d moves a quantity q in two ways: at its station k directly, because the corrected reading gives the
/// direction of the hole there, and at all stations through the estimate x, which the same input moves. With the
/// corrected field b and the down direction u of every station,
///   dq/dd = D_k + Y S_k,   D_k = dq/d(b_k, u_k) d(b_k, u_k)/dd,   S_k = dx/dd (Sensitivity),   Y = dq/dx
///   cov q = sum over all inputs of (dq/dd)(dq/dd)'
/// The two are effects of one draw: they are added before anything is squared. Squared apart, D_k D_k' + Y S_k S_k' Y',
/// they lack D_k S_k' Y' and its transpose. These sum to zero where all gains are equal and accelerometers are perfect,
/// because then the field's noise turns the hole by its east part, while the estimate sees the north and down parts.
/// Computed in a time linear in the stations.
#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "estimate/sensitivity.h"

namespace surveymc::analysis {

/// Derivatives of Q quantities by one station's corrected field (per nT) and down direction (per unit, any direction).
template <int Q>
struct StationDerivatives {
  Eigen::Matrix<double, Q, 3> by_field = Eigen::Matrix<double, Q, 3>::Zero(),
                              by_down = Eigen::Matrix<double, Q, 3>::Zero();
};

/// Y of quantities that depend on the estimate through the corrected fields alone, by the error (estimate less truth)
/// of gain x, y, z (1) and bias x, y, z (nT): each corrected field changes by -(b_i dgain_i + dbias_i) / gain_i.
template <int Q>
Eigen::Matrix<double, Q, 6> by_estimate(const std::vector<StationDerivatives<Q>>& stations,
                                        const estimate::NominalTruth& truth) {
  const Eigen::RowVector3d per_gain = Eigen::RowVector3d(truth.gain.data()).cwiseInverse();
  Eigen::Matrix<double, Q, 6> y = Eigen::Matrix<double, Q, 6>::Zero();
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const Eigen::Matrix<double, Q, 3> by_bias = stations[k].by_field * per_gain.asDiagonal();
    y.template leftCols<3>() -= by_bias * survey::to_eigen(truth.stations[k].field_T).asDiagonal();
    y.template rightCols<3>() -= by_bias;
  }
  return y;
}

/// dq/dd of all inputs, a column a draw of size 1.
template <int Q>
struct InputEffects {
  std::vector<Eigen::Matrix<double, Q, 3>> magnetometer;   ///< of each station: axes x, y, z
  std::vector<Eigen::Matrix<double, Q, 3>> accelerometer;  ///< of each station: axes x, y, z
  std::vector<Eigen::Matrix<double, Q, 2>> reference;      ///< total field, dip: one of the run, or one a station
  Eigen::Matrix<double, Q, 6> tool;                        ///< true gain x, y, z, bias x, y, z

  /// Of the quantities, where a draw of size 1 has variance 1. `correlation`: of the reference's draws, two a station;
  /// null: they are independent.
  Eigen::Matrix<double, Q, Q> covariance(const Eigen::MatrixXd* correlation = nullptr) const {
    Eigen::Matrix<double, Q, Q> c = square(tool);
    for (std::size_t k = 0; k < magnetometer.size(); ++k) {
      c += square(magnetometer[k]);
      c += square(accelerometer[k]);
    }
    for (const auto& m : reference) c += square(m);
    if (correlation == nullptr) return c;
    const auto draws = by_reference();
    c += draws * (*correlation - Eigen::MatrixXd::Identity(draws.cols(), draws.cols())) * draws.transpose();
    return c;
  }
  /// `reference` as one matrix: column 2 pair + {0 total field, 1 dip}.
  Eigen::Matrix<double, Q, Eigen::Dynamic> by_reference() const {
    Eigen::Matrix<double, Q, Eigen::Dynamic> all(Q, 2 * static_cast<Eigen::Index>(reference.size()));
    for (std::size_t k = 0; k < reference.size(); ++k)
      all.template middleCols<2>(2 * static_cast<Eigen::Index>(k)) = reference[k];
    return all;
  }

 private:
  template <int Draws>
  static Eigen::Matrix<double, Q, Q> square(const Eigen::Matrix<double, Q, Draws>& m) {
    return m.lazyProduct(m.transpose());
  }
};

/// `y` is dq/dx; `sensitive` holds the S of the same truth. `sizes`: what a draw of size 1 of each input is. A quantity
/// is taken as the error of the run: tools that vary move it through the estimate alone.
template <int Q>
InputEffects<Q> input_effects(const std::vector<StationDerivatives<Q>>& stations, const Eigen::Matrix<double, Q, 6>& y,
                              const estimate::Sensitivity& sensitive, const estimate::NominalTruth& truth,
                              const estimate::InputErrors& sizes) {
  const Eigen::RowVector3d per_gain = Eigen::RowVector3d(truth.gain.data()).cwiseInverse();
  const Eigen::Vector2d reference_sizes(sizes.total, sizes.dip);
  const auto through_estimate = [&y]<int Inputs>(const Eigen::Matrix<double, 8, Inputs>& s) {
    return Eigen::Matrix<double, Q, Inputs>(y.lazyProduct(s.template topRows<6>()));
  };
  InputEffects<Q> out;
  Eigen::Matrix<double, Q, 2> common = Eigen::Matrix<double, Q, 2>::Zero();
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const Eigen::Vector3d u = survey::to_eigen(truth.stations[k].down_T);
    const Eigen::Matrix3d across = sizes.down * (Eigen::Matrix3d::Identity() - u * u.transpose());
    const auto& direct = stations[k];
    out.magnetometer.push_back(sizes.magnetometer * (through_estimate(sensitive.by_magnetometer[k]) +
                                                     direct.by_field * per_gain.asDiagonal()));
    // Without noise there is no effect, even on the azimuth of a vertical hole, whose derivative is not finite.
    out.accelerometer.push_back(Eigen::Matrix<double, Q, 3>::Zero());
    if (sizes.down > 0) out.accelerometer.back() = (through_estimate(sensitive.by_down[k]) + direct.by_down) * across;
    const Eigen::Matrix<double, Q, 2> by_reference =
        through_estimate(sensitive.by_reference[k]) * reference_sizes.asDiagonal();
    if (sizes.reference_per_station)
      out.reference.push_back(by_reference);
    else
      common += by_reference;
  }
  if (!sizes.reference_per_station) out.reference.push_back(common);
  Eigen::Matrix<double, 6, 1> tool_sd;
  for (int axis = 0; axis < 3; ++axis) {
    tool_sd[axis] = sizes.gain;
    tool_sd[3 + axis] = sizes.bias_sd(axis);
  }
  out.tool = through_estimate(sensitive.by_truth) * tool_sd.asDiagonal();
  return out;
}

}  // namespace surveymc::analysis
