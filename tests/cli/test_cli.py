#!/usr/bin/python3
"""End-to-end tests of the command line: test_cli.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]

Every test works in a folder of its own. Whatever a command is asked, three things hold (checked by Case.call): no crash,
no raw exception text, and nothing on stdout when it refuses.
"""
import contextlib
import csv
import fcntl
import io
import itertools
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest
from pathlib import Path

import h5py
import numpy as np

EXECUTABLE = None
SOURCE = None

DONE, UNEXPECTED, USAGE, BAD_INPUT, CANNOT_WRITE, INTERRUPTED = 0, 1, 64, 65, 74, 75
RAW_EXCEPTION = re.compile(r"terminate called|what\(\):|Traceback|internal error|HDF5-DIAG|Sanitizer|core dumped")

SURVEY = """\
md_m,inclination_deg,azimuth_deg,toolface_deg
0,10,20,0
30,14,25,50
60,18,30,120
90,22,37,200
120,28,44,300
150,33,52,40
"""

CONFIG = """\
experiment = "msa_position"
title = "Base"
seed = 1
trials = 600
estimator = "msa"
[survey]
file = "survey.csv"
toolface_zero = "y"
[field]
total_nT = 50000.0
dip_deg = 60.0
[noise]
magnetometer_nT = 50.0
"""

COUNT_TRIALS = {"parameters", "position", "ellipse", "parameter_correlation"}


def contents(path):
    """Every dataset and attribute outside /run, bit for bit; without the command that made the file."""
    out = {}

    def bits(value):
        value = np.asarray(value)
        return value.dtype.str, value.shape, value.tolist() if value.dtype.hasobject else value.tobytes()

    with h5py.File(path, "r") as f:
        def visit(name, item):
            if name == "run" or name.startswith("run/"):
                return
            for key, value in item.attrs.items():
                if key not in ("command", "DIMENSION_LIST", "REFERENCE_LIST"):
                    out[f"{name}@{key}"] = bits(value)
            if isinstance(item, h5py.Dataset):
                out[name] = bits(item[()])

        visit("/", f)
        f.visititems(visit)
    return out


def attribute(path, name, group="/"):
    with h5py.File(path, "r") as f:
        return f[group].attrs[name]


def content_hash(path):
    return attribute(path, "content_hash")


def stored_config(path):
    return tomllib.loads(attribute(path, "config"))


def column(path, table, name):
    with h5py.File(path, "r") as f:
        d = f[table][name]
        return d.asstr()[()] if h5py.check_string_dtype(d.dtype) else d[()]


class Case(unittest.TestCase):
    maxDiff = 4000

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="surveymc-cli-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.write("survey.csv", SURVEY)
        self.write("base.toml", CONFIG)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    def config(self, name, *changes, append=""):
        """Base config with each (old, new) replaced."""
        text = CONFIG
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new)
        return self.write(name, text + append)

    def call(self, *arguments, code=DONE, cwd=None, env=None, timeout=30, before=None):
        """Runs surveymc, asserts what holds for every command, returns what it printed."""
        done = subprocess.run([EXECUTABLE, *map(str, arguments)], cwd=cwd or self.folder, timeout=timeout,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              env={**os.environ, **(env or {})}, preexec_fn=before)
        done.stdout, done.stderr = done.stdout.decode(), done.stderr.decode()
        told = f"{' '.join(map(str, arguments))}\nstdout: {done.stdout[:2000]}\nstderr: {done.stderr[:2000]}"
        self.assertGreaterEqual(done.returncode, 0, f"killed by a signal: {told}")
        self.assertNotRegex(done.stdout + done.stderr, RAW_EXCEPTION, told)
        codes = code if isinstance(code, tuple) else (code,)
        self.assertIn(done.returncode, codes, told)
        if done.returncode not in (DONE, UNEXPECTED):
            self.assertEqual(done.stdout, "", told)
            self.assertNotEqual(done.stderr.strip(), "", told)
        return done

    def refused(self, code, *arguments, says=r"\S", **more):
        """The command fails with `code` and a message that matches `says`; no file appears or changes."""
        with self.untouched():
            done = self.call(*arguments, code=code, **more)
        self.assertRegex(done.stderr, says)
        return done.stderr

    def snapshot(self):
        return {str(p.relative_to(self.folder)): p.read_bytes() if p.is_file() else None
                for p in sorted(self.folder.rglob("*"))}

    @contextlib.contextmanager
    def untouched(self):
        before = self.snapshot()
        yield
        after = self.snapshot()
        self.assertEqual(sorted(before), sorted(after), "files appeared or vanished")
        for name in before:
            self.assertTrue(before[name] == after[name], f"{name} was changed")

    def run_config(self, *arguments, output="out.h5", config="base.toml", **more):
        """`run`, checked; the path of the result."""
        done = self.call("run", config, "-o", output, *arguments, **more)
        self.assertNotRegex(done.stdout, r"(?i)\bnan\b", "NaN reached a reader")
        return self.folder / output

    def table_csv(self, path, table, **more):
        rows = list(csv.reader(io.StringIO(self.call("show", path, table, "--csv", **more).stdout, newline="")))
        return rows[0], rows[1:]


class Basics(Case):
    def test_list_names_the_experiments(self):
        out = self.call("list").stdout
        self.assertRegex(out, r"(?m)^msa_position\s+\S+")
        self.assertRegex(out, r"(?m)^msa_benefit\s+\S+")

    def test_help_and_version(self):
        for command in ["list", "models", "check", "run", "plan", "merge", "status", "show", "rerun", "man", "completion", "keys", "new", "schema", "cite"]:
            self.assertIn(command, self.call("--help").stdout)
            self.assertIn("Usage", self.call(command, "--help").stdout)
        self.assertRegex(self.call("--version").stdout,
                         r"^surveymc \d+\.\d+\.\d+ \(\S+\)\ncompiler: +\S.*\nHDF5: +\d+\.\d+\.\d+\nMPI: +\S.*\n"
                         r"instruction set: x86-64-v[34]\nnumerics:        \d+, (?:GNU|Clang) [^\n]*, probe [0-9a-f]{8}, tallies [0-9a-f]{8}\n$")

    def test_check_prints_the_resolved_config_and_writes_nothing(self):
        with self.untouched():
            out = self.call("check", "base.toml").stdout
        config = tomllib.loads(out)
        self.assertEqual(config["experiment"], "msa_position")
        self.assertEqual((config["seed"], config["trials"], config["title"]), (1, 600, "Base"))
        self.assertEqual(config["field"], {"total_nT": 50000.0, "dip_deg": 60.0, "declination_deg": 0.0,
                                           "convergence_deg": 0.0, "gravity_mps2": 9.80665})
        self.assertEqual(config["noise"]["scale"], 1.0)
        self.assertEqual(config["noise"]["law"], "gaussian")
        self.assertEqual(config["noise"]["reference"]["per"], "none")
        self.assertEqual(config["sensor"], {"gain": [1.0, 1.0, 1.0], "bias_nT": [0.0, 0.0, 0.0],
                                            "spread": {"gain": 0.0, "bias_nT": 0.0, "axial_bias_nT": 0.0}})
        self.assertEqual(config["estimator"]["name"], "msa")
        self.assertEqual(config["survey"]["azimuth_reference"], "true")
        self.assertRegex(out, r"(?m)^# 1 sweep point, 600 trials in all\b")

    def test_check_of_shipped_configs(self):
        """One of each study; the tests configs.check.* check all of them."""
        chosen = {tomllib.loads(path.read_text()).get("experiment"): path for path in sorted((SOURCE / "configs").glob("*/*.toml"))}
        del chosen[None]  # no configs, but what configs name
        self.assertGreater(len(chosen), 15)
        for path in chosen.values():
            with self.subTest(config=path.name), self.untouched():
                config = tomllib.loads(self.call("check", path).stdout)
                self.assertEqual(config["experiment"], tomllib.loads(path.read_text())["experiment"])

    def test_resolved_config_is_the_same_run(self):
        resolved = self.call("check", "base.toml", "--set", "sweep.noise.scale=[1.0, 0.1]").stdout
        self.write("resolved.toml", resolved)
        self.assertEqual(self.call("check", "resolved.toml").stdout, resolved)
        a = self.run_config("--set", "sweep.noise.scale=[1.0, 0.1]", output="a.h5")
        b = self.run_config(config="resolved.toml", output="b.h5")
        self.assertEqual(content_hash(a), content_hash(b))
        self.assertEqual(contents(a), contents(b))

    def test_run_writes_what_show_prints(self):
        done = self.call("run", "base.toml", "-o", "out.h5", "--verbose")
        self.assertIn("wrote out.h5", done.stdout)
        self.assertRegex(done.stderr, "600 trials in all")
        shown = self.call("show", "out.h5", "--verbose").stdout
        for table in ["parameters", "position", "ellipse"]:
            self.assertRegex(shown, rf"(?m)^{table}: ")
            self.assertRegex(done.stdout, rf"(?m)^{table}: ")
        self.assertIn("Base", shown.splitlines()[0])
        self.assertEqual(attribute("%s/out.h5" % self.folder, "title"), "Base")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["base.toml", "out.h5", "survey.csv"])

    def test_the_answer_is_printed_stored_and_told_as_json(self):
        done = self.call("run", "base.toml", "-o", "out.h5")
        with h5py.File(self.folder / "out.h5") as f:
            answer = list(f["tables/answer/sentence"].asstr()[()])
        self.assertTrue(2 <= len(answer) <= 4)
        self.assertEqual(done.stdout.splitlines()[:len(answer)], answer)
        self.assertNotIn("parameters: ", done.stdout)
        shown = self.call("show", "out.h5").stdout.splitlines()
        self.assertEqual([line for line in shown if line in answer], answer)
        told = json.loads(self.call("run", "base.toml", "-o", "out.h5", "--overwrite", "--json").stdout)
        self.assertEqual(told["answer"], answer)
        self.assertEqual((told["file"], told["title"], told["verdicts"]["unexpected"]), ("out.h5", "Base", 0))
        self.call("run", "base.toml", "-o", "out.h5", "--json", "--verbose", code=USAGE)

    def test_compressed_results_are_the_same_results(self):
        size, content = {}, {}
        for level in ["0", "6"]:
            name = f"out{level}.h5"
            self.call("run", "base.toml", "-o", name, "--trials", "3000", "--set", "save_samples=3000", "--compress", level)
            size[level] = (self.folder / name).stat().st_size
            content[level] = attribute(f"{self.folder}/{name}", "content_hash")
        self.assertEqual(content["0"], content["6"])
        self.assertLess(size["6"], size["0"])
        self.assertEqual(self.call("show", "out6.h5", "--unchecked").stdout.splitlines()[2:],
                         self.call("show", "out0.h5").stdout.replace("out0", "out6").splitlines()[2:])
        self.call("run", "base.toml", "--compress", "10", code=USAGE)

    def test_default_output_is_in_results(self):
        self.call("run", "base.toml")
        self.assertEqual([p.name for p in (self.folder / "results").iterdir()], ["base.h5"])
        self.call("rerun", "results/base.h5")

    def test_results_is_a_file(self):
        self.write("results", "mine")
        self.refused(CANNOT_WRITE, "run", "base.toml", says="results")

    def test_empty_output_name_is_not_the_default(self):
        """`-o "$UNSET"` in a script must not write somewhere else."""
        self.refused((USAGE, BAD_INPUT, CANNOT_WRITE), "run", "base.toml", "-o", "", says="output|-o|name a file")


