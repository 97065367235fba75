#!/usr/bin/python3
"""Tests of plot_collision.py on the smoke results, whose paths are in SURVEYMC_RESULT, SURVEYMC_FUNCTIONS and
SURVEYMC_EVENTS. Without them they are skipped."""
import os
import unittest

import drawing

WELLS, FUNCTIONS, EVENTS = (os.environ.get(k, "") for k in ("SURVEYMC_RESULT", "SURVEYMC_FUNCTIONS", "SURVEYMC_EVENTS"))


@unittest.skipUnless(WELLS, "SURVEYMC_RESULT is not set")
class Collision(drawing.Drawing):
    script = "plot_collision.py"

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
