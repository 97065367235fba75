#!/usr/bin/python3
"""Nothing that a user had is lost, and --quiet is quiet: test_backup.py SURVEYMC_EXECUTABLE [unittest arguments]"""
import os
import resource
import signal
import subprocess
import unittest

from durability import CANNOT_WRITE, DONE, INTERRUPTED, Case, content_hash, program_from_arguments


class Backup(Case):
    def bytes(self, name):
        return (self.folder / name).read_bytes()

    def files(self, suffix=".h5"):
        return sorted(p.name for p in self.folder.iterdir() if suffix in p.name)

    def run_small(self, *arguments, seed=1, output="out.h5", **more):
        return self.call("run", "small.toml", "--trials", 600, "--seed", seed, "-o", output, *arguments, **more)

    def test_every_result_is_kept_under_the_next_number(self):
        old = []
        for seed in range(1, 5):
            said = self.run_small(seed=seed)
            self.assertEqual("the file that was there is now" in said, seed > 1, said)
            old.append(self.bytes("out.h5"))
        self.assertEqual(self.files(), ["out.1.h5", "out.2.h5", "out.3.h5", "out.h5"])
        self.assertEqual([self.bytes(f"out.{n}.h5") for n in (1, 2, 3)], old[:3])
        (self.folder / "out.2.h5").unlink()  # a gap is filled, and nothing else touched
        self.run_small("--overwrite", seed=9)
        self.assertEqual(self.files(), ["out.1.h5", "out.3.h5", "out.h5"])
        before = self.bytes("out.h5")
        self.assertIn("is now out.2.h5", self.run_small(seed=5))
        self.assertEqual((self.bytes("out.1.h5"), self.bytes("out.2.h5"), self.bytes("out.3.h5")), (old[0], before, old[2]))

    def test_a_run_that_fails_leaves_all_as_it_was(self):
        self.run_small()
        before = {n: self.bytes(n) for n in self.files()}
        self.run_small("--set", "noise.magnetometer_nT=-1", code=65)
        (self.folder / "notes.h5").write_text("mine")
        self.run_small(output="notes.h5", code=CANNOT_WRITE, says="refusing to overwrite")
        self.run_small("--overwrite", output="notes.h5", code=CANNOT_WRITE, says="refusing to overwrite")
        self.assertEqual(self.bytes("notes.h5"), b"mine")
        self.assertEqual({n: self.bytes(n) for n in self.files() if n != "notes.h5"}, before)

    def test_a_result_that_cannot_be_written_leaves_the_old_one_its_name(self):
        def little():  # the second result is larger than a file may be
            resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

        self.run_small()
        before = self.bytes("out.h5")
        done = subprocess.run([*self.PROGRAM, "run", "small.toml", "--trials", "5000", "--set", "save_samples=5000", "-o", "out.h5"],
                              cwd=self.folder, capture_output=True, text=True, preexec_fn=little)
        self.assertEqual(done.returncode, CANNOT_WRITE, done.stderr)
        self.assertEqual([n for n in self.files() if "journal" not in n], ["out.h5"])
        self.assertEqual(self.bytes("out.h5"), before)

    def test_an_interrupted_run_keeps_the_old_result_until_it_is_done(self):
        self.run_small()
        before = self.bytes("out.h5")
        for number in (signal.SIGKILL, signal.SIGTERM):
            code, said = self.interrupt("run", "large.toml", "-o", "out.h5", "--resume", "--threads", 1, "--checkpoint-seconds", 0.01,
                                        number=number)
            self.assertEqual(code, -number if number == signal.SIGKILL else INTERRUPTED, said)
            self.assertEqual(self.bytes("out.h5"), before)
            self.assertFalse((self.folder / "out.1.h5").exists())
        self.call("run", "large.toml", "-o", "out.h5", "--resume", says="going on from [0-9]+ trials")
        self.assertEqual(self.files(), ["out.1.h5", "out.h5"])
        self.assertEqual(self.bytes("out.1.h5"), before)
        self.call("run", "large.toml", "-o", "plain.h5")
        self.assertEqual(self.hash_of("out.h5"), self.hash_of("plain.h5"))

    def test_a_kill_between_the_two_names_makes_no_second_copy(self):
        self.run_small()
        before = self.bytes("out.h5")
        os.link(self.folder / "out.h5", self.folder / "out.1.h5")  # what such a kill leaves
        self.assertIn("is now out.1.h5", self.run_small(seed=2))
        self.assertEqual(self.files(), ["out.1.h5", "out.h5"])
        self.assertEqual(self.bytes("out.1.h5"), before)

    def test_a_link_keeps_the_file_it_leads_to(self):
        (self.folder / "far").mkdir()
        self.run_small(output="far/real.h5")
        before = self.bytes("far/real.h5")
        (self.folder / "latest.h5").symlink_to("far/real.h5")
        self.assertIn("is now far/real.1.h5", self.run_small(seed=2, output="latest.h5"))
        self.assertTrue((self.folder / "latest.h5").is_symlink())
        self.assertEqual(self.bytes("far/real.1.h5"), before)
        self.assertNotEqual(self.bytes("far/real.h5"), before)

    def test_merge_keeps_the_old_result_and_parts_are_not_mixed(self):
        for point in range(3):
            self.call("run", "small.toml", "--point", point, "-o", "p/")
        self.run_small(output="whole.h5")
        before = self.bytes("whole.h5")
        self.assertIn("is now whole.1.h5", self.call("merge", "p", "-o", "whole.h5"))
        self.assertEqual(self.bytes("whole.1.h5"), before)
        merged = self.bytes("whole.h5")
        self.call("merge", "p", "-o", "whole.h5", "--overwrite")
        self.assertEqual(self.files(), ["whole.1.h5", "whole.h5"])
        self.assertEqual(self.bytes("whole.h5"), merged)
        # A part that is there is not computed again, with or without --overwrite; one of another config is refused or replaced.
        part = self.folder / "p/point-00001.part"
        kept = part.read_bytes()
        self.call("run", "small.toml", "--point", 1, "-o", "p/", says="is done already")
        self.call("run", "small.toml", "--point", 1, "-o", "p/", "--overwrite", says="is done already")
        self.call("run", "small.toml", "--seed", 2, "--point", 1, "-o", "p/", code=CANNOT_WRITE, says="replace it with --overwrite")
        self.assertEqual(part.read_bytes(), kept)
        self.call("run", "small.toml", "--seed", 2, "--point", 1, "-o", "q.part")
        self.call("run", "small.toml", "--point", 1, "-o", "q.part", "--overwrite")
        self.assertFalse((self.folder / "q.part.1").exists())
        # A damaged one is kept where merge does not see it.
        part.write_bytes(kept[:-5])
        self.call("run", "small.toml", "--point", 1, "-o", "p/", says="is now p/point-00001.part.1")
        self.assertEqual((self.folder / "p/point-00001.part.1").read_bytes(), kept[:-5])
        self.call("merge", "p", "-o", "again.h5")
        self.assertEqual(content_hash(self.folder / "again.h5"), content_hash(self.folder / "whole.h5"))

    def test_an_interrupted_shard_that_is_resumed(self):
        self.call("run", "large.toml", "--seed", 2, "--trials", 2000, "--shard", "0/2", "-o", "a.part")
        before = self.bytes("a.part")
        arguments = ["run", "large.toml", "--shard", "0/2", "-o", "a.part", "--overwrite", "--threads", 1, "--checkpoint-seconds", 0.01]
        code, said = self.interrupt(*arguments, number=signal.SIGTERM)
        self.assertEqual(code, INTERRUPTED, said)
        self.assertEqual(self.bytes("a.part"), before)
        self.call(*arguments, "--resume")
        self.call("run", "large.toml", "--shard", "1/2", "-o", "b.part")
        self.call("merge", "a.part", "b.part", "-o", "merged.h5")
        self.call("run", "large.toml", "-o", "plain.h5")
        self.assertEqual(self.hash_of("merged.h5"), self.hash_of("plain.h5"))

    def test_a_rerun_writes_nothing(self):
        self.run_small()
        before = self.bytes("out.h5")
        self.call("rerun", "out.h5")
        self.assertEqual(self.files(), ["out.h5"])
        self.assertEqual(self.bytes("out.h5"), before)


