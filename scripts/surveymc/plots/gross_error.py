"""Figures of a gross-error study: detection curves, or rates by strategy; PNG and SVG next to the result.

    surveymc plot gross_error RESULT.h5 [-o FOLDER]

With a sweep over `factor` (configs/gross_error/curve.toml): detection and identification against the size of the error,
one panel a case; points are Monte Carlo with their intervals, lines are predictions, the designed power is marked.
Without: one bar of outcomes (identified ... missed) for each case and strategy, and the rate of detection beside it.
"""
import functools

import matplotlib.pyplot as plt
import numpy as np

from . import drawing, reading, saving, wording

SPANS = ("factor",)  # keys of a sweep that has figures of its own here

OUTCOMES = {"identified": ("#0072B2", "", "the right ones, and only these"),
            "identified_group": ("#56B4E9", "//", "their inseparable group"),
            "identified_partly": ("#F0E442", "..", "some of them, or others with them"),
            "identified_wrong": ("#D55E00", "xx", "others only"),
            "missed": ("#DDDDDD", "", "nothing")}
STRATEGIES = ("single", "iterative", "readmission", "pairs")
LABELS = {"detection": "detected: own test rejects", "identified": "identified: own test is the largest",
          "identified_wrong": "another reading is blamed"}


def cases_of(table, keys):
    """Names of the points of the sweep by `keys`, and the rows of each."""
    names = [wording.point_name(keys, [table[k][i] for k in keys]) for i in range(table.rows)]
    return {name: [i for i in range(table.rows) if names[i] == name] for name in dict.fromkeys(names)}


def series(table, rows, formulation, quantity):
    """Factors, rates, lower and upper bounds, predictions; in the order of the factors."""
    rows = [i for i in rows if table["formulation"][i] == formulation and
            (table["quantity"][i] == quantity or
             (quantity == "detection" and table["quantity"][i].startswith("detection_") and
              table["quantity"][i] not in ("detection_any", "detection_general")))]
    rows.sort(key=lambda i: table["factor"][i])
    return [np.array([table[c][i] for i in rows]) for c in
            ("factor", "monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high", "analytic")]


def designed_power(config, keys, point, factor=None):
    """The power that the tests of a sweep point were designed for; None where its errors are not of the size that this power
    is for. factor: on the errors, the point's own if none is given."""
    at = functools.partial(reading.setting_at, config, keys, point)
    factors = [at("factor", 1) if factor is None else factor] + [e.get("factor", 1) for e in at("inject", [])]
    sized = all("size" in e for e in at("inject", []))
    return float(at("power", 0.8)) if sized and all(f in (1, -1) for f in factors) else None


def point_of(table, keys, i):
    return [table[k][i] for k in keys]


def curves_figure(title, table, keys, power_of, place):
    cases = cases_of(table, [k for k in keys if k != "factor"])
    figure, panels = drawing.panels(len(cases), (3.7, 3.6), columns=len(cases), sharey=True)
    looks = {"detection": ("nonlinear", "#0072B2", "o", "-"), "identified": ("single", "#009E73", "s", (0, (7, 2))),
             "identified_wrong": ("single", "#D55E00", "^", (0, (1, 1.3)))}
    for axes, (name, rows) in zip(panels, cases.items()):
        for quantity, (formulation, colour, marker, line) in looks.items():
            x, rate, low, high, predicted = series(table, rows, formulation, quantity)
            if len(x) == 0:
                continue
            axes.plot(x, predicted, color=colour, linestyle=line, linewidth=1.2)
            axes.errorbar(x, rate, yerr=[rate - low, high - rate], fmt=marker, color=colour, markersize=4, capsize=2,
                          linewidth=1, label=LABELS[quantity])
        power = power_of(rows[0])
        axes.axvline(1, color="#777777", linewidth=0.8)
        if power is not None:
            axes.axhline(power, color="#777777", linewidth=0.8)
            axes.plot(1, power, "D", markersize=8, markerfacecolor="none", markeredgecolor="#222222", zorder=5,
                      label="designed: power at the minimal detectable error")
        axes.set_title(f"error in {name}" if name else "", fontsize=9)
        axes.set_xlabel("size of the error (minimal detectable errors)" if power is not None else "size of the error (times that of the config)")
        axes.set_ylim(-0.02, 1.02)
    panels[0].set_ylabel("share of the runs")
    drawing.heading(figure, title, f"Points: Monte Carlo with {100 * table.confidence:g} % intervals, {wording.trials_text(table)} each; lines: predicted.{place}")
    drawing.legend_below(figure, panels[0].get_legend_handles_labels()[0])
    return figure


