#!/usr/bin/python3
"""Tests of plot_clearance.py on the smoke result, whose path is in the environment variable SURVEYMC_RESULT. Without it they
are skipped."""
import os
import unittest

import drawing

RESULT = os.environ.get("SURVEYMC_RESULT", "")
FIGURES = ("ladder", "separation", "cylinder", "views", "relative", "cloud")


@unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
class Clearance(drawing.Drawing):
    script = "plot_clearance.py"

    def test_every_figure_is_drawn_in_both_forms(self):
        self.assert_drawn([f"clearance_{f}" for f in FIGURES], RESULT)

    def test_what_is_not_there_is_said(self):
        self.refused(64, "--point 3", RESULT, "--point", "3")
        self.refused(65, "no such file", RESULT + ".none")


if __name__ == "__main__":
    unittest.main()
