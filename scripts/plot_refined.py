#!/usr/bin/python3
"""The map of a refined sweep: cells of uneven size, coloured by the quantity of [refine], and the boundary.

    scripts/plot_refined.py RESULT.h5 [-o FOLDER] [--format png,svg]

RESULT.h5 is a merged result of all rounds (scripts/slurm/refine.sh). One panel for each value of the keys that [refine] does
not divide; two axes. A cell is drawn where four points that stand in a rectangle have no point inside it.
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import tomllib

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import TwoSlopeNorm

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("result")
parser.add_argument("-o", "--output", help="folder of the figures (default: beside the result)")
parser.add_argument("--format", default="png,svg")
args = parser.parse_args()


def text(column):
    return np.array([v.decode() if isinstance(v, bytes) else v for v in column])


with h5py.File(args.result) as file:
    config = tomllib.loads(file.attrs["config"])
    rule = config["refine"]
    name, column = rule["quantity"].split(".", 1)
    table = file["tables"][name]
    chosen = np.ones(len(table["row"]), bool)
    for key, word in rule.get("where", {}).items():
        chosen &= text(table[key][:]) == word
    keys = [k for k in table if table[k].attrs.get("long_name", "") in ("sweep key", b"sweep key")]
    values = {k: table[k][:][chosen] for k in keys}
    quantity = table[column][:][chosen]
axes = sorted(rule.get("axes") or rule["grid"])
if len(axes) != 2:
    sys.exit(f"{args.result}: [refine] divides {len(axes)} axes, this draws 2")
others = [k for k in keys if k not in axes]
slices = sorted(set(zip(*(values[k] for k in others)))) if others else [()]
level = rule.get("level", 0.0)


def cells_of(points, grid):
    """Leaf rectangles (x0, x1, y0, y1) of the cells of `grid` halved as far as `points` go."""
    leaves = []
    stack = [(grid[0][i], grid[0][i + 1], grid[1][j], grid[1][j + 1]) for i in range(len(grid[0]) - 1) for j in range(len(grid[1]) - 1)]
    while stack:
        x0, x1, y0, y1 = stack.pop()
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        if has(points, x, y):
            stack += [(x0, x, y0, y), (x, x1, y0, y), (x0, x, y, y1), (x, x1, y, y1)]
        elif has(points, x, y0) and has(points, x, y1):  # halved along x only
            stack += [(x0, x, y0, y1), (x, x1, y0, y1)]
        elif has(points, x0, y) and has(points, x1, y) and not (has(points, x, y0) or has(points, x, y1)):
            leaves.append((x0, x1, y0, y1))
        else:
            leaves.append((x0, x1, y0, y1))
    return leaves


def key_of(x, y):
    return round(x, 9), round(y, 9)


def has(points, x, y):
    return key_of(x, y) in points


fig, panels = plt.subplots(1, len(slices), figsize=(5.2 * len(slices), 4.6), squeeze=False, layout="constrained")
finite = quantity[np.isfinite(quantity)]
low, high = (np.percentile(finite, 2), np.percentile(finite, 98)) if len(finite) else (level - 1, level + 1)
norm = TwoSlopeNorm(level, min(low, level - 1e-6), max(high, level + 1e-6))
for panel, which in zip(panels[0], slices):
    here = np.ones(len(quantity), bool)
    for key, value in zip(others, which):
        here &= values[key] == value
    x, y, q = values[axes[0]][here], values[axes[1]][here], quantity[here]
    points = {key_of(a, b): c for a, b, c in zip(x, y, q)}
    leaves = cells_of(points, (rule["grid"][axes[0]], rule["grid"][axes[1]]))
    mean = [np.nanmean([points.get(key_of(a, b), np.nan) for a in cell[:2] for b in cell[2:]]) for cell in leaves]
    cells = PolyCollection([[(a, c), (b, c), (b, d), (a, d)] for a, b, c, d in leaves], array=np.array(mean), norm=norm, cmap="RdBu_r",
                           edgecolors="0.6", linewidths=0.2)
    panel.add_collection(cells)
    crossed = [cell for cell in leaves
               if len({points.get(key_of(a, b), np.nan) >= level for a in cell[:2] for b in cell[2:]}) == 2]
    panel.plot([(a + b) / 2 for a, b, _, _ in crossed], [(c + d) / 2 for _, _, c, d in crossed], "k.", markersize=1.5)
    panel.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()), xlabel=axes[0].replace("_", " "), ylabel=axes[1].replace("_", " "))
    panel.set_title(", ".join(f"{k} = {v:g}" if isinstance(v, float) else f"{k} = {v}" for k, v in zip(others, which)) +
                    f"  ({len(points)} points)", fontsize=9)
fig.colorbar(cells, ax=panels[0].tolist(), label=f"{rule['quantity']}; boundary at {level:g}", extend="both")
folder = pathlib.Path(args.output or pathlib.Path(args.result).parent)
folder.mkdir(parents=True, exist_ok=True)
for form in args.format.split(","):
    path = folder / f"{pathlib.Path(args.result).stem}_refined.{form}"
    fig.savefig(path, dpi=150)
    print(path)
