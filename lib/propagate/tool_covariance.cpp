#include "propagate/tool_covariance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/units.h"
#include "error_model/model_graph.h"

namespace surveymc::propagate {
namespace {

namespace em = error_model;
using Eigen::Matrix3d;
using em::Evaluation;
using em::Variable;

constexpr std::size_t kBlock = Evaluation::kBlock;
using Column = std::array<double, kBlock>;

/// Sines and cosines of all stations, and tangents.
struct Directions {
  std::vector<double> sin_i, cos_i, sin_a, cos_a, sin_am, cos_am;
  std::vector<double> north, east;  ///< of the tangents; down is cos_i

  Directions(const survey::Survey& survey, double declination) {
    const std::size_t n = survey.stations.size();
    for (auto* v : {&sin_i, &cos_i, &sin_a, &cos_a, &sin_am, &cos_am, &north, &east}) v->resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      const survey::Station& s = survey.stations[k];
      sin_i[k] = std::sin(s.inclination);
      cos_i[k] = std::cos(s.inclination);
      sin_a[k] = std::sin(s.azimuth);
      cos_a[k] = std::cos(s.azimuth);
      const double magnetic = s.azimuth - declination;
      sin_am[k] = declination == 0 ? sin_a[k] : std::sin(magnetic);
      cos_am[k] = declination == 0 ? cos_a[k] : std::cos(magnetic);
      north[k] = sin_i[k] * cos_a[k];
      east[k] = sin_i[k] * sin_a[k];
    }
  }
};

/// What a unit of depth and of angle at the stations of a block does to their own position (star) and to all beyond
/// (full), in structures of arrays: north, east, down.
struct Displacements {
  std::array<Column, 3> star_depth, full_depth;
  Column star_angle, full_angle;    ///< metres per rad along the two directions below
  std::array<Column, 3> high_side;  ///< dt/dI
  Column right_north, right_east;   ///< dt/dA over sinI
  Column length;                    ///< of the interval before the station, m
  std::array<bool, kBlock> is_vertical;

  void set(const survey::Survey& survey, const Directions& d, std::size_t first, std::size_t count,
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

/// Weights of one function at the stations of a block; null where it has none.
struct BlockWeights {
  const double *depth = nullptr, *inclination = nullptr, *lateral = nullptr;
  const double *vertical_north = nullptr, *vertical_east = nullptr;  ///< both or neither
  double largest_depth = 0, largest_angle = 0;                       ///< absolute; infinite if one is no number
};

/// Infinite if one is not finite.
double largest(const double* x, std::size_t count) {
  if (x == nullptr) return 0;
  double most = 0;
  bool is_fine = true;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = std::abs(x[i]);
    is_fine = is_fine & (a <= 1e300);
    most = most < a ? a : most;
  }
  return is_fine ? most : HUGE_VAL;
}

/// Of the stretch that station k is in.
std::size_t stretch_index(const std::vector<GyroStretch>& stretches, std::size_t k) {
  const auto at =
      std::partition_point(stretches.begin(), stretches.end(), [&](const GyroStretch& s) { return s.end <= k; });
  return static_cast<std::size_t>(at - stretches.begin());
}

/// The functions of one tool run, evaluated block after block.
class RunWeights {
 public:
  RunWeights(const em::Model& model, const em::ModelGraph& graph, const survey::Survey& survey,
             const std::vector<double>& tvd, const Directions& directions, const survey::ReferenceField& field,
             double latitude)
      : model_(model),
        graph_(graph),
        survey_(survey),
        tvd_(tvd),
        directions_(directions),
        declination_(field.declination),
        surroundings_(em::surroundings_of(model.parameters, field.dip, field.total, field.gravity, latitude)),
        evaluation_(graph.graph, surroundings_),
        weights_(graph.functions.size()),
        modes_(graph.functions.size()) {
    zeros_.fill(0);
  }

  /// Of a run with the stations first to end - 1, before its first block.
  void begin_run(const std::vector<GyroStretch>& stretches) {
    stretches_ = stretches;
    for (ByMode& m : modes_) m = {};
  }

  /// The stations first to first + count - 1.
  void evaluate(std::size_t first, std::size_t count) {
    fill_inputs(first, count);
    evaluation_.run(count);
    for (std::size_t f = 0; f < weights_.size(); ++f) weights_[f] = weights_of(f, first, count);
  }
  const BlockWeights& of_term(std::size_t term) const { return weights_[graph_.function_of_term[term]]; }

