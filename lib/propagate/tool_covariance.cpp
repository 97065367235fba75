#include "propagate/tool_covariance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/huge_pages.h"
#include "base/units.h"
#include "error_model/model_graph.h"
#include "propagate/tool_weights.h"

namespace surveymc::propagate {
namespace {

namespace em = error_model;
using Eigen::Matrix3d;

constexpr std::size_t kBlock = kStationBlock;
using Column = StationColumn;

/// What a unit of depth and of angle at the stations of a block does to their own position (star) and to all beyond
/// (full), in structures of arrays: north, east, down.
struct Displacements {
  std::array<Column, 3> star_depth, full_depth;
  Column star_angle, full_angle;    ///< metres per rad along the two directions below
  std::array<Column, 3> high_side;  ///< dt/dI
  Column right_north, right_east;   ///< dt/dA over sinI
  Column length;                    ///< of the interval before the station, m
  std::array<bool, kBlock> is_vertical;

  void set(const survey::Survey& survey, const StationDirections& d, std::size_t first, std::size_t count,
           bool first_doubled) {
    const std::size_t last = survey.stations.size() - 1;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = first + i, after = std::min(k + 1, last);  // nothing asks for the full ones of the last
      const auto depth = [&](std::size_t axis, double before, double at, double beyond) {
        star_depth[axis][i] = 0.5 * (before + at);
        full_depth[axis][i] = star_depth[axis][i] - 0.5 * (at + beyond);
      };
      depth(0, d.north[k - 1], d.north[k], d.north[after]);
      depth(1, d.east[k - 1], d.east[k], d.east[after]);
      depth(2, d.cos_i[k - 1], d.cos_i[k], d.cos_i[after]);
      length[i] = survey.stations[k].md - survey.stations[k - 1].md;
      star_angle[i] = (first_doubled && i == 0 ? 1 : 0.5) * length[i];
      full_angle[i] = star_angle[i] + 0.5 * (survey.stations[after].md - survey.stations[k].md);
      high_side[0][i] = d.cos_i[k] * d.cos_a[k];
      high_side[1][i] = d.cos_i[k] * d.sin_a[k];
      high_side[2][i] = -d.sin_i[k];
      right_north[i] = -d.sin_a[k];
      right_east[i] = d.cos_a[k];
      is_vertical[i] = survey.stations[k].inclination < em::kVerticalLimit;
    }
  }
};

/// An error source of the well and what has summed up so far (ErrorSum, in structures of arrays).
struct Source {
  std::string code;
  em::PropagationMode mode;
  std::size_t row;               ///< of the code among ToolCovariances::sources
  std::array<double, 3> sum{};   ///< of the effects of the group at hand
  std::array<double, 6> past{};  ///< covariance of the groups before: nn, ee, vv, ne, nv, ev

  void end_group() {
    add_product(past, sum[0], sum[1], sum[2]);
    sum = {};
  }
  static void add_product(std::array<double, 6>& c, double x, double y, double z) {
    c[0] += x * x;
    c[1] += y * y;
    c[2] += z * z;
    c[3] += x * y;
    c[4] += x * z;
    c[5] += y * z;
  }
};

/// All sources of a well, and which of them each term of each run is.
struct Sources {
  std::vector<std::string> codes;
  std::vector<Source> all;
  std::vector<std::vector<std::size_t>> of_run;

  explicit Sources(const std::vector<ToolRun>& runs) {
    for (const ToolRun& run : runs) {
      of_run.emplace_back();
      for (const em::Term& term : run.model->terms) of_run.back().push_back(index_of(term));
    }
  }

