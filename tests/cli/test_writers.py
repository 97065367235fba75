#!/usr/bin/python3
"""Several writers of one output at once, and results of strangers: test_writers.py SURVEYMC_EXECUTABLE [unittest arguments]

What was there and what another writer has finished is never lost, whoever writes it. SURVEYMC_ROUNDS (2): how often each
command is begun by four at once; 50 nightly.
"""
import os
import random
import shutil
import time
import unittest

import h5py

from durability import CANNOT_WRITE, DONE, PATIENCE, SURVEY, Case, program_from_arguments
from test_parts import ROUNDS

HOW_OFTEN = int(os.environ.get("SURVEYMC_ROUNDS", "2"))
SEEDS = (1, 2, 3, 4)


class Writers(Case):
    def at_once(self, *commands, codes=(DONE,)):
        """Exit codes of commands that run at the same time."""
        children = [self.start(*command) for command in commands]
        ends = [(child.communicate(timeout=PATIENCE)[1], child.returncode) for child in children]
        for err, code in ends:
            self.assertIn(code, codes, err)
        self.assertEqual(self.temporaries(), [])
        return [code for _, code in ends]

    def seeds(self):
        """Of all results of the name x.h5 and x.N.h5; each is whole, as h5py reads it."""
        found = []
        for path in self.folder.glob("x*.h5"):
            with h5py.File(path) as file:
                found.append(int(file.attrs["seed"]))
        return sorted(found)

    def again(self):
        """Round after round, each without outputs of the round before."""
        for _ in range(HOW_OFTEN):
            for path in self.folder.glob("x*"):
                path.unlink()
            yield

    def test_runs(self):
        for _ in self.again():
            self.at_once(*(("run", "small.toml", "--trials", 600, "--seed", s, "-o", "x.h5") for s in SEEDS))
            self.assertEqual(self.seeds(), [1, 2, 3, 4])
            self.at_once(*(("run", "small.toml", "--trials", 600, "--seed", s + 4, "-o", "x.h5") for s in SEEDS))
            self.assertEqual(self.seeds(), [1, 2, 3, 4, 5, 6, 7, 8])

    def test_streamed_maps(self):
        for _ in self.again():
            self.at_once(*(("run", "maps.toml", "--seed", s, "-o", "x.h5") for s in SEEDS))
            self.assertEqual(self.seeds(), [1, 2, 3, 4])

    def test_runs_that_overwrite_leave_one_result(self):
        for _ in self.again():
            self.at_once(*(("run", "small.toml", "--trials", 600, "--seed", s, "-o", "x.h5", "--overwrite") for s in SEEDS))
            self.assertEqual(len(self.seeds()), 1)

    def assert_kept_parts(self, number):
        contents = {path.name: path.read_bytes() for path in self.folder.glob("x.part*")}
        self.assertEqual(len(set(contents.values())), len(contents))
        self.assertTrue(all(data.startswith(b"SMCPART") for data in contents.values()))
        self.assertEqual(sorted(contents), sorted(["x.part", *(f"x.part.{n}" for n in range(1, number))]))

    def test_parts(self):
        for _ in self.again():
            commands = [("run", "small.toml", "--trials", 600, "--seed", s, "--point", 0, "-o", "x.part") for s in SEEDS]
            codes = self.at_once(*commands, codes=(DONE, CANNOT_WRITE))
            self.assert_kept_parts(codes.count(DONE))  # others may have found a part of another config before they began

    def test_merges(self):
        for s in SEEDS:
            for point in range(3):
                self.call("run", "small.toml", "--trials", 600, "--seed", s, "--point", point, "-o", f"parts{s}/")
        for _ in self.again():
            self.at_once(*(("merge", f"parts{s}", "-o", "x.h5") for s in SEEDS))
            self.assertEqual(self.seeds(), [1, 2, 3, 4])
            self.at_once(*(("merge", "--part", f"parts{s}", "-o", "x.part") for s in SEEDS))
            self.assert_kept_parts(4)

    def test_new_and_refine(self):
        for s in SEEDS:
            (self.folder / f"round{s}.toml").write_text(ROUNDS.replace("seed = 11", f"seed = {s}"))
            self.call("run", f"round{s}.toml", "-o", f"round{s}.h5", "--trials", 400)
        alone = {}
        for s in SEEDS:
            self.call("refine", f"round{s}.h5", "-o", "x.toml")
            alone[(self.folder / "x.toml").read_text()] = (self.folder / "x.points.csv").read_text()
            for path in self.folder.glob("x*"):
                path.unlink()
        self.assertEqual(len(alone), 4)
        for _ in self.again():
            for more in ([], ["--overwrite"]):
                codes = self.at_once(*(("refine", f"round{s}.h5", "-o", "x.toml", *more) for s in SEEDS), codes=(DONE, CANNOT_WRITE))
                self.assertEqual(codes.count(DONE), 4 if more else 1)
                self.assertEqual(alone.get((self.folder / "x.toml").read_text()), (self.folder / "x.points.csv").read_text())
                self.assertEqual(sorted(p.name for p in self.folder.glob("x*")), ["x.points.csv", "x.toml"])
            codes = self.at_once(*(("new", name, "-o", "x_new.toml") for name in ("estimate", "clearance", "collision", "vertical_well")),
                                 codes=(DONE, CANNOT_WRITE))
            self.assertEqual(codes.count(DONE), 1)

    def test_a_file_that_appears_meanwhile_stays(self):
        """A user's own, at any moment of a run; and of an old result in its place, the old result."""
        self.call("run", "small.toml", "-o", "before.h5")
        begin = time.monotonic()
        self.call("run", "small.toml", "-o", "x.h5")
        seconds, moment = time.monotonic() - begin, random.Random(5)
        met = 0
        for _ in self.again():
            for start in ("nothing", "a result"):
                for path in self.folder.glob("x*"):
                    path.unlink()
                if start == "a result":
                    (self.folder / "x.h5").write_bytes((self.folder / "before.h5").read_bytes())
                child = self.start("run", "small.toml", "-o", "x.h5")
                time.sleep(moment.uniform(0, seconds))
                (self.folder / "mine").write_text("mine")
                os.rename(self.folder / "mine", self.folder / "x.h5") if start == "a result" else self.link_if_free()
                err = child.communicate(timeout=PATIENCE)[1]
                self.assertIn(child.returncode, (DONE, CANNOT_WRITE), err)
                texts = [p.read_bytes() for p in self.folder.glob("x*")]
                if not (self.folder / "mine").exists():
                    met += 1
                    self.assertTrue(b"mine" in texts, err)
                self.assertEqual(self.temporaries(), [])
        self.assertGreater(met, 0)

    def link_if_free(self):
        """mine becomes x.h5 if nothing has the name."""
        try:
            os.link(self.folder / "mine", self.folder / "x.h5")
            (self.folder / "mine").unlink()
        except FileExistsError:
            pass


