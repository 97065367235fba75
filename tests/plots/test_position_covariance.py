#!/usr/bin/python3
"""Tests of surveymc.plots.position_covariance: what it draws is the covariance of the file.

Needs a result of position_covariance without a sweep (SURVEYMC_RESULT) and one with (SURVEYMC_SWEEP_RESULT).
"""
import os
import unittest

import numpy as np
from matplotlib.patches import Polygon

import plot_case
from surveymc.plots import position_covariance as plot
from surveymc import arguments
from surveymc.plots import geometry, reading

RESULT = os.environ.get("SURVEYMC_RESULT", "")
SWEEP = os.environ.get("SURVEYMC_SWEEP_RESULT", "")


def tables(path, *names):
    with reading.open_result(path, "position_covariance") as file:
        return [reading.read_table(file, n) for n in names]


@unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
class Data(unittest.TestCase):
    def test_drawn_ellipses_are_those_of_the_covariance(self):
        covariance, ellipsoid = tables(RESULT, "covariance", "ellipsoid")
        (_, east, north, plan), (_, along, tvd, section) = plot.views(covariance, ellipsoid)[0]
        azimuth = np.radians(plot.views(covariance, ellipsoid)[1])
        n, e = ellipsoid["north_m"], ellipsoid["east_m"]
        np.testing.assert_array_equal(east, e)
        np.testing.assert_array_equal(north, n)
        np.testing.assert_allclose(along, n * np.cos(azimuth) + e * np.sin(azimuth), rtol=1e-13)
        for k in range(1, covariance.rows, 25):
            nn, ee, vv, ne, nv, ev = (covariance[f"{c}_m2"][k] for c in ("nn", "ee", "vv", "ne", "nv", "ev"))
            # Every drawn point is at Mahalanobis distance 1 of the covariance in the plane that is shown.
            for matrix, expected in (
                    (plan[k], [[ee, ne], [ne, nn]]),
                    (section[k], [[np.cos(azimuth)**2 * nn + 2 * np.sin(azimuth) * np.cos(azimuth) * ne
                                   + np.sin(azimuth)**2 * ee, np.cos(azimuth) * nv + np.sin(azimuth) * ev],
                                  [np.cos(azimuth) * nv + np.sin(azimuth) * ev, vv]])):
                np.testing.assert_allclose(matrix, expected, rtol=1e-12, atol=1e-13 * np.trace(matrix))
                points = np.array(geometry.ellipse_points(matrix, 1.0, count=37))
                distance = np.einsum("ik,ij,jk->k", points, np.linalg.inv(expected), points)
                np.testing.assert_allclose(distance, 1, rtol=1e-9)

    def test_ellipses_of_the_table_are_eigenvectors(self):
        covariance, ellipsoid = tables(RESULT, "covariance", "ellipsoid")
        matrices = geometry.covariances(covariance)
        for k in range(1, covariance.rows, 10):
            c = matrices[k]
            scale = np.trace(c)
            a = np.radians(covariance["major_azimuth_deg"][k])
            for axis, sd in (((np.cos(a), np.sin(a)), covariance["semi_major_m"][k]),
                             ((-np.sin(a), np.cos(a)), covariance["semi_minor_m"][k])):
                np.testing.assert_allclose(c[:2, :2] @ axis, sd**2 * np.array(axis), atol=1e-12 * scale)
            for i in (1, 2, 3):
                sd, azimuth, inclination = (ellipsoid[f"axis{i}{s}"][k] for s in ("_m", "_azimuth_deg",
                                                                                 "_inclination_deg"))
                azimuth, inclination = np.radians(azimuth), np.radians(inclination)
                axis = np.array([np.sin(inclination) * np.cos(azimuth), np.sin(inclination) * np.sin(azimuth),
                                 np.cos(inclination)])
                np.testing.assert_allclose(c @ axis, sd**2 * axis, atol=1e-12 * scale)

    def test_stations_without_a_covariance_are_left_out(self):
        covariance, ellipsoid, by_source, terms = tables(RESULT, "covariance", "ellipsoid", "covariance_by_source", "error_terms")
        rows = covariance.rows
        lost = rows - 10
        covariance["sd_lateral_m"][lost:] = 0  # a sd of nothing is no sd
        for c in geometry.COVARIANCE:
            covariance[c][lost:] = np.nan
            by_source[c][np.isin(by_source["md_m"], covariance["md_m"][lost:])] = np.nan
        said = f"At 10 of {rows} stations there is no covariance: a weight is not finite."
        views = plot.views_figure("t", covariance, ellipsoid, terms, 2.0, None)
        ellipses = [p for p in views.axes[0].patches if isinstance(p, Polygon)]
        self.assertEqual(len(ellipses), len(plot.chosen_stations(covariance["md_m"][:lost])))
        along = plot.along_figure("t", covariance, ellipsoid, terms)
        for ax in along.axes[:2]:
            for line in ax.lines[:3]:
                self.assertEqual(np.flatnonzero(np.isnan(line.get_ydata())).tolist(), list(range(lost, rows)))
        sources = plot.sources_figure("t", covariance, by_source, terms)
        self.assertEqual(sources.axes[0].get_xlim(), (covariance["md_m"][0], covariance["md_m"][lost - 1]))
        for figure in (views, along, sources):
            self.assertTrue(any(said in " ".join(t.get_text().split()) for t in figure.texts))
        covariance["nn_m2"][1:] = np.nan  # none but the tie-on
        self.assertIsNone(plot.sources_figure("t", covariance, by_source, terms))
        self.assertEqual(len(plot.views_figure("t", covariance, ellipsoid, terms, 2.0, None).axes[0].patches), 0)

    def test_stacked_sources_add_up_to_the_variance(self):
        covariance, by_source, terms = tables(RESULT, "covariance", "covariance_by_source", "error_terms")
        for columns in (("nn_m2", "ee_m2"), ("vv_m2",)):
            md, variances = plot.source_variances(by_source, columns, plot.families(terms))
            np.testing.assert_array_equal(md, covariance["md_m"])
            chosen, rest, others = plot.largest_sources(variances, plot.LARGEST_SOURCES)
            self.assertEqual(len(chosen), plot.LARGEST_SOURCES)
            self.assertGreater(others, 0)
            np.testing.assert_allclose(sum(variances[s] for s in chosen) + rest,
                                       sum(covariance[c] for c in columns), rtol=1e-12)
        self.assertEqual(plot.families(terms)["DECR"], "DEC* (5 terms)")
        self.assertEqual(plot.families(terms)["MBZ"], "MBZ")

    def test_ellipses_are_at_stations_along_the_whole_well(self):
        md = np.array([0.0, 10, 20, 500, 1000, 3000])
        self.assertEqual(plot.chosen_stations(md), [2, 3, 4, 5])
        self.assertEqual(plot.chosen_stations(md[:2]), [1])
        many = plot.chosen_stations(np.arange(1000.0))
        self.assertEqual((many[-1], len(many)), (999, 12))

    def test_magnification_keeps_ellipses_small(self):
        for extent, largest, factor in ((1000, 100, 1), (1000, 40, 2), (1000, 0.7, 100), (1000, 0, 1)):
            self.assertEqual(plot.nice_magnification(extent, largest), factor)


@unittest.skipUnless(RESULT and SWEEP, "SURVEYMC_RESULT or SURVEYMC_SWEEP_RESULT is not set")
class Drawing(plot_case.Drawing):
    script = "position_covariance"

    def test_figures(self):
        stem = os.path.splitext(os.path.basename(RESULT))[0]
        self.assert_drawn([f"{stem}_{f}" for f in ("along", "sources", "views")], RESULT)

    def test_sweep(self):
        stem = os.path.splitext(os.path.basename(SWEEP))[0]
        self.assert_drawn([f"{stem}_compare"], SWEEP)
        self.assertIn(f"{stem}_point2_views.png", self.figures(SWEEP, "--point", "2", "--sigma", "1", "--magnify", "10"))

    def test_bad_arguments(self):
        for option, value in (("--point", "99"), ("--sigma", "0"), ("--magnify", "x")):
            self.refused(arguments.USAGE, option, SWEEP, option, value)
        self.refused(reading.BAD_DATA, "no such file", "none.h5")


if __name__ == "__main__":
    unittest.main()
