#!/usr/bin/python3
"""Every command and a signal at a random moment: test_signals.py SURVEYMC_EXECUTABLE [unittest arguments]

Commands that compute end by themselves (exit code 75), the others by the default action of the signal. What was there
before stays as it was, or all that the command writes is there; no temporary file is left.
"""
import hashlib
import random
import shutil
import signal
import time
import unittest

from durability import DONE, INTERRUPTED, Case, program_from_arguments

DIFFERENT = 1  # exit code of `diff` and `rerun`
REFINED = """\
experiment = "msa_benefit"
seed = 1
estimator = "msa"
[well]
kind = "building"
stations = 10
spacing_m = 30.0
build_rate_deg_per_30m = 3.0
toolface = "even"
[field]
total_nT = 51000.0
dip_deg = 72.0
[sensor.spread]
gain = 0.0016
bias_nT = 70.0
[noise]
magnetometer_nT = 30.0
reference = { per = "run", total_nT = 130.0, dip_deg = 0.20 }
[sweep]
inclination_deg = { from = 2.0, to = 178.0, count = 6 }
azimuth_deg = { from = 0.0, to = 180.0, count = 6 }
[refine]
quantity = "summary.ratio_best"
where = { quantity = "azimuth" }
level = 1.0
cell = 0.01
"""


class Signals(Case):
    TRIES = 4

    def content(self):
        return {str(p.relative_to(self.folder)): hashlib.md5(p.read_bytes()).hexdigest() for p in self.folder.rglob("*") if p.is_file()}

    def stopped(self, *command, makes=(), caught=False, codes=(DONE,)):
        """The command, TRIES times with a signal while it runs. `makes`: the files that it writes."""
        before, moment = self.content(), random.Random(" ".join(map(str, command)))
        begin = time.monotonic()
        done = self.start(*command)
        err = done.communicate()[1]
        self.assertIn(done.returncode, codes, err)
        seconds, whole = time.monotonic() - begin, self.content()
        self.assertEqual(set(whole) - set(before), set(makes))
        ended = 0
        for k in range(self.TRIES):
            for name in makes:
                (self.folder / name).unlink(missing_ok=True)
            number = (signal.SIGINT, signal.SIGTERM)[k % 2]
            code, err = self.interrupt(*command, number=number, after=moment.uniform(0, seconds))
            self.assertIn(code, (*codes, -number, *((INTERRUPTED,) if caught else ())), f"{command}\n{err}")
            after = self.content()
            self.assertEqual({name: h for name, h in after.items() if name not in makes}, before, command)
            there = [name for name in makes if name in after]
            self.assertIn(len(there), (0, len(makes)), command)
            if code in codes:
                self.assertEqual(there, list(makes), err)
            if not any(name.endswith(".part") for name in makes):  # parts have the time
                self.assertEqual({name: after[name] for name in there}, {name: whole[name] for name in there}, command)
            ended += code not in codes
        for name in makes:
            (self.folder / name).unlink(missing_ok=True)
        return ended

    def test_commands_that_only_read(self):
        (self.folder / "points.csv").write_text("noise.scale\n" + "".join(f"{1 + i / 1000}\n" for i in range(1_000)))
        text = (self.folder / "small.toml").read_text()
        (self.folder / "table.toml").write_text(
            text[:text.index("[sweep]")] + '[sweep]\ndesign = { kind = "table", file = "points.csv" }\n')
        self.call("run", "small.toml", "-o", "a.h5")
        self.call("run", "small.toml", "-o", "b.h5", "--seed", 2)
        self.call("run", "table.toml", "--point", "7", "--trials", 512, "-o", "parts/")
        part, = (self.folder / "parts").glob("*.part")
        for i in range(100):
            shutil.copy(part, self.folder / "parts" / f"{i}.part")
        ended = 0
        for command in (("check", "table.toml"), ("plan", "table.toml", "--groups", 50), ("status", "parts"),
                        ("plan", "table.toml", "--trials", 512, "--missing", "parts"), ("show", "a.h5"),
                        ("show", "a.h5", "position", "--csv"), ("diff", "a.h5", "a.h5"), ("keys", "msa_position")):
            ended += self.stopped(*command)
        ended += self.stopped("diff", "a.h5", "b.h5", codes=(DONE, DIFFERENT))
        ended += self.stopped("rerun", "a.h5", caught=True)
        self.assertGreater(ended, 4)  # of 40

    def test_commands_that_write(self):
        (self.folder / "round.toml").write_text(REFINED)
        self.call("run", "round.toml", "-o", "round.h5")
        ended = self.stopped("refine", "round.h5", "-o", "next.toml", makes=("next.points.csv", "next.toml"), caught=True)
        for i in range(3):
            self.call("run", "small.toml", "--point", i, "-o", "p/")
        ended += self.stopped("merge", "-o", "m.h5", "p", makes=("m.h5",), caught=True)
        ended += self.stopped("merge", "--part", "-o", "m.part", "p", makes=("m.part",), caught=True)
        self.assertGreater(ended, 0)  # of 12

    def test_refine_keeps_the_old_files(self):
        (self.folder / "round.toml").write_text(REFINED)
        self.call("run", "round.toml", "-o", "round.h5")
        self.call("refine", "round.h5", "-o", "next.toml")
        new = self.content()
        for name in ("next.toml", "next.points.csv"):
            (self.folder / name).write_text("old")
        old = self.content()
        moment, begin = random.Random(3), time.monotonic()
        self.call("refine", "round.h5", "-o", "next.toml", "--overwrite")
        seconds = time.monotonic() - begin
        for name in ("next.toml", "next.points.csv"):
            (self.folder / name).write_text("old")
        for k in range(60):
            code, err = self.interrupt("refine", "round.h5", "-o", "next.toml", "--overwrite", number=signal.SIGTERM,
                                       after=moment.uniform(0.3 * seconds, seconds))
            self.assertIn(code, (DONE, INTERRUPTED, -signal.SIGTERM), err)
            self.assertIn(self.content(), (old, new), k)
            for name in ("next.toml", "next.points.csv"):
                (self.folder / name).write_text("old")


if __name__ == "__main__":
    program_from_arguments(__doc__)
    unittest.main()
