#!/usr/bin/python3
"""Figures of surveymc.plots.chained from the smoke runs: SURVEYMC_SMOKE_RESULTS names their folder."""
import argparse
import contextlib
import io
import os
import unittest

import numpy as np

import plot_case
from surveymc.plots import chained
from surveymc.plots import reading

FOLDER = os.environ["SURVEYMC_SMOKE_RESULTS"]


class Chained(plot_case.Drawing):
    script = "chained"

    def check(self, result, names):
        self.assert_drawn(names, os.path.join(FOLDER, result + ".h5"))

    def test_performance(self):
        self.check("chained", [f"chained_{kind}_{truth}" for kind in ("rms", "tracks", "consistency") for truth in
                               ("constant", "chained")])

    def test_others(self):
        for result in ("chained_outliers", "chained_interference", "chained_unstart"):
            self.check(result, [result])

    def test_one_point_of_a_sweep(self):
        result = os.path.join(FOLDER, "chained.h5")
        self.assert_drawn([f"chained_{kind}_chained" for kind in ("rms", "tracks", "consistency")], result, "--point", "1")
        self.refused(64, "--point 2", result, "--point", "2")

    def test_a_large_sweep_is_drawn_in_part(self):
        with reading.open_result(os.path.join(FOLDER, "chained_outliers.h5"), "chained_multistation") as file:
            table = reading.read_table(file, "outliers")
        keys, rows = ["case"], table.rows
        many = reading.Table("outliers", {k: [f"case {i}" for i in range(40) for _ in range(rows)] if k == "case" else
                                           (list(v) * 40 if isinstance(v, list) else np.tile(v, 40)) for k, v in table.items()}, table.long_name)
        with contextlib.redirect_stderr(io.StringIO()) as said:
            title, shown = chained.shown_cases(argparse.Namespace(point=None, result="r.h5"), "Run", many, keys)
        self.assertEqual((title, len(set(shown["case"]))), ("Run (the first 12 of 40 points)", 12))
        self.assertIn("points 0 to 11 of 40", said.getvalue())

    def test_readings(self):
        self.check("estimate_chained", ["estimate_chained_run_filter", "estimate_chained_run_smoother"])


if __name__ == "__main__":
    unittest.main()
