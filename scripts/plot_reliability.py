#!/usr/bin/python3
"""Figures of a reliability map: minimal detectable error beside its effect, PNG and SVG next to the result.

    plot_reliability.py RESULT.h5 [-o FOLDER] [--observation NAME] [--effect azimuth|inclination|toolface]

Two axes with more than one value: filled contours with labelled levels, one row of panels for each value of what varies
besides; hatched where the error is never detected (infinite), a dashed line where the effect passes the tolerance. One
such axis: curves, their breaking points marked (where the effect passes the tolerance).
"""
import itertools
import os

import numpy as np

import plotting
from plotting import plt

TITLES = {"inclination": "inclination (°)", "toolface": "toolface τ (°)", "magnetic_azimuth": "magnetic azimuth (°)",
          "dip": "dip (°)", "noise_scale": "noise scale"}
NAMES = {"gx": "$g_x$", "gy": "$g_y$", "gz": "$g_z$", "bx": "$b_x$", "by": "$b_y$", "bz": "$b_z$", "gravity": "G",
         "total_field": "B", "dip": "Θ"}
UNITS = {"mps2": "m/s²", "nT": "nT", "deg": "°", "1": "", "mixed": ""}
MAXIMUM_ROWS = 6
LINES = ["-", (0, (7, 2)), (0, (3.5, 2)), (0, (1, 1.3)), (0, (7, 2, 1, 2)), (0, (3, 1, 1, 1, 1, 1))]
COLOURS = ["#0072B2", "#D55E00", "#222222", "#A8508A", "#009E73", "#777777"]


class Grid:
    """A map with its axes by name; `slice()` takes one value of some of them."""

    def __init__(self, file, name):
        if f"maps/{name}" not in file:
            raise plotting.PlotError(f"{file.filename}: has no map '{name}'")
        data = file[f"maps/{name}"]
        self.name, self.values = name, data[()]
        self.unit = plotting.text_attribute(data, "units")
        self.axes = {}
        for dimension in data.dims:
            scale = dimension[0]
            text = scale.dtype.kind == "O"
            self.axes[os.path.basename(scale.name)] = list(scale.asstr()[()]) if text else scale[()]

    def slice(self, chosen):
        index = tuple(chosen.get(name, slice(None)) for name in self.axes)
        return self.values[index]


def levels_of(sizes, count=7):
    """Round levels that follow the distribution: contours where the map has its values, on a logarithmic scale."""
    finite = sizes[np.isfinite(sizes) & (sizes > 0)]
    if finite.size == 0:
        return np.array([0.5, 1.0])
    low, high = np.quantile(finite, [0.02, 0.97])
    raw = np.geomspace(max(low, high / 1e3), max(high, low * 1.01), count)
    digits = 2 if high / low > 3 else 3
    return np.unique([float(f"{x:.{digits - 1}e}") for x in raw])


def panel(axes, x, y, sizes, names, title, tolerance=None):
    levels = levels_of(sizes)
    tiny = levels[0] / 1e3  # zeros have no place on a logarithmic scale
    shown = np.where(np.isfinite(sizes), np.maximum(sizes, tiny), np.nan)
    filled = axes.contourf(x, y, np.clip(shown, None, levels[-1] * 10), levels=np.append(levels, levels[-1] * 10.1),
                           norm=plotting.matplotlib.colors.LogNorm(levels[0] / 1.5, levels[-1] * 1.5), cmap="cividis",
                           extend="min")
    lines = axes.contour(x, y, shown, levels=levels, colors="white", linewidths=0.5)
    labels = axes.clabel(lines, fmt=lambda v: f"{v:g}", fontsize=7, inline_spacing=2)
    for label in labels:
        label.set_path_effects([plotting.matplotlib.patheffects.withStroke(linewidth=1.5, foreground="#333333")])
    for collection in filled.collections:
        collection.set_edgecolor("face")
    if tolerance is not None and np.nanmin(shown) < tolerance < np.nanmax(shown):
        axes.contour(x, y, shown, levels=[tolerance], colors="#D55E00", linewidths=1.6, linestyles="dashed")
    infinite = np.argwhere(~np.isfinite(sizes))
    if len(infinite) > 0:  # a patch of at least 2 % of the panel around each point, or single points would not be seen
        wide, high = 0.02 * np.ptp(x), 0.02 * np.ptp(y)
        for i, j in infinite:
            axes.add_patch(plotting.matplotlib.patches.Rectangle(
                (x[j] - wide, y[i] - high), 2 * wide, 2 * high, hatch="/////", facecolor="white", edgecolor="#B00020",
                linewidth=0.8, zorder=3))
    axes.set_xlim(min(x), max(x))
    axes.set_ylim(min(y), max(y))
    axes.set_xlabel(TITLES.get(names[1], names[1]))
    axes.set_ylabel(TITLES.get(names[0], names[0]))
    for set_ticks, values in ((axes.set_xticks, x), (axes.set_yticks, y)):
        if np.ptp(values) in (90, 180, 360):
            set_ticks(np.linspace(min(values), max(values), 7))
    axes.set_title(title, fontsize=9)


