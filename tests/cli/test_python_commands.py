#!/usr/bin/python3
"""surveymc plot, report, import, studies: the program becomes its Python side. test_python_commands.py SURVEYMC SOURCE_FOLDER"""
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import test_cli
from test_cli import BAD_INPUT, CANNOT_WRITE, USAGE, Case

NO_MEANS = 71
PYTHON = "/usr/bin/python3"
TEXT = "MD (m);Incl (deg);Azimuth Grid (deg)\n1000;2,1;45\n1095;4,8;46,2\n"


class PythonCommands(Case):
    def tool(self, name, text):
        path = self.write(name, f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
        return path

    def test_from_a_config_to_figures_page_and_import(self):
        self.run_config(timeout=60)
        figures = self.call("plot", "out.h5", "-o", "figures", timeout=300).stdout.split()
        self.assertIn("figures/out_parameters.png", figures)
        self.assertTrue(all((self.folder / f).is_file() for f in figures))
        self.assertIn("page/index.html: 1 result", self.call("report", "out.h5", "--no-figures", "-o", "page", timeout=300).stdout)
        self.write("own.txt", TEXT)
        self.call("import", "own.txt", "--decimal", "comma", "-o", "own.csv")
        self.assertIn("1000,2.1,45", (self.folder / "own.csv").read_text())
        self.assertRegex(self.call("studies", "--list", "--only", "thesis/test4", timeout=120).stdout, r"^thesis/test4 +msa_position ")

    def test_words_and_exit_codes_are_those_of_the_python_side(self):
        self.call("plot", "-o", "a folder", "no such.h5", code=BAD_INPUT, timeout=120)
        self.call("import", "none.txt", code=CANNOT_WRITE)
        self.assertRegex(self.call("import", "--help").stdout, r"^usage: surveymc import ")
        says = "surveymc (check|run) base.toml"
        for words in (["plot", "base.toml"], ["plot", "msa_position", "base.toml"], ["report", "base.toml"]):
            self.refused(USAGE, *words, says=f"must be a result, but this is a config; commands for it:\n  {says}\n  {says}\n")

    def test_no_page_replaces_a_result(self):
        self.run_config(timeout=60)
        self.refused(CANNOT_WRITE, "report", "out.h5", "--no-figures", "-o", "./out.h5", says="./out.h5: cannot write", timeout=120)
        (self.folder / "results").mkdir()
        (self.folder / "out.h5").rename(self.folder / "results/mine.h5")
        self.assertIn("results/report/index.html: 1 result", self.call("report", "--no-figures", timeout=120).stdout)

    def test_signals_go_to_it(self):
        python = self.tool("python", 'touch began; exec sleep 60')
        child = subprocess.Popen([test_cli.EXECUTABLE, "plot", "x.h5"], cwd=self.folder, env={**os.environ, "SURVEYMC_PYTHON": str(python)})
        end = time.monotonic() + 30
        while not (self.folder / "began").exists() and time.monotonic() < end:
            time.sleep(0.01)
        child.send_signal(signal.SIGTERM)
        self.assertEqual(child.wait(10), -signal.SIGTERM)  # of sleep: no process stands between

    def test_what_is_missing_is_said_with_a_way_out(self):
        none = {"PATH": str(self.folder)}
        bare = self.tool("bare", f'exec {PYTHON} -S -E "$@"')  # without the packages of Debian
        self.refused(NO_MEANS, "plot", "x.h5", env={**none, "SURVEYMC_PYTHON": str(bare)},
                     says=r"^surveymc plot: \S+ lacks numpy, h5py, xxhash, matplotlib: sudo apt install python3-numpy .*; or name .*SURVEYMC_PYTHON\n$")
        self.refused(NO_MEANS, "plot", "x.h5", env={"SURVEYMC_PYTHON": "/nowhere/python"}, says="surveymc plot: /nowhere/python: cannot be run: No such file")
        alone = self.folder / "bin/surveymc"
        alone.parent.mkdir()
        shutil.copy(test_cli.EXECUTABLE, alone)
        done = subprocess.run([alone, "report", "x.h5"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, NO_MEANS, done.stderr)
        self.assertRegex(done.stderr, r"^error: surveymc report: is written in Python, and scripts/surveymc is not beside \S+/bin/surveymc: install all of surveymc")

    def test_another_python_that_has_the_packages_is_taken(self):
        """A Python without packages begins, as /usr/bin/python3 may be one; that of the user's PATH has them."""
        self.run_config(timeout=60)
        self.tool("path/python3", f'echo taken >> {self.folder}/log; exec {PYTHON} "$@"')
        side = Path(test_cli.SOURCE) / "scripts/surveymc"
        environment = {**os.environ, "PATH": f"{self.folder}/path:/bin"}
        environment.pop("SURVEYMC_PYTHON", None)
        done = subprocess.run([PYTHON, "-S", "-E", side, "plot", "out.h5"], cwd=self.folder, env=environment, capture_output=True, text=True,
                              timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("out_parameters.svg", done.stdout)
        self.assertEqual((self.folder / "log").read_text(), "taken\n" * 2)  # asked for its packages, then used

    def test_files_of_the_users_folder_are_no_modules(self):
        self.call("new", "position_covariance", "-o", "well.toml")
        self.call("run", "well.toml", "-o", "out.h5", timeout=60)
        for name in ("numpy", "toml", "surveymc", "json"):
            self.write(f"{name}.py", "raise SystemExit('mine')\n")
        self.assertEqual(self.call("plot", "out.h5", timeout=300).stderr, "")  # also of the drawer that has nothing to draw

    def test_the_program_that_was_started_runs_the_studies(self):
        done = self.call("studies", "--list", "--only", "thesis/test4", env={"SURVEYMC": "/nowhere"}, timeout=120)
        self.assertTrue(re.search("to run|done", done.stdout))


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
