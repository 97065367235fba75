#!/usr/bin/python3
"""End-to-end tests of tool codes: test_tool_codes.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import sys
import tomllib
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
import tool_code_reference
from test_cli import BAD_INPUT, USAGE, Case, column

SURVEY = "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{30 * k},{min(3.0 * max(0, k - 3), 87)},{60 + k}\n" for k in range(36))
CONFIG = """\
experiment = "position_covariance"
error_model = "GYRO-NS-CT"
[survey]
file = "well.csv"
[field]
total_nT = 50000.0
dip_deg = 72.0
latitude_deg = 60.0
"""
MAP = """\
experiment = "tool_code_map"
codes = ["MWD+SRGM", "GYRO-NS"]
[field]
total_nT = 50000.0
dip_deg = 72.0
declination_deg = -4.0
latitude_deg = 60.0
[map]
inclination_deg = [30.0, 60.0, 90.0]
azimuth_deg = [0.0, 90.0]
"""
OWN = """\
[[function]]
name = "OWN"
azimuth = "Sin(Inc) * Cos(AzM)"
[[model]]
name = "a"
first_leg = "once"
terms = [ { code = "X", function = "OWN", magnitude = 1.0, unit = "deg", mode = "S" } ]
[[model]]
name = "b"
extends = "a"
terms = [ { code = "X", function = "OWN", magnitude = 2.0, unit = "deg", mode = "S" } ]
"""


class CodesCase(Case):
    def setUp(self):
        super().setUp()
        self.write("well.csv", SURVEY)
        self.write("base.toml", CONFIG)


class Models(CodesCase):
    def test_models_lists_all_and_prints_one_that_reads_back(self):
        listed = self.call("models").stdout
        self.assertEqual(sum(" terms  " in line for line in listed.splitlines()), 103)
        self.assertRegex(listed, r"(?m)^  MWD\+IFR1 +\d+ terms  0-180 deg ")
        self.assertRegex(listed, r"(?m)^  GYRO-NS-CT .* 0-150 deg ")
        for name in ("MWD+IFR1", "owsg_a_rev5.1/GYRO-NS-CT"):
            with self.subTest(name=name):
                text = self.call("models", name).stdout
                model = tomllib.loads(text)["model"][0]
                self.assertEqual(model["name"], name.split("/")[-1])
                self.write("mine.toml", text)
                own = self.run_config("--set", "error_model={ file = \"mine.toml\" }", output="own.h5")
                shipped = self.run_config("--set", f"error_model={name}", output="shipped.h5")
                for e in ("nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2"):
                    np.testing.assert_allclose(column(own, "tables/covariance", e),
                                               column(shipped, "tables/covariance", e), rtol=1e-13, atol=1e-15)
        self.refused(USAGE, "models", "MWD+IFR9", says='unknown error model: did you mean "MWD\\+IFR1"')

    def test_models_of_a_file(self):
        self.write("own.toml", OWN)
        self.assertRegex(self.call("models", "--file", "own.toml").stdout, r"(?m)^  a +1 terms")
        self.assertIn("magnitude = 2", self.call("models", "b", "--file", "own.toml").stdout)
        self.refused(BAD_INPUT, "models", "c", "--file", "own.toml", says="has no model of this name")
        self.write("own.toml", OWN.replace("AzM", "AzX"))
        self.refused(BAD_INPUT, "models", "--file", "own.toml", says=r'own.toml:3: function OWN: azimuth = .*: column 16: '
                                                                     r'unknown variable "AzX"; did you mean "AzM" or "AzT"\?')

    def test_a_file_of_several_models_needs_a_name(self):
        self.write("own.toml", OWN)
        self.write("mine.toml", CONFIG.replace('error_model = "GYRO-NS-CT"\n', "") + '[error_model]\nfile = "own.toml"\n')
        self.refused(BAD_INPUT, "run", "mine.toml", "-o", "x.h5", says="has 2 models: choose one with error_model.name")
        a, b = (column(self.run_config("--set", f"error_model.name={n}", config="mine.toml", output=f"{n}.h5"),
                       "tables/covariance", "ee_m2") for n in "ab")
        np.testing.assert_allclose(b, 4 * a, rtol=1e-14)

    def test_check_prints_the_terms(self):
        out = self.call("check", "base.toml").stdout
        self.assertIn('# name = "GYRO-NS-CT"', out)
        self.assertIn('function = "GXY-GD"', out)
        tomllib.loads(out)


class Covariances(CodesCase):
    def test_latitude_is_asked_for_where_a_formula_has_it(self):
        self.write("base.toml", CONFIG.replace("latitude_deg = 60.0\n", ""))
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "x.h5", says="field.latitude_deg.*missing: .* of GYRO-NS-CT needs")
        self.run_config("--set", "error_model=MWD+SRGM")

    def test_the_tables_of_a_gyro(self):
        path = self.run_config()
        header, rows = self.table_csv(path, "gyro")
        self.assertEqual([r[header.index("mode")] for r in rows], ["stationary", "continuous"])
        self.assertAlmostEqual(float(rows[1][header.index("initialised_at_deg")]), 15)
        header, rows = self.table_csv(path, "tool_codes")
        self.assertEqual(rows[0][header.index("catalogue")], "owsg_a_rev5.1")
        header, rows = self.table_csv(path, "error_terms")
        for name in ("kind", "depth", "inclination", "azimuth_or_lateral", "file"):
            self.assertIn(name, header)

    def test_outside_its_range_a_model_is_marked_or_refused(self):
        path = self.run_config("--set", "error_model=INC-ONLY")
        header, rows = self.table_csv(path, "validity")
        self.assertEqual(rows[0][header.index("rule")], "inclination range")
        said = self.call("run", "base.toml", "--set", "error_model=INC-ONLY", "-o", "again.h5").stdout
        self.assertRegex(said, r"(?m)^warning: INC-ONLY: inclination range: 22 stations")
        self.refused(BAD_INPUT, "run", "base.toml", "--set", "error_model={name=\"INC-ONLY\",outside_range=\"refuse\"}",
                     "-o", "x.h5", says=r"outside_range.*INC-ONLY: station at md .* 0 to 30 deg")
        header, rows = self.table_csv(self.run_config("--set", "error_model=MWD+IFR1+MS", output="ms.h5"), "validity")
        self.assertEqual(rows[-1][header.index("rule")], "note")

    def test_a_term_without_effect_is_named(self):
        self.write("own.toml", OWN.replace("magnitude = 1.0", "magnitude = 0.0"))
        self.write("mine.toml", CONFIG.replace('error_model = "GYRO-NS-CT"\n', "") +
                   '[error_model]\nfile = "own.toml"\nname = "a"\n')
        self.assertRegex(self.call("run", "mine.toml", "-o", "z.h5").stdout,
                         r"(?m)^warning: own.toml: a: zero term: .*X: OWN has no effect")

    def test_check_names_what_does_nothing_in_an_own_model(self):
        self.write("own.toml", OWN.replace("magnitude = 1.0", "magnitude = 0.0") +
                   '[[function]]\nname = "SPARE"\nazimuth = "Sin(AzM)"\n')
        self.write("mine.toml", CONFIG.replace('error_model = "GYRO-NS-CT"\n', "") +
                   '[error_model]\nfile = "own.toml"\nname = "a"\n')
        wells = (SURVEY.replace("60", "61"), '[survey]\nfile = "well.csv"\nhole_diameter_in = 12.25\n',
                 '[[offset]]\nname = "o"\nfile = "offset.csv"\nslot_m = [50.0, 0.0, 0.0]\n')
        self.write("offset.csv", wells[0])
        config = (self.folder / "mine.toml").read_text()
        self.write("wells.toml", config.replace("position_covariance", "clearance").replace('[survey]\nfile = "well.csv"\n', wells[1]) + wells[2])
        self.write("drawn.toml", "trials = 100\nseed = 1\n" + config.replace("position_covariance", "error_model_monte_carlo"))
        for name in ("mine.toml", "wells.toml", "drawn.toml"):
            with self.subTest(config=name):
                out = self.call("check", name).stdout
                self.assertIn("# warning: own.toml: a: term X: magnitude = 0, function = OWN: has no effect at any inclination and azimuth; take it out", out)
                self.assertRegex(out, r'# warning: own.toml:\d+: function\[1\].name = "SPARE": no term of this file has this function')
        self.write("own.toml", OWN)
        self.assertNotIn("# warning", self.call("check", "mine.toml").stdout)
        # Shipped models are as published.
        self.assertNotIn("has no effect", self.call("check", "base.toml", "--set", "field.dip_deg=0").stdout)

    def test_a_leg_has_the_name_that_the_config_gives_its_model(self):
        def models(*options):
            header, rows = self.table_csv(self.run_config(*options, config="mine.toml", output="named.h5"), "tool_codes")
            return [r[header.index("model")] for r in rows], [r[header.index("catalogue")] for r in rows]

        self.write("own.toml", OWN[:OWN.index('[[model]]\nname = "b"')])
        self.write("mine.toml", CONFIG.replace('error_model = "GYRO-NS-CT"\n', "") + '[error_model]\nfile = "own.toml"\n')
        self.assertEqual(models(), (["own.toml"], ["own.toml"]))
        self.assertEqual(models("--set", "error_model.name=a"), (["own.toml: a"], ["own.toml"]))
        self.refused(BAD_INPUT, "check", "mine.toml", "--set", "error_model.name=c", says='error_model.name = "c": must be "a"\n')

    def test_by_source(self):
        every = self.run_config(output="all.h5")
        last = self.run_config("--set", "output.by_source=last", output="last.h5")
        none = self.run_config("--set", "output.by_source=none", output="none.h5")
        a, b = (column(p, "tables/covariance_by_source", "ee_m2") for p in (every, last))
        np.testing.assert_array_equal(a[-len(b):], b)
        with h5py.File(none) as f:
            self.assertNotIn("covariance_by_source", f["tables"])
        for path in (last, none):
            np.testing.assert_array_equal(column(path, "tables/covariance", "nn_m2"), column(every, "tables/covariance", "nn_m2"))

    def test_a_sweep_by_patterns(self):
        self.write("sweep.toml", CONFIG.replace('error_model = "GYRO-NS-CT"\n', "") +
                   '[sweep]\n"error_model.name" = { match = ["MWD+IFR1*", "ZERO*"], without = ["*_Fl", "*AX*"] }\n')
        out = self.call("check", "sweep.toml").stdout
        self.assertRegex(out, r'"error_model.name" = \["MWD\+IFR1", "MWD\+IFR1\+MS", "MWD\+IFR1\+SAG"')
        path = self.run_config(config="sweep.toml", output="s.h5")
        names = list(dict.fromkeys(column(path, "tables/covariance", "error_model.name")))
        self.assertIn("ZERO-ERROR", names)
        self.assertNotIn("MWD+IFR1_Fl", names)
        self.assertRegex(self.call("rerun", path).stdout, "^identical")
        for bad, says in (('["Q*"]', "fits no shipped error model"), ('[1]', "must be a string")):
            self.write("bad.toml", CONFIG.replace('error_model = "GYRO-NS-CT"\n', "") +
                       f'[sweep]\n"error_model.name" = {{ match = {bad} }}\n')
            self.refused(BAD_INPUT, "check", "bad.toml", says=says)
        self.write("bad.toml", CONFIG + '[sweep]\n"survey.file" = { match = ["*"] }\n')
        self.refused(BAD_INPUT, "check", "bad.toml", says="only error_model.name can be swept by match")


class Maps(CodesCase):
    def test_maps_are_the_covariances_of_straight_holes(self):
        self.write("map.toml", MAP)
        path = self.run_config(config="map.toml", output="map.h5")
        with h5py.File(path) as f:
            lateral, inside = f["maps/sd_lateral_m"][()], f["maps/inside_range"][()]
        self.assertEqual(lateral.shape, (2, 3, 2))
        self.assertAlmostEqual(lateral[0, 0, 0], 4.5070, places=4)   # an independent program's
        self.assertAlmostEqual(lateral[0, 1, 1], 12.5091, places=4)
        self.assertAlmostEqual(lateral[1, 1, 1], 108.9421, places=4)
        np.testing.assert_array_equal(inside[0], 1)
        np.testing.assert_array_equal(inside[1], [[1, 1], [1, 1], [0, 0]])
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{30 * k},60,90\n" for k in range(31)))
        one = self.run_config("--set", "error_model=MWD+SRGM", "--set", "field.declination_deg=-4", output="one.h5")
        self.assertEqual(column(one, "tables/covariance", "sd_lateral_m")[-1], lateral[0, 1, 1])
        self.assertRegex(self.call("rerun", path).stdout, "^identical")

    def test_bad_maps_are_refused(self):
        for old, new, says in (('"GYRO-NS"', '"GYRO-XX"', 'unknown error model "GYRO-XX"'),
                               ('"GYRO-NS"', '"MWD+SRGM"', "is in the list twice"),
                               ("latitude_deg = 60.0\n", "", "needs the latitude"),
                               ("[map]\n", "[map]\nspacing_m = 7.0\n", "must divide length_m")):
            with self.subTest(new=new):
                self.write("map.toml", MAP.replace(old, new))
                self.refused(BAD_INPUT, "run", "map.toml", "-o", "x.h5", says=says)


class AgainstReference(Case):
    """Covariances at all stations of wells that published figures do not reach: they turn through north, fall back below
    the gate of a gyro, go beyond 90 deg, return to the vertical, have short intervals and tools that follow each other."""

    def survey(self, start):
        md, inclination, azimuth = [start], [0.0 if start == 0 else 24.0], [123.0]
        shape = ([0, 0, 1, 4, 9, 13, 16, 21, 18, 14.9, 11, 8, 12, 15, 19, 30, 51, 75, 88, 91, 104, 110, 101, 70, 40, 15, 14, 5,
                  0]
                 if start == 0 else [28, 33, 36, 31, 22, 16, 12, 9, 14, 17, 25, 38, 52, 61, 58, 47, 30, 20])
        for k, i in enumerate(shape):
            md.append(round(md[-1] + (3.0, 30.0, 9.9, 28.0, 45.0)[k % 5], 1))
            inclination.append(i)
            azimuth.append((335 + 7 * k - (k * k) // 9) % 360)
        self.write("turning.csv", "md_m,inclination_deg,azimuth_deg\n"
                   + "".join(f"{a},{b},{c}\n" for a, b, c in zip(md, inclination, azimuth)))
        return np.array(md), np.radians(inclination), np.radians(azimuth)

    def check(self, start, names, files=()):
        source = test_cli.SOURCE
        shipped = [source / "configs/error_models" / f for f in ("functions.toml", "owsg_a_rev5.1.toml", "owsg_b_rev5.1.toml")]
        functions, models = tool_code_reference.read(*shipped, *files)
        md, inclination, azimuth = self.survey(start)
        legs = [(md[0] if k == 0 else float(md[len(md) * k // len(names)]), name) for k, name in enumerate(names)]
        which = [f'{{ file = "{files[-1]}", name = "{name}" }}' if files else f'"{name}"' for name in names]
        self.write("turning.toml", f"""\
