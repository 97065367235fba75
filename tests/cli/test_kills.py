#!/usr/bin/python3
"""SIGKILL at random moments of six experiments: test_kills.py SURVEYMC SOURCE_FOLDER [unittest arguments]

Each run is killed and resumed until it has died SURVEYMC_KILLS (1000) / 6 times; whenever a result is there, it is that of a run
in one go.
"""
import os
import random
import signal
import sys
import time
import unittest
from pathlib import Path

from durability import DONE, Case, program_from_arguments

EXPERIMENTS = ("msa_position", "vertical_well", "sensor_monte_carlo", "gross_error_detection", "error_model_monte_carlo", "msa_benefit")
CONFIGS = Path()
LEAST_SECONDS = 0.5  # of a run in one go, so that it can be killed at many places


class Kills(Case):
    def test_six_experiments(self):
        kills = -(-int(os.environ.get("SURVEYMC_KILLS", "1000")) // len(EXPERIMENTS))
        for name in EXPERIMENTS:
            with self.subTest(name):
                self.check(name, kills, random.Random(name))

    def check(self, name, wanted, moment):
        trials, seconds = 2000, 0
        while seconds < LEAST_SECONDS:
            trials *= 2
            begin = time.monotonic()
            self.call("run", CONFIGS / f"{name}.toml", "--trials", trials, "-o", f"{name}.whole.h5", "--overwrite", "--threads", 1)
            seconds = time.monotonic() - begin
        whole, kills, finished, output = self.hash_of(f"{name}.whole.h5"), 0, 0, self.folder / f"{name}.h5"
        run = ("run", CONFIGS / f"{name}.toml", "--trials", trials, "-o", output, "--checkpoint-seconds", "0.01", "--resume")
        while kills < wanted:
            code, err = self.interrupt(*run, "--threads", (1, 2, 3)[kills % 3], after=moment.uniform(0, 0.7 * seconds))
            self.assertIn(code, (DONE, -signal.SIGKILL), err)
            kills += code == -signal.SIGKILL
            if output.exists():  # then it is whole
                self.assertEqual(self.hash_of(output.name), whole)
                output.unlink()
                finished += 1
                self.assertLess(finished, 10 * wanted + 10)
        self.call(*run)
        self.assertEqual(self.hash_of(output.name), whole)
        self.assertEqual(self.journals(), [])
        self.assertEqual([t for t in self.temporaries() if name in t], [])
        print(f"{name}: {kills} kills, {finished} results beside them, {trials} trials", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    CONFIGS = Path(sys.argv.pop(2)).resolve() / "configs/smoke"
    program_from_arguments(__doc__)
    unittest.main()
