#include "config/config.h"

#include <bit>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/error.h"
#include "config/config_document.h"
#include "config/key_log.h"
#include "config/reader_state.h"
#include "config/toml_tree.h"

namespace surveymc::config {

struct Config::Impl {
  std::shared_ptr<ConfigDocument> doc = std::make_shared<ConfigDocument>();
};

Config::Config(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Config::~Config() = default;
Config::Config(Config&&) noexcept = default;

Config Config::load(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  Config config(std::make_unique<Impl>());
  ConfigDocument& doc = *config.impl_->doc;
  doc.label = path.string();
  doc.folder = path.parent_path();
  const auto [text, fault] =
      read_file(path, kLargestDocument, "a config has keys; data go to a CSV file that it names");
  require(fault.empty(), "{}: cannot be read: {}", doc.label, fault);
  doc.build(parse_document(text, doc.label), overrides);
  return config;
}

Config config_with_log(const InputText& file, std::shared_ptr<KeyLog> log) {
  Config config(std::make_unique<Config::Impl>());
  ConfigDocument& doc = *config.impl_->doc;
  doc.label = file.path;
  doc.folder = std::filesystem::path(file.path).parent_path();
  doc.log = std::move(log);
  doc.build(parse_document(file.text, doc.label), {});
  return config;
}

Config Config::from_text(const std::string& text, const std::string& label, std::vector<InputTable> files,
                         std::vector<InputText> texts, std::vector<InputReference> references,
                         const std::filesystem::path& folder) {
  Config config(std::make_unique<Impl>());
  ConfigDocument& doc = *config.impl_->doc;
  doc.label = label;
  doc.is_from_result = true;
  doc.folder = folder;
  for (auto& f : files) {
    std::string path = f.path;
    doc.stored_files.emplace(std::move(path), std::move(f));
  }
  for (auto& t : texts) doc.stored_texts.emplace(std::move(t.path), std::move(t.text));
  for (auto& r : references) {
    std::string path = r.path;
    doc.stored_references.emplace(std::move(path), std::move(r));
  }
  doc.build(parse_document(text, label), {});
  return config;
}

std::string Config::experiment() const { return impl_->doc->base.entry("experiment")->text; }

bool Config::has_seed() const { return impl_->doc->base.entry("seed") != nullptr; }

std::uint64_t Config::seed() const { return impl_->doc->seed(); }

std::string Config::title() const {
  const TomlNode* n = impl_->doc->base.entry("title");
  return n ? n->text : "";
}

std::size_t Config::point_count() const { return impl_->doc->sweep.point_count(); }

std::vector<SweepValue> Config::sweep_values(std::size_t point) const {
  impl_->doc->require_point(point);
  return impl_->doc->sweep.values(point);
}

static ConfigReader reader_of(std::shared_ptr<ConfigDocument> doc, std::size_t point, TomlNode root) {
  auto p = std::make_shared<ConfigPoint>();
  p->doc = std::move(doc);
  p->index = point;
  p->root = std::move(root);
  const TomlNode* table = &p->root;
  return ConfigReader(std::make_shared<ConfigReader::State>(ConfigReader::State{std::move(p), table, ""}));
}

ConfigReader Config::reader(std::size_t point) { return reader_of(impl_->doc, point, impl_->doc->point_root(point)); }

void Config::fail(const std::string& key, const std::string& rule) const {
  reader_of(impl_->doc, 0, impl_->doc->base).fail(key, rule);
}

std::string Config::resolved_text() const { return impl_->doc->resolved_text(); }

std::vector<InputTable> Config::inputs() const {
  std::vector<InputTable> out;
  for (const auto& [path, table] : impl_->doc->inputs) out.push_back(table);
  return out;
}

std::vector<InputText> Config::input_texts() const {
  std::vector<InputText> out;
  for (const auto& [path, text] : impl_->doc->texts) out.push_back({path, text});
  return out;
}

std::vector<InputReference> Config::input_references() const {
  std::vector<InputReference> out;
  for (const auto& [path, reference] : impl_->doc->references) out.push_back(reference);
  return out;
}

const std::vector<Remark>& Config::remarks() const { return impl_->doc->remarks; }

bool Config::is_product() const { return impl_->doc->sweep.is_product(); }

std::optional<std::vector<SweepDimension>> Config::sweep_product() const {
  const Sweep& sweep = impl_->doc->sweep;
  if (!sweep.is_product()) return std::nullopt;
  return sweep.dimensions();
}

std::vector<std::size_t> Config::sample_points() const {
  constexpr std::size_t kMostOfAxis = 1000, kRandom = 1000;
  return impl_->doc->sweep.sample(kMostOfAxis, kRandom);
}

void Config::check_sweep(const std::function<void()>& between) const { impl_->doc->sweep.check_table(between); }

std::string Config::sweep_file() const { return impl_->doc->sweep.table_file(); }

std::string Config::source_text() const {
  return impl_->doc->text_with_refine(impl_->doc->base) + impl_->doc->sweep.toml();
}

namespace {

/// Hash of a config's text and files. Lengths stand before contents, so that no two different inputs give the same
/// bytes.
class ConfigHash {
 public:
  ConfigHash() { XXH3_128bits_reset(&state_); }
  void add(const std::string& s) {
    add(s.size());
    XXH3_128bits_update(&state_, s.data(), s.size());
  }
  void add_files(const ConfigDocument& doc, const std::string& only = "") {
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
  }
  std::string hex() const {
    const XXH128_hash_t h = XXH3_128bits_digest(&state_);
    return fmt::format("{:016x}{:016x}", h.high64, h.low64);
  }

 private:
  static_assert(std::endian::native == std::endian::little, "the hash is over little-endian numbers");
  void add(std::size_t n) {
    const std::uint64_t x = n;
    XXH3_128bits_update(&state_, &x, sizeof x);
  }
  XXH3_state_t state_;
};

}  // namespace

std::string Config::source_hash() const {
  ConfigHash h;
  h.add(source_text());
  if (!sweep_file().empty()) h.add_files(*impl_->doc, sweep_file());
  return h.hex();
}

std::string Config::hash_as_read() const {
  ConfigHash h;
  h.add(source_text());
  h.add_files(*impl_->doc);
  return h.hex();
}

std::string Config::hash() const {
  ConfigHash h;
  h.add(resolved_text());
  h.add_files(*impl_->doc);
  return h.hex();
}

}  // namespace surveymc::config
