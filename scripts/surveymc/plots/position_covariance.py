"""Figures of a position_covariance result: how uncertain is a well along its length, and which errors make it so?

    surveymc plot position_covariance RESULT.h5 [-o FOLDER] [--point I] [--sigma K] [--magnify F]

<stem>_along     standard deviations along the well: high side, lateral, along hole; horizontal ellipse and vertical
<stem>_sources   variance by error source, stacked: of the horizontal position and of the vertical
<stem>_views     plan and vertical section with K-sigma ellipses (2), F times as large as the map (as large as fits)
<stem>_compare   standard deviations of all points, if the run is a sweep of at most 24

each as PNG and SVG. Of a sweep the first three are drawn for the point given by --point (counted from 0, in the order of
the file) and are then named <stem>_point<I>_<figure>.
"""

import os

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from . import drawing, geometry, one_point, reading, saving, wording
from .reading import PlotError
from .wording import number

SPANS = ("error_model.name",)  # keys of a sweep that has figures of its own here

SIGMA = "\N{GREEK SMALL LETTER SIGMA}"
DEGREE = "\N{DEGREE SIGN}"
TIMES = "\N{MULTIPLICATION SIGN}"
HOLE = (("sd_high_side_m", "high side", "#0072B2", "-"), ("sd_lateral_m", "lateral", "#D55E00", (0, (6, 2))),
        ("sd_along_hole_m", "along hole", "#222222", (0, (1, 1.2))))
MAP = (("semi_major_m", "horizontal, major axis", "#D55E00", "-"),
       ("semi_minor_m", "horizontal, minor axis", "#0072B2", (0, (6, 2))),
       ("sd_vertical_m", "vertical", "#222222", (0, (1, 1.2))))
ELLIPSE = "#D55E00"
LARGEST_SOURCES = 7
# Distinguishable in order, with common colour blindness too; the rest of the sources is grey.
SOURCE_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442")
HATCHES = ("", "//", "", "\\\\", "", "xx", "")


def with_a_covariance(table):
    """Which rows have one: a model may have no finite weight somewhere along a well."""
    return np.all([np.isfinite(table[e]) for e in geometry.COVARIANCE], axis=0)


def left_out(table):
    """' At 3 of 40 stations there is no covariance: a weight is not finite.'; '' where all have one."""
    missing = int(np.count_nonzero(~with_a_covariance(table)))
    return f" At {missing} of {table.rows} stations there is no covariance: a weight is not finite." if missing else ""


def leg_starts(terms):
    """Measured depths where a second or later survey leg begins."""
    if terms is None:
        return []
    return sorted({float(m) for m, leg in zip(terms["from_md_m"], terms["leg"]) if leg > 1})


def models_text(terms):
    """'models/tool.toml, from 192 m iscwsa_mwd_rev5.10'."""
    if terms is None or terms.rows == 0:
        return ""
    legs = {}
    for leg, md, model in zip(terms["leg"], terms["from_md_m"], terms["model"]):
        legs[leg] = model if leg == 1 else f"from {number(md)} m {model}"
    return ", ".join(legs.values())


def mark_legs(ax, starts):
    for md in starts:
        ax.axvline(md, color="#777777", linewidth=1.0, linestyle=(0, (4, 3)), zorder=0.5)


# --- 1: along the well ----------------------------------------------------------------------------------------------


def along_figure(title, covariance, ellipsoid, terms):
    figure, panels = plt.subplots(3, 1, figsize=(11.5, 9.2), sharex=True, height_ratios=(3, 3, 1.2), layout="constrained")
    drawing.heading(figure, title, f"Position uncertainty along the well, 1{SIGMA}. Error model: {models_text(terms)}.{left_out(covariance)}")
    md = covariance["md_m"]
    for ax, lines, what in ((panels[0], HOLE, "Relative to the hole"), (panels[1], MAP, "On the map, and vertical")):
        for key, label, colour, style in lines:
            values = np.where(with_a_covariance(covariance), covariance[key], np.nan)
            ax.plot(md, values, color=colour, linestyle=style, linewidth=1.8,
                    label=f"{label}, {number(values[-1])} m at the last station")
        ax.set_title(what)
        ax.set_ylabel(f"Standard deviation, 1{SIGMA} (m)")
        ax.set_ylim(0, None)
        ax.legend(loc="upper left")
    panels[2].plot(ellipsoid["md_m"], ellipsoid["inclination_deg"], color="#0072B2")
    panels[2].set_ylabel(f"Inclination ({DEGREE})")
    panels[2].set_ylim(0, max(95, 1.05 * np.max(ellipsoid["inclination_deg"])))
    panels[2].set_yticks((0, 30, 60, 90))
    panels[2].set_xlabel("Measured depth (m)")
    panels[2].set_xlim(md[0], md[-1])
    starts = leg_starts(terms)
    for ax in panels:
        mark_legs(ax, starts)
    if starts:
        panels[2].annotate("next survey leg", (starts[0], 0.92), xycoords=("data", "axes fraction"), xytext=(5, 0),
                           textcoords="offset points", va="top", fontsize=9, color="#555555")
    return figure


