#!/usr/bin/python3
"""Tests of scripts/plot_tool_codes.py on the smoke results SURVEYMC_MAP (tool_code_map), SURVEYMC_SWEEP (position_covariance) and
SURVEYMC_DESIGN (position_covariance, models and wells drawn together)."""
import os
import unittest

import h5py
import numpy as np

import drawing
import plot_tool_codes as plot
import plotting

MAP, SWEEP, DESIGN = (os.environ.get(f"SURVEYMC_{name}", "") for name in ("MAP", "SWEEP", "DESIGN"))


@unittest.skipUnless(MAP and SWEEP and DESIGN, "SURVEYMC_MAP, SURVEYMC_SWEEP or SURVEYMC_DESIGN is not set")
class Figures(drawing.Drawing):
    script = "plot_tool_codes.py"

    def test_maps_are_blank_where_a_model_does_not_hold(self):
        with h5py.File(MAP) as file:
            maps = plot.Maps(file)
            inside, lateral = file["maps/inside_range"][()], file["maps/sd_lateral_m"][()]
        self.assertTrue((inside == 0).any())
        np.testing.assert_array_equal(np.isnan(maps.lateral), (inside == 0) | np.isnan(lateral))
        np.testing.assert_array_equal(maps.lateral[~np.isnan(maps.lateral)], lateral[~np.isnan(maps.lateral)])

    def test_figures_are_written(self):
        stem = os.path.splitext(os.path.basename(MAP))[0]
        files = {*self.figures(MAP), *self.figures(SWEEP, "--order", "family")}
        for figure in (f"{stem}_maps", f"{stem}_ratio", os.path.splitext(os.path.basename(SWEEP))[0] + "_bars"):
            self.assertIn(f"{figure}.png", files)
            self.assertIn(f"{figure}.svg", files)

    def test_nothing_is_drawn_of_models_with_several_wells(self):
        done = drawing.draw(self.script, DESIGN)
        self.assertEqual((done.returncode, done.stdout), (0, ""))
        self.assertIn("several models and one well", done.stderr)

    def test_a_wrong_reference_is_told_in_a_line(self):
        self.refused(plotting.USAGE, "--reference nothing: must be one of MWD", MAP, "--reference", "nothing")


if __name__ == "__main__":
    unittest.main()
