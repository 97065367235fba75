#!/usr/bin/python3
"""Tests of scripts/plot_tool_codes.py on the smoke results SURVEYMC_MAP (tool_code_map) and SURVEYMC_SWEEP (position_covariance)."""
import os
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
sys.path.insert(0, SCRIPTS)
import plot_tool_codes as plot  # noqa: E402
import plotting  # noqa: E402

SCRIPT = os.path.join(SCRIPTS, "plot_tool_codes.py")
MAP, SWEEP = os.environ.get("SURVEYMC_MAP", ""), os.environ.get("SURVEYMC_SWEEP", "")


def draw(*arguments):
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, timeout=120)


@unittest.skipUnless(MAP and SWEEP, "SURVEYMC_MAP or SURVEYMC_SWEEP is not set")
class Figures(unittest.TestCase):
    def test_maps_are_blank_where_a_model_does_not_hold(self):
        with h5py.File(MAP) as file:
            maps = plot.Maps(file)
            inside, lateral = file["maps/inside_range"][()], file["maps/sd_lateral_m"][()]
        self.assertTrue((inside == 0).any())
        np.testing.assert_array_equal(np.isnan(maps.lateral), (inside == 0) | np.isnan(lateral))
        np.testing.assert_array_equal(maps.lateral[~np.isnan(maps.lateral)], lateral[~np.isnan(maps.lateral)])

    def test_figures_are_written(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(draw(MAP, "-o", folder).returncode, 0)
            self.assertEqual(draw(SWEEP, "-o", folder, "--order", "family").returncode, 0)
            files = sorted(os.listdir(folder))
        stem = os.path.splitext(os.path.basename(MAP))[0]
        for figure in (f"{stem}_maps", f"{stem}_ratio", os.path.splitext(os.path.basename(SWEEP))[0] + "_bars"):
            self.assertIn(f"{figure}.png", files)
            self.assertIn(f"{figure}.svg", files)

    def test_a_wrong_reference_is_told_in_a_line(self):
        done = draw(MAP, "--reference", "nothing")
        self.assertEqual(done.returncode, plotting.USAGE)
        self.assertRegex(done.stderr, "--reference nothing: must be one of MWD")


if __name__ == "__main__":
    unittest.main()
