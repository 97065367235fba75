/// Study: the azimuth of a single station with an axially magnetised string: where no correction, the simple one and
/// the extended ones fail. Source: slides on chained multistation analysis, 2 to 6.
///
///   constant errors -> readings -> every method -> error maps; sigmas -> covariance -> sd maps
///   noise, references, Mz drawn (sensor) -> every method (estimate) -> tally, compared with the covariance
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "axial_correction/study.h"
#include "base/units.h"
#include "random/study_stream.h"
#include "single_station/station_solution.h"
#include "study/experiment.h"

namespace surveymc::studies::axial_correction {
namespace {

std::vector<sensor::StationTruth> true_stations(const Scenario& s) {
  std::vector<sensor::StationTruth> truth;
  for (const survey::Attitude& at : s.stations)
    truth.push_back(station_truth(s, at, s.axial_is_drawn ? ConstantErrors{} : s.errors));
  return truth;
}

class AxialCorrection final : public study::StudyPoint {
 public:
  explicit AxialCorrection(const Scenario& scenario)
      : s_(scenario),
        stream_(random::stream_of(s_.seed)),
        groups_(s_.methods.size(), s_.stations.size()),
        counts_(s_.methods.size(), s_.stations.size()),
        draw_{s_.sigmas.accelerometer_xy, s_.sigmas.accelerometer_z,
              s_.sigmas.magnetometer_xy,  s_.sigmas.magnetometer_z,
              s_.sigmas.gravity,          s_.sigmas.horizontal,
              s_.sigmas.vertical,         s_.axial_is_drawn ? s_.sigmas.axial : 0},
        truth_(true_stations(s_)) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    const int groups = survey::groups_for(block.count);
    const auto methods = s_.methods.size(), stations = s_.stations.size(), runs = static_cast<std::size_t>(block.count);
    stats::Tally tally;
    tally.trials = runs;
    tally.counts.assign(counts_.size(), 0);
    tally.groups.resize(groups_.size());
    std::vector<Eigen::MatrixXd> squares(methods, Eigen::MatrixXd::Zero(block.count, kProfileQuantities));
    std::vector<std::vector<bool>> whole(methods, std::vector<bool>(runs, true));
    for (std::size_t first = 0; first < stations; first += sensor::kStationBatch) {
      const std::size_t count = std::min<std::size_t>(sensor::kStationBatch, stations - first);
      const std::vector<sensor::StationTruth> truth(truth_.begin() + static_cast<std::ptrdiff_t>(first),
                                                    truth_.begin() + static_cast<std::ptrdiff_t>(first + count));
      const survey::LaneArray readings =
          sensor::draw_stations(truth, static_cast<int>(first), draw_, stream_, block.first, groups);
      for (std::size_t m = 0; m < methods; ++m) {
        const survey::LaneArray found =
            single_station::solve_stations(readings, static_cast<int>(count), groups, s_.sigmas, s_.methods[m]);
        for (std::size_t k = 0; k < count; ++k) {
          Eigen::MatrixXd errors(block.count, 2);
          Eigen::Index kept = 0;
          for (int t = 0; t < block.count; ++t) {
            const auto e = errors_of(readings, found, t, static_cast<int>(k), s_.stations[first + k]);
            if (!e.found) {
              ++tally.counts[counts_.failed(m, first + k)];
              whole[m][static_cast<std::size_t>(t)] = false;
              continue;
            }
            tally.counts[counts_.over_tolerance(m, first + k)] += std::abs(e.values[0]) > s_.tolerance;
            for (std::size_t q = 0; q < kProfileQuantities; ++q)
              squares[m](t, static_cast<Eigen::Index>(q)) += e.values[q] * e.values[q] / static_cast<double>(stations);
            errors.row(kept++) << e.values[0], e.values[6];
          }
          tally.groups[groups_.station(m, first + k)] = stats::Moments::of(errors.topRows(kept));
        }
      }
    }
    for (std::size_t m = 0; m < methods; ++m) {
      Eigen::Index kept = 0;
      for (int t = 0; t < block.count; ++t)
        if (whole[m][static_cast<std::size_t>(t)]) squares[m].row(kept++) = squares[m].row(t).eval();
      tally.groups[groups_.profile(m)] = stats::Moments::of(squares[m].topRows(kept));
    }
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    study::PointResult r;
    add_maps(s_, r.maps, r.tables);
    if (!s_.stations.empty()) {
      r.tables.push_back(verification_table(s_, tally));
      r.tables.push_back(profile_table(s_, tally));
    }
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    std::string text = fmt::format("trial {}\n", trial);
    for (std::size_t k = 0; k < s_.stations.size(); ++k) {
      const std::size_t first = k / sensor::kStationBatch * sensor::kStationBatch, at = k - first;
      const std::vector<sensor::StationTruth> truth(truth_.begin() + static_cast<std::ptrdiff_t>(first),
                                                    truth_.begin() + static_cast<std::ptrdiff_t>(k + 1));
      const survey::LaneArray readings =
          sensor::draw_stations(truth, static_cast<int>(first), draw_, stream_, trial, 1);
      const int row = static_cast<int>(at) * survey::kStationReadingRows;
      const auto in = [&](int r) { return readings.value(0, row + r); };
      text += fmt::format("  I {:g} A {:g} deg: g {:.9g} {:.9g} {:.9g} m/s2, b {:.9g} {:.9g} {:.9g} nT, Mz {:.6g} nT\n",
                          s_.stations[k].inclination / kDegree, s_.stations[k].azimuth / kDegree, in(0), in(1), in(2),
                          in(3), in(4), in(5), in(survey::kAxialRow));
      for (std::size_t m = 0; m < s_.methods.size(); ++m) {
        const single_station::StationSolution x = single_station::solve_station(
            {in(0), in(1), in(2)}, {in(3), in(4), in(5)}, {in(6), in(7), in(8)}, s_.sigmas, s_.methods[m]);
        text += x.determined
                    ? fmt::format("    {:<12} azimuth {:.9g} deg, Bh {:.9g}, Bd {:.9g}, Mz {:.6g} nT\n", s_.name_of(m),
                                  x.attitude.azimuth / kDegree, x.horizontal(), x.vertical, x.axial + 0.0)
                    : fmt::format("    {:<12} no solution\n", s_.name_of(m));
      }
    }
    return text;
  }

