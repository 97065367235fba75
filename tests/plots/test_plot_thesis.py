#!/usr/bin/python3
"""Tests of surveymc.plots.thesis and error_ellipsoids.

Most need the program, which runs the shipped configs with few trials: its path in the environment variable SURVEYMC.
Without it they are skipped.
"""

import os
import subprocess
import tempfile
import unittest

import numpy as np

import plot_case
from surveymc.plots import error_ellipsoids
from surveymc.plots import thesis
from surveymc.plots import reading

ROOT = plot_case.SCRIPTS.parent
PROGRAM = os.environ.get("SURVEYMC", "")
ELSEWHERE = """experiment = "msa_position"
seed = 2
trials = 50
[survey]
file = "{survey}"
toolface_zero = "x"
azimuth_reference = "{north}"
[field]
{field}
[noise]
magnetometer_nT = 70.0
[estimator]
name = "msa"
[[sweep.case]]
name = "a"
"sensor.bias_nT" = [250.0, 295.0, -335.0]
"""


def draw(*arguments):
    return plot_case.draw("thesis", *arguments)


class Geometry(unittest.TestCase):
    def test_axes_of_the_hole(self):
        for inclination in (0, 1e-8, 0.3, np.pi / 2, np.pi):
            for azimuth in (0, 1e-8, 1.1, np.pi, 5.0):
                t = error_ellipsoids.hla_from_nev(inclination, azimuth)
                np.testing.assert_allclose(t @ t.T, np.eye(3), atol=1e-15)
                self.assertAlmostEqual(np.linalg.det(t), 1)
        # A horizontal hole to the east: high side is up, lateral is to the right (south), along hole is east.
        t = error_ellipsoids.hla_from_nev(np.pi / 2, np.pi / 2)
        np.testing.assert_allclose(t, [[0, 0, -1], [-1, 0, 0], [0, 1, 0]], atol=1e-15)

    def test_outline_satisfies_the_equation_of_the_ellipse(self):
        c = np.array([[36.0, -20.0, 0.003], [-20.0, 18.0, -0.002], [0.003, -0.002, 3e-5]])
        for x, y in ((1, 0), (0, 2), (1, 2)):
            points = np.array(error_ellipsoids.outline(c, x, y))
            inverse = np.linalg.inv(c[np.ix_((x, y), (x, y))])
            np.testing.assert_allclose(np.einsum("ik,ij,jk->k", points, inverse, points), 9, rtol=1e-9)

    def test_degenerate_outlines_are_lines(self):
        flat = np.diag([4.0, 9.0, 0.0])
        px, py = error_ellipsoids.outline(flat, 0, 2)  # no vertical at all
        self.assertEqual((px.min(), px.max()), (-6, 6))
        self.assertEqual(np.abs(py).max(), 0)
        px, py = error_ellipsoids.outline(flat, 2, 0)
        self.assertEqual(np.abs(px).max(), 0)
        self.assertAlmostEqual(py.max() - py.min(), 12)
        line = np.array([[4.0, 6.0, 0], [6.0, 9.0, 0], [0, 0, 0]])  # a plane well: one direction only
        px, py = error_ellipsoids.outline(line, 1, 0)
        np.testing.assert_allclose(py, px * 2 / 3, atol=1e-12)
        self.assertAlmostEqual(px.max(), 9)
        self.assertTrue(error_ellipsoids.is_line(line, 1, 0))
        self.assertFalse(error_ellipsoids.is_line(flat, 0, 1))

    def test_surface_of_an_ellipsoid(self):
        c = np.array([[36.0, -20.0, 0.003], [-20.0, 18.0, -0.002], [0.003, -0.002, 3e-5]])
        points = error_ellipsoids.surface(c).reshape(3, -1)
        np.testing.assert_allclose(np.einsum("ik,ij,jk->k", points, np.linalg.inv(c), points), 9, rtol=1e-6)

    def test_rms_of_ratios(self):
        self.assertAlmostEqual(thesis.rms(np.array([2.0, 0.5, 2.0])), np.log(2))


