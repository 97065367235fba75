"""Figures of a collision or rare_event result, or of a run of events: how likely is it, and how far to be trusted?

    surveymc plot collision RESULT.h5 [-o FOLDER] [--point I]
"""

import matplotlib.pyplot as plt
import numpy as np

from . import drawing, reading, saving, wording

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#A8508A", "#222222", "#E69F00")
MOST_CURVES = 12
MARKERS = ("o", "s", "^", "D", "v", "P")


def rows(table, **wanted):
    return table.where(lambda i: all(table[k][i] == v for k, v in wanted.items()))


def distinct(values):
    return list(dict.fromkeys(values))


def intervals(table):
    p = np.asarray(table["monte_carlo"])
    return np.clip(np.array([p - table["monte_carlo_ci_low"], table["monte_carlo_ci_high"] - p]), 0, None)


def events_of(table):
    return distinct(zip(table["offset"], table["correlation"]))


def probability(table):
    """Probability against the least separation factor; what the wells share joins the points of an offset."""
    form = rows(table, formulation="form")
    figure, ax = plt.subplots(figsize=(7.5, 5.2), layout="constrained")
    seen = []
    for k, offset in enumerate(distinct(form["offset"])):
        own = rows(form, offset=offset)
        order = np.argsort(own["separation_factor"])
        ax.errorbar(np.asarray(own["separation_factor"])[order], np.asarray(own["monte_carlo"])[order],
                    intervals(own)[:, order], color=COLOURS[k % 6], marker=MARKERS[k % 6], linewidth=1.2, label=offset)
        places = {}  # correlations that make no difference share a mark, and a text
        for i in order:
            place = tuple(float(f"{own[key][i]:.3g}") for key in ("separation_factor", "monte_carlo"))
            places.setdefault(place, []).append(i)
        for at in places.values():
            text = ", ".join(wording.quantity_name(own["correlation"][i]) for i in at)
            drawing.label_points(ax, text, (own["separation_factor"][at[0]], own["monte_carlo"][at[0]]), fontsize=7.5)
        seen += [v for key in ("monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high") for v in own[key] if v > 0]
    ax.axvline(1, color="#777777", linewidth=1)
    ax.set(yscale="log", xlabel="least separation factor", ylabel="probability that the wells touch")
    if seen:
        logarithmic(ax.yaxis, min(seen) / 2, min(2 * max(seen), 1.1))
    ax.margins(x=0.12)
    ax.legend()
    ax.set_title("Probability and separation factor (bars: "
                 f"{100 * table.confidence:g} % intervals; line: factor 1)", loc="left", fontsize=10)
    return figure


def logarithmic(axis, low, high):
    """The axis of a panel between these limits, logarithmic, with ticks to read."""
    axis.axes.set(**{f"{axis.axis_name}lim": (low, high)})
    drawing.plain_log_axis(axis, low, high)


def contact(table):
    events = events_of(table)
    figure, axes = plt.subplots(len(events), 2, figsize=(9, 1.0 + 1.5 * len(events)), squeeze=False, layout="constrained")
    for line, (offset, correlation) in zip(axes, events):
        for ax, well in zip(line, ("reference", "offset")):
            own = rows(table, offset=offset, correlation=correlation, well=well)
            low, high = np.asarray(own["from_md_m"]), np.asarray(own["to_md_m"])
            ax.bar(low, own["share"], high - low, align="edge", color="#0072B2", edgecolor="white", linewidth=0.5)
            ax.set_title(f"{offset}, {wording.quantity_name(correlation)}: {well} well", loc="left", fontsize=9)
            ax.set_ylabel("share")
    for ax in axes[-1]:
        ax.set_xlabel("measured depth where they touch (m)")
    return figure


def importance(table):
    events = events_of(table)
    columns = min(4, len(events))
    lines = -(-len(events) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(1.5 + 2.7 * columns, 3.6 * lines), squeeze=False,
                                layout="constrained")
    for ax in axes.flat[len(events):]:
        ax.set_axis_off()
    for ax, (offset, correlation) in zip(axes.flat, events):
        own = rows(table, offset=offset, correlation=correlation, component=0)
        sums = {}
        for code, mode, well, factor in zip(own["code"], own["mode"], own["well"], own["factor"]):
            bar = sums.setdefault(f"{code} {mode}".strip(), {})
            side = well if well in ("reference", "both") else "offset"
            bar[side] = bar.get(side, 0) + factor
        top = sorted(sums, key=lambda c: -sum(sums[c].values()))[:12][::-1]
        left = np.zeros(len(top))
        for side, colour in (("reference", "#0072B2"), ("offset", "#E69F00"), ("both", "#222222")):
            width = np.array([sums[c].get(side, 0) for c in top])
            ax.barh(range(len(top)), width, left=left, color=colour, label=side)
            left += width
        ax.set_yticks(range(len(top)), top, fontsize=8)
        ax.set_xlabel("part of \N{GREEK SMALL LETTER BETA}\N{SUPERSCRIPT TWO}")
        ax.set_title(f"{offset},\n{correlation}", fontsize=9)
    axes[0][0].legend(fontsize=8, loc="lower right")
    return figure


