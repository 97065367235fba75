#include "estimate/msa.h"
#include "stats/linear_algebra.h"

namespace surveymc::estimate {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Gradient and Newton's matrix of half the cost in y, x = x0 + L y.
struct InY {
  Vector6 gradient;
  Matrix6 matrix;
};
InY equations(const MsaData& data, const std::array<double, 6>& x, const Matrix6& to_x) {
  const auto e = msa_normal_equations<double>(data, msa_reading_sums<double>(data), x, 1.0);
  InY out;
  for (int i = 0; i < 6; ++i) {
    out.gradient[i] = e.gradient[static_cast<std::size_t>(i)];
    for (int j = 0; j <= i; ++j)
      out.matrix(i, j) = out.matrix(j, i) =
          e.matrix[simd::packed(static_cast<std::size_t>(i), static_cast<std::size_t>(j))];
  }
  out.gradient = to_x.transpose() * out.gradient;
  out.matrix = to_x.transpose() * out.matrix * to_x;
  return out;
}

/// The columns of the matrix's inverse root: eigenvectors by rising eigenvalue, the weakest first. None if an
/// eigenvalue is not above rounding.
std::optional<Matrix6> inverse_root(const Matrix6& matrix) {
  if (!matrix.allFinite()) return std::nullopt;
  const stats::SymmetricEigen eigen = stats::symmetric_eigen(Eigen::MatrixXd(matrix));
  if (!(eigen.values[0] > 1e-12 * eigen.values[5])) return std::nullopt;
  return Matrix6(eigen.vectors * eigen.values.cwiseSqrt().cwiseInverse().asDiagonal());
}

/// Third and fourth derivatives of the expected cost, by differences of the matrix along the two weak directions.
void add_curvature(const MsaData& data, const Matrix6& to_x, const Matrix6& matrix, MsaValley& v) {
  constexpr double kStep = 1e-3;  // of the largest unknown: truncated at 1e-6, rounded at 1e-10 of the terms
  std::array<Matrix6, 2> first, second;
  for (int w = 0; w < 2; ++w) {
    const double step = kStep / to_x.col(w).cwiseAbs().maxCoeff();
    const auto at = [&](double y) {
      std::array<double, 6> x = v.x;
      for (int i = 0; i < 6; ++i) x[static_cast<std::size_t>(i)] += to_x(i, w) * y;
      return equations(data, x, to_x).matrix;
    };
    const Matrix6 forward = at(step), back = at(-step);
    const auto at_w = static_cast<std::size_t>(w);
    first[at_w] = (forward - back) / (2 * step);
    second[at_w] = (forward + back - 2 * matrix) / (step * step);
  }
  v.cubic = {first[0](0, 0), first[0](0, 1), first[0](1, 1), first[1](1, 1)};
  v.quartic = {second[0](0, 0), second[0](0, 1), second[0](1, 1), second[1](0, 1), second[1](1, 1)};
  for (int j = 0; j < 4; ++j) {
    auto& t = v.t[static_cast<std::size_t>(j)];
    t = {first[0](2 + j, 0), first[0](2 + j, 1), first[1](2 + j, 1)};
    v.quartic[0] -= 3 * t[0] * t[0];
    v.quartic[1] -= 3 * t[0] * t[1];
    v.quartic[2] -= 2 * t[1] * t[1] + t[0] * t[2];
    v.quartic[3] -= 3 * t[1] * t[2];
    v.quartic[4] -= 3 * t[2] * t[2];
  }
}

/// Derivatives of gradient and weak matrix by each reading, by differences of one station's equations; and what the
/// sums of the expected readings have to be subtracted.
void add_sums(survey::ReadingBlock& expected, double total, const Matrix6& to_x, MsaValley& v) {
  constexpr std::size_t n = MsaValley::kSums;
  v.reference_of_run.assign(2 * n, 0.0);
  v.constant.fill(0.0);
  v.constant_down.fill(0.0);
  for (int k = 0; k < expected.stations; ++k) {
    const MsaData station{
        expected.magnetic.row(0, 3 * k), expected.down.row(0, 3 * k), expected.reference.row(0, 0), 1, 0, 1 / total};
    const auto derivative = [&](double& reading, double step) {
      const double kept = reading;
      reading = kept + step;
      const InY above = equations(station, v.x, to_x);
      reading = kept - step;
      const InY below = equations(station, v.x, to_x);
      reading = kept;
      const Vector6 gradient = (above.gradient - below.gradient) / (2 * step);
      const Matrix6 matrix = (above.matrix - below.matrix) / (2 * step);
      std::array<double, n> d;
      for (int i = 0; i < 6; ++i) d[static_cast<std::size_t>(i)] = gradient[i];
      const std::array<double, 3> weak{matrix(0, 0), matrix(1, 0), matrix(1, 1)};
      for (std::size_t i = 0; i < 3; ++i) {
        d[6 + i] = weak[i];
        for (std::size_t j = 0; j < 4; ++j) d[6 + i] -= v.t[j][i] * d[2 + j];  // z = -h
      }
      return d;
    };
    const auto append = [&](survey::LaneArray& rows, int row, double step, std::vector<double>& coefficients,
                            std::array<double, n>& constant) {
      const std::array<double, n> d = derivative(rows.row(0, row)[0], step);
      coefficients.insert(coefficients.end(), d.begin(), d.end());
      for (std::size_t i = 0; i < n; ++i) constant[i] -= d[i] * rows.row(0, row)[0];
    };
    constexpr double kStep = 1e-4;  // of the field and of the unit vector
    for (int i = 0; i < 3; ++i) {
      append(expected.magnetic, 3 * k + i, kStep * total, v.magnetic, v.constant);
      append(expected.down, 3 * k + i, kStep, v.down, v.constant_down);
    }
    for (int i = 0; i < 2; ++i) append(expected.reference, i, kStep * total, v.reference, v.constant);
    for (std::size_t i = 0; i < 2 * n; ++i)
      v.reference_of_run[i] += v.reference[2 * n * static_cast<std::size_t>(k) + i];
  }
}

}  // namespace

std::optional<MsaValley> msa_valley(const std::vector<survey::StationFields>& truth,
                                    const std::vector<survey::Vec3<double>>& expected,
                                    const survey::ReferenceField& field) {
  const std::optional<MsaExpansion> expansion = msa_expansion(truth, expected, field);
  if (!expansion) return std::nullopt;
  survey::ReadingBlock one = expected_readings(truth, expected, field);
  const MsaData data{one.magnetic.row(0, 0), one.down.row(0, 0),   one.reference.row(0, 0),
                     one.stations,           one.reference_stride, 1 / field.total};
  MsaValley v{};
  v.x = expansion->x;
  const std::optional<Matrix6> to_x = inverse_root(equations(data, v.x, Matrix6::Identity()).matrix);
  if (!to_x) return std::nullopt;
  const Matrix6 across = to_x->rightCols<4>() * to_x->rightCols<4>().transpose();
  for (std::size_t i = 0; i < 36; ++i) {
    const auto row = static_cast<Eigen::Index>(i / 6), column = static_cast<Eigen::Index>(i % 6);
    v.to_x[i] = (*to_x)(row, column);
    v.across[i] = across(row, column);
  }
  add_curvature(data, *to_x, equations(data, v.x, *to_x).matrix, v);
  add_sums(one, field.total, *to_x, v);
  return v;
}

}  // namespace surveymc::estimate
