#!/usr/bin/python3
"""Tests of surveymc.plots.tool_codes on the smoke results SURVEYMC_MAP (tool_code_map), SURVEYMC_SWEEP (position_covariance) and
SURVEYMC_DESIGN (position_covariance, models and wells drawn together), and of maps that the program SURVEYMC makes."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

import plot_case
from surveymc.plots import tool_codes as plot
from surveymc import arguments
from surveymc.plots import reading

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402

MAP, SWEEP, DESIGN = (os.environ.get(f"SURVEYMC_{name}", "") for name in ("MAP", "SWEEP", "DESIGN"))
PROGRAM = os.environ.get("SURVEYMC", "")
MAPS = """experiment = "tool_code_map"
title = "Two tools"
codes = ["MWD+SRGM", "MWD+SRGM+AX"]
[field]
{}
[map]
inclination_deg = [30.0, 60.0]
azimuth_deg = {{ from = 0.0, to = 360.0, step = 45.0 }}
{}
"""
PLACE = """model = "wmm2025"
latitude_deg = 70.0
longitude_deg = -150.0
date = 2026-01-01"""


@unittest.skipUnless(PROGRAM, "SURVEYMC is not set")
class MagneticEastAndWest(plot_case.Drawing):
    """The dashed lines are where the program has them, whichever way it knows the declination."""
    script = "tool_codes"

    def maps_of(self, field, sweep=""):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        config, result = (os.path.join(folder.name, f"two.{ending}") for ending in ("toml", "h5"))
        with open(config, "w", encoding="utf-8") as file:
            file.write(MAPS.format(field, sweep))
        subprocess.run([PROGRAM, "run", config, "-o", result, "--quiet"], check=True, timeout=100)
        return result

    def lines(self, result, number=0):
        with h5py.File(result) as file:
            maps = plot.Maps(file, number)
        figure = plot.draw_maps(maps)
        return [float(line.get_xdata()[0]) for line in figure.axes[0].lines], figure.texts[0].get_text()

    def test_of_a_field_by_model(self):
        result = self.maps_of(PLACE)
        with reading.open_result(result, "tool_code_map") as file:
            declination = float(reading.read_table(file, "reference_field")["declination_deg"][0])
        self.assertGreater(declination, 10)
        np.testing.assert_allclose(self.lines(result)[0], [90 + declination, 270 + declination], rtol=1e-12)

    def test_of_each_point_of_a_sweep(self):
        result = self.maps_of("total_nT = 50000.0\ndip_deg = 72.0", '[sweep]\n"field.declination_deg" = [30.0, -40.0]')
        for number, declination in enumerate((30, -40)):
            lines, title = self.lines(result, number)
            self.assertEqual(lines, [90 + declination, 270 + declination])
            self.assertEqual(title.splitlines()[0], f"Two tools: declination {declination}\N{DEGREE SIGN}")
            self.assert_drawn([f"two_point{number}_{f}" for f in ("maps", "ratio")], result, "--point", str(number))
        self.assert_drawn([f"two_point0_{f}" for f in ("maps", "ratio")], result)
        self.refused(arguments.USAGE, "points 0 to 1", result, "--point", "2")


@unittest.skipUnless(MAP and SWEEP and DESIGN, "SURVEYMC_MAP, SURVEYMC_SWEEP or SURVEYMC_DESIGN is not set")
class Figures(plot_case.Drawing):
    script = "tool_codes"

    @staticmethod
    def words(figure):
        return " ".join(" ".join(t.get_text().split()) for t in figure.texts)

    def test_tools_of_equal_values_share_a_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "equal.h5")
            shutil.copy(SWEEP, path)
            with result_file(path, "a") as file:
                last = file["tables/covariance/md_m"][()] == np.max(file["tables/covariance/md_m"][()])
                for d, *_ in plot.DIRECTIONS:
                    values = file[f"tables/covariance/sd_{d}_m"][()]
                    values[last] = 3.0
                    file[f"tables/covariance/sd_{d}_m"][()] = values
            with reading.open_result(path, "position_covariance") as file:
                labels = [t.get_text() for t in plot.draw_bars(file, None, "sd").axes[0].get_yticklabels()]
        self.assertLess(len(labels), np.sum(last))
        self.assertEqual(sum(label.count(",") + 1 for label in labels), np.sum(last))

    def test_maps_are_blank_where_a_model_does_not_hold(self):
        with h5py.File(MAP) as file:
            maps = plot.Maps(file)
            inside, lateral = file["maps/inside_range"][()], file["maps/sd_lateral_m"][()]
        self.assertTrue((inside == 0).any())
        np.testing.assert_array_equal(np.isnan(maps.lateral), (inside == 0) | np.isnan(lateral))
        np.testing.assert_array_equal(maps.lateral[~np.isnan(maps.lateral)], lateral[~np.isnan(maps.lateral)])
        self.assertIn("grey: the model does not hold", self.words(plot.draw_maps(maps)))
        self.assertIn(f"grey: the model or {maps.models[0]} does not hold", self.words(plot.draw_ratio(maps, None)))

    def test_figures_are_written(self):
        stem = os.path.splitext(os.path.basename(MAP))[0]
        files = {*self.figures(MAP), *self.figures(SWEEP, "--order", "family")}
        for figure in (f"{stem}_maps", f"{stem}_ratio", os.path.splitext(os.path.basename(SWEEP))[0] + "_bars"):
            self.assertIn(f"{figure}.png", files)
            self.assertIn(f"{figure}.svg", files)

    def test_bars_say_where_there_is_no_covariance(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "none.h5")
            shutil.copy(SWEEP, path)
            with result_file(path, "a") as file:
                for d, *_ in plot.DIRECTIONS:
                    file[f"tables/covariance/sd_{d}_m"][-1] = np.nan
            with reading.open_result(path, "position_covariance") as file:
                texts = [t.get_text() for t in plot.draw_bars(file, None, "sd").axes[0].texts]
        self.assertEqual(texts.count("no covariance: a weight is not finite"), 1)

    def test_nothing_is_drawn_of_models_with_several_wells(self):
        done = plot_case.draw(self.script, DESIGN)
        self.assertEqual((done.returncode, done.stdout), (0, ""))
        self.assertIn("several error models at one well", done.stderr)

    def test_a_wrong_reference_is_told_in_a_line(self):
        self.refused(arguments.USAGE, "--reference nothing: must be one of MWD", MAP, "--reference", "nothing")


if __name__ == "__main__":
    unittest.main()
