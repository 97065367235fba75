#include "estimate/msa.h"

#include "estimate/msa_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc {
namespace {

class Msa final : public Estimator {
 public:
  Msa(const MsaOptions& options, double total) : options_(options), total_(total) {}
  std::string name() const override { return "msa"; }

  void solve(const ReadingBlock& in, EstimateBlock& out) const override {
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
                         options_};
    if (instruction_set() == InstructionSet::v4)
      isa_v4::msa_solve_batch(batch);
    else
      isa_v3::msa_solve_batch(batch);
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
