#!/usr/bin/python3
"""End-to-end tests of drift_monitoring: test_drift_monitoring.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, Case, column

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
        path = self.run_config("--set", "source.bad_rows=skip", config="csv.toml", output="csv.h5")
        found = {r["finding"]: (r["rows"], r["lines"]) for r in rows(path, "data_quality")}
        self.assertEqual((found["text"], found["zero"]), ((1, "21"), (1, "31")))
        self.assertEqual(found["gap"], (2, "22 32"))
        self.assertEqual(found["good_rows"][0], 78)
        path = self.run_config("--set", "source.bad_rows=skip", "--set", "source.zeros_are_bad=false", config="csv.toml",
                               output="zeros.h5")
        self.assertEqual({r["finding"]: r["rows"] for r in rows(path, "data_quality")}["zero"], 0)

    def test_bad_settings(self):
        for setting, says in (("source.name=olga", "must be one of"), ("source.sample_s=62", "multiple of the 5 s"),
                              ("source.train_h=60", "samples to monitor"), ("model.bandwidth=0", "must be"),
                              ("model.memory_vectors=7", "must be"), ("model.memory_vectors=5000", "training samples"),
                              ("drift.pattern=[1.0]", "4"), ("drift.start_h=40", "before the end"),
                              ("sprt.false_alarm=0.6", "must be"), ('architecture=["aakr"]', "aakr_sprt"),
                              ("filter.gates=1", "gate"), ("source.injection_kgps=[-1.0]", "must be")):
            with self.subTest(setting=setting):
                self.refused(BAD_INPUT, "run", "base.toml", "--set", setting, says=says)

    def test_one_architecture(self):
        path = self.run_config("--set", 'architecture="aakr_kf_sprt"')
        self.assertEqual({r["architecture"] for r in rows(path, "alarms")}, {"aakr_kf_sprt"})
        self.assertEqual(len(rows(path, "claims")), 1)


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
