"""Figures of a collision or rare_event result, or of a run of events: how likely is it, and how far to be trusted?

    surveymc plot collision RESULT.h5 [-o FOLDER] [--point I]
"""

import matplotlib.pyplot as plt
import numpy as np

from . import drawing, ratios, reading, saving, wording

SPANS = ("errors.multiplier", "problem.name", "noise.scale", "factor", "alpha", "sampling.method")  # keys of a sweep that has figures of its own here

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#A8508A", "#222222", "#E69F00")
MOST_CURVES, MOST_LINES = 12, 40
MARKERS = ("o", "s", "^", "D", "v", "P")
TEXTS = {"probability": "The probability that the wells touch against the least separation factor, with intervals; line: factor 1. What the wells "
                        "share joins the points of an offset.",
         "contact": "Where they touch: median, middle half and middle 90 % of the probability.",
         "importance": "Which errors make the wells touch: their shares of the squared distance of the nearest way.",
         "multiplier": "Probability and separation factor against the size of all errors.",
         "crossing": "Probability against the angle at which the wells pass each other at the same distance.",
         "plane": "Hits in the plane across the wells at their closest pair (size: weight), the holes, and 1, 2 and 3 sd."}


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
    """Probability against the least separation factor; what the wells share joins the points of an offset. None of one number."""
    form = rows(table, formulation="form")
    if form.rows < 2:
        return None
    are_named = len(set(form["correlation"])) > 1
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
        for at in places.values() if are_named else ():
            text = ", ".join(wording.quantity_name(own["correlation"][i]) for i in at)
            drawing.label_points(ax, text, (own["separation_factor"][at[0]], own["monte_carlo"][at[0]]), fontsize=7.5)
        seen += [v for key in ("monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high") for v in own[key] if v > 0]
    ax.axvline(1, color="#777777", linewidth=1)
    ax.set(yscale="log", xlabel="least separation factor", ylabel="probability that the wells touch")
    if seen:
        logarithmic(ax.yaxis, min(seen) / 2, min(2 * max(seen), 1.1))
    ax.margins(x=0.12)
    ax.legend()
    return figure


def logarithmic(axis, low, high):
    """The axis of a panel between these limits, logarithmic, with ticks to read."""
    axis.axes.set(**{f"{axis.axis_name}lim": (low, high)})
    drawing.plain_log_axis(axis, low, high)


def contact(table):
    """Depths at which the wells touch: median, the middle half and the middle 90 % of the probability, a line an event."""
    events = events_of(table)
    figure, panels = plt.subplots(1, 2, figsize=(10, 1.5 + 0.3 * len(events)), sharey=True, layout="constrained")
    for ax, well in zip(panels, ("reference", "offset")):
        for y, (offset, correlation) in enumerate(events):
            own = rows(table, offset=offset, correlation=correlation, well=well)
            low, first, middle, last, high = own["md_m"][np.argsort(own["share"])]
            ax.plot((low, high), (y, y), color="#0072B2", linewidth=1.5)
            ax.plot((first, last), (y, y), color="#0072B2", linewidth=6, solid_capstyle="butt")
            ax.plot(middle, y, "o", color="white", markeredgecolor="#0072B2", markersize=5)
        ax.set_xlabel(f"measured depth on the {well} well (m)")
    panels[0].set_yticks(range(len(events)), [events_text([e]) for e in events])
    panels[0].set_ylim(len(events) - 0.4, -0.6)
    return figure


