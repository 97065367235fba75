#include "estimate/msa.h"

namespace surveymc {
namespace {

class Msa final : public Estimator {
 public:
  Msa(const MsaOptions& options, double total) : options_(options), total_(total) {}
  std::string name() const override { return "msa"; }

  void solve(const ReadingBlock& in, EstimateBlock& out) const override {
    using T = Lanes;
    for (int group = 0; group < in.groups(); ++group)
      for (int i = 0; i < kGroup; i += lane_count<T>) {
        const MsaSolution<T> s =
            msa_solve<T>({in.magnetic.row(group, 0) + i, in.down.row(group, 0) + i, in.reference.row(group, 0) + i,
                          in.stations, in.reference_stride, 1 / total_},
                         options_);
        for (int a = 0; a < 3; ++a) {
          const auto j = static_cast<std::size_t>(a);
          const T gain = T(1.0) / s.x[j];
          store(out.parameters.row(group, a) + i, gain);
          store(out.parameters.row(group, 3 + a) + i, s.x[3 + j] * gain * T(total_));
        }
        store(out.cost.row(group, 0) + i, s.cost * T(total_ * total_));
        store(out.iterations.row(group, 0) + i, s.iterations);
        store(out.converged.row(group, 0) + i, s.converged);
      }
  }

 private:
  MsaOptions options_;
  double total_;
};

}  // namespace

std::unique_ptr<Estimator> make_msa(const MsaOptions& options, const ReferenceField& field) {
  return std::make_unique<Msa>(options, field.total);
}

}  // namespace surveymc
