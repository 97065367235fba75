#!/usr/bin/python3
"""Figures of calibrated claims and of refined sweeps: test_plot_claims.py SURVEYMC SOURCE_FOLDER SMOKE_FOLDER"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import plot_case
from surveymc.plots import calibration as plot
from surveymc.plots import reading

EXECUTABLE, SOURCE, SMOKE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])


class Claims(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="surveymc-plots-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def plot(self, script, result, code=0):
        done = plot_case.draw(script, result, "-o", self.folder)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        return sorted(p.name for p in self.folder.glob("*.png")), done.stderr

    def test_what_a_result_claims(self):
        names, _ = self.plot("calibration", SMOKE / "calibration.h5")
        for figure in ["calibration_family.png", "calibration_point1_calibration.png", "calibration_point1_histogram.png",
                       "calibration_point1_looks.png", "calibration_point1_merit.png"]:
            self.assertIn(figure, names)

    def test_levels_are_those_of_the_tables(self):
        with reading.open_result(SMOKE / "calibration.h5", "msa_position") as file:
            found = {n: reading.read_table(file, n) for n in ("calibration", "pit", "looks")}
        keys = [k for k in found["looks"] if "." in k]
        point = reading.sweep_points(found["looks"], keys)[0]
        calibration, pit, looks = (reading.at_point(t, keys, point) for t in found.values())
        self.assertEqual(calibration.confidence, 0.95)  # "..., simultaneous intervals at 95 %"
        widths = {}
        self.addCleanup(setattr, plot, "MOST_PANELS", plot.MOST_PANELS)
        plot.MOST_PANELS = 2
        for level in (0.95, 0.8):
            calibration.confidence = looks.confidence = level
            figures = [plot.calibration_figure("t", calibration, pit), plot.histogram_figure("t", calibration, pit),
                       plot.looks_figure("t", looks)]
            for figure in figures:
                said = " ".join(t.get_text() for t in figure.legends[0].get_texts())
                self.assertIn(f"{100 * level:g} %", said)
                self.assertNotIn("80 %" if level == 0.95 else "95 %", said)
            extents = figures[1].axes[0].patches[0].get_extents().transformed(figures[1].axes[0].transData.inverted())
            widths[level] = extents.height
        self.assertAlmostEqual(widths[0.8] / widths[0.95], 1.2815516 / 1.9599640, places=6)

    def test_what_differs_between_two_results(self):
        runs = []
        for seed, bias in ((1, 0.0), (2, 0.0), (3, 160.0)):
            runs.append(self.folder / f"seed{seed}.h5")
            subprocess.run([EXECUTABLE, "run", SOURCE / "configs/calibration/msa_joint.toml", "-o", runs[-1], "--quiet", "--trials", "2000",
                            "--seed", str(seed), "--set", f"sensor.bias_nT=[{bias}, 0.0, 0.0]",
                            "--set", 'calibration.truth="as_is"'], check=True, timeout=200)
        os.environ["SURVEYMC"] = str(EXECUTABLE)
        for other, name in ((runs[1], "seed2_difference.png"), (runs[2], "seed3_difference.png")):
            done = plot_case.draw("difference", runs[0], other, "-o", self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((self.folder / name).exists())
        # The same draws: nothing that chance can move.
        done = plot_case.draw("difference", runs[0], runs[0])
        self.assertEqual(done.returncode, 65)
        self.assertIn("no value that chance can move", done.stderr)

    def test_a_first_round_along_a_boundary(self):
        result = self.folder / "harm.h5"
        subprocess.run([EXECUTABLE, "run", SOURCE / "configs/sweeps/msa_harm_boundary.toml", "-o", result, "--quiet",
                        "--set", "sweep.inclination_deg=[10.0, 60.0, 110.0]", "--set", "sweep.azimuth_deg=[0.0, 60.0, 120.0]",
                        "--set", "sweep.well.stations=[10, 30]"], check=True, timeout=200)
        self.assertEqual(self.plot("refined", result)[0], ["harm_refined.png"])

    def test_what_explains_a_quantity(self):
        self.assertEqual(self.plot("sensitivity", SMOKE / "sensitivity.h5")[0], ["sensitivity_sensitivity_semi_major_m.png"])

    def test_other_results_are_refused_in_a_line(self):
        self.assertIn("has no [refine]", self.plot("refined", SMOKE / "calibration.h5", code=65)[1])
        self.assertIn("has no [sensitivity]", self.plot("sensitivity", SMOKE / "reliability_map.h5", code=65)[1])
        self.assertIn("has neither calibration", self.plot("calibration", SMOKE / "reliability_map.h5", code=65)[1])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
