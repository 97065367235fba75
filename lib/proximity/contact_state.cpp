#include "proximity/contact_state.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "random/rare_channels.h"

namespace surveymc::proximity {

using Eigen::Vector3d;
using propagate::DrawPlace;
using propagate::kPathRows;
using propagate::WellErrors;
using propagate::WellPoint;

ContactState::Side ContactState::make_side(const DrawnWellPlace& place, const std::vector<DrawPlace>& places) {
  const WellPoint last{place.errors->survey.stations.size() - 1, 1};
  propagate::WellMixing mixing;
  if (place.laws != nullptr) mixing = propagate::well_mixing(*place.errors, *place.laws, places);
  propagate::DrawnWell well = propagate::drawn_well(*place.errors, {last}, places, false, mixing);
  return {
      place.slot, place.slot_sd, place.errors->survey.md(), place.first, 0, std::move(well), {}, {}, std::move(mixing),
      {}};
}

int ContactState::row_of(random::Channel channel, std::uint32_t index) {
  const auto at = std::find_if(calls_.begin(), calls_.end(),
                               [&](const rare::NormalCall& c) { return c.channel == channel && c.call == index / 4; });
  const auto number = at - calls_.begin();
  if (at == calls_.end()) calls_.push_back({channel, index / 4});
  names_.resize(4 * calls_.size(), {-1, 0});
  return static_cast<int>(4 * number + index % 4);
}

void ContactState::add_rows(Side& side, const std::vector<DrawPlace>& places) {
  for (const propagate::DrawCall& c : side.well.calls())
    side.rows.push_back(static_cast<std::uint32_t>(row_of(c.channel, 4 * c.call)));
  for (const DrawPlace& p : places) {
    const auto at = std::find_if(calls_.begin(), calls_.end(), [&](const rare::NormalCall& c) {
      return c.channel == p.channel && c.call == p.index / 4;
    });
    // A draw without effect has no call.
    side.draw_rows.push_back(at == calls_.end() ? 0xffffffffu
                                                : static_cast<std::uint32_t>(4 * (at - calls_.begin())) + p.index % 4);
  }
}

void ContactState::add_mixing(Side& side, const WellErrors& errors) {
  for (const random::MixingSlot& slot : side.well.slots())
    side.slot_rows.push_back(static_cast<std::uint32_t>(row_of(slot.channel, slot.index)));
  for (std::size_t d = 0; d < errors.station_draws; ++d) {
    const int number = side.mixing.slot_of_draw.empty() ? -1 : side.mixing.slot_of_draw[d];
    if (number < 0 || side.draw_rows[d] == 0xffffffffu) continue;
    const random::MixingSlot& slot = side.mixing.slots[static_cast<std::size_t>(number)];
    const auto row = static_cast<std::uint32_t>(row_of(slot.channel, slot.index));
    auto at = std::find_if(mixing_.begin(), mixing_.end(), [&](const rare::MixingNormal& m) { return m.row == row; });
    if (at == mixing_.end()) at = mixing_.insert(at, {row, slot.law, {}});
    if (std::find(at->of.begin(), at->of.end(), side.draw_rows[d]) == at->of.end()) at->of.push_back(side.draw_rows[d]);
  }
}

void ContactState::name_normals(const Side& side, const WellErrors& errors, int well) {
  for (std::size_t d = 0; d < errors.draws.size(); ++d) {
    if (side.draw_rows[d] == 0xffffffffu) continue;
    NormalName& n = names_[side.draw_rows[d]];
    n = n.well == 0 && well == 1 ? NormalName{2, n.source} : NormalName{well, errors.draws[d].source};
  }
}

ContactState contact_state(const DrawnWellPlace& reference, const DrawnWellPlace& offset, const SharedDraws& shared,
                           double radii) {
  const std::vector<DrawPlace> of_reference = propagate::draw_places(*reference.errors),
                               of_offset = offset_places(*reference.errors, *offset.errors, shared);
  ContactState state(radii, ContactState::make_side(reference, of_reference),
                     ContactState::make_side(offset, of_offset));
  for (auto [side, place] : {std::pair(&state.reference_, &reference), {&state.offset_, &offset}}) {
    if (place->slot_sd.isZero(0)) continue;
    side->slot_row = state.row_of(random::kWellPlace, 4 * place->number);
    for (int axis = 0; axis < 3; ++axis)
      if (place->slot_sd[axis] > 0)
        state.names_[static_cast<std::size_t>(side->slot_row + axis)] = {side == &state.reference_ ? 0 : 1,
                                                                         ContactState::kSlot};
  }
  state.add_rows(state.reference_, of_reference);
  state.add_rows(state.offset_, of_offset);
  state.add_mixing(state.reference_, *reference.errors);
  state.add_mixing(state.offset_, *offset.errors);
  state.name_normals(state.reference_, *reference.errors, 0);
  state.name_normals(state.offset_, *offset.errors, 1);
  if (state.calls_.empty()) state.row_of(random::kWellPlace, 0);  // no source at all: a row that nothing reads
  return state;
}

void ContactState::set_path(const Side& side, const survey::LaneArray& drawn, const survey::LaneArray& z, int trial,
                            DrawnPath& path) {
  const std::size_t n = side.well.stations();
  path.resize(n);
  Vector3d slot = side.slot;
  for (int axis = 0; axis < 3; ++axis)
    if (side.slot_sd[axis] > 0) slot[axis] += side.slot_sd[axis] * z.value(trial, side.slot_row + axis);
  const double* row = drawn.row(trial / simd::kGroup, 0) + trial % simd::kGroup;
  constexpr std::size_t kStep = kPathRows * simd::kGroup;
  for (std::size_t k = 0; k < n; ++k) {
    const double* at = row + kStep * k;
    path.x[k] = slot.x() + at[0];
    path.y[k] = slot.y() + at[simd::kGroup];
    path.z[k] = slot.z() + at[2 * simd::kGroup];
    path.tx[k] = at[3 * simd::kGroup];
    path.ty[k] = at[4 * simd::kGroup];
    path.tz[k] = at[5 * simd::kGroup];
    path.length[k] = at[6 * simd::kGroup];
  }
}

namespace {

/// Memory of a thread that is used again from batch to batch: all of it is written before it is read.
struct ContactBuffers {
  int groups = 0;
  std::size_t reference_stations = 0, offset_stations = 0;
  survey::LaneArray a, b;
  DrawnPath reference, offset;
  ContactScratch scratch;

