"""Figures of an axial_correction result, PNG and SVG next to it.

    surveymc plot axial_correction RESULT.h5 [-o FOLDER] [--point I]

<stem>_maps      error of the azimuth by the constant errors (if there are any), and its standard deviation, over
                 inclination and azimuth: a column for each method; hatched where there is no solution
<stem>_curves    both against inclination, a column of panels for three azimuths; points: Monte Carlo with its interval

A sweep is drawn for the point given by --point (counted from 0); the figures are then named <stem>_point<I>_<figure>.
"""

import matplotlib.patheffects
import matplotlib.pyplot as plt
import h5py
import matplotlib
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import MultipleLocator

from . import drawing, reading, saving, wording
from .reading import PlotError

LOOK = {
    "basic": {"label": "basic", "color": "#222222", "linestyle": "-", "marker": "o"},
    "simple": {"label": "simple", "color": "#D55E00", "linestyle": (0, (6, 2)), "marker": "s"},
    "extended": {"label": "extended", "color": "#0072B2", "linestyle": (0, (3, 1.2)), "marker": "^"},
    "extended_bh": {"label": "extended with Bh", "color": "#009E73", "linestyle": (0, (1, 1)), "marker": "D"},
    "optimising": {"label": "fully optimising", "color": "#CC79A7", "linestyle": (0, (5, 1.5, 1, 1.5)), "marker": "v"},
}
LEVELS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50]
FINE = [s * 10.0**e for e in (-1, 0, 1) for s in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)]  # of maps that vary little
DEGREE = "\N{DEGREE SIGN}"
ROUNDING = 1e-9  # deg: no error
MOST = 180.0  # an azimuth is not off by more


def read(file, point):
    """Axes and the two maps of one sweep point, values [method][inclination][azimuth], and the table of Monte Carlo."""
    maps = file["maps"]
    data = maps["azimuth_error_deg"]
    scales = [dim[0] for dim in data.dims][-3:]
    methods, inclination, azimuth = [s.asstr()[()] if h5py.check_string_dtype(s.dtype) is not None else s[()] for s in scales]
    chosen, keys, values, points = reading.map_point(file, data, 3, point)
    title = wording.point_name(keys, values)
    table = reading.read_table(file, "verification")
    if table is not None:
        own = [(k, v) for k, v in zip(keys, values) if k in table]
        table = reading.at_point(table, [k for k, _ in own], [v for _, v in own])
    return (list(methods), np.asarray(inclination, float), np.asarray(azimuth, float), np.abs(data[chosen]),
            maps["azimuth_sd_deg"][chosen], table, title, points)


def levels_of(maps):
    """Contours for several maps together: round sizes between most of their smallest and largest values."""
    values = np.concatenate([v[np.isfinite(v) & (v > ROUNDING)] for v in maps]) if maps else np.array([])
    if values.size == 0:
        return LEVELS
    low, high = np.percentile(np.clip(values, LEVELS[0], LEVELS[-1]), [5, 95])
    # maps count as varying little if nine tenths of them lie within a factor of four
    steps = [v for v in (FINE if high < 4 * low else LEVELS) if low / 1.6 <= v <= high * 2.1]
    return steps if len(steps) > 2 else LEVELS


def panel(axes, x, y, values, levels):
    """Filled contours of sizes on a logarithmic scale; returns them for the colour bar."""
    shown = np.where(np.isfinite(values), np.clip(values, levels[0] / 2, MOST), np.nan)
    axes.set_facecolor("#DDDDDD")
    norm = matplotlib.colors.LogNorm(levels[0] / 1.3, levels[-1] * 1.3)
    filled = axes.contourf(x, y, shown, levels=levels, norm=norm, cmap="cividis", extend="both")
    for collection in filled.collections:
        collection.set_edgecolor("face")
    crossed = [v for v in levels if np.nanmin(shown) < v < np.nanmax(shown)]
    if crossed:
        lines = axes.contour(x, y, shown, levels=crossed, colors="white", linewidths=0.6)
        drawing.label_contours(axes, lines, lambda v: f"{v:g}")
    else:
        most = np.nanmax(values[np.isfinite(values)])
        axes.text(0.5, 0.5, "no error" if most < ROUNDING else f"at most {wording.number(most)}", color="white",
                  transform=axes.transAxes, ha="center")
    wide, high = 0.008 * np.ptp(x), 0.012 * np.ptp(y)
    # one patch for each run of azimuths without a solution, or single points would not be seen
    for i in range(len(y)):
        bad = np.flatnonzero(~np.isfinite(values[i]))
        for run in np.split(bad, np.flatnonzero(np.diff(bad) > 1) + 1) if bad.size else []:
            axes.add_patch(Rectangle((x[run[0]] - wide, y[i] - high), x[run[-1]] - x[run[0]] + 2 * wide, 2 * high,
                                     hatch="/////", facecolor="white", edgecolor="#B00020", linewidth=0.8, zorder=3))
    axes.grid(False)
    axes.set_xlim(min(x), max(x))
    axes.set_ylim(min(y), max(y))
    for set_ticks, v in ((axes.set_xticks, x), (axes.set_yticks, y)):
        if np.ptp(v) in (90, 180, 360):
            set_ticks(np.linspace(min(v), max(v), 5 if np.ptp(v) == 360 else 7 if set_ticks == axes.set_yticks else 4))
    return filled


