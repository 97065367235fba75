"""Draw how the claims of a result hold: claimed distributions of errors, and looks of a stopping rule.

Draws what the file has, of any experiment:
  calibration  the largest deviation of every claimed distribution from what was found, with interval, margin and verdict, of all points
  shapes       the whole deviation, where a claim leaves the band of a right one: how it is wrong
  looks        interval of every row that may end the run, at all looks, with the margin

Of a sweep the first six points are drawn, or the one of --point (counted from 0, in the order of the file); what is left out is
said on stderr.
"""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import drawing, reading, saving, wording
from .reading import PlotError

SPANS = True  # keys of a sweep that has figures of its own here

DATA, SHAPE, BAND, MARGIN = "#0072B2", "#D55E00", "#BBBBBB", "#3C8C50"
BAND_LEVEL = 0.05  # below this p a claim leaves the band of a right one
MOST_SHAPES, MOST_ROWS = 9, 24


def claim_name(row):
    """Words for a row of a table; "claimed" is what all formulations of claims are called."""
    other = [wording.quantity_name(row["formulation"])] if row["formulation"] not in ("", "claimed") else []
    return ", ".join([wording.quantity_name(row["quantity"]), *other])


def calibration_figure(title, table, keys, points):
    """Largest deviation of every claim, a line a quantity, a colour a point of the sweep."""
    judged = table.where(lambda i: bool(table["verdict"][i]))
    rows = [{k: v[i] for k, v in judged.items()} for i in range(judged.rows)]
    names = list(dict.fromkeys(claim_name(r) for r in rows))[:MOST_ROWS]
    palette = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    figure, ax = plt.subplots(figsize=(8.5, 1.7 + 0.34 * len(names)), layout="constrained")
    margin = max(r["margin"] for r in rows)
    ax.axvspan(-margin, margin, color=MARGIN, alpha=0.18, linewidth=0)
    ax.axvline(0, color="#444444", linewidth=1)
    counts = {}
    for r in rows:
        point = tuple(r[k] for k in keys)
        if point not in points or claim_name(r) not in names:
            continue
        counts[r["verdict"]] = counts.get(r["verdict"], 0) + 1
        n = points.index(point)
        ax.errorbar(r["deviation"], names.index(claim_name(r)) + 0.7 * ((n + 0.5) / len(points) - 0.5), color=palette[n % len(palette)],
                    xerr=[[r["deviation"] - r["deviation_ci_low"]], [r["deviation_ci_high"] - r["deviation"]]], capsize=2,
                    elinewidth=1, marker=drawing.VERDICT_MARKER.get(r["verdict"], "s"), markersize=4.5)
    ax.set_yticks(range(len(names)), names)
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("largest deviation: share of errors below a claimed quantile, less that quantile")
    said = ", ".join(f"{n} {'agree' if v == 'agrees' else 'differ' if v == 'differs' else v}" for v, n in counts.items())
    drawing.heading(figure, title, f"Claimed distributions against {wording.counts_text(judged['trials'])} trials a point: {said}. "
                    f"Intervals of {100 * table.confidence:g} % hold for the whole distribution.")
    drawing.legend_below(figure, [*(Line2D([], [], color=palette[n % len(palette)], linewidth=3, label=wording.point_name(keys, p))
                                    for n, p in enumerate(points) if keys),
                                  *(Line2D([], [], color="#444444", marker=drawing.VERDICT_MARKER[v], linestyle="none", label=v)
                                    for v in drawing.VERDICT_MARKER if v in counts),
                                  Patch(color=MARGIN, alpha=0.18, label=f"agrees: within {margin:g}")])
    return figure


def shapes_figure(title, calibration, pit, keys, points):
    """The deviation along each claim that leaves the band, the largest first; None where none does."""
    left = [i for i in range(calibration.rows) if calibration["verdict"][i] and calibration["p_band"][i] < BAND_LEVEL
            and tuple(calibration[k][i] for k in keys) in points]
    left = sorted(left, key=lambda i: -abs(calibration["deviation"][i]))
    if not left:
        return None
    figure, axes = drawing.panels(min(len(left), MOST_SHAPES), (3.4, 2.4), sharex=True, sharey=True)
    for ax, i in zip(axes, left):
        row = {k: v[i] for k, v in calibration.items()}
        one = reading.at_point(pit, [*keys, "formulation", "quantity"], [row[k] for k in (*keys, "formulation", "quantity")])
        u = one["upto"]
        ax.fill_between(u, one["band_low"] - u, one["band_high"] - u, color=BAND, alpha=0.55, linewidth=0)
        ax.axhline(0, color="black", linewidth=0.6)
        for edge in (-row["margin"], row["margin"]):
            ax.axhline(edge, color=MARGIN, linewidth=1, linestyle=(0, (4, 2)))
        if row["shape"]:
            ax.plot(u, one["shape"] - u, color=SHAPE, linestyle=":", linewidth=1.6)
        ax.plot(u, one["share"] - u, color=DATA, linewidth=1.2)
        point = wording.point_name(keys, [row[k] for k in keys])
        ax.set_title("\n".join(filter(None, (claim_name(row), point, row["note"].split(";")[0] if row["shape"] else ""))), fontsize=8.5)
        ax.set_xlim(0, 1)
    axes[0].set_ylabel("share below it, less u")
    for ax in axes[-3:]:
        ax.set_xlabel("claimed quantile u")
    drawing.heading(figure, title, f"{len(left)} of the claims leave the band that a right one keeps to with {100 * calibration.confidence:g} %"
                    + (f"; the {MOST_SHAPES} largest." if len(left) > MOST_SHAPES else "."))
    drawing.legend_below(figure, [Line2D([], [], color=DATA, label="found"), Patch(color=BAND, label="band of a right claim"),
                                  Line2D([], [], color=MARGIN, linestyle=(0, (4, 2)), label="margin"),
                                  Line2D([], [], color=SHAPE, linestyle=":", label="what it resembles")])
    return figure


