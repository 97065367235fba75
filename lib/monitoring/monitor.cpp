#include "monitoring/monitor.h"

#include "base/error.h"

namespace surveymc::monitoring {

const char* name(Architecture a) { return a == Architecture::aakr_sprt ? "aakr_sprt" : "aakr_kf_sprt"; }

MonitorStream::MonitorStream(Architecture architecture, const Aakr& model, const DriftFilterOptions& filter,
                             bool with_nearest)
    : architecture_(architecture), with_nearest_(with_nearest), model_(&model), filter_(filter, model.sensors()) {}

MonitorTrace MonitorStream::next(const Samples& readings) {
  const Eigen::Index n = readings.rows(), p = readings.cols();
  require(p == model_->sensors(), "monitor: readings of {} sensors: the model has {}", p, model_->sensors());
  MonitorTrace t{Samples(n, p), Samples(n, p), Eigen::VectorXd(with_nearest_ ? n : 0)};
  double* nearest = with_nearest_ ? t.nearest.data() : nullptr;
  if (architecture_ == Architecture::aakr_sprt) {
    model_->predict(readings.data(), static_cast<int>(n), t.prediction.data(), nearest, scratch_);
    t.signal = readings - t.prediction;
    return t;
  }
  Eigen::RowVectorXd corrected(p), observed(p);
  for (Eigen::Index i = 0; i < n; ++i) {
    corrected = readings.row(i) - filter_.drift();
    model_->predict(corrected.data(), 1, t.prediction.row(i).data(), nearest ? nearest + i : nullptr, scratch_);
    observed = readings.row(i) - t.prediction.row(i);
    if (!filter_.update(observed)) ++t.skipped;
    t.signal.row(i) = filter_.drift();
  }
  return t;
}

MonitorTrace MonitorStream::next(const Samples& readings, Samples prediction) {
  MonitorTrace t{std::move(prediction), Samples(readings.rows(), readings.cols()), {}};
  if (architecture_ == Architecture::aakr_sprt) {
    t.signal = readings - t.prediction;
    return t;
  }
  Eigen::RowVectorXd observed(readings.cols());
  for (Eigen::Index i = 0; i < readings.rows(); ++i) {
    observed = readings.row(i) - t.prediction.row(i);
    if (!filter_.update(observed)) ++t.skipped;
    t.signal.row(i) = filter_.drift();
  }
  return t;
}

MonitorTrace run_monitor(Architecture architecture, const Aakr& model, const DriftFilterOptions& options,
                         const Samples& readings) {
  return MonitorStream(architecture, model, options).next(readings);
}

}  // namespace surveymc::monitoring
