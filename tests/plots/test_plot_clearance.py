#!/usr/bin/python3
"""Tests of plot_clearance.py on the smoke result, whose path is in the environment variable SURVEYMC_RESULT. Without it they
are skipped."""
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
RESULT = os.environ.get("SURVEYMC_RESULT", "")
FIGURES = ("ladder", "separation", "cylinder", "views", "relative", "cloud")


def draw(*arguments):
    return subprocess.run([sys.executable, os.path.join(SCRIPTS, "plot_clearance.py"), *arguments], capture_output=True,
                          text=True, timeout=120)


@unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
class Drawing(unittest.TestCase):
    def test_every_figure_is_drawn_in_both_forms(self):
        with tempfile.TemporaryDirectory() as folder:
            run = draw(RESULT, "-o", folder)
            self.assertEqual(run.returncode, 0, run.stderr)
            wanted = sorted(f"clearance_{f}.{e}" for f in FIGURES for e in ("png", "svg"))
            self.assertEqual(sorted(os.listdir(folder)), wanted)
            self.assertEqual(sorted(run.stdout.split()), [os.path.join(folder, n) for n in wanted])
            for name in wanted:
                self.assertGreater(os.path.getsize(os.path.join(folder, name)), 10_000, name)

    def test_what_is_not_there_is_said(self):
        self.assertIn("--point 3", draw(RESULT, "--point", "3").stderr)
        self.assertNotEqual(draw(RESULT + ".none").returncode, 0)


if __name__ == "__main__":
    unittest.main()
