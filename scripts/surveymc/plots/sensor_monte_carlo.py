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
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, MaxNLocator

from . import drawing, geometry, reading, saving, wording
from .reading import PlotError
from .wording import SIGMA, grouped, number

MULTIPLIER = "sensor_errors.multiplier"
FORMULATIONS = {
    "toolface_dependent": ("toolface-dependent", "#D55E00", (0, (7, 2)), "o"),
    "ti_systematic": ("TI terms, systematic (slid)", "#222222", (0, (3.5, 2)), "s"),
    "ti_random": ("TI terms, random (rotated)", "#009E73", (0, (1, 1.3)), "^"),
}
MARKERS, LINES = "os^vDP*X", ("-", (0, (6, 2)), (0, (3, 1.5)), (0, (1, 1.2)))
MOST_DEPTHS = 6  # lines a panel of the first figure, panels of the second


def some(values):
    """At most MOST_DEPTHS of them, evenly spread, with the first and the last."""
    if len(values) <= MOST_DEPTHS:
        return list(values)
    return [values[round(i)] for i in np.linspace(0, len(values) - 1, MOST_DEPTHS)]


# --- 1: axes --------------------------------------------------------------------------------------------------------


def axes_figure(title, table, keys, margin):
    """Ratio along each axis. Columns: axes; rows: the other keys of the sweep; lines: depths, or formulations."""
    swept = MULTIPLIER in keys and len(set(table[MULTIPLIER])) > 1
    others = [k for k in keys if not (swept and k == MULTIPLIER)]
    points = reading.sweep_points(table, others)
    depths = sorted(set(table["md_m"]))
    height = 1.75 + 2.9 * len(points)
    figure, panels = plt.subplots(len(points), 3, figsize=(12.0, height), sharex=True, sharey="row", squeeze=False)
    figure.subplots_adjust(left=0.075, right=0.985, top=1 - 1.1 / height, bottom=1.15 / height, hspace=0.32, wspace=0.08)
    figure.suptitle(title, x=0.02, y=1 - 0.12 / height, ha="left")
    figure.text(0.02, 1 - 0.42 / height, "Predicted (toolface-dependent covariance) over Monte-Carlo standard deviation "
                if swept else "Predicted over Monte-Carlo standard deviation ", ha="left", va="top")
    figure.texts[-1].set_text(figure.texts[-1].get_text() + "along the axes of the predicted ellipsoid, largest first. "
                              f"{wording.counts_text(table['trials'])} runs a point.")
    palette = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    handles = []
    for line, point in zip(panels, points):
        here = reading.at_point(table, others, point)
        low, high = 1 - 1.3 * (margin or 0.03), 1 + 1.3 * (margin or 0.03)
        for axis, ax in enumerate(line, 1):
            rows = here.where(lambda i: here["quantity"][i] == f"sd_axis_{axis}" and np.isfinite(here["ratio"][i]))
            if margin:
                ax.axhspan(1 - margin, 1 + margin, color="#009E73", alpha=0.18, linewidth=0, zorder=0)
            ax.axhline(1, color="#444444", linewidth=1.0, zorder=1)
            curves = []
            if swept:
                for c, md in enumerate(some(depths)):
                    keep = [i for i in range(rows.rows)
                            if rows["md_m"][i] == md and rows["formulation"][i] == "toolface_dependent"]
                    curves.append((keep, f"{md:g} m", palette[c % len(palette)], LINES[c % 4], MARKERS[c % 8], c,
                                   MULTIPLIER))
            else:
                for c, (name, (label, color, style, marker)) in enumerate(FORMULATIONS.items()):
                    keep = [i for i in range(rows.rows) if rows["formulation"][i] == name]
                    curves.append((keep, label, color, style, marker, c, "md_m"))
            handles = [Line2D([], [], color=color, linestyle=style, marker=marker, label=label)
                       for _, label, color, style, marker, *_ in curves]
            for keep, _, color, style, marker, c, x_key in curves:
                if not keep:
                    continue
                keep.sort(key=lambda i: rows[x_key][i])
                x, y = rows[x_key][keep], rows["ratio"][keep]
                if swept:  # side by side, not on top of each other
                    x = x * 1.025 ** (c - (len(curves) - 1) / 2)
                ax.errorbar(x, y, yerr=[y - rows["ratio_ci_low"][keep], rows["ratio_ci_high"][keep] - y], color=color,
                            linestyle=style, marker=marker, markersize=5.5, elinewidth=1.2)
                low, high = min(low, rows["ratio_ci_low"][keep].min()), max(high, rows["ratio_ci_high"][keep].max())
            zero = sorted({here["md_m"][i] for i in range(here.rows) if here["quantity"][i] == f"sd_axis_{axis}"
                           and here["note"][i].startswith("zero to first order")})
            if zero:
                ax.annotate(f"zero to first order at {', '.join(f'{z:g}' for z in zero)} m, not drawn", (0.03, 0.04),
                            xycoords="axes fraction", style="italic", fontsize=8.5)
            name = ("largest", "middle", "smallest")[axis - 1] + " axis"
            ax.set_title(name if not others else f"{wording.point_name(others, point)}: {name}")
            if swept:
                ax.set_xscale("log")
        spread = high - low
        line[0].set_ylim(low - 0.1 * spread, high + 0.06 * spread)
        if high > 2 * low > 0:
            line[0].set_yscale("log")
            line[0].set_ylim(low / 1.35, high * 1.12)
            drawing.plain_log_axis(line[0].yaxis, low / 1.35, high * 1.12)
        line[0].set_ylabel("Predicted / Monte Carlo")
    sizes = sorted(set(table[MULTIPLIER])) if swept else []
    for ax in panels[-1]:
        ax.set_xlabel("Size of the errors (1: as in the config)" if swept else "Measured depth (m)")
        if not swept:
            depth = sorted(set(table["md_m"]))  # a tick at an end would run into that of the panel beside
            ax.xaxis.set_major_locator(MaxNLocator(5, prune="both") if len(depth) > 1 else FixedLocator(depth))
        if swept:
            drawing.plain_log_axis(ax.xaxis, sizes[0] / 1.2, sizes[-1] * 1.2)
            ax.set_xticks(sizes)
            ax.set_xlim(sizes[0] / 1.25, sizes[-1] * 1.25)
    handles.append(Line2D([], [], color="#444444", marker="|", linestyle="none", markersize=11, markeredgewidth=1.6,
                          label=f"{100 * table.confidence:g} % interval"))
    if margin:
        handles.append(Patch(color="#009E73", alpha=0.18, label=f"agrees: 1 \N{PLUS-MINUS SIGN} {margin:g}"))
    figure.legend(handles=handles, loc="lower center", ncol=min(len(handles), 8), bbox_to_anchor=(0.5, 0.08 / height))
    return figure


