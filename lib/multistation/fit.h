#pragma once
/// Multi-station analysis with any parameters of the table: least squares with priors and a weight for each station.
///   minimise  sum_k w_k |r_k|^2 + sum_i (x_i / sd_i)^2
/// over the parameters of a set, and over errors of the reference where it is estimated; r_k as in model.h.
#include <vector>

#include <Eigen/Core>

#include "multistation/fit_kernel.h"
#include "multistation/model.h"
#include "survey/readings.h"

namespace surveymc::multistation {

/// One standard deviation of the reference that all stations share: gravity (m/s2), total field (nT), dip (rad).
struct ReferenceErrors {
  double gravity = 0, total = 0, dip = 0;
};

struct FitOptions {
  ParameterSet parameters = ParameterSet::named("6");
  PerParameter<double> prior_sd = default_priors();  ///< about 0; infinite: no prior
  ResidualKind residuals = ResidualKind::survey;
  ResidualSizes sizes{0.006, 70, 70};
  double total = 50000, dip = 0;  ///< nT, rad: the nominal reference, about which its errors are linear
  ReferenceErrors reference;      ///< 0: known
  /// True: errors of the reference are unknowns with these priors (infinite: none). False: the reference is a consider
  /// parameter: the estimate takes it as it is, and the covariance counts its errors.
  bool estimates_reference = false;
  /// Whether readings' noise moves |g|: a robust loss counts it as a component of the residual only then.
  bool gravity_is_noisy = true;
  int max_iterations = 50;
  double step_tolerance = 1e-6;  ///< of a parameter, in units of the table's prior
};

/// Throws InputError: a prior or size that is not positive, an empty set.
FitPlan fit_plan(const FitOptions& options);

/// Derivatives of Reference's three values by gravity, total field and dip.
Eigen::Matrix3d reference_derivatives(const FitPlan& plan);

/// One run. Columns and rows of parameters are in the order of the set.
struct Fit {
  Eigen::VectorXd estimate;
  /// Of estimate less truth, with unit variance of the residuals in units of their sizes: (J'WJ + P)^-1, and what
  /// errors of a reference that is not estimated do.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd posterior;     ///< its first part alone
  Eigen::VectorXd learnt;        ///< 1 - covariance_ii / sd_i^2 against the prior; 1 without prior
  Eigen::MatrixXd joint;         ///< posterior with the reference's gravity, total field and dip where it is estimated
  Eigen::MatrixXd inverse;       ///< (J'WJ + P)^-1 of these unknowns, which `joint` is for unit variance
  Eigen::MatrixXd by_reference;  ///< parameters by errors of a reference that is not estimated: gravity, total, dip
  ReferenceErrors reference;     ///< estimated errors: the reference less the truth has minus these
  ReferenceErrors reference_sd;  ///< after the estimate
  Eigen::Matrix<double, kResiduals, Eigen::Dynamic> residuals;  ///< a column a station, in units of the sizes
  double cost = 0;
  int iterations = 0;
  bool converged = false;       ///< false: nothing else may be used
  PerParameter<double> tool{};  ///< the estimate, in the table's order
};

/// Claims anew, for residuals whose variance is `variance` in units of their sizes, after a fit that took it as 1:
///   joint = N^-1 (variance J'WJ + P) N^-1,  N = J'WJ + P
/// and with it posterior, covariance, learnt and reference_sd. Priors are variances of their own, and so are errors of
/// a reference that is not estimated: both stay as they are.
void claim_for_variance(Fit& fit, const FitOptions& options, double variance);

/// `weights`: one a station, empty for 1. Throws InputError where the options are wrong, or where stations and priors
/// do not determine the unknowns.
Fit fit(const std::vector<StationReadings>& stations, const FitOptions& options,
        const std::vector<double>& weights = {});

/// First-order effects on the estimate: what an error of an input adds to estimate less truth.
struct FitSensitivity {
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 3>> by_gravity, by_magnetic;  ///< per m/s2, nT of a reading
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 3>> by_reference;  ///< of a station: gravity, total (nT), dip (rad)
  /// Per unit of each parameter of the table's true value: the pull of the priors (parameters of the set); the effect
  /// on the set of an error that is not in it.
  Eigen::Matrix<double, Eigen::Dynamic, kParameters> by_truth;
  Eigen::MatrixXd posterior;  ///< N^-1 of the set, N = J'WJ + P with the reference's unknowns where it is estimated
  Eigen::MatrixXd of_priors;  ///< N^-1 P N^-1 of the set: what errors of the priors make of the posterior

  /// Claimed, for residuals whose variance is `variance` in units of the posterior's: as claim_for_variance().
  Eigen::MatrixXd claimed(double variance) const {
    return variance == 1 ? posterior : variance * (posterior - of_priors) + of_priors;
  }
};
/// At error-free readings and the true errors `tool`. Rows: parameters of the set; then, where the reference is
/// estimated, its gravity, total field and dip. Throws InputError as fit().
FitSensitivity fit_sensitivity(const std::vector<StationReadings>& stations, const PerParameter<double>& tool,
                               const FitOptions& options, const std::vector<double>& weights = {});

/// Readings of many trials, trials fastest (survey/readings.h).
struct SixAxisBlock {
  SixAxisBlock(int trial_count, int station_count, bool reference_per_station = false)
      : trials(trial_count),
        stations(station_count),
        reference_stride(reference_per_station ? kResiduals : 0),
        gravity(survey::groups_for(trial_count), 3 * station_count),
        magnetic(survey::groups_for(trial_count), 3 * station_count),
        reference(survey::groups_for(trial_count), reference_per_station ? kResiduals * station_count : kResiduals) {}

  int groups() const { return survey::groups_for(trials); }

  int trials, stations, reference_stride;
  survey::LaneArray gravity, magnetic;  ///< rows 3 k + axis
  survey::LaneArray reference;          ///< rows reference_stride k + {gravity, first, second}
};

/// One run as a block of one trial, with a reference for each station.
SixAxisBlock block_of(const std::vector<StationReadings>& stations);

/// Estimates of many trials.
struct FitBlock {
  /// `variances`: with posterior variances, from the last normal matrix.
  FitBlock(int trials, const FitOptions& options, bool variances = false)
      : estimate(survey::groups_for(trials), options.parameters.size()),
        reference(survey::groups_for(trials), 3),
        variance(survey::groups_for(trials), options.parameters.size(), !variances),
        has_variance(variances),
        cost(survey::groups_for(trials), 1),
        iterations(survey::groups_for(trials), 1),
        converged(survey::groups_for(trials), 1) {}

  survey::LaneArray estimate;   ///< rows: the parameters of the set
  survey::LaneArray reference;  ///< errors of gravity (m/s2), total (nT), dip (rad); 0 where not estimated
  survey::LaneArray variance;
  bool has_variance;
  survey::LaneArray cost, iterations, converged;  ///< as FitSolution
};

/// `weights`: null, or row k the weight of station k. Trial by trial the bits of solve_fit<double>.
void fit_block(const SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set, FitBlock& out,
               const survey::LaneArray* weights = nullptr);

/// Corrects the readings of each trial by its estimates: `gravity` and `magnetic` of `readings` become the corrected
/// ones.
void correct_block(SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set, const FitBlock& estimates);

/// Residuals of each trial at its estimates, in units of the sizes: rows 3 k + {gravity, first, second}.
void residual_block(const SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set,
                    const FitBlock& estimates, survey::LaneArray& residuals);

}  // namespace surveymc::multistation