 private:
  /// A stationary or continuous function of a tool with a gyro.
  struct ByMode {
    double sum = 0;                                 ///< of a continuous function, at the station before
    double held_inclination = 0, held_azimuth = 0;  ///< of a stationary function, since the initialisation
    Column inclination, lateral;
  };

  void fill_inputs(std::size_t first, std::size_t count) {
    const em::Graph& g = graph_.graph;
    const auto fill = [&](Variable v, const auto& value_at) {
      if (!g.names(v)) return;
      double* x = evaluation_.input(v);
      for (std::size_t i = 0; i < count; ++i) x[i] = value_at(first + i);
    };
    const auto& s = survey_.stations;
    fill(Variable::md, [&](std::size_t k) { return s[k].md; });
    fill(Variable::md_before, [&](std::size_t k) { return s[k - 1].md; });
    fill(Variable::tvd, [&](std::size_t k) { return tvd_[k]; });
    fill(Variable::inclination, [&](std::size_t k) { return s[k].inclination; });
    fill(Variable::inclination_before, [&](std::size_t k) { return s[k - 1].inclination; });
    fill(Variable::azimuth, [&](std::size_t k) { return s[k].azimuth; });
    fill(Variable::azimuth_before, [&](std::size_t k) { return azimuth_before(s[k - 1], s[k]); });
    fill(Variable::azimuth_magnetic, [&](std::size_t k) { return s[k].azimuth - declination_; });
    const double noise = model_.gyro ? 1 : model_.parameters.noise_reduction;
    fill(Variable::noise_reduction, [&](std::size_t) { return noise; });
    fill(Variable::running_speed, [&](std::size_t k) { return speed_at(s[k].inclination); });
    const Directions& d = directions_;
    fill(Variable::sin_inclination, [&](std::size_t k) { return d.sin_i[k]; });
    fill(Variable::cos_inclination, [&](std::size_t k) { return d.cos_i[k]; });
    fill(Variable::sin_azimuth, [&](std::size_t k) { return d.sin_a[k]; });
    fill(Variable::cos_azimuth, [&](std::size_t k) { return d.cos_a[k]; });
    fill(Variable::sin_azimuth_magnetic, [&](std::size_t k) { return d.sin_am[k]; });
    fill(Variable::cos_azimuth_magnetic, [&](std::size_t k) { return d.cos_am[k]; });
  }

  /// Zones that overlap have one speed (the reader of models sees to it); where there is none, nothing grows.
  double speed_at(double inclination) const {
    if (model_.gyro)
      for (const em::GyroZone& z : model_.gyro->zones)
        if (zone_at(*model_.gyro, z.axis, inclination) == &z) return z.speed;
    return 1;
  }

  BlockWeights weights_of(std::size_t f, std::size_t first, std::size_t count) {
    const em::FunctionNodes& n = graph_.functions[f];
    const auto output = [&](const std::optional<std::size_t>& node) {
      return node ? evaluation_.output(*node) : nullptr;
    };
    BlockWeights w;
    w.depth = output(n.depth);
    w.inclination = output(n.inclination);
    w.lateral = output(n.lateral);
    if (n.has_vertical()) {
      w.vertical_north = n.vertical_north ? output(n.vertical_north) : zeros_.data();
      w.vertical_east = n.vertical_east ? output(n.vertical_east) : zeros_.data();
    }
    if (n.function->kind == em::Kind::continuous) run_sums(f, first, count, w);
    if (n.function->kind == em::Kind::stationary && model_.gyro) hold_values(f, first, count, w);
    w.largest_depth = largest(w.depth, count);
    w.largest_angle = std::max(largest(w.inclination, count), largest(w.lateral, count));
    return w;
  }

  /// The stretch that a station is in.
  const GyroStretch& stretch_at(std::size_t k) const { return stretches_[stretch_index(stretches_, k)]; }

  void run_sums(std::size_t f, std::size_t first, std::size_t count, BlockWeights& w) {
    const em::FunctionNodes& n = graph_.functions[f];
    ByMode& m = modes_[f];
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = first + i;
      const GyroStretch& stretch = stretch_at(k);
      const bool begins_section = k == stretch.first && (k == stretches_.front().first || !stretch.is_continuous);
      if (begins_section) m.sum = 0;
      if (zone_at(*model_.gyro, n.function->axis, survey_.stations[k].inclination) != nullptr)
        m.sum = evaluation_.step(n.azimuth_chain, m.sum, i);
      m.lateral[i] = stretch.is_continuous ? directions_.sin_i[k] * m.sum : 0;
    }
    w.lateral = m.lateral.data();
  }

