"""Figures of an msa_position result: how large are the errors MSA leaves, and which propagation predicts them?

    surveymc plot msa_position RESULT.h5 [-o FOLDER] [--point I]

<stem>_position      final positions of the realisations with sample and predicted error ellipses
<stem>_parameters    gains and biases: input, mean estimate, 3-sigma intervals (figure 6 of the thesis)
<stem>_ratio         predicted over Monte-Carlo standard deviation, per direction and propagation
<stem>_profile       the path of the position along the errors that move it most, and densities beside the realisations
<stem>_tails         with table `tails`: lateral errors beyond k sd against k, and the line of the normal distribution
<stem>_noise_scale   the same ratio against the size of the noise, if the run sweeps noise.scale
<stem>_orders        the same for every formulation of prediction.orders

each as PNG and SVG, and each only if the file has the data. Of a sweep the first three are drawn for the point given
by --point (counted from 0, in the order of the file) and are then named <stem>_point<I>_<figure>.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import drawing, geometry, one_point, ratios, reading, saving, tails, wording
from .drawing import LOOK, PROPAGATIONS, PUBLISHED
from .reading import PlotError, is_zero_to_first_order
from .wording import SIGMA, counts_text, grouped, number, trials_text

SPANS = ("noise.scale",)  # keys of a sweep that has figures of its own here

DIRECTIONS = (("north", "North"), ("east", "East"), ("vertical", "Vertical"))
PARAMETERS = ("gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z")
TIMES = "\N{MULTIPLICATION SIGN}"
WIDTH = {1: 1.0, 2: 1.3, 3: 1.8}  # line widths of the k-sigma ellipses
CIRCLE = "#888888"


# --- 1: position ----------------------------------------------------------------------------------------------------


def read_ellipses(covariances, ellipses):
    """The ellipse of each formulation: dict of (major, minor, azimuth_deg, centre, row of the ellipse table)."""
    result = {}
    for name in ("monte_carlo",) + PROPAGATIONS:
        c, e = covariances.row(formulation=name), ellipses.row(formulation=name)
        if c is None or e is None:
            continue
        matrix = geometry.covariances(c)[:2, :2]
        if np.all(np.isfinite(matrix)):
            result[name] = geometry.ellipse_axes(matrix) + ((e["center_north_m"], e["center_east_m"]), e)
    return result


def position_figure(title, samples, covariances, ellipses):
    """Cloud and ellipses, twice: as a map, and along and across the predicted major axis with separate scales."""
    shapes = read_ellipses(covariances, ellipses)
    azimuth, truth = shapes["joint"][2:4]
    north, east = samples["north_m"] - truth[0], samples["east_m"] - truth[1]

    figure, (plan, axes) = drawing.panels(2, (6.0, 7.2))
    drawing.heading(figure, title, "Final position after MSA, relative to the true one. Cloud: the first "
                    f"{grouped(len(north))} realisations; statistics: {trials_text(ellipses)}."
                    + (" Lines with ticks, below in (b): predicted ellipses without width." if any(geometry.is_line(*s[:2]) for s in shapes.values())
                       else ""))
    for ax, view in ((plan, lambda n, e: (e, n)),
                     (axes, lambda n, e: geometry.map_turned(n, e, azimuth))):
        drawing.cloud(ax, *view(north, east), smallest=3.0)
        ax.plot(0, 0, "+", color="black", markersize=11, markeredgewidth=1.6, zorder=9)
        draw_ellipses(ax, view, {n: s for n, s in shapes.items() if ax is plan or not geometry.is_line(*s[:2])}, truth)
        ax.margins(0.06)

    plan.set_title("(a) Map, equal scales")
    plan.set_xlabel("East of the true position (m)")
    plan.set_ylabel("North of the true position (m)")
    plan.set_aspect("equal", adjustable="datalim")

    axes.set_xlabel(f"Along the predicted major axis, azimuth {azimuth:.2f}\N{DEGREE SIGN} (m)")
    axes.set_ylabel(f"Across it, azimuth {(azimuth - 90) % 360:.2f}\N{DEGREE SIGN} (m)")
    axes.autoscale_view()
    draw_rulers(axes, {n: s[0] for n, s in shapes.items() if geometry.is_line(*s[:2])})
    axes.autoscale(False)
    circle = draw_circle_about_origin(axes, truth, azimuth)
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    minor = shapes.get("monte_carlo", shapes["joint"])[1]
    enlarged = f", enlarged {number((x1 - x0) / (y1 - y0), 1)} times" if x1 - x0 > 1.5 * (y1 - y0) else ""
    axes.set_title(f"(b) Along and across{enlarged}; 1{SIGMA} across: {length(minor)}")
    drawing.legend_below(figure, ellipse_handles(shapes, circle), handlelength=3.2)
    return figure


def draw_ellipses(ax, view, shapes, truth):
    """The 1, 2, 3-sigma ellipses; view(north, east) gives what ax shows. The sample ellipse first, then the longest."""
    order_of = sorted(shapes.items(), key=lambda s: (s[0] != "monte_carlo", -s[1][0]))
    for order, (name, (a, b, azimuth, centre, _)) in enumerate(order_of):
        offset = (centre[0] - truth[0], centre[1] - truth[1])
        look = {"color": LOOK[name]["color"], "linestyle": LOOK[name]["linestyle"], "zorder": 3 + 0.1 * order}
        if geometry.is_line(a, b):
            ends = view(*(p[:2] for p in geometry.ellipse_points_from_axes(a, 0, azimuth, 3, offset, 3)))
            ax.plot(*ends, color="white", linewidth=3.2, zorder=look["zorder"], solid_capstyle="butt")
            ax.plot(*ends, linewidth=2.2, **look)
            continue
        for k in (1, 2, 3):
            ax.plot(*view(*geometry.ellipse_points_from_axes(a, b, azimuth, k, offset)), linewidth=WIDTH[k], **look)


def draw_rulers(ax, sizes, ticks=(1, 2, 3), share=0.05):
    """Ellipses that are lines along the abscissa, below each other under the cloud, with ticks at so many sigma: on their place
    they hide each other. sizes: their 1-sigma axes, in units of the abscissa; share: of the panel, from one to the next."""
    if not sizes:
        return
    low, high = sorted(ax.get_ylim())
    down = ax.yaxis_inverted()
    step = share * (high - low)
    edge, step = (high, -step) if down else (low, step)
    for i, (name, a) in enumerate(sorted(sizes.items(), key=lambda s: -s[1]), 1):
        look = {"color": LOOK[name]["color"], "zorder": 5}
        ax.plot([-ticks[-1] * a, ticks[-1] * a], [edge - i * step] * 2, linestyle=LOOK[name]["linestyle"], linewidth=1.8, **look)
        ax.plot([k * a * side for k in ticks for side in (-1, 1)], [edge - i * step] * 2 * len(ticks), linestyle="none", marker="|",
                markersize=9, markeredgewidth=1.6, **look)
    edge -= (len(sizes) + 0.8) * step
    ax.set_ylim(*((edge, low) if down else (edge, high)))


def draw_circle_about_origin(ax, truth, azimuth):
    """Where one and the same azimuth error at every station moves the end: a circle about the first station.

    Drawn, and True, if it runs along the major axis (within half a degree): there it explains the bend of the cloud.
    """
    radius, bearing = np.hypot(*truth), np.arctan2(truth[1], truth[0])
    off = (np.degrees(bearing) + 90 - azimuth + 90) % 180 - 90
    if radius == 0 or abs(off) > 0.5:
        return False
    turn = bearing + np.linspace(-np.pi / 2, np.pi / 2, 4001)
    ax.plot(*geometry.map_turned(radius * np.cos(turn) - truth[0], radius * np.sin(turn) - truth[1], azimuth),
            color=CIRCLE, linewidth=1.0, zorder=0.9)
    return True


def ellipse_handles(shapes, circle):
    """Legend and numbers in one: what a line is, its axes, and the share of the trials inside of it."""
    meaning = {"monte_carlo": "sample, about its mean", "joint": "each draw, direct and by the estimate",
               "systematic": "six independent systematic errors", "random": "errors independent from station to station"}
    handles = []
    for name, (a, b, azimuth, _, row) in shapes.items():
        is_line = geometry.is_line(a, b)
        text = f"{LOOK[name]['label']} ({meaning[name]}): 1{SIGMA} {length(a)} by {'0' if is_line else length(b)}, azimuth {azimuth:.2f}\N{DEGREE SIGN}"
        if name != "monte_carlo" and not is_line:  # a line has no inside
            inside = [f"{100 * row[f'coverage_{k}sigma']:.1f}" for k in (1, 2, 3)]
            text += f"; inside 1, 2, 3{SIGMA} {', '.join(inside)} %"
        handles.append(Line2D([], [], color=LOOK[name]["color"], linestyle=LOOK[name]["linestyle"], linewidth=1.8, label=text))
    handles.append(Line2D([], [], color="black", marker="+", linestyle="none", markersize=11, markeredgewidth=1.6, label="true position; inside, if normal: "
                          + ", ".join(f"{100 * geometry.ellipse_coverage(k):.1f}" for k in (1, 2, 3)) + " %"))
    if circle:
        handles.append(Line2D([], [], color=CIRCLE, linewidth=1.0, label="circle about the first station: where one azimuth error, the same at all "
                              "stations, moves the end"))
    return handles


# --- 2: parameters --------------------------------------------------------------------------------------------------


def parameters_figure(title, table):
    """Deviation of each parameter from its input: Monte Carlo, prediction and publication, all with 3-sigma bars."""
    rows = {q: table.row(quantity=q) for p in PARAMETERS for q in (f"mean_{p}", f"sigma3_{p}")}
    if any(r is None for r in rows.values()):
        raise PlotError("table 'parameters' lacks mean_ or sigma3_ of a gain or a bias")
    looks = {"Monte Carlo": (LOOK["monte_carlo"]["color"], "o", "monte_carlo"), "predicted": (LOOK["joint"]["color"], "D", "analytic"),
             "published": (PUBLISHED, "s", "published")}
    if not any(np.isfinite(r["published"]) for r in rows.values()):
        looks.pop("published")
    figure, panels = drawing.panels(6, (3.9, 2.9))
    for ax, p in zip(panels, PARAMETERS):
        kind, axis = p.split("_")
        mean, bars = rows[f"mean_{p}"], rows[f"sigma3_{p}"]
        true = mean["analytic"]
        size = max(bars[column] for _, _, column in looks.values() if np.isfinite(bars[column]))
        power = 3 * int(np.floor(np.log10(size) / 3)) if 0 < size < 0.002 else 0
        digits = int(max(2 - np.floor(np.log10(size) - power), 0)) if size > 0 else 0
        ax.axhline(0, color="#444444", linewidth=1.0)
        for x, (label, (colour, marker, column)) in enumerate(looks.items()):
            ax.errorbar(x, (mean[column] - true) / 10.0**power, yerr=bars[column] / 10.0**power, fmt=marker, color=colour, elinewidth=3, capsize=6,
                        capthick=1.5, markersize=7, markeredgecolor="white", zorder=3)
        ax.set_xticks(range(len(looks)), [f"{label}\n\N{PLUS-MINUS SIGN}{bars[column] / 10.0**power:.{digits}f}" if np.isfinite(bars[column]) else label
                                          for label, (*_, column) in looks.items()])
        ax.set_xlim(-0.55, len(looks) - 0.45)
        ax.grid(False, axis="x")
        shown = f"{true:.3f}" if kind == "gain" else f"{true:g} nT".replace("-", "\N{MINUS SIGN}")
        ax.set_title(f"{kind.capitalize()} {axis}, input {shown}")
        unit = " ".join(filter(None, (f"$10^{{{power}}}$" if power else "", "nT" if kind == "bias" else "")))
        ax.set_ylabel("less its input" + (f" ({unit})" if unit else ""))
    drawing.heading(figure, title, f"Estimated gains and biases less their input: means and 3{SIGMA}, whose numbers stand below. {trials_text(table)}.")
    return figure


# --- 3: ratio -------------------------------------------------------------------------------------------------------


def ratio_figure(title, table, confidence):
    """Predicted over Monte-Carlo sd: a panel a direction, a line a propagation."""
    panels, wrong_on_purpose, zero = [], set(), []
    for d, label in DIRECTIONS:
        found = {f: table.row(quantity=f"sigma3_{d}", formulation=f) for f in PROPAGATIONS}
        found = {f: row for f, row in found.items() if row is not None}
        if not found:
            continue
        sd = next(iter(found.values()))["monte_carlo"] / 3
        if all(map(is_zero_to_first_order, found.values())):
            zero.append(f"{label}: zero to first order, Monte Carlo 1{SIGMA} = {length(sd)}.")
        else:
            panels.append((f"{label}: Monte Carlo 1{SIGMA} = {length(sd)}", {f: [(row, "", False)] for f, row in found.items()}))
            wrong_on_purpose |= {LOOK[f]["label"] for f, row in found.items() if row["expected"] == "differs"}
    if not panels:
        raise PlotError("table 'position' has no rows sigma3_north, sigma3_east, sigma3_vertical")
    text = " ".join([f"Predicted over Monte-Carlo standard deviation of the final position. {trials_text(table)}.", *zero])
    if wrong_on_purpose:
        text += f" Expected to differ, being wrong on purpose: {', '.join(sorted(wrong_on_purpose))}."
    return ratios.lines_figure(title, text, panels, {f: (LOOK[f]["label"], LOOK[f]["color"]) for f in PROPAGATIONS}, confidence)


def length(metres):
    """A length for people: millimetres if it is small."""
    return f"{number(metres)} m" if not abs(metres) < 0.1 else f"{number(1000 * metres)} mm"


# --- 4: profile -----------------------------------------------------------------------------------------------------


def profile_figure(title, path, density, orders, samples, ellipses):
    """The position along the errors that move it most, and the densities that follow, beside the realisations."""
    truth = ellipses.row(formulation="joint")
    inputs = {orders.row(quantity=q)["input"] for q in ("north", "east")}
    figure, axes = drawing.panels(1 + len(set(density["quantity"])), (4.6, 3.6))
    drawing.heading(figure, title, "Error of the final position by the profile, which follows the direction of the errors that moves it most "
                    f"({', '.join(sorted(i.replace('_', ' ') for i in inputs))}), and by first order."
                    + (f" Histogram: {grouped(samples.rows)} realisations." if samples else ""))
    colours = {"profile": "#009E73", "first": LOOK["joint"]["color"]}
    leap = np.flatnonzero(np.abs(np.diff(path["along_m"])) > 8 * np.median(np.abs(np.diff(path["along_m"]))))
    along = np.insert(path["along_m"], leap + 1, np.nan)  # a gap where the estimate goes over to another minimum
    axes[0].plot(np.insert(path["t"], leap + 1, np.nan), along, color=colours["profile"], linewidth=1.8)
    axes[0].plot(path["t"], path["first_m"], color=colours["first"], linestyle=LOOK["joint"]["linestyle"], linewidth=1.3)
    axes[0].set_xlabel("Errors along that direction (standard deviations)")
    axes[0].set_ylabel("Error along the major axis (m)")
    axes[0].set_title("(a) The path")
    for letter, ax, name in zip("bc", axes[1:], dict.fromkeys(density["quantity"])):
        rows = density.where(lambda i: density["quantity"][i] == name)
        azimuth = np.radians(rows["azimuth_deg"][0])
        if samples:
            x = np.cos(azimuth) * (samples["north_m"] - truth["center_north_m"]) + np.sin(azimuth) * (samples["east_m"] - truth["center_east_m"])
            ax.hist(x, bins=np.linspace(rows["error_m"][0], rows["error_m"][-1], 81), density=True, color=LOOK["monte_carlo"]["color"], alpha=0.35)
        for which, line in (("profile", "-"), ("first", LOOK["joint"]["linestyle"])):
            ax.plot(rows["error_m"], rows[which], color=colours[which], linestyle=line, linewidth=1.5)
        peak = max(rows["profile"].max(), rows["first"].max())
        ax.set_yscale("log")
        ax.set_ylim(peak / 3e4, 2 * peak)
        ax.set_xlabel(f"Error {'along the major axis' if name == 'along' else 'across it'} (m)")
        ax.set_ylabel("Density (1/m)")
        ax.set_title(f"({letter}) {name.capitalize()}, azimuth {np.degrees(azimuth) % 360:.1f}\N{DEGREE SIGN}")
    handles = [Line2D([], [], color=colours["profile"], label="profile"),
               Line2D([], [], color=colours["first"], linestyle=LOOK["joint"]["linestyle"], label="first order (joint)")]
    if samples:
        handles.append(Patch(color=LOOK["monte_carlo"]["color"], alpha=0.35, label="Monte Carlo"))
    drawing.legend_below(figure, handles)
    return figure


# --- 5: noise scale -------------------------------------------------------------------------------------------------


def ratios_against_noise(table, others, curve, formulation, quantity):
    """Rows of one curve that first order does not leave at zero; none without such rows."""
    rows = reading.at_point(table, [*others, "formulation", "quantity"], [*curve, formulation, quantity])
    return rows.where(lambda i: np.isfinite(rows["ratio"][i]) and not is_zero_to_first_order({k: rows[k][i] for k in ("analytic", "ratio")}))


def noise_scale_figure(title, table, keys, margin, confidence):
    """Ratio of the joint prediction against the noise, and of the profile: the first tends to 1 where only nonlinearity kept it away."""
    others = [k for k in keys if k != "noise.scale"]
    cases = {wording.point_name(others, c) or "joint": c for c in reading.sweep_points(table, others)}
    shown = [f for f in ("joint", "profile") if f in table["formulation"]]
    markers, lines = "osD^vP*X", ("-", (0, (6, 2)), (0, (3, 1.5)), (0, (1, 1.2)))
    palette = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    curves, looks = {}, {}
    for c, (name, case) in enumerate(cases.items()):
        for formulation in shown:
            label = name if formulation == "joint" else f"{name}, profile"
            curves[label] = case, formulation
            looks[label] = palette[c % len(palette)], lines[c % 4] if formulation == "joint" else "none", markers[c % 8] if formulation == "joint" else "_"
    panels = []
    for d, label in DIRECTIONS:
        found = {name: ratios_against_noise(table, others, *curve, f"sigma3_{d}") for name, curve in curves.items()}
        found = {name: rows for name, rows in found.items() if rows.rows}
        zero = [name for name in cases if name not in found]
        found = {name: rows for name, rows in found.items() if name.removesuffix(", profile") not in zero}
        note = f"{', '.join(zero) if len(zero) < 3 else f'{len(zero)} of {len(cases)} curves'}:\nzero to first order, not drawn" if zero else ""
        panels.append((label, found, note, {}))
    text = "Joint prediction (curves) and profile (bars)" if len(shown) > 1 else "Joint prediction"
    return ratios.curves_figure(title, f"{text} over Monte-Carlo standard deviation of the final position. "
                                f"{counts_text(table['trials'])} trials a point. All points use the same random numbers: an offset that all of "
                                "them share is sampling error.", panels, looks, "noise.scale", confidence, margin,
                                "noise scale (1: as in the config)", sorted(set(table["noise.scale"])))


ORDERS = {"joint": ("first order (joint)", "#D55E00", "-", "o"), "second": ("second order", "#0072B2", (0, (6, 2)), "s"),
          "unscented": ("unscented", "#A8508A", (0, (3, 1.5)), "D"), "cubature5": ("cubature of degree 5", "#E69F00", (0, (1, 1.2)), "^"),
          "profile": ("profile", "#009E73", "-", "v")}


def orders_figure(title, table, keys, margin, confidence):
    """Ratio of every formulation beyond first order against the noise: a panel a case and direction."""
    others = [k for k in keys if k != "noise.scale"]
    panels = []
    for case in reading.sweep_points(table, others):
        for d, label in DIRECTIONS[:2]:
            found = {ORDERS[f][0]: ratios_against_noise(table, others, case, f, f"sigma3_{d}") for f in ORDERS if f in table["formulation"]}
            found = {name: rows for name, rows in found.items() if rows.rows}
            if found:
                panels.append((", ".join(filter(None, (wording.point_name(others, case), label.lower()))), found, "", {}))
    return ratios.curves_figure(title, "Predicted over Monte-Carlo standard deviation of the final position, by formulation. "
                                f"{counts_text(table['trials'])} trials a point, the same random numbers at all of them.", panels,
                                {label: look for label, *look in ORDERS.values()}, "noise.scale", confidence, margin,
                                "noise scale (1: as in the config)", sorted(set(table["noise.scale"])))


# --------------------------------------------------------------------------------------------------------------------


def main():
    arguments = one_point.parse(saving.argument_parser("Draw the figures of an msa_position result."))
    drawing.use_style()
    with reading.open_result(arguments.result, "msa_position") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        parameters, position, ellipses, covariances = (reading.read_table(file, n) for n in
                                                       ("parameters", "position", "ellipse", "position_covariance"))
        cloud, beyond = reading.read_table(file, "realisations", "samples"), reading.read_table(file, "tails")
        path, density, orders = (reading.read_table(file, n) for n in ("profile_path", "density", "orders"))
    if position is None or position.rows == 0:
        raise PlotError(f"{arguments.result}: table 'position' is missing or empty")
    keys = reading.sweep_keys(config, position)
    points = reading.sweep_points(position, keys)
    figures = {}
    if len(points) == 1:
        title += f": {wording.point_name(keys, points[0])}" if keys else ""
        figures["ratio"] = ratio_figure(title, position, position.confidence)
        if path and density and orders:
            figures["profile"] = profile_figure(title, path, density, orders, cloud if cloud and cloud.rows else None, ellipses)
        if parameters:
            figures["parameters"] = parameters_figure(title, parameters)
        if cloud is None or cloud.rows == 0:
            print("no position figure: the file has no realisations (save_samples in the config)", file=sys.stderr)
        elif not (covariances and ellipses and {"monte_carlo", "joint"} <= set(read_ellipses(covariances, ellipses))):
            print("no position figure: the file has no error ellipses", file=sys.stderr)
        else:
            figures["position"] = position_figure(title, cloud, covariances, ellipses)
        figures = {n: figures[n] for n in ("position", "parameters", "ratio", "profile") if n in figures}  # the order in which they are read
    if "noise.scale" in keys and len(set(position["noise.scale"])) > 1:
        margin = float(config.get("verdict", {}).get("margin", 0))
        figures["noise_scale"] = noise_scale_figure(title, position, keys, margin, position.confidence)
        if {"second", "profile"} & set(position["formulation"]):
            figures["orders"] = orders_figure(title, position, keys, margin, position.confidence)
    tail_figure = None if beyond is None else tails.coverage_figure(title, beyond, keys)
    if tail_figure is not None:
        figures["tails"] = tail_figure
    if not figures:
        raise PlotError(f"{arguments.result}: a sweep of {len(points)} points: choose one with --point I")
    saving.save_all(figures, arguments)
