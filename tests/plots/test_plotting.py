#!/usr/bin/python3
"""Tests of surveymc.plots and surveymc.plots.msa_position.

The drawing tests need a result of msa_position with realisations: its path in the environment variable
SURVEYMC_RESULT. Without it they are skipped.
"""

import argparse
import contextlib
import fractions
import io
import os
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import legible
import matplotlib
import matplotlib.pyplot as plt
import plot_case
from surveymc import arguments, streams
from surveymc.plots import drawing, geometry, reading, saving, wording

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402

SCRIPT = "msa_position"
RESULT = os.environ.get("SURVEYMC_RESULT", "")
EPSILON = np.finfo(float).eps


def covariance(major, minor, azimuth_deg):
    """The covariance (rounded to double) of an ellipse with these axes."""
    a = np.radians(azimuth_deg)
    axes = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return axes @ np.diag([major**2, minor**2]) @ axes.T


def quadratic_form(c, north, east):
    """x' C^-1 x in rational arithmetic: the points and the matrix are taken as they are, nothing is rounded."""
    nn, ne, ee, n, e = (fractions.Fraction(float(v)) for v in (c[0, 0], c[0, 1], c[1, 1], north, east))
    return float((n * n * ee - 2 * n * e * ne + e * e * nn) / (nn * ee - ne * ne))


class Names(unittest.TestCase):
    def test_other_points_have_other_files(self):
        self.assertEqual(wording.name_of(["smoother", 0.5]), "smoother_0.5")
        self.assertNotEqual(wording.name_of([-60.0]), wording.name_of([60.0]))
        self.assertEqual(wording.name_of(["a/b c"]), "a_b_c")


class Words(unittest.TestCase):
    def test_points_are_named_in_words_not_by_keys(self):
        for keys, point, words in ((("noise.scale", "case"), (0.1, "test 1"), "test 1, noise \N{MULTIPLICATION SIGN} 0.1"),
                                   (("mode",), ("mse_shared",), "many stations, references shared"),
                                   (("case",), ("msa_joint with priors",), "joint MSA with priors"),
                                   (("sensor.spread.axial_bias_nT",), (220.0,), "axial bias sd 220 nT"),
                                   (("sigma.axial_interference_nT",), (150.0,), "sd of axial interference 150 nT"), (("problem.name",), ("rp107",), "rp107"),
                                   (("field.dip_deg",), (70.0,), "dip 70\N{DEGREE SIGN}"), (("field.total_nT",), (5e4,), "total 50000 nT"),
                                   (("model.memory_vectors",), (150,), "memory vectors 150"), ((), (), "")):
            self.assertEqual(wording.point_name(keys, point), words)

    def test_counts_of_rows_that_differ_are_ranges(self):
        def table(trials, failed):
            return reading.Table("t", {"trials": np.array(trials), "failed": np.array(failed)})

        self.assertEqual(wording.counts_text([7168.0, 7168.0]), "7\N{NARROW NO-BREAK SPACE}168")
        self.assertEqual(wording.counts_text([7168.0, 21504.0, 8192.0]), "7\N{NARROW NO-BREAK SPACE}168 to 21\N{NARROW NO-BREAK SPACE}504")
        self.assertEqual(wording.trials_text(table([100.0, 100.0], [0.0, 0.0])), "100 trials")
        self.assertEqual(wording.trials_text(table([100.0, 100.0], [0.0, 3.0])), "97 to 100 of 100 trials (0 to 3 did not converge)")

    def test_settings_are_those_of_the_point(self):
        config = {"field": {"dip_deg": 70.0, "grid": {"zone": 6}}, "sweep": {"case": [
            {"name": "a", "field.dip_deg": 60.0}, {"name": "b", "field": {"dip_deg": 50.0}}, {"name": "c"}]}}
        for keys, point, dip in (([], [], 70.0), (["case"], ["a"], 60.0), (["case"], ["b"], 50.0), (["case"], ["c"], 70.0),
                                 (["case", "field.dip_deg"], ["c", 40.0], 40.0)):
            self.assertEqual(reading.setting_at(config, keys, point, "field.dip_deg"), dip)
        self.assertEqual(reading.setting_at(config, [], [], "field.grid"), {"zone": 6})
        self.assertEqual(reading.setting_at(config, [], [], "field.total_nT", 1), 1)


