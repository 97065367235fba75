#!/usr/bin/python3
"""`surveymc new` for every experiment: test_new.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]"""
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

from test_keys import leaves

EXECUTABLE = SOURCE = None


class New(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="surveymc-new-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def call(self, *arguments, code=0):
        done = subprocess.run([EXECUTABLE, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, code, f"{arguments}\n{done.stdout[-300:]}{done.stderr}")
        return done.stdout if code == 0 else done.stderr

    def experiments(self):
        return [line.split()[0] for line in self.call("list").splitlines() if not line.startswith(" ")]

    def data_of(self, config):
        """The files that a config names."""
        return [v for _, v in leaves(config) if isinstance(v, str) and v.endswith(".csv")]

    def test_every_experiment_has_one_that_is_accepted_and_runs(self):
        for experiment in self.experiments():
            with self.subTest(experiment=experiment):
                text = self.call("new", experiment)
                self.assertEqual(text.splitlines()[:2], [f"#:schema ./{experiment}.schema.json", f"# This file comes from: surveymc new {experiment}"])
                self.assertLessEqual(max(map(len, text.splitlines())), 128)
                config = tomllib.loads(text)
                self.assertEqual(config["experiment"], experiment)
                self.assertEqual(os.listdir(self.folder), [])
                said = self.call("new", experiment, "-o", "mine.toml")
                self.assertEqual((self.folder / "mine.toml").read_text(), text)
                self.assertEqual(sorted(os.listdir(self.folder)), sorted(["mine.toml", f"{experiment}.schema.json", *self.data_of(config)]))
                self.assertIn("wrote mine.toml", said)
                self.assertIn("config hash", self.call("check", "mine.toml"))
                few = ["--trials", 100] if "trials" in config else []
                self.call("run", "mine.toml", "-o", "mine.h5", "--quiet", *few)
                self.call("rerun", "mine.h5")
                if self.data_of(config):  # without the data it is not: the message names the file that is missing
                    data = self.folder / self.data_of(config)[0]
                    data.rename(self.folder / "away")
                    self.assertIn(f'"{data.name}": cannot be read', self.call("check", "mine.toml", code=65))
                for path in self.folder.iterdir():
                    path.unlink()

    def test_estimators_that_it_offers_are_accepted(self):
        """Those of 'estimator = "msa"   # or ...'."""
        tried = 0
        for experiment in self.experiments():
            offer = re.search(r"(?m)^estimator = .*# or (.*)$", self.call("new", experiment))
            if offer:
                self.call("new", experiment, "-o", f"{experiment}.toml")
            for name in re.findall(r'"(\w+)"', offer[1]) if offer else []:
                with self.subTest(experiment=experiment, estimator=name):
                    self.call("check", f"{experiment}.toml", "--set", f"estimator={name}")
                    tried += 1
        self.assertGreater(tried, 5)

    def test_no_file_is_written_over(self):
        (self.folder / "mine.toml").write_text("mine")
        self.assertIn("mine.toml: exists", self.call("new", "msa_position", "-o", "mine.toml", code=74))
        self.assertEqual(os.listdir(self.folder), ["mine.toml"])  # no schema either
        self.assertEqual((self.folder / "mine.toml").read_text(), "mine")
        (self.folder / "own_well.csv").write_text("mine too")
        self.assertIn("own_well.csv is there", self.call("new", "msa_position", "-o", "other.toml"))
        self.assertEqual((self.folder / "own_well.csv").read_text(), "mine too")
        (self.folder / "link.toml").symlink_to("nowhere.toml")
        self.call("new", "msa_position", "-o", "link.toml", code=74)
        self.assertFalse((self.folder / "nowhere.toml").exists())
        self.assertIn("No such file or directory", self.call("new", "msa_position", "-o", "no/x.toml", code=74))
        self.assertIn("did you mean estimate?", self.call("new", "estimat", code=64))
        self.assertIn("experiment is required", self.call("new", code=64))

    def test_the_data_come_with_the_config_into_another_folder(self):
        (self.folder / "sub").mkdir()
        self.call("new", "position_covariance", "-o", "sub/mine.toml")
        self.assertEqual(sorted(os.listdir(self.folder / "sub")), ["mine.toml", "own_well.csv", "position_covariance.schema.json"])
        self.call("check", "sub/mine.toml")
        self.assertEqual((self.folder / "sub/own_well.csv").read_text(), (SOURCE / "configs/examples/own_well.csv").read_text())


if __name__ == "__main__":
    EXECUTABLE, SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
