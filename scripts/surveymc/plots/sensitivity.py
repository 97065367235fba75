"""Which inputs of a sweep explain a quantity: the table `sensitivity` of a result.

    surveymc plot sensitivity RESULT.h5 [-o FOLDER]

RESULT.h5 is a run of a config with [sensitivity] (configs/sweeps/global_reference.toml). One figure a quantity: the share of
every key, alone and with its pairs, with intervals; and the quantity against the four keys that explain most, its median and
the middle 80 % of the points.
"""
import matplotlib.pyplot as plt
import numpy as np

from . import drawing, reading, saving, wording
from .reading import PlotError

SPANS = True  # keys of a sweep that has figures of its own here


def read(path):
    """Title of the result, [sensitivity] of the config, its table, and by quantity the values of the keys and of the quantity."""
    with reading.open_any(path) as file:
        title, rule = wording.title_of(file), reading.configuration(file).get("sensitivity")
        table = reading.read_table(file, "sensitivity")
        if not rule or table is None:
            raise PlotError(f"{path}: its config has no [sensitivity]")
        samples = {}
        for quantity in sorted(set(table["quantity"])):
            name, column = quantity.split(".", 1)
            values = reading.read_table(file, name)
            chosen = np.ones(values.rows, bool)
            for key, word in rule.get("where", {}).items():
                chosen &= np.array(values[key]) == word
            keys = [k for k in values if reading.text_attribute(file[f"tables/{name}/{k}"], "long_name") == "sweep key"]
            samples[quantity] = {k: np.array(values[k])[chosen] for k in keys}, np.array(values[column])[chosen]
    return title, rule, table, samples


def draw_shares(panel, rows):
    """`rows`: input -> {order: (share, low, high)}, most first."""
    places = np.arange(len(rows))[::-1]
    for order, color, shift in (("first", "C0", 0.18), ("with pairs", "C1", -0.18)):
        share, low, high = (np.array([of[order][i] for of in rows.values()]) for i in range(3))
        bars = np.clip(share, 0, None)
        panel.barh(places + shift, bars, 0.34, color=color, label="alone" if order == "first" else "with its pairs")
        panel.errorbar(bars, places + shift, xerr=[np.clip(bars - low, 0, None), np.clip(high - bars, 0, None)], fmt="none",
                       ecolor="0.2", elinewidth=0.8, capsize=2)
    panel.set_yticks(places, [wording.axis_name(key).split(" (")[0] for key in rows])
    panel.set(xlim=(0, None), xlabel="share of the variance")
    panel.legend(loc="lower right", fontsize=8)


def draw_effect(panel, key, x, y, quantity, log):
    if x.dtype.kind in "OUS":
        words = sorted(set(x), key=lambda w: np.median(y[x == w]))
        groups = [y[x == w] for w in words]
        middle = np.arange(len(words))
        panel.set_xticks(middle, words, rotation=35, ha="right", fontsize=6)
    else:
        edges = np.quantile(x, np.linspace(0, 1, 25))
        at = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, 23)
        groups = [y[at == g] for g in range(24) if (at == g).any()]
        middle = np.array([np.mean(x[at == g]) for g in range(24) if (at == g).any()])
    low, mid, high = (np.array([np.quantile(g, q) for g in groups]) for q in (0.1, 0.5, 0.9))
    if x.dtype.kind in "OUS":
        panel.errorbar(middle, mid, yerr=[mid - low, high - mid], fmt="o", color="C0", markersize=4, capsize=3)
    else:
        panel.fill_between(middle, low, high, color="C0", alpha=0.25, linewidth=0)
        panel.plot(middle, mid, color="C0")
    panel.set(xlabel=wording.axis_name(key), ylabel=wording.axis_name(quantity.split(".", 1)[1]))
    if log:
        panel.set_yscale("log")
        drawing.plain_log_axis(panel.yaxis, *panel.get_ylim())


def draw(title, rule, table, quantity, sample):
    keys, y = sample
    of_quantity = [i for i in range(table.rows) if table["quantity"][i] == quantity]
    rows = {}
    for i in of_quantity:
        if table["order"][i] in ("first", "with pairs"):
            rows.setdefault(table["input"][i], {})[table["order"][i]] = tuple(table[c][i] for c in ("share", "share_ci_low", "share_ci_high"))
    figure = plt.figure(figsize=(11, 4.8), layout="constrained")
    grid = figure.add_gridspec(2, 4)
    draw_shares(figure.add_subplot(grid[:, :2]), rows)
    good = np.isfinite(y)
    strongest = sorted(rows, key=lambda key: -rows[key]["with pairs"][0])[:4]
    for n, key in enumerate(strongest):
        draw_effect(figure.add_subplot(grid[n // 2, 2 + n % 2]), key, keys[key][good], y[good], quantity, rule.get("scale") == "log")
    drawing.heading(figure, title, f"{wording.axis_name(quantity.split('.', 1)[1])} of {wording.grouped(int(good.sum()))} points; right: the keys that "
                    "explain most, medians and the middle 80 %.")
    return figure


def main():
    arguments = saving.argument_parser("what explains a quantity of a sweep").parse_args()
    drawing.use_style()
    title, rule, table, samples = read(arguments.result)
    stem = saving.stem_of(arguments.result)
    for quantity, sample in samples.items():
        figure = draw(title, rule, table, quantity, sample)
        saving.save(figure, saving.figures_folder(arguments.output, arguments.result),
                      f"{stem}_sensitivity_{quantity.split('.', 1)[1]}")