class Ellipse(unittest.TestCase):
    AZIMUTHS = (0, 1e-8, 30, 45, 89.999, 90, 117.76, 135, 165, 179.5)

    def test_points_satisfy_the_equation_of_the_ellipse(self):
        for azimuth in self.AZIMUTHS:
            for major, minor in ((1, 1), (3, 2), (8.6, 0.7), (100, 0.5), (129, 0.2)):
                c = covariance(major, minor, azimuth)
                c[1, 0] = c[0, 1]
                for k in (1, 2, 3):
                    north, east = geometry.ellipse_points(c, k, count=73)
                    # The points of the nearly degenerate ones: a rounding of the coordinate, eps/2 of the major axis,
                    # weighs major/minor in the minor direction; 16 roundings, twice since squared.
                    bound = max(1e-12, 16 * EPSILON * major / minor) * k * k
                    self.assertLessEqual(bound, 3e-12 * k * k)
                    for n, e in zip(north, east):
                        self.assertAlmostEqual(quadratic_form(c, n, e), k * k, delta=bound)

    def test_points_of_an_extremely_thin_ellipse(self):
        # Test 4 of the thesis: 0.2 % and thinner. The same bound without the floor.
        for azimuth in self.AZIMUTHS:
            for ratio in (2e-3, 1e-4, 1e-5):
                c = covariance(10, 10 * ratio, azimuth)
                c[1, 0] = c[0, 1]
                for n, e in zip(*geometry.ellipse_points(c, 1, count=37)):
                    self.assertAlmostEqual(quadratic_form(c, n, e), 1, delta=16 * EPSILON / ratio)

    def test_axes_are_the_eigenvectors(self):
        for azimuth in self.AZIMUTHS:
            for major, minor in ((3, 2), (100, 0.5), (129, 0)):
                c = covariance(major, minor, azimuth)
                values, vectors = np.linalg.eigh(c)
                a, b, found = geometry.ellipse_axes(c)
                self.assertAlmostEqual(a, np.sqrt(values[1]), delta=8 * EPSILON * major)
                self.assertAlmostEqual(b**2, max(values[0], 0), delta=8 * EPSILON * major**2)
                self.assertTrue(0 <= found < 180)
                axis = np.array([np.cos(np.radians(found)), np.sin(np.radians(found))])
                # Eigenvectors of eigh turn by eps times major^2 over the gap of the eigenvalues.
                gap = (major**2 - minor**2) / major**2
                self.assertAlmostEqual(abs(axis @ vectors[:, 1]), 1, delta=1e-14)
                self.assertAlmostEqual(axis @ vectors[:, 0], 0, delta=32 * EPSILON / gap)
                self.assertAlmostEqual(np.sin(np.radians(found - azimuth)), 0, delta=32 * EPSILON / gap)

    def test_azimuth_is_clockwise_from_north(self):
        self.assertAlmostEqual(geometry.ellipse_axes([[4, 0], [0, 1]])[2], 0)  # long north-south
        self.assertAlmostEqual(geometry.ellipse_axes([[1, 0], [0, 4]])[2], 90)  # long east-west
        self.assertAlmostEqual(geometry.ellipse_axes([[2, 1], [1, 2]])[2], 45)  # north-east: both grow together
        self.assertAlmostEqual(geometry.ellipse_axes([[2, -1], [-1, 2]])[2], 135)  # south-east

    def test_drawn_ellipse_is_longest_along_its_azimuth(self):
        c = covariance(8.63, 0.0207, 117.76)
        north, east = geometry.ellipse_points(c, 3, centre=(1216.0, 639.6), count=3601)
        north, east = north - 1216.0, east - 639.6
        far = np.argmax(np.hypot(north, east))
        self.assertAlmostEqual(np.hypot(north[far], east[far]), 3 * 8.63, delta=1e-11)
        self.assertAlmostEqual(np.degrees(np.arctan2(east[far], north[far])) % 180, 117.76, delta=1e-9)

    def test_a_singular_covariance_is_a_line(self):
        for azimuth in self.AZIMUTHS:
            for scale in (1.0, 1 - 1e-15):  # a determinant that rounding made negative, too
                c = covariance(121, 0, azimuth)
                c[0, 0] *= scale
                a, b, found = geometry.ellipse_axes(c)
                self.assertTrue(geometry.is_line(a, b), (azimuth, a, b))
                across = geometry.rotate_to_axes(*geometry.ellipse_points(c), azimuth)[1]
                self.assertLess(np.max(np.abs(across)), 1e-5)
        self.assertEqual(geometry.ellipse_axes(np.zeros((2, 2))), (0, 0, 0))

    def test_what_is_not_a_covariance(self):
        for c in ([[1, 2], [2, 1]], [[-1, 0], [0, 1]], [[1, 0], [0, np.nan]], [1, 2, 3]):
            with self.assertRaises(reading.PlotError):
                geometry.ellipse_axes(c)

    def test_rotation_to_the_axes(self):
        along, across = geometry.rotate_to_axes(0.0, 1.0, 90.0)  # east, seen when facing east: ahead
        self.assertAlmostEqual(along, 1)
        self.assertAlmostEqual(across, 0)
        self.assertAlmostEqual(geometry.rotate_to_axes(0.0, 1.0, 0.0)[1], 1)  # facing north: to the right

    def test_a_turned_map_is_not_mirrored(self):
        # north turned to the right: west is up, and the way from north over up to the other axes is that of the map
        np.testing.assert_allclose(geometry.map_turned(1.0, 0.0, 0.0), (1, 0), atol=EPSILON)
        np.testing.assert_allclose(geometry.map_turned(0.0, -1.0, 0.0), (0, 1), atol=EPSILON)
        for azimuth in (0.0, 37.0, 165.0, 300.0):
            (xn, yn), (xe, ye) = geometry.map_turned(1.0, 0.0, azimuth), geometry.map_turned(0.0, 1.0, azimuth)
            self.assertAlmostEqual(xe * yn - ye * xn, 1)  # as (east, north) on the map: a turn has determinant 1

    def test_coverage(self):
        for k, share in ((1, 0.39347), (2, 0.86466), (3, 0.98889)):
            self.assertAlmostEqual(geometry.ellipse_coverage(k), share, delta=5e-6)