def plane(hits, closest):
    events = events_of(closest)
    # Where the closest pair is that of the slots, it does not move.
    seen = [e for e in range(len(events)) if np.any(np.asarray(hits["event"]) == e + 1) and closest["towards_m2"][e] > 1e-3]
    if not seen:
        return None
    columns = min(4, len(seen))
    lines = -(-len(seen) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(3.6 * columns, 3.6 * lines), squeeze=False, layout="constrained")
    angle = np.linspace(0, 2 * np.pi, 200)
    for ax in axes.flat[len(seen):]:
        ax.set_axis_off()
    for ax, e in zip(axes.flat, seen):
        own = hits.where(lambda i: hits["event"][i] == e + 1)
        row = {k: closest[k][e] for k in closest}
        weight = np.asarray(own["weight"])
        ax.scatter(own["towards_m"], own["across_m"], s=0.5 + 25 * weight / weight.max(), color="#0072B2", alpha=0.5,
                   linewidths=0, rasterized=True)
        c = np.array([[row["towards_m2"], row["cross_m2"]], [row["cross_m2"], row["across_m2"]]])
        values, vectors = np.linalg.eigh(c)
        for k in (1, 2, 3):
            curve = vectors @ (np.sqrt(np.maximum(values, 0))[:, None] * np.array([np.cos(angle), np.sin(angle)])) * k
            ax.plot(row["distance_m"] + curve[0], curve[1], color="#D55E00", linewidth=1)
        ax.fill(row["radii_m"] * np.cos(angle), row["radii_m"] * np.sin(angle), facecolor="none", edgecolor="#222222")
        ax.plot(row["distance_m"], 0, "+", color="#222222")
        ax.set_aspect("equal", adjustable="datalim")
        ax.set(xlabel="towards the offset (m)", ylabel="across (m)")
        ax.set_title("{}, {}".format(*events[e]), fontsize=9)
    return figure


def multiplier(table):
    """Probability, hypothesis test and separation factor against the size of the errors."""
    figure, ax = plt.subplots(figsize=(7.5, 5), layout="constrained")
    factor = ax.twinx()
    for k, (offset, correlation) in enumerate(events_of(table)):
        own = rows(table, offset=offset, correlation=correlation)
        size = {f: rows(own, formulation=f) for f in distinct(own["formulation"])}
        form = size["form"]
        x = form["errors.multiplier"]
        ax.errorbar(x, form["monte_carlo"], intervals(form), color=COLOURS[k % 6], marker="o",
                    label=f"{offset}, {correlation}: probability")
        test = size["half_space_least_sf"]
        ax.plot(x, test["analytic"], color=COLOURS[k % 6], linestyle="--", label="hypothesis test at the least factor")
        factor.plot(x, form["separation_factor"], color="#777777", linestyle=":", label="separation factor")
    ax.set(xscale="log", yscale="log", xlabel="errors times", ylabel="probability")
    x = sorted(set(table["errors.multiplier"]))
    ax.set_xticks(x, [f"{v:g}" for v in x])
    ax.minorticks_off()
    factor.set_ylabel("separation factor (dotted)")
    factor.grid(False)
    ax.legend(loc="center right", fontsize=8)
    ax.set_title("Probability and separation factor against the size of all errors", loc="left")
    return figure


