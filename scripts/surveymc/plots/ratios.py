"""Figures of ratios, prediction and Monte Carlo: marks on named lines, or curves; with intervals, margins and verdicts."""

import numpy as np
from matplotlib.lines import Line2D

from . import drawing, reading

BAND = {"color": "#009E73", "alpha": 0.18, "linewidth": 0, "zorder": 0}


def some(values, most):
    """At most so many of them, evenly spread, with the first and the last."""
    if len(values) <= most:
        return list(values)
    return [values[round(i)] for i in np.linspace(0, len(values) - 1, most)]


def _finish(figure, title, text, handles, confidence, margins, published):
    handles = [*handles, drawing.interval_handle(confidence)]
    handles += [Line2D([], [], color=drawing.PUBLISHED, marker="x", linestyle="none", markeredgewidth=1.6, label="published")] if published else []
    margins = [m for m in margins if m and np.isfinite(m)]
    handles += drawing.margin_handle(min(margins), max(margins)) if margins else []
    drawing.heading(figure, title, text)
    drawing.legend_below(figure, handles)
    return figure


def lines_figure(title, text, panels, names, confidence, columns=None, more_handles=()):
    """A line a name in every panel. panels: (title, {name: [(row of a comparison, end of its columns, is hollow)]});
    names: {name: (label, colour)}, top to bottom. The mark is that of the row's verdict, the band that of its own margin."""
    names = {n: look for n, look in names.items() if any(n in marks for _, marks in panels)}
    columns = columns or min(len(panels), 3)
    high = 0.3 * len(names) + 0.6 + 1.8 / -(-len(panels) // columns)  # heading and legend need room in the figure of one panel too
    figure, axes = drawing.panels(len(panels), (4.0, high), columns=columns, least_wide=9, sharex=True, sharey=True)
    ends, verdicts, margins, published = [1.0], set(), [], False
    for ax, (name, marks) in zip(axes, panels):
        ax.axvline(1, color="#444444", linewidth=1.0, zorder=1)
        for y, n in enumerate(names):
            numbers = []
            for k, (row, end, is_hollow) in enumerate(marks.get(n, ())):
                value, low, upper = (row[f"ratio{end}{e}"] for e in ("", "_ci_low", "_ci_high"))
                if not np.isfinite(value) or value < reading.ZERO_TO_FIRST_ORDER:
                    numbers.append("zero to first order" if np.isfinite(value) else "no value")
                    continue
                at = y + 0.5 * ((k + 0.5) / len(marks[n]) - 0.5)
                if np.isfinite(row.get("margin", np.nan)):
                    margins.append(row["margin"])
                    ax.fill_betweenx([y - 0.45, y + 0.45], 1 - row["margin"], 1 + row["margin"], **BAND)
                ax.errorbar(value, at, xerr=[[value - low], [min(upper, 1e9) - value]], color=names[n][1], markersize=6, elinewidth=1.4,
                            fmt=drawing.VERDICT_MARKER.get(row["verdict"], "s"), markerfacecolor="white" if is_hollow else None, zorder=4)
                verdicts.add(row["verdict"])
                ends += [e for e in (low if low > 0 else value, upper if upper < np.inf else value)]
                numbers.append(f"{value:.3f}")
                said = row.get(f"published_ratio{end}", np.nan)
                if np.isfinite(said) and said > 0:
                    ax.plot(said, at, "x", color=drawing.PUBLISHED, markersize=7, markeredgewidth=1.6, zorder=5)
                    published, ends = True, [*ends, said]
            ax.annotate(", ".join(dict.fromkeys(numbers)), (1, y), xycoords=("axes fraction", "data"), xytext=(5, 0),
                        textcoords="offset points", va="center", fontsize=8.5)
        ax.set_title(name)
        ax.grid(False, axis="y")
    axes[0].set_yticks(range(len(names)), [label for label, _ in names.values()])
    axes[0].set_ylim(len(names) - 0.4, -0.6)
    axes[0].set_xscale("log")
    low, upper = min([*ends, *(1 - 1.3 * m for m in margins)]) / 1.1, max([*ends, *(1 + 1.3 * m for m in margins)]) * 1.1
    axes[0].set_xlim(low, upper)
    drawing.plain_log_axis(axes[0].xaxis, low, upper)
    for ax in axes[-columns:]:
        ax.set_xlabel("predicted / Monte Carlo (right: the number)")
    handles = [Line2D([], [], linestyle="none", marker=drawing.VERDICT_MARKER[v], color="#444444", label=v)
               for v in drawing.VERDICT_MARKER if v in verdicts]
    return _finish(figure, title, text, [*handles, *more_handles], confidence, margins, published)


def curves_figure(title, text, panels, looks, key, confidence, margin, x_label, sizes=(), is_found_over_predicted=False):
    """Three panels a row, a curve a look. panels: (title, {label: rows}, note, {label: (x, y) of a dashed curve});
    looks: {label: (colour, line, marker)}; key: the abscissa, on a logarithmic axis with ticks at `sizes` if there are any."""
    figure, axes = drawing.panels(len(panels), (4.0, 2.7 + 1.6 / -(-len(panels) // 3)), columns=3, sharex=True, sharey="row")
    ends = {}  # of every row of panels
    for k, (ax, (name, curves, note, dashed)) in enumerate(zip(axes, panels)):
        drawing.band(ax, margin)
        seen = ends.setdefault(k // 3, [1 - 1.3 * (margin or 0.03), 1 + 1.3 * (margin or 0.03)])
        for c, (label, rows) in enumerate(curves.items()):
            colour, line, marker = looks[label]
            order = np.argsort(rows[key]) if key in rows else np.arange(rows.rows)
            x = rows[key][order] if key in rows else np.ones(rows.rows)
            x = x * 1.025 ** (c - (len(curves) - 1) / 2) if len(sizes) else x  # side by side, not on top of each other
            y, low, high = (rows[n][order] for n in ("ratio", "ratio_ci_low", "ratio_ci_high"))
            y, low, high = (1 / y, 1 / high, 1 / low) if is_found_over_predicted else (y, low, high)
            ax.errorbar(x, y, yerr=[np.maximum(y - low, 0), np.maximum(high - y, 0)], color=colour, linestyle=line, marker=marker,
                        markersize=5.5, elinewidth=1.2)
            seen += [*low, *high]
            if label in dashed:
                ax.plot(*dashed[label], color=colour, linestyle=(0, (4, 2)), linewidth=1.1, zorder=1.5)
        if note:
            ax.annotate(note, (0.03, 0.04), xycoords="axes fraction", style="italic", fontsize=8.5)
        ax.set_title(name)
    for k, ax in enumerate(axes):
        seen = np.array(ends[k // 3])
        low, high = np.min(seen[seen > 0]), np.max(seen[np.isfinite(seen)])
        if high > 2 * low:
            ax.set_yscale("log")
            low, high = low / 1.15, high * 1.12
            drawing.plain_log_axis(ax.yaxis, low, high)
        else:
            low, high = low - 0.1 * (high - low), high + 0.06 * (high - low)
        ax.set_ylim(low, high)
        if len(sizes):
            ax.set_xscale("log")
            drawing.plain_log_axis(ax.xaxis, sizes[0] / 1.2, sizes[-1] * 1.2)
            if len(sizes) <= 8:
                ax.set_xticks(sizes)
            ax.set_xlim(sizes[0] / 1.25, sizes[-1] * 1.25)
        if k % 3 == 0:
            ax.set_ylabel("Monte Carlo / predicted" if is_found_over_predicted else "predicted / Monte Carlo")
        if k >= len(axes) - 3:
            ax.set_xlabel(x_label)
    handles = [Line2D([], [], color=colour, linestyle=line, marker=marker, label=label) for label, (colour, line, marker) in looks.items()]
    if any(p[3] for p in panels):
        handles.append(Line2D([], [], color="#444444", linestyle=(0, (4, 2)), linewidth=1.1, label="second order"))
    return _finish(figure, title, text, handles, confidence, [margin], False)
