#!/usr/bin/python3
"""Warnings are rows of the result, and all mistakes of a config are told at once:
test_warnings.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]"""
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py

SURVEYMC = os.path.realpath(sys.argv[1])
BAD_DATA = 65

SURVEY = """# tie-on and three stations
md_m,inclination_deg,azimuth_deg
0,0,0

30,1,10
60,60,10
90,61,10
"""
CONFIG = """experiment = "position_covariance"
[survey]
file = "well.csv"
azimuth_reference = "grid"
[field]
total_nT = 50000
dip_deg = 70
gravity_mps2 = 9.8
declination_deg = 0
[error_model]
name = "iscwsa_mwd_rev4"
"""
GRID = ("warning", "well.csv", "", "azimuths are from grid north, and the convergence is 0",
        "if that is not meant, set field.convergence_deg or field.grid")
DOGLEG = ("warning", "well.csv:6", "inclination_deg = 60, azimuth_deg = 10",
          "the hole turns by 59 degrees in 30 m (59 deg/30 m): no tool drills more than 30 deg/30 m", "a typing error?")


class Case(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.addCleanup(self.scratch.cleanup)
        self.folder = Path(self.scratch.name)
        self.write("well.csv", SURVEY)
        self.write("mine.toml", CONFIG)

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def call(self, *arguments, exit_code=0):
        done = subprocess.run([SURVEYMC, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, exit_code, done.stdout + done.stderr)
        return done

    def warnings(self, name):
        with h5py.File(self.folder / name) as file:
            table = file["tables/warnings"]
            columns = [table[c].asstr()[()] for c in ("severity", "place", "value", "message", "way_out")]
            return [*zip(*columns)], [*zip(table["points"][()].tolist(), table["at"].asstr()[()])]

    def hash_of(self, name):
        with h5py.File(self.folder / name) as file:
            return file.attrs["content_hash"]


class InTheResult(Case):
    def test_warnings_of_the_input_are_rows(self):
        self.call("run", "mine.toml", "-o", "out.h5")
        rows, points = self.warnings("out.h5")
        self.assertEqual(rows, [GRID, DOGLEG])
        self.assertEqual(points, [(1, ""), (1, "")])

    def test_a_result_without_doubts_has_the_table_without_rows(self):
        self.write("well.csv", SURVEY.replace("60,60", "60,2").replace("90,61", "90,3"))
        self.call("run", "mine.toml", "--set", "field.convergence_deg=1.5", "-o", "out.h5")
        self.assertEqual(self.warnings("out.h5")[0], [])

    def test_each_is_printed_once(self):
        for options in ((), ("--quiet",)):
            done = self.call("run", "mine.toml", "-o", "out.h5", "--overwrite", *options)
            said = " ".join((done.stdout + done.stderr).split())
            for row in (GRID, DOGLEG):
                self.assertEqual(said.count(row[3]), 1, said)
                self.assertIn(row[4], said)
        checked = " ".join(re.sub(r"\n#? *", " ", self.call("check", "mine.toml").stdout).split())
        self.assertIn(f"warning: {DOGLEG[1]}: {DOGLEG[2]}: {DOGLEG[3]}; {DOGLEG[4]}", checked)

    def test_of_a_run_that_ends_in_an_error_they_are_printed(self):
        done = subprocess.run(["prlimit", "--fsize=4096", SURVEYMC, "run", "mine.toml"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 74, done.stdout + done.stderr)
        self.assertRegex(done.stderr, r"(?m) warning: well\.csv: azimuths are from grid north")

    def test_what_is_allowed_as_unusual_is_in_the_file(self):
        self.write("well.csv", SURVEY.replace("90,61,10", "90,61,400"))
        self.call("run", "mine.toml", "-o", "out.h5", exit_code=BAD_DATA)
        self.call("run", "mine.toml", "--set", "survey.unusual=allow", "-o", "out.h5")
        self.assertIn(("warning", "well.csv:7", "azimuth_deg = 400", "must be in [0, 360]: 40 if no digit is wrong", ""),
                      self.warnings("out.h5")[0])

    def test_a_key_is_its_place_whatever_the_config_is_called(self):
        config = CONFIG.replace("[error_model]", "[error_model]\n# a comment") + """[[offset]]
name = "other"
file = "well.csv"
azimuth_reference = "grid"
slot_m = [50, 0, 0]
"""
        config = config.replace("position_covariance", "clearance").replace("[survey]", "[survey]\nhole_diameter_m = 7.9")
        self.write("mine.toml", config.replace('slot_m = [50, 0, 0]', 'slot_m = [50, 0, 0]\nhole_diameter_m = 0.3'))
        self.call("run", "mine.toml", "-o", "out.h5")
        rows = [r for r in self.warnings("out.h5")[0] if r[1] == "survey.hole_diameter_m"]
        self.assertEqual(len(rows), 1)
        self.assertEqual(rows[0][2], "7.9")
        self.call("rerun", "out.h5")

    def test_own_and_other_north_have_one_rule(self):
        for north, angle, is_doubtful in (("grid", "", True), ("grid", "field.convergence_deg=2", False), ("magnetic", "", True),
                                          ("magnetic", "field.declination_deg=3", False), ("true", "", False)):
            changes = [f"--set=survey.azimuth_reference={north}", *([f"--set={angle}"] if angle else [])]
            self.call("run", "mine.toml", *changes, "-o", "out.h5", "--overwrite")
            found = [r for r in self.warnings("out.h5")[0] if r[3].startswith(f"azimuths are from {north} north")]
            self.assertEqual(len(found), is_doubtful, (north, angle))


class TheSameBits(Case):
    def setUp(self):
        super().setUp()
        self.write("sweep.toml", CONFIG.replace("dip_deg = 70\n", "") + '[sweep]\n"field.dip_deg" = [50, 60, 70, 80]\n'
                   '"survey.azimuth_reference" = ["true", "grid"]\n')
        self.write("sweep.toml", (self.folder / "sweep.toml").read_text().replace('azimuth_reference = "grid"\n', ""))
        self.call("run", "sweep.toml", "-o", "out.h5")

    def test_one_row_for_many_points(self):
        rows, points = self.warnings("out.h5")
        self.assertEqual(dict(zip(rows, points)),
                         {DOGLEG: (8, "field.dip_deg = 50, survey.azimuth_reference = true"),
                          GRID: (4, "field.dip_deg = 50, survey.azimuth_reference = grid")})

    def test_for_any_number_of_threads_and_parts(self):
        for threads in (1, 2, 5):
            self.call("run", "sweep.toml", "--threads", threads, "-o", f"{threads}.h5")
            self.assertEqual(self.hash_of(f"{threads}.h5"), self.hash_of("out.h5"))
        for point in range(8):
            self.call("run", "sweep.toml", "--point", point, "-o", "parts/")
        self.call("merge", "parts", "-o", "merged.h5")
        self.assertEqual(self.hash_of("merged.h5"), self.hash_of("out.h5"))

    def test_when_a_result_is_run_again(self):
        self.call("rerun", "out.h5")

    def test_of_a_survey_in_another_form(self):
        self.write("well.txt", "Measured Depth (m);Incl. (deg);Azimuth Grid (deg)\n0;0;\n30;1;45\n60;2;46\n90;3;47\n")
        self.write("mine.toml", CONFIG.replace("well.csv", "well.txt").replace('azimuth_reference = "grid"\n', ""))
        self.call("run", "mine.toml", "-o", "out.h5")
        rows = self.warnings("out.h5")[0]
        self.assertTrue(any(r[1] == "well.txt:line 2" and "is empty at inclination 0" in r[3] for r in rows), rows)
        self.call("rerun", "out.h5")
        self.call("run", "mine.toml", "--point", 0, "-o", "parts/")
        self.call("merge", "parts", "-o", "merged.h5")
        self.assertEqual(self.hash_of("merged.h5"), self.hash_of("out.h5"))


class SparseSurveys(Case):
    """A well by key points about 500 m apart: 107 m, where the same path every 30 m has 7 m."""
    MODEL = 'name = "MWD+IFR1+MS"'
    KEY_POINTS = ((0, 0, 45), (510, 0, 45), (1020, 30, 45), (1530, 60, 90), (2040, 60, 135))

    def setUp(self):
        super().setUp()
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{m},{i},{a}\n" for m, i, a in self.KEY_POINTS))
        self.write("mine.toml", CONFIG.replace('name = "iscwsa_mwd_rev4"', self.MODEL).replace('"grid"', '"true"'))

    def last(self, name):
        """The covariance of the last station, and how many stations there are."""
        with h5py.File(self.folder / name) as file:
            table = file["tables/covariance"]
            return [table[c][-1] for c in ("nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2")], len(table["md_m"])

    def dense_survey(self, step):
        """The path of the key points every `step` metres, as an engineer would write it down: by the arcs of its tangents."""
        def tangent(inclination, azimuth):
            i, a = math.radians(inclination), math.radians(azimuth)
            return [math.sin(i) * math.cos(a), math.sin(i) * math.sin(a), math.cos(i)]

        rows = [self.KEY_POINTS[0]]
        for (m1, *from_), (m2, *to) in zip(self.KEY_POINTS, self.KEY_POINTS[1:]):
            t1, t2 = tangent(*from_), tangent(*to)
            b = math.acos(min(1, sum(x * y for x, y in zip(t1, t2))))
            for md in range(m1 + step, m2 + 1, step):
                f = (md - m1) / (m2 - m1)
                t = [math.sin((1 - f) * b) / math.sin(b) * x + math.sin(f * b) / math.sin(b) * y for x, y in zip(t1, t2)] if b > 1e-6 else t2
                azimuth = math.degrees(math.atan2(t[1], t[0])) % 360 if math.hypot(t[0], t[1]) > 1e-9 else to[1]
                rows.append((md, math.degrees(math.acos(t[2])), azimuth))
        return "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{m},{i!r},{a!r}\n" for m, i, a in rows)

    def test_interpolated_stations_give_the_covariance_of_the_dense_survey(self):
        self.call("run", "mine.toml", "-o", "sparse.h5")
        self.call("run", "mine.toml", "--set", "survey.interpolate_m=30", "-o", "between.h5")
        self.write("dense.csv", self.dense_survey(30))
        self.call("run", "mine.toml", "--set", "survey.file=dense.csv", "-o", "dense.h5")
        (sparse, few), (between, many), (dense, as_many) = (self.last(f"{name}.h5") for name in ("sparse", "between", "dense"))
        self.assertEqual((few, many, as_many), (5, 69, 69))
        for got, wanted in zip(between, dense):  # directions differ by rounding, 1e-15 rad, and acos of it, 1e-8 rad
            self.assertAlmostEqual(got, wanted, delta=1e-6 * sum(dense[:3]))
        sparse_sd, dense_sd = (math.sqrt(sum(c[:3])) for c in (sparse, dense))
        self.assertGreater(sparse_sd, 100)
        self.assertLess(dense_sd, 8)
        (row,) = [r for r in self.warnings("sparse.h5")[0] if "m apart" in r[3]]
        found = re.search(r"up to 510 m apart: .* deviation of ([\d.]+) m \(root of the trace\), and of ([\d.]+) m with stations "
                          r"every 30 m on the same path: ([\d.]+) % of its variance is made by the spacing, most of it by (\w+)", row[3])
        self.assertIsNotNone(found, row)
        for said, value in zip(found.groups(), (sparse_sd, dense_sd, 100 * (1 - dense_sd**2 / sparse_sd**2))):
            self.assertAlmostEqual(float(said), value, delta=0.005 * value)
        self.assertIn(found[4], ("XCLA", "XCLH"))
        self.assertIn("survey.interpolate_m = 30", row[4])
        for name in ("between.h5", "dense.h5"):
            self.assertEqual([r for r in self.warnings(name)[0] if "m apart" in r[3]], [])
        for name in ("sparse.h5", "between.h5"):
            self.call("rerun", name)

    def test_listed_vertical_depths_and_legs_are_of_the_given_stations(self):
        """A leg begins at the first station below its depth, wherever that is; the file's vertical depths stay."""
        self.call("run", "mine.toml", "-o", "out.h5")
        with h5py.File(self.folder / "out.h5") as file:
            tvd = file["tables/ellipsoid/tvd_m"][()]
        rows = [f"{m},{i},{a},{d!r}\n" for (m, i, a), d in zip(self.KEY_POINTS, tvd.tolist())]
        self.write("listed.csv", "md_m,inclination_deg,azimuth_deg,tvd_m\n" + "".join(rows))
        self.write("mine.toml", (self.folder / "mine.toml").read_text() + "[[leg]]\nfrom_md_m = 1200\n")
        for name in ("well", "listed"):
            self.call("run", "mine.toml", "--set", "survey.interpolate_m=30", "--set", f"survey.file={name}.csv", "-o", f"{name}.h5")
        for got, wanted in zip(self.last("listed.h5")[0], self.last("well.h5")[0]):
            self.assertAlmostEqual(got, wanted, delta=1e-9)
        with h5py.File(self.folder / "listed.h5") as file:
            self.assertEqual(file["tables/tool_codes/from_md_m"][1], 1200)

    def test_what_is_refused(self):
        for value, says in (("0", "must be in [1, 1000]"), ("5000", "must be in [1, 1000]")):
            said = self.call("check", "mine.toml", "--set", f"survey.interpolate_m={value}", exit_code=BAD_DATA).stderr
            self.assertIn(says, said)


class AllMistakes(Case):
    def mistakes(self, text, *options):
        self.write("bad.toml", text)
        said = self.call("check", "bad.toml", *options, exit_code=BAD_DATA).stderr
        self.assertEqual(said, self.call("run", "bad.toml", *options, exit_code=BAD_DATA).stderr)
        lines = said.removeprefix("error: ").splitlines()
        if len(lines) > 1:
            self.assertEqual(lines.pop(0), f"bad.toml: {len(lines)} mistakes:")
        return lines

    def test_unknown_keys_first_then_what_is_refused(self):
        text = CONFIG.replace("total_nT", "total_T").replace("dip_deg = 70", "dip_deg = 170").replace("well.csv", "none.csv")
        text = text.replace("gravity_mps2 = 9.8", 'gravity_mps2 = "g"') + "outside_rang = 'mark'\n[surve]\nx = 1\n"
        self.assertEqual(self.mistakes(text), [
            "bad.toml:6: field.total_T: unknown unit: write field.total_nT",
            "bad.toml:12: error_model.outside_rang: unknown key: did you mean error_model.outside_range?",
            "bad.toml:13: surve: unknown key: did you mean survey?",
            "bad.toml:7: field.dip_deg = 170: must be in [-90, 90]",
            'bad.toml:8: field.gravity_mps2 = "g": must be a number',
            'bad.toml:3: survey.file = "none.csv": cannot be read: No such file or directory (looked for none.csv)'])

    def test_a_single_mistake_is_told_as_before(self):
        self.assertEqual(self.mistakes(CONFIG.replace("= 70", "= 170")), ["bad.toml:7: field.dip_deg = 170: must be in [-90, 90]"])
        (line,) = self.mistakes(CONFIG.replace("dip_deg", "dip_de"))
        self.assertIn("field.dip_deg: missing (found field.dip_de", line)

    def test_what_a_stand_in_may_be_to_blame_for_is_left_out(self):
        # Which error model there is decides what else is needed of [error_model] and the field.
        self.assertEqual(len(self.mistakes(CONFIG.replace('"iscwsa_mwd_rev4"', '"iscwsa_mwd_rev44"'))), 1)
        # A survey that cannot be read has no rows to refuse, and no toolface to miss.
        self.assertEqual(len(self.mistakes(CONFIG.replace("well.csv", "none.csv"))), 1)

    def test_mistakes_of_several_points(self):
        text = CONFIG.replace("dip_deg = 70\n", "") + '[[sweep.case]]\nname = "a"\n"field.dip_deg" = 170\n' + (
            '[[sweep.case]]\nname = "b"\n"field.dip_deg" = 60\n"field.total_nT" = -3\n')
        lines = self.mistakes(text.replace("total_nT = 50000\n", ""))
        self.assertTrue(any("field.dip_deg = 170" in line for line in lines), lines)
        self.assertTrue(any("field.total_nT = -3" in line for line in lines), lines)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
