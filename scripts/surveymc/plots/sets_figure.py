"""Figure of parameter sets of a run (`estimate` with estimator "multistation"): what the run justifies, and what each set and loss
predicts of stations that its fit has not seen."""

import numpy as np
from matplotlib.lines import Line2D

from . import drawing
from .wording import number

LOSSES = {"least_squares": ("least squares", "#222222", "o"), "l1": ("l1", "#E69F00", "^"), "huber": ("huber", "#0072B2", "s"),
          "cauchy": ("cauchy", "#009E73", "D"), "tukey": ("tukey from lmeds", "#A8508A", "v")}
RAW = "#D55E00"


def figure(title, table):
    """A panel a measure; a place a set, a mark a loss; the dashed line is what readings have without correction."""
    names = list(dict.fromkeys(table["set"]))
    measures = [("nees_median", "NEES of held-out stations, by medians", 1.0, ""), ("coverage_95", "Held-out stations in their 95 % ellipsoid", 0.95, ""),
                ("sd_total_field_nT", "Spread of the total field (nT)", None, "raw_sd_total_field_nT"),
                ("sd_dip_deg", "Spread of the dip (\N{DEGREE SIGN})", None, "raw_sd_dip_deg"),
                ("sd_gravity_mps2", "Spread of gravity (m/s\N{SUPERSCRIPT TWO})", None, "raw_sd_gravity_mps2")]
    if np.any(np.isfinite(table["axis_rms_deg"])):
        measures.append(("axis_rms_deg", "Scatter of the axis turned about (\N{DEGREE SIGN})", None, "raw_axis_rms_deg"))
    drawn, axes = drawing.panels(1 + len(measures), (3.7, 2.8), columns=4 if len(measures) > 5 else 3)
    judged = table.where(lambda i: table["loss"][i] == "least_squares")
    known = np.isfinite(judged["difference"])
    axes[0].bar(np.flatnonzero(known), judged["difference"][known], color=["#009E73" if j == "justified" else "#BBBBBB" for j, k in
                                                                             zip(judged["judgement"], known) if k])
    for place, (value, judgement) in enumerate(zip(judged["difference"], judged["judgement"])):
        axes[0].annotate("no fit" if not np.isfinite(value) else judgement if value == 0 else f"+{value:.0f}", (place, value if np.isfinite(value) else 0),
                         xytext=(0, 3), textcoords="offset points", ha="center", fontsize=8)
    axes[0].set_title("Information criterion above the least")
    axes[0].margins(y=0.15)
    for ax, (column, name, right, raw) in zip(axes[1:], measures):
        for k, (loss, (_, colour, marker)) in enumerate(LOSSES.items()):
            rows = table.where(lambda i: table["loss"][i] == loss)
            x = [names.index(n) + 0.14 * (k - 2) for n in rows["set"]]
            ax.plot(x, rows[column], linestyle="none", color=colour, marker=marker, markersize=5)
        if right is not None:
            ax.axhline(right, color="#444444", linewidth=1.0, zorder=1)
        if raw:
            ax.axhline(np.nanmax(judged[raw]), color=RAW, linestyle=(0, (5, 2)), linewidth=1.3, zorder=1)
        values = np.concatenate([table[column], judged[raw]]) if raw else table[column]
        values = values[np.isfinite(values) & (values > 0)]
        if column != "coverage_95" and len(values) and values.max() > 8 * values.min():
            ax.set_yscale("log")
        elif raw:
            ax.set_ylim(0, 1.08 * values.max() if len(values) else None)
        ax.set_title(name)
    for ax in axes:
        ax.set_xticks(range(len(names)), [n if len(n) < 8 else "own" for n in names])
        ax.grid(False, axis="x")
        ax.set_xlabel("parameters")
    drawing.heading(drawn, title, "Sets of 6 to 21 errors of the tool: each station is judged by a fit of the others. No truth is known here: a set can be "
                    "justified and predict, not be right.")
    handles = [Line2D([], [], linestyle="none", color=colour, marker=marker, label=label) for label, colour, marker in LOSSES.values()]
    drawing.legend_below(drawn, [*handles, Line2D([], [], color=RAW, linestyle=(0, (5, 2)), label="as read"),
                                 Line2D([], [], color="#444444", label="if all is as claimed")])
    return drawn