class Numbers(unittest.TestCase):
    def test_significant_digits(self):
        for value, digits, text in ((129.15, 3, "129"), (0.0207, 3, "0.0207"), (147.3, 2, "150"), (0, 3, "0"),
                                    (-8.626, 3, "\N{MINUS SIGN}8.63"), (1.96e-7, 2, "2.0e\N{MINUS SIGN}07"),
                                    (float("nan"), 3, "\N{EN DASH}"), (9.996, 3, "10.0")):
            self.assertEqual(wording.number(value, digits), text)


def draw(*arguments):
    return plot_case.draw(SCRIPT, *arguments)


def draw_as_users_do(*arguments):
    """A program of its own; another seed of its hashes may change no figure."""
    return subprocess.run([sys.executable, plot_case.SCRIPTS / "surveymc", "plot", SCRIPT, *arguments], capture_output=True, text=True, timeout=plot_case.PATIENCE,
                          env={**os.environ, "PYTHONHASHSEED": "7"})


class Labels(unittest.TestCase):
    def test_axes_and_quantities_are_named_in_words(self):
        for name, words in (("survey.plan.inclination_deg", "inclination (\N{DEGREE SIGN})"), ("error_model.name", "error model"),
                            ("md_m", "measured depth (m)"), ("semi_major_m", "semi-major axis (m)"), ("sigma.noise_nT", "sd of noise (nT)")):
            self.assertEqual(wording.axis_name(name), words)
        self.assertEqual(wording.quantity_name("sigma3_gain_z"), f"3{wording.SIGMA} of gain z")
        self.assertEqual(wording.quantity_name("first_order"), "first order")

    def test_the_check_of_figures_finds_faults(self):
        figure, ax = plt.subplots()
        ax.text(0.5, 0.5, "one text")
        ax.text(0.5, 0.5, "another text")
        figure.text(0.97, 0.5, "cut off by the edge")
        ax.set_title("sigma.axial_interference_nT 0")
        said = " ".join(legible.faults(figure))
        plt.close(figure)
        for words in ("'one text' and 'another text' share", "'cut off by the edge' leaves the figure", "shows a key"):
            self.assertIn(words, said)

    def test_a_drawer_whose_figure_is_hard_to_read_fails(self):
        def two_texts(y):
            figure, ax = plt.subplots()
            ax.text(0.5, 0.5, "one text")
            ax.text(0.5, y, "another text")
            saving.save(figure, folder, "x")

        with tempfile.TemporaryDirectory() as folder:
            for y, code in ((0.5, plot_case.ILLEGIBLE), (0.2, 0)):
                done = plot_case.draw(lambda: two_texts(y))
                self.assertEqual(done.returncode, code, done.stderr)

    def test_texts_at_near_points_move_apart(self):
        figure, ax = plt.subplots()
        ax.plot([1, 1.01, 1.02], [1, 1, 1.001], "o")
        ax.set(xlim=(0, 2), ylim=(0, 2))
        for k, point in enumerate(((1, 1), (1.01, 1), (1.02, 1.001), (1.99, 1.99))):
            drawing.label_points(ax, f"a label of point {k}", point)
        self.assertTrue(legible.faults(figure))
        drawing.settle_labels(figure)
        self.assertEqual(legible.faults(figure), [])
        plt.close(figure)

    def test_contour_labels_leave_out_those_that_lie_on_others(self):
        figure, ax = plt.subplots()
        x = np.linspace(0, 1, 20)
        lines = ax.contour(x, x, np.add.outer(0 * x, np.exp(20 * x)), levels=np.geomspace(1.5, 1e8, 60))
        drawing.label_contours(ax, lines, lambda v: f"{v:.4g}")
        drawing.settle_labels(figure)
        texts = [t for t in ax.texts if t.get_visible()]
        boxes = [t.get_window_extent(figure.canvas.get_renderer()) for t in texts]
        self.assertTrue(0 < len(texts) < len(ax.texts))
        self.assertFalse(any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[k + 1:]))
        plt.close(figure)

    def test_logarithmic_axes_have_ticks_to_read(self):
        for low, high, words in ((0.85, 1.2, {"1", "0.9", "1.1"}), (3e-7, 5e-6, {"$10^{-6}$", r"$2\times10^{-6}$"}),
                                 (1e-12, 1, {"$10^{-10}$", "1"}), (0.01, 200, {"0.02", "100"})):
            figure, ax = plt.subplots()
            ax.set(xscale="log", xlim=(low, high))
            drawing.plain_log_axis(ax.xaxis, low, high)
            figure.draw_without_rendering()
            self.assertLessEqual(words, {t.get_text() for t in ax.get_xticklabels()}, (low, high))
            plt.close(figure)

    def test_a_large_sweep_is_drawn_in_part_and_says_so(self):
        arguments = argparse.Namespace(point=None, result="r.h5")
        points = [(k,) for k in range(300)]
        with contextlib.redirect_stderr(io.StringIO()) as said:
            self.assertEqual(reading.points_to_draw(arguments, points), [(k, (k,)) for k in range(6)])
        self.assertEqual(said.getvalue(), "r.h5: points 0 to 5 of 300 of the sweep are drawn; any other with --point I\n")
        self.assertEqual(wording.point_title("Run", ["seed"], points, 3), "Run: seed 3 (point 3 of 0 to 299)")
        arguments.point = 299
        self.assertEqual(reading.points_to_draw(arguments, points), [(299, (299,))])
        arguments.point = 300
        with self.assertRaises(reading.PlotError):
            reading.points_to_draw(arguments, points)


