"""Figures of a chained multistation study; PNG and SVG next to the result.

    surveymc plot chained RESULT.h5 [-o FOLDER] [--point I]

study "performance": RMS errors along the stations with the published values (_rms), biases of the first run and their
estimates (_tracks), z-scores, NEES and cost against theory (_consistency). "outliers": what is found and blamed, and
what the remedies do (_outliers). "interference": azimuth errors by treatment. "unstart": failures by solver. A result of
`estimate` with estimator = "chained": azimuths, residuals and biases along the run (_run). A sweep gives one figure of
each kind a point where the figure has no room for several: of the first six points, or of the one of --point (counted from 0,
in the order of the file). Figures of several points show the first twelve. What is left out is said on stderr and in the title.
"""
import matplotlib.pyplot as plt
import numpy as np

from . import drawing, reading, saving, wording

ESTIMATORS = {  # label, colour, line, marker
    "base": ("basic, one station", "#777777", (0, (1, 1.3)), "v"),
    "single": ("fully optimising, one station", "#E69F00", (0, (3.5, 2)), "s"),
    "filter_independent": ("filter, references independent", "#D55E00", (0, (7, 2)), "^"),
    "filter": ("filter, references chained", "#A8508A", (0, (5, 1, 1, 1)), "D"),
    "smoother_independent": ("smoother, references independent", "#56B4E9", (0, (2, 1)), "<"),
    "smoother": ("smoother, references chained", "#0072B2", "-", "o")}
QUANTITIES = {"azimuth_deg": "azimuth (\N{DEGREE SIGN})", "inclination_deg": "inclination (\N{DEGREE SIGN})", "toolface_deg": "toolface (\N{DEGREE SIGN})",
              "gravity_mg": "gravity (mg)", "horizontal_nT": "horizontal field (nT)", "down_nT": "downward field (nT)"}
MOST_CASES = 12  # points of a sweep beside each other
READINGS = ("accelerometer_x_mg", "accelerometer_y_mg", "accelerometer_z_mg", "magnetometer_x_nT", "magnetometer_y_nT",
            "magnetometer_z_nT")


def rms_figure(title, stations, rms):
    figure, panels = drawing.panels(6, (3.7, 2.9))
    shown = [e for e in ESTIMATORS if e in set(stations["formulation"])]
    last = max(stations["station"])
    for axes, (quantity, label) in zip(panels, QUANTITIES.items()):
        seen = []
        for name in shown:
            text, colour, line, marker = ESTIMATORS[name]
            t = stations.where(lambda i: stations["formulation"][i] == name)
            low, y, high = (t[f"rms_{quantity}{end}"] for end in ("_ci_low", "", "_ci_high"))
            axes.fill_between(t["station"], low, high, color=colour, alpha=0.18, linewidth=0)
            axes.plot(t["station"], y, color=colour, linestyle=line, marker=marker, markersize=3.4, linewidth=1.3, label=text)
            published = (rms.row(formulation=name, quantity=quantity) or {}).get("published", np.nan)
            axes.plot(last + 0.9, published, marker=marker, markersize=8, markerfacecolor="none", markeredgecolor=colour,
                      markeredgewidth=1.6, linestyle="none")
            seen += [*low[low > 0], *high, published]
        low, high = np.nanmin(seen) / 1.1, np.nanmax(seen) * 1.1
        if high > 4 * low > 0:
            axes.set_yscale("log")
            axes.set_ylim(low, high)
            drawing.plain_log_axis(axes.yaxis, low, high)
        else:
            axes.set_ylim(0, high)
        axes.set_title(label[0].upper() + label[1:])
        axes.set_xlim(min(stations["station"]) - 0.5, last + 1.6)
        axes.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
        axes.set_xticks([t for t in axes.get_xticks() if min(stations["station"]) <= t <= last])  # beyond it is what was published
    for axes in panels[3:]:
        axes.set_xlabel("Station")
    for axes in panels[::3]:
        axes.set_ylabel("RMS error")
    drawing.heading(figure, title, f"RMS errors along the stations with {100 * stations.confidence:g} % intervals"
                    + ("; open markers at the right: published, over all stations." if np.isfinite(rms["published"]).any() else "."))
    drawing.legend_below(figure, panels[0].get_legend_handles_labels()[0])
    return figure


