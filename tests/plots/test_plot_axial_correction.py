#!/usr/bin/python3
"""Figures of surveymc.plots.axial_correction from the smoke run: SURVEYMC_RESULT names its file."""
import os
import unittest

import numpy as np

import plot_case
from surveymc.plots import axial_correction as plot
from surveymc.plots import reading

RESULT = os.environ["SURVEYMC_RESULT"]


class AxialCorrection(plot_case.Drawing):
    script = "axial_correction"

    def test_figures(self):
        for point in (0, 1):
            names = [f"axial_correction_point{point}_{n}.{e}" for n in ("curves", "maps") for e in ("png", "svg")]
            self.assertEqual(sorted(self.figures(RESULT, "--point", str(point))), names)

    def test_points_of_monte_carlo_are_promised_only_where_they_are(self):
        with reading.open_result(RESULT, "axial_correction") as file:
            methods, inclination, azimuth, error, sd, table, _, _ = plot.read(file, 0)
        self.assertNotIn(35.0, azimuth)  # the only azimuth that was drawn: not one of the maps
        near = int(np.argmin(np.abs(azimuth - 35)))
        for moved in (False, True):
            if moved:
                azimuth[near] = 35.0
            figure = plot.curves_figure("t", methods, inclination, azimuth, error, sd, table, False)
            said = " ".join(t.get_text() for t in [*figure.texts, *figure.legends[0].get_texts()])
            self.assertEqual("Monte Carlo" in said, moved)

    def test_bad_requests(self):
        self.refused(64, "--point", RESULT, "--point", "7")
        self.refused(65, "no such file", RESULT + "x")


if __name__ == "__main__":
    unittest.main()
