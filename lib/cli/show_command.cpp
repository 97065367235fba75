#include "cli/commands.h"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "base/error.h"
#include "base/shell_word.h"
#include "cli/print_result.h"
#include "cli/screen.h"
#include "cli/show_map.h"
#include "cli/verdict_counts.h"
#include "compare/warnings.h"
#include "config/suggest.h"
#include "render/json.h"
#include "render/table_text.h"
#include "render/text.h"
#include "store/result_file.h"

namespace surveymc::cli {
namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

/// As wide as the reader's screen, if there is one, and as long as one can read.
render::TableFormat readable_format(const ShowArguments& a) {
  render::TableFormat format = screen_format();
  constexpr std::size_t kReadableRows = 40;
  format.most_rows = kReadableRows;
  if (a.rows) format.most_rows = *a.rows == 0 ? kNoLimit : static_cast<std::size_t>(*a.rows);
  return format;
}

store::Table in_units(const ShowArguments& a, const store::Table& table) {
  return a.units == "ft" ? in_feet(table) : table;
}

/// Text for the screen; of a table that is not held only the rows that are shown are read.
std::string formatted(const ShowArguments& a, const store::Table& table) {
  render::TableFormat format = readable_format(a);
  const std::size_t shown = std::min(format.most_rows, table.rows());
  if (!table.is_held()) format.left_out = table.rows() - shown;
  std::string text =
      render::format_table(in_units(a, table.is_held() ? table : render::first_and_last(table, shown)), format);
  if (!a.rows && shown < table.rows())
    text += on_screen("(--rows 0 prints all rows, --csv exports them)", STDOUT_FILENO) + "\n";
  return text;
}

void print_text(const std::string& text) { fmt::print("{}", text); }

/// "36 agree, 2 findings, 1 differs (1 !)": the kinds that occur; "!" counts the verdicts that are not as expected.
std::string short_words(const VerdictCounts& counts) {
  std::string out;
  const auto add = [&](std::size_t n, const char* one, const char* several) {
    if (n > 0) out += fmt::format("{}{} {}", out.empty() ? "" : ", ", n, n == 1 ? one : several);
  };
  add(counts.agrees, "agrees", "agree");
  add(counts.findings, "finding", "findings");
  add(counts.differs - counts.findings, "differs", "differ");
  add(counts.undecided, "undecided", "undecided");
  return counts.unexpected > 0 ? out + fmt::format(" ({} !)", counts.unexpected) : out;
}

/// The list of a file's contents, as a table.
store::Table list_of(const store::Result& r) {
  using Texts = std::vector<std::string>;
  store::Table list{"contents",
                    "",
                    {{"kind", "", "", Texts()},
                     {"name", "", "", Texts()},
                     {"size", "", "rows x columns, or lengths of the axes", Texts()},
                     {"unit", "", "", Texts()},
                     {"verdicts", "", "", Texts()},
                     {"title", "", "", Texts()}}};
  const auto add = [&](const std::array<std::string, 6>& row) {
    for (std::size_t c = 0; c < row.size(); ++c) std::get<Texts>(list.columns[c].values).push_back(row[c]);
  };
  const auto add_tables = [&](const char* what, const std::vector<store::Table>& tables) {
    for (const store::Table& t : tables)
      add({what, t.name, fmt::format("{} x {}", t.rows(), t.columns.size()), "", short_words(count_verdicts({t})),
           t.long_name});
  };
  add_tables("table", r.tables);
  add_tables("samples", r.samples);
  for (const store::MapSource& m : store::maps_of(r))
    add({"map", m.map->name, shape_text(*m.map), m.map->unit == "1" ? "" : m.map->unit, "", m.map->long_name});
  return list;
}

void print_heading(const store::Result& r) {
  const store::Provenance& p = r.provenance;
  const auto say = [](const std::string& text) {
    fmt::print("{}\n", on_screen(render::printable(text), STDOUT_FILENO));
  };
  say(p.title);
  const bool may_stop = ("\n" + p.config).find("\n[stop]") != std::string::npos;
  say(fmt::format("experiment {}, seed {}, {}{} trials a point; surveymc {} ({}), {}", p.experiment, p.seed,
                  may_stop ? "at most " : "", p.trials, p.surveymc_version, p.git_revision, r.run.created));
  const std::string verdicts = in_words(count_verdicts(r.tables));
  if (!verdicts.empty()) say("verdicts: " + verdicts);
}

/// The first letters, and "..." where there are more than `most`.
std::string shortened(const std::string& text, std::size_t most) {
  std::size_t letters = 0, keep = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0) == 0x80) continue;
    if (letters + 3 == most) keep = i;
    ++letters;
  }
  return letters > most ? text.substr(0, keep) + "..." : text;
}

/// The list on a screen too narrow for its columns: an entry has two lines or more.
std::string stacked(const store::Table& list, std::size_t screen) {
  std::string out;
  const auto text = [&](const char* column, std::size_t row) {
    return render::printable(std::get<std::vector<std::string>>(list.column(column).values)[row]);
  };
  for (std::size_t row = 0; row < list.rows(); ++row) {
    std::string head;
    for (const char* column : {"kind", "name", "size", "unit", "verdicts"})
      if (const std::string own = text(column, row); !own.empty()) head += (head.empty() ? "" : "  ") + own;
    out += render::folded(head, screen, 4) + "\n" + render::folded("    " + text("title", row), screen, 4) + "\n";
  }
  return out;
}