def tracks_figure(title, tracks):
    figure, panels = drawing.panels(6, (3.7, 2.7), sharex=True)
    for axes, name in zip(panels, READINGS):
        kind, axis, unit = name.split("_")
        x = tracks["station"]
        y, sd = tracks[f"smoother_{name}"], tracks[f"smoother_sd_{name}"]
        axes.fill_between(x, y - 2 * sd, y + 2 * sd, color="#0072B2", alpha=0.16, linewidth=0,
                          label="smoother, \N{PLUS-MINUS SIGN}2 claimed sd")
        axes.plot(x, tracks[f"true_{name}"], color="#111111", linewidth=1.6, label="true bias")
        axes.plot(x, y, color="#0072B2", marker="o", markersize=3.4, label=ESTIMATORS["smoother"][0])
        axes.plot(x, tracks[f"filter_{name}"], color="#D55E00", linestyle=(0, (7, 2)), marker="^", markersize=3.4,
                  label=ESTIMATORS["filter_independent"][0])
        axes.set_title(f"{kind.capitalize()} {axis}")
        axes.set_ylabel(f"Bias ({unit})")
        axes.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
    for axes in panels[3:]:
        axes.set_xlabel("Station")
    drawing.heading(figure, title, "Biases of the first run, true and estimated.")
    drawing.legend_below(figure, panels[0].get_legend_handles_labels()[0])
    return figure


def consistency_figure(title, histogram, trials):
    """Cumulative shares: the steps of few runs do not hide each other, as bars do."""
    figure, panels = drawing.panels(3, (3.8, 3.4), sharey=True)
    words = {"z": ("z-score", "standard normal"), "nees": ("NEES of a station", "\N{GREEK SMALL LETTER CHI}\N{SUPERSCRIPT TWO}, 12 states"),
             "cost": ("cost J of a run", "\N{GREEK SMALL LETTER CHI}\N{SUPERSCRIPT TWO}, 3 a station")}
    for axes, (quantity, (label, theory)) in zip(panels, words.items()):
        names = [n for n in ("smoother", "filter_independent", "filter", "smoother_independent") if n in histogram["formulation"]][:2]
        for name in names:
            t = histogram.where(lambda i: histogram["formulation"][i] == name and histogram["quantity"][i] == quantity)
            if t.rows == 0:
                continue
            edges = np.append(t["from"], t["to"][-1])
            found, expected = (np.append(0, 100 * np.cumsum(t[k]) / t[k].sum()) for k in ("count", "expected"))
            text, colour, line, _ = ESTIMATORS[name]
            if name == names[0]:
                axes.plot(edges, expected, color="#111111", linewidth=1.2, label="theory: what an honest covariance gives")
            axes.plot(edges, found, color=colour, linestyle=line, linewidth=1.8, label=text)
        axes.set_xlabel(label)
        axes.set_title(f"{label.capitalize() if label[0] != 'N' else label} against {theory}", fontsize=9)
        axes.set_ylim(0, 100)
    panels[0].set_ylabel("Share that is smaller (%)")
    drawing.heading(figure, title, f"What the covariances claim: {wording.counts_text(trials)} runs. Left of the black line: the errors "
                    "are smaller than claimed.")
    drawing.legend_below(figure, panels[0].get_legend_handles_labels()[0])
    return figure


def cases_of(table, keys):
    return [(wording.point_name(keys, p) or "", reading.at_point(table, keys, p)) for p in
            reading.sweep_points(table, keys)]


