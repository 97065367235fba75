#!/usr/bin/python3
"""End-to-end tests of the experiment `estimate`: test_estimate.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]

Readings come from a forward model of their own, so that the program is held against something else than itself.
"""
import re
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, USAGE, Case, column, content_hash

GRAVITY, TOTAL, DIP, DECLINATION, CONVERGENCE = 9.81, 50000.0, 66.0, 4.0, -1.5
GAIN, BIAS = np.array([1.004, 0.991, 1.012]), np.array([120.0, -260.0, 410.0])
HEADER = "md_m,gx_mps2,gy_mps2,gz_mps2,bx_nT,by_nT,bz_nT"
PARAMETERS = ["gain_x", "gain_y", "gain_z", "bias_x_nT", "bias_y_nT", "bias_z_nT"]

CONFIG = f"""\
experiment = "estimate"
seed = 1
readings = "run.csv"
estimator = "msa"
[field]
total_nT = {TOTAL}
dip_deg = {DIP}
declination_deg = {DECLINATION}
convergence_deg = {CONVERGENCE}
gravity_mps2 = {GRAVITY}
[noise]
magnetometer_nT = 50.0
reference = {{ per = "run", total_nT = 107.0, dip_deg = 0.16 }}
"""


def attitudes(count=16):
    """Inclination, true azimuth, toolface (from y) in degrees: a build with a turn, the tool well rotated."""
    k = np.arange(count)
    return 12 + 3.1 * k, 20 + 5 * k, (77 * k + 13) % 360


def true_readings(inclination, azimuth, toolface):
    """Gravity (pointing down) and field in the tool frame: rotations about z, y, z, not the program's formulas."""
    rows = []
    dip = np.radians(DIP)
    field_n = TOTAL * np.array([np.cos(dip), 0, np.sin(dip)])  # magnetic north, east, down
    for i, a, t in zip(np.radians(inclination), np.radians(azimuth - DECLINATION), np.radians(toolface)):
        along = np.array([np.sin(i) * np.cos(a), np.sin(i) * np.sin(a), np.cos(i)])
        high = np.array([np.cos(i) * np.cos(a), np.cos(i) * np.sin(a), -np.sin(i)])
        right = np.array([-np.sin(a), np.cos(a), 0])
        # Toolface from y: y points to the high side at 0, x to it at 90.
        y = np.cos(t) * high + np.sin(t) * right
        x = np.cross(y, along)
        rows.append((np.array([v @ np.array([0, 0, GRAVITY]) for v in (x, y, along)]),
                     np.array([v @ field_n for v in (x, y, along)])))
    return np.array([g for g, _ in rows]), np.array([b for _, b in rows])


def run_of(inclination, azimuth, toolface, noise=0.0, seed=1):
    """Columns of a file: md, g, m with the tool's gains and biases."""
    g, b = true_readings(inclination, azimuth, toolface)
    m = GAIN * b + BIAS + np.random.default_rng(seed).normal(0, 1, b.shape) * noise
    return np.column_stack([1000 + 30 * np.arange(len(g)), g, m])


def csv_text(rows, header=HEADER):
    return header + "\n" + "".join(",".join(repr(float(x)) for x in row) + "\n" for row in rows)


