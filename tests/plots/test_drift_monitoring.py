#!/usr/bin/python3
"""Tests of scripts/plot_monitoring.py. Needs a result of drift_monitoring with series (SURVEYMC_RESULT) and one of a
sweep (SURVEYMC_SWEEP_RESULT)."""
import os
import unittest

import numpy as np

import drawing
import mwd_drift_figures
import plot_monitoring as plot
import plotting

RESULT = os.environ.get("SURVEYMC_RESULT", "")
SWEEP = os.environ.get("SURVEYMC_SWEEP_RESULT", "")
MWD = os.environ.get("SURVEYMC_MWD_RESULT", "")


class Parts(unittest.TestCase):
    def test_runs_of_alarms(self):
        self.assertEqual(plot.runs([0, 1, 1, 0, -1]), [(1, 2), (4, 4)])
        self.assertEqual(plot.runs([1, 1]), [(0, 1)])
        self.assertEqual(plot.runs([0, 0]), [])

    def test_sensors_shown(self):
        series = plotting.Table("series", {"sensor": ["a", "b", "c"], "drift_z": np.array([0.0, 1.0, 2.0])})
        self.assertEqual(plot.shown_sensors(series, None), ["b", "a"])
        self.assertEqual(plot.shown_sensors(series, ["c"]), ["c"])
        with self.assertRaisesRegex(plotting.PlotError, "no sensor 'd'"):
            plot.shown_sensors(series, ["d"])


@unittest.skipUnless(RESULT and SWEEP, "SURVEYMC_RESULT or SURVEYMC_SWEEP_RESULT is not set")
class Figures(drawing.Drawing):
    script = "plot_monitoring.py"

    def test_files(self):
        self.assert_drawn([f"drift_csv_{n}" for n in ("decisions", "delay", "predictions")], RESULT)
        self.assert_drawn(["drift_monitoring_operating",
                           *(f"drift_monitoring_point1_{n}" for n in ("curves", "decisions", "delay", "predictions"))],
                          SWEEP, "--point", "1")

    @unittest.skipUnless(MWD, "SURVEYMC_MWD_RESULT is not set")
    def test_mwd_drift(self):
        self.assert_drawn([f"mwd_drift_{n}" for n in ("detection", "point1_tracks", "verdicts")], MWD, "--point", "1")
        self.refused(plotting.USAGE, "--point 2", MWD, "--point", "2")
        with plotting.open_result(MWD, "mwd_drift") as file:
            series = plotting.at_point(plotting.read_table(file, "series"), ["case"], ("Gx",))
        figure = mwd_drift_figures.tracks_figure("title", series)
        ax = next(a for a in figure.axes if a.get_title() == "Gx: drifts")
        self.assertEqual(ax.get_ylabel(), "Bias (mg)")
        true = next(x for x in ax.lines if x.get_label() == "true bias")
        self.assertAlmostEqual(true.get_ydata()[-1], 1.0)

    def test_predictions_are_in_the_units_of_the_sensor(self):
        with plotting.open_result(RESULT, "drift_monitoring") as file:
            series, model = plotting.read_table(file, "series"), plot.read_model(file, [], ())
        self.assertEqual(model.units["pdg_kPa"], "kPa")
        s = plot.of_sensor(series, "pdg_kPa")
        figure = plot.predictions_figure("title", series, model, ["pdg_kPa"])
        line = next(x for x in figure.axes[0].lines if x.get_label() == "reading")
        np.testing.assert_allclose(line.get_ydata(), model["pdg_kPa"][0] + model["pdg_kPa"][1] * s["reading_z"])
        self.assertTrue(12000 < np.median(line.get_ydata()) < 14500)  # bottom-hole pressures of this well

    def test_wrong_use(self):
        self.refused(plotting.USAGE, "--point 9", SWEEP, "--point", "9")
        self.refused(plotting.USAGE, "no sensor 'x'", RESULT, "--sensors", "x")
        self.refused(plotting.BAD_DATA, "not an HDF5 file", str(drawing.SCRIPTS / self.script))


if __name__ == "__main__":
    unittest.main()
