#!/usr/bin/python3
"""The maps and the axial rows of corrected_codes against an independent program: test_code_maps.py SURVEYMC_EXECUTABLE SOURCE_FOLDER

The figures are first-order ones of an independent numpy program, and of its own Monte Carlo for axial correction.
"""
import re
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, Case, column

CORRECTIONS = ("msa", "msa3", "joint", "joint_priors")
CLASSES = ("free", "kept", "broken", "harmful", "undetermined")
# Shares of the directions by class, printed to 0.01.
NONE = (0, 0, 0, 0, 1)
MAPS = {
    "dip 72, building, even": ((.55, .19, .24, .02, 0), (.57, .43, 0, 0, 0), (.56, .37, .06, .01, 0), (.57, .43, 0, 0, 0)),
    "dip 72, building, slide": ((0, 0, .71, .11, .19), (0, .20, .51, .14, .15), (0, 0, .71, .11, .19), (.17, .40, .43, 0, 0)),
    "dip 72, straight, even": (NONE, (.35, .47, .15, 0, .02), NONE, (.35, .50, .13, 0, .02)),
    "dip 72, straight, slide": (NONE, NONE, NONE, (0, 0, .98, 0, .02)),
    "dip 0, building, even": ((.63, .37, 0, 0, 0),) * 4,
    "dip 82, building, even": ((.47, .13, .35, .05, 0), (.52, .48, 0, 0, 0), (.50, .36, .12, .02, 0), (.52, .48, 0, 0, 0)),
    "dip 82, straight, even": (NONE, (.37, .42, .20, 0, .01), NONE, (.37, .47, .15, 0, .01)),
}
# (inclination, azimuth): share of the area where the claim is broken, and the largest ratio, by correction.
GLOBE = {
    (90, 90): ((.66, 3.3), (0, .96), (0, .95), (0, .82)),
    (90, 45): ((.12, 3.1), (0, .93), (0, .90), (0, .86)),
    (90, 0): ((.03, 3.5), (0, .95), (0, .95), (0, .95)),
    (45, 90): ((.25, 9.1), (0, None), (.15, None), (0, None)),
    (45, 45): ((.14, 11), (0, None), (.03, None), (0, None)),
    (45, 0): ((.03, 5.4), (0, None), (.01, None), (0, None)),
}
# Code and dip: (rms over claimed, share beyond three claimed sd in %) at 30, 20, 17.5, 15, 12.5 and 10 deg from magnetic east.
FROM_EAST = (30, 20, 17.5, 15, 12.5, 10)
AXIAL = {
    "SRGM+AX, dip 0": ((.997, .3), (.998, .3), (1.000, .3), (1.005, .4), (1.018, .6), (1.077, 1.2)),
    "SRGM+AX, dip 60": ((1.010, .3), (1.015, .4), (1.021, .5), (1.037, .7), (1.087, 1.2), (1.178, 3.4)),
    "SRGM+AX, dip 72": ((1.014, .3), (1.032, .5), (1.057, .9), (1.113, 1.6), (1.181, 4.0), (1.117, 0)),
    "SRGM+AX, dip 80": ((1.022, .4), (1.106, 1.6), (1.167, 3.0), (1.171, .2), (1.073, 0), (.872, 0)),
    "IFR1+AX, dip 72": ((1.019, .3), (1.024, .4), (1.032, .6), (1.052, .9), (1.116, 1.6), (1.192, 4.7)),
    "IFR1+AX, dip 80": ((1.023, .4), (1.050, .8), (1.088, 1.3), (1.162, 2.4), (1.185, 6.0), (1.064, 0)),
    "IFR2+AX+SAG, dip 72": ((1.021, None), (1.024, None), (1.029, None), (1.040, .6), (1.077, None), (1.178, None)),
    "IFR2+AX+SAG, dip 80": ((1.024, None), (1.040, None), (1.059, None), (1.112, 1.5), (1.192, None), (1.146, None)),
}
HALF_ANGLES = {"SRGM+AX, dip 0": 12, "SRGM+AX, dip 60": 15, "SRGM+AX, dip 72": 19, "SRGM+AX, dip 80": 26, "IFR1+AX, dip 72": 15,
               "IFR1+AX, dip 80": 20}
# Degrees from level east: rms over claimed at 0, 15, 30, 45, 60 and 90 deg out of the level.
CIRCLES = {15: (1.113, 1.100, 1.056, 1.024, 1.015, 1.008), 10: (1.117, 1.256, 1.242, 1.165, 1.102, 1.022)}


def rows_of(path, table):
    with h5py.File(path) as file:
        names = list(file[f"tables/{table}"])
    return [dict(zip(names, row)) for row in zip(*(list(column(path, f"tables/{table}", n)) for n in names))]


def config_of(name):
    return test_cli.SOURCE / "configs" / "corrected_codes" / f"{name}.toml"


class ConfigCase(Case):
    def result(self, name, *options):
        path = Path(self.folder) / f"{name}.h5"
        self.call("run", config_of(name), "-o", path, *options, code=(0, 1), timeout=600)
        return path


