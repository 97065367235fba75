"""The map of a refined sweep: cells of uneven size, coloured by the quantity of [refine], and the boundary.

    surveymc plot refined RESULT.h5 [-o FOLDER]

RESULT.h5 is a merged result of all rounds (scripts/slurm/refine.sh). One panel for each value of the keys that [refine] does
not divide; two axes. A cell is drawn where a rectangle has no point inside it, in the mean colour of its corners; the black line
is the boundary between the points.
"""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import TwoSlopeNorm
from matplotlib.tri import Triangulation

from . import drawing, reading, saving, wording
from .reading import PlotError

SPANS = True  # keys of a sweep that has figures of its own here


def read(path):
    """title, rule, axes, other keys, their values by name, the quantity: of the rows that [refine] looks at."""
    with reading.open_any(path) as file:
        rule, title = reading.configuration(file).get("refine"), wording.title_of(file)
        if not rule or "quantity" not in rule:
            raise PlotError(f"{path}: its config has no [refine] with a quantity")
        name, column = rule["quantity"].split(".", 1)
        table = reading.read_table(file, name)
        if table is None or column not in table:
            raise PlotError(f"{path}: has no {rule['quantity']}")
        chosen = np.ones(table.rows, bool)
        for key, word in rule.get("where", {}).items():
            chosen &= np.array(table[key]) == word
        keys = [k for k in table if reading.text_attribute(file[f"tables/{name}/{k}"], "long_name") == "sweep key"]
    axes = sorted(rule.get("axes") or rule.get("grid", []))
    if len(axes) != 2:
        raise PlotError(f"{path}: [refine] divides {len(axes)} axes, this draws 2")
    values = {k: np.array(table[k])[chosen] for k in keys}
    rule.setdefault("grid", {a: sorted(set(values[a])) for a in axes})  # a first round
    return title, rule, axes, [k for k in keys if k not in axes], values, np.array(table[column])[chosen]


def cells_of(x, y, grid):
    """Leaf rectangles (x0, x1, y0, y1) of the cells of `grid`, halved where points lie inside. Midpoints that `refine` has inferred
    are no points: there a cell is drawn larger than it was looked at."""
    leaves = []
    stack = [(grid[0][i], grid[0][i + 1], grid[1][j], grid[1][j + 1], np.arange(len(x)))
             for i in range(len(grid[0]) - 1) for j in range(len(grid[1]) - 1)]
    while stack:
        x0, x1, y0, y1, near = stack.pop()
        near = near[(x[near] >= x0) & (x[near] <= x1) & (y[near] >= y0) & (y[near] <= y1)]
        tiny = 1e-9 * (x1 - x0), 1e-9 * (y1 - y0)
        inside = (x[near] > x0 + tiny[0]) & (x[near] < x1 - tiny[0]) & (y[near] > y0 + tiny[1]) & (y[near] < y1 - tiny[1])
        if inside.any():
            middle = (x0 + x1) / 2, (y0 + y1) / 2
            stack += [(a, b, c, d, near) for a, b in ((x0, middle[0]), (middle[0], x1)) for c, d in ((y0, middle[1]), (middle[1], y1))]
        else:
            leaves.append((x0, x1, y0, y1))
    return leaves


def key_of(x, y):
    return round(x, 9), round(y, 9)


def mean_of(cell, points, x, y, q):
    """Mean of the corners that were run; else the point that is nearest to the middle."""
    corners = [v for v in (points.get(key_of(a, b), np.nan) for a in cell[:2] for b in cell[2:]) if np.isfinite(v)]
    if corners:
        return np.mean(corners)
    return q[np.argmin(((x - sum(cell[:2]) / 2) / np.ptp(x)) ** 2 + ((y - sum(cell[2:]) / 2) / np.ptp(y)) ** 2)]


def draw(title, rule, axes, others, values, quantity):
    level = rule.get("level", 0.0)
    slices = sorted(set(zip(*(values[k] for k in others)))) if others else [()]
    figure, panels = drawing.panels(len(slices), (4.4, 3.9), sharex=True, sharey=True)
    finite = quantity[np.isfinite(quantity)]
    low, high = (np.percentile(finite, 2), np.percentile(finite, 98)) if len(finite) else (level - 1, level + 1)
    norm = TwoSlopeNorm(level, min(low, level - 1e-6), max(high, level + 1e-6))
    for panel, which in zip(panels, slices):
        here = np.ones(len(quantity), bool)
        for key, value in zip(others, which):
            here &= values[key] == value
        x, y, q = values[axes[0]][here], values[axes[1]][here], quantity[here]
        points = {key_of(a, b): c for a, b, c in zip(x, y, q)}
        leaves = cells_of(x, y, (rule["grid"][axes[0]], rule["grid"][axes[1]]))
        mean = [mean_of(cell, points, x, y, q) for cell in leaves]
        cells = PolyCollection([[(a, c), (b, c), (b, d), (a, d)] for a, b, c, d in leaves], array=np.array(mean), norm=norm, cmap="RdBu_r",
                               edgecolors="0.6", linewidths=0.2)
        panel.add_collection(cells)
        good = np.isfinite(q)
        distance = (q[good] - level) / np.maximum(np.abs(q[good]) + abs(level), 1e-300)
        if good.sum() > 2 and distance.min() < 0 < distance.max():
            scaled = [(v[good] - v.min()) / (v.max() - v.min()) for v in (x, y)]  # triangles of the map, not of its units
            mesh = Triangulation(x[good], y[good], Triangulation(*scaled).triangles)
            panel.tricontour(mesh, distance, levels=[0], colors="k", linewidths=1)
        panel.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()), xlabel=wording.axis_name(axes[0]))
        panel.grid(False)
        panel.set_title(", ".join(filter(None, (wording.point_name(others, which), f"{len(points)} points run"))))
    panels[0].set_ylabel(wording.axis_name(axes[1]))
    name = wording.quantity_name(rule["quantity"].split(".", 1)[-1])
    bar = figure.colorbar(cells, ax=panels, label=name, extend="both")
    bar.ax.axhline(level, color="k", linewidth=1.5)
    drawing.heading(figure, title, f"Black line: where {name} is {level:g}. Cells are divided along it, and drawn in the mean of their corners.")
    return figure


def main():
    arguments = saving.argument_parser("map of a refined sweep").parse_args()
    drawing.use_style()
    figure = draw(*read(arguments.result))
    stem = saving.stem_of(arguments.result)
    saving.save(figure, saving.figures_folder(arguments.output, arguments.result), f"{stem}_refined")
