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

    def test_estimators_fail_one_by_one_and_rarely(self):
        # Horizontal east: Gauss-Newton does not converge in most runs, and their trials were lost to all estimators.
        text = STUDY.replace("trials = 600", "trials = 200").replace("stations = 5", """stations = 18
inclination_from_deg = 90.0
inclination_to_deg = 90.0
magnetic_azimuth_deg = 90.0
[model]
magnetometer_z = { random_nT = 80.0, walk_nT = 80.0, offset_nT = 600.0 }""")
        out = self.folder / "east.h5"
        self.call("run", self.write("east.toml", text), "-o", out)
        with h5py.File(out) as file:
            table = file["tables/failures"]
            names, status = table["formulation"].asstr()[()], table["status"].asstr()[()]
            count = table["count"][()]
            for name in ("filter", "filter_independent", "smoother", "smoother_independent"):
                self.assertEqual(count[names == name].sum(), 200)
                self.assertGreaterEqual(count[(names == name) & (status == "converged")][0], 198)
            rms = file["tables/rms"]
            self.assertTrue(np.all(rms["failed"][()][rms["formulation"].asstr()[()] == "base"] == 0))

    def test_bad_input(self):
        for text, message in ((STUDY + "[model]\naccelerometer_xy = { random_mg = 0.0 }\n", "random_mg"),
                              (STUDY + "[model]\naccelerometer_xy = { random_nT = 1.0 }\n", "random_nT"),
                              (STUDY.replace("seed = 5", 'seed = 5\nestimators = ["smother"]'), "estimators"),
                              (STUDY.replace("seed = 5", 'seed = 5\nstudy = "outlier"'), "study"),
                              (STUDY.replace("seed = 5", 'seed = 5\nstudy = "outliers"') +
                               "[outliers]\nreading = \"hz\"\nsize_nT = 800.0\n[model]\nfield = { offset_nT = 95.0 }\n",
                               "model.field.offset_nT = 95"),
                              (STUDY + "toolface = \"survey\"\n", "profile.toolface")):
            self.refused(BAD_INPUT, "check", self.write("bad.toml", text), says=message)

    def test_offsets_of_references_are_for_estimators_that_observe_them_anew(self):
        texts = STUDY.replace("trials = 600", "trials = 50"), STUDY.replace("trials = 600", "trials = 50") + (
            "[model]\nfield = { offset_nT = 600.0 }\n")
        rms = []
        for i, text in enumerate(texts):
            out = self.folder / f"offset{i}.h5"
            self.call("run", self.write("offset.toml", text), "-o", out)
            with h5py.File(out) as file:
                t = file["tables/rms"]
                rms.append(dict(zip(zip(t["formulation"].asstr()[()], t["quantity"].asstr()[()]), t["monte_carlo"][()])))
        for name in ("base", "filter", "smoother"):
            self.assertEqual(rms[0][name, "horizontal_nT"], rms[1][name, "horizontal_nT"])
        for name in ("single", "filter_independent", "smoother_independent"):
            self.assertNotEqual(rms[0][name, "horizontal_nT"], rms[1][name, "horizontal_nT"])

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

    def test_horizontal_east_is_solved_and_its_claims_are_doubted(self):
        toolface = np.arange(0.0, 360.0, 24.0)
        inclination, azimuth = np.full(15, 90.0), np.full(15, 90.0)
        gravity, field = test_estimate.true_readings(inclination, azimuth, toolface)
        random = np.random.default_rng(3)
        field += 80 * random.standard_normal(field.shape) + np.array([0, 0, 700.0])
        gravity += 3e-3 * random.standard_normal(gravity.shape)
        self.write_run(gravity, field)
        with h5py.File(self.result(READINGS.replace("walk_nT = 80.0 }", "walk_nT = 80.0, offset_nT = 1000.0 }"))) as file:
            profile = file["tables/profile"]
            self.assertTrue(np.any(profile["claims_hold"][()] == 0))
            self.assertIn("claimed sd do not hold", " ".join(file["tables/warnings/message"].asstr()))

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
                              (READINGS + "[tests]\nalpha_w = 0.001\n", "tests.alpha_w"),
                              # An offset of a chained reference would change nothing.
                              (READINGS + "gravity = { offset_mg = 1.0 }\n", "model.gravity.offset_mg = 1"),
                              (READINGS + "field = { offset_nT = 95.0 }\n", "model.field.offset_nT = 95")):
            self.refused(BAD_INPUT, "check", self.write("bad.toml", text), says=message)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    test_cli.EXECUTABLE = str(Path(sys.argv[1]).resolve())
    test_cli.SOURCE = Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
