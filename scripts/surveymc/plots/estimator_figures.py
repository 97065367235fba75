"""Figures that compare estimators over the tests of the thesis; drawn by surveymc plot thesis."""

import re
import textwrap

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from . import drawing, reading, wording
from .drawing import PUBLISHED
from .wording import SIGMA, number

PARAMETERS = ("gain_x", "gain_y", "gain_z", "bias_x", "bias_y", "bias_z")
DIRECTIONS = ("north", "east", "vertical")
MARKERS, COLOURS = "osD^vP", ("#0072B2", "#D55E00", "#009E73", "#A8508A", "#E69F00", "#222222")
STEP = re.compile(r"(.+): (\d+) (.+)$")


def is_ladder(parameters):
    """Whether every case is named "TEST: K STEP"."""
    return all(STEP.match(c) for c in parameters["case"])


def ladder(title, parameters, confidence):
    """3 sigma of each parameter over the steps of wls_ladder.toml: Monte Carlo, prediction, publication."""
    cases = [STEP.match(c) for c in dict.fromkeys(parameters["case"])]
    tests = list(dict.fromkeys(m[1] for m in cases))
    steps = {int(m[2]): m[3] for m in cases}
    figure, panels = drawing.panels(6, (4.1, 3.6), sharex=True)
    for ax, p in zip(panels, PARAMETERS):
        for t, test in enumerate(tests):
            points = []
            for k in steps:
                row = parameters.row(case=f"{test}: {k} {steps[k]}", quantity=f"sigma3_{p}", formulation="first_order")
                if row is not None:
                    points.append((k + 0.16 * (t - (len(tests) - 1) / 2), row))
            x = np.array([a for a, _ in points])
            mc, low, high, predicted, published = (np.array([r[c] for _, r in points]) for c in (
                "monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high", "analytic", "published"))
            ax.plot(x, mc, "-", color=COLOURS[t], linewidth=0.7, alpha=0.5, zorder=2)
            ax.errorbar(x, mc, yerr=(mc - low, high - mc), linestyle="none", marker=MARKERS[t], color=COLOURS[t],
                        markersize=5.5, zorder=4)
            ax.plot(x, predicted, linestyle="none", marker="_", color="black", markersize=11, markeredgewidth=1.5, zorder=5)
            shown = np.isfinite(published)
            ax.plot(x[shown], published[shown], linestyle="none", marker=MARKERS[t], markerfacecolor="none",
                    color=PUBLISHED, markersize=10, markeredgewidth=1.3, zorder=3)
        kind, axis = p.split("_")
        ax.set_yscale("log")
        drawing.plain_log_axis(ax.yaxis, *ax.get_ylim())
        ax.set_title(f"{kind.capitalize()} {axis}")
        ax.set_ylabel(f"3{SIGMA} of {kind} {axis}" + (" (nT)" if kind == "bias" else ""))
        ax.set_xticks(list(steps), [textwrap.fill(s, 14) for s in steps.values()], rotation=35, ha="right", fontsize=8.5)
        ax.grid(False, axis="x")
    drawing.heading(figure, title, f"3{SIGMA} of the six parameters; every step to the right knows less than the one before. "
                    f"{wording.counts_text(parameters['trials'])} trials a point; {100 * confidence:g} % intervals are drawn where "
                    "they are larger than the markers.")
    handles = [Line2D([], [], linestyle="none", marker=MARKERS[t], color=COLOURS[t], label=f"{test}, Monte Carlo")
               for t, test in enumerate(tests)]
    handles.append(Line2D([], [], linestyle="none", marker="_", color="black", markersize=11, markeredgewidth=1.5,
                          label="predicted"))
    handles.append(Line2D([], [], linestyle="none", marker="o", markerfacecolor="none", color=PUBLISHED, markersize=9,
                          label="published: table 7 at step 1, table 5 at the last"))
    drawing.legend_below(figure, handles)
    return figure


