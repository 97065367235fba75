"""Figures of a sensor_monte_carlo result: does the covariance model predict the spread, and up to which errors?

    surveymc plot sensor_monte_carlo RESULT.h5 [-o FOLDER] [--point I]

<stem>_axes       predicted over Monte-Carlo standard deviation along the three axes of the predicted ellipsoid: against
                  the size of the errors if the run sweeps sensor_errors.multiplier, otherwise against measured depth
<stem>_ellipses   horizontal errors of the realisations with the 1-sigma ellipses, at every reported depth

each as PNG and SVG, and each only if the file has the data. Of a sweep the second is drawn for the point given by
--point (counted from 0, in the order of the file) and is then named <stem>_point<I>_ellipses.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from . import drawing, geometry, one_point, ratios, reading, saving, wording
from .reading import PlotError
from .wording import SIGMA, grouped, number

MULTIPLIER = "sensor_errors.multiplier"
SPANS = (MULTIPLIER, "drilling.mode")  # keys of a sweep that has figures of its own here
FORMULATIONS = {
    "toolface_dependent": ("toolface-dependent", "#D55E00", (0, (7, 2)), "o"),
    "ti_systematic": ("TI terms, systematic (slid)", "#222222", (0, (3.5, 2)), "s"),
    "ti_random": ("TI terms, random (rotated)", "#009E73", (0, (1, 1.3)), "^"),
}
MARKERS, LINES = "os^vDP*X", ("-", (0, (6, 2)), (0, (3, 1.5)), (0, (1, 1.2)))
MOST_DEPTHS = 6  # lines a panel of the first figure, panels of the second


# --- 1: axes --------------------------------------------------------------------------------------------------------


def axes_figure(title, table, keys, margin):
    """Ratio along each axis. Columns: axes; rows: the other keys of the sweep; lines: depths, or formulations."""
    swept = MULTIPLIER in keys and len(set(table[MULTIPLIER])) > 1
    others = [k for k in keys if not (swept and k == MULTIPLIER)]
    palette = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    if swept:
        curves = {f"{md:g} m": {"formulation": "toolface_dependent", "md_m": md} for md in ratios.some(sorted(set(table["md_m"])), MOST_DEPTHS)}
        looks = {n: (palette[c % len(palette)], LINES[c % 4], MARKERS[c % 8]) for c, n in enumerate(curves)}
    else:
        curves = {look[0]: {"formulation": f} for f, look in FORMULATIONS.items()}
        looks = {label: look for label, *look in FORMULATIONS.values()}
    panels = []
    for point in reading.sweep_points(table, others):
        for axis, word in enumerate(("largest", "middle", "smallest"), 1):
            here = reading.at_point(table, [*others, "quantity"], [*point, f"sd_axis_{axis}"])
            finite = here.where(lambda i: np.isfinite(here["ratio"][i]))
            shown = {n: reading.at_point(finite, list(of), list(of.values())) for n, of in curves.items()}
            zero = sorted({m for m, note in zip(here["md_m"], here["note"]) if note.startswith("zero to first order")})
            panels.append((", ".join(filter(None, (wording.point_name(others, point), f"{word} axis"))), {n: t for n, t in shown.items() if t.rows},
                           f"zero to first order at {', '.join(f'{z:g}' for z in zero)} m, not drawn" if zero else "", {}))
    figure = ratios.curves_figure(title, f"Predicted{' (toolface-dependent covariance)' if swept else ''} over Monte-Carlo standard deviation along "
                                  f"the axes of the predicted ellipsoid, largest first. {wording.counts_text(table['trials'])} runs a point.", panels,
                                  looks, MULTIPLIER if swept else "md_m", table.confidence, margin,
                                  "size of the errors (1: as in the config)" if swept else "measured depth (m)",
                                  sorted(set(table[MULTIPLIER])) if swept else ())
    return figure


# --- 2: ellipses ----------------------------------------------------------------------------------------------------


def ellipses_figure(title, point, samples, table):
    """A panel a depth, along and across the predicted major axis with separate scales: thin ellipses stay legible."""
    depths = ratios.some(sorted(set(table["md_m"])), MOST_DEPTHS)
    figure, panels = drawing.panels(len(depths), (4.0, 3.4))
    monte_carlo = drawing.LOOK["monte_carlo"]["color"]
    for ax, md in zip(panels, depths):
        here = table.where(lambda i: table["md_m"][i] == md)
        reference = here.row(formulation="toolface_dependent")
        if reference is None or here.row(formulation="monte_carlo") is None:
            raise PlotError("table 'ellipse' lacks 'monte_carlo' or 'toolface_dependent'")
        azimuth = reference["major_azimuth_deg"]
        truth = (reference["center_north_m"], reference["center_east_m"])
        if samples is not None and samples.rows:
            cloud = samples.where(lambda i: samples["md_m"][i] == md)
            drawing.cloud(ax, *geometry.map_turned(cloud["north_m"], cloud["east_m"], azimuth))
        for name in ("monte_carlo", *FORMULATIONS):
            row = here.row(formulation=name)
            if row is None:
                continue
            centre = (row["center_north_m"] - truth[0], row["center_east_m"] - truth[1])
            points = geometry.ellipse_points_from_axes(row["semi_major_m"], row["semi_minor_m"],
                                                       row["major_azimuth_deg"], centre=centre)
            color, line = (monte_carlo, "-") if name == "monte_carlo" else FORMULATIONS[name][1:3]
            ax.plot(*geometry.map_turned(*points, azimuth), color=color, linestyle=line, zorder=4,
                    linewidth=3.2 if name == "monte_carlo" else 1.8)
        ax.plot(0, 0, "+", color="black", markersize=9, markeredgewidth=1.3, zorder=6)
        ax.set_title(f"{md:g} m: {number(reference['semi_major_m'])} by {number(reference['semi_minor_m'])} m")
        ax.set_xlabel(f"Along, azimuth {azimuth:.1f}\N{DEGREE SIGN} (m)")
        ax.xaxis.set_major_locator(MaxNLocator(6))
        ax.margins(0.05)
    panels[0].set_ylabel("Across, to the left (m)")
    handles = [Line2D([], [], color=monte_carlo, linewidth=3.2, label="Monte Carlo")]
    handles += [Line2D([], [], color=color, linestyle=line, linewidth=1.8, label=label)
                for label, color, line, _ in FORMULATIONS.values()]
    handles.append(Line2D([], [], color="black", marker="+", linestyle="none", markersize=9, markeredgewidth=1.3,
                          label="true position"))
    drawing.heading(figure, title, (f"{point}. " if point else "") + "Horizontal position errors along and across the major axis of the "
                    f"toolface-dependent ellipse; scales differ. Ellipses are 1{SIGMA}. Monte Carlo: {wording.counts_text(table['trials'])} runs"
                    + (f", the first {grouped(len(set(samples['trial'])))} drawn." if samples is not None and samples.rows else "."))
    drawing.legend_below(figure, handles)
    return figure


# --------------------------------------------------------------------------------------------------------------------


def main():
    arguments = one_point.parse(saving.argument_parser("Draw the figures of a sensor_monte_carlo result."))
    drawing.use_style()
    with reading.open_result(arguments.result, "sensor_monte_carlo") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        axes, ellipses = (reading.read_table(file, n) for n in ("axes", "ellipse"))
        samples = reading.read_table(file, "realisations", "samples")
    for name, table in (("axes", axes), ("ellipse", ellipses)):
        if table is None or table.rows == 0:
            raise PlotError(f"{arguments.result}: table '{name}' is missing or empty")
    keys = reading.sweep_keys(config, axes)
    points = reading.sweep_points(axes, keys)
    figures = {"axes": axes_figure(title, axes, keys, float(config.get("verdict", {}).get("margin", 0)))}
    if len(points) == 1:
        figures["ellipses"] = ellipses_figure(title, wording.point_name(keys, points[0]), samples, ellipses)
    else:
        print("no figure of the ellipses: choose a sweep point with --point I", file=sys.stderr)
    saving.save_all(figures, arguments)
