#include "compare/warnings.h"

#include <limits>
#include <utility>

#include <fmt/format.h>

#include "compare/table_rows.h"
#include "config/config.h"

namespace surveymc::compare {

static constexpr std::uint64_t kNoPoint = std::numeric_limits<std::uint64_t>::max();

std::string in_words(const Warning& w) {
  std::string out = w.severity + ": " + config::remark_text(w.place, w.value, w.message, w.way_out);
  if (w.points > 1)
    out += fmt::format(" ({} points, the first: {})", w.points, w.at);
  else if (!w.at.empty())
    out += fmt::format(" (at {})", w.at);
  return out;
}

store::Table warnings_table(const std::vector<Warning>& warnings) {
  TableRows t(kWarningsTable, "what to know before the numbers are used");
  write_rows(t, warnings, [&](const Warning& w) {
    t.word("severity", "severe: do not use the numbers as they are; warning: look at it; info", w.severity);
    t.word("place", "key of the config, line of a file, error model, or depth", w.place);
    t.word("value", "what stands there", w.value);
    t.word("message", "what is unusual", w.message);
    t.word("way_out", "what to do if it is not meant", w.way_out);
    t.count("points", "points of the sweep that it is about", w.points);
    t.word("at", "the first of these points", w.at);
  });
  return t.take();
}

std::vector<Warning> warnings_of(const store::Table& table) {
  std::vector<Warning> out;
  store::for_each_piece(table, [&](const store::Table& t, std::size_t) {
    for (std::size_t row = 0; row < t.rows(); ++row) {
      Warning w{t.word("severity", row), t.word("place", row), t.word("value", row), t.word("message", row),
                t.word("way_out", row)};
      const double points = t.number("points", row);
      if (points > 1) w.points = static_cast<std::uint64_t>(points);
      w.at = t.word("at", row);
      out.push_back(std::move(w));
    }
  });
  return out;
}

void WarningList::add(Warning w) { add(std::move(w), kNoPoint); }

void WarningList::add(Warning w, std::uint64_t point) {
  const std::string says = fmt::format("{}\n{}\n{}\n{}\n{}", w.severity, w.place, w.value, w.message, w.way_out);
  const auto known = known_.find(says);
  if (known != known_.end()) {
    if (point != kNoPoint && known->second.point == point) return;
    known->second.point = point;
    list_[known->second.row].points += w.points;
    return;
  }
  if (list_.size() == kMost) {
    left_out_ += w.points;
    return;
  }
  known_.emplace(says, Known{list_.size(), point});
  list_.push_back(std::move(w));
}

store::Table WarningList::table() const {
  if (left_out_ == 0) return warnings_table(list_);
  std::vector<Warning> all = list_;
  all.push_back({.severity = "warning",
                 .place = "",
                 .message = fmt::format("{} warnings more of other points are left out", left_out_)});
  return warnings_table(all);
}

}  // namespace surveymc::compare
