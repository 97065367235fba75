#!/usr/bin/python3
"""Figures of scripts/plot_chained.py from the smoke runs: SURVEYMC_SMOKE_RESULTS names their folder."""
import os
import subprocess
import sys
import tempfile
import unittest

FOLDER = os.environ["SURVEYMC_SMOKE_RESULTS"]
SCRIPT = os.path.join(os.path.dirname(__file__), "../../scripts/plot_chained.py")


def drawn(result):
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run([sys.executable, SCRIPT, os.path.join(FOLDER, result + ".h5"), "-o", folder],
                             capture_output=True, text=True, timeout=180)
        content = {}
        for path in run.stdout.split():
            with open(path, "rb") as file:
                content[os.path.basename(path)] = file.read()
        return run, content


class Drawing(unittest.TestCase):
    def check(self, result, names):
        run, content = drawn(result)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(run.stderr, "")
        self.assertEqual(sorted(content), sorted(n + e for n in names for e in (".png", ".svg")))
        return content

    def test_performance(self):
        names = [f"chained_{kind}_{truth}" for kind in ("rms", "tracks", "consistency") for truth in
                 ("constant", "chained")]
        self.assertEqual(self.check("chained", names), self.check("chained", names))

    def test_others(self):
        for result in ("chained_outliers", "chained_interference", "chained_unstart"):
            self.check(result, [result])

    def test_readings(self):
        self.check("estimate_chained", ["estimate_chained_run_filter", "estimate_chained_run_smoother"])


if __name__ == "__main__":
    unittest.main()
