#include "study/experiment.h"

#include <algorithm>
#include <stdexcept>

#include "base/error.h"
#include "study/cost.h"
#include "study/family.h"

namespace surveymc::study {

std::uint64_t RunPlan::total_trials() const {
  std::uint64_t n = 0;
  for (const auto& p : points) n += p->trials();
  return n;
}

namespace {

/// The seed; 0 where a config has none, because it draws nothing.
std::uint64_t seed_of(const config::Config& config) { return config.has_seed() ? config.seed() : 0; }

}  // namespace

std::shared_ptr<const StudyPoint> RunPlan::prepare(std::size_t point, const montecarlo::RunOptions& options) const {
  if (options.stop && *options.stop) throw Interrupted("stopped before all points were prepared");
  try {
    return points.at(point)->prepare(options);
  } catch (const InputError& e) {
    if (points.size() == 1) throw;
    throw InputError(fmt::format("{} (point {} of the sweep)", e.what(), point));
  }
}

RunPlan read_run(const Experiment& experiment, config::Config config, const std::atomic<bool>* stop) {
  RunPlan run{experiment, std::move(config), {}, {}};
  const random::StudySeed seed{seed_of(run.config), experiment.id};
  std::vector<store::Axis> first;
  for (std::size_t i = 0; i < run.config.point_count(); ++i) {
    if (stop && *stop) throw Interrupted("stopped before all points were read");
    config::ConfigReader reader = run.config.reader(i);
    run.points.push_back(experiment.read(reader, seed));
    if (reader.has("verdict.family")) run.as_family = reader.text("verdict.family") != "none";
    run.placed.push_back(reader.has("field.model") ? read_placed_field(reader) : std::nullopt);
    if (run.points.back()->trials() > 0) run.config.seed();  // trials draw: there must be one
    const std::vector<store::Axis> own = run.points.back()->map_axes();
    if (i == 0) first = own;
    for (std::size_t a = 0; a < std::max(first.size(), own.size()); ++a)
      require(a < first.size() && a < own.size() && first[a].name == own[a].name && first[a].values == own[a].values,
              "sweep: point {} has other values of the map axis {} than point 0: give all of them as the grid itself",
              i, (a < own.size() ? own : first)[a].name);
  }
  return run;
}

std::string unit_of_name(const std::string& name) {
  const std::string suffix = name.substr(name.rfind('_') + 1);  // all of it without an underscore
  for (const char* unit : {"m", "ft", "deg", "nT", "uT", "mps2", "mg", "s"})
    if (suffix == unit && suffix.size() < name.size()) return suffix;
  return "1";
}

store::Column sweep_column(const config::SweepValue& value, std::size_t rows) {
  store::Column c{value.key, "", "sweep key", std::vector<double>(rows, 0.0)};
  if (const double* number = std::get_if<double>(&value.value)) {
    c.unit = unit_of_name(value.key);
    c.values = std::vector<double>(rows, *number);
  } else {
    c.values = std::vector<std::string>(rows, std::get<std::string>(value.value));
  }
  return c;
}

namespace {

store::Table with_sweep_columns(store::Table t, const std::vector<config::SweepValue>& sweep) {
  if (sweep.empty()) return t;
  store::Table all{t.name, t.long_name};
  store::for_each_piece(t, [&](const store::Table& piece, std::size_t) {
    store::Table part = piece;
    std::vector<store::Column> keys;
    for (const config::SweepValue& v : sweep) keys.push_back(sweep_column(v, piece.rows()));
    part.columns.insert(part.columns.begin(), keys.begin(), keys.end());
    if (all.columns.empty())
      all.columns = std::move(part.columns);
    else
      store::append_rows(all, part);
  });
  return all;
}

void add_point(std::vector<store::Table>& all, std::vector<store::Table>&& tables,
               const std::vector<config::SweepValue>& sweep) {
  for (store::Table& t : tables) {
    t = with_sweep_columns(std::move(t), sweep);
    const auto same = std::find_if(all.begin(), all.end(), [&](const store::Table& o) { return o.name == t.name; });
    if (same == all.end()) {
      all.push_back(std::move(t));
    } else {
      const auto named_alike = [](const store::Column& a, const store::Column& b) { return a.name == b.name; };
      require(std::equal(same->columns.begin(), same->columns.end(), t.columns.begin(), t.columns.end(), named_alike),
              "table {}: points of the sweep fill it with other columns: run them apart", t.name);
      store::append_rows(*same, t);
    }
  }
}

/// Sweep dimensions in column order with their distinct values in order of the points.
std::vector<store::Axis> sweep_axes(const config::Config& config) {
  std::vector<store::Axis> axes;
  for (std::size_t i = 0; i < config.point_count(); ++i) {
    const std::vector<config::SweepValue> values = config.sweep_values(i);
    if (i == 0)
      for (const config::SweepValue& v : values) {
        const bool number = std::holds_alternative<double>(v.value);
        store::Axis axis{v.key, number ? unit_of_name(v.key) : "", "sweep key", std::vector<double>{}};
        if (!number) axis.values = std::vector<std::string>{};
        axes.push_back(axis);
      }
    for (std::size_t d = 0; d < values.size(); ++d)
      std::visit(
          [&](const auto& v) {
            auto& seen = std::get<std::vector<std::decay_t<decltype(v)>>>(axes[d].values);
            if (std::find(seen.begin(), seen.end(), v) == seen.end()) seen.push_back(v);
          },
          values[d].value);
  }
  return axes;
}

void add_maps(std::vector<store::Map>& all, std::vector<store::Map>&& maps, const std::vector<store::Axis>& sweep) {
  for (store::Map& m : maps) {
    const auto same = std::find_if(all.begin(), all.end(), [&](const store::Map& o) { return o.name == m.name; });
    if (same != all.end()) {  // points come in product order, last key fastest: appending is the right place
      if (same->unit != m.unit) same->unit = "mixed";  // a sweep over what decides the unit
      same->values.insert(same->values.end(), m.values.begin(), m.values.end());
      continue;
    }
    m.axes.insert(m.axes.begin(), sweep.begin(), sweep.end());
    all.push_back(std::move(m));
  }
}

/// The streams of all points, one after the other: points come in product order, last key fastest.
class Streams {
 public:
  void add(std::vector<store::MapStream>&& streams, const std::vector<store::Axis>& sweep) {
    if (all_.empty()) {
      all_.resize(streams.size());
      for (std::size_t i = 0; i < streams.size(); ++i)
        for (store::Map m : streams[i].maps) {
          m.axes.insert(m.axes.begin(), sweep.begin(), sweep.end());
          all_[i].maps.push_back(std::move(m));
        }
      points_.resize(streams.size());
    }
    for (std::size_t i = 0; i < streams.size(); ++i) {
      for (std::size_t m = 0; m < streams[i].maps.size(); ++m)
        if (all_[i].maps[m].unit != streams[i].maps[m].unit) all_[i].maps[m].unit = "mixed";
      points_[i].push_back(std::move(streams[i]));
    }
  }