def looks_figure(title, looks):
    """Intervals of the rows that may end the run, at every look."""
    named = ["table", "formulation", "quantity"]
    chosen = reading.sweep_points(looks, named)[:MOST_ROWS]
    figure, axes = drawing.panels(len(chosen), (4.4, 2.5), columns=min(2, len(chosen)), sharex=True)
    for ax, row in zip(axes, chosen):
        one = reading.at_point(looks, named, row)
        n, margin = one["trials"], float(np.nanmax(one["margin"]))
        ax.axhspan(1 - margin, 1 + margin, color=MARGIN, alpha=0.15, linewidth=0)
        ax.fill_between(n, one["ratio_ci_low"], one["ratio_ci_high"], color=DATA, alpha=0.25, linewidth=0)
        ax.plot(n, one["ratio"], color=DATA, marker="o", markersize=3)
        ax.axvline(n[-1], color="black", linewidth=0.8, linestyle=(0, (4, 2)))
        ax.set_xscale("log")
        ax.set_title(f"{claim_name(dict(zip(named, row)))}: {one['decision'][-1]}", fontsize=9)
        ticks = np.unique(n[np.linspace(0, len(n) - 1, min(len(n), 5)).astype(int)])
        ax.set_xticks(ticks, [wording.grouped(int(t)) for t in ticks], rotation=20)
        ax.xaxis.set_minor_locator(plt.NullLocator())
    axes[0].set_ylabel("analytic / Monte Carlo")
    for ax in axes[-2:]:
        ax.set_xlabel("trials")
    merit = looks["relative_merit"][np.isfinite(looks["relative_merit"])] if "relative_merit" in looks else []
    drawing.heading(figure, title, f"The run ended after {wording.counts_text(looks['trials'][-1:])} trials; intervals hold at all looks "
                    f"together, {100 * looks.confidence:g} %." + ("" if not len(merit) else
                    " A trial was worth at least " + wording.number(np.min(merit), 2) + " of one before the first look (below 0.9: heavy tails)."))
    drawing.legend_below(figure, [Line2D([], [], color=DATA, marker="o", markersize=3, label="ratio at the look"),
                                  Patch(color=DATA, alpha=0.25, label="its interval"), Patch(color=MARGIN, alpha=0.15, label="margin"),
                                  Line2D([], [], color="black", linestyle=(0, (4, 2)), label="end of the run")])
    return figure


def main():
    parser = saving.argument_parser(__doc__.splitlines()[0])
    parser.add_argument("--point", type=int, metavar="I", help="only this point of a sweep, from 0 (default: the first six)")
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_any(arguments.result) as file:
        tables = {n: reading.read_table(file, n) for n in ("calibration", "pit", "looks")}
        title = wording.title_of(file)
        first = next((t for t in tables.values() if t is not None and t.rows), None)
        keys = [] if first is None else [k for k in first if reading.text_attribute(file[f"tables/{first.name}/{k}"], "long_name") == "sweep key"]
    if first is None:
        raise PlotError(f"{arguments.result}: has neither calibration nor looks")
    points = reading.sweep_points(first, keys)
    drawn = reading.points_to_draw(arguments, points)
    figures = {}
    claims = tables["calibration"]
    if claims and any(claims["verdict"]):
        chosen = [p for _, p in drawn]
        figures["calibration"] = calibration_figure(title, claims, keys, chosen)
        figures["shapes"] = shapes_figure(title, claims, tables["pit"], keys, chosen)
    for i, point in drawn if tables["looks"] else []:
        here = reading.at_point(tables["looks"], keys, point)
        here.confidence = tables["looks"].confidence
        if here.rows:
            figures["looks" if len(points) == 1 else f"point{i}_looks"] = looks_figure(wording.point_title(title, keys, points, i), here)
    saving.save_all(figures, arguments)
