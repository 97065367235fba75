#!/usr/bin/python3
"""SIGKILL and signals that stop at random moments of six experiments: test_kills.py SURVEYMC SOURCE_FOLDER [unittest arguments]

Each run is killed and resumed until it has died SURVEYMC_KILLS (1000) / 6 times, and is stopped a third as often by a signal that
it may answer; whenever a result is there, it is that of a run in one go.
"""
import os
import random
import signal
import sys
import time
import unittest
from pathlib import Path

from durability import DONE, INTERRUPTED, Case, program_from_arguments

EXPERIMENTS = ("msa_position", "vertical_well", "sensor_monte_carlo", "gross_error_detection", "error_model_monte_carlo", "msa_benefit")
CONFIGS = Path()
STOPS = (signal.SIGTERM, signal.SIGHUP, signal.SIGXCPU)
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
        whole, finished, output = self.hash_of(f"{name}.whole.h5"), 0, self.folder / f"{name}.h5"
        run = ("run", CONFIGS / f"{name}.toml", "--trials", trials, "-o", output, "--checkpoint-seconds", "0.01", "--resume")
        ended = {signal.SIGKILL: 0, **{stop: 0 for stop in STOPS}}
        goal = {signal.SIGKILL: wanted, **{stop: -(-wanted // 9) for stop in STOPS}}
        reach = 0.7 * seconds  # less while runs end before their signal: how fast the machine is changes
        for attempt in range(20 * wanted + 20):
            open_signals = [number for number in goal if ended[number] < goal[number]]
            if not open_signals:
                break
            number = open_signals[attempt % len(open_signals)]
            code, err = self.interrupt(*run, "--threads", (1, 2, 3)[attempt % 3], number=number, after=moment.uniform(0, reach))
            # A signal before main() has its usual action.
            self.assertIn(code, (DONE, -number) if number == signal.SIGKILL else (DONE, INTERRUPTED, -number), err)
            ended[number] += code != DONE
            reach = reach * 0.9 if code == DONE else min(0.7 * seconds, reach * 1.1)
            if output.exists():  # then it is whole
                self.assertEqual(self.hash_of(output.name), whole)
                output.unlink()
                finished += 1
        self.assertEqual(ended, goal, f"{finished} results beside them")
        self.call(*run)
        self.assertEqual(self.hash_of(output.name), whole)
        self.assertEqual(self.journals(), [])
        self.assertEqual([t for t in self.temporaries() if name in t], [])
        stops = sum(ended[stop] for stop in STOPS)
        print(f"{name}: {ended[signal.SIGKILL]} kills, {stops} stops, {finished} results beside them, {trials} trials", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    CONFIGS = Path(sys.argv.pop(2)).resolve() / "configs/smoke"
    program_from_arguments(__doc__)
    unittest.main()
