#!/usr/bin/python3
"""Tests of the drawer clearance on the smoke result, whose path is in the environment variable SURVEYMC_RESULT. Without it they
are skipped."""
import os
import types
import unittest

import numpy as np

import plot_case
from surveymc.plots import clearance as plot
from surveymc.plots import geometry, reading, wording

RESULT = os.environ.get("SURVEYMC_RESULT", "")
FIGURES = ("ladder", "separation", "cylinder", "views", "relative", "cloud")


@unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
class Clearance(plot_case.Drawing):
    script = "clearance"

    def test_every_figure_is_drawn_in_both_forms(self):
        self.assert_drawn([f"clearance_{f}" for f in FIGURES], RESULT)

    def test_what_is_not_there_is_said(self):
        self.refused(64, "--point 3", RESULT, "--point", "3")
        self.refused(65, "no such file", RESULT + ".none")

    def data(self):
        with reading.open_result(RESULT, "clearance") as file:
            return plot.Clearance(file, types.SimpleNamespace(result=RESULT, point=None))

    def titles(self, figure):
        return [ax.get_title(loc="left") or ax.get_title() for ax in figure.axes]

    def test_the_smaller_factor_of_the_other_direction_is_said(self):
        data = self.data()
        least = {d: data.least_row("sidetrack", direction=d)["continuous"] for d in ("reference", "offset")}
        self.assertLess(least["offset"], least["reference"])
        title = next(t for t in self.titles(plot.ladder(data)) if t.startswith("sidetrack"))
        self.assertIn(f"along the reference {wording.number(least['reference'])} at", title)
        self.assertTrue(title.endswith(f"along the offset {wording.number(least['offset'])}"), title)
        self.assertNotIn("along the offset", next(t for t in self.titles(plot.ladder(data)) if t.startswith("winding")))

    def test_the_worst_factor_is_drawn_where_it_lies_below_the_axis(self):
        data = self.data()
        rows = [i for i in range(data.least.rows) if data.least["offset"][i] == "winding" and data.least["direction"][i] == "reference"
                and data.least["quantity"][i] == "separation_factor"]
        data.least["continuous"][rows] = -0.187
        ax = plot.separation(data).axes[0]
        low = ax.get_ylim()[0]
        self.assertLess(low, 0.8)
        edge = [line for line in ax.lines if line.get_marker() == "v"]
        self.assertEqual([line.get_ydata()[0] for line in edge], [low] * len(rows))
        self.assertIn("\N{MINUS SIGN}0.187", [t.get_text() for t in ax.texts])

    def test_figures_bear_wells_without_a_covariance(self):
        data = self.data()
        for table, columns in ((data.rows, ("separation_factor", "sd_relative_m")), (data.least, ("continuous", "ref_md_m")),
                               (data.covariance, geometry.COVARIANCE)):
            of = np.array([o == "sidetrack" for o in table["offset"]])
            for c in columns:
                table[c][of] = np.nan
        for draw in (plot.ladder, plot.separation, plot.cylinder, lambda d: plot.views(d, 2), lambda d: plot.relative(d, 2)):
            figure = draw(data)
            figure.canvas.draw()
        self.assertEqual([t for t in self.titles(plot.views(data, 2)) if "sidetrack" in t],
                         ["sidetrack, plan: no covariance there", "sidetrack, section: no covariance there"])


if __name__ == "__main__":
    unittest.main()
