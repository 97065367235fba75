"""Figures of a drift_monitoring or mwd_drift result: which sensors drift, when the monitors say so, and whom they blame.

    surveymc plot monitoring RESULT.h5 [-o FOLDER] [--point I] [--sensors NAME ...]

<stem>_predictions   readings, truth and what each monitor takes for the correct reading (figures 4 and 7 of the source)
<stem>_decisions     drift estimate or residual of each monitor, its alarms shaded (figures 5, 6, 8 and 9)
<stem>_delay         time to the first alarm over all realisations: quantiles, misses, false blame
<stem>_curves        with [operating]: delay against false alarms and false blame, a line a method
<stem>_operating     of a sweep: delay against the chance to blame a healthy sensor, and misses

each as PNG and SVG. The first two show the first realisation; of a sweep, the point given by --point (counted from 0), if
the series was kept. --sensors chooses what they show (the first sensor that drifts and all healthy ones).
Those of mwd_drift: mwd_drift_figures.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from .. import storage
from ..arguments import USAGE
from . import drawing, mwd_drift_figures, reading, saving, wording
from .reading import PlotError

LOOK = {"aakr_sprt": ("AAKR-SPRT", "#0072B2", "o"), "aakr_kf_sprt": ("AAKR-KF-SPRT", "#D55E00", "s"),
        "aakr_cusum": ("CUSUM on AAKR", "#009E73", "^"), "aakr_threshold": ("threshold on AAKR", "#A8508A", "v")}
MONITORS = ("aakr_sprt", "aakr_kf_sprt")
READING, TRUTH = "#BBBBBB", "#222222"


def present(table):
    """The monitors of a series."""
    return [m for m in MONITORS if f"signal_{m}" in table]


def shown_sensors(series, wanted):
    """--sensors, or the first that drifts and all healthy ones."""
    names = list(dict.fromkeys(series["sensor"]))
    if wanted:
        for w in wanted:
            if w not in names:
                raise PlotError(f"no sensor '{w}'; there are {', '.join(names)}", USAGE)
        return wanted
    drifting = [n for n in names if np.any(of_sensor(series, n)["drift_z"] != 0)]
    return drifting[:1] + [n for n in names if n not in drifting]


def of_sensor(series, name):
    return series.where(lambda i: series["sensor"][i] == name)


def runs(decision):
    """[(first, last)] of the stretches in which an alarm is held."""
    on = np.concatenate(([0], (np.asarray(decision) != 0).astype(int), [0]))
    return list(zip(np.flatnonzero(np.diff(on) == 1), np.flatnonzero(np.diff(on) == -1) - 1))


def keep_in_view(ax, least, *series):
    """Limits that show all but outliers (a dropout of a second must not flatten 100 h), and how many those are."""
    values = np.concatenate([np.asarray(x)[np.isfinite(x)] for x in series])
    low, high = np.quantile(values, (0.001, 0.999))
    low, high = min(low, least[0]), max(high, least[1])
    room = 0.25 * (high - low) or 1.0
    outside = max(int(np.sum((x < low - room) | (x > high + room))) for x in series)
    if outside == 0:
        low, high, room = min(low, np.min(values)), max(high, np.max(values)), 0.06 * (high - low)
    else:
        ax.text(0.992, 0.04, f"{outside} sample{'' if outside == 1 else 's'} outside the panel", transform=ax.transAxes,
                ha="right", va="bottom", fontsize="small", bbox={"color": "white", "alpha": 0.8, "pad": 1.5})
    ax.set_ylim(low - room, high + room)


FEWEST = 10  # realisations: of fewer an interval says nothing


def strips(count):
    return drawing.panels(count, (11.5, 2.5), columns=1, sharex=True)


def predictions_figure(title, series, model, sensors):
    figure, axes = strips(len(sensors))
    drawing.heading(figure, title, "First realisation. Readings with drift, and what the monitors take for the correct reading.")
    for ax, name in zip(axes, sensors):
        s = of_sensor(series, name)
        mean, sd = model[name][0], model[name][1]
        unit = model.units.get(name, "")
        if unit == "Pa":  # no gauge of a well is read in units of 1e-7 of what it shows
            mean, sd, unit = mean / 1e3, sd / 1e3, "kPa"
        t = s["time_h"]
        ax.plot(t, mean + sd * s["reading_z"], color=READING, linewidth=0.6, label="reading", rasterized=True)
        for m in present(series):
            label, colour, _ = LOOK[m]
            ax.plot(t, mean + sd * s[f"prediction_{m}"], color=colour, linewidth=0.8, label=label, rasterized=True)
        if np.any(np.isfinite(s["truth_z"])):
            ax.plot(t, mean + sd * s["truth_z"], color=TRUTH, linewidth=1.3, linestyle=(0, (4, 2)), label="truth")
        ax.set_title(f"{name}: drifts" if np.any(s["drift_z"] != 0) else f"{name}: healthy")
        ax.set_ylabel(f"{name} ({unit})")
        ax.set_xlim(t[0], t[-1])
        ax.ticklabel_format(axis="y", style="plain", useOffset=False)
        shown = [mean + sd * s[k] for k in ("reading_z", *(f"prediction_{m}" for m in present(series)))]
        keep_in_view(ax, (np.inf, -np.inf), *shown)
    legend = drawing.legend_below(figure, axes[0].get_legend_handles_labels()[0])
    for line in legend.get_lines():
        line.set_linewidth(2)
    axes[-1].set_xlabel("Time in the test (h)")
    return figure


def decisions_figure(title, series, sensors):
    rows = [(n, m) for m in present(series) for n in sensors]
    figure, axes = strips(len(rows))
    drawing.heading(figure, title, "First realisation. What the SPRT looks at, in sd of the training data (z). "
            "Shaded: it holds an alarm.")
    for ax, (name, m) in zip(axes, rows):
        s = of_sensor(series, name)
        label, colour, _ = LOOK[m]
        t = s["time_h"]
        for first, last in runs(s[f"decision_{m}"]):
            ax.axvspan(t[first], max(t[last], t[first] + 0.002 * (t[-1] - t[0])), color="#F0E442", alpha=0.55,
                       linewidth=0)
        ax.plot(t, s[f"signal_{m}"], color=colour, linewidth=0.8, rasterized=True,
                label="residual" if m == "aakr_sprt" else "drift estimate")
        ax.plot(t, s["drift_z"], color=TRUTH, linewidth=1.3, linestyle=(0, (4, 2)), label="true drift")
        ax.set_title(f"{label}: {name}, {'drifts' if np.any(s['drift_z'] != 0) else 'healthy'}")
        ax.set_ylabel("Drift (z)")
        ax.set_xlim(t[0], t[-1])
        # A healthy sensor's estimate is seen small, and the legend has room.
        keep_in_view(ax, (-1.0, 2.0), s[f"signal_{m}"], s["drift_z"])
        ax.legend(loc="upper left", ncol=2)
    axes[-1].set_xlabel("Time in the test (h)")
    return figure


def error_bars(low, middle, high):
    return np.array([[middle - low], [high - middle]])


def longest(delay):
    """The longest delay that is no miss; 1 h where all are. A median may be longer than the 95 % of all other rows."""
    hours = np.concatenate([delay[k] for k in ("delay_q05_h", "delay_q50_h", "delay_q95_h")])
    return np.max(hours[np.isfinite(hours)], initial=0) or 1.0


def delay_figure(title, delay, blame, alarms):
    """Left: delay quantiles of every drifting sensor. Right: chances of a miss and of false blame."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.5, 5.2), width_ratios=(3, 2), layout="constrained")
    trials = int(delay["trials"][0])
    few = trials < FEWEST
    drawing.heading(figure, title, "One file: nothing is drawn, so that there are no intervals." if trials == 1 else
                    f"{trials} realisations of the noise: too few for intervals." if few else
                    f"{trials} realisations of the noise. Bars: 5 to 95 % of the realisations; right: {100 * blame.confidence:g} % intervals.")
    sensors = list(dict.fromkeys(delay["sensor"]))
    methods = list(dict.fromkeys(delay["architecture"]))
    top = 1.15 * longest(delay)
    for i, m in enumerate(methods):
        label, colour, marker = LOOK[m]
        at = (i - (len(methods) - 1) / 2) * 0.16
        for j, sensor in enumerate(sensors):
            r = delay.row(architecture=m, sensor=sensor)
            low, middle, high = (min(r[k], top) for k in ("delay_q05_h", "delay_q50_h", "delay_q95_h"))
            left.errorbar([j + at], [middle], yerr=None if few else error_bars(low, middle, high), color=colour, capsize=4,
                          marker=marker if np.isfinite(r["delay_q50_h"]) else "x", label=label if j == 0 else None)
        r = blame.row(architecture=m)
        for x, value, low, high in ((0, r["p_healthy_blamed"], r["p_healthy_blamed_ci_low"], r["p_healthy_blamed_ci_high"]),
                                    (1, 1 - r["p_all_found"], 1 - r["p_all_found_ci_high"], 1 - r["p_all_found_ci_low"])):
            if np.isfinite(value):
                right.errorbar([x + at], [100 * value], yerr=None if few else 100 * error_bars(low, value, high),
                               color=colour, marker=marker, capsize=4)
    left.set_xticks(range(len(sensors)), sensors)
    left.set_xlim(-0.6, len(sensors) - 0.4)
    left.set_ylim(0, 1.05 * top)
    left.set_ylabel("Time from the start of the drift (h)")
    left.set_title("First alarm of a drifting sensor (x: mostly missed)")
    right.set_xticks((0, 1), ("a healthy sensor\nis blamed", "a drift\nis missed"))
    right.set_xlim(-0.6, 1.6)
    right.set_ylim(-4, 104)
    right.set_ylabel("Share of realisations (%)")
    if trials == 1:
        right.set_yticks((0, 100), ("no", "yes"))
        right.set_ylabel("")
    right.set_title("Errors")
    drawing.legend_below(figure, left.get_legend_handles_labels()[0])
    return figure