def named(axis, value):
    title = TITLES.get(axis, axis)
    return f"{title.split(' (')[0]} {value:g}" + ("°" if "°" in title else "")


def unit_of(grid, observation):
    if grid.unit not in ("mixed", ""):
        return UNITS.get(grid.unit, grid.unit)
    return {"g": "m/s²", "b": "nT"}.get(observation[0], "nT") if observation not in ("gravity", "dip") else \
        {"gravity": "m/s²", "dip": "°"}[observation]


def maps_figure(title, detectable, effect, names, rows, observation_of, effect_name, tolerance):
    figure, grid = plt.subplots(len(rows), 2, figsize=(8.4, 3.5 * len(rows) + 0.7), squeeze=False,
                                layout="constrained")
    x, y = (np.asarray(detectable.axes[n], float) for n in (names[1], names[0]))
    for row, (words, chosen) in zip(grid, rows):
        observation = observation_of(chosen)
        suffix = f"\n{words}" if words else ""
        panel(row[0], x, y, np.abs(detectable.slice(chosen)), names,
              f"minimal detectable error of {NAMES[observation]} ({unit_of(detectable, observation)}){suffix}")
        panel(row[1], x, y, np.abs(effect.slice(chosen)), names, f"its effect on the {effect_name} (°){suffix}", tolerance)
    notes = "hatched: infinite (never detected, or the angle has no value)"
    if tolerance is not None:
        notes += f"; dashed: tolerance {tolerance:g}°"
    figure.suptitle(f"{title}\n{notes}", fontsize=10)
    return figure


def curves_figure(title, detectable, effect, name, rows, observation_of, effect_name, tolerance):
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.8, 4.1), layout="constrained")
    x = np.asarray(detectable.axes[name], float)
    units = set()
    for k, (words, chosen) in enumerate(rows):
        observation = observation_of(chosen)
        units.add(unit_of(detectable, observation))
        look = {"color": COLOURS[k % 6], "linestyle": LINES[k % 6], "label": words or NAMES[observation]}
        for axes, grid in ((left, detectable), (right, effect)):
            values = np.abs(grid.slice(chosen)).ravel()
            axes.plot(x, np.where(np.isfinite(values), values, np.nan), **look)
        values = np.abs(effect.slice(chosen)).ravel()
        for i in range(1, len(x)):
            if tolerance is not None and np.all(np.isfinite(values[i - 1:i + 1])) and \
                    (values[i - 1] <= tolerance) != (values[i] <= tolerance):
                at = x[i - 1] + (x[i] - x[i - 1]) * (tolerance - values[i - 1]) / (values[i] - values[i - 1])
                right.plot(at, tolerance, "o", color=look["color"], markersize=5, zorder=4)
                right.annotate(f"{plotting.number(at, 4)}°", (at, tolerance), xytext=(-4, 5 + 11 * (k % 2)), ha="right",
                               textcoords="offset points", fontsize=7.5, color=look["color"],
                               path_effects=[plotting.matplotlib.patheffects.withStroke(linewidth=2.5, foreground="white")])
    left.set_ylabel(f"minimal detectable error ({', '.join(sorted(units))})")
    right.set_ylabel(f"effect on the {effect_name} (°)")
    for axes, grid in ((left, detectable), (right, effect)):
        shown = np.abs(grid.values[np.isfinite(grid.values)])
        shown = shown[shown > 0]
        if shown.size and shown.max() > 30 * np.median(shown):  # a pole: show what lies below
            axes.set_ylim(0, 8 * np.median(shown))
        else:
            axes.set_ylim(bottom=0)
        axes.set_xlim(min(x), max(x))
        axes.set_xlabel(TITLES.get(name, name))
    if tolerance is not None:
        right.axhline(tolerance, color="#777777", linewidth=0.8)
        right.set_ylim(0, max(5 * tolerance, 1e-12))
    left.legend(fontsize=8)
    figure.suptitle(title + ("" if tolerance is None else
                             f"\npoints: where the effect passes the tolerance of {tolerance:g}°"),
                    fontsize=10)
    return figure


