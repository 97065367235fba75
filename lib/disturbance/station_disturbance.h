#pragma once
/// A disturbance at the stations of a well, as draws of unit variance in place of those that are new at every station.
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "disturbance/process.h"
#include "survey/readings.h"

namespace surveymc::disturbance {

/// `[disturbance]` of a config.
struct Disturbance {
  Process process;
  /// The elements' sizes are those of the code's errors that are new at every station (R); else those of the process.
  bool match_variance = false;
  double scale = 1;           ///< of the sizes
  std::vector<double> times;  ///< s, of every station of the survey
  std::vector<double> lags;   ///< s, of the table `disturbance`

  /// Each error keeps the normals that it has without a disturbance, which only become correlated in time.
  bool keeps_normals() const { return process.kind == Kind::ar1 && match_variance; }
  /// Draws of different stations are correlated.
  bool has_memory() const { return !(keeps_normals() && process.tau == 0); }
  /// A disturbance and its negative are equally likely.
  bool symmetric() const { return process.kind != Kind::series; }
};

/// One draw: the disturbance of an element at a station, in units of its standard deviation.
struct StationDraw {
  std::size_t station = 0;
  Element element = kDeclination;
  std::uint32_t source = 0;  ///< of Disturbance::keeps_normals(): draws of different sources are independent
  /// Address of the normal that it keeps.
  random::Channel channel{};
  std::uint32_t index = 0;
};

class StationDisturbance {
 public:
  /// `draws`: those of one source in the order of their stations. Draws of an element that the disturbance does not
  /// change are 0.
  StationDisturbance(Disturbance disturbance, const survey::ReferenceField& field, std::vector<StationDraw> draws);

  const std::vector<StationDraw>& draws() const { return draws_; }
  /// Of the process, rad, rad, nT.
  const std::array<double, kElements>& sizes() const { return sizes_; }
  /// Of draws i and j; draws of the same station and element have 1.
  double correlation(std::size_t i, std::size_t j) const { return correlation(draws_[i], draws_[j]); }
  double correlation(const StationDraw& a, const StationDraw& b) const;
  Eigen::MatrixXd correlation() const;
  /// The draws' values in one trial, in their order. Antithetic trials 2 j and 2 j + 1: those of trial j, with opposite
  /// signs.
  std::vector<double> values(const random::Stream& stream, std::uint64_t trial, bool antithetic = false) const;
  /// The same of trials in lanes: row i is draw i.
  void fill(const random::Stream& stream, std::uint64_t first_trial, bool antithetic, int groups,
            survey::LaneArray& rows) const;

 private:
  Disturbance d_;
  std::vector<StationDraw> draws_;
  Eigen::Matrix3d unit_ = Eigen::Matrix3d::Zero();  ///< elements in units of their sd, by the field
  std::array<double, kElements> sizes_{};
  std::vector<std::ptrdiff_t> before_;                    ///< of keeps_normals(): the source's draw before, or -1
  std::vector<double> memory_;                            ///< correlation with it
  std::vector<std::pair<double, Eigen::Matrix3d>> lags_;  ///< of a series, sorted: lag, correlation of elements
};

}  // namespace surveymc::disturbance