def operating_figure(title, delay, blame, keys, points):
    """Delay of the sensor that takes longest, and the chance of false blame, a line a point of the sweep."""
    figure, (left, right) = drawing.panels(2, (5.2, 1.2 + 0.3 * len(points)), columns=2, sharey=True)
    names = [wording.point_name(keys, p) for p in points]
    few = int(delay["trials"][0]) < FEWEST
    top = 1.1 * longest(delay)  # where misses are drawn: they are not soon, but never
    for m, shift in zip(MONITORS, (-0.15, 0.15)):
        label, colour, marker = LOOK[m]
        for n, p in enumerate(points):
            d = reading.at_point(delay, keys, p)
            d = d.where(lambda i, d=d, m=m: d["architecture"][i] == m)
            b = reading.at_point(blame, keys, p).row(architecture=m)
            if d.rows == 0 or b is None:
                continue
            worst = int(np.argmax(d["delay_q50_h"]))
            low, middle, high = (min(d[k][worst], top) for k in ("delay_q05_h", "delay_q50_h", "delay_q95_h"))
            missed = not np.isfinite(d["delay_q50_h"][worst])
            left.errorbar(middle, n + shift, xerr=None if few or missed else error_bars(low, middle, high), color=colour, capsize=3,
                          marker="x" if missed else marker, linestyle="none", clip_on=False)
            value = b["p_healthy_blamed"]
            if np.isfinite(value):
                right.errorbar(100 * value, n + shift, color=colour, marker=marker, capsize=3, linestyle="none", clip_on=False,
                               xerr=None if few else 100 * error_bars(b["p_healthy_blamed_ci_low"], value, b["p_healthy_blamed_ci_high"]))
    left.set_yticks(range(len(names)), names)
    left.set_ylim(len(names) - 0.5, -0.5)
    left.set_xlim(0, top)
    left.set_xlabel("Median delay (h)" if few else "Median delay, bars 5 to 95 % (h)")
    left.set_title("Slowest drifting sensor")
    right.set_xlim(0, 100)
    right.set_xlabel("Realisations that blame a healthy sensor (%)")
    right.set_title("False blame")
    drawing.heading(figure, title, f"Every point of the sweep, {wording.counts_text(delay['trials'])} realisations each"
                    + (": too few for intervals." if few else f"; right: {100 * blame.confidence:g} % intervals."))
    drawing.legend_below(figure, [*(Line2D([], [], color=LOOK[m][1], marker=LOOK[m][2], linestyle="none", label=LOOK[m][0]) for m in MONITORS),
                                  Line2D([], [], color="#555555", marker="x", linestyle="none", markersize=8, label="missed in most realisations")])
    return figure


