#include "collision/pair_event.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "base/units.h"
#include "proximity/touch_predictions.h"
#include "random/rare_channels.h"
#include "stats/intervals.h"
#include "stats/normal_tail.h"

namespace surveymc::studies::collision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using proximity::PairPoints;
using proximity::PathPoint;
using proximity::ScanDirection;

constexpr double kKeep = 2.5;  // of beta: design points within it of the least
constexpr int kMostDimensions = 10;

/// Orthonormal directions of the rows of J at the first design point, then of the others as far as they lead out of
/// them.
Eigen::MatrixXd directions_of(const Eigen::Matrix3Xd& j, const std::vector<rare::DesignPoint>& designs) {
  constexpr double kSpread = 1e-6, kNew = 0.2;
  Eigen::MatrixXd basis(j.cols(), 0);
  const auto add = [&](Eigen::VectorXd x, double least) {
    for (int twice = 0; twice < 2; ++twice) x -= basis * (basis.transpose() * x);
    if (!(x.norm() > least) || basis.cols() >= kMostDimensions) return;
    basis.conservativeResize(j.cols(), basis.cols() + 1);
    basis.col(basis.cols() - 1) = x.normalized();
  };
  const double size = j.rowwise().norm().maxCoeff();
  for (int row = 0; row < 3; ++row) add(j.row(row).transpose(), kSpread * size);
  for (const rare::DesignPoint& d : designs) add(d.z, kNew * d.beta);
  return basis;
}

std::size_t bin_of(double md, const std::pair<double, double>& range) {
  const double share = (md - range.first) / (range.second - range.first);
  return static_cast<std::size_t>(
      std::clamp(std::floor(share * PairEvent::kContactBins), 0.0, PairEvent::kContactBins - 1.0));
}

}  // namespace

std::unique_ptr<const PairEvent> pair_event(const Scenario& s, const scenario::PairReference& reference,
                                            const propagate::WellErrors& drawn, std::size_t offset,
                                            const scenario::PairFormulation& formulation,
                                            const random::Stream& stream) {
  const scenario::SurveyedWell& well = s.offsets[offset];
  const WellExtras& extras = s.extras[offset];
  std::unique_ptr<PairEvent> event(new PairEvent(s, stream, well.name, formulation.name));
  PairEvent& e = *event;
  const scenario::WellPair pair = scenario::well_pair(s, reference, well);
  const proximity::WellPath& offset_path = *pair.offset_path;
  const proximity::PairErrors& errors = pair.formulation(formulation.name);
  const bool is_hole_shared = formulation.kind == scenario::PairFormulation::Kind::shared_hole;
  const propagate::WellErrors offset_errors =
      scenario::drawn_errors(well, is_hole_shared ? well.tools_from_kickoff : well.tools, s.vertical);
  const proximity::SharedDraws shared = is_hole_shared
                                            ? proximity::draws_of_shared_hole(drawn, offset_errors, *well.kickoff)
                                            : proximity::shared_draws(drawn, offset_errors, errors);
  e.radii_ = pair.geometry.radii;
  e.depths_ = {std::pair(reference.path().md(extras.first), reference.path().md(reference.path().stations() - 1)),
               std::pair(offset_path.md(extras.first), offset_path.md(offset_path.stations() - 1))};
  e.state_ = std::make_unique<proximity::ContactState>(proximity::contact_state(
      {&drawn, s.reference.slot, extras.reference_slot_sd, extras.first, 0, &s.laws},
      {&offset_errors, well.slot, extras.slot_sd, extras.first, static_cast<std::uint32_t>(offset + 1), &s.laws},
      shared, e.radii_));
  e.hits_ = std::make_unique<proximity::HitState>(*e.state_);
  e.reference_sources_ = drawn.sources;
  e.offset_sources_ = offset_errors.sources;
  e.slots_.diagonal() = extras.reference_slot_sd.cwiseAbs2() + extras.slot_sd.cwiseAbs2();
  e.touching_ = proximity::touching_pairs(
      reference.path(), extras.first, offset_path, extras.first,
      [&](const PathPoint& a, const PathPoint& b) {
        return Matrix3d(e.slots_ + proximity::relative_covariance(
                                       errors, errors.reference->covariance_at(a.leg, a.share),
                                       errors.offset->covariance_at(b.leg, b.share), a.leg, a.share, b.leg, b.share));
      },
      e.radii_, kKeep, s.run.sampling.preparing.max_components);
  e.event_ = events::prepare_event(s.run.sampling, [&] { return e.prepare(drawn, offset_errors); });
  e.predict(pair, errors, extras.first);
  e.closest_r_ = e.predictions_.closest.offset.position - e.predictions_.closest.reference.position;
  e.closest_j_ = e.state_->derivative(drawn, offset_errors, proximity::well_point(e.predictions_.closest.reference),
                                      proximity::well_point(e.predictions_.closest.offset));
  e.leading_ = e.importance();
  e.leading_.erase(
      std::remove_if(e.leading_.begin(), e.leading_.end(), [](const PairEvent::Importance& x) { return x.design > 0; }),
      e.leading_.end());
  if (e.leading_.size() > PairEvent::kLeading) e.leading_.resize(PairEvent::kLeading);
  e.trials_ = std::make_unique<rare::EventTrials>(*e.hits_, e.event_.prepared.proposal,
                                                  rare::TrialAddresses{e.state_->calls(), random::kRareChoice}, stream);
  return event;
}

