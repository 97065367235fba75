/// The page of a running sweep.
#include <chrono>
#include <cmath>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "cli/sweep_status.h"
#include "render/text.h"

namespace surveymc::cli {
namespace {

constexpr std::uint64_t kMostCells = 5000;  // points that get a square of their own

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : render::printable(text)) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">{refresh}
<meta name="viewport" content="width=device-width"><title>{title}</title>
{mark}
<style>
body {{ font: 16px/1.45 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; overflow-wrap: anywhere }}
h1 {{ font-size: 1.3rem; margin: 1.5rem 0 .2rem }} p {{ margin: .3rem 0 }} .of {{ color: #666; font-size: .85rem }}
.bar {{ background: #ddd; height: 1rem; margin: .6rem 0 }} .bar div {{ background: #0072B2; height: 100% }}
.points {{ display: flex; flex-wrap: wrap; gap: 2px; margin: .8rem 0 }}
.points i {{ width: 10px; height: 10px; background: #ddd }} .points .d {{ background: #0072B2 }}
.points .b {{ background: #56B4E9 }} .points .f {{ background: #D55E00 }}
@media (prefers-color-scheme: dark) {{ body {{ background: #1c1c1c; color: #ddd }} .of {{ color: #aaa }}
  .bar, .points i {{ background: #444 }} }}
</style></head><body>
)";

std::string squares(const SweepStatus& s) {
  if (s.points < 2 || s.points > kMostCells) return "";
  std::string out = "<div class=\"points\">";
  for (std::uint64_t i = 0; i < s.points; ++i) {
    const auto share = s.begun.find(i);
    const bool failed = s.failed.contains(i), done = s.done.contains(i);
    const std::string what = failed                   ? "cannot be run"
                             : done                   ? "done"
                             : share != s.begun.end() ? fmt::format("{:.0f} %", std::floor(100 * share->second))
                                                      : "not begun";
    const char* kind = failed ? " class=\"f\"" : done ? " class=\"d\"" : share != s.begun.end() ? " class=\"b\"" : "";
    out += fmt::format("<i{} title=\"point {}: {}\"></i>", kind, i, what);
  }
  return out +
         "</div>\n<p class=\"of\">A square a point: dark blue done, light blue in work, orange cannot be run.</p>\n";
}

}  // namespace

std::string status_page(const std::vector<SweepStatus>& runs, double refresh_s) {
  const std::string refresh =
      refresh_s > 0 ? fmt::format("<meta http-equiv=\"refresh\" content=\"{:.0f}\">", std::ceil(refresh_s)) : "";
  const std::string title = runs.size() == 1
                                ? fmt::format("{:.0f} % {}", std::floor(100 * runs[0].share), runs[0].title)
                                : fmt::format("{} runs", runs.size());
  std::string out = fmt::format(kHead, fmt::arg("refresh", refresh), fmt::arg("title", escaped(title)),
                                fmt::arg("mark", kStatusPageMark));
  for (const SweepStatus& s : runs) {
    out += fmt::format("<h1>{}</h1>\n<p class=\"of\">{}, config hash {}</p>\n", escaped(s.title), escaped(s.experiment),
                       s.config_hash);
    out += fmt::format("<div class=\"bar\"><div style=\"width: {:.1f}%\"></div></div>\n", 100 * s.share);
    for (const std::string& line : status_lines(s)) out += fmt::format("<p>{}</p>\n", escaped(line));
    out += squares(s);
  }
  if (runs.empty()) out += "<p>Nothing is kept yet.</p>\n";
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return out + fmt::format("<p class=\"of\">Written at {:%Y-%m-%d %H:%M:%S}.{}</p>\n</body></html>\n",
                           fmt::localtime(now), refresh_s > 0 ? "" : " It is not written again.");
}

}  // namespace surveymc::cli
