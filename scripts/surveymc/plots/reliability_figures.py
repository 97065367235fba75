"""Panels and figures of reliability maps, for surveymc plot reliability."""
import os
import re

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from . import drawing, reading, wording

TITLES = {"inclination": "inclination (°)", "toolface": "toolface τ (°)", "magnetic_azimuth": "magnetic azimuth (°)",
          "dip": "dip (°)", "noise_scale": "noise scale"}
NAMES = {"gx": "$g_x$", "gy": "$g_y$", "gz": "$g_z$", "bx": "$b_x$", "by": "$b_y$", "bz": "$b_z$", "gravity": "G",
         "total_field": "B", "dip": "Θ"}
UNITS = {"mps2": "m/s²", "nT": "nT", "deg": "°", "1": "sd", "mixed": ""}
LINES = ["-", (0, (7, 2)), (0, (3.5, 2)), (0, (1, 1.3)), (0, (7, 2, 1, 2)), (0, (3, 1, 1, 1, 1, 1))]
COLOURS = ["#0072B2", "#D55E00", "#222222", "#A8508A", "#009E73", "#777777"]


class Grid:
    """A map with its axes by name; `slice()` takes one value of some of them."""

    def __init__(self, file, name):
        if f"maps/{name}" not in file:
            raise reading.PlotError(f"{file.filename}: has no map '{name}'")
        data = file[f"maps/{name}"]
        self.name, self.values = name, data[()]
        self.unit = reading.text_attribute(data, "units")
        self.axes = {}
        for dimension in data.dims:
            scale = dimension[0]
            text = scale.dtype.kind == "O"
            self.axes[os.path.basename(scale.name)] = list(scale.asstr()[()]) if text else scale[()]

    def slice(self, chosen):
        index = tuple(chosen.get(name, slice(None)) for name in self.axes)
        return self.values[index]


def levels_of(sizes, count=7, highest=0.97):
    """Round levels that follow the distribution: contours where the map has its values, on a logarithmic scale."""
    finite = sizes[np.isfinite(sizes) & (sizes > 0)]
    if finite.size == 0:
        return np.array([0.5, 1.0])
    low, high = np.quantile(finite, [0.02, highest])
    if high <= low * (1 + 1e-6):  # the same everywhere: a level at its value would draw lines through rounding errors
        return np.array([float(f"{low * f:.2e}") for f in (0.99, 1.01)])
    raw = np.geomspace(max(low, high / 1e3), max(high, low * 1.01), count)
    digits = 2 if high / low > 3 else 3
    return np.unique([float(f"{x:.{digits - 1}e}") for x in raw])


def axis_title(name):
    return TITLES.get(name) or wording.axis_name(name)


def frame(axes, x, y, names, title):
    axes.set_xlim(min(x), max(x))
    axes.set_ylim(min(y), max(y))
    axes.set_xlabel(axis_title(names[1]))
    axes.set_ylabel(axis_title(names[0]))
    for set_ticks, values in ((axes.set_xticks, x), (axes.set_yticks, y)):
        if np.ptp(values) in (90, 180, 360):
            set_ticks(np.linspace(min(values), max(values), 7))
    axes.set_title(title, fontsize=9)


def panel(axes, x, y, sizes, names, title, tolerance=None, levels=None):
    """Filled contours of sizes on a logarithmic scale, infinite ones hatched."""
    levels = levels_of(sizes) if levels is None else levels
    tiny = levels[0] / 1e3  # zeros have no place on a logarithmic scale
    shown = np.where(np.isfinite(sizes), np.maximum(sizes, tiny), np.nan)
    filled = axes.contourf(x, y, shown, levels=levels, cmap="cividis", extend="both",
                           norm=matplotlib.colors.LogNorm(levels[0] / 1.5, levels[-1] * 1.5))
    if np.any((np.nanmin(shown) < levels) & (levels < np.nanmax(shown))):
        lines = axes.contour(x, y, shown, levels=levels, colors="white", linewidths=0.5)
        drawing.label_contours(axes, lines, lambda v: f"{v:g}")
    for collection in filled.collections:
        collection.set_edgecolor("face")
    if tolerance is not None and np.nanmin(shown) < tolerance < np.nanmax(shown):
        axes.contour(x, y, shown, levels=[tolerance], colors="#D55E00", linewidths=1.6, linestyles="dashed")
    infinite = np.argwhere(~np.isfinite(sizes))
    if len(infinite) > 0:  # a patch of at least 2 % of the panel around each point, or single points would not be seen
        wide, high = 0.02 * np.ptp(x), 0.02 * np.ptp(y)
        for i, j in infinite:
            axes.add_patch(matplotlib.patches.Rectangle(
                (x[j] - wide, y[i] - high), 2 * wide, 2 * high, hatch="/////", facecolor="white", edgecolor="#B00020",
                linewidth=0.8, zorder=3))
    frame(axes, x, y, names, title)
    return filled