  std::vector<store::MapStream> take(const std::atomic<bool>* stop) {
    for (std::size_t i = 0; i < all_.size(); ++i)
      all_[i].values = [points = std::move(points_[i]), stop](std::size_t first, std::size_t count) {
        if (stop && *stop) throw Interrupted("stopped before all maps were written");
        const std::size_t of_point = store::map_size(points.front().maps.front());
        std::vector<std::vector<double>> out;
        while (count > 0) {
          const std::size_t at = first % of_point, n = std::min(count, of_point - at);
          std::vector<std::vector<double>> part = points[first / of_point].values(at, n);
          if (out.empty()) {
            out = std::move(part);
          } else {
            for (std::size_t m = 0; m < out.size(); ++m) out[m].insert(out[m].end(), part[m].begin(), part[m].end());
          }
          first += n;
          count -= n;
        }
        return out;
      };
    return std::move(all_);
  }

 private:
  std::vector<store::MapStream> all_;
  std::vector<std::vector<store::MapStream>> points_;  // [stream][point]
};

store::Table table_of(const config::InputTable& in) {
  store::Table t{in.path, "as read from " + in.path};
  for (std::size_t c = 0; c < in.names.size(); ++c) {
    t.columns.push_back({in.names[c], unit_of_name(in.names[c]), "column of the user's file", in.columns[c]});
  }
  return t;
}

/// One row a line of the text; joined by line feeds, the rows are the text again.
store::Table table_of(const config::InputText& in) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
    end = in.text.find('\n', begin);
    lines.push_back(in.text.substr(begin, end - begin));
  }
  return {in.path, "as read from " + in.path, {{"line", "", "line of the file", std::move(lines)}}};
}

/// One row: hash, size and header, which identify the file.
store::Table table_of(const config::InputReference& in) {
  return {in.path,
          "not stored, as it is too large: what identifies " + in.path,
          {{"file_hash", "", "128-bit XXH3 of the bytes of the file, in hex", std::vector<std::string>{in.hash}},
           {"size_bytes", "1", "bytes of the file", std::vector<std::int64_t>{static_cast<std::int64_t>(in.size)}},
           {"header", "", "its first line that is no comment", std::vector<std::string>{in.header}}}};
}

}  // namespace

montecarlo::RunOptions options_of_point(montecarlo::RunOptions options, const RunPlan& run, std::size_t point,
                                        checkpoint::Journal* journal) {
  options.block_trials = run.points[point]->block_trials();
  options.point = point;
  if (!journal) return options;
  options.save_due = [journal] { return journal->due(); };
  options.save = [journal, point](montecarlo::OrderedMerge& merge) {
    merge.take_unsaved([&](const montecarlo::Subtree& s) { journal->add(point, s); });
    if (journal->due()) journal->write();
  };
  return options;
}