class Determinism(Case):
    def test_threads_do_not_change_a_bit(self):
        whole = None
        for threads in [1, 2, 3, 7]:
            path = self.run_config("--trials", 3000, "--threads", threads, "--set", "save_samples=3000",
                                   "--set", "noise.reference.per=run", "--set", "noise.reference.total_nT=100",
                                   output=f"{threads}.h5")
            self.assertEqual(attribute(path, "threads", "run"), threads)
            now = contents(path)
            self.assertGreater(len(now), 100)
            if whole is None:
                whole = now
            for name in whole:
                self.assertTrue(whole[name] == now[name], f"{name} differs with {threads} threads")
            self.assertEqual(sorted(whole), sorted(now))

    def test_omp_num_threads(self):
        whole = None
        cores = len(os.sched_getaffinity(0))
        for text, threads in [("1", 1), ("5", 5), ("3,2", 3), ("0", cores), ("-4", cores), ("many", cores), ("", cores)]:
            path = self.run_config("--trials", 3000, output="out.h5", env={"OMP_NUM_THREADS": text})
            self.assertEqual(attribute(path, "threads", "run"), threads, text)
            whole = whole or contents(path)
            self.assertEqual(contents(path), whole, text)
            path.unlink()

    def test_same_bits_from_every_instruction_set(self):
        # Where the processor has AVX-512 the first run uses it; elsewhere the two are the same code.
        noise = ["--set", "noise.accelerometer_mps2=0.003"]
        best = self.run_config("--trials", 3000, *noise, output="best.h5")
        avx2 = self.run_config("--trials", 3000, *noise, output="avx2.h5", env={"SURVEYMC_INSTRUCTION_SET": "x86-64-v3"})
        self.assertEqual(contents(best), contents(avx2))

    def test_same_bits_of_every_estimator(self):
        tools = ["--set", "sensor.spread.gain=0.0016", "--set", "sensor.spread.bias_nT=70",
                 "--set", "noise.reference.per=run", "--set", "noise.reference.total_nT=60",
                 "--set", "noise.reference.dip_deg=0.1", "--trials", 1500,
                 "--set", 'sweep.estimator.name=["msa", "msa_weighted", "msa_joint", "wls", "wls_consider"]']
        self.config("all.toml", ('estimator = "msa"\n', ""))
        best = self.run_config(*tools, config="all.toml", output="best.h5", env={"OMP_NUM_THREADS": "1"})
        avx2 = self.run_config(*tools, config="all.toml", output="avx2.h5",
                               env={"SURVEYMC_INSTRUCTION_SET": "x86-64-v3", "OMP_NUM_THREADS": "3"})
        self.assertEqual(contents(best), contents(avx2))

    def test_same_bits_on_every_run_and_in_every_folder(self):
        a = self.run_config()
        shutil.copytree(self.folder, self.folder / "elsewhere")
        b = self.run_config(output="elsewhere/b.h5", config=self.folder / "elsewhere/base.toml")
        self.assertEqual(contents(a), contents(b))

    def test_seed_changes_the_result(self):
        seeds = [0, 1, 2, 1 + 2**32, 2**63 - 1]
        results = [self.run_config("--seed", seed, "--set", "save_samples=1", output=f"{seed}.h5") for seed in seeds]
        self.assertEqual(len({content_hash(r) for r in results}), len(seeds))
        self.assertEqual(len({float(column(r, "samples/realisations", "bias_z_nT")[0]) for r in results}), len(seeds))

    def test_more_trials_keep_the_first_ones(self):
        short = self.run_config("--trials", 100, "--set", "save_samples=100", output="a.h5")
        long = self.run_config("--trials", 1500, "--set", "save_samples=100", output="b.h5")
        for name in ["gain_x", "bias_z_nT", "north_m"]:
            np.testing.assert_array_equal(column(short, "samples/realisations", name),
                                          column(long, "samples/realisations", name))

    def test_rerun_needs_nothing_but_the_file(self):
        self.config("run.toml", append='[sweep]\n"noise.scale" = [1.0, 0.5]\n[[expect]]\ntable = "position"\n'
                                       'formulation = "joint"\nquantities = ["sigma3_east"]\nverdict = "agrees"\n'
                                       'at = { "noise.scale" = 0.5 }\n')
        path = self.run_config(config="run.toml", output="out.h5")
        other = self.folder / "other"
        other.mkdir()
        path.rename(other / "moved.h5")
        for name in ["survey.csv", "base.toml", "run.toml"]:
            (self.folder / name).unlink()
        before = content_hash(other / "moved.h5")
        with self.untouched():
            out = self.call("rerun", "moved.h5", cwd=other).stdout
        self.assertRegex(out, f"^identical: {before}\\b")
        for threads in [1, 3]:
            self.assertRegex(self.call("rerun", other / "moved.h5", "--threads", threads, cwd="/").stdout, "^identical")

    def test_rerun_with_several_inputs_and_odd_names(self):
        self.write("a/s.csv", SURVEY)
        self.write("b/s.csv", SURVEY.replace(",20,", ",26,"))
        self.write("my ü, survey.csv", SURVEY.replace(",20,", ",21,"))
        cases = {'größe, "x"': "a/s.csv", "two\\nlines": "b/s.csv", "three {} %s": "my ü, survey.csv"}
        text = CONFIG.replace('file = "survey.csv"\n', "").replace('"Base"', '"a {} %s \\"t\\" ü"')
        for name, file in cases.items():
            text += f"[[sweep.case]]\nname = '''{name}'''\n".replace("\\n", "\n") + f'"survey.file" = "{file}"\n'
        self.write("cases.toml", text)
        path = self.run_config(config="cases.toml")
        for folder in ["a", "b"]:
            shutil.rmtree(self.folder / folder)
        (self.folder / "my ü, survey.csv").unlink()
        self.assertRegex(self.call("rerun", path).stdout, "^identical")
        header, rows = self.table_csv(path, "parameters")
        names = [n.replace("\\n", "\n") for n in cases]
        self.assertEqual(list(dict.fromkeys(r[header.index("case")] for r in rows)), names)
        with h5py.File(path) as f:
            self.assertEqual(sorted(g.attrs["path"] for g in f["inputs"].values()), sorted(cases.values()))
        self.assertEqual(attribute(path, "title"), 'a {} %s "t" ü')

    def test_rerun_of_altered_data(self):
        path = self.run_config("--set", "save_samples=5")

        def table(f):
            f["tables/parameters/monte_carlo"][3] *= 1.0000001

        def label(f):
            f["tables/parameters/verdict"][0] = "agreed"

        def sample(f):
            f["samples/realisations/gain_x"][0] += 1e-15

        def survey(f):
            f["inputs/survey/inclination_deg"][2] += 0.1

        def config(f):
            f.attrs["config"] = f.attrs["config"].replace("seed = 1", "seed = 2")

        def stored_hash(f):
            f.attrs["content_hash"] = "0" * 32

        def no_config(f):
            del f.attrs["config"]

        def no_tables(f):
            del f["tables"]

        def another_type(f):
            del f["tables/parameters/monte_carlo"]
            f["tables/parameters/monte_carlo"] = np.arange(3)

        for change in [table, label, sample, survey, config, stored_hash, no_config, no_tables, another_type]:
            with self.subTest(change=change.__name__):
                altered = self.folder / "altered.h5"
                shutil.copy(path, altered)
                with h5py.File(altered, "r+") as f:
                    change(f)
                with self.untouched():
                    done = self.call("rerun", altered, code=(UNEXPECTED, BAD_INPUT, CANNOT_WRITE))
                self.assertRegex(done.stdout + done.stderr, "not identical|altered.h5: ")

    def test_rerun_accepts_other_run_information(self):
        """/run is outside the hash; a file that h5py has extended there is still the same result."""
        path = self.run_config()
        with h5py.File(path, "r+") as f:
            f["run"].attrs["host"] = "another"
        self.assertRegex(self.call("rerun", path).stdout, "^identical")


class Overrides(Case):
    def test_set_is_recorded(self):
        self.write("other.csv", SURVEY.replace(",20,", ",23,"))
        path = self.run_config("--set", "noise.scale=0.25", "--set", "survey.file=other.csv", "--set", "title=A title",
                               "--set", "sensor.bias_nT=[1, 2.5, -3]", "--set", "field.declination_deg=-7",
                               "--set", "estimator.max_iterations=40", "--set", "noise.law=uniform")
        config = stored_config(path)
        self.assertEqual(config["noise"]["scale"], 0.25)
        self.assertEqual(config["noise"]["law"], "uniform")
        self.assertEqual(config["survey"]["file"], "other.csv")
        self.assertEqual(config["title"], "A title")
        self.assertEqual(attribute(path, "title"), "A title")
        self.assertEqual(config["sensor"]["bias_nT"], [1, 2.5, -3])
        self.assertEqual(config["field"]["declination_deg"], -7)
        self.assertEqual(config["estimator"]["max_iterations"], 40)
        with h5py.File(path) as f:
            self.assertEqual(f["inputs/other"].attrs["path"], "other.csv")
            self.assertEqual(f["inputs/other/azimuth_deg"][0], 23)
        self.assertRegex(self.call("rerun", path).stdout, "^identical")

    def test_set_has_an_effect(self):
        wide = self.run_config(output="a.h5")
        narrow = self.run_config("--set", "noise.scale=0.1", output="b.h5")
        row = list(column(wide, "tables/parameters", "quantity")).index("sigma3_bias_x")
        ratio = column(wide, "tables/parameters", "analytic")[row] / column(narrow, "tables/parameters", "analytic")[row]
        self.assertAlmostEqual(ratio, 10, delta=1e-9)
        ratio = (column(wide, "tables/parameters", "monte_carlo")[row] /
                 column(narrow, "tables/parameters", "monte_carlo")[row])
        self.assertAlmostEqual(ratio, 10, delta=0.5)

    def test_set_equals_the_same_value_in_the_file(self):
        a = self.run_config("--set", "field.dip_deg=-45.5", "--set", "trials=700", output="a.h5")
        self.config("b.toml", ("dip_deg = 60.0", "dip_deg = -45.5"), ("trials = 600", "trials = 700"))
        self.assertEqual(contents(a), contents(self.run_config(config="b.toml", output="b.h5")))

    def test_last_set_wins(self):
        config = tomllib.loads(self.call("check", "base.toml", "--set", "noise.scale=2", "--set", "noise.scale=3").stdout)
        self.assertEqual(config["noise"]["scale"], 3)

    def test_trials_and_seed(self):
        path = self.run_config("--trials", 700, "--seed", 12345)
        config = stored_config(path)
        self.assertEqual((config["trials"], config["seed"]), (700, 12345))
        self.assertEqual((attribute(path, "trials"), attribute(path, "seed")), (700, 12345))
        self.assertEqual(set(column(path, "tables/parameters", "trials")), {700})
        out = self.call("check", "base.toml", "--trials", 700, "--seed", 12345).stdout
        self.assertEqual(tomllib.loads(out), config)
        self.assertIn("700 trials in all", out)

    def test_command_is_recorded(self):
        path = self.run_config("--set", "noise.scale=0.5", "--threads", 1)
        self.assertIn("run base.toml -o out.h5 --set noise.scale=0.5 --threads 1", attribute(path, "command"))

    def test_bad_set(self):
        """Place, value and rule, as for a value in the file."""
        self.run_config(output="old.h5")
        bad = {
            "noise.scale=0": r"noise\.scale = 0: must be > 0",
            "noise.scale=-1": r"noise\.scale = -1: must be > 0",
            "noise.scale=nan": r"noise\.scale = nan: must be a finite number",
            "noise.scale=-inf": r"noise\.scale = -inf: must be a finite number",
            "noise.scale=abc": r'noise\.scale = "abc": must be a number',
            "noise.scale=[1.0]": r"noise\.scale = \[1\]: must be a number",
            "noise.scale=": r"noise\.scale: the value is missing",
            "noise.scale": "must be KEY=VALUE",
            "=3": "the key is missing",
            "noise.scal=1": r"noise\.scal: unknown key: did you mean noise\.scale\?",
            "field.dip_deg=95": r"field\.dip_deg = 95: must be in \[-90, 90\]",
            "field.dip=60": r"field\.dip: the unit is missing: write field\.dip_deg",
            "field.total_uT=50": r"field\.total_uT: unknown unit: write field\.total_nT",
            "sensor.gain=[1,1]": r"sensor\.gain = \[1, 1\]: must have 3 numbers",
            "sensor.gain=[1,1": "sensor.gain",
            "sensor.gain=[1,1,nan]": "must be a finite number",
            "survey.file=nix.csv": r'survey\.file = "nix\.csv": cannot be read: No such file',
            "survey.toolface_zero=z": r'toolface_zero = "z": must be one of "x", "y"',
            "estimator=mas": r'estimator\S* = "mas": must be one of "msa", "msa_weighted"',
            "estimator.solver=x": r'estimator\.solver = "x": must be one of',
            "trials=0": r"trials = 0: must be in \[2, ",
            "trials=1.5": r"trials = 1\.5: must be an integer",
            "trials=-5": r"trials = -5: must be in \[2, ",
            "seed=-1": r"seed = -1: must be in \[0, ",
            "seed=9223372036854775808": "seed",
            "title=5": r"title = 5: must be a string",
            "experiment=foo": r'experiment = "foo": must be one of .*msa_position',
            "sweep.noise.scale=[]": r"sweep\.noise\.scale = \[\]: must not be empty",
            "sweep.noise.scale=1": r"sweep\.noise\.scale = 1: must be a list",
            "sweep.noise.scale=[1.0, 0.0]": r"noise\.scale = 0: must be > 0",
            "sweep.seed=[1, 2]": "cannot be swept",
            "verdict.margin=2": r"verdict\.margin = 2: must be in \(0, 1\)",
            "verdict.confidence=1e-300": r"verdict\.confidence = 1e-300: must be in \[1e-09, 0\.999999999\]",
            "save_samples=-1": r"save_samples = -1: must be in",
        }
        for argument, rule in bad.items():
            for command in [["check"], ["run", "-o", "old.h5"], ["run", "-o", "new.h5"]]:
                with self.subTest(set=argument, command=command):
                    place = "--set " + re.escape(argument)
                    message = self.refused((USAGE, BAD_INPUT), command[0], "base.toml", *command[1:], "--set", argument, says=rule)
                    self.assertRegex(message, f"^error: {place}: ")
                    self.assertEqual(message.count("\n"), 1)

    def test_trials_and_seed_show_what_was_typed(self):
        self.run_config(output="old.h5")
        for option, value in itertools.product(["--trials", "--seed"], ["-1", "1.5", "abc", "", "99999999999999999999"]):
            with self.subTest(option=option, value=value):
                message = self.refused((USAGE, BAD_INPUT), "run", "base.toml", "-o", "old.h5", f"{option}={value}")
                self.assertIn(value, message)
                self.assertIn(option, message)
                self.assertNotIn("18446744073709551615", message)
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "old.h5", "--trials", 0, says=r"trials = 0: must be in \[2, ")
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "old.h5", "--trials", 1, says=r"trials = 1: must be in \[2, ")


class Usage(Case):
    def test_usage_errors(self):
        for arguments, says in [
            ([], r"surveymc new position_covariance -o well\.toml .*\n  surveymc run well\.toml .*\n  surveymc show results/well\.h5 "),
            (["frobnicate"], "frobnicate"),
            (["Run", "base.toml"], "Run is not expected: did you mean run\\?"),
            (["run"], "config"),
            (["check"], "config"),
            (["show"], "file"),
            (["rerun"], "file"),
            (["--nix"], "nix"),
            (["run", "base.toml", "--fop"], "--fop"),
            (["run", "base.toml", "extra"], "extra"),
            (["check", "base.toml", "-o", "x.h5"], "-o"),
            (["check", "base.toml", "--threads", "1"], "--threads"),
            (["list", "extra"], "extra"),
            (["show", "a.h5", "t", "extra"], "extra"),
            (["rerun", "a.h5", "--trials", "5"], "--trials"),
            (["run", "base.toml", "-o"], "-o|output"),
            (["run", "base.toml", "--set"], "--set"),
            (["run", "base.toml", "--threads", "-2"], "--threads.*-2"),
            (["run", "base.toml", "--threads", "0"], "--threads.*0"),
            (["run", "base.toml", "--threads", "abc"], "--threads.*abc"),
            (["run", "base.toml", "--threads", "99999999999999999999"], "--threads"),
            (["rerun", "a.h5", "--threads", "-2"], "--threads.*-2"),
        ]:
            with self.subTest(arguments=arguments):
                self.refused(USAGE, *arguments, says=says)


