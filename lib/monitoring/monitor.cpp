#include "monitoring/monitor.h"

#include "base/error.h"

namespace surveymc {

const char* name(Architecture a) { return a == Architecture::aakr_sprt ? "aakr_sprt" : "aakr_kf_sprt"; }

MonitorTrace run_monitor(Architecture architecture, const Aakr& model, const DriftFilterOptions& options,
                         const Samples& readings) {
  const Eigen::Index n = readings.rows(), p = readings.cols();
  require(p == model.sensors(), "monitor: readings of {} sensors: the model has {}", p, model.sensors());
  MonitorTrace t{Samples(n, p), Samples(n, p), Eigen::VectorXd(n)};
  Aakr::Scratch scratch;
  if (architecture == Architecture::aakr_sprt) {
    model.predict(readings.data(), static_cast<int>(n), t.prediction.data(), t.nearest.data(), scratch);
    t.signal = readings - t.prediction;
    return t;
  }
  DriftFilter filter(options, p);
  Eigen::RowVectorXd corrected(p), observed(p);
  for (Eigen::Index i = 0; i < n; ++i) {
    corrected = readings.row(i) - filter.drift();
    model.predict(corrected.data(), 1, t.prediction.row(i).data(), &t.nearest[i], scratch);
    observed = readings.row(i) - t.prediction.row(i);
    if (!filter.update(observed)) ++t.skipped;
    t.signal.row(i) = filter.drift();
  }
  return t;
}

}  // namespace surveymc
