#pragma once
/// Robust multi-station analysis with any parameters of the table: the fit of fit.h with weights of the stations that
/// are found from their residuals (robust_kernel.h). A station's residual has the components Bh and Bv, and |g| where
/// parameters of the accelerometers are estimated, or, if it has noise, the reference. A shared error of the reference
/// is no gross error: the scale of the residuals includes it.
#include <array>
#include <cstdint>
#include <vector>

#include "multistation/fit.h"
#include "multistation/robust_kernel.h"
#include "random/stream.h"

namespace surveymc::multistation {

/// Components of a station's residual: 2 or 3.
int robust_components(const FitPlan& plan);
/// Those that have noise. Of the others a fit leaves next to nothing, so that a residual is as long as that of these.
int noisy_components(const FitPlan& plan);

/// How a loss is fitted. Tukey's begins with lmeds whatever `start`, and keeps the scale of that fit.
RobustOptions robust_options(Loss loss, RobustStart start = RobustStart::least_squares);

/// What the loss costs in a fit with this plan.
LossCost loss_cost(Loss loss, const FitPlan& plan);

/// The options with which stations of weight k are first order of a fit by the loss: |g| without noise has the weight
/// E min(w, 1) instead, as psi(e) has the derivative w across e; of l1, whose w has no bound, as a claim counts it.
FitOptions as_weighed(FitOptions options, const LossCost& cost);

/// What a robust fit of many trials finds beside the estimates.
struct RobustBlock {
  RobustBlock(int trials, int stations)
      : weights(survey::groups_for(trials), stations),
        scale(survey::groups_for(trials), 1),
        reweightings(survey::groups_for(trials), 1) {}
  survey::LaneArray weights;  ///< row k: of station k
  survey::LaneArray scale;    ///< of the residuals, in units of their sizes
  survey::LaneArray reweightings;
};

/// Fills estimate, reference and converged of `out` (no variance, cost and iterations). `first_trial`, a multiple of
/// kGroup, and `stream` address the subsets of the start lmeds. `given`: null, or row k the weight of station k of a
/// least-squares fit that knows which stations to trust. `start`: unknowns of the plan, in units of its scales.
void robust_fit_block(const SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set,
                      const RobustOptions& options, const random::Stream& stream, std::uint64_t first_trial,
                      FitBlock& out, RobustBlock& robust, const survey::LaneArray* given = nullptr,
                      const std::array<double, kUnknowns>& start = {});

/// The fit by the loss of `options`: robust_fit_block(), or of least_squares fit_block().
void fit_block_by_loss(const SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set,
                       const RobustOptions& options, const random::Stream& stream, std::uint64_t first_trial,
                       FitBlock& out, RobustBlock& robust);

/// One run.
struct RobustFit {
  /// Of the weighted stations. Its covariance is that of the loss, (J'WJ + P)^-1 (f J'WJ + P) (J'WJ + P)^-1
  /// with W = LossCost::information(w) (loss.h), by the a-priori sizes of the residuals.
  Fit fit;
  std::vector<double> weights;  ///< one a station
  double scale = 1;             ///< of the residuals, in units of their sizes
  double factor = 1;            ///< f = v k: what the loss costs
  int reweightings = 0;
};
/// Begins at least squares, which halves steps that are too long: tukey's subsets are linear about it. Throws
/// InputError as fit(), where too few stations have any weight, and where the fit with the weights does not converge.
RobustFit robust_fit(const std::vector<StationReadings>& stations, const FitOptions& options,
                     const RobustOptions& robust, const random::Stream& stream);

}  // namespace surveymc::multistation