class BadConfigs(Case):
    """Each is refused with 65, place and rule by check and by run; nothing is written, nothing existing is touched."""

    def setUp(self):
        super().setUp()
        self.run_config(output="old.h5")

    def refuse(self, name, says):
        """By `check` and by one of the three kinds of `run`, in turn."""
        self.refusals = getattr(self, "refusals", 0) + 1
        run = [["run", name, "-o", "old.h5"], ["run", name, "-o", "new.h5"], ["run", name]][self.refusals % 3]
        for command in [["check", name], run]:
            message = self.refused(BAD_INPUT, *command, says=says)
            self.assertTrue(message.startswith("error: "), message)
            self.assertEqual(message.count("\n"), 1, message)

    def test_keys_and_values(self):
        def at(old):
            return rf"^error: bad\.toml:{CONFIG[:CONFIG.index(old)].count(chr(10)) + 1}: "

        dip, total = "dip_deg = 60.0", "total_nT = 50000.0"
        for old, new, says in [
            (dip, "dip_deg = 95", at(dip) + r"field\.dip_deg = 95: must be in \[-90, 90\]$"),
            (dip, "dip_deg = -90.5", at(dip) + r"field\.dip_deg = -90\.5: must be in \[-90, 90\]$"),
            (dip, "dip_deg = 90", at(dip) + r"field\.dip_deg = 90: the horizontal field vanishes"),
            (dip, "dip_deg = nan", at(dip) + r"field\.dip_deg = nan: must be a finite number$"),
            (dip, "dip_deg = inf", at(dip) + r"field\.dip_deg = inf: must be a finite number$"),
            (dip, 'dip_deg = "60"', at(dip) + r'field\.dip_deg = "60": must be a number$'),
            (dip, "dip_deg = true", at(dip) + r"field\.dip_deg = true: must be a number$"),
            (dip, "dip_deg = [60.0]", at(dip) + r"field\.dip_deg = \[60\]: must be a number$"),
            (dip, "dip_deg = 2020-01-01", at(dip) + r"field\.dip_deg = 2020-01-01: must be a number$"),
            (dip, "dip_rad = 1.0", at(dip) + r"field\.dip_deg: missing .*dip_rad: unknown unit"),
            (dip, "dip = 60.0", at(dip) + r"field\.dip_deg: missing .*dip: the unit is missing"),
            (dip, dip + "\ndip_deg = 61.0", r"^error: bad\.toml:12: .*redefine"),
            (dip, dip + "\ndeclination = 3.0", r"^error: bad\.toml:12: field\.declination: the unit is missing: write "
                                               r"field\.declination_deg"),
            (dip, dip + "\nrubbish = 3.0", r"^error: bad\.toml:12: field\.rubbish: unknown key"),
            (dip + "\n", "", r"^error: bad\.toml\S*: field\.dip_deg: missing"),
            (total, "total_nT = 50.0", at(total) + r"field\.total_nT = 50: must be in \[1000, 1000000\]$"),
            (total, "total_uT = 50.0", at(total) + r"field\.total_nT: missing .*total_uT: unknown unit"),
            ("seed = 1", "seed = -1", at("seed") + "seed = -1: must be in "),
            ("seed = 1", "seed = 1.0", at("seed") + r"seed = 1\.0: must be an integer"),
            ("seed = 1", "seed = 99999999999999999999", at("seed") + ".*99999999999999999999"),
            ("seed = 1\n", "", r"^error: bad\.toml\S*: seed: missing"),
            ("trials = 600", "trials = 0", at("trials") + r"trials = 0: must be in \[2, "),
            ("trials = 600", "trials = 1", at("trials") + r"trials = 1: must be in \[2, "),
            ("trials = 600", "trials = -600", at("trials") + r"trials = -600: must be in \[2, "),
            ("trials = 600", "trials = 1.5", at("trials") + r"trials = 1\.5: must be an integer"),
            ("trials = 600", "trials = 1e-3", at("trials") + r"trials = 0\.001: must be an integer$"),
            ("trials = 600", "trials = 1e300", at("trials") + r"trials = 1e\+300: must be an integer$"),
            ("trials = 600", 'trials = "600"', at("trials") + r'trials = "600": must be an integer: write 600 without quotes$'),
            ("trials = 600", 'trials = "10k"', at("trials") + r'trials = "10k": must be an integer: write 10000 without quotes$'),
            ("trials = 600", 'trials = "many"', at("trials") + r'trials = "many": must be an integer$'),
            ("trials = 600\n", "", r"^error: bad\.toml\S*: trials: missing"),
            ('"msa_position"', '"msa_pos"', at("experiment") + r'experiment = "msa_pos": must be one of msa_position'),
            ('experiment = "msa_position"\n', "", r"^error: bad\.toml\S*: experiment: missing"),
            ('estimator = "msa"', 'estimator = "mas"', at("estimator") + r'estimator = "mas": must be one of "msa", "msa_weighted"'),
            ('estimator = "msa"', 'estimator = { name = "msa", solver = "x" }', at("estimator") + "estimator.solver"),
            ('estimator = "msa"', 'estimator = { name = "msa", max_iterations = 0 }', at("estimator") +
             r"estimator\.max_iterations = 0: must be in \[1, "),
            ('estimator = "msa"\n', "", r"^error: bad\.toml\S*: estimator\S*: missing"),
            ("[field]", "[feld]", r"^error: bad\.toml:9: .*feld"),
            ("[field]", "[field", r"^error: bad\.toml:9: "),
            ("title = ", "title ", r"^error: bad\.toml:2: "),
            ('title = "Base"', 'title = "Base', r"^error: bad\.toml:2: "),
            ("title = ", "titel = ", at("title") + "titel: unknown key: did you mean title"),
            ('toolface_zero = "y"', 'toolface_zero = "z"', at("toolface") + r'survey\.toolface_zero = "z": must be one of'),
            ('toolface_zero = "y"\n', "", r"^error: bad\.toml\S*: survey\.toolface_zero: missing"),
            ('"survey.csv"', '"nix.csv"', at("file") + r'survey\.file = "nix\.csv": cannot be read: No such file'),
            ('"survey.csv"', '"."', at("file") + r'survey\.file = "\.": cannot be read: .*folder'),
            ('"survey.csv"', '""', at("file") + r'survey\.file = "": must name a file'),
            ('"survey.csv"', "5", at("file") + r"survey\.file = 5: must be a string"),
            ("magnetometer_nT = 50.0", "magnetometer_nT = -50.0", at("magnetometer") +
             r"noise\.magnetometer_nT = -50: must be in \[0, "),
        ]:
            with self.subTest(old=old, new=new):
                self.config("bad.toml", (old, new))
                self.refuse("bad.toml", says)

    def test_estimators_and_drawn_tools(self):
        line = r"^error: bad\.toml:5: "

        def estimator(settings):
            return ('estimator = "msa"', "estimator = { " + settings + " }")

        drawn = 'name = "wls", magnetometer_drawn = '
        for changes, append, says in [
            ([estimator('name = "msa_joint", magnetometer_nT = 0')], "",
             line + r"estimator\.magnetometer_nT = 0: must be > 0: msa_joint weighs the readings by it$"),
            ([estimator('name = "msa_joint"'), ("magnetometer_nT = 50.0", "magnetometer_nT = 0.0")], "",
             r"^error: bad\.toml\S*: estimator\.magnetometer_nT\b.*must be > 0: msa_joint weighs"),
            ([estimator('name = "wls", solver = "nlopt_lbfgs"')], "",
             line + r"estimator\.solver = \"nlopt_lbfgs\": wls is solved in closed form: must be \"gauss_newton\"$"),
            ([estimator('name = "msa_joint", derivative = "true"')], "",
             line + r"estimator\.derivative = \"true\": must be one of \"measured\", \"fitted\""),
            ([estimator('name = "msa", derivative = "fitted"')], "",
             line + r"estimator\.derivative = \"fitted\": only msa_weighted, msa_joint, wls_consider have it$"),
            ([estimator('name = "wls", derivative = "fitted"')], "",
             line + r"estimator\.derivative = \"fitted\": only msa_weighted, msa_joint, wls_consider have it$"),
            ([estimator(drawn + '"sd"')], "", line + r"estimator\.magnetometer_drawn = \"sd\": .*outputs = \[\"parameters\"\]"),
            ([estimator(drawn + '"sd"'), ("seed = 1", 'seed = 1\noutputs = ["parameters"]')], "",
             r"^error: bad\.toml:6: estimator\.magnetometer_drawn = \"sd\": .*control_variate = false"),
            ([estimator(drawn + '"often"')], "", line + r"estimator\.magnetometer_drawn = \"often\": must be one of \"constant\""),
            ([estimator('name = "msa_joint", magnetometer_drawn = "sd"')], "",
             line + r"estimator\.magnetometer_drawn = \"sd\": only wls has it$"),
            ([estimator('name = "msa_joint", prior = { gain = -0.1 }')], "",
             line + r"estimator\.prior\.gain = -0\.1: must be in \[0, "),
            ([estimator('name = "msa_joint", prior = { bias_nT = -1.0 }')], "",
             line + r"estimator\.prior\.bias_nT = -1: must be in \[0, "),
            ([estimator('name = "msa_joint", prior = { bias = 1.0 }')], "",
             line + r"estimator\.prior\.bias: the unit is missing: write estimator\.prior\.bias_nT"),
            ([estimator('name = "msa", prior = { gain = 0.1 }')], "", line + r"estimator\.prior\S*: unknown key"),
            ([estimator('name = "msa_weighted", reference = { dip_deg = 46.0 }')], "",
             line + r"estimator\.reference\.dip_deg = 46: must be in \[0, 45\]"),
            ([], "[sensor.spread]\ngain = -0.001\n", r"^error: bad\.toml:15: sensor\.spread\.gain = -0\.001: must be in \[0, "),
            ([], "[sensor.spread]\nscale = 0.001\n", r"^error: bad\.toml:15: sensor\.spread\.scale: unknown key"),
            ([], "[sensor.spread]\nbias = 70.0\n", r"^error: bad\.toml:15: sensor\.spread\.bias: the unit is missing"),
        ]:
            with self.subTest(changes=changes, append=append):
                self.config("bad.toml", *changes, append=append)
                self.refuse("bad.toml", says)

    def test_antithetic_pairs(self):
        first = r"^error: bad\.toml:4: "
        half_open = r'^error: bad\.toml:15: noise\.law = "%s_half_open": must be symmetric about zero .*antithetic'
        for old, new, says in [
            ("seed = 1", "seed = 1\nantithetic = 1", first + "antithetic = 1: must be true or false"),
            ("seed = 1", 'seed = 1\nantithetic = "true"', first + 'antithetic = "true": must be true or false'),
            ("seed = 1", "seed = 1\nantithetical = true", first + "antithetical: unknown key: did you mean antithetic"),
            ("trials = 600", "antithetic = true\ntrials = 601",
             r"^error: bad\.toml:5: trials = 601: must be even where antithetic = true"),
            ("trials = 600", "antithetic = true\n[stop]\nrelative_ci = 0.01\nquantities = ['sigma3_gain_x']\n"
             "max_trials = 5001\n[estimator]\nname = 'msa'\n#", r"^error: bad\.toml:8: stop\.max_trials = 5001: must be even"),
        ]:
            with self.subTest(new=new):
                changes = [(old, new)] + ([('estimator = "msa"\n', "")] if "[stop]" in new else [])
                self.config("bad.toml", *changes)
                self.refuse("bad.toml", says)
        for law in ["gaussian", "uniform"]:
            self.config("bad.toml", ("trials = 600", "trials = 600\nantithetic = true"),
                        append=f'law = "{law}_half_open"\n')
            self.refuse("bad.toml", half_open % law)
            self.config("good.toml", append=f'law = "{law}_half_open"\n')
            self.call("check", "good.toml")
        self.refused(BAD_INPUT, "run", "base.toml", "--trials", 301, "--set", "antithetic=true",
                     says=r"^error: --set trials=301: .*must be even where antithetic = true")

    def test_sweeps_and_annotations(self):
        published = '[[published]]\nsource = "S"\n'
        for text, says in [
            ("[sweep]", r":14: sweep: is empty"),
            ('[sweep]\n"noise.scale" = []', r":15: sweep\.noise\.scale = \[\]: must not be empty"),
            ('[sweep]\n"noise.scal" = [1.0]', r":15: noise\.scal: unknown key: did you mean noise\.scale"),
            ('[sweep]\n"noise.scale" = [1.0, -1.0]', r":15: noise\.scale = -1: must be > 0"),
            ('[sweep]\n"noise.scale" = [1.0, 1.0]', r":15: sweep\.noise\.scale = 1: is in the list twice"),
            ('[sweep]\n"noise.scale" = [1.0, "a"]', r":15: sweep\.noise\.scale = \"a\""),
            ('[sweep]\n"noise.scale" = [1.0, nan]', r":15: .*must be a finite number"),
            ('[sweep]\n"noise.scale" = { from = 0.1, to = 1.0, step = 0.0 }', r":15: .*step = 0: must not be 0"),
            ('[sweep]\n"noise.scale" = { from = 0.1, to = 1.0, step = -0.1 }', r":15: .*step = -0\.1: must lead"),
            ('[sweep]\n"noise.scale" = { from = 0.1, to = 1.0, step = 1e-13 }', r":15: .*more than 2\^40"),
            ('[sweep]\nseed = [1, 2]', r":15: sweep\.seed: cannot be swept"),
            ('[[sweep.case]]\n"noise.scale" = 1.0', r":14: sweep\.case\[0\]\.name: missing"),
            ('[[sweep.case]]\nname = "a"\n[[sweep.case]]\nname = "a"', r":17: .*two cases have this name"),
            ('[[sweep.case]]\nname = "a"\n"noise.scal" = 1.0', r":16: noise\.scal: unknown key"),
            (published + 'table = "nix"\nvalues = { a = 1.0 }', r":17: published\[0\].*no such table"),
            (published + 'table = "position"\nvalues = { nix = 1.0 }', r':17: published\[0\].*no row "nix"'),
            (published + 'table = "position"\nvalues = { sigma3_north = "1" }', r":17: .*must be a number"),
            (published + 'table = "position"\nvalues = { sigma3_north = nan }', r":17: .*must be a finite number"),
            (published + 'table = "position"\nvalues = { sigma3_north = 1.0 }\nat = { "noise.scal" = 1.0 }',
             r":18: .*noise\.scal"),
            ('[[published]]\ntable = "position"\nvalues = { sigma3_north = 1.0 }', r"bad\.toml\S*: published\[0\]\.source: missing"),
            ('[[expect]]\ntable = "nix"\nquantities = ["a"]\nverdict = "agrees"', r":16: expect\[0\].*no such table"),
            ('[[expect]]\ntable = "position"\nquantities = ["a"]\nverdict = "agrees"', r':16: expect\[0\].*no row "a"'),
            ('[[expect]]\ntable = "position"\nformulation = "nix"\nquantities = ["sigma3_north"]\nverdict = "agrees"',
             r':17: expect\[0\].*"nix"'),
            ('[[expect]]\ntable = "position"\nquantities = ["sigma3_north"]\nverdict = "agree"',
             r':17: expect\[0\]\.verdict = "agree": must be one of'),
            ('[[expect]]\ntable = "position"\nquantities = []\nverdict = "agrees"', r":16: .*must not be empty"),
            ('[nonsense]\na = 1', r"^error: bad\.toml:1[45]: nonsense"),
        ]:
            with self.subTest(text=text):
                self.config("bad.toml", append=text + "\n")
                self.refuse("bad.toml", says)

    def test_a_swept_key_may_not_collide_with_a_column(self):
        """`trials` is a column of every table: sweeping it is refused, or gives one column of that name."""
        done = self.call("run", "base.toml", "-o", "swept.h5", "--set", "sweep.trials=[100, 200]", code=(DONE, BAD_INPUT))
        if done.returncode == DONE:
            header, _ = self.table_csv("swept.h5", "parameters")
            self.assertEqual(len(header), len(set(header)), f"two columns of one name: {header}")

    def test_surveys(self):
        head = SURVEY.splitlines()[0] + "\n"
        attitude = "".join(f"{30 * i},10,20,0\n" for i in range(6))
        rotated = "".join(f"{30 * i},10,20,{60 * i}\n" for i in range(6))
        for text, says in [
            (SURVEY.replace("60,18", "20,18"), r"survey\.csv:4: md_m = 20: must be greater than the one before"),
            (SURVEY.replace("60,18", "30,18"), r"survey\.csv:4: md_m = 30: must be greater than the one before"),
            ("# comment\n\n" + SURVEY.replace("60,18", "20,18"), r"survey\.csv:6: md_m = 20: "),
            (SURVEY.replace("30,14,25", "30,abc,25"), r'survey\.csv:3: inclination_deg = "abc": must be a number'),
            (SURVEY.replace("30,14,25", "30,14 deg,25"), r'survey\.csv:3: inclination_deg = "14 deg": must be a number'),
            (SURVEY.replace("30,14,25", "30,nan,25"), r'survey\.csv:3: inclination_deg = "nan": must be a finite number'),
            (SURVEY.replace("30,14,25", "30,1e999,25"), r'survey\.csv:3: inclination_deg = "1e999": '),
            (SURVEY.replace("30,14,25", "30,,25"), r"survey\.csv:3: inclination_deg: is empty"),
            (SURVEY.replace("30,14,25", "30,190,25"), r"survey\.csv:3: inclination_deg = 190: must be in \[0, 180\]"),
            (SURVEY.replace("30,14,25,50", "30,14,25"), r"survey\.csv:3: 3 cells: must have 4"),
            (SURVEY.replace(",", ";"), r"survey\.csv: .*which north.*survey\.azimuth_reference"),  # a form of others, read by script
            (SURVEY.replace("md_m", "md"), r"survey\.csv:1: column md: the unit is missing: write md_m or md_ft"),
            (SURVEY.replace("inclination_deg", "inclination_rad"), r"survey\.csv:1: .*unknown unit: write inclination_deg"),
            (SURVEY.replace("azimuth_deg", "azimuth_deg_2"), r"survey\.csv:1: "),
            (re.sub(r"(?m),[^,]*$", "", SURVEY), r"survey\.csv:1: column toolface_deg: missing"),
            (head, r"survey\.csv: has no rows"),
            (head + "0,10,20,0\n", r"survey\.csv: 1 station"),
            ("", r"survey\.csv: is empty"),
            (b"\x89HDF\r\n\x1a\n\0\0\0", r"survey\.csv:1: is not plain UTF-8 text"),
        ]:
            with self.subTest(survey=text):
                self.write("survey.csv", text)
                self.refuse("base.toml", says)
                self.assertIn("survey.csv", self.call("check", "base.toml", code=BAD_INPUT).stderr,
                              "the message must name the file")
        # What only computing shows comes from the task that runs the point, at once, and with the point of a sweep
        for text in [head + attitude, head + rotated, head + "0,10,20,0\n30,12,25,70\n"]:
            with self.subTest(survey=text):
                self.write("survey.csv", text)
                self.call("check", "base.toml")
                says = r"^error: base\.toml:\d+: survey\.file = \"survey\.csv\": .*cannot determine"
                self.refused(BAD_INPUT, "run", "base.toml", "-o", "old.h5",
                             says="(?m)" + says + r"[^()]*(\([^()]*\)[^()]*)*$")
                self.refused(BAD_INPUT, "run", "base.toml", "-o", "new.h5", "--set", "sweep.noise.scale=[1.0, 0.5]",
                             says="(?m)" + says + r".*\(point 0 of the sweep\)$")

    def test_files_that_are_no_config(self):
        (self.folder / "folder.toml").mkdir()
        self.write("empty.toml", "")
        self.write("binary.toml", bytes(range(256)) * 20)
        self.write("zero.toml", b"\0" * 100)
        self.write("nested.toml", "a = " + "[" * 5000)
        for name in ["folder.toml", "missing.toml", "empty.toml", "binary.toml", "zero.toml", "nested.toml"]:
            with self.subTest(config=name):
                self.refuse(name, rf"^error: {re.escape(name)}\b")
        self.refuse("", "cannot be read")


