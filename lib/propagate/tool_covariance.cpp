#include "propagate/tool_covariance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

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

void add_depth(const BlockWeights& w, double sigma, const Displacements& d, std::size_t count, Effects& e) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < count; ++i) {
      const double depth = sigma * w.depth[i];
      e.star[axis][i] = depth * d.star_depth[axis][i];
      e.full[axis][i] = depth * d.full_depth[axis][i];
    }
}

/// Effects of angles across the hole, in metres per metre of interval.
void set_across(const BlockWeights& w, double sigma, const Displacements& d, std::size_t count,
                std::array<Column, 3>& across) {
  const double *wi = w.inclination, *wl = w.lateral;
  if (wi != nullptr && wl != nullptr) {
    for (std::size_t i = 0; i < count; ++i) {
      across[0][i] = sigma * (wi[i] * d.high_side[0][i] + wl[i] * d.right_north[i]);
      across[1][i] = sigma * (wi[i] * d.high_side[1][i] + wl[i] * d.right_east[i]);
      across[2][i] = sigma * (wi[i] * d.high_side[2][i]);
    }
  } else if (wi != nullptr) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < count; ++i) across[axis][i] = sigma * (wi[i] * d.high_side[axis][i]);
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      across[0][i] = wl != nullptr ? sigma * (wl[i] * d.right_north[i]) : 0;
      across[1][i] = wl != nullptr ? sigma * (wl[i] * d.right_east[i]) : 0;
      across[2][i] = 0;
    }
  }
  if (w.vertical_north == nullptr) return;
  for (std::size_t i = 0; i < count; ++i)
    if (d.is_vertical[i]) {
      across[0][i] = sigma * w.vertical_north[i];
      across[1][i] = sigma * w.vertical_east[i];
      across[2][i] = 0;
    }
}

void set_effects(const em::Term& term, const BlockWeights& w, const Displacements& d, std::size_t count, Effects& e) {
  const double sigma = term.sigma;
  const bool has_angles = w.inclination != nullptr || w.lateral != nullptr || w.vertical_north != nullptr;
  if (w.depth != nullptr) {
    add_depth(w, sigma, d, count, e);
    if (!has_angles) return;
  } else {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::fill_n(e.star[axis].begin(), count, 0.0);
      std::fill_n(e.full[axis].begin(), count, 0.0);
    }
  }
  std::array<Column, 3> across;
  set_across(w, sigma, d, count, across);
  if (term.function->kind == em::Kind::course) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < count; ++i) {
        e.star[axis][i] += d.length[i] * across[axis][i];
        e.full[axis][i] += d.length[i] * across[axis][i];
      }
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < count; ++i) {
      e.star[axis][i] += d.star_angle[i] * across[axis][i];
      e.full[axis][i] += d.full_angle[i] * across[axis][i];
    }
}

/// Covariance of one source, or of all, at the stations of a block: nn, ee, vv, ne, nv, ev.
using BlockCovariance = std::array<Column, 6>;

/// Moves a source through a block: its covariance at every station.
void propagate(Source& s, Grouping grouping, const std::array<bool, kBlock>& begins_group, const Effects& e,
               std::size_t count, BlockCovariance& c) {
  if (grouping == Grouping::station) {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t m = 0; m < 6; ++m) c[m][i] = s.past[m];
      Source::add_product(s.past, e.full[0][i], e.full[1][i], e.full[2][i]);
    }
    constexpr std::array<std::array<std::size_t, 2>, 6> kAxes{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
    for (std::size_t m = 0; m < 6; ++m)
      for (std::size_t i = 0; i < count; ++i) c[m][i] += e.star[kAxes[m][0]][i] * e.star[kAxes[m][1]][i];
    return;
  }
  std::array<Column, 3> at;
  for (std::size_t i = 0; i < count; ++i) {
    if (grouping == Grouping::mixed) {
      if (begins_group[i]) s.end_group();
      for (std::size_t m = 0; m < 6; ++m) c[m][i] = s.past[m];
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis][i] = s.sum[axis] + e.star[axis][i];
      s.sum[axis] += e.full[axis][i];
    }
  }
  if (grouping == Grouping::run)
    for (std::size_t m = 0; m < 6; ++m) std::fill_n(c[m].begin(), count, s.past[m]);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = at[0][i], y = at[1][i], z = at[2][i];
    c[0][i] += x * x;
    c[1][i] += y * y;
    c[2][i] += z * z;
    c[3][i] += x * y;
    c[4][i] += x * z;
    c[5][i] += y * z;
  }
}

