#!/usr/bin/python3
"""Tests of surveymc.plots.monitoring. Needs a result of drift_monitoring with series (SURVEYMC_RESULT) and one of a
sweep (SURVEYMC_SWEEP_RESULT)."""
import os
import unittest

import matplotlib
import numpy as np
from matplotlib.collections import PolyCollection

import plot_case
from surveymc.plots import mwd_drift_figures
from surveymc.plots import monitoring as plot
from surveymc import arguments
from surveymc.plots import reading

RESULT = os.environ.get("SURVEYMC_RESULT", "")
SWEEP = os.environ.get("SURVEYMC_SWEEP_RESULT", "")
MWD = os.environ.get("SURVEYMC_MWD_RESULT", "")


class Parts(unittest.TestCase):
    def test_runs_of_alarms(self):
        self.assertEqual(plot.runs([0, 1, 1, 0, -1]), [(1, 2), (4, 4)])
        self.assertEqual(plot.runs([1, 1]), [(0, 1)])
        self.assertEqual(plot.runs([0, 0]), [])

    def test_sensors_shown(self):
        series = reading.Table("series", {"sensor": ["a", "b", "c"], "drift_z": np.array([0.0, 1.0, 2.0])})
        self.assertEqual(plot.shown_sensors(series, None), ["b", "a"])
        self.assertEqual(plot.shown_sensors(series, ["c"]), ["c"])
        with self.assertRaisesRegex(reading.PlotError, "no sensor 'd'"):
            plot.shown_sensors(series, ["d"])


def words(figure):
    """All texts of a figure."""
    return " ".join(" ".join(t.get_text().split()) for t in figure.findobj(matplotlib.text.Text))


class Captions(unittest.TestCase):
    """Levels, margins and scales are those of the tables."""

    def tables(self, path, experiment, *names):
        with reading.open_result(path, experiment) as file:
            found = [reading.read_table(file, n) for n in names]
        for table in found:
            table.long_name = table.long_name.replace("95 %", "80 %")
            table.confidence = 0.8
        return found

    @unittest.skipUnless(SWEEP, "SURVEYMC_SWEEP_RESULT is not set")
    def test_levels_of_drift_monitoring(self):
        delay, blame, operating = self.tables(SWEEP, "drift_monitoring", "delay", "blame", "operating")
        keys = ["sprt.shift_z"]
        points = reading.sweep_points(blame, keys)
        of = [reading.at_point(t, keys, points[0]) for t in (delay, blame, operating)]
        for figure in (plot.operating_figure("t", delay, blame, keys, points), plot.delay_figure("t", of[0], of[1], None),
                       plot.curves_figure("t", of[2])):
            self.assertIn("80 % interval", words(figure))
            self.assertNotIn("95 % interval", words(figure))
        for table in (delay, blame, *of):
            table["trials"][:] = 3
        for figure in (plot.operating_figure("t", delay, blame, keys, points), plot.delay_figure("t", of[0], of[1], None),
                       plot.curves_figure("t", of[2])):  # intervals of three realisations are those of nothing
            self.assertIn("too few for intervals", words(figure))
            self.assertEqual([c for ax in figure.axes for c in ax.collections if c.get_visible() and len(c.get_paths())], [])

    @unittest.skipUnless(SWEEP, "SURVEYMC_SWEEP_RESULT is not set")
    def test_the_longest_median_is_in_the_panel(self):
        delay, blame = self.tables(SWEEP, "drift_monitoring", "delay", "blame")
        delay["delay_q95_h"][:] = np.inf
        keys = ["sprt.shift_z"]
        points = reading.sweep_points(blame, keys)
        finite = delay["delay_q50_h"][np.isfinite(delay["delay_q50_h"])]
        top = plot.operating_figure("t", delay, blame, keys, points).axes[0].get_xlim()[1]
        self.assertGreater(top, np.max(finite))
        self.assertLess(top, 2 * np.max(finite))
        delay["delay_q50_h"][:] = delay["delay_q05_h"][:] = np.inf
        self.assertEqual(plot.longest(delay), 1.0)

    @unittest.skipUnless(MWD, "SURVEYMC_MWD_RESULT is not set")
    def test_levels_and_margins_of_mwd_drift(self):
        curve, comparison = self.tables(MWD, "mwd_drift", "alarm_curve", "comparison")
        points = reading.sweep_points(curve, ["case"])
        verdicts = mwd_drift_figures.verdicts_figure("t", comparison, ["case"], points)
        for figure in (verdicts, mwd_drift_figures.detection_figure("t", curve, ["case"], points)):
            self.assertIn("80 % interval", words(figure))
            self.assertNotIn("95 % interval", words(figure))
        bands = [c.get_paths()[0].get_extents() for c in verdicts.axes[0].collections if isinstance(c, PolyCollection)]
        for (formulation, quantity, _), band in zip(mwd_drift_figures.ROWS, bands, strict=False):
            margin = comparison.row(formulation=formulation, quantity=quantity)["margin"]
            np.testing.assert_allclose((band.x0, band.x1), (1 - margin, 1 + margin), rtol=1e-12)
        self.assertEqual(len(bands), 4)
        self.assertIn("1 \N{PLUS-MINUS SIGN} 0.02 to 0.06", words(verdicts))