class Saving(unittest.TestCase):
    def drawn(self, figure):
        with tempfile.TemporaryDirectory() as folder:
            saving.save(figure, folder, "figure")
            with open(os.path.join(folder, "figure.svg"), encoding="utf-8") as file:
                return file.read()

    def test_titles_of_any_length_stay_in_the_figure(self):
        figure, panels = plt.subplots(1, 2, figsize=(6, 3))
        drawing.heading(figure, "A run of a long name " * 6, "What is drawn, and of how many trials it is. " * 3)
        for ax in panels:
            ax.set_title("a well of a long name " * 3, loc="left")
        self.drawn(figure)
        renderer = figure.canvas.get_renderer()
        for text in figure.texts:
            self.assertLessEqual(text.get_window_extent(renderer).x1, figure.bbox.width)
        first, second = (ax.get_window_extent(renderer) for ax in panels)
        self.assertLessEqual(panels[0]._left_title.get_window_extent(renderer).x1, second.x0)
        self.assertLessEqual(panels[1]._left_title.get_window_extent(renderer).x1, figure.bbox.width)

    def test_titles_that_fit_stay_as_they_are(self):
        figure, ax = plt.subplots()
        ax.set_title("north")
        figure.suptitle("A run")
        sizes = ax.title.get_fontsize(), figure._suptitle.get_fontsize()
        self.drawn(figure)
        self.assertEqual((ax.title.get_text(), figure._suptitle.get_text()), ("north", "A run"))
        self.assertEqual((ax.title.get_fontsize(), figure._suptitle.get_fontsize()), sizes)

    def test_clips_are_counted_not_named_by_addresses(self):
        kept, drawings = [], []
        for _ in range(3):  # a polar panel clips by a path; the earlier figures keep their addresses
            figure, ax = plt.subplots(subplot_kw={"projection": "polar"})
            ax.plot([0, 1], [0, 1])
            kept.append(figure)
            drawings.append(self.drawn(figure))
        self.assertEqual(len(set(drawings)), 1)
        clips = re.findall(r'<clipPath id="(\w+)"', drawings[0])
        self.assertTrue(clips)
        self.assertLessEqual(set(re.findall(r'clip-path="url\(#(\w+)\)', drawings[0])), set(clips))

    def test_a_figure_is_drawn_once_for_each_of_its_files(self):
        draws = []
        kind = matplotlib.figure.Figure
        self.addCleanup(setattr, kind, "draw", kind.draw)
        kind.draw = lambda figure, renderer, drawn=kind.draw: (draws.append(1), drawn(figure, renderer))
        figure, ax = plt.subplots(layout="constrained")
        ax.plot([0, 1], [0, 1])
        drawing.label_points(ax, "here", (0.5, 0.5))
        self.drawn(figure)
        self.assertEqual(len(draws), 2)

    def test_a_dollar_sign_of_the_user_begins_no_formula(self):
        words = "cost $x_{$ and 5"
        figure, ax = plt.subplots()
        ax.set_title(wording.plain_text(words))
        figure.suptitle(wording.point_name(("case",), (words,)))
        self.drawn(figure)
        ax.set_title(words)
        with self.assertRaises(ValueError):  # what it was before
            figure.savefig(io.BytesIO())


