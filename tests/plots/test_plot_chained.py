#!/usr/bin/python3
"""Figures of scripts/plot_chained.py from the smoke runs: SURVEYMC_SMOKE_RESULTS names their folder."""
import os
import unittest

import drawing

FOLDER = os.environ["SURVEYMC_SMOKE_RESULTS"]


class Chained(drawing.Drawing):
    script = "plot_chained.py"

    def check(self, result, names):
        self.assert_drawn(names, os.path.join(FOLDER, result + ".h5"))

    def test_performance(self):
        self.check("chained", [f"chained_{kind}_{truth}" for kind in ("rms", "tracks", "consistency") for truth in
                               ("constant", "chained")])

    def test_others(self):
        for result in ("chained_outliers", "chained_interference", "chained_unstart"):
            self.check(result, [result])

    def test_readings(self):
        self.check("estimate_chained", ["estimate_chained_run_filter", "estimate_chained_run_smoother"])


if __name__ == "__main__":
    unittest.main()