def crossing(table, closest):
    """From disc to slab: probability against the angle at which the wells pass each other."""
    correlation = closest["correlation"][0]
    own = rows(closest, correlation=correlation)
    order = np.argsort(own["crossing_deg"])
    angle = np.asarray(own["crossing_deg"])[order]
    figure, ax = plt.subplots(figsize=(7.5, 5), layout="constrained")
    of = {f: [rows(table, offset=own["offset"][i], correlation=correlation, formulation=f) for i in order]
          for f in ("form", "slab", "disc", "half_space")}
    for formulation, colour in (("half_space", "#A8508A"), ("slab", "#009E73"), ("disc", "#D55E00")):
        ax.plot(angle, [t["analytic"][0] for t in of[formulation]], "--", color=colour,
                label=wording.quantity_name(formulation))
    found = of["form"]
    half = np.hstack([intervals(t) for t in found])
    ax.errorbar(angle, [t["monte_carlo"][0] for t in found], half, color="#0072B2", marker="o", label="whole wells")
    ax.set(xscale="log", yscale="log", xlabel="angle at which the wells pass each other (deg)", ylabel="probability")
    apart = [x for k, x in enumerate(angle) if k == 0 or x > 1.2 * max(angle[:k])]
    ax.set_xticks(apart, [f"{x:.3g}" for x in apart])
    ax.minorticks_off()
    ax.legend(fontsize=8)
    ax.set_title("Probability against the angle of crossing", loc="left")
    return figure


def factors(table):
    """Which draws make an event: parts of beta squared."""
    events = distinct(table["event"])
    figure, axes = plt.subplots(1, len(events), figsize=(1.5 + 3.4 * len(events), 3.6), squeeze=False, layout="constrained")
    for ax, event in zip(axes[0], events):
        own = rows(table, event=event, component=0)
        top = slice(0, 12)
        ax.barh([wording.quantity_name(c) for c in own["code"][top][::-1]], np.asarray(own["factor"])[top][::-1], color="#0072B2")
        ax.set_xlabel("part of \N{GREEK SMALL LETTER BETA}\N{SUPERSCRIPT TWO}")
        ax.set_title(event, fontsize=9)
    return figure


def predictions(table, sampling):
    """Probability of every event with its interval, what subset simulation has, and what was predicted."""
    events = distinct(table["event"])
    formulations = distinct(table["formulation"])
    figure, ax = plt.subplots(figsize=(7.5, 1.9 + 0.9 * len(events)), layout="constrained")
    seen, labelled = [], set()

    def label(name):
        is_new = name not in labelled
        labelled.add(name)
        return name if is_new else None
    for y, event in enumerate(events):
        own, drawn = rows(table, event=event), rows(sampling, event=event)
        p, low, high = (own[k][0] for k in ("monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high"))
        note = "" if drawn["trusted"][0] else " (not trusted)"
        seen += [v for v in (p, low, high, *own["analytic"]) if v > 0]
        if p > 0:
            ax.errorbar([p], [y], xerr=[[p - max(low, 0)], [max(high - p, 0)]], color="#0072B2", marker="o", capsize=4,
                        label=label("estimate and interval"))
        elif high > 0:
            ax.plot([high], [y], color="#0072B2", marker="<", linestyle="none", label=label("upper end of the interval"))
        at = p if p > 0 else high if high > 0 else 1
        seen.append(at)
        ax.annotate(f"{wording.number(p)}{note}", (at, y), xytext=(0, 9), textcoords="offset points",
                    ha="center", fontsize=8)
        check = drawn["subset_probability"][0]
        if check > 0:
            bounds = np.clip([check - drawn["subset_ci_low"][0], drawn["subset_ci_high"][0] - check], 0, None)
            ax.errorbar([check], [y - 0.18], xerr=bounds[:, None], color="#777777", marker="s", markersize=4, capsize=3,
                        label=label("subset simulation"))
            seen.append(check)
        for k, formulation in enumerate(formulations):
            for value in rows(own, formulation=formulation)["analytic"]:
                if value > 0:
                    ax.plot([value], [y + 0.18], linestyle="none", marker=MARKERS[(k + 2) % 6], color=COLOURS[(k + 1) % 6],
                            label=label(wording.quantity_name(formulation)))
    ax.set(xscale="log", ylim=(len(events) - 0.4, -0.6), xlabel="probability")
    logarithmic(ax.xaxis, min(seen, default=1e-9) / 3, max(seen, default=1) * 3)
    ax.set_yticks(range(len(events)), events)
    ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    ax.set_title("What was found, and what was predicted", loc="left")
    return figure


