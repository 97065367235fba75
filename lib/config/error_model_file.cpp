#include "config/error_model_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "config/suggest.h"
#include "config/text.h"
#include "error_model/model_graph.h"

namespace surveymc::config {
namespace {

namespace em = error_model;
using em::Expression;
using em::Variable;

// ----------------------------------------------------------------------------------------------------------- functions

/// The entry of a function in its file, and what is wrong with one of its formulas.
class FunctionEntry {
 public:
  explicit FunctionEntry(ConfigReader& entry) : entry_(entry) {}

  em::Function read() {
    f_.name = entry_.text("name", "name of the function, once in the file");
    entry_.require(!f_.name.empty(), "name", "must not be empty");
    const std::string kind =
        entry_.choice("kind", {"station", "course", "stationary", "continuous"},
                      "'course': its weight times the length of the interval displaces the end of the interval alone; "
                      "'stationary': a gyrocompass; 'continuous': a running sum",
                      "station");
    for (const em::Kind k : {em::Kind::station, em::Kind::course, em::Kind::stationary, em::Kind::continuous})
      if (em::kind_name(k) == kind) f_.kind = k;
    if (f_.kind == em::Kind::continuous) {
      f_.axis = entry_.choice("axis", {"XY", "Z", "XYZ"}, "of a continuous function: the gyro axis that runs");
      f_.per_section =
          entry_.boolean("per_section", "of a continuous function: a random walk, summed section by section", false);
    } else {
      for (const char* key : {"axis", "per_section"})
        if (entry_.has(key)) entry_.fail(key, "only a function of kind \"continuous\" has it");
    }
    for (const auto& [key, formula] :
         std::initializer_list<std::pair<const char*, Expression*>>{{"depth", &f_.depth},
                                                                    {"inclination", &f_.inclination},
                                                                    {"azimuth", &f_.azimuth},
                                                                    {"lateral", &f_.lateral},
                                                                    {"vertical_north", &f_.vertical_north},
                                                                    {"vertical_east", &f_.vertical_east}})
      if (entry_.has(key)) *formula = read_formula(key);
    check_keys();
    check_dimensions();
    const std::string fault = em::vertical_fault(f_, {});
    if (!fault.empty())
      fail(f_.vertical_north.empty() && f_.vertical_east.empty() ? "azimuth"
           : f_.vertical_north.empty()                           ? "vertical_east"
                                                                 : "vertical_north",
           fault);
    return f_;
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& rule) {
    throw InputError(fmt::format("{}: function {}: {} = {}: {}", entry_.place(key).text(), f_.name, key,
                                 in_quotes(entry_.text(key, kMeaningElsewhere)), rule));
  }

  Expression read_formula(const char* key) {
    try {
      return em::parse_expression(entry_.text(key, "a formula"));
    } catch (const em::FormulaError& e) {
      const std::string near = suggestion(e.unknown, e.known);
      fail(key, e.what() + (near.empty() && !e.known.empty() ? fmt::format("; there are {}", fmt::join(e.known, ", "))
                                                             : near));
    }
  }

  void check_keys() {
    if (!f_.azimuth.empty() && !f_.lateral.empty()) fail("lateral", "not together with azimuth");
    for (const char* key : {"vertical_north", "vertical_east"})
      if (entry_.has(key) && !f_.lateral.empty()) fail(key, "not together with lateral, which needs none");
    if (f_.kind == em::Kind::continuous) {
      entry_.require(!f_.azimuth.empty(), "azimuth", "a continuous function is a sum of azimuths");
      for (const char* key : {"depth", "inclination", "lateral", "vertical_north", "vertical_east"})
        if (entry_.has(key)) fail(key, "a continuous function may define only `azimuth`");
      return;
    }
    for (const auto& [key, formula] : f_.formulas())
      for (const Variable v : {Variable::previous, Variable::running_speed})
        if (formula->names(v))
          fail(key, fmt::format("{} belongs to functions of kind \"continuous\"", em::variable_name(v)));
  }

