#!/usr/bin/python3
"""Figures of scripts/plot_reliability.py from the smoke run: SURVEYMC_RESULT names its file, SURVEYMC_COMBINATION that of
the smoke run of combinations, SURVEYMC the program."""
import os
import subprocess
import sys
import tempfile
import unittest

RESULT = os.environ["SURVEYMC_RESULT"]
SCRIPT = os.path.join(os.path.dirname(__file__), "../../scripts/plot_reliability.py")


def draw(*arguments):
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, timeout=120)


class Drawing(unittest.TestCase):
    def test_figures(self):
        content = []
        for _ in range(2):
            with tempfile.TemporaryDirectory() as folder:
                run = draw(RESULT, "-o", folder, "--observation", "bx")
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(run.stderr, "")
                content.append({})
                for path in run.stdout.split():
                    with open(path, "rb") as file:
                        content[-1][os.path.basename(path)] = file.read()
        self.assertEqual(sorted(content[0]), ["reliability_map_azimuth.png", "reliability_map_azimuth.svg",
                                              "reliability_map_nonlinear.png", "reliability_map_nonlinear.svg"])
        self.assertEqual(content[0], content[1])  # no dates: the same bytes
        self.assertGreater(len(content[0]["reliability_map_azimuth.png"]), 10_000)

    def names_of(self, result, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            run = draw(result, "-o", folder, *arguments)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(run.stderr, "")
            for path in run.stdout.split():
                self.assertGreater(os.path.getsize(path), 10_000)
            return sorted(os.path.basename(path) for path in run.stdout.split() if path.endswith(".png"))

    def test_residuals_of_figure_1(self):
        config = os.path.join(os.path.dirname(__file__), "../../configs/reliability/fig1.toml")
        with tempfile.TemporaryDirectory() as folder:
            result = os.path.join(folder, "fig1.h5")
            subprocess.run([os.environ["SURVEYMC"], "run", config, "-o", result], check=True, capture_output=True, timeout=60)
            self.assertEqual(self.names_of(result), ["fig1_inclination.png", "fig1_residuals.png"])

    def test_combinations_and_nonlinear_errors(self):
        self.assertEqual(self.names_of(os.environ["SURVEYMC_COMBINATION"]),
                         ["reliability_combination_azimuth.png", "reliability_combination_direction.png"])
        self.assertIn("reliability_map_nonlinear.png", self.names_of(RESULT, "--observation", "bx"))

    def test_bad_requests(self):
        for code, word, *arguments in ((64, "panels", RESULT), (64, "--observation", RESULT, "--observation", "gx"),
                                       (65, "no such file", RESULT + "x"), (64, "--effect", RESULT, "--effect", "depth")):
            run = draw(*arguments)
            self.assertEqual(run.returncode, code, run.stderr)
            self.assertIn(word, run.stderr)
            self.assertNotIn("Traceback", run.stderr)


if __name__ == "__main__":
    unittest.main()
