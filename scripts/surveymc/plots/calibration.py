"""Draw how the claims of a result hold together: calibration, looks of a stopping rule, p-values of its verdicts.

Draws what the file has, of any experiment:
  calibration  deviation of every claimed distribution from uniform, with band, margin and the shape that it resembles
  histogram    u = F(error) in 20 bins, with the interval of one bin
  looks        interval of every row that may end the run, at all looks, with the margin
  merit        figure of merit of these rows at all looks, over that of the first
  family       p-values of the rows that differ or might, against their rank, with the line of Holm's procedure

Of a sweep all but the last are drawn of the first six points, or of the one of --point (counted from 0, in the order of the
file); the last has the rows of all points. What is left out is said on stderr and in the title.
"""
import statistics
import textwrap

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .. import storage
from ..result import Result, holm
from . import drawing, reading, saving, wording
from .reading import PlotError

DATA, SHAPE, BAND, MARGIN = "#0072B2", "#D55E00", "#BBBBBB", "#3C8C50"
LEVEL = 0.05
MOST_PANELS = 24
MARKERS = "os^Dv"


def panels(count, columns, width, height, **options):
    """A figure with `count` panels, `columns` beside each other; the spare ones are hidden."""
    columns = min(columns, count)
    rows = -(-count // columns)
    figure, axes = plt.subplots(rows, columns, squeeze=False, figsize=(1 + width * columns, 1.3 + height * rows), **options)
    for ax in axes.flat[count:]:
        ax.set_visible(False)
        above = list(axes.flat).index(ax) - columns
        if above >= 0:
            axes.flat[above].xaxis.set_tick_params(labelbottom=True)
    return figure, list(axes.flat[:count])


def judged_groups(calibration):
    """(formulation, quantity) of the rows with a verdict, in the order of the file, as many as there is room for."""
    rows = zip(calibration["formulation"], calibration["quantity"], calibration["verdict"])
    return [(f, q) for f, q, verdict in rows if verdict][:MOST_PANELS]


def calibration_figure(title, calibration, pit):
    """D with band, margin and shape: one panel a quantity."""
    chosen = judged_groups(calibration)
    figure, axes = panels(len(chosen), 4, 2.7, 1.9, sharex=True, sharey=True)
    margin = float(calibration["margin"][0])
    for ax, (formulation, quantity) in zip(axes, chosen):
        one = pit.where(lambda i: pit["formulation"][i] == formulation and pit["quantity"][i] == quantity)
        said = calibration.row(formulation=formulation, quantity=quantity)
        u = one["upto"]
        ax.fill_between(u, one["band_low"] - u, one["band_high"] - u, color=BAND, alpha=0.55, linewidth=0)
        ax.axhline(0, color="black", linewidth=0.6)
        if margin > 0:
            for edge in (-margin, margin):
                ax.axhline(edge, color=MARGIN, linewidth=1, linestyle=(0, (4, 2)))
        if said["shape"]:
            ax.plot(u, one["shape"] - u, color=SHAPE, linestyle=":", linewidth=1.6)
        ax.plot(u, one["share"] - u, color=DATA, linewidth=1.2)
        ax.set_title(f"{wording.quantity_name(quantity)}: {said['verdict']}", fontsize=9)
    names = {f for f, _ in chosen}
    figure.suptitle(title + (f" ({', '.join(sorted(names))})" if len(names) == 1 else ""))
    figure.supxlabel("u = F(error), F the claimed distribution", y=0.36 / figure.get_figheight(), fontsize=10)
    figure.supylabel("Share of trials below u, less u", fontsize=10)
    handles = [Line2D([], [], color=DATA, label="found"), Patch(color=BAND, label=f"band of a right claim, {100 * calibration.confidence:g} % as a whole"),
               Line2D([], [], color=SHAPE, linestyle=":", label="shape it resembles, where it leaves the band")]
    if margin > 0:
        handles.insert(2, Line2D([], [], color=MARGIN, linestyle=(0, (4, 2)), label=f"margin {margin:g}"))
    figure.legend(handles=handles, loc="lower center", ncol=len(handles), fontsize=8)
    figure.tight_layout(rect=(0, 0.5 / figure.get_figheight(), 1, 1))
    return figure


def histogram_figure(title, calibration, pit):
    chosen = judged_groups(calibration)
    figure, axes = panels(len(chosen), 4, 2.7, 1.7, sharex=True, sharey=True)
    bins = 20
    sd = statistics.NormalDist().inv_cdf((1 + calibration.confidence) / 2)
    top = 1.0
    for ax, (formulation, quantity) in zip(axes, chosen):
        one = pit.where(lambda i: pit["formulation"][i] == formulation and pit["quantity"][i] == quantity)
        trials = float(calibration.row(formulation=formulation, quantity=quantity)["trials"])
        share = np.diff(np.concatenate([[0.0], one["share"][4::5]])) * bins
        half = sd * np.sqrt((bins - 1) / trials)
        top = max(top, share.max(), 1 + half)
        ax.axhspan(1 - half, 1 + half, color=BAND, alpha=0.55, linewidth=0)
        ax.bar((np.arange(bins) + 0.5) / bins, share, width=0.9 / bins, color=DATA)
        ax.set_title(wording.quantity_name(quantity), fontsize=9)
        ax.set_xlim(0, 1)
    axes[0].set_ylim(0, 1.12 * top)
    figure.suptitle(title)
    figure.supxlabel("u = F(error), F the claimed distribution", y=0.36 / figure.get_figheight(), fontsize=10)
    figure.supylabel("Trials in a bin over those expected", fontsize=10)
    figure.legend(handles=[Patch(color=DATA, label="found"), Patch(color=BAND, label=f"interval of one bin, {100 * calibration.confidence:g} %")],
                  loc="lower center", ncol=2, fontsize=8)
    figure.tight_layout(rect=(0, 0.5 / figure.get_figheight(), 1, 1))
    return figure


def looks_figure(title, looks):
    chosen = list(dict.fromkeys(zip(looks["table"], looks["formulation"], looks["quantity"])))[:MOST_PANELS]
    figure, axes = panels(len(chosen), 2, 4.2, 2.6, sharex=True)
    for ax, (table, formulation, quantity) in zip(axes, chosen):
        one = looks.where(lambda i: (looks["table"][i], looks["formulation"][i], looks["quantity"][i]) == (table, formulation, quantity))
        n, margin = one["trials"], float(np.nanmax(one["margin"]))
        ax.axhspan(1 - margin, 1 + margin, color=MARGIN, alpha=0.15, linewidth=0)
        ax.fill_between(n, one["ratio_ci_low"], one["ratio_ci_high"], color=DATA, alpha=0.25, linewidth=0)
        ax.plot(n, one["ratio"], color=DATA, marker="o", markersize=3)
        ax.axvline(n[-1], color="black", linewidth=0.8, linestyle=(0, (4, 2)))
        ax.set_xscale("log")
        ax.set_title(f"{wording.quantity_name(quantity)}{', ' + wording.quantity_name(formulation) if formulation else ''}: {one['decision'][-1]}", fontsize=9)
        ticks = np.unique(n[np.linspace(0, len(n) - 1, min(len(n), 5)).astype(int)])
        ax.set_xticks(ticks, [f"{int(t):,}" for t in ticks], rotation=20)
        ax.xaxis.set_minor_locator(plt.NullLocator())
    figure.suptitle(title)
    figure.supxlabel("Trials", y=0.36 / figure.get_figheight(), fontsize=10)
    figure.supylabel("Analytic / Monte Carlo", fontsize=10)
    figure.legend(handles=[Line2D([], [], color=DATA, marker="o", markersize=3, label="ratio at the look"),
                           Patch(color=DATA, alpha=0.25, label=f"interval that holds at all looks, {100 * looks.confidence:g} %"),
                           Patch(color=MARGIN, alpha=0.15, label="margin"),
                           Line2D([], [], color="black", linestyle=(0, (4, 2)), label="end of the run")],
                  loc="lower center", ncol=4, fontsize=8)
    figure.tight_layout(rect=(0, 0.5 / figure.get_figheight(), 1, 1))
    return figure


def merit_figure(title, looks):
    """Figure of merit against the trials: 1 / (standard error^2 x trials), over that of the first look."""
    chosen = list(dict.fromkeys(zip(looks["table"], looks["formulation"], looks["quantity"])))[:MOST_PANELS]
    figure, ax = plt.subplots(figsize=(6.4, 4.2))
    ax.axhspan(0.9, 1.1, color=MARGIN, alpha=0.15, linewidth=0, label="within 10 %")
    for i, (table, formulation, quantity) in enumerate(chosen):
        one = looks.where(lambda k: (looks["table"][k], looks["formulation"][k], looks["quantity"][k]) == (table, formulation, quantity))
        ax.plot(one["trials"], one["relative_merit"], marker=MARKERS[i % len(MARKERS)], markersize=4,
                label=f"{wording.quantity_name(quantity)}{', ' + wording.quantity_name(formulation) if formulation else ''}")
    ax.set_xscale("log")
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, 0.85), max(high, 1.15))
    n = np.unique(looks["trials"])
    n = np.unique(n[np.linspace(0, len(n) - 1, min(len(n), 5)).astype(int)])
    ax.set_xticks(n, [f"{int(t):,}" for t in n])
    ax.xaxis.set_minor_locator(plt.NullLocator())
    ax.set_xlabel("Trials")
    ax.set_ylabel("Figure of merit over that of the first look")
    ax.set_title(textwrap.fill(title, 60), fontsize=10)
    ax.legend(loc="lower left", fontsize=8)
    figure.tight_layout()
    return figure