def colour_bar(figure, filled, axes, levels, unit):
    """The scale of contours that `panel` has filled, for one panel or several. unit: of the sizes."""
    bar = figure.colorbar(filled, ax=axes, ticks=levels, shrink=0.9, pad=0.02, format=lambda v, _: f"{v:g}")
    bar.ax.minorticks_off()
    bar.set_label(unit)


def named(axis, value):
    if axis not in TITLES:  # a key of the sweep
        return wording.point_name([axis], [value])
    title = TITLES[axis]
    return f"{title.split(' (')[0]} {value:g}" + ("°" if "°" in title else "")


def unit_of(grid, observation):
    if grid.unit not in ("mixed", ""):
        return UNITS.get(grid.unit, grid.unit)
    return {"g": "m/s²", "b": "nT"}.get(observation[0], "nT") if observation not in ("gravity", "dip") else \
        {"gravity": "m/s²", "dip": "°"}[observation]


def subject_name(name):
    """What the error is in, for a reader: an observation, or a combination such as "0.8 bx - 0.6 bz"."""
    return re.sub(r"[a-z_]+", lambda word: NAMES.get(word[0], word[0]), name)


def plane_of(grid, names):
    return (np.asarray(grid.axes[n], float) for n in (names[1], names[0]))


def nonlinear_figure(title, grids, names, rows, observation_of, differs=None):
    """Detectable errors on the same levels: linear, and without linearisation for both signs, by the general test and,
    if there, by the reading's own. `differs`: where linear theory is off, as a line in the linear panel."""
    words = ["linear", "general test, positive", "general test, negative", "own test, positive", "own test, negative"]
    words = words[:len(grids)]
    figure, panels = plt.subplots(len(rows), len(grids), figsize=(3.8 * min(len(grids), 3) + 2.6 * max(len(grids) - 3, 0),
                                                                  3.4 * len(rows) + 0.7),
                                  squeeze=False, layout="constrained")
    x, y = plane_of(grids[0], names)
    for row, (suffix, chosen) in zip(panels, rows):
        observation = observation_of(chosen)
        sizes = [np.abs(g.slice(chosen)) for g in grids]
        levels = levels_of(np.concatenate([s.ravel() for s in sizes]), 8, 0.995)
        for axes, size, word in zip(row, sizes, words):
            filled = panel(axes, x, y, size, names, f"{NAMES[observation]}, {word}" + (f"\n{suffix}" if suffix else ""), levels=levels)
        colour_bar(figure, filled, list(row), levels, unit_of(grids[0], observation))
        if differs is not None:
            wrong = differs.slice(chosen)
            if 0 < np.mean(wrong) < 1:
                row[0].contour(x, y, wrong if wrong.shape == (len(y), len(x)) else wrong.T, [0.5], colors="#D55E00",
                               linewidths=1.6)
    units = ", ".join(sorted({unit_of(grids[0], observation_of(chosen)) for _, chosen in rows}))
    line = "; inside the orange line linear theory is off by more than 20 %" if differs is not None else ""
    drawing.heading(figure, title, f"Minimal detectable errors ({units}); hatched: infinite (never detected){line}.")
    return figure


def direction_figure(title, grids, names, rows):
    """Entries of the weakest combination, a unit vector in standard deviations. An entry that is nearly 1 everywhere is a sentence."""
    shown, said = [], []
    for suffix, chosen in rows:
        for grid in grids:
            words = NAMES[grid.name.removeprefix("direction_")] + (f", {suffix}" if suffix else "")
            values = grid.slice(chosen)
            if np.ptp(values) < 0.12:
                said.append(f"{words}: {np.min(values):.2f} to {np.max(values):.2f} everywhere")
            else:
                shown.append((words, values))
    if not shown:
        return None
    figure, panels = drawing.panels(len(shown), (3.9, 3.3))
    x, y = plane_of(grids[0], names)
    levels = np.linspace(-1, 1, 21)
    for axes, (words, values) in zip(panels, shown):
        filled = axes.contourf(x, y, values, levels=levels, cmap="PuOr", extend="neither")
        for collection in filled.collections:
            collection.set_edgecolor("face")
        frame(axes, x, y, names, words)
    figure.colorbar(filled, ax=panels, label="entry of the unit vector (sd)", shrink=0.8, ticks=levels[::4])
    drawing.heading(figure, title, "Errors of these sizes, in standard deviations, at once show least. " + "; ".join(said) + ("." if said else ""))
    return figure


