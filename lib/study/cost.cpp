#include "study/cost.h"

#include <cmath>
#include <ctime>

#include "base/units.h"
#include "compare/table_rows.h"
#include "study/experiment.h"
#include "study/sweep_columns.h"

namespace surveymc::study {

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void add_cost(store::Table& cost, const std::vector<store::Table>& tables, const std::vector<config::SweepValue>& sweep,
              double seconds, std::uint64_t computed, std::uint64_t trials) {
  const double per_trial = seconds / static_cast<double>(computed), n = static_cast<double>(trials);
  compare::TableRows t(
      "cost", "processor time of the rows that have a ratio; figure of merit = 1 / (relative half width^2 x seconds)");
  std::size_t rows = 0;
  const auto add_rows = [&](const store::Table& table) {
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const double lo = table.number("ratio_ci_low", i), hi = table.number("ratio_ci_high", i);
      if (!(lo > 0) || !(hi > lo) || !std::isfinite(hi)) continue;
      const double half = std::log(hi / lo) / 2, to_decide = table.number("trials_to_decide", i);
      const bool judged = !table.word("verdict", i).empty();
      ++rows;
      t.word("table", "where the row stands", table.name);
      t.word("formulation", "which prediction", table.word("formulation", i));
      t.word("quantity", "what is compared", table.word("quantity", i));
      t.count("trials", "trials run", trials);
      t.number("relative_half_width", "1", "half of the interval's logarithm", half);
      t.number("seconds_per_trial", "s", "processor time of a trial", per_trial);
      t.number("figure_of_merit", "1/s", "1 / (relative half width^2 x processor time of all trials)",
               1 / (half * half * per_trial * n));
      t.number("seconds_to_verdict", "s", "processor time until the row is decided, about; NaN: it has no verdict",
               !judged ? kNaN : per_trial * (std::isnan(to_decide) ? n : to_decide));
    }
  };
  for (const store::Table& table : tables)
    if (table.find_column("ratio_ci_low"))
      store::for_each_piece(table, [&](const store::Table& piece, std::size_t) { add_rows(piece); });
  if (rows == 0) return;
  store::append_rows(cost, with_sweep_columns(t.take(), sweep));
}

}  // namespace surveymc::study
