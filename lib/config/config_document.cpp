#include "config/config_document.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/input_path.h"
#include "base/retry.h"
#include "config/next_round.h"
#include "config/sensitivity_rule.h"
#include "config/suggest.h"
#include "config/text.h"
#include "config/toml_tree.h"

namespace surveymc::config {

namespace fs = std::filesystem;

FileText read_file(const fs::path& path, std::uint64_t most, const std::string& way_out) {
  const auto failed = [](const std::string& fault) { return FileText{"", fault}; };
  const auto reason = [] { return std::generic_category().message(errno); };
  if (const std::string fault = input_fault(path, most, way_out); !fault.empty()) return failed(fault);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      uninterrupted([&] { return std::fopen(path.c_str(), "rb"); }), &std::fclose);
  if (!file) return failed(reason());
  FileText out;
  char buffer[1 << 16];
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, file.get())) out.text.append(buffer, n);
  if (std::ferror(file.get())) out.fault = reason();
  return out;
}

// ---------------------------------------------------------------------------------------------------------- building

namespace {

const TomlNode& required(const ConfigDocument& doc, const std::string& key) {
  if (const TomlNode* n = doc.base.entry(key)) return *n;
  for (const auto& [k, v] : doc.base.entries) {  // the trap of TOML: below a [header], a key belongs to that table
    if (const TomlNode* n = v.entry(key))
      refuse(n->place, key, fmt::format("missing (found {}.{}: write it above the first [table])", k, key));
  }
  for (const auto& [k, v] : doc.base.entries) {
    if (resembles(k, key)) refuse(v.place, key, fmt::format("missing (found {})", k));
  }
  refuse(doc.label, key, "missing");
}

void apply_override(ConfigDocument& doc, const std::string& argument) {
  const std::string place = "--set " + argument;
  const auto equals = argument.find('=');
  require(equals != std::string::npos, "{}: must be KEY=VALUE", place);
  std::string_view name = trimmed(std::string_view(argument).substr(0, equals));
  if (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  require(!name.empty(), "{}: the key is missing: must be KEY=VALUE", place);
  const auto key = clean_key(name);
  require(key.has_value(), "{}: {}", shortened(place), no_key_rule(name));
  const std::string value_text(trimmed(std::string_view(argument).substr(equals + 1)));
  const TomlNode value = parse_value(value_text, *key, place);

  if (*key == "sweep" || (*key + ".").starts_with("sweep.case.")) {
    refuse(place, *key, "cannot be set here: set sweep.KEY=[...] for one key");
  }
  if (key->starts_with("sweep.")) {
    doc.sweep.set_list(key->substr(6), value);
  } else {
    doc.sweep.fix(*key, value);
    assign(doc.base, *key, value);
  }
}

}  // namespace

void ConfigDocument::build(TomlNode root, const std::vector<std::string>& overrides) {
  base = std::move(root);
  if (const auto swept = base.entries.extract("sweep")) sweep.read(swept.mapped());
  for (const auto& o : overrides) apply_override(*this, o);
  if (auto at = base.entries.extract("refine")) {
    refine_rule(at.mapped());
    refine = std::move(at.mapped());
  }
  if (auto at = base.entries.extract("sensitivity")) {
    sensitivity_rule(at.mapped());
    sensitivity = std::move(at.mapped());
  }
  sweep.expand([this](const TomlNode& n, const std::string& key) { return file(n, key); });
  if (sensitivity && (!sweep.has_independent_keys() || sweep.point_count() < 20))
    refuse(sensitivity->place, "sensitivity",
           "needs a sweep of at least 20 points whose keys vary independently: a product, latin_hypercube or sobol");

  const TomlNode& experiment = required(*this, "experiment");
  if (!experiment.is_text()) refuse_kind(experiment, "experiment", "must be a string");
  if (experiment.text.empty()) refuse(experiment, "experiment", "must not be empty");
  if (const TomlNode* seed = base.entry("seed")) {
    if (seed->kind != TomlNode::Kind::integer) refuse_kind(*seed, "seed", "must be an integer");
    if (seed->integer < 0) refuse(*seed, "seed", "must be in [0, 9223372036854775807]");
  }
  if (const TomlNode* title = base.entry("title"); title && !title->is_text()) {
    refuse_kind(*title, "title", "must be a string");
  }
}

std::uint64_t ConfigDocument::seed() const { return static_cast<std::uint64_t>(required(*this, "seed").integer); }

// ----------------------------------------------------------------------------------------------------------- reading

void ConfigDocument::require_point(std::size_t point) const {
  const std::size_t count = sweep.point_count();
  require(point < count, "{}: point {}: must be in [0, {}]", label, point, count - 1);
}

TomlNode ConfigDocument::point_root(std::size_t point) const {
  require_point(point);
  TomlNode root = base;
  sweep.apply(root, point);
  if (log) {
    log->asked.clear();
    log->denied.clear();
    log->missing = log->refused = log->with_default = "";
    apply_suppositions(*log, root);
  }
  return root;
}

/// Equal without being written as text: most defaults are.
static bool has_same_scalar(const TomlNode& a, const TomlNode& b) {
  using Kind = TomlNode::Kind;
  if (a.kind != b.kind) return false;
  return (a.kind == Kind::real && a.real == b.real && std::signbit(a.real) == std::signbit(b.real)) ||
         (a.kind == Kind::integer && a.integer == b.integer) || (a.kind == Kind::boolean && a.flag == b.flag) ||
         (a.kind == Kind::text && a.text == b.text);
}

void ConfigDocument::use_default(const std::string& key, const TomlNode& value, std::size_t point) {
  const std::scoped_lock lock(showing);
  const auto [it, is_new] = defaults.try_emplace(key);
  UsedDefault& d = it->second;
  if (is_new) d.value = value;
  d.is_alike = d.is_alike && (has_same_scalar(d.value, value) || toml_text(d.value) == toml_text(value));
  d.points.add(point);
}

namespace {

/// What is known of the file `name` that `n` stands for, from this run or from the result; null if it has to be read.
template <class T>
const T* known_file(const TomlNode& n, const std::string& key, const std::string& name, std::map<std::string, T>& read,
                    const std::map<std::string, T>& stored, bool is_from_result) {
  if (!n.is_text()) refuse_kind(n, key, "must be a string: the name of a file");
  if (name.empty()) refuse(n, key, "must name a file");
  if (const auto it = read.find(name); it != read.end()) return &it->second;
  if (!is_from_result) return nullptr;
  const auto it = stored.find(name);
  if (it == stored.end()) refuse(n, key, "is not among the files stored with this config");
  return &read.emplace(*it).first->second;
}

std::string bytes_of(const ConfigDocument& doc, const TomlNode& n, const std::string& key, std::uint64_t most,
                     const std::string& way_out) {
  if (n.text.find('\0') != std::string::npos) refuse(n, key, "is not the name of a file");
  const fs::path path = doc.folder / n.text;  // an absolute path stays as it is
  auto [text, fault] = doc.read(path, most, way_out);
  if (!fault.empty()) refuse(n, key, fmt::format("cannot be read: {} (looked for {})", fault, path.string()));
  return text;
}

}  // namespace

FileText ConfigDocument::read(const fs::path& path, std::uint64_t most, const std::string& way_out) const {
  if (!log) return read_file(path, most, way_out);
  std::optional<std::string> text = shipped_text(path);
  return text ? FileText{std::move(*text), ""} : FileText{"", "does not come with the program"};
}

const InputTable& ConfigDocument::input(const TomlNode& n, const std::string& key) {
  const std::scoped_lock lock(showing);
  if (const auto* known = known_file(n, key, n.text, inputs, stored_files, is_from_result)) return *known;
  return inputs.emplace(n.text, parse_csv(bytes_of(*this, n, key, kLargestTable, kSmallerTable), n.text)).first->second;
}

const InputTable& ConfigDocument::table(const TomlNode& n, const std::string& key,
                                        const std::function<InputTable(const fs::path&)>& load,
                                        const std::string& reading) {
  const std::scoped_lock lock(showing);
  if (const auto it = readings.find(n.text); n.is_text() && it != readings.end() && it->second != reading)
    refuse(n, key,
           fmt::format("is read in two ways ({}; {}): a result stores a file once: copy it under another name",
                       it->second.empty() ? "as it is" : it->second, reading.empty() ? "as it is" : reading));
  if (const auto* known = known_file(n, key, n.text, inputs, stored_files, is_from_result)) return *known;
  if (log) return input(n, key);  // files that come with the program are CSV
  try {
    InputTable table = load(folder / n.text);
    table.path = n.text;
    readings.emplace(n.text, reading);
    return inputs.emplace(n.text, std::move(table)).first->second;
  } catch (const IoError& e) {
    refuse(n, key, e.what());
  }
}

InputText ConfigDocument::text(const TomlNode& n, const std::string& key, const InputText* shipped) {
  if (parent) {
    TomlNode beside = n;
    if (!shipped && n.is_text() && !n.text.empty())
      beside.text = (fs::path(label).parent_path() / n.text).lexically_normal().string();
    return parent->text(beside, key, shipped);
  }
  const std::scoped_lock lock(showing);
  if (shipped) {  // `n` may be a list that chose several
    TomlNode name = n;
    name.kind = TomlNode::Kind::text;
    if (const auto* known = known_file(name, key, shipped->path, texts, stored_texts, is_from_result))
      return {shipped->path, *known};
    return {shipped->path, texts.emplace(shipped->path, shipped->text).first->second};
  }
  if (const auto* known = known_file(n, key, n.text, texts, stored_texts, is_from_result)) return {n.text, *known};
  return {n.text, texts.emplace(n.text, bytes_of(*this, n, key, kLargestDocument, "give only what the config needs"))
                      .first->second};
}

InputFile ConfigDocument::file(const TomlNode& n, const std::string& key) {
  const auto held = [&] {
    InputText t = text(n, key, nullptr);
    const std::uint64_t size = t.text.size();
    return InputFile{t.path, std::make_shared<const std::string>(std::move(t.text)), {}, size};
  };
  if (log || !n.is_text() || n.text.empty() || n.text.find('\0') != std::string::npos)
    return held();  // which refuses it
  const fs::path place = folder / n.text;
  const std::scoped_lock lock(showing);
  if (const auto it = references.find(n.text); it != references.end())
    return {n.text, nullptr, place, it->second.size, it->second.hash};
  const auto stored = stored_references.find(n.text);
  if (is_from_result && stored == stored_references.end()) return held();
  std::error_code error;
  const bool is_file = fs::is_regular_file(place, error);
  if (is_from_result) {
    const InputReference& was = stored->second;
    const std::string what = fmt::format("is not stored with this config ({} bytes, hash {})", was.size, was.hash);
    if (!is_file)
      refuse(n, key,
             fmt::format("{}: it is not at {}: name the folder of the config with --inputs", what, place.string()));
    try {
      const InputReference now = describe_file(n.text, place);
      if (now.hash != was.hash || now.size != was.size)
        refuse(n, key,
               fmt::format("{}: the file at {} is another one ({} bytes, hash {})", what, place.string(), now.size,
                           now.hash));
    } catch (const IoError& e) {
      refuse(n, key, fmt::format("{}: cannot be read: {}", what, e.what()));
    }
    if (was.size <= kLargestStoredFile) {  // of a part, which leaves the table of points to the folder of the config
      const FileText read = read_file(place, kLargestStoredFile, kSmallerTable);
      if (!read.fault.empty()) refuse(n, key, fmt::format("{}: cannot be read: {}", what, read.fault));
      texts.emplace(n.text, read.text);
      return {n.text, std::make_shared<const std::string>(read.text), {}, was.size};
    }
    references.emplace(*stored);
    return {n.text, nullptr, place, was.size, was.hash};
  }
  if (!is_file || fs::file_size(place, error) <= kLargestStoredFile) return held();
  try {
    const InputReference r = describe_file(n.text, place);
    references.emplace(n.text, r);
    return {n.text, nullptr, place, r.size, r.hash};
  } catch (const IoError& e) {
    refuse(n, key, fmt::format("cannot be read: {}", e.what()));
  }
}

/// What a remark says, wherever its key stands.
static std::string saying(const Remark& r) {
  return fmt::format("{}\n{}\n{}\n{}", r.place, r.value, r.message, r.way_out);
}

void ConfigDocument::remark(std::size_t point, Remark remark) {
  if (parent) return parent->remark(point, std::move(remark));  // of a file that the config names
  const std::scoped_lock lock(showing);
  PointSet& points = remarked[saying(remark)];
  const std::size_t first = points.empty() ? point + 1 : points.ranges().begin()->first;
  points.add(point);
  if (first <= point) return;
  if (first != point + 1)
    std::erase_if(remarks, [&](const Remark& r) { return r.point == first && saying(r) == saying(remark); });
  remark.point = point;
  const auto behind = std::upper_bound(remarks.begin(), remarks.end(), point,
                                       [](std::size_t p, const Remark& r) { return p < r.point; });
  remarks.insert(behind, std::move(remark));
}

std::vector<Remark> Config::remarks() const {
  const std::scoped_lock lock(doc_->showing);
  std::vector<Remark> out = doc_->remarks;
  for (Remark& r : out) r.points = doc_->remarked.at(saying(r)).count();
  return out;
}

// ---------------------------------------------------------------------------------------------------------- resolved

namespace {

/// Both spellings of a table's name become one.
void write_names_into_tables(TomlNode& root, const std::set<std::string>& named) {
  for (const auto& key : named) {
    const TomlNode* at = &root;
    for (const auto& part : split_key(key)) at = at && at->is_table() ? at->entry(part) : nullptr;
    if (at && at->is_text()) assign(root, key + ".name", TomlNode(*at));
  }
}

/// True if writing the default changes nothing for any point that reads the text back.
bool belongs_into_text(const ConfigDocument& doc, const std::string& key, const UsedDefault& d) {
  const bool everywhere = d.points.covers(0, doc.sweep.point_count());
  if (!d.is_alike || !everywhere || doc.sweep.varies(key)) return false;
  // Neither the key, nor its name, nor a table that it is in: looked up one by one, as a config may have 10,000 tables.
  const auto is_absent = [&](const std::string& k) { return doc.known_absent.contains(k); };
  if (is_absent(key) || is_absent(key + ".name")) return false;
  for (std::size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', dot + 1))
    if (is_absent(key.substr(0, dot))) return false;
  return true;
}

}  // namespace

std::string ConfigDocument::resolved_text() const {
  TomlNode root = base;
  write_names_into_tables(root, named);
  if (!is_later_round())
    for (const auto& [key, d] : defaults)
      if (belongs_into_text(*this, key, d)) assign_default(root, key, d.value);
  return text_with_refine(std::move(root)) + sweep.toml();
}

bool ConfigDocument::is_later_round() const { return refine && refine->entry("grid"); }

std::string ConfigDocument::text_with_refine(TomlNode root) const {
  if (refine) root.entries["refine"] = *refine;
  if (sensitivity) root.entries["sensitivity"] = *sensitivity;
  return toml_document(root);
}

}  // namespace surveymc::config
