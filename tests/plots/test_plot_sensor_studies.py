#!/usr/bin/python3
"""Tests of the drawer vertical_well and the drawer sensor_monte_carlo on the smoke results, whose folder is in the environment
variable SURVEYMC_SMOKE_RESULTS. Without it they are skipped."""
import os
import sys
import tempfile
import unittest

import plot_case
from surveymc.plots import sensor_monte_carlo
from surveymc.plots import vertical_well
from surveymc import arguments
from surveymc.plots import reading, wording

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402

FOLDER = os.environ.get("SURVEYMC_SMOKE_RESULTS", "")
STUDIES = {"vertical_well": ("ellipses", "ratio"), "sensor_monte_carlo": ("ellipses", "axes")}


def draw(study, *arguments):
    return plot_case.draw(study, *arguments)


@unittest.skipUnless(FOLDER, "SURVEYMC_SMOKE_RESULTS is not set")
class Drawing(unittest.TestCase):
    def test_figures_of_a_sweep_point_and_of_all(self):
        for study, figures in STUDIES.items():
            with self.subTest(study=study), tempfile.TemporaryDirectory() as folder:
                run = draw(study, os.path.join(FOLDER, f"{study}.h5"), "-o", folder, "--point", "1")
                self.assertEqual(run.returncode, 0, run.stderr)
                names = sorted(os.listdir(folder))
                self.assertEqual(sorted(run.stdout.split()), [os.path.join(folder, n) for n in names])
                for figure in figures:
                    self.assertTrue(any(n.endswith(f"{figure}.png") for n in names), (figure, names))
                    self.assertTrue(any(n.endswith(f"{figure}.svg") for n in names), (figure, names))
                for name in names:
                    self.assertGreater(os.path.getsize(os.path.join(folder, name)), 10_000, name)

    def test_without_a_point_a_sweep_still_has_its_overview(self):
        for study, figures in STUDIES.items():
            with self.subTest(study=study), tempfile.TemporaryDirectory() as folder:
                run = draw(study, os.path.join(FOLDER, f"{study}.h5"), "-o", folder)
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertIn("--point", run.stderr)
                self.assertEqual(sorted(os.listdir(folder)), [f"{study}_{figures[1]}.png", f"{study}_{figures[1]}.svg"])

    def test_points_that_ran_different_numbers_of_trials(self):
        for study, table, draw_all in (("vertical_well", "ellipse", lambda t, keys: vertical_well.ratio_figure(
                                            "t", t, keys, reading.sweep_points(t, keys))),
                                       ("sensor_monte_carlo", "axes", lambda t, keys: sensor_monte_carlo.axes_figure(
                                           "t", t, keys, 0.03))):
            with reading.open_result(os.path.join(FOLDER, f"{study}.h5"), study) as file:
                t, config = reading.read_table(file, table), reading.configuration(file)
            t["trials"][-1] = 21504
            said = " ".join(x.get_text().replace("\n", " ") for x in draw_all(t, reading.sweep_keys(config, t)).texts)
            self.assertIn(f"{wording.grouped(int(t['trials'][0]))} to {wording.grouped(21504)} runs a", said)

    def test_a_point_that_is_not_there(self):
        for study in STUDIES:
            run = draw(study, os.path.join(FOLDER, f"{study}.h5"), "--point", "99")
            self.assertEqual(run.returncode, arguments.USAGE)
            self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)

    def test_a_result_of_another_experiment(self):
        for study, other in zip(STUDIES, reversed(STUDIES)):
            run = draw(study, os.path.join(FOLDER, f"{other}.h5"))
            self.assertEqual(run.returncode, reading.BAD_DATA)
            self.assertIn(other, run.stderr)


class BadInput(unittest.TestCase):
    def test_tables_that_are_missing(self):
        for study in STUDIES:
            with self.subTest(study=study), tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "empty.h5")
                with result_file(path) as file:
                    file.attrs.update({"format": "surveymc", "experiment": study, "config": ""})
                run = draw(study, path)
                self.assertEqual(run.returncode, reading.BAD_DATA, run.stderr)
                self.assertNotIn("Traceback", run.stderr)
                self.assertIn("missing or empty", run.stderr)


if __name__ == "__main__":
    unittest.main()