 private:
  std::size_t index_of(const em::Term& term) {
    const auto same = std::find_if(all.begin(), all.end(),
                                   [&](const Source& s) { return s.code == term.code && s.mode == term.mode; });
    if (same != all.end()) return static_cast<std::size_t>(same - all.begin());
    const auto code = std::find(codes.begin(), codes.end(), term.code);
    const auto row = static_cast<std::size_t>(code - codes.begin());
    if (code == codes.end()) codes.push_back(term.code);
    all.push_back({term.code, term.mode, row, {}, {}});
    return all.size() - 1;
  }
};

/// Effects of one source at the stations of a block, metres.
struct Effects {
  std::array<Column, 3> star, full;
};

/// Effects of angles: across the hole, metres per metre of interval, times the intervals on both sides. The vertical
/// formulas take the place of the others where there are any.
void set_angle_effects(const BlockWeights& w, double sigma, bool is_course, const Displacements& d, std::size_t count,
                       Effects& e) {
  static constexpr Column kZeros{};
  const double* const wi = w.inclination != nullptr ? w.inclination : kZeros.data();
  const double* const wl = w.lateral != nullptr ? w.lateral : kZeros.data();
  const double* const at = is_course ? d.length.data() : d.star_angle.data();
  const double* const beyond = is_course ? d.length.data() : d.full_angle.data();
#pragma GCC ivdep  // e is none of the columns that are read
  for (std::size_t i = 0; i < count; ++i) {
    const double north = sigma * (wi[i] * d.high_side[0][i] + wl[i] * d.right_north[i]),
                 east = sigma * (wi[i] * d.high_side[1][i] + wl[i] * d.right_east[i]),
                 down = sigma * (wi[i] * d.high_side[2][i]);
    e.star[0][i] = at[i] * north;
    e.star[1][i] = at[i] * east;
    e.star[2][i] = at[i] * down;
    e.full[0][i] = beyond[i] * north;
    e.full[1][i] = beyond[i] * east;
    e.full[2][i] = beyond[i] * down;
  }
  if (w.vertical_north == nullptr) return;
  for (std::size_t i = 0; i < count; ++i) {
    if (!d.is_vertical[i]) continue;
    const std::array<double, 3> across{sigma * w.vertical_north[i], sigma * w.vertical_east[i], 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      e.star[axis][i] = at[i] * across[axis];
      e.full[axis][i] = beyond[i] * across[axis];
    }
  }
}

void zero_effects(std::size_t count, Effects& e) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::fill_n(e.star[axis].begin(), count, 0.0);
    std::fill_n(e.full[axis].begin(), count, 0.0);
  }
}

void set_effects(const em::Term& term, const BlockWeights& w, const Displacements& d, std::size_t count, Effects& e) {
  const bool has_angles = w.inclination != nullptr || w.lateral != nullptr || w.vertical_north != nullptr;
  if (has_angles)
    set_angle_effects(w, term.sigma, term.function->kind == em::Kind::course, d, count, e);
  else
    zero_effects(count, e);
  if (w.depth == nullptr) return;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < count; ++i) {
      const double depth = term.sigma * w.depth[i];
      e.star[axis][i] += depth * d.star_depth[axis][i];
      e.full[axis][i] += depth * d.full_depth[axis][i];
    }
}

/// Covariance of one source, or of all, at the stations of a block: nn, ee, vv, ne, nv, ev.
using BlockCovariance = std::array<Column, 6>;
constexpr std::array<std::array<std::size_t, 2>, 6> kAxes{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

/// What a source that is one error along the block moves the positions by; adds up its effects.
void add_up(Source& s, const Effects& e, std::size_t count, std::array<Column, 3>& at) {
  double north = s.sum[0], east = s.sum[1], down = s.sum[2];
  for (std::size_t i = 0; i < count; ++i) {
    at[0][i] = north + e.star[0][i];
    at[1][i] = east + e.star[1][i];
    at[2][i] = down + e.star[2][i];
    north += e.full[0][i];
    east += e.full[1][i];
    down += e.full[2][i];
  }
  s.sum = {north, east, down};
}

/// Moves a source through a block: its covariance at every station.
void propagate(Source& s, Grouping grouping, const std::array<bool, kBlock>& begins_group, const Effects& e,
               std::size_t count, BlockCovariance& c) {
  if (grouping == Grouping::run) {
    std::array<Column, 3> at;
    add_up(s, e, count, at);
    for (std::size_t m = 0; m < 6; ++m) {
      const Column &x = at[kAxes[m][0]], &y = at[kAxes[m][1]];
      const double past = s.past[m];
      for (std::size_t i = 0; i < count; ++i) c[m][i] = past + x[i] * y[i];
    }
    return;
  }
  if (grouping == Grouping::station) {
    for (std::size_t m = 0; m < 6; ++m) {
      const std::size_t x = kAxes[m][0], y = kAxes[m][1];
      double past = s.past[m];
      for (std::size_t i = 0; i < count; ++i) {
        c[m][i] = past + e.star[x][i] * e.star[y][i];
        past += e.full[x][i] * e.full[y][i];
      }
      s.past[m] = past;
    }
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (begins_group[i]) s.end_group();
    std::array<double, 3> at;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = s.sum[axis] + e.star[axis][i];
      s.sum[axis] += e.full[axis][i];
    }
    for (std::size_t m = 0; m < 6; ++m) c[m][i] = s.past[m] + at[kAxes[m][0]] * at[kAxes[m][1]];
  }
}

Matrix3d symmetric(double nn, double ee, double vv, double ne, double nv, double ev) {
  Matrix3d m;
  m << nn, ne, nv,  //
      ne, ee, ev,   //
      nv, ev, vv;
  return m;
}

