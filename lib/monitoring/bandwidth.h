#pragma once
/// Choice of the kernel's bandwidth by grid search and k-fold cross-validation (An et al. 2011).
#include <vector>

#include "monitoring/samples.h"

namespace surveymc::monitoring {

struct BandwidthScore {
  double bandwidth = 0;
  double mse_measured = 0;  ///< against the readings themselves: degenerate for an auto-associative model (see below)
  double mse_truth = 0;     ///< against readings without noise; NaN where they are not known
};

/// Mean square error (over samples and sensors, z) of the samples of each fold, predicted from `vectors` memory vectors
/// of the others (fewer if they have fewer). Sample i is in fold i mod `folds`. z and truth: n x p; truth may be empty.
/// A small bandwidth gives back the nearest reading, noise and all: against `z` it wins, because noise that a query
/// shares with its prediction costs nothing. Use the truth where it is known, that is, in simulation.
std::vector<BandwidthScore> search_bandwidth(const Samples& z, const Samples& truth, Eigen::Index vectors,
                                             const std::vector<double>& bandwidths, int folds);

}  // namespace surveymc::monitoring
