#!/usr/bin/python3
"""End-to-end tests of drift_monitoring: test_drift_monitoring.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, Case, column, content_hash

CONFIG = """\
experiment = "drift_monitoring"
seed = 3
trials = 6
[source]
name = "gas_lift_well"
step_h = 1.0
sample_s = 300.0
train_h = 12.0
[model]
bandwidth = 0.3
memory_vectors = 40
[drift]
pattern = [1.0, 0.0, 0.0, 0.0]
amplitude_z = 6.0
start_h = 3.0
[filter]
process_variance_z2 = 1e-3
"""


def rows(path, table):
    with h5py.File(path) as f:
        g = f["tables"][table]
        columns = {k: (d.asstr()[()] if h5py.check_string_dtype(d.dtype) else d[()]) for k, d in g.items()}
    return [dict(zip(columns, v)) for v in zip(*columns.values())]


class Monitoring(Case):
    def setUp(self):
        super().setUp()
        self.write("base.toml", CONFIG)

    def test_tables_and_series(self):
        path = self.run_config()
        with h5py.File(path) as f:
            self.assertLessEqual({"metrics", "alarms", "delay", "blame", "claims", "model", "series"}, set(f["tables"]))
        series = [r for r in rows(path, "series") if r["sensor"] == "PT_f"]
        self.assertEqual(len(series), 18 * 12)  # 18 h, a sample every 5 min
        for r in series:  # linear from 3 h to the last sample at 18 h less 5 min
            self.assertAlmostEqual(r["drift_z"], max(0, 6 * (r["time_h"] - 3) / (18 - 1 / 12 - 3)), delta=1e-12)
            self.assertAlmostEqual(r["signal_aakr_sprt"], r["reading_z"] - r["prediction_aakr_sprt"], delta=1e-12)
        self.assertTrue(all(r["drift_z"] == 0 for r in rows(path, "series") if r["sensor"] != "PT_f"))
        alarm = {(r["architecture"], r["sensor"]): r for r in rows(path, "alarms")}
        decided = [r["time_h"] for r in series if r["decision_aakr_kf_sprt"] != 0]
        self.assertAlmostEqual(alarm["aakr_kf_sprt", "PT_f"]["first_alarm_h"], decided[0], delta=1e-12)
        self.assertEqual(len(rows(path, "delay")), 4)  # one drifting sensor, four methods
        model = rows(path, "model")
        self.assertEqual([r["item"] for r in model[:4]], ["mean", "sd", "bandwidth", "memory"])
        self.assertEqual(len(model), 43)

    def test_same_bits_for_any_number_of_threads_and_again(self):
        one = self.run_config("--threads", "1", output="one.h5")
        three = self.run_config("--threads", "3", output="three.h5")
        with h5py.File(one) as a, h5py.File(three) as b:
            self.assertEqual(a.attrs["content_hash"], b.attrs["content_hash"])
        self.assertRegex(self.call("rerun", one).stdout, "^identical")

    def test_first_realisations_do_not_depend_on_how_many_follow(self):
        few, many = self.run_config(output="few.h5"), self.run_config("--trials", "9", output="many.h5")
        for name in ("first_alarm_h", "alarms"):
            np.testing.assert_array_equal(column(few, "tables/alarms", name), column(many, "tables/alarms", name))

    def test_what_points_share_is_what_each_computes_alone(self):
        # Two with the same predictions with drift, three with the same without, one with none in common. Before the
        # drift begins, and with another number of threads, which find and keep in another order.
        cases = {"base": {}, "shift": {"sprt.shift_z": 2.0}, "weak": {"drift.amplitude_z": 2.0},
                 "narrow": {"model.bandwidth": 0.2}}
        sweep = "".join(f'[[sweep.case]]\nname = "{name}"\n' + "".join(f'"{k}" = {x}\n' for k, x in keys.items())
                        for name, keys in cases.items())
        calibrated = CONFIG + "[baselines]\ncalibration_trials = 4\n"
        self.write("sweep.toml", calibrated + sweep)
        self.write("base.toml", calibrated)
        together = self.run_config("--threads", "3", config="sweep.toml", output="together.h5")
        for name, keys in cases.items():
            alone = self.run_config(*(a for k, x in keys.items() for a in ("--set", f"{k}={x}")), output=f"{name}.h5")
            for table in ("alarms", "delay", "blame", "metrics", "claims", "baselines", "model"):
                mine = [{k: x for k, x in r.items() if k not in ("case", "row", "sweep_point")}
                        for r in rows(together, table) if r["case"] == name]
                own = [{k: x for k, x in r.items() if k != "row"} for r in rows(alone, table)]
                self.assertEqual(len(mine), len(own))
                for a, b in zip(mine, own):
                    for key in b:
                        self.assertTrue(a[key] == b[key] or a[key] != a[key] and b[key] != b[key], (name, table, key))

    def test_train_once_and_monitor_later(self):
        trained = self.run_config("--trials", "1", output="trained.h5")
        self.write("later.toml", CONFIG.replace("bandwidth = 0.3\nmemory_vectors = 40", 'file = "trained.h5"'))
        path = self.run_config("--trials", "1", config="later.toml", output="later.h5")
        # The same realisation with the model it was trained on: the same series.
        for name in ("prediction_aakr_sprt", "signal_aakr_kf_sprt"):
            np.testing.assert_array_equal(column(trained, "tables/series", name), column(path, "tables/series", name))
        (self.folder / "trained.h5").unlink()
        self.assertRegex(self.call("rerun", path).stdout, "^identical")  # the model is in the result

    def test_a_model_of_other_sensors_is_refused(self):
        self.run_config("--trials", "1", output="trained.h5")
        lines = ["time_min,PT_f_kPa,PT_t_kPa,PT_g_kPa"] + [f"{i},1{i % 7},2{i % 5},3{i % 3}" for i in range(50)]
        self.write("gauges.csv", "\n".join(lines) + "\n")
        source = ('experiment = "drift_monitoring"\nseed = 1\n[source]\nname = "csv"\nfile = "gauges.csv"\n'
                  'time = "time_min"\nsensors = ["PT_f_kPa", "PT_t_kPa", "PT_g_kPa"]\n[drift]\nstart_h = 0.1\n')
        self.write("later.toml", source + '[model]\nfile = "trained.h5"\n')
        self.refused(BAD_INPUT, "run", "later.toml", says="trained on other sensors")
        self.write("later.toml", source + '[model]\nfile = "gauges.csv"\n')
        self.refused(BAD_INPUT, "run", "later.toml", says=r"later\.toml:\d+: model\.file")

    def test_csv_policies(self):
        lines = ["time_min,a_kPa,b_kPa"]
        lines += [f"{i},{100 + i % 7},{50 - i % 7 + 0.01 * (i % 3)}" for i in range(80)]
        lines[20] = lines[20].replace(lines[20].split(",")[1], "bad")
        lines[30] = "29,0,50"
        self.write("gauges.csv", "\n".join(lines) + "\n")
        text = ('experiment = "drift_monitoring"\nseed = 1\n[source]\nname = "csv"\nfile = "gauges.csv"\n'
                'time = "time_min"\nsensors = ["a_kPa", "b_kPa"]\ntrain_h = 0.7\n'
                '[model]\nmemory_vectors = 10\n[drift]\nstart_h = 0.1\npattern = [1.0, 0.0]\n')
        self.write("csv.toml", text)
        self.refused(BAD_INPUT, "run", "csv.toml", says=r"text for a sensor: 1 \(line 21\); .*reads zero: 1 \(line 31\)")
        self.write("unsorted.csv", "\n".join(lines[:40] + ["5,101,50"] + lines[40:]) + "\n")
        self.refused(BAD_INPUT, "run", "csv.toml", "--set", "source.file=unsorted.csv",
                     says=r"before that of an earlier row: 1 \(line 41\).* sort the file by time first")
        path = self.run_config("--set", "source.bad_rows=skip", config="csv.toml", output="csv.h5")
        found = {r["finding"]: (r["rows"], r["lines"]) for r in rows(path, "data_quality")}
        self.assertEqual((found["text"], found["zero"]), ((1, "21"), (1, "31")))
        self.assertEqual(found["gap"], (2, "22 32"))
        self.assertEqual(found["good_rows"][0], 78)
        path = self.run_config("--set", "source.bad_rows=skip", "--set", "source.zeros_are_bad=false", config="csv.toml",
                               output="zeros.h5")
        self.assertEqual({r["finding"]: r["rows"] for r in rows(path, "data_quality")}["zero"], 0)

    def test_units_of_time_change_no_number(self):
        """Samples at the start of the drift are part of it, whatever rounding did to their times."""
        rows_of = [(6 * i, 100 + i % 7, 50 - i % 7 + 0.01 * (i % 3)) for i in range(200)]
        found = []
        for unit, minutes, day in (("min", 1, 0), ("s", 1 / 60, 3), ("h", 60, 3), ("d", 1440, 45000)):  # as of a spreadsheet
            self.write("gauges.csv", f"time_{unit},a_kPa,b_kPa\n" + "".join(
                f"{(day * 1440 + t) / minutes!r},{a},{b}\n" for t, a, b in rows_of))
            self.write("csv.toml",
                       'experiment = "drift_monitoring"\nseed = 1\n[source]\nname = "csv"\nfile = "gauges.csv"\n'
                       f'time = "time_{unit}"\nsensors = ["a_kPa", "b_kPa"]\ntrain_h = 8.0\n'
                       '[model]\nmemory_vectors = 10\n[drift]\nstart_h = 0.1\npattern = [1.0, 0.0]\n')
            for start in range(1, 40, 3):
                path = self.run_config("--set", f"drift.start_h={start / 10}", config="csv.toml", output="csv.h5")
                value = {r["quantity"] + r["formulation"]: r["monte_carlo"] for r in rows(path, "metrics")}
                found.append((start, unit, value))
        for start, unit, value in found:
            of_minutes = next(v for s, u, v in found if s == start and u == "min")
            for name, x in value.items():
                np.testing.assert_allclose(x, of_minutes[name], rtol=1e-7, atol=1e-12, err_msg=f"{start} {unit} {name}")

    def test_a_file_too_large_to_be_stored(self):
        """More than 16 MiB: name, size, hash and header are stored; the same numbers as of a file that is held."""
        row = "{},{:.1f},{:.1f}" + 80 * " " + "\n"
        lines = [row.format(i, 100 + i % 7 + i % 1000 / 100, 50 - i % 7 + 0.01 * (i % 3)) for i in range(180_000)]
        lines[120_000] = "120000,,50\n"
        text = "time_min,a_kPa,b_kPa\n" + "".join(lines)
        self.assertGreater(len(text), 1 << 24)
        self.write("long.csv", text)
        self.write("short.csv", "time_min,a_kPa,b_kPa\n" + "".join(line.replace(" ", "") for line in lines))
        self.write("csv.toml",
                   'experiment = "drift_monitoring"\nseed = 1\n[source]\nname = "csv"\nfile = "long.csv"\n'
                   'time = "time_min"\nsensors = ["a_kPa", "b_kPa"]\ntrain_fraction = 0.6\ntraining_rows = 5000\n'
                   'bad_rows = "skip"\n[model]\nmemory_vectors = 20\n[drift]\nstart_h = 10.0\npattern = [1.0, 0.0]\n')
        self.refused(BAD_INPUT, "run", "csv.toml", "--set", "source.bad_rows=reject", says=r"empty.*: 1 \(line 120002\)")
        long = self.run_config(config="csv.toml", output="long.h5")
        short = self.run_config("--set", "source.file=short.csv", config="csv.toml", output="short.h5")
        with h5py.File(long) as a, h5py.File(short) as b:
            self.assertEqual(list(a["inputs/long"]), ["row", "file_hash", "size_bytes", "header"])
            self.assertEqual(a["inputs/long/size_bytes"][0], len(text))
            self.assertEqual(a["inputs/long/header"].asstr()[0], "time_min,a_kPa,b_kPa")
            self.assertEqual(len(b["inputs/short/line"]), 180_002)
            for table in ("metrics", "alarms", "delay", "model", "series", "data_quality"):
                for name in a["tables"][table]:
                    np.testing.assert_array_equal(a["tables"][table][name][()], b["tables"][table][name][()])
            self.assertLessEqual(len(a["tables/series/row"]), 2 * 60_000)
            self.assertGreater(len(a["tables/series/row"]), 2 * 30_000)
        found = {r["finding"]: r for r in rows(long, "data_quality")}
        self.assertLessEqual(found["training_rows"]["rows"], 5000 + 4)
        self.assertRegex(found["training_rows"]["action"], "of 107999: every 22th")

        self.call("run", "csv.toml", "--point", 0, "-o", "parts/")
        merged = lambda *more: (self.call("merge", "parts", "-o", "merged.h5", *more), content_hash(self.folder / "merged.h5"))[1]
        self.assertEqual(merged(), content_hash(long))

        self.assertRegex(self.call("rerun", long).stdout, "^identical")  # the file is in this folder
        self.assertRegex(self.call("rerun", "short.h5").stdout, "^identical")
        (self.folder / "moved").mkdir()
        (self.folder / "long.csv").rename(self.folder / "moved/long.csv")
        self.refused(BAD_INPUT, "rerun", "long.h5", says="is not stored with this config .* --inputs")
        self.refused(BAD_INPUT, "merge", "parts", "-o", "merged.h5", says="is not stored with this config .* --inputs")
        self.assertEqual(merged("--inputs", "moved"), content_hash(long))
        self.assertRegex(self.call("rerun", "long.h5", "--inputs", "moved").stdout, "^identical")
        self.write("moved/long.csv", text.replace("1,", "2,", 1))
        self.refused(BAD_INPUT, "rerun", "long.h5", "--inputs", "moved", says="is another one")

    def test_training_on_part_of_the_rows_keeps_the_extremes(self):
        lines = ["time_min,a_kPa,b_kPa"] + [f"{i},{100 + i % 7 + 0.001 * i},{50 - i % 5}" for i in range(9000)]
        lines[1 + 777] = "777,190,50"
        lines[1 + 3331] = "3331,100,7"
        self.write("gauges.csv", "\n".join(lines) + "\n")
        self.write("csv.toml",
                   'experiment = "drift_monitoring"\nseed = 1\n[source]\nname = "csv"\nfile = "gauges.csv"\n'
                   'time = "time_min"\nsensors = ["a_kPa", "b_kPa"]\ntrain_fraction = 0.5\ntraining_rows = 1000\n'
                   '[model]\nmemory_vectors = 10\n[drift]\nstart_h = 1.0\n')
        model = rows(self.run_config(config="csv.toml"), "model")
        of = lambda j: [model[0][j] + model[1][j] * r[j] for r in model[3:]]  # noqa: E731
        self.assertAlmostEqual(max(of("a_kPa")), 190, delta=1e-9)
        self.assertAlmostEqual(min(of("b_kPa")), 7, delta=1e-9)

    def test_series_never_hide_an_alarm_between_the_rows_they_keep(self):
        path = self.run_config("--set", "series_rows=10")
        series = [r for r in rows(path, "series") if r["sensor"] == "PT_f"]
        self.assertEqual(len(series), 10)
        self.assertAlmostEqual(series[-1]["time_h"], 18 - 1 / 12, delta=1e-9)
        first = next(r for r in rows(path, "alarms") if r["architecture"] == "aakr_sprt" and r["sensor"] == "PT_f")
        held = [r["time_h"] for r in series if r["decision_aakr_sprt"] != 0]
        self.assertLess(held[0] - first["first_alarm_h"], 18 / 9)
        self.assertGreaterEqual(held[0], first["first_alarm_h"])

    def test_baselines_are_calibrated_on_draws_of_their_own(self):
        fixed = self.run_config(output="fixed.h5")
        path = self.run_config("--set", "baselines.calibration_trials=30", "--set", "sprt.shift_z=2.5",
                               "--trials", "60", output="calibrated.h5")
        base = {r["architecture"]: r for r in rows(path, "baselines")}
        k = base["aakr_sprt"]["calibration_alarms"]
        self.assertTrue(0 < k < 30, k)  # at this shift some runs have a false alarm, and not all
        self.assertEqual(base["aakr_threshold"]["calibration_trials"], 30)
        self.assertEqual({r["value_z"] for r in rows(fixed, "baselines") if r["architecture"] == "aakr_threshold"}, {3.0})
        # On the draws of the run they are about as rare: binomials of 30 and of 60, four standard errors.
        with_alarm = {m: max(r["p_alarm_without_drift"] for r in rows(path, "alarms") if r["architecture"] == m)
                      for m in ("aakr_cusum", "aakr_threshold")}
        for p in with_alarm.values():
            self.assertLess(p, k / 30 + 4 * (0.25 / 30 + 0.25 / 60)**0.5)
        self.refused(BAD_INPUT, "run", "base.toml", "--set", "baselines.calibration_trials=5", "--set",
                     "baselines.threshold_z=1.0", says="leave out")

    def test_operating_curves_are_those_of_runs_at_these_settings(self):
        path = self.run_config("--set", "operating.shift_z=[1.0, 2.0]", "--set", "operating.threshold_z=0.7")
        operating = {(r["architecture"], r["value_z"]): r for r in rows(path, "operating")}
        self.assertEqual(set(operating), {(a, m) for a in ("aakr_sprt", "aakr_kf_sprt") for m in (1.0, 2.0)} |
                         {("aakr_threshold", 0.7)})
        other = self.run_config("--set", "sprt.shift_z=1.0", "--set", "baselines.threshold_z=0.7", output="other.h5")
        for method, value in (("aakr_sprt", 1.0), ("aakr_kf_sprt", 1.0), ("aakr_threshold", 0.7)):
            delay = next(r for r in rows(other, "delay") if r["architecture"] == method)
            blame = next(r for r in rows(other, "blame") if r["architecture"] == method)
            for name in ("p_miss", "delay_q05_h", "delay_q50_h", "delay_q95_h"):
                self.assertEqual(operating[method, value][name], delay[name])
            self.assertEqual(operating[method, value]["p_healthy_blamed"], blame["p_healthy_blamed"])

    def test_bad_settings(self):
        for setting, says in (("source.name=olga", "must be one of"), ("source.sample_s=62", "multiple of the 5 s"),
                              ("source.train_h=60", "samples to monitor"), ("model.bandwidth=0", "must be"),
                              ("model.memory_vectors=7", "must be"), ("model.memory_vectors=5000", "training samples"),
                              ("drift.pattern=[1.0]", "4"), ("drift.start_h=40", "before the end"),
                              ("sprt.false_alarm=0.6", "must be"), ('architecture=["aakr"]', "aakr_sprt"),
                              ("filter.gates=1", "gate"), ("source.injection_kgps=[-1.0]", "must be")):
            with self.subTest(setting=setting):
                self.refused(BAD_INPUT, "run", "base.toml", "--set", setting, says=says)

    def test_settings_without_effect_are_refused(self):
        alone = ("--set", 'architecture="aakr_kf_sprt"')
        disabled = ("--set", "baselines.enabled=false")
        for settings, says in (
                (("--set", "source.out_of_range=true", "--set", f"source.injection_kgps={[0.6] * 30}"),
                 "source.out_of_range = true: must be left out"),
                ((*alone, "--set", "operating.threshold_z=0.7"), "operating.threshold_z = 0.7: has no effect without"),
                ((*alone, "--set", "baselines.calibration_trials=3"), "baselines.calibration_trials = 3: has no effect"),
                ((*alone, "--set", "baselines.cusum_allowance_z=0.4"), "baselines.cusum_allowance_z = 0.4: has no effect"),
                ((*disabled, "--set", "operating.cusum_threshold_z=[1.0, 2.0]"), "baselines.enabled = false: leave it out")):
            with self.subTest(settings=settings):
                self.refused(BAD_INPUT, "run", "base.toml", *settings, says=says)
        path = self.run_config(*alone, "--set", "operating.shift_z=1.0")  # a setting of the SPRT
        self.assertEqual({r["architecture"] for r in rows(path, "operating")}, {"aakr_kf_sprt"})

    def test_claims_about_drift_have_no_verdict_where_nothing_drifts(self):
        quiet = self.run_config("--set", "drift.amplitude_z=0.0", output="quiet.h5")
        verdicts = {r["quantity"]: (r["verdict"], r["monte_carlo"]) for r in rows(quiet, "claims")}
        self.assertIn(verdicts.pop("unfaulted_mse_is_higher")[0], ("agrees", "differs", "undecided"))
        self.assertEqual(len(verdicts), 5)
        for quantity, (verdict, value) in verdicts.items():
            self.assertEqual(verdict, "", quantity)
            self.assertTrue(np.isnan(value), quantity)
        drifting = {r["quantity"]: r["verdict"] for r in rows(self.run_config(), "claims")}
        self.assertNotIn("", drifting.values())

    def test_one_realisation_confirms_no_claim(self):
        for r in rows(self.run_config("--trials", "1"), "claims"):
            self.assertEqual(r["verdict"], "", r)
            self.assertTrue(np.isfinite(r["monte_carlo"]) and np.isnan(r["p_agrees"]), r)
            self.assertIn("no interval, no verdict", r["note"])

    def test_rate_of_alarms_is_per_monitored_hour(self):
        def run(name, gap_h, jump):
            lines = ["time_h,a_kPa,b_kPa"]
            for i in range(400):
                wave = i % 37 / 37 + 0.3 * (i * 7 % 11) / 11
                lines.append(f"{i / 60 + (gap_h if i >= 300 else 0):.8f},{100 + 10 * wave + (jump if i >= 200 else 0)},"
                             f"{50 + 3 * wave + 0.1 * (i % 5)}")
            self.write(f"{name}.csv", "\n".join(lines) + "\n")
            self.write(f"{name}.toml", f"""\