class Maps(ConfigCase):
    # Where the shares differ from the source's: it calls determined what no reading can tell. In a slide that builds in one plane bx is
    # the same at all stations, so that gain and bias of x are one; at the magnetic equator a hole to the east has no bz, and no gain of
    # z. Straight holes: one or two cells beside level east.
    UNDETERMINED = {("dip 72, building, slide", "msa"): 1, ("dip 72, building, slide", "joint"): 1,
                    ("dip 0, building, even", "msa"): 12 / 156, ("dip 0, building, even", "joint"): 12 / 156,
                    ("dip 72, straight, even", "msa3"): 1 / 156, ("dip 72, straight, even", "joint_priors"): 0,
                    ("dip 72, straight, slide", "joint_priors"): 0}

    def test_shares_over_directions(self):
        rows = rows_of(self.result("maps"), "shares")
        for case, by_correction in MAPS.items():
            for correction, shares in zip(CORRECTIONS, by_correction):
                row = next(r for r in rows if r["case"] == case and r["correction"] == correction)
                with self.subTest(case=case, correction=correction):
                    if (case, correction) in self.UNDETERMINED:
                        self.assertAlmostEqual(row["undetermined"], self.UNDETERMINED[case, correction], places=12)
                        continue
                    # Half a step of rounding, and one cell of 156 beside the margin.
                    self.assertLess(max(abs(row[c] - s) for c, s in zip(CLASSES, shares)), 0.012)

    def test_shares_over_the_globe(self):
        rows = rows_of(self.result("globe"), "shares")
        self.assertEqual({r["cells"] for r in rows}, {15 * 24})
        for (inclination, azimuth), by_correction in GLOBE.items():
            for correction, (broken, largest) in zip(CORRECTIONS, by_correction):
                row = next(r for r in rows if (r["well.inclination_deg"], r["well.azimuth_deg"]) == (inclination, azimuth)
                           and r["correction"] == correction)
                with self.subTest(well=(inclination, azimuth), correction=correction):
                    self.assertLess(abs(row["broken"] + row["harmful"] - broken), 0.02)
                    if largest is not None:
                        self.assertLess(abs(row["largest_ratio"] - largest), 0.006 if largest < 2 else 0.06 if largest < 10 else 0.6)

    def test_six_places(self):
        path = self.result("places")
        rows, claims = ([r for r in rows_of(path, t) if r["quantity"].endswith("lateral")] for t in ("prediction", "claims"))
        self.assertEqual(len(rows), 36)
        for row, claim in zip(rows, claims):
            with self.subTest(case=row["case"], azimuth=row["well.azimuth_deg"], correction=row["correction.kind"]):
                self.assertLess(abs(claim["predicted_ratio"] - row["published"]), 0.01)

    def test_a_place_of_a_map_is_that_place_by_itself(self):
        alone = {(r["case"], r["well.azimuth_deg"], r["correction"]): r["predicted_ratio"] for r in rows_of(self.result("places"), "claims")}
        with h5py.File(self.result("globe")) as file:
            data = file["maps/ratio_lateral"]
            axes = {d[0].name.split("/")[-1]: list(d[0].asstr()[()] if d[0].dtype.kind == "O" else d[0][()]) for d in data.dims}
            at = [axes["correction.kind"].index("msa"), axes["well.inclination_deg"].index(90), axes["well.azimuth_deg"].index(90)]
            cell = data[()][(*at, axes["latitude"].index(60), axes["longitude"].index(0))]
        self.assertEqual(cell, alone["North Sea", 90, "msa"])

    def test_wrong_maps(self):
        for options, said in ((("map.latitude_deg=[91.0]",), "must be in [-90, 90]"), (("trials=10",), "has no trials"),
                              (("field.latitude_deg=60",), "not together with places of a map"),
                              (("field.date=2031-01-01",), "valid from"),
                              (("map.inclination_deg=[0.0, 90.0]",), "over places or over directions")):
            with self.subTest(options=options):
                self.refused(BAD_INPUT, "check", config_of("world"), *sum((["--set", o] for o in options), []), says=re.escape(said))


class Axial(ConfigCase):
    def test_beside_magnetic_east(self):
        path = self.result("axial")
        claims, zones = rows_of(path, "claims"), rows_of(path, "zone")
        for case, by_angle in AXIAL.items():
            for angle, (rms, tail) in zip(FROM_EAST, by_angle):
                found, beyond = (np.mean([r[n] for r in claims if r["case"] == case and r["well.azimuth_deg"] == 90 - angle])
                                 for n in ("rms_ratio", "beyond_3_sd"))
                with self.subTest(case=case, angle=angle):
                    if case.startswith("SRGM"):
                        self.assertLess(abs(found - rms), 0.012)
                        self.assertLess(abs(100 * beyond - tail), 0.2)
                        continue
                    # The source has 1.019 to 1.024 at 30 deg, where its own first order, and ours, is 1 to 0.001: all its rows of IFR
                    # codes are 1.02 times too large. The curve is the same.
                    far = np.mean([r["rms_ratio"] for r in claims if r["case"] == case and r["well.azimuth_deg"] == 60])
                    self.assertLess(abs(far - 1), 0.012)
                    self.assertLess(abs(found / far - rms / by_angle[0][0]), 0.02)  # four rms of 24,000 draws
        for case, angle in HALF_ANGLES.items():
            row = next(r for r in zones if r["case"] == case)
            self.assertLess(abs(row["half_angle_deg"] - angle), 0.6, case)

    def test_out_of_the_level(self):
        claims = rows_of(self.result("axial_circle"), "claims")
        for x, by_angle in CIRCLES.items():
            for phi, rms in zip((0, 15, 30, 45, 60, 90), by_angle):
                found = [r["rms_ratio"] for r in claims if r["case"] == f"{x} deg, {phi} deg out of the level"]
                with self.subTest(x=x, phi=phi):
                    # Of 24,000 trials each: an sd of 0.007 of the difference.
                    self.assertLess(abs(np.mean(found) - rms), 0.021)


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
