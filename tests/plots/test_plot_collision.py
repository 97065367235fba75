#!/usr/bin/python3
"""Tests of the drawer collision on the smoke results, whose paths are in SURVEYMC_RESULT, SURVEYMC_FUNCTIONS and
SURVEYMC_EVENTS. Without them they are skipped."""
import os
import unittest

import numpy as np

import plot_case
from surveymc.plots import collision as plot
from surveymc.plots import reading, wording

WELLS, FUNCTIONS, EVENTS = (os.environ.get(k, "") for k in ("SURVEYMC_RESULT", "SURVEYMC_FUNCTIONS", "SURVEYMC_EVENTS"))


class Convergence(unittest.TestCase):
    def figure(self, events, kept=100):
        """Every second of 100 kept trials hits with weight 0.02; the table's estimate, of 400 trials, is 0.008."""
        names = [f"event {k}" for k in range(events)]
        sampling = reading.Table("sampling", {"event": names, "evaluations": np.full(events, 400.0)})
        probability = reading.Table("probability", {"event": names, "monte_carlo": np.full(events, 0.008)})
        trials = np.arange(0.0, 100, 2)
        hits = reading.Table("hits", {"event": np.repeat(np.arange(1.0, events + 1), 50), "trial": np.tile(trials, events),
                                       "weight": np.full(50 * events, 0.02)})
        return plot.convergence(hits, probability, sampling, kept).axes[0]

    def test_curves_are_of_the_kept_trials_and_numbers_of_all(self):
        ax = self.figure(1)
        line = ax.lines[0]
        self.assertEqual(line.get_label(), "event 0: 0.00800")
        np.testing.assert_allclose((line.get_xdata()[-1], line.get_ydata()[-1]), (100, 0.01 / 0.008), rtol=1e-12)
        self.assertIn("The first 100 of 400 evaluations", ax.get_title(loc="left"))
        self.assertNotIn("settle", ax.get_title(loc="left"))

    def test_no_event_is_dropped_without_a_word(self):
        ax = self.figure(8)
        self.assertEqual(sum(x.get_label().startswith("event") for x in ax.lines), 8)
        self.assertEqual(len({(x.get_color(), x.get_linestyle()) for x in ax.lines if x.get_label().startswith("event")}), 8)
        self.assertNotIn("not drawn", ax.get_title(loc="left"))
        ax = self.figure(15)
        self.assertEqual(sum(x.get_label().startswith("event") for x in ax.lines), 12)
        self.assertIn("3 more events are not drawn", ax.get_title(loc="left"))

    @unittest.skipUnless(WELLS, "SURVEYMC_RESULT is not set")
    def test_the_legend_has_the_numbers_of_the_table(self):
        with reading.open_result(WELLS, "collision") as file:
            probability, sampling = (reading.read_table(file, n) for n in ("probability", "sampling"))
            hits = reading.read_table(file, "hits", "samples")
        ax = plot.convergence(hits, probability, sampling, 200).axes[0]
        found = {f"{o}, {c}: {wording.number(p)}" for o, c, p in zip(probability["offset"], probability["correlation"], probability["monte_carlo"])}
        self.assertEqual({x.get_label() for x in ax.lines if ": " in x.get_label()}, found)


class Predictions(unittest.TestCase):
    def tables(self, names):
        n = len(names)
        own = {"event": names, "formulation": ["form"] * n, "analytic": np.full(n, 1e-9), "published": np.full(n, np.nan),
               "monte_carlo": np.zeros(n), "monte_carlo_ci_low": np.zeros(n), "monte_carlo_ci_high": np.full(n, 0.004)}
        drawn = {"event": names, "trusted": np.zeros(n), "subset_probability": np.zeros(n), "subset_ci_low": np.zeros(n),
                 "subset_ci_high": np.zeros(n)}
        return reading.Table("probability", own), reading.Table("sampling", drawn)

    def test_an_event_without_a_hit_has_the_upper_end_of_its_interval(self):
        ax = plot.predictions("t", *self.tables(["far", "farther"]), []).axes[0]
        ends = {bars.get_label(): [x for line in ax.lines if line.get_marker() == "<" for x in line.get_xdata()] for bars in ax.containers}
        self.assertIn("no hit: upper end of the interval", ends)
        xs = sorted(set(ends["no hit: upper end of the interval"]))
        np.testing.assert_allclose(xs, [4e-5, 0.004])  # the prediction of 1e-9 stands at the edge
        self.assertLess(ax.get_xlim()[0], 4e-5)

    def test_many_events_are_drawn_in_part_and_the_figure_says_so(self):
        figure = plot.predictions("t", *self.tables([f"event {k}" for k in range(300)]), [])
        self.assertEqual(len(figure.axes[0].get_yticklabels()), 40)
        self.assertIn("40 of 300, evenly spread.", " ".join(t.get_text().replace("\n", " ") for t in figure.texts))

    def test_one_probability_is_a_sentence(self):
        self.assertIsNone(plot.predictions("t", *self.tables(["far"]), []))


class Importance(unittest.TestCase):
    def table(self, factors):
        events, codes = zip(*factors)
        return reading.Table("importance", {"event": list(events), "component": np.zeros(len(events)), "code": list(codes),
                                            "factor": np.array(list(factors.values()))})

    def test_events_of_the_same_errors_share_a_panel(self):
        figure = plot.importance(self.table({("a", "x"): 0.7, ("a", "y"): 0.3, ("b", "x"): 0.7, ("b", "y"): 0.3, ("c", "y"): 1.0}))
        self.assertEqual([ax.get_title() for ax in figure.axes if ax.axison], ["a\nb", "c"])
        self.assertEqual(sorted(round(bar.get_width()) for bar in figure.axes[0].patches), [30, 70])

    def test_one_error_that_makes_all_is_a_sentence(self):
        self.assertIsNone(plot.importance(self.table({("a", "x"): 0.999, ("a", "y"): 0.001})))


@unittest.skipUnless(WELLS, "SURVEYMC_RESULT is not set")
class Collision(plot_case.Drawing):
    script = "collision"

    def test_every_figure_is_drawn_in_both_forms(self):
        for result, stem, figures in ((WELLS, "collision", ("probability", "contact", "importance", "plane", "convergence")),
                                      (FUNCTIONS, "rare_event", ("probability", "convergence")),
                                      (EVENTS, "msa_event", ("probability", "importance", "convergence"))):
            self.assert_drawn([f"{stem}_{f}" for f in figures], result)

    def test_what_is_not_there_is_said(self):
        self.refused(64, "--point 3", WELLS, "--point", "3")
        self.refused(65, "no such file", WELLS + ".none")


if __name__ == "__main__":
    unittest.main()
