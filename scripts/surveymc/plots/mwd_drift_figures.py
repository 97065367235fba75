"""Figures of an mwd_drift result, for surveymc plot monitoring.

<stem>_tracks      one well: channels with the SPRT's alarms shaded, biases that the filter estimates with 2-sigma bands
<stem>_detection   share of wells with an alarm up to a depth, with and without drift, every point of the sweep
<stem>_verdicts    consistency of the filter against theory and false alarms, every point of the sweep
"""

import matplotlib.pyplot as plt
import numpy as np

from ..arguments import USAGE
from . import drawing, ratios, reading, saving, wording

METHODS = {"channel_sprt": ("SPRT on each channel", "#0072B2", "-"), "bias_filter": ("bias filter", "#D55E00", "--")}
ALARM, TRUTH, BAND = "#F0E442", "#222222", "#D55E00"
CHANNELS = (("gravity", "Gravity |g|"), ("total_field", "Total field |b|"), ("dip", "Dip"))
SENSORS = (("gx", "mg"), ("gy", "mg"), ("gz", "mg"), ("bx", "nT"), ("by", "nT"), ("bz", "nT"))


def held(on):
    """[(first, last)] of the stretches in which `on` is true."""
    edges = np.diff(np.concatenate(([0], np.asarray(on).astype(int), [0])))
    return list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1))


def shade(ax, depth, on):
    half = 0.5 * (depth[1] - depth[0])
    for first, last in held(on):
        ax.axvspan(depth[first] - half, depth[last] + half, color=ALARM, alpha=0.55, linewidth=0, zorder=0)


def tracks_figure(title, series):
    figure, axes = plt.subplots(3, 3, figsize=(13.0, 8.6), sharex=True, layout="constrained")
    drawing.heading(figure, title, "First well. Top: channels less reference; yellow: the SPRT on this channel holds an alarm. "
                     "Below: biases that the filter estimates; yellow: its alarm names this sensor.")
    depth = series["md_m"]
    for ax, (key, name) in zip(axes[0], CHANNELS):
        shade(ax, depth, series[f"decision_{key}"] != 0)
        ax.axhline(0, color=TRUTH, linewidth=0.8)
        ax.plot(depth, series[f"{key}_sd"], color="#0072B2", marker=".", linewidth=0.8)
        ax.set_title(name)
        ax.set_ylabel("Residual (sd)")
        low, high = ax.get_ylim()
        ax.set_ylim(min(low, -3.5), max(high, 3.5))
    for row, sensors in ((1, SENSORS[:3]), (2, SENSORS[3:])):
        names = [f"{s}_{u}" for s, u in sensors]
        reach = 1.08 * max(np.max(np.abs(series[f"bias_{n}"]) + 2 * series[f"sd_{n}"]) for n in names)
        reach = max(reach, 1.08 * max(np.max(np.abs(series[f"true_{n}"])) for n in names))
        for ax, (sensor, unit), n in zip(axes[row], sensors, names):
            shade(ax, depth, np.array([x == sensor for x in series["named"]]))
            bias, sd, true = series[f"bias_{n}"], series[f"sd_{n}"], series[f"true_{n}"]
            ax.fill_between(depth, bias - 2 * sd, bias + 2 * sd, color=BAND, alpha=0.22, linewidth=0,
                            label="estimate ± 2 sd of the filter")
            ax.plot(depth, bias, color=BAND, linewidth=1.4, label="estimate")
            ax.plot(depth, true, color=TRUTH, linewidth=1.3, linestyle=(0, (4, 2)), label="true bias")
            ax.set_ylim(-reach, reach)
            drifts = np.any(true != 0)
            ax.set_title(f"{sensor[0].upper()}{sensor[1]}: {'drifts' if drifts else 'healthy'}")
            ax.set_ylabel(f"Bias ({unit})")
    for ax in axes[2]:
        ax.set_xlabel("Measured depth from the first station (m)")
        ax.set_xlim(depth[0], depth[-1])
    drawing.legend_below(figure, axes[1][0].get_legend_handles_labels()[0])
    return figure