BENEFIT = """\
experiment = "msa_benefit"
seed = 1
inclination_deg = [0.0, 60.0, 90.0]
azimuth_deg = { from = 0.0, to = 90.0, step = 45.0 }
estimator = { name = "msa", estimated = ["bias_x", "bias_y", "bias_z"] }
well = { kind = "straight", stations = 10 }
[field]
total_nT = 51000.0
dip_deg = 72.0
[sensor.spread]
gain = 0.0016
bias_nT = 70.0
[noise]
magnetometer_nT = 30.0
reference = { per = "run", total_nT = 130.0, dip_deg = 0.2 }
"""
VERIFY = "[[verify]]\ninclination_deg = 60.0\nazimuth_deg = 0.0\n"


class Benefit(Case):
    def setUp(self):
        super().setUp()
        self.write("benefit.toml", BENEFIT)

    def test_maps_without_trials(self):
        path = self.run_config(config="benefit.toml")
        with h5py.File(path) as f:
            ratio = f["maps/azimuth_ratio"][()]
            self.assertEqual(ratio.shape, (3, 3))
            np.testing.assert_array_equal(f["maps/inclination"][()], [0, 60, 90])
            np.testing.assert_array_equal(f["maps/azimuth"][()], [0, 45, 90])
            np.testing.assert_array_equal(
                ratio, f["maps/azimuth_sd_after_deg"][()] / f["maps/azimuth_sd_before_deg"][()])
            self.assertTrue(np.isinf(ratio[2, 2]) and np.isinf(f["maps/condition"][2, 2]))  # horizontal, east
            self.assertEqual(np.isinf(ratio).sum(), 1)
            self.assertFalse(np.isnan(ratio).any() or np.isnan(f["maps/lateral_ratio"][()]).any())
            self.assertLess(ratio[1, 0], 1)
            self.assertGreater(ratio[2, 1], 1)
            self.assertEqual(f.attrs["trials"], 0)
            self.assertNotIn("verification", f["tables"])
        np.testing.assert_array_equal(column(path, "tables/summary", "undetermined"), [1, 1])
        self.call("rerun", path)

    def test_a_single_direction_is_a_map_of_length_one(self):
        whole = self.run_config(config="benefit.toml")
        one = self.run_config("--set", "inclination_deg=60.0", "--set", "azimuth_deg=45.0", config="benefit.toml", output="one.h5")
        with h5py.File(whole) as a, h5py.File(one) as b:
            self.assertEqual(b["maps/azimuth_ratio"].shape, (1, 1))
            self.assertEqual(b["maps/azimuth_ratio"][0, 0], a["maps/azimuth_ratio"][1, 1])
            self.assertEqual((b["maps/inclination"][0], b["maps/azimuth"][0]), (60, 45))

    def test_a_vertical_hole_has_no_azimuth_where_accelerometers_are_noisy(self):
        quiet = self.run_config("--set", "inclination_deg=[0.0, 60.0, 180.0]", config="benefit.toml")
        path = self.run_config("--set", "inclination_deg=[0.0, 60.0, 180.0]", "--set", "noise.accelerometer_mps2=0.001",
                               config="benefit.toml", output="noisy.h5")
        with h5py.File(quiet) as a, h5py.File(path) as b:
            for name in ("azimuth_ratio", "azimuth_sd_before_deg", "azimuth_sd_after_deg", "lateral_ratio"):
                self.assertFalse(np.isnan(a[f"maps/{name}"][()]).any(), name)  # a limit
                here = b[f"maps/{name}"][()]
                np.testing.assert_array_equal(np.isnan(here), name.startswith("azimuth") * np.array([[1] * 3, [0] * 3, [1] * 3]), name)
        np.testing.assert_array_equal(column(path, "tables/summary", "directions"), [3, 9])
        np.testing.assert_array_equal(column(path, "tables/summary", "best_inclination_deg")[:1], [60])
        one = self.run_config("--set", "inclination_deg=0", "--set", "azimuth_deg=0", "--set", "noise.accelerometer_mps2=0.001",
                              config="benefit.toml", output="one.h5")
        self.assertTrue(np.isnan(column(one, "tables/summary", "ratio_median")[0]))
        self.assertIn("missing", self.call("show", path, "azimuth_ratio").stdout)
        self.call("rerun", path)

    def test_sweep_adds_a_dimension(self):
        path = self.run_config("--set", "sweep.well.stations=[5, 10]", config="benefit.toml")
        with h5py.File(path) as f:
            self.assertEqual(f["maps/azimuth_ratio"].shape, (2, 3, 3))
        np.testing.assert_array_equal(column(path, "tables/summary", "well.stations"), [5, 5, 10, 10])

    def test_verification_and_replay(self):
        self.write("verify.toml", "trials = 2000\n" + BENEFIT + VERIFY)
        path = self.run_config("--threads", 1, config="verify.toml", output="a.h5")
        self.assertEqual(contents(path), contents(self.run_config("--threads", 3, config="verify.toml", output="b.h5")))
        ratio = column(path, "tables/verification", "ratio")
        self.assertEqual(len(ratio), 4)
        np.testing.assert_allclose(ratio, 1, atol=4.5 / np.sqrt(2 * 2000) + .02)  # standard errors; second order
        self.assertRegex(self.call("run", "verify.toml", "--trial", 3).stdout, "azimuth error .*before")

    def test_refusals(self):
        verify = BENEFIT + VERIFY
        for text, says in [
            (BENEFIT.replace('"straight"', '"curved"'), "well.kind"),
            (BENEFIT.replace("stations = 10", "stations = 1"), "well.stations = 1"),
            (BENEFIT.replace("[0.0, 60.0, 90.0]", "[0.0, 190.0]"), "inclination_deg.*190"),
            (BENEFIT.replace("bias_z", "bias_w"), 'estimator.estimated.*"bias_w" is none of'),
            (BENEFIT.replace('"bias_z"', '"bias_x"'), "twice"),
            (BENEFIT.replace('name = "msa"', 'name = "wls"'), "estimator.name"),
            (BENEFIT.replace("magnetometer_nT = 30.0", 'magnetometer_nT = 30.0\nlaw = "uniform_half_open"'), "noise.law"),
            ("trials = 10\n" + BENEFIT, "trials = 10: without"),
            (verify, "trials"),
            ("trials = 10\n" + verify.replace("60.0\nazimuth_deg = 0.0", "90.0\nazimuth_deg = 90.0"), "do not determine"),
            ("trials = 10\n" + verify.replace("60.0\nazimuth_deg = 0.0", "0.5\nazimuth_deg = 90.0"), r"\[1, 179\]"),
            (BENEFIT.replace('kind = "straight"', 'kind = "building", spacing_m = 900.0, build_rate_deg_per_30m = 6.0'),
             "well.build_rate_deg_per_30m"),
            (BENEFIT + "[survey]\nfile = 'x.csv'\n", "survey"),
        ]:
            with self.subTest(says=says):
                self.write("bad.toml", text)
                self.refused(BAD_INPUT, "run", "bad.toml", "-o", "out.h5", says=says)


