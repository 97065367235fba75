#!/usr/bin/python3
"""End-to-end tests of calibration, stops by verdict, families and cost: test_calibration.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import json
import sys
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
    def test_tables_hang_together(self):
        path = self.run_config()
        quantity = list(column(path, "tables/calibration", "quantity"))
        self.assertEqual(quantity, ["gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z", "reference_total", "reference_dip",
                                    "nees", "north", "east", "vertical", "major_axis", "minor_axis"])
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
        # Estimates are the same without.
        self.write("plain.toml", CONFIG[:CONFIG.index("[calibration]")])
        plain = self.run_config(config="plain.toml", output="plain.h5")
        for name in ("monte_carlo", "ratio_ci_low"):
            np.testing.assert_array_equal(column(path, "tables/parameters", name), column(plain, "tables/parameters", name))

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
        again = self.run_config(output="again.h5")  # other times, the same result
        self.assertEqual(content_hash(again), content_hash(path))
        self.call("run", "base.toml", "-o", "p/", "--shard", "0/1")
        self.call("merge", "-o", "merged.h5", "p")
        self.refused(BAD_INPUT, "show", "merged.h5", "--cost", says="does not say what its rows cost")


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
