#include "proximity/pair_errors.h"

#include <algorithm>

#include "propagate/disturbed_errors.h"

namespace surveymc::proximity {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using error_model::PropagationMode;
using propagate::StationEffects;

namespace {

/// True if the source is one draw along the well.
bool is_one_draw(const StationEffects& e, std::size_t source) {
  int draw = StationEffects::kNone;
  for (std::size_t k = 0; k < e.stations; ++k) {
    const int own = e.draw[source * e.stations + k];
    if (own == StationEffects::kNone) continue;
    if (draw != StationEffects::kNone && own != draw) return false;
    draw = own;
  }
  return draw != StationEffects::kNone;
}

/// s_i of draw `draw` of a source at all stations from `first` on; effects of other draws do not count.
std::vector<Vector3d> sums_of_draw(const StationEffects& e, std::size_t source, int draw, std::size_t first) {
  std::vector<Vector3d> out;
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < e.stations; ++k) {
    const std::size_t at = source * e.stations + k;
    const bool is_here = e.draw[at] == draw;
    if (k >= first) out.push_back(is_here ? Vector3d(sum + e.star[at]) : sum);
    if (is_here) sum += e.full[at];
  }
  return out;
}

/// Puts s_i of the given sources and draws in order of stations; those before `first` are zero.
void set_summed(const std::vector<std::vector<Vector3d>>& by_source, std::size_t stations, std::size_t first,
                PositionErrors& out) {
  out.summed.assign(stations * by_source.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < by_source.size(); ++i)
    for (std::size_t k = first; k < stations; ++k) out.summed[k * by_source.size() + i] = by_source[i][k - first];
}

void set_joining_sources(const StationEffects& e, PositionErrors& out) {
  std::vector<std::vector<Vector3d>> summed;
  for (std::size_t s = 0; s < e.sources.size(); ++s) {
    if (!error_model::joins_legs(e.sources[s].mode) || !is_one_draw(e, s)) continue;
    out.sources.push_back({e.sources[s].code, e.sources[s].mode, e.sources[s].function});
    summed.push_back(sums_of_draw(e, s, 1, 0));
  }
  set_summed(summed, e.stations, 0, out);
}

}  // namespace

Matrix3d PositionErrors::covariance_at(std::size_t leg, double f) const {
  if (f == 0) return covariance[leg];
  if (f == 1) return covariance[leg + 1];
  if (step.empty()) return (1 - f) * covariance[leg] + f * covariance[leg + 1];
  return (1 - f) * (1 - f) * covariance[leg] + f * f * covariance[leg + 1] +
         f * (1 - f) * (step[leg] + step[leg].transpose());
}

Vector3d PositionErrors::summed_at(std::size_t source, std::size_t leg, double f) const {
  const std::size_t n = sources.size();
  if (f == 0) return summed[leg * n + source];
  if (f == 1) return summed[(leg + 1) * n + source];
  return (1 - f) * summed[leg * n + source] + f * summed[(leg + 1) * n + source];
}

void sum_effects(const StationEffects& e, std::size_t first, PositionErrors& out) {
  out.covariance.assign(e.stations, Matrix3d::Zero());
  out.step.assign(e.stations - 1, Matrix3d::Zero());
  for (std::size_t s = 0; s < e.sources.size(); ++s) {
    Vector3d sum = Vector3d::Zero(), before = Vector3d::Zero();  // of the draw at hand; its part of eps_k-1
    Matrix3d past = Matrix3d::Zero();                            // of the draws that ended
    int draw = StationEffects::kNone;
    for (std::size_t k = first; k < e.stations; ++k) {
      const std::size_t at = s * e.stations + k;
      const bool is_here = e.draw[at] != StationEffects::kNone;
      Matrix3d step = past;
      if (is_here && e.draw[at] != draw) {
        step += before * sum.transpose();
        past += sum * sum.transpose();
        sum.setZero();
        before.setZero();
        draw = e.draw[at];
      }
      const Vector3d own = is_here ? Vector3d(sum + e.star[at]) : sum;
      step += before * own.transpose();
      out.covariance[k] += past + own * own.transpose();
      if (k > first) out.step[k - 1] += step;
      before = own;
      if (is_here) sum += e.full[at];
    }
  }
}

PositionErrors position_errors(const survey::Survey& survey, const std::vector<double>& tvd,
                               const std::vector<propagate::ToolRun>& runs, const survey::ReferenceField& field,
                               double latitude, Interpolation interpolation, propagate::ToolCovariances* out,
                               const disturbance::Disturbance* disturbance) {
  const bool is_disturbed = disturbance != nullptr && disturbance->has_memory();
  StationEffects effects;
  propagate::ToolCovariances own =
      propagate::tool_covariances(survey, tvd, runs, field, latitude, propagate::SourceDetail::none, &effects,
                                  interpolation == Interpolation::covariance && !is_disturbed);
  if (is_disturbed) {
    propagate::add_correlation(own, effects, runs, *disturbance, field, propagate::SourceDetail::none);
    if (interpolation == Interpolation::effects)
      effects = propagate::with_independent_draws(effects, runs, *disturbance, field);
  }
  PositionErrors w;
  if (interpolation == Interpolation::effects) sum_effects(effects, 0, w);
  w.covariance = own.total;
  set_joining_sources(effects, w);
  if (out != nullptr) *out = std::move(own);
  return w;
}