class Output(Case):
    def test_an_older_result_is_replaced(self):
        path = self.run_config()
        before = content_hash(path)
        self.run_config("--seed", 5)
        self.assertNotEqual(content_hash(path), before)
        self.call("rerun", path)

    def test_a_link_keeps_pointing(self):
        (self.folder / "real").mkdir()
        target = self.run_config(output="real/target.h5")
        before = content_hash(target)
        (self.folder / "link.h5").symlink_to(target)
        self.run_config("--seed", 5, output="link.h5")
        self.assertTrue((self.folder / "link.h5").is_symlink())
        self.assertNotEqual(content_hash(target), before)

    def test_places_that_cannot_be_written(self):
        (self.folder / "folder").mkdir()
        self.write("file", "text")
        for output, says in [("missing/out.h5", "missing.*does not exist"), ("folder", "is a folder"),
                             ("folder/", "is a folder"), (".", "is a folder"), ("file/out.h5", "file"),
                             ("/dev/null", "/dev/null"), ("x" * 300 + ".h5", "too long")]:
            with self.subTest(output=output):
                self.refused(CANNOT_WRITE, "run", "base.toml", "-o", output, says=says)

    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_read_only_folder(self):
        (self.folder / "locked").mkdir(mode=0o500)
        self.refused(CANNOT_WRITE, "run", "base.toml", "-o", "locked/out.h5", says="locked.*Permission denied")

    def test_foreign_files_stay(self):
        result = self.run_config(output="result.h5").read_bytes()
        with h5py.File(self.folder / "foreign.h5", "w") as f:
            f["x"] = np.arange(10)
        self.write("text.h5", "somebody's notes")
        self.write("empty.h5", "")
        self.write("truncated.h5", result[:len(result) // 2])
        for output in ["foreign.h5", "text.h5", "empty.h5", "truncated.h5", "base.toml", "survey.csv"]:
            with self.subTest(output=output):
                self.refused(CANNOT_WRITE, "run", "base.toml", "-o", output, "--seed", 2,
                             says=rf"{re.escape(output)}: .*(not a surveymc result|cannot be read).*refus")

    def test_full_disk(self):
        """A file-size limit stands for a full disk: same code path, an error of write()."""
        self.run_config("--set", "save_samples=500", output="old.h5")
        for limit, output in itertools.product([0, 1, 2048, 5000, 20000, 80000], ["old.h5", "new.h5"]):
            with self.subTest(limit=limit, output=output):
                for left in self.folder.glob(".*.tmp"):  # of a subtest that failed
                    left.unlink()
                self.refused(CANNOT_WRITE, "run", "base.toml", "-o", output, "--set", "save_samples=500", "--seed", 2,
                             says=rf"{output}: cannot.*(large|space)",
                             before=lambda n=limit: resource.setrlimit(resource.RLIMIT_FSIZE, (n, n)))
        self.call("rerun", "old.h5")

    def test_stale_temporary_files_go(self):
        stale = self.write(".out.h5.0123456789abcdef.tmp", "half a file")
        alive = self.write(".out.h5.fedcba9876543210.tmp", "a living writer's")
        other = self.write(".other.h5.0123456789abcdef.tmp", "of another result")
        with open(alive) as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            self.run_config(output="out.h5")
        self.assertFalse(stale.exists())
        self.assertTrue(alive.exists())
        self.assertTrue(other.exists())

    def test_name_that_is_not_utf8(self):
        output = os.fsencode(self.folder) + b"/\xff\xfe.h5"
        done = subprocess.run([os.fsencode(EXECUTABLE), b"run", b"base.toml", b"-o", output], cwd=self.folder,
                              capture_output=True)
        self.assertEqual(done.returncode, DONE, done.stderr)
        shutil.copy(output, self.folder / "copy.h5")
        self.call("rerun", "copy.h5")
        self.assertIsInstance(attribute(self.folder / "copy.h5", "command"), str)

    def test_stdout_that_cannot_be_written(self):
        """Output that is lost must not look like success."""
        path = self.run_config("--set", "save_samples=500")
        for arguments in [["list"], ["check", "base.toml"], ["show", path], ["show", path, "realisations", "--csv"],
                          ["rerun", path], ["run", "base.toml", "--trial", "3"], ["run", "base.toml", "-o", "again.h5"]]:
            with self.subTest(arguments=arguments), open("/dev/full", "w") as full:
                done = subprocess.run([EXECUTABLE, *arguments], cwd=self.folder, stdout=full, stderr=subprocess.PIPE,
                                      text=True)
                self.assertEqual(done.returncode, CANNOT_WRITE, done.stderr)
                self.assertNotRegex(done.stderr, RAW_EXCEPTION)
                self.assertRegex(done.stderr, "No space left|cannot")
        self.call("rerun", "again.h5")  # the result itself is on the disk

    def test_stderr_that_cannot_be_written(self):
        """The log on the disk that is full: still the exit code, not an abort."""
        for arguments, code in [(["run", "nix.toml"], BAD_INPUT), (["run", "base.toml", "-o", "nix/x.h5"], CANNOT_WRITE),
                                (["run"], USAGE), (["run", "base.toml", "-o", "out.h5"], DONE)]:
            with self.subTest(arguments=arguments), open("/dev/full", "w") as full:
                done = subprocess.run([EXECUTABLE, *arguments], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=full)
                self.assertEqual(done.returncode, code)


class Signals(Case):
    def interrupted(self, trials, number, output):
        """Starts a long run, sends the signal when blocks of it are done; seconds until it ended."""
        child = subprocess.Popen([EXECUTABLE, "run", "base.toml", "--trials", str(trials), "-o", output, "--threads", "2",
                                  "--checkpoint-seconds", "0.01"], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            line = child.stderr.readline()
            self.assertRegex(line, f"{trials} trials in all")
            end = time.monotonic() + 60
            while not list(self.folder.glob(f"{output}.journal.*")) and time.monotonic() < end:  # then blocks are done
                time.sleep(0.005)
            self.assertIsNone(child.poll())
            child.send_signal(number)
            begin = time.monotonic()
            try:
                out, err = child.communicate(timeout=5)
            except subprocess.TimeoutExpired:
                self.fail(f"still running 5 s after {number.name}")
            self.assertEqual(child.returncode, INTERRUPTED, err)
            self.assertEqual(out, "")
            self.assertRegex(err, f"interrupted: what is done is kept beside {output}; go on with: surveymc run .* --resume")
            journal, = self.folder.glob(f"{output}.journal.*")
            journal.unlink()
            self.assertNotRegex(err, RAW_EXCEPTION)
            return time.monotonic() - begin
        finally:
            child.kill()
            child.wait()
            child.stdout.close()
            child.stderr.close()

    def test_interrupted_run_writes_no_result(self):
        self.run_config(output="old.h5")
        for number, output in [(signal.SIGTERM, "new.h5"), (signal.SIGINT, "new.h5"), (signal.SIGTERM, "old.h5"),
                               (signal.SIGINT, "old.h5")]:
            with self.subTest(signal=number.name, output=output), self.untouched():
                self.assertLess(self.interrupted(2_000_000_000, number, output), 3)

    def test_the_largest_run_ends_as_quickly(self):
        with self.untouched():
            self.assertLess(self.interrupted(1_000_000_000_000, signal.SIGTERM, "new.h5"), 3)


class Show(Case):
    def setUp(self):
        super().setUp()
        self.path = self.run_config("--trials", 2000, "--set", "save_samples=2000", "--set", "sweep.noise.scale=[1.0, 0.5]")

    def test_one_table(self):
        out = self.call("show", self.path, "position").stdout
        self.assertRegex(out, "^position: ")
        self.assertNotRegex(out, "(?m)^parameters: ")
        self.assertIn("sigma3_north", out)

    def test_csv_equals_the_file_to_the_last_bit(self):
        with h5py.File(self.path) as f:
            tables = [f["tables"][n] for n in f["tables"]] + [f["samples"][n] for n in f["samples"]]
            self.assertGreaterEqual(len(tables), 6)
            for group in tables:
                with self.subTest(table=group.name):
                    header, rows = self.table_csv(self.path, group.name.rsplit("/", 1)[1])
                    self.assertEqual(sorted(header), sorted(n for n in group if n != "row"))
                    self.assertTrue(all(len(r) == len(header) for r in rows))
                    self.assertEqual(len(rows), len(group["row"]))
                    for i, name in enumerate(header):
                        d = group[name]
                        cells = [r[i] for r in rows]
                        if h5py.check_string_dtype(d.dtype):
                            self.assertEqual(cells, list(d.asstr()[()]), name)
                        elif d.dtype.kind == "i":
                            self.assertEqual([int(c) for c in cells], d[()].tolist(), name)
                        else:
                            values = np.array([float(c) if c else np.nan for c in cells])
                            stored = d[()]
                            np.testing.assert_array_equal(np.isnan(values), np.isnan(stored), name)
                            known = ~np.isnan(stored)
                            self.assertEqual(values[known].tobytes(), stored[known].tobytes(), name)

    def test_unknown_table(self):
        for extra in [[], ["--csv"]]:
            message = self.refused(BAD_INPUT, "show", self.path, "nix", *extra, says="nix")
            for table in ["parameters", "position", "ellipse", "realisations"]:
                self.assertIn(table, message)

    def test_closed_pipe(self):
        for arguments in [["show", self.path, "realisations", "--csv"], ["show", self.path, "realisations"],
                          ["show", self.path], ["show", self.path, "--json"], ["list"]]:
            with self.subTest(arguments=arguments):
                child = subprocess.Popen([EXECUTABLE, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                self.assertTrue(child.stdout.readline())
                child.stdout.close()
                err = child.stderr.read().decode()
                child.stderr.close()
                self.assertIn(child.wait(timeout=10), [DONE, CANNOT_WRITE, -signal.SIGPIPE, 128 + signal.SIGPIPE])
                self.assertNotRegex(err, RAW_EXCEPTION)
                self.assertLessEqual(err.count("\n"), 1)

    def test_titles_cannot_drive_the_terminal(self):
        path = self.run_config("--set", 'title="red \\u001b[31m and\\nnext"', output="t.h5")
        out = self.call("show", path).stdout
        self.assertNotIn("\x1b", out)
        self.assertEqual(attribute(path, "title"), "red \x1b[31m and\nnext")

    def test_files_that_are_no_result(self):
        whole = self.path.read_bytes()
        with h5py.File(self.folder / "foreign.h5", "w") as f:
            f["x"] = np.arange(10)
        with h5py.File(self.folder / "impostor.h5", "w") as f:
            f.attrs["format"] = "surveymc"
            f.attrs["format_version"] = 1
        with h5py.File(self.folder / "future.h5", "w") as f:
            f.attrs["format"] = "surveymc"
            f.attrs["format_version"] = 999
        (self.folder / "folder.h5").mkdir()
        self.write("garbage.h5", np.random.default_rng(1).bytes(5000))
        self.write("empty.h5", b"")
        self.write("text.h5", "hello\n")
        flipped = bytearray(whole)
        flipped[len(whole) // 3] ^= 1
        self.write("flipped.h5", bytes(flipped))
        names = ["missing.h5", "foreign.h5", "impostor.h5", "future.h5", "folder.h5", "garbage.h5", "empty.h5", "text.h5",
                 "flipped.h5"]
        for length in [7, 8, 100, len(whole) // 2, len(whole) - 100, len(whole) - 30]:
            names.append(f"truncated_{length}.h5")
            self.write(names[-1], whole[:length])
        for name, command in itertools.product(names, [["show"], ["rerun"], ["show", "parameters", "--csv"]]):
            with self.subTest(file=name, command=command):
                message = self.refused(CANNOT_WRITE, command[0], name, *command[1:])
                self.assertRegex(message, rf"^error: {re.escape(name)}: \S")
                self.assertEqual(message.count("\n"), 1)

    def test_damaged_bytes(self):
        whole = self.run_config("--trials", 20, output="small.h5").read_bytes()
        random = np.random.default_rng(7)
        for i in range(30):
            damaged = bytearray(whole)
            for at in random.integers(0, len(whole) - 24, [1, 3, 20][i % 3]):
                damaged[at] ^= random.integers(1, 256)
            self.write("damaged.h5", bytes(damaged))
            with self.subTest(i=i):
                self.refused(CANNOT_WRITE, "show", "damaged.h5", says="damaged.h5: ")


class Verdicts(Case):
    def expecting(self, name, formulation, verdict, *more):
        return self.config(name, ("trials = 600", "trials = 3000"), *more,
                           append=f'[verdict]\nmargin = 0.1\n[[expect]]\ntable = "position"\nformulation = "{formulation}"\n'
                                  f'quantities = ["sigma3_east"]\nverdict = "{verdict}"\n')

    def test_expected_verdicts(self):
        self.expecting("good.toml", "joint", "agrees")
        for extra in [[], ["--check"]]:
            self.assertRegex(self.call("run", "good.toml", "-o", "out.h5", *extra).stdout, "; all as expected|, 1 differs")

    def test_unexpected_verdicts(self):
        self.expecting("bad.toml", "joint", "differs")
        out = self.call("run", "bad.toml", "-o", "out.h5", "--check", code=UNEXPECTED).stdout
        self.assertRegex(out, "; 1 not as expected")
        listed = out[out.index("; 1 not as expected"):].splitlines()[1]
        for word in ["position", "joint", "sigma3_east", "agrees", "differs"]:
            self.assertIn(word, listed)
        self.call("rerun", "out.h5")
        self.assertIn("1 not as expected", self.call("run", "bad.toml", "-o", "out.h5").stdout)

    def test_a_verdict_that_is_not_reached_is_not_the_expected_one(self):
        self.expecting("few.toml", "joint", "agrees", ("trials = 3000", "trials = 10"))
        self.call("run", "few.toml", "-o", "out.h5", "--check", code=UNEXPECTED)
        self.expecting("none.toml", "joint", "agrees", ('estimator = "msa"', 'estimator = { name = "msa", max_iterations = 1 }'))
        self.call("run", "none.toml", "-o", "out.h5", "--check", code=UNEXPECTED)

    def test_published_values_arrive(self):
        self.config("p.toml", append='[[published]]\nsource = "S"\ntable = "position"\nformulation = "joint"\n'
                                     'values = { sigma3_east = 0.5 }\n')
        header, rows = self.table_csv(self.run_config(config="p.toml"), "position")
        for r in (dict(zip(header, r)) for r in rows):
            here = r["formulation"] == "joint" and r["quantity"] == "sigma3_east"
            self.assertEqual(r["published"], "0.5" if here else "")
            if here:
                self.assertAlmostEqual(float(r["published_ratio"]), 0.5 / float(r["monte_carlo"]), delta=1e-12)


class ThesisTables(Case):
    """Published values that a table has to every printed digit, as the shipped configs carry them."""

    def rows(self, config, table, *options):
        header, rows = self.table_csv(self.run_config(*options, config=SOURCE / "configs/thesis" / config), table)
        return [dict(zip(header, r)) for r in rows]

    def assert_printed(self, row, digit):
        # What is printed is rounded to `digit`: half of it, and 1e-9 for the rounding of the decimals themselves.
        self.assertAlmostEqual(float(row["analytic"]), float(row["published"]), delta=0.5 * digit * (1 + 1e-9), msg=str(row))

    def test_table_6_estimates(self):
        rows = [r for r in self.rows("table6.toml", "hanak_parameters", "--trials", 2) if r["quantity"].startswith("mean_")
                and r["case"] != "test 4"]
        self.assertEqual(len(rows), 3 * 2 * 6)
        for r in rows:
            self.assert_printed(r, 1e-3 if "scale" in r["quantity"] else 1)

    def test_table_7(self):
        rows = self.rows("table7.toml", "parameters")
        exact = [r for r in rows if r["published"] and r["case"] != "test 1"]
        self.assertEqual(len(exact), 6 + 6 + 6 + 6 + 6)  # estimates of tests 2 and 3, 3-sigma of tests 2, 3 and 4
        for r in exact:
            self.assert_printed(r, 1e-4 if "gain" in r["quantity"] else 0.1)
        for r in rows:  # test 1 is one draw of weights for the mean of many: within 0.15 of their sd
            if r["published"] and r["case"] == "test 1" and r["quantity"].startswith("mean_"):
                sd = next(float(s["monte_carlo"]) / 3 for s in rows if s["case"] == "test 1"
                          and s["quantity"] == r["quantity"].replace("mean_", "sigma3_"))
                digit = 1e-4 if "gain" in r["quantity"] else 0.1
                self.assertLess(abs(float(r["monte_carlo"]) - float(r["published"])), 0.15 * sd + 0.5 * digit, r)


class Replay(Case):
    NAMES = ["gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z", "north", "east", "vertical"]

    def replayed(self, *arguments):
        with self.untouched():
            out = self.call("run", *arguments).stdout
        values = dict(re.findall(r"(?m)^\s+(\w+)\s+(\S+) (?:1|nT|m)$", out))
        return out, [float(values[n]) for n in self.NAMES]

    def sample(self, path, row):
        with h5py.File(path) as f:
            g = f["samples/realisations"]
            names = [n + ("_nT" if n.startswith("bias") else "" if n.startswith("gain") else "_m") for n in self.NAMES]
            return float(g["trial"][row]), [float(g[n][row]) for n in names]

    def test_bits_are_those_of_the_run(self):
        options = ["--set", "save_samples=1100", "--trials", 1100, "--set", "noise.reference.per=station",
                   "--set", "noise.reference.total_nT=60", "--set", "noise.reference.dip_deg=0.1",
                   "--set", "noise.accelerometer_mps2=0.002", "--set", "field.declination_deg=5"]
        path = self.run_config(*options)
        for k in [0, 1, 7, 8, 255, 511, 512, 513, 700, 1023, 1024, 1099]:
            with self.subTest(trial=k):
                out, values = self.replayed("base.toml", "--trial", k, *options)
                self.assertRegex(out, f"^trial {k}\n")
                self.assertEqual((float(k), values), self.sample(path, k))

    def test_drawn_tools(self):
        for pairs in ["false", "true"]:
            options = ["--set", "save_samples=600", "--set", "sensor.spread.gain=0.002", "--set", f"antithetic={pairs}",
                       "--set", "sensor.spread.bias_nT=80", "--set", "estimator.name=msa_joint"]
            self.config("tools.toml", ('estimator = "msa"\n', ""))
            path = self.run_config(*options, config="tools.toml")
            for k in [0, 1, 8, 511, 512, 599]:
                with self.subTest(trial=k, pairs=pairs):
                    _, values = self.replayed("tools.toml", "--trial", k, *options)
                    self.assertEqual((float(k), values), self.sample(path, k))

    def test_points_of_a_sweep(self):
        options = ["--set", "save_samples=600", "--set", "sweep.noise.scale=[1.0, 0.5, 0.25]"]
        path = self.run_config(*options)
        for point, k in itertools.product([0, 1, 2], [3, 599]):
            _, values = self.replayed("base.toml", "--trial", k, "--point", point, *options)
            self.assertEqual((float(k), values), self.sample(path, 600 * point + k))

    def test_without_samples_and_with_any_solver(self):
        _, values = self.replayed("base.toml", "--trial", 4)
        _, other = self.replayed("base.toml", "--trial", 4, "--set", "estimator.solver=nlopt_lbfgs")
        np.testing.assert_allclose(values, other, rtol=1e-3, atol=1)

    def test_numbers_out_of_range(self):
        self.refused(USAGE, "run", "base.toml", "--trial", 600, says="--trial 600: .*numbered 0 to 599")
        self.refused(USAGE, "run", "base.toml", "--trial", 2**63, says="--trial 9223372036854775808")
        self.refused(USAGE, "run", "base.toml", "--trial", 0, "--point", 1, says="--point 1: .*numbered 0 to 0")
        sweep = ["--set", "sweep.noise.scale=[1.0, 0.5]"]
        self.refused(USAGE, "run", "base.toml", "--trial", 0, "--point", 2, *sweep, says="--point 2: .*numbered 0 to 1")
        for arguments in [["--trial=-1"], ["--trial", "0", "--point=-1"]]:
            message = self.refused((USAGE, BAD_INPUT), "run", "base.toml", *arguments, says="-1")
            self.assertNotIn("18446744073709551615", message)

    def test_failed_trials_say_so(self):
        options = ["--set", "estimator.max_iterations=3"]
        path = self.run_config(*options)
        failed = column(path, "tables/failed_trials", "trial")
        self.assertTrue(0 < len(failed) < 600, len(failed))
        self.assertEqual(set(column(path, "tables/parameters", "failed")), {len(failed)})
        for k in [int(failed[0]), int(failed[-1])]:
            self.assertIn("NOT converged", self.call("run", "base.toml", "--trial", k, *options).stdout)
        k = next(i for i in range(600) if i not in set(failed.tolist()))
        self.assertNotIn("NOT converged", self.call("run", "base.toml", "--trial", k, *options).stdout)

    def test_failed_trials_leave_the_control_variate_in_force(self):
        options = ["--set", "estimator.max_iterations=3"]
        path = self.run_config(*options)
        failed = len(column(path, "tables/failed_trials", "trial"))
        get = lambda name: column(path, "tables/control_variate", name)
        self.assertGreaterEqual(len(get("controlled")), 12)
        self.assertTrue(np.isfinite(get("controlled")).all())
        width = lambda name: np.subtract(get(f"{name}_ci_high"), get(f"{name}_ci_low"))
        self.assertTrue((width("controlled") <= width("plain") * (1 + 1e-9)).all())
        self.assertLess(np.median(width("controlled") / width("plain")), 0.7)
        with h5py.File(path) as f:
            self.assertIn(f"{failed} failed", f["tables/control_variate"].attrs["long_name"])
        # The stopping rule goes by the controlled interval too: the first look suffices.
        self.write("stop.toml", CONFIG.replace("trials = 600\n", "") +
                   '[stop]\nrelative_ci = 0.02\nquantities = ["sigma3_gain_x"]\nmax_trials = 200000\n')
        trials = {}
        for controlled in ["true", "false"]:
            stopped = self.run_config(*options, "--set", f"control_variate={controlled}", config="stop.toml",
                                      output=f"{controlled}.h5")
            trials[controlled] = int(column(stopped, "tables/parameters", "trials")[0])
        self.assertLess(trials["true"], trials["false"])


class Antithetic(Case):
    ON = ["--set", "antithetic=true", "--set", "noise.accelerometer_mps2=0.002", "--set", "noise.reference.per=run",
          "--set", "noise.reference.total_nT=60"]

    def test_the_default_is_off_and_in_the_file(self):
        self.assertIs(tomllib.loads(self.call("check", "base.toml").stdout)["antithetic"], False)
        path = self.run_config()
        with h5py.File(path) as f:
            self.assertNotIn("antithetic_pairs", f["tables"])

    def test_small_noise_mirrors_a_pair_about_the_truth(self):
        path = self.run_config(*self.ON, "--set", "noise.scale=1e-4", "--set", "save_samples=600")
        for name, truth in [("gain_x", 1), ("gain_z", 1), ("bias_x_nT", 0), ("bias_z_nT", 0)]:
            errors = column(path, "samples/realisations", name) - truth
            # what does not cancel is second order: 1e-4 of the noise's 1e-3 relative size
            self.assertLess(np.max(np.abs(errors[0::2] + errors[1::2])), 1e-3 * np.std(errors))

    def test_bits_do_not_depend_on_threads_or_instructions(self):
        one = self.run_config(*self.ON, "--trials", 3000, "--threads", 1, output="one.h5")
        three = self.run_config(*self.ON, "--trials", 3000, "--threads", 3, output="three.h5")
        avx2 = self.run_config(*self.ON, "--trials", 3000, output="avx2.h5",
                               env={"SURVEYMC_INSTRUCTION_SET": "x86-64-v3"})
        self.assertEqual(contents(one), contents(three))
        self.assertEqual(contents(one), contents(avx2))
        self.assertRegex(self.call("rerun", one).stdout, "^identical")

    def test_first_trials_of_pairs_are_the_independent_ones(self):
        pairs = self.run_config(*self.ON, "--set", "save_samples=600", output="a.h5")
        alone = self.run_config(*self.ON[2:], "--set", "save_samples=600", output="b.h5")
        for name in ["gain_x", "bias_z_nT", "north_m"]:
            np.testing.assert_array_equal(column(pairs, "samples/realisations", name)[0::2],
                                          column(alone, "samples/realisations", name)[:300])

    def test_statistics_are_those_of_the_pairs(self):
        path = self.run_config(*self.ON, "--set", "save_samples=600")
        rows = list(column(path, "tables/parameters", "quantity"))
        for name in ["gain_x", "bias_z"]:
            y = column(path, "samples/realisations", name + ("_nT" if name.startswith("bias") else ""))
            h, d = (y[0::2] + y[1::2]) / 2, (y[0::2] - y[1::2]) / 2
            value = {c: column(path, "tables/parameters", c) for c in
                     ["monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high", "trials"]}
            mean, sd = rows.index("mean_" + name), rows.index("sigma3_" + name)
            self.assertEqual(value["trials"][mean], 600)
            self.assertAlmostEqual(value["monte_carlo"][sd], 3 * np.sqrt(np.var(h, ddof=1) + np.mean(d * d)), delta=1e-9)
            half = (value["monte_carlo_ci_high"][mean] - value["monte_carlo_ci_low"][mean]) / 2
            np.testing.assert_allclose(half, 1.959963984540054 * np.std(h, ddof=1) / np.sqrt(300), rtol=1e-6)

    def test_a_pair_with_a_failed_trial_is_left_out_whole(self):
        # Large noise with few iterations: some trials fail whose other does not.
        options = [*self.ON, "--set", "estimator.max_iterations=3", "--set", "save_samples=600"]
        path = self.run_config(*options)
        failed = set(column(path, "tables/failed_trials", "trial").tolist())
        alone = {k ^ 1 for k in failed} - failed
        self.assertTrue(failed and alone, (len(failed), len(alone)))
        counts = {c: int(column(path, "tables/antithetic_pairs", c)[0]) for c in ["trials", "failed", "left_out", "pairs"]}
        self.assertEqual(counts, {"trials": 600, "failed": len(failed), "left_out": len(alone),
                                  "pairs": (600 - len(failed) - len(alone)) // 2})
        self.assertEqual(set(column(path, "tables/position", "failed")), {len(failed)})
        with h5py.File(path) as f:  # not of all converged trials
            self.assertIn(f"of the pairs of which both trials converged: {len(failed)} failed",
                          f["tables/control_variate"].attrs["long_name"])
            self.assertIn(f"and {len(alone)} converged beside one that failed", f["tables/control_variate"].attrs["long_name"])
        saved = column(path, "samples/realisations", "trial").astype(int)  # all that converged, as without pairs
        self.assertEqual(saved.tolist(), [k for k in range(600) if k not in failed])
        keep = np.array([k ^ 1 not in failed for k in saved])
        mean = list(column(path, "tables/parameters", "quantity")).index("mean_bias_z")
        np.testing.assert_allclose(column(path, "tables/parameters", "monte_carlo")[mean],
                                   np.mean(column(path, "samples/realisations", "bias_z_nT")[keep]), rtol=1e-9, atol=1e-9)

    def test_replay_has_the_sign_of_the_run(self):
        options = [*self.ON, "--set", "save_samples=600"]
        path = self.run_config(*options)
        for k in [0, 1, 6, 7, 8, 511, 512, 599]:
            out = self.call("run", "base.toml", "--trial", k, *options).stdout
            value = float(re.search(r"(?m)^\s+bias_z\s+(\S+) nT$", out).group(1))
            self.assertEqual(value, column(path, "samples/realisations", "bias_z_nT")[k])

    def test_stopping_rule(self):
        text = CONFIG.replace("trials = 600\n", "antithetic = true\n") + (
            '[stop]\nrelative_ci = 0.001\nquantities = ["sigma3_gain_x"]\nmax_trials = 200000\n')
        for controlled in ["true", "false"]:
            self.write("stop.toml", text.replace("seed = 1", f"seed = 1\ncontrol_variate = {controlled}"))
            path = self.run_config(config="stop.toml", output=f"{controlled}.h5")
            trials = int(column(path, "tables/antithetic_pairs", "trials")[0])
            self.assertEqual(trials, 4096 if controlled == "true" else 200000)

    def test_when_no_trial_converges(self):
        none = ["--set", "estimator.max_iterations=1", "--set", "estimator.step_tolerance=1e-15"]
        path = self.run_config(*self.ON, *none, output="fixed.h5")
        self.assertEqual(int(column(path, "tables/antithetic_pairs", "pairs")[0]), 0)
        self.write("stop.toml", CONFIG.replace("trials = 600\n", "antithetic = true\n") +
                   '[stop]\nrelative_ci = 0.001\nquantities = ["sigma3_gain_x"]\nmax_trials = 20000\n')
        path = self.run_config(*none, config="stop.toml", output="stop.h5")
        self.assertEqual(int(column(path, "tables/antithetic_pairs", "failed")[0]), 20000)

    def test_few_trials(self):
        for trials in [2, 4, 8, 42]:
            path = self.run_config(*self.ON, "--trials", trials, output=f"{trials}.h5")
            self.assertEqual(int(column(path, "tables/antithetic_pairs", "pairs")[0]), trials // 2)


class Sweeps(Case):
    def test_points_columns_and_order(self):
        """Cases vary slowest, then the keys in alphabetical order, the last one fastest."""
        self.config("sweep.toml", ("trials = 600", "trials = 20\nsave_samples = 2"), append="""
[sweep]
"noise.scale" = { from = 0.25, to = 0.75, step = 0.25 }
"noise.law" = ["uniform", "gaussian"]
[[sweep.case]]
name = "zulu"
"field.dip_deg" = 50.0
[[sweep.case]]
name = "alpha"
"field.dip_deg" = 70.0
""")
        out = self.call("check", "sweep.toml").stdout
        self.assertIn("# 12 sweep points, 240 trials in all", out)
        self.assertEqual(tomllib.loads(out)["sweep"]["noise.law"], ["uniform", "gaussian"])
        path = self.run_config(config="sweep.toml")
        expected = list(itertools.product(["zulu", "alpha"], ["uniform", "gaussian"], ["0.25", "0.5", "0.75"]))
        with h5py.File(path) as f:
            tables = [t for t in f["tables"] if t not in ("answer", "family", "warnings")]  # of all points together
        self.assertLessEqual(COUNT_TRIALS, set(tables))
        for table in tables + ["realisations"]:
            with self.subTest(table=table):
                header, rows = self.table_csv(path, table)
                self.assertEqual(header[:3], ["case", "noise.law", "noise.scale"])
                if rows or table != "failed_trials":
                    self.assertEqual(list(dict.fromkeys(tuple(r[:3]) for r in rows)), expected)
        self.assertEqual(len(column(path, "samples/realisations", "trial")), 24)
        # The values belong to the points they are labelled with.
        header, rows = self.table_csv(path, "parameters")
        sd = {tuple(r[:3]): float(r[header.index("analytic")]) for r in rows
              if r[header.index("quantity")] == "sigma3_bias_x"}
        for case, law in itertools.product(["zulu", "alpha"], ["uniform", "gaussian"]):
            self.assertAlmostEqual(sd[case, law, "0.75"] / sd[case, law, "0.25"], 3, delta=1e-9)
        single = self.run_config("--set", "field.dip_deg=70", "--set", "noise.law=gaussian", "--set", "noise.scale=0.5",
                                 "--trials", 20, output="single.h5")
        header, rows = self.table_csv(single, "parameters")
        row = next(r for r in rows if r[header.index("quantity")] == "sigma3_bias_x")
        self.assertEqual(float(row[header.index("analytic")]), sd["alpha", "gaussian", "0.5"])

    def test_fixing_a_swept_key_takes_it_out(self):
        self.config("sweep.toml", append='[sweep]\n"noise.scale" = [1.0, 0.5]\n"field.dip_deg" = [50.0, 60.0, 70.0]\n')
        self.assertIn("# 6 sweep points, 3600 trials", self.call("check", "sweep.toml").stdout)
        out = self.call("check", "sweep.toml", "--set", "noise.scale=0.1").stdout
        self.assertIn("# 3 sweep points, 1800 trials", out)
        self.assertEqual(tomllib.loads(out)["noise"]["scale"], 0.1)
        self.assertIn("# 12 sweep points", self.call("check", "sweep.toml", "--set", "sweep.noise.scale=[1.0,2.0,3.0,4.0]").stdout)

    def test_every_point_of_a_sweep_sees_the_noise_of_the_single_run(self):
        swept = self.run_config("--set", "sweep.field.declination_deg=[0.0, 5.0]", "--set", "save_samples=3", output="a.h5")
        alone = self.run_config("--set", "field.declination_deg=5.0", "--set", "save_samples=3", output="b.h5")
        for name in ["gain_x", "bias_z_nT", "north_m"]:
            np.testing.assert_array_equal(column(swept, "samples/realisations", name)[3:],
                                          column(alone, "samples/realisations", name))


class Extremes(Case):
    TRUTH = {"gain_x": 1.1, "gain_y": 0.95, "gain_z": 1.02, "bias_x_nT": 250, "bias_y_nT": -350, "bias_z_nT": 850}

    def zero_noise(self):
        self.call("run", "base.toml", "-o", "out.h5", "--set", "noise.magnetometer_nT=0", "--set", "save_samples=600",
                  "--set", "sensor.gain=[1.1, 0.95, 1.02]", "--set", "sensor.bias_nT=[250, -350, 850]")
        return self.folder / "out.h5"

    def test_without_noise_the_estimate_is_the_truth(self):
        path = self.zero_noise()
        self.assertEqual(len(column(path, "samples/realisations", "trial")), 600)
        self.assertEqual(set(column(path, "tables/parameters", "failed")), {0})
        rows = dict(zip(column(path, "tables/parameters", "quantity"), column(path, "tables/parameters", "monte_carlo")))
        for name, value in self.TRUTH.items():
            np.testing.assert_allclose(column(path, "samples/realisations", name), value, rtol=1e-9, err_msg=name)
            self.assertAlmostEqual(rows["mean_" + name.removesuffix("_nT")] / value, 1, delta=1e-9)
        self.call("rerun", path)

    def test_without_noise_the_notes_are_readable(self):
        path = self.zero_noise()
        for table in ["parameters", "position"]:
            for note in column(path, f"tables/{table}", "note"):
                self.assertNotRegex(note, r"(?i)\b(nan|inf)\b")
                self.assertNotRegex(note, r"\d{9}", "a shift in units of a rounding error")

    def test_without_noise_nothing_differs_from_its_prediction(self):
        path = self.zero_noise()
        for table in ["parameters", "position", "ellipse"]:
            self.assertNotIn("differs", list(column(path, f"tables/{table}", "verdict")), table)

    def test_when_no_trial_converges(self):
        path = self.run_config("--set", "estimator.max_iterations=1", "--set", "save_samples=5")
        for table in COUNT_TRIALS:
            self.assertEqual(set(column(path, f"tables/{table}", "failed")), {600}, table)
            self.assertEqual(set(column(path, f"tables/{table}", "trials")), {600}, table)
        np.testing.assert_array_equal(column(path, "tables/failed_trials", "trial"), np.arange(600))
        self.assertEqual(len(column(path, "samples/realisations", "trial")), 0)
        self.assertTrue(np.all(np.isnan(column(path, "tables/parameters", "monte_carlo"))))
        self.assertLessEqual(set(column(path, "tables/parameters", "verdict")), {"", "undecided"})
        with h5py.File(path) as f:
            for group in f["tables"].values():
                for name, d in group.items():
                    self.assertFalse(d.dtype.kind == "f" and np.any(np.isinf(d[()])), f"{group.name}/{name} is infinite")
        self.call("show", path)
        self.call("rerun", path)

    def test_few_trials(self):
        for trials in [2, 3, 4, 5, 8, 9, 511, 512, 513]:
            with self.subTest(trials=trials):
                path = self.run_config("--trials", trials)
                self.assertEqual(set(column(path, "tables/position", "trials")), {trials})
                self.call("rerun", path)

    def test_very_large_noise(self):
        path = self.run_config("--set", "noise.magnetometer_nT=100000", "--trials", 200)
        self.call("rerun", path)

    def test_many_threads(self):
        path = self.run_config("--threads", 64, "--trials", 100)
        self.assertEqual(content_hash(path), content_hash(self.run_config("--trials", 100, output="b.h5")))

    def peak_kilobytes(self, trials):
        child = subprocess.Popen([EXECUTABLE, "run", "base.toml", "-o", f"{trials}.h5", "--trials", str(trials), "--threads", "2"],
                                 cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(child.returncode, DONE)
        return usage.ru_maxrss

    def test_memory_does_not_grow_with_trials(self):
        if "Release" not in self.call("--version").stdout:
            self.skipTest("memory is measured in a release build")
        self.assertLess(self.peak_kilobytes(400_000) - self.peak_kilobytes(20_000), 10_000)


RELIABILITY = """\
experiment = "reliability_map"
seed = 1
mode = "sse"
observation = "bx"
inclination_deg = 30.0
toolface_deg = { from = 0.0, to = 180.0, step = 45.0 }
magnetic_azimuth_deg = [0.0, 60.0, 90.0]
"""


class ReliabilityMaps(Case):
    def reliability(self, *changes, append=""):
        text = RELIABILITY
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new)
        return self.write("map.toml", text + append)

    def maps(self, *arguments):
        self.call("run", "map.toml", "-o", "map.h5", *arguments)
        with h5py.File(self.folder / "map.h5") as f:
            return {name: (d[()], [dim[0].name.split("/")[-1] for dim in d.dims], d.attrs.get("units"))
                    for name, d in f["maps"].items() if not h5py.h5ds.is_scale(d.id)}

    def test_names_axes_units_and_a_value(self):
        self.reliability()
        maps = self.maps()
        self.assertEqual(list(maps), ["redundancy_number", "minimal_detectable_error", "external_inclination_deg",
                                      "external_toolface_deg", "external_azimuth_deg"])
        for values, axes, _ in maps.values():
            self.assertEqual(values.shape, (1, 5, 3))
            self.assertEqual(axes, ["inclination", "toolface", "magnetic_azimuth"])
        self.assertEqual([m[2] for m in maps.values()], ["1", "nT", "deg", "deg", "deg"])
        self.assertAlmostEqual(maps["minimal_detectable_error"][0][0, 1, 1], 689.04775, delta=5e-6)
        self.assertAlmostEqual(maps["external_azimuth_deg"][0][0, 1, 1], -0.593197, delta=5e-7)
        self.assertTrue(np.isinf(maps["minimal_detectable_error"][0][0, 0, 0]))

    def test_more_axes_lead(self):
        self.reliability(('"bx"', '"all"'), append="noise_scale = [0.5, 1.0]\n[field]\ndip_deg = [70.0, 75.0]\n")
        values, axes, unit = self.maps("--set", 'sweep.alpha=[1e-4, 1e-3]')["minimal_detectable_error"]
        self.assertEqual(axes, ["alpha", "observation", "noise_scale", "dip", "inclination", "toolface", "magnetic_azimuth"])
        self.assertEqual(values.shape, (2, 9, 2, 2, 1, 5, 3))
        self.assertEqual(unit, "mixed")
        self.assertAlmostEqual(values[0, 3, 1, 1, 0, 1, 1], 689.04775, delta=5e-6)
        self.assertTrue(np.all((values[1] < values[0]) | np.isinf(values[0])))  # a coarser test finds smaller errors

    def test_streamed_and_held_maps_are_the_same(self):
        self.reliability(("30.0", "{ from = 1.0, to = 90.0, step = 1.0 }"), ("step = 45.0", "step = 1.0"),
                         ("[0.0, 60.0, 90.0]", "{ from = 0.0, to = 179.0, step = 1.0 }"),
                         append='maps = ["minimal_detectable_error"]\n')
        held = self.maps("--set", "tolerance.inclination_deg=0.1")["minimal_detectable_error"][0]  # tolerances need it whole
        medians = list(column(self.folder / "map.h5", "tables/summary", "median"))
        streamed = self.maps()["minimal_detectable_error"][0]
        self.assertTrue(np.array_equal(streamed, held))
        self.assertEqual(list(column(self.folder / "map.h5", "tables/summary", "median")), medians)
        self.assertIn("identical", self.call("rerun", "map.h5").stdout)
        # A second observation makes it larger than what can be needed whole: medians to 1e-6
        both = self.maps("--set", 'observation=["bx", "bz"]')["minimal_detectable_error"][0]
        self.assertEqual(both.shape, (2, *held.shape))
        self.assertTrue(np.array_equal(both[0], held))
        self.assertIn("identical", self.call("rerun", "map.h5").stdout)

    def test_instruction_sets_give_the_same_bits(self):
        self.reliability(('"bx"', '"all"'))
        first = self.maps()
        self.call("run", "map.toml", "-o", "v3.h5", env={"SURVEYMC_INSTRUCTION_SET": "x86-64-v3"})
        self.assertEqual(content_hash(self.folder / "map.h5"), content_hash(self.folder / "v3.h5"))
        self.assertEqual(len(first), 5)

    def test_responses_to_a_gross_error(self):
        # g_z alone, equal weights (figure 1 of Nyrnes et al.): e_x = -5 Gal cos I sin I sin tau, e_z = 5 Gal cos^2 I
        self.reliability(('"sse"', '"mse_fixed"'), ('"bx"', '"gz"'), append="gross_error_mps2 = 0.05\n[field]\ngravity_mps2 = 9.8\n"
                         "[sigma]\nmagnetometer_noise_nT = 1e5\n")
        maps = self.maps()
        names = [n for n in maps if n.startswith(("residual_", "effect_"))]
        self.assertEqual(names, ["residual_gx_mps2", "residual_gy_mps2", "residual_gz_mps2", "residual_bx_nT", "residual_by_nT",
                                 "residual_bz_nT", "effect_inclination_deg", "effect_toolface_deg", "effect_azimuth_deg"])
        self.assertEqual([maps[n][2] for n in names], ["mps2"] * 3 + ["nT"] * 3 + ["deg"] * 3)
        size = 0.05 * 0.5 * np.sqrt(0.75)
        for name, expected in (("residual_gx_mps2", -size * np.sqrt(0.5)), ("residual_gz_mps2", 0.05 * 0.75),
                               ("effect_inclination_deg", -np.degrees(0.05 / 9.8) * 0.5)):
            self.assertAlmostEqual(maps[name][0][0, 1, 0], expected, delta=1e-7 * abs(expected))  # tau = 45
        # Twice the error, twice the response; and a result runs again from what is in it
        twice = self.maps("--set", "gross_error_mps2=0.1")
        np.testing.assert_allclose(twice["residual_gz_mps2"][0], 2 * maps["residual_gz_mps2"][0], rtol=1e-13)
        self.assertIn("identical", self.call("rerun", "map.h5").stdout)

    def test_where_two_residuals_cross(self):
        crossing = ('[[statement]]\ntext = "figure 1"\nquantity = "residual_gz_mps2"\nstatistic = "crossing"\n'
                    'crosses = "residual_gx_mps2"\nwhere = { toolface_deg = 45.0, magnetic_azimuth_deg = 0.0 }\n'
                    "published = 54.74\ntolerance = 0.0002\n")
        changes = (('"sse"', '"mse_fixed"'), ('"bx"', '"gz"'), ("30.0", "{ from = 0.0, to = 90.0, step = 0.5 }"))
        body = "gross_error_mps2 = 0.05\n[sigma]\nmagnetometer_noise_nT = 1e5\n"
        self.reliability(*changes, append=body + crossing)
        self.call("run", "map.toml", "-o", "map.h5", "--check")
        self.assertAlmostEqual(column(self.folder / "map.h5", "tables/statements", "found")[0], 54.7356, delta=2e-3)
        for old, new, rule in (('"crossing"', '"maximum"', "only with a crossing"), ("gx_mps2", "bx_nT", "another unit"),
                               ("published", "level = 1.0\npublished", "not together with crosses")):
            self.reliability(*changes, append=body + crossing.replace(old, new))
            self.refused(BAD_INPUT, "run", "map.toml", "-o", "no.h5", says=rule)

    def test_statements_need_like_points(self):
        statement = '[[statement]]\ntext = "t"\nquantity = "external_azimuth_deg"\npublished = 1.0\nstatistic = '
        inclined = ("30.0", "{ from = 10.0, to = 80.0, step = 10.0 }")
        for body, rule in (('"crossing"\nlevel = 1.0\nwhere = { toolface_deg = 45.0 }\n', "several points at one"),
                           ('"largest_ratio"\nwhere = { toolface_deg = 45.0 }\nrelative_to = { inclination_deg = 30.0 }\n',
                            "other points than those of where"),
                           ('"largest_ratio"\nwhere = { toolface_deg = 45.0 }\nrelative_to = { toolface_deg = 90.0, '
                            'inclination_deg = 30.0 }\n', "other points than those of where")):
            self.reliability(inclined, append=statement + body)
            self.refused(BAD_INPUT, "check", "map.toml", says=rule)
        for body in ('"crossing"\nlevel = 1.0\nwhere = { toolface_deg = 45.0, magnetic_azimuth_deg = 60.0 }\n',
                     '"largest_ratio"\nwhere = { toolface_deg = 45.0 }\nrelative_to = { toolface_deg = 90.0 }\n'):
            self.reliability(inclined, append=statement + body)
            self.call("check", "map.toml")

    def test_combinations_of_observations(self):
        self.reliability(('observation = "bx"', 'weakest_of = ["bx", "by"]'))
        weakest = self.maps()
        self.assertEqual(list(weakest)[5:], ["direction_bx", "direction_by", "test_dimension", "test_alpha"])
        self.assertEqual(weakest["minimal_detectable_error"][2], "1")
        self.assertEqual(weakest["minimal_detectable_error"][1], ["inclination", "toolface", "magnetic_azimuth"])
        at = (0, 1, 1)  # tau 45, A 60
        direction = [float(weakest[f"direction_{o}"][0][at]) for o in ("bx", "by")]
        self.assertAlmostEqual(np.hypot(*direction), 1, delta=1e-12)
        self.assertEqual(weakest["test_dimension"][0][at], 2)
        self.assertAlmostEqual(weakest["test_alpha"][0][at], 6.29e-4, delta=1e-6)
        # That direction, given, is as long; any other one is shorter, and the longest of single readings is, too
        for entries, check in ((direction, lambda a, b: self.assertAlmostEqual(a / b, 1, delta=1e-9)),
                               ([1.0, -1.0], self.assertLess), ([1.0, 2.0], self.assertLess)):
            self.reliability(('observation = "bx"', f"direction = {{ by = {entries[1]!r}, bx = {entries[0]!r} }}"))
            given = self.maps()
            self.assertNotIn("direction_bx", given)
            check(given["minimal_detectable_error"][0][at], weakest["minimal_detectable_error"][0][at])
        self.assertEqual(column(self.folder / "map.h5", "tables/summary", "observation")[0], "0.4472 bx + 0.8944 by")

    def test_combinations_and_gross_errors_that_are_refused(self):
        for replaced, rule in (('weakest_of = ["bx"]', "two observations or more"), ('weakest_of = ["bx", "bq"]', "none of gx"),
                               ('weakest_of = ["bx", "bx"]', "twice"), ("direction = { bx = 1.0 }", "two observations or more"),
                               ("direction = { bx = 1.0, by = 0.0 }", "must not be 0"), ("direction = { bx = 1.0, q = 1.0 }", "none of"),
                               ('observation = "bx"\nweakest_of = ["bx", "by"]', "not together with observation"),
                               ('weakest_of = ["gx", "gy"]\ndirection = { bx = 1.0, by = 1.0 }', "not together with direction"),
                               ('weakest_of = ["bx", "by"]\ngross_error_nT = 5.0', "no observation of the maps has this unit"),
                               ('weakest_of = ["bx", "by"]\nmaps = ["max_correlation"]', "none of redundancy_number"),
                               ('observation = "bx"\ngross_error_mps2 = 0.1', "no observation of the maps has this unit"),
                               ('observation = ["bx", "gx"]\ngross_error_mps2 = 0.1', "bx needs gross_error_nT"),
                               ('observation = "bx"\ngross_error_nT = 0.0', "must not be 0"),
                               ('observation = "bx"\ngross_error = 5.0', "gross_error"),
                               ('observation = "bx"\nmaps = ["residual_bx_nT"]', "residual_bx_nT needs .*gross_error_nT"),
                               ('observation = "bx"\ngross_error_nT = 5.0\nmaps = ["residual_q"]', "none of")):
            self.reliability(('observation = "bx"', replaced))
            self.refused(BAD_INPUT, "run", "map.toml", "-o", "map.h5", says=rule)
        self.reliability(('"sse"', '"sse_axial"'), ('observation = "bx"', 'weakest_of = ["bx", "bz"]'))
        self.refused(BAD_INPUT, "run", "map.toml", "-o", "map.h5", says="bz is not observed in mode sse_axial")
        self.reliability(('"sse"', '"mse_fixed"'), append='gross_error_nT = 5.0\nmaps = ["residual_dip_deg"]\n')
        self.refused(BAD_INPUT, "run", "map.toml", "-o", "map.h5", says='"residual_dip_deg" is none of')

    def test_nonlinear_errors_of_multi_station_modes(self):
        self.reliability(('"sse"', '"mse_shared"'), ("{ from = 0.0, to = 180.0, step = 45.0 }", "[0.0, 2.0]"),
                         ("[0.0, 60.0, 90.0]", "[0.0, 2.0]"),
                         append='maps = ["minimal_detectable_error", "nonlinear_detectable_error_plus", '
                                '"nonlinear_detectable_error_minus"]\n')
        for terms in ("false", "true"):
            linear, plus, minus = (m[0] for m in self.maps("--set", f"systematic_terms={terms}").values())
            self.assertTrue(np.isinf(linear[0, 0, 0]))
            self.assertTrue(np.all(np.isfinite(plus)) and np.all(plus > 0) and np.all(minus < 0))
            self.assertLess(plus[0, 1, 1], 0.8 * -minus[0, 1, 1])

    def test_what_is_refused(self):
        for rule, *changes in (("mode = .*must be", ('"sse"', '"msse"')), ("none of gx", ('"bx"', '"bq"')),
                               ("not observed in mode sse_axial", ('"sse"', '"sse_axial"'), ('"bx"', '"bz"')),
                               ("not observed in mode mse_fixed", ('"sse"', '"mse_fixed"'), ('"bx"', '"gravity"')),
                               ("in the list twice", ('"bx"', '["bx", "bx"]')), ("must not be empty", ('"bx"', "[]")),
                               ("must not be empty", ("[0.0, 60.0, 90.0]", "[]")),
                               ("inclination_deg = 190", ("30.0", "190.0")), ("inclination_deg", ("30.0", "nan")),
                               ("step", ("step = 45.0", "step = -45.0"))):
            self.reliability(*changes)
            self.refused(BAD_INPUT, "run", "map.toml", "-o", "map.h5", says=rule)
        self.reliability()
        for setting, rule in (("alpha=0", "alpha = 0"), ("alpha=1", "alpha = 1"), ("alpha=0.6", "0.5"), ("power=1.0", "power = 1"),
                              ("power=0", "power = 0"), ("alpha=0.3", ""), ("tails=three", "tails"),
                              ("power=0.00001", "false alarm"), ("sigma.gravity_nT=3", "gravity"), ("toolfaces_deg=3", "toolface"),
                              ("sigma.magnetometer_noise_nT=0", "noise"), ('maps=["x"]', "none of"),
                              ("sweep.inclination_deg=[10.0, 20.0]", "inclination"), ("field.dip_deg=90", "dip_deg"),
                              ("stations=0", "stations")):
            if setting == "alpha=0.3":
                self.call("check", "map.toml", "--set", setting)
                continue
            self.refused(BAD_INPUT, "run", "map.toml", "-o", "map.h5", "--set", setting, says=rule)
        self.refused(USAGE, "run", "map.toml", "--trial", 0, says="no trials")

    def test_well(self):
        self.write("well.toml", 'experiment = "reliability_well"\nseed = 1\nmode = "mse_shared"\nobservation = "all"\n'
                                '[survey]\nfile = "survey.csv"\ntoolface_zero = "y"\n')
        self.call("run", "well.toml", "-o", "well.h5")
        self.assertEqual(len(column(self.folder / "well.h5", "tables/stations", "md_m")), 6 * 6 + 3)
        for angle in ("inclination", "toolface", "azimuth"):
            sizes = np.abs(column(self.folder / "well.h5", "tables/stations", f"external_{angle}_deg"))
            self.assertTrue(np.all(np.isnan(sizes) | (sizes <= 180)), angle)
        self.write("mine.csv", SURVEY.replace(",toolface_deg", "").replace(",0\n", "\n").replace(",50\n", "\n")
                   .replace(",120\n", "\n").replace(",200\n", "\n").replace(",300\n", "\n").replace(",40\n", "\n"))
        self.refused(BAD_INPUT, "run", "well.toml", "-o", "b.h5", "--set", "survey.file=mine.csv", says="toolface")
        self.call("run", "well.toml", "-o", "b.h5", "--set", "survey.file=mine.csv", "--set", "toolface=worst")
        self.refused(BAD_INPUT, "run", "well.toml", "-o", "c.h5", "--set", "stations=3", says="the survey has 6")
        self.call("check", "well.toml", "--set", "stations=6")

    def test_rounding_of_no_effect_is_no_difference(self):
        self.write("down.csv", "md_m,inclination_deg,azimuth_deg,toolface_deg\n0,0,0,30\n30,0,0,30\n60,0,0,30\n")
        self.write("well.toml", 'experiment = "reliability_well"\nseed = 1\nmode = "sse"\nobservation = "gz"\n'
                                '[survey]\nfile = "down.csv"\ntoolface_zero = "y"\n')
        self.call("run", "well.toml", "-o", "well.h5")
        self.assertLess(max(column(self.folder / "well.h5", "tables/stations", "position_m")), 1e-9)
        with h5py.File(self.folder / "well.h5") as f:
            self.assertEqual(set(f["tables/stations/note"].asstr()[()]), {""})


GROSS_ERROR = """\
experiment = "gross_error_detection"
seed = 1
trials = 3000
mode = "sse"
inclination_deg = 30.0
toolface_deg = 45.0
magnetic_azimuth_deg = 60.0
[[inject]]
observation = "bx"
size = "minimal_detectable"
"""


class GrossErrors(Case):
    def errors(self, *changes, append=""):
        text = GROSS_ERROR
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new)
        return self.write("error.toml", text + append)

    def rates(self, path="e.h5"):
        with h5py.File(self.folder / path) as f:
            table = f["tables/detection"]
            return dict(zip(zip(table["formulation"].asstr()[()], table["quantity"].asstr()[()]), table["monte_carlo"][()]))

    def test_full_configs_give_their_verdicts(self):
        for name in ("detection", "weak_geometry", "linear_size"):
            self.call("run", SOURCE / f"configs/gross_error/{name}.toml", "-o", f"{name}.h5", "--check")
        rates = self.rates("linear_size.h5")
        self.assertGreater(rates["linear", "detection_bx"], 0.999)  # not the designed 0.8

    def test_rates_add_up_and_threads_do_not_matter(self):
        self.errors()
        self.call("run", "error.toml", "-o", "e.h5", "--threads", 1)
        rates = self.rates()
        self.assertAlmostEqual(rates["linear", "detection_bx"], 0.802, delta=4 * (0.16 / 3000)**0.5)
        outcomes = [rate for (formulation, _), rate in rates.items() if formulation == "single"]
        self.assertEqual(len(outcomes), 5)
        self.assertAlmostEqual(sum(outcomes), 1, delta=1e-12)
        self.assertAlmostEqual(rates["single", "missed"], 1 - rates["linear", "detection_any"], delta=1e-12)
        self.call("run", "error.toml", "-o", "b.h5", "--threads", 2, env={"SURVEYMC_INSTRUCTION_SET": "x86-64-v3"})
        self.assertEqual(content_hash(self.folder / "e.h5"), content_hash(self.folder / "b.h5"))
        self.assertIn("identical", self.call("rerun", "e.h5").stdout)
        self.assertIn("single: ", self.call("run", "error.toml", "--trial", 5).stdout)

    def test_replay_prints_all_that_is_adjusted(self):
        """Least squares of the printed numbers, by the paper's six unknowns, gives the printed Omega and w."""
        self.errors(('toolface_deg = ', 'sigma.magnetometer_scale = 0.0\nsigma.accelerometer_scale = 0.0\ntoolface_deg = '))
        sd = np.array([np.hypot(0.0039, 0.003)] * 3 + [np.hypot(70, 70)] * 2 + [np.sqrt(150**2 + 2 * 70**2), 0.003, 65, np.deg2rad(0.12)])

        def model(x):
            inclination, toolface, azimuth, gravity, total, dip = x
            (si, st, sa, sd_), (ci, ct, ca, cd) = np.sin([*x[:3], dip]), np.cos([*x[:3], dip])
            down, north = np.array([-si * st, -si * ct, ci]), np.array([ci * ca * st + sa * ct, ci * ca * ct - sa * st, si * ca])
            return np.array([*(gravity * down), *(total * (cd * north + sd_ * down)), gravity, total, dip])

        for trial in (0, 5):
            for part in re.split(r"(?m)^with.* errors: ", self.call("run", "error.toml", "--trial", trial).stdout)[1:]:
                found = np.array(re.findall(r"(?m)^  (?:station 0 )?\w+ +(\S+) \w+, w (\S+)$", part), float)
                self.assertEqual(found.shape, (9, 2))
                y = np.array([*found[:8, 0], np.deg2rad(found[8, 0])])
                x = np.array([*np.deg2rad([30, 45, 60]), *y[6:]])
                step = np.array([1e-6] * 3 + [1e-5, 0.05, 1e-6])
                for _ in range(12):
                    a = np.array([(model(x + h) - model(x - h)) / (2 * h.sum()) for h in np.diag(step)]).T / sd[:, None]
                    e = (y - model(x)) / sd
                    x = x + np.linalg.lstsq(a / np.linalg.norm(a, axis=0), e, rcond=None)[0] / np.linalg.norm(a, axis=0)
                q, _ = np.linalg.qr(a / np.linalg.norm(a, axis=0))
                self.assertAlmostEqual(e @ e / float(re.search(r"Omega (\S+)", part)[1]), 1, delta=1e-8)
                np.testing.assert_allclose(e / np.sqrt(1 - (q**2).sum(axis=1)), found[:, 1], atol=2e-6)

    def test_replay_prints_references_without_error_and_systematic_terms(self):
        self.errors(('mode = "sse"', 'mode = "mse_fixed"'))
        self.assertRegex(self.call("run", "error.toml", "--trial", 5).stdout, r"(?m)^  dip 75 deg$")
        self.errors(('mode = "sse"', 'mode = "mse_shared"\nstations = 2\nsystematic_terms = true'))
        self.assertEqual(len(re.findall(r"(?m)^  systematic_term_\d+ 0, w ", self.call("run", "error.toml", "--trial", 5).stdout)), 24)

    def test_sizes(self):
        with_size = lambda size: (('size = "minimal_detectable"', size),)
        for change, expected in ((with_size("size_nT = -250.0"), -250), ((), 689.04775),
                                 (with_size('size = "minimal_detectable"\nfactor = -2.0'), -2 * 689.04775),
                                 (with_size('size = "nonlinear_detectable"\nfactor = -1.0'), -689.831)):
            self.errors(*change)
            self.call("run", "error.toml", "-o", "e.h5", "--trials", 10)
            self.assertAlmostEqual(column(self.folder / "e.h5", "tables/injected", "size")[0], expected, delta=1e-3)
        self.errors()
        self.call("run", "error.toml", "-o", "e.h5", "--trials", 10, "--set", "factor=0.5")
        self.assertAlmostEqual(column(self.folder / "e.h5", "tables/injected", "size")[0], 0.5 * 689.04775, delta=1e-3)

    def row(self, formulation, quantity, path="e.h5"):
        with h5py.File(self.folder / path) as f:
            table = f["tables/detection"]
            names = list(zip(table["formulation"].asstr()[()], table["quantity"].asstr()[()]))
            at = names.index((formulation, quantity))
            return table["monte_carlo"][at], table["analytic"][at], table["verdict"].asstr()[at]

    def test_a_reading_that_linear_theory_does_not_control_raises_false_alarms(self):
        self.errors(("45.0", "0.0"), ("60.0", "0.0"), ('size = "minimal_detectable"', "size_nT = 3000.0"))
        self.call("run", "error.toml", "-o", "e.h5", "--set", "alpha=0.05")
        self.assertEqual(column(self.folder / "e.h5", "tables/injected", "redundancy_number")[0], 0)
        found, predicted, verdict = self.row("design", "false_alarm_bx")
        self.assertEqual(predicted, 0.1)
        self.assertAlmostEqual(found, predicted, delta=5 * (0.09 / 3000)**0.5)
        self.assertNotEqual(verdict, "differs")

    def test_a_tie_of_the_vertical_alone_predicts_no_identification(self):
        self.errors(("30.0", "0.0"), ('"bx"', '"gz"'))
        self.call("run", "error.toml", "-o", "e.h5", "--trials", 1000)
        for outcome in ("identified", "identified_group", "identified_wrong"):
            found, predicted, verdict = self.row("single", outcome)
            self.assertGreater(found, 0.1)
            self.assertTrue(np.isnan(predicted))
            self.assertEqual(verdict, "")
        self.assertAlmostEqual(self.row("single", "missed")[1], 0.2, delta=1e-3)

    def test_many_errors_are_identified_in_any_order_of_rejection(self):
        large = "".join(f'[[inject]]\nobservation = "bx"\nstation = {k}\nsize_nT = {5000 + 500 * k}\n' for k in range(1, 7))
        self.errors(('"sse"', '"mse_shared"\nstations = 30\nstrategy = "iterative"'),
                    ('size = "minimal_detectable"', "size_nT = 5000"), append=large)
        self.call("run", "error.toml", "-o", "e.h5", "--trials", 50)
        self.assertGreater(self.rates()["iterative", "identified"], 0.8)

    def test_inseparable_readings_are_never_identified(self):
        self.errors(('"sse"', '"sse_axial"'))
        self.call("run", "error.toml", "-o", "e.h5")
        rates = self.rates()
        self.assertEqual(rates["single", "identified"], 0)
        self.assertGreater(rates["single", "identified_group"], 0.7)

    def test_what_is_refused(self):
        for rule, *changes in (("not observed in mode mse_fixed", ('"sse"', '"mse_fixed"'), ('"bx"', '"dip"')),
                               ("observation = .*must be", ('"bx"', '"bq"')),
                               ("errors of bx are in nT", ('size = "minimal_detectable"', "size_mps2 = 3.0")),
                               ("is infinite", ("45.0", "0.0"), ("60.0", "0.0")),
                               ("only with mode", ("45.0", "[45.0, 50.0]")),
                               ("must not be empty", ("45.0", "[]")), ("station", ('"bx"', '"bx"\nstation = 1')),
                               ("has two errors", ("[[inject]]", '[[inject]]\nobservation = "bx"\nsize_nT = 5.0\n[[inject]]')),
                               ("not together with size", ('"bx"', '"bx"\nsize_nT = 3.0'))):
            self.errors(*changes)
            self.refused(BAD_INPUT, "run", "error.toml", "-o", "e.h5", says=rule)
        self.errors()
        for setting, rule in (("alpha=0", "alpha = 0"), ("power=1.0", "power = 1"), ("test=f", "test"), ("strategy=all", "strategy"),
                              ('strategy=["single","single"]', "twice"), ("trials=0", "trials"), ("toolfaces_deg=1", "toolface"),
                              ("rotational_shot=true", "rotational_shot"), ("verdict.false_alarm_margin=2", "margin")):
            self.refused(BAD_INPUT, "run", "error.toml", "-o", "e.h5", "--set", setting, says=rule)
        self.refused(BAD_INPUT, "run", "error.toml", "-o", "e.h5", "--set", "test=pope", "--set", "strategy=pairs", says="known variance")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    EXECUTABLE = str(Path(sys.argv[1]).resolve())
    SOURCE = Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