def maps_figure(title, methods, inclination, azimuth, error, sd):
    rows = [(sd, "sd")]
    if np.any(error[np.isfinite(error)] > ROUNDING):
        rows.insert(0, (error, "|error|"))
    columns = len(methods)
    figure, grid = plt.subplots(len(rows), columns, figsize=(1.2 + 2.9 * columns, 0.9 + 3.0 * len(rows)), squeeze=False,
                                sharex=True, sharey=True, layout="constrained")
    levels, filled = {name: levels_of(list(values)) for values, name in rows}, {}
    for k, m in enumerate(methods):
        for axes, (values, name) in zip(grid[:, k], rows):
            filled[name] = panel(axes, azimuth, inclination, values[k], levels[name])
            axes.set_title(f"{LOOK[m]['label']}: {name} ({DEGREE})", fontsize=9)
        grid[-1][k].set_xlabel(f"magnetic azimuth ({DEGREE})")
    for row, (_, name) in zip(grid, rows):
        row[0].set_ylabel(f"inclination ({DEGREE})")
        bar = figure.colorbar(filled[name], ax=list(row), ticks=drawing.apart(levels[name], levels[name][0], levels[name][-1], lambda t: 0.05), pad=0.02, format=lambda v, _: f"{v:g}")
        bar.ax.minorticks_off()
        bar.set_label(f"{name} ({DEGREE})")
    drawing.heading(figure, title, ("Standard deviation of the azimuth" if len(rows) == 1 else "Azimuth: error by the constant errors, and standard "
                    "deviation") + ". Hatched: infinite (no solution, or no azimuth)"
                    + ("; grey: beside it." if any(not np.all(np.isfinite(v)) for v, _ in rows) else "."))
    return figure