experiment = "position_covariance"
error_model = {which[0]}
[survey]
file = "turning.csv"
azimuth_reference = "magnetic"
unusual = "allow"
[field]
total_nT = 43210.0
dip_deg = -64.0
declination_deg = 7.2
gravity_mps2 = 9.79
latitude_deg = -31.0
""" + "".join(f"[[leg]]\nfrom_md_m = {legs[k][0]!r}\nerror_model = {which[k]}\n" for k in range(1, len(legs))))
        result = self.run_config("--overwrite", config="turning.toml", output="turning.h5")
        field = {"total": 43210.0, "dip": -64 * tool_code_reference.RAD, "g": 9.79,
                 "declination": 7.2 * tool_code_reference.RAD, "latitude": -31 * tool_code_reference.RAD}
        c = tool_code_reference.covariances(md, inclination, azimuth + field["declination"],
                                            [(depth, models[name]) for depth, name in legs], functions, field)
        for a, b, name in ((0, 0, "nn"), (1, 1, "ee"), (2, 2, "vv"), (0, 1, "ne"), (0, 2, "nv"), (1, 2, "ev")):
            difference = np.abs(column(result, "tables/covariance", f"{name}_m2") - c[:, a, b])
            # both are sums of some thousand products of doubles
            self.assertLess(np.max(difference[1:] / np.trace(c[1:], axis1=1, axis2=2)), 1e-13, f"{names} {name}")

    def test_single_tools(self):
        for name in ("MWD+SRGM", "MWD+IFR1+AX", "EMS+SRGM", "GYRO-NS-CT", "GYRO-NS-CT_Fl", "GYRO-MWD", "INC-ONLY", "BLIND",
                     "FINDS"):
            for start in (0, 500):
                self.check(start, [name])

    def test_tools_that_follow_each_other(self):
        for start in (0, 500):
            self.check(start, ["GYRO-NS-CT", "MWD+IFR1+AX", "GYRO-NS-CT"])
            self.check(start, ["INC-ONLY", "GYRO-MWD", "MWD+SRGM"])

    def test_gyros_of_two_zones_and_from_the_start_of_a_leg(self):
        examples = test_cli.SOURCE / "tests/tool_codes/data/spe90408_examples.toml"
        self.write("gyros.toml", examples.read_text().replace('functions = "functions.toml"', ""))
        for start in (0, 500):
            for names in (["example_3"], ["example_4"], ["example_5"], ["example_6", "example_4", "example_3", "example_4"]):
                self.check(start, names, [self.folder / "gyros.toml"])


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
