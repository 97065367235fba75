#include "multistation/robust.h"

#include <cmath>
#include <utility>

#include "base/error.h"
#include "multistation/robust_lanes.h"
#include "multistation/subsets.h"

namespace surveymc::multistation {

int robust_components(const FitPlan& plan) {
  const bool of_reference = plan.kinds[static_cast<std::size_t>(plan.kind_count - 1)] == kReferenceKind,
             sees_gravity = plan.corrects_accelerometers || (of_reference && plan.gravity_is_noisy);
  return sees_gravity ? kResiduals : kResiduals - 1;
}

int noisy_components(const FitPlan& plan) { return plan.gravity_is_noisy ? robust_components(plan) : kResiduals - 1; }

RobustOptions robust_options(Loss loss, RobustStart start) {
  RobustOptions o;
  o.loss = loss;
  o.start = start;
  if (loss == Loss::tukey) {
    o.start = RobustStart::lmeds;
    o.scale = RobustScale::start;
  }
  return o;
}

LossCost loss_cost(Loss loss, const FitPlan& plan) { return loss_cost(loss, noisy_components(plan)); }

FitOptions as_weighed(FitOptions o, const LossCost& cost) {
  if (!o.gravity_is_noisy) o.sizes[0] *= std::sqrt(cost.slope / cost.mean_trust);
  return o;
}

void fit_block_by_loss(const SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set,
                       const RobustOptions& options, const random::Stream& stream, std::uint64_t first_trial,
                       FitBlock& out, RobustBlock& robust) {
  if (options.loss == Loss::least_squares)
    fit_block(readings, plan, set, out);
  else
    robust_fit_block(readings, plan, set, options, stream, first_trial, out, robust);
}

void robust_fit_block(const SixAxisBlock& r, const FitPlan& plan, const ParameterSet& set, const RobustOptions& options,
                      const random::Stream& stream, std::uint64_t first_trial, FitBlock& out, RobustBlock& robust,
                      const survey::LaneArray* given, const std::array<double, kUnknowns>& start) {
  RobustBatch b{};
  b.fit = batch_of(r, plan, set, out, given);
  b.options = options;
  b.options.smallest_scale = 1e-9;  // of the sizes: exact readings have no scale
  b.problem.shape = {r.stations, robust_components(plan), plan.size()};
  std::array<double, kUnknowns> unit, information;
  for (int i = 0; i < plan.size(); ++i) {
    const std::size_t at = static_cast<std::size_t>(plan.kinds[static_cast<std::size_t>(i / 3)] + i % 3);
    unit[static_cast<std::size_t>(i)] = 1;
    information[static_cast<std::size_t>(i)] = plan.free[at] ? plan.precision[at] : 1;
  }
  std::array<bool, kUnknownKinds> moves_first{};
  for (int a = 0; a < plan.kind_count; ++a) {
    const int kind = plan.kinds[static_cast<std::size_t>(a)];
    moves_first[static_cast<std::size_t>(a)] = is_of_accelerometer(kind) || kind == kReferenceKind;
  }
  b.problem.moves_first = moves_first.data();
  b.problem.unit = unit.data();
  b.problem.prior_information = information.data();
  b.problem.scale_of_median = scale_of_median(noisy_components(plan));
  std::vector<int> subsets;
  if (options.start == RobustStart::lmeds) {
    b.problem.subset_count = kSubsets;
    b.problem.subset_size = subset_size(set.size(), r.stations);
    for (int g = 0; g < r.groups(); ++g) {
      const std::vector<int> own = draw_subsets(stream, first_trial / simd::kGroup + static_cast<std::uint64_t>(g),
                                                r.stations, b.problem.subset_size);
      subsets.insert(subsets.end(), own.begin(), own.end());
      b.subsets_stride = own.size();
    }
    b.problem.subsets = subsets.data();
  }
  survey::LaneArray scratch(1, static_cast<int>(RobustMemory<double>::size(b.problem.shape)));
  b.start = start.data();
  b.scratch = scratch.row(0, 0);
  b.weights = robust.weights.row(0, 0);
  b.weights_stride = robust.weights.group_stride();
  b.scale = robust.scale.row(0, 0);
  b.reweightings = robust.reweightings.row(0, 0);
  b.scalar_stride = robust.scale.group_stride();
  simd::run_kernel<isa_v3::robust_batch, isa_v4::robust_batch>(b);
}

RobustFit robust_fit(const std::vector<StationReadings>& stations, const FitOptions& o, const RobustOptions& robust,
                     const random::Stream& stream) {
  const FitPlan plan = fit_plan(o);
  const int count = static_cast<int>(stations.size());
  const Fit squares = fit(stations, o);
  std::array<double, kUnknowns> start{};
  const std::array<double, 3> reference{squares.reference.gravity, squares.reference.total, squares.reference.dip};
  for (int i = 0; squares.converged && i < plan.size(); ++i) {
    const auto at = static_cast<std::size_t>(plan.kinds[static_cast<std::size_t>(i / 3)] + i % 3);
    start[static_cast<std::size_t>(i)] =
        (at < kParameters ? squares.tool[at] : reference[at - kParameters]) / plan.scale[at];
  }
  FitBlock found(1, o);
  RobustBlock block(1, count);
  robust_fit_block(block_of(stations), plan, o.parameters, robust, stream, 0, found, block, nullptr, start);
  require(found.converged.value(0, 0) != 0,
          "the robust fit of {} stations has no solution: too few of them, or no weight is left", count);
  RobustFit out;
  for (int k = 0; k < count; ++k) out.weights.push_back(block.weights.value(0, k));
  out.scale = block.scale.value(0, 0);
  out.reweightings = static_cast<int>(block.reweightings.value(0, 0));
  constexpr const char* kNoFit = "the fit of {} stations with the weights of the loss does not converge";
  out.fit = fit(stations, o, out.weights);
  require(out.fit.converged, kNoFit, count);
  const LossCost cost = loss_cost(robust.loss, plan);
  std::vector<double> information;
  for (const double w : out.weights) information.push_back(cost.information(w));
  if (information != out.weights) {
    Fit claimed = fit(stations, as_weighed(o, cost), information);
    require(claimed.converged, kNoFit, count);
    out.fit.inverse = std::move(claimed.inverse);
    out.fit.by_reference = std::move(claimed.by_reference);
  }
  out.factor = cost.claimed_variance();
  claim_for_variance(out.fit, o, out.factor);
  return out;
}

}  // namespace surveymc::multistation