experiment = "drift_monitoring"
seed = 1
model = {{ bandwidth = 0.5, memory_vectors = 60 }}
drift.start_h = 1.0
[source]
name = "csv"
file = "{name}.csv"
time = "time_h"
sensors = ["a_kPa", "b_kPa"]
bad_rows = "skip"
train_fraction = 0.5
""")
            path = self.run_config(config=f"{name}.toml", output=f"{name}.h5")
            return {(r["architecture"], r["sensor"]): r for r in rows(path, "alarms")}["aakr_threshold", "a_kPa"]
        rate = "alarms_per_h_without_drift"
        whole, gap, jump = run("whole", 0, 0), run("gap", 5000, 0), run("jump", 0, 300)
        self.assertEqual((whole[rate], gap[rate]), (0, 0))
        # No alarm in 200 samples a minute apart: the upper bound of a Poisson count of 0.
        for r in (whole, gap):
            self.assertAlmostEqual(r[rate + "_ci_high"], -np.log(0.025) / (200 / 60), delta=1e-5)
        self.assertEqual(jump["first_alarm_h"], 0)
        self.assertAlmostEqual(jump[rate], 60, delta=1e-4)  # one alarm in one sample

    def test_one_architecture(self):
        path = self.run_config("--set", 'architecture="aakr_kf_sprt"')
        self.assertEqual({r["architecture"] for r in rows(path, "alarms")}, {"aakr_kf_sprt"})
        self.assertEqual(len(rows(path, "claims")), 1)


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