def unit_of_residual(observation):
    """Unit of an observation in the names of maps."""
    return {"total_field": "nT", "dip": "deg"}.get(observation) or {"g": "mps2", "b": "nT"}[observation[0]]


def residual_curves(axes, x, residuals, chosen, unit):
    """Sizes of the residuals; returns (label, sizes) of each curve. Its sign is in the label."""
    factor = 100 if unit == "mps2" else 1  # Gal, as the paper
    curves = []
    for k, grid in enumerate(residuals):
        values = factor * grid.slice(chosen).ravel()
        observation = re.sub("^residual_|_[^_]+$", "", grid.name)
        symbol = {"gravity": "e_G", "total_field": "e_B", "dip": "e_\\Theta"}.get(observation) or f"e_{observation[1]}"
        rounding = 1e-9 * np.max(np.abs(values))
        sign = "" if np.all(values >= -rounding) else "-" if np.all(values <= rounding) else None
        label = f"${sign}{symbol}$" if sign is not None else f"$|{symbol}|$"
        sizes = np.abs(values)
        axes.plot(x, sizes, color=COLOURS[k % 6], linestyle=LINES[k % 6], label=label)
        curves.append((label, sizes))
    return curves


def residuals_figure(title, residuals, effect, effect_name, sizes, plane, rows, observation_of):
    """Residuals that a gross error causes (left axis) and its effect (right axis): figure 1 of the paper. `residuals`
    and `sizes` by unit."""
    figure, panels = plt.subplots(1, len(rows), figsize=(4.6 * len(rows) + 0.6, 4.3), squeeze=False,
                                  layout="constrained")
    x = np.asarray(effect.axes[plane], float)
    for axes, (suffix, chosen) in zip(panels[0], rows):
        observation = observation_of(chosen)
        unit = unit_of_residual(observation)
        shown = "Gal" if unit == "mps2" else UNITS[unit]
        curves = residual_curves(axes, x, residuals[unit], chosen, unit)
        if len(curves) > 1:  # where the residual of the observation in error passes the first other one
            own = next((k for k, g in enumerate(residuals[unit]) if g.name.startswith(f"residual_{observation}_")), 0)
            other = next(k for k in range(len(curves)) if k != own)
            difference = curves[own][1] - curves[other][1]
            for i in np.flatnonzero(difference[1:] * difference[:-1] < 0):
                part = difference[i] / (difference[i] - difference[i + 1])
                at = x[i] + part * (x[i + 1] - x[i])
                level = curves[own][1][i] + part * (curves[own][1][i + 1] - curves[own][1][i])
                if level < 1e-3 * np.max(curves[own][1]):  # both vanish there
                    continue
                axes.plot(at, level, "o", color="#222222", markersize=5, zorder=4)
                axes.annotate(f"{at:.2f}°", (at, level), xytext=(5, 6), textcoords="offset points", fontsize=9)
        right = axes.twinx()
        right.spines["right"].set_visible(True)
        right.grid(False)
        values = np.abs(effect.slice(chosen)).ravel()
        right.plot(x, np.where(np.isfinite(values), values, np.nan), color="#777777", linestyle=LINES[4],
                   label=f"{effect_name} (right)")
        for side in (axes, right):
            side.set_ylim(bottom=0, top=side.get_ylim()[1] * 1.25)  # room for the legend
        axes.set_xlim(min(x), max(x))
        if np.ptp(x) in (90, 180):
            axes.set_xticks(np.linspace(min(x), max(x), 7))
        axes.set_xlabel(axis_title(plane))
        axes.set_ylabel(f"residual ({shown})")
        right.set_ylabel(f"error of the {effect_name} (°)")
        suffix = ", ".join(w for w in suffix.split(", ") if w != NAMES[observation])
        size = sizes[unit] * (100 if unit == "mps2" else 1)
        axes.set_title(f"error of {size:g} {shown} in {NAMES[observation]}" + (f"\n{suffix}" if suffix else ""), fontsize=9)
        lines = [*axes.get_lines(), *right.get_lines()]
        lines = [line for line in lines if not line.get_label().startswith("_")]
        axes.legend(lines, [line.get_label() for line in lines], fontsize=8, loc="upper center", ncols=len(lines),
                    columnspacing=1, handlelength=2.2, handletextpad=0.5)
    drawing.heading(figure, title, "Residuals that the error causes, and what it does to the angle.")
    return figure