@unittest.skipUnless(PROGRAM, "SURVEYMC is not set")
class Drawing(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)

    def result(self, name, trials, *options):
        path = os.path.join(self.folder.name, f"{name}.h5")
        if not os.path.exists(path):
            subprocess.run([PROGRAM, "run", os.path.join(ROOT, "configs", "thesis", f"{name}.toml"), "-o", path, "--trials",
                            str(trials), *options], check=True, capture_output=True, timeout=300)
        return path

    def figures(self, path, *expected):
        """What is printed before the paths; there are exactly the expected figures."""
        folder = os.path.join(self.folder.name, "figures_" + os.path.basename(path))
        run = draw(path, "-o", folder)
        self.assertEqual(run.returncode, 0, run.stderr)
        stem = os.path.splitext(os.path.basename(path))[0]
        wanted = sorted(os.path.join(folder, f"{stem}_{n}.{e}") for n in expected for e in ("png", "svg"))
        lines = run.stdout.split("\n")[:-1]
        self.assertEqual(sorted(line for line in lines if line.startswith(folder)), wanted)
        self.assertEqual(sorted(os.path.join(folder, f) for f in os.listdir(folder)), wanted)
        for name in wanted:
            with open(name, "rb") as file:
                data = file.read()
            self.assertTrue(data.startswith(b"\x89PNG\r\n\x1a\n" if name.endswith(".png") else b"<?xml"), name)
            self.assertGreater(len(data), 10_000, name)
        return [line for line in lines if not line.startswith(folder)]

    def test_ranking_of_the_noise(self):
        text = self.figures(self.result("noise_hypotheses", 1000), "hypotheses")
        first = next(line for line in text if line.startswith("1 "))
        # 10 % apart from the next: 18 standard deviations of 1000 trials, 2.2 % each, decide that.
        self.assertRegex(first, r"^1 +gaussian +107 nT/.16 deg per run")
        self.assertEqual(sum(line[:2].strip().isdigit() for line in text), 20)

    def test_combined_fit_is_that_of_the_tests(self):
        path = self.result("noise_hypotheses", 1000)
        with reading.open_result(path, "msa_position") as file:
            fit, parameters = (reading.read_table(file, n) for n in ("published_fit", "parameters"))
        for (law, reference), ratios in thesis.readings_of_the_noise(parameters).items():
            rows = fit.where(lambda i: fit["noise.law"][i] == law and fit["case"][i].split(": ")[1].endswith(reference))
            self.assertEqual((rows.rows, len(ratios)), (3, 18))
            combined = np.sqrt(np.average(rows["rms_log_ratio"] ** 2, weights=rows["quantities"]))
            self.assertAlmostEqual(thesis.rms(ratios), combined, places=12)
            self.assertAlmostEqual(ratios.min(), rows["ratio_min"].min(), places=12)
            self.assertAlmostEqual(ratios.max(), rows["ratio_max"].max(), places=12)

    def test_ladder(self):
        self.figures(self.result("wls_ladder", 500), "ladder")

    def test_estimators(self):
        self.figures(self.result("joint_estimation", 500), "estimators")

    def test_published_positions(self):
        text = self.figures(self.result("table9_10_11", 500), "published")
        self.assertEqual(sum(" sigma3_" in line for line in text), 3 * 4 * 2)  # tables, tests, directions

    def test_text_alone(self):
        text = self.figures(self.result("table7", 50))
        self.assertEqual(sum(" sigma3_" in line for line in text), 4 * 6)

    def test_ellipsoids(self):
        self.figures(self.result("table8", 600, "--set", "save_samples=300"), "published",
                     *(f"ellipsoid_test{n}" for n in (1, 2, 3, 4)))

    def test_hole_axes_are_those_of_the_program(self):
        self.assert_hole_axes(self.result("table8", 600, "--set", "save_samples=300"), 4)

    def test_hole_axes_of_azimuths_from_another_north(self):
        for name, field, north in (("model", "model = 'wmm2025'\nlatitude_deg = 70.0\nlongitude_deg = -150.0\ndate = 2026-01-01", "magnetic"),
                                   ("angle", "total_nT = 51000.0\ndip_deg = 72.0\ndeclination_deg = 40.0", "magnetic"),
                                   ("model_grid", "model = 'wmm2025'\nlatitude_deg = 70.0\nlongitude_deg = -150.0\ndate = 2026-01-01\n"
                                    "grid = { crs = 'utm', zone = 6 }", "grid"),
                                   ("grid", "total_nT = 51000.0\ndip_deg = 72.0\nlatitude_deg = 70.0\nlongitude_deg = -150.0\n"
                                    "grid = { crs = 'utm', zone = 6 }", "grid")):
            config, path = (os.path.join(self.folder.name, f"{name}.{ending}") for ending in ("toml", "h5"))
            with open(config, "w", encoding="utf-8") as file:
                file.write(ELSEWHERE.format(survey=os.path.join(ROOT, "configs", "thesis", "traj4.csv"), north=north, field=field))
            subprocess.run([PROGRAM, "run", config, "-o", path, "--quiet"], check=True, capture_output=True, timeout=100)
            # No table has the convergence of a grid without a model: rather no axes of the hole than wrong ones.
            self.assert_hole_axes(path, 0 if name == "grid" else 1)

    def assert_hole_axes(self, path, cases):
        with reading.open_result(path, "msa_position") as file:
            config = reading.configuration(file)
            holes = error_ellipsoids.last_stations(file, config)
            covariances, hla = (reading.read_table(file, n) for n in ("position_covariance", "position_hla"))
        self.assertEqual(len(holes), cases)
        for case, hole in holes.items():
            turn = error_ellipsoids.hla_from_nev(*hole)
            for name, c in error_ellipsoids.matrices(reading.at_point(covariances, ["case"], (case,))).items():
                own = turn @ c @ turn.T
                for i, d in enumerate(("high_side", "lateral", "along_hole")):
                    row = hla.row(case=case, quantity=f"sigma3_{d}", formulation="joint" if name == "monte_carlo" else name)
                    value = row["monte_carlo" if name == "monte_carlo" else "analytic"]
                    # Rounding of the rotation: 1e-14 of the largest variance.
                    self.assertAlmostEqual(value**2 / 9, own[i, i], delta=1e-14 * np.trace(c) + 1e-9 * abs(own[i, i]))

    def test_nothing_to_draw(self):
        run = draw(self.result("test4", 100))
        self.assertEqual(run.returncode, 0, run.stderr)  # its published values are printed
        path = os.path.join(self.folder.name, "smoke.h5")
        subprocess.run([PROGRAM, "run", os.path.join(ROOT, "configs", "smoke", "msa_estimators.toml"), "-o", path, "--trials",
                        "50"], check=True, capture_output=True, timeout=100)
        run = draw(path)
        self.assertEqual(run.returncode, reading.BAD_DATA)
        self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
        self.assertIn("msa_position", run.stderr)


if __name__ == "__main__":
    unittest.main()