std::vector<double> PairEvent::wider_errors() const {
  if (state_->mixing().empty()) return {0};
  std::vector<double> out;
  for (double v = 0; v <= 6; v += 0.25) out.push_back(v);
  return out;
}

Eigen::Matrix3Xd PairEvent::with_mixing(Eigen::Matrix3Xd j, double v) const {
  for (const auto& m : state_->mixing())
    for (const std::uint32_t i : m.of) j.col(i) *= m.law->draw(v).factor;
  return j;
}

rare::Prepared PairEvent::prepare(const propagate::WellErrors& reference, const propagate::WellErrors& offset) {
  struct Way {
    proximity::TouchingPair pair;
    Eigen::Matrix3Xd j;
    rare::DesignPoint design;
  };
  std::vector<Way> ways;
  for (const proximity::TouchingPair& p : touching_) {
    Eigen::Matrix3Xd j =
        state_->derivative(reference, offset, proximity::well_point(p.reference), proximity::well_point(p.offset));
    const Vector3d r = p.offset.position - p.reference.position;
    std::optional<Way> best;
    for (const double v : wider_errors()) {
      const Eigen::Matrix3Xd wide = with_mixing(j, v);
      Vector3d q;
      const double beta = proximity::touching_beta(r, propagate::covariance_of(wide), radii_, &q);
      if (!std::isfinite(beta)) continue;
      Eigen::VectorXd z = proximity::design_of(wide, r, q);
      for (const auto& m : state_->mixing()) z[m.row] = v;
      if (!best || z.norm() < best->design.beta) best = Way{p, wide, {z, z.norm()}};
    }
    if (best) ways.push_back(std::move(*best));
  }
  rare::Prepared out;
  if (ways.empty()) return out;
  // The search has sorted them by the covariances between stations, which may exceed those of the draws.
  std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) { return a.design.beta < b.design.beta; });
  touching_.clear();
  for (const Way& w : ways) {
    touching_.push_back(w.pair);
    out.designs.push_back(w.design);
  }
  const Eigen::Matrix3Xd& first = ways.front().j;
  const bool is_near = out.designs.front().beta < events::kPlainBeta;
  directions_ = directions_of(first, out.designs);
  Eigen::MatrixXd errors = directions_;
  for (std::size_t i = 0; i < state_->names().size(); ++i)
    if (state_->names()[i].source == proximity::ContactState::kSlot || state_->names()[i].well < 0)
      errors.row(static_cast<Eigen::Index>(i)).setZero();
  scaled_ = errors.transpose() * errors;
  if (s_.run.sampling.method == "auto" && is_near) return out;
  constexpr double kLeastWide = 1.3;
  const double wide = std::max(kLeastWide, out.designs.front().beta / std::sqrt(3.0));
  constexpr int kRounds = 8;
  out.proposal = rare::adapt_proposal(*state_, stream_, out.designs, directions_, s_.run.sampling.preparing, wide,
                                      kRounds, true, out.evaluations);
  return out;
}