def positions(title, position, margin, confidence):
    """Position after each estimator: its 3 sigma at full noise, and predicted / Monte Carlo at every size of the noise."""
    tests, names = (list(dict.fromkeys(position[k])) for k in ("case", "estimator.name"))
    scales = sorted(set(position["noise.scale"]), reverse=True) if "noise.scale" in position else [None]
    figure, panels = plt.subplots(2, 3, figsize=(12.5, 8.2), sharex=True, layout="constrained")
    for column, d in enumerate(DIRECTIONS):
        top, bottom = panels[:, column]
        drawing.band(bottom, margin)
        unit, word = (1000, "mm") if d == "vertical" else (1, "m")
        for e, name in enumerate(names):
            for s, scale in enumerate(scales):
                at = {} if scale is None else {"noise.scale": scale}
                rows = [position.row(**{"case": t, "estimator.name": name, "quantity": f"sigma3_{d}",
                                        "formulation": "joint", **at}) for t in tests]
                x = np.arange(len(tests)) + 0.24 * (e - (len(names) - 1) / 2)
                mc, low, high, predicted = (np.array([r[c] for r in rows]) for c in (
                    "monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high", "analytic"))
                look = {"color": COLOURS[e], "marker": MARKERS[e], "linestyle": "none"}
                if s == 0:
                    mc, low, high, predicted = (v * unit for v in (mc, low, high, predicted))
                    top.errorbar(x, mc, yerr=(mc - low, high - mc), markersize=6, **look)
                    first = np.array([not reading.is_zero_to_first_order(r) for r in rows])
                    top.plot(x[first], predicted[first], linestyle="none", marker="_", color="black", markersize=13,
                             markeredgewidth=1.5, zorder=5)
                for i, row in enumerate(rows):
                    if reading.is_zero_to_first_order(row):
                        continue
                    shift = 0 if len(scales) == 1 else 0.09 * (s - (len(scales) - 1) / 2)
                    bottom.errorbar(x[i] + shift, row["ratio"], markersize=5.5, elinewidth=1.2,
                                    yerr=[[row["ratio"] - row["ratio_ci_low"]], [row["ratio_ci_high"] - row["ratio"]]],
                                    markerfacecolor="white" if s else COLOURS[e], **look)
        for i, t in enumerate(tests):
            row = position.row(case=t, quantity=f"sigma3_{d}", formulation="joint")
            if reading.is_zero_to_first_order(row):
                bottom.annotate("zero to first order", (i, 1), rotation=90, ha="center", va="center", style="italic",
                                fontsize=9, bbox={"facecolor": "white", "edgecolor": "none", "pad": 2})
        top.set_yscale("log")
        drawing.plain_log_axis(top.yaxis, *top.get_ylim())
        top.set_title(f"{d.capitalize()}")
        top.set_ylabel(f"3{SIGMA} of {d} ({word})" + (", full noise" if len(scales) > 1 else ""))
        bottom.set_ylabel("Predicted / Monte Carlo")
        bottom.set_xticks(range(len(tests)))
        bottom.set_xticklabels(tests)
        for ax in (top, bottom):
            ax.grid(False, axis="x")
    reach = max(max(abs(y - 1) for y in ax.get_ylim()) for ax in panels[1])
    for ax in panels[1]:
        ax.set_ylim(1 - reach, 1 + reach)
        ax.set_xlim(-0.55, len(tests) - 0.45)
    handles = [Line2D([], [], linestyle="none", marker=MARKERS[e], color=COLOURS[e], label=wording.quantity_name(n)) for e, n in enumerate(names)]
    handles.append(Line2D([], [], linestyle="none", marker="_", color="black", markersize=13, markeredgewidth=1.5,
                          label="predicted"))
    small = [f"hollow: noise \N{MULTIPLICATION SIGN} {s:g}" for s in scales[1:]]
    best = []  # of full noise, by test: how many times less the last estimator leaves than the first
    for t in tests:
        at = {} if scales[0] is None else {"noise.scale": scales[0]}
        first, last = (position.row(**{"case": t, "estimator.name": n, "quantity": "sigma3_north", "formulation": "joint", **at})["monte_carlo"]
                       for n in (names[0], names[-1]))
        best.append(first / last)
    drawing.heading(figure, title, f"Uncertainty of the final position: {wording.quantity_name(names[-1])} leaves {number(min(best), 2)} to "
                    f"{number(max(best), 2)} times less of the north error than {wording.quantity_name(names[0])}. Below, the prediction of it"
                    + "".join(f"; {w}" for w in small) + f". {wording.counts_text(position['trials'])} trials a point, "
                    f"{100 * confidence:g} % intervals.")
    drawing.legend_below(figure, handles + drawing.margin_handle(margin))
    return figure
