#!/usr/bin/python3
"""Figures of scripts/plot_gross_error.py from the smoke run: SURVEYMC_RESULT names its file."""
import os
import subprocess
import sys
import tempfile
import unittest

RESULT = os.environ["SURVEYMC_RESULT"]
SCRIPT = os.path.join(os.path.dirname(__file__), "../../scripts/plot_gross_error.py")


class Drawing(unittest.TestCase):
    def test_outcomes_by_strategy(self):
        content = []
        for _ in range(2):
            with tempfile.TemporaryDirectory() as folder:
                run = subprocess.run([sys.executable, SCRIPT, RESULT, "-o", folder], capture_output=True, text=True,
                                     timeout=120)
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(run.stderr, "")
                content.append({})
                for path in run.stdout.split():
                    with open(path, "rb") as file:
                        content[-1][os.path.basename(path)] = file.read()
        self.assertEqual(sorted(content[0]), ["gross_error_detection.png", "gross_error_detection.svg"])
        self.assertEqual(content[0], content[1])


if __name__ == "__main__":
    unittest.main()