# --- 2: sources -----------------------------------------------------------------------------------------------------


def families(terms):
    """{source: name of its family}: sources of one weighting function (DEC-U, DEC-OS ...) are one, 'DEC* (5 terms)'."""
    by_function = {}
    for source, function in zip(terms["source"], terms["function"]):
        by_function.setdefault(function, {})[source] = None
    names = {}
    for function, sources in by_function.items():
        prefix = os.path.commonprefix(list(sources)).rstrip("-")
        for s in sources:
            names.setdefault(s, s if len(sources) == 1 else f"{prefix or function}* ({len(sources)} terms)")
    return names


def source_variances(by_source, columns, names):
    """(measured depths, {family of sources: variance at each}): the sum of `columns`, where all sources have one."""
    sources = list(dict.fromkeys(by_source["source"]))
    md = by_source["md_m"][::len(sources)]
    values = sum(by_source[c] for c in columns).reshape(-1, len(sources))
    known = np.all(np.isfinite(values), axis=1)
    md, values = md[known], values[known]
    variances = {}
    for i, s in enumerate(sources):
        name = names.get(s, s)
        variances[name] = variances.get(name, 0) + values[:, i]
    return md, variances


def largest_sources(variances, count):
    """The sources that are most of the variance, on average over the stations and at the last one, the largest at the
    last first; the sum of the others, and how many they are."""
    total = sum(variances.values())
    shares = {s: np.divide(v, total, out=np.zeros_like(v), where=total > 0) for s, v in variances.items()}
    share = {s: np.mean(x) + x[-1] for s, x in shares.items()}
    chosen = sorted(variances, key=lambda s: -share[s])[:count]
    chosen.sort(key=lambda s: -variances[s][-1])
    others = [s for s in variances if s not in chosen and share[s] > 0]
    return chosen, sum((variances[s] for s in others), np.zeros_like(total)), len(others)


def sources_figure(title, covariance, by_source, terms):
    """None where no station but the tie-on has a covariance."""
    if np.count_nonzero(with_a_covariance(covariance)) < 2:
        return None
    figure, panels = plt.subplots(2, 2, figsize=(12.5, 9.0), sharex=True, layout="constrained")
    names_of = families(terms)
    drawing.heading(figure, title, "Variance of the position by error source; variances add up, standard deviations do not. "
            f"Error model: {models_text(terms)}.{left_out(covariance)}")
    last = "the last station" if with_a_covariance(covariance)[-1] else "the last of these"
    for row, (what, columns) in enumerate((("Horizontal (N + E)", ("nn_m2", "ee_m2")), ("Vertical", ("vv_m2",)))):
        md, variances = source_variances(by_source, columns, names_of)
        chosen, rest, others = largest_sources(variances, LARGEST_SOURCES)
        total = sum(variances.values())
        stack = [variances[s] for s in chosen] + [rest]
        names = chosen + [f"{others} others"]
        colours = SOURCE_COLOURS[:len(chosen)] + ("#BBBBBB",)
        with np.errstate(invalid="ignore", divide="ignore"):
            shares = [np.where(total > 0, 100 * v / total, np.nan) for v in stack]
        for ax, layers, label in ((panels[row, 0], stack, "Variance (m\N{SUPERSCRIPT TWO})"),
                                  (panels[row, 1], shares, "Share of the variance (%)")):
            polygons = ax.stackplot(md, layers, colors=colours, edgecolor="white", linewidth=0.4)
            for polygon, hatch in zip(polygons, HATCHES[:len(chosen)] + ("",)):
                polygon.set_hatch(hatch)
            ax.set_ylabel(label)
            ax.set_xlim(md[0], md[-1])
            ax.grid(False)
            mark_legs(ax, leg_starts(terms))
        panels[row, 0].set_title(f"{what}, {SIGMA} = {number(np.sqrt(total[-1]))} m at {last}")
        panels[row, 0].set_ylim(0, 1.04 * np.max(total) if np.max(total) > 0 else 1)
        panels[row, 1].set_title(f"{what}, share")
        panels[row, 1].set_ylim(0, 100)
        end = [f"{n} ({number(v[-1] / total[-1] * 100, 2)} %)" if total[-1] > 0 else n for n, v in zip(names, stack)]
        panels[row, 1].legend(polygons[::-1], end[::-1], loc="center left", bbox_to_anchor=(1.02, 0.5),
                              title="share at\n" + last, handlelength=1.6, handleheight=1.2)
    for ax in panels[1]:
        ax.set_xlabel("Measured depth (m)")
    return figure


