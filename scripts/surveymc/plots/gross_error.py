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


def curves_figure(title, table, keys, power_of, confidence):
    cases = cases_of(table, [k for k in keys if k != "factor"])
    figure, panels = plt.subplots(1, len(cases), figsize=(max(3.7 * len(cases), 6) + 0.6, 4.8), squeeze=False, sharey=True)
    looks = {"detection": ("nonlinear", "#0072B2", "o", "-"), "identified": ("single", "#009E73", "s", (0, (7, 2))),
             "identified_wrong": ("single", "#D55E00", "^", (0, (1, 1.3)))}
    for axes, (name, rows) in zip(panels[0], cases.items()):
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
    panels[0][0].set_ylabel("share of the runs")
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="lower center", ncols=2, fontsize=8)
    figure.suptitle(f"{title}\npoints: Monte Carlo with {100 * confidence:g} % intervals; lines: predicted",
                    fontsize=10)
    figure.tight_layout(rect=(0, 0.11, 1, 1))
    return figure


def bars_figure(title, table, keys, power_of, confidence):
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
    one_strategy = len({strategy for _, strategy, *_ in bars}) == 1
    bars = [(name if name and one_strategy else ", ".join(filter(None, (name, strategy))), *rest) for name, strategy, *rest in bars]
    figure, axes = plt.subplots(figsize=(8.6, 0.5 * len(bars) + 2.3))
    interval = f"{100 * confidence:g} % interval"
    for k, (_, found, detections, _) in enumerate(bars):
        left = 0.0
        for outcome, (colour, hatch, label) in OUTCOMES.items():
            i = found[outcome]
            rate = table["monte_carlo"][i]
            axes.barh(k, rate, left=left, height=0.62, color=colour, hatch=hatch, edgecolor="#333333", linewidth=0.6,
                      label=label if k == 0 else None)
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
    axes.set_xlabel("share of the runs: what is rejected")
    axes.grid(False)
    figure.legend(loc="lower center", ncols=3, fontsize=8)
    figure.suptitle(title, fontsize=10)
    figure.tight_layout(rect=(0, 0.75 / figure.get_figheight(), 1, 1))
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
    if curves:  # the diamond is at the factor 1, whatever factors are swept
        figure = curves_figure(title, table, keys, lambda i: designed_power(config, keys, point_of(table, keys, i), 1), table.confidence)
    else:
        figure = bars_figure(title, table, keys, lambda i: designed_power(config, keys, point_of(table, keys, i)), table.confidence)
    folder = saving.figures_folder(arguments.output, arguments.result)
    saving.save(figure, folder, saving.stem_of(arguments.result))