def place_of(config, keys, point):
    """' Inclination 85\N{DEGREE SIGN}, toolface 45\N{DEGREE SIGN}, ...' of a point whose angles are single numbers; '' without."""
    found = [(w, reading.setting_at(config, keys, point, f"{k}_deg")) for w, k in
             (("inclination", "inclination"), ("toolface", "toolface"), ("magnetic azimuth", "magnetic_azimuth"))]
    words = ", ".join(f"{w} {v:g}\N{DEGREE SIGN}" for w, v in found if isinstance(v, (int, float)))
    return f" {words[0].upper()}{words[1:]}." if words else ""


def single_figure(title, table, power, place):
    """One case, one strategy: what the tests find, and what is blamed, a line each."""
    labels = {"detection_any": "any reading's test rejects", "detection_general": "the general test rejects",
              "identified": "rejected: the right ones, and only these", "identified_group": "rejected: their inseparable group",
              "identified_partly": "rejected: some of them, or others with them", "identified_wrong": "rejected: others only",
              "missed": "nothing is rejected"}
    own = [q for q in dict.fromkeys(table["quantity"]) if q.startswith("detection_") and q not in labels]
    labels = {q: f"the test of {wording.quantity_name(q.removeprefix('detection_'))} rejects" for q in own} | labels
    shown = [q for q in labels if any(q == x and table["formulation"][i] != "design" for i, x in enumerate(table["quantity"]))]
    figure, axes = plt.subplots(figsize=(8.6, 0.4 * len(shown) + 1.8), layout="constrained")
    looks = {"linear": ("linear theory", "#D55E00", "^"), "nonlinear": ("without linearisation", "#009E73", "D")}
    handles = {}
    for y, q in enumerate(shown):
        rows = [i for i in range(table.rows) if table["quantity"][i] == q and table["formulation"][i] != "design"]
        for i in rows:
            label, colour, marker = looks.get(table["formulation"][i], ("without linearisation", "#009E73", "D"))
            handles[label], = axes.plot(table["analytic"][i], y, marker, color=colour, markersize=8, markerfacecolor="none", label=label,
                                        clip_on=False)
        rate, low, high = (table[f"monte_carlo{end}"][rows[0]] for end in ("", "_ci_low", "_ci_high"))
        handles["Monte Carlo"] = axes.errorbar(rate, y, xerr=[[max(rate - low, 0)], [max(high - rate, 0)]], fmt="o", color="#0072B2", capsize=4,
                                               markersize=4.5, zorder=4, clip_on=False, label=f"Monte Carlo, {100 * table.confidence:g} % interval")
        axes.annotate(wording.number(rate), (1, y), xycoords=("axes fraction", "data"), xytext=(10, 0), textcoords="offset points", va="center")
    if power is not None:
        handles["power"] = axes.axvline(power, color="#111111", linewidth=1, linestyle=(0, (3, 2)), label=f"designed power {power:g}")
    axes.set_yticks(range(len(shown)), [labels[q] for q in shown])
    axes.set_ylim(len(shown) - 0.5, -0.5)
    axes.set_xlim(0, 1)
    axes.set_xlabel("share of the runs (right: Monte Carlo)")
    drawing.heading(figure, title, f"{wording.trials_text(table)}.{place}")
    drawing.legend_below(figure, list(handles.values()))
    return figure


