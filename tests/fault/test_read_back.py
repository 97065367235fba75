#!/usr/bin/python3
"""A bit that changes on its way to the disk: test_read_back.py SURVEYMC FAULT_LIBRARY

Whichever write it is in, the run ends with a message, the old result stays as it was under its name, and nothing else is left.
"""
import os
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cli"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
from durability import CANNOT_WRITE, Case  # noqa: E402
from surveymc import integrity  # noqa: E402


class ReadBack(Case):
    LIBRARY = ""

    def run_with(self, fault, counts):
        return subprocess.run([*self.PROGRAM, "run", "small.toml", "-o", "out.h5", "--overwrite"], cwd=self.folder,
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                              env={**os.environ, "LD_PRELOAD": self.LIBRARY, "SURVEYMC_FAULT": fault, "SURVEYMC_FAULT_COUNTS": counts})

    def test_every_write(self):
        self.call("run", "small.toml", "-o", "out.h5")
        old = (self.folder / "out.h5").read_bytes()
        counts = self.folder / "counts"
        self.assertEqual(self.run_with("write:0:flip", str(counts)).returncode, 0)
        writes = int(dict(line.split() for line in counts.read_text().splitlines())["write"])
        (self.folder / "out.h5").write_bytes(old)
        names = sorted(p.name for p in self.folder.iterdir())
        refused = 0
        for number in range(1, writes + 1):
            with self.subTest(write=number, of=writes):
                done = self.run_with(f"write:{number}:flip", str(counts))
                if done.returncode == 0:  # not of the result: a page that tries the disk, or of the journal
                    self.assertTrue(integrity.seal_of(self.folder / "out.h5"))
                    (self.folder / "out.h5").write_bytes(old)
                else:
                    refused += 1
                    self.assertEqual(done.returncode, CANNOT_WRITE, done.stderr)
                    self.assertIn("does not read back as what was written", done.stderr)
                    self.assertEqual((self.folder / "out.h5").read_bytes(), old)
                self.assertEqual(sorted(p.name for p in self.folder.iterdir() if ".journal." not in p.name), names)
        self.assertGreaterEqual(refused, 1)


if __name__ == "__main__":
    ReadBack.LIBRARY = os.path.abspath(sys.argv.pop())
    ReadBack.PROGRAM = [os.path.abspath(sys.argv.pop())]
    unittest.main()
