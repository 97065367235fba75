#!/usr/bin/python3
"""Tests of the drawer error_model_monte_carlo on the smoke result, whose folder is in the environment variable
SURVEYMC_SMOKE_RESULTS; and on a map that the program given as argument runs."""
import os
import subprocess
import sys
import tempfile
import unittest

import plot_case
from surveymc.plots import reading

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402

FOLDER = os.environ.get("SURVEYMC_SMOKE_RESULTS", "")
EXECUTABLE = sys.argv.pop(1)

MAP = """\
experiment = "error_model_monte_carlo"
seed = 1
trials = 200
error_model = "iscwsa_mwd_rev5.10"
[well]
length_m = 600.0
vertical_m = 90.0
[field]
total_nT = 50000.0
dip_deg = 72.0
[sweep]
"well.inclination_deg" = [30.0, 60.0]
"well.azimuth_deg" = [0.0, 90.0, 180.0]
"errors.multiplier" = [1.0, 3.0]
"""


class ErrorModelMonteCarlo(plot_case.Drawing):
    script = "error_model_monte_carlo"

    def check(self, result, figures):
        self.assert_drawn([f"{os.path.splitext(os.path.basename(result))[0]}_{f}" for f in figures], result)

    @unittest.skipUnless(FOLDER, "SURVEYMC_SMOKE_RESULTS is not set")
    def test_ratio_cloud_and_sources(self):
        self.check(os.path.join(FOLDER, "error_model_monte_carlo.h5"), ("ratio", "cloud", "sources"))

    def test_a_map_over_inclination_and_azimuth(self):
        with tempfile.TemporaryDirectory() as folder:
            config, result = os.path.join(folder, "map.toml"), os.path.join(folder, "map.h5")
            with open(config, "w", encoding="utf-8") as file:
                file.write(MAP)
            subprocess.run([EXECUTABLE, "run", config, "-o", result], check=True, capture_output=True)
            self.check(result, ("map",))

    def test_tables_that_are_missing(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "empty.h5")
            with result_file(path) as file:
                file.attrs.update({"format": "surveymc", "experiment": "error_model_monte_carlo", "config": ""})
            run = plot_case.draw(self.script, path)
            self.assertEqual(run.returncode, reading.BAD_DATA, run.stderr)
            self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)


if __name__ == "__main__":
    unittest.main()