class Quiet(Case):
    def test_nothing_is_printed(self):
        for words in (["check", "small.toml"], ["run", "small.toml", "-o", "out.h5"], ["run", "small.toml", "-o", "out.h5"],
                      ["run", "small.toml", "--point", "0", "-o", "p/"], ["run", "small.toml", "--point", "1", "-o", "p/"],
                      ["run", "small.toml", "--point", "2", "-o", "p/"], ["merge", "p", "-o", "merged.h5"], ["rerun", "out.h5"]):
            for flag in ("--quiet", "-q"):
                done = subprocess.run([*self.PROGRAM, *words, flag], cwd=self.folder, capture_output=True, text=True)
                self.assertEqual((done.returncode, done.stdout, done.stderr), (DONE, "", ""), words)
        self.assertEqual(self.hash_of("out.h5"), self.hash_of("merged.h5"))

    def test_exit_codes_and_messages_stay(self):
        text = (self.folder / "small.toml").read_text()
        (self.folder / "strict.toml").write_text(text + '[[expect]]\ntable = "position"\nquantities = ["sigma3_north"]\nverdict = "differs"\n')
        self.call("run", "strict.toml", "-o", "s.h5", "--check", "--quiet", code=1)
        self.call("run", "none.toml", "--quiet", code=65, says="none.toml: cannot be read")
        journal = self.interrupt("run", "endless.toml", "-o", "e.h5", "--quiet", "--checkpoint-seconds", 0.05, number=signal.SIGTERM)
        self.assertEqual(journal[0], INTERRUPTED)
        self.assertRegex(journal[1], "^interrupted: what is done is kept beside e.h5; go on with: .* --resume\n$")


if __name__ == "__main__":
    program_from_arguments(__doc__)
    unittest.main()
