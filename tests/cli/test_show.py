#!/usr/bin/python3
"""`surveymc show`, on results with comparisons, a sweep, samples and maps: test_show.py SURVEYMC_EXECUTABLE SOURCE_FOLDER

JSON and CSV are held against what h5py reads from the file, bit for bit.
"""
import csv
import fcntl
import io
import json
import os
import pty
import re
import struct
import subprocess
import sys
import tempfile
import termios
import unittest
from pathlib import Path

import h5py
import numpy as np

EXECUTABLE, SOURCE = None, None


def call(*arguments, code=0):
    done = subprocess.run([EXECUTABLE, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert done.returncode == code, f"{arguments}: exit {done.returncode}: {done.stderr}"
    return done.stdout if code == 0 else done.stderr


def on_a_terminal(columns, *arguments):
    """What the command prints on a terminal that is so wide."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    child = subprocess.Popen([EXECUTABLE, *map(str, arguments)], stdout=slave, stderr=subprocess.DEVNULL, cwd=Show.temporary.name)
    os.close(slave)
    out = b""
    while True:
        try:
            piece = os.read(master, 65536)
        except OSError:  # the other end is closed
            break
        if not piece:
            break
        out += piece
    os.close(master)
    assert child.wait() == 0
    return out.decode().replace("\r\n", "\n")


def as_stored(values):
    """JSON values as they are stored: null is NaN, infinities are words."""
    return [float("nan") if v is None else float(v) for v in values]


class Show(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="surveymc-show-")
        folder = Path(cls.temporary.name)
        cls.comparison, cls.maps, cls.unexpected = folder / "comparison.h5", folder / "maps.h5", folder / "unexpected.h5"
        call("run", SOURCE / "configs/smoke/msa_position.toml", "-o", cls.comparison)
        call("run", SOURCE / "configs/smoke/reliability_map.toml", "-o", cls.maps)
        # The systematic propagation is wrong on purpose; expecting that it agrees is wrong too.
        text = (SOURCE / "configs/smoke/msa_position.toml").read_text()
        text = re.sub(r'file = "([^"]+)"', lambda m: f'file = "{(SOURCE / "configs/smoke" / m[1]).resolve()}"', text)
        (folder / "unexpected.toml").write_text(text + """
[[expect]]
table = "position"
formulation = "systematic"
quantities = ["sigma3_north"]
verdict = "agrees"
""")
        call("run", folder / "unexpected.toml", "-o", cls.unexpected)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_list_names_everything_with_size_and_title(self):
        for path in [self.comparison, self.maps]:
            text = call("show", path)
            with h5py.File(path) as f:
                for kind, group in [("table", "tables"), ("samples", "samples")]:
                    for name, table in f.get(group, {}).items():
                        columns = len([c for c in table if c != "row"])
                        self.assertRegex(text, rf"(?m)^{kind} +{name} +{len(table['row'])} x {columns} ")
                for name, item in f.get("maps", {}).items():
                    if "long_name" in item.attrs and item.ndim > 1:
                        shape = " x ".join(map(str, item.shape))
                        self.assertRegex(text, rf"(?m)^map +{name} +{shape} .*{re.escape(item.attrs['long_name'])}")

    def test_list_counts_verdicts(self):
        with h5py.File(self.comparison) as f:
            judged = [t for t in f["tables"].values() if "verdict" in t]
            words = [v for t in judged for v in t["verdict"].asstr()[()]]
            findings = sum(((t["verdict"].asstr()[()] == "differs") & np.isin(t["expected"].asstr()[()], ["differs", "either"])).sum()
                           for t in judged if "expected" in t)
        self.assertGreater(findings, 0)  # approximations
        self.assertRegex(call("show", self.comparison),
                         rf"(?m)^verdicts: {words.count('agrees')} agree( \(.*\))?, {findings} findings, "
                         rf"{words.count('differs') - findings} differ( \(.*\))?, {words.count('undecided')} undecided$")
        self.assertRegex(call("show", self.unexpected), r"(?m)^verdicts: .*; 1 not as expected$")
        self.assertRegex(call("show", self.unexpected), r"(?m)^table +position .*\(1 !\)")

    def test_unexpected_verdict_is_marked_in_its_row_alone(self):
        text = call("show", self.unexpected, "position")
        marked = [line for line in text.splitlines() if "differs (!)" in line]
        self.assertEqual(len(marked), 1, text)
        self.assertRegex(marked[0], r"^systematic +sigma3_north ")
        self.assertIn("\n(!) 1 not as expected\n", text)
        self.assertNotIn("(!)", call("show", self.comparison, "position"))

    def test_columns_are_aligned_and_have_units(self):
        text = call("show", self.comparison, "realisations", "--rows", 6)
        self.assertNotIn("--rows", text)
        lines = text.splitlines()
        rule = next(i for i, line in enumerate(lines) if set(line) == {"-"})
        ends = lambda line: {m.end() for m in re.finditer(r"\S+", line)}  # noqa: E731 - numbers end in one column
        self.assertIn("[nT]", lines[rule - 1])
        for line in lines[rule + 1:]:
            if not line.startswith("..."):
                self.assertEqual(ends(line), ends(lines[rule + 1]), line)
        self.assertIn("... 494 of 500 rows left out ...", text)
        self.assertEqual(len(lines) - rule - 1, 7)
        self.assertNotIn("left out", call("show", self.comparison, "realisations", "--rows", 0))

    def test_forty_rows_of_a_long_table_are_printed_where_nobody_says_how_many(self):
        text = call("show", self.comparison, "realisations")
        self.assertIn("... 460 of 500 rows left out ...\n", text)
        self.assertTrue(text.endswith("\n(--rows 0 prints all rows, --csv exports them)\n"), text)
        self.assertEqual(len(text.split("-\n")[1].splitlines()), 40 + 2)
        self.assertEqual(len(call("show", self.comparison, "realisations", "--csv").splitlines()), 501)

    def test_terminal_gets_its_width_and_the_ends_of_long_tables(self):
        for columns in [80, 120]:
            text = on_a_terminal(columns, "show", self.comparison, "realisations")
            self.assertLessEqual(max(map(len, text.splitlines()[1:])), columns)
            self.assertIn("rows left out", text)
            listed = on_a_terminal(columns, "show", self.comparison)
            self.assertIn("realisations", listed)
        whole = on_a_terminal(120, "show", self.comparison, "realisations", "--rows", 0)
        self.assertNotIn("left out", whole)

    def test_nothing_is_wider_than_a_narrow_screen(self):
        for columns in [60, 80]:
            for text in [on_a_terminal(columns, "show", self.comparison), on_a_terminal(columns, "show", self.maps, "--list"),
                         on_a_terminal(columns, "run", SOURCE / "configs/smoke/tool_codes.toml", "-o", "codes.h5"),
                         on_a_terminal(columns, "run", SOURCE / "configs/smoke/msa_sweep.toml", "-o", "sweep.h5"),
                         on_a_terminal(columns, "list")]:
                for line in text.splitlines():
                    self.assertLessEqual(len(line), columns, line)
        names = on_a_terminal(60, "show", self.comparison, "control_variate")  # the longest name of a row there is
        parts = names.split("\n\n")
        self.assertGreater(len(parts), 2)
        for part in parts:
            self.assertEqual(part.count("covariance_north_vertical"), 1, part)

    def test_feet(self):
        with h5py.File(self.comparison) as f:
            metres = f["tables/position_covariance/nn_m2"][()]
        lines = call("show", self.comparison, "position_covariance", "--units", "ft").splitlines()
        head = lines.index(next(line for line in lines if "nn_ft2" in line))
        self.assertIn("[ft2]", lines[head + 1])
        shown = [float(line.split()[1]) for line in lines[head + 3:]]
        np.testing.assert_allclose(shown, metres / 0.3048**2, rtol=5.1e-6)  # six digits are printed
        call("show", self.comparison, "--units", "ft", "--csv", code=64)
        call("show", self.comparison, "--units", "feet", code=64)

    def test_split_tables_name_their_rows_in_every_part(self):
        text = on_a_terminal(80, "show", self.comparison, "position")
        parts = text.split("\n\n")
        self.assertGreater(len(parts), 1, text)
        for part in parts:
            self.assertEqual(part.count("sigma3_north"), 3, part)

    def test_json_of_a_table_is_the_file_to_the_last_bit(self):
        for path, group in [(self.comparison, "tables"), (self.comparison, "samples"), (self.maps, "tables")]:
            with h5py.File(path) as f:
                for name, table in f[group].items():
                    parsed = json.loads(call("show", path, name, "--json"))
                    self.assertEqual(parsed["rows"], len(table["row"]))
                    self.assertEqual({c["name"] for c in parsed["columns"]}, set(table) - {"row"})
                    for c in parsed["columns"]:
                        stored = table[c["name"]]
                        if h5py.check_string_dtype(stored.dtype):
                            self.assertEqual(c["values"], list(stored.asstr()[()]))
                            self.assertEqual(c["unit"], "")
                        else:
                            self.assertEqual(c["unit"], stored.attrs["units"])
                            np.testing.assert_array_equal(np.array(as_stored(c["values"])), stored[()].astype(float))

    def test_json_and_csv_of_a_map_are_the_file_to_the_last_bit(self):
        for name in ["redundancy_number", "minimal_detectable_error", "worst_toolface_external_azimuth_deg"]:
            with h5py.File(self.maps) as f:
                stored = f["maps"][name][()]
            parsed = json.loads(call("show", self.maps, name, "--json"))
            self.assertEqual(parsed["shape"], list(stored.shape))
            self.assertEqual([len(a["values"]) for a in parsed["axes"]], list(stored.shape))
            np.testing.assert_array_equal(np.array(as_stored(parsed["values"])).reshape(stored.shape), stored)
            rows = list(csv.reader(io.StringIO(call("show", self.maps, name, "--csv"))))
            self.assertEqual(rows[0], [a["name"] for a in parsed["axes"]] + [name])
            np.testing.assert_array_equal([float(r[-1] or "nan") for r in rows[1:]], stored.ravel())
            last = [str(a["values"][-1]) for a in parsed["axes"]]
            self.assertEqual([c.removesuffix(".0") for c in rows[-1][:-1]], [c.removesuffix(".0") for c in last])
        self.assertIn("Infinity", json.loads(call("show", self.maps, "minimal_detectable_error", "--json"))["values"])

    def test_map_summary(self):
        text = call("show", self.maps, "minimal_detectable_error")
        with h5py.File(self.maps) as f:
            stored = f["maps/minimal_detectable_error"][()]
        finite = stored[np.isfinite(stored)]
        self.assertIn(f"{stored.size} values: {finite.size} finite, {np.isinf(stored).sum()} infinite, 0 missing", text)
        self.assertIn(f"smallest {finite.min():g} at ", text)
        self.assertIn(f"largest  {finite.max():g} at ", text)
        self.assertIn("  inclination [deg]: 3 values: 0, 30, 90\n", text)

    def test_json_of_a_file(self):
        for path in [self.comparison, self.maps]:
            short, whole = json.loads(call("show", path, "--list", "--json")), json.loads(call("show", path, "--json"))
            with h5py.File(path) as f:
                for key in ["title", "experiment", "content_hash", "git_revision", "compiler", "command"]:
                    self.assertEqual(short[key], f.attrs[key])
                self.assertEqual((short["seed"], short["trials"]), (f.attrs["seed"], f.attrs["trials"]))
                self.assertEqual({t["name"] for t in short["tables"]}, set(f["tables"]))
            for table in whole["tables"] + whole["samples"]:
                for column in table["columns"]:
                    self.assertEqual(len(column.pop("values")), table["rows"])
            self.assertEqual(short, whole)  # the short one lacks the values, and nothing else

    def test_csv_list(self):
        rows = list(csv.DictReader(io.StringIO(call("show", self.maps, "--csv"))))
        self.assertEqual({r["kind"] for r in rows}, {"table", "map"})
        for r in rows:
            call("show", self.maps, r["name"], "--csv")

    def test_options_that_exclude_each_other(self):
        for options in [["--csv", "--json"], ["position", "--list"], ["--list", "--csv"], ["--rows", "-1"]]:
            call("show", self.comparison, *options, code=64)
        self.assertIn("redundancy_number", call("show", self.maps, "nix", code=65))


if __name__ == "__main__":
    EXECUTABLE, SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
