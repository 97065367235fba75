#include "config/config.h"

#include <algorithm>
#include <bit>
#include <sstream>

#define XXH_INLINE_ALL
#include <fmt/ranges.h>
#include <xxhash.h>

#include "base/error.h"
#include "config/config_document.h"
#include "config/key_log.h"
#include "config/toml_tree.h"

namespace surveymc::config {

Config::Config() : doc_(std::make_shared<ConfigDocument>()) {}

Config Config::load(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  Config config;
  ConfigDocument& doc = *config.doc_;
  doc.label = path.string();
  doc.folder = path.parent_path();
  const auto [text, fault] =
      read_file(path, kLargestDocument, "a config has keys; data go to a CSV file that it names");
  require(fault.empty(), "{}: cannot be read: {}", doc.label, fault);
  doc.build(parse_document(text, doc.label), overrides);
  return config;
}

Config config_with_log(const InputText& file, std::shared_ptr<KeyLog> log) {
  Config config;
  ConfigDocument& doc = *config.doc_;
  doc.label = file.path;
  doc.folder = std::filesystem::path(file.path).parent_path();
  doc.log = std::move(log);
  doc.build(parse_document(file.text, doc.label), {});
  return config;
}

static std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Config Config::from_text(const std::string& text, const std::string& label, std::vector<InputTable> files,
                         std::vector<InputText> texts, std::vector<InputReference> references,
                         const std::filesystem::path& folder) {
  Config config;
  ConfigDocument& doc = *config.doc_;
  doc.label = label;
  doc.is_from_result = true;
  doc.folder = folder;
  for (auto& f : files) {
    std::string path = f.path;
    doc.stored_files.emplace(std::move(path), std::move(f));
  }
  for (auto& t : texts) {
    const std::string of =
        t.path.ends_with(kDoubtsSuffix) ? t.path.substr(0, t.path.size() - kDoubtsSuffix.size()) : "";
    if (const auto table = doc.stored_files.find(of); table != doc.stored_files.end())
      table->second.doubts = lines_of(t.text);
    else
      doc.stored_texts.emplace(std::move(t.path), std::move(t.text));
  }
  for (auto& r : references) {
    std::string path = r.path;
    doc.stored_references.emplace(std::move(path), std::move(r));
  }
  doc.build(parse_document(text, label), {});
  return config;
}

std::string Config::experiment() const { return doc_->base.entry("experiment")->text; }

bool Config::has_seed() const { return doc_->base.entry("seed") != nullptr; }

std::uint64_t Config::seed() const { return doc_->seed(); }

std::string Config::title() const {
  const TomlNode* n = doc_->base.entry("title");
  return n ? n->text : "";
}

std::size_t Config::point_count() const { return doc_->sweep.point_count(); }

std::vector<SweepValue> Config::sweep_values(std::size_t point) const {
  doc_->require_point(point);
  return doc_->sweep.values(point);
}

ConfigReader Config::reader(std::size_t point) { return ConfigReader::of_point(doc_, point, doc_->point_root(point)); }

void Config::fail(const std::string& key, const std::string& rule) const {
  ConfigReader::of_point(doc_, 0, doc_->base).fail(key, rule);
}

std::string Config::resolved_text() const { return doc_->resolved_text(); }

std::vector<InputTable> Config::inputs() const {
  std::vector<InputTable> out;
  for (const auto& [path, table] : doc_->inputs) out.push_back(table);
  return out;
}

std::vector<InputText> Config::input_texts() const {
  std::vector<InputText> out;
  for (const auto& [path, text] : doc_->texts) out.push_back({path, text});
  for (const auto& [path, table] : doc_->inputs)
    if (!table.doubts.empty()) out.push_back({path + kDoubtsSuffix, fmt::format("{}", fmt::join(table.doubts, "\n"))});
  std::sort(out.begin(), out.end(), [](const InputText& a, const InputText& b) { return a.path < b.path; });
  return out;
}

std::vector<InputReference> Config::input_references() const {
  std::vector<InputReference> out;
  for (const auto& [path, reference] : doc_->references) out.push_back(reference);
  return out;
}

bool Config::is_product() const { return doc_->sweep.is_product(); }

std::optional<std::vector<SweepDimension>> Config::sweep_product() const {
  const Sweep& sweep = doc_->sweep;
  if (!sweep.is_product()) return std::nullopt;
  return sweep.dimensions();
}

std::vector<std::size_t> Config::sample_points() const {
  constexpr std::size_t kMostOfAxis = 1000, kRandom = 1000;
  return doc_->sweep.sample(kMostOfAxis, kRandom);
}

void Config::check_sweep(const std::function<void()>& between) const { doc_->sweep.check_table(between); }

std::string Config::sweep_file() const { return doc_->sweep.table_file(); }

std::string Config::source_text() const { return doc_->text_with_refine(doc_->base) + doc_->sweep.toml(); }

namespace {

/// Hash of a config's text and files. Lengths stand before contents, so that no two different inputs give the same
/// bytes.
class ConfigHash {
 public:
  explicit ConfigHash(const std::string& text) {
    XXH3_128bits_reset(&state_);
    add(text);
  }
  ConfigHash& add_files(const ConfigDocument& doc, const std::string& only = "") {
    for (const auto& [path, table] : doc.inputs) {
      if (!only.empty() && path != only) continue;
      add(path);
      add(table.names.size());
      for (std::size_t j = 0; j < table.names.size(); ++j) {
        add(table.names[j]);
        add(table.columns[j].size());
        XXH3_128bits_update(&state_, table.columns[j].data(), table.columns[j].size() * sizeof(double));
      }
    }
    for (const auto& [path, text] : doc.texts) {
      if (!only.empty() && path != only) continue;
      add(path);
      add(text);
    }
    for (const auto& [path, reference] : doc.references) {
      if (!only.empty() && path != only) continue;
      add(path);
      add(reference.size);
      add(reference.hash);
    }
    return *this;
  }
  std::string hex() const {
    const XXH128_hash_t h = XXH3_128bits_digest(&state_);
    return fmt::format("{:016x}{:016x}", h.high64, h.low64);
  }

 private:
  static_assert(std::endian::native == std::endian::little, "the hash is over little-endian numbers");
  void add(const std::string& s) {
    add(s.size());
    XXH3_128bits_update(&state_, s.data(), s.size());
  }
  void add(std::size_t n) {
    const std::uint64_t x = n;
    XXH3_128bits_update(&state_, &x, sizeof x);
  }
  XXH3_state_t state_;
};

}  // namespace

std::string Config::source_hash() const {
  ConfigHash h(source_text());
  if (!sweep_file().empty()) h.add_files(*doc_, sweep_file());
  return h.hex();
}

std::string Config::hash_as_read() const { return ConfigHash(source_text()).add_files(*doc_).hex(); }

std::string Config::hash() const { return ConfigHash(resolved_text()).add_files(*doc_).hex(); }

}  // namespace surveymc::config