def detection_figure(title, curve, keys, points):
    figure, axes = drawing.panels(len(points), (5.8, 3.1), columns=min(len(points), 2), sharex=True, sharey=True)
    drawing.heading(figure, title, f"{wording.trials_text(curve)}. Share of wells with an alarm up to a depth; bands: {100 * curve.confidence:g} % intervals. "
                     "Thin: without drift. Grey: the drift grows.")
    for ax, point in zip(axes, points):
        c = reading.at_point(curve, keys, point)
        for m, (label, colour, style) in METHODS.items():
            of = c.where(lambda i, c=c, m=m: c["method"][i] == m)
            x = of["md_m"]
            start = np.flatnonzero(of["drift_share"] > 0)[0] - 1
            ax.axvspan(x[start], x[-1], color="#EEEEEE", linewidth=0, zorder=0)
            ax.fill_between(x, 100 * of["p_alarm_ci_low"], 100 * of["p_alarm_ci_high"], color=colour, alpha=0.22,
                            linewidth=0)
            ax.plot(x, 100 * of["p_alarm"], color=colour, linestyle=style, linewidth=2.0, label=label)
            ax.plot(x, 100 * of["p_alarm_without_drift"], color=colour, linestyle=style, linewidth=0.8)
        ax.axhline(50, color="#888888", linewidth=0.6)
        ax.set_xlim(x[0], x[-1])
        ax.set_ylim(-2, 102)
        ax.set_title(wording.point_name(keys, point) if keys else "")
    for ax in axes[-2:]:
        ax.set_xlabel("Measured depth from the first station (m)")
    for ax in axes[::2]:
        ax.set_ylabel("Wells with an alarm (%)")
    drawing.legend_below(figure, axes[0].get_legend_handles_labels()[0])
    return figure


ROWS = (("bias_filter", "nis_mean", "mean NIS"), ("bias_filter", "nis_within_95", "NIS below its 95 % quantile"),
        ("bias_filter", "nees_mean", "mean NEES"), ("channel_sprt", "p_alarm_without_drift", "false alarms of the SPRT"))


def verdicts_figure(title, comparison, keys, points):
    """Theory over Monte Carlo: a panel a point of the sweep, a line a quantity; the band of each is that of its own margin."""
    panels = []
    for point in points:
        table = reading.at_point(comparison, keys, point)
        rows = {label: table.row(formulation=f, quantity=q) for f, q, label in ROWS}
        panels.append((wording.point_name(keys, point), {n: [(r, "", False)] for n, r in rows.items() if r is not None}))
    return ratios.lines_figure(title, f"{wording.trials_text(comparison)} a point. Theory over Monte Carlo. NIS and NEES: all six biases walk as the filter "
                               "assumes; false alarms: no sensor drifts, theory by integration. Points of a sweep share their draws.", panels,
                               {label: (label, METHODS[f][1]) for f, _, label in ROWS}, comparison.confidence, min(2, len(points)))


def draw(file, stem, folder, point_number):
    """All figures of a result; point_number: of the sweep, for the tracks."""
    config = reading.configuration(file)
    curve, comparison, series = (reading.read_table(file, n) for n in ("alarm_curve", "comparison", "series"))
    keys = reading.sweep_keys(config, curve)
    points = reading.sweep_points(curve, keys)
    if not 0 <= point_number < len(points):
        raise reading.PlotError(f"--point {point_number}: must be in [0, {len(points) - 1}]", USAGE)
    title = wording.title_of(file)
    saving.save(detection_figure(title, curve, keys, points), folder, f"{stem}_detection")
    saving.save(verdicts_figure(title, comparison, keys, points), folder, f"{stem}_verdicts")
    point = points[point_number]
    if len(points) > 1:
        stem, title = f"{stem}_point{point_number}", f"{title}: {wording.point_name(keys, point)}"
    saving.save(tracks_figure(title, reading.at_point(series, keys, point)), folder, f"{stem}_tracks")