def family_figure(title, result):
    """Sorted p-values of all rows and covariance tests, the smallest in sight, with Holm's line; None without rows."""
    p = np.sort(np.asarray(result.family, float))
    if len(p) == 0:
        return None
    rank = np.arange(1, len(p) + 1)
    rejected = sum(holm(list(p), LEVEL))
    figure, ax = plt.subplots(figsize=(6.4, 4.6))
    floor = 1e-12
    below = p < floor
    ax.plot(rank[~below], p[~below], linestyle="none", marker="o", markersize=4, color=DATA, label="rows of the file")
    if below.any():
        ax.plot(rank[below], np.full(below.sum(), floor), linestyle="none", marker="v", markersize=4, color=DATA,
                label="less than $10^{-12}$")
    ax.plot(rank, LEVEL / (len(p) + 1 - rank), color=SHAPE, label="Holm, 5 % for all rows together")
    ax.axhline(LEVEL, color="black", linewidth=0.8, linestyle=(0, (4, 2)), label="5 % for one row")
    ax.set_yscale("log")
    ax.set_ylim(floor / 2, 2)
    if len(p) > 30:
        ax.set_xscale("log")
        drawing.plain_log_axis(ax.xaxis, *ax.get_xlim())
    ax.set_xlabel("Rank of the row")
    ax.set_ylabel("p of a value within the margin")
    words = textwrap.fill(title, 60)
    ax.set_title(f"{words}\n{rejected} of {len(p)} rows differ among all of them", fontsize=10)
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=2, fontsize=8)
    figure.tight_layout(rect=(0, 0.48 / figure.get_figheight(), 1, 1))
    return figure


