#!/usr/bin/python3
"""The Python reader believes no damaged result: test_integrity.py RESULT.h5 (a small one)"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from surveymc import integrity, storage  # noqa: E402


class Integrity(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="surveymc-integrity-")
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "r.h5"
        self.whole = pathlib.Path(RESULT).read_bytes()

    def refused(self, data, says):
        self.file.write_bytes(data)
        with self.assertRaisesRegex(storage.ResultError, says):
            storage.open_file(str(self.file)).close()

    def test_whole(self):
        self.assertTrue(integrity.seal_of(RESULT))
        with storage.open_file(RESULT) as file:
            self.assertEqual(integrity.content_hash(file), file.attrs["content_hash"])

    def test_a_flipped_byte(self):
        end = len(self.whole) - integrity.SEAL_SIZE
        for at in [*range(0, end, 131), *range(end, len(self.whole))]:
            damaged = bytearray(self.whole)
            damaged[at] ^= 0x5A
            with self.subTest(at=at):
                self.refused(bytes(damaged), "damaged|not an HDF5 file")

    def test_a_cut(self):
        end = len(self.whole) - integrity.SEAL_SIZE
        for size in [*range(0, end, 997), *range(end - 3, end), *range(end + 1, len(self.whole))]:
            with self.subTest(size=size):
                self.refused(self.whole[:size], "damaged|not an HDF5 file")

    def test_without_a_seal(self):
        """Other programs may have rewritten the file: its contents count."""
        self.file.write_bytes(self.whole[:-integrity.SEAL_SIZE])
        with storage.open_file(str(self.file)) as file:
            self.assertEqual(integrity.content_hash(file), file.attrs["content_hash"])
        if shutil.which("h5repack"):
            other = self.file.with_name("repacked.h5")
            subprocess.run(["h5repack", str(self.file), str(other)], check=True)
            storage.open_file(str(other)).close()

    def test_an_edited_value(self):
        self.file.write_bytes(self.whole[:-integrity.SEAL_SIZE])
        edited = 0
        with h5py.File(self.file, "r+") as file:
            for table in file["tables"].values():
                for column in table.values():
                    if column.dtype == np.float64 and column.size and not edited:
                        column[0] = column[0] + 1 if np.isfinite(column[0]) else 1.0
                        edited += 1
        self.assertEqual(edited, 1)
        with self.assertRaisesRegex(storage.ResultError, "do not match its content_hash"):
            storage.open_file(str(self.file)).close()


if __name__ == "__main__":
    RESULT = os.path.abspath(sys.argv.pop(1))
    unittest.main()
