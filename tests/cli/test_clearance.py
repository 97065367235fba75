#!/usr/bin/python3
"""End-to-end tests of clearance: test_clearance.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import math
import re
import sys
import unittest
from pathlib import Path

import numpy as np

import test_cli
from test_cli import BAD_INPUT, DONE, UNEXPECTED, Case, column


def survey(stations):
    return "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{md},{i},{a}\n" for md, i, a in stations)


MAIN = [(30 * k, min(max(0, 3 * (k - 10)), 60), 20) for k in range(41)]
SIDE = MAIN[:21] + [(600 + 30 * k, 30, 20 + 4 * k) for k in range(1, 15)]
OTHER = [(30 * k, min(max(0, 3 * (k - 8)), 70), 200) for k in range(45)]

CONFIG = """\
experiment = "clearance"
[survey]
file = "main.csv"
hole_diameter_in = 12.25
[field]
total_nT = 50000.0
dip_deg = 70.0
[error_model]
name = "iscwsa_mwd_rev5.10"
[[offset]]
name = "other"
file = "other.csv"
slot_m = [600.0, 180.0, 0.0]
[[offset]]
name = "side"
file = "side.csv"
kickoff_md_m = 600.0
[separation]
formulations = ["independent", "geomagnetic", "shared", "zeroed"]
"""


class ClearanceCase(Case):
    def setUp(self):
        super().setUp()
        self.write("main.csv", survey(MAIN))
        self.write("other.csv", survey(OTHER))
        self.write("side.csv", survey(SIDE))
        self.write("base.toml", CONFIG)

    def changed(self, *changes, append=""):
        text = CONFIG
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        self.write("changed.toml", text + append)
        return "changed.toml"

    def rows(self, path, table="clearance", **wanted):
        header, rows = self.table_csv(path, table)
        rows = [dict(zip(header, r)) for r in rows]
        return [r for r in rows if all(r[k] == v for k, v in wanted.items())]


class Files(ClearanceCase):
    def test_the_survey_of_an_offset_may_be_of_another_program(self):
        wanted = self.rows(self.run_config(output="own.h5"), "least")
        text = "Survey of a well\nMD;Incl.;Azimuth\n;(deg);(deg)\n" + "".join(f"{md};{i};{a}\n" for md, i, a in OTHER)
        self.write("other.txt", text)
        config = self.changed(('"other.csv"', '"other.txt"'))
        self.refused(BAD_INPUT, "run", config, "-o", "x.h5",
                     says=r"""other\.txt:lines 2-3: column 'MD': no unit: must be known: offset\.depth_unit = "m", "ft" or "usft"; or make a CSV""")
        keys = '"other.txt"\ndepth_unit = "m"\nazimuth_reference = "true"'
        config = self.changed(('"other.csv"', keys))
        self.assertIn("# other.txt read as semicolon-separated text", self.call("check", config).stdout)
        self.assertEqual(self.rows(self.run_config(config=config, output="theirs.h5"), "least"), wanted)
        (self.folder / "other.txt").unlink()
        self.assertIn("identical: ", self.call("rerun", "theirs.h5").stdout)
        self.write("other.txt", text)
        self.refused(BAD_INPUT, "check", self.changed(('"other.csv"', keys.replace("\nazimuth_reference = \"true\"", ""))),
                     says=r"other\.txt: the file does not say which north .* azimuth_reference = ")
        self.refused(BAD_INPUT, "check", self.changed(('"other.csv"', '"other.csv"\ndepth_unit = "m"')),
                     says=r"other\.csv: .*must be without offset\.depth_unit")

    def test_a_hole_that_nobody_drills_is_a_warning(self):
        said = self.call("check", self.changed(("hole_diameter_in = 12.25", "hole_diameter_in = 311.0"))).stdout
        self.assertRegex(said, r"# warning: changed.toml:4: survey.hole_diameter_in = 311: a hole of 7\.899 m is wider than any")
        self.assertNotIn("# warning", self.call("check", "base.toml").stdout)


class Tables(ClearanceCase):
    def test_rows_hang_together(self):
        path = self.run_config()
        c = {k: np.array(column(path, "tables/clearance", k)) for k in
             ("distance_m", "sd_reference_m", "sd_offset_m", "sd_relative_m", "separation_factor", "sigma_distance",
              "mahalanobis", "ellipsoid_factor", "ellipse_separation_m", "ref_north_m", "offset_north_m", "ref_east_m",
              "offset_east_m", "ref_tvd_m", "offset_tvd_m")}
        words = np.array(column(path, "tables/clearance", "formulation")), np.array(column(path, "tables/clearance", "offset"))
        formulation, offset = words
        d = np.array([c[f"offset_{a}_m"] - c[f"ref_{a}_m"] for a in ("north", "east", "tvd")])
        np.testing.assert_allclose(np.linalg.norm(d, axis=0), c["distance_m"], rtol=0, atol=1e-9)
        radii = 12.25 * .0254
        sf = (c["distance_m"] - radii - .3) / (3.5 * np.hypot(c["sd_relative_m"], .5))
        np.testing.assert_allclose(sf, c["separation_factor"], rtol=1e-12)
        np.testing.assert_allclose(c["distance_m"] - radii - 3.5 * c["sd_relative_m"], c["ellipse_separation_m"],
                                   rtol=0, atol=1e-9)
        alone = formulation == "independent"
        np.testing.assert_allclose(np.hypot(c["sd_reference_m"], c["sd_offset_m"])[alone], c["sd_relative_m"][alone],
                                   rtol=1e-10)
        # A theorem: the pedal radius is never less cautious than Mahalanobis.
        self.assertTrue(np.all(c["sigma_distance"] <= c["mahalanobis"] * (1 + 1e-9)))
        finite = alone & np.isfinite(c["mahalanobis"]) & (c["distance_m"] > 0)
        ratio = c["ellipsoid_factor"][finite] / c["mahalanobis"][finite]
        self.assertTrue(np.all((ratio > math.sqrt(.5) - 1e-9) & (ratio < 1 + 1e-9)))
        # From the kick-off on, and "shared", "zeroed" for the sidetrack alone.
        self.assertEqual(set(formulation[offset == "other"]), {"independent", "geomagnetic"})
        self.assertEqual(set(formulation[offset == "side"]), {"independent", "geomagnetic", "shared", "zeroed"})
        md = np.array(column(path, "tables/clearance", "ref_md_m"))
        self.assertEqual(sorted(set(md[offset == "side"]))[:2], [600, 630])
        # At the kick-off both wells are one point: no direction, so no sd along it, and the rule's constants alone.
        kickoff = (offset == "side") & (md == 600)
        self.assertEqual(kickoff.sum(), 4)
        for name in ("distance_m", "sd_reference_m", "sd_offset_m", "sd_relative_m", "mahalanobis"):
            self.assertEqual(set(c[name][kickoff]), {0}, name)
        np.testing.assert_allclose(c["separation_factor"][kickoff], -(radii + .3) / (3.5 * .5), rtol=1e-12)
        # What is least is sought below it.
        self.assertGreater(min(float(r["distance_m"]) for r in self.rows(path, "least", offset="side")), 0)

    def test_least_says_whether_the_rule_is_kept(self):
        path = self.run_config()
        for r in self.rows(path, "least"):
            self.assertLessEqual(float(r["continuous"]), float(r["at_stations"]))
            if r["quantity"] == "separation_factor":
                self.assertEqual(r["rule"], "kept" if float(r["continuous"]) >= 1 else "broken")
            else:
                self.assertEqual(r["rule"], "")
        self.assertEqual(self.rows(path, "least", offset="side", formulation="shared", quantity="separation_factor")[0]["rule"],
                         "broken")  # at the kick-off, holes touch

    def test_no_rows_where_none_are_wanted(self):
        few = self.run_config(config=self.changed(append="[output]\nclearance = \"none\"\n"))
        all_rows = self.run_config(output="all.h5")
        self.assertEqual(self.rows(few, "least"), self.rows(all_rows, "least"))
        self.call("show", few, "clearance", code=(test_cli.USAGE, BAD_INPUT))

    def test_both_directions_find_other_pairs(self):
        path = self.run_config(config=self.changed(append="[scan]\ndirection = \"both\"\nstep_m = 10.0\n"))
        there, back = (self.rows(path, direction=d, offset="other", formulation="independent") for d in ("reference", "offset"))
        # Ten metres apart: stations are among these points.
        self.assertEqual([float(r["ref_md_m"]) for r in there], [10.0 * k for k in range(121)])
        self.assertEqual([float(r["offset_md_m"]) for r in back], [10.0 * k for k in range(133)])

    def test_the_least_at_stations_is_of_stations_alone(self):
        found = {}
        for step in (0.0, 7.0):
            path = self.run_config(config=self.changed(append=f"[scan]\ndirection = \"both\"\nstep_m = {step}\n"))
            found[step] = self.rows(path, "least", offset="other")
            least = {(r["direction"], r["formulation"]): float(r["continuous"]) for r in found[step] if r["quantity"] == "distance"}
            for r in self.rows(path, offset="other"):
                self.assertLessEqual(least[r["direction"], r["formulation"]], float(r["distance_m"]) * (1 + 1e-9))
        for a, b in zip(*found.values()):
            for name in ("at_stations", "stations_ref_md_m", "stations_offset_md_m"):
                self.assertEqual(a[name], b[name])
            self.assertAlmostEqual(float(a["continuous"]), float(b["continuous"]), delta=1e-4 * float(a["continuous"]))

    def test_published_figures_are_judged(self):
        path = self.run_config()
        row = self.rows(path, offset="other", formulation="geomagnetic", ref_md_m="900")[0]
        entry = """
