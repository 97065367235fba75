#!/usr/bin/python3
"""End-to-end tests of axial_correction and the single-station estimators of estimate:
test_axial_correction.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]

Expected values come from a forward model and a weighted least squares of their own.
"""
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, Case, column

TOTAL, DIP, GRAVITY = 50000.0, np.radians(75.0), 9.81
SIGMA = {"xy": 150.0, "z": 220.0, "vertical": 95.0, "axial": 500.0}

STUDY = """\
experiment = "axial_correction"
seed = 3
trials = 4000
inclination_deg = [0.0, 30.0, 85.0, 90.0]
magnetic_azimuth_deg = [35.0, 85.0]
toolface_deg = 147.0
methods = ["basic", "simple", "extended"]
[field]
total_nT = 50000.0
dip_deg = 75.0
[sigma]
magnetometer_xy_nT = 150.0
magnetometer_z_nT = 220.0
vertical_nT = 95.0
axial_magnetisation_nT = 500.0
[error]
magnetometer_bias_nT = [90.0, -60.0, 700.0]
vertical_nT = 50.0
"""

ESTIMATE = """\
experiment = "estimate"
seed = 1
readings = "run.csv"
[estimator]
name = "axial_correction"
method = "extended"
[field]
total_nT = 50000.0
dip_deg = 75.0
declination_deg = 4.0
gravity_mps2 = 9.81
[sigma]
accelerometer_xy_mps2 = 0.006
gravity_mps2 = 0.001
magnetometer_xy_nT = 150.0
magnetometer_z_nT = 220.0
horizontal_nT = 95.0
vertical_nT = 95.0
axial_magnetisation_nT = 500.0
"""


def reading(inclination, azimuth, toolface):
    """Gravity (pointing down) and field in the tool frame, toolface from y; degrees."""
    i, a, t = np.radians([inclination, azimuth, toolface])
    along = np.array([np.sin(i) * np.cos(a), np.sin(i) * np.sin(a), np.cos(i)])
    high = np.array([np.cos(i) * np.cos(a), np.cos(i) * np.sin(a), -np.sin(i)])
    right = np.array([-np.sin(a), np.cos(a), 0])
    y = np.cos(t) * high + np.sin(t) * right
    axes = (np.cross(y, along), y, along)
    field = TOTAL * np.array([np.cos(DIP), 0, np.sin(DIP)])
    return np.array([v[2] * GRAVITY for v in axes]), np.array([v @ field for v in axes])


def extended(g, b, vertical):
    """(azimuth in degrees, Mz) by the matrix of slide 3."""
    lean = np.hypot(g[0], g[1])
    i, htf = np.arctan2(lean, g[2]), np.arctan2(g[1], -g[0])
    si, ci, s, c = np.sin(i), np.cos(i), np.sin(htf), np.cos(htf)
    design = np.array([[ci * c, -s, -si * c, 0], [-ci * s, -c, si * s, 0], [si, 0, ci, 1], [0, 0, 1, 0], [0, 0, 0, 1]])
    weight = 1 / np.array([SIGMA["xy"], SIGMA["xy"], SIGMA["z"], SIGMA["vertical"], SIGMA["axial"]])
    x = np.linalg.lstsq(design * weight[:, None], np.array([*b, vertical, 0]) * weight, rcond=None)[0]
    return np.degrees(np.arctan2(x[1], x[0])) % 360, x[3]


class Study(Case):
    def test_worked_cases_on_the_map(self):
        self.write("study.toml", STUDY)
        result = self.folder / "study.h5"
        self.call("run", self.folder / "study.toml", "-o", result)
        with h5py.File(result) as file:
            error = file["maps/azimuth_error_deg"][()]
            axial = file["maps/axial_magnetisation_error_nT"][()]
        # basic, simple, extended at I 30 A 35 and I 85 A 85, toolface 57 deg from x; printed to three decimals
        np.testing.assert_allclose(error[:, 1, 0], np.array([33.769, 34.484, 34.388]) - 35, atol=6e-4)
        np.testing.assert_allclose(error[:, 2, 1], np.array([81.877, 77.540, 81.604]) - 85, atol=6e-4)
        np.testing.assert_allclose([axial[2, 1, 0], axial[2, 2, 1]], [459.933, -56.999], atol=6e-4)
        self.assertTrue(np.all(np.isinf(error[1, 3])))  # the simple one at I = 90

    def test_same_bits_for_any_number_of_threads(self):
        self.write("study.toml", STUDY + "[monte_carlo]\ninclination_deg = [30.0, 90.0]\nmagnetic_azimuth_deg = 35.0\n")
        values = []
        for threads in ("1", "3"):
            result = self.folder / f"study{threads}.h5"
            self.call("run", self.folder / "study.toml", "-o", result, "--threads", threads)
            values.append(np.asarray(column(result, "tables/verification", "monte_carlo")))
        np.testing.assert_array_equal(*values)

    def test_bad_configs(self):
        for change, word in ((("methods = [\"basic\"", "methods = [\"basics\""), "basics"),
                             (("methods = [\"basic\"", "methods = [\"extended_bh\""), "horizontal_nT"),
                             (("dip_deg = 75.0", "dip_deg = 90.0"), "field.dip_deg"),
                             (("vertical_nT = 95.0", "vertcal_nT = 95.0"), "vertcal_nT"),
                             (("magnetometer_z_nT = 220.0", "magnetometer_z_nT = 0.0"), "magnetometer_z_nT")):
            self.write("bad.toml", STUDY.replace(*change))
            run = self.call("run", self.folder / "bad.toml", "-o", self.folder / "bad.h5", code=BAD_INPUT)
            self.assertIn(word, run.stderr)
            self.assertFalse((self.folder / "bad.h5").exists())