void PairEvent::predict(const scenario::WellPair& pair, const proximity::PairErrors& errors, std::size_t first) {
  const auto covariance = [&](const PairPoints& p) {
    return Matrix3d(slots_ + proximity::relative_covariance(
                                 errors, errors.reference->covariance_at(p.reference.leg, p.reference.share),
                                 errors.offset->covariance_at(p.offset.leg, p.offset.share), p.reference.leg,
                                 p.reference.share, p.offset.leg, p.offset.share));
  };
  const auto apart = [](const PairPoints& p) { return Vector3d(p.offset.position - p.reference.position); };
  // Of what the event counts: a sidetrack from where the holes have left each other.
  proximity::PairGeometry geometry = pair.geometry;
  geometry.first = geometry.first_scanned = first;
  const ScanDirection direction = ScanDirection::reference;
  const auto scanned = proximity::scan(geometry, direction, 0, 1);
  // The error of a slot is one displacement of a whole well: a constant part of C_rel = C - K - K'.
  proximity::PairErrors with_slots = errors;
  if (!slots_.isZero(0)) {
    with_slots.common.constant -= slots_ / 2;
    with_slots.is_independent = false;
  }
  const auto least = proximity::least_clearance(geometry, with_slots, direction, scanned,
                                                proximity::least_samples(geometry, direction));
  Predictions& out = predictions_;
  out.closest = least[1].pair;
  out.separation_factor = least[0].continuous;
  out.least_sf_pair = least[0].pair;
  std::size_t near = 0;
  for (const PairPoints& p : scanned) near += p.distance < out.closest.distance * 1.0001;
  out.is_equidistant = near > 2 && near * 10 > scanned.size();
  const Vector3d r = apart(out.closest);
  out.covariance = covariance(out.closest);
  const Matrix3d& c = out.covariance;
  const Vector3d &a = out.closest.reference.tangent, &b = out.closest.offset.tangent;
  const Vector3d along = (a.dot(b) < 0 ? Vector3d(a - b) : Vector3d(a + b)).normalized();
  out.sd = proximity::pedal_radius(c, r.normalized());
  out.mahalanobis = proximity::mahalanobis(r, c);
  plane_.row(0) = (r - along * along.dot(r)).normalized().transpose();
  plane_.row(1) = along.cross(Vector3d(plane_.row(0).transpose())).transpose();
  const double beta = touching_.empty()                 ? kInfinity
                      : event_.prepared.designs.empty() ? touching_.front().beta
                                                        : event_.prepared.designs.front().beta;
  out.probability = {proximity::touch_half_space(r, c, radii_),
                     proximity::touch_half_space(apart(out.least_sf_pair), covariance(out.least_sf_pair), radii_),
                     proximity::touch_slab(r, c, radii_),
                     proximity::touch_disc(r, c, radii_, along),
                     proximity::touch_point(r, c, radii_),
                     stats::normal_upper_tail(beta)};
}

std::size_t PairEvent::weights() const {
  return rare::kFirstComponent + event_.prepared.proposal.components().size() + 2 * kContactBins;
}

stats::Tally PairEvent::run_block(std::uint64_t first, int count, std::size_t number) const {
  std::vector<stats::WeightedHits> bins(2 * kContactBins);
  std::vector<double> samples;
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(count, 2);
  stats::Tally tally = trials_->run_block(first, count, [&](const rare::EventTrial& t, const rare::DrawnTrials& drawn) {
    scores.row(static_cast<Eigen::Index>(t.trial - first)) << t.weight, t.weight * score(drawn, t.lane_index);
    bins[bin_of(t.marks[0], depths_[0])].add(t.weight);
    bins[kContactBins + bin_of(t.marks[1], depths_[1])].add(t.weight);
    if (t.trial >= s_.run.save_samples) return;
    Vector3d x = closest_r_;
    for (int i = 0; i < state_->dimension(); ++i) x += closest_j_.col(i) * drawn.z.value(t.lane_index, i);
    const Eigen::Vector2d at = plane_ * x;
    samples.insert(samples.end(), {static_cast<double>(number + 1), static_cast<double>(t.trial), t.weight,
                                   static_cast<double>(t.component), t.marks[0], t.marks[1], at[0], at[1]});
    for (std::size_t k = 0; k < kLeading; ++k) {
      double towards = k < leading_.size() ? 0 : kNaN;
      for (int i = 0; k < leading_.size() && i < state_->dimension(); ++i)
        towards += leading_[k].direction[i] * drawn.z.value(t.lane_index, i);
      samples.push_back(towards);
    }
  });
  tally.weighted.insert(tally.weighted.end(), bins.begin(), bins.end());
  tally.samples = std::move(samples);
  tally.moments = stats::Moments::of(scores);
  return tally;
}

