/// Calibration of the claimed distributions of the study `msa_position`, and its stopping rule by verdict.
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "msa_position/study.h"
#include "study/table_rows.h"
#include "survey/minimum_curvature.h"

namespace surveymc::studies::msa_position {

/// The tallied NEES is then that of the claim.
bool PositionPoint::claims_what_is_predicted() const {
  const Eigen::Matrix<double, 6, 6> claimed = prediction_.claimed_covariance.topLeftCorner<6, 6>();
  for (int i = 0; i < 6; ++i) {
    const auto a = static_cast<std::size_t>(i);
    const double off = prediction_.parameters[i] - (i < 3 ? s_.errors.gain[a] : s_.errors.bias[a - 3]);
    if (!(std::abs(off) <= 1e-9 * std::sqrt(claimed(i, i)))) return false;
    for (int j = 0; j <= i; ++j)
      if (!(std::abs(claimed(i, j) - prediction_.parameter_covariance(i, j)) <=
            1e-12 * std::sqrt(claimed(i, i) * claimed(j, j))))
        return false;
  }
  return true;
}

void PositionPoint::make_calibrated() {
  const Eigen::Matrix3d& joint = prediction_.position_covariance[0];
  const Eigen::Vector3d off =
      prediction_.position - Eigen::Vector3d(survey::minimum_curvature_positions(s_.survey).back());
  const bool constant = s_.assumed_noise == sensor::AssumedNoise::constant;
  for (const study::RowName& row : calibrated_rows(s_)) {
    if (!s_.calibration.wants(row.quantity)) continue;
    const std::string &f = row.formulation, &q = row.quantity;
    CalibratedColumn at;
    double sd = 1;
    for (int i = 0; i < 6; ++i)
      if (const auto a = static_cast<std::size_t>(i); q == estimate::kParameterNames[a]) {
        at = {at_.parameter + i, prediction_.parameters[i] - (i < 3 ? s_.errors.gain[a] : s_.errors.bias[a - 3]),
              constant ? -1 : at_.claimed + i};
        if (constant) sd = std::sqrt(prediction_.claimed_covariance(i, i));
      }
    for (int i = 0; i < 2; ++i)
      if (q == kReference[static_cast<std::size_t>(i)]) {
        at = {at_.reference + i};
        sd = std::sqrt(prediction_.claimed_covariance(6 + i, 6 + i)) / (i == 0 ? 1 : kDegree);
      }
    for (int i = 0; i < 3; ++i)
      if (q == kDirections[static_cast<std::size_t>(i)]) {
        at = {at_.position + i, off[i]};
        sd = std::sqrt(joint(i, i));
      }
    for (int i = 0; i < 2; ++i)
      if (q == (i == 0 ? "major_axis" : "minor_axis")) {
        const Eigen::Vector2d axis = horizontal_axes_[0].col(i);
        at = {at_.axes + i, axis.dot(off.head<2>())};
        const double variance = axis.dot(joint.topLeftCorner<2, 2>() * axis);
        sd = variance > 1e-14 * joint.trace() ? std::sqrt(variance) : 0;  // rounding is no claim
      }
    if (q == "nees") at = {claims_what_is_predicted() ? at_.nees_parameters : kNees};
    calibrated_.push_back(q == "nees" ? study::chi_squared_quantity(f, q, 6) : study::normal_quantity(f, q, sd));
    calibrated_columns_.push_back(at);
  }
}

void PositionPoint::count_calibration(const Eigen::Ref<const Eigen::MatrixXd>& values,
                                      std::vector<std::uint64_t>& counts) const {
  for (std::size_t c = 0; c < calibrated_.size(); ++c) {
    const stats::PitCells& cells = calibrated_[c].cells;
    const CalibratedColumn& at = calibrated_columns_[c];
    std::uint64_t* slots = counts.data() + kCounts + c * stats::kPitSlots;
    for (Eigen::Index t = 0; t < values.rows(); ++t) {
      double x = 0;
      if (at.column == kNees) {
        Eigen::Matrix<double, 6, 1> error;
        for (int i = 0; i < 6; ++i) {
          const auto a = static_cast<std::size_t>(i);
          error[i] = values(t, at_.parameter + i) + prediction_.parameters[i] -
                     (i < 3 ? s_.errors.gain[a] : s_.errors.bias[a - 3]);
        }
        x = error.dot(claimed_weight_ * error);
      } else {
        x = values(t, at.column) + at.offset;
        if (at.variance >= 0) x /= std::sqrt(values(t, at.variance));
      }
      ++slots[cells.of(x)];
    }
  }
}

stats::Tally PositionPoint::tally_at_look(const stats::Tally& tally, std::size_t look) const {
  stats::Tally at;
  at.trials = std::min(s_.plan.looks.at(std::min(look, s_.plan.looks.size() - 1)), tally.trials);
  for (std::size_t part = 0; part <= look && 2 * part + 1 < tally.groups.size(); ++part) {
    at.moments.merge(tally.groups[2 * part]);
    at.pairs.merge(tally.groups[2 * part + 1]);
  }
  return at;
}

std::vector<PositionPoint::DecisiveRow> PositionPoint::decisive_rows(const stats::Tally& tally) const {
  std::vector<DecisiveRow> found;
  for (const auto& [table, rows] : all_rows(tally))
    for (const study::ComparisonRow& row : rows)
      for (const study::RowName& name : s_.plan.decisive)
        if (name.table == table && name.quantity == row.quantity && name.formulation == row.formulation)
          found.push_back({table, row});
  return found;
}

void PositionPoint::note_look(const std::string& table, std::vector<study::ComparisonRow>& rows,
                              const stats::Tally& tally) const {
  std::size_t look = 1;
  while (look < s_.plan.looks.size() && s_.plan.looks[look - 1] < tally.trials) ++look;
  for (const study::RowName& name : s_.plan.decisive)
    for (study::ComparisonRow& row : rows)
      if (name.table == table && name.quantity == row.quantity && name.formulation == row.formulation)
        row.note += fmt::format("{}the run ended at look {} of at most {}", row.note.empty() ? "" : "; ", look,
                                s_.plan.looks.size());
}

store::Table PositionPoint::looks_table(const stats::Tally& tally) const {
  struct LookRow {
    std::size_t look = 0;
    std::uint64_t trials = 0;
    DecisiveRow decisive;
  };
  std::vector<LookRow> rows;
  for (std::size_t look = 0; look < s_.plan.looks.size() && s_.plan.looks[look] <= tally.trials; ++look) {
    const stats::Tally at = tally_at_look(tally, look);
    if (units(at) < 2) continue;
    for (DecisiveRow& d : decisive_rows(at)) rows.push_back({look + 1, at.trials, std::move(d)});
  }
  study::TableRows t("looks", "the rows that may end the run, at every look" + intervals_);
  study::write_rows(t, rows, [&](const LookRow& x) {
    const study::ComparisonRow& row = x.decisive.row;
    t.count("look", "number of the look, from 1", x.look);
    t.count("trials", "trials at the look", x.trials);
    t.word("table", "where the row stands", x.decisive.table);
    t.word("formulation", "which analytic prediction", row.formulation);
    t.word("quantity", "what is compared", row.quantity);
    t.estimate("ratio", "1", "analytic / Monte Carlo; of a mean, one plus its shift in sd", row.judged,
               row.judged_interval);
    t.number("margin", "1", "what agrees: within 1 -+ margin", row.margin);
    t.word("decision", "verdict at this look", row.verdict);
  });
  return t.take();
}

}  // namespace surveymc::studies::msa_position
