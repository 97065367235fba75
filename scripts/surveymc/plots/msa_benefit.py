"""Figures of an msa_benefit result: in which directions does MSA make a survey better, and where worse?

    surveymc plot msa_benefit RESULT.h5 [-o FOLDER]

<stem>_azimuth_ratio   sd of azimuth after MSA over that before, for every direction of the hole
<stem>_lateral_ratio   the same of the last position to the side of the hole
<stem>_order_needed    the order of prediction that this position needs, if the config has predictions beyond first order
<stem>_tails           with table `tails`: lateral errors after MSA beyond k sd against k, in the directions of [[verify]]
<stem>_tails_map       with a law of the reference: how many of them are beyond the k next to 3.5, for every direction

each as PNG and SVG, one panel for each point of the sweep. The thick line is the ratio 1: MSA changes nothing there.
"""

import os
import textwrap

import h5py
import numpy as np
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap, LogNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import drawing, order_map, reading, saving, tails, wording
from .reading import PlotError

SPANS = ("well.kind", "sensor.spread.axial_bias_nT", "estimator.name")  # keys of a sweep that has figures of its own here

LEVELS = (0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 5.0, 10.0)
QUANTITIES = (("azimuth_ratio", "Azimuth of the last station"),
              ("lateral_ratio", "Last position to the side of the hole"))
UNDETERMINED, UNCHANGED = "#777777", "#FFFFF0"
DEGREE = "\N{DEGREE SIGN}"
BEYOND = "lateral_after_beyond_"


def read_map(file, name):
    """The map as (values, list of (axis name, its values)), the sweep's dimensions first."""
    path = f"maps/{name}"
    if path not in file:
        raise PlotError(f"{file.filename}: has no map '{name}'")
    data = file[path]
    axes = []
    for dimension in data.dims:
        if len(dimension.values()) != 1:
            raise PlotError(f"{file.filename}: an axis of {path} has no values")
        scale = dimension[0]
        text = h5py.check_string_dtype(scale.dtype) is not None
        axes.append((os.path.basename(scale.name), list(scale.asstr()[()]) if text else scale[()]))
    if [a[0] for a in axes[-2:]] != ["inclination", "azimuth"]:
        raise PlotError(f"{file.filename}: {path} is no map over inclination and azimuth")
    if min(data.shape[-2:]) < 2:
        raise PlotError(f"{file.filename}: {path} is a line or a point: give inclination_deg and azimuth_deg two values")
    return data[()], axes


def panels_of(values, axes):
    """Rows and columns of panels: a list of rows, each a list of (title, map). The longest dimension goes down."""
    sweep = axes[:-2]
    grid = values.reshape(-1, *values.shape[-2:])
    shape = values.shape[:-2]
    names = []
    for index in np.ndindex(*shape):
        point = [(a[0], a[1][i]) for a, i in zip(sweep, index)]
        cases = [wording.point_name([k], [v]) for k, v in point if k == "case"]  # a line of its own
        others = [(k, v) for k, v in point if k != "case"]
        if others:
            cases.append(wording.point_name([k for k, _ in others], [v for _, v in others]))
        names.append("\n".join(cases))
    columns = 1 if not shape else min(shape, key=lambda n: n if n > 1 else 1000)
    if columns > 4 or columns == 1:  # one dimension: as square as it gets
        columns = int(np.ceil(np.sqrt(len(grid))))
        order = range(len(grid))
    else:
        across = [d for d in range(len(shape)) if shape[d] == columns][-1]
        order = np.moveaxis(np.arange(len(grid)).reshape(shape), across, -1).ravel()
    panels = [(names[i], grid[i]) for i in order]
    return [panels[i:i + columns] for i in range(0, len(panels), columns)]


