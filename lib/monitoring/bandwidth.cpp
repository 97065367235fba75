#include "monitoring/bandwidth.h"

#include "base/error.h"
#include "base/units.h"
#include "monitoring/aakr.h"
#include "monitoring/training.h"

namespace surveymc::monitoring {

std::vector<BandwidthScore> search_bandwidth(const Samples& z, const Samples& truth, Eigen::Index vectors,
                                             const std::vector<double>& bandwidths, int folds) {
  require(folds >= 2 && folds <= z.rows(), "bandwidth search: {} folds: must be between 2 and the {} samples", folds,
          z.rows());
  std::vector<BandwidthScore> scores;
  for (const double h : bandwidths) scores.push_back({h, 0, 0});
  Aakr::Scratch scratch;
  for (int f = 0; f < folds; ++f) {
    std::vector<Eigen::Index> in, out;
    for (Eigen::Index i = 0; i < z.rows(); ++i) (i % folds == f ? out : in).push_back(i);
    const Samples others = rows_of(z, in), queries = rows_of(z, out);
    const Samples memory = rows_of(others, select_memory(others, std::min(vectors, others.rows())));
    Samples predicted(queries.rows(), queries.cols());
    for (BandwidthScore& s : scores) {
      Aakr(memory, s.bandwidth)
          .predict(queries.data(), static_cast<int>(queries.rows()), predicted.data(), nullptr, scratch);
      s.mse_measured += (predicted - queries).squaredNorm();
      if (truth.size() > 0) s.mse_truth += (predicted - rows_of(truth, out)).squaredNorm();
    }
  }
  for (BandwidthScore& s : scores) {
    s.mse_measured /= static_cast<double>(z.size());
    s.mse_truth = truth.size() > 0 ? s.mse_truth / static_cast<double>(z.size()) : kNaN;
  }
  return scores;
}

}  // namespace surveymc::monitoring