  void resize(int count, std::size_t of_reference, std::size_t of_offset) {
    if (count == groups && of_reference == reference_stations && of_offset == offset_stations) return;
    groups = count, reference_stations = of_reference, offset_stations = of_offset;
    a = survey::LaneArray(count, static_cast<int>(kPathRows * of_reference));
    b = survey::LaneArray(count, static_cast<int>(kPathRows * of_offset));
  }
};

/// A place that is not finite leaves none beyond it finite.
bool is_finite(const DrawnPath& path) {
  const std::size_t last = path.stations() - 1;
  return std::isfinite(path.x[last] + path.y[last] + path.z[last]);
}

}  // namespace

template <class EachTrial>
void ContactState::each(const survey::LaneArray& z, int groups, EachTrial each_trial) const {
  thread_local ContactBuffers buffers;
  buffers.resize(groups, reference_.well.stations(), offset_.well.stations());
  survey::LaneArray &a = buffers.a, &b = buffers.b;
  DrawnPath &reference = buffers.reference, &offset = buffers.offset;
  ContactScratch& scratch = buffers.scratch;
  reference_.well.draw_path(z, reference_.rows, reference_.slot_rows, groups, a);
  offset_.well.draw_path(z, offset_.rows, offset_.slot_rows, groups, b);
  for (int t = 0; t < groups * simd::kGroup; ++t) {
    set_path(reference_, a, z, t, reference);
    set_path(offset_, b, z, t, offset);
    each_trial(t, reference, offset, scratch);
  }
}

void ContactState::evaluate(const survey::LaneArray& z, int groups, double* g) const {
  each(z, groups, [&](int t, const DrawnPath& a, const DrawnPath& b, ContactScratch& scratch) {
    g[t] = is_finite(a) && is_finite(b)
               ? nearest_contact(a, reference_.first, b, offset_.first, kInfinity, scratch).distance - radii_
               : kNaN;
  });
}

double ContactState::md_of(const Side& side, std::size_t leg, double share) {
  return side.md[leg] + share * (side.md[leg + 1] - side.md[leg]);
}

void ContactState::evaluate_hits(const survey::LaneArray& z, int groups, double* g, double* depths) const {
  each(z, groups, [&](int t, const DrawnPath& a, const DrawnPath& b, ContactScratch& scratch) {
    if (!is_finite(a) || !is_finite(b)) {
      g[t] = kNaN;
      return;
    }
    const Contact c = nearest_contact(a, reference_.first, b, offset_.first, radii_, scratch);
    g[t] = c.distance < radii_ ? c.distance - radii_ : radii_;
    if (depths == nullptr || g[t] > 0) return;
    depths[2 * t] = md_of(reference_, c.reference_leg, c.reference_share);
    depths[2 * t + 1] = md_of(offset_, c.offset_leg, c.offset_share);
  });
}

Contact ContactState::contact(const survey::LaneArray& z, int trial, double& reference_md, double& offset_md) const {
  survey::LaneArray one(1, dimension());
  for (int i = 0; i < dimension(); ++i)
    for (int lane = 0; lane < simd::kGroup; ++lane) one.row(0, i)[lane] = z.value(trial, i);
  Contact found;
  each(one, 1, [&](int t, const DrawnPath& a, const DrawnPath& b, ContactScratch& scratch) {
    if (t == 0) found = nearest_contact(a, reference_.first, b, offset_.first, kInfinity, scratch);
  });
  reference_md = md_of(reference_, found.reference_leg, found.reference_share);
  offset_md = md_of(offset_, found.offset_leg, found.offset_share);
  return found;
}

Eigen::Matrix3Xd ContactState::derivative(const WellErrors& reference, const WellErrors& offset,
                                          const WellPoint& reference_point, const WellPoint& offset_point) const {
  Eigen::Matrix3Xd j = Eigen::Matrix3Xd::Zero(3, dimension());
  const auto add = [&](const Side& side, const WellErrors& errors, const WellPoint& point, double sign) {
    const Eigen::Matrix3Xd m = propagate::draw_effects(errors, point, propagate::FirstOrder::minimum_curvature);
    for (std::size_t d = 0; d < side.draw_rows.size(); ++d)
      if (side.draw_rows[d] != 0xffffffffu) j.col(side.draw_rows[d]) += sign * m.col(static_cast<Eigen::Index>(d));
    for (int axis = 0; axis < 3; ++axis)
      if (side.slot_sd[axis] > 0) j(axis, side.slot_row + axis) += sign * side.slot_sd[axis];
  };
  add(reference_, reference, reference_point, -1);
  add(offset_, offset, offset_point, 1);
  return j;
}

}  // namespace surveymc::proximity
