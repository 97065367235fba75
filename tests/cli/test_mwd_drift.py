#!/usr/bin/python3
"""End-to-end tests of mwd_drift: test_mwd_drift.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, Case, column

CONFIG = """\
experiment = "mwd_drift"
seed = 5
trials = 150
[field]
total_nT = 50000.0
dip_deg = 72.0
[drift]
sensor = "gx"
at_td_mg = 1.0
"""


class MwdDrift(Case):
    def setUp(self):
        super().setUp()
        self.write("base.toml", CONFIG)

    def detection(self, *arguments):
        path = self.run_config(*arguments)
        return {m: i for i, m in enumerate(column(path, "tables/detection", "method"))}, path

    def test_the_filter_finds_the_drift_sooner_and_names_it(self):
        row, path = self.detection()
        value = lambda name, method: column(path, "tables/detection", name)[row[method]]  # noqa: E731
        self.assertLess(value("delay_q50_stations", "bias_filter"), value("delay_q50_stations", "channel_sprt"))
        self.assertGreater(value("p_detected_ci_low", "bias_filter"), value("p_detected_ci_high", "channel_sprt"))
        self.assertGreater(value("p_named_ci_low", "bias_filter"), 0.95)
        for method in row:  # one in 300: of 150 wells more than 4 have a chance of 2e-4
            self.assertLessEqual(value("p_alarm_without_drift", method), 4 / 150)

    def test_series_follow_the_drift(self):
        _, path = self.detection()
        true, bias, sd = (column(path, "tables/series", f"{n}_gx_mg") for n in ("true", "bias", "sd"))
        np.testing.assert_allclose(true[[0, 20, 21, 79]], (0, 0, 1 / 59, 1), atol=1e-12)
        self.assertLess(abs(bias[-1] - 1), 5 * sd[-1] + 0.3)  # a random walk lags behind a ramp
        self.assertTrue((column(path, "tables/series", "true_bz_nT") == 0).all())

    def test_comparison_with_theory(self):
        path = self.run_config("--trials", "400")
        with h5py.File(path) as f:
            t = f["tables/comparison"]
            row = {(a, b): i for i, (a, b) in enumerate(zip(t["formulation"].asstr()[()], t["quantity"].asstr()[()]))}
            value = lambda c, *key: t[c][row[key]]  # noqa: E731
            # Standard errors of 400 wells: NIS sqrt(6 / 80 / 400) = 0.014; NEES from its own interval; 4 of them.
            self.assertEqual(value("analytic", "bias_filter", "nis_mean"), 3)
            self.assertLess(abs(value("monte_carlo", "bias_filter", "nis_mean") - 3), 4 * 0.014)
            self.assertLess(abs(value("monte_carlo", "bias_filter", "nis_within_95") - 0.95),
                            4 * (0.95 * 0.05 / 80 / 400)**0.5)
            nees = value("monte_carlo", "bias_filter", "nees_mean")
            half = nees - value("monte_carlo_ci_low", "bias_filter", "nees_mean")
            self.assertLess(abs(nees - 6), 2.1 * half)  # 4 / 1.96
            false_alarm = value("analytic", "channel_sprt", "p_alarm_without_drift")
            self.assertTrue(0.005 < false_alarm < 0.01, false_alarm)
            seen = value("monte_carlo", "channel_sprt", "p_alarm_without_drift")
            self.assertLess(abs(seen - false_alarm), 4 * (false_alarm / 400)**0.5)
            claims = f["tables/claims"]
            verdicts = dict(zip(claims["quantity"].asstr()[()], claims["verdict"].asstr()[()]))
            self.assertEqual((verdicts["detects_no_less"], verdicts["is_sooner"]), ("agrees", "agrees"))

    def test_wells_that_are_all_alike_confirm_no_difference(self):
        for trials in ("1", "2"):
            with h5py.File(self.run_config("--trials", trials, "--overwrite")) as f:
                claims = f["tables/claims"]
                i = list(claims["quantity"].asstr()[()]).index("detects_no_less")
                self.assertEqual(claims["verdict"].asstr()[i], "undecided")
                self.assertLess(claims["monte_carlo_ci_low"][i], -0.5)

    def test_no_prediction_of_false_alarms_where_it_is_not_known(self):
        def row(*settings):
            path = self.run_config("--trials", "4000", *(a for s in settings for a in ("--set", s)), output="row.h5")
            with h5py.File(path) as f:
                t = f["tables/comparison"]
                i = list(zip(t["formulation"].asstr()[()], t["quantity"].asstr()[()])).index(
                    ("channel_sprt", "p_alarm_without_drift"))
                return t["analytic"][i], t["verdict"].asstr()[i], t["note"].asstr()[i]
        # Sides of a channel are nearly exclusive: taken as independent they would have 0.669 of 0.687.
        analytic, verdict, note = row("sprt.shift_sd=0.2", "sprt.false_alarm=0.2")
        self.assertTrue(np.isnan(analytic))
        self.assertEqual(verdict, "")
        self.assertRegex(note, "from 0.669.*to 0.708")
        # Steps of a hundredth of the distance of the bounds: more panels than the integration has.
        analytic, verdict, note = row("sprt.shift_sd=0.01", "sprt.false_alarm=0.3", "sprt.missed_alarm=1e-9")
        self.assertTrue(np.isnan(analytic))
        self.assertEqual(verdict, "")
        self.assertIn("too small", note)

    def test_alarm_curve_ends_at_the_detection_rate(self):
        row, path = self.detection()
        curve = {k: column(path, "tables/alarm_curve", k) for k in ("method", "md_m", "p_alarm")}
        for method, i in row.items():
            share = [p for m, p in zip(curve["method"], curve["p_alarm"]) if m == method]
            self.assertEqual(len(share), 80)
            self.assertTrue(all(a <= b for a, b in zip(share, share[1:])))
            self.assertEqual(share[19], 0)
            self.assertEqual(share[-1], column(path, "tables/detection", "p_detected")[i])

    def test_published_and_expected_rows(self):
        self.write("base.toml", CONFIG + '[[published]]\nsource = "x"\ntable = "comparison"\n'
                   'formulation = "bias_filter"\nvalues = { p_detected = 1.0 }\n'
                   '[[expect]]\ntable = "claims"\nquantities = ["is_sooner"]\nverdict = "differs"\n')
        done = self.call("run", "base.toml", "--check", "-o", "out.h5", code=1)
        self.assertRegex(done.stdout, "claims .* is_sooner: agrees, expected differs")
        self.write("base.toml", CONFIG + '[[expect]]\ntable = "claims"\nquantities = ["sooner"]\nverdict = "agrees"\n')
        self.refused(BAD_INPUT, "run", "base.toml", says='no row "sooner"')

    def test_nothing_is_claimed_of_a_drift_of_zero(self):
        path = self.run_config("--set", "drift.at_td_mg=0.0", "--trials", "1500")
        with h5py.File(path) as f:
            claims, detection, comparison = (f["tables"][t] for t in ("claims", "detection", "comparison"))
            for quantity, verdict, value, note in zip(claims["quantity"].asstr()[()], claims["verdict"].asstr()[()],
                                                      claims["monte_carlo"][()], claims["note"].asstr()[()]):
                with self.subTest(quantity=quantity):
                    if quantity == "false_alarms_are_rare":
                        self.assertGreaterEqual(value, 0)
                    else:
                        self.assertEqual((verdict, str(value)), ("", "nan"))
                        self.assertIn("no sensor drifts", note)
            self.assertEqual(set(detection["sensor"].asstr()[()]), {"none"})
            for name in ("p_detected", "p_named", "delay_q05_stations", "delay_q50_stations", "delay_q95_stations"):
                self.assertTrue(np.isnan(detection[name][()]).all(), name)
            self.assertTrue((detection["p_alarm_without_drift"][()] > 0).all())
            of = dict(zip(comparison["quantity"].asstr()[()], comparison["monte_carlo"][()]))
            self.assertTrue(np.isnan(of["p_detected"]) and np.isnan(of["p_named"]))
            self.assertTrue(of["nis_mean"] > 2)

    def test_threads_and_rerun(self):
        one = self.run_config("--threads", "1", output="one.h5")
        three = self.run_config("--threads", "3", output="three.h5")
        with h5py.File(one) as a, h5py.File(three) as b:
            self.assertEqual(a.attrs["content_hash"], b.attrs["content_hash"])
        self.assertRegex(self.call("rerun", one).stdout, "^identical")

    def test_bad_settings(self):
        for setting, says in (("drift.sensor=gt", "must be one of"), ("drift.from_station=79", "must be"),
                              ("noise.magnetometer_nT=0", "must be"), ("drift.at_td_nT=1.0", "at_td_nT"),
                              ("well.stations=2", "must be")):
            with self.subTest(setting=setting):
                self.refused(BAD_INPUT, "run", "base.toml", "--set", setting, says=says)


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