  void check_dimensions() {
    for (const auto& [key, formula] : f_.formulas()) {
      try {
        em::dimension_of(*formula);
      } catch (const em::FormulaError& e) {
        fail(key, e.what());
      }
    }
    try {
      f_.magnitude = em::magnitude_dimension(f_);
    } catch (const em::FormulaError& e) {
      fail(f_.formulas().front().first, e.what());
    }
  }

  ConfigReader& entry_;
  em::Function f_;
};

void read_functions_into(ConfigReader& document, const std::string& file, FunctionTable& out) {
  for (ConfigReader& entry : document.tables("function", "functions of this file")) {
    em::Function f = FunctionEntry(entry).read();
    f.file = file;
    const std::string name = f.name;
    entry.require(out.emplace(name, std::make_shared<const em::Function>(std::move(f))).second, "name",
                  "two functions have this name");
  }
}

// -------------------------------------------------------------------------------------------------------------- models

/// What a model says about itself: the keys, and where each is kept.
constexpr std::array<std::pair<const char*, std::string em::Model::*>, 7> kTexts{{{"title", &em::Model::title},
                                                                                  {"source", &em::Model::source},
                                                                                  {"prefix", &em::Model::prefix},
                                                                                  {"revision", &em::Model::revision},
                                                                                  {"date", &em::Model::date},
                                                                                  {"tool", &em::Model::tool},
                                                                                  {"note", &em::Model::note}}};

/// The models of one document, read with what they extend.
class ModelFile {
 public:
  ModelFile(ConfigReader document, std::string catalogue)
      : document_(std::move(document)), catalogue_(std::move(catalogue)) {}

  std::vector<SharedModel> read() {
    if (document_.has("functions")) {
      ConfigReader file = document_.toml("functions", "a file of functions, relative to this one");
      read_functions_into(file, document_.text("functions", kMeaningElsewhere), in_file_of_functions_);
      file.finish();
    }
    read_functions_into(document_, catalogue_, own_);
    if (!document_.has("model")) {
      std::vector<SharedModel> only{read_single()};
      warn_of_unused(only);
      return only;
    }
    for (ConfigReader& entry : document_.tables("model", "models of this file")) {
      const std::string name = entry.text("name", "name of the model, once in the file");
      entry.require(!name.empty(), "name", "must not be empty");
      const bool is_new =
          std::none_of(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.name == name; });
      entry.require(is_new, "name", "two models have this name");
      entries_.push_back({name, entry, nullptr, false});
    }
    std::vector<SharedModel> out;
    for (Entry& e : entries_) out.push_back(resolved(e));
    document_.finish();
    warn_of_unused(out);
    return out;
  }

 private:
  struct Entry {
    std::string name;
    ConfigReader reader;
    SharedModel model;
    bool is_being_read;
  };

  /// A file that is one model and has no [[model]].
  SharedModel read_single() {
    auto model = std::make_shared<em::Model>();
    model->name = model->catalogue = catalogue_;
    model->title = document_.text("title", "title, for tables", "");
    model->source = document_.text("source", "where the model is from, for tables", "");
    model->first_leg_doubled =
        document_.choice("first_leg", {"once", "doubled"},
                         "how the first leg counts: 'once', or 'doubled' as ISCWSA does") == "doubled";
    document_.require(document_.has("terms"), "terms", "missing");
    read_terms(document_, *model);
    document_.finish();
    check_gyro_terms(document_, *model);
    return model;
  }

  SharedModel resolved(Entry& e) {
    if (e.model) return e.model;
    e.reader.require(!e.is_being_read, "extends", "the models extend each other in a circle");
    e.is_being_read = true;
    auto model = std::make_shared<em::Model>();
    const bool extends = e.reader.has("extends");
    if (extends) *model = *base_of(e);
    model->name = e.name;
    model->catalogue = catalogue_;
    read_settings(e.reader, *model, extends);
    if (e.reader.has("remove")) remove_terms(e.reader, *model, extends);
    e.reader.require(extends || e.reader.has("terms"), "terms", "missing (a tool without errors has terms = [])");
    read_terms(e.reader, *model);
    use_own_functions(e.reader, *model);
    check_parameters(e.reader, *model);
    check_gyro_terms(e.reader, *model);
    e.model = model;
    e.is_being_read = false;
    return e.model;
  }

