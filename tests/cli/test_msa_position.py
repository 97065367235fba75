#!/usr/bin/python3
"""End-to-end tests of msa_position: test_msa_position.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]"""
import json
import sys
import unittest
from pathlib import Path

import h5py

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
                 r"weighs stations by what noise leaves in them: give noise\.magnetometer_nT"),
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


HEAVY = {"dip": '{ law = "nig", shape = 0.2, size = "sd" }', "total": '{ law = "nig", shape = 0.2, size = "sd" }'}
STORM = '{ kind = "storm", match = "variance", storms_per_day = 1.0, rise_s = 600.0, decay_s = 20000.0, drilling_m_per_h = 25.0 }'
LASTING = '{ kind = "ar1", match = "variance", tau_s = 20000.0, drilling_m_per_h = 25.0 }'
BOTH = """\
experiment = "{study}"
seed = 5
trials = 60000
field = {{ total_nT = 50000.0, dip_deg = 70.0 }}
disturbance = {disturbance}
reference_law = {{ declination = {{ law = "nig", shape = 0.2, size = "sd" }}, modes = ["G", "W"] }}
"""


class Reference(Case):
    """Laws of the reference and disturbances of it, in both studies of MSA."""

    @staticmethod
    def smoke(name):
        return Path(test_cli.SOURCE) / f"configs/smoke/{name}.toml"

    def test_limits_of_sizes_and_keys_of_other_tables_are_refused_with_the_reason(self):
        event = lambda quantity, limit: ("--set", f'event=[{{name="far",quantity="{quantity}",{limit}}}]')
        for sets, says in ((event("lateral_in_sd", "below=-5.0"), "below = -5: .lateral_in_sd. is a size.* give `above`, a number > 0"),
                           (event("north_in_sd", "above=0.0"), "above = 0: .north_in_sd. is a size, never below 0: must be > 0"),
                           (event("distance_m", "below=-5.0"), "below = -5: .distance_m. is a size, never below 0: must be > 0"),
                           (event("lateral_in_sd", "above=5.0") + ("--set", "tails.k=[3.0]"), "tails.* a run of ..event.. has none"),
                           (event("lateral_in_sd", "above=5.0") + ("--set", 'reference_law={}'), 'no row "probability" of "normal"')):
            with self.subTest(sets):
                self.refused(65, "check", self.smoke("msa_tails_event"), *sets, says=says)
        self.call("check", self.smoke("msa_tails_event"), *event("distance_m", "above=500.0"), *("--set", "expect=[]"))

    def run_with(self, config, output="out.h5", **keys):
        sets = [word for key, value in keys.items() for word in ("--set", f"{key.replace('__', '.')} = {value}")]
        return self.run_config(*sets, config=config, output=output, timeout=300)

    def beyond(self, path, formulation="mixture"):
        """Rows of the formulation: [((inclination, azimuth) or None, quantity, Monte Carlo, predicted by the laws, verdict)]"""
        with h5py.File(path) as file:
            has_place = "inclination_deg" in file["tables/tails"]
        of = lambda name: column(path, "tables/tails", name)
        place = list(zip(of("inclination_deg"), of("azimuth_deg"))) if has_place else [None] * len(of("quantity"))
        rows = zip(of("formulation"), place, of("quantity"), of("monte_carlo"), of("predicted"), of("verdict"))
        return [row for name, *row in rows if name == formulation]

    def test_tails_of_wells_that_are_not_linear_are_within_a_tenth_of_a_percent(self):
        """Beyond 3 sd a percent and more. 400,000 trials: a standard error is 0.02 percent points."""
        heavy = f"{{ dip = {HEAVY['dip']}, total = {HEAVY['total']}, shared_mixing = true }}"
        source = Path(test_cli.SOURCE) / "configs"
        thesis = self.run_with(source / "thesis/test4.toml", output="thesis.h5", trials=400_000, save_samples=0, reference_law=heavy)
        level = self.run_with(source / "msa_benefit/heavy_reference.toml", output="level.h5", inclination_deg="[90.0]", azimuth_deg="[60.0]")
        for path, at, quantities, rows in ((thesis, None, ("north", "east", "high_side", "lateral"), 4),
                                           (level, (90, 60), ("lateral_after", "azimuth_after"), 4)):
            found = [r for r in self.beyond(path) if r[0] == at and r[1] in [f"{q}_beyond_3" for q in quantities]]
            self.assertEqual(len(found), rows)
            for place, quantity, drawn, predicted, _ in found:
                with self.subTest(place=place, quantity=quantity):
                    self.assertGreater(predicted, 0.005)  # of a normal distribution 0.0027
                    self.assertLess(abs(drawn - predicted), 1e-3)

    def test_maps_of_tails_are_the_predictions_of_the_table(self):
        path = self.run_with(self.smoke("msa_benefit_tails"), trials=64, inclination_deg="[40.0, 75.0]", azimuth_deg="[0.0, 30.0]")
        with h5py.File(path) as file:
            maps = {name: file["maps"][name][()] for name in file["maps"] if "_beyond_" in name}
        of = lambda name: column(path, "tables/tails", name)
        rows = list(zip(of("case"), of("inclination_deg"), of("azimuth_deg"), of("quantity"), of("formulation"), of("predicted")))
        cases = list(dict.fromkeys(r[0] for r in rows))
        seen = 0
        for case, inclination, azimuth, quantity, formulation, predicted in rows:
            if formulation == "mixture":
                at = (cases.index(case), [40, 75].index(inclination), [0, 30].index(azimuth))
                self.assertAlmostEqual(maps[quantity][at], predicted, delta=1e-12)
                seen += 1
        self.assertEqual(seen, 3 * 2 * 2 * 3)
        # One draw a run is heavier than a draw a station; errors that last are normal.
        run, station, lasting = (maps["lateral_after_beyond_3.5"][i, 1, 1] for i in range(3))
        self.assertGreater(run, 2 * station)
        self.assertAlmostEqual(lasting, 4.6526e-4, delta=1e-7)

    def test_a_disturbance_that_is_not_normal_has_trials_and_no_prediction_of_tails(self):
        for study, more in (("disturbance_msa", {}), ("msa_benefit", {"noise__reference__per": '"station"'})):
            with self.subTest(study=study):
                path = self.run_with(self.smoke(study), output=f"{study}.h5", trials=2000, disturbance=STORM, tails="{ k = [2.0] }", **more)
                rows = self.beyond(path)
                self.assertTrue(rows)
                for _, quantity, drawn, predicted, verdict in rows:
                    self.assertNotEqual(predicted, predicted)
                    self.assertEqual(verdict, "")
                    self.assertTrue(0 < drawn < 0.5 or not quantity.startswith("lateral"), quantity)
                with h5py.File(path) as file:
                    self.assertFalse([name for name in file.get("maps", {}) if "_beyond_" in name])

    def test_maps_that_a_point_of_a_sweep_does_not_have_are_nan_there(self):
        text = self.smoke("msa_benefit_tails").read_text()
        case = lambda name: f'[[sweep.case]]\nname = "{name}"\n"noise.reference.per" = "station"\n"disturbance" = {STORM}\n\n'
        first, last = text.index("[[sweep.case]]"), text.index("[[expect]]")
        self.write("storms.toml", text[:first] + case("before") + text[first:last] + case("behind"))
        path = self.run_with("storms.toml", trials=64, inclination_deg="[40.0]", azimuth_deg="[30.0]")
        with h5py.File(path) as file:
            beyond = file["maps/lateral_after_beyond_3.5"][:, 0, 0]
        self.assertEqual([p == p for p in beyond], [False, True, True, True, False])
        self.assertAlmostEqual(beyond[3], 4.6526e-4, delta=1e-7)
        without = text[:text.index("[[verify]]")].replace("trials = 20000\n", "") + case("alone")
        self.write("without.toml", without)
        self.refused(65, "check", "without.toml", says="no maps of tails, but trials: leave out .tails., or give ..verify")

    def test_what_lasts_has_laws_beside_a_disturbance_of_what_does_not(self):
        """Both at once: sds as predicted, tails by the laws where the disturbance is normal."""
        for study, table, quantity, model in (
                ("error_model_monte_carlo", "position_hla", "sd_lateral",
                 'error_model = "MWD+SRGM"\nwell = { inclination_deg = 90.0, azimuth_deg = 0.0, length_m = 2100.0, vertical_m = 300.0 }\n'),
                ("corrected_codes", "prediction", "ratio_lateral",
                 'code = { base = "MWD+IFR1", claimed = "MWD+IFR1+MS" }\ncorrection = { kind = "msa3" }\n'
                 'well = { kind = "building", stations = 31, inclination_deg = 80.0, azimuth_deg = 60.0 }\n')):
            self.write("base.toml", BOTH.format(study=study, disturbance=f"{LASTING[:-1]}, scale = 3.0 }}") + model)
            path = self.run_config(output=f"{study}.h5", timeout=300)
            of = lambda name: column(path, f"tables/{table}", name)
            with self.subTest(study=study):
                at = list(of("quantity")).index(quantity)
                self.assertLess(abs(of("monte_carlo")[at] / of("analytic")[at] - 1), 0.02)
                rows = {q: (drawn, predicted) for _, q, drawn, predicted, _ in self.beyond(path) if q.startswith("lateral")}
                self.assertGreater(len(rows), 2)
                for q, (drawn, predicted) in rows.items():
                    self.assertLess(abs(drawn - predicted), 5 * (predicted / 60000) ** 0.5, q)
                self.assertGreater(rows["lateral_beyond_3.5"][1], 6e-4)  # of a normal distribution 4.7e-4

    def test_what_cannot_go_together_is_refused_with_the_way_out(self):
        law = f"reference_law = {{ dip = {HEAVY['dip']} }}"
        for study, sets, says in [
                ("msa_orders", [law], "leave them out, trials and the table .tails. have the laws"),
                ("msa_benefit_orders", [law], "leave them out, trials and the table .tails. have the laws"),
                ("disturbance_msa", [law], "error_model_monte_carlo and corrected_codes have both"),
                ("msa_benefit", ['noise.reference.per = "station"', law, f"disturbance = {LASTING}"],
                 "error_model_monte_carlo and corrected_codes have both"),
                ("msa_benefit", [f"disturbance = {LASTING}"], "noise.reference.per must be"),
                ("disturbance_msa", ["noise.reference.total_nT = 0.0", "noise.reference.dip_deg = 0.0"], "whose errors are 0: give noise.ref"),
                ("disturbance_codes", [law], "what lasts has the laws")]:
            with self.subTest(study=study, says=says):
                self.refused(65, "check", self.smoke(study), *[w for s in sets for w in ("--set", s)], says=says)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    test_cli.EXECUTABLE = str(Path(sys.argv[1]).resolve())
    test_cli.SOURCE = Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
