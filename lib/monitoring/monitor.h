#pragma once
/// The two monitors of Boechat, Moreno and Haramura: AAKR-SPRT and AAKR-KF-SPRT (their fig. 1).
#include "monitoring/aakr.h"
#include "monitoring/kalman.h"
#include "monitoring/training.h"

namespace surveymc::monitoring {

enum class Architecture {
  aakr_sprt,     ///< AS: residual of the readings against their prediction
  aakr_kf_sprt,  ///< AKS: readings are corrected by the drift estimated so far, before they are predicted
};
/// "aakr_sprt", "aakr_kf_sprt".
const char* name(Architecture architecture);

/// Results of a monitor for n readings of p sensors, all in z.
struct MonitorTrace {
  Samples prediction;        ///< n x p: xhat
  Samples signal;            ///< n x p: the signal that is tested: residual r - xhat (AS) or drift estimate (AKS)
  Eigen::VectorXd nearest;   ///< n: distance to the nearest memory vector, if it was asked for
  Eigen::Index skipped = 0;  ///< rows that the gate of the filter left out
};

/// A monitor that is fed row by row or block by block: the same bits however the rows are divided.
class MonitorStream {
 public:
  /// `model` must outlive it. `filter` is for AKS only. `with_nearest`: distances to the nearest vectors, too.
  MonitorStream(Architecture architecture, const Aakr& model, const DriftFilterOptions& filter,
                bool with_nearest = true);
  /// readings: n x p, scaled, which follow those of the call before. InputError for another number of sensors.
  MonitorTrace next(const Samples& readings);
  /// The same where the model's predictions of these readings are known.
  MonitorTrace next(const Samples& readings, Samples prediction);

 private:
  Architecture architecture_;
  bool with_nearest_;
  const Aakr* model_;
  DriftFilter filter_;
  Aakr::Scratch scratch_;
};

/// All readings in one call.
MonitorTrace run_monitor(Architecture architecture, const Aakr& model, const DriftFilterOptions& filter,
                         const Samples& readings);

}  // namespace surveymc::monitoring
