#!/usr/bin/python3
"""Tests of scripts/surveymc on smoke results: test_reader.py SMOKE_FOLDER SURVEYMC"""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import warnings

import h5py
import numpy as np
import pandas

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
sys.path.insert(0, SCRIPTS)
import surveymc  # noqa: E402
from surveymc import NotFound, ResultError  # noqa: E402
from surveymc.result import agreement_share, holm  # noqa: E402

SMOKE = SURVEYMC = ""


def opened(name):
    return surveymc.open(os.path.join(SMOKE, name + ".h5"))


class Reading(unittest.TestCase):
    def test_attributes_are_those_of_the_file(self):
        result = opened("msa_sweep")
        with h5py.File(result.path) as file:
            for name, stored in (("title", "title"), ("experiment", "experiment"), ("seed", "seed"), ("trials", "trials"),
                                 ("version", "surveymc_version"), ("revision", "git_revision"), ("config", "config")):
                self.assertEqual(getattr(result, name), file.attrs[stored])
        self.assertEqual(result.settings["experiment"], "msa_position")
        self.assertGreater(result.run["elapsed_s"], 0)
        self.assertIsInstance(result.seed, int)

    def test_verdicts_are_those_that_surveymc_counts(self):
        for name in ("msa_sweep", "vertical_well", "gross_error_detection", "position_covariance"):
            result, counted = opened(name), {"agrees": 0, "differs": 0, "undecided": 0}
            for table in result.tables.values():
                for verdict in table.get("verdict", []):
                    if verdict:
                        counted[verdict] += 1
            got = result.verdicts
            self.assertEqual(got["agrees"], counted["agrees"])
            self.assertEqual(got["undecided"], counted["undecided"])
            self.assertEqual(got["differs"] + got["finding"], counted["differs"])
            self.assertEqual(got["unexpected"], 0, "smoke configs pass --check")
        self.assertGreater(opened("vertical_well").verdicts["finding"], 0)

    def test_warnings_are_rows_and_told_once(self):
        surveymc.result._told.clear()
        with self.assertWarns(surveymc.ResultWarning) as told:
            result = opened("estimate")
        self.assertEqual(told.filename, __file__)
        rows = [r for r in result.warnings if r["severity"] != "info"]
        self.assertTrue(rows)
        self.assertIn(f"{len(rows)} warnings:", str(told.warning))
        for row in rows:
            self.assertIn(row["message"], str(told.warning))
        with warnings.catch_warnings(record=True) as again:
            warnings.simplefilter("always")
            opened("estimate")
        self.assertEqual(again, [])
        self.assertEqual(surveymc.result.warning_in_words(
            {"severity": "warning", "place": "field.dip_deg", "value": "5", "message": "odd", "way_out": "look", "points": 2, "at": "a = 1"}),
            "warning: field.dip_deg = 5: odd; look (2 points, the first: a = 1)")

    def test_table_has_columns_units_and_intervals(self):
        table = opened("msa_sweep").table("ellipse")
        self.assertIsInstance(table, pandas.DataFrame)
        self.assertEqual(list(table.columns[:3]), ["case", "noise.law", "formulation"])
        self.assertEqual(table.attrs["sweep_keys"], ["case", "noise.law"])
        self.assertEqual(table.attrs["units"]["semi_major_m"], "m")
        self.assertNotIn("formulation", table.attrs["units"])
        self.assertEqual(table.attrs["confidence"], 0.95)
        low, high = table.attrs["intervals"]["ratio_major"]
        known = table.dropna(subset=["ratio_major"])
        self.assertTrue(((known[low] <= known["ratio_major"]) & (known["ratio_major"] <= known[high])).all())

    def test_table_is_what_surveymc_exports(self):
        for name, table in (("msa_sweep", "position"), ("estimate", "tests"), ("reliability_map", "statements")):
            result = opened(name)
            run = subprocess.run([SURVEYMC, "show", result.path, table, "--csv"], capture_output=True, text=True, check=True)
            with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
                file.write(run.stdout)
                file.flush()
                exported = pandas.read_csv(file.name, keep_default_na=False, na_values=["", "nan"], float_precision="round_trip")
            ours = result.table(table)
            self.assertEqual(list(ours.columns), list(exported.columns))
            for column in ours:
                if ours[column].dtype == object:
                    self.assertEqual(list(ours[column]), list(exported[column].fillna("").astype(str)))
                else:
                    np.testing.assert_array_equal(ours[column], exported[column].astype(float))

    def test_mappings_read_what_there_is(self):
        result = opened("sensor_monte_carlo")
        self.assertEqual(set(result.tables), {"answer", "axes", "ellipse", "family", "position_covariance", "warnings"})
        self.assertEqual(len(result.samples["realisations"]), 300)
        self.assertEqual(list(result.inputs["traj4"].columns)[0], "md_m")
        self.assertEqual(len(result.maps), 0)
        self.assertEqual(repr(result.tables), "<answer, axes, ellipse, position_covariance, warnings, family>")

    def test_map_has_coordinates_and_units(self):
        result = opened("reliability_map")
        found = result.map("minimal_detectable_error")
        self.assertEqual(found.dims[-3:], ("inclination", "toolface", "magnetic_azimuth"))
        self.assertEqual(found.attrs["units"], "nT")
        self.assertEqual(found.coords["inclination"].attrs["units"], "deg")
        self.assertEqual(found.coords["observation"].dtype, object)
        with h5py.File(result.path) as file:
            np.testing.assert_array_equal(found.values, file["maps/minimal_detectable_error"][()])
        self.assertTrue(np.isinf(found.values).any())
        self.assertEqual(found.sel(inclination=30, toolface=60, magnetic_azimuth=90).ndim, found.ndim - 3)
        self.assertNotIn("inclination", result.maps)  # a coordinate is no map