void require_proposal(const StudyPoint& point, const stats::Tally& tally, const std::string& whose) {
  if (tally.proposal == 0 || tally.proposal == point.proposal()) return;
  throw InputError(fmt::format(
      "{}: its trials were drawn from another preparation ({:016x}) than this run's ({:016x}), so that their "
      "weights do not add up: must be of this config, seed and program; remove it, and run it again",
      whose, tally.proposal, point.proposal()));
}

stats::Tally point_tally(const RunPlan& run, std::size_t index, const StudyPoint& point,
                         const montecarlo::RunOptions& options, const Checkpoint& checkpoint) {
  const PointPlan& plan = *run.points[index];
  if (plan.trials() == 0) return {};
  const auto kept = checkpoint.finished.find(index);
  if (kept != checkpoint.finished.end())
    for (const montecarlo::Subtree& s : kept->second) require_proposal(point, s.tally, "a journal beside the output");
  return montecarlo::run_blocks(
      plan.trials(), [&](montecarlo::TrialBlock b) { return point.run_block(b); },
      options_of_point(options, run, index, checkpoint.journal),
      {plan.looks(), [&](const stats::Tally& t) { return point.trials_needed(t); }},
      kept == checkpoint.finished.end() ? std::vector<montecarlo::Subtree>{} : kept->second);
}

PointResult point_report(const std::shared_ptr<const StudyPoint>& point, const stats::Tally& tally,
                         const montecarlo::RunOptions& options) {
  PointResult r = point->report(tally, options);
  for (store::MapStream& s : r.streams)
    s.values = [point, values = std::move(s.values)](std::size_t first, std::size_t count) {
      return values(first, count);
    };
  return r;
}

store::Result execute(const RunPlan& run, const montecarlo::RunOptions& options, const Checkpoint& checkpoint) {
  std::uint64_t done_before = 0, after = run.total_trials();
  store::Table cost;
  store::Result result = assemble(
      run,
      [&](std::size_t i) {
        after -= run.points[i]->trials();
        montecarlo::RunOptions of_point = options;
        if (options.progress)
          of_point.progress = [&](std::uint64_t done, std::uint64_t expected) {
            options.progress(done_before + done, done_before + expected + after);
          };
        const std::shared_ptr<const StudyPoint> point = run.prepare(i, of_point);
        const double before = processor_seconds();
        const stats::Tally tally = point_tally(run, i, *point, of_point, checkpoint);
        const double seconds = processor_seconds() - before;
        done_before += tally.trials;
        PointResult r = point_report(point, tally, of_point);
        std::uint64_t kept = 0;
        if (const auto of_earlier = checkpoint.finished.find(i); of_earlier != checkpoint.finished.end())
          for (const montecarlo::Subtree& n : of_earlier->second) kept += n.tally.trials;
        // The time of other ranks is not known here.
        if (tally.trials > kept && !options.workers)
          add_cost(cost, r.tables, run.config.sweep_values(i), seconds, tally.trials - kept, tally.trials);
        return r;
      },
      options.stop);
  result.cost = std::move(cost);
  return result;
}

store::Result assemble(const RunPlan& run, const std::function<PointResult(std::size_t)>& point_result,
                       const std::atomic<bool>* stop) {
  store::Result result;
  const std::vector<store::Axis> axes = sweep_axes(run.config);
  Streams streams;
  for (std::size_t i = 0; i < run.points.size(); ++i) {
    PointResult r = point_result(i);
    if (run.placed[i])
      for (store::Table& t : field_tables(*run.placed[i])) r.tables.push_back(std::move(t));
    const std::vector<config::SweepValue> sweep = run.config.sweep_values(i);
    add_point(result.tables, std::move(r.tables), sweep);
    add_point(result.samples, std::move(r.samples), sweep);
    add_maps(result.maps, std::move(r.maps), axes);
    streams.add(std::move(r.streams), axes);
  }
  if (run.as_family) apply_family(result.tables);
  result.streams = streams.take(stop);
  const auto add_inputs = [&](const auto& files) {
    for (const auto& in : files) {
      const store::Table t = table_of(in);
      result.inputs.push_back({in.path, store::input_hash(t), t});
    }
  };
  add_inputs(run.config.inputs());
  add_inputs(run.config.input_texts());
  add_inputs(run.config.input_references());
  store::Provenance& p = result.provenance;
  p.title = run.config.title().empty() ? run.experiment.summary : run.config.title();
  p.experiment = run.experiment.name();
  p.config = run.config.resolved_text();
  p.config_hash = run.config.hash();
  p.seed = seed_of(run.config);
  p.trials = run.points.empty() ? 0 : run.points.front()->trials();
  return result;
}

}  // namespace surveymc::study
