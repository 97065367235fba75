#pragma once
/// Disturbances of the geomagnetic field as random functions of time: three components in nT, along magnetic north,
/// magnetic east and down. All kinds have mean 0 and are stationary: what happens does not depend on when the run
/// begins.
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "random/reference_laws.h"
#include "survey/reference_field.h"

namespace surveymc::disturbance {

/// Channels of the draws; their numbers are part of every archived result (stream.h).
inline constexpr random::Channel kStart{95};        ///< index 0: uniform, where in its ring a series begins
inline constexpr random::Channel kAr1{96};          ///< index 4 station + component: normals
inline constexpr random::Channel kStorm{97};        ///< index 4 storm + {0: time from the storm before, 1: V}: uniforms
inline constexpr random::Channel kStormVector{98};  ///< index 4 storm + component: normals

enum class Kind {
  ar1,    ///< correlation exp(-|dt| / tau) in each component; components independent
  storm,  ///< sum over storms, whose onsets are a Poisson process, of sqrt(V) N s(t - onset)
  series  ///< a record read from a random minute on, as a ring: behind its last value comes its first
};

/// Values at equal steps, less their mean. A ring gives every value the same probability at every station, so that its
/// covariance is exactly the circular sample autocovariance.
struct Series {
  double step = 60;        ///< s
  Eigen::Matrix3Xd field;  ///< nT
};

struct Process {
  Kind kind = Kind::ar1;
  double tau = 0;                                ///< s; 0: a new draw at every station
  Eigen::Vector3d sd = Eigen::Vector3d::Zero();  ///< nT: of ar1, and of N of a storm
  double storms = 0, rise = 0, decay = 0;        ///< 1/s; s: s(u) = u / rise, then exp(-(u - rise) / decay)
  bool mixing = false;                           ///< V of a storm: exponential of mean 1, or 1
  std::shared_ptr<const Series> series;
};

/// E a(t) b(t + lag) of the components a (rows) and b (columns), nT2. Of a series the lag is rounded to a step.
/// Of storms Campbell's theorem: rate E V sd^2 times the integral of s(u) s(u + lag).
Eigen::Matrix3d covariance(const Process& process, double lag);

/// Values (nT) of a trial at `times` (s, not falling); a column a time. Values of a trial at a time depend on the
/// differences of the times before it alone.
Eigen::Matrix3Xd draw(const Process& process, const std::vector<double>& times, const random::Stream& stream,
                      std::uint64_t trial);

/// How many storms a trial draws for a run that takes `seconds`, on average: those that still decay at its beginning
/// among them.
double storms_of_run(const Process& process, double seconds);

/// Fourth moment over the squared second one, of the component along `direction`; NaN where it has no variance.
double kurtosis(const Process& process, const Eigen::RowVector3d& direction);
/// Share of the time in which the component along `direction` is further than 3 sd from 0; NaN of storms, which have
/// none in closed form.
double outside_three_sd(const Process& process, const Eigen::RowVector3d& direction);

/// A day of waves of 24, 12 and 8 hours, in minutes. `amplitude` (nT) and `maximum` (h after the day's begin):
/// component times wave.
Series daily_waves(const Eigen::Matrix3d& amplitude, const Eigen::Matrix3d& maximum);

/// What the series is measured from: its mean, or the mean of each minute of the day over its days.
enum class QuietLevel { mean, daily };
/// Takes it off. A day has a whole number of steps (daily).
void take_off_quiet_level(Series& series, QuietLevel level);

// ------------------------------------------------------------------------------------------ elements of the reference

/// Elements of a reference field that a disturbance changes, as indices: those of random::ReferenceElement, which has
/// their names.
enum Element {
  kDeclination = static_cast<int>(random::ReferenceElement::declination),
  kDip = static_cast<int>(random::ReferenceElement::dip),
  kTotal = static_cast<int>(random::ReferenceElement::total),
  kElements
};

/// How the elements (rows: rad, rad, nT) follow a small disturbance (columns: north, east, down; nT):
///   dD = dE / H,  dI = (dZ cos I - dH sin I) / F,  dF = dH cos I + dZ sin I
Eigen::Matrix3d elements_by_field(const survey::ReferenceField& field);

}  // namespace surveymc::disturbance