def curves_figure(title, operating):
    """Operating curves of the sensor that takes longest: its median delay against errors, a mark a setting."""
    figure, axes = drawing.panels(2, (5.7, 4.6), columns=2, sharey=True)
    few = int(operating["trials"][0]) < FEWEST
    finite = operating["delay_q50_h"][np.isfinite(operating["delay_q50_h"])]
    top = 1.18 * np.max(finite) if len(finite) else 1.0
    medians = {s: np.median(np.minimum(operating.where(lambda i, s=s: operating["sensor"][i] == s)["delay_q50_h"], top))
               for s in dict.fromkeys(operating["sensor"])}
    sensor = max(medians, key=medians.get)
    drawing.heading(figure, title, f"{int(operating['trials'][0])} realisations. {sensor}: median delay"
                    + (", too few for intervals" if few else f" with its {100 * operating.confidence:g} % interval")
                    + "; a mark a setting: M of the SPRT, or the threshold (z). Marks are set apart by up to 1 % for each method, "
                    "so that those at 0 and at 100 % can be told.")
    shown = operating.where(lambda i: operating["sensor"][i] == sensor)
    for m in dict.fromkeys(shown["architecture"]):
        label, colour, marker = LOOK[m]
        of = shown.where(lambda i, m=m: shown["architecture"][i] == m)
        label = f"{label}, {np.min(of['value_z']):g} to {np.max(of['value_z']):g}"
        apart = 0.7 * (list(LOOK).index(m) - 1.5)
        missed = ~np.isfinite(of["delay_q50_h"])
        y = np.where(missed, 0.96 * top, of["delay_q50_h"])
        low = np.where(missed, y, np.minimum(of["delay_q50_h_ci_low"], y))
        high = np.where(missed, y, np.minimum(of["delay_q50_h_ci_high"], top))
        for ax, column in zip(axes, ("p_alarm_without_drift", "p_healthy_blamed")):
            x = 100 * of[column] + apart
            if not np.any(np.isfinite(x)):
                continue
            ax.plot(x, y, color=colour, linewidth=1.0, alpha=0.7)
            ax.errorbar(x, y, yerr=None if few else [y - low, high - y], color=colour, marker=marker, markersize=5, linestyle="none", capsize=2,
                        label=label)
            ax.plot(x[missed], y[missed], color=colour, marker="x", markersize=11, linestyle="none")
    for ax, label in zip(axes, ("Realisations with a false alarm of any sensor, without drift (%)",
                                "Realisations that blame a healthy sensor, with drift (%)")):
        ax.set_xlim(-5, 105)
        ax.set_ylim(0, top)
        ax.set_xlabel(label)
    axes[0].set_ylabel(f"Median delay of {sensor} (h; x: mostly missed)")
    drawing.legend_below(figure, axes[0].get_legend_handles_labels()[0])
    return figure