double PairEvent::score(const rare::DrawnTrials& drawn, int trial) const {
  if (directions_.cols() == 0) return 0;
  Eigen::VectorXd y;
  if (event_.prepared.proposal.is_plain()) {
    y = Eigen::VectorXd::Zero(directions_.cols());
    for (Eigen::Index i = 0; i < directions_.rows(); ++i)
      y += directions_.row(i).transpose() * drawn.z.value(trial, static_cast<int>(i));
  } else {
    y = drawn.y.col(trial);
  }
  return y.dot(scaled_ * y) - scaled_.trace();
}

PairEvent::SizeSlope PairEvent::size_slope(const stats::Moments& m, double confidence) const {
  if (directions_.cols() == 0 || m.count < 2 || !(m.mean[0] > 0)) return {};
  const double slope = m.mean[1] / m.mean[0];
  const Eigen::MatrixXd c = m.covariance();
  const double variance = (c(1, 1) - 2 * slope * c(0, 1) + slope * slope * c(0, 0)) / static_cast<double>(m.count);
  const double half = stats::normal_quantile((1 + confidence) / 2) * std::sqrt(std::max(0.0, variance)) / m.mean[0];
  return {slope, slope - half, slope + half};
}

stats::Tally PairEvent::subset_replicates(std::uint64_t first, int count) const {
  return rare::run_subset_replicates(*state_, stream_, first, count, s_.run.sampling.subset_samples);
}

std::string PairEvent::replay(std::uint64_t trial) const {
  const std::string head = fmt::format("  {}, {}: ", offset_, correlation_);
  if (event_.method == "subset") {
    const rare::SubsetReplicate r = rare::subset_simulation(*state_, stream_, trial, s_.run.sampling.subset_samples);
    return head +
           fmt::format("probability {:.17g}, levels {}, evaluations {}\n", r.probability, r.levels, r.evaluations);
  }
  rare::EventTrials all(*state_, event_.prepared.proposal, rare::TrialAddresses{state_->calls(), random::kRareChoice},
                        stream_);
  proximity::Contact c;
  double reference_md = 0, offset_md = 0;
  const rare::EventTrial t = all.replay(trial, [&](const rare::EventTrial& at, const rare::DrawnTrials& drawn) {
    c = state_->contact(drawn.z, at.lane_index, reference_md, offset_md);
  });
  const auto& components = event_.prepared.proposal.components();
  return head + fmt::format(
                    "g {:.17g} m{}, weight {:.17g}, component {} ({}), nearest at {:.10g} m of the reference and "
                    "{:.10g} m of the offset\n",
                    t.g, t.g <= 0 ? " (a hit)" : "", t.weight, t.component,
                    components.empty() ? "plain" : rare::name_of(components[t.component].kind), reference_md,
                    offset_md);
}

std::vector<PairEvent::Importance> PairEvent::importance() const {
  std::vector<Importance> out;
  for (std::size_t k = 0; k < event_.prepared.designs.size(); ++k) {
    const rare::DesignPoint& d = event_.prepared.designs[k];
    std::map<std::pair<int, std::uint32_t>, Eigen::VectorXd> of_sources;
    for (std::size_t i = 0; i < state_->names().size(); ++i) {
      const auto& name = state_->names()[i];
      const auto at = static_cast<Eigen::Index>(i);
      if (name.well < 0 || d.z[at] == 0) continue;
      of_sources.try_emplace({name.well, name.source}, Eigen::VectorXd::Zero(d.z.size())).first->second[at] =
          d.z[at] / d.beta;
    }
    const auto first = static_cast<std::ptrdiff_t>(out.size());
    for (const auto& [name, alpha] : of_sources) {
      Importance x{k,
                   "slot",
                   "",
                   name.first == 0   ? "reference"
                   : name.first == 1 ? offset_
                                     : "both",
                   alpha.squaredNorm(),
                   alpha.normalized()};
      if (name.second != proximity::ContactState::kSlot) {
        const propagate::ErrorSource& source = (name.first == 1 ? offset_sources_ : reference_sources_)[name.second];
        x.code = source.code;
        x.mode = std::string(1, error_model::mode_letter(source.mode));
      }
      out.push_back(std::move(x));
    }
    std::stable_sort(out.begin() + first, out.end(),
                     [](const Importance& x, const Importance& y) { return x.factor > y.factor; });
  }
  return out;
}

}  // namespace surveymc::studies::collision
