#!/usr/bin/python3
"""Tests of plot_collision.py on the smoke results, whose paths are in SURVEYMC_RESULT, SURVEYMC_FUNCTIONS and
SURVEYMC_EVENTS. Without them they are skipped."""
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
WELLS, FUNCTIONS, EVENTS = (os.environ.get(k, "") for k in ("SURVEYMC_RESULT", "SURVEYMC_FUNCTIONS", "SURVEYMC_EVENTS"))


def draw(*arguments):
    return subprocess.run([sys.executable, os.path.join(SCRIPTS, "plot_collision.py"), *arguments], capture_output=True,
                          text=True, timeout=120)


@unittest.skipUnless(WELLS, "SURVEYMC_RESULT is not set")
class Drawing(unittest.TestCase):
    def test_every_figure_is_drawn_in_both_forms(self):
        for result, stem, figures in ((WELLS, "collision", ("probability", "contact", "importance", "plane", "convergence")),
                                      (FUNCTIONS, "rare_event", ("probability", "convergence")),
                                      (EVENTS, "msa_event", ("probability", "importance", "convergence"))):
            with tempfile.TemporaryDirectory() as folder:
                run = draw(result, "-o", folder)
                self.assertEqual(run.returncode, 0, run.stderr)
                wanted = sorted(f"{stem}_{f}.{e}" for f in figures for e in ("png", "svg"))
                self.assertEqual(sorted(os.listdir(folder)), wanted)
                for name in wanted:
                    self.assertGreater(os.path.getsize(os.path.join(folder, name)), 8_000, name)

    def test_what_is_not_there_is_said(self):
        self.assertIn("--point 3", draw(WELLS, "--point", "3").stderr)
        self.assertNotEqual(draw(WELLS + ".none").returncode, 0)


if __name__ == "__main__":
    unittest.main()
