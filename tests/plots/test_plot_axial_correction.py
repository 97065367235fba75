#!/usr/bin/python3
"""Figures of scripts/plot_axial_correction.py from the smoke run: SURVEYMC_RESULT names its file."""
import os
import subprocess
import sys
import tempfile
import unittest

RESULT = os.environ["SURVEYMC_RESULT"]
SCRIPT = os.path.join(os.path.dirname(__file__), "../../scripts/plot_axial_correction.py")


def draw(*arguments):
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, timeout=120)


class Drawing(unittest.TestCase):
    def test_figures(self):
        for point in (0, 1):
            content = []
            for _ in range(2):
                with tempfile.TemporaryDirectory() as folder:
                    run = draw(RESULT, "-o", folder, "--point", str(point))
                    self.assertEqual(run.returncode, 0, run.stderr)
                    self.assertEqual(run.stderr, "")
                    content.append({})
                    for path in run.stdout.split():
                        with open(path, "rb") as file:
                            content[-1][os.path.basename(path)] = file.read()
            names = [f"axial_correction_point{point}_{n}.{e}" for n in ("curves", "maps") for e in ("png", "svg")]
            self.assertEqual(sorted(content[0]), names)
            self.assertEqual(content[0], content[1])  # no dates: the same bytes
            self.assertGreater(min(len(c) for c in content[0].values()), 10_000)

    def test_bad_requests(self):
        for code, word, *arguments in ((64, "--point", RESULT, "--point", "7"), (65, "no such file", RESULT + "x")):
            run = draw(*arguments)
            self.assertEqual(run.returncode, code, run.stderr)
            self.assertIn(word, run.stderr)
            self.assertNotIn("Traceback", run.stderr)


if __name__ == "__main__":
    unittest.main()