class BadInput(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def assert_refused(self, code, word, *arguments):
        run = draw(*arguments)
        self.assertEqual(run.returncode, code, run.stderr)
        self.assertNotIn("Traceback", run.stderr)
        self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
        self.assertIn(word, run.stderr)
        self.assertEqual(run.stdout, "")

    def write(self, name, config="", **attributes):
        with result_file(self.path(name)) as file:
            file.attrs.update({"format": "surveymc", "experiment": "msa_position", "config": config, **attributes})
        return self.path(name)

    def test_missing_file(self):
        self.assert_refused(reading.BAD_DATA, "no such file", self.path("none.h5"))

    def test_folder(self):
        self.assert_refused(reading.BAD_DATA, "folder", self.folder.name)

    def test_not_hdf5(self):
        with open(self.path("text.h5"), "w") as file:
            file.write("md_m,inclination_deg\n")
        self.assert_refused(reading.BAD_DATA, "not an HDF5 file", self.path("text.h5"))
        os.rename(self.path("text.h5"), self.path("text.toml"))
        self.assert_refused(reading.BAD_DATA, "not an HDF5 file, or damaged; a config has its result by: surveymc run", self.path("text.toml"))

    def test_hdf5_of_someone_else(self):
        self.assert_refused(reading.BAD_DATA, "not a result file", self.write("other.h5", format="netCDF"))

    def test_other_experiment(self):
        self.assert_refused(reading.BAD_DATA, "reliability_map", self.write("map.h5", experiment="reliability_map"))

    def test_no_tables(self):
        self.assert_refused(reading.BAD_DATA, "position", self.write("empty.h5"))

    def test_config_that_is_not_toml(self):
        self.assert_refused(reading.BAD_DATA, "TOML", self.write("toml.h5", config="= 3"))

    def test_table_without_its_columns(self):
        path = self.write("column.h5")
        with result_file(path, "a") as file:
            file["tables/position/quantity"] = ["sigma3_north"]
        self.assert_refused(reading.BAD_DATA, "no column", path)

    def test_columns_of_different_length(self):
        path = self.write("length.h5")
        with result_file(path, "a") as file:
            file["tables/position/quantity"] = ["sigma3_north"]
            file["tables/position/ratio"] = [1.0, 2.0]
        self.assert_refused(reading.BAD_DATA, "differ in length", path)


@unittest.skipUnless(RESULT, "SURVEYMC_RESULT is not set")
class Drawing(unittest.TestCase):
    def test_figures(self):
        with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
            content = []
            for start, folder in ((draw, first), (draw_as_users_do, os.path.join(second, "new"))):
                run = start(RESULT, "-o", folder, "--point", "0")
                self.assertEqual(run.returncode, 0, run.stderr)
                paths = run.stdout.split("\n")[:-1]
                self.assertEqual(sorted(paths), sorted(os.path.join(folder, f) for f in os.listdir(folder)))
                for figure in ("position", "parameters", "ratio"):
                    self.assertTrue(any(p.endswith(f"_{figure}.png") for p in paths), (figure, paths))
                content.append({})
                for path in paths:
                    with open(path, "rb") as file:
                        content[-1][os.path.basename(path)] = file.read()
            for name, data in content[0].items():
                magic = b"\x89PNG\r\n\x1a\n" if name.endswith(".png") else b"<?xml"
                self.assertTrue(data.startswith(magic), name)
                self.assertGreater(len(data), 10_000, name)
            self.assertEqual(content[0], content[1])  # no dates: the same bytes

    def test_point_that_is_not_there(self):
        run = draw(RESULT, "--point", "100000")
        self.assertEqual(run.returncode, arguments.USAGE)
        self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)

    def test_folder_that_cannot_be_made(self):
        run = draw(RESULT, "--point", "0", "-o", os.path.join(RESULT, "below_a_file"))
        self.assertEqual(run.returncode, streams.CANNOT_WRITE)
        self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)

    def test_ellipses_of_the_result(self):
        # Drawn from the covariance; the program's own semi axes and azimuths must be the same.
        with reading.open_result(RESULT, "msa_position") as file:
            ellipses = reading.read_table(file, "ellipse")
            covariances = reading.read_table(file, "position_covariance")
        self.assertEqual(ellipses["formulation"], covariances["formulation"])
        for i in range(ellipses.rows):
            nn, ne, ee = (covariances[k][i] for k in ("nn_m2", "ne_m2", "ee_m2"))
            a, b, azimuth = geometry.ellipse_axes([[nn, ne], [ne, ee]])
            self.assertAlmostEqual(a, ellipses["semi_major_m"][i], delta=1e-12 * a)
            # The program takes the minor axis from a general routine, good to 1e-15 of the major one squared.
            self.assertAlmostEqual(b**2, ellipses["semi_minor_m"][i] ** 2, delta=1e-14 * a**2)
            self.assertAlmostEqual(np.sin(np.radians(azimuth - ellipses["major_azimuth_deg"][i])), 0, delta=1e-12)


if __name__ == "__main__":
    unittest.main()