Matrix3d relative_covariance(const PairErrors& pair, const Matrix3d& c_reference, const Matrix3d& c_offset,
                             std::size_t reference_leg, double reference_share, std::size_t offset_leg,
                             double offset_share) {
  Matrix3d c = c_reference + c_offset;
  if (pair.is_independent) return c;
  Matrix3d common = pair.common.constant;
  for (const auto& [i, j] : pair.common.sources)
    common += pair.reference->summed_at(i, reference_leg, reference_share) *
              pair.offset->summed_at(j, offset_leg, offset_share).transpose();
  return c - common - common.transpose();
}

bool is_shared(Sharing sharing, const std::vector<std::string>& codes, const JoiningSource& source) {
  const bool is_global = source.mode == PropagationMode::global;
  switch (sharing) {
    case Sharing::none:
      return false;
    case Sharing::geomagnetic:
      return is_global && (source.function == "AZ" || source.function == "DBH");
    case Sharing::global:
      return is_global;
    case Sharing::pad:
      return true;
    case Sharing::listed:
      return std::find(codes.begin(), codes.end(), source.code) != codes.end();
  }
  return false;
}

std::vector<std::pair<std::size_t, std::size_t>> shared_sources(Sharing sharing, const std::vector<std::string>& codes,
                                                                const PositionErrors& reference,
                                                                const PositionErrors& offset) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  for (std::size_t i = 0; i < reference.sources.size(); ++i)
    for (std::size_t j = 0; j < offset.sources.size(); ++j)
      if (reference.sources[i].code == offset.sources[j].code && reference.sources[i].mode == offset.sources[j].mode &&
          is_shared(sharing, codes, reference.sources[i]) && is_shared(sharing, codes, offset.sources[j]))
        out.emplace_back(i, j);
  return out;
}

PairErrors shared_hole(const StationEffects& reference, const StationEffects& offset, std::size_t kickoff) {
  auto r = std::make_shared<PositionErrors>(), o = std::make_shared<PositionErrors>();
  sum_effects(reference, 0, *r);
  sum_effects(offset, 0, *o);
  PairErrors pair{"shared", nullptr, nullptr, {}, false};
  std::vector<std::vector<Vector3d>> of_reference, of_offset;
  for (std::size_t i = 0; i < reference.sources.size(); ++i)
    for (std::size_t j = 0; j < offset.sources.size(); ++j) {
      if (reference.sources[i].code != offset.sources[j].code || reference.sources[i].mode != offset.sources[j].mode)
        continue;
      std::vector<int> draws;  // that move a station of the shared hole, or join all legs
      for (std::size_t k = 1; k <= kickoff; ++k) {
        const int draw = reference.draw[i * reference.stations + k];
        if (draw != StationEffects::kNone && (draws.empty() || draws.back() != draw)) draws.push_back(draw);
      }
      if (error_model::joins_legs(reference.sources[i].mode) && draws.empty()) draws.push_back(1);
      for (const int draw : draws) {
        std::vector<Vector3d> a = sums_of_draw(reference, i, draw, kickoff), b = sums_of_draw(offset, j, draw, kickoff);
        const auto is_constant = [](const std::vector<Vector3d>& x) {
          return std::all_of(x.begin(), x.end(), [&](const Vector3d& v) { return v == x.front(); });
        };
        if (is_constant(a) && is_constant(b)) {
          pair.common.constant += a.front() * b.front().transpose();
          continue;
        }
        pair.common.sources.emplace_back(of_reference.size(), of_reference.size());
        of_reference.push_back(std::move(a));
        of_offset.push_back(std::move(b));
        r->sources.push_back({reference.sources[i].code, reference.sources[i].mode, reference.sources[i].function});
        o->sources.push_back(r->sources.back());
      }
    }
  set_summed(of_reference, reference.stations, kickoff, *r);
  set_summed(of_offset, offset.stations, kickoff, *o);
  pair.reference = r;
  pair.offset = o;
  return pair;
}

namespace {

/// Errors of the part of a well from its kick-off on, which counts as known.
std::shared_ptr<const PositionErrors> errors_from(StationEffects e, std::size_t kickoff, const Vector3d& tangent,
                                                  Interpolation interpolation) {
  for (std::size_t s = 0; s < e.sources.size(); ++s) {
    const std::size_t at = s * e.stations + kickoff;
    // Half the leg below with its angles and -(t_0 + t_1)/2 with its depth; that the kick-off itself is where it is
    // adds t_0 to the latter.
    e.full[at] = e.full[at] - e.star[at] + e.depth[at] * tangent;
    e.star[at].setZero();
  }
  auto w = std::make_shared<PositionErrors>();
  sum_effects(e, kickoff, *w);
  if (interpolation == Interpolation::covariance) w->step.clear();
  return w;
}

}  // namespace

PairErrors zeroed_at_kickoff(const StationEffects& reference, const StationEffects& offset, std::size_t kickoff,
                             const Vector3d& tangent, Interpolation interpolation) {
  return {"zeroed",
          errors_from(reference, kickoff, tangent, interpolation),
          errors_from(offset, kickoff, tangent, interpolation),
          {},
          true};
}

}  // namespace surveymc::proximity