def importance(table):
    """Which errors make an event: a panel for every different answer, one list of sources for all. None where one error makes
    all of every event: that is a sentence."""
    named = [k for k in ("offset", "correlation", "event") if k in table]
    own = rows(table, component=0)
    parts = {}  # parts of beta squared by event and source
    for i in range(own.rows):
        code = own["code"][i]
        source = f"{code} {own['mode'][i]}".strip() if "mode" in own else wording.quantity_name(code)
        of_event = parts.setdefault(tuple(own[k][i] for k in named), {})
        of_event[source] = of_event.get(source, 0) + own["factor"][i]
    if all(max(of.values()) > 0.98 for of in parts.values()):
        return None
    panels = {}  # events of the same parts share one
    for event, of in parts.items():
        panels.setdefault(tuple((s, round(of[s], 2)) for s in sorted(of) if of[s] > 0.01), []).append(event)
    panels = {tuple(events): parts[events[0]] for events in panels.values()}
    largest = {s: max(of.get(s, 0) for of in panels.values()) for of in panels.values() for s in of}
    shown = [s for s in sorted(largest, key=lambda s: -largest[s]) if largest[s] > 0.01][:12]
    columns = min(4, len(panels))
    lines = -(-len(panels) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(max(2 + 2.6 * columns, 7), lines * (0.9 + 0.24 * len(shown)) + 0.8), squeeze=False,
                                layout="constrained", sharex=True, sharey=True)
    for ax in axes.flat[len(panels):]:
        ax.set_axis_off()
    for ax, (events, of) in zip(axes.flat, panels.items()):
        ax.barh(range(len(shown)), [100 * of.get(s, 0) for s in shown], color="#0072B2")
        ax.set_title(events_text(events), fontsize=9)
    axes[0][0].set_yticks(range(len(shown)), shown, fontsize=8)
    axes[0][0].invert_yaxis()
    for ax in axes[-1]:
        ax.set_xlabel("share of the nearest way (%)")
    return figure


def events_text(events):
    """'parallel: independent, geomagnetic' for the same offset, a line each for others."""
    by_first = {}
    for first, *rest in events:
        by_first.setdefault(first, []).extend(map(wording.quantity_name, rest))
    return "\n".join(": ".join(filter(None, (first, ", ".join(rest)))) for first, rest in by_first.items())


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
    ax.set(xscale="log", yscale="log", xlabel="size of all errors (1: the models' own)", ylabel="probability that the wells touch")
    x = sorted(set(table["errors.multiplier"]))
    if len(x) <= 10:
        ax.set_xticks(x, [f"{v:g}" for v in x])
        ax.minorticks_off()
    factor.set_ylabel("separation factor (dotted)")
    factor.grid(False)
    ax.legend(loc="center right", fontsize=8)
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
    ax.set(xscale="log", yscale="log", xlabel="angle at which the wells pass each other (\N{DEGREE SIGN})", ylabel="probability that the wells touch")
    apart = [x for k, x in enumerate(angle) if k == 0 or x > 1.2 * max(angle[:k])]
    ax.set_xticks(apart, [f"{x:.3g}" for x in apart])
    ax.minorticks_off()
    ax.legend(fontsize=8)
    return figure


