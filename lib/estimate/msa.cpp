#include "estimate/msa.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "estimate/msa_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::estimate {
namespace {

/// The readings of some trials; spare lanes repeat the last of them.
survey::ReadingBlock readings_of(const std::vector<int>& trials, const survey::ReadingBlock& in) {
  const int count = static_cast<int>(trials.size());
  survey::ReadingBlock out(count, in.stations, !in.down.shared(), in.reference_stride != 0);
  const auto copy = [&](const survey::LaneArray& from, survey::LaneArray& to, int rows) {
    for (int t = 0; t < survey::groups_for(to.shared() ? 1 : count) * simd::kGroup; ++t)
      for (int r = 0; r < rows; ++r)
        to.row(t / simd::kGroup, r)[t % simd::kGroup] =
            from.value(trials[static_cast<std::size_t>(std::min(t, count - 1))], r);
  };
  copy(in.magnetic, out.magnetic, 3 * in.stations);
  copy(in.down, out.down, 3 * in.stations);
  copy(in.reference, out.reference, in.reference_stride == 0 ? 2 : 2 * in.stations);
  return out;
}

class Msa final : public Estimator {
 public:
  Msa(const NewtonOptions& options, double total, std::optional<MsaExpansion> expansion,
      std::optional<MsaValley> valley)
      : options_(options), total_(total), expansion_(expansion), valley_(std::move(valley)) {}
  std::string name() const override { return "msa"; }

  void solve(const survey::ReadingBlock& in, EstimateBlock& out) const override {
    run(in, out, Start::known);
    if (!expansion_ && !valley_) return;
    std::vector<int> far;
    for (int t = 0; t < in.trials; ++t)
      if (out.converged.value(t, 0) == 0) far.push_back(t);
    if (far.empty()) return;
    EstimateBlock whole(static_cast<int>(far.size()));
    for (int t = 0; t < survey::groups_for(static_cast<int>(far.size())) * simd::kGroup; ++t)
      for (int a = 0; a < 6; ++a)
        whole.parameters.row(t / simd::kGroup, a)[t % simd::kGroup] =
            out.parameters.value(far[std::min(static_cast<std::size_t>(t), far.size() - 1)], a);
    run(readings_of(far, in), whole, valley_ ? Start::estimates : Start::unit_gains);
    for (std::size_t i = 0; i < far.size(); ++i) {
      const int from = static_cast<int>(i), group = far[i] / simd::kGroup, lane = far[i] % simd::kGroup;
      for (int a = 0; a < 6; ++a) out.parameters.row(group, a)[lane] = whole.parameters.value(from, a);
      out.cost.row(group, 0)[lane] = whole.cost.value(from, 0);
      out.iterations.row(group, 0)[lane] += whole.iterations.value(from, 0);
      out.converged.row(group, 0)[lane] = whole.converged.value(from, 0);
    }
  }

 private:
  /// known: the expansion or the valley, if there is one; estimates: those that are in `out`.
  enum class Start { known, estimates, unit_gains };
  void run(const survey::ReadingBlock& in, EstimateBlock& out, Start start) const {
    const bool near = start == Start::known;
    const MsaBatch batch{{in.magnetic.row(0, 0), in.down.row(0, 0), in.reference.row(0, 0), in.stations,
                          in.reference_stride, 1 / total_},
                         in.magnetic.group_stride(),
                         in.down.group_stride(),
                         in.reference.group_stride(),
                         out.parameters.row(0, 0),
                         out.cost.row(0, 0),
                         out.iterations.row(0, 0),
                         out.converged.row(0, 0),
                         out.parameters.group_stride(),
                         out.cost.group_stride(),
                         in.groups(),
                         total_,
                         options_,
                         near && expansion_ ? &*expansion_ : nullptr,
                         near && valley_ ? &*valley_ : nullptr,
                         start == Start::estimates};
    simd::run_kernel<isa_v3::msa_solve_batch, isa_v4::msa_solve_batch>(batch);
  }

  NewtonOptions options_;
  double total_;
  std::optional<MsaExpansion> expansion_;
  std::optional<MsaValley> valley_;
};

}  // namespace

survey::ReadingBlock expected_readings(const std::vector<survey::StationFields>& truth,
                                       const std::vector<survey::Vec3<double>>& expected,
                                       const survey::ReferenceField& field) {
  const int stations = static_cast<int>(expected.size());
  survey::ReadingBlock one(1, stations, false, false);
  for (int k = 0; k < stations; ++k) {
    const survey::Vec3<double>&m = expected[static_cast<std::size_t>(k)],
          &u = truth[static_cast<std::size_t>(k)].down_T;
    const double rows[2][3] = {{m.x, m.y, m.z}, {u.x, u.y, u.z}};
    for (int i = 0; i < 3; ++i) {
      one.magnetic.fill(0, 3 * k + i, rows[0][i]);
      one.down.fill(0, 3 * k + i, rows[1][i]);
    }
  }
  one.reference.fill(0, 0, field.total * std::cos(field.dip));
  one.reference.fill(0, 1, field.total * std::sin(field.dip));
  return one;
}

std::optional<MsaExpansion> msa_expansion(const std::vector<survey::StationFields>& truth,
                                          const std::vector<survey::Vec3<double>>& expected,
                                          const survey::ReferenceField& field) {
  const survey::ReadingBlock one = expected_readings(truth, expected, field);
  const MsaData data{one.magnetic.row(0, 0), one.down.row(0, 0),   one.reference.row(0, 0),
                     one.stations,           one.reference_stride, 1 / field.total};
  const MsaSolution<double> s = msa_solve<double>(data, NewtonOptions{});
  if (s.converged == 0) return std::nullopt;
  const auto e = msa_normal_equations<double>(data, msa_reading_sums<double>(data), s.x, 1.0);
  const simd::Symmetric<double, 6> factor = simd::ldlt<double, 6>(e.matrix);
  MsaExpansion out{s.x, {}};
  for (std::size_t j = 0; j < 6; ++j) {
    if (!(factor[simd::packed(j, j)] > 0)) return std::nullopt;  // 1 / D
    std::array<double, 6> unit{};
    unit[j] = 1;
    const std::array<double, 6> column = simd::ldlt_solve<double, 6>(factor, unit);
    for (std::size_t i = 0; i < 6; ++i) out.inverse[6 * i + j] = column[i];
  }
  return out;
}

std::unique_ptr<Estimator> make_msa_from(const NewtonOptions& options, double total,
                                         std::optional<MsaExpansion> expansion, std::optional<MsaValley> valley) {
  return std::make_unique<Msa>(options, total, expansion, std::move(valley));
}

std::unique_ptr<Estimator> make_msa(const NewtonOptions& options, const survey::ReferenceField& field,
                                    const std::vector<survey::StationFields>& truth,
                                    const std::vector<survey::Vec3<double>>& expected) {
  const bool near = !expected.empty() && expected.size() == truth.size();
  return make_msa_from(options, field.total, near ? msa_expansion(truth, expected, field) : std::nullopt, std::nullopt);
}

std::unique_ptr<Estimator> make_msa_in_valley(const NewtonOptions& options, const survey::ReferenceField& field,
                                              const std::vector<survey::StationFields>& truth,
                                              const std::vector<survey::Vec3<double>>& expected) {
  std::optional<MsaValley> valley = msa_valley(truth, expected, field);
  if (!valley) return nullptr;
  return make_msa_from(options, field.total, std::nullopt, std::move(valley));
}

}  // namespace surveymc::estimate
