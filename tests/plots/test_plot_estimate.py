#!/usr/bin/python3
"""Tests of scripts/plot_estimate.py. SURVEYMC_RESULT: a result of estimate with a sweep of two points."""

import os
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402


SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "plot_estimate.py")
RESULT = os.environ.get("SURVEYMC_RESULT", "")
USAGE, BAD_DATA = 64, 65


def draw(*arguments):
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, timeout=120)


class PlotEstimate(unittest.TestCase):
    def assert_refused(self, code, word, *arguments):
        run = draw(*arguments)
        self.assertEqual(run.returncode, code, run.stderr)
        self.assertNotIn("Traceback", run.stderr)
        self.assertIn(word, run.stderr)
        self.assertEqual(run.stdout, "")

    @unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
    def test_figures_depend_on_the_data_only(self):
        with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
            content = []
            for folder in (first, second):
                run = draw(RESULT, "-o", folder, "--point", "1")
                self.assertEqual((run.returncode, run.stderr), (0, ""))
                content.append({})
                for name in sorted(os.listdir(folder)):
                    with open(os.path.join(folder, name), "rb") as file:
                        content[-1][name] = file.read()
            self.assertEqual(content[0], content[1])
            self.assertEqual(list(content[0]), [f"{os.path.basename(RESULT)[:-3]}_point1_{figure}.{extension}"
                                                for figure in ("azimuth", "parameters", "plan", "residuals")
                                                for extension in ("png", "svg")])
            for name, data in content[0].items():
                self.assertGreater(len(data), 10_000, name)

    @unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
    def test_points(self):
        self.assert_refused(USAGE, "--point I", RESULT)
        self.assert_refused(USAGE, "points 0 to 1", RESULT, "--point", "2")

    def test_what_is_not_a_result(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "r.h5")
            self.assert_refused(BAD_DATA, "no such file", path)
            with result_file(path) as file:
                file.attrs.update({"format": "surveymc", "experiment": "msa_position", "config": ""})
            self.assert_refused(BAD_DATA, "msa_position", path)
            with result_file(path) as file:
                file.attrs.update({"format": "surveymc", "experiment": "estimate", "config": ""})
            self.assert_refused(BAD_DATA, "'parameters' is missing", path)


if __name__ == "__main__":
    unittest.main()
