#!/usr/bin/python3
"""Kill anything at any time, lose nothing: test_resume.py SURVEYMC_EXECUTABLE [unittest arguments]

Journals and --resume. Every comparison is of content hashes with an uninterrupted run. SURVEYMC_KILLS (10) is how many
SIGKILLs a run has to survive; test_kills.py has a thousand over six experiments, nightly.
"""
import os
import random
import re
import shutil
import signal
import subprocess
import time
import unittest

import h5py

from durability import BAD_INPUT, CANNOT_WRITE, CONFIG, DONE, INTERRUPTED, PATIENCE, USAGE, Case, program_from_arguments


class Resume(Case):
    RUN = ("run", "large.toml", "-o", "out.h5", "--checkpoint-seconds", "0.01")
    ENDLESS = ("run", "endless.toml", "-o", "out.h5", "--checkpoint-seconds", "0.01")

    def whole(self):
        """Content hash, and how long it takes."""
        begin = time.monotonic()
        self.call("run", "large.toml", "-o", "whole.h5")
        return self.hash_of("whole.h5"), time.monotonic() - begin

    def test_random_kills(self):
        (whole, seconds), moment, kills, finished = self.whole(), random.Random(1), 0, 0
        wanted = int(os.environ.get("SURVEYMC_KILLS", "10"))
        while kills < wanted:
            code, err = self.interrupt(*self.RUN, "--resume", "--threads", (1, 2, 3, 7)[kills % 4],
                                       after=moment.uniform(0, 0.4 * seconds))
            self.assertIn(code, (DONE, -signal.SIGKILL), err)
            kills += code == -signal.SIGKILL
            if (self.folder / "out.h5").exists():  # then it is whole
                self.assertEqual(self.hash_of("out.h5"), whole)
                self.assertFalse(code == DONE and self.journals())
                (self.folder / "out.h5").unlink()
                finished += 1
                self.assertLess(finished, 10 * wanted)
        self.call(*self.RUN, "--resume")
        self.assertEqual(self.hash_of("out.h5"), whole)
        self.assertEqual(self.journals(), [])
        self.assertEqual(self.temporaries(), [])
        print(f"{kills} kills, {finished} results beside them", flush=True)

    def test_signals(self):
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1, signal.SIGHUP, signal.SIGXCPU):
            code, err = self.interrupt(*self.ENDLESS, "--resume", number=number)
            self.assertEqual(code, INTERRUPTED, err)
            self.assertRegex(err, r"interrupted: what is done is kept beside out.h5; go on with: surveymc run .* --resume")
            self.assertTrue(self.journals())
            self.assertFalse((self.folder / "out.h5").exists())

    def test_nothing_is_said_to_be_kept_in_a_folder_that_is_gone(self):
        for gone in (shutil.rmtree, lambda folder: folder.rename(self.folder / "elsewhere")):
            (self.folder / "out").mkdir()
            child = self.start("run", "large.toml", "--trials", 4_000_000, "-o", "out/x.h5", "--checkpoint-seconds", 0.01)
            while child.poll() is None and not self.journals():
                time.sleep(0.005)
            gone(self.folder / "out")
            err = child.communicate(timeout=PATIENCE)[1]
            self.assertEqual(child.returncode, CANNOT_WRITE, err)
            self.assertNotIn("is kept", err)

    def test_nohup_is_respected(self):
        child = subprocess.Popen([*self.PROGRAM, *self.RUN], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                 preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        while child.poll() is None:
            child.send_signal(signal.SIGHUP)
            time.sleep(0.01)
        self.assertEqual(child.returncode, DONE, child.stderr.read())

    def test_a_signal_at_once_does_no_harm(self):
        # Before main() a signal kills; behind it the program ends by itself, with or without anything that is done.
        for i in range(20):
            code, err = self.interrupt(*self.ENDLESS, "--resume", number=signal.SIGTERM, after=0.002 * i)
            self.assertIn(code, (-signal.SIGTERM, INTERRUPTED), err)
            self.assertEqual(self.temporaries(), [])
        self.assertFalse((self.folder / "out.h5").exists())

    def test_max_seconds(self):
        whole, _ = self.whole()
        self.assertGreater(self.run_until_done(*self.RUN), 0)
        self.assertEqual(self.hash_of("out.h5"), whole)
        self.assertEqual(self.journals(), [])
        self.call("run", "endless.toml", "-o", "e.h5", "--max-seconds", "0.000001", code=INTERRUPTED, says="nothing was written")
        self.assertEqual(self.journals(), [])

    def test_trials_and_rate_are_those_that_were_drawn(self):
        self.interrupt(*self.RUN, "--resume", "--threads", 1)
        out = self.call(*self.RUN, "--resume")
        told = re.search(r"wrote out.h5 \((\d+) trials, (\d+) of them from an earlier attempt, in ", out)
        self.assertTrue(told, out)
        self.assertEqual(int(told[1]), 1_200_000)
        self.assertTrue(0 < int(told[2]) <= 1_200_000, out)
        rule = '[stop]\nquantities = ["sigma3_north"]\nrelative_ci = 0.02\nmax_trials = 1000000\n'
        (self.folder / "stop.toml").write_text(CONFIG.format(trials=1).replace("trials = 1\n", "") + rule)
        out = self.call("run", "stop.toml", "-o", "stop.h5")
        with h5py.File(self.folder / "stop.h5") as f:
            table = f["tables/position"]
            trials = sum({s: n for s, n in zip(table["noise.scale"][:], table["trials"][:])}.values())
        self.assertLess(trials, 100_000)
        self.assertRegex(out, rf"wrote stop.h5 \({trials} trials in ")
        self.assertRegex(self.call("rerun", "stop.h5"), rf"\({trials} trials in ")
        self.assertRegex(self.call("show", "stop.h5"), " at most 1000000 trials a point;")
        self.assertRegex(self.call("show", "out.h5"), ", 400000 trials a point;")

    def test_what_is_refused(self):
        self.assertEqual(self.interrupt(*self.ENDLESS, number=signal.SIGTERM)[0], INTERRUPTED)
        journal = self.journals()[0].read_bytes()
        self.call(*self.ENDLESS, code=CANNOT_WRITE, says="was not finished.*--resume, or delete")
        self.call(*self.ENDLESS, "--resume", "--seed", 2, code=CANNOT_WRITE, says="another config")
        self.call(*self.ENDLESS, "--seed", 2, code=CANNOT_WRITE, says="another config")
        self.assertEqual(self.journals()[0].read_bytes(), journal)
        self.assertFalse((self.folder / "out.h5").exists())

    def test_damaged_journals(self):
        whole, _ = self.whole()
        code = INTERRUPTED
        while not self.journals():
            code, err = self.interrupt(*self.RUN, number=signal.SIGTERM)
            self.assertIn(code, (DONE, INTERRUPTED), err)  # DONE: it was faster than the signal
        path, = self.journals()
        good = path.read_bytes()
        for at in (0, 9, len(good) // 2, len(good) - 1):
            for bad in (good[:at], good[:at] + bytes([good[at] ^ 1]) + good[at + 1:]):
                path.write_bytes(bad)
                (self.folder / "out.h5").unlink(missing_ok=True)  # else it is done already
                self.call("run", "large.toml", "-o", "out.h5", "--resume")
                self.assertEqual(self.hash_of("out.h5"), whole)
        path.unlink(missing_ok=True)

    def test_two_attempts_at_once(self):
        whole, _ = self.whole()
        for _ in range(3):
            self.interrupt(*self.RUN, "--resume", number=signal.SIGTERM)
            children = [self.start(*self.RUN, "--resume") for _ in range(2)]
            ends = [(c.communicate(timeout=PATIENCE)[1], c.returncode) for c in children]
            self.assertEqual([code for _, code in ends], [DONE, DONE], ends)
            self.assertEqual(self.hash_of("out.h5"), whole)

    def test_resume_on_the_first_start_and_with_a_stopping_rule(self):
        text = CONFIG.format(trials=1).replace("trials = 1\n", "")
        (self.folder / "stop.toml").write_text(text + '[stop]\nquantities = ["sigma3_north"]\nrelative_ci = 0.006\nmax_trials = 1000000\n')
        begin = time.monotonic()
        self.call("run", "stop.toml", "-o", "whole.h5", "--resume")
        seconds = time.monotonic() - begin
        for i in range(8):
            self.interrupt("run", "stop.toml", "-o", "out.h5", "--resume", "--checkpoint-seconds", "0.01", after=seconds * i / 8)
        self.call("run", "stop.toml", "-o", "out.h5", "--resume")
        self.assertEqual(self.hash_of("out.h5"), self.hash_of("whole.h5"))
        for point in range(3):
            self.call("run", "stop.toml", "-o", "p/", "--point", point)
        self.call("merge", "-o", "merged.h5", "p")
        self.assertEqual(self.hash_of("merged.h5"), self.hash_of("whole.h5"))
        self.call("run", "stop.toml", "-o", "p/", "--shard", "0/2", code=USAGE, says=r"ends by \[stop\]")


if __name__ == "__main__":
    program_from_arguments(__doc__)
    unittest.main()
