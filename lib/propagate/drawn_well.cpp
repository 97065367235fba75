#include "propagate/drawn_well.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>

#include "simd/instruction_set.h"

namespace surveymc::propagate {
namespace {

std::array<double, kDrawnSums> parts_of(const DrawEffect& e) {
  return {e.depth, e.inclination, e.azimuth, e.tilt, e.course.x(), e.course.y(), e.course.z()};
}

/// What one lasting draw adds to one sum: station by station.
struct LastingColumn {
  std::uint32_t draw = 0;
  std::vector<std::pair<std::size_t, double>> weights;
};

/// The factor by which `b` is `a`; 0 if it is not. Rounding alone may lie between them.
double proportion(const LastingColumn& a, const LastingColumn& b) {
  if (a.weights.size() != b.weights.size()) return 0;
  double ab = 0, aa = 0, most = 0;
  for (std::size_t i = 0; i < a.weights.size(); ++i) {
    if (a.weights[i].first != b.weights[i].first) return 0;
    ab += a.weights[i].second * b.weights[i].second;
    aa += a.weights[i].second * a.weights[i].second;
    most = std::max(most, std::abs(b.weights[i].second));
  }
  const double factor = ab / aa;
  for (std::size_t i = 0; i < a.weights.size(); ++i)
    if (!(std::abs(b.weights[i].second - factor * a.weights[i].second) <= 1e-14 * most)) return 0;
  return factor;
}

/// Draws, weights, rows: gives every draw the row where its call puts it.
class CallList {
 public:
  CallList(std::vector<DrawCall>& calls, const std::vector<DrawPlace>& places) : calls_(calls), places_(places) {}