def colours():
    """One colour a band: blue where MSA helps, orange and red where it harms. Also told apart by its lightness."""
    below, above = LEVELS.index(1.0) + 1, len(LEVELS) - LEVELS.index(1.0)
    blue = LinearSegmentedColormap.from_list("b", ["#08306B", "#2171B5", "#6BAED6", "#DEEBF7"])
    red = LinearSegmentedColormap.from_list("r", ["#FEEDDE", "#FDAE6B", "#E6550D", "#7F2704"])
    bands = [blue(i / (below - 1)) for i in range(below)] + [red(i / (above - 1)) for i in range(above)]
    return LinearSegmentedColormap.from_list("benefit", bands, N=len(bands))


def plateau(flat):
    """Points all of whose neighbours, and themselves, are flat: an area, and not where a slope passes through 1."""
    rows, columns = flat.shape
    around = np.pad(flat, 1, mode="edge")
    return np.all([around[r:r + rows, c:c + columns] for r in range(3) for c in range(3)], axis=0)


def draw_panel(ax, title, ratio, inclination, azimuth, width):
    ax.set_title("\n".join(line for part in title.split("\n") for line in textwrap.wrap(part, width)), fontsize=8.5)
    ax.set_facecolor(UNDETERMINED)
    ax.grid(False)
    shown = np.ma.masked_invalid(np.where(np.isfinite(ratio), np.clip(ratio, LEVELS[0] * 0.5, LEVELS[-1] * 2), np.nan))
    cmap = colours()
    levels = np.log(LEVELS)  # ratios: linear in the logarithm between the points of the map
    norm = BoundaryNorm(levels, cmap.N, extend="both")
    image = None
    if shown.count() > 0:
        shown = np.ma.log(shown)
        image = ax.contourf(azimuth, inclination, shown, levels=levels, cmap=cmap, norm=norm, extend="both")
        inside = [v for v in levels if v != 0 and shown.min() < v < shown.max()]
        if inside:
            thin = ax.contour(azimuth, inclination, shown, levels=inside, colors="black", linewidths=0.4,
                              linestyles="solid")
            drawing.label_contours(ax, thin, lambda v: f"{np.exp(v):.2g}", "black", "white", 6.5)
        # Where MSA cannot change anything the ratio is 1 but for a per mille: a plain area, and no line in it.
        ax.contourf(azimuth, inclination, shown, levels=np.log([0.99, 1.01]), colors=[UNCHANGED])
        line = np.ma.masked_where(plateau(np.abs(shown.filled(np.inf)) < 1e-3), shown)
        if line.count() > 0 and line.min() < 0 < line.max():
            ax.contour(azimuth, inclination, line, levels=[0.0], colors="black", linewidths=2.2)
    else:
        ax.text(0.5, 0.5, "not determined\nin any direction", transform=ax.transAxes, ha="center", va="center",
                color="white", fontsize=9, fontweight="bold")
    ax.set_xlim(azimuth[0], azimuth[-1])
    ax.set_ylim(inclination[0], inclination[-1])
    span = azimuth[-1] - azimuth[0]
    ax.set_xticks(np.arange(azimuth[0], azimuth[-1] + 1e-9, 45 if span > 90 else span / 4 or 1))
    ax.set_yticks(np.arange(inclination[0], inclination[-1] + 1e-9, 45 if inclination[-1] - inclination[0] > 90 else 15))
    return image


def figure_of(title, meaning, values, axes):
    rows = panels_of(values, axes)
    columns, shown = len(rows[0]), sum(rows, [])
    figure, grid = drawing.panels(len(shown), (3.1, 2.4), columns=columns, sharex=True, sharey=True)
    image = None
    for ax, (name, ratio) in zip(grid, shown):
        drawn = draw_panel(ax, name, ratio, axes[-2][1], axes[-1][1], width=40)
        image = drawn if drawn is not None else image
    for ax in grid[-columns:]:
        ax.set_xlabel(f"azimuth ({DEGREE})")
        ax.xaxis.set_tick_params(labelbottom=True)
    for ax in grid[::columns]:
        ax.set_ylabel(f"inclination ({DEGREE})")
    if image is not None:
        bar = figure.colorbar(image, ax=grid, ticks=np.log(LEVELS), aspect=30, shrink=min(1, 2.2 / len(rows)))
        bar.ax.set_yticklabels([f"{v:g}" for v in LEVELS])
        bar.set_label("sd after MSA / sd before")
    drawing.heading(figure, title, f"{meaning}: below 1 (blue) MSA helps, for every direction of the last station.")
    drawing.legend_below(figure, [Line2D([], [], color="black", linewidth=2.2, label="ratio 1"),
                                  Patch(facecolor=UNCHANGED, edgecolor="black", linewidth=0.5, label="within 1 %"),
                                  Patch(color=UNDETERMINED, label="MSA not determined")])
    return figure


