"""Figures of table `tails`: how often errors are beyond k predicted standard deviations, by several studies.

The probability against k with the normal distribution's line, and a map of it over inclination and azimuth of made-up wells.
"""

import math
import textwrap

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D

from . import drawing, ratios, reading, wording

PREDICTED, NORMAL = "#0072B2", "#222222"
INCLINATION, AZIMUTH = "well.inclination_deg", "well.azimuth_deg"
RULE = 3.5  # k of the separation rule


def of_direction(table, direction, md=None):
    """The rows of the prediction by laws along a direction, at one depth where the table has several."""
    names = {q: q.rsplit("_beyond_", 1)[0] for q in set(table["quantity"])}
    return table.where(lambda i: names[table["quantity"][i]] == direction and table["formulation"][i] == "mixture"
                       and (md is None or "md_m" not in table or table["md_m"][i] == md))


def normal_tail(k):
    return [math.erfc(x / math.sqrt(2)) for x in np.atleast_1d(k)]


def coverage_figure(title, table, keys, direction="lateral", md=None, errors=None):
    """A panel a sweep point: what is beyond k sd, drawn and predicted, and of a normal distribution. None without rows."""
    rows = of_direction(table, direction, md)
    points = ratios.some(reading.sweep_points(rows, keys), 6)
    if not rows.rows or not np.isfinite(rows["predicted"]).any():
        return None
    figure, panels = drawing.panels(len(points), (3.9, 3.4), sharex=True, sharey=True)
    for ax, point in zip(panels, points):
        here = reading.at_point(rows, keys, point)
        k, order = here["k"], np.argsort(here["k"])
        fine = np.linspace(0.9 * k.min(), 1.05 * k.max(), 100)
        ax.plot(fine, normal_tail(fine), color=NORMAL, linestyle=(0, (5, 2)), linewidth=1.2)
        ax.plot(k[order], here["predicted"][order], color=PREDICTED, marker="_", markersize=12, linewidth=1.2)
        y, low, high = (here[n] for n in ("monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high"))
        seen = y > 0
        ax.errorbar(k[seen], y[seen], yerr=[(y - low)[seen], (high - y)[seen]], color="#D55E00", linestyle="none", marker="o",
                    markersize=4.5, elinewidth=1.2)
        share = float(here["heavy_share"][0])
        ax.set_title("\n".join([*textwrap.wrap(wording.point_name(keys, point), 46), f"{100 * share:.0f} % of the variance heavy"]), fontsize=9)
        ax.set_yscale("log")
        if k.min() <= RULE <= k.max():
            ax.axvline(RULE, color="#999999", linewidth=0.8, zorder=0)
    columns = panels[0].get_gridspec().ncols
    for i, ax in enumerate(panels):
        if i + columns >= len(panels):
            ax.set_xlabel("k (predicted standard deviations)")
        if i % columns == 0:
            ax.set_ylabel("Probability beyond k")
    drawing.heading(figure, title, f"{errors or direction.replace('_', ' ').capitalize() + ' errors'} beyond k predicted standard deviations. "
                    f"{wording.trials_text(table)} a panel. Grey: k of the separation rule.")
    handles = [Line2D([], [], color=NORMAL, linestyle=(0, (5, 2)), label="normal distribution"),
               Line2D([], [], color=PREDICTED, marker="_", markersize=12, label="predicted by the laws"),
               Line2D([], [], color="#D55E00", marker="o", linestyle="none", label="Monte Carlo, exact interval")]
    drawing.legend_below(figure, handles)
    return figure


def map_figure(title, table, keys, direction="lateral", md=None):
    """A panel a further value of the sweep (two codes): percent beyond the k next to 3.5, over inclination and azimuth."""
    rows = of_direction(table, direction, md)
    at = min(set(rows["k"]), key=lambda k: abs(k - RULE))
    rows = rows.where(lambda i: rows["k"][i] == at)
    others = [k for k in keys if k not in (INCLINATION, AZIMUTH)]
    points = ratios.some(reading.sweep_points(rows, others), 4)
    inclinations, azimuths = sorted(set(rows[INCLINATION])), sorted(set(rows[AZIMUTH]))
    low, high = 100 * normal_tail(at)[0], 100 * float(np.nanmax(rows["predicted"]))
    figure, panels = plt.subplots(1, len(points), figsize=(4.4 * len(points) + 1.2, 4.6), squeeze=False, layout="constrained")
    for ax, point in zip(panels[0], points):
        here = reading.at_point(rows, others, point)
        grid = np.full((len(inclinations), len(azimuths)), np.nan)
        for i in range(here.rows):
            grid[inclinations.index(here[INCLINATION][i]), azimuths.index(here[AZIMUTH][i])] = 100 * here["predicted"][i]
        image = ax.imshow(grid, origin="lower", aspect="auto", cmap="magma_r", norm=LogNorm(low, max(high, 1.01 * low)))
        for y, x in np.ndindex(grid.shape):
            dark = np.log(grid[y, x] / low) > 0.45 * np.log(max(high, 1.01 * low) / low)
            ax.text(x, y, wording.number(grid[y, x], 2), ha="center", va="center", fontsize=8, color="white" if dark else "black")
        ax.set_xticks(range(len(azimuths)), [f"{a:g}" for a in azimuths])
        ax.set_yticks(range(len(inclinations)), [f"{i:g}" for i in inclinations])
        ax.set_title(wording.point_name(others, point), fontsize=10)
        ax.set_xlabel("Azimuth (\N{DEGREE SIGN})")
        ax.grid(False)
    panels[0][0].set_ylabel("Inclination (\N{DEGREE SIGN})")
    ticks = [m * 10.0**e for e in range(-4, 3) for m in (1, 2, 5) if low <= m * 10.0**e <= high]
    figure.colorbar(image, ax=list(panels[0]), pad=0.01, format="%g", ticks=ticks, label="%").ax.minorticks_off()
    drawing.heading(figure, title, f"Percent of {direction.replace('_', ' ')} errors beyond {at:g} predicted standard deviations, by the laws; "
                    f"a normal distribution has {low:.2g} %.")
    return figure