  /// Of this file, or shipped.
  SharedModel base_of(Entry& e) {
    const std::string name = e.reader.text("extends", "the model whose terms and settings are taken over");
    for (Entry& other : entries_)
      if (other.name == name) return resolved(other);
    const ShippedModel* shipped = find_shipped_model(name);
    if (shipped == nullptr)
      e.reader.fail("extends",
                    fmt::format("no model of this file, and none that is shipped: {}", shipped_model_suggestion(name)));
    return read_shipped_model(e.reader, "extends", *shipped);
  }

  /// A formula that was written for nothing: the term that should name it may name another. A file of functions is for
  /// many models.
  void warn_of_unused(const std::vector<SharedModel>& models) {
    for (ConfigReader& entry : document_.tables("function", kMeaningElsewhere)) {
      const auto& function = own_.at(entry.text("name", kMeaningElsewhere));
      const bool is_used = std::any_of(models.begin(), models.end(), [&](const SharedModel& m) {
        return std::any_of(m->terms.begin(), m->terms.end(), [&](const em::Term& t) { return t.function == function; });
      });
      if (!is_used)
        entry.warn("name", "no term of this file has this function: its formulas do nothing",
                   "does a term name another?");
    }
  }

  static void read_settings(ConfigReader& r, em::Model& m, bool extends) {
    for (const auto& [key, text] : kTexts)
      if (r.has(key)) m.*text = r.text(key, "text for tables; a note is a row of `validity`");
    if (r.has("first_leg") || !extends)
      m.first_leg_doubled = r.choice("first_leg", {"once", "doubled"}, kMeaningElsewhere) == "doubled";
    if (r.has("inclination_range_deg")) {
      const auto range = r.numbers("inclination_range_deg", Range::closed(0, 180), "where the model holds", 2);
      r.require(range[0] <= range[1], "inclination_range_deg", "must be [from, to] with from <= to");
      m.inclination_min = range[0] * kDegree;
      m.inclination_max = range[1] * kDegree;
    }
    if (r.has("east_west_exclusion_deg"))
      m.east_west_exclusion =
          r.number("east_west_exclusion_deg", Range::closed(0, 90),
                   "the model does not hold within this angle of horizontal magnetic east and west") *
          kDegree;
    if (r.has("parameters.MinCourseLength_m"))
      m.parameters.min_course_length =
          r.number("parameters.MinCourseLength_m", Range::non_negative(), "least course length in formulas");
    if (r.has("parameters.XCLTortuosity_deg_per_100ft"))
      m.parameters.tortuosity = r.number("parameters.XCLTortuosity_deg_per_100ft", Range::non_negative(),
                                         "tortuosity in formulas of cross-course length") *
                                kDegree / (100 * kFoot);
    if (r.has("parameters.NoiseReductionFactor"))
      m.parameters.noise_reduction =
          r.number("parameters.NoiseReductionFactor", Range::non_negative(), "factor in formulas of gyros");
    if (r.has("gyro")) m.gyro = read_gyro(r);
  }

