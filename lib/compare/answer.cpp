#include "compare/answer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include <fmt/format.h>

#include "compare/family.h"
#include "compare/table_rows.h"

namespace surveymc::compare {

Figure Figure::times(double factor) const { return {value * factor, unit, fmt::format("{} * {}", source, factor)}; }

Figure Figure::percent() const {
  constexpr double kPercent = 100;
  Figure f = times(kPercent);
  f.unit = "%";
  return f;
}

Figure Figure::with_unit(const std::string& of_number) const {
  Figure f = *this;
  f.unit = of_number;
  return f;
}

Figure Figure::with_decimals(int count) const {
  Figure f = *this;
  f.decimals = count;
  return f;
}

Phrase::Phrase(const Figure& f)
    : text(f.decimals < 0 ? three_digits(f.value) : fmt::format("{:.{}f}", f.value, f.decimals)), sources{f.source} {
  if (!f.unit.empty() && f.unit != "1") text += " " + f.unit;
}

Phrase::Phrase(std::string_view pattern, std::initializer_list<Phrase> parts) {
  for (const Phrase& part : parts) {
    const std::size_t place = pattern.find("{}");
    if (place == std::string_view::npos) throw std::logic_error("more parts than places in a sentence");
    text += std::string(pattern.substr(0, place)) + part.text;
    sources.insert(sources.end(), part.sources.begin(), part.sources.end());
    pattern.remove_prefix(place + 2);
  }
  if (pattern.find("{}") != std::string_view::npos) throw std::logic_error("fewer parts than places in a sentence");
  text += pattern;
}

std::string three_digits(double value) {
  constexpr double kWhole = 100, kLargest = 1e9, kSmallest = 1e-4;
  const double size = std::abs(value);
  if (!std::isfinite(value)) return std::isnan(value) ? "no number" : value > 0 ? "infinite" : "-infinite";
  if (size >= kWhole && size < kLargest) return fmt::format("{:.0f}", value);
  const std::string text = fmt::format("{:.3g}", value);
  if (size == 0 || (size >= kSmallest && size < kLargest)) return text;
  const std::size_t e = text.find('e');  // "3.1e-09" as "3.1e-9"
  if (e == std::string::npos) return text;
  return fmt::format("{}e{}", text.substr(0, e), std::stoi(text.substr(e + 1)));
}

// --- rows -------------------------------------------------------------------------------------------------------

namespace {

/// The number of a row; NaN in a column of words.
double number_of(const store::Column& c, std::size_t row) {
  if (const auto* x = std::get_if<std::vector<double>>(&c.values)) return (*x)[row];
  if (const auto* n = std::get_if<std::vector<std::int64_t>>(&c.values)) return static_cast<double>((*n)[row]);
  return kNaN;
}

/// The word of a row; "" in a column of numbers.
std::string word_of(const store::Column& c, std::size_t row) {
  const auto* words = std::get_if<std::vector<std::string>>(&c.values);
  return words ? (*words)[row] : "";
}

}  // namespace

Rows::Rows(const std::vector<store::Table>& tables, std::string_view name) {
  for (const store::Table& t : tables) {
    if (t.name != name) continue;
    if (!t.is_held()) throw LongTable{{static_cast<double>(t.rows()), "", "count " + t.name}, t.name};
    table_ = &t;
  }
  if (!table_) return;
  for (std::size_t i = 0; i < table_->rows(); ++i) rows_.push_back(i);
}

const store::Column* Rows::column(std::string_view name) const {
  return table_ ? table_->find_column(std::string(name)) : nullptr;
}

bool Rows::has(std::string_view name) const { return column(name) != nullptr; }

template <class Keep>
Rows Rows::kept(const std::string& condition, Keep keep) const {
  Rows some = *this;
  std::erase_if(some.rows_, [&](std::size_t row) { return !keep(row); });
  some.conditions_ += (conditions_.empty() ? "" : " and ") + condition;
  return some;
}

Rows Rows::one(std::size_t place) const {
  Rows some = *this;
  some.rows_ = {rows_.at(place)};
  return some;
}

Rows Rows::where(std::string_view name, std::string_view word) const {
  const store::Column* c = column(name);
  return kept(fmt::format("{} = {}", name, word), [&](std::size_t row) { return c && word_of(*c, row) == word; });
}

Rows Rows::without(std::string_view name, std::string_view word) const {
  const store::Column* c = column(name);
  if (!c) return *this;
  return kept(fmt::format("{} != {}", name, word), [&](std::size_t row) { return word_of(*c, row) != word; });
}

Rows Rows::with(std::string_view name) const {
  const store::Column* c = column(name);
  return kept(fmt::format("{} finite", name), [&](std::size_t row) { return c && std::isfinite(number_of(*c, row)); });
}

Rows Rows::between(std::string_view name, double low, double high) const {
  const store::Column* c = column(name);
  return kept(fmt::format("{} in {}..{}", name, low, high),
              [&](std::size_t row) { return c && number_of(*c, row) >= low && number_of(*c, row) <= high; });
}

Rows Rows::at_largest(std::string_view name, const std::function<double(double)>& size) const {
  const Rows finite = with(name);
  if (finite.empty()) return finite;
  const auto size_of = [&](std::size_t row) {
    const double x = number_of(*column(name), row);
    return size ? size(x) : x;
  };
  std::size_t best = 0;
  for (std::size_t i = 1; i < finite.size(); ++i)
    if (size_of(finite.rows_[i]) > size_of(finite.rows_[best])) best = i;
  return finite.one(best);
}

Rows Rows::at_least(std::string_view name) const {
  return at_largest(name, [](double x) { return -x; });
}

Rows Rows::first() const { return empty() ? *this : one(0); }

Rows Rows::last() const { return empty() ? *this : one(size() - 1); }

std::vector<std::string> Rows::words(std::string_view name) const {
  std::vector<std::string> out;
  const store::Column* c = column(name);
  for (const std::size_t row : rows_)
    if (std::string word = c ? word_of(*c, row) : ""; c && std::find(out.begin(), out.end(), word) == out.end())
      out.push_back(std::move(word));
  return out;
}

Figure Rows::count() const {
  return {static_cast<double>(size()), "",
          fmt::format("count {}{}{}", table_ ? table_->name : "", conditions_.empty() ? "" : " where ", conditions_)};
}

double Rows::number(std::string_view name) const {
  const store::Column* c = column(name);
  return c && !empty() ? number_of(*c, rows_.front()) : kNaN;
}

std::string Rows::word(std::string_view name) const {
  const store::Column* c = column(name);
  return c && !empty() ? word_of(*c, rows_.front()) : "";
}

Figure Rows::figure(std::string_view name) const {
  const store::Column* c = column(name);
  if (!c || empty()) return {};
  const bool is_of_row = c->long_name.find("in the row's unit") != std::string::npos;
  return {number(name), is_of_row ? word("unit") : c->unit,
          fmt::format("{}.{}[{}]", table_->name, name, rows_.front())};
}

std::vector<const store::Column*> Rows::sweep_columns() const {
  std::vector<const store::Column*> out;
  for (std::size_t i = 0; table_ && i < table_->columns.size(); ++i) {
    if (table_->columns[i].long_name != store::kSweepKey) break;
    out.push_back(&table_->columns[i]);
  }
  return out;
}

Phrase Rows::point() const {
  Phrase out("");
  if (empty()) return out;
  for (const store::Column* c : sweep_columns()) {
    const char* comma = out.text.empty() ? "" : ", ";
    Figure value = figure(c->name);
    value.unit = "";  // the key has it
    if (c->name == "case")
      out = {"{}{}{}", {out, comma, word(c->name)}};
    else if (std::holds_alternative<std::vector<std::string>>(c->values))
      out = {"{}{}{} = {}", {out, comma, c->name, word(c->name)}};
    else
      out = {"{}{}{} = {}", {out, comma, c->name, value}};
  }
  return out.text.empty() ? out : Phrase(" ({})", {out});
}

Rows Rows::at_point_of(const Rows& other) const {
  Rows some = *this;
  if (other.empty()) return some;
  for (const store::Column* c : sweep_columns())
    std::erase_if(some.rows_, [&](std::size_t row) {
      const std::size_t wanted = other.rows_.front();
      return word_of(*c, row) != word_of(*c, wanted) ||
             (std::isfinite(number_of(*c, wanted)) && number_of(*c, row) != number_of(*c, wanted));
    });
  return some;
}

double number_at(const std::vector<store::Table>& tables, const std::string& source) {
  const std::size_t dot = source.find('.'), bracket = source.rfind('['), star = source.rfind(" * ");
  if (dot == std::string::npos || bracket == std::string::npos) return kNaN;
  for (const store::Table& t : tables) {
    if (t.name != source.substr(0, dot)) continue;
    const store::Column* c = t.find_column(source.substr(dot + 1, bracket - dot - 1));
    const std::size_t row = std::strtoull(source.c_str() + bracket + 1, nullptr, 10);
    const double factor = star == std::string::npos ? 1 : std::strtod(source.c_str() + star + 3, nullptr);
    return c && t.is_held() && row < t.rows() ? number_of(*c, row) * factor : kNaN;
  }
  return kNaN;
}

// --- sentences --------------------------------------------------------------------------------------------------

void Answer::say(std::string_view pattern, std::initializer_list<Phrase> parts) {
  sentences_.emplace_back(pattern, parts);
}

namespace {

/// "within 2 %", "within 2 to 6 %", or "" of rows without a margin.
Phrase margins(const Rows& rows) {
  const Rows least = rows.at_least("margin"), largest = rows.at_largest("margin");
  if (least.empty()) return "";
  const Figure low = least.figure("margin").percent(), high = largest.figure("margin").percent();
  if (low.value == high.value) return {" within {}", {low}};
  Figure pure = low;
  pure.unit = "";
  return {" within {} to {}", {pure, high}};
}

/// "sigma_east of joint (noise.scale = 0.5)"
Phrase name_of_row(const Rows& row) {
  const std::string quantity = row.word("quantity"), formulation = row.word("formulation");
  const char* of = quantity.empty() ? "that of " : " of ";
  return {"{}{}{}", {quantity, formulation.empty() ? "" : of + formulation, row.point()}};
}

/// "; worst is sigma_east of joint, 0.83 times the Monte-Carlo value"
Phrase worst_of(const Rows& differ) {
  const char* ratio = differ.has("ratio") ? "ratio" : "ratio_major";
  const Rows worst = differ.at_largest(ratio, [](double r) { return std::abs(std::log(r)); });
  if (worst.empty()) return "";
  return {"; worst is {}, {} times the Monte-Carlo value", {name_of_row(worst), worst.figure(ratio)}};
}

/// ", 3 are undecided (some 5000 trials decide all)"
Phrase undecided_part(const Rows& undecided) {
  if (undecided.empty()) return "";
  const Rows slowest = undecided.at_largest("trials_to_decide");
  const Phrase wanted = slowest.number("trials_to_decide") > 0
                            ? Phrase(" (some {} trials decide all)", {slowest.figure("trials_to_decide")})
                            : Phrase("");
  return {", {} undecided{}", {undecided.count(), wanted}};
}

/// Rows that were asked beforehand and differ.
Rows known_to_differ(const Rows& rows) { return rows.where("expected", "differs").where("verdict", "differs"); }

}  // namespace

void Answer::say_verdicts(const Rows& all, const std::string& what, const std::string& subject) {
  const Rows known = known_to_differ(all);
  const Rows rows = all.without("verdict", "").without("expected", "differs");
  const Rows agree = rows.where("verdict", "agrees"), undecided = rows.where("verdict", "undecided");
  const Rows differ = rows.where("verdict", "differs").without("family", kMayBeChance);
  const Rows chance = rows.where("verdict", "differs").where("family", kMayBeChance);
  const char* how = !differ.empty()                   ? " does not hold everywhere"
                    : agree.size() == rows.size()     ? " holds"
                    : agree.empty() && chance.empty() ? " is undecided"
                                                      : " is not contradicted";
  if (!rows.empty())
    say("{}{}: {} of {} {} agree{}{}{}{}{}.",
        {subject, how, agree.count(), rows.count(), what, margins(rows),
         differ.empty() ? Phrase("") : Phrase(", {} differ", {differ.count()}), undecided_part(undecided),
         chance.empty() ? Phrase("") : Phrase(", {} may differ by chance", {chance.count()}), worst_of(differ)});
  if (!known.empty()) say("A finding: {} {} of formulations known to be wrong differ.", {known.count(), what});
}

void Answer::say_failures(const std::vector<store::Table>& tables) {
  Rows worst(tables, "");
  for (const store::Table& t : tables) {
    if (!t.is_held()) continue;
    const Rows failed = Rows(tables, t.name).at_largest("failed");
    if (failed.has("trials") && failed.number("failed") > 0 &&
        (worst.empty() || failed.number("failed") > worst.number("failed")))
      worst = failed;
  }
  if (!worst.empty())
    say("{} of {} trials failed{}: these numbers are of the others.",
        {worst.figure("failed"), worst.figure("trials"), worst.point()});
}

void Answer::say_formulations(const Rows& all, const std::string& what) {
  const Rows rows = all.without("verdict", "");
  if (rows.empty()) return;
  Phrase list("");
  for (const std::string& name : rows.words("formulation")) {
    const Rows own = rows.where("formulation", name);
    const Rows undecided = own.where("verdict", "undecided");
    list = Phrase(list.text.empty() ? "{}{} in {} of {}{}" : "{}, {} in {} of {}{}",
                  {list, name.empty() ? "the prediction" : name, own.where("verdict", "agrees").count(), own.count(),
                   undecided.empty() ? Phrase("") : Phrase(" ({} undecided)", {undecided.count()})});
  }
  const Rows known = known_to_differ(rows);
  say("Predictions of {} agree with Monte Carlo{} by formulation: {}{}.",
      {what, margins(rows), list, known.empty() ? Phrase("") : Phrase("; {} are known to differ", {known.count()})});
}

store::Table Answer::table() const {
  TableRows t(kAnswerTable, "what was found; every number is in another table");
  for (const Phrase& s : sentences_) {
    t.word("sentence", "in plain words, with three digits", s.text);
    std::string sources;
    for (const std::string& source : s.sources) sources += (sources.empty() ? "" : "; ") + source;
    t.word("sources", "where its numbers are, in order: TABLE.COLUMN[ROW], rows from 0", sources);
  }
  return t.take();
}

}  // namespace surveymc::compare