def shown_cases(arguments, title, table, keys):
    """(title, table) of a figure of all points of a sweep: of those that have room, or of the one of --point."""
    points = reading.sweep_points(table, keys)
    kept = {point for _, point in reading.points_to_draw(arguments, points, MOST_CASES)}
    if arguments.point is None and len(kept) < len(points):
        title = f"{title} (the first {MOST_CASES} of {len(points)} points)"
    return title, table.where(lambda i: tuple(table[k][i] for k in keys) in kept)


def bars(axes, rows, labels, colours, hatches):
    """Grouped bars with intervals: rows[group][bar] = (value, low, high)."""
    count = len(labels)
    for b in range(count):
        x = np.arange(len(rows)) + (b - (count - 1) / 2) * 0.8 / count
        v, low, high = (np.array([r[b][i] for r in rows]) for i in range(3))
        axes.bar(x, v, width=0.8 / count, color=colours[b], hatch=hatches[b], edgecolor="#333333", linewidth=0.6,
                 label=labels[b])
        axes.errorbar(x, v, yerr=[np.maximum(v - low, 0), np.maximum(high - v, 0)], fmt="none", color="#111111",
                      capsize=2, linewidth=1)


def values(table, names, **where):
    found = [table.row(quantity=n, **where) for n in names]
    return [(r["monte_carlo"], r["monte_carlo_ci_low"], r["monte_carlo_ci_high"]) for r in found]


def outliers_figure(title, table, keys):
    cases = cases_of(table, keys)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 5.4), layout="constrained")
    events = {"detected": "detected", "station_right": "right station", "reading_right": "right reading",
              "deleted": "one reading clearly dominates", "deleted_wrong": "dominates, but another is wrong"}
    bars(left, [values(t, events) for _, t in cases], list(events.values()),
         ["#0072B2", "#56B4E9", "#009E73", "#F0E442", "#D55E00"], ["", "//", "", "..", "xx"])
    left.set_ylabel("share of the runs")
    left.set_ylim(0, 1.05)
    remedies = {"azimuth_clean_deg": "no error", "azimuth_ignored_deg": "ignored",
                "azimuth_largest_deleted_deg": "largest deleted", "azimuth_gated_deg": "deleted if it dominates"}
    bars(right, [values(t, remedies) for _, t in cases], list(remedies.values()),
         ["#999999", "#D55E00", "#E69F00", "#0072B2"], ["", "xx", "//", ""])
    right.set_ylabel("RMS azimuth error at the station (\N{DEGREE SIGN})")
    for axes in (left, right):
        axes.set_xticks(range(len(cases)), [n or "all runs" for n, _ in cases])
        axes.grid(axis="x", visible=False)
        axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=2)
    drawing.heading(figure, title, f"What the tests find, and what the remedies leave; error bars: {100 * table.confidence:g} % intervals.")
    return figure


def interference_figure(title, table, keys):
    cases = cases_of(table, keys)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.8), width_ratios=(1.4, 1), layout="constrained")
    ways = {"undisturbed": "no interference", "ignored": "ignored", "free_vector": "free vector estimated",
            "known_direction": "amplitude of known direction estimated"}
    colours, hatches = ["#999999", "#D55E00", "#E69F00", "#0072B2"], ["", "xx", "//", ""]
    for axes, quantity in ((left, "azimuth_deg"), (right, "rejected")):
        bars(axes, [[values(t, [quantity], formulation=w)[0] for w in ways] for _, t in cases], list(ways.values()),
             colours, hatches)
        axes.set_xticks(range(len(cases)), [n or "all runs" for n, _ in cases])
        axes.grid(axis="x", visible=False)
    left.set_ylabel("RMS azimuth error, disturbed stations (\N{DEGREE SIGN})")
    right.set_ylabel("share of runs that \N{GREEK SMALL LETTER CHI}\N{SUPERSCRIPT TWO} of the run rejects")
    drawing.heading(figure, title, f"Error bars: {100 * table.confidence:g} % intervals.")
    drawing.legend_below(figure, left.get_legend_handles_labels()[0])
    return figure


