#!/usr/bin/python3
"""Runs in parts, merge, status, and disks that fail: test_parts.py SURVEYMC_EXECUTABLE [unittest arguments]

Every comparison is of content hashes with a run in one go.
"""
import os
import random
import signal
import subprocess
import unittest
from pathlib import Path

import h5py

from durability import BAD_INPUT, CANNOT_WRITE, CONFIG, DONE, INTERRUPTED, USAGE, Case, program_from_arguments

SOURCE = Path(__file__).resolve().parents[2]


class Parts(Case):
    def setUp(self):
        super().setUp()
        self.call("run", "small.toml", "-o", "whole.h5")
        self.whole = self.hash_of("whole.h5")

    def part(self, *arguments, folder="p/", **more):
        return self.call("run", "small.toml", "-o", folder, *arguments, **more)

    def test_any_division_gives_the_same_file(self):
        files = set()
        divisions = [[("--shard", f"{i}/{n}") for i in range(n)] for n in (1, 2, 5)]
        divisions.append([("--point", 0), ("--point", 2), ("--point", 1, "--shard", "1/2"), ("--point", 1, "--shard", "0/2")])
        divisions.append([("--shard", "0/2"), ("--shard", "2/5"), ("--shard", "3/5"), ("--shard", "4/5"), ("--point", 1)])
        divisions.append([("--point", "0:2"), ("--point", "2:3")])
        divisions.append([("--point", "0:3:2"), ("--point", "1:3:2"), ("--point", "0:2", "--shard", "1/3")])
        for d, division in enumerate(divisions):
            for i, choice in enumerate(division):
                self.part(*choice, "--threads", (1, 2, 3, 7)[i % 4], folder=f"{d}/")
            parts = sorted((self.folder / str(d)).iterdir())
            random.Random(d).shuffle(parts)
            self.call("merge", "-o", f"{d}.h5", *parts)
            self.assertEqual(self.hash_of(f"{d}.h5"), self.whole, division)
            files.add((self.folder / f"{d}.h5").read_bytes())
        self.assertEqual(len(files), 1)
        self.assertRegex(self.call("rerun", "0.h5"), "identical")

    def test_plan_missing_array_and_status(self):
        self.assertEqual(self.call("plan", "small.toml", "--count"), "3\n")
        self.assertEqual(self.call("plan", "small.toml", "--missing", "p"), "0-2\n")
        self.part("--array", env={"SLURM_ARRAY_TASK_ID": "1", "SLURM_ARRAY_TASK_COUNT": "3"})
        self.assertEqual(self.call("plan", "small.toml", "--missing", "p"), "0,2\n")
        self.assertRegex(self.call("status", "p"), "1 of 3 points done; missing, whole or in part: 0,2")
        self.call("merge", "-o", "m.h5", "p", code=BAD_INPUT, says="missing points 0,2")
        self.assertEqual(self.call("plan", "small.toml", "--missing", "s", "--shards", 9), "0-8\n")
        for i in range(9):
            if i not in (3, 7):
                self.part("--array", "--shards", 9, folder="s/", env={"SLURM_ARRAY_TASK_ID": str(i)})
        self.assertEqual(self.call("plan", "small.toml", "--missing", "s", "--shards", 9), "3,7\n")
        self.call("merge", "-o", "m.h5", "s", code=BAD_INPUT, says="missing shards 3,7 of 9; of point 0 the trials 1536 to 2047")
        self.assertRegex(self.call("status", "s"), "missing shards 3,7 of 9")
        self.call("merge", "-o", "m.h5", "s", "p", code=BAD_INPUT, says="missing of point 0 the trials 1536 to")
        self.assertFalse((self.folder / "m.h5").exists())
        self.part("--shard", "3/9", folder="s/")
        self.call("merge", "-o", "m.h5", "s", code=BAD_INPUT, says="missing shard 7 of 9; of point 0")
        self.part("--shard", "7/9", folder="s/")
        self.assertNotIn("missing", self.call("status", "s"))
        self.assertEqual(self.call("plan", "small.toml", "--missing", "s", "--shards", 9), "")
        self.call("merge", "-o", "m.h5", "s")
        self.assertEqual(self.hash_of("m.h5"), self.whole)
        self.part("--array", code=USAGE, says="SLURM_ARRAY_TASK_ID is not set")

    def test_finished_parts_are_skipped_and_others_refused(self):
        self.part("--point", 1)
        path, = (self.folder / "p").iterdir()
        before = path.stat().st_mtime_ns
        self.part("--point", 1, says="is done already")
        self.part("--point", 1, "--seed", 5, code=CANNOT_WRITE, says="another config")
        self.part("--point", 2, folder=path, code=CANNOT_WRITE, says="another part")
        self.assertEqual(path.stat().st_mtime_ns, before)
        good = path.read_bytes()
        path.write_bytes(good[:-50])
        self.call("merge", "-o", "m.h5", path, code=CANNOT_WRITE, says="damaged")
        self.part("--point", 1, says="damaged.*computed again")
        path.write_text("my notes")
        self.part("--point", 1, code=CANNOT_WRITE, says="no surveymc part file")
        self.assertEqual(path.read_text(), "my notes")

    def test_a_tree_of_merges_gives_the_same_bytes(self):
        for i, choice in enumerate((("--point", 0), ("--point", "1:3"), ("--shard", "0/2"), ("--shard", "1/2"))):
            self.part(*choice, folder=f"p/{i % 2}/")  # folders within the folder
        files = sorted((self.folder / "p").glob("*/*.part"))
        self.call("merge", "-o", "flat.h5", "p")
        self.call("merge", "--part", "-o", "points.part", *[f for f in files if "point" in f.name])
        self.call("merge", "--part", "-o", "shards.part", *[f for f in files if "shard" in f.name])
        self.call("merge", "--part", "-o", "all.part", "points.part", "shards.part", files[0])
        for i, names in enumerate((["points.part"], ["shards.part"], ["all.part"], ["all.part", "points.part", files[1]])):
            self.call("merge", "-o", f"{i}.h5", *names)
            self.assertEqual((self.folder / f"{i}.h5").read_bytes(), (self.folder / "flat.h5").read_bytes(), names)
        self.assertEqual(self.hash_of("flat.h5"), self.whole)
        self.call("merge", "--part", "-o", "x.h5", "points.part", code=USAGE, says="ends in .part")
        self.call("merge", "--part", "--check", "-o", "x.part", "points.part", code=USAGE, says="--check: a part has no verdicts")
        self.call("merge", "--part", "-o", "points.part", "points.part", code=BAD_INPUT, says="is one of the parts")
        self.assertRegex(self.call("status", "p"), "4 parts, .*; 3 of 3 points done\n")

    def test_ranges_of_points(self):
        self.assertEqual(self.call("plan", "small.toml", "--groups", 2), "0:2\n2\n")
        self.assertEqual(self.call("plan", "small.toml", "--groups", 9, "--count"), "3\n")
        self.part("--point", "0:2")
        self.assertEqual([p.name for p in (self.folder / "p").iterdir()], ["points-00000-00002.part"])
        self.assertEqual(self.call("plan", "small.toml", "--groups", 2, "--missing", "p"), "1\n")
        self.assertEqual(self.call("plan", "small.toml", "--missing", "p"), "2\n")
        self.part("--point", "0:2", says="is done already")
        self.part("--point", "0:3:2", folder="p/points-00000-00002.part", code=CANNOT_WRITE, says="another part of this config")
        for bad, rule in (("2:4", "numbered 0 to 2"), ("2:2", "has no points"), ("0:2:0", "step must not be 0"), ("0:x", "whole number"),
                          ("1:2:3:4", "whole number")):
            self.part("--point", bad, code=USAGE, says=rule)

    def test_names_that_merge_would_not_find(self):
        for name in ("x.h5", "x", "x.part.1", "x.PART"):
            self.call("run", "small.toml", "--shard", "0/2", "-o", name, code=USAGE, says=f"-o {name}: the name of a part ends in .part")
            self.assertFalse((self.folder / name).exists())

    def test_a_part_that_was_renamed_is_named(self):
        for shard in (0, 1):
            self.call("run", "small.toml", "--shard", f"{shard}/2", "-o", "r/")
        (self.folder / "r/notes.txt").write_text("no part")
        (self.folder / "r/shard-1-of-2.part").rename(self.folder / "r/second.dat")
        self.call("merge", "r", "-o", "m.h5", code=BAD_INPUT, says="(?s)r/second.dat: is a part whose name does not end in .part.*"
                  "missing shard 1 of 2")
        self.call("status", "r", says="missing shard 1 of 2")
        self.call("merge", "r/shard-0-of-2.part", "r/second.dat", "-o", "m.h5")  # by their names they are merged

    def test_a_mistake_in_the_config_is_none_of_the_command_line(self):
        (self.folder / "bad.toml").write_text(CONFIG.format(trials=5000).replace("survey.csv", "no.csv"))
        for choice in (("--shard", "0/2"), ("--point", "0")):
            self.call("run", "bad.toml", *choice, "-o", "q/", code=BAD_INPUT, says="no.csv.*cannot be read: No such file")

    def test_a_part_does_not_grow_with_the_sweep(self):
        sizes = []
        for count in (10, 1_000_000):
            text = CONFIG.format(trials=5000).replace("noise.scale = [1.0, 0.5, 0.1]",
                                                      f"noise.scale = {{ from = 0.1, to = 1.0, count = {count} }}")
            (self.folder / "sweep.toml").write_text(text)
            self.call("run", "sweep.toml", "--point", 7, "-o", f"{count}.part")
            sizes.append((self.folder / f"{count}.part").stat().st_size)
        self.assertLess(abs(sizes[1] - sizes[0]), 32)
        self.assertLess(sizes[1], 12_000)
        self.assertEqual(self.call("plan", "sweep.toml", "--count"), "1000000\n")
        self.assertEqual(self.call("plan", "sweep.toml", "--groups", 4), "0:250000\n250000:500000\n500000:750000\n750000:1000000\n")
        self.assertRegex(self.call("check", "sweep.toml"), "a sample of [0-9]+ points .*\n# 1000000 sweep points, 5000000000 trials")

    def test_points_of_a_table(self):
        (self.folder / "points.csv").write_text("noise.scale,field.dip_deg\n1.0,60\n0.5,61\n0.1,62\n")
        text = CONFIG.format(trials=5000).replace("noise.scale = [1.0, 0.5, 0.1]", 'design = { kind = "table", file = "points.csv" }')
        (self.folder / "table.toml").write_text(text)
        self.call("run", "table.toml", "-o", "table.h5")
        for choice in ("0:2", "2"):
            self.call("run", "table.toml", "--point", choice, "-o", "t/")
        self.assertFalse(any(b"0.1,62" in p.read_bytes() for p in (self.folder / "t").iterdir()))  # no part has the table
        self.call("merge", "-o", "m.h5", "t")
        self.assertEqual(self.hash_of("m.h5"), self.hash_of("table.h5"))
        self.assertRegex(self.call("rerun", "m.h5"), "identical")
        (self.folder / "points.csv").write_text("noise.scale,field.dip_deg\n1.0,60\n0.5,61\n0.1,63\n")
        self.call("merge", "-o", "m.h5", "t", code=BAD_INPUT, says="points.csv.*another one")
        self.call("run", "table.toml", "--point", "2", "-o", "t/", code=CANNOT_WRITE, says="another config")

    def test_other_contents_of_an_input_file(self):
        self.part("--point", 0)
        path = self.folder / "survey.csv"
        path.write_text(path.read_text().replace("30,14", "30,15"))
        self.part("--point", 0, code=CANNOT_WRITE, says="other contents of survey.csv")
        self.part("--point", "1:3")
        self.call("merge", "-o", "m.h5", "p", code=BAD_INPUT, says="survey.csv had other contents")

    def test_parts_of_an_earlier_format_are_refused_by_name(self):
        (self.folder / "old.part").write_bytes(b"SMCPART2" + bytes(200))
        self.call("merge", "-o", "m.h5", "old.part", code=CANNOT_WRITE, says="old.part: is a part file of another version")

    def test_foreign_parts_are_not_merged(self):
        for i in range(2):
            self.part("--shard", f"{i}/2")
        self.call("run", "small.toml", "--seed", 9, "--shard", "0/3", "-o", "q/")
        self.call("merge", "-o", "m.h5", "p", "q", code=BAD_INPUT, says="is of another config")
        self.call("merge", "-o", "m.h5", "whole.h5", code=USAGE, says="must be a part of a run, but this is a result")
        self.call("merge", "-o", "survey.csv", "p", code=CANNOT_WRITE, says="refusing to overwrite")

    def test_what_is_refused(self):
        for rule, *arguments in (("numbered 0 to 2", "--point", 3), ("numbered 0 to 1", "--shard", "2/2"),
                                 ("I/N", "--shard", "2"), ("whole number", "--shard", "a/b"), ("at least one shard", "--shard", "0/0"),
                                 ("verdicts", "--point", 0, "--check"), ("--array", "--shards", 3)):
            self.part(*arguments, code=USAGE, says=rule)
        self.call("run", "maps.toml", "--shard", "0/2", "-o", "p/", code=USAGE, says="no trials to divide")

    def test_a_study_without_trials(self):
        self.call("run", "maps.toml", "-o", "maps.h5")
        for point in (1, 0):
            self.call("run", "maps.toml", "--point", point, "-o", "p/")
        self.call("merge", "-o", "m.h5", "p")
        self.assertEqual(self.hash_of("m.h5"), self.hash_of("maps.h5"))

    def test_a_killed_part_goes_on(self):
        self.call("run", "large.toml", "-o", "large.h5")
        for shard in ("0/2", "1/2"):
            choice = ("run", "large.toml", "--shard", shard, "-o", "k/", "--resume", "--checkpoint-seconds", "0.02")
            for _ in range(3):
                self.interrupt(*choice)
            self.call(*choice)
        self.call("merge", "-o", "m.h5", "k")
        self.assertEqual(self.hash_of("m.h5"), self.hash_of("large.h5"))
        self.assertEqual(self.journals(), [])


    def kept_points(self, path):
        """Points without trials of a journal; docs/results-format.md has the form."""
        data, at, points = path.read_bytes(), 0, []
        while data[at:at + 8] == b"SMCJRNL1":
            size, begin = int.from_bytes(data[at + 8:at + 16], "little"), at + 16
            for _ in range(2):  # config hash, program
                begin += 8 + int.from_bytes(data[begin:begin + 8], "little")
            what = int.from_bytes(data[begin:begin + 8], "little")
            self.assertGreaterEqual(what, 1 << 63)
            points.append(what - (1 << 63))
            at += 16 + size + 16
        if at > len(data):  # killed within a write
            points.pop()
            return points
        self.assertEqual(at, len(data))
        return points

    def killed_and_resumed(self, *command):
        """A run without trials, killed three times, and a record of its journal damaged before it ends."""
        output = self.folder / command[-1]
        run = ("run", *command, "--resume", "--checkpoint-seconds", "0.001")
        wanted = [signal.SIGKILL, signal.SIGTERM, signal.SIGKILL]
        for _ in range(30):
            code, err = self.interrupt(*run, number=wanted[-1])
            if code == DONE:  # it was faster than the signal
                output.unlink()
                continue
            self.assertEqual(code, INTERRUPTED if wanted.pop() == signal.SIGTERM else -signal.SIGKILL, err)
            if not wanted:
                break
        self.assertEqual(wanted, [])
        kept = [point for path in self.journals() for point in self.kept_points(path)]
        self.assertEqual(len(set(kept)), len(kept), "a point was computed twice")
        self.call(*run[:-3], code=CANNOT_WRITE, says="was not finished.*--resume, or delete")
        journal = self.journals()[0]
        damaged = bytearray(journal.read_bytes())
        damaged[len(damaged) // 2] ^= 1
        journal.write_bytes(damaged)
        self.call(*run, says=f"is damaged; what cannot be read is computed again(?s:.*)going on from {len(kept) - 1} point")
        self.assertEqual(self.journals(), [])

    def test_killed_points_without_trials_go_on(self):
        text = (self.folder / "maps.toml").read_text().replace("step = 45.0", "step = 1.0")
        (self.folder / "grid.toml").write_text(text[:text.index("alpha")] + "alpha = { from = 1e-4, to = 1e-2, count = 200 }\n")
        self.call("run", "grid.toml", "--point", "0:200", "-o", "whole.part")
        self.call("merge", "-o", "whole.h5", "whole.part")
        self.killed_and_resumed("grid.toml", "--point", "0:200", "-o", "k.part")
        self.call("merge", "-o", "k.h5", "k.part")
        self.assertEqual((self.folder / "k.h5").read_bytes(), (self.folder / "whole.h5").read_bytes())
        (self.folder / "k.h5").unlink()
        self.killed_and_resumed("grid.toml", "-o", "k.h5")  # in one go
        self.assertEqual(self.hash_of("k.h5"), self.hash_of("whole.h5"))

    def test_a_merge_that_is_interrupted_leaves_nothing(self):
        for i in range(3):
            self.part("--point", i)
        for i in range(12):
            code, err = self.interrupt("merge", "-o", "m.h5", "p", number=signal.SIGINT, after=0.004 * i)
            self.assertIn(code, (DONE, INTERRUPTED, -signal.SIGINT), err)
            self.assertEqual(self.temporaries(), [])
            if code == DONE:
                self.assertEqual(self.hash_of("m.h5"), self.whole)
                (self.folder / "m.h5").unlink()
            self.assertFalse((self.folder / "m.h5").exists())
        self.call("merge", "-o", "m.h5", "p")
        self.assertEqual(self.hash_of("m.h5"), self.whole)

    def test_groups_of_equal_cost_count_stations(self):
        rows = (self.folder / "survey.csv").read_text().splitlines()
        (self.folder / "short.csv").write_text("\n".join(rows[:3]) + "\n")  # 2 stations, the other has 6
        text = (self.folder / "small.toml").read_text().replace('file = "survey.csv"\n', "")
        (self.folder / "wells.toml").write_text(text.replace(
            "[sweep]", '[[sweep.case]]\nname = "short"\nsurvey.file = "short.csv"\n[[sweep.case]]\nname = "long"\nsurvey.file = "survey.csv"\n[sweep]'))
        self.assertEqual(self.call("plan", "wells.toml", "--groups", 2).split(), ["0:4", "4:6"])  # 3 x 2 + 6 of 24

    def test_a_sensitivity_table_is_that_of_the_whole_run_whatever_the_parts(self):
        smoke = SOURCE / "configs/smoke/sensitivity.toml"
        self.call("run", smoke, "-o", "s.h5")
        for r in ("0:17", "17:60"):
            self.call("run", smoke, "--point", r, "-o", "sp/")
        self.call("merge", "-o", "sm.h5", "sp")
        self.assertEqual(self.hash_of("sm.h5"), self.hash_of("s.h5"))
        self.call("run", smoke, "-o", "t.h5", "--set", "sensitivity.quantity=covariance.sd", code=BAD_INPUT,
                  says="sensitivity.quantity: table covariance has no column sd; it has")


class Differences(Case):
    def test_runs_that_ended_by_their_verdicts(self):
        text = (self.folder / "small.toml").read_text().replace("trials = 5000\n", "").replace(
            "[survey]", '[stop]\nverdict = ["position.sigma3_north"]\nmax_trials = 8000\n[survey]')
        (self.folder / "stop.toml").write_text(text)
        for seed in (1, 2):
            self.call("run", "stop.toml", "-o", f"{seed}.h5", "--seed", seed)
        self.assertRegex(self.call("diff", "1.h5", "2.h5"), r"other seeds(.|\n)*\n0 differ(.|\n)*power: ")
        for r in ("0:2", "2"):  # every point has its own stop, whatever task runs it
            self.call("run", "stop.toml", "--point", r, "-o", "p/", "--seed", 1)
        self.call("merge", "-o", "m.h5", "p")
        self.assertEqual(self.hash_of("m.h5"), self.hash_of("1.h5"))

    def test_two_seeds_do_not_differ_and_two_configs_do(self):
        run = lambda name, *more: self.call("run", "small.toml", "-o", name, *more)
        run("a.h5")
        run("b.h5", "--seed", 2)
        self.call("diff", "a.h5", "a.h5", says="0 differ.*the same|the same seed(.|\n)*0 differ")
        self.assertRegex(self.call("diff", "a.h5", "b.h5"), r"other seeds(.|\n)*\n0 differ(.|\n)*power: .* % of the value")
        self.assertTrue(self.call("diff", "a.h5", "b.h5").startswith("keys of the config that differ:\n  seed: 1 in A, 2 in B\n\n"))
        self.assertTrue(self.call("diff", "a.h5", "a.h5").startswith("no key of the config differs\n\n"))
        run("c.h5", "--set", "noise.magnetometer_nT=50.5", "--seed", 2)
        self.call("diff", "a.h5", "c.h5", code=1)  # the predictions have changed, whatever chance did
        run("d.h5", "--set", "noise.magnetometer_nT=50.5")
        self.assertRegex(self.call("diff", "a.h5", "d.h5", code=1), "changed")  # common draws: everything shows
        csv = self.call("diff", "a.h5", "b.h5", "--csv")
        self.assertTrue(csv.startswith("table,row,column,finding,"), csv[:80])
        self.assertGreater(len(csv.splitlines()), 20)
        self.assertIn('"name":', self.call("diff", "a.h5", "b.h5", "--json").replace(" ", "").replace('"name":', '"name":'))
        run("e.h5", "--set", "noise.scale=1.0")
        self.assertRegex(self.call("diff", "a.h5", "e.h5", code=1), r"(?s)^keys of the config that differ:\n.*  noise\.scale: \S.* in A, .*only in A")
        self.call("run", "maps.toml", "-o", "maps.h5")
        self.call("diff", "a.h5", "maps.h5", code=BAD_INPUT, says="different experiments")
        self.call("diff", "maps.h5", "maps.h5", says="0 differ")
        (self.folder / "bad.h5").write_bytes((self.folder / "a.h5").read_bytes()[:-30])
        self.call("diff", "a.h5", "bad.h5", code=CANNOT_WRITE, says="bad.h5")


class Disks(Case):
    def test_read_only_folder(self):
        nobody = {"user": 65534} if os.geteuid() == 0 else {}  # root may write anywhere
        self.folder.chmod(0o755)
        (self.folder / "ro").mkdir(mode=0o555)
        try:
            done = subprocess.run([*self.PROGRAM, "run", "small.toml", "--point", "0", "-o", "ro/"], cwd=self.folder, text=True,
                                  capture_output=True, **nobody)
        except PermissionError:
            self.skipTest("the program is in a folder that only root may enter")
        self.assertEqual(done.returncode, CANNOT_WRITE, done.stderr)
        self.assertRegex(done.stderr, "ro/point-00000.part: cannot be written: Permission denied")

    def test_missing_folder_of_a_file(self):
        self.call("run", "small.toml", "--point", 0, "-o", "no/a.part", code=CANNOT_WRITE, says="No such file")

    def test_full_disk(self):
        disk = self.folder / "disk"
        disk.mkdir()
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", disk],
                                               capture_output=True).returncode:
            self.skipTest("no tmpfs can be mounted here")
        try:
            (disk / "ballast").write_bytes(b"x" * 40_000)
            # The journal does not fit: the run goes on, and says so when it is interrupted
            self.call("run", "endless.toml", "--set", "save_samples=20000", "-o", "disk/out.h5", "--checkpoint-seconds", "0.01",
                      "--max-seconds", 3, code=CANNOT_WRITE, says="interrupted, and the checkpoint .* could not be written: No space left")
            self.call("run", "small.toml", "--set", "save_samples=2000", "--point", 0, "-o", "disk/", code=CANNOT_WRITE,
                      says="No space left")
            self.assertEqual(list(disk.glob("*.part")), [])
        finally:
            subprocess.run(["umount", disk], check=True)

    def test_results_that_are_damaged_or_foreign_stay_as_they_are(self):
        self.call("run", "small.toml", "-o", "r.h5")
        good = (self.folder / "r.h5").read_bytes()
        for bad in (good[:len(good) // 2], good[:-40], b"my notes", b""):
            (self.folder / "r.h5").write_bytes(bad)
            for command in (("show", "r.h5"), ("rerun", "r.h5")):
                self.call(*command, code=CANNOT_WRITE, says="error: r.h5: ")
            if bad == b"my notes":
                self.call("run", "small.toml", "-o", "r.h5", code=CANNOT_WRITE, says="refusing to overwrite")
            self.assertEqual((self.folder / "r.h5").read_bytes(), bad)


ROUNDS = """\
experiment = "msa_position"
seed = 11
trials = 2000
estimator = "msa_joint"
[survey]
file = "survey.csv"
toolface_zero = "y"
[field]
total_nT = 50000.0
dip_deg = 60.0
[noise]
magnetometer_nT = 70.0
reference = { per = "run", total_nT = 130.0, dip_deg = 0.2 }
[refine]
quantity = "parameters.monte_carlo"
where = { quantity = "sigma3_bias_x", formulation = "first_order" }
level = 60.0
cell = 0.1
[sensitivity]
quantity = "parameters.monte_carlo"
where = { quantity = "sigma3_bias_x", formulation = "first_order" }
[sweep]
field.dip_deg = [40.0, 50.0, 60.0, 70.0, 80.0]
noise.magnetometer_nT = [20.0, 40.0, 60.0, 100.0]
"""


class Rounds(Case):
    """The estimator's noise is by default that of the sensors, which all points of the second round share."""

    def text(self, name):
        with h5py.File(self.folder / name) as f:
            return f.attrs["config"]

    def test_merged_rounds_are_the_run_of_all_their_points(self):
        (self.folder / "rounds.toml").write_text(ROUNDS)
        self.call("run", "rounds.toml", "-o", "0.h5")
        self.call("refine", "0.h5", "-o", "next.toml")
        self.call("run", "next.toml", "-o", "1.h5")
        with h5py.File(self.folder / "1.h5") as f:
            self.assertEqual(len(set(f["tables/parameters/noise.magnetometer_nT"])), 1)
        for name in ("0.h5", "1.h5"):
            self.assertNotIn("magnetometer_nT", self.text(name).split("[estimator]")[1].split("[")[0])
        said = self.call("merge", "-v", "-o", "all.h5", "0.h5", "1.h5")
        for text in ("covariance_tests", "verdicts: ", "wrote all.h5 (from 2 results)"):  # the tables, as a merge of parts prints them
            self.assertIn(text, said)
        with h5py.File(self.folder / "all.h5") as f, h5py.File(self.folder / "0.h5") as first:
            self.assertIn("sensitivity", first["tables"])
            self.assertNotIn("sensitivity", f["tables"])
            self.assertEqual(f["tables/family/verdicts"].shape, (1,))
            self.assertGreater(f["tables/family/verdicts"][0], first["tables/family/verdicts"][0])
        self.assertRegex(self.call("rerun", "all.h5"), "identical")
        self.call("refine", "all.h5", "-o", "third.toml")
        self.assertNotIn("magnetometer_nT", (self.folder / "third.toml").read_text().split("[estimator]")[1].split("[")[0])

    def test_merged_rounds_have_the_maps_of_all_their_points(self):
        config = (Path(__file__).resolve().parents[2] / "configs/sweeps/msa_harm_boundary.toml").read_text()
        for old, new in (("count = 14", "count = 4"), ("[10, 30, 100]", "[10, 30]"), ("cell = 0.01", "cell = 0.17")):
            self.assertIn(old, config)
            config = config.replace(old, new)
        (self.folder / "rounds.toml").write_text(config)
        self.call("run", "rounds.toml", "-o", "0.h5")
        self.call("refine", "0.h5", "-o", "next.toml")
        self.call("run", "next.toml", "-o", "1.h5")
        self.call("merge", "-v", "-o", "all.h5", "0.h5", "1.h5")
        of = {}
        for name in ("0", "1", "all"):
            with h5py.File(self.folder / f"{name}.h5") as f:
                of[name] = f["maps/azimuth_ratio"][()]
        self.assertEqual([of["0"].shape, of["1"].ndim, of["all"].ndim], [(4, 4, 2), 1, 1])  # the direction is the sweep's
        self.assertEqual(of["all"].ravel().tolist(), [*of["0"].ravel(), *of["1"].ravel()])
        self.assertRegex(self.call("rerun", "all.h5"), "identical")
        self.call("refine", "all.h5", "-o", "third.toml")

    def test_a_round_of_another_survey_is_none(self):
        (self.folder / "rounds.toml").write_text(ROUNDS.replace("trials = 2000", "trials = 100"))
        self.call("run", "rounds.toml", "-o", "0.h5")
        self.call("refine", "0.h5", "-o", "next.toml")
        survey = self.folder / "survey.csv"
        survey.write_text(survey.read_text().replace("60,18", "60,19"))
        self.call("run", "next.toml", "-o", "1.h5")
        self.call("merge", "-o", "all.h5", "0.h5", "1.h5", code=BAD_INPUT, says="1.h5: is no round of the sweep of 0.h5: survey.csv had other contents")

    def test_check_of_merged_rounds(self):
        """A verdict is judged in the rounds' result as in that of any other merge."""
        expect = '[[expect]]\ntable = "parameters"\nformulation = "first_order"\nquantities = ["sigma3_bias_x"]\nverdict = "differs"\n'
        (self.folder / "rounds.toml").write_text(ROUNDS + expect)
        self.call("run", "rounds.toml", "-o", "0.h5")
        self.call("refine", "0.h5", "-o", "next.toml")
        self.call("run", "next.toml", "-o", "1.h5")
        said = self.call("merge", "-o", "all.h5", "0.h5", "1.h5", "--check", code=1)
        self.assertRegex(said, r"verdicts: .* not as expected")
        self.assertRegex(said, r"(?m)^wrote all.h5 \(from 2 results\)$")
        self.call("merge", "-o", "all.h5", "0.h5", "1.h5", "--overwrite")


if __name__ == "__main__":
    program_from_arguments(__doc__)
    unittest.main()