void print_list(const ShowArguments& a, const store::Result& r) {
  print_heading(r);
  const std::vector<std::string> answer = answer_of(r, a.units == "ft");
  if (!answer.empty()) fmt::print("\n");
  for (const std::string& sentence : answer) say(sentence);
  std::size_t warnings = 0;
  for (const store::Table& t : r.tables)
    if (t.name == compare::kWarningsTable)
      for (const compare::Warning& w : compare::warnings_of(t)) warnings += w.severity != "info";
  if (warnings > 0)
    say(fmt::format("{}: surveymc show {} {}", counted(warnings, "warning"), shell_word(a.file),
                    compare::kWarningsTable));
  store::Table list = list_of(r);
  render::TableFormat format = readable_format(a);
  const std::size_t screen = format.fold ? format.width : kNoLimit;
  auto& titles = std::get<std::vector<std::string>>(list.columns.back().values);
  const std::vector<std::string> whole = titles;
  for (std::string& t : titles) t.clear();
  format.width = format.most_rows = kNoLimit;
  format.fold = false;
  constexpr std::size_t kGap = 2, kLeastTitle = 20;
  const std::size_t taken = render::longest_line(render::format_table(list, format)) + kGap;
  std::string text;
  if (taken + kLeastTitle > screen) {
    titles = whole;
    text = stacked(list, screen);
  } else {
    for (std::size_t i = 0; i < titles.size(); ++i) titles[i] = shortened(whole[i], screen - taken);
    text = render::format_table(list, format);
    text = text.substr(text.find('\n') + 1);
  }
  fmt::print("\n{}\n{}\n", text,
             on_screen(render::printable(fmt::format(
                           "surveymc show {} NAME prints one of them; --csv and --json export", shell_word(a.file))),
                       STDOUT_FILENO));
}

void print_json(const ShowArguments& a, const store::Result& r) {
  fmt::print("{{{}", summary_json(r, a.file));
  const auto print_tables = [&](const char* key, const std::vector<store::Table>& tables) {
    fmt::print(",\n\"{}\": [", key);
    for (const store::Table& t : tables)
      fmt::print("{}\n", &t == &tables.front() ? "" : ","), render::to_json(t, !a.list, print_text);
    fmt::print("]");
  };
  print_tables("tables", r.tables);
  print_tables("samples", r.samples);
  fmt::print(",\n\"maps\": [");
  const std::vector<store::MapSource> maps = store::maps_of(r);
  for (const store::MapSource& m : maps) {
    fmt::print("{}\n{{{}}}", &m == &maps.front() ? "" : ",", render::map_members_json(*m.map));
  }
  fmt::print("]}}\n");
}

void print_table(const ShowArguments& a, const store::Table& t) {
  if (a.csv)
    print_csv(t);
  else if (a.json)
    render::to_json(t, true, print_text), print_text("\n");
  else
    print_text(formatted(a, t));
}

/// Prints the table or map of that name. False: there is none.
bool print_one(const ShowArguments& a, const store::Result& r) {
  for (const auto* tables : {&r.tables, &r.samples})
    for (const store::Table& t : *tables) {
      if (t.name != a.name) continue;
      print_table(a, t);
      return true;
    }
  for (const store::MapSource& m : store::maps_of(r)) {
    if (m.map->name != a.name) continue;
    (a.csv ? print_map_csv : a.json ? print_map_json : print_map)(m);
    if (a.json) fmt::print("\n");
    return true;
  }
  return false;
}

void show_result(const ShowArguments& a, const store::Result& r) {
  if (a.cost) {
    if (r.cost.columns.empty())
      throw InputError(
          fmt::format("{}: does not say what its rows cost: only a run that computed all of its trials itself does, "
                      "neither merged parts nor several ranks",
                      a.file));
    print_table(a, r.cost);
    return;
  }
  if (a.name.empty()) {
    if (a.json) {
      print_json(a, r);
    } else if (a.csv) {
      print_csv(list_of(r));
    } else {
      print_list(a, r);
      for (const store::Table& t : r.tables)
        if (t.rows() > 0 && a.verbose) fmt::print("\n{}", formatted(a, t));
    }
    return;
  }
  if (print_one(a, r)) return;
  const store::Table list = list_of(r);
  const auto& names = std::get<std::vector<std::string>>(list.column("name").values);
  throw InputError(fmt::format("{}: table {}: not in this file, which has {}{}", a.file, a.name, fmt::join(names, ", "),
                               config::suggestion(a.name, names)));
}

}  // namespace

void show(const ShowArguments& a) {
  const store::Result r = a.unchecked ? store::read_unchecked_result(a.file) : store::read_result(a.file);
  const auto refuse = [&] {
    throw IoError(
        fmt::format("{}: is not as surveymc writes results: a column is missing or has another type", a.file));
  };
  try {
    show_result(a, r);
  } catch (const std::out_of_range&) {
    refuse();
  } catch (const std::bad_variant_access&) {
    refuse();
  }
}

}  // namespace surveymc::cli
