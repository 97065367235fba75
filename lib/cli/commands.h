#pragma once
/// The commands of the program: their arguments, and the functions that do what they ask.
#include <optional>
#include <string>
#include <vector>

#include "cli/run_arguments.h"
#include "study/experiment.h"
#include "study/parts.h"

namespace surveymc::cli {

// ---- check, run, rerun

/// Prints the config with every default, and what a run of it would be.
int check_config(const RunArguments& a);
/// Runs the config, or the part or trial of it that the arguments ask for. `command`: the command line, for the result.
int run_config(const RunArguments& a, const std::string& command);
/// Repeats the result in `file`, and compares. `folder`: of its config.
int rerun_result(const std::string& file, const std::string& folder, const RunArguments& a, const std::string& command);

// ---- list, keys: every key of an experiment's configs

struct KeysArguments {
  std::string experiment;  ///< empty: the list of experiments
  bool csv = false;
};

/// The experiment of this name. Throws UsageError with the nearest name. `command`: for the message.
const study::Experiment& experiment_named(const std::vector<study::Experiment>& studies, const std::string& name,
                                          const std::string& command);

std::string list_text(const std::vector<study::Experiment>& studies);

void print_keys(const std::vector<study::Experiment>& studies, const KeysArguments& a);

// ---- schema: the same as JSON Schema, for editors (sweep/config_schema.h)

void print_schema(const std::vector<study::Experiment>& studies, const std::string& experiment);

// ---- new: a commented config of an experiment, to be filled in

struct NewArguments {
  std::string experiment, output;  ///< output: empty for stdout
};

/// Prints the config, or writes it to a.output, and beside it its schema and the example data that it names, where they
/// are not there.
/// Never writes over a file. Throws UsageError for an unknown experiment, IoError.
void new_config(const std::vector<study::Experiment>& studies, const NewArguments& a);

// ---- models

struct ModelsArguments {
  std::string name;  ///< of a model; empty: list them
  std::string file;  ///< a file of models; empty: those that come with the program
};

/// `surveymc models`: a line per error model (name, terms, range of inclinations, title), or one model as TOML with its
/// functions, ready to edit. Throws InputError for a name that is none.
std::string models_text(const ModelsArguments& arguments);

// ---- run --point/--shard/--array, plan, merge, status: runs in parts (docs/cluster.md)

struct PlanArguments {
  bool count = false;
  std::string folder;
  std::optional<std::string> groups;  // as typed
};

/// True if the arguments ask for a part of a run.
bool is_part(const RunArguments& a);

/// The part that the arguments or Slurm's environment ask for, if is_part(a). Throws InputError.
study::PartChoice part_choice(const RunArguments& a, const study::RunPlan& run);

/// Runs that part and writes its part file.
int run_one_part(const RunArguments& a, const std::string& command);
int plan_parts(const RunArguments& a, const PlanArguments& plan);
/// `part`: to a larger part, not to a result.
int merge_files(const RunArguments& a, const std::vector<std::string>& names, const std::string& inputs, bool part);

// ---- status: how far a run is

struct StatusArguments {
  bool watch = false;
  double every_s = 5;
  std::string page;  ///< HTML file; "": none
};

/// Prints what is kept of the run: of all runs whose parts are in the folder a.config; or of the config a.config, with
/// the options of its run: its journals beside a.output, or its parts there.
int status_of(const RunArguments& a, const StatusArguments& s);

// ---- show: what is in a result file, for a terminal, as CSV, as JSON (docs/results-format.md)

struct ShowArguments {
  std::string file;
  std::string name;  ///< of a table, samples or map; "": all of them
  bool list = false, csv = false, json = false;
  bool verbose = false;     ///< all tables, too
  bool cost = false;        ///< what the rows cost, instead
  std::string units = "m";  ///< "ft": lengths of tables in feet
  std::optional<int> rows;  ///< most of a table; 0: all
  bool unchecked = false;   ///< the file is not verified: no more of it is read than is shown
};

/// Prints. Throws InputError where there is nothing of that name, IoError where the file cannot be read.
void show(const ShowArguments& a);

// ---- diff A.h5 B.h5: what differs beyond chance between two results

struct DiffArguments {
  std::string a, b;
  double level = 0.05, tolerance = 0;
  bool csv = false, json = false;
};

/// Prints the differences; 0 if there are none, 1 if there are. Throws IoError, InputError.
int diff_results(const DiffArguments& arguments);

// ---- cite RESULT.h5: how to cite it, the program and the sources that it stands on

struct CiteArguments {
  std::string file;
  bool bibtex = false;
};

/// Prints. Throws IoError.
void cite_result(const std::vector<study::Experiment>& studies, const CiteArguments& a);

// ---- man

struct ManArguments {
  std::string command;  ///< whose page is printed; "": that of the program
  std::string folder;   ///< where all pages are written, in place of that
};

/// Throws IoError.
void print_manual(const ManArguments& a);

// ---- refine RESULT.h5 -o next.toml: the next round of a sweep; and rounds put together to one result

struct RefineArguments {
  std::string file, output;
  bool overwrite = false;
};

/// Writes the config and, beside it, its table of points; says so and writes nothing if the boundary is as fine as the
/// config wants it. Throws InputError, IoError.
int refine_result(const RefineArguments& arguments);

/// One result of several, which are rounds of one sweep. `output`: its name; `folder`: of the config.
store::Result merge_rounds(const std::vector<study::Experiment>& studies, const std::vector<std::string>& files,
                           const std::string& output, const std::string& folder);

}  // namespace surveymc::cli