def main():
    parser = saving.argument_parser(__doc__.splitlines()[0])
    parser.add_argument("--point", type=int, metavar="I", help="only this point of a sweep, from 0 (default: the first six)")
    arguments = parser.parse_args()
    drawing.use_style()
    try:
        result = Result(arguments.result)
    except storage.ResultError as error:
        raise PlotError(str(error)) from None
    with reading.open_any(arguments.result) as file:
        tables = {n: reading.read_table(file, n) for n in ("calibration", "pit", "looks")}
    title = wording.plain_text(result.title)
    first = next((t for t in tables.values() if t is not None and t.rows), None)
    keys = [] if first is None else result.table(first.name).attrs["sweep_keys"]
    points = reading.sweep_points(first, keys) if first is not None else [()]
    figures = {}
    for i, point in reading.points_to_draw(arguments, points):
        prefix = "" if len(points) == 1 else f"point{i}_"
        heading = wording.point_title(title, keys, points, i)
        here = {n: reading.at_point(t, keys, point) for n, t in tables.items()}
        if here["calibration"] and any(here["calibration"]["verdict"]):
            figures[prefix + "calibration"] = calibration_figure(heading, here["calibration"], here["pit"])
            figures[prefix + "histogram"] = histogram_figure(heading, here["calibration"], here["pit"])
        if here["looks"] and here["looks"].rows:
            figures[prefix + "looks"] = looks_figure(heading, here["looks"])
            if "relative_merit" in here["looks"]:
                figures[prefix + "merit"] = merit_figure(heading, here["looks"])
    together = family_figure(title, result)
    if together is not None:
        figures["family"] = together
    if not figures:
        raise PlotError(f"{arguments.result}: has neither calibration, nor looks, nor rows with a verdict and a p-value")
    saving.save_all(figures, arguments)