  static em::Gyro read_gyro(ConfigReader& r) {
    em::Gyro gyro;
    if (r.is_text("gyro.initialise_at_deg"))
      r.choice("gyro.initialise_at_deg", {"leg start"},
               "inclination at which stationary terms keep their values, or 'leg start'");
    else
      gyro.initialise_at = r.number("gyro.initialise_at_deg", Range{0, 180, true, false}, kMeaningElsewhere) * kDegree;
    for (ConfigReader& zone : r.tables("gyro.zones", "zones of a gyro")) {
      em::GyroZone z;
      z.axis = zone.choice("axis", {"XY", "Z", "XYZ"}, "axes that the gyro has in the zone");
      z.from = zone.number("from_deg", Range::closed(0, 180), "the zone begins at this inclination") * kDegree;
      z.to = zone.number("to_deg", Range::closed(0, 180), "the zone ends below this inclination") * kDegree;
      zone.require(z.from < z.to, "to_deg", "must be larger than from_deg");
      z.speed = zone.number("speed_m_per_h", Range::positive(), "running speed in the zone") / 3600;
      for (const em::GyroZone& other : gyro.zones)
        zone.require(z.speed == other.speed || z.from >= other.to || z.to <= other.from, "speed_m_per_h",
                     "zones that overlap must have one speed");
      gyro.zones.push_back(z);
    }
    return gyro;
  }

  static void remove_terms(ConfigReader& r, em::Model& m, bool extends) {
    r.require(extends, "remove", "there is nothing to remove from: only with extends");
    for (const std::string& code : r.texts("remove", "codes of terms of the extended model that are left out")) {
      const auto at = std::find_if(m.terms.begin(), m.terms.end(), [&](const em::Term& t) { return t.code == code; });
      r.require(at != m.terms.end(), "remove",
                fmt::format("the model that is extended has no term {}", in_quotes(code)));
      m.terms.erase(at);
    }
  }

  /// Terms of the same code are replaced, others are added.
  void read_terms(ConfigReader& r, em::Model& m) {
    std::set<std::string> codes;
    for (ConfigReader& entry :
         r.tables("terms", "terms of the model; with `extends` they replace those of the same code, or are added")) {
      em::Term term = read_term(entry);
      entry.require(codes.insert(term.code).second, "code", "two terms have this code");
      const auto same =
          std::find_if(m.terms.begin(), m.terms.end(), [&](const em::Term& t) { return t.code == term.code; });
      if (same != m.terms.end())
        *same = std::move(term);
      else
        m.terms.push_back(std::move(term));
    }
  }

  em::Term read_term(ConfigReader& entry) {
    em::Term term;
    term.code = entry.text("code", "code of the term, once in the model");
    entry.require(!term.code.empty(), "code", "must not be empty");
    term.function = function_named(entry);
    term.magnitude = entry.number("magnitude", Range::non_negative(), "one standard deviation, in `unit`");
    term.unit = entry.text("unit", "unit of the magnitude");
    const double factor = em::unit_factor(term.function->magnitude, term.unit);
    if (factor == 0)
      entry.fail("unit", fmt::format("the unit of {} must be {}", term.function->name,
                                     em::unit_names(term.function->magnitude)));
    term.sigma = factor * term.magnitude;
    const std::string mode =
        entry.choice("mode", {"R", "S", "W", "G"},
                     "how errors repeat: 'R' at each station anew, 'S' in a run, 'W' in a well, 'G' in all wells");
    using enum em::PropagationMode;
    for (const em::PropagationMode m : {random, systematic, well, global})
      if (em::mode_letter(m) == mode[0]) term.mode = m;
    return term;
  }

  /// A name means one function in all of a file: terms that were inherited act by this file's functions, too.
  void use_own_functions(ConfigReader& r, em::Model& m) {
    for (em::Term& term : m.terms) {
      const auto f = find_function(term.function->name, {&own_, &in_file_of_functions_});
      if (f == nullptr || f == term.function) continue;
      const double factor = em::unit_factor(f->magnitude, term.unit);
      r.require(factor != 0, "extends",
                fmt::format("its term {} has the unit {}, but that of {} in this file must be {}: give the function "
                            "another name, or the term anew",
                            term.code, term.unit, in_quotes(f->name), em::unit_names(f->magnitude)));
      term.function = f;
      term.sigma = factor * term.magnitude;
    }
  }

