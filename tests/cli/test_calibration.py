#!/usr/bin/python3
"""End-to-end tests of calibration, stops by verdict, families and cost: test_calibration.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import json
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import numpy as np

import test_cli
from test_cli import BAD_INPUT, UNEXPECTED, USAGE, Case, column, content_hash

CONFIG = """\
experiment = "msa_position"
seed = 1
trials = 3000
control_variate = false
estimator = "msa_joint"
[survey]
file = "survey.csv"
toolface_zero = "y"
[field]
total_nT = 50000.0
dip_deg = 60.0
[sensor.spread]
gain = 0.001
bias_nT = 50.0
[noise]
magnetometer_nT = 50.0
reference = { per = "run", total_nT = 100.0, dip_deg = 0.15 }
[calibration]
margin = 0.05
"""
SURVEY = "md_m,inclination_deg,azimuth_deg,toolface_deg\n" + "".join(
    f"{30 * k},{5 + 3 * k},{40 + 4 * k},{137.5 * k % 360}\n" for k in range(20))
STOP = '[stop]\nverdict = ["parameters.sigma3_gain_z.claimed"]\nmax_trials = 40000\n[verdict]\nmargin = 0.03\n'


class CalibrationCase(Case):
    def setUp(self):
        super().setUp()
        self.write("survey.csv", SURVEY)
        self.write("base.toml", CONFIG)
        self.write("stop.toml", CONFIG.replace("trials = 3000\n", "") + STOP)


class Calibration(CalibrationCase):
    def test_pairs_are_told_as_trials(self):
        path = self.run_config("--trials", 1600, "--set", "antithetic=true")
        self.assertEqual(set(column(path, "tables/calibration", "verdict")), {"undecided"})
        for note in column(path, "tables/calibration", "note"):
            self.assertIn("at least 2000 trials (1000 pairs) are needed", note)
        self.assertGreaterEqual(min(column(path, "tables/calibration", "trials_to_decide")), 2000)

    def test_tables_hang_together(self):
        path = self.run_config()
        quantity = list(column(path, "tables/calibration", "quantity"))
        self.assertEqual(quantity, ["gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z", "reference_total", "reference_dip",
                                    "nees", "azimuth_first", "azimuth_middle", "azimuth_last", "north", "east", "vertical", "major_axis", "minor_axis"])
        share, upto = (column(path, "tables/pit", c).reshape(len(quantity), 100) for c in ("share", "upto"))
        self.assertTrue((np.diff(share, axis=1) >= 0).all() and (share[:, -1] == 1).all())
        d = (share - upto)[:, :-1]
        largest = np.take_along_axis(d, np.abs(d).argmax(axis=1)[:, None], axis=1)[:, 0]
        np.testing.assert_allclose(column(path, "tables/calibration", "deviation"), largest, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(column(path, "tables/calibration", "trials"), 3000)
        coverage = column(path, "tables/coverage", "share").reshape(-1, 5)
        self.assertTrue((np.diff(coverage, axis=1) >= 0).all())
        np.testing.assert_allclose(coverage[:, 0], share[:, 74] - share[:, 24], rtol=0, atol=1e-12)
        np.testing.assert_allclose(coverage[:, 4], share[:, 98] - share[:, 0], rtol=0, atol=1e-12)
        # Of another seed: the same rows, whatever shapes they have, and no largest deviation taken for a normal value.
        said = json.loads(self.call("diff", path, self.run_config("--seed", 2, output="other.h5"), "--json", code=(0, UNEXPECTED)).stdout)
        said = {c["name"]: c["values"] for c in said["columns"]}
        self.assertNotIn("only in A", said["finding"])
        self.assertNotIn("deviation", said["column"])
        # Estimates are the same without.
        self.write("plain.toml", CONFIG[:CONFIG.index("[calibration]")])
        plain = self.run_config(config="plain.toml", output="plain.h5")
        for name in ("monte_carlo", "ratio_ci_low"):
            np.testing.assert_array_equal(column(path, "tables/parameters", name), column(plain, "tables/parameters", name))

    def test_azimuths_are_calibrated_and_a_wrong_claim_shows_in_them(self):
        asked = "--set", 'calibration.quantities=["azimuth_first", "azimuth_middle", "azimuth_last"]', "--set", "calibration.margin=0"
        right = self.run_config(*asked)
        self.assertGreater(column(right, "tables/calibration", "p_band").min(), 1e-4)
        wrong = self.run_config(*asked, "--set", "estimator.magnetometer_nT=16", output="wrong.h5")
        self.assertEqual(list(column(wrong, "tables/calibration", "verdict")), ["differs"] * 3)

    def test_a_wrong_claim_is_found_and_named(self):
        # Assumed noise a third of the true one: errors are far larger than the claim.
        path = self.run_config("--set", "estimator.magnetometer_nT=16", "--set", 'calibration.quantities=["nees"]')
        self.assertEqual(column(path, "tables/calibration", "verdict")[0], "differs")
        self.assertEqual(column(path, "tables/calibration", "shape")[0], "sd")
        self.assertGreater(column(path, "tables/calibration", "size")[0], 0)
        self.assertEqual(column(path, "tables/calibration", "family")[0], "differs")

    def test_few_trials_are_undecided(self):
        path = self.run_config("--trials", 900)
        self.assertEqual(set(column(path, "tables/calibration", "verdict")), {"undecided"})
        self.assertIn("at least 1000 trials", column(path, "tables/calibration", "note")[0])

    def test_bad_input(self):
        for change, says in ((("estimator.prior.gain=0.002",), r"estimator.prior.gain = 0.002: with \[calibration\] must be "
                                                               r"sensor.spread.gain = 0.001.*as_is"),
                             (("sensor.bias_nT=[100.0, 0.0, 0.0]",), r"sensor.bias_nT = .*must be 0, the middle of the priors"),
                             (("estimator.reference.dip_deg=0.2",), r"estimator.reference.dip_deg = 0.2"),
                             (('estimator.name="msa"',), r"estimator.name = \"msa\": claims no covariance"),
                             (('calibration.quantities=["gain"]',), r"calibration.quantities.*\"gain\" is none of gain_x"),
                             (("calibration.margin=0.5",), r"calibration.margin = 0.5: must be in \[0, 0.5\)"),
                             (('calibration.truth="fixed"',), r"must be one of \"prior\", \"as_is\"")):
            self.refused(BAD_INPUT, "run", "base.toml", "-o", "x.h5", *(a for c in change for a in ("--set", c)), says=says)
        self.run_config("--set", "estimator.prior.gain=0.002", "--set", 'calibration.truth="as_is"')


BENEFIT = """\
experiment = "msa_benefit"
seed = 4
trials = 2000
inclination_deg = [75.0]
azimuth_deg = [30.0]
estimator = "msa_joint"
[well]
kind = "building"
stations = 12
[field]
total_nT = 51000.0
dip_deg = 72.0
[sensor.spread]
gain = 0.0016
bias_nT = 70.0
[noise]
magnetometer_nT = 30.0
reference = { per = "run", total_nT = 50.0, dip_deg = 0.1 }
[[verify]]
inclination_deg = 75.0
azimuth_deg = 30.0
[[verify]]
inclination_deg = 60.0
azimuth_deg = 80.0
"""
CHAINED = """\
experiment = "chained_multistation"
seed = 8
trials = 1000
estimators = ["base", "filter", "smoother"]
[field]
total_nT = 50000.0
dip_deg = 75.0
[profile]
stations = 4
"""


class OtherStudies(CalibrationCase):
    def test_the_benefit_of_msa_is_calibrated_and_ends_by_its_verdicts(self):
        self.write("benefit.toml", BENEFIT + "[calibration]\nmargin = 0.08\n")
        path = self.run_config(config="benefit.toml", output="benefit.h5")
        self.assertEqual(list(column(path, "tables/calibration", "quantity")),
                         ["azimuth_before", "azimuth_after", "lateral_before", "lateral_after"] * 2)
        self.assertEqual(set(column(path, "tables/calibration", "trials")), {2000})
        self.assertEqual(set(column(path, "tables/calibration", "verdict")), {"agrees"})
        self.write("stop.toml", BENEFIT.replace("trials = 2000\n", "") + "[verdict]\nmargin = 0.05\n"
                   '[stop]\nverdict = ["verification.sd_azimuth_after"]\nmax_trials = 40000\n')
        path = self.run_config("--threads", 1, config="stop.toml")
        quantity, verdict, note, trials = (column(path, "tables/verification", c) for c in ("quantity", "verdict", "note", "trials"))
        named = [i for i, q in enumerate(quantity) if q == "sd_azimuth_after"]
        self.assertEqual([verdict[i] for i in named], ["agrees"] * 2)
        self.assertTrue(all("the run ended at look" in note[i] for i in named))
        self.assertEqual(column(path, "tables/looks", "trials")[-1], trials[0])
        self.assertLess(trials[0], 40000)
        self.assertEqual(set(column(path, "tables/looks", "formulation")), {"inclination 75 azimuth 30", "inclination 60 azimuth 80"})
        again = self.run_config("--threads", 2, config="stop.toml", output="again.h5")
        self.assertEqual(content_hash(again), content_hash(path))

    def test_the_smoother_is_calibrated(self):
        self.write("chained.toml", CHAINED + "[calibration]\nmargin = 0.08\n")
        path = self.run_config(config="chained.toml")
        rows = list(zip(column(path, "tables/calibration", "formulation"), column(path, "tables/calibration", "quantity")))
        self.assertEqual(len(rows), 2 * (3 * 13 + 1))
        self.assertNotIn("base", {f for f, _ in rows})
        self.assertNotIn("differs", set(column(path, "tables/calibration", "verdict")))
        self.assertIn(("smoother", "cost"), rows)

    def test_what_a_study_does_not_offer_is_said_by_name(self):
        for study in ("vertical_well", "sensor_monte_carlo", "error_model_monte_carlo", "gross_error_detection", "drift_monitoring"):
            self.call("new", study, "-o", f"{study}.toml")
            if study == "drift_monitoring":
                self.refused(BAD_INPUT, "check", f"{study}.toml", "--set", 'stop.verdict=["a.b"]',
                             says=f"{study} has a fixed number of trials.*msa_position, msa_benefit, sensor_monte_carlo, vertical_well, "
                                  "error_model_monte_carlo, chained_multistation, gross_error_detection, collision, rare_event")
            self.refused(BAD_INPUT, "check", f"{study}.toml", "--set", "calibration.margin=0.01",
                         says=f"{study} has no estimator that claims.*msa_position, msa_benefit, chained_multistation")
        self.write("benefit.toml", BENEFIT.replace("trials = 2000\n", ""))
        self.refused(BAD_INPUT, "check", "benefit.toml", "--set", "stop.relative_ci=0.1", says="ends by its verdicts: give stop.verdict")


SENSOR = """\
experiment = "sensor_monte_carlo"
seed = 3
report_md_m = [300.0, 570.0]
[survey]
file = "survey.csv"
toolface_zero = "y"
[drilling]
mode = "survey"
[field]
total_nT = 50000.0
dip_deg = 60.0
[sensor_errors]
accelerometer_bias_mps2 = 0.004
magnetometer_bias_nT = 70.0
"""
VERTICAL = """\
experiment = "vertical_well"
seed = 5
depth_m = 300.0
spacing_m = 30.0
[drilling]
mode = "rotating"
[field]
total_nT = 50000.0
dip_deg = 72.0
[sensor_errors]
accelerometer_bias_mps2 = 0.004
"""
DRAWN = """\
experiment = "error_model_monte_carlo"
seed = 6
antithetic = true
report_md_m = [300.0, 570.0]
[survey]
file = "survey.csv"
toolface_zero = "y"
azimuth_reference = "true"
[field]
total_nT = 50000.0
dip_deg = 60.0
declination_deg = 1.0
[error_model]
name = "iscwsa_mwd_rev5.10"
[errors]
multiplier = 6.0
"""


GROSS = """\
experiment = "gross_error_detection"
seed = 5
mode = "sse"
inclination_deg = 45.0
magnetic_azimuth_deg = 100.0
toolface_deg = 30.0
[[inject]]
observation = "bx"
size = "minimal_detectable"
"""


class EndsByVerdict(CalibrationCase):
    """Every study with rows of means and sds: the run ends early, whatever the threads, and goes on after it was killed."""
    def ends(self, text, margin, names, wrong, meant, most=60000):
        self.write("stop.toml", text + f"[verdict]\nmargin = {margin}\n[stop]\nverdict = {json.dumps(names)}\nmax_trials = {most}\n")
        path = self.run_config("--threads", 1, config="stop.toml")
        trials, decision, table, quantity = (list(column(path, "tables/looks", c)) for c in ("trials", "decision", "table", "quantity"))
        self.assertLess(trials[-1], most)
        self.assertGreater(trials[-1], 4096)
        rows = trials.count(trials[-1])  # at one look
        self.assertNotIn("undecided", decision[-rows:])
        self.assertIn("undecided", decision[-2 * rows:-rows])
        self.assertEqual({f"{t}.{q}" for t, q in zip(table, quantity)}, {".".join(n.split(".")[:2]) for n in names})
        again = self.run_config("--threads", 3, config="stop.toml", output="again.h5")
        self.assertEqual(content_hash(again), content_hash(path))
        self.assertEqual(content_hash(self.killed_and_resumed()), content_hash(path))
        self.refused(BAD_INPUT, "check", "stop.toml", "--set", f'stop.verdict=["{wrong}"]',
                     says=rf"\"{wrong}\" is no row with a margin that trials can decide: must be of .*; did you mean .*\"{meant}\"")
        return path, rows

    def killed_and_resumed(self):
        for attempt in range(10):  # a run may end before it is killed
            output = f"killed_{attempt}.h5"
            child = subprocess.Popen([test_cli.EXECUTABLE, "run", "stop.toml", "-o", output, "--threads", "1", "--quiet",
                                      "--checkpoint-seconds", "0.001"], cwd=self.folder)
            end = time.monotonic() + 60
            while not list(self.folder.glob(f"{output}.journal.*")) and child.poll() is None and time.monotonic() < end:
                time.sleep(0.002)
            child.kill()
            if child.wait() == -signal.SIGKILL and list(self.folder.glob(f"{output}.journal.*")):
                return self.run_config("--resume", "--threads", 2, config="stop.toml", output=output)
        self.fail("no run was killed before it ended")

    def same_at_the_last_look(self, path, table, row, rows, look=-1):
        for name in ("ratio", "ratio_ci_low", "ratio_ci_high"):
            self.assertAlmostEqual(column(path, f"tables/{table}", name)[row], column(path, "tables/looks", name)[look], delta=1e-12)
        last = len(column(path, "tables/looks", "look")) // rows
        self.assertIn(f"ended at look {last} of", column(path, f"tables/{table}", "note")[row])

    def test_sensor_monte_carlo(self):
        path, rows = self.ends(SENSOR, 0.03, ["axes.sd_axis_1.toolface_dependent"], "axes.sd_axes_1.toolface_dependent",
                               "axes.sd_axis_1.toolface_dependent")
        self.assertEqual(list(column(path, "tables/looks", "place")[-rows:]), ["300 m", "570 m"])
        md, quantity, formulation = (column(path, "tables/axes", c) for c in ("md_m", "quantity", "formulation"))
        for depth, look in ((300, -2), (570, -1)):
            row, = (i for i in range(len(md)) if (md[i], quantity[i], formulation[i]) == (depth, "sd_axis_1", "toolface_dependent"))
            self.same_at_the_last_look(path, "axes", row, rows, look)
        # Of a mean no ratio; no interval of a NEES holds at all looks.
        self.refused(BAD_INPUT, "check", "stop.toml", "--set", 'stop.verdict=["axes.nees"]', says="is no row with a margin")
        self.refused(BAD_INPUT, "check", "stop.toml", "--set", "stop.relative_ci=0.1", says="not together with stop.verdict")

    def test_vertical_well(self):
        path, rows = self.ends(VERTICAL, 0.08, ["toolface_sequences.ratio_rms", "ellipse.ratio_major.toolface_dependent"],
                               "toolface_sequences.ratio_rmss", "toolface_sequences.ratio_rms")
        self.same_at_the_last_look(path, "toolface_sequences", 0, rows)
        names = list(column(path, "tables/ellipse", "formulation"))
        row = names.index("toolface_dependent")
        self.assertIn("ratio_major: the run ended at look", column(path, "tables/ellipse", "note")[row])
        for name in ("low", "high"):
            self.assertAlmostEqual(column(path, "tables/ellipse", f"ratio_major_ci_{name}")[row],
                                   column(path, "tables/looks", f"ratio_ci_{name}")[-2], delta=1e-12)
        self.refused(BAD_INPUT, "check", "stop.toml", "--set", 'stop.verdict=["toolface_sequences.ratio_q50"]', says="is no row with a margin")

    def test_error_model_monte_carlo(self):
        path, rows = self.ends(DRAWN, 0.0015, ["axes.sd_axis_1.minimum_curvature", "position.sd_east.minimum_curvature"],
                               "position.sd_est.minimum_curvature", "position.sd_east.minimum_curvature")
        self.assertEqual(rows, 4)
        md, quantity, formulation = (column(path, "tables/position", c) for c in ("md_m", "quantity", "formulation"))
        row, = (i for i in range(len(md)) if (md[i], quantity[i], formulation[i]) == (570, "sd_east", "minimum_curvature"))
        self.same_at_the_last_look(path, "position", row, rows)
        self.refused(BAD_INPUT, "check", "stop.toml", "--set", 'errors.sources="quadrature"', says="draws nothing: leave it out")

    def test_chained_multistation(self):
        text = CHAINED.replace("trials = 1000\n", "").replace('["base", "filter", "smoother"]', '["filter"]')
        path, rows = self.ends(text, 0.05, ["rms.inclination_deg.filter", "consistency.cost_sd"], "rms.inclinatoin_deg.filter",
                               "rms.inclination_deg.filter")
        row, = (i for i, q in enumerate(column(path, "tables/consistency", "quantity")) if q == "cost_sd")
        self.same_at_the_last_look(path, "consistency", row, rows)
        for study in ("unstart", "outliers", "interference"):
            self.refused(BAD_INPUT, "check", "stop.toml", "--set", f'study="{study}"', says='only study = "performance" ends by its verdicts')


    def test_gross_error_detection(self):
        path, rows = self.ends(GROSS, 0.03, ["detection.detection_bx.nonlinear", "detection.detection_any"], "detection.detection_by.nonlinear",
                               "detection.detection_bx.nonlinear")
        self.assertEqual(rows, 3)  # detection_any by both formulations
        names = list(zip(column(path, "tables/detection", "formulation"), column(path, "tables/detection", "quantity")))
        self.same_at_the_last_look(path, "detection", names.index(("nonlinear", "detection_any")), rows)


class Verdicts(CalibrationCase):
    def test_a_run_ends_when_its_row_is_decided_with_the_same_bits_however_it_is_run(self):
        path = self.run_config("--threads", 1, config="stop.toml")
        trials, look = (column(path, "tables/looks", c) for c in ("trials", "look"))
        self.assertEqual(list(look), list(range(1, len(look) + 1)))
        self.assertGreater(len(look), 2)
        self.assertEqual(column(path, "tables/parameters", "trials")[0], trials[-1])
        decision = list(column(path, "tables/looks", "decision"))
        self.assertEqual(set(decision[:-1]), {"undecided"})
        self.assertEqual(decision[-1], "agrees")
        merit = column(path, "tables/looks", "relative_merit")
        self.assertEqual(merit[0], 1)
        np.testing.assert_allclose(merit, 1, rtol=0, atol=0.1)
        row = [i for i, (q, f) in enumerate(zip(column(path, "tables/parameters", "quantity"),
                                                column(path, "tables/parameters", "formulation")))
               if (q, f) == ("sigma3_gain_z", "claimed")][0]
        for name in ("ratio", "ratio_ci_low", "ratio_ci_high"):
            self.assertAlmostEqual(column(path, "tables/parameters", name)[row], column(path, "tables/looks", name)[-1], delta=1e-12)
        self.assertIn(f"ended at look {len(look)}", column(path, "tables/parameters", "note")[row])
        again = self.run_config("--threads", 2, config="stop.toml", output="again.h5")
        self.assertEqual(content_hash(again), content_hash(path))
        # Looks are those of a plain run of as many trials, but for the intervals.
        fixed = self.run_config("--trials", int(trials[-1]), output="fixed.h5")
        np.testing.assert_array_equal(column(path, "tables/parameters", "monte_carlo"), column(fixed, "tables/parameters", "monte_carlo"))
        self.refused(USAGE, "run", "stop.toml", "-o", "p/", "--shard", "0/2", says=r"ends by \[stop\]")

    def test_bad_input(self):
        for change, says in (('stop.verdict=["parameters.nees"]', r"\"parameters.nees\" is no row with a margin"),
                             ('stop.verdict=["parameters.sigma3_gain_z.first"]', r"is no row with a margin"),
                             ("stop.relative_ci=0.01", r"stop.relative_ci = 0.01: not together with stop.verdict"),
                             ('stop.correction="bonferroni"', r"stop.correction.*not together with stop.verdict"),
                             ("stop.max_trials=100", r"must be in \[4096"),
                             ('verdict.family="bh"', r"must be one of \"holm\", \"none\"")):
            self.refused(BAD_INPUT, "run", "stop.toml", "-o", "x.h5", "--set", change, says=says)

    def test_the_family_of_a_file(self):
        path = self.run_config()
        said = {c: column(path, "tables/family", c)[0] for c in
                ("verdicts", "agrees", "differs", "undecided", "differs_holm", "agrees_q")}
        self.assertEqual(said["verdicts"], said["agrees"] + said["differs"] + said["undecided"])
        tests = [p for t in ("covariance_tests", "ellipse") for p in column(path, f"tables/{t}", "wishart_p") if p == p]
        self.assertEqual(column(path, "tables/family", "tests")[0], len(tests))
        self.assertGreater(len(tests), 1)
        self.assertLessEqual(said["differs_holm"], said["differs"])
        words = {w for t in ("parameters", "position", "calibration", "ellipse") for w in column(path, f"tables/{t}", "family")}
        self.assertLessEqual(words, {"", "differs", "may be chance"})
        verdict, family = (column(path, "tables/position", c) for c in ("verdict", "family"))
        self.assertEqual([v == "differs" for v in verdict], [f != "" for f in family])
        none = self.run_config("--set", 'verdict.family="none"', output="none.h5")
        self.assertEqual(set(column(none, "tables/position", "family")), {""})
        # A difference that is expected and missing counts always.
        self.write("expect.toml", CONFIG + '[[expect]]\ntable = "parameters"\nquantities = ["nees"]\nverdict = "differs"\n')
        self.call("run", "expect.toml", "-o", "e.h5", "--check", code=UNEXPECTED)


class Cost(CalibrationCase):
    def test_every_row_with_a_ratio_has_its_cost(self):
        path = self.run_config()
        table = json.loads(self.call("show", path, "--cost", "--json").stdout)
        values = {c["name"]: np.array(c["values"]) for c in table["columns"]}
        ratio = sum(np.isfinite(column(path, f"tables/{t}", "ratio_ci_low")).sum() for t in ("parameters", "position", "position_hla"))
        self.assertGreaterEqual(len(values["table"]), ratio // 2)
        np.testing.assert_allclose(values["figure_of_merit"].astype(float),
                                   1 / (values["relative_half_width"] ** 2 * values["seconds_per_trial"] * 3000), rtol=1e-9)
        # The figure of merit does not depend on the number of trials, but for the seconds of a trial, which no test times.
        more = self.run_config("--trials", 48000, output="more.h5")
        table = json.loads(self.call("show", more, "--cost", "--json").stdout)
        later = {c["name"]: np.array(c["values"]) for c in table["columns"]}
        rows = np.isin(values["quantity"], ["sigma3_gain_x", "sigma3_bias_z", "sigma3_north", "sigma3_east", "sigma3_vertical"])
        np.testing.assert_array_equal(values["quantity"][rows], later["quantity"][rows])
        merit = [(v["figure_of_merit"] * v["seconds_per_trial"])[rows].astype(float) for v in (values, later)]
        np.testing.assert_allclose(merit[0], merit[1], rtol=0.1)
        again = self.run_config(output="again.h5")  # other times, the same result
        self.assertEqual(content_hash(again), content_hash(path))
        self.call("run", "base.toml", "-o", "p/", "--shard", "0/1")
        self.call("merge", "-o", "merged.h5", "p")
        self.refused(BAD_INPUT, "show", "merged.h5", "--cost", says="does not say what its rows cost")


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
