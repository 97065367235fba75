#!/usr/bin/python3
"""End-to-end tests of error_model_monte_carlo: test_error_model_monte_carlo.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import csv
import io
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

EXECUTABLE = None
SOURCE = None
DONE, BAD_INPUT = 0, 65

WELL = """\
experiment = "error_model_monte_carlo"
seed = 5
trials = 2000
report_md_m = [900.0]
error_model = "iscwsa_mwd_rev5.10"
[well]
inclination_deg = 60.0
azimuth_deg = 80.0
length_m = 900.0
vertical_m = 300.0
[field]
total_nT = 50000.0
dip_deg = 72.0
"""


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = Path(self.folder.name)

    def call(self, *arguments):
        return subprocess.run([EXECUTABLE, *map(str, arguments)], capture_output=True, text=True, cwd=self.path, timeout=300)

    def run_config(self, text, *arguments):
        (self.path / "well.toml").write_text(text)
        run = self.call("run", "well.toml", "-o", "well.h5", *arguments)
        self.assertEqual(run.returncode, DONE, run.stderr)

    def table(self, name, **wanted):
        shown = self.call("show", "well.h5", name, "--csv")
        self.assertEqual(shown.returncode, DONE, shown.stderr)
        rows = list(csv.DictReader(io.StringIO(shown.stdout)))
        return [r for r in rows if all(r[k] == v for k, v in wanted.items())]

    def refused(self, text, *says):
        (self.path / "well.toml").write_text(text)
        run = self.call("run", "well.toml", "-o", "well.h5")
        self.assertEqual(run.returncode, BAD_INPUT, run.stderr)
        self.assertFalse((self.path / "well.h5").exists())
        for words in says:
            self.assertIn(words, run.stderr)
        self.assertRegex(run.stderr, r"well\.toml:\d+: ")


class Results(Case):
    def test_small_errors_have_the_predicted_covariance_along_every_axis(self):
        self.run_config(WELL, "--set", "errors.multiplier=0.1")
        for formulation in ("minimum_curvature", "second"):
            for axis in (1, 2, 3):
                (row,) = self.table("axes", formulation=formulation, quantity=f"sd_axis_{axis}")
                # The control variate leaves 1e-3 of the sampling error of 2000 trials.
                self.assertLess(abs(float(row["ratio"]) - 1), 1e-3)
                self.assertLess(float(row["ratio_ci_high"]) - float(row["ratio_ci_low"]), 2e-3)

    def test_orders_say_what_the_rows_of_each_formulation_say(self):
        names = ["minimum_curvature", "second", "unscented", "cubature5", "profile"]
        well = WELL.replace("[well]", f"formulations = {names}\nerrors.multiplier = 5.0\n[well]").replace("'", '"')
        self.run_config(well.replace("azimuth_deg = 80.0", "azimuth_deg = 90.0").replace("900.0", "3000.0"))
        (third,) = self.table("orders", quantity="axis_3")
        sd = {f: self.table("axes", formulation=f, quantity="sd_axis_3")[0] for f in names}
        for column, formulation in (("sd_first", "minimum_curvature"), ("sd_second", "second"), ("sd_profile", "profile")):
            self.assertAlmostEqual(float(third[column]) / float(sd[formulation]["analytic"]), 1, delta=1e-12)
        self.assertAlmostEqual(float(third["e2"]), float(third["sd_second"]) / float(third["sd_first"]) - 1, delta=1e-12)
        self.assertEqual(float(third["monte_carlo"]), float(sd["profile"]["monte_carlo"]))
        # The four beyond first order agree, unlike first order; the trials have the last word.
        for formulation in names[1:]:
            self.assertLess(abs(float(sd[formulation]["analytic"]) / float(sd["second"]["analytic"]) - 1), 0.02)
            self.assertNotEqual(self.table("axes", formulation=formulation, quantity="mean_axis_3")[0]["verdict"], "differs")
        self.assertGreater(float(third["e2"]), 0.02)
        self.assertEqual(self.table("orders", quantity="axis_1")[0]["order"], "first")
        self.assertIn(third["order"], ("second", "profile"))
        self.assertEqual(len(self.table("order_coverage")), 3)

    def test_iscwsa_has_the_covariance_of_position_covariance(self):
        self.run_config(WELL.replace("[900.0]", "[385.0, 900.0]"))
        between, own = self.table("position_covariance", formulation="iscwsa")
        rows = ["md_m,inclination_deg,azimuth_deg"]
        for k in range(31):
            rows.append(f"{30 * k},{min(60, max(0, 3 * (k - 10)))},80")
        (self.path / "well.csv").write_text("\n".join(rows) + "\n")
        (self.path / "covariance.toml").write_text(re.sub(r"\[well\][^[]*", '[survey]\nfile = "well.csv"\n', WELL)
                                                   .replace("error_model_monte_carlo", "position_covariance")
                                                   .replace("[900.0]", "[385.0]"))
        run = self.call("run", "covariance.toml", "-o", "covariance.h5")
        self.assertEqual(run.returncode, DONE, run.stderr)
        shown = self.call("show", "covariance.h5", "covariance", "--csv").stdout
        last = [r for r in csv.DictReader(io.StringIO(shown)) if float(r["md_m"]) == 900][0]
        trace = sum(float(last[c]) for c in ("nn_m2", "ee_m2", "vv_m2"))
        for element in ("nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2"):
            self.assertLess(abs(float(own[element]) - float(last[element])), 1e-11 * trace)
        shown = self.call("show", "covariance.h5", "uncertainty", "--csv").stdout
        sd = {r["quantity"]: float(r["sd_m"]) for r in csv.DictReader(io.StringIO(shown)) if float(r["md_m"]) == 385}
        for quantity, element in (("north", "nn_m2"), ("east", "ee_m2"), ("vertical", "vv_m2")):
            self.assertAlmostEqual(float(between[element]) / sd[quantity] ** 2, 1, delta=1e-11)

    def test_quadrature_leaves_random_sources_out_and_needs_no_trials(self):
        self.run_config(WELL.replace("trials = 2000\n", ""), "--set", "errors.sources=quadrature")
        rows = self.table("by_source", formulation="minimum_curvature", quantity="sd_along")
        modes = {r["mode"] for r in rows}
        self.assertEqual(modes, {"S", "W", "G"})
        self.assertNotIn("DECR", {r["source"] for r in rows})
        told = self.call("check", "well.toml", "--set", "errors.sources=quadrature")
        self.assertIn("leaves out DRFR (R), DECR (R),", told.stderr + told.stdout)
        for r in rows:
            self.assertLess(abs(float(r["ratio"]) - 1), 1e-3)

    def test_quadrature_names_every_source_that_it_leaves_out_and_no_other(self):
        well = WELL.replace("trials = 2000\n", "").replace("dip_deg = 72.0", "dip_deg = 72.0\nlatitude_deg = 60.0")
        legs = "".join(f'[[leg]]\nfrom_md_m = {md}.0\nerror_model = "INC-ONLY"\n' for md in (450, 600, 750))
        for model, more in (("MWD+SRGM", legs), ("GYRO-NS-CT", ""), ("GYRO-NS-CT", legs)):
            self.run_config(well.replace("iscwsa_mwd_rev5.10", model) + more, "--set", "errors.sources=quadrature", "--overwrite")
            taken = {(r["source"], r["mode"]) for r in self.table("by_source")}
            told = self.call("check", "well.toml", "--set", "errors.sources=quadrature")
            left = set(re.findall(r"(\S+) \((\w)\)", re.search(r"leaves out (.*)", told.stderr + told.stdout)[1]))
            self.assertFalse(taken & left)
            # What has no effect at all is in neither, but every source has some in this well.
            terms = subprocess.run([EXECUTABLE, "models", model], capture_output=True, text=True, check=True).stdout
            listed = set(re.findall(r'code = "(\S+)",.* mode = "(\w)"', terms))
            self.assertTrue(listed)
            self.assertEqual(listed - taken, left & listed)

    def test_a_sampled_source_is_what_quadrature_says(self):
        self.run_config(WELL, "--set", "errors.sources=[\"AMIL\"]", "--set", "errors.multiplier=5")
        (sampled,) = self.table("by_source", formulation="minimum_curvature", quantity="sd_along")
        self.run_config(WELL, "--set", "errors.sources=quadrature", "--set", "errors.multiplier=5")
        (exact,) = self.table("by_source", formulation="minimum_curvature", quantity="sd_along", source="AMIL")
        half = (float(sampled["monte_carlo_ci_high"]) - float(sampled["monte_carlo_ci_low"])) / 2
        self.assertLess(abs(float(sampled["monte_carlo"]) - float(exact["monte_carlo"])), 3 * half + 1e-9)
        self.assertLess(half, 0.01 * float(exact["monte_carlo"]))

    def test_between_stations_high_side_is_that_of_the_hole_there(self):
        (self.path / "bend.csv").write_text("md_m,inclination_deg,azimuth_deg\n0,0,0\n300,0,0\n400,60,0\n500,90,90\n")
        (self.path / "tool.toml").write_text(
            'first_leg = "once"\nterms = [{ code = "DRFR", function = "DREF", magnitude = 0.35, unit = "m", mode = "R" }]\n')
        self.run_config(re.sub(r"report_md_m.*\n", "report_md_m = [150.0, 350.0, 400.0]\n", re.sub(r"\[well\][^[]*", "", WELL))
                        .replace('error_model = "iscwsa_mwd_rev5.10"\n', "") +
                        '[survey]\nfile = "bend.csv"\nunusual = "allow"\n[error_model]\nfile = "tool.toml"\n')

        def row(depth, direction):
            return [r for r in self.table("position_hla", formulation="iscwsa", quantity=f"sd_{direction}")
                    if float(r["md_m"]) == depth][0]
        # A vertical hole has its depth error along it, also where the next station is not vertical: half of the variance.
        self.assertAlmostEqual(float(row(150, "along_hole")["analytic"]), 0.35 / 2 ** 0.5, delta=1e-12)
        self.assertEqual(row(150, "high_side")["note"], "zero to first order")
        # At 350 m the hole has 30 deg. Half of the covariances at 300 and 400 m; balanced tangential, the leg's depth error e
        # lies along its mean direction m: e t at 300 m; at 400 m e (t - m) of the station before and e m of the next, t
        # vertical. High side h = (cos 30, 0, -sin 30).
        s, c = 3 ** 0.5 / 2, 0.5
        mean = ((0 + s) / 2, (1 + c) / 2)  # north, down
        for direction, (n, v) in (("high_side", (s, -0.5)), ("along_hole", (0.5, s))):
            to = mean[0] * n + mean[1] * v
            expected = 0.35 * ((v ** 2 + (v - to) ** 2 + to ** 2) / 2) ** 0.5
            self.assertAlmostEqual(float(row(350, direction)["analytic"]), expected, delta=1e-9)

    def test_effects_cancel_by_code_and_mode(self):
        # The second tool's systematic error is small beside the random one of the same code above it, but whole.
        (self.path / "tools.toml").write_text("".join(
            f'[[model]]\nname = "{name}"\nfirst_leg = "once"\n'
            f'terms = [{{ code = "AMX", function = "AZ", magnitude = {size}, unit = "deg", mode = "{mode}" }}]\n'
            for name, size, mode in (("above", 3.0, "R"), ("below", 0.3, "S"))))
        tool = '{{ file = "tools.toml", name = "{}" }}'
        self.run_config(WELL.replace('"iscwsa_mwd_rev5.10"', tool.format("above"))
                        + f'[[leg]]\nfrom_md_m = 810.0\nerror_model = {tool.format("below")}\n',
                        "--set", "errors.sources=each")
        (row,) = self.table("by_source", formulation="iscwsa", mode="S")
        self.assertEqual(row["note"], "")
        self.assertEqual(row["verdict"], "agrees")

    def test_a_source_whose_effects_cancel_is_not_judged(self):
        # There and back: an azimuth error turns the well about its beginning, to which it returns.
        rows = ["md_m,inclination_deg,azimuth_deg"]
        rows += [f"{30 * k},90,{0 if k <= 30 else min(178, 30 * (k - 30))}" for k in range(67)]
        (self.path / "there_and_back.csv").write_text("\n".join(rows) + "\n")
        self.run_config(re.sub(r"\[well\][^[]*", '[survey]\nfile = "there_and_back.csv"\n', WELL)
                        .replace("[900.0]", "[900.0, 1980.0]"), "--set", 'errors.sources=["DEC-U"]')
        (before,) = self.table("by_source", formulation="iscwsa", md_m="900")
        (back,) = self.table("by_source", formulation="iscwsa", md_m="1980")
        self.assertEqual(before["note"], "")
        self.assertIn("nearly cancel", back["note"])

    def test_stations_beyond_the_range_of_the_model_are_marked(self):
        self.run_config(WELL.replace("iscwsa_mwd_rev5.10", "INC-ONLY"))
        # 3 deg / 30 m from 300 m on: above the 30 deg of the model from 630 m on.
        (row,) = self.table("validity")
        self.assertEqual((row["rule"], float(row["first_md_m"]), float(row["last_md_m"])), ("inclination range", 630, 900))
        (warning,) = self.table("warnings")
        self.assertEqual(warning["place"], "INC-ONLY")
        self.assertIn("inclination range: 10 stations, md 630 to 900 m", warning["message"])
        self.run_config(WELL, "--overwrite")
        self.assertEqual(self.table("validity"), [])

    def test_a_gyro_is_drawn_too(self):
        text = WELL.replace("iscwsa_mwd_rev5.10", "GYRO-NS-CT").replace("dip_deg = 72.0", "dip_deg = 72.0\nlatitude_deg = 60.0")
        self.run_config(text, "--set", "errors.multiplier=0.1")
        for axis in (1, 2, 3):
            (row,) = self.table("axes", formulation="minimum_curvature", quantity=f"sd_axis_{axis}")
            self.assertLess(abs(float(row["ratio"]) - 1), 2e-3)

    def test_a_trial_is_printed_again(self):
        self.run_config(WELL + "[verdict]\nmargin = 0.1\n", "--set", "save_samples=10", "--set", "antithetic=true")
        text = self.call("run", "well.toml", "--set", "antithetic=true", "--trial", "7").stdout
        rows = list(csv.DictReader(io.StringIO(self.call("show", "well.h5", "realisations", "--csv").stdout)))
        self.assertIn(f"north {float(rows[7]['north_m']):.17g} m", text)
        pair = self.call("run", "well.toml", "--set", "antithetic=true", "--trial", "6").stdout
        values = [float(re.search(r"AMIL.*: (\S+)", t)[1]) for t in (text, pair)]
        self.assertEqual(values[0], -values[1])


class Events(Case):
    EVENT = '[[event]]\nname = "far"\nquantity = "lateral_in_sd"\nabove = 5.0\n[sampling]\nmethod = "importance"\npilot = 400\nsubset = { replicates = 0 }\n'
    LAW = '[reference_law]\ndeclination = { law = "nig", shape = 0.2, size = "sd" }\nmodes = ["R"]\n'
    EXPECT = '[[expect]]\ntable = "probability"\nformulation = "%s"\nquantities = ["probability"]\nverdict = "%s"\n'

    def test_draws_of_deeper_stations_are_no_part_of_an_event_in_mid_well(self):
        level = WELL.replace("60.0", "90.0").replace("80.0", "0.0").replace("iscwsa_mwd_rev5.10", "MWD+IFR1")
        level = level.replace("report_md_m = [900.0]\n", "").replace("length_m = 900", "length_m = 1500")
        depths = [30.0 * k for k in range(11, 24)]
        self.run_config(level + self.LAW + self.EVENT + f"[sweep]\nreport_md_m = {[[d] for d in depths]}\n")
        rows = self.table("probability", formulation="first_order")
        self.assertEqual(len(rows), len(depths))
        for row in rows:  # stations with a V each: nearly normal
            self.assertLess(abs(float(row["ratio"]) - 1), 0.15, row)
        sources = {r["code"] for r in self.table("importance")}
        self.assertIn("variance of the reference", sources)
        self.assertNotIn("", sources)

    def test_an_expectation_of_a_row_that_is_not_there_is_not_met(self):
        for quantity, formulation, law in (("lateral_in_sd", "form", "nig"), ("lateral_m", "first_order", "asymmetric_nig")):
            skew = "skew = 1.0, " if law != "nig" else ""
            text = WELL + self.LAW.replace('"nig", ', f'"{law}", {skew}') + self.EVENT.replace("lateral_in_sd", quantity)
            text = text.replace("above = 5.0", "above = 500.0").replace("modes", "each_term = true\nmodes") if quantity == "lateral_m" else text
            for verdict in ("agrees", "differs"):
                (self.path / "well.toml").write_text(text + self.EXPECT % (formulation, verdict))
                run = self.call("run", "well.toml", "-o", "well.h5", "--overwrite", "--check")
                self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
                (row,) = self.table("probability", formulation=formulation)
                self.assertEqual((row["verdict"], row["expected"]), ("", verdict))

    def test_form_is_no_row_of_an_event_of_two_sides(self):
        for quantity, limit, form in (("lateral_in_sd", 5.0, False), ("lateral_m", 200.0, True)):
            self.run_config(WELL + self.EVENT.replace("lateral_in_sd", quantity).replace("5.0", str(limit)), "--overwrite")
            self.assertEqual({r["formulation"] for r in self.table("probability")},
                             {"first_order", "form"} if form else {"first_order"})


class BadInput(Case):
    def test_values_are_refused_with_place_and_rule(self):
        self.refused(WELL + "[errors]\nmultiplier = 0.0\n", "errors.multiplier = 0", "must be in (0, 1000]")
        self.refused(WELL + "[errors]\nsources = [\"AMILL\"]\n", "errors.sources", "AMILL")
        self.refused(WELL.replace("[900.0]", "[900.0, 901.0]"), "report_md_m", "901 is off the survey")
        self.refused(WELL.replace("[900.0]", "[600.0, 300.0]"), "report_md_m", "must increase")
        self.refused(WELL.replace("trials = 2000", "trials = 2001\nantithetic = true"), "trials = 2001", "even")
        self.refused(WELL + "[survey]\nfile = \"well.csv\"\n", "survey.file", "not together with [well]")
        self.refused("formulations = [\"iscwsa\", \"linear\"]\n" + WELL, "formulations", "linear")
        self.refused(WELL + "[errors]\nvertical = \"lateral\"\n", "errors.vertical", "tilt")

    def test_references_that_cannot_be_drawn_or_judged_are_refused(self):
        law = '[reference_law]\ndeclination = { law = "laplace", size = "sd" }\n'
        self.refused(WELL + law + "[tails]\nk = [3.0, 3.0]\n", "tails.k", "must increase")
        storm = '[disturbance]\nkind = "storm"\nmatch = "variance"\nrise_s = 0.0\ndrilling_m_per_h = 30.0\n'
        self.refused(WELL + storm + "storms_per_day = 1e9\ndecay_s = 100.0\n", "storms_per_day", "storms a run")
        self.refused(WELL + storm + "storms_per_day = 1.0\ndecay_s = 1e12\n", "storms_per_day", "storms a run")
        (self.path / "hour.csv").write_text("time,x_nT,y_nT,z_nT\n" + "".join(
            f"2016-01-01T00:{m:02d}:00,{m},{m * m},0\n" for m in range(60)))
        series = '[disturbance]\nkind = "series"\nmatch = "none"\nfile = "hour.csv"\n'
        self.refused(WELL + series + "drilling_m_per_h = 30.0\n", "has 1 h, and the run takes 30 h")
        event = '[[event]]\nname = "far"\nquantity = "lateral_in_sd"\nabove = 5.0\n'
        self.refused(WELL + event + storm + "storms_per_day = 1.0\ndecay_s = 100.0\n", "only \"ar1\" is normal")
        self.refused(WELL.replace("[900.0]", "[885.0]") + event, "report_md_m", "must be one station")
        lateral = event.replace("in_sd", "m")
        self.refused(WELL + lateral.replace("above", "below"), "below = 5", "must be one that draws cause")
        self.refused(WELL + event.replace("above = ", "below = -"), "event[0].below = -5", "is not rare: give `above`")
        self.refused(WELL + event.replace("5.0", "-5.0"), "event[0].above = -5", "never below 0: must be > 0")
        self.refused('formulations = ["second"]\n' + WELL + event, "formulations", "a run of [[event]] has none")
        self.refused(WELL + event + "[tails]\nk = [3.0]\n", "tails", "a run of [[event]] has none")
        expect = '[[expect]]\ntable = "probability"\nformulation = "normal"\nquantities = ["probability"]\nverdict = "agrees"\n'
        self.refused(WELL + event + expect, 'no row "probability" of "normal"')
        self.run_config(WELL.replace("2000", "20") + series + "drilling_m_per_h = 1000.0\n")

    def test_times_that_cannot_be_read_are_not_missing_as_well(self):
        (self.path / "timed.csv").write_text("md_m,inclination_deg,azimuth_deg,time_s\n0,0,0,0\n30,1,10,soon\n60,2,10,7200\n")
        (self.path / "well.toml").write_text(
            'experiment = "error_model_monte_carlo"\nseed = 1\ntrials = 1000\nsurvey.file = "timed.csv"\n'
            'field = { total_nT = 50000.0, dip_deg = 70.0 }\nerror_model = "MWD+SRGM"\n'
            'disturbance = { kind = "ar1", match = "variance", tau_s = 20000.0 }\n')
        check = self.call("check", "well.toml")
        self.assertEqual(check.returncode, BAD_INPUT)
        self.assertRegex(check.stderr, r'timed.csv:3: time_s = "soon"')
        self.assertNotIn("drilling_m_per_h", check.stderr)

    def test_references_that_few_trials_see_are_warned_of(self):
        storm = '[disturbance]\nkind = "storm"\nmatch = "variance"\nrise_s = 0.0\ndecay_s = 1000.0\ndrilling_m_per_h = 30.0\n'
        for text, says in ((storm + "storms_per_day = 1e-3\n", "disturbance.storms_per_day"),
                           ('[reference_law]\ndeclination = { law = "student", degrees = 3.0, size = "sd" }\n', "excess kurtosis of inf")):
            (self.path / "well.toml").write_text(WELL + text)
            check = self.call("check", "well.toml")
            self.assertEqual(check.returncode, DONE, check.stderr)
            self.assertIn(says, check.stderr + check.stdout)
        (self.path / "well.toml").write_text(WELL + storm + "storms_per_day = 5.0\n")
        self.assertNotIn("warning", self.call("check", "well.toml").stderr)

    def test_a_pole_of_the_model_is_refused(self):
        text = WELL.replace("iscwsa_mwd_rev5.10", "GYRO-NS").replace("inclination_deg = 60.0", "inclination_deg = 90.0")
        text = text.replace("[field]", "build_deg_per_30m = 6.0\n[field]\nlatitude_deg = 60.0")
        self.refused(text, "has no finite effect at 750 m")
        # A depth between stations depends on the station below it.
        self.refused(text.replace("[900.0]", "[300.0, 735.0]"), "has no finite effect at 750 m")
        self.run_config(text.replace("[900.0]", "[300.0, 720.0]"))


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    EXECUTABLE, SOURCE = str(Path(sys.argv.pop(1)).resolve()), Path(sys.argv.pop(1)).resolve()
    unittest.main()
