#!/usr/bin/python3
"""Tests of surveymc.plots.thesis.

Most need the program, which runs the shipped configs with few trials: its path in the environment variable SURVEYMC.
Without it they are skipped.
"""

import os
import subprocess
import tempfile
import unittest

import numpy as np

import plot_case
from surveymc.plots import thesis
from surveymc.plots import geometry, reading
from surveymc.plots.drawing import LOOK

ROOT = plot_case.SCRIPTS.parent
PROGRAM = os.environ.get("SURVEYMC", "")


def draw(*arguments):
    return plot_case.draw("thesis", *arguments)


class Ranking(unittest.TestCase):
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
        """There are exactly the expected figures, and nothing else is printed."""
        folder = os.path.join(self.folder.name, "figures_" + os.path.basename(path))
        run = draw(path, "-o", folder)
        self.assertEqual(run.returncode, 0, run.stderr)
        stem = os.path.splitext(os.path.basename(path))[0]
        wanted = sorted(os.path.join(folder, f"{stem}_{n}.{e}") for n in expected for e in ("png", "svg"))
        lines = run.stdout.split("\n")[:-1]
        self.assertEqual(sorted(lines), wanted)
        self.assertEqual(sorted(os.path.join(folder, f) for f in os.listdir(folder)), wanted)
        for name in wanted:
            with open(name, "rb") as file:
                data = file.read()
            self.assertTrue(data.startswith(b"\x89PNG\r\n\x1a\n" if name.endswith(".png") else b"<?xml"), name)
            self.assertGreater(len(data), 10_000, name)

    def test_ranking_of_the_noise(self):
        path = self.result("noise_hypotheses", 1000)
        self.figures(path, "hypotheses")
        with reading.open_result(path, "msa_position") as file:
            ranked = thesis.readings_of_the_noise(reading.read_table(file, "parameters"))
        # 10 % apart from the next: 18 standard deviations of 1000 trials, 2.2 % each, decide that.
        self.assertEqual(next(iter(ranked)), ("gaussian", "107 nT/.16 deg per run"))
        self.assertEqual(len(ranked), 20)

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
        path = self.result("table9_10_11", 500)
        self.figures(path, "published")
        with reading.open_result(path, "msa_position") as file:
            position = reading.read_table(file, "position")
        figure = thesis.published_figure("t", position)
        drawn = sorted(line.get_xdata()[0] for ax in figure.axes for line in ax.lines if line.get_marker() == "x")
        chosen = [q in ("sigma3_north", "sigma3_east") and p > 0 for q, p in zip(position["quantity"], position["published_ratio"])]
        np.testing.assert_allclose(drawn, sorted(position["published_ratio"][chosen]))
        self.assertEqual(len(drawn), 3 * 4 * 2)  # tables, tests, directions

    def test_ellipsoids(self):
        path = self.result("table8", 600, "--set", "save_samples=300")
        self.figures(path, "published", "ellipsoids")
        with reading.open_result(path, "msa_position") as file:
            covariances, position = (reading.read_table(file, n) for n in ("position_covariance", "position"))
            samples = reading.read_table(file, "realisations", "samples")
        figure = thesis.ellipsoids_figure("t", samples, covariances, position)
        # Test 4, seen from above: the outline satisfies the equation of the 3-sigma ellipse of the covariance on the map.
        ax = figure.axes[6]
        r = covariances.row(case="test 4", formulation="monte_carlo")
        c = np.array([[r["nn_m2"], r["ne_m2"]], [r["ne_m2"], r["ee_m2"]]])
        j = covariances.row(case="test 4", formulation="joint")
        a = np.radians(geometry.ellipse_axes([[j["nn_m2"], j["ne_m2"]], [j["ne_m2"], j["ee_m2"]]])[2])
        outline = next(line for line in ax.lines if line.get_color() == LOOK["monte_carlo"]["color"] and len(line.get_xdata()) == 361)
        along, left = outline.get_xdata(), outline.get_ydata() / (1000 if "mm" in ax.get_ylabel() else 1)
        points = np.array([along * np.cos(a) + left * np.sin(a), along * np.sin(a) - left * np.cos(a)])
        np.testing.assert_allclose(np.einsum("ik,ij,jk->k", points, np.linalg.inv(c), points), 9, rtol=1e-6)
        # Test 1 is a plane well: its predicted ellipses are lines, and drawn below the cloud with an end at 3 sigma.
        ends = [line for line in figure.axes[0].lines if line.get_marker() == "|"]
        j = covariances.row(case="test 1", formulation="joint")
        self.assertEqual(len(ends), 3)
        self.assertTrue(any(abs(max(line.get_xdata()) - 3 * np.sqrt(j["nn_m2"] + j["ee_m2"])) < 1e-6 for line in ends))

    def test_nothing_to_draw(self):
        path = os.path.join(self.folder.name, "smoke.h5")
        subprocess.run([PROGRAM, "run", os.path.join(ROOT, "configs", "smoke", "msa_estimators.toml"), "-o", path, "--trials",
                        "50"], check=True, capture_output=True, timeout=100)
        run = draw(path)
        self.assertEqual(run.returncode, reading.BAD_DATA)
        self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
        self.assertIn("msa_position", run.stderr)


if __name__ == "__main__":
    unittest.main()
