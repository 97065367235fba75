#include "cli/commands.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cli/exit_codes.h"
#include "cli/print_result.h"
#include "cli/screen.h"
#include "render/json.h"
#include "render/table_text.h"
#include "sweep/difference.h"

namespace surveymc::cli {
namespace {

/// What a difference would have had to be to be found.
void print_power(const sweep::Differences& d) {
  std::vector<double> relative, sizes;
  for (const sweep::DifferenceRow& r : d.rows) {
    if (std::isnan(r.detectable)) continue;
    // Rows of logarithms say it in per cent; the others in standard errors only.
    if (r.a > 0 && r.b > 0 && std::abs(r.difference - std::log(r.b / r.a)) < 1e-12) relative.push_back(r.detectable);
    sizes.push_back(r.detectable / r.standard_error);
  }
  if (sizes.empty()) return;
  std::string text =
      fmt::format("power: a difference of {:.2g} standard errors would be found with probability 0.9", sizes.front());
  if (!relative.empty()) {
    std::sort(relative.begin(), relative.end());
    const auto percent = [](double ln) { return 100 * std::expm1(ln); };
    text += fmt::format("; that is {:.2g} % of the value in the median row, {:.2g} % to {:.2g} % in all {}",
                        percent(relative[relative.size() / 2]), percent(relative.front()), percent(relative.back()),
                        counted(relative.size(), "row"));
  }
  say(text);
}

/// What the runs were asked for, where it is not the same: read before what they found.
void print_keys_that_differ(const store::Result& a, const store::Result& b) {
  const std::vector<sweep::KeyDifference> keys = sweep::differing_keys(a, b);
  constexpr std::size_t kMostKeys = 40, kLongest = 60;
  const auto shown = [](const std::string& value) {
    return value.empty() ? "not given" : value.size() <= kLongest ? value : value.substr(0, kLongest) + "...";
  };
  say(keys.empty() ? "no key of the config differs" : "keys of the config that differ:");
  for (std::size_t i = 0; i < std::min(keys.size(), kMostKeys); ++i)
    say(fmt::format("  {}: {} in A, {} in B", keys[i].key, shown(keys[i].a), shown(keys[i].b)));
  if (keys.size() > kMostKeys) say(fmt::format("  and {} more", keys.size() - kMostKeys));
  fmt::print("\n");
}

}  // namespace

int diff_results(const DiffArguments& a) {
  const store::Result first = store::read_result(a.a), second = store::read_result(a.b);
  const sweep::Differences d = sweep::compare_results(first, second, {.level = a.level, .tolerance = a.tolerance});
  if (a.csv || a.json) {
    const store::Table all = sweep::difference_table(d, true);
    if (a.csv)
      print_csv(all);
    else
      fmt::print("{}\n", render::to_json(all));
    return d.any() ? kUnexpected : kDone;
  }
  print_keys_that_differ(first, second);
  const store::Table found = sweep::difference_table(d, false);
  if (found.rows() > 0) {
    render::TableFormat format = screen_format();
    constexpr std::size_t kReadableRows = 60;
    format.most_rows = kReadableRows;
    fmt::print("{}\n", render::format_table(found, format));
  }
  std::size_t equal = 0, chance = 0, few = 0, verdicts = 0, differing = 0;
  for (const sweep::DifferenceRow& r : d.rows) {
    equal += r.finding == "equal";
    chance += r.finding == "chance";
    few += r.finding == "few";
    verdicts += r.finding == "verdict";
    differing += r.counts();
  }
  say(fmt::format("{} and {}: {}, {}", a.a, a.b, d.same_seed ? "the same seed" : "other seeds",
                  d.same_trials ? "as many trials" : "other numbers of trials"));
  say(fmt::format("{} differ, {} do not beyond chance (level {:g} for all {} together), {} are equal{}{}", differing,
                  chance, a.level, d.judged, equal,
                  few > 0 ? fmt::format(", {} have too few trials or events", few) : "",
                  verdicts > 0 ? fmt::format("; {} changed", counted(verdicts, "verdict")) : ""));
  print_power(d);
  return d.any() ? kUnexpected : kDone;
}

}  // namespace surveymc::cli
