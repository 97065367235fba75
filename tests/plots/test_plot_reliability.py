#!/usr/bin/python3
"""Figures of surveymc.plots.reliability from the smoke run: SURVEYMC_RESULT names its file, SURVEYMC_COMBINATION that of
the smoke run of combinations, SURVEYMC the program."""
import os
import subprocess
import tempfile
import unittest

import numpy as np

import plot_case
import matplotlib.pyplot as plt
from surveymc.plots import reliability_figures

RESULT = os.environ["SURVEYMC_RESULT"]


class Reliability(plot_case.Drawing):
    script = "reliability"

    def test_figures(self):
        self.assertEqual(sorted(self.figures(RESULT, "--observation", "bx")),
                         ["reliability_map_azimuth.png", "reliability_map_azimuth.svg",
                          "reliability_map_nonlinear.png", "reliability_map_nonlinear.svg"])

    def test_many_panels_take_several_figures(self):
        run = plot_case.draw(self.script, RESULT, names_only=True)  # pages are drawn alike
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual(sorted(os.path.basename(path) for path in run.stdout.split()),
                         [f"reliability_map_{kind}_{page}.png" for kind in ("azimuth", "nonlinear") for page in (1, 2)])

    def test_a_constant_map_has_no_lines_through_its_rounding_errors(self):
        axes = plt.figure().subplots()
        x = np.arange(7.0)
        sizes = 654.335 * (1 + 1e-14 * np.add.outer(x, -x))
        reliability_figures.panel(axes, x, x, sizes, ("toolface", "magnetic_azimuth"), "")
        self.assertEqual(len(axes.texts), 0)  # labels of contours
        sizes[3, 3] = 700
        reliability_figures.panel(axes, x, x, sizes, ("toolface", "magnetic_azimuth"), "", levels=np.array([660.0, 680.0]))
        self.assertGreater(len(axes.texts), 0)

    def test_residuals_of_figure_1(self):
        config = plot_case.SCRIPTS / "../configs/reliability/fig1.toml"
        with tempfile.TemporaryDirectory() as folder:
            result = os.path.join(folder, "fig1.h5")
            subprocess.run([os.environ["SURVEYMC"], "run", config, "-o", result], check=True, capture_output=True, timeout=60)
            self.assertEqual([n for n in sorted(self.figures(result)) if n.endswith(".png")],
                             ["fig1_inclination.png", "fig1_residuals.png"])

    def test_combinations(self):
        self.assertEqual([n for n in sorted(self.figures(os.environ["SURVEYMC_COMBINATION"])) if n.endswith(".png")],
                         ["reliability_combination_azimuth.png", "reliability_combination_direction.png"])

    def test_bad_requests(self):
        for code, word, *arguments in ((64, "--observation", RESULT, "--observation", "gx"),
                                       (65, "no such file", RESULT + "x"), (64, "--effect", RESULT, "--effect", "depth")):
            self.refused(code, word, *arguments)


if __name__ == "__main__":
    unittest.main()