  /// Of the first table that has it; nothing if none has.
  static std::shared_ptr<const em::Function> find_function(const std::string& name,
                                                           const std::vector<const FunctionTable*>& tables) {
    for (const FunctionTable* table : tables)
      if (const auto at = table->find(name); at != table->end()) return at->second;
    return nullptr;
  }

  std::shared_ptr<const em::Function> function_named(ConfigReader& entry) {
    const std::string name = entry.text("function", "name of the weighting function");
    const std::vector<const FunctionTable*> tables{&own_, &in_file_of_functions_, &shipped_functions()};
    if (const auto f = find_function(name, tables)) return f;
    std::vector<std::string> names;
    for (const FunctionTable* table : tables)
      for (const auto& [other, f] : *table) names.push_back(other);
    std::string list;
    for (const std::string& other : names) list += (list.empty() ? "" : ", ") + in_quotes(other);
    const std::string near = suggestion(name, names);
    entry.fail("function", near.empty() ? "must be one of " + list : "unknown function" + near);
  }

  /// A parameter that the table itself gives, and no formula needs.
  static void check_parameters(ConfigReader& r, const em::Model& m) {
    for (const auto& [key, variable] : {std::pair{"MinCourseLength_m", Variable::min_course_length},
                                        std::pair{"XCLTortuosity_deg_per_100ft", Variable::tortuosity},
                                        std::pair{"NoiseReductionFactor", Variable::noise_reduction}})
      if (const std::string full = std::string("parameters.") + key; r.has(full))
        r.require(m.names(variable), full,
                  fmt::format("no formula of this model has {}: leave it out", em::variable_name(variable)));
  }

  static void check_gyro_terms(ConfigReader& r, const em::Model& m) {
    for (const em::Term& term : m.terms) {
      if (term.function->kind != em::Kind::continuous) continue;
      r.require(m.gyro.has_value(), "terms",
                fmt::format("term {}: {} is continuous: the model must have gyro = {{ initialise_at_deg, zones }}",
                            term.code, term.function->name));
      const auto& zones = m.gyro->zones;
      r.require(
          std::any_of(zones.begin(), zones.end(), [&](const em::GyroZone& z) { return z.axis == term.function->axis; }),
          "gyro",
          fmt::format("term {}: {} needs a zone of axis {}", term.code, term.function->name,
                      in_quotes(term.function->axis)));
    }
  }

  ConfigReader document_;
  std::string catalogue_;
  FunctionTable own_, in_file_of_functions_;
  std::vector<Entry> entries_;
};

}  // namespace

FunctionTable read_functions(ConfigReader document) {
  FunctionTable out;
  read_functions_into(document, "functions.toml", out);
  document.finish();
  return out;
}

std::vector<SharedModel> read_error_models(ConfigReader document, const std::string& catalogue) {
  return ModelFile(std::move(document), catalogue).read();
}

SharedModel read_shipped_model(ConfigReader& config, const std::string& key, const ShippedModel& shipped) {
  // All texts that the model is made of are inputs of the config. A result that another version of the program has made
  // may have others.
  bool are_own = true;
  for (const ShippedModel* m = &shipped; m != nullptr;
       m = m->extends.empty() ? nullptr : find_shipped_model(m->extends)) {
    const InputText document = shipped_document(*m);
    are_own = are_own && config.file_text(key, document).text == document.text;
  }
  if (are_own) return load_shipped_model(shipped);
  return read_error_models(config.toml(key, shipped_document(shipped)), shipped.catalogue).back();
}

SharedModel load_shipped_model(const ShippedModel& shipped) {
  // What a name stands for never changes: the text is parsed when the model is first named.
  static std::mutex mutex;
  static std::map<const ShippedModel*, SharedModel> loaded;
  {
    const std::lock_guard lock(mutex);
    if (const auto at = loaded.find(&shipped); at != loaded.end()) return at->second;
  }
  std::vector<InputText> documents;
  for (const ShippedModel* m = &shipped; m != nullptr;
       m = m->extends.empty() ? nullptr : find_shipped_model(m->extends))
    documents.push_back(shipped_document(*m));
  Config config = Config::from_text("experiment = \"shipped model\"\nmodel = \"name\"\n", "model", {}, documents);
  SharedModel model = read_error_models(config.reader(0).toml("model", documents.front()), shipped.catalogue).back();
  const std::lock_guard lock(mutex);
  return loaded.emplace(&shipped, std::move(model)).first->second;
}