/// Covariances of all codes at the stations of a block, source by source, and their way to station by station.
class BlockBySource {
 public:
  explicit BlockBySource(std::size_t codes)
      : codes_(codes), columns_(6 * codes), rows_(kTile * codes), is_begun_(codes) {}

  void clear() { is_begun_.assign(codes_, false); }
  /// Every code has a source.
  void add(std::size_t code, const BlockCovariance& own, std::size_t count) {
    for (std::size_t m = 0; m < 6; ++m) {
      PaddedColumn& c = columns_[m * codes_ + code];
      if (is_begun_[code])
        for (std::size_t i = 0; i < count; ++i) c[i] += own[m][i];
      else
        for (std::size_t i = 0; i < count; ++i) c[i] = 0.0 + own[m][i];  // 0, not -0
    }
    is_begun_[code] = true;
  }
  /// The stations first to first + count - 1 of the block, behind those that `out` has.
  void append(std::size_t first, std::size_t count, CovarianceColumns& out) {
    for (std::size_t m = 0; m < 6; ++m) {
      for (std::size_t tile = 0; tile < count; tile += kTile) {
        const std::size_t stations = std::min(kTile, count - tile);
        for (std::size_t code = 0; code < codes_; ++code) {
          const double* from = columns_[m * codes_ + code].data() + first + tile;
          for (std::size_t i = 0; i < stations; ++i) rows_[i * codes_ + code] = from[i];
        }
        // Appended, and not written into a column made longer before: memory that is new would be filled twice.
        out.elements[m].insert(out.elements[m].end(), rows_.begin(),
                               rows_.begin() + static_cast<std::ptrdiff_t>(stations * codes_));
      }
    }
  }

 private:
  static constexpr std::size_t kTile = 8;                   // stations of which a line of the cache holds one column
  using PaddedColumn = std::array<double, kBlock + kTile>;  // columns do not all begin in the same set of the cache
  std::size_t codes_;
  std::vector<PaddedColumn> columns_;  // [element][code]
  std::vector<double> rows_;           // [station of a tile][code]: one element
  std::vector<bool> is_begun_;         // [code]
};

/// Keeps the effects of sources for StationEffects.
class EffectsKeeper {
 public:
  EffectsKeeper(const std::vector<ToolRun>& runs, const Sources& sources, std::size_t stations, bool joining_alone,
                StationEffects* out)
      : out_(out) {
    if (out_ == nullptr) return;
    *out_ = {};
    out_->stations = stations;
    for (const Source& s : sources.all) {
      const bool is_kept = !joining_alone || em::joins_legs(s.mode);
      row_.push_back(is_kept ? out_->sources.size() : kNotKept);
      if (is_kept) out_->sources.push_back({s.code, s.mode, ""});
    }
    for (std::size_t r = 0; r < runs.size(); ++r)
      for (std::size_t t = 0; t < runs[r].model->terms.size(); ++t) {
        const std::size_t row = row_[sources.of_run[r][t]];
        if (row != kNotKept && out_->sources[row].function.empty())
          out_->sources[row].function = runs[r].model->terms[t].function->name;
      }
    const std::size_t size = out_->sources.size() * stations;
    out_->star.assign(size, Eigen::Vector3d::Zero());
    out_->full = out_->star;
    out_->depth.assign(size, 0);
    out_->draw.assign(size, StationEffects::kNone);
    draw_.assign(out_->sources.size(), 1);
  }

  void keep(std::size_t source, const em::Term& term, const BlockWeights& w, const Effects& e, Grouping grouping,
            const std::array<bool, kBlock>& begins_group, std::size_t run_first, std::size_t first, std::size_t count) {
    if (out_ == nullptr || row_[source] == kNotKept) return;
    const std::size_t row = row_[source], at = row * out_->stations + first;
    for (std::size_t i = 0; i < count; ++i) {
      out_->star[at + i] = {e.star[0][i], e.star[1][i], e.star[2][i]};
      out_->full[at + i] = {e.full[0][i], e.full[1][i], e.full[2][i]};
      if (w.depth != nullptr) out_->depth[at + i] = term.sigma * w.depth[i];
      const bool is_new = grouping == Grouping::station || (grouping == Grouping::mixed && begins_group[i]);
      if (is_new)
        draw_[row] = static_cast<int>(first + i);
      else if (grouping == Grouping::run)
        draw_[row] = em::joins_legs(term.mode) ? 1 : static_cast<int>(run_first);
      out_->draw[at + i] = draw_[row];
    }
  }

