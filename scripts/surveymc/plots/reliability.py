"""Figures of a reliability map: minimal detectable error beside its effect, PNG and SVG next to the result.

    surveymc plot reliability RESULT.h5 [-o FOLDER] [--observation NAME] [--effect azimuth|inclination|toolface]

Two axes with more than one value: filled contours with labelled levels, one row of panels for each value of what varies
besides; hatched where the error is never detected (infinite), a dashed line where the effect passes the tolerance. One
such axis: curves, their breaking points marked (where the effect passes the tolerance). Where a figure has no room for all,
they are numbered: `_azimuth_1`, `_azimuth_2` ...

More figures where the result has their maps: `_residuals`, curves of the residuals that a gross error causes with its
effect on the inclination (figure 1 of the paper); `_nonlinear`, detectable errors without linearisation beside the
linear one; `_direction`, entries of the weakest combination.
"""
import itertools
import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from ..arguments import USAGE
from . import drawing, reading, saving, wording
from .reliability_figures import (COLOURS, LINES, NAMES, Grid, axis_title, colour_bar, direction_figure, levels_of, named, nonlinear_figure, panel,
                                 residuals_figure, subject_name, unit_of, unit_of_residual)

ROWS = 6  # of panels in a figure, or curves
MOST_ROWS = 24  # of a map; one that has more is drawn in part


def maps_figure(title, detectable, effect, names, rows, observation_of, effect_name, tolerance):
    figure, grid = plt.subplots(len(rows), 2, figsize=(9.6, 3.5 * len(rows) + 0.7), squeeze=False,
                                layout="constrained")
    x, y = (np.asarray(detectable.axes[n], float) for n in (names[1], names[0]))
    for row, (words, chosen) in zip(grid, rows):
        observation = observation_of(chosen)
        suffix = f"\n{words}" if words else ""
        unit = unit_of(detectable, observation)
        for axes, sizes, title_of, unit_shown, line in (
                (row[0], np.abs(detectable.slice(chosen)), f"minimal detectable error of {subject_name(observation)}", unit, None),
                (row[1], np.abs(effect.slice(chosen)), f"its effect on the {effect_name}", "°", tolerance)):
            levels = levels_of(sizes)
            filled = panel(axes, x, y, sizes, names, f"{title_of} ({unit_shown}){suffix}", line, levels)
            colour_bar(figure, filled, axes, levels, unit_shown)
    drawing.heading(figure, title, "Hatched: infinite (never detected, or the angle has no value)"
                    + ("." if tolerance is None else f"; dashed: tolerance {tolerance:g}°."))
    return figure


def curves_figure(title, detectable, effect, name, rows, observation_of, effect_name, tolerance):
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.8, 4.1), layout="constrained")
    x = np.asarray(detectable.axes[name], float)
    units = set()
    for k, (words, chosen) in enumerate(rows):
        observation = observation_of(chosen)
        units.add(unit_of(detectable, observation))
        look = {"color": COLOURS[k % 6], "linestyle": LINES[k % 6], "label": words or subject_name(observation)}
        for axes, grid in ((left, detectable), (right, effect)):
            values = np.abs(grid.slice(chosen)).ravel()
            axes.plot(x, np.where(np.isfinite(values), values, np.nan), **look)
        values = np.abs(effect.slice(chosen)).ravel()
        for i in range(1, len(x)):
            if tolerance is not None and np.all(np.isfinite(values[i - 1:i + 1])) and \
                    (values[i - 1] <= tolerance) != (values[i] <= tolerance):
                at = x[i - 1] + (x[i] - x[i - 1]) * (tolerance - values[i - 1]) / (values[i] - values[i - 1])
                right.plot(at, tolerance, "o", color=look["color"], markersize=5, zorder=4)
                right.annotate(f"{wording.number(at, 4)}°", (at, tolerance), xytext=(-4, 5 + 11 * (k % 2)), ha="right",
                               textcoords="offset points", fontsize=7.5, color=look["color"],
                               path_effects=[matplotlib.patheffects.withStroke(linewidth=2.5, foreground="white")])
    left.set_ylabel(f"minimal detectable error ({', '.join(sorted(units))})")
    right.set_ylabel(f"effect on the {effect_name} (°)")
    for axes, grid in ((left, detectable), (right, effect)):
        shown = np.concatenate([np.abs(grid.slice(chosen)).ravel() for _, chosen in rows])
        shown = shown[np.isfinite(shown) & (shown > 0)]
        if shown.size and shown.max() > 30 * np.median(shown):  # a pole: show what lies below
            axes.set_ylim(0, 8 * np.median(shown))
        else:
            axes.set_ylim(bottom=0)
        axes.set_xlim(min(x), max(x))
        axes.set_xlabel(axis_title(name))
    if tolerance is not None:
        right.axhline(tolerance, color="#777777", linewidth=0.8)
        right.set_ylim(0, max(5 * tolerance, 1e-12))
    left.legend(fontsize=8)
    drawing.heading(figure, title, "" if tolerance is None else f"Points: where the effect passes the tolerance of {tolerance:g}°.")
    return figure