def tails_map(title, k, values, axes):
    """Percent of lateral errors after MSA beyond k predicted sd; None where all are as many as of a normal distribution."""
    normal = 100 * tails.normal_tail(k)[0]
    rows = panels_of(100 * values, axes)
    columns, shown = len(rows[0]), sum(rows, [])
    highest = float(np.nanmax(100 * values, initial=0))
    if highest < 1.001 * normal:
        return None
    figure, grid = drawing.panels(len(shown), (3.1, 2.4), columns=columns, sharex=True, sharey=True)
    for ax, (name, percent) in zip(grid, shown):
        ax.set_title(name, fontsize=8.5)
        ax.set_facecolor(UNDETERMINED)
        ax.grid(False)
        image = ax.pcolormesh(axes[-1][1], axes[-2][1], np.ma.masked_invalid(percent), cmap="magma_r", shading="nearest",
                              norm=LogNorm(normal, highest))
    for ax in grid[-columns:]:
        ax.set_xlabel(f"azimuth ({DEGREE})")
    for ax in grid[::columns]:
        ax.set_ylabel(f"inclination ({DEGREE})")
    figure.colorbar(image, ax=grid, aspect=30, shrink=min(1, 2.2 / len(rows))).set_label(f"percent beyond {k:g} sd")
    drawing.heading(figure, title, f"Lateral errors after MSA beyond {k:g} predicted sd, by the laws of the reference; of a normal "
                    f"distribution {normal:.3g} %.")
    return figure


def main():
    arguments = saving.argument_parser(__doc__.splitlines()[0]).parse_args()
    drawing.use_style()
    stem = saving.stem_of(arguments.result)
    with reading.open_result(arguments.result, "msa_benefit") as file:
        title = wording.title_of(file)
        maps = [(name, meaning, *read_map(file, name)) for name, meaning in QUANTITIES]
        orders = read_map(file, "order_needed") if "maps/order_needed" in file else None
        beyond = reading.read_table(file, "tails")
        keys = [] if beyond is None else reading.sweep_keys(reading.configuration(file), beyond)
        # By a prediction: beside a disturbance that is not normal there is none.
        ks = [float(name.removeprefix(BEYOND)) for name in file["maps"] if name.startswith(BEYOND)]
        k = min(ks, key=lambda k: abs(k - tails.RULE), default=None)
        tail_map = None if k is None else read_map(file, f"{BEYOND}{k:g}")
    folder = saving.figures_folder(arguments.output, arguments.result)
    for name, meaning, values, axes in maps:
        saving.save(figure_of(title, meaning, values, axes), folder, f"{stem}_{name}")
    if orders is not None:
        values, axes = orders
        saving.save(order_map.figure(title, "the last position to the side of the hole", panels_of(values, axes), axes[-2][1], axes[-1][1]),
                    folder, f"{stem}_order_needed")
    figures = {}
    if beyond is not None:
        figures["tails"] = tails.coverage_figure(title, beyond, [*keys, "inclination_deg", "azimuth_deg"], "lateral_after",
                                                errors="Lateral errors after MSA")
    if tail_map is not None:
        figures["tails_map"] = tails_map(title, k, *tail_map)
    for name, figure in figures.items():
        if figure is not None:
            saving.save(figure, folder, f"{stem}_{name}")
