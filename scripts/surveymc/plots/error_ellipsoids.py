"""Figure 7 of the thesis: the cloud of final positions with the 3-sigma ellipsoids of the propagations.

Projections on north-east, north-vertical and east-vertical, a view in three dimensions, and the hole's own axes at the
last station (high side, lateral, along hole; thesis eq 48). Drawn by surveymc plot thesis.

In a plane well azimuth errors do not move the vertical to first order: the predicted ellipsoids are flat there, or even
lines, and are drawn as such.
"""

import os

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from . import reading
from .drawing import LOOK, PROPAGATIONS
from .reading import PlotError
from .wording import SIGMA, grouped, number

FORMULATIONS = ("monte_carlo",) + PROPAGATIONS
CLOUD = {"color": "#56B4E9", "markersize": 3.0, "alpha": 0.45, "markeredgewidth": 0}
K = 3  # sigma of the ellipsoids


def hla_from_nev(inclination, azimuth):
    """Rows are high side, lateral and along hole in north, east, vertical (thesis eq 48, corrected). Radians."""
    si, ci, sa, ca = np.sin(inclination), np.cos(inclination), np.sin(azimuth), np.cos(azimuth)
    return np.array([[ci * ca, ci * sa, -si], [-sa, ca, 0.0], [si * ca, si * sa, ci]])


def last_stations(file, config):
    """(inclination, true azimuth) in radians at the last station of every case; cases of which the file does not say are
    not there."""
    stations = {}
    for case in config.get("sweep", {}).get("case", []):
        keys, point = ["case"], [case.get("name")]
        declination, convergence = reading.norths_at(file, config, keys, point)
        north = reading.setting_at(config, keys, point, "survey.azimuth_reference", "true")
        offset = {"magnetic": declination, "grid": convergence}.get(north, 0.0)
        path = reading.setting_at(config, keys, point, "survey.file", "")
        table = reading.read_table(file, os.path.splitext(os.path.basename(path))[0], "inputs")
        if table and "inclination_deg" in table and "azimuth_deg" in table and np.isfinite(offset):
            stations[case.get("name")] = (np.radians(table["inclination_deg"][-1]),
                                          np.radians(table["azimuth_deg"][-1] + offset))
    return stations


def matrices(covariances):
    """The 3x3 covariance (m2; north, east, vertical) of each formulation."""
    result = {}
    for name in FORMULATIONS:
        row = covariances.row(formulation=name)
        if row is None:
            continue
        c = np.array([[row["nn_m2"], row["ne_m2"], row["nv_m2"]], [row["ne_m2"], row["ee_m2"], row["ev_m2"]],
                      [row["nv_m2"], row["ev_m2"], row["vv_m2"]]])
        if np.all(np.isfinite(c)):
            result[name] = c
    return result


def is_line(covariance, x, y):
    """Whether the ellipse of two coordinates has no width: to rounding, 1e-14 of the variances."""
    vx, vy = covariance[x, x], covariance[y, y]
    return vx * vy - covariance[x, y] ** 2 <= 1e-12 * vx * vy or min(vx, vy) <= 1e-14 * max(vx, vy)


def outline(covariance, x, y):
    """K-sigma ellipse of the coordinates x, y of a covariance: (points of x, points of y).

    Each axis in units of its own sd, so that a vertical a thousand times smaller than the horizontal keeps its digits.
    A coordinate without variance stays at zero.
    """
    sx, sy = (np.sqrt(max(covariance[i, i], 0.0)) for i in (x, y))
    r = covariance[x, y] / (sx * sy) if sx > 0 and sy > 0 else 0.0
    # A line is drawn once, not there and back: its dashes would fill each other's gaps.
    line = is_line(covariance, x, y)
    t = np.linspace(0, np.pi, 3) if line else np.linspace(0, 2 * np.pi, 361)
    if line and sx <= 1e-7 * sy:
        t = t + np.pi / 2
    return K * sx * np.cos(t), K * sy * (np.clip(r, -1, 1) * np.cos(t) + np.sqrt(max(1 - r * r, 0.0)) * np.sin(t))


def draw_outlines(ax, shapes, x, y, unit_x, unit_y):
    """The sample's ellipse first, then the longest: on a line the shorter ones stay visible."""
    ordered = sorted(shapes.items(), key=lambda s: (s[0] != "monte_carlo", -s[1][x, x] - s[1][y, y]))
    for order, (name, c) in enumerate(ordered):
        look = {"color": LOOK[name]["color"], "linestyle": LOOK[name]["linestyle"], "zorder": 3 + 0.1 * order}
        px, py = outline(c, x, y)
        if is_line(c, x, y):  # lines lie upon each other: a white edge sets them apart
            ax.plot(px * unit_x, py * unit_y, color="white", linewidth=3.4, zorder=look["zorder"], solid_capstyle="butt")
        ax.plot(px * unit_x, py * unit_y, linewidth=1.3 if name in ("systematic", "random") and len(px) > 3 else 1.9, **look)


def scaled(largest):
    """(factor, unit) for an axis of lengths up to `largest` metres: millimetres where they are small."""
    return (1000.0, "mm") if largest < 0.5 else (1.0, "m")