def main():
    parser = saving.argument_parser(__doc__.splitlines()[0])
    parser.add_argument("--observation", help="of a map of several, only this one")
    parser.add_argument("--effect", choices=["azimuth", "inclination", "toolface"],
                        help="default: inclination for accelerometers and gravity, azimuth otherwise")
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, "reliability_map") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        detectable = Grid(file, "minimal_detectable_error")
        configured = config.get("observation") or reading.read_table(file, "summary")["observation"][0]
        first = arguments.observation or (configured if isinstance(configured, str) else configured[0])
        effect_name = arguments.effect or ("inclination" if first[0] == "g" else "azimuth")
        effect = Grid(file, f"external_{effect_name}_deg")
        response = f"maps/effect_{effect_name}_deg" in file and Grid(file, f"effect_{effect_name}_deg")
        residuals = {unit: [Grid(file, n) for n in file["maps"] if n.startswith("residual_") and n.endswith(f"_{unit}")]
                     for unit in ("mps2", "nT", "deg")}
        directions = [Grid(file, n) for n in file["maps"] if n.startswith("direction_")]
        nonlinear = [Grid(file, n) for n in ("nonlinear_detectable_error_plus", "nonlinear_detectable_error_minus",
                                              "nonlinear_own_test_plus", "nonlinear_own_test_minus")
                     if f"maps/{n}" in file]
        differs = Grid(file, "linear_differs") if "maps/linear_differs" in file else None
    tolerance = config.get("tolerance", {}).get(f"{effect_name}_deg")

    observations = detectable.axes.get("observation")
    known = observations or ([configured] if isinstance(configured, str) else configured)
    if arguments.observation and arguments.observation not in known:
        raise reading.PlotError(f"--observation {arguments.observation}: not in {arguments.result}", USAGE)
    wide = [n for n in ("noise_scale", "dip", "inclination", "toolface", "magnetic_azimuth")
            if len(detectable.axes.get(n, [0])) > 1]
    plane = wide[-2:] if len(wide) > 1 and len(detectable.axes[wide[-2]]) > 3 else wide[-1:]
    if not plane:
        raise reading.PlotError(f"{arguments.result}: a single point: nothing to draw")
    others = [n for n in detectable.axes if n not in plane]
    if np.prod([len(detectable.axes[n]) for n in others]) > MOST_ROWS:  # over the longest axes; of the others the middle, of observations all
        plane = sorted(sorted(wide, key=lambda n: -len(detectable.axes[n]))[:2], key=wide.index)
        others = [n for n in detectable.axes if n not in plane]
        print(f"{arguments.result}: drawn over {' and '.join(axis_title(n).split(' (')[0] for n in plane)}, each other axis at its middle value",
              file=sys.stderr)
        choices = [range(len(detectable.axes[n])) if n == "observation" else reading.spread(range(len(detectable.axes[n])), 1) for n in others]
    else:
        choices = [range(len(detectable.axes[n])) for n in others]
    if observations and arguments.observation:
        choices[others.index("observation")] = [observations.index(arguments.observation)]
    rows = []
    for picked in itertools.product(*choices):
        words = [named(n, detectable.axes[n][i])
                 for n, i in zip(others, picked) if len(detectable.axes[n]) > 1 and n != "observation"]
        if observations and len(observations) > 1 and len(plane) == 1:
            words.insert(0, NAMES[observations[picked[others.index("observation")]]])
        rows.append((", ".join(words), dict(zip(others, picked))))

    def observation_of(chosen):
        return observations[chosen["observation"]] if observations else known[0]

    kinds = {}  # curves of one unit have an axis
    for row in rows:
        kinds.setdefault(unit_of(detectable, observation_of(row[1])) if len(plane) == 1 else "", []).append(row)
    pages = [kind[first:first + ROWS] for kind in kinds.values() for first in range(0, len(kind), ROWS)]

    folder = saving.figures_folder(arguments.output, arguments.result)
    stem = saving.stem_of(arguments.result)

    def draw(kind, figure_of):
        for number, page in enumerate(pages, 1):
            figure = figure_of(page)
            if figure is not None:
                saving.save(figure, folder, f"{stem}_{kind}" + (f"_{number}" if len(pages) > 1 else ""))

    if len(plane) == 2:
        draw(effect_name, lambda page: maps_figure(title, detectable, effect, plane, page, observation_of, effect_name, tolerance))
        if len(nonlinear) in (2, 4):
            draw("nonlinear", lambda page: nonlinear_figure(title, [detectable, *nonlinear], plane, page, observation_of, differs))
        if directions:
            draw("direction", lambda page: direction_figure(title, directions, plane, page))
        return
    draw(effect_name, lambda page: curves_figure(title, detectable, effect, plane[0], page, observation_of, effect_name, tolerance))
    if response and all(residuals[unit_of_residual(observation_of(c))] for _, c in rows):
        sizes = {unit: config.get(f"gross_error_{unit}") for unit in residuals}
        draw("residuals", lambda page: residuals_figure(title, residuals, response, effect_name, sizes, plane[0], page, observation_of))