def unstart_figure(title, table, keys):
    cases = cases_of(table, keys)
    figure, axes = plt.subplots(figsize=(9.5, 1.1 * len(cases) + 2.2), layout="constrained")
    ways = {"gauss_newton": ("Gauss-Newton", "#D55E00", "v"), "levenberg": ("Levenberg", "#E69F00", "s"),
            "search_gauss_newton": ("sub-search, Gauss-Newton", "#56B4E9", "^"),
            "search": ("sub-search, Levenberg", "#0072B2", "o")}
    for b, (way, (label, colour, marker)) in enumerate(ways.items()):
        y = np.arange(len(cases)) + (b - 1.5) * 0.2
        v, low, high = (np.array([values(t, ["failed"], formulation=way)[0][i] for _, t in cases]) for i in range(3))
        axes.errorbar(v, y, xerr=[v - low, high - v], fmt=marker, color=colour, markersize=6, capsize=2, linewidth=1.1,
                      label=label, clip_on=False)
        for place, share, end, (_, t) in zip(y, v, high, cases):
            runs = int(t["trials"][0])
            axes.annotate(f"{share * runs:.0f} of {runs}", (end, place), xytext=(4, 0), textcoords="offset points",
                          va="center", fontsize=7.5, color="#444444")
    axes.set_yticks(range(len(cases)), [n or "all runs" for n, _ in cases])
    axes.invert_yaxis()
    axes.set_xlim(0, 1.12 * axes.get_xlim()[1])
    axes.set_xlabel("share of the runs that do not end at the lowest minimum")
    axes.grid(axis="y", visible=False)
    drawing.heading(figure, title, f"Error bars: {100 * table.confidence:g} % intervals.")
    drawing.legend_below(figure, axes.get_legend_handles_labels()[0])
    return figure


BIASES = ("accelerometer_bias_x_mg", "accelerometer_bias_y_mg", "accelerometer_bias_z_mg", "bias_x_nT", "bias_y_nT",
          "bias_z_nT")


def run_figure(title, parameters, stations, tests):
    figure, panels = plt.subplots(3, 3, figsize=(11, 9), sharex=True, layout="constrained")
    depth = stations["md_m"]
    change = (stations["azimuth_magnetic_deg"] - stations["raw_azimuth_magnetic_deg"] + 180) % 360 - 180
    axes = panels[0, 0]
    axes.fill_between(depth, change - 2 * stations["sd_azimuth_deg"], change + 2 * stations["sd_azimuth_deg"],
                      color="#0072B2", alpha=0.16, linewidth=0)
    axes.plot(depth, change, color="#0072B2", marker="o", markersize=3.4)
    axes.set_title("azimuth less basic solution", fontsize=10)
    axes.set_ylabel("change of azimuth (\N{DEGREE SIGN})")
    gate = next(tests["critical_high"][i] for i in range(tests.rows) if tests["test"][i] == "reading")
    for axes, kind, name in ((panels[0, 1], "g", "accelerometers"), (panels[0, 2], "b", "magnetometers")):
        largest = gate
        for axis, colour, marker in (("x", "#0072B2", "o"), ("y", "#E69F00", "s"), ("z", "#009E73", "^")):
            t = tests.where(lambda i: tests["component"][i] == kind + axis)
            axes.plot(t["md_m"], t["statistic"], color=colour, marker=marker, markersize=4.5, linestyle="none", label=axis)
            largest = max(largest, np.nanmax(np.abs(t["statistic"])))
        for sign in (-1, 1):
            axes.axhline(sign * gate, color="#D55E00", linestyle=(0, (3, 2)), linewidth=1)
        axes.set_ylim(-1.45 * largest, 1.12 * largest)
        axes.set_title(name, fontsize=10)
        axes.set_ylabel("normalised residual")
        axes.legend(fontsize=8, ncols=3, loc="lower left")
    for axes, name in zip(panels[1:].flat, BIASES):
        t = parameters.where(lambda i: parameters["quantity"][i] == name)
        axes.fill_between(t["md_m"], t["estimate"] - 2 * t["sd"], t["estimate"] + 2 * t["sd"], color="#0072B2", alpha=0.16,
                          linewidth=0)
        axes.plot(t["md_m"], t["estimate"], color="#0072B2", marker="o", markersize=3.4)
        sensor = "accelerometer" if name.startswith("a") else "magnetometer"
        axes.set_title(f"{sensor} {name.split('_')[-2]}", fontsize=10)
        axes.set_ylabel(f"bias ({name.split('_')[-1]})")
    for axes in panels[2]:
        axes.set_xlabel("measured depth (m)")
    drawing.heading(figure, title, f"Bands: \N{PLUS-MINUS SIGN}2 claimed sd; dashed: the gate, {gate:g}.")
    return figure