// ------------------------------------------------------------------------------------------------------------- writing

std::string model_text(const em::Model& m) {
  std::string out;
  std::set<const em::Function*> written;
  for (const em::Term& term : m.terms) {
    const em::Function& f = *term.function;
    if (!written.insert(&f).second) continue;
    out += fmt::format("[[function]]\nname = {}\n", in_quotes(f.name));
    if (f.kind != em::Kind::station) out += fmt::format("kind = {}\n", in_quotes(em::kind_name(f.kind)));
    if (!f.axis.empty()) out += fmt::format("axis = {}\n", in_quotes(f.axis));
    if (f.per_section) out += "per_section = true\n";
    for (const auto& [key, formula] : f.formulas()) out += fmt::format("{} = {}\n", key, in_quotes(formula->text));
    out += '\n';
  }
  out += fmt::format("[[model]]\nname = {}\n", in_quotes(m.name));
  for (const auto& [key, text] : kTexts)
    if (!(m.*text).empty()) out += fmt::format("{} = {}\n", key, in_quotes(m.*text));
  const auto degrees = [](double x) { return format_number(std::round(x / kDegree * 1e9) / 1e9); };
  out += fmt::format("first_leg = \"{}\"\n", m.first_leg_doubled ? "doubled" : "once");
  out += fmt::format("inclination_range_deg = [{}, {}]\n", degrees(m.inclination_min), degrees(m.inclination_max));
  if (m.east_west_exclusion > 0) out += fmt::format("east_west_exclusion_deg = {}\n", degrees(m.east_west_exclusion));
  std::string parameters;
  const auto parameter = [&](Variable v, const char* key, double x) {
    if (m.names(v))
      parameters +=
          fmt::format("{}{} = {}", parameters.empty() ? "" : ", ", key, format_number(std::round(x * 1e12) / 1e12));
  };
  parameter(Variable::min_course_length, "MinCourseLength_m", m.parameters.min_course_length);
  parameter(Variable::tortuosity, "XCLTortuosity_deg_per_100ft", m.parameters.tortuosity * 100 * kFoot / kDegree);
  parameter(Variable::noise_reduction, "NoiseReductionFactor", m.parameters.noise_reduction);
  if (!parameters.empty()) out += fmt::format("parameters = {{ {} }}\n", parameters);
  if (m.gyro) {
    std::string zones;
    for (const em::GyroZone& z : m.gyro->zones)
      zones += fmt::format("{}{{ axis = {}, from_deg = {}, to_deg = {}, speed_m_per_h = {} }}",
                           zones.empty() ? "" : ", ", in_quotes(z.axis), degrees(z.from), degrees(z.to),
                           format_number(std::round(z.speed * 3600 * 1e9) / 1e9));
    out += fmt::format("gyro = {{ initialise_at_deg = {}, zones = [{}{}{}] }}\n",
                       m.gyro->initialise_at ? degrees(*m.gyro->initialise_at) : "\"leg start\"",
                       zones.empty() ? "" : " ", zones, zones.empty() ? "" : " ");
  }
  out += "terms = [\n";
  for (const em::Term& t : m.terms)
    out += fmt::format("  {{ code = {}, function = {}, magnitude = {}, unit = {}, mode = \"{}\" }},\n",
                       in_quotes(t.code), in_quotes(t.function->name), format_number(t.magnitude), in_quotes(t.unit),
                       em::mode_letter(t.mode));
  return out + "]\n";
}

}  // namespace surveymc::config