# --- 3: plan and section --------------------------------------------------------------------------------------------


def chosen_stations(md, count=12):
    """Indices of about `count` stations, evenly along the well, the last one always; not the tie-on."""
    wanted = np.linspace(md[0], md[-1], count + 1)[1:]
    return sorted({max(1, int(np.argmin(np.abs(md - w)))) for w in wanted})


def nice_magnification(extent, largest):
    """The largest of 1, 2, 5, 10, ... that keeps an ellipse of this semi-axis within 8 % of the drawing."""
    if largest <= 0:
        return 1
    steps = [s * 10**e for e in range(6) for s in (1, 2, 5)]
    return max([s for s in steps if s * largest <= 0.08 * extent], default=1)


def section_azimuth(north, east):
    """Direction (deg) of the vertical section: from the first station to the farthest from it."""
    far = np.argmax(np.hypot(north, east))
    return np.degrees(np.arctan2(east[far], north[far])) % 360


def views(covariance, ellipsoid):
    """The two drawings: [(name, path across, path up, 2x2 covariances in (across, up))], and the section's azimuth.

    Plan: east across, north up. Section: distance along the azimuth across, true vertical depth down.
    """
    c = geometry.covariances(covariance)
    north, east, tvd = ellipsoid["north_m"], ellipsoid["east_m"], ellipsoid["tvd_m"]
    azimuth = section_azimuth(north, east)
    a = np.radians(azimuth)
    plan = np.array([[0, 1, 0], [1, 0, 0]])
    section = np.array([[np.cos(a), np.sin(a), 0], [0, 0, 1]])
    along = geometry.rotate_to_axes(north, east, azimuth)[0]
    return [("plan", east, north, plan @ c @ plan.T), ("section", along, tvd, section @ c @ section.T)], azimuth


def set_equal_scales(ax, down):
    """One scale for both axes; a well along one of them gets room at the other, below it if `down` is up on the axis."""
    ax.relim()
    ax.autoscale_view()
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    wide, high = 1.12 * (x1 - x0), 1.12 * (y1 - y0)
    middle = (x0 + x1) / 2
    wide, more = max(wide, 0.75 * high), max(high, 0.75 * wide) - high
    ax.set_xlim(middle - wide / 2, middle + wide / 2)
    low, top = y0 - 0.06 * (y1 - y0), y1 + 0.06 * (y1 - y0)
    if down:
        ax.set_ylim(top + more, low)
    else:
        ax.set_ylim(low - more / 2, top + more / 2)
    ax.set_aspect("equal", adjustable="box", anchor="N")


def views_figure(title, covariance, ellipsoid, terms, sigma, magnify):
    drawings, azimuth = views(covariance, ellipsoid)
    known = np.flatnonzero(with_a_covariance(covariance))
    stations = [known[k] for k in chosen_stations(covariance["md_m"][known])] if len(known) > 1 else []
    figure, panels = plt.subplots(1, 2, figsize=(12.5, 7.6), layout="constrained")
    for ax, (name, x, y, c) in zip(panels, drawings):
        extent = max(np.ptp(x), np.ptp(y))
        largest = sigma * np.sqrt(max((np.linalg.eigvalsh(c[k])[1] for k in known), default=0))
        factor = magnify or nice_magnification(extent, largest)
        for k in stations:
            # ellipse_points speaks of (north, east); here these are (across, up)
            px, py = geometry.ellipse_points(c[k], sigma * factor, (x[k], y[k]))
            ax.fill(px, py, facecolor=ELLIPSE, alpha=0.22, edgecolor="none", zorder=2)
            ax.plot(px, py, color=ELLIPSE, linewidth=1.1, zorder=3)
        ax.plot(x, y, color="#222222", linewidth=1.3, zorder=4)
        ax.plot(x[stations], y[stations], ".", color="#222222", markersize=5, zorder=5)
        ax.plot(x[0], y[0], "s", color="#0072B2", markersize=6, zorder=6)
        for md in leg_starts(terms):
            k = int(np.argmin(np.abs(covariance["md_m"] - md)))
            ax.plot(x[k], y[k], "D", markerfacecolor="white", markeredgecolor="#222222", markersize=6, zorder=6)
        ax.annotate(f"{number(covariance['md_m'][-1], 4)} m", (x[-1], y[-1]), xytext=(14, 10),
                    textcoords="offset points", fontsize=9)
        set_equal_scales(ax, down=name == "section")
        enlarged = f"ellipses enlarged {factor:g} times" if factor != 1 else "ellipses at the scale of the map"
        ax.set_title(f"{'Plan view' if name == 'plan' else f'Vertical section, azimuth {azimuth:.1f}{DEGREE}'}; "
                     f"{enlarged}")
    figure.set_figheight(1.9 + 5.6 * max(abs(np.ptp(ax.get_ylim()) / np.ptp(ax.get_xlim())) for ax in panels))  # of their maps
    panels[0].set_xlabel("East of the first station (m)")
    panels[0].set_ylabel("North of the first station (m)")
    panels[1].set_xlabel(f"Distance from the first station along azimuth {azimuth:.1f}{DEGREE} (m)")
    panels[1].set_ylabel("True vertical depth (m)")
    drawing.heading(figure, title, f"Well with {sigma:g}{SIGMA} error ellipses ({100 * geometry.ellipse_coverage(sigma):.1f} % "
            f"of positions, if normal) at {len(stations)} stations. Error model: {models_text(terms)}.{left_out(covariance)}")
    handles = [Line2D([], [], color="#222222", marker=".", label="well, stations with an ellipse"),
               Line2D([], [], color=ELLIPSE, label=f"{sigma:g}{SIGMA} ellipse"),
               Line2D([], [], color="#0072B2", marker="s", linestyle="none", label="tie-on, without error")]
    if leg_starts(terms):
        handles.append(Line2D([], [], color="#222222", marker="D", markerfacecolor="white", linestyle="none",
                              label="next survey leg"))
    drawing.legend_below(figure, handles)
    return figure


