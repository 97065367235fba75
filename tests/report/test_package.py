#!/usr/bin/python3
"""Tests of running and drawing with the Python package: test_package.py SURVEYMC SMOKE_FOLDER"""
import datetime
import gc
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import tomllib
import unittest

import numpy as np

SCRIPTS = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
CONFIGS = os.path.join(os.path.dirname(SCRIPTS), "configs", "smoke")
sys.path.insert(0, SCRIPTS)
import surveymc  # noqa: E402
from surveymc import program, toml  # noqa: E402

SMOKE = SURVEYMC = ""


def settings_of(name):
    with open(os.path.join(CONFIGS, name + ".toml"), "rb") as file:
        return tomllib.load(file)


class Missing(unittest.TestCase):
    def test_what_is_not_installed_is_said_with_a_way_out(self):
        done = subprocess.run([sys.executable, "-S", "-E", "-c", "import surveymc; surveymc.open(1)"], cwd=SCRIPTS, capture_output=True, text=True)  # without packages
        self.assertEqual(done.returncode, 1)
        last = done.stderr.splitlines()[-1]
        for words in ("ImportError: surveymc needs h5py, numpy", "pip install h5py numpy", "apt install python3-h5py"):
            self.assertIn(words, last)


class Toml(unittest.TestCase):
    def test_what_is_written_is_read_again(self):
        settings = {"a": 1, "b": -2.5e-9, "c": True, "text": "quote \" back \\ line\n tab\t bell\a \N{DEGREE SIGN}", "empty": [],
                    "nested": [[1.0, 2.0], ["x"]], "day": datetime.date(2025, 3, 1), "big": 2**62, "infinite": float("-inf"),
                    "table": {"inner": {"x": 1}, "noise.scale": [1.0, 0.1], "mixed": [1, {"y": 2}]},
                    "rows": [{"name": "one", "deep": {"z": 3}}, {"name": "two", "parts": [{"q": 1}, {"q": 2}]}]}
        self.assertEqual(tomllib.loads(toml.dumps(settings)), settings)

    def test_every_config_comes_back(self):
        folder = os.path.dirname(CONFIGS)
        for part in sorted(os.listdir(folder)):
            for name in sorted(os.listdir(os.path.join(folder, part))):
                if name.endswith(".toml"):
                    with open(os.path.join(folder, part, name), "rb") as file:
                        settings = tomllib.load(file)
                    self.assertEqual(tomllib.loads(toml.dumps(settings)), settings, name)

    def test_numpy_and_paths(self):
        self.assertEqual(toml.value(np.float32(0.5)), "0.5")
        self.assertEqual(toml.value(np.linspace(0, 1, 3)), "[0.0, 0.5, 1.0]")
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(toml.value(pathlib.Path(folder)), f'"{folder}"')
        with self.assertRaisesRegex(TypeError, "no TOML value"):
            toml.dumps({"a": object()})