 private:
  static constexpr std::size_t kNotKept = static_cast<std::size_t>(-1);
  StationEffects* out_;
  std::vector<std::size_t> row_;  ///< of each source among those that are kept
  std::vector<int> draw_;         ///< at hand, of each that is kept
};

/// The sources, moved along the well.
class Propagation {
 public:
  Propagation(const survey::Survey& survey, const std::vector<ToolRun>& runs, SourceDetail detail, ToolCovariances& out,
              StationEffects* effects, bool joining_alone)
      : survey_(survey),
        runs_(runs),
        detail_(detail),
        sources_(runs),
        by_source_(detail == SourceDetail::none ? 0 : sources_.codes.size()),  // 200 kB that a small well would feel
        out_(out),
        keeper_(runs, sources_, survey.stations.size(), joining_alone, effects) {
    const std::size_t n = survey.stations.size();
    out.sources = sources_.codes;
    out.total.assign(n, Matrix3d::Zero());
    if (detail != SourceDetail::all) return;
    const std::size_t rows = n * out.sources.size();
    {  // The columns come to lie side by side where these were. Asked for one by one, their ends would have small
       // pages. Halves: glibc gives what is above 32 MiB back to the system at once.
      std::array<std::vector<double>, 2> halves;
      for (std::vector<double>& room : halves) {
        room.reserve(out.by_source.elements.size() / halves.size() * rows);
        prefer_huge_pages(room.data(), room.capacity() * sizeof(double));
      }
    }
    for (std::vector<double>& column : out.by_source.elements) {
      column.reserve(rows);
      prefer_huge_pages(column.data(), column.capacity() * sizeof(double));
      column.resize(out.sources.size());  // the tie-on
    }
  }

  void run_block(std::size_t run, std::size_t first, std::size_t count, const RunWeights& weights,
                 const Displacements& d, const std::array<bool, kBlock>& begins_group) {
    for (std::size_t m = 0; m < 6; ++m) std::fill_n(total_[m].begin(), count, 0.0);
    const bool is_kept =
        detail_ == SourceDetail::all || (detail_ == SourceDetail::last && first + count == survey_.stations.size());
    if (is_kept) by_source_.clear();
    term_of_source_.assign(sources_.all.size(), nullptr);
    const auto& terms = runs_[run].model->terms;
    for (std::size_t t = 0; t < terms.size(); ++t) term_of_source_[sources_.of_run[run][t]] = &terms[t];
    for (std::size_t s = 0; s < sources_.all.size(); ++s) {
      Source& source = sources_.all[s];
      if (const em::Term* term = term_of_source_[s]) {
        const auto t = static_cast<std::size_t>(term - terms.data());
        set_effects(*term, weights.of_term(t), d, count, effects_);
        refuse_poles(run, t, weights.of_term(t), first, count, d);
        const Grouping grouping = grouping_of(*term, runs_[run].model->gyro.has_value());
        propagate(source, grouping, begins_group, effects_, count, own_);
        keeper_.keep(s, *term, weights.of_term(t), effects_, grouping, begins_group,
                     static_cast<std::size_t>(runs_[run].first), first, count);
      } else {
        // The tool of this run does not have it: what there is remains, and stays in the covariance.
        std::array<double, 6> c = source.past;
        Source::add_product(c, source.sum[0], source.sum[1], source.sum[2]);
        for (std::size_t m = 0; m < 6; ++m) std::fill_n(own_[m].begin(), count, c[m]);
      }
      for (std::size_t m = 0; m < 6; ++m)
        for (std::size_t i = 0; i < count; ++i) total_[m][i] += own_[m][i];
      if (is_kept) by_source_.add(source.row, own_, count);
    }
    for (std::size_t i = 0; i < count; ++i)
      out_.total[first + i] =
          symmetric(total_[0][i], total_[1][i], total_[2][i], total_[3][i], total_[4][i], total_[5][i]);
    if (detail_ == SourceDetail::all) by_source_.append(0, count, out_.by_source);
    if (detail_ == SourceDetail::last && first + count == survey_.stations.size())
      by_source_.append(count - 1, 1, out_.by_source);
  }

  void end_run(std::size_t run) {
    const auto& terms = runs_[run].model->terms;
    std::vector<bool> is_per_section(sources_.all.size(), false);
    for (std::size_t t = 0; t < terms.size(); ++t)
      is_per_section[sources_.of_run[run][t]] = terms[t].function->per_section;
    for (std::size_t s = 0; s < sources_.all.size(); ++s) {
      Source& source = sources_.all[s];
      if (!em::joins_legs(source.mode) || is_per_section[s]) source.end_group();
    }
  }