def draw_estimate(file, folder, stem, arguments):
    tables = {n: reading.read_table(file, n) for n in ("parameters", "stations", "tests", "modes")}
    if tables["modes"] is None:
        raise reading.PlotError(f"{file.filename}: not of the chained estimator: draw it with surveymc plot estimate")
    config, title = reading.configuration(file), wording.title_of(file)
    keys = reading.sweep_keys(config, tables["parameters"])
    points = reading.sweep_points(tables["parameters"], keys)
    for number, point in reading.points_to_draw(arguments, points):
        here = [reading.at_point(tables[n], keys, point) for n in ("parameters", "stations", "tests")]
        name, end = wording.point_title(title, keys, points, number), "_" + wording.name_of(point) if keys else ""
        saving.save(run_figure(name, *here), folder, f"{stem}_run{end}")


def open_any(path):
    try:
        return reading.open_result(path, "chained_multistation")
    except reading.PlotError as error:
        if "of experiment 'estimate'" in str(error):
            return reading.open_result(path, "estimate")
        raise


def main():
    parser = saving.argument_parser(__doc__.splitlines()[0])
    parser.add_argument("--point", type=int, metavar="I", help="only this point of a sweep, from 0 (default: the first six)")
    arguments = parser.parse_args()
    drawing.use_style()
    folder = saving.figures_folder(arguments.output, arguments.result)
    stem = saving.stem_of(arguments.result)
    with open_any(arguments.result) as file:
        if reading.text_attribute(file, "experiment") == "estimate":
            draw_estimate(file, folder, stem, arguments)
            return
        config = reading.configuration(file)
        title = wording.title_of(file)
        tables = {n: reading.read_table(file, n) for n in
                  ("rms", "stations", "tracks", "histogram", "outliers", "interference", "unstart")}
    for name, draw in (("outliers", outliers_figure), ("interference", interference_figure),
                       ("unstart", unstart_figure)):
        if tables[name] is not None:
            keys = reading.sweep_keys(config, tables[name])
            saving.save(draw(*shown_cases(arguments, title, tables[name], keys), keys), folder, stem)
    if tables["rms"] is None:
        return
    keys = reading.sweep_keys(config, tables["rms"])
    points = reading.sweep_points(tables["rms"], keys)
    for number, point in reading.points_to_draw(arguments, points):
        t = {n: reading.at_point(tables[n], keys, point) for n in ("rms", "stations", "tracks", "histogram")}
        name, end = wording.point_title(title, keys, points, number), "_" + wording.name_of(point) if keys else ""
        if t["stations"].rows:
            t["stations"].confidence = tables["stations"].confidence
            saving.save(rms_figure(name, t["stations"], t["rms"]), folder, f"{stem}_rms{end}")
        saving.save(tracks_figure(name, t["tracks"]), folder, f"{stem}_tracks{end}")
        if t["histogram"].rows:
            trials = t["rms"]["trials"] - t["rms"]["failed"]
            saving.save(consistency_figure(name, t["histogram"], trials), folder, f"{stem}_consistency{end}")
