"""Figures of a vertical_well result: Hanak's memo, figures 1 and 2, and how every formulation does.

    surveymc plot vertical_well RESULT.h5 [-o FOLDER] [--point I]

<stem>_ellipses    last positions of the realisations with the 1-sigma ellipses, and the same without realisations
<stem>_ratio       predicted over Monte-Carlo standard deviation along both axes, every formulation, every sweep point
<stem>_sequences   Monte-Carlo sd of fixed toolface sequences against the mean over sequences, if the run sweeps them

each as PNG and SVG, and each only if the file has the data. Of a sweep the first is drawn for the point given by
--point (counted from 0, in the order of the file) and is then named <stem>_point<I>_ellipses.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import drawing, geometry, one_point, ratios, reading, saving, wording
from .reading import PlotError
from .wording import SIGMA, grouped, number

SPANS = ("drilling.sequence", "drilling.mode")  # keys of a sweep that has figures of its own here


# Colours of the memo where it has them: green for what fits, red for what does not, blue for Monte Carlo.
FORMULATIONS = {
    "toolface_dependent": ("toolface-dependent, eqs 19, 20", "#009E73", (0, (6, 2))),
    "fictive_terms": ("fictive terms 4, 5, eqs 36\N{EN DASH}40", "#000000", (0, (1, 2))),
    "fictive_terms_accelerometer_toolface": ("the same, accelerometer toolface", "#56B4E9", (0, (5, 1, 1, 1))),
    "ti_random": ("ABXY-TI1/TI2, eqs 41, 42, random", "#E69F00", (0, (3, 2))),
    "ti_systematic": ("ABXY-TI1/TI2, systematic", "#CC79A7", (0, (8, 2, 2, 2))),
    "spe_67616": ("SPE 67616, A = \N{GREEK SMALL LETTER ALPHA} = 0", "#D55E00", "-"),
    "copegrove_without_half_leg": ("CDR-SM-03 rev 4, without \N{GREEK CAPITAL LETTER DELTA}D/2", "#D55E00", (0, (4, 1))),
    "copegrove_with_half_leg": ("CDR-SM-03 rev 4, with \N{GREEK CAPITAL LETTER DELTA}D/2", "#009E73", (0, (4, 1.5, 1, 1.5))),
}
MONTE_CARLO = drawing.LOOK["monte_carlo"]["color"]


def known_formulations(table):
    """Formulations of a table, in the order of FORMULATIONS."""
    return [f for f in FORMULATIONS if f in table["formulation"]]


# --- 1: ellipses ----------------------------------------------------------------------------------------------------


def ellipses_figure(title, point, samples, table):
    """The memo's two panels: cloud and ellipses, and the ellipses alone, on the same scales in millimetres."""
    formulations = known_formulations(table)
    cloud = samples is not None and samples.rows > 0
    figure, panels = drawing.panels(1 + cloud, (5.6, 6.6), columns=1 + cloud, sharex=True, sharey=True)
    rows = [table.row(formulation=f) for f in formulations]
    sample = table.row(formulation="monte_carlo")
    if sample is None:
        raise PlotError("table 'ellipse' has no row 'monte_carlo'")
    reach = 1.18e3 * max(r["semi_major_m"] for r in rows + [sample])
    if cloud:
        reach = max(reach, 1e3 * 3.3 * sample["semi_major_m"])
        inside = np.maximum(abs(samples["north_m"]), abs(samples["east_m"])) * 1e3 <= reach
        drawing.cloud(panels[0], 1e3 * samples["east_m"][inside], 1e3 * samples["north_m"][inside], alpha=0.35)
        beyond = int(np.count_nonzero(~inside))
        panels[0].set_title("(a) With the realisations" + (f"; {grouped(beyond)} lie outside" if beyond else ""))
        panels[1].set_title("(b) The ellipses alone")
    for ax in panels:
        for row in [sample] + rows:
            name = row["formulation"]
            _, color, line = ("Monte Carlo", MONTE_CARLO, "-") if name == "monte_carlo" else FORMULATIONS[name]
            north, east = geometry.ellipse_points_from_axes(
                1e3 * row["semi_major_m"], 1e3 * row["semi_minor_m"], row["major_azimuth_deg"],
                centre=(1e3 * row["center_north_m"], 1e3 * row["center_east_m"]))
            ax.plot(east, north, color=color, linestyle=line, linewidth=3.6 if name == "monte_carlo" else 1.9,
                    zorder=3 if name == "monte_carlo" else 4)
        ax.plot(0, 0, "+", color="black", markersize=9, markeredgewidth=1.3, zorder=6)
        ax.set_xlim(-reach, reach)
        ax.set_ylim(-reach, reach)
        ax.set_aspect("equal", adjustable="box")
        ax.set_xlabel("East (mm)")
    panels[0].set_ylabel("North (mm)")
    handles = [Line2D([], [], color=MONTE_CARLO, linewidth=3.6, label=f"Monte Carlo: {axes_text(sample)}")]
    for row in rows:
        label, color, line = FORMULATIONS[row["formulation"]]
        handles.append(Line2D([], [], color=color, linestyle=line, linewidth=1.9,
                              label=f"{label}: {axes_text(row)}; predicted / Monte Carlo {row['ratio_major']:.3f}, "
                                    f"{row['ratio_minor']:.3f}"))
    drawing.heading(figure, title, (f"{point}. " if point else "") + f"Horizontal error of the last position; ellipses are 1{SIGMA}. "
                    f"Monte Carlo: {wording.counts_text(table['trials'])} runs" + (f", {grouped(samples.rows)} of them drawn." if cloud else "."))
    drawing.legend_below(figure, handles, handlelength=3.2)
    return figure


