#!/usr/bin/python3
"""scripts/quickstart.sh, with a build that is there already or fails: test_quickstart.py SURVEYMC SOURCE_FOLDER"""
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

EXECUTABLE = SOURCE = None


class Quickstart(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="surveymc-quickstart-")
        self.addCleanup(temporary.cleanup)
        self.tree = Path(temporary.name)
        for folder in ("scripts", "build", "tools"):
            (self.tree / folder).mkdir()
        (self.tree / "configs").symlink_to(SOURCE / "configs")
        (self.tree / "build/surveymc").symlink_to(EXECUTABLE)
        self.tool("scripts/bootstrap.sh", "echo bootstrap: all 26 packages are installed")
        # The script as it is: a link would lead to the folder of the source.
        self.tool("scripts/quickstart.sh", (SOURCE / "scripts/quickstart.sh").read_text())

    def tool(self, name, text):
        path = self.tree / name
        path.write_text(text if text.startswith("#!") else f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)

    def run_with(self, cmake):
        self.tool("tools/cmake", cmake)
        environment = {**os.environ, "PATH": f"{self.tree}/tools:{os.environ['PATH']}"}
        return subprocess.run([self.tree / "scripts/quickstart.sh"], cwd="/", env=environment, capture_output=True, text=True, timeout=600)

    def test_it_ends_with_result_figures_and_the_next_commands_in_thirty_lines(self):
        done = self.run_with('seq 200; echo "cmake $*" >&2')
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        lines = done.stdout.splitlines()
        self.assertLessEqual(len(lines), 30, done.stdout)
        self.assertRegex(done.stdout, r"\nbuilt in \d+ s\n\nTest 4 of the thesis: .*\?\nAfter the correction .*\n(.*\n)*wrote results/quickstart.h5 ")
        figures = [line.strip() for line in lines if line.startswith("  results/")]
        self.assertGreater(len(figures), 0, done.stdout)
        for figure in figures:
            self.assertTrue((self.tree / figure).is_file(), figure)
        self.assertIn("build/surveymc show results/quickstart.h5", done.stdout)
        log = (self.tree / "build/quickstart.log").read_text()
        self.assertIn("\n200\n", log)
        self.assertIn("cmake --build --preset release --target surveymc\n", log)

    def test_a_build_that_fails_says_where_its_log_is(self):
        done = self.run_with('seq 200; echo "error: no such header"; [ "$1" != --build ]')
        self.assertEqual(done.returncode, 1, done.stdout)
        said = done.stderr.splitlines()
        self.assertLessEqual(len(said), 16)
        self.assertEqual(said[-2], "error: no such header")
        self.assertEqual(said[-1], "quickstart.sh: failed: cmake --build --preset release --target surveymc: the last lines are above, "
                                   "all are in build/quickstart.log")
        self.assertNotIn("built", done.stdout)
        self.assertFalse((self.tree / "results/quickstart.h5").exists())

    def test_packages_that_are_missing_end_it(self):
        self.tool("scripts/bootstrap.sh", "echo bootstrap.sh: run this as root >&2; exit 1")
        done = self.run_with("exit 0")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (1, "", "bootstrap.sh: run this as root\n"))


if __name__ == "__main__":
    EXECUTABLE, SOURCE = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