@unittest.skipUnless(RESULT and SWEEP, "SURVEYMC_RESULT or SURVEYMC_SWEEP_RESULT is not set")
class Figures(plot_case.Drawing):
    script = "monitoring"

    def test_files(self):
        self.assert_drawn([f"drift_csv_{n}" for n in ("decisions", "delay", "predictions")], RESULT)
        self.assert_drawn(["drift_monitoring_operating",
                           *(f"drift_monitoring_point1_{n}" for n in ("curves", "decisions", "delay", "predictions"))],
                          SWEEP, "--point", "1")

    @unittest.skipUnless(MWD, "SURVEYMC_MWD_RESULT is not set")
    def test_mwd_drift(self):
        self.assert_drawn([f"mwd_drift_{n}" for n in ("detection", "point1_tracks", "verdicts")], MWD, "--point", "1")
        self.refused(arguments.USAGE, "--point 2", MWD, "--point", "2")
        with reading.open_result(MWD, "mwd_drift") as file:
            series = reading.at_point(reading.read_table(file, "series"), ["case"], ("Gx",))
        figure = mwd_drift_figures.tracks_figure("title", series)
        ax = next(a for a in figure.axes if a.get_title() == "Gx: drifts")
        self.assertEqual(ax.get_ylabel(), "Bias (mg)")
        true = next(x for x in ax.lines if x.get_label() == "true bias")
        self.assertAlmostEqual(true.get_ydata()[-1], 1.0)

    def test_predictions_are_in_the_units_of_the_sensor(self):
        with reading.open_result(RESULT, "drift_monitoring") as file:
            series, model = reading.read_table(file, "series"), plot.read_model(file, [], ())
        self.assertEqual(model.units["pdg_kPa"], "kPa")
        s = plot.of_sensor(series, "pdg_kPa")
        figure = plot.predictions_figure("title", series, model, ["pdg_kPa"])
        line = next(x for x in figure.axes[0].lines if x.get_label() == "reading")
        np.testing.assert_allclose(line.get_ydata(), model["pdg_kPa"][0] + model["pdg_kPa"][1] * s["reading_z"])
        self.assertTrue(12000 < np.median(line.get_ydata()) < 14500)  # bottom-hole pressures of this well

    def test_wrong_use(self):
        self.refused(arguments.USAGE, "--point 9", SWEEP, "--point", "9")
        self.refused(arguments.USAGE, "no sensor 'x'", RESULT, "--sensors", "x")
        self.refused(reading.BAD_DATA, "not an HDF5 file", __file__)


if __name__ == "__main__":
    unittest.main()