def convergence(hits, probability, sampling, most_kept):
    """Estimate and 95 % band (normal) of the trials whose hits are kept, over the estimate of all.

    hits: by number of the event in the order of `sampling`; most_kept: of how many trials they are kept, if there are so many.
    """
    named = [k for k in ("offset", "correlation", "event") if k in sampling]
    points = reading.sweep_points(sampling, named)
    estimates = [(", ".join(e), rows(probability, **dict(zip(named, e)))["monte_carlo"][0]) for e in points]
    evaluations = sampling["evaluations"].astype(int)
    numbers = distinct(hits["event"])
    shown = [int(n) for n in numbers if estimates[int(n) - 1][1] > 0]
    figure, ax = plt.subplots(figsize=(7.5, 5), layout="constrained")
    low, high = 0.4, 1.8
    for k, event in enumerate(shown[:MOST_CURVES]):
        name, found = estimates[event - 1]
        kept = min(most_kept, evaluations[event - 1])
        own = hits.where(lambda i: hits["event"][i] == event)
        order = np.argsort(own["trial"], kind="stable")
        n = np.append(np.asarray(own["trial"])[order] + 1, kept)  # up to the last of them, whether or not it hit
        w = np.append(np.asarray(own["weight"])[order], 0)
        s, q = np.cumsum(w), np.cumsum(w * w)
        p, half = s / n / found, 1.96 * np.sqrt(np.maximum(q - s * s / n, 0)) / n / found
        keep = (n > 20) | (n == kept)
        ax.plot(n[keep], p[keep], color=COLOURS[k % 6], linestyle=("-", "--")[k // 6], label=f"{name}: {wording.number(found)}")
        ax.fill_between(n[keep], (p - half)[keep], (p + half)[keep], color=COLOURS[k % 6], alpha=0.15, linewidth=0)
        low, high = min(low, 0.9 * (p - half)[-1]), max(high, 1.1 * (p + half)[-1])
    ax.axhspan(0.9, 1.1, color="#009E73", alpha=0.12, linewidth=0)
    ax.axhline(1, color="#777777", linewidth=1)
    ax.set(xscale="log", ylim=(low, high), xlabel="evaluations of the main run", ylabel="estimate / that of all evaluations")
    drawing.plain_log_axis(ax.xaxis, *ax.get_xlim())
    ax.legend(fontsize=8, title="estimate of all evaluations", title_fontsize=8)
    part = "All" if most_kept >= max(evaluations) else f"The first {wording.grouped(most_kept)} of"
    missing = len(shown) - MOST_CURVES
    ax.set_title(f"{part} {wording.counts_text(evaluations)} evaluations: estimate and 95 % interval,\nover the estimate of all;"
                 " shaded: 10 %" + (f"; {missing} more events are not drawn" if missing > 0 else ""), loc="left", fontsize=10)
    return figure


def main():
    parser = saving.argument_parser("probability that two wells touch, where, and by which errors")
    parser.add_argument("--point", type=int, help="point of a sweep, from 0 (the first)")
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, ("collision", "rare_event", "msa_position", "gross_error_detection",
                                                  "chained_multistation")) as file:
        config, title = reading.configuration(file), wording.title_of(file)
        tables = {n: reading.read_table(file, n) for n in ("probability", "sampling", "contact", "importance", "closest_pair")}
        hits = reading.read_table(file, "hits", "samples")
    whole = tables["probability"]
    if whole is None:
        raise reading.PlotError(f"{arguments.result}: is no run of events")
    keys = reading.sweep_keys(config, whole)
    points = reading.sweep_points(whole, keys)
    chosen = reading.chosen_point(arguments, points)
    point = points[chosen or 0]
    at = {n: reading.at_point(t, keys, point) for n, t in tables.items() if t is not None}
    hits = reading.at_point(hits, keys, point) if hits is not None else None
    folder = saving.figures_folder(arguments.output, arguments.result)
    stem = saving.stem_of(arguments.result) + ("" if chosen is None else f"_point{chosen}")

    def save(figure, name, label=wording.point_name(keys, point)):
        figure.suptitle(": ".join(filter(None, (title, label))), x=0.01, ha="left", fontsize=10)
        saving.save(figure, folder, f"{stem}_{name}")

    if "offset" in whole:
        save(probability(at["probability"]), "probability")
        if at["contact"].rows:
            save(contact(at["contact"]), "contact")
        if at["importance"].rows:
            save(importance(at["importance"]), "importance")
        if "errors.multiplier" in keys and len(keys) == 1:
            save(multiplier(whole), "multiplier", "")
        if len(set(np.round(at["closest_pair"]["crossing_deg"], 3))) > 2:
            save(crossing(at["probability"], at["closest_pair"]), "crossing")
        drawn = plane(hits, at["closest_pair"]) if hits is not None and hits.rows else None
        if drawn is not None:
            save(drawn, "plane")
    else:
        save(predictions(at["probability"], at["sampling"]), "probability")
        if "importance" in at and at["importance"].rows:
            save(factors(at["importance"]), "importance")
    if hits is not None and hits.rows:
        kept = int(reading.setting_at(config, keys, point, "save_samples", 0))
        save(convergence(hits, at["probability"], at["sampling"], kept), "convergence")
