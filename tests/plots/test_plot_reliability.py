#!/usr/bin/python3
"""Figures of scripts/plot_reliability.py from the smoke run: SURVEYMC_RESULT names its file, SURVEYMC_COMBINATION that of
the smoke run of combinations, SURVEYMC the program."""
import os
import subprocess
import tempfile
import unittest

import drawing

RESULT = os.environ["SURVEYMC_RESULT"]


class Reliability(drawing.Drawing):
    script = "plot_reliability.py"

    def test_figures(self):
        self.assertEqual(sorted(self.figures(RESULT, "--observation", "bx")),
                         ["reliability_map_azimuth.png", "reliability_map_azimuth.svg",
                          "reliability_map_nonlinear.png", "reliability_map_nonlinear.svg"])

    def test_residuals_of_figure_1(self):
        config = drawing.SCRIPTS / "../configs/reliability/fig1.toml"
        with tempfile.TemporaryDirectory() as folder:
            result = os.path.join(folder, "fig1.h5")
            subprocess.run([os.environ["SURVEYMC"], "run", config, "-o", result], check=True, capture_output=True, timeout=60)
            self.assertEqual([n for n in sorted(self.figures(result)) if n.endswith(".png")],
                             ["fig1_inclination.png", "fig1_residuals.png"])

    def test_combinations(self):
        self.assertEqual([n for n in sorted(self.figures(os.environ["SURVEYMC_COMBINATION"])) if n.endswith(".png")],
                         ["reliability_combination_azimuth.png", "reliability_combination_direction.png"])

    def test_bad_requests(self):
        for code, word, *arguments in ((64, "panels", RESULT), (64, "--observation", RESULT, "--observation", "gx"),
                                       (65, "no such file", RESULT + "x"), (64, "--effect", RESULT, "--effect", "depth")):
            self.refused(code, word, *arguments)


if __name__ == "__main__":
    unittest.main()
