#!/usr/bin/python3
"""Tests of surveymc.plots.corrected_codes: test_plot_corrected_codes.py RESULT.h5"""
import os
import shutil
import sys
import tempfile
import unittest

import numpy as np

import plot_case
from surveymc.plots import corrected_codes, reading

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402

RESULT = ""


class Figures(plot_case.Drawing):
    script = "corrected_codes"

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_maps_and_wells_as_png_and_svg(self):
        self.assert_drawn([f"corrected_codes_{n}" for n in ("class", "along", "budget")], RESULT)

    def test_a_panel_of_a_class_map_has_its_own_point(self):
        with reading.open_result(RESULT, "corrected_codes") as file:
            values, axes = corrected_codes.read_map(file, "class")
        _, panels = corrected_codes.panel_grid(values, axes, (3, 2))
        self.assertEqual(sorted(point for *_, point in panels), list(range(4)))
        for _, shown, point in panels:
            np.testing.assert_array_equal(shown, values[point])

    def test_nothing_determined_is_a_figure_too(self):
        path = os.path.join(self.folder, "none.h5")
        shutil.copy(RESULT, path)
        with result_file(path, "a") as file:
            file["maps/class"][...] = corrected_codes.UNDETERMINED
        run = plot_case.draw("corrected_codes", path, "-o", self.folder)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_every_input_is_in_one_group_of_the_budget(self):
        with reading.open_result(RESULT, "corrected_codes") as file:
            budget = reading.read_table(file, "budget")
        groups = [n for _, _, inputs in corrected_codes.BUDGET for n in inputs]
        self.assertEqual(sorted(groups), sorted(set(budget["input"])))

    def test_coast_lines_are_places(self):
        lines = corrected_codes.coast_lines()
        self.assertGreater(len(lines), 100)
        for longitude, latitude in lines:
            self.assertEqual(len(longitude), len(latitude))
            self.assertLessEqual(np.abs(longitude).max(), 180)
            self.assertLessEqual(np.abs(latitude).max(), 90)
        # Cape Agulhas, the south of Africa, is on one of them.
        self.assertLess(min(np.hypot(x - 20.0, y + 34.8).min() for x, y in lines), 0.5)


if __name__ == "__main__":
    RESULT = os.path.abspath(sys.argv.pop(1))
    unittest.main()
