#include "estimate/msa.h"

#include <cmath>
#include <optional>

#include "estimate/msa_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::estimate {
namespace {

class Msa final : public Estimator {
 public:
  Msa(const NewtonOptions& options, double total, std::optional<MsaExpansion> expansion)
      : options_(options), total_(total), expansion_(expansion) {}
  std::string name() const override { return "msa"; }

  void solve(const survey::ReadingBlock& in, EstimateBlock& out) const override {
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
                         expansion_ ? &*expansion_ : nullptr};
    if (simd::instruction_set() == simd::InstructionSet::v4)
      isa_v4::msa_solve_batch(batch);
    else
      isa_v3::msa_solve_batch(batch);
  }

 private:
  NewtonOptions options_;
  double total_;
  std::optional<MsaExpansion> expansion_;
};

}  // namespace

std::optional<MsaExpansion> msa_expansion(const std::vector<survey::StationFields>& truth,
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
  const MsaData data{one.magnetic.row(0, 0), one.down.row(0, 0), one.reference.row(0, 0), stations,
                     one.reference_stride,   1 / field.total};
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

std::unique_ptr<Estimator> make_msa(const NewtonOptions& options, const survey::ReferenceField& field,
                                    const std::vector<survey::StationFields>& truth,
                                    const std::vector<survey::Vec3<double>>& expected) {
  const bool near = !expected.empty() && expected.size() == truth.size();
  return std::make_unique<Msa>(options, field.total, near ? msa_expansion(truth, expected, field) : std::nullopt);
}

}  // namespace surveymc::estimate