# --- 2: ellipses ----------------------------------------------------------------------------------------------------


def ellipses_figure(title, point, samples, table):
    """A panel a depth, along and across the predicted major axis with separate scales: thin ellipses stay legible."""
    depths = some(sorted(set(table["md_m"])))
    columns = min(len(depths), 3)
    lines = -(-len(depths) // columns)
    height = 1.75 + 3.6 * lines
    figure, panels = plt.subplots(lines, columns, figsize=(12.0 if columns > 1 else 8.5, height), squeeze=False)
    figure.subplots_adjust(left=0.075 if columns > 1 else 0.12, right=0.985, top=1 - 1.2 / height, bottom=1.05 / height,
                           hspace=0.42, wspace=0.24)
    figure.suptitle(title, x=0.02, y=1 - 0.12 / height, ha="left")
    figure.text(0.02, 1 - 0.42 / height, "Horizontal position errors along and across the major axis of the "
                f"toolface-dependent ellipse; scales differ.\n" + (f"{point}. " if point else "") +
                f"Ellipses are 1{SIGMA}. Monte Carlo: {wording.counts_text(table['trials'])} runs" +
                (f", the first {grouped(len(set(samples['trial'])))} drawn." if samples is not None and samples.rows
                 else "."), ha="left", va="top", linespacing=1.4)
    monte_carlo = drawing.LOOK["monte_carlo"]["color"]
    for ax, md in zip(panels.flat, depths):
        here = table.where(lambda i: table["md_m"][i] == md)
        reference = here.row(formulation="toolface_dependent")
        if reference is None or here.row(formulation="monte_carlo") is None:
            raise PlotError("table 'ellipse' lacks 'monte_carlo' or 'toolface_dependent'")
        azimuth = reference["major_azimuth_deg"]
        truth = (reference["center_north_m"], reference["center_east_m"])
        if samples is not None and samples.rows:
            cloud = samples.where(lambda i: samples["md_m"][i] == md)
            ax.plot(*geometry.map_turned(cloud["north_m"], cloud["east_m"], azimuth), ".", color="#56B4E9",
                    markersize=drawing.dot_size(cloud.rows), alpha=0.45, markeredgewidth=0, rasterized=True, zorder=1)
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
    for line in panels:
        line[0].set_ylabel("Across, to the left (m)")
    for ax in list(panels.flat)[len(depths):]:
        ax.set_visible(False)
    handles = [Line2D([], [], color=monte_carlo, linewidth=3.2, label="Monte Carlo")]
    handles += [Line2D([], [], color=color, linestyle=line, linewidth=1.8, label=label)
                for label, color, line, _ in FORMULATIONS.values()]
    handles.append(Line2D([], [], color="black", marker="+", linestyle="none", markersize=9, markeredgewidth=1.3,
                          label="true position"))
    figure.legend(handles=handles, loc="lower center", ncol=5 if columns > 1 else 3,
                  bbox_to_anchor=(0.5, 0.06 / height))
    return figure


# --------------------------------------------------------------------------------------------------------------------


def main():
    parser = saving.argument_parser("Draw the figures of a sensor_monte_carlo result.")
    parser.add_argument("--point", type=int, metavar="I", help="sweep point of the ellipses, from 0")
    arguments = parser.parse_args()
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
    index = reading.chosen_point(arguments, points)
    figures = {"axes": axes_figure(title, axes, keys, float(config.get("verdict", {}).get("margin", 0)))}
    if len(points) == 1 or index is not None:
        point = points[index or 0]
        prefix = "" if len(points) == 1 else f"point{index}_"
        figures[prefix + "ellipses"] = ellipses_figure(title, wording.point_name(keys, point),
                                                       reading.at_point(samples, keys, point),
                                                       reading.at_point(ellipses, keys, point))
    else:
        print("no figure of the ellipses: choose a sweep point with --point I", file=sys.stderr)
    saving.save_all(figures, arguments)
