"""Figure of a robustness_map result: what gross errors do to the fit, by loss; PNG and SVG next to the result.

    surveymc plot robustness_map RESULT.h5 [-o FOLDER]

The error of the right stations over that of the fit that knows the wrong ones, with its interval, against the share of
wrong stations, or against the size of their errors where a sweep varies only this; one panel for each other point of the
sweep. Without such a sweep: one point a loss.
"""
import numpy as np
from matplotlib.ticker import NullLocator

from . import drawing, reading, saving, wording

SPANS = ("gross.share", "gross.size_nT", "gross.kind", "estimator.parameters")  # keys of a sweep that has figures of its own here

LOSSES = {"least_squares": ("#777777", "o", (0, (1, 1.3)), "least squares"), "l1": ("#56B4E9", "s", "-", "l1"),
          "huber": ("#E69F00", "^", "-", "Huber"), "cauchy": ("#009E73", "D", "-", "Cauchy"),
          "tukey": ("#0072B2", "v", "-", "Tukey from LMedS")}
LEVELS = (0.6, 0.7, 0.8, 0.9, 1, 1.1, 1.2, 1.5, 2, 3, 4, 5, 7, 10, 20, 50, 100)


def axis_of(table, keys):
    """The key along which a panel goes: (its column, its factor, its label), or None."""
    if "gross.share" in keys and len(set(table["gross.share"])) > 1:
        return "gross.share", 100, "stations in error (%)"
    if "gross.size_nT" in keys and len(set(table["gross.size_nT"])) > 1:
        return "gross.size_nT", 1, "size of a gross error (nT, one sd an axis)"
    return None


def draw(axes, table, rows, along):
    handles = []
    for place, (loss, (colour, marker, line, label)) in enumerate(LOSSES.items()):
        mine = [i for i in rows if table["loss"][i] == loss]
        if not mine:
            continue
        x = np.array([table[along[0]][i] * along[1] for i in mine] if along else [place] * len(mine), dtype=float)
        order = np.argsort(x)
        y, low, high = (np.array([table[f"ratio{end}"][i] for i in mine])[order] for end in ("", "_ci_low", "_ci_high"))
        handles.append(axes.errorbar(x[order], y, yerr=[y - low, high - y], color=colour, marker=marker, linestyle=line, markersize=4,
                                     linewidth=1.3, capsize=2, label=label))
    axes.axhline(1, color="#444444", linewidth=1, zorder=1)
    if along:
        axes.set_xlabel(along[2])
        if along[0] == "gross.size_nT":
            sizes = sorted(set(table[along[0]][i] for i in rows))
            if sizes[0] > 0 and sizes[-1] > 8 * sizes[0]:
                axes.set_xscale("log")
                axes.set_xticks(sizes, [f"{v:g}" for v in sizes])
                axes.xaxis.set_minor_locator(NullLocator())
    else:
        axes.set_xticks(range(len(LOSSES)), [label.split(" from")[0] for *_, label in LOSSES.values()])
    return handles


def main():
    arguments = saving.argument_parser(__doc__.splitlines()[0]).parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, "robustness_map") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        table = reading.read_table(file, "breakdown")
    keys = reading.sweep_keys(config, table)
    along = axis_of(table, keys)
    others = [k for k in keys if not along or k != along[0]]
    names = [wording.point_name(others, [table[k][i] for k in others]) for i in range(table.rows)]
    panels = {name: [i for i in range(table.rows) if names[i] == name] for name in dict.fromkeys(names)}
    figure, axes = drawing.panels(len(panels), (4.4, 3.5), columns=min(2, len(panels)), sharey=True)
    for ax, (name, rows) in zip(axes, panels.items()):
        handles = draw(ax, table, rows, along)
        ax.set_title(name, fontsize=9)
    shown = [i for i in range(table.rows) if table["loss"][i] in LOSSES]
    ends = np.concatenate([table[f"ratio_ci_{end}"][shown] for end in ("low", "high")])
    ends = ends[np.isfinite(ends)]
    low, high = min(ends.min(initial=1), 0.97) / 1.03, max(ends.max(initial=1), 1.12) * 1.03
    for ax in axes[:len(panels)]:
        ax.set_yscale("log")
        ax.set_ylim(low, high)
        ticks = [v for v in LEVELS if low <= v <= high]
        ax.set_yticks(ticks, [f"{v:g}" for v in ticks])
        ax.yaxis.set_minor_locator(NullLocator())
    axes[0].set_ylabel("error of the right stations\nover that of the informed fit")
    drawing.heading(figure, title, "1: as good as the fit that knows which stations are wrong; "
                                   f"{wording.trials_text(table)}, {100 * table.confidence:g} % intervals")
    drawing.legend_below(figure, handles)
    folder = saving.figures_folder(arguments.output, arguments.result)
    saving.save(figure, folder, saving.stem_of(arguments.result))