[[published]]
source = "a source"
table = "clearance"
offset = "other"
formulation = "geomagnetic"
md_m = 900.0
values = {{ separation_factor = {}, distance_m = {} }}
"""
        sf, d = float(row["separation_factor"]), float(row["distance_m"])
        good = self.changed(append=entry.format(round(sf, 2), round(d, 2)))
        self.run_config("--check", config=good)
        self.call("run", self.changed(append=entry.format(round(sf, 2) + .02, d)), "-o", "bad.h5", "--check", code=UNEXPECTED)

    def test_a_list_of_codes_shares_them(self):
        lists = '{ name = "field", codes = ["DEC-OS", "DEC-OH", "DEC-OI", "DBH-OS", "DBH-OH", "DBH-OI"] }'
        path = self.run_config(config=self.changed(('"geomagnetic"', f'"geomagnetic", {lists}')))
        a, b = (self.rows(path, offset="other", formulation=f) for f in ("geomagnetic", "field"))
        self.assertEqual([r["sd_relative_m"] for r in a], [r["sd_relative_m"] for r in b])

    def test_least_distances_are_printed_in_feet(self):
        path = self.run_config()
        metres = self.rows(path, "least", quantity="distance")
        table = self.call("show", path, "least", "--units", "ft").stdout
        head = next(line for line in table.splitlines() if " quantity " in line)
        self.assertIn("quantity", head)
        rows = [line for line in table.splitlines() if re.search(r" distance +ft ", line)]
        self.assertEqual(len(rows), len(metres))
        for row, line in zip(metres, rows):
            self.assertAlmostEqual(float(re.search(r" distance +ft +(\S+)", line)[1]), float(row["at_stations"]) / 0.3048, delta=0.01)
        factors = self.rows(path, "least", quantity="separation_factor")
        for row, line in zip(factors, [l for l in table.splitlines() if " separation_factor " in l]):
            self.assertAlmostEqual(float(re.search(r" separation_factor +1 +(\S+)", line)[1]), float(row["at_stations"]), delta=1e-4)


class Sidetracks(ClearanceCase):
    def test_the_azimuth_listed_in_a_vertical_shared_hole_does_not_matter(self):
        below = [(300 + 30 * k, 3 * k, 80) for k in range(1, 15)]
        found = []
        for azimuth in (20, 90):
            self.write("side.csv", survey([(30 * k, 0, azimuth) for k in range(11)] + below))
            path = self.run_config(config=self.changed(("kickoff_md_m = 600.0", "kickoff_md_m = 300.0")))
            found.append(self.rows(path, offset="side"))
        self.assertEqual(*found)


    def test_without_a_tool_of_its_own_a_sidetrack_has_those_of_the_reference_at_its_depths(self):
        legs = ('[[offset]]\nname = "other"', '[[leg]]\nfrom_md_m = {}\nerror_model = "MWD+IFR1"\n[[offset]]\nname = "other"')
        own = "kickoff_md_m = 600.0"
        for begins, said in ((600.0, 'error_model = "MWD+IFR1"'),
                             (700.0, '[[offset.leg]]\nfrom_md_m = 700.0\nerror_model = "MWD+IFR1"')):
            legs_at = (legs[0], legs[1].format(begins))
            for formulation in ("shared", "zeroed"):
                found = [self.rows(self.run_config(config=self.changed(legs_at, (own, f"{own}\n{text}"))),
                                   offset="side", formulation=formulation) for text in ("", said)]
                self.assertEqual(*found)


class North(ClearanceCase):
    GRID = survey(MAIN).replace("azimuth_deg", "azimuth_grid_deg")
    FIELD = ("dip_deg = 70.0", "dip_deg = 70.0\nconvergence_deg = 5.0")

    def test_a_file_that_names_its_north_is_turned_by_it(self):
        self.write("grid.csv", self.GRID)
        path = self.run_config(config=self.changed(("other.csv", "grid.csv"), self.FIELD))
        for well, turn in (("reference", 0), ("other", 5)):
            self.assertEqual({float(r["azimuth_deg"]) for r in self.rows(path, "paths", well=well)}, {20 + turn})

    def test_slots_of_a_map_are_turned_or_asked_about(self):
        for name in "main.csv", "other.csv", "side.csv":
            self.write(name, (self.folder / name).read_text().replace("azimuth_deg", "azimuth_grid_deg"))
        says = r"survey.slot_reference: missing: .*the convergence of 5 deg turns by up to 54\.6 m: survey.slot_reference = \"true\" or \"grid\""
        self.refused(BAD_INPUT, "check", self.changed(self.FIELD), says=says)
        given = lambda north: ('file = "main.csv"', f'file = "main.csv"\nslot_reference = "{north}"')
        true = self.rows(self.run_config(config=self.changed(self.FIELD, given("true"))), "paths", well="other")[0]
        self.assertEqual((float(true["north_m"]), float(true["east_m"])), (600, 180))
        least = {}
        for config in self.changed(self.FIELD, given("grid")), "base.toml":  # the second: the map is true north
            if config == "base.toml":
                for name in "main.csv", "other.csv", "side.csv":
                    self.write(name, (self.folder / name).read_text().replace("azimuth_grid_deg", "azimuth_deg"))
            path = self.run_config(config=config)
            least[config] = min(float(r["distance_m"]) for r in self.rows(path, offset="other"))
        self.assertAlmostEqual(*least.values(), places=6)
        near = [("[600.0, 180.0, 0.0]", "[30.0, 0.0, 0.0]"), self.FIELD]
        for name in "main.csv", "other.csv", "side.csv":
            self.write(name, (self.folder / name).read_text().replace("azimuth_deg", "azimuth_grid_deg"))
        self.assertIn("turns by up to 2.62 m", self.call("check", self.changed(*near)).stdout)

    def test_the_north_of_a_reference_that_names_it_is_asked_of_the_others(self):
        self.write("main.csv", self.GRID)
        says = r"offset\[0\].azimuth_reference: missing: azimuths of the reference are from grid north"
        self.refused(BAD_INPUT, "check", self.changed(self.FIELD), says=says)

    def test_a_north_that_contradicts_the_file_is_refused(self):
        said = ('name = "other"', 'name = "other"\nazimuth_reference = "true"')
        for word, change, says in (("grid", [said], r"offset\[0\].azimuth_reference = .*says grid north: must agree"),
                                   ("unreferenced", [], r"grid.csv: .*must be known: azimuth_reference")):
            self.write("grid.csv", self.GRID.replace("grid", word))
            self.refused(BAD_INPUT, "check", self.changed(("other.csv", "grid.csv"), *change), says=says)


class BadInput(ClearanceCase):
    def refuse(self, says, *changes, append=""):
        config = self.changed(*changes, append=append)
        return self.refused(BAD_INPUT, "run", config, "-o", "out.h5", says=says)

    def test_every_mistake_has_its_place_value_and_rule(self):
        side = '[[offset]]\nname = "side"\nfile = "side.csv"\nkickoff_md_m = 600.0\n'
        for says, change in (
                (r'changed.toml:19: .*codes = .*"NONE".*no model here has the code "NONE"',
                 ('"shared"', '{ name = "own", codes = ["NONE"] }')),
                (r"codes.*mode R or S.*never share", ('"shared"', '{ name = "own", codes = ["SAGE"] }')),
                (r'formulations = .*"corelated" is none of', ('"geomagnetic"', '"corelated"')),
                (r'formulations.*two formulations have the name "shared"', ('"zeroed"', '"shared"')),
                (r'formulations.*"shared" is for sidetracks', (side, "")),
                (r"kickoff_md_m = 610: the survey of the sidetrack has no station", ("kickoff_md_m = 600.0", "kickoff_md_m = 610.0")),
                (r"kickoff_md_m = 630: down to it, both surveys must be equal: station 22", ("kickoff_md_m = 600.0", "kickoff_md_m = 630.0")),
                (r"kickoff_md_m = 0: must be below the tie-on", ("kickoff_md_m = 600.0", "kickoff_md_m = 0.0")),
                (r"kickoff_md_m = 600: a sidetrack has the slot", ("kickoff_md_m = 600.0", "kickoff_md_m = 600.0\nslot_m = [1.0, 0.0, 0.0]")),
                (r"offset\[1\].field.*: differs from that of the reference",
                 ("kickoff_md_m = 600.0", "kickoff_md_m = 600.0\nfield = { total_nT = 58000.0, dip_deg = 76.0 }")),
                (r"offset\[1\].field.*: differs from that of the reference",
                 ("kickoff_md_m = 600.0", "kickoff_md_m = 600.0\nfield.declination_deg = 3.0")),
                (r"offset\[1\].name = .*another well has this name", ('name = "side"', 'name = "other"')),
                (r"another well has this name", ('name = "side"', 'name = "reference"')),
                (r"offset\[0\].slot_m: missing", ("slot_m = [600.0, 180.0, 0.0]\n", "")),
                (r"survey.hole_diameter_in = 0: must be > 0", ("12.25", "0.0")),
                (r"hole_diameter_in = 5: not together with", ("12.25", "5.0\nhole_diameter_m = 0.1")),
                (r"hole_diameter", ("hole_diameter_in = 12.25\n", "")),
                (r"azimuth_reference: missing: azimuths of the reference are from grid north",
                 ('hole_diameter_in', 'azimuth_reference = "grid"\nhole_diameter_in')),
                (r"offset\[0\].field.dip_deg: missing", ('name = "other"', 'name = "other"\nfield = { total_nT = 48000.0 }')),
                (r"offset: missing: there must be at least one", (CONFIG[CONFIG.index("[[offset]]"):], "")),
                (r"file = .*is the reference itself", ('file = "other.csv"\nslot_m = [600.0, 180.0, 0.0]', 'file = "main.csv"\nslot_m = [0.0, 0.0, 0.0]')),
                (r"separation.scale_factor = 0: must be > 0", ("[separation]\n", "[separation]\nscale_factor = 0.0\n")),
                (r"separation.surface_margin_m = -1: must be >= 0", ("[separation]\n", "[separation]\nsurface_margin_m = -1.0\n")),
                (r"scan.keep = 0.5: must be >= 1", ("[separation]\n", "[scan]\nkeep = 0.5\n[separation]\n")),
                (r"report_md_m = .*1300 is not on the reference", ("[survey]", "report_md_m = [600.0, 1300.0]\n[survey]")),
                (r"report_md_m = .*must increase", ("[survey]", "report_md_m = [600.0, 600.0]\n[survey]")),
                (r"unknown key", ("[survey]", "sepration = 1\n[survey]"))):
            with self.subTest(says):
                self.refuse(says, change)

    def test_depths_twice_and_a_gap_in_a_name(self):
        self.write("other.csv", survey(OTHER[:5] + OTHER[4:]))
        self.refuse(r"other.csv:\d+: md_m = 120: must be greater than the one before")

    def test_what_only_one_well_has_is_told_by_name(self):
        config = self.changed(('name = "other"', 'name = "other"\nerror_model = "MWD+IFR1"'))
        told = self.call("run", config, "-o", "out.h5").stdout
        self.assertRegex(told, r'"geomagnetic" of other: errors that only one of the wells has are not shared: only the reference has .*DEC-OS.*only the offset has .*DEC-CI')
        config = self.changed(('name = "other"', 'name = "other"\nerror_model = "iscwsa_mwd_rev4"'))
        told = self.call("run", config, "-o", "out.h5").stdout
        self.assertRegex(told, r'"geomagnetic" of other: the wells share nothing, and their results are those of "independent": only the reference has ')

    def pole(self, *changes, append=""):
        # A lateral error of 1/cosI: at 90 degrees there is none.
        self.write("pole.toml", 'title = "pole"\nsource = "a test"\nfirst_leg = "once"\n'
                   'terms = [{ code = "POLE", function = "POLE", magnitude = 1.0, unit = "deg", mode = "S" }]\n'
                   '[[function]]\nname = "POLE"\nazimuth = "1/cos(Inc)"\n')
        self.write("main.csv", survey([(30 * k, 3 * k, 0) for k in range(31)]))
        return self.changed(('name = "iscwsa_mwd_rev5.10"', 'file = "pole.toml"'),
                            ('[[offset]]\nname = "side"\nfile = "side.csv"\nkickoff_md_m = 600.0\n', ""),
                            (', "shared", "zeroed"', ""), *changes, append=append)

    def test_a_model_without_finite_effect_gives_no_verdict(self):
        path = self.run_config(config=self.pole(), code=(DONE, UNEXPECTED))
        self.assertIn("severe", {r["severity"] for r in self.rows(path, "warnings")})
        for r in self.rows(path, "least"):
            self.assertIn(r["rule"], ("broken", "none", ""))
        # Far apart wherever there is a covariance: at the pole they may be anything.
        path = self.run_config(config=self.pole(("[600.0, 180.0, 0.0]", "[60000.0, 0.0, 0.0]")), code=(DONE, UNEXPECTED))
        least = self.rows(path, "least", quantity="separation_factor", formulation="independent")[0]
        self.assertGreater(float(least["continuous"]), 1)
        self.assertEqual(least["rule"], "none")

    def test_a_model_without_finite_effect_is_not_drawn(self):
        trials = ("[survey]", "seed = 1\ntrials = 100\nreport_md_m = [300.0, {}]\n[survey]")
        says = r'changed.toml:\d+: error_model.*: reference: POLE has no finite effect at 900 m'
        for md in (900.0, 885.0):  # a point between stations follows both
            config = self.pole((trials[0], trials[1].format(md)))
            self.refused(BAD_INPUT, "run", config, "-o", "out.h5", says=says)
        path = self.run_config(config=self.pole((trials[0], trials[1].format(870.0))), code=(DONE, UNEXPECTED))
        self.assertEqual({r["md_m"] for r in self.rows(path, "relative_position")}, {"300", "870"})

    def test_a_range_that_refuses_holds_for_all_wells(self):
        self.write("main.csv", survey([(30 * k, 0, 0) for k in range(41)]))
        config = self.changed(('name = "iscwsa_mwd_rev5.10"', 'name = "INC-ONLY"\noutside_range = "refuse"'),
                              ('[[offset]]\nname = "side"\nfile = "side.csv"\nkickoff_md_m = 600.0\n', ""),
                              (', "shared", "zeroed"', ""))
        self.refused(BAD_INPUT, "check", config, says=r"outside_range.*: other: INC-ONLY: station at md 570 m")


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