def projection(ax, points, shapes, x, y, names):
    """Cloud and ellipses of two coordinates. Both axes have their own scale unless they are of one size."""
    largest = [max([np.abs(points[i]).max()] + [K * np.sqrt(max(c[i, i], 0)) for c in shapes.values()]) for i in (x, y)]
    (ux, wx), (uy, wy) = (scaled(v) for v in largest)
    ax.plot(points[x] * ux, points[y] * uy, ".", rasterized=True, zorder=1, **CLOUD)
    draw_outlines(ax, shapes, x, y, ux, uy)
    ax.plot(0, 0, "+", color="black", markersize=11, markeredgewidth=1.6, zorder=9)
    ax.margins(0.06)
    ax.set_xlabel(f"{names[x]} ({wx})")
    ax.set_ylabel(f"{names[y]} ({wy})")
    predicted = [f for f in PROPAGATIONS if f in shapes]
    flat = [names[i].lower() for i in (x, y) if predicted and all(shapes[f][i, i] <= 1e-14 * np.trace(shapes[f])
                                                                  for f in predicted)]
    if flat:
        ax.annotate(f"{' and '.join(flat)}: zero to first order", (0.03, 0.03), xycoords="axes fraction", fontsize=9,
                    style="italic", bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}, zorder=10)


def surface(covariance, count=24):
    """K-sigma ellipsoid as a mesh (3, n, n); a flat or linear one collapses to what it is."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 2 * count), np.linspace(0, np.pi, count))
    sphere = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    return K * np.einsum("ij,jkl->ikl", root, sphere)


def view(ax, points, shapes):
    """The three of them in space; down is down."""
    widest = max(max(np.abs(points[2]).max(), K * np.sqrt(max(c[2, 2], 0))) for c in shapes.values())
    unit, word = scaled(widest)
    ax.plot(points[1], points[0], points[2] * unit, ".", rasterized=True, **{**CLOUD, "alpha": 0.25})
    for name in sorted(PROPAGATIONS, key=lambda f: -np.trace(shapes[f]) if f in shapes else 0):
        if name in shapes:
            colour, width = LOOK[name]["color"], 1.0 if name == "joint" else 0.6
            values, vectors = np.linalg.eigh(shapes[name])
            if values[1] <= 1e-14 * values[2]:  # a line
                end = K * np.sqrt(values[2]) * vectors[:, 2]
                ax.plot((-end[1], end[1]), (-end[0], end[0]), (-end[2] * unit, end[2] * unit), color=colour,
                        linestyle=LOOK[name]["linestyle"], linewidth=2.2, zorder=10)
                continue
            n, e, v = surface(shapes[name])
            ax.plot_wireframe(e, n, v * unit, color=colour, linewidth=width, alpha=0.6, rstride=3, cstride=4)
    ax.invert_zaxis()
    ax.set_xlabel("East (m)")
    ax.set_ylabel("North (m)")
    ax.set_zlabel(f"Down ({word})")
    ax.tick_params(labelsize=8)
    ax.view_init(elev=22, azim=-60)
    ax.locator_params(nbins=5)


def figure(title, samples, covariances, hole, trials):
    """One figure of one test. samples: realisations; hole: (inclination, azimuth) at the last station, or None."""
    shapes = matrices(covariances)
    if not {"monte_carlo", "joint"} <= set(shapes):
        raise PlotError("table 'position_covariance' lacks Monte Carlo or joint")
    points = np.array([samples[f"{d}_m"] for d in ("north", "east", "vertical")])
    middle = points.mean(axis=1, keepdims=True)
    points = points - middle
    drawn = plt.figure(figsize=(13.0, 9.2))
    drawn.suptitle(title, x=0.02, y=0.985, ha="left")
    drawn.text(0.02, 0.95, f"Final position after MSA about its mean, with {K}{SIGMA} ellipses. Cloud: the first "
               f"{grouped(points.shape[1])} of {grouped(trials)} trials. Axes have own scales."
               + (f" Hole at the last station: inclination {np.degrees(hole[0]):.1f}\N{DEGREE SIGN}, azimuth "
                  f"{np.degrees(hole[1]):.1f}\N{DEGREE SIGN}." if hole is not None else ""), va="top")
    grid = drawn.add_gridspec(2, 3, left=0.065, right=0.985, top=0.885, bottom=0.155, hspace=0.3, wspace=0.3)
    names = ("North", "East", "Down")
    for column, (x, y, letter) in enumerate(((1, 0, "a"), (0, 2, "b"), (1, 2, "c"))):
        ax = drawn.add_subplot(grid[0, column])
        projection(ax, points, shapes, x, y, names)
        if y == 2:
            ax.invert_yaxis()
        ax.set_title(f"({letter}) {names[y]} against {names[x].lower()}")
    space = drawn.add_subplot(grid[1, 0], projection="3d")
    view(space, points, shapes)
    box = space.get_position()  # room for the label of the vertical
    space.set_position((box.x0 - 0.035, box.y0 - 0.03, box.width, box.height))
    space.set_title("(d) In space", x=0.12)
    if hole is not None:
        turn = hla_from_nev(*hole)
        own = turn @ points
        turned = {name: turn @ c @ turn.T for name, c in shapes.items()}
        hla = ("High side", "Lateral", "Along hole")
        for column, (x, y, letter) in enumerate(((1, 0, "e"), (1, 2, "f")), 1):
            ax = drawn.add_subplot(grid[1, column])
            projection(ax, own, turned, x, y, hla)
            ax.set_title(f"({letter}) {hla[y]} against {hla[x].lower()}")
    handles = [Line2D([], [], linestyle="none", marker=".", color=CLOUD["color"], markersize=9, label="trials")]
    for name, c in shapes.items():
        sizes = ", ".join(number(K * np.sqrt(max(c[i, i], 0.0))) for i in range(3))
        handles.append(Line2D([], [], color=LOOK[name]["color"], linestyle=LOOK[name]["linestyle"],
                              label=f"{LOOK[name]['label']}: {sizes} m"))
    handles.append(Line2D([], [], linestyle="none", marker="+", color="black", markersize=10, label="mean"))
    drawn.legend(handles=handles, loc="lower center", ncol=len(handles), bbox_to_anchor=(0.5, 0.02),
                 title=f"{K}{SIGMA} of north, east, vertical", columnspacing=1.4)
    return drawn
