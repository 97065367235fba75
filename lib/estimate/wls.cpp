#include "estimate/wls.h"

#include "base/error.h"
#include "estimate/wls_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::estimate {
namespace {

class Wls final : public Estimator {
 public:
  Wls(const InputErrors& assumed, const std::vector<survey::StationFields>& truth) : assumed_(assumed) {
    for (const survey::StationFields& s : truth) truth_.push_back(s.field_T);
    total_ = norm(truth_.front());
  }
  std::string name() const override { return "wls"; }

  void solve(const survey::ReadingBlock& in, EstimateBlock& out) const override {
    require(in.stations == static_cast<int>(truth_.size()),
            "wls knows the true field of {} stations, the survey has {}", truth_.size(), in.stations);
    WlsBatch b{};
    b.truth = &truth_.front().x;
    b.magnetic = in.magnetic.row(0, 0);
    b.magnetic_stride = in.magnetic.group_stride();
    if (in.has_assumed_sd) {
      b.assumed_sd = in.assumed_sd.row(0, 0);
      b.assumed_stride = in.assumed_sd.group_stride();
    }
    b.stations = in.stations;
    b.groups = in.groups();
    b.sd = assumed_.magnetometer;
    b.gain_weight = assumed_.gain > 0 ? 1 / (assumed_.gain * assumed_.gain) : 0;
    for (int axis = 0; axis < 3; ++axis)
      if (const double sd = assumed_.bias_sd(axis); sd > 0) b.bias_weight[axis] = 1 / (sd * sd);
    b.total = total_;
    b.parameters = out.parameters.row(0, 0);
    b.claimed_variance = out.claimed_variance.row(0, 0);
    b.parameters_stride = out.parameters.group_stride();
    b.cost = out.cost.row(0, 0);
    b.iterations = out.iterations.row(0, 0);
    b.converged = out.converged.row(0, 0);
    b.scalar_stride = out.cost.group_stride();
    simd::run_kernel<isa_v3::wls_batch, isa_v4::wls_batch>(b);
  }

 private:
  InputErrors assumed_;
  std::vector<survey::Vec3<double>> truth_;
  double total_ = 1;
};

}  // namespace

std::unique_ptr<Estimator> make_wls(const InputErrors& assumed, const std::vector<survey::StationFields>& truth) {
  require_weights(assumed);
  require(!truth.empty(), "wls needs the true field at every station: it cannot be used on readings alone");
  return std::make_unique<Wls>(assumed, truth);
}

}  // namespace surveymc::estimate
