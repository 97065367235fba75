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
        np.testing.assert_allclose(true[[0, 20, 79]], (0, 0, 1))
        self.assertLess(abs(bias[-1] - 1), 5 * sd[-1] + 0.3)  # a random walk lags behind a ramp
        self.assertTrue((column(path, "tables/series", "true_bz_nT") == 0).all())

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