class Estimate(Case):
    def setUp(self):
        super().setUp()
        self.rows = run_of(*attitudes())
        self.write("run.csv", csv_text(self.rows))
        self.write("base.toml", CONFIG)
        self.write("weighted.toml", CONFIG.replace('estimator = "msa"\n', "") + '[estimator]\nname = "msa_weighted"\n')

    def estimates(self, path):
        return column(path, "tables/parameters", "estimate")

    def warnings(self, path):
        return list(zip(column(path, "tables/warnings", "severity"), column(path, "tables/warnings", "message")))

    # ---- answers

    def test_noise_free_readings_give_the_tool_and_the_survey_back(self):
        path = self.run_config()
        self.assertEqual(list(column(path, "tables/parameters", "quantity")), PARAMETERS)
        # Readings of 5e4 nT are rounded to 7e-12; the weakest combination (gain_z, bias_z) magnifies that some 1e3 times.
        off = self.estimates(path) - np.concatenate([GAIN, BIAS])
        self.assertLess(np.abs(off[:3]).max(), 1e-9)
        self.assertLess(np.abs(off[3:]).max(), 1e-6)
        inclination, azimuth, toolface = attitudes()
        station = lambda name: column(path, "tables/stations", name)
        np.testing.assert_allclose(station("inclination_deg"), inclination, atol=1e-9)
        np.testing.assert_allclose(station("toolface_deg"), toolface, atol=1e-9)
        np.testing.assert_allclose(station("azimuth_true_deg"), azimuth, atol=1e-7)
        np.testing.assert_allclose(station("azimuth_magnetic_deg"), azimuth - DECLINATION, atol=1e-7)
        np.testing.assert_allclose(station("azimuth_grid_deg"), azimuth - CONVERGENCE, atol=1e-7)
        np.testing.assert_allclose(station("raw_azimuth_true_deg") + station("azimuth_change_deg"), azimuth, atol=1e-7)
        self.assertGreater(np.abs(station("azimuth_change_deg")).max(), 0.1)
        self.assertLess(np.abs(station("total_field_residual_nT")).max(), 1e-5)
        self.assertEqual(station("md_m")[-1], 1450)
        # Positions: minimum curvature with a finely divided arc is beyond this test; a leg's length bounds the chord.
        step = np.diff(np.column_stack([station("north_m"), station("east_m"), station("vertical_m")]), axis=0)
        lengths = np.linalg.norm(step, axis=1)
        self.assertTrue(np.all(lengths < 30) and np.all(lengths > 29.9))
        with h5py.File(path) as f:
            for group in f["tables"].values():
                for name, d in group.items():
                    self.assertFalse(d.dtype.kind == "f" and np.any(np.isinf(d[()])), name)
        self.assertLess(column(path, "tables/fit", "s0")[0], 1e-6)

    def test_names_that_scripts_rely_on(self):
        path = self.run_config()
        header, rows = self.table_csv(path, "parameters")
        self.assertEqual(header[:5], ["quantity", "estimate", "sd", "ci_low", "ci_high"])
        self.assertEqual([r[0] for r in rows], PARAMETERS)
        with h5py.File(path) as f:
            self.assertLessEqual({"parameters", "stations", "tests", "warnings", "observability"}, set(f["tables"]))
            self.assertEqual(list(f["inputs"].values())[0].attrs["path"], "run.csv")
            self.assertEqual(list(f["inputs"].values())[0]["bx_nT"].attrs["units"], "nT")

    def test_interval_is_a_normal_one(self):
        path = self.run_config("--set", "confidence=0.9")
        p = lambda name: column(path, "tables/parameters", name)
        np.testing.assert_allclose(p("ci_high") - p("estimate"), 1.6448536269514722 * p("sd"), rtol=1e-9)
        np.testing.assert_allclose(p("estimate") - p("ci_low"), p("ci_high") - p("estimate"), rtol=1e-6)
        np.testing.assert_allclose(p("sd") ** 2, p("sd_noise") ** 2 + p("sd_reference") ** 2, rtol=1e-9)
        np.testing.assert_array_equal(p("sd_prior"), 0)

    def test_cost_is_the_sum_of_the_squared_residuals(self):
        """Of every estimator, whatever it weighs and whatever priors it has."""
        self.write("run.csv", csv_text(run_of(*attitudes(), noise=50)))
        for name in ["msa", "msa_weighted", "msa_joint", "wls_consider"]:
            with self.subTest(estimator=name):
                path = self.run_config("--set", f"estimator.name={name}", "--set", "noise.accelerometer_mps2=0.003",
                                       *(() if name == "msa" else ("--set", "estimator.prior={gain=0.01, bias_nT=300}")),
                                       config="weighted.toml", output=f"{name}.h5")
                of = lambda table, what: column(path, f"tables/{table}", what)
                total, dip = TOTAL, np.radians(DIP)
                if name == "msa_joint":
                    total, dip = of("reference", "estimate")[0], np.radians(of("reference", "estimate")[1])
                # The stations' residuals are less the given reference.
                h = of("stations", "horizontal_residual_nT") + TOTAL * np.cos(np.radians(DIP)) - total * np.cos(dip)
                v = of("stations", "vertical_residual_nT") + TOTAL * np.sin(np.radians(DIP)) - total * np.sin(dip)
                np.testing.assert_allclose(of("fit", "cost_nT2")[0], np.sum(h * h + v * v), rtol=1e-8)
                np.testing.assert_allclose(of("fit", "residual_sd_nT")[0],
                                           np.sqrt(of("fit", "cost_nT2")[0] / of("fit", "redundancy")[0]), rtol=1e-12)
                p = lambda what: of("parameters", what)
                np.testing.assert_allclose(p("sd") ** 2, p("sd_noise") ** 2 + p("sd_reference") ** 2 + p("sd_prior") ** 2,
                                           rtol=1e-9)
                self.assertEqual(name != "msa", bool(np.all(p("sd_prior") > 0)))

    def test_units_signs_and_order_of_columns_do_not_matter(self):
        rows = run_of(*attitudes(), noise=50)
        self.write("run.csv", csv_text(rows))
        plain = self.run_config()
        other = np.column_stack([rows[:, 6] / 1000, rows[:, 4] / 1000, rows[:, 5] / 1000, rows[:, 0] / 0.3048,
                                 -rows[:, 1:4] / 9.80665e-3])
        self.write("other.csv", csv_text(other, "bz_uT,bx_uT,by_uT,md_ft,gx_mg,gy_mg,gz_mg"))
        turned = self.run_config("--set", "readings=other.csv", "--set", "accelerometers=specific_force", output="b.h5")
        for table, name in [("parameters", "estimate"), ("parameters", "sd"), ("stations", "azimuth_true_deg"),
                            ("stations", "nn_m2"), ("stations", "md_m"), ("fit", "chi_squared")]:
            np.testing.assert_allclose(column(turned, f"tables/{table}", name), column(plain, f"tables/{table}", name),
                                       rtol=1e-8, err_msg=name)

    def test_every_solver_has_the_same_answer(self):
        self.write("run.csv", csv_text(run_of(*attitudes(), noise=50)))
        path = self.run_config("--set", 'sweep.estimator.solver=["gauss_newton", "nlopt_neldermead", "nlopt_lbfgs"]')
        found = self.estimates(path).reshape(3, 6)
        for other in found[1:]:
            self.assertLess(np.abs(other - found[0])[:3].max(), 1e-6)
            self.assertLess(np.abs(other - found[0])[3:].max(), 1e-6 * TOTAL)

    def test_gross_error_is_pointed_at(self):
        rows = run_of(*attitudes(), noise=50)
        rows[9, 6] += 900
        self.write("run.csv", csv_text(rows))
        done = self.call("run", "base.toml", "-o", "out.h5")
        self.assertRegex(done.stdout, r"(?m)^warning: station 10 \(md 1270 m\) is suspect")
        self.assertRegex(done.stdout, r"\ARead the severe warnings first \(\d\)")
        self.assertRegex(done.stdout, r"(?m)^The reading b\w at 1270 m is most likely wrong, by ")
        self.assertRegex(done.stdout, r"(?m)^severe: variance factor ")
        path = self.folder / "out.h5"
        decision = np.array(column(path, "tables/tests", "decision"))
        w = np.abs(column(path, "tables/tests", "statistic"))
        residual = np.array(column(path, "tables/tests", "test")) == "residual"
        np.testing.assert_array_equal(decision[residual] == "rejected", w[residual] > 3.290526731491894)
        self.assertEqual(column(path, "tables/tests", "station")[residual][np.argmax(w[residual])], 10)

    def test_no_reading_is_blamed_where_all_are_worse_than_claimed(self):
        self.write("run.csv", csv_text(run_of(*attitudes(), noise=300)))
        said = self.call("run", "base.toml", "-o", "out.h5").stdout
        self.assertRegex(said, r"(?m)^Readings and reference do not fit together, and no single reading explains it\.")
        self.assertNotIn("most likely wrong", said)

    def test_error_of_an_accelerometer_has_the_sign_of_the_file(self):
        """A user subtracts the reported error from the file."""
        for sign, name in [(1, "gravity"), (-1, "specific_force")]:
            with self.subTest(accelerometers=name):
                rows = run_of(*attitudes(), noise=50)
                rows[:, 1:4] *= sign
                rows[9, 1] += 0.3
                self.write("run.csv", csv_text(rows))
                path = self.run_config("--set", f"accelerometers={name}", "--set", "noise.accelerometer_mps2=0.003")
                reading = list(column(path, "tables/suspect_readings", "reading"))
                of = lambda what: column(path, "tables/suspect_readings", what)[reading.index("gx")]
                self.assertLess(abs(of("error") - 0.3), 5 * of("sd_error"))
                self.assertGreater(of("w"), 3.3)
                said = [m for _, m in self.warnings(path) if "is suspect" in m][0]
                first = column(path, "tables/suspect_readings", "w")[0]
                self.assertIn(f"most likely reading {reading[0]} (w {first:.2f}, ", said)

    def test_warnings_are_the_last_words(self):
        self.write("run.csv", csv_text(self.rows[[0, 7, 15]]))
        done = self.call("run", "base.toml", "-o", "out.h5")
        last = done.stdout.strip().splitlines()[-4:]
        self.assertRegex(last[-1], r"^wrote out.h5 \(in ")
        self.assertIn("severe: 3 stations give 6 residuals for 6 unknowns", done.stdout)
        self.assertNotRegex(done.stdout, r"(?i)\bnan\b|\binf\b")
        self.assertNotIn("verdicts:", done.stdout)
        self.assertIn(("severe", "3 stations give 6 residuals for 6 unknowns: nothing checks the estimate, and no gross "
                       "error would show"), self.warnings(self.folder / "out.h5"))

    def test_quiet_keeps_the_warnings(self):
        """On stderr, as stdout is closed; nothing that only informs."""
        self.write("run.csv", csv_text(self.rows[[0, 7, 15]]))
        done = self.call("run", "base.toml", "--trials", "7", "-o", "out.h5", "--quiet")
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, r"(?m)^\d\d:\d\d:\d\d severe: 3 stations give 6 residuals for 6 unknowns")
        warnings = self.warnings(self.folder / "out.h5")
        self.assertIn("info", [severity for severity, _ in warnings])
        self.assertEqual(len(done.stderr.splitlines()), sum(severity != "info" for severity, _ in warnings))

    def test_one_or_two_stations_where_no_more_are_needed(self):
        """What solves every station by itself gives each the same answer alone; the chained smoother of the first stations
        is the filter of the whole run there, which knows nothing of later ones."""
        sigma = "[sigma]\naccelerometer_xy_mps2 = 0.004\ngravity_mps2 = 0.001\nmagnetometer_xy_nT = 70.0\n" \
                "horizontal_nT = 90.0\nvertical_nT = 90.0\naxial_magnetisation_nT = 500.0\n"
        alone = CONFIG[:CONFIG.index("[noise]")].replace('estimator = "msa"\n', "")
        self.write("alone.toml", alone + sigma)
        self.write("chained.toml", alone + "[model]\noffset_stations = 16\n[estimator]\nname = \"chained\"\n")
        rows = run_of(*attitudes(), noise=50)
        for name, config, whole in [("single_station", "alone.toml", ()), ("axial_correction", "alone.toml", ()),
                                    ("chained", "chained.toml", ("--set", "estimator.mode=filter"))]:
            setting = ("--set", f"estimator.name={name}")
            self.write("run.csv", csv_text(rows))
            full = self.run_config(*setting, *whole, config=config)
            full.rename(self.folder / "full.h5")
            for count in (1, 2):
                self.write("run.csv", csv_text(rows[:count]))
                few = self.run_config(*setting, config=config)
                # Of the stations before, a filter keeps a linearisation: some thousandths of a sd.
                near = 1e-3 if name == "chained" and count > 1 else 1e-6
                for what in ["inclination_deg", "azimuth_true_deg", "toolface_deg", "sd_inclination_deg", "sd_azimuth_deg"]:
                    with self.subTest(estimator=name, stations=count, column=what):
                        found = column(few, "tables/stations", what)
                        self.assertEqual(len(found), count)
                        self.assertAlmostEqual(found[-1], column(self.folder / "full.h5", "tables/stations", what)[count - 1],
                                               delta=near)
        self.write("run.csv", csv_text(rows[:2]))  # which the others refuse
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "x.h5", says="three gains and three biases need at least 3 stations")

    def test_run_without_rotation(self):
        inclination, azimuth, toolface = attitudes()
        self.write("run.csv", csv_text(run_of(inclination, azimuth, 0 * toolface + 30, noise=50)))
        path = self.run_config()
        self.assertTrue(any("poor rotation" in m for _, m in self.warnings(path)))
        self.write("run.csv", csv_text(run_of(0 * inclination + 40, 0 * azimuth + 70, 0 * toolface + 30)))
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "x.h5", says=r"base\.toml:3: readings = \"run\.csv\": the stations cannot determine")

    def test_accelerometers_the_other_way_round(self):
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "x.h5", "--set", "accelerometers=specific_force",
                     says="do the accelerometers read the other way round")

    def test_rerun_needs_nothing_but_the_file(self):
        absolute = self.write("far/away.csv", csv_text(self.rows))
        for readings in ["run.csv", str(absolute)]:
            path = self.run_config("--set", f"readings={readings}", output="a.h5")
            moved = self.folder / "moved.h5"
            path.rename(moved)
            Path(self.folder / readings).unlink()
            self.assertRegex(self.call("rerun", moved).stdout, f"^identical: {content_hash(moved)}")
            moved.unlink()

    # ---- bad input

    def refuse_csv(self, text, says):
        self.write("run.csv", text)
        self.refused(BAD_INPUT, "check", "base.toml", says=says)
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "x.h5", says=says)

    def test_bad_files(self):
        good = csv_text(self.rows)
        row = good.splitlines()[1]
        for text, says in [
                (good.replace("gx_mps2", "gx mps2"), r"run\.csv:1: column gx mps2: .*write gx_mps2 or gx_mg"),
                (good.replace("gx_mps2", "gx"), r"run\.csv:1: column gx: the unit is missing"),
                (good.replace("gx_mps2", "gx_g"), r"run\.csv:1: column gx_g: unknown unit"),
                (good.replace("gx_mps2", "gx_mg"), r"run\.csv:1: column gy_mps2|run\.csv:1: column gx_mg"),
                (good.replace("bz_nT", "bz_mT"), r"run\.csv:1: column bz_mT: unknown unit: write bz_nT or bz_uT"),
                (good.replace("md_m", "depth_m"), r"run\.csv:1: column depth_m: unknown column"),
                (good.replace(row, row.replace("1000.0", "abc", 1)), r"run\.csv:2: md_m = \"abc\": must be a number"),
                (good.replace(row, row.replace("1000.0", "nan", 1)), r"run\.csv:2: md_m = \"nan\": must be a finite"),
                (good.replace(row, row.replace("1000.0", "5000", 1)), r"run\.csv:3: md_m = 1030: must be greater"),
                (good.replace(row, row + ",1"), r"run\.csv:2: 8 cells: must have 7"),
                (good.replace(row, row.replace(",", ";")), r"run\.csv:2: "),
                ("", r"run\.csv: is empty"),
                (HEADER + "\n", r"run\.csv: has no rows"),
                (csv_text(self.rows[:2]), r"run\.csv: 2 stations: three gains and three biases need at least 3"),
                (csv_text(np.delete(self.rows, 3, 1), HEADER.replace("gz_mps2,", "")), r"column gz_mps2 or gz_mg: missing"),
                (csv_text(self.rows[:, [0, 4, 5, 6, 1, 2, 3]]), r"run\.csv:2: gx_mps2, gy_mps2, gz_mps2: .*columns in place"),
                (csv_text(np.column_stack([self.rows[:, :4], self.rows[:, 4:] / 1000])),
                 r"run\.csv:2: bx_nT, by_nT, bz_nT: .*is the unit right"),
                (csv_text(np.column_stack([self.rows[:, 0], self.rows[:, 1:4] * 100, self.rows[:, 4:]])),
                 r"run\.csv:2: gx_mps2, gy_mps2, gz_mps2: .*is the unit right")]:
            with self.subTest(says=says):
                self.refuse_csv(text, says)

    def test_another_axis_down_hole_is_warned_of(self):
        rows = run_of(*attitudes())
        for order, name in (((2, 0, 1), "x"), ((1, 2, 0), "y")):
            axes = [0, *(1 + k for k in order), *(4 + k for k in order)]
            self.write("run.csv", csv_text(rows[:, axes]))
            said = self.call("check", "base.toml").stdout
            self.assertRegex(said, rf"their z axis turns by .* deg .*no tool drills more than 30 deg/30 m; the {name} axis turns as a hole does")
        self.write("run.csv", csv_text(rows))
        self.assertNotIn("axis turns", self.call("check", "base.toml").stdout)

    def test_swapped_axes_do_not_pass_silently(self):
        """y and z of the magnetometers swapped: the total field is right, and nothing else."""
        self.write("run.csv", csv_text(self.rows[:, [0, 1, 2, 3, 4, 6, 5]]))
        done = self.call("run", "base.toml", "-o", "out.h5", code=(0, BAD_INPUT))
        self.assertRegex(done.stdout + done.stderr, "(?m)^severe: |finds no minimum")

    def test_variance_components_take_the_place_of_given_sizes(self):
        """What was given scales out: the same sizes are found from others, and with them s0 is 1."""
        config = str(test_cli.SOURCE / "configs" / "examples" / "instrument.toml")
        found = []
        for given in (50, 1000):
            out = f"out_{given}.h5"
            self.call("run", config, "-o", out, "--set", "estimator.variance_components=true", "--set", f"residual_sd.field_nT={given}")
            redundancy = column(self.folder / out, "tables/variance_components", "redundancy")
            self.assertAlmostEqual(sum(redundancy), 3 * 24 - 22, delta=0.01)  # 21 parameters, and the dip
            found.append(column(self.folder / out, "tables/variance_components", "sd"))
            sets = zip(*(column(self.folder / out, "tables/sets", name) for name in ("set", "loss", "s0")))
            s0 = [x for name, loss, x in sets if (name, loss) == ("21", "least_squares")]
            self.assertAlmostEqual(s0[0], 1, delta=0.01)
        np.testing.assert_allclose(found[0], found[1], rtol=2e-3)

    def test_names_that_are_offered_are_accepted(self):
        said = self.refused(BAD_INPUT, "check", "base.toml", "--set", "estimator=nobody", says="must be one of")
        offered = re.findall(r'"(\w+)"', said.split("must be one of")[1])
        self.assertEqual(offered, ["msa", "msa_weighted", "msa_joint", "wls_consider", "single_station", "axial_correction",
                                   "chained", "multistation"])
        listed = self.call("keys", "estimate", "--csv").stdout
        rule = next(line for line in listed.splitlines() if line.startswith("estimator.name")).replace('""', '"')
        for name in offered:
            self.assertIn(f'"{name}"', rule)
        self.assertNotIn('"wls"', rule)

    def test_bad_keys(self):
        for setting, says in [("noise.magnetometer_nT=0", r"noise\.magnetometer_nT.*must be > 0"),
                              ("noise.law=uniform", r"noise\.law.*must be \"gaussian\""),
                              ("accelerometers=up", r"accelerometers.*must be"),
                              ("estimator=nobody", r"estimator.*must be"),
                              ("confidence=95", r"confidence = 95: must be in \(0, 1\)"),
                              ("tests.alpha=0", r"tests\.alpha = 0"),
                              ("tests.alpha_w=2", r"tests\.alpha_w = 2"),
                              ("readings=none.csv", r"readings.*cannot be read"),
                              ("sensor.gain=[1,1,1]", r"sensor"),
                              ("survey.file=run.csv", r"survey")]:
            with self.subTest(setting=setting):
                self.refused(BAD_INPUT, "run", "base.toml", "-o", "x.h5", "--set", setting, says=says)

    def test_there_are_no_trials(self):
        self.refused(USAGE, "run", "base.toml", "--trial", "0", says="has no trials")
        path = self.run_config("--trials", "7")
        self.assertIn(("info", "the config's trials are not used: there is one run of readings"), self.warnings(path))


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    test_cli.EXECUTABLE = str(Path(sys.argv[1]).resolve())
    test_cli.SOURCE = Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