class Ellipses(unittest.TestCase):
    def test_outline_is_the_level_line_of_the_covariance_in_the_file(self):
        result = opened("msa_sweep")
        covariances = result.table("position_covariance")
        for formulation in ("monte_carlo", "joint", "random"):
            ellipse = result.ellipse(propagation=formulation, case="reference exact", law="uniform")
            row = covariances[(covariances["formulation"] == formulation) & (covariances["case"] == "reference exact")
                              & (covariances["noise.law"] == "uniform")].iloc[0]
            stored = np.array([[row["nn_m2"], row["ne_m2"]], [row["ne_m2"], row["ee_m2"]]])
            # axes and covariance are stored to 1e-16 of the largest element, the small eigenvalue carries that
            np.testing.assert_allclose(ellipse.covariance, stored, rtol=1e-10, atol=1e-12 * np.trace(stored))
            for k in (1, 2.5):
                north, east = ellipse.outline(k=k, count=91)
                x = np.array([north - ellipse.center_north, east - ellipse.center_east])
                # the thinnest ellipse here has semi axes of 1.06 and 0.025 m: condition 1800, so 1e-9 has room
                np.testing.assert_allclose(np.einsum("in,ij,jn->n", x, np.linalg.inv(ellipse.covariance), x), k**2, rtol=1e-9)
                self.assertAlmostEqual(north[0], north[-1], places=9)

    def test_azimuth_is_clockwise_from_north(self):
        north, east = surveymc.Ellipse(0, 0, 2, 1, 30.0).outline()
        self.assertAlmostEqual(north[0], 2 * np.cos(np.pi / 6))
        self.assertAlmostEqual(east[0], 2 * np.sin(np.pi / 6))

    def test_sweep_point_by_keyword_by_key_and_by_station(self):
        result = opened("msa_sweep")
        a = result.ellipse(propagation="joint", case="reference exact", noise_law="gaussian")
        b = result.ellipse(at={"case": "reference exact", "noise.law": "gaussian", "formulation": "joint"})
        self.assertEqual(a, b)
        self.assertEqual(a.row["verdict"], b.row["verdict"])
        covariance = opened("position_covariance")
        table = covariance.table("covariance")
        station = covariance.ellipse(table="covariance", case=table["case"][5], md_m=table["md_m"][5])
        self.assertEqual(station.semi_major, table["semi_major_m"][5])

    def test_what_is_not_one_row_says_what_there_is(self):
        result = opened("msa_sweep")
        for point, words in (({}, ("6 rows", "case: reference exact", "noise.law: gaussian")),
                             ({"case": "reference exakt"}, ("did you mean 'reference exact'",)),
                             ({"propagation": "jiont"}, ("did you mean 'joint'", "systematic")),
                             ({"colour": 1}, ("no column 'colour'", "noise.law"))):
            with self.assertRaises(NotFound) as raised:
                result.ellipse(**point)
            for word in words:
                self.assertIn(word, str(raised.exception))
        with self.assertRaisesRegex(ResultError, "has no ellipses: no column major_azimuth_deg"):
            result.ellipse(table="position")