# --- 4: points of a sweep -------------------------------------------------------------------------------------------


MOST_NAMED = 24  # points of a sweep: more cannot be told apart


def compare_figure(title, covariance, keys, points):
    figure, panels = drawing.panels(3, (4.3, 4.0), sharex=True)
    palette = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    styles = ("-", (0, (6, 2)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))
    for ax, (key, label, *_) in zip(panels, HOLE):
        values = []
        for i, point in enumerate(points):
            table = reading.at_point(covariance, keys, point)
            values.append(np.where(with_a_covariance(table), table[key], np.nan))
            ax.plot(table["md_m"], values[-1], color=palette[i % len(palette)], linestyle=styles[i % len(styles)], linewidth=1.8,
                    marker="o" if table.rows == 1 else None, markersize=4, label=wording.point_name(keys, point))
        seen = np.concatenate(values)
        seen = seen[seen > 0]
        if len(seen) and max(np.nanmax(v, initial=0) for v in values) > 20 * np.median([np.nanmax(v, initial=0) for v in values]):
            ax.set_yscale("log")  # one tool may make all others look alike
            drawing.plain_log_axis(ax.yaxis, *ax.get_ylim())
        else:
            ax.set_ylim(0, None)
        ax.set_title(label.capitalize())
        ax.set_xlabel("Measured depth (m)")
    panels[0].set_ylabel(f"Standard deviation, 1{SIGMA} (m)")
    drawing.heading(figure, title, f"Standard deviations along the well, 1{SIGMA}, for every point of the sweep.{left_out(covariance)}")
    drawing.legend_below(figure, panels[0].get_legend_handles_labels()[0])
    return figure


# --------------------------------------------------------------------------------------------------------------------


def positive(text):
    value = float(text)
    if not 0 < value < np.inf:
        raise ValueError
    return value


def main():
    parser = saving.argument_parser("Draw the figures of a position_covariance result.")
    parser.add_argument("--sigma", type=positive, default=2.0, metavar="K", help="size of the ellipses (2)")
    parser.add_argument("--magnify", type=positive, metavar="F", help="enlarge the ellipses F times (what fits)")
    arguments = one_point.parse(parser)
    drawing.use_style()
    with reading.open_result(arguments.result, "position_covariance") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        covariance, by_source, ellipsoid, terms = (reading.read_table(file, n) for n in
                                                   ("covariance", "covariance_by_source", "ellipsoid", "error_terms"))
    for name, table in (("covariance", covariance), ("ellipsoid", ellipsoid)):
        if table is None or table.rows == 0:
            raise PlotError(f"{arguments.result}: table '{name}' is missing or empty")
    keys = reading.sweep_keys(config, covariance)
    points = reading.sweep_points(covariance, keys)
    figures = {}
    if len(points) == 1 and covariance.rows == 1:
        raise PlotError(f"{arguments.result}: no figures along the well: it has the last station alone (output.stations)")
    elif len(points) == 1:
        name = title + (f": {wording.point_name(keys, points[0])}" if keys else "")
        figures["along"] = along_figure(name, covariance, ellipsoid, terms)
        if by_source is not None and len(set(by_source["md_m"])) > 1:  # output.by_source = "all", and a tool with errors
            figures["sources"] = sources_figure(name, covariance, by_source, terms)
        figures["views"] = views_figure(name, covariance, ellipsoid, terms, arguments.sigma, arguments.magnify)
    elif len(points) <= MOST_NAMED:
        figures["compare"] = compare_figure(title, covariance, keys, points)
    saving.save_all(figures, arguments)