def bars_figure(title, table, keys, power_of, place):
    bars = []
    for name, rows in cases_of(table, keys).items():
        detections = [i for i in rows if table["formulation"][i] == "linear" and
                      table["quantity"][i].startswith("detection_") and
                      table["quantity"][i] not in ("detection_any", "detection_general")]
        for strategy in STRATEGIES:
            found = {table["quantity"][i]: i for i in rows if table["formulation"][i] == strategy}
            if found:
                bars.append((name, strategy, found, detections, power_of(rows[0])))
    if not bars:
        raise reading.PlotError("the result has no injected errors: nothing to draw")
    if len(bars) == 1:
        return single_figure(title, table, bars[0][-1], place)
    one_strategy = len({strategy for _, strategy, *_ in bars}) == 1
    bars = [(name if name and one_strategy else ", ".join(filter(None, (name, strategy))), *rest) for name, strategy, *rest in bars]
    figure, axes = plt.subplots(figsize=(8.6, 0.5 * len(bars) + 2.3), layout="constrained")
    interval, labelled = f"{100 * table.confidence:g} % interval", set()
    for k, (_, found, detections, _) in enumerate(bars):
        left = 0.0
        for outcome, (colour, hatch, label) in OUTCOMES.items():
            i = found[outcome]
            rate = table["monte_carlo"][i]
            axes.barh(k, rate, left=left, height=0.62, color=colour, hatch=hatch, edgecolor="#333333", linewidth=0.6,
                      label=label if outcome not in labelled and rate > 0 else None)
            labelled |= {outcome} if rate > 0 else set()
            left += rate
            if rate > 0.06:
                axes.text(left - rate / 2, k, wording.number(rate, 3), ha="center", va="center", fontsize=8, color="#111111",
                          bbox={"facecolor": "white", "edgecolor": "none", "boxstyle": "round,pad=0.25"})
            if outcome == "identified" and rate > 0:
                low, high = table["monte_carlo_ci_low"][i], table["monte_carlo_ci_high"][i]
                axes.errorbar(rate, k, xerr=[[max(rate - low, 0)], [max(high - rate, 0)]], color="#111111", capsize=3,
                              linewidth=1.2, label=interval)
                interval = None  # once is enough
        for n, i in enumerate(detections):
            axes.plot(table["monte_carlo"][i], k + 0.41, "v", color="#111111", markersize=5, clip_on=False,
                      label="its own test rejects" if k == 0 and n == 0 else None)
    powers = [power for *_, power in bars]
    if None not in powers and len(set(powers)) == 1:
        axes.axvline(powers[0], color="#111111", linewidth=1, linestyle=(0, (3, 2)), label=f"designed power {powers[0]:g}")
    else:
        label = "designed power"
        for k, power in enumerate(powers):
            if power is not None:
                axes.plot([power, power], [k - 0.5, k + 0.5], color="#111111", linewidth=1, linestyle=(0, (3, 2)), label=label)
                label = None  # once is enough
    axes.set_yticks(range(len(bars)), [b[0] for b in bars])
    axes.set_ylim(len(bars) - 0.45, -0.6)
    axes.set_xlim(0, 1)
    axes.set_xlabel("share of the runs")
    axes.grid(False)
    drawing.heading(figure, title, f"What is rejected; {wording.trials_text(table)} a line.{place}")
    drawing.legend_below(figure, axes.get_legend_handles_labels()[0])
    return figure


def main():
    parser = saving.argument_parser(__doc__.splitlines()[0])
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, "gross_error_detection") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        table = reading.read_table(file, "detection")
    if table is None or not table.rows:
        raise reading.PlotError(f"{arguments.result}: has no table 'detection': a run of events is drawn by surveymc plot collision")
    keys = reading.sweep_keys(config, table)
    curves = "factor" in keys and len(set(table["factor"])) > 3
    places = {place_of(config, keys, point) for point in reading.sweep_points(table, keys)}
    place = places.pop() if len(places) == 1 else ""
    if curves:  # the diamond is at the factor 1, whatever factors are swept
        figure = curves_figure(title, table, keys, lambda i: designed_power(config, keys, point_of(table, keys, i), 1), place)
    else:
        figure = bars_figure(title, table, keys, lambda i: designed_power(config, keys, point_of(table, keys, i)), place)
    folder = saving.figures_folder(arguments.output, arguments.result)
    saving.save(figure, folder, saving.stem_of(arguments.result))