  void hold_values(std::size_t f, std::size_t first, std::size_t count, BlockWeights& w) {
    const em::FunctionNodes& n = graph_.functions[f];
    ByMode& m = modes_[f];
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = first + i;
      const GyroStretch& stretch = stretch_at(k);
      if (stretch.is_continuous && k == stretch.first) initialise(n, stretch, m);
      m.inclination[i] = stretch.is_continuous ? m.held_inclination : w.inclination ? w.inclination[i] : 0;
      m.lateral[i] = stretch.is_continuous ? directions_.sin_i[k] * m.held_azimuth : w.lateral ? w.lateral[i] : 0;
    }
    if (n.inclination) w.inclination = m.inclination.data();
    if (n.lateral) w.lateral = m.lateral.data();
  }

  void initialise(const em::FunctionNodes& n, const GyroStretch& stretch, ByMode& m) const {
    const std::size_t k = stretch.initialised_from;
    em::SampleStation s;
    s.inclination = stretch.initialised_inclination;
    s.azimuth = stretch.initialised_azimuth;
    s.declination = declination_;
    s.md = survey_.stations[k].md;
    s.dmd = survey_.stations[k + 1].md - s.md;
    s.tvd = tvd_[k];
    s.noise_reduction = model_.parameters.noise_reduction;
    Evaluation at(graph_.graph, surroundings_);
    em::set_station(at, 0, s);
    at.run(1);
    m.held_inclination = n.inclination ? at.output(*n.inclination)[0] : 0;
    m.held_azimuth = n.azimuth   ? at.output(*n.azimuth)[0]
                     : n.lateral ? at.output(*n.lateral)[0] / std::sin(s.inclination)
                                 : 0;
  }

  const em::Model& model_;
  const em::ModelGraph& graph_;
  const survey::Survey& survey_;
  const std::vector<double>& tvd_;
  const Directions& directions_;
  double declination_;
  em::Surroundings surroundings_;
  Evaluation evaluation_;
  std::vector<BlockWeights> weights_;
  std::vector<ByMode> modes_;
  std::vector<GyroStretch> stretches_;
  Column zeros_;
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

/// How the errors of a source go together within a run.
enum class Grouping {
  station,  ///< another error at every station
  run,      ///< one error
  mixed     ///< `begins_group` says where another error begins
};

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

Grouping grouping_of(const em::Term& term, bool has_gyro) {
  const em::Kind kind = term.function->kind;
  const bool is_of_gyro = has_gyro && (kind == em::Kind::stationary || kind == em::Kind::continuous);
  if (is_of_gyro && (term.mode == em::PropagationMode::random || term.function->per_section)) return Grouping::mixed;
  return term.mode == em::PropagationMode::random ? Grouping::station : Grouping::run;
}

/// True where an error of a gyro that is drawn anew begins: at every stationary station, and with every section.
std::array<bool, kBlock> group_begins(const std::vector<GyroStretch>& stretches, std::size_t first, std::size_t count) {
  std::array<bool, kBlock> out{};
  if (stretches.empty()) return out;
  std::size_t at = stretch_index(stretches, first);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = first + i;
    if (k == stretches[at].end) ++at;
    out[i] = k == stretches[at].first || !stretches[at].is_continuous;
  }
  return out;
}

/// The sources, moved along the well.
class Propagation {
 public:
  Propagation(const survey::Survey& survey, const std::vector<ToolRun>& runs, SourceDetail detail, ToolCovariances& out)
      : survey_(survey), runs_(runs), detail_(detail), sources_(runs), out_(out) {
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
        propagate(source, grouping_of(*term, runs_[run].model->gyro.has_value()), begins_group, effects_, count, own_);
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
      const bool joins_runs = source.mode == em::PropagationMode::well || source.mode == em::PropagationMode::global;
      if (!joins_runs || is_per_section[s]) source.end_group();
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
  std::vector<const em::Term*> term_of_source_;
  Effects effects_;
  BlockCovariance own_, total_;
};

}  // namespace

double azimuth_before(const survey::Station& before, const survey::Station& at) {
  if (before.inclination < em::kVerticalLimit) return at.azimuth;
  const double turn = at.azimuth - before.azimuth;
  return std::abs(turn) <= kPi ? before.azimuth : at.azimuth - std::remainder(turn, 2 * kPi);
}

ToolCovariances tool_covariances(const survey::Survey& survey, const std::vector<double>& tvd,
                                 const std::vector<ToolRun>& runs, const survey::ReferenceField& field, double latitude,
                                 SourceDetail detail) {
  const std::size_t n = survey.stations.size();
  const Directions directions(survey, field.declination);
  ToolCovariances out;
  Propagation propagation(survey, runs, detail, out);
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
