#!/usr/bin/python3
"""Figures of scripts/plot_axial_correction.py from the smoke run: SURVEYMC_RESULT names its file."""
import os
import unittest

import drawing

RESULT = os.environ["SURVEYMC_RESULT"]


class AxialCorrection(drawing.Drawing):
    script = "plot_axial_correction.py"

    def test_figures(self):
        for point in (0, 1):
            names = [f"axial_correction_point{point}_{n}.{e}" for n in ("curves", "maps") for e in ("png", "svg")]
            self.assertEqual(sorted(self.figures(RESULT, "--point", str(point))), names)

    def test_bad_requests(self):
        self.refused(64, "--point", RESULT, "--point", "7")
        self.refused(65, "no such file", RESULT + "x")


if __name__ == "__main__":
    unittest.main()
