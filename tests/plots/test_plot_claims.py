#!/usr/bin/python3
"""Figures of calibrated claims and of refined sweeps: test_plot_claims.py SURVEYMC SOURCE_FOLDER SMOKE_FOLDER"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

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
        self.assertEqual(names, ["calibration_calibration.png", "calibration_point0_looks.png", "calibration_point1_looks.png",
                                 "calibration_shapes.png"])

    def test_what_is_drawn_is_what_the_tables_say(self):
        with reading.open_result(SMOKE / "calibration.h5", "msa_position") as file:
            calibration, pit, looks = (reading.read_table(file, n) for n in ("calibration", "pit", "looks"))
        keys = [k for k in looks if "." in k]
        points = reading.sweep_points(looks, keys)
        self.assertEqual(calibration.confidence, 0.95)  # "..., simultaneous intervals at 95 %"
        for level in (0.95, 0.8):
            calibration.confidence = looks.confidence = level
            figures = [plot.calibration_figure("t", calibration, keys, points), plot.shapes_figure("t", calibration, pit, keys, points),
                       plot.looks_figure("t", reading.at_point(looks, keys, points[0]))]
            for figure in figures[:2]:
                said = " ".join(t.get_text() for t in figure.texts)
                self.assertIn(f"{100 * level:g} %", said)
                self.assertNotIn("80 %" if level == 0.95 else "95 %", said)
        drawn = sorted(bars[0].get_segments()[0][0][0] for *_, bars in figures[0].axes[0].containers)
        judged = [v != "" for v in calibration["verdict"]]
        np.testing.assert_allclose(drawn, sorted(calibration["deviation_ci_low"][judged]), atol=1e-12)
        left = [d for d, p, v in zip(calibration["deviation"], calibration["p_band"], judged) if v and p < 0.05]
        largest = max(left, key=abs)
        curve = figures[1].axes[0].lines[-1].get_ydata()
        self.assertAlmostEqual(curve[np.argmax(np.abs(curve))], largest)

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
        self.assertIn("has neither calibration nor looks", self.plot("calibration", SMOKE / "reliability_map.h5", code=65)[1])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
