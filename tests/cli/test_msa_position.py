#!/usr/bin/python3
"""End-to-end tests of msa_position: test_msa_position.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]"""
import json
import sys
import unittest
from pathlib import Path

import test_cli
from test_cli import Case, column

CONFIG = """\
experiment = "msa_position"
seed = 3
trials = 2000
[survey]
file = "{source}/configs/thesis/traj4.csv"
toolface_zero = "x"
[field]
total_nT = 51000.0
dip_deg = 72.0
[noise]
magnetometer_nT = 7.0
reference = {{ per = "run", total_nT = 10.7, dip_deg = 0.016 }}
"""
# A tool far from what the priors say, which therefore pull the estimate.
PULLED = """\
[sensor]
gain = [1.01, 1.0, 1.0]
bias_nT = [100.0, 0.0, -300.0]
[estimator]
name = "{estimator}"
magnetometer_nT = 20.0
prior = {{ gain = 0.005, bias_nT = 100.0 }}
"""
PARAMETERS = [f"{what}_{axis}" for what in ("gain", "bias") for axis in "xyz"]
HANAK = [f"{what}_{axis}" for what in ("scale", "offset") for axis in "xyz"]


class MsaPosition(Case):
    def rows(self, table, config):
        """{quantity: (Monte Carlo, half its 95 % interval, analytic)}; of several formulations the first."""
        self.write("base.toml", CONFIG.format(source=test_cli.SOURCE) + config)
        path = self.run_config()
        of = lambda name: column(path, f"tables/{table}", name)
        half = (of("monte_carlo_ci_high") - of("monte_carlo_ci_low")) / 2
        out = {}
        for q, *row in zip(of("quantity"), of("monte_carlo"), half, of("analytic")):
            out.setdefault(q, row)
        return out

    def assert_close(self, row, halves=2.1):  # 4 standard errors
        found, half, analytic = row
        self.assertLess(abs(found - analytic), halves * half)

    def test_spread_of_the_tools_is_no_error_of_an_estimate(self):
        """In Hanak's convention as in gains and biases. Without priors; the tools' own 300 nT would be 900 in sigma3."""
        config = "[sensor]\nspread = { gain = 0.0016, bias_nT = 300.0 }\n" \
                 "[estimator]\nname = \"wls_consider\"\nprior = { gain = 0.0, bias_nT = 0.0 }\n"
        ours, hanak = self.rows("parameters", config), self.rows("hanak_parameters", config)
        for p, h in zip(PARAMETERS, HANAK):
            with self.subTest(quantity=h):
                self.assert_close(hanak[f"sigma3_{h}"])
                self.assertLess(abs(hanak[f"sigma3_{h}"][0] / ours[f"sigma3_{p}"][0] - 1), 0.01)

    def test_orders_beyond_first_need_normals_and_a_fit_of_the_field(self):
        for study, key, value, says in [("msa_orders", "noise.law", "uniform", "are made of normals"),
                                        ("msa_benefit_orders", "noise.law", "uniform", "are made of normals"),
                                        ("msa_orders", "estimator.name", "wls", "does not fit (Bh, Bv)"),
                                        ("msa_orders", "prediction.orders", ["third"], "must be a list of"),
                                        ("msa_benefit_orders", "prediction.nodes", 7, "must be 5, 9, 13")]:
            with self.subTest(study=study, key=key):
                config = Path(test_cli.SOURCE) / f"configs/smoke/{study}.toml"
                done = self.call("check", config, "--set", f"{key} = {json.dumps(value)}", code=65)
                self.assertIn(says, done.stderr)

    def test_robust_losses_go_with_parameters_alone(self):
        """What does not go together is refused before anything runs, with a way out."""
        smoke = Path(test_cli.SOURCE) / "configs/smoke"
        robust = ("--set", "estimator.robust.loss=cauchy")
        for config, settings, says in [
                ("msa_position", robust, r'estimator\.robust: is of estimators by estimator\.parameters: name them, "6"'),
                ("msa_benefit", robust, r'estimator\.robust: is of estimators by estimator\.parameters'),
                ("corrected_codes", robust, r'estimator\.robust: needs correction\.kind = "estimator"'),
                ("robustness_map", robust, r"estimator\.robust: the study compares losses: name them in estimator\.losses"),
                ("estimate", robust, r'estimator\.robust: needs estimator\.name = "multistation"'),
                ("estimate_chained", robust, r'estimator\.robust: needs estimator\.name = "multistation"'),
                ("msa_robust", ("--set", 'prediction.orders=["second"]'), r"prediction: is not of estimators by estimator\.parameters"),
                ("msa_robust", ("--set", "antithetic=true"), r"antithetic = true: is not of .* leave it, or these two, out"),
                ("msa_robust", ("--set", "estimator.robust=cauchy"), r'estimator\.robust\.name = "cauchy": is a table: write \{ loss'),
                ("msa_robust", ("--set", "estimator.robust.loss=couchy"), r'must be one of .*; did you mean "cauchy"\?'),
                ("msa_robust", ("--set", "noise.magnetometer_nT=0", "--set", "estimator.magnetometer_nT=9", *robust),
                 r"weighs stations by errors of their own, of which there are none: give noise\.magnetometer_nT"),
                ("corrected_codes_parameters", (*robust, "--set", "draw.reference.station_total_nT=0", "--set",
                                                "draw.reference.station_dip_deg=0", "--set", "noise.magnetometer_nT=0"),
                 r"weighs stations by errors of their own")]:
            with self.subTest(config=config, says=says):
                self.assertRegex(self.call("check", smoke / f"{config}.toml", *settings, code=65).stderr, says)

    def test_a_loss_of_least_squares_is_none(self):
        """A sweep of losses may begin with it: the same bits. Six parameters are then a set like the others."""
        smoke = Path(test_cli.SOURCE) / "configs/smoke/msa_parameter_sets.toml"
        few = ("--trials", "64", "--set", 'estimator.parameters="12"')
        numbers = []
        for name, more in [("none", ()), ("named", ("--set", "estimator.robust.loss=least_squares"))]:
            self.call("run", smoke, *few, *more, "-o", f"{name}.h5")
            numbers.append(list(column(self.folder / f"{name}.h5", "tables/parameters", "monte_carlo")))
        self.assertEqual(*numbers)
        self.call("run", smoke, "--trials", "64", "--set", 'estimator.parameters="6"', "--set", "estimator.robust.loss=huber",
                  "-o", "six.h5")
        quantities = [q.decode() if isinstance(q, bytes) else q for q in column(self.folder / "six.h5", "tables/learnt", "parameter")]
        self.assertEqual(quantities, ["mbx", "mby", "mbz", "msx", "msy", "msz"])

    def test_errors_that_stations_share_are_warned_of(self):
        """A loss is linear in them where they are small beside the stations' own."""
        smoke = Path(test_cli.SOURCE) / "configs/smoke/msa_robust.toml"
        for name, warned in [("msa_joint", False), ("msa", True)]:
            with self.subTest(name=name):
                self.call("run", smoke, "--trials", "64", "--set", "noise.magnetometer_nT=20", "--set", f"estimator.name={name}",
                          "--set", 'estimator.parameters="6"', "--set", "estimator.robust.loss=cauchy", "-o", f"{name}.h5")
                said = self.call("show", f"{name}.h5", "warnings").stdout
                (self.assertIn if warned else self.assertNotIn)("of errors that stations share the fit leaves", said)

    def test_priors_that_pull_shift_the_reference_too(self):
        rows = self.rows("parameters", PULLED.format(estimator="msa_joint"))
        for quantity, truth in [("mean_reference_total", 51000), ("mean_reference_dip", 72)]:
            with self.subTest(quantity=quantity):
                self.assert_close(rows[quantity])
                self.assertGreater(abs(rows[quantity][2] - truth), rows[quantity][1])
        # The first-order shift by an independent linearisation.
        self.assertAlmostEqual(rows["mean_reference_total"][2] - 51000, 0.7845, delta=1e-4)
        self.assertAlmostEqual(rows["mean_reference_dip"][2] - 72, 0.0024384, delta=1e-7)

    def test_priors_that_pull_shift_hanaks_parameters_too(self):
        rows = self.rows("hanak_parameters", PULLED.format(estimator="wls_consider"))
        for name in HANAK:
            with self.subTest(quantity=name):
                self.assert_close(rows[f"mean_{name}"])
        self.assertGreater(rows["mean_offset_z"][2], -290)  # of the true -300


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    test_cli.EXECUTABLE = str(Path(sys.argv[1]).resolve())
    test_cli.SOURCE = Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
