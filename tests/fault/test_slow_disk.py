#!/usr/bin/python3
"""A signal while a disk takes half a minute for one call: test_slow_disk.py SURVEYMC... FAULT_LIBRARY

Each program ends by the signal, long before the disk. No temporary file stays, an older file is as it was, and the work that
was done is kept: --resume writes the same result.
"""
import os
import signal
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cli"))
from durability import BAD_INPUT, INTERRUPTED, PATIENCE, Case, content_hash  # noqa: E402


class SlowDisk(Case):
    LIBRARY, PROGRAMS = "", []

    def stopped(self, *command, call="fsync:1", number=signal.SIGINT):
        """stderr of a command that gets a signal while the call takes its time."""
        child = subprocess.Popen([*self.PROGRAM, *command], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                 text=True, env={**os.environ, "LD_PRELOAD": self.LIBRARY, "SURVEYMC_FAULT": call + ":wait"})
        said = ""
        for line in child.stderr:
            if line == "waiting\n":
                break
            said += line
        child.send_signal(number)
        said += child.communicate(timeout=PATIENCE)[1]
        self.assertEqual(child.returncode, INTERRUPTED, said)
        self.assertEqual([p.name for p in self.folder.rglob("*.tmp")], [])
        return said

    def test_a_result_or_part_that_is_being_written(self):
        self.call("run", "small.toml", "-o", "whole.h5")
        whole = content_hash(self.folder / "whole.h5")
        for program in self.PROGRAMS:
            self.PROGRAM = [program]
            (self.folder / "r.h5").write_bytes((self.folder / "whole.h5").read_bytes())
            self.assertRegex(self.stopped("run", "small.toml", "--seed", "2", "-o", "r.h5"), "what is done is kept beside r.h5")
            self.assertEqual(content_hash(self.folder / "r.h5"), whole)
            for path in (*self.journals(), *self.folder.glob("r*.h5")):
                path.unlink()
            self.stopped("run", "small.toml", "-o", "r.h5", number=signal.SIGTERM)
            self.assertFalse((self.folder / "r.h5").exists())
            self.call("run", "small.toml", "-o", "r.h5", "--resume", says="going on from 15000 trials")
            self.assertEqual(content_hash(self.folder / "r.h5"), whole)
            (self.folder / "r.h5").unlink()
            self.stopped("run", "small.toml", "--point", "0:3", "-o", "all.part")
            self.assertFalse((self.folder / "all.part").exists())
            self.call("run", "small.toml", "--point", "0:3", "-o", "all.part", "--resume", says="going on from 15000 trials")
            self.assertRegex(self.stopped("merge", "-o", "m.h5", "all.part"), "nothing was written")
            self.assertRegex(self.stopped("merge", "--part", "-o", "m.part", "all.part"), "nothing was written")
            self.assertFalse([p for p in self.folder.iterdir() if p.name.startswith("m.")])
            (self.folder / "all.part").unlink()

    def test_a_config_that_is_being_read(self):
        for program in self.PROGRAMS:  # with MPI, libraries open files of their own before
            self.PROGRAM, counts = [program], self.folder / "counts"
            self.call("run", "none.toml", "-o", "r.h5", code=BAD_INPUT,
                      env={"LD_PRELOAD": self.LIBRARY, "SURVEYMC_FAULT_COUNTS": str(counts)})
            before = int(dict(line.split() for line in counts.read_text().splitlines())["open"])
            for command in (("run", "small.toml", "-o", "r.h5"), ("run", "small.toml", "--point", "1", "-o", "p.part")):
                self.assertRegex(self.stopped(*command, call=f"open:{before + 1}"), "nothing was written")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    SlowDisk.LIBRARY = str(Path(sys.argv.pop()).resolve())
    SlowDisk.PROGRAMS = [str(Path(p).resolve()) for p in sys.argv[1:] if p]
    Case.PROGRAM = SlowDisk.PROGRAMS[:1]
    unittest.main(argv=sys.argv[:1])