class Estimators(Case):
    def setUp(self):
        super().setUp()
        self.write_readings([90, -60, 700])

    def write_readings(self, bias_nT):
        at = [(30, 35, 147), (60, 200, 20), (85, 85, 147), (90, 90, 300)]
        self.readings = [reading(*x) for x in at]
        for g, b in self.readings:
            b += bias_nT
        lines = [",".join(repr(float(v)) for v in (1000 + 30 * k, *g, *b)) for k, (g, b) in enumerate(self.readings)]
        self.write("run.csv", "md_m,gx_mps2,gy_mps2,gz_mps2,bx_nT,by_nT,bz_nT\n" + "\n".join(lines) + "\n")

    def run_estimate(self, config, *arguments):
        self.write("estimate.toml", config)
        result = self.folder / "estimate.h5"
        self.call("run", self.folder / "estimate.toml", "-o", result, *arguments)
        return result

    def test_against_weighted_least_squares(self):
        result = self.run_estimate(ESTIMATE)
        expected = [extended(g, b, TOTAL * np.sin(DIP)) for g, b in self.readings]
        # 1e-9 of the field in the normal equations of the oracle
        np.testing.assert_allclose(column(result, "tables/stations", "azimuth_magnetic_deg"), [a for a, _ in expected],
                                   atol=1e-8)
        np.testing.assert_allclose(column(result, "tables/stations", "azimuth_true_deg"),
                                   [(a + 4) % 360 for a, _ in expected], atol=1e-8)
        mz = np.asarray(column(result, "tables/stations", "axial_magnetisation_nT"))
        np.testing.assert_allclose(mz, [m for _, m in expected], atol=1e-5)
        sd = np.asarray(column(result, "tables/stations", "sd_axial_magnetisation_nT"))
        low = np.asarray(column(result, "tables/stations", "axial_magnetisation_ci_low_nT"))
        np.testing.assert_allclose(mz - low, 1.959963984540054 * sd, rtol=1e-12)
        self.assertAlmostEqual(sd[3], 500, places=6)  # horizontal: nothing is said about Mz

    def test_methods(self):
        simple = self.run_estimate(ESTIMATE, "--set", "estimator.method=simple")
        determined = list(column(simple, "tables/stations", "determined"))
        self.assertEqual(determined, [1, 1, 1, 0])
        self.assertTrue(np.isnan(column(simple, "tables/stations", "azimuth_magnetic_deg")[3]))
        self.assertIn("severe", list(column(simple, "tables/warnings", "severity")))
        basic = self.run_estimate(ESTIMATE.replace('name = "axial_correction"\nmethod = "extended"',
                                                   'name = "single_station"'))
        with h5py.File(basic) as file:
            self.assertNotIn("axial_magnetisation_nT", file["tables/stations"])
        np.testing.assert_array_equal(column(basic, "tables/stations", "azimuth_magnetic_deg"),
                                      column(basic, "tables/stations", "raw_azimuth_magnetic_deg"))
        self.run_estimate(ESTIMATE, "--set", "estimator.method=extended_bh")

    def test_another_gravity_is_not_taken_for_magnetisation(self):
        single = ESTIMATE.replace('name = "axial_correction"\nmethod = "extended"', 'name = "single_station"')
        self.write_readings([0, 0, 0])
        for text in (ESTIMATE, single):
            for gravity, found in ((9.81, False), (9.75, True)):
                path = self.run_estimate(text, "--set", f"field.gravity_mps2={gravity}")
                with h5py.File(path) as file:
                    warnings = file["tables/warnings"]
                    told = list(zip(warnings["severity"].asstr()[()], warnings["message"].asstr()[()]))
                of_gravity = [t for t in told if "gravity" in t[1]]
                self.assertEqual([severity for severity, _ in of_gravity], ["warning"] * found, told)
                if found:
                    self.assertIn("4 of 4 stations", of_gravity[0][1])
                    self.assertIn("accelerometers", of_gravity[0][1])
                self.assertFalse([t for t in told if "magnetised" in t[1]], told)

    def test_bad_configs(self):
        for change, words in ((("method = \"extended\"", "method = \"basic\""), ("estimator.method", "extended")),
                              (("name = \"axial_correction\"", "name = \"axial\""), ("estimator.name", "single_station")),
                              (("axial_magnetisation_nT = 500.0", "axial_magnetisation_nT = 0.0"), ("axial_magnetisation",)),
                              (("[sigma]", "[noise]\nmagnetometer_nT = 50.0\n[sigma]"), ("noise",)),
                              (("magnetometer_xy_nT = 150.0\n", ""), ("magnetometer_xy_nT",))):
            self.write("bad.toml", ESTIMATE.replace(*change))
            run = self.call("run", self.folder / "bad.toml", "-o", self.folder / "bad.h5", code=BAD_INPUT)
            for word in words:
                self.assertIn(word, run.stderr)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    test_cli.EXECUTABLE = str(Path(sys.argv[1]).resolve())
    test_cli.SOURCE = Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
