#!/usr/bin/python3
"""End-to-end tests of vertical_well and sensor_monte_carlo: test_sensor_studies.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import csv
import io
import math
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

EXECUTABLE = None
SOURCE = None
DONE, BAD_INPUT = 0, 65

VERTICAL = """\
experiment = "vertical_well"
seed = 5
trials = 3000
depth_m = 300.0
spacing_m = 30.0
[drilling]
mode = "rotating"
[field]
total_nT = 50000.0
dip_deg = 72.0
[sensor_errors]
accelerometer_bias_mps2 = 0.004
"""

SENSORS = """\
experiment = "sensor_monte_carlo"
seed = 5
trials = 3000
report_md_m = [60.0, 150.0]
[survey]
file = "survey.csv"
toolface_zero = "y"
[drilling]
mode = "survey"
[field]
total_nT = 50000.0
dip_deg = 60.0
declination_deg = 10.0
[sensor_errors]
accelerometer_bias_mps2 = 0.004
accelerometer_scale = 0.0005
magnetometer_bias_nT = 70.0
magnetometer_scale = 0.0016
"""

SURVEY = """\
md_m,inclination_deg,azimuth_deg,toolface_deg
0,10,20,0
30,14,25,50
60,18,30,120
90,22,37,200
120,28,44,300
150,33,52,40
"""


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="surveymc-cli-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.write("vertical.toml", VERTICAL)
        self.write("sensors.toml", SENSORS)
        self.write("survey.csv", SURVEY)

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def call(self, *arguments, code=DONE):
        done = subprocess.run([EXECUTABLE, *map(str, arguments)], cwd=self.folder, timeout=60, capture_output=True,
                              text=True)
        self.assertEqual(done.returncode, code, f"{arguments}\n{done.stdout[:2000]}\n{done.stderr[:2000]}")
        return done

    def run_config(self, name, *arguments, output="out.h5"):
        self.call("run", name, "-o", output, *arguments)
        return self.folder / output

    def rows(self, path, table):
        """Rows of a table as dicts, numbers as float, empty cells as NaN where numbers stand."""
        text = self.call("show", path, table, "--csv").stdout
        return [{k: number(v) for k, v in row.items()} for row in csv.DictReader(io.StringIO(text))]

    def content_hash(self, path):
        with h5py.File(path) as f:
            return f.attrs["content_hash"]

    def refused(self, name, *settings, says):
        arguments = [a for s in settings for a in ("--set", s)]
        done = self.call("run", name, "-o", "never.h5", *arguments, code=BAD_INPUT)
        self.assertRegex(done.stderr, says)
        self.assertEqual(done.stdout, "")
        self.assertFalse((self.folder / "never.h5").exists())


def number(text):
    try:
        return float(text)
    except ValueError:
        return text if text else math.nan


class VerticalWell(Case):
    TILT = 0.004 / 9.80665

    def semi_axes(self, *arguments):
        path = self.run_config("vertical.toml", *arguments)
        return {r["formulation"]: (r["semi_major_m"], r["semi_minor_m"]) for r in self.rows(path, "ellipse")}

    def test_exact_values_rotated(self):
        axes = self.semi_axes()
        independent = self.TILT * 30 * math.sqrt(9.5)
        self.assertAlmostEqual(independent, 0.0377157, delta=1e-7)
        for name in ("fictive_terms", "ti_random", "copegrove_with_half_leg"):
            for axis in axes[name]:
                self.assertAlmostEqual(axis, independent, delta=1e-14)
        for name in ("spe_67616", "ti_systematic", "fictive_terms_accelerometer_toolface"):
            for axis in axes[name]:
                self.assertAlmostEqual(axis / independent, 10 / math.sqrt(9.5), delta=1e-12)
        self.assertAlmostEqual(axes["copegrove_without_half_leg"][0], independent, delta=1e-14)
        self.assertAlmostEqual(axes["copegrove_without_half_leg"][1], independent / 15, delta=1e-14)

    def test_exact_values_slid(self):
        for settings in (("--set", "drilling.mode=sliding"),
                         ("--set", "drilling.mode=sliding", "--set", "drilling.toolface_deg=77.0"),
                         ("--set", "drilling.mode=sliding", "--set", "spacing_m=10.0")):
            axes = self.semi_axes(*settings)
            for name in ("toolface_dependent", "fictive_terms", "ti_systematic", "spe_67616", "copegrove_with_half_leg"):
                for axis in axes[name]:
                    self.assertAlmostEqual(axis, 300 * self.TILT, delta=1e-13)

    def test_a_fixed_sequence_is_a_trial_of_the_rotated_well(self):
        rotated = self.run_config("vertical.toml", "--set", "save_samples=20")
        with h5py.File(rotated) as f:
            ratios = np.sqrt(f["samples/realisations/own_variance_ratio"][()])
        fixed = self.semi_axes("--set", "drilling.mode=fixed_sequence", "--set", "drilling.sequence=7")
        self.assertAlmostEqual(fixed["toolface_dependent"][0] / fixed["ti_random"][0], ratios[7], delta=1e-12)

    def test_spread_of_sequences(self):
        rows = {r["quantity"]: r for r in self.rows(self.run_config("vertical.toml", "--trials", 50000),
                                                     "toolface_sequences")}
        # 5 and 95 % of 50,000 nearly Rayleigh values: standard errors 1 % and 0.4 %
        self.assertAlmostEqual(rows["ratio_q05"]["monte_carlo"], 0.23, delta=0.01)
        self.assertAlmostEqual(rows["ratio_q95"]["monte_carlo"], 1.71, delta=0.03)

    def test_formulations_are_a_choice(self):
        path = self.run_config("vertical.toml", "--set", 'formulations=["spe_67616", "ti_random"]')
        self.assertEqual([r["formulation"] for r in self.rows(path, "ellipse")],
                         ["monte_carlo", "spe_67616", "ti_random"])

    def test_samples_are_the_tallied_positions(self):
        path = self.run_config("vertical.toml", "--set", "save_samples=3000")
        with h5py.File(path) as f:
            s = f["samples/realisations"]
            covariance = np.cov(s["north_m"][()], s["east_m"][()])
        row = self.rows(path, "ellipse")[0]
        values = np.sqrt(np.linalg.eigvalsh(covariance))
        self.assertAlmostEqual(row["semi_major_m"], values[1], delta=1e-12)
        self.assertAlmostEqual(row["semi_minor_m"], values[0], delta=1e-12)

    def test_threads_and_reruns(self):
        hashes = {self.content_hash(self.run_config("vertical.toml", "--threads", n, "--set", "save_samples=700",
                                                    output=f"{n}.h5")) for n in (1, 2, 3, 7)}
        self.assertEqual(len(hashes), 1)
        self.assertIn("identical", self.call("rerun", "3.h5").stdout)

    def test_replay(self):
        path = self.run_config("vertical.toml", "--set", "save_samples=20")
        with h5py.File(path) as f:
            north = f["samples/realisations/north_m"][13]
        text = self.call("run", "vertical.toml", "--trial", 13).stdout
        self.assertIn(f"{north:.17g} m", text)

    def test_bad_input(self):
        for settings, says in (
                (("spacing_m=7.0",), r"spacing_m = 7: must divide depth_m"),
                (("spacing_m=0.05",), r"spacing_m = 0.05: .*3000 intervals"),
                (("spacing_m=-30.0",), r"spacing_m = -30"),
                (("drilling.mode=spinning",), r'drilling.mode = "spinning": must be one of'),
                (("drilling.mode=mixed",), r"drilling.slide_from_m"),
                (('formulations=["ti"]',), r'formulations = .*"ti" is none of toolface_dependent'),
                (('formulations=["ti_random", "ti_random"]',), r"twice"),
                (("field.declination_deg=3.0",), r"field.declination_deg = 3: must be 0"),
                (("sensor_errors.accelerometer_bias_mps2=0.0",), r"accelerometer_bias_mps2"),
                (("sensor_errors.magnetometer_bias_nT=70.0",), r"sensor_errors.magnetometer_bias_nT: unknown key"),
                (("trials=1",), r"trials = 1"),
        ):
            with self.subTest(settings=settings):
                self.refused("vertical.toml", *settings, says=says)


class SensorMonteCarlo(Case):
    def test_prediction_agrees_with_monte_carlo(self):
        path = self.run_config("sensors.toml", "--trials", 20000, "--set",
                               'sweep.drilling.mode=["survey", "sliding", "rotating", "fixed_sequence"]')
        checked = 0
        for r in self.rows(path, "axes"):
            if r["formulation"] == "toolface_dependent" and r["quantity"].startswith("sd_axis"):
                # First order is right along all axes (to 0.1 %, 2e6 trials) but one, 0.1 mm long, where second order adds.
                second_order = (r["drilling.mode"], r["md_m"], r["quantity"]) == ("sliding", 60.0, "sd_axis_3")
                # 20,000 trials, kurtosis up to 6: a standard error of 0.8 %, four of them
                self.assertAlmostEqual(r["ratio"], 0.962 if second_order else 1, delta=0.032, msg=str(r))
                checked += 1
        self.assertEqual(checked, 4 * 2 * 3)

    def test_a_tie_on_has_no_error(self):
        """Config key first_station: Monte Carlo and predictions both leave the first station's errors out, a sixth of the
        variance 60 m from it."""
        variance = {}
        for first in ["measured", "tie_on"]:
            path = self.run_config("sensors.toml", "--set", f"first_station={first}", "--trials", 20000,
                                   output=f"{first}.h5")
            found = {row["formulation"]: row["nn_m2"] + row["ee_m2"] + row["vv_m2"]
                     for row in self.rows(path, "position_covariance") if row["md_m"] == 60}
            variance[first] = found["toolface_dependent"]
            # 4 standard errors of a variance from 20,000 runs (sqrt(2 / n) = 1 %)
            self.assertAlmostEqual(found["monte_carlo"] / found["toolface_dependent"], 1, delta=0.04)
        self.assertLess(variance["tie_on"], 0.95 * variance["measured"])
        self.refused("sensors.toml", "first_station=known", says=r'first_station = "known": must be one of "measured"')

    def test_ellipses_are_the_eigenvectors_of_the_covariances(self):
        path = self.run_config("sensors.toml")
        covariances = {(r["md_m"], r["formulation"]): r for r in self.rows(path, "position_covariance")}
        rows = self.rows(path, "ellipse")
        self.assertEqual(len(rows), 8)
        for r in rows:
            c = covariances[r["md_m"], r["formulation"]]
            values, vectors = np.linalg.eigh([[c["nn_m2"], c["ne_m2"]], [c["ne_m2"], c["ee_m2"]]])
            self.assertAlmostEqual(r["semi_major_m"], math.sqrt(values[1]), delta=1e-12)
            self.assertAlmostEqual(r["semi_minor_m"], math.sqrt(values[0]), delta=1e-12)
            azimuth = math.radians(r["major_azimuth_deg"])
            self.assertAlmostEqual(abs(vectors[:, 1] @ [math.cos(azimuth), math.sin(azimuth)]), 1, delta=1e-12)

    def test_thesis_toolfaces_are_turned(self):
        """The same survey written from x, toolfaces 90 deg less, is the same run."""
        self.write("x.csv", "\n".join(SURVEY.splitlines()[:1] + [
            ",".join(r.split(",")[:3] + [str(float(r.split(",")[3]) - 90)]) for r in SURVEY.splitlines()[1:]]) + "\n")
        a = self.rows(self.run_config("sensors.toml"), "position_covariance")
        b = self.rows(self.run_config("sensors.toml", "--set", "survey.file=x.csv", "--set", "survey.toolface_zero=x"),
                      "position_covariance")
        for x, y in zip(a, b):
            for key in ("nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2"):
                self.assertAlmostEqual(x[key], y[key], delta=1e-12 * (x["nn_m2"] + x["ee_m2"]))

    def test_feet_and_metres(self):
        self.write("feet.csv", "md_ft,inclination_deg,azimuth_deg\n0,0,0\n100,10,20\n200,20,20\n")
        path = self.run_config("sensors.toml", "--set", "survey.file=feet.csv", "--set", "drilling.mode=sliding",
                               "--set", "report_md_m=[30.48]")
        self.assertAlmostEqual(self.rows(path, "axes")[0]["md_m"], 30.48, delta=1e-12)
        self.write("report.toml", SENSORS.replace("report_md_m = [60.0, 150.0]", "report_md_ft = [100.0, 200.0]")
                   .replace("survey.csv", "feet.csv").replace('"survey"', '"rotating"'))
        depths = {r["md_m"] for r in self.rows(self.run_config("report.toml"), "axes")}
        self.assertEqual(sorted(depths), [30.48, 60.96])

    def test_vertical_is_zero_to_first_order(self):
        self.write("down.csv", "md_m,inclination_deg,azimuth_deg\n0,0,0\n30,0,90\n60,0,200\n90,0,10\n")
        path = self.run_config("sensors.toml", "--set", "survey.file=down.csv", "--set", "drilling.mode=rotating",
                               "--set", "report_md_m=[90.0]")
        rows = {(r["formulation"], r["quantity"]): r for r in self.rows(path, "axes")}
        third = rows["toolface_dependent", "sd_axis_3"]
        self.assertEqual((third["analytic"], third["note"]), (0, "zero to first order"))
        self.assertTrue(math.isnan(third["verdict"]) and math.isnan(third["ratio"]))
        self.assertGreater(third["monte_carlo"], 0)  # the second order's
        self.assertNotIn(("toolface_dependent", "nees"), rows)

    def test_threads_and_reruns(self):
        hashes = {self.content_hash(self.run_config("sensors.toml", "--threads", n, "--set", "drilling.mode=rotating",
                                                    "--set", "save_samples=700", output=f"{n}.h5"))
                  for n in (1, 2, 3, 7)}
        self.assertEqual(len(hashes), 1)
        self.assertIn("identical", self.call("rerun", "3.h5").stdout)

    def test_replay(self):
        path = self.run_config("sensors.toml", "--set", "save_samples=20")
        with h5py.File(path) as f:
            s = f["samples/realisations"]
            east = s["east_m"][()][(s["trial"][()] == 13) & (s["md_m"][()] == 150)][0]
        text = self.call("run", "sensors.toml", "--trial", 13).stdout
        printed = float(text.split("at 150 m:")[1].split("east ")[1].split(" m")[0])
        truth = self.rows(path, "ellipse")[5]["center_east_m"]
        self.assertAlmostEqual(printed - truth, east, delta=1e-12)

    def test_bad_input(self):
        for settings, says in (
                (("report_md_m=[61.0]",), r"report_md_m = \[61.*: 61 is not the measured depth of a station"),
                (("report_md_m=[0.0]",), r"0 is not the measured depth of a station after the first"),
                (("report_md_m=[150.0, 60.0]",), r"must increase"),
                (("report_md_m=[]",), r"report_md_m"),
                (("report_md_ft=[100.0]",), r"not together with report_md_m"),
                (("drilling.mode=spinning",), r'drilling.mode = "spinning": must be one of .*survey'),
                (("sensor_errors.multiplier=0.0",), r"sensor_errors.multiplier = 0"),
                (("sensor_errors.accelerometer_bias=0.1",), r"the unit is missing: .*accelerometer_bias_mps2"),
        ):
            with self.subTest(settings=settings):
                self.refused("sensors.toml", *settings, says=says)

    def test_no_errors_at_all(self):
        self.write("none.toml", SENSORS.split("[sensor_errors]")[0])
        self.refused("none.toml", says=r"sensor_errors.*greater than 0")

    def test_toolfaces_are_asked_for_only_where_they_are_used(self):
        self.write("bare.csv", "\n".join(",".join(r.split(",")[:3]) for r in SURVEY.splitlines()) + "\n")
        self.refused("sensors.toml", "survey.file=bare.csv", says=r"bare.csv:1: column toolface_deg: missing")
        self.run_config("sensors.toml", "--set", "survey.file=bare.csv", "--set", "drilling.mode=rotating")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    EXECUTABLE = str(Path(sys.argv[1]).resolve())
    SOURCE = Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