class Refusals(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_names_that_are_not_there(self):
        result = opened("reliability_map")
        for read, word in ((lambda: result.table("summery"), "did you mean 'summary'"),
                           (lambda: result.table("SUMMARY"), "did you mean 'summary'"),
                           (lambda: result.map("minimal_error"), "redundancy_number"),
                           (lambda: result.map("inclination"), "no map 'inclination'"),
                           (lambda: result.samples["x"], "there are: none")):
            with self.assertRaises(NotFound) as raised:
                read()
            self.assertIn(word, str(raised.exception))
            self.assertIn(result.path, str(raised.exception))
            self.assertIsInstance(raised.exception, KeyError)

    def test_files_that_are_no_results(self):
        text = os.path.join(self.folder, "text.h5")
        with open(text, "w", encoding="utf-8") as file:
            file.write("md_m,inclination_deg\n")
        other = os.path.join(self.folder, "other.h5")
        with h5py.File(other, "w") as file:
            file["x"] = [1, 2]
        newer = os.path.join(self.folder, "newer.h5")
        shutil.copy(opened("msa_sweep").path, newer)
        with h5py.File(newer, "a") as file:
            file.attrs["format_version"] = 99
        for path, word in ((text, "not an HDF5 file"), (other, "not a result file of surveymc"), (self.folder, "is a folder"),
                           (os.path.join(self.folder, "no.h5"), "no such file"), (newer, "format version 99")):
            with self.assertRaisesRegex(ResultError, word):
                surveymc.open(path)


class Elsewhere(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_pip_installs_it_without_network(self):
        if subprocess.run([sys.executable, "-c", "import setuptools, wheel, pip"], capture_output=True).returncode:
            self.skipTest("python3-pip, python3-setuptools or python3-wheel is not installed")
        source, target = os.path.join(self.folder, "source"), os.path.join(self.folder, "target")
        shutil.copytree(SCRIPTS, source, ignore=shutil.ignore_patterns("build", "__pycache__", "*.egg-info"))
        run = subprocess.run([sys.executable, "-m", "pip", "install", "--no-build-isolation", "--no-deps", "--no-index",
                              "--quiet", "--target", target, source], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        code = (f"import surveymc; r = surveymc.open({opened('vertical_well').path!r}); print(surveymc.__file__, len(r.tables));"
                "print(surveymc.plot(r))")
        environment = {**os.environ, "PYTHONPATH": target}
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=self.folder, env=environment)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn(target, run.stdout)
        self.assertIn("vertical_well_ratio.png", run.stdout)
        for command, argument, word in (("import", "--help", "WITSML"), ("report", "--help", "report"), ("plot", "--help", "figures")):
            run = subprocess.run([sys.executable, "-m", "surveymc", command, argument], cwd=self.folder, capture_output=True, text=True, env=environment)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertIn(word, run.stdout)

    def test_octave_reads_what_python_reads(self):
        if not shutil.which("octave"):
            self.skipTest("octave is not installed")
        result = opened("msa_sweep")
        table = os.path.join(self.folder, "ellipse.csv")
        with open(table, "w", encoding="utf-8") as file:
            subprocess.run([SURVEYMC, "show", result.path, "ellipse", "--csv"], stdout=file, check=True)
        # docs/python.md, the snippet for MATLAB and Octave
        code = f"""addpath("{SCRIPTS}/surveymc");
            e = surveymc_table("{table}");
            k = find(strcmp(e.formulation, "joint") & strcmp(e.("case"), "reference exact") & strcmp(e.noise_law, "gaussian"));
            a = e.major_azimuth_deg(k) * pi / 180;  t = linspace(0, 2 * pi, 361);
            north = e.center_north_m(k) + e.semi_major_m(k) * cos(t) * cos(a) - e.semi_minor_m(k) * sin(t) * sin(a);
            east = e.center_east_m(k) + e.semi_major_m(k) * cos(t) * sin(a) + e.semi_minor_m(k) * sin(t) * cos(a);
            printf("%.12f %.12f\\n", [north; east]);"""
        run = subprocess.run(["octave", "--no-gui", "--norc", "-q", "--eval", code], capture_output=True, text=True, timeout=60)
        ours = result.ellipse(propagation="joint", case="reference exact", law="gaussian").outline()
        got = np.array([line.split() for line in run.stdout.split("\n") if line], float)
        self.assertEqual(got.shape, (361, 2), run.stderr)
        np.testing.assert_allclose(got, np.transpose(ours), atol=1e-9)  # metres; printed to 1e-12


class Family(unittest.TestCase):
    def test_the_procedures_give_what_the_table_of_cases_says(self):
        """The program is held to the same table: tests/compare/test_family.cpp."""
        path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../compare/family_cases.csv")
        with open(path) as file:
            cases = [line.rstrip("\n").split(",") for line in file][1:]
        for procedure, level, p, expected in cases:
            p, expected = [float(x) for x in p.split()], [float(x) for x in expected.split()]
            with self.subTest(procedure=procedure, p=p):
                if procedure == "holm":
                    self.assertEqual([float(r) for r in holm(p, float(level))], expected)
                else:
                    self.assertAlmostEqual(agreement_share(p, float(level)), expected[0], delta=1e-12)
        self.assertEqual(len(cases), 11)


if __name__ == "__main__":
    SURVEYMC = os.path.abspath(sys.argv.pop())
    SMOKE = os.path.abspath(sys.argv.pop())
    unittest.main()