class Strangers(Case):
    """`refine` of a result that somebody else has made: the names of its inputs are his."""

    def result_of(self, survey):
        """The folders of a result whose survey has this name, and an empty one."""
        there, here = self.folder / "there/in", self.folder / "here"
        for folder in (there, here):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
        (there / survey).parent.mkdir(parents=True, exist_ok=True)
        (there / survey).write_text(SURVEY)
        quoted = "".join(f"\\u{ord(c):04x}" if ord(c) < 0xA0 and not c.isprintable() else c for c in survey.replace("\\", "\\\\"))
        (there / "rounds.toml").write_text(ROUNDS.replace("survey.csv", quoted))
        self.call("run", there / "rounds.toml", "-o", there / "r.h5", "--trials", 400)
        return there, here

    def refined(self, survey, *more, code=DONE, says="(?s).*", before=lambda folder: None):
        """What refine writes into an empty folder from a result whose survey has this name."""
        there, here = self.result_of(survey)
        before(here)
        printed = self.call("refine", there / "r.h5", "-o", here / "next.toml", *more, code=code, says=says)
        return printed, sorted(str(p.relative_to(here)) for p in here.rglob("*") if not p.is_dir())

    def test_inputs_of_usual_names_are_written_and_told(self):
        for name in ("well.csv", "data/well A-3.txt", "a/b/Well.LAS"):
            printed, files = self.refined(name)
            self.assertEqual(files, sorted([name, "next.points.csv", "next.toml"]))
            self.assertIn(f"here/{name}, which the config names", printed)
            self.call("check", self.folder / "here/next.toml")

    def test_no_other_names_are_written(self):
        for name in (".bash_profile", ".ssh/authorized_keys", "a/.hidden/x.csv", ".x.csv", "../x.csv", "a/../../x.csv", "./x.csv",
                     "x.py", "Makefile", "a.desktop", "x.csv.sh", "a\x1b[31m.csv", "a\u0085.csv", "a\\b.csv", "next.toml"):
            with self.subTest(name=name):
                _, files = self.refined(name, code=CANNOT_WRITE, says="is not written from the result, as .*name")
                self.assertEqual(files, [])

    def test_rerun_and_merge_write_no_inputs(self):
        for name in (".bash_profile", "../x.csv", "well.csv"):
            with self.subTest(name=name):
                there, here = self.result_of(name)
                for half in (0, 1):
                    self.call("run", there / "rounds.toml", "--trials", 400, "--shard", f"{half}/2", "-o", there / f"{half}.part")
                before = sorted(self.folder.rglob("*"))
                self.call("rerun", there / "r.h5", "--inputs", here)
                self.call("merge", there / "0.part", there / "1.part", "--inputs", here, "-o", here / "whole.h5")
                self.assertEqual(sorted(self.folder.rglob("*")), sorted([*before, here / "whole.h5"]))

    def test_no_link_is_followed(self):
        outside = self.folder / "outside"
        outside.mkdir()
        _, files = self.refined("data/well.csv", code=CANNOT_WRITE, says="here/data is a link",
                                before=lambda here: (here / "data").symlink_to(outside))
        self.assertEqual(list(outside.iterdir()), [])
        for name, more in (("well.csv", []), ("next.points.csv", []), ("next.points.csv", ["--overwrite"])):
            self.refined("well.csv", *more, code=CANNOT_WRITE, before=lambda here, n=name: (here / n).symlink_to(outside / "planted"))
            self.assertEqual(list(outside.iterdir()), [])


if __name__ == "__main__":
    program_from_arguments(__doc__)
    unittest.main()