def read_model(file, keys, point):
    model = reading.at_point(reading.read_table(file, "model"), keys, point)
    model.units = {k: reading.text_attribute(d, "units") for k, d in file["tables/model"].items()}
    return model


def is_mwd_drift(path):
    """What cannot be opened is left to open_result() to refuse."""
    try:
        with storage.open_file(path) as file:
            return reading.text_attribute(file, "experiment") == "mwd_drift"
    except storage.ResultError:
        return False


def main():
    parser = saving.argument_parser(__doc__.split("\n\n")[0])
    parser.add_argument("--point", type=int, default=0, metavar="I", help="point of a sweep, from 0")
    parser.add_argument("--sensors", nargs="+", metavar="NAME", help="what the first two figures show")
    arguments = parser.parse_args()
    drawing.use_style()
    stem = saving.stem_of(arguments.result)
    if is_mwd_drift(arguments.result):
        with reading.open_result(arguments.result, "mwd_drift") as file:
            folder = saving.figures_folder(arguments.output, arguments.result)
            mwd_drift_figures.draw(file, stem, folder, arguments.point)
        return
    with reading.open_result(arguments.result, "drift_monitoring") as file:
        config = reading.configuration(file)
        delay, blame, alarms, series = (reading.read_table(file, n) for n in ("delay", "blame", "alarms", "series"))
        keys = reading.sweep_keys(config, blame)
        points = reading.sweep_points(blame, keys)
        if not 0 <= arguments.point < len(points):
            raise PlotError(f"--point {arguments.point}: must be in [0, {len(points) - 1}]", USAGE)
        point = points[arguments.point]
        title = wording.title_of(file)
        folder = saving.figures_folder(arguments.output, arguments.result)
        if len(points) > 1:
            if delay.rows:
                saving.save(operating_figure(title, delay, blame, keys, points), folder, f"{stem}_operating")
            stem, title = f"{stem}_point{arguments.point}", f"{title}: {wording.point_name(keys, point)}"
        if series is not None:
            shown = reading.at_point(series, keys, point)
            sensors = shown_sensors(shown, arguments.sensors)
            model = read_model(file, keys, point)
            saving.save(predictions_figure(title, shown, model, sensors), folder, f"{stem}_predictions")
            saving.save(decisions_figure(title, shown, sensors), folder, f"{stem}_decisions")
        operating = reading.at_point(reading.read_table(file, "operating"), keys, point)
        if operating is not None and operating.rows:
            saving.save(curves_figure(title, operating), folder, f"{stem}_curves")
        of_point = reading.at_point(delay, keys, point)
        if of_point.rows:
            saving.save(delay_figure(title, of_point, reading.at_point(blame, keys, point), alarms), folder,
                          f"{stem}_delay")
