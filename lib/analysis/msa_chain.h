#pragma once
/// The error of the last position after multi-station analysis as a function of the normals of a run (orders/chain.h):
/// readings, estimate, corrected survey, minimum curvature; with its first and second derivatives, exact at any point.
///
/// The estimate x solves g(x, y) = 0, y the readings and references of the stations, and the position is Q(x, y). With
/// N = dg/dx and lambda_a = -N^-T dQ_a/dx, the derivatives of Q_a along all ways of (x, y) that keep g = 0 are those of
///   L_a(x, y) = Q_a + lambda_a' g,   J_a = dL_a/dy,   H_a = [X; 1]' L_a'' [X; 1],   X = dx/dy = -N^-1 dg/dy
/// g is a sum over stations, and Q one over neighbours: L'' has a block for x, one for x and each station, and blocks
/// of neighbours. Time and memory are linear in the stations.
#include <memory>
#include <vector>

#include "estimate/estimator.h"
#include "estimate/field_fit_point.h"
#include "estimate/sensitivity.h"
#include "orders/chain.h"
#include "sensor/readings_of_normals.h"
#include "survey/survey.h"

namespace surveymc::analysis {

/// What the trials are made of. The noise is Gaussian.
struct MsaTrials {
  survey::Survey survey;
  survey::ReferenceField field;
  sensor::CleanReadings clean;
  sensor::NoiseModel noise;
  sensor::ToolSpread spread;
  sensor::MagnetometerErrors errors = {};  ///< of the nominal tool, which `clean` has
};

class MsaChain final : public orders::Chain {
 public:
  /// `options`: of an estimator that fits (Bh, Bv) (estimate/field_fit.h). Throws InputError for others.
  MsaChain(MsaTrials trials, const estimate::EstimatorOptions& options);

  /// Normals as in sensor::reading_normals(); those that nothing reads have no effect.
  Eigen::Index dimension() const override { return normals_.rows(); }
  Eigen::Matrix3Xd values(const Eigen::MatrixXd& z) const override;
  /// States: p, q / total, z (FieldFitPoint). A point whose estimate does not converge has no value. Between two minima
  /// the path takes the lower cost of those that Newton's steps reach from the truth and from the point before, going
  /// outward from the centre: what trials do, which start at the truth. A minimum that is lower but reached from
  /// neither is no trial's.
  orders::Path path(const Eigen::VectorXd& v, const std::vector<double>& t) const override;
  orders::Expansion expand(const Eigen::VectorXd& z, const Eigen::VectorXd& state,
                           const orders::ExpansionParts& parts) const override;

  /// The directions in which the estimate moves, an orthonormal basis: total field and dip of the reference, where one
  /// pair holds for the run, those of the tool, and the six of all other normals (right singular vectors of dx/dz).
  Eigen::MatrixXd directions(const Eigen::VectorXd& state) const;
  const sensor::ReadingNormals& normals() const { return normals_; }

  /// Gains and biases (nT) of a state, and their derivatives by all normals (6 x d), NaN where there is no estimate.
  estimate::Vector6d parameters(const Eigen::VectorXd& state) const;
  Eigen::MatrixXd parameters_by_normals(const Eigen::VectorXd& z, const Eigen::VectorXd& state) const;

 private:
  struct Station;
  struct Linearised;
  survey::ReadingBlock readings_of(const Eigen::MatrixXd& z) const;
  Eigen::Matrix3Xd positions_of(const survey::ReadingBlock& readings,
                                const std::vector<estimate::FieldFitPoint>& estimates) const;
  Linearised linearise(const Eigen::VectorXd& z, const Eigen::VectorXd& state) const;
  /// Of the unknowns by the normals that are drawn for a station alone, 8 x d; those of the run have zeros.
  Eigen::MatrixXd unknowns_by_own_normals(const Linearised& linearised) const;

  MsaTrials trials_;
  estimate::FieldFitModel model_;
  sensor::ReadingNormals normals_;
  std::unique_ptr<estimate::Estimator> estimator_;
  estimate::FieldFitPoint at_truth_;
  std::vector<double> md_;
  Eigen::Vector3d truth_;  ///< N, E, V of the last station from the first
};

}  // namespace surveymc::analysis