def predictions(title, table, sampling, keys):
    """Probability of the events of all points, with what was predicted of them: one line each. None of a single one: a sentence."""
    named = [*keys, "event"]
    events = reading.sweep_points(table, named)
    if len(events) < 2:
        return None
    every, events = len(events), ratios.some(events, MOST_LINES)
    has_events = len(set(table["event"])) > len(set(e[-1] for e in events)) or len(set(e[:-1] for e in events)) < len(events)
    formulations = distinct(table["formulation"])
    figure, ax = plt.subplots(figsize=(9, 1.6 + 0.42 * len(events)), layout="constrained")
    labels, seen = {}, []
    found = np.concatenate([table["monte_carlo"], table["monte_carlo_ci_high"]])
    floor = np.min(found[found > 0], initial=1) / 100  # what was predicted far below every estimate stands at the edge

    def mark(x, y, label, **look):
        if x > 0:
            labels.setdefault(label, ax.errorbar(max(x, floor), y, linestyle="none", label=label, **(look if x > floor else look | {"marker": "<"})))
            seen.append(max(x, floor))
    for y, event in enumerate(events):
        own, drawn = rows(table, **dict(zip(named, event))), rows(sampling, **dict(zip(named, event)))
        p, low, high = (own[k][0] for k in ("monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high"))
        for k, formulation in enumerate(formulations):
            for value in rows(own, formulation=formulation)["analytic"]:
                mark(value, y, wording.quantity_name(formulation), marker=MARKERS[(k + 2) % 6], color=COLOURS[(k + 1) % 6],
                     markerfacecolor="none", markersize=9)
        for value in distinct(own["published"][np.isfinite(own["published"])]):
            mark(value, y, "published", marker="x", color=drawing.PUBLISHED, markersize=9)
        check = drawn["subset_probability"][0]
        mark(check, y + 0.25, "subset simulation", marker="s", markersize=4, color="#777777", capsize=3,
             xerr=np.clip([[check - drawn["subset_ci_low"][0]], [drawn["subset_ci_high"][0] - check]], 0, None))
        mark(p, y, f"estimate and {100 * table.confidence:g} % interval", marker="o", markersize=5, color="#0072B2", capsize=4,
             xerr=np.clip([[p - low], [high - p]], 0, None), zorder=4)
        if p == 0:
            mark(high, y, "no hit: upper end of the interval", marker="<", color="#0072B2")
        note = "" if drawn["trusted"][0] else ", not trusted"
        ax.annotate(wording.number(p) + note, (1, y), xycoords=("axes fraction", "data"), xytext=(6, 0), textcoords="offset points",
                    va="center", fontsize=8.5)
    ax.set(xscale="log", ylim=(len(events) - 0.4, -0.6), xlabel="probability (right: the estimate)")
    logarithmic(ax.xaxis, min(seen, default=1e-9) / 1.5, min(max(seen, default=1) * 3, 1.5))
    names = [", ".join(filter(None, (wording.point_name(keys, e[:-1]), e[-1] if has_events or not keys else ""))) for e in events]
    ax.set_yticks(range(len(events)), names)
    ax.grid(axis="y", visible=False)
    drawing.heading(figure, title, "Points upon each other agree: what was found, and what was predicted or is known."
                    + (f" {len(events)} of {every}, evenly spread." if every > len(events) else ""))
    drawing.legend_below(figure, list(labels.values()))
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
                                                  "chained_multistation", "error_model_monte_carlo")) as file:
        config, title = reading.configuration(file), wording.title_of(file)
        tables = {n: reading.read_table(file, n) for n in ("probability", "sampling", "contact_quantiles", "importance", "closest_pair")}
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

    saved = []

    def save(figure, name, label=wording.point_name(keys, point)):
        if figure is None:
            return
        saved.append(name)
        if figure._suptitle is None:
            drawing.heading(figure, ": ".join(filter(None, (title, label))), TEXTS.get(name, ""))
        saving.save(figure, folder, f"{stem}_{name}")

    if "offset" in whole:
        save(probability(at["probability"]), "probability")
        if at["contact_quantiles"].rows:
            save(contact(at["contact_quantiles"]), "contact")
        if "errors.multiplier" in keys and len(keys) == 1:
            save(multiplier(whole), "multiplier", "")
        near = at["closest_pair"]
        if len(set(np.round(near["crossing_deg"], 3))) > 2 and np.ptp(near["distance_m"]) < 0.01 * np.min(near["distance_m"]):
            save(crossing(at["probability"], near), "crossing")
        if hits is not None and hits.rows:
            save(plane(hits, at["closest_pair"]), "plane")
    else:
        save(predictions(title, whole, tables["sampling"], keys), "probability")
    if "importance" in at and at["importance"].rows:
        save(importance(at["importance"]), "importance")
    if hits is not None and hits.rows:
        kept = int(reading.setting_at(config, keys, point, "save_samples", 0))
        save(convergence(hits, at["probability"], at["sampling"], kept), "convergence")
    if not saved:
        p, low, high = (wording.number(whole[k][0]) for k in ("monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high"))
        raise reading.PlotError(f"{arguments.result}: one number, no figure: {whole['event'][0]}: {p}, between {low} and {high}")