 private:
  /// Where one standard deviation has no finite effect, it becomes NaN, and so does all beyond; the term is noted.
  void refuse_poles(std::size_t run, std::size_t t, const BlockWeights& w, std::size_t first, std::size_t count,
                    const Displacements& d) {
    const em::Term& term = runs_[run].model->terms[t];
    if (term.sigma == 0) return zero_effects(count, effects_);
    if (term.sigma * w.largest_angle <= kLargestAngle && term.sigma * w.largest_depth <= 1e300) return;
    for (std::size_t i = 0; i < count; ++i) {
      const bool has_vertical = w.vertical_north != nullptr && d.is_vertical[i];
      const auto is_beyond = [&](const double* x, double most) {
        return x != nullptr && !(std::abs(term.sigma * x[i]) <= most);
      };
      const auto formula_beyond = [&]() -> const em::Expression* {
        const em::Function& f = *term.function;
        if (is_beyond(w.depth, 1e300)) return &f.depth;
        if (is_beyond(has_vertical ? w.vertical_north : w.inclination, kLargestAngle))
          return has_vertical ? &f.vertical_north : &f.inclination;
        if (is_beyond(has_vertical ? w.vertical_east : w.lateral, kLargestAngle))
          return has_vertical ? &f.vertical_east : &f.azimuth_or_lateral();
        return nullptr;
      };
      const em::Expression* formula = formula_beyond();
      if (formula == nullptr) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) effects_.star[axis][i] = effects_.full[axis][i] = kNaN;
      note(run, t, first + i, *formula);
    }
  }

  void note(std::size_t run, std::size_t t, std::size_t k, const em::Expression& formula) {
    auto& all = out_.non_finite;
    const auto same =
        std::find_if(all.begin(), all.end(), [&](const NonFiniteTerm& x) { return x.run == run && x.term == t; });
    if (same != all.end()) {
      ++same->stations;
      same->last = k;
      return;
    }
    for (const auto& [key, f] : runs_[run].model->terms[t].function->formulas())
      if (f == &formula) all.push_back({run, t, 1, k, k, fmt::format("{} = \"{}\"", key, formula.text)});
  }

  const survey::Survey& survey_;
  const std::vector<ToolRun>& runs_;
  SourceDetail detail_;
  Sources sources_;
  BlockBySource by_source_;
  ToolCovariances& out_;
  EffectsKeeper keeper_;
  std::vector<const em::Term*> term_of_source_;
  Effects effects_;
  BlockCovariance own_, total_;
};

}  // namespace

Matrix3d CovarianceColumns::operator[](std::size_t i) const {
  return symmetric(elements[0][i], elements[1][i], elements[2][i], elements[3][i], elements[4][i], elements[5][i]);
}

ToolCovariances tool_covariances(const survey::Survey& survey, const std::vector<double>& tvd,
                                 const std::vector<ToolRun>& runs, const survey::ReferenceField& field, double latitude,
                                 SourceDetail detail, StationEffects* effects, bool joining_alone,
                                 const std::function<void(std::size_t)>& at_station) {
  const std::size_t n = survey.stations.size();
  const StationDirections directions(survey, field.declination);
  ToolCovariances out;
  Propagation propagation(survey, runs, detail, out, effects, joining_alone);
  // Runs of one model share its graph; both maps keep their elements in place.
  std::map<const em::Model*, em::ModelGraph> graphs;
  std::map<const em::Model*, RunWeights> weights;
  const auto displacements = std::make_unique<Displacements>();
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const em::Model& model = *runs[r].model;
    const auto begin = static_cast<std::size_t>(runs[r].first);
    const std::size_t end = r + 1 < runs.size() ? static_cast<std::size_t>(runs[r + 1].first) : n;
    auto graph = graphs.find(&model);
    if (graph == graphs.end()) graph = graphs.emplace(&model, em::model_graph(model.terms)).first;
    RunWeights& w =
        weights.try_emplace(&model, model, graph->second, survey, tvd, directions, field, latitude).first->second;
    out.gyro.push_back(model.gyro ? gyro_stretches(survey, begin, end, *model.gyro) : std::vector<GyroStretch>());
    w.begin_run(out.gyro.back());
    for (std::size_t first = begin; first < end; first += kBlock) {
      const std::size_t count = std::min(kBlock, end - first);
      displacements->set(survey, directions, first, count, first == 1 && model.first_leg_doubled);
      w.evaluate(first, count);
      propagation.run_block(r, first, count, w, *displacements, group_begins(out.gyro.back(), first, count));
      if (at_station) at_station(first + count);
    }
    propagation.end_run(r);
  }
  return out;
}

}  // namespace surveymc::propagate
