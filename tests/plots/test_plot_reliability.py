#!/usr/bin/python3
"""Figures of scripts/plot_reliability.py from the smoke run: SURVEYMC_RESULT names its file."""
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
        self.assertEqual(sorted(content[0]), ["reliability_map_azimuth.png", "reliability_map_azimuth.svg"])
        self.assertEqual(content[0], content[1])  # no dates: the same bytes
        self.assertGreater(len(content[0]["reliability_map_azimuth.png"]), 10_000)

    def test_bad_requests(self):
        for code, word, *arguments in ((64, "panels", RESULT), (64, "--observation", RESULT, "--observation", "gx"),
                                       (65, "no such file", RESULT + "x"), (64, "--effect", RESULT, "--effect", "depth")):
            run = draw(*arguments)
            self.assertEqual(run.returncode, code, run.stderr)
            self.assertIn(word, run.stderr)
            self.assertNotIn("Traceback", run.stderr)


if __name__ == "__main__":
    unittest.main()