  /// Calls for `draws`, in the order of channels and calls; their rows begin at first_row.
  void add(std::vector<std::uint32_t> draws, std::uint32_t first_row) {
    const auto key = [&](std::uint32_t d) { return std::pair(places_[d].channel, places_[d].index); };
    std::sort(draws.begin(), draws.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    const std::size_t begin = calls_.size();
    for (const std::uint32_t d : draws) {
      const DrawPlace& place = places_[d];
      const bool is_new =
          calls_.size() == begin || calls_.back().channel != place.channel || calls_.back().call != place.index / 4;
      if (is_new) calls_.push_back({place.channel, place.index / 4});
      row_[d] = first_row + 4 * static_cast<std::uint32_t>(calls_.size() - 1 - begin) + place.index % 4;
    }
  }
  std::uint32_t row(std::uint32_t draw) const { return row_.at(draw); }

 private:
  std::vector<DrawCall>& calls_;
  const std::vector<DrawPlace>& places_;
  std::map<std::uint32_t, std::uint32_t> row_;
};

void sort_and_unite(std::vector<std::uint32_t>& x) {
  std::sort(x.begin(), x.end());
  x.erase(std::unique(x.begin(), x.end()), x.end());
}

}  // namespace

std::vector<DrawPlace> draw_places(const WellErrors& errors, std::uint32_t first_source, std::uint32_t first_station) {
  std::vector<DrawPlace> out;
  for (std::size_t i = 0; i < errors.draws.size(); ++i) {
    const bool lasts = i < errors.station_draws;
    out.push_back({lasts ? random::Channel::error_source : random::Channel::station_error,
                   static_cast<std::uint32_t>(lasts ? i + first_source : i - errors.station_draws + first_station)});
  }
  return out;
}

DrawnWell drawn_well(const WellErrors& errors, const std::vector<WellPoint>& points,
                     const std::vector<DrawPlace>& places, bool with_control, const WellMixing& mixing) {
  DrawnWell w;
  w.points_ = points;
  w.stations_ = points.back().station + 1;
  w.legs_.resize(w.stations_);
  for (std::size_t k = 1; k < w.stations_; ++k) w.legs_[k] = leg_geometry(errors, k);
  w.make_items(errors, places, mixing);
  w.make_points(errors, with_control);
  return w;
}

void DrawnWell::make_items(const WellErrors& errors, const std::vector<DrawPlace>& places, const WellMixing& mixing) {
  // Weights of lasting draws, by sum; draws that are used.
  std::array<std::map<std::uint32_t, LastingColumn>, kDrawnSums> columns;
  std::vector<std::uint32_t> lasting;
  std::vector<std::vector<std::uint32_t>> at_station(stations_);
  const auto lasts = [&](std::uint32_t draw) { return draw < errors.station_draws; };
  for (std::size_t k = 1; k < stations_; ++k)
    for (const DrawEffect& e : errors.at[k]) {
      (lasts(e.draw) ? lasting : at_station[k]).push_back(e.draw);
      const auto parts = parts_of(e);
      for (std::size_t q = 0; q < kDrawnSums && lasts(e.draw); ++q)
        if (parts[q] != 0) {
          LastingColumn& c = columns[q][e.draw];
          c.draw = e.draw;
          c.weights.emplace_back(k, parts[q]);
        }
    }
  sort_and_unite(lasting);
  CallList rows(calls_, places);
  rows.add(lasting, 0);
  lasting_calls_ = calls_.size();
  std::map<int, std::uint32_t> slot_of;  // those that are used, by their numbers in `mixing`
  const auto add_mixed = [&](const std::vector<std::uint32_t>& draws) {
    for (const std::uint32_t d : draws) {
      const int slot = mixing.slot_of_draw.empty() ? -1 : mixing.slot_of_draw[d];
      if (slot < 0) continue;
      const auto [at, is_new] = slot_of.emplace(slot, static_cast<std::uint32_t>(slots_.size()));
      if (is_new) slots_.push_back(mixing.slots[static_cast<std::size_t>(slot)]);
      mixed_.push_back({rows.row(d), at->second});
    }
  };
  add_mixed(lasting);
  lasting_mixed_ = mixed_.size();

  // Columns of one sum that are proportional become one row, their draws' weighted sum.
  std::array<std::vector<std::vector<WeightedRow>>, kDrawnSums> items_of;
  for (auto& of_sum : items_of) of_sum.resize(stations_);
  combined_ends_ = {0};
  auto next_row = static_cast<std::uint32_t>(4 * lasting_calls_);
  for (std::size_t q = 0; q < kDrawnSums; ++q) {
    std::vector<std::pair<const LastingColumn*, std::vector<WeightedRow>>> groups;
    for (const auto& [draw, column] : columns[q]) {
      double factor = 0;
      for (auto& [first, members] : groups)
        if ((factor = proportion(*first, column)) != 0) {
          members.push_back({rows.row(draw), factor});
          break;
        }
      if (factor == 0) groups.push_back({&column, {{rows.row(draw), 1}}});
    }
    for (const auto& [first, members] : groups) {
      std::uint32_t row = members.front().row;
      if (members.size() > 1) {
        combined_items_.insert(combined_items_.end(), members.begin(), members.end());
        combined_ends_.push_back(static_cast<std::uint32_t>(combined_items_.size()));
        row = next_row++;
      }
      for (const auto& [k, weight] : first->weights) items_of[q][k].push_back({row, weight});
    }
  }

  // Draws of one station: some stations together, so that calls fill. Twenty stations of seven draws are 35 calls.
  constexpr std::size_t kStations = 20, kDraws = 160;
  most_rows_ = next_row;
  for (std::size_t first = 1; first < stations_;) {
    std::size_t end = first;
    std::vector<std::uint32_t> draws;
    while (end < stations_ && (end == first || (end - first < kStations && draws.size() < kDraws)))
      draws.insert(draws.end(), at_station[end].begin(), at_station[end].end()), ++end;
    sort_and_unite(draws);
    const std::size_t first_call = calls_.size(), first_mixed = mixed_.size();
    rows.add(draws, next_row);
    add_mixed(draws);
    stretches_.push_back({first, end, first_call, calls_.size(), first_mixed, mixed_.size()});
    most_rows_ = std::max(most_rows_, next_row + 4 * (calls_.size() - first_call));
    first = end;
  }
  for (std::size_t k = 1; k < stations_; ++k)
    for (const DrawEffect& e : errors.at[k]) {
      if (lasts(e.draw)) continue;
      const auto parts = parts_of(e);
      for (std::size_t q = 0; q < kDrawnSums; ++q)
        if (parts[q] != 0) items_of[q][k].push_back({rows.row(e.draw), parts[q]});
    }
  item_ends_ = {0};
  for (std::size_t k = 0; k < stations_; ++k)
    for (std::size_t q = 0; q < kDrawnSums; ++q) {
      items_.insert(items_.end(), items_of[q][k].begin(), items_of[q][k].end());
      item_ends_.push_back(static_cast<std::uint32_t>(items_.size()));
    }
}

void DrawnWell::make_points(const WellErrors& errors, bool with_control) {
  const auto put = [](const LegDerivatives& d, double* out) {
    for (int i = 0; i < 4; ++i)
      for (int axis = 0; axis < 3; ++axis) {
        out[3 * i + axis] = d.from(axis, i);
        out[12 + 3 * i + axis] = d.to(axis, i);
      }
  };
  if (with_control) {
    derivatives_.assign(24 * stations_, 0);
    for (std::size_t k = 1; k < stations_; ++k)
      put(leg_derivatives(errors, k, 1, FirstOrder::minimum_curvature), &derivatives_[24 * k]);
  }
  for (const WellPoint& p : points_) {
    drawn_points_.push_back({p.station, p.share, {}});
    if (with_control)
      put(leg_derivatives(errors, p.station, p.share, FirstOrder::minimum_curvature), drawn_points_.back().derivatives);
  }
  // The well without errors, by the same operations as the drawn ones, so that no errors give no displacement.
  survey::Vec3<double> position{0, 0, 0};
  const DrawnErrors<double> none{0, 0, 0, 0};
  std::size_t point = 0;
  for (std::size_t k = 1; k < stations_; ++k) {
    for (; point < points_.size() && points_[point].station == k; ++point) {
      const auto r = position + drawn_leg_point(legs_[k], none, none, points_[point].share);
      truth_.insert(truth_.end(), {r.x, r.y, r.z});
    }
    position = position + drawn_leg_point(legs_[k], none, none, 1);
  }
  assert(truth_.size() == 3 * points_.size());
}

survey::LaneArray DrawnWell::make_scratch() const { return {1, 2 * static_cast<int>(most_rows_)}; }

DrawnWellBatch DrawnWell::batch(std::uint64_t first_trial, bool antithetic, int groups, survey::LaneArray& out,
                                survey::LaneArray& scratch, const survey::LaneArray* mixing) const {
  DrawnWellBatch b{};
  b.mixed = mixed_.data();
  b.lasting_mixed = lasting_mixed_;
  if (mixing != nullptr) {
    b.mixing = mixing->row(0, 0);
    b.mixing_stride = mixing->group_stride();
  }
  b.legs = legs_.data();
  b.stations = stations_;
  b.items = items_.data();
  b.item_ends = item_ends_.data();
  b.calls = calls_.data();
  b.lasting_calls = lasting_calls_;
  b.combined_items = combined_items_.data();
  b.combined_ends = combined_ends_.data();
  b.combined = combined_ends_.size() - 1;
  b.stretches = stretches_.data();
  b.stretch_count = stretches_.size();
  b.rows = scratch.row(0, 0);
  b.points = drawn_points_.data();
  b.point_count = drawn_points_.size();
  b.truth = truth_.data();
  b.derivatives = derivatives_.empty() ? nullptr : derivatives_.data();
  b.first_trial = first_trial;
  b.antithetic = antithetic;
  b.groups = static_cast<std::size_t>(groups);
  b.positions = out.row(0, 0);
  b.positions_stride = out.group_stride();
  return b;
}

void DrawnWell::draw(const random::Stream& stream, std::uint64_t first_trial, bool antithetic, int groups,
                     survey::LaneArray& out, const survey::LaneArray* made) const {
  assert(first_trial % simd::kGroup == 0);
  survey::LaneArray scratch = make_scratch(), mixing;
  if (!slots_.empty()) {
    mixing = survey::LaneArray(groups, 2 * static_cast<int>(slots_.size()));
    random::draw_mixing(stream, slots_, first_trial, antithetic, groups, mixing.row(0, 0), mixing.group_stride());
  }
  DrawnWellBatch b = batch(first_trial, antithetic, groups, out, scratch, slots_.empty() ? nullptr : &mixing);
  if (made != nullptr) {
    b.made = made->row(0, 0);
    b.made_stride = made->group_stride();
  }
  simd::run_kernel<isa_v3::draw_wells, isa_v4::draw_wells>(b, stream);
}

void DrawnWell::draw_path(const survey::LaneArray& z, const std::vector<std::uint32_t>& rows,
                          const std::vector<std::uint32_t>& slot_rows, int groups, survey::LaneArray& out) const {
  survey::LaneArray scratch = make_scratch(), points(groups, this->rows()), mixing;
  if (!slots_.empty()) {
    mixing = survey::LaneArray(groups, 2 * static_cast<int>(slots_.size()));
    for (int g = 0; g < groups; ++g)
      for (std::size_t i = 0; i < slots_.size(); ++i) {
        const double* normal = z.row(g, static_cast<int>(slot_rows[i]));
        double* factor = mixing.row(g, 2 * static_cast<int>(i));
        for (int lane = 0; lane < simd::kGroup; ++lane) {
          const random::MixingLaw::Draw v = slots_[i].law->draw(normal[lane]);
          factor[lane] = v.factor;
          factor[simd::kGroup + lane] = v.shift;
        }
      }
  }
  DrawnWellBatch b = batch(0, false, groups, points, scratch, slots_.empty() ? nullptr : &mixing);
  b.derivatives = nullptr;
  b.given = z.row(0, 0);
  b.given_stride = z.group_stride();
  b.given_rows = rows.data();
  b.path = out.row(0, 0);
  b.path_stride = out.group_stride();
  simd::run_kernel<isa_v3::draw_wells, isa_v4::draw_wells>(b, random::Stream(0, 0));
}

std::vector<double> drawn_positions(const WellErrors& errors, const std::vector<WellPoint>& points,
                                    const std::vector<double>& draws) {
  const auto errors_at = [&](std::size_t k, Eigen::Vector3d& course) {
    DrawnErrors<double> x{0, 0, 0, 0};
    course.setZero();
    for (const DrawEffect& e : errors.at[k]) {
      const double z = draws[e.draw];
      x.depth += z * e.depth;
      x.inclination += z * e.inclination;
      x.azimuth += z * e.azimuth;
      x.tilt += z * e.tilt;
      course += z * e.course;
    }
    return x;
  };
  const auto leg_errors = [](const LegGeometry& leg, const DrawnErrors<double>& from, const DrawnErrors<double>& to,
                             double share) {
    const DrawnErrors<double> none{0, 0, 0, 0};
    return Eigen::Vector3d(survey::to_eigen(drawn_leg_point(leg, from, to, share)) -
                           survey::to_eigen(drawn_leg_point(leg, none, none, share)));
  };
  std::vector<double> out;
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), course;
  DrawnErrors<double> before{0, 0, 0, 0};
  std::size_t point = 0;
  for (std::size_t k = 1; k <= points.back().station; ++k) {
    const LegGeometry leg = leg_geometry(errors, k);
    const DrawnErrors<double> at = errors_at(k, course);
    for (; point < points.size() && points[point].station == k; ++point) {
      const double share = points[point].share;
      const Eigen::Vector3d r = position + share * course + leg_errors(leg, before, at, share);
      out.insert(out.end(), r.data(), r.data() + 3);
    }
    position += course + leg_errors(leg, before, at, 1);
    before = at;
  }
  return out;
}

}  // namespace surveymc::propagate
