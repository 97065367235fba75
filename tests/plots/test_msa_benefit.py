#!/usr/bin/python3
"""Tests of surveymc.plots.msa_benefit: test_msa_benefit.py RESULT.h5"""
import os
import shutil
import sys
import tempfile
import unittest

import numpy as np

import plot_case
from surveymc.plots import msa_benefit
from surveymc.plots import reading

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402

RESULT = ""


def draw(*arguments):
    return plot_case.draw("msa_benefit", *arguments)


class Figures(plot_case.Drawing):
    script = "msa_benefit"

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def changed(self, change):
        path = os.path.join(self.folder, "changed.h5")
        shutil.copy(RESULT, path)
        with result_file(path, "a") as file:
            change(file)
        return path

    def test_both_ratios_as_png_and_svg(self):
        self.assert_drawn([f"msa_benefit_{q}_ratio" for q in ("azimuth", "lateral")], RESULT)

    def test_panels_are_the_points_of_the_sweep(self):
        with reading.open_result(RESULT, "msa_benefit") as file:
            values, axes = msa_benefit.read_map(file, "azimuth_ratio")
        self.assertEqual([a[0] for a in axes], ["case", "inclination", "azimuth"])
        panels = sum(msa_benefit.panels_of(values, axes), [])
        self.assertEqual([name for name, _ in panels], list(axes[0][1]))
        for (_, shown), expected in zip(panels, values):
            np.testing.assert_array_equal(shown, expected)

    def test_nothing_determined_is_a_figure_too(self):
        def all_infinite(file):
            for name in ("azimuth_ratio", "lateral_ratio"):
                file["maps"][name][...] = np.inf

        run = draw(self.changed(all_infinite), "-o", self.folder)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_refusals(self):
        def no_map(file):
            del file["maps/azimuth_ratio"]

        def other(file):
            file.attrs["experiment"] = "msa_position"

        for change, word in ((no_map, "no map"), (other, "msa_position")):
            run = draw(self.changed(change))
            self.assertEqual(run.returncode, reading.BAD_DATA)
            self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
            self.assertIn(word, run.stderr)


if __name__ == "__main__":
    RESULT = os.path.abspath(sys.argv.pop(1))
    unittest.main()
