#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "cli/commands.h"
#include "cli/screen.h"
#include "cli/sources.h"
#include "render/text.h"
#include "store/result_file.h"

namespace surveymc::cli {
namespace {

constexpr const char* kTitle = "surveymc: a Monte-Carlo research workbench for wellbore directional surveying";
constexpr const char* kAuthors = "The surveymc authors";

/// "S. Vis: Title. TU Delft, 2019." as one line.
std::string as_text(const Source& s) {
  std::string out = fmt::format("{}: {}. {}", fmt::join(s.authors, ", "), s.title, s.where);
  if (!s.volume.empty()) out += " " + s.volume;
  if (!s.number.empty()) out += "(" + s.number + ")";
  if (!s.pages.empty()) out += ", " + s.pages;
  if (s.year > 0) out += fmt::format(", {}", s.year);
  return out + (s.doi.empty() ? "." : ". doi:" + s.doi);
}

/// What TeX takes for a command is escaped.
std::string tex(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (std::string_view("&%$#_{}").find(c) != std::string_view::npos) out += '\\';
    out += c == '\\' ? '/' : c;
  }
  return out;
}

class BibEntry {
 public:
  BibEntry(const std::string& type, const std::string& id) : text_(fmt::format("@{}{{{}", type, id)) {}
  BibEntry& field(const char* name, const std::string& value) {
    if (!value.empty()) text_ += fmt::format(",\n  {} = {{{}}}", name, value);
    return *this;
  }
  std::string text() const { return text_ + "\n}\n"; }

 private:
  std::string text_;
};

std::string as_bibtex(const Source& s) {
  std::vector<std::string> authors;
  for (const std::string& a : s.authors) {  // an organisation is one name: in braces of its own
    const bool is_person = a.size() > 2 && a[1] == '.';
    authors.push_back(is_person ? tex(a) : "{" + tex(a) + "}");
  }
  const char* where = s.type == "article"      ? "journal"
                      : s.type == "phdthesis"  ? "school"
                      : s.type == "techreport" ? "institution"
                                               : "howpublished";
  return BibEntry(s.type, s.id)
      .field("author", fmt::format("{}", fmt::join(authors, " and ")))
      .field("title", "{" + tex(s.title) + "}")
      .field(where, tex(s.where))
      .field("volume", s.volume)
      .field("number", s.number)
      .field("pages", tex(s.pages))
      .field("year", s.year > 0 ? std::to_string(s.year) : "")
      .field("doi", s.doi)
      .text();
}

}  // namespace

void cite_result(const std::vector<study::Experiment>& studies, const CiteArguments& a) {
  const store::Result result = store::read_unchecked_result(a.file);
  const store::Provenance& p = result.provenance;
  const std::string created = result.run.created.substr(0, 10), hash = store::stored_content_hash(a.file);
  std::string summary, after;
  for (const study::Experiment& e : studies)
    if (e.name() == p.experiment) summary = e.summary, after = e.reproduces;
  const std::vector<Source> sources = sources_of(p);
  if (a.bibtex) {
    fmt::print("{}", BibEntry("misc", "surveymc")
                         .field("author", fmt::format("{{{}}}", kAuthors))
                         .field("title", fmt::format("{{{}}}", tex(kTitle)))
                         .field("note", tex(fmt::format("version {}, revision {}", p.surveymc_version, p.git_revision)))
                         .text());
    fmt::print("\n{}", BibEntry("misc", "surveymc_result_" + hash.substr(0, 8))
                           .field("author", fmt::format("{{{}}}", kAuthors))
                           .field("title", fmt::format("{{{}}}", tex(render::printable(p.title))))
                           .field("howpublished", tex(fmt::format("result of the study {} of surveymc {}", p.experiment,
                                                                  p.surveymc_version)))
                           .field("year", created.substr(0, 4))
                           .field("note", tex(fmt::format("config {}, content {}", p.config_hash, hash)))
                           .text());
    for (const Source& s : sources) fmt::print("\n{}", as_bibtex(s));
    return;
  }
  const auto say = [](const std::string& text) {
    fmt::print("{}\n", on_screen(render::printable(text), STDOUT_FILENO, 2));
  };
  say(fmt::format("{}: {}, version {}, revision {}.", kAuthors, kTitle, p.surveymc_version, p.git_revision));
  say(fmt::format("Result \"{}\" of {}, config {}, content {}.", p.title, created, p.config_hash, hash));
  say(fmt::format("Study {}: {}; after {}.", p.experiment, summary, after));
  fmt::print("\nIt stands on:\n");
  for (const Source& s : sources) say(as_text(s));
}

}  // namespace surveymc::cli
