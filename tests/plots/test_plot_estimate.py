#!/usr/bin/python3
"""Tests of surveymc.plots.estimate. SURVEYMC_RESULT: a result of estimate with a sweep of two points."""

import os
import sys
import tempfile
import unittest

import plot_case

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402

RESULT = os.environ.get("SURVEYMC_RESULT", "")
USAGE, BAD_DATA = 64, 65


class PlotEstimate(plot_case.Drawing):
    script = "estimate"

    @unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
    def test_figures(self):
        self.assert_drawn([f"{os.path.basename(RESULT)[:-3]}_point1_{figure}" for figure in ("azimuth", "parameters", "plan", "residuals")],
                          RESULT, "--point", "1")

    @unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
    def test_points(self):
        self.refused(USAGE, "--point I", RESULT)
        self.refused(USAGE, "points 0 to 1", RESULT, "--point", "2")

    def test_what_is_not_a_result(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "r.h5")
            self.refused(BAD_DATA, "no such file", path)
            with result_file(path) as file:
                file.attrs.update({"format": "surveymc", "experiment": "msa_position", "config": ""})
            self.refused(BAD_DATA, "msa_position", path)
            with result_file(path) as file:
                file.attrs.update({"format": "surveymc", "experiment": "estimate", "config": ""})
            self.refused(BAD_DATA, "'parameters' is missing", path)


if __name__ == "__main__":
    unittest.main()
