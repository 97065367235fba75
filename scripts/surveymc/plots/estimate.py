"""Figures of an estimate result: what a run of six-axis readings says of the tool, the survey, and its own quality.

    surveymc plot estimate RESULT.h5 [-o FOLDER] [--point I]

<stem>_residuals     total field and dip less the reference, before and after the correction, and the normalised residuals
<stem>_parameters    gains and biases with their intervals, and what of them the sensors' noise and the reference make
<stem>_azimuth       how the correction changes the azimuth along the hole, with its uncertainty
<stem>_plan          the raw and the corrected path from above, with error ellipses

of the estimator "multistation" instead of these
<stem>_sets          what the run justifies, and what each set of parameters and loss predicts of stations that it has not seen

each as PNG and SVG. A sweep is drawn for the point given by --point (counted from 0, in the order of the file); the
figures are then named <stem>_point<I>_<figure>.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from ..arguments import USAGE
from . import drawing, geometry, one_point, reading, saving, sets_figure, wording
from .reading import PlotError
from .wording import number

TABLES = ("parameters", "stations", "tests", "fit", "warnings")
RAW = {"color": "#777777", "marker": "s", "linestyle": (0, (3, 1.5)), "markersize": 4.5}
CORRECTED = {"color": "#0072B2", "marker": "o", "linestyle": "-", "markersize": 4.5}
NOISE, REFERENCE, PRIOR, BAD = "#0072B2", "#E69F00", "#009E73", "#D55E00"
SIGMA, PM = "\N{GREEK SMALL LETTER SIGMA}", "\N{PLUS-MINUS SIGN}"
K95 = np.sqrt(-2 * np.log(0.05))  # a 2-D normal point is in its 2.45-sigma ellipse with 95 %


def summary(fit, warnings):
    """'25 stations, 44 redundant residuals, s0 = 1.07; 1 severe, 2 warnings.' Warnings are those of all points of a sweep."""
    count = {s: sum(w == s for w in warnings["severity"]) for s in ("severe", "warning")}
    said = ", ".join(f"{n} {'severe' if s == 'severe' else 'warnings' if n > 1 else 'warning'}"
                     for s, n in count.items() if n)
    s0 = fit["s0"][0]
    quality = f", s0 = {number(s0)} (residuals over what the noise would make)" if np.isfinite(s0) else ""
    return f"{fit['stations'][0]} stations, {fit['redundancy'][0]} redundant residuals{quality}." + (
        f" {said}{' at all points' if np.any(warnings['at'] != '') else ''}: see the table warnings." if said else "")


# --- 1: residuals ---------------------------------------------------------------------------------------------------


def residuals_figure(title, t):
    stations, tests = t["stations"], t["tests"]
    figure, panels = plt.subplots(3, 1, figsize=(11.0, 9.4), sharex=True, layout="constrained")
    drawing.heading(figure, title, "Field of the readings less the reference, before and after the correction. "
                    + summary(t["fit"], t["warnings"]))
    md = stations["md_m"]
    for ax, name, label in ((panels[0], "total_field_residual_nT", "Total field \N{MINUS SIGN} reference (nT)"),
                            (panels[1], "dip_residual_deg", "Dip \N{MINUS SIGN} reference (\N{DEGREE SIGN})")):
        for look, prefix, meaning in ((RAW, "raw_", "as read"), (CORRECTED, "", "corrected")):
            y = stations[prefix + name]
            ax.plot(md, y, label=f"{meaning}: mean {number(y.mean(), 2)}, rms {number(np.sqrt(np.mean(y**2)), 2)}",
                    linewidth=1.1, **look)
        ax.axhline(0, color="#444444", linewidth=0.9, zorder=1)
        ax.set_ylabel(label)
        ax.margins(y=0.12)
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=2, borderpad=0, borderaxespad=0.3)
    normalised_panel(panels[2], tests)
    panels[2].set_xlabel("Measured depth (m)")
    panels[2].xaxis.set_major_locator(MaxNLocator(12, steps=(1, 2, 2.5, 5, 10)))
    return figure


def normalised_panel(ax, tests):
    """w of every residual, with the critical value; those beyond it are marked."""
    residual = tests.where(lambda i: tests["test"][i] == "residual")
    critical = residual["critical_high"][0]
    for component, marker, color in (("horizontal", "^", "#009E73"), ("vertical", "v", "#A8508A")):
        rows = residual.where(lambda i: residual["component"][i] == component)
        ax.plot(rows["md_m"], rows["statistic"], marker=marker, color=color, linestyle="none", markersize=6.5,
                label=f"{component} field")
    ax.axhline(0, color="#444444", linewidth=0.9, zorder=1)
    if not np.any(np.isfinite(residual["statistic"])):
        ax.annotate("as many residuals as unknowns: nothing to test", (0.5, 0.5), xycoords="axes fraction", ha="center",
                    va="center", style="italic", bbox={"facecolor": "white", "edgecolor": "none"})
    rejected = residual.where(lambda i: residual["decision"][i] == "rejected")
    if rejected.rows:
        ax.plot(rejected["md_m"], rejected["statistic"], "o", markersize=13, markerfacecolor="none", markeredgewidth=1.6,
                color=BAD, label="beyond the critical value")
    for sign in (-1, 1):
        ax.axhline(sign * critical, color=BAD, linewidth=1.1, linestyle=(0, (5, 2)), zorder=1,
                   label=f"critical value {PM}{critical:.2f}" if sign > 0 else None)
    largest = np.nanmax(np.abs(np.append(residual["statistic"], critical)))
    ax.set_ylim(-1.18 * largest, 1.18 * largest)
    ax.set_ylabel("Normalised residual w")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=4, borderpad=0, borderaxespad=0.3)


# --- 2: parameters --------------------------------------------------------------------------------------------------


def parameters_figure(title, t):
    table = t["parameters"]
    figure, panels = plt.subplots(1, 6, figsize=(12.0, 5.6), layout="constrained")
    drawing.heading(figure, title, "Magnetometer gains and biases: estimate, its interval, and what makes it uncertain, by the noise of the config. "
                    + summary(t["fit"], t["warnings"]))
    confidence = table.confidence
    k = (table["ci_high"] - table["estimate"]) / table["sd"]
    parts = [("sd_noise", "part of the sensors' noise", NOISE), ("sd_reference", "part of the reference field", REFERENCE)]
    if np.any(table.get("sd_prior", 0) > 0):
        parts.append(("sd_prior", "part of the tools' spread (prior)", PRIOR))
    offsets = np.linspace(0.55, 0.95 + 0.4 * (len(parts) - 2), len(parts))
    for i, ax in enumerate(panels):
        kind, axis = table["quantity"][i].split("_")[:2]
        x, low, high = table["estimate"][i], table["ci_low"][i], table["ci_high"][i]
        for offset, (name, _, color) in zip(offsets, parts):
            half = k[i] * table[name][i]
            ax.bar(offset, 2 * half, bottom=x - half, width=0.3, color=color, alpha=0.75)
        ax.errorbar(0, x, yerr=[[x - low], [high - x]], fmt="o", color="black", capsize=6, elinewidth=1.8, markersize=6.5)
        perfect = 1 if kind == "gain" else 0
        ax.axhline(perfect, color=BAD, linewidth=1.1, linestyle=(0, (5, 2)), zorder=1)
        ax.set_xlim(-0.45, offsets[-1] + 0.35)
        ax.set_xticks([])
        ax.margins(y=0.1)
        ax.yaxis.set_major_locator(MaxNLocator(7, steps=(1, 2, 2.5, 5, 10)))
        other, r = table["most_correlated"][i].replace("_", " "), table["correlation"][i]
        unit = "" if kind == "gain" else " nT"
        ax.set_title(f"{kind.capitalize()} {axis}{' (nT)' if unit else ''}")
        shown, half = (f"{v:.4f}" if kind == "gain" else f"{v:.0f}" for v in (x, (high - low) / 2))
        ax.set_xlabel(f"{shown} {PM} {half}{unit}\nwith {other}:\ncorrelation {number(r, 3)}".replace("-", "\N{MINUS SIGN}"),
                      fontsize=8.5)
    handles = [Line2D([], [], color="black", marker="o", label=f"estimate and {100 * confidence:g} % interval"),
               *(Patch(color=color, alpha=0.75, label=label) for _, label, color in parts),
               Line2D([], [], color=BAD, linestyle=(0, (5, 2)), label="perfect tool")]
    drawing.legend_below(figure, handles)
    return figure


# --- 3: azimuth -----------------------------------------------------------------------------------------------------


def azimuth_figure(title, t):
    s = t["stations"]
    figure, (change, azimuth) = plt.subplots(2, 1, figsize=(11.0, 7.6), sharex=True, layout="constrained")
    drawing.heading(figure, title, "Azimuth before and after the correction. Its interval is that of gains, biases and own noise; "
                    "declination is taken as exact. " + summary(t["fit"], t["warnings"]))
    md, delta, sd = s["md_m"], s["azimuth_change_deg"], s["sd_azimuth_deg"]
    change.fill_between(md, delta - 1.96 * sd, delta + 1.96 * sd, color=CORRECTED["color"], alpha=0.18, linewidth=0,
                        label="95 % interval of the corrected azimuth")
    change.plot(md, delta, linewidth=1.3, label="corrected \N{MINUS SIGN} as read", **CORRECTED)
    change.axhline(0, color=RAW["color"], linewidth=1.1, linestyle=RAW["linestyle"], label="as read")
    change.set_ylabel("Change of azimuth (\N{DEGREE SIGN})")
    unwrapped = np.degrees(np.unwrap(np.radians(s["azimuth_true_deg"])))
    azimuth.plot(md, unwrapped - delta, linewidth=1.1, label="as read", **RAW)
    azimuth.plot(md, unwrapped, linewidth=1.1, label="corrected", **CORRECTED)
    azimuth.set_ylabel("Azimuth, true north (\N{DEGREE SIGN})")
    azimuth.set_xlabel("Measured depth (m)")
    azimuth.xaxis.set_major_locator(MaxNLocator(12, steps=(1, 2, 2.5, 5, 10)))
    for ax in (change, azimuth):
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=3, borderpad=0, borderaxespad=0.3)
    return figure


# --- 4: plan --------------------------------------------------------------------------------------------------------


def plan_figure(title, t):
    s = t["stations"]
    figure, (path, end) = plt.subplots(1, 2, figsize=(12.0, 7.0), width_ratios=(1.15, 1.0), layout="constrained")
    drawing.heading(figure, title, "Path from above, from the first station, true north. Ellipses hold the corrected position "
                    "with 95 %. " + summary(t["fit"], t["warnings"]))
    last = s.rows - 1
    shown = sorted({round(last * f) for f in (1 / 3, 2 / 3, 1)})
    for ax in (path, end):
        ax.plot(s["raw_east_m"], s["raw_north_m"], linewidth=1.1, label="as read", **RAW)
        ax.plot(s["east_m"], s["north_m"], linewidth=1.1, label="corrected", **CORRECTED)
        ax.set_xlabel("East (m)")
        ax.set_ylabel("North (m)")
        ax.margins(0.08)
    for k in shown:
        n, e = geometry.ellipse_points([[s["nn_m2"][k], s["ne_m2"][k]], [s["ne_m2"][k], s["ee_m2"][k]]], K95,
                                       (s["north_m"][k], s["east_m"][k]))
        path.plot(e, n, color=BAD, linewidth=1.6, zorder=4)
        if k == last:
            end.plot(e, n, color=BAD, linewidth=1.6, zorder=1.9)
            reach = 1.25 * max(np.ptp(e) / 2, np.ptp(n) / 2, abs(s["raw_east_m"][k] - s["east_m"][k]),
                               abs(s["raw_north_m"][k] - s["north_m"][k]), 1e-3)
            end.set_xlim(s["east_m"][k] - reach, s["east_m"][k] + reach)
            end.set_ylim(s["north_m"][k] - reach, s["north_m"][k] + reach)
            a, b, azimuth = geometry.ellipse_axes([[s["nn_m2"][k], s["ne_m2"][k]], [s["ne_m2"][k], s["ee_m2"][k]]])
            moved = np.hypot(s["raw_east_m"][k] - s["east_m"][k], s["raw_north_m"][k] - s["north_m"][k])
            end.set_title(f"(b) The last one, md {s['md_m'][k]:.0f} m: moved by {number(moved)} m;\n1{SIGMA} {number(a)} "
                          f"by {number(b)} m, major axis at {azimuth:.0f}\N{DEGREE SIGN}")
    path.set_aspect("equal", adjustable="datalim")
    end.set_aspect("equal", adjustable="box")
    depths = ", ".join(f"{s['md_m'][k]:.0f}" for k in shown)
    path.set_title(f"(a) Equal scales; ellipses at md {depths} m")
    handles = [Line2D([], [], label="as read", **RAW), Line2D([], [], label="corrected", **CORRECTED),
               Line2D([], [], color=BAD, linewidth=1.6, label=f"95 % ellipse ({K95:.2f}{SIGMA})")]
    path.legend(handles=handles, loc="best")
    return figure


# --------------------------------------------------------------------------------------------------------------------


def main():
    arguments = one_point.parse(saving.argument_parser("Draw the figures of an estimate result."))
    drawing.use_style()
    with reading.open_result(arguments.result, "estimate") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        if reading.read_table(file, "modes") is not None:
            raise PlotError(f"{arguments.result}: of the chained estimator: draw it with surveymc plot chained")
        tables = {n: reading.read_table(file, n) for n in TABLES}
        sets = reading.read_table(file, "sets")
    if sets is not None:
        points = reading.sweep_points(sets, reading.sweep_keys(config, sets))
        if len(points) > 1:
            raise PlotError(f"{arguments.result}: a sweep of {len(points)} points: choose one with --point I", USAGE)
        saving.save_all({"sets": sets_figure.figure(title, sets)}, arguments)
        return
    for name, table in tables.items():
        if table is None or (table.rows == 0 and name != "warnings"):
            raise PlotError(f"{arguments.result}: table '{name}' is missing or empty")
    points = reading.sweep_points(tables["parameters"], reading.sweep_keys(config, tables["parameters"]))
    if len(points) > 1:
        raise PlotError(f"{arguments.result}: a sweep of {len(points)} points: choose one with --point I", USAGE)
    saving.save_all({"residuals": residuals_figure(title, tables), "parameters": parameters_figure(title, tables),
                     "azimuth": azimuth_figure(title, tables), "plan": plan_figure(title, tables)}, arguments)