def main():
    parser = plotting.argument_parser(__doc__.splitlines()[0])
    parser.add_argument("--observation", help="of a map of several, only this one")
    parser.add_argument("--effect", choices=["azimuth", "inclination", "toolface"],
                        help="default: inclination for accelerometers and gravity, azimuth otherwise")
    arguments = parser.parse_args()
    plotting.use_style()
    with plotting.open_result(arguments.result, "reliability_map") as file:
        config = plotting.configuration(file)
        title = plotting.text_attribute(file, "title")
        detectable = Grid(file, "minimal_detectable_error")
        configured = config.get("observation", "bx")
        first = arguments.observation or (configured if isinstance(configured, str) else configured[0])
        effect_name = arguments.effect or ("inclination" if first[0] == "g" else "azimuth")
        effect = Grid(file, f"external_{effect_name}_deg")
    tolerance = config.get("tolerance", {}).get(f"{effect_name}_deg")

    observations = detectable.axes.get("observation")
    known = observations or ([configured] if isinstance(configured, str) else configured)
    if arguments.observation and arguments.observation not in known:
        raise plotting.PlotError(f"--observation {arguments.observation}: not in {arguments.result}", plotting.USAGE)
    wide = [n for n in ("noise_scale", "dip", "inclination", "toolface", "magnetic_azimuth")
            if len(detectable.axes.get(n, [0])) > 1]
    plane = wide[-2:] if len(wide) > 1 and len(detectable.axes[wide[-2]]) > 3 else wide[-1:]
    if not plane:
        raise plotting.PlotError(f"{arguments.result}: a single point: nothing to draw")
    others = [n for n in detectable.axes if n not in plane]
    choices = [range(len(detectable.axes[n])) for n in others]
    if observations and arguments.observation:
        choices[others.index("observation")] = [observations.index(arguments.observation)]
    rows = []
    for picked in itertools.product(*choices):
        words = [str(detectable.axes[n][i]) if isinstance(detectable.axes[n], list) else
                 named(n, detectable.axes[n][i])
                 for n, i in zip(others, picked) if len(detectable.axes[n]) > 1 and n != "observation"]
        if observations and len(observations) > 1 and len(plane) == 1:
            words.insert(0, NAMES[observations[picked[others.index("observation")]]])
        rows.append((", ".join(words), dict(zip(others, picked))))
    if len(rows) > MAXIMUM_ROWS * (1 if len(plane) == 2 else 2):
        raise plotting.PlotError(f"{arguments.result}: {len(rows)} panels: choose with --observation, or map fewer values",
                                 plotting.USAGE)

    def observation_of(chosen):
        return observations[chosen["observation"]] if observations else known[0]

    draw = maps_figure if len(plane) == 2 else curves_figure
    figure = draw(title, detectable, effect, plane if len(plane) == 2 else plane[0], rows, observation_of, effect_name,
                  tolerance)
    folder = plotting.figures_folder(arguments.output, arguments.result)
    plotting.save(figure, folder, os.path.splitext(os.path.basename(arguments.result))[0] + f"_{effect_name}")


if __name__ == "__main__":
    import matplotlib.patheffects  # noqa: F401
    plotting.run(main)
