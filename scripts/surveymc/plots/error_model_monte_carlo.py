"""Figures of an error_model_monte_carlo result: where the covariance of an error model is that of the position errors.

    surveymc plot error_model_monte_carlo RESULT.h5 [-o FOLDER] [--md DEPTH]

<stem>_ratio     Monte-Carlo over predicted standard deviation along the predicted axes, against the size of the errors
<stem>_cloud     realisations with the 1, 2, 3-sigma ellipses of minimum_curvature, in plan and in the vertical section
                 along the well's mean azimuth, a panel a size
<stem>_sources   single sources: standard deviation along the predicted axis, and what is beside it
<stem>_map       over inclination and azimuth of made-up wells: ratio of the smallest axis, coverage of the 3-sigma ellipse

each as PNG and SVG, and each only if the file has the data. Depth: the deepest, or the reported one nearest to --md (m).
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D

from . import drawing, geometry, reading, saving, wording
from .reading import PlotError

MULTIPLIER = "errors.multiplier"
INCLINATION, AZIMUTH, VERTICAL = "well.inclination_deg", "well.azimuth_deg", "errors.vertical"
AXES = ("largest", "middle", "smallest")
COLORS, LINES, MARKERS = ("#0072B2", "#D55E00", "#009E73", "#A8508A", "#222222"), ("-", (0, (6, 2)), (0, (3, 1.5))), "os^vD"
MOST_LINES, MOST_SOURCES = 5, 20
TIMES = "\N{MULTIPLICATION SIGN}"


def some(values, most):
    """At most so many of them, evenly spread, with the first and the last."""
    if len(values) <= most:
        return list(values)
    return [values[round(i)] for i in np.linspace(0, len(values) - 1, most)]


def sizes_of(table):
    return sorted(set(table[MULTIPLIER])) if MULTIPLIER in table else [1.0]


def at_size(table, size):
    return table.where(lambda i: table[MULTIPLIER][i] == size) if table is not None and MULTIPLIER in table else table


def rows_of(table, formulation, quantity):
    return table.where(lambda i: table["formulation"][i] == formulation and table["quantity"][i] == quantity
                       and np.isfinite(table["ratio"][i]))


# --- 1: ratio against size ------------------------------------------------------------------------------------------


def ratio_figure(title, axes, keys, margin):
    """Columns: axes; rows: the other keys of the sweep; lines: depths, and the second order of each depth, dashed."""
    others = [k for k in keys if k != MULTIPLIER]
    points = some(reading.sweep_points(axes, others), 4)
    depths = some(sorted(set(axes["md_m"])), MOST_LINES)
    height = 1.75 + (3.2 if others else 3.0) * len(points)
    figure, panels = plt.subplots(len(points), 3, figsize=(12.0, height), sharex=True, squeeze=False)
    figure.subplots_adjust(left=0.075, right=0.985, top=1 - (1.35 if others else 1.1) / height, bottom=1.05 / height, hspace=0.42, wspace=0.22)
    drawing.heading(figure, title, "Monte-Carlo over predicted standard deviation along the axes of the predicted "
                     f"ellipsoid (minimum_curvature). {wording.trials_text(axes)} a point.")
    for line, point in zip(panels, points):
        here = reading.at_point(axes, others, point)
        for axis, ax in enumerate(line, 1):
            drawing.band(ax, margin)
            for c, md in enumerate(depths):
                rows = rows_of(here, "minimum_curvature", f"sd_axis_{axis}")
                rows = rows.where(lambda i: rows["md_m"][i] == md)
                if not rows.rows:
                    continue
                order = np.argsort(sizes_of_rows(rows))
                x = sizes_of_rows(rows)[order] * 1.02 ** (c - (len(depths) - 1) / 2)
                y, low, high = (1 / rows[k][order] for k in ("ratio", "ratio_ci_high", "ratio_ci_low"))
                ax.errorbar(x, y, yerr=[np.maximum(y - low, 0), np.maximum(high - y, 0)], color=COLORS[c],
                            marker=MARKERS[c], markersize=5.5, elinewidth=1.2, linewidth=1.6)
                second = here.where(lambda i: here["formulation"][i] == "second_order" and here["md_m"][i] == md
                                    and here["quantity"][i] == f"sd_axis_{axis}" and np.isfinite(here["analytic"][i]))
                if second.rows == rows.rows:
                    expected = second["analytic"] / rows["analytic"]
                    ax.plot(sizes_of_rows(second)[order], expected[order], color=COLORS[c], linestyle=(0, (4, 2)),
                            linewidth=1.1, zorder=1.5)
            name = f"{AXES[axis - 1]} axis"
            words = wording.point_name(others, point) if axis == 1 else ""
            ax.set_title(f"{words}\n{name}" if others else name, loc="left")
            ax.set_xscale("log")
        line[0].set_ylabel("Monte Carlo / predicted")
    sizes = sizes_of(axes)
    for ax in panels[-1]:
        ax.set_xlabel("Size of the errors (1: the model's own)")
    for ax in panels.flat:
        drawing.plain_log_axis(ax.xaxis, sizes[0] / 1.2, sizes[-1] * 1.2)
        ax.set_xticks(sizes)
        ax.set_xlim(sizes[0] / 1.3, sizes[-1] * 1.3)
    handles = [Line2D([], [], color=COLORS[c], marker=MARKERS[c], label=f"{md:g} m") for c, md in enumerate(depths)]
    if "second_order" in axes["formulation"]:
        handles.append(Line2D([], [], color="#444444", linestyle=(0, (4, 2)), linewidth=1.1, label="second order"))
    handles += [drawing.interval_handle(axes.confidence), *drawing.margin_handle(margin)]
    figure.legend(handles=handles, loc="lower center", ncol=8, bbox_to_anchor=(0.5, 0.06 / height))
    return figure


def sizes_of_rows(rows):
    return np.asarray(rows[MULTIPLIER]) if MULTIPLIER in rows else np.ones(rows.rows)


# --- 2: cloud -------------------------------------------------------------------------------------------------------


def matrix(row):
    return np.array([[row["nn_m2"], row["ne_m2"], row["nv_m2"]], [row["ne_m2"], row["ee_m2"], row["ev_m2"]],
                     [row["nv_m2"], row["ev_m2"], row["vv_m2"]]])


def cloud_figure(title, covariances, samples, ellipses, md):
    """Rows: plan (north up) and vertical section along the mean azimuth; a column a size."""
    sizes = some(sizes_of(covariances), 4)
    figure, panels = plt.subplots(2, len(sizes), figsize=(3.4 * len(sizes) + 0.8, 8.2), squeeze=False)
    figure.subplots_adjust(left=0.075, right=0.985, top=0.86, bottom=0.12, hspace=0.3, wspace=0.34)
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
        c = matrix(predicted)
        turn = np.radians(azimuth)
        along = np.array([np.cos(turn), np.sin(turn), 0.0])
        section = np.array([along, [0.0, 0.0, 1.0]])
        views = ((panels[0][column], np.array([[0, 1.0, 0], [1.0, 0, 0]])), (panels[1][column], section))
        points = np.array([cloud["north_m"], cloud["east_m"], cloud["vertical_m"]])
        for ax, view in views:  # abscissa, ordinate
            x = view @ points
            ax.plot(x[0], x[1], ".", color="#56B4E9", markersize=drawing.dot_size(count), alpha=0.5, markeredgewidth=0, rasterized=True,
                    zorder=1)
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
    figure.legend(handles=handles, loc="lower center", ncol=4, bbox_to_anchor=(0.5, 0.01))
    return figure


# --- 3: sources -----------------------------------------------------------------------------------------------------


def sources_figure(title, table, md):
    """Bars on a logarithmic axis: the largest sources at one depth, their sd along and across, two sizes at most."""
    sizes = sizes_of(table)
    wanted = [min(sizes, key=lambda s: abs(np.log(s)))]
    if sizes[-1] > wanted[0]:
        wanted.append(sizes[-1])
    figure, panels = plt.subplots(1, len(wanted), figsize=(6.2 * len(wanted), 8.0), squeeze=False)
    figure.subplots_adjust(left=0.1 if len(wanted) > 1 else 0.17, right=0.98, top=0.87, bottom=0.12, wspace=0.24)
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
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=3, bbox_to_anchor=(0.5, 0.01))
    return figure


# --- 4: map ---------------------------------------------------------------------------------------------------------


def map_figure(title, axes, ellipses, md):
    """Columns: sizes; rows: Monte Carlo over predicted of the smallest axis, coverage of the 3-sigma ellipse."""
    sizes = some(sizes_of(axes), 4)
    figure, panels = plt.subplots(2, len(sizes), figsize=(3.9 * len(sizes) + 1.2, 8.4), squeeze=False, layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 1, 0.9))
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
        line[0].set_ylabel("Inclination (deg)")
        bar = figure.colorbar(image, ax=list(line), pad=0.01, format="%g",
                              ticks=[t for t in ((0.5, 1, 2, 5, 10, 20, 50, 100) if high - low > 0.6 else
                                        (0.5, 0.7, 1, 1.2, 1.5, 2, 3, 5)) if 10**low <= t <= 10**high])
        bar.ax.minorticks_off()
    for ax in panels[-1]:
        ax.set_xlabel("Azimuth (deg)")
    drawing.heading(figure, title, f"At {md:g} m. {wording.trials_text(axes)} a cell; a normal distribution has "
                     f"{100 * (1 - geometry.ellipse_coverage(3)):.1f} % outside the ellipse.")
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
        axes, ellipses, covariances, sources = (reading.read_table(file, n) for n in
                                                ("axes", "ellipse", "position_covariance", "by_source"))
        samples = reading.read_table(file, "realisations", "samples")
    if covariances is None or covariances.rows == 0:
        raise PlotError(f"{arguments.result}: table 'position_covariance' is missing or empty")
    depths = sorted(set(covariances["md_m"]))
    md = depths[-1] if arguments.md is None else min(depths, key=lambda x: abs(x - arguments.md))
    keys = reading.sweep_keys(config, covariances)
    others = [k for k in keys if k != MULTIPLIER]
    is_map = axes is not None and INCLINATION in keys and AZIMUTH in keys
    figures = {}
    if is_map:
        figures["map"] = map_figure(title, axes, ellipses, md)
    elif axes is not None and axes.rows:
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
    saving.save_all(figures, arguments)