class Running(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_a_file_and_its_content_give_the_same_result(self):
        path = os.path.join(CONFIGS, "msa_sweep.toml")
        of_file = surveymc.run(path, trials=40, threads=1)
        of_dict = surveymc.run(settings_of("msa_sweep"), trials=40, threads=2, folder=CONFIGS)
        self.assertEqual(of_file.content_hash, of_dict.content_hash)
        self.assertEqual(of_file.trials, 40)
        self.assertEqual([f for f in os.listdir(CONFIGS) if f.startswith(".surveymc-")], [])

    def test_keys_are_replaced_with_their_types(self):
        new = {"field.dip_deg": 71.5, "seed": 12, "title": 'A "new" title', "sensor.bias_nT": np.array([1.0, 2.0, 3.0]),
               "control_variate": False}
        result = surveymc.run(os.path.join(CONFIGS, "msa_position.toml"), set=new, trials=20, threads=1)
        self.assertEqual((result.settings["field"]["dip_deg"], result.seed, result.title), (71.5, 12, 'A "new" title'))
        self.assertEqual(result.settings["sensor"]["bias_nT"], [1.0, 2.0, 3.0])
        self.assertIs(result.settings["control_variate"], False)

    def test_output_is_kept_or_goes_with_the_result(self):
        output = os.path.join(self.folder, "kept.h5")
        self.assertEqual(surveymc.run(os.path.join(CONFIGS, "vertical_well.toml"), trials=50, output=output).path, output)
        self.assertTrue(os.path.exists(output))
        result = surveymc.run(os.path.join(CONFIGS, "vertical_well.toml"), trials=50)
        path = result.path
        self.assertTrue(os.path.exists(path))
        del result
        gc.collect()
        self.assertFalse(os.path.exists(path))

    def test_refusals_say_what_the_program_says(self):
        path = os.path.join(CONFIGS, "msa_position.toml")
        cases = ((lambda: surveymc.run(path, set={"field.dip_deg": 95}), 65, "must be in"),
                 (lambda: surveymc.run(path, set={"field.dipp_deg": 5}), 65, "field.dipp_deg"),
                 (lambda: surveymc.run(os.path.join(self.folder, "none.toml")), 65, "none.toml"),
                 (lambda: surveymc.run({"experiment": "msa_position"}, folder="/proc"), 74, "/proc: cannot write"),
                 (lambda: surveymc.sweep(os.path.join(self.folder, "none.toml"), {}, "position"), 65, "cannot be read"))
        for call, code, word in cases:
            with self.assertRaises(surveymc.RunError) as raised:
                call()
            self.assertEqual(raised.exception.exit_code, code, raised.exception)
            self.assertIn(word, str(raised.exception))
        with self.assertRaisesRegex(surveymc.RunError, r"(?m)^config: field.total_nT: missing"):
            surveymc.run({"experiment": "msa_position", "survey": {"file": "x.csv"}}, folder=self.folder)
        with self.assertRaises(surveymc.RunError) as raised:
            surveymc.run(path, set={"verdict.margin": 1e-6}, trials=200, check=True, threads=1)
        self.assertEqual(raised.exception.exit_code, 1)

    def test_all_mistakes_are_in_the_error(self):
        with self.assertRaises(surveymc.RunError) as raised:
            surveymc.run(os.path.join(CONFIGS, "msa_position.toml"), set={"field.dip_deg": 170.0, "field.gravity_mps": 3.0})
        self.assertIn("2 mistakes:\n", str(raised.exception))
        self.assertIn("field.dip_deg = 170: must be in [-90, 90]", str(raised.exception))
        self.assertIn("write field.gravity_mps2", str(raised.exception))

    def test_what_is_doubtful_is_a_warning(self):
        surveymc.result._told.clear()
        with self.assertWarns(surveymc.ResultWarning) as told:
            result = surveymc.run(os.path.join(CONFIGS, "msa_position.toml"), trials=20, set={"survey.azimuth_reference": "magnetic", "field.declination_deg": 0.0})
        self.assertIn("the declination is 0", str(told.warning))
        self.assertEqual(told.filename, __file__)
        self.assertEqual([r["message"] for r in result.warnings], ["azimuths are from magnetic north, and the declination is 0"])

    def test_sweep_is_one_table_with_its_axes(self):
        frame = surveymc.sweep(os.path.join(CONFIGS, "msa_position.toml"),
                               {"noise.scale": (0.5, 1.0), "estimator.name": ["msa", "msa_joint"]}, "position", trials=40)
        self.assertEqual(set(frame.attrs["sweep_keys"]), {"noise.scale", "estimator.name"})
        self.assertEqual(len(frame.groupby(["noise.scale", "estimator.name"])), 4)
        self.assertEqual([f for f in os.listdir(CONFIGS) if f.startswith(".surveymc-")], [])
        kept = surveymc.sweep(settings_of("msa_sweep"), {"noise.law": ["gaussian"]}, "position", trials=40, folder=CONFIGS)
        self.assertEqual(set(kept["case"]), {c["name"] for c in settings_of("msa_sweep")["sweep"]["case"]})  # axes that stay
        self.assertEqual(set(kept["noise.law"]), {"gaussian"})

    def test_every_failure_is_a_run_error(self):
        folder = pathlib.Path(self.folder)
        config = os.path.join(CONFIGS, "vertical_well.toml")
        os.mkfifo(folder / "pipe.toml")
        (folder / "latin.toml").write_bytes(b'title = "\xff"\n')
        (folder / "scalar.toml").write_text("sweep = 5\n")
        (folder / "noprogram").write_text("no program")
        (folder / "noprogram").chmod(0o755)
        deep = {}
        for _ in range(3000):
            deep = {"a": deep}
        bad = [lambda: surveymc.run({"x": object()}), lambda: surveymc.run({1: 2}), lambda: surveymc.run(config, set={"a": object()}),
               lambda: surveymc.run(config, seed="one"), lambda: surveymc.run(deep, folder=folder),
               lambda: surveymc.run("a\0b.toml"), lambda: surveymc.run(config, output="a\0b.h5"),
               lambda: surveymc.sweep(folder / "pipe.toml", {}, "x"), lambda: surveymc.sweep(folder / "latin.toml", {}, "x"),
               lambda: surveymc.sweep(folder / "scalar.toml", {"a": [1]}, "x"), lambda: surveymc.sweep(config, {"a": 1}, "x"),
               lambda: surveymc.sweep(folder, {}, "x"), lambda: surveymc.sweep(None, {}, "x"), lambda: surveymc.sweep(config, 5, "x"),
               lambda: surveymc.run(5), lambda: surveymc.run(config, set=5), lambda: surveymc.run(config, output=5), lambda: surveymc.run({}, folder=5),
               lambda: surveymc.run(config, set={"title": "x" * (1 << 18)})]
        for call in bad:
            with self.assertRaises(surveymc.RunError):
                call()
        self.assertEqual([p.name for p in folder.iterdir() if p.name.startswith(".surveymc-")], [])
        limit = resource.getrlimit(resource.RLIMIT_FSIZE)
        try:
            resource.setrlimit(resource.RLIMIT_FSIZE, (10, limit[1]))
            with self.assertRaises(surveymc.RunError) as raised:
                surveymc.run({"experiment": "msa_position"}, folder=folder)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        self.assertEqual(raised.exception.exit_code, 74)
        os.environ["SURVEYMC"] = str(folder / "noprogram")
        try:
            with self.assertRaises(surveymc.RunError):
                surveymc.run(config)
        finally:
            os.environ["SURVEYMC"] = SURVEYMC

    def test_the_program_is_found(self):
        self.assertEqual(program.find_program(), SURVEYMC)
        os.environ["SURVEYMC"] = os.path.join(self.folder, "none")
        try:
            with self.assertRaisesRegex(surveymc.RunError, "no such program"):
                surveymc.find_program()
        finally:
            os.environ["SURVEYMC"] = SURVEYMC


class Drawing(unittest.TestCase):
    def test_figures_of_a_result_are_files_and_show_in_a_notebook(self):
        result = surveymc.open(os.path.join(SMOKE, "vertical_well.h5"))
        with tempfile.TemporaryDirectory() as folder:
            figures = surveymc.plot(result, folder)
            self.assertTrue(figures and all(os.path.exists(f) and os.path.exists(f[:-3] + "svg") for f in figures))
        figures = surveymc.plot(result.path)
        self.assertEqual(figures._repr_html_().count("<img"), len(figures))
        path = figures[0]
        del figures
        self.assertFalse(os.path.exists(path))

    def test_a_map_over_four_keys_is_drawn(self):
        wide = surveymc.run({"experiment": "reliability_map", "mode": "sse", "observation": ["bx", "bz"],
                             "inclination_deg": list(range(5, 90, 6)), "toolface_deg": [0, 30, 60, 90], "magnetic_azimuth_deg": [0, 45, 90, 135]})
        self.assertTrue(surveymc.plot(wide))

    def test_what_is_not_there_says_so(self):
        with self.assertRaisesRegex(surveymc.ResultError, "no such file"):
            surveymc.plot("/nowhere/x.h5")

    def test_ellipse_is_drawn_as_a_map(self):
        import matplotlib
        matplotlib.use("Agg")
        axes = surveymc.Ellipse(10, 20, 2, 1, 90.0).plot(k=2, color="red")  # the major axis points east
        east, north = axes.lines[0].get_data()
        self.assertAlmostEqual(np.ptp(east), 8)
        self.assertAlmostEqual(np.ptp(north), 4)
        self.assertEqual(axes.get_aspect(), 1.0)


class Commands(unittest.TestCase):
    def test_the_importer_needs_no_other_package(self):
        done = subprocess.run([sys.executable, "-S", "-E", "-m", "surveymc.importer", "--help"], cwd=SCRIPTS, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_every_drawer_reads_through_the_package(self):
        for path in pathlib.Path(SCRIPTS, "surveymc").glob("*/*.py"):
            self.assertFalse("h5py.File(" in path.read_text(encoding="utf-8"), path)

    def test_one_command_draws_any_result(self):
        with tempfile.TemporaryDirectory() as folder:
            run = subprocess.run([sys.executable, os.path.join(SCRIPTS, "surveymc"), "plot", os.path.join(SMOKE, "msa_sweep.h5"),
                                  "-o", folder, "--point", "1"], capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertIn("msa_sweep_point1_position.svg", run.stdout)

    def test_figures_that_cannot_be_written(self):
        run = subprocess.run([sys.executable, os.path.join(SCRIPTS, "surveymc"), "plot", os.path.join(SMOKE, "msa_sweep.h5"), "-o", "/proc"],
                             capture_output=True, text=True)
        self.assertEqual(run.returncode, 74, run.stderr)
        self.assertRegex(run.stderr, "^surveymc plot: .*/proc/.*: cannot write: [^\n]*\n$")


if __name__ == "__main__":
    SMOKE = os.path.abspath(sys.argv.pop())
    SURVEYMC = os.environ["SURVEYMC"] = os.path.abspath(sys.argv.pop())
    unittest.main()