def axes_text(row):
    return f"{number(1e3 * row['semi_major_m'])} by {number(1e3 * row['semi_minor_m'])} mm"


# --- 2: ratio -------------------------------------------------------------------------------------------------------


def ratio_figure(title, table, keys, points):
    """Every formulation against Monte Carlo, one panel a sweep point, both axes of the ellipse."""
    panels = []
    for point in points:
        here = reading.at_point(table, keys, point)
        rows = {name: here.row(formulation=name) for name in known_formulations(table)}
        panels.append((wording.point_name(keys, point), {n: [(r, "_major", False), (r, "_minor", True)] for n, r in rows.items() if r}))
    axes = [Line2D([], [], linestyle="none", marker="o", color="#444444", markerfacecolor=face, label=f"{axis} axis")
            for axis, face in (("major", "#444444"), ("minor", "white"))]
    return ratios.lines_figure(title, "Predicted over Monte-Carlo standard deviation of the last position along the axes of its ellipse. "
                               f"{wording.counts_text(table['trials'])} runs a panel.", panels,
                               {n: look[:2] for n, look in FORMULATIONS.items()}, table.confidence, min(2, len(points)), axes)


# --- 3: sequences ---------------------------------------------------------------------------------------------------


def sequences_figure(title, table, keys):
    """Each fixed toolface sequence by its sd over that of eqs 41, 42 as random, and where 90 % of sequences lie."""
    rows = table.where(lambda i: table["quantity"][i] == "ratio_rms")
    order = np.argsort(rows["monte_carlo"])
    figure, ax = plt.subplots(figsize=(11.0, 6.0), layout="constrained")
    low, high = (np.sqrt(-np.log1p(-p)) for p in (0.05, 0.95))
    ax.axhspan(low, high, color="#E69F00", alpha=0.15, linewidth=0)
    ax.axhline(1, color="#444444", linewidth=1.0)
    x = np.arange(len(order))
    value = rows["monte_carlo"][order]
    ax.errorbar(x, value, yerr=[value - rows["monte_carlo_ci_low"][order], rows["monte_carlo_ci_high"][order] - value],
                fmt="o", color=MONTE_CARLO, markersize=7, capsize=4, zorder=4)
    ax.plot(x, rows["analytic"][order], linestyle="none", marker="_", markersize=22, markeredgewidth=2.2,
            color="#009E73", zorder=3)
    for i, v in zip(x, value):
        ax.annotate(f"{v:.3f}", (i, v), xytext=(0, 9), textcoords="offset points", ha="center", fontsize=8.5)
    names = reading.sweep_points(rows, keys)
    ax.set_xticks(x)
    ax.set_xticklabels([f"{names[i][keys.index('drilling.sequence')]:g}" for i in order])
    ax.set_xlabel("Number of the toolface sequence, in the order of its result")
    ax.set_ylabel("Sequence / mean over sequences")
    ax.set_ylim(0, max(1.15 * high, 1.12 * value.max()))
    ax.grid(False, axis="x")
    handles = [Line2D([], [], color=MONTE_CARLO, marker="o", linestyle="none",
                      label=f"Monte Carlo, {100 * table.confidence:g} % interval"),
               Line2D([], [], color="#009E73", marker="_", linestyle="none", markersize=16, markeredgewidth=2.2,
                      label="toolface-dependent, eqs 19, 20"),
               Line2D([], [], color="#444444", linewidth=1.0, label="eqs 41, 42 as random"),
               Patch(color="#E69F00", alpha=0.15, label=f"90 % of all sequences: {low:.2f} to {high:.2f} (many stations)")]
    drawing.heading(figure, title, "Standard deviation of the last position over that of eqs 41, 42 as random. "
                    f"{wording.counts_text(table['trials'])} runs a sequence.")
    drawing.legend_below(figure, handles)
    return figure


# --------------------------------------------------------------------------------------------------------------------


def main():
    arguments = one_point.parse(saving.argument_parser("Draw the figures of a vertical_well result."))
    drawing.use_style()
    with reading.open_result(arguments.result, "vertical_well") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        ellipses = reading.read_table(file, "ellipse")
        sequences = reading.read_table(file, "toolface_sequences")
        samples = reading.read_table(file, "realisations", "samples")
    if ellipses is None or ellipses.rows == 0:
        raise PlotError(f"{arguments.result}: table 'ellipse' is missing or empty")
    keys = reading.sweep_keys(config, ellipses)
    points = reading.sweep_points(ellipses, keys)
    figures = {}
    if len(points) == 1:
        figures["ellipses"] = ellipses_figure(title, wording.point_name(keys, points[0]), samples, ellipses)
    elif samples is not None:
        print("no figure of the ellipses: choose a sweep point with --point I", file=sys.stderr)
    if "drilling.sequence" in keys and sequences:
        figures["sequences"] = sequences_figure(title, sequences, keys)
    elif len(points) <= 12:
        figures["ratio"] = ratio_figure(title, ellipses, keys, points)
    saving.save_all(figures, arguments)
