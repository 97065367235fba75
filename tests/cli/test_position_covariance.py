#!/usr/bin/python3
"""End-to-end tests of position_covariance: test_position_covariance.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import os
import pty
import re
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, DONE, UNEXPECTED, USAGE, Case, column, contents, stored_config

ELEMENTS = ("nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2")

SURVEY = """\
md_m,inclination_deg,azimuth_deg
0,0,0
30,0,0
60,4,340
90,9,352
120,15,3
150,22,11
"""

CONFIG = """\
experiment = "position_covariance"
seed = 1
error_model = "iscwsa_mwd_rev5.10"
[survey]
file = "well.csv"
[field]
total_nT = 50000.0
dip_deg = 72.0
declination_deg = -4.0
convergence_deg = 2.0
"""


class CovarianceCase(Case):
    def setUp(self):
        super().setUp()
        self.write("well.csv", SURVEY)
        self.write("base.toml", CONFIG)

    def shipped_model(self, name):
        return (test_cli.SOURCE / "configs/error_models" / f"{name}.toml").read_text()

    def covariance(self, *arguments, output="out.h5", **more):
        """The covariances of a run, one row a station."""
        path = self.run_config(*arguments, output=output, **more)
        return np.array([column(path, "tables/covariance", e) for e in ELEMENTS]).T


class LongSurvey(CovarianceCase):
    """100,000 stations by source take far longer than the fifth of a second after which the first line appears."""

    def setUp(self):
        super().setUp()
        rows = [f"{0.12 * k:.2f},{min(90, 0.0012 * k):.4f},{(75 + 0.0002 * k) % 360:.4f}" for k in range(100_000)]
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n" + "\n".join(rows) + "\n")

    def test_a_long_survey_says_on_a_terminal_how_far_it_is(self):
        parent, child = pty.openpty()
        process = subprocess.Popen([test_cli.EXECUTABLE, "run", "base.toml", "-o", "out.h5"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=child)
        os.close(child)
        said = b""
        while True:
            try:
                piece = os.read(parent, 4096)
            except OSError:  # Linux: the other end is closed
                break
            if not piece:
                break
            said += piece
        os.close(parent)
        self.assertEqual(process.wait(), DONE)
        shares = [float(x) for x in re.findall(rb"([0-9.]+) %", said)]
        self.assertTrue(shares, said)
        self.assertTrue(all(0 <= x <= 100 for x in shares), shares)
        self.assertRegex(said, rb"% of [0-9.e+]+ stations")


class Tables(CovarianceCase):
    def test_the_columns_that_scripts_rely_on(self):
        path = self.run_config()
        header, rows = self.table_csv(path, "covariance")
        self.assertEqual(header[:7], ["md_m", *ELEMENTS])
        self.assertEqual([float(r[0]) for r in rows], [0, 30, 60, 90, 120, 150])
        header, rows = self.table_csv(path, "covariance_by_source")
        self.assertEqual(header, ["md_m", "source", *ELEMENTS])
        self.assertEqual(len(rows), 6 * 35)
        self.assertRegex(self.call("list").stdout, r"(?m)^position_covariance\s+\S+")

    def test_a_large_result_says_how_far_it_is(self):
        # 37 rows a station: 35 sources, covariance, ellipsoid. Above 10^6 rows a line on stderr, but with --quiet.
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{k / 2},45,30\n" for k in range(27100)))
        arguments = ["run", "base.toml", "-o", "large.h5", "--overwrite"]
        self.assertRegex(self.call(*arguments).stderr, r"computed in \S+ s; writing 10027\d\d rows to large\.h5")
        self.assertNotIn("writing", self.call(*arguments, "--quiet").stderr)
        self.assertNotIn("writing", self.call(*arguments, "--set", 'output.by_source="last"').stderr)

    def test_a_long_survey_has_the_same_contents_for_any_number_of_threads(self):
        # Above 65,536 rows by source another thread makes that table beside the covariances
        rows = (f"{6 * k},{min(90, 0.06 * k):.4f},{(75 + 0.01 * k) % 360:.4f}\n" for k in range(1900))
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n" + "".join(rows))

        def said_and_hash(threads, *more):
            said = self.call("run", "base.toml", "-o", "out.h5", "--overwrite", "--threads", threads, *more).stdout
            with h5py.File(self.folder / "out.h5") as f:
                return re.sub(r"\(in .*\)", "", said), f.attrs["content_hash"]

        alone = said_and_hash("1")
        self.assertEqual(said_and_hash("2"), alone)
        self.assertEqual(said_and_hash("2", "--compress", "1"), alone)
        self.assertIn("identical", self.call("rerun", "out.h5").stdout)
        swept = ["--set", "sweep.field.dip_deg=[70.0, 72.0]"]
        self.assertEqual(said_and_hash("2", *swept), said_and_hash("1", *swept))

    def test_the_answer_has_no_high_side_in_a_vertical_hole(self):
        sideways = r"\AAt 150 m the position is known to \S+ m by \S+ m sideways, .* and \S+ m in depth"
        self.assertNotRegex(self.call("run", "base.toml", "-o", "out.h5").stdout, sideways)
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n0,0,0\n30,20,40\n90,20,40\n120,0.5,40\n150,0,40\n")
        said = self.call("run", "base.toml", "-o", "out.h5", "--overwrite").stdout
        self.assertRegex(said, sideways)
        self.assertNotIn("high side", said)

    def test_sources_add_up_and_frames_agree(self):
        path = self.run_config()
        sources = np.array([column(path, "tables/covariance_by_source", e) for e in ELEMENTS]).T.reshape(6, 35, 6)
        total = np.array([column(path, "tables/covariance", e) for e in ELEMENTS]).T
        np.testing.assert_allclose(sources.sum(axis=1), total, rtol=0, atol=1e-14 * total[:, :3].sum(axis=1).max())
        hla = np.array([column(path, "tables/covariance", e) for e in ("hh_m2", "ll_m2", "aa_m2")]).T
        np.testing.assert_allclose(hla.sum(axis=1), total[:, :3].sum(axis=1), rtol=1e-14)
        sd = [column(path, "tables/covariance", f"sd_{d}_m") for d in ("north", "east", "vertical")]
        np.testing.assert_allclose(np.square(sd).T, total[:, :3], rtol=1e-14)
        axes = [column(path, "tables/ellipsoid", f"axis{i}_m") for i in (1, 2, 3)]
        np.testing.assert_allclose(np.square(axes).sum(axis=0), total[:, :3].sum(axis=1), rtol=1e-13)

    def uncertainty(self, path):
        """{(md, quantity): row} of the table, without NaN."""
        header, rows = self.table_csv(path, "uncertainty")
        return header, {(float(r[0]), r[1]): dict(zip(header, (float(x or "nan") if i != 1 else x for i, x in enumerate(r)))) for r in rows}

    def test_the_last_station_is_printed(self):
        printed = self.call("run", "base.toml", "-o", "out.h5", "--verbose").stdout
        path = self.folder / "out.h5"
        header, rows = self.uncertainty(path)
        self.assertEqual(header, ["md_m", "quantity", "sd_m", "sigma2_m", "azimuth_deg"])
        for direction in ("north", "east", "vertical", "high_side", "lateral", "along_hole"):
            sd = column(path, "tables/covariance", f"sd_{direction}_m")[-1]
            self.assertEqual(rows[150, direction]["sd_m"], sd)
            self.assertEqual(rows[150, direction]["sigma2_m"], 2 * sd)
            self.assertRegex(printed, rf"(?m)^ 150  {direction} +{sd:.6g} ")
        for axis in ("semi_major", "semi_minor"):
            self.assertEqual(rows[150, axis]["sd_m"], column(path, "tables/covariance", f"{axis}_m")[-1])
        azimuth = column(path, "tables/covariance", "major_azimuth_deg")[-1]
        self.assertEqual(rows[150, "semi_major"]["azimuth_deg"], azimuth)
        self.assertAlmostEqual(rows[150, "semi_minor"]["azimuth_deg"], (azimuth + 90) % 180, delta=1e-12)
        feet = self.call("run", "base.toml", "-o", "feet.h5", "--units", "ft", "--verbose").stdout
        self.assertRegex(feet, rf"(?m)^492\.126  north +{rows[150, 'north']['sd_m'] / 0.3048:.6g} ")
        self.assertRegex(feet, r"(?m)^ +md_ft +quantity +sd_ft +sigma2_ft")

    def test_sigmas_percent_and_depths_between_stations(self):
        path = self.run_config("--set", "report.sigmas=[3, 1, 2.5]", "--set", "report.percent=95", "--set", "report_md_m=[100, 60]")
        header, rows = self.uncertainty(path)
        self.assertEqual(header, ["md_m", "quantity", "sd_m", "sigma2.5_m", "sigma3_m", "p95_m", "azimuth_deg"])
        self.assertEqual(sorted({md for md, _ in rows}), [60, 100, 150])
        north = rows[150, "north"]
        self.assertEqual(north["sigma2.5_m"], 2.5 * north["sd_m"])
        # Quantiles of the normal distribution and of chi-squared with two degrees of freedom, sqrt(-2 ln 0.05), from tables.
        self.assertAlmostEqual(north["p95_m"] / north["sd_m"], 1.959963984540054, delta=1e-12)
        major = rows[150, "semi_major"]
        self.assertAlmostEqual(major["p95_m"] / major["sd_m"], (-2 * np.log(0.05)) ** 0.5, delta=1e-12)
        # At a station the covariance is its own; between stations, linear in measured depth: 100 is a third of 90 .. 120.
        variance = {md: dict(zip(("nn", "ee", "vv", "ne", "nv", "ev"), v)) for md, v in zip(
            (0, 30, 60, 90, 120, 150), np.array([column(path, "tables/covariance", e) for e in ELEMENTS]).T)}
        for i, direction in (("nn", "north"), ("ee", "east"), ("vv", "vertical")):
            self.assertEqual(rows[60, direction]["sd_m"], variance[60][i] ** 0.5)
            self.assertAlmostEqual(rows[100, direction]["sd_m"] ** 2, (2 * variance[90][i] + variance[120][i]) / 3, delta=1e-14)
        total = sum(rows[100, d]["sd_m"] ** 2 for d in ("north", "east", "vertical"))
        self.assertAlmostEqual(sum(rows[100, d]["sd_m"] ** 2 for d in ("high_side", "lateral", "along_hole")), total, delta=1e-13)
        # Along the hole: the tangent turns about the normal of the arc, at the same angle to it; a third of the dogleg.
        def tangent(inclination, azimuth):
            i, a = np.radians([inclination, azimuth])
            return np.array([np.sin(i) * np.cos(a), np.sin(i) * np.sin(a), np.cos(i)])
        t0, t1 = tangent(9, 352), tangent(15, 3)
        axis = np.cross(t0, t1) / np.linalg.norm(np.cross(t0, t1))
        angle = np.arccos(t0 @ t1) / 3
        t = t0 * np.cos(angle) + np.cross(axis, t0) * np.sin(angle)
        c = {k: (2 * variance[90][k] + variance[120][k]) / 3 for k in variance[90]}
        matrix = np.array([[c["nn"], c["ne"], c["nv"]], [c["ne"], c["ee"], c["ev"]], [c["nv"], c["ev"], c["vv"]]])
        self.assertAlmostEqual(rows[100, "along_hole"]["sd_m"] ** 2, t @ matrix @ t, delta=1e-13)

    def test_reports_that_cannot_be(self):
        for bad, says in (("report_md_m=151", r"report_md_m = 151: 151 is outside the survey, which is from 0 to 150 m"),
                          ("report_md_m=[30, 30]", "has a value twice"), ("report_md_m=-1", r"report_md_m = -1: must be"),
                          ("report.sigmas=0", r"report\.sigmas = 0: must be in \(0, 100\]"), ("report.sigmas='2'", "must be a number"),
                          ("report.percent=100", r"report\.percent = 100: must be in \(0, 100\)"), ("report.sigma=2", "sigmas")):
            self.refused(BAD_INPUT, "run", "base.toml", "-o", "bad.h5", "--set", bad, says=says)

    def test_a_depth_written_in_metres_is_that_of_a_station_in_feet(self):
        self.write("well.csv", "md_ft,inclination_deg,azimuth_deg\n0,0,0\n300,0,0\n600,4,40\n1100,9,40\n")
        path = self.run_config("--set", "report_md_m=[182.8804, 335.28]")  # 600 ft to half a mm; 335.28000000000003 m
        depths = column(path, "tables/uncertainty", "md_m")
        self.assertEqual(list(depths[::8]), [600 * 0.3048, 1100 * 0.3048])
        path = self.run_config("--set", "report_md_m=335.2804", output="deeper.h5")
        self.assertEqual(list(column(path, "tables/uncertainty", "md_m")[::8]), [1100 * 0.3048])
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "bad.h5", "--set", "report_md_m=[182.88, 182.8804]",
                     says="report_md_m.*: has a depth twice")
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n0,0,0\n30,0,0\n30.0005,4,40\n60,9,40\n")
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "bad.h5", says=r"well\.csv:4: md_m = 30\.0005: is within 1 mm")

    def test_along_hole_of_a_vertical_well_is_depth(self):
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n0,0,120\n30,0,120\n60,0,120\n")
        path = self.run_config()
        np.testing.assert_allclose(column(path, "tables/covariance", "sd_along_hole_m"),
                                   column(path, "tables/covariance", "sd_vertical_m"), rtol=1e-15)

    def test_no_seed_is_asked_for_where_nothing_is_drawn(self):
        a = self.covariance(output="a.h5")
        self.write("base.toml", CONFIG.replace("seed = 1\n", ""))
        b = self.covariance(output="b.h5")
        np.testing.assert_array_equal(a, b)
        self.call("rerun", "b.h5")
        self.write("base.toml", test_cli.CONFIG.replace("seed = 1\n", ""))
        self.write("survey.csv", test_cli.SURVEY)
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "never.h5", says=r"base\.toml\S*: seed: missing")

    def test_trials_and_seed_change_nothing(self):
        """There is no Monte Carlo, but any config may name them."""
        a = self.covariance()
        b = self.covariance("--seed", 7, "--trials", 100, output="b.h5")
        np.testing.assert_array_equal(a, b)
        self.refused(USAGE, "run", "base.toml", "--trial", 0, says="has no trials")


PLACE = """experiment = "position_covariance"
error_model = "iscwsa_mwd_rev5.10"
[survey]
file = "well.csv"
azimuth_reference = "grid"
[field]
model = "wmm2025"
latitude_deg = -46.0
longitude_deg = -85.0
height_m = 96000.0
date = 2027.5
grid = { crs = "utm" }
"""


class FieldOfAPlace(CovarianceCase):
    def setUp(self):
        super().setUp()
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n0,0,0\n30,2,120\n60,4,121\n")
        self.write("place.toml", PLACE)

    def test_run_gives_the_published_row_and_says_what_was_read(self):
        done = self.call("run", "place.toml", "-o", "place.h5")
        self.assertIn("reference field of wmm2025 at 46 S, 85 W, 96000 m, 2027.50: ", done.stderr)
        self.assertIn("survey well.csv: 3 stations, measured depth 0 to 60 m, inclination up to 4 deg (at 60 m), "
                      "dogleg up to 2 deg/30 m", done.stderr)
        with h5py.File(self.folder / "place.h5") as f:
            elements = dict(zip([q.decode() for q in f["tables/magnetic_elements/quantity"][:]],
                                zip(f["tables/magnetic_elements/value"][:], f["tables/magnetic_elements/per_year"][:])))
            self.assertEqual(f["tables/reference_field/zone"][0].decode(), "none")
        # WMM2025_TEST_VALUES of NOAA NCEI; the printed north component is off by up to 6e-4 nT (tests/earth)
        for name, value, rate, digits in (("east", 6129.590452, -46.615842, 2e-6),
                                          ("down", -21631.434316, 53.698344, 3e-6),
                                          ("north", 18947.658009, -40.865392, 6e-4),
                                          ("total", 29402.458634, -75.558704, 6e-4),
                                          ("declination", 17.93, -0.091418, 5.001e-3),
                                          ("dip", -47.37, -0.005439, 5.001e-3)):
            self.assertAlmostEqual(elements[name][0], value, delta=digits, msg=name)
            self.assertAlmostEqual(elements[name][1], rate, delta=2e-6, msg=name)
        self.call("rerun", "place.h5")

    def test_check_says_it_behind_a_hash_so_that_its_text_is_still_a_config(self):
        done = self.call("check", "place.toml", "--set", "field.date=2026-07-01")
        told = [line for line in done.stdout.splitlines() if line.startswith("# ")]
        self.assertTrue(told[0].startswith("# reference field of wmm2025 at 46 S, 85 W, 96000 m, 2026.50: "), told)
        self.assertTrue(told[1].startswith("# survey well.csv: 3 stations"), told)
        self.write("again.toml", done.stdout)
        self.assertEqual(self.call("check", "again.toml").stdout.splitlines()[-1], done.stdout.splitlines()[-1])

    def test_mistakes_have_place_value_rule_and_way_out(self):
        for setting, said in (("field.date=2030-01-02", "wmm2025 is valid from 2025.0 to 2030.0"),
                              ("field.total_nT=50000", "take one away"),
                              ("field.grid.zone=31", "that of the place is 16")):
            done = self.call("check", "place.toml", "--set", setting, code=65)
            self.assertIn(f"--set {setting}: ", done.stderr)
            self.assertIn(said, done.stderr)

    def test_a_place_on_sweep_axes_is_a_map(self):
        self.write("map.toml", PLACE + '[sweep]\n"field.latitude_deg" = { from = -60, to = 60, step = 20 }\n'
                                       '"field.longitude_deg" = [-90.0, 0.0, 90.0]\n')
        self.call("run", "map.toml", "-o", "map.h5")
        with h5py.File(self.folder / "map.h5") as f:
            self.assertEqual(len(f["tables/reference_field/total_nT"]), 21)
            np.testing.assert_array_equal(f["tables/reference_field/field.latitude_deg"][:3], [-60, -60, -60])


class Reading(CovarianceCase):
    def test_feet_and_azimuth_references(self):
        base = self.covariance()
        rows = [r.split(",") for r in SURVEY.splitlines()[1:]]
        feet = "".join(f"{float(m) / 0.3048!r},{i},{a}\n" for m, i, a in rows)
        self.write("feet.csv", "md_ft,inclination_deg,azimuth_deg\n" + feet)
        np.testing.assert_allclose(self.covariance("--set", "survey.file=feet.csv", output="f.h5"), base, rtol=1e-12,
                                   atol=1e-14)
        # true = magnetic + declination = grid + convergence; 3 deg magnetic is -1 deg true: through north
        for north, minus in (("magnetic", -4), ("grid", 2)):
            turned = "".join(f"{m},{i},{(float(a) - minus) % 360}\n" for m, i, a in rows)
            self.write("turned.csv", "md_m,inclination_deg,azimuth_deg\n" + turned)
            got = self.covariance("--set", "survey.file=turned.csv", "--set", f"survey.azimuth_reference={north}",
                                  output=f"{north}.h5")
            np.testing.assert_allclose(got, base, rtol=1e-12, atol=1e-14)

    def test_listed_tvd_is_used(self):
        listed = "md_m,inclination_deg,azimuth_deg,tvd_m\n" + "".join(
            f"{r},{tvd}\n" for r, tvd in zip(SURVEY.splitlines()[1:], (1000, 1030, 1060, 1090, 1119, 1147)))
        self.write("listed.csv", listed)
        base, deep = self.run_config(), self.run_config("--set", "survey.file=listed.csv", output="l.h5")
        source = column(base, "tables/covariance_by_source", "source")
        a, b = (column(p, "tables/covariance_by_source", "vv_m2") for p in (base, deep))
        self.assertTrue((a[source == "DSTG"][1:] < b[source == "DSTG"][1:]).all())
        np.testing.assert_array_equal(a[source != "DSTG"], b[source != "DSTG"])
        self.write("bad.csv", listed.replace("tvd_m", "tvd"))
        self.refused(BAD_INPUT, "run", "base.toml", "--set", "survey.file=bad.csv",
                     says=r"bad\.csv:1: column tvd: the unit is missing: write tvd_m or tvd_ft")

    def test_toolface_is_not_needed_but_may_be_there(self):
        self.write("toolface.csv", "".join(f"{line},{'toolface_deg' if i == 0 else 13 * i}\n"
                                           for i, line in enumerate(SURVEY.splitlines())))
        np.testing.assert_array_equal(self.covariance("--set", "survey.file=toolface.csv", output="t.h5", ),
                                      self.covariance())
        np.testing.assert_array_equal(self.covariance("--set", "survey.toolface_zero=x", output="x.h5"),
                                      self.covariance())

    def test_through_the_vertical(self):
        """Inclination 0, 1e-9 and 1e-6 deg are the same to that; a vertical well has no azimuth."""
        def well(inclination, azimuth):
            rows = [(30 * k, inclination if k < 4 else 3 * (k - 3), azimuth) for k in range(9)]
            return "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{m},{i},{a}\n" for m, i, a in rows)

        for azimuth in (0, 75):
            results = []
            for inclination in (0, 1e-9, 1e-6):
                self.write("well.csv", well(inclination, azimuth))
                results.append(self.covariance("--set", "error_model=iscwsa_mwd_rev4"))
            trace = results[0][:, :3].sum(axis=1, keepdims=True)
            for got in results[1:]:
                self.assertLess(np.max(np.abs(got - results[0])[1:] / trace[1:]), 2e-7)
        vertical = []
        for azimuth in (0, 75, 200, 359.9):
            self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n" +
                       "".join(f"{20 * k},0,{azimuth}\n" for k in range(9)))
            vertical.append(self.covariance())
            np.testing.assert_allclose(vertical[-1], vertical[0], rtol=1e-13, atol=1e-15)


class Models(CovarianceCase):
    def test_a_copy_of_a_shipped_model_is_that_model(self):
        for name in ("iscwsa_mwd_rev4", "iscwsa_mwd_rev5.10"):
            self.write("models/mine.toml", self.shipped_model(name))
            self.config_with('error_model = "iscwsa_mwd_rev5.10"', '[error_model]\nfile = "models/mine.toml"')
            np.testing.assert_array_equal(self.covariance(config="mine.toml", output="a.h5"),
                                          self.covariance("--set", f"error_model={name}", output="b.h5"))

    def config_with(self, old, new):
        self.assertIn(old, CONFIG)
        # a table goes to the end: what follows it would belong to it
        self.write("mine.toml", CONFIG.replace(old, "") + new + "\n")

    def test_names_work_in_any_folder_and_results_rerun_without_the_files(self):
        self.write("models/mine.toml", self.shipped_model("iscwsa_mwd_rev4").replace("0.35", "0.7"))
        self.config_with('error_model = "iscwsa_mwd_rev5.10"', '[error_model]\nfile = "models/mine.toml"')
        elsewhere = self.folder / "deep/er"
        elsewhere.mkdir(parents=True)
        named = self.run_config(config=self.folder / "base.toml", output=self.folder / "named.h5", cwd=elsewhere)
        filed = self.run_config(config=self.folder / "mine.toml", output=self.folder / "filed.h5", cwd=elsewhere)
        shutil.rmtree(self.folder / "models")
        (self.folder / "well.csv").unlink()
        for path in (named, filed):
            self.assertRegex(self.call("rerun", path, cwd="/").stdout, "^identical")
        with h5py.File(filed) as f:
            self.assertEqual(f["inputs/mine"].attrs["path"], "models/mine.toml")
            text = "\n".join(f["inputs/mine/line"].asstr()[()])
            self.assertIn("magnitude = 0.7", text)
        with h5py.File(named) as f:
            self.assertEqual("\n".join(f["inputs/iscwsa_mwd_rev5.10/line"].asstr()[()]),
                             self.shipped_model("iscwsa_mwd_rev5.10"))

    def test_a_changed_model_file_changes_the_hash_of_the_config(self):
        self.config_with('error_model = "iscwsa_mwd_rev5.10"', '[error_model]\nfile = "mine_model.toml"')
        hashes = set()
        for magnitude in ("0.35", "0.36"):
            self.write("mine_model.toml", self.shipped_model("iscwsa_mwd_rev4").replace("0.35", magnitude))
            hashes.add(self.call("check", "mine.toml").stdout.strip().splitlines()[-1])
        self.assertEqual(len(hashes), 2)

    def test_bad_models_say_the_line(self):
        text = self.shipped_model("iscwsa_mwd_rev5.10")
        lines = text.splitlines()
        row = next(i for i, line in enumerate(lines) if "MBZ" in line)
        self.config_with('error_model = "iscwsa_mwd_rev5.10"', '[error_model]\nfile = "bad.toml"')
        for old, new, says in (
                ('function = "MBZ"', 'function = "MBQ"', 'function = "MBQ": unknown function; did you mean "MBZ"'),
                ('"nT"', '"gauss"', 'unit = "gauss": the unit of MBZ must be "nT", "uT", "deg.nT" or "rad.nT"'),
                ('"nT"', '"deg"', 'unit = "deg": the unit of MBZ must be'),
                ('"S"', '"X"', 'mode = "X": must be one of "R", "S", "W", "G"'),
                ('70.0', '-70.0', "magnitude = -70: must be >= 0"),
                ('70.0', 'nan', "magnitude = nan: must be a finite number"),
                ('code = "MBZ"', 'code = "ABZ"', 'code = "ABZ": two terms have this code'),
                ('unit =', 'units =', "unit"),
                ('mode = "S"', 'mode = "S", note = "x"', "note: unknown key")):
            with self.subTest(new=new):
                self.assertIn(old, lines[row])
                bad = lines[:row] + [lines[row].replace(old, new)] + lines[row + 1:]
                self.write("bad.toml", "\n".join(bad) + "\n")
                message = self.refused(BAD_INPUT, "run", "mine.toml", says=rf"bad\.toml:{row + 1}: ")
                self.assertIn(says, message)
        self.refused(BAD_INPUT, "run", "base.toml", "--set", "error_model=iscwsa", says="unknown error model: did you mean \"iscwsa_mwd_rev4\" or ")
        self.refused(BAD_INPUT, "run", "mine.toml", "--set", "error_model.file=none.toml", says="cannot be read")

    def test_sweep_over_models_and_field(self):
        path = self.run_config("--set", 'sweep.error_model.name=["iscwsa_mwd_rev4", "iscwsa_mwd_rev5.10"]', "--set",
                               "sweep.field.dip_deg=[-60.0, 0.0, 60.0]")
        table = "tables/covariance"
        self.assertEqual(len(column(path, table, "md_m")), 6 * 6)
        self.assertEqual(sorted(set(column(path, table, "error_model.name"))), ["iscwsa_mwd_rev4", "iscwsa_mwd_rev5.10"])
        sd = column(path, table, "sd_east_m").reshape(6, 6)[:, -1]
        self.assertEqual(len(set(sd)), 6)
        self.assertRegex(self.call("rerun", path).stdout, "^identical")
        self.assertEqual(stored_config(path)["survey"]["azimuth_reference"], "true")

    def test_legs(self):
        one = self.covariance()
        legs = CONFIG + "[[leg]]\nfrom_md_m = 60.0\n"
        self.write("legs.toml", legs)
        two = self.covariance(config="legs.toml", output="two.h5")
        np.testing.assert_array_equal(one[:3], two[:3])
        self.assertTrue((one[3:, 2] > two[3:, 2]).all())
        self.write("legs.toml", legs + 'error_model = "iscwsa_mwd_rev4"\n')
        path = self.run_config(config="legs.toml", output="three.h5")
        self.assertEqual(list(np.unique(column(path, "tables/error_terms", "leg"), return_counts=True)[1]), [35, 27])
        self.refused(BAD_INPUT, "run", "legs.toml", "--set", "survey.azimuth_reference=up", says="must be one of")
        self.write("legs.toml", CONFIG + "[[leg]]\nfrom_md_m = 1500.0\n")
        self.refused(BAD_INPUT, "run", "legs.toml", says=r"legs\.toml:\d+: leg\[0\]\.from_md_m = 1500: no station is deeper")


class BetweenVerticalStations(CovarianceCase):
    def test_high_side_is_that_of_the_listed_azimuth(self):
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n0,0,75\n300,0,75\n600,30,75\n1200,30,75\n1500,0,75\n1800,0,75\n")
        path = self.run_config("--set", "report_md_m=[1500, 1650, 1799.99]")
        # The covariance between is linear in measured depth, and so is every variance of a direction that stays.
        of = {(md, q): sd for md, q, sd in zip(*(column(path, "tables/uncertainty", c) for c in ("md_m", "quantity", "sd_m")))}
        self.assertEqual(sorted({md for md, _ in of}), [1500, 1650, 1799.99, 1800])
        for direction in ("high_side", "lateral", "along_hole"):
            ends = of[1500, direction] ** 2, of[1800, direction] ** 2
            self.assertAlmostEqual(of[1650, direction] ** 2 / (sum(ends) / 2), 1, delta=1e-12)
            self.assertAlmostEqual(of[1799.99, direction] / of[1800, direction], 1, delta=1e-4)


class NoCovariance(CovarianceCase):
    """A gyrocompass code has a pole at exactly 90 deg: there is no covariance from there on, and none is not zero."""

    def setUp(self):
        super().setUp()
        self.write("well.csv", "md_m,inclination_deg,azimuth_deg\n0,0,0\n100,0,0\n200,30,45\n300,60,45\n400,90,45\n500,90,45\n")
        self.write("base.toml", CONFIG.replace('"iscwsa_mwd_rev5.10"', '"GYRO-NS"') + "latitude_deg = 60.0\n")

    def test_every_figure_of_it_is_no_number(self):
        path = self.run_config()
        for table, columns in (("covariance", ("nn_m2", "sd_north_m", "sd_east_m", "sd_vertical_m", "sd_high_side_m", "sd_lateral_m",
                                               "sd_along_hole_m", "semi_major_m", "semi_minor_m", "major_azimuth_deg")),
                               ("ellipsoid", ("axis1_m", "axis2_m", "axis3_m", "axis1_azimuth_deg", "axis3_inclination_deg"))):
            for name in columns:
                self.assertEqual(list(np.isnan(column(path, f"tables/{table}", name))), 4 * [False] + 2 * [True], name)
        self.assertTrue(np.isnan(column(path, "tables/uncertainty", "sd_m")).all())


class Published(CovarianceCase):
    ENTRY = '[[published]]\nsource = "me"\ntable = "{}"\nmd_m = {}\nvalues = {{ {} }}\n{}'

    def test_verdicts(self):
        path = self.run_config()
        vv = column(path, "tables/covariance", "vv_m2")[1]
        good = CONFIG + self.ENTRY.format("covariance", 30, f"vv_m2 = {vv!r}, nv_m2 = 0.0", "")
        self.write("good.toml", good)
        self.call("run", "good.toml", "-o", "good.h5", "--check", code=DONE)
        self.write("bad.toml", good.replace(repr(vv), repr(vv * 1.00001)))
        self.call("run", "bad.toml", "-o", "bad.h5", "--check", code=UNEXPECTED)
        self.call("run", "bad.toml", "-o", "bad.h5", "--check", "--set", "verdict.margin=1e-4", code=DONE)
        source = self.ENTRY.format("covariance_by_source", 30, "vv_m2 = 0.1225", 'error_source = "DRFR"\n')
        self.write("source.toml", CONFIG + source)
        self.call("run", "source.toml", "-o", "source.h5", "--check", code=DONE)

    def test_what_cannot_be_compared(self):
        for entry, says in ((("covariance", 31, "vv_m2 = 1.0", ""), "no station at this depth"),
                            (("covariance", 30, "vw_m2 = 1.0", ""), "must be of nn_m2"),
                            (("covariances", 30, "vv_m2 = 1.0", ""), "must be one of"),
                            (("covariance_by_source", 30, "vv_m2 = 1.0", ""), "error_source: missing"),
                            (("covariance_by_source", 30, "vv_m2 = 1.0", 'error_source = "X"\n'), "no model here")):
            self.write("bad.toml", CONFIG + self.ENTRY.format(*entry))
            self.refused(BAD_INPUT, "run", "bad.toml", says=rf"bad\.toml:\d+: .*{says}")


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
