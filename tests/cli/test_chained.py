#!/usr/bin/python3
"""End-to-end tests of chained multistation: test_chained.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]"""
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, Case, content_hash
import test_estimate

STUDY = """\
experiment = "chained_multistation"
seed = 5
trials = 600
[field]
total_nT = 50000.0
dip_deg = 75.0
[profile]
stations = 5
"""

READINGS = test_estimate.CONFIG[:test_estimate.CONFIG.index("[noise]")].replace('"msa"', '"chained"') + """\
[model]
magnetometer_z = { random_nT = 80.0, walk_nT = 80.0 }
"""


class Study(Case):
    def test_any_number_of_threads_gives_the_same_bits(self):
        path = self.write("study.toml", STUDY)
        hashes = set()
        for threads in ("1", "2", "3"):
            out = self.folder / f"t{threads}.h5"
            self.call("run", path, "-o", out, "--threads", threads)
            hashes.add(content_hash(out))
        self.assertEqual(len(hashes), 1)

    def test_bad_input(self):
        for text, message in ((STUDY + "[model]\naccelerometer_xy = { random_mg = 0.0 }\n", "random_mg"),
                              (STUDY + "[model]\naccelerometer_xy = { random_nT = 1.0 }\n", "random_nT"),
                              (STUDY.replace("seed = 5", 'seed = 5\nestimators = ["smother"]'), "estimators"),
                              (STUDY.replace("seed = 5", 'seed = 5\nstudy = "outlier"'), "study"),
                              (STUDY + "toolface = \"survey\"\n", "profile.toolface")):
            self.refused(BAD_INPUT, "check", self.write("bad.toml", text), says=message)

    def test_replay_repeats_a_trial(self):
        path = self.write("study.toml", STUDY)
        self.assertIn("smoother: converged", self.call("run", path, "--trial", "7").stdout)


class Readings(Case):
    def write_run(self, gravity, field):
        rows = [f"{1000 + 30 * k}," + ",".join(f"{x:.9f}" for x in (*g, *b))
                for k, (g, b) in enumerate(zip(gravity, field))]
        self.write("run.csv", test_estimate.HEADER + "\n" + "\n".join(rows) + "\n")

    def result(self, text):
        out = self.folder / "out.h5"
        self.call("run", self.write("run.toml", text), "-o", out)
        return out

    def test_readings_without_errors_give_their_attitudes(self):
        inclination, azimuth, toolface = test_estimate.attitudes()
        self.write_run(*test_estimate.true_readings(inclination, azimuth, toolface))
        for mode in ("smoother", "filter"):
            text = READINGS.replace('estimator = "chained"', f'estimator = {{ name = "chained", mode = "{mode}" }}')
            with h5py.File(self.result(text)) as file:
                table = file["tables/stations"]
                # the file has nine digits: 1e-9 m/s2 of 9.8, 1e-9 nT of 20000
                np.testing.assert_allclose(table["inclination_deg"], inclination, atol=1e-6)
                np.testing.assert_allclose(table["azimuth_true_deg"], azimuth, atol=1e-5)
                np.testing.assert_allclose(table["toolface_deg"], toolface, atol=1e-5)
                self.assertTrue(np.all(table["sd_azimuth_deg"][()] > 0))
                self.assertEqual(file["tables/fit"]["ambiguous"][0], 0)

    def test_a_gross_error_is_blamed_and_signs_are_those_of_the_file(self):
        gravity, field = test_estimate.true_readings(*test_estimate.attitudes())
        gravity[7, 2] += 0.2  # m/s2: 20 mg
        self.write_run(gravity, field)
        with h5py.File(self.result(READINGS)) as file:
            tests = file["tables/tests"]
            names, station = list(tests["component"].asstr()), tests["station"][()]
            row = next(i for i in range(len(names)) if station[i] == 8 and names[i] == "gz")
            self.assertEqual(tests["decision"].asstr()[row], "rejected")
            self.assertAlmostEqual(tests["error"][row], 20.4, delta=1.0)  # mg, positive as in the file
            self.assertIn("station 8", " ".join(file["tables/warnings/message"].asstr()))

    def test_bad_input(self):
        self.write_run(*test_estimate.true_readings(*test_estimate.attitudes()))
        for text, message in ((READINGS + "[noise]\nmagnetometer_nT = 50.0\n", "noise"),
                              (READINGS.replace('estimator = "chained"', 'estimator = { name = "chained", mode = "both" }'),
                               "estimator.mode"),
                              (READINGS + "[tests]\nalpha_w = 0.001\n", "tests.alpha_w")):
            self.refused(BAD_INPUT, "check", self.write("bad.toml", text), says=message)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    test_cli.EXECUTABLE = str(Path(sys.argv[1]).resolve())
    test_cli.SOURCE = Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
