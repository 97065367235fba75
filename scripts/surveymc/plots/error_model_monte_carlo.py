"""Figures of an error_model_monte_carlo result: where the covariance of an error model is that of the position errors.

    surveymc plot error_model_monte_carlo RESULT.h5 [-o FOLDER] [--md DEPTH]

<stem>_ratio     Monte-Carlo over predicted standard deviation along the predicted axes, against the size of the errors
<stem>_cloud     realisations with the 1, 2, 3-sigma ellipses of minimum_curvature, in plan and in the vertical section
                 along the well's mean azimuth, a panel a size
<stem>_sources   single sources: standard deviation along the predicted axis, and what is beside it
<stem>_tails     with table `tails`: lateral errors beyond k sd against k, and the line of the normal distribution
<stem>_tails_map over inclination and azimuth of made-up wells: how many are beyond 3.5 sd
<stem>_map       over inclination and azimuth of made-up wells: ratio of the smallest axis, coverage of the 3-sigma ellipse
<stem>_disturbance   the first trials of a disturbance along the run: errors of azimuths, and of the lateral position, with its
                 predicted sd and that of independent errors

each as PNG and SVG, and each only if the file has the data. Depth: the deepest, or the reported one nearest to --md (m).
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D

from . import drawing, geometry, ratios, reading, saving, tails, wording
from .reading import PlotError

SPANS = ("well.inclination_deg", "well.azimuth_deg", "errors.multiplier", "errors.vertical")  # keys of a sweep that has figures of its own here

MULTIPLIER = "errors.multiplier"
INCLINATION, AZIMUTH = "well.inclination_deg", "well.azimuth_deg"
AXES = ("largest", "middle", "smallest")
COLORS, LINES, MARKERS = ("#0072B2", "#D55E00", "#009E73", "#A8508A", "#222222"), ("-", (0, (6, 2)), (0, (3, 1.5))), "os^vD"
MOST_LINES, MOST_SOURCES = 5, 20
TIMES, DEGREE = "\N{MULTIPLICATION SIGN}", "\N{DEGREE SIGN}"


def sizes_of(table):
    return sorted(set(table[MULTIPLIER])) if MULTIPLIER in table else [1.0]


def at_size(table, size):
    return table.where(lambda i: table[MULTIPLIER][i] == size) if table is not None and MULTIPLIER in table else table


# --- 1: ratio against size ------------------------------------------------------------------------------------------


def ratio_figure(title, axes, keys, margin):
    """Columns: axes; rows: the other keys of the sweep; lines: depths, and the second order of each depth, dashed."""
    others = [k for k in keys if k != MULTIPLIER]
    depths = ratios.some(sorted(set(axes["md_m"])), MOST_LINES)
    looks = {f"{md:g} m": (COLORS[c], "-", MARKERS[c]) for c, md in enumerate(depths)}
    panels = []
    for point in ratios.some(reading.sweep_points(axes, others), 4):
        for axis, word in enumerate(AXES, 1):
            here = reading.at_point(axes, [*others, "quantity"], [*point, f"sd_axis_{axis}"])
            shown, second = {}, {}
            for label, md in zip(looks, depths):
                rows = here.where(lambda i: here["formulation"][i] == "minimum_curvature" and here["md_m"][i] == md and np.isfinite(here["ratio"][i]))
                more = here.where(lambda i: here["formulation"][i] == "second" and here["md_m"][i] == md and np.isfinite(here["analytic"][i]))
                if rows.rows:
                    shown[label] = rows
                if rows.rows and more.rows == rows.rows and MULTIPLIER in rows:
                    order = np.argsort(rows[MULTIPLIER])
                    second[label] = rows[MULTIPLIER][order], (more["analytic"] / rows["analytic"])[order]
            panels.append((", ".join(filter(None, (wording.point_name(others, point), f"{word} axis"))), shown, "", second))
    return ratios.curves_figure(title, "Monte-Carlo over predicted standard deviation along the axes of the predicted ellipsoid (minimum curvature). "
                                f"{wording.trials_text(axes)} a point.", panels, looks, MULTIPLIER, axes.confidence, margin,
                                "size of the errors (1: the model's own)", sizes_of(axes), is_found_over_predicted=True)


# --- 2: cloud -------------------------------------------------------------------------------------------------------


def cloud_figure(title, covariances, samples, ellipses, md):
    """Rows: plan (north up) and vertical section along the mean azimuth; a column a size."""
    sizes = ratios.some(sizes_of(covariances), 4)
    figure, panels = plt.subplots(2, len(sizes), figsize=(max(3.4 * len(sizes) + 0.8, 6.4), 8.2), squeeze=False, layout="constrained")
    row = ellipses.row(formulation="minimum_curvature", md_m=md)
    azimuth = np.degrees(np.arctan2(row["center_east_m"], row["center_north_m"])) if row else 0.0
    count = 0
    for column, size in enumerate(sizes):
        cloud, here = at_size(samples, size), at_size(covariances, size)
        cloud = cloud.where(lambda i: cloud["md_m"][i] == md)
        count = cloud.rows
        predicted = here.row(formulation="minimum_curvature", md_m=md)
        if predicted is None:
            raise PlotError("table 'position_covariance' lacks 'minimum_curvature'")
        c = geometry.covariances(predicted)
        turn = np.radians(azimuth)
        along = np.array([np.cos(turn), np.sin(turn), 0.0])
        section = np.array([along, [0.0, 0.0, 1.0]])
        views = ((panels[0][column], np.array([[0, 1.0, 0], [1.0, 0, 0]])), (panels[1][column], section))
        points = np.array([cloud["north_m"], cloud["east_m"], cloud["vertical_m"]])
        for ax, view in views:  # abscissa, ordinate
            x = view @ points
            drawing.cloud(ax, *x)
            for k in (1, 2, 3):
                ellipse = geometry.ellipse_points(view @ c @ view.T, k)
                ax.plot(*ellipse, color="#D55E00", linewidth=1.5, zorder=3)
            ax.plot(*(view @ points).mean(axis=1), "x", color="#222222", markersize=7, markeredgewidth=1.5, zorder=4)
            ax.plot(0, 0, "+", color="black", markersize=9, markeredgewidth=1.3, zorder=4)
            ax.margins(0.06)
        panels[0][column].set_title(f"errors {TIMES} {size:g}")
        panels[0][column].set_xlabel("East (m)")
        panels[1][column].set_xlabel(f"Along azimuth {azimuth % 360:.0f}\N{DEGREE SIGN} (m)")
        panels[1][column].invert_yaxis()
    panels[0][0].set_ylabel("North (m)")
    panels[1][0].set_ylabel("Down (m)")
    drawing.heading(figure, title, f"Position errors at {md:g} m: {wording.grouped(count)} realisations a panel, above in "
                     "plan, below in the vertical section along the mean azimuth. Scales differ.")
    handles = [Line2D([], [], color="#56B4E9", marker=".", linestyle="none", label="realisation"),
               Line2D([], [], color="#D55E00", linewidth=1.5, label="predicted, 1, 2, 3\N{GREEK SMALL LETTER SIGMA}"),
               Line2D([], [], color="black", marker="+", linestyle="none", markersize=9, label="true position"),
               Line2D([], [], color="#222222", marker="x", linestyle="none", label="mean of the realisations")]
    drawing.legend_below(figure, handles)
    return figure


# --- 3: sources -----------------------------------------------------------------------------------------------------


def sources_figure(title, table, md):
    """Bars on a logarithmic axis: the largest sources at one depth, their sd along and across, two sizes at most."""
    sizes = sizes_of(table)
    wanted = [min(sizes, key=lambda s: abs(np.log(s)))]
    if sizes[-1] > wanted[0]:
        wanted.append(sizes[-1])
    figure, panels = plt.subplots(1, len(wanted), figsize=(6.2 * len(wanted), 8.0), squeeze=False, layout="constrained")
    for ax, size in zip(panels[0], wanted):
        here = at_size(table, size)
        here = here.where(lambda i: here["md_m"][i] == md and here["quantity"][i] == "sd_along"
                          and here["formulation"][i] == "minimum_curvature")
        if not here.rows:
            raise PlotError("table 'by_source' has no rows of minimum_curvature at this depth")
        order = np.argsort(-here["monte_carlo"])[:MOST_SOURCES][::-1]
        y = np.arange(len(order))
        across = here["across_m"][order]
        floor = max(1e-4, 0.5 * min(here["monte_carlo"][order].min(), across[across > 1e-4].min() if (across > 1e-4).any()
                                    else 1.0))
        shift = np.sqrt(sum(here[f"mean_{d}_m"][order] ** 2 for d in ("north", "east", "vertical")))
        for offset, values, color, label in ((0.27, here["monte_carlo"][order], "#0072B2", "along the predicted axis"),
                                             (0.0, across, "#D55E00", "across"), (-0.27, shift, "#222222", "mean shift")):
            ax.barh(y + offset, np.maximum(values - floor, 0), 0.25, left=floor, color=color, label=label)
        ax.set_xscale("log")
        ax.set_yticks(y, [f"{here['source'][i]} ({here['mode'][i]})" for i in order])
        ax.set_ylim(-0.6, len(order) - 0.4)
        ax.set_xlabel("One standard deviation, or shift (m)")
        ax.set_title(f"errors {TIMES} {size:g}")
        ax.grid(axis="y", visible=False)
    drawing.heading(figure, title, f"Single sources at {md:g} m, the largest {min(MOST_SOURCES, len(order))}. First order has "
                     "nothing across and no shift.")
    drawing.legend_below(figure, panels[0][0].get_legend_handles_labels()[0])
    return figure


# --- 4: map ---------------------------------------------------------------------------------------------------------


def map_figure(title, axes, ellipses, md):
    """Columns: sizes; rows: Monte Carlo over predicted of the smallest axis, coverage of the 3-sigma ellipse."""
    sizes = ratios.some(sizes_of(axes), 4)
    figure, panels = plt.subplots(2, len(sizes), figsize=(3.9 * len(sizes) + 1.2, 8.4), squeeze=False, layout="constrained")
    ratio = axes.where(lambda i: axes["md_m"][i] == md and axes["quantity"][i] == "sd_axis_3"
                       and axes["formulation"][i] == "minimum_curvature")
    cover = ellipses.where(lambda i: ellipses["md_m"][i] == md and ellipses["formulation"][i] == "minimum_curvature")
    inclinations, azimuths = sorted(set(axes[INCLINATION])), sorted(set(axes[AZIMUTH]))
    values = ((1 / ratio["ratio"], ratio, "Monte Carlo / predicted, smallest axis", "viridis", lambda v: f"{v:.2f}"),
              (100 * (1 - cover["coverage_3sigma"]), cover, "Outside the horizontal 3\N{GREEK SMALL LETTER SIGMA} ellipse (%)",
               "magma_r", lambda v: f"{v:.1f}"))
    for line, (value, table, label, colours, text) in zip(panels, values):
        logarithm = np.log10(np.clip(value, 1e-3, None))
        low, high = logarithm.min(), logarithm.max()
        for ax, size in zip(line, sizes):
            grid = np.full((len(inclinations), len(azimuths)), np.nan)
            for i in range(table.rows):
                if MULTIPLIER not in table or table[MULTIPLIER][i] == size:
                    grid[inclinations.index(table[INCLINATION][i]), azimuths.index(table[AZIMUTH][i])] = value[i]
            image = ax.imshow(np.clip(grid, 1e-3, None), origin="lower", aspect="auto", cmap=colours,
                              norm=LogNorm(10**low, 10**(high if high > low else low + 1)))
            for y, x in np.ndindex(grid.shape):
                shade = (np.log10(max(grid[y, x], 1e-3)) - low) / max(high - low, 1e-9)
                dark = shade < 0.6 if colours == "viridis" else shade > 0.5
                ax.text(x, y, text(grid[y, x]), ha="center", va="center", fontsize=8.5, color="white" if dark else "black")
            ax.set_xticks(range(len(azimuths)), [f"{a:g}" for a in azimuths])
            ax.set_yticks(range(len(inclinations)), [f"{i:g}" for i in inclinations])
            ax.set_title(f"{label if size == sizes[0] else ''}\nerrors {TIMES} {size:g}", loc="left")
            ax.grid(False)
        line[0].set_ylabel(f"Inclination ({DEGREE})")
        bar = figure.colorbar(image, ax=list(line), pad=0.01, format="%g",
                              ticks=[t for t in ((0.5, 1, 2, 5, 10, 20, 50, 100) if high - low > 0.6 else
                                        (0.5, 0.7, 1, 1.2, 1.5, 2, 3, 5)) if 10**low <= t <= 10**high])
        bar.ax.minorticks_off()
    for ax in panels[-1]:
        ax.set_xlabel(f"Azimuth ({DEGREE})")
    drawing.heading(figure, title, f"At {md:g} m. {wording.trials_text(axes)} a cell; a normal distribution has "
                     f"{100 * (1 - geometry.ellipse_coverage(3)):.1f} % outside the ellipse.")
    return figure


# --- 5: disturbance -------------------------------------------------------------------------------------------------


def disturbance_figure(title, runs):
    """Above the errors of the azimuths, below the lateral errors; the trial with the largest lateral error stands out."""
    figure, panels = plt.subplots(2, 1, figsize=(8.2, 6.8), sharex=True, layout="constrained")
    trials = sorted(set(runs["trial"]))
    worst = runs["trial"][np.argmax(np.abs(runs["lateral_m"]))]
    one = runs.where(lambda i: runs["trial"][i] == worst)
    for k in (2, 1):
        panels[1].fill_between(one["time_h"], -k * one["lateral_sd_m"], k * one["lateral_sd_m"], color="#D55E00", alpha=0.14, linewidth=0)
        for sign in (-1, 1):
            panels[1].plot(one["time_h"], sign * k * one["independent_sd_m"], color="#222222", linewidth=1.0, linestyle=LINES[1 if k == 2 else 2])
    for trial in (*(x for x in trials if x != worst), worst):
        here = runs.where(lambda i: runs["trial"][i] == trial)
        look = {"color": "#0072B2", "linewidth": 1.8, "zorder": 4} if trial == worst else {"color": "#8A8A8A", "linewidth": 0.9}
        for ax, column in zip(panels, ("azimuth_deg", "lateral_m")):
            ax.plot(here["time_h"], here[column], marker="." if len(here["time_h"]) < 60 else None, markersize=4, **look)
    panels[0].set_ylabel(f"Error of the azimuth ({DEGREE})")
    panels[1].set_ylabel("Lateral error (m)")
    panels[1].set_xlabel("Time since the first station (h)")
    drawing.heading(figure, title, f"The disturbance alone, {len(trials)} trials. Where it lasts, the position's errors add up: "
                    f"at the end its sd is {one['lateral_sd_m'][-1]:.2g} m, and {one['independent_sd_m'][-1]:.2g} m if every station had a new one.")
    drawing.legend_below(figure, [
        Line2D([], [], color="#0072B2", linewidth=1.8, label="trial with the largest lateral error"),
        Line2D([], [], color="#8A8A8A", linewidth=0.9, label="other trials"),
        Line2D([], [], color="#D55E00", alpha=0.3, linewidth=7, label="1, 2 predicted sd"),
        Line2D([], [], color="#222222", linewidth=1.0, linestyle=LINES[1], label="1, 2 sd of independent errors")])
    return figure


# --------------------------------------------------------------------------------------------------------------------


def main():
    parser = saving.argument_parser("Draw the figures of an error_model_monte_carlo result.")
    parser.add_argument("--md", type=float, metavar="DEPTH", help="reported depth (m) of clouds, sources and map")
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, "error_model_monte_carlo") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        axes, ellipses, covariances, sources, beyond = (reading.read_table(file, n) for n in
                                                        ("axes", "ellipse", "position_covariance", "by_source", "tails"))
        samples = reading.read_table(file, "realisations", "samples")
        runs = reading.read_table(file, "disturbance_runs")
    if covariances is None or covariances.rows == 0:
        raise PlotError(f"{arguments.result}: table 'position_covariance' is missing or empty")
    depths = sorted(set(covariances["md_m"]))
    md = depths[-1] if arguments.md is None else min(depths, key=lambda x: abs(x - arguments.md))
    keys = reading.sweep_keys(config, covariances)
    others = [k for k in keys if k != MULTIPLIER]
    is_map = axes is not None and INCLINATION in keys and AZIMUTH in keys
    figures = {}
    if beyond is not None and is_map:
        figures["tails_map"] = tails.map_figure(title, beyond, keys, md=md)
    elif beyond is not None:
        figures["tails"] = tails.coverage_figure(title, beyond, keys, md=md)
    if is_map and set(keys) <= {INCLINATION, AZIMUTH, MULTIPLIER}:  # a panel a size: cells of several models would hide each other
        figures["map"] = map_figure(title, axes, ellipses, md)
    elif not is_map and axes is not None and axes.rows:
        figures["ratio"] = ratio_figure(title, axes, keys, float(config.get("verdict", {}).get("margin", 0)))
    if not is_map and samples is not None and samples.rows:
        for index, point in enumerate(reading.sweep_points(covariances, others)):
            name = "cloud" if not others else f"cloud_{index}"
            words = wording.point_name(others, point)
            figures[name] = cloud_figure(f"{title}: {words}" if words else title,
                                         reading.at_point(covariances, others, point),
                                         reading.at_point(samples, others, point),
                                         reading.at_point(ellipses, others, point), md)
    if sources is not None and sources.rows:
        first = reading.sweep_points(covariances, others)[0]
        figures["sources"] = sources_figure(title, reading.at_point(sources, others, first), md)
    if runs is not None and runs.rows:
        for index, point in enumerate(reading.sweep_points(runs, keys)):
            words = wording.point_name(keys, point)
            figures["disturbance" if not keys else f"disturbance_{index}"] = disturbance_figure(
                f"{title}: {words}" if words else title, reading.at_point(runs, keys, point))
    saving.save_all({name: figure for name, figure in figures.items() if figure is not None}, arguments)