Matrix3d matrix_at(const BlockCovariance& c, std::size_t i) {
  Matrix3d m;
  m << c[0][i], c[3][i], c[4][i],  //
      c[3][i], c[1][i], c[5][i],   //
      c[4][i], c[5][i], c[2][i];
  return m;
}

bool joins_runs(em::PropagationMode mode) {
  return mode == em::PropagationMode::well || mode == em::PropagationMode::global;
}

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
      const bool is_kept = !joining_alone || joins_runs(s.mode);
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
        draw_[row] = joins_runs(term.mode) ? 1 : static_cast<int>(run_first);
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
        out_(out),
        keeper_(runs, sources_, survey.stations.size(), joining_alone, effects) {
    const std::size_t n = survey.stations.size();
    out.sources = sources_.codes;
    out.total.assign(n, Matrix3d::Zero());
    if (detail != SourceDetail::none)
      out.by_source.assign((detail == SourceDetail::all ? n : 1) * out.sources.size(), Matrix3d::Zero());
  }

  void run_block(std::size_t run, std::size_t first, std::size_t count, const RunWeights& weights,
                 const Displacements& d, const std::array<bool, kBlock>& begins_group) {
    for (std::size_t m = 0; m < 6; ++m) std::fill_n(total_[m].begin(), count, 0.0);
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
      keep_source(source.row, first, count);
    }
    for (std::size_t i = 0; i < count; ++i) out_.total[first + i] = matrix_at(total_, i);
  }

  void end_run(std::size_t run) {
    const auto& terms = runs_[run].model->terms;
    std::vector<bool> is_per_section(sources_.all.size(), false);
    for (std::size_t t = 0; t < terms.size(); ++t)
      is_per_section[sources_.of_run[run][t]] = terms[t].function->per_section;
    for (std::size_t s = 0; s < sources_.all.size(); ++s) {
      Source& source = sources_.all[s];
      if (!joins_runs(source.mode) || is_per_section[s]) source.end_group();
    }
  }

 private:
  void keep_source(std::size_t row, std::size_t first, std::size_t count) {
    const std::size_t rows = out_.sources.size();
    if (detail_ == SourceDetail::all)
      for (std::size_t i = 0; i < count; ++i) out_.by_source[(first + i) * rows + row] += matrix_at(own_, i);
    if (detail_ == SourceDetail::last && first + count == survey_.stations.size())
      out_.by_source[row] += matrix_at(own_, count - 1);
  }

  /// Where one standard deviation has no finite effect, it becomes NaN, and so does all beyond; the term is noted.
  void refuse_poles(std::size_t run, std::size_t t, const BlockWeights& w, std::size_t first, std::size_t count,
                    const Displacements& d) {
    const em::Term& term = runs_[run].model->terms[t];
    if (term.sigma == 0) return zero_effects(count);
    if (term.sigma * w.largest_angle <= kLargestAngle && term.sigma * w.largest_depth <= 1e300) return;
    for (std::size_t i = 0; i < count; ++i) {
      const bool has_vertical = w.vertical_north != nullptr && d.is_vertical[i];
      const auto is_beyond = [&](const double* x, double most) {
        return x != nullptr && !(std::abs(term.sigma * x[i]) <= most);
      };
      const em::Expression* formula = is_beyond(w.depth, 1e300)                 ? &term.function->depth
                                      : has_vertical                            ? nullptr
                                      : is_beyond(w.inclination, kLargestAngle) ? &term.function->inclination
                                      : is_beyond(w.lateral, kLargestAngle)     ? &term.function->azimuth_or_lateral()
                                                                                : nullptr;
      if (formula == nullptr) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) effects_.star[axis][i] = effects_.full[axis][i] = kNaN;
      note(run, t, first + i, *formula);
    }
  }

  void zero_effects(std::size_t count) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::fill_n(effects_.star[axis].begin(), count, 0.0);
      std::fill_n(effects_.full[axis].begin(), count, 0.0);
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
  ToolCovariances& out_;
  EffectsKeeper keeper_;
  std::vector<const em::Term*> term_of_source_;
  Effects effects_;
  BlockCovariance own_, total_;
};

}  // namespace

ToolCovariances tool_covariances(const survey::Survey& survey, const std::vector<double>& tvd,
                                 const std::vector<ToolRun>& runs, const survey::ReferenceField& field, double latitude,
                                 SourceDetail detail, StationEffects* effects, bool joining_alone) {
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
    }
    propagation.end_run(r);
  }
  return out;
}

}  // namespace surveymc::propagate