def nearest_azimuths(azimuth, table):
    """Up to three azimuths to cut the maps at: those of the Monte Carlo, or 0, 45, 90 or what is nearest."""
    wanted = set(table["magnetic_azimuth_deg"]) if table is not None else set()
    wanted = sorted(wanted if len(wanted) > 2 else wanted | {0.0, 90.0} if wanted else {0.0, 45.0, 90.0})
    found = []
    for a in wanted:
        j = int(np.argmin(np.abs(azimuth - a)))
        if j not in found:
            found.append(j)
    return [found[i] for i in sorted({0, len(found) // 2, len(found) - 1})]


def are_alike(values, j):
    """Whether all methods have the same curve at azimuth j, but for where one has no solution."""
    of_cut = values[:, :, j]
    size = np.where(np.isfinite(of_cut), of_cut, np.nanmedian(of_cut[np.isfinite(of_cut)]) if np.isfinite(of_cut).any() else 0)
    return np.max(np.ptp(size, axis=0) - 0.01 * np.min(size, axis=0)) < ROUNDING


def curves_figure(title, methods, inclination, azimuth, error, sd, table, given):
    wrong = bool(np.any(error[np.isfinite(error)] > ROUNDING))
    maps = [error, sd] if wrong else [sd]
    cuts = nearest_azimuths(azimuth, table)
    if table is None or given:  # a cut where all methods are alike is a sentence
        alike = [j for j in cuts if all(are_alike(values, j) for values in maps)]
    else:
        alike = [] if wrong else [j for j in cuts if are_alike(sd, j)]
    alike = alike if len(alike) < len(cuts) else []
    cuts = [j for j in cuts if j not in alike]
    figure, grid = drawing.panels(len(maps) * len(cuts), (3.9, 2.9), columns=len(cuts), sharex=True)
    grid = np.reshape(grid, (len(maps), len(cuts)))
    drawn = None  # points of Monte Carlo: there may be none at the azimuths of the maps
    for column, j in zip(grid.T, cuts):
        for axes, values in zip(column, maps):
            for k, m in enumerate(methods):
                look = {key: v for key, v in LOOK[m].items() if key != "marker"}
                y = values[k][:, j]
                axes.plot(inclination, np.where(np.isfinite(y) & (y > ROUNDING), y, np.nan), **look)
            if not np.any(np.isfinite(values[:, :, j]) & (values[:, :, j] > ROUNDING)):
                axes.text(0.5, 0.5, "no error at this azimuth", transform=axes.transAxes, ha="center", color="#555555")
        column[0].set_title(f"Magnetic azimuth {azimuth[j]:g}{DEGREE}")
        column[-1].set_xlabel(f"Inclination ({DEGREE})")
        column[-1].xaxis.set_major_locator(MultipleLocator(30 if np.ptp(inclination) > 90 else 15))
        column[-1].set_xlim(min(inclination), max(inclination))
        if table is None or given:
            continue
        for k, m in enumerate(methods):
            rows = table.where(lambda i: table["formulation"][i] == m and table["quantity"][i] == "azimuth"
                               and abs(table["magnetic_azimuth_deg"][i] - azimuth[j]) < 1e-9)
            if not np.any(np.isfinite(rows["monte_carlo"])):
                continue
            y = rows["monte_carlo"]
            drawn = table
            column[-1].errorbar(rows["inclination_deg"], y, yerr=[np.maximum(y - rows["monte_carlo_ci_low"], 0),
                                                                 np.maximum(rows["monte_carlo_ci_high"] - y, 0)],
                               color=LOOK[m]["color"], marker=LOOK[m]["marker"], linestyle="none", markersize=4.5,
                               markerfacecolor="white", zorder=4)
    for row, values in zip(grid, maps):
        finite = values[np.isfinite(values) & (values > ROUNDING)]
        low = max(1e-3, np.percentile(finite, 5) / 1.3) if finite.size else 1e-3
        high = min(MOST, np.max(finite) * 1.3) if finite.size else MOST
        for axes in row:
            axes.set_yscale("log")
            axes.set_ylim(low, high)
            drawing.plain_log_axis(axes.yaxis, low, high)
            axes.label_outer()
    if wrong:
        grid[0][0].set_ylabel(f"|error| of the azimuth ({DEGREE})")
    grid[-1][0].set_ylabel(f"sd of the azimuth ({DEGREE})")
    handles = [Line2D([], [], **{k: v for k, v in LOOK[m].items() if k != "marker"}) for m in methods]
    text = ("Above: error by the constant errors. Below: s" if wrong else "S") + "tandard deviation, first order"
    if drawn is not None:
        handles.append(Line2D([], [], color="#444444", marker="o", markerfacecolor="white", linestyle="none",
                              label=f"Monte Carlo, {100 * table.confidence:g} % interval"))
        text += f"; points: Monte Carlo, {wording.counts_text(table['trials'])} trials"
    text += "".join(f". At magnetic azimuth {azimuth[j]:g}{DEGREE} all methods are alike: "
                    + ("no error, " if wrong else "") + f"at least {wording.number(np.nanmin(sd[:, :, j]), 2)}{DEGREE}" for j in alike)
    drawing.heading(figure, title, text + (". Where cos I = 0 the simple correction has no solution." if "simple" in methods else "."))
    drawing.legend_below(figure, handles)
    return figure


def main():
    parser = saving.argument_parser(__doc__.splitlines()[0])
    parser.add_argument("--point", type=int, help="of a sweep: which point, from 0")
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, "axial_correction") as file:
        title = wording.title_of(file)
        config = reading.configuration(file)
        methods, inclination, azimuth, error, sd, table, where, points = read(file, arguments.point or 0)
    if points > 1:
        title += f" ({where})"
    given = "given" in where or config.get("monte_carlo", {}).get("axial_magnetisation") == "given"
    folder = saving.figures_folder(arguments.output, arguments.result)
    stem = saving.stem_of(arguments.result)
    if points > 1:
        stem += f"_point{arguments.point or 0}"
    if len(inclination) < 2:
        raise PlotError(f"{arguments.result}: a single inclination: nothing to draw")
    if len(azimuth) > 3:
        saving.save(maps_figure(title, methods, inclination, azimuth, error, sd), folder, stem + "_maps")
    saving.save(curves_figure(title, methods, inclination, azimuth, error, sd, table, given), folder,
                  stem + "_curves")