 private:
  struct Errors {
    bool found;
    std::array<double, kProfileQuantities> values;  ///< in the order of profile_quantities(), SI
  };

  Errors errors_of(const survey::LaneArray& readings, const survey::LaneArray& solutions, int trial, int k,
                   const survey::Attitude& at) const {
    const auto x = [&](int r) { return solutions.value(trial, k * single_station::kStationSolutionRows + r); };
    const double n = x(single_station::kNorthRow), e = x(single_station::kNorthRow + 1),
                 d = x(single_station::kNorthRow + 2);
    const double bh = std::hypot(n, e);
    if (x(single_station::kFoundRow) != 1 || !std::isfinite(bh) || !std::isfinite(d)) return {false, {}};
    const auto off = [](double estimate, double truth) { return std::remainder(estimate - truth, 2 * kPi); };
    return {true,
            {off(std::atan2(e, n), at.azimuth), off(std::atan2(x(0), x(1)), at.inclination),
             off(std::atan2(x(2), x(3)), at.toolface), x(single_station::kTotalRow) - s_.field.gravity,
             bh - s_.field.total * std::cos(s_.field.dip), d - s_.field.total * std::sin(s_.field.dip),
             x(single_station::kNorthRow + 3) -
                 readings.value(trial, k * survey::kStationReadingRows + survey::kAxialRow)}};
  }

  Scenario s_;
  random::Stream stream_;
  Groups groups_;
  Counts counts_;
  sensor::StationDrawSd draw_;
  std::vector<sensor::StationTruth> truth_;
};

class AxialCorrectionPlan final : public study::PlanOfPoint<Scenario, AxialCorrection> {
 public:
  using PlanOfPoint::PlanOfPoint;
  std::vector<store::Axis> map_axes() const override { return map_axes_of(s_); }
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::axial_correction,
          "Single stations and an axially magnetised string: azimuth errors of basic, simple and extended solutions",
          "slides on chained multistation analysis, 2 to 6", study::plan_of<AxialCorrectionPlan, read_scenario>};
}

}  // namespace surveymc::studies::axial_correction
