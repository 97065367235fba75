"""Figures of a corrected_codes result: does a corrected tool code keep what it claims, where, and what breaks it?

    surveymc plot corrected_codes RESULT.h5 [-o FOLDER]

Of a result with maps, a panel for each point of the sweep:
<stem>_class    what the correction does in every direction of the hole: four colours, hatched where nothing is determined; the
                circle of 15 degrees about magnetic east and west and the line kappa = 0.12, inside which axial correction fails
<stem>_order_needed  the order of prediction that the last position to the side needs there, if the config has predictions beyond first order
<stem>_world    the same of one well at every place, with coast lines
Of a result with wells, a panel for each well:
<stem>_along    azimuth that is left over that claimed, station by station, a curve a correction; at the end the last position
<stem>_budget   share of the variance of the last position to the side, by what was drawn
<stem>_tails    with table `tails`: lateral errors beyond k sd against k, and the line of the normal distribution

each as PNG and SVG. What the result has not is not drawn.
"""

import os
import textwrap

import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import drawing, order_map, reading, saving, tails, wording
from .msa_benefit import panels_of
from .reading import PlotError
from .tool_codes import cell_edges

SPANS = ("correction.kind",)  # keys of a sweep that has figures of its own here

DEGREE = "\N{DEGREE SIGN}"
# Told apart by lightness, too.
CLASSES = (("free", "#A6D8F0", "free: the uncorrected survey holds, too"),
           ("kept", "#009E73", "kept: the correction makes the claim true"),
           ("broken", "#D55E00", "broken: neither holds"),
           ("harmful", "#5B2A86", "harmful: only the uncorrected survey holds"))
UNDETERMINED = 4
HATCH = "////"
KAPPA, CIRCLE = 0.12, 15.0
COAST = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "data", "coast_110m.csv")
LOOKS = {"none": ("#777777", (0, (4, 2))), "msa": ("#D55E00", "-"), "msa3": ("#0072B2", "-"), "joint": ("#E69F00", "-"),
         "joint_priors": ("#009E73", "-"), "axial": ("#CC79A7", "-"), "estimator": ("#000000", "-")}
CORRECTIONS = {"none": "uncorrected", "msa": "MSA, six parameters", "msa3": "MSA, three biases", "joint": "joint",
               "joint_priors": "joint with priors", "axial": "axial", "estimator": "own estimator"}

def looks_of(corrections):
    """{correction: (colour, line, words)} in a fixed order; sets of parameters have names of their own, and come last."""
    looks = {k: (*LOOKS[k], CORRECTIONS[k]) for k in LOOKS if k in corrections}
    lines = ("-", "--", "-.", ":")
    others = [k for k in dict.fromkeys(corrections) if k not in LOOKS]
    return looks | {k: ("#000000", lines[i % len(lines)], k) for i, k in enumerate(others)}


# What is drawn, in groups that a reader can tell apart.
BUDGET = (("interference", "#D55E00", ("interference",)),
          ("reference dip", "#0072B2", ("dip",)),
          ("reference total field", "#56B4E9", ("total_field",)),
          ("declination", "#CC79A7", ("declination", "station_declination")),
          ("field of a station", "#999999", ("station_total_field", "station_dip")),
          ("magnetometer biases", "#009E73", tuple(f"magnetometer_bias_{a}" for a in "xyz")),
          ("magnetometer scales", "#E69F00", tuple(f"magnetometer_scale_{a}" for a in "xyz")),
          ("accelerometers", "#F0E442", tuple(f"accelerometer_{k}_{a}" for k in ("bias", "scale") for a in "xyz")),
          ("magnetometer noise", "#000000", ("magnetometer_noise",)))


# --- maps -----------------------------------------------------------------------------------------------------------


def read_map(file, name):
    """The map as (values, list of (axis name, its values)), the sweep's dimensions first; None if there is none."""
    path = f"maps/{name}"
    if path not in file:
        return None
    data, axes = file[path], []
    for dimension in data.dims:
        scale = dimension[0]
        text = h5py.check_string_dtype(scale.dtype) is not None
        axes.append((os.path.basename(scale.name), list(scale.asstr()[()]) if text else scale[()]))
    if min(data.shape[-2:]) < 2:
        raise PlotError(f"{file.filename}: {path} is a line or a point: give both axes of [map] two values")
    return data[()], axes


def coast_lines():
    """Longitudes and latitudes (deg) of every line."""
    with open(COAST, encoding="utf-8") as file:
        numbers = [np.array(line.split(","), float) for line in file if not line.startswith("#")]
    return [(line[::2], line[1::2]) for line in numbers]


def draw_classes(ax, x, y, classes):
    cmap = plt.matplotlib.colors.ListedColormap([colour for _, colour, _ in CLASSES])
    ax.grid(False)
    ax.pcolormesh(x, y, np.ma.masked_where(classes >= UNDETERMINED, classes), cmap=cmap, vmin=-0.5, vmax=3.5, rasterized=True)
    ax.patch.set(facecolor="#F2F2F2", hatch=HATCH, edgecolor="#999999", linewidth=0)  # what is not covered


def class_handles(values):
    handles = [Patch(color=colour, label=label) for k, (_, colour, label) in enumerate(CLASSES) if (values == k).any()]
    if (values >= UNDETERMINED).any():
        handles.append(Patch(facecolor="#F2F2F2", edgecolor="#999999", hatch=HATCH, label="not determined"))
    return handles


def panel_grid(values, axes, size):
    """(figure, [(axes, map, number of its point)]). Corrections stand beside each other, wells below each other."""
    sweep = axes[:-2]
    numbers = np.arange(values[..., 0, 0].size).reshape(values.shape[:-2] or (1,))
    across = next((d for d, (name, _) in enumerate(sweep) if name == "correction.kind"), None)
    if across is not None and len(sweep[across][1]) > 1 and numbers.size > len(sweep[across][1]):
        columns = len(sweep[across][1])
        order = np.moveaxis(numbers, across, -1).ravel()
    else:
        columns = min(int(np.ceil(np.sqrt(numbers.size))), 4)
        order = numbers.ravel()
    rows = -(-len(order) // columns)
    figure, grid = plt.subplots(rows, columns, squeeze=False, sharex=True, sharey=True, layout="constrained",
                                figsize=(max(size[0] * columns + 0.6, 7.2), size[1] * rows + 1.5))
    maps, drawn = values.reshape(-1, *values.shape[-2:]), []
    for i, ax in enumerate(grid.flat):
        if i >= len(order):
            ax.set_axis_off()
            grid.flat[i - columns].xaxis.set_tick_params(labelbottom=True)
            continue
        index = np.unravel_index(order[i], numbers.shape)
        point = [(name, at[k]) for (name, at), k in zip(sweep, index)]
        words = [CORRECTIONS[v] for name, v in point if name == "correction.kind"]
        others = [(name, v) for name, v in point if name != "correction.kind"]
        words = ([wording.point_name(*zip(*others))] if others else []) + words
        ax.set_title("\n".join(line for part in words for line in textwrap.wrap(part, int(size[0] * 12))), fontsize=8.5)
        drawn.append((ax, maps[order[i]], int(order[i])))
    return figure, drawn


def share_text(shares):
    return ", ".join(f"{100 * s:.0f} % {name}" for s, (name, *_) in zip(shares, (*CLASSES, ("undetermined",))) if s > 0.0005)


def class_figure(title, claimed, found, kappa, norths):
    """norths: declination of each point, deg."""
    values, axes = found
    inclination, azimuth = (np.asarray(a[1], float) for a in axes[-2:])
    figure, panels = panel_grid(values, axes, (3.3, 2.3))
    drawing.heading(figure, title, f"What a correction does to the last position to the side, against what {claimed} claims, by "
                                   "direction of the hole at its end; first order. A cell a direction.")
    x, y = cell_edges(azimuth), np.clip(cell_edges(inclination), 0, 180)
    fine = np.meshgrid(np.linspace(x[0], x[-1], 721), np.linspace(y[0], y[-1], 361))
    for ax, shown, point in panels:
        draw_classes(ax, x, y, shown)
        along = np.abs(np.sin(np.radians(fine[1])) * np.sin(np.radians(fine[0] - norths[point])))
        away = np.degrees(np.arccos(np.clip(along, 0, 1)))
        ax.contour(*fine, away, levels=[CIRCLE], colors="white", linewidths=2.6)
        ax.contour(*fine, away, levels=[CIRCLE], colors="black", linewidths=1.0, linestyles="dashed")
        # s_h / Bh is the same in all directions: kappa of any cell gives it.
        cell = np.unravel_index(np.argmin(kappa[point]), kappa[point].shape)
        east = np.sin(np.radians(inclination[cell[0]])) * np.sin(np.radians(azimuth[cell[1]] - norths[point]))
        ratio = kappa[point][cell] * (1 - east**2)
        line = ratio / np.maximum(1 - along**2, 1e-12)
        if line.min() < KAPPA < line.max():
            ax.contour(*fine, line, levels=[KAPPA], colors="white", linewidths=2.6)
            ax.contour(*fine, line, levels=[KAPPA], colors="black", linewidths=1.6)
        ax.set_xlim(x[0], x[-1])
        ax.set_ylim(y[0], y[-1])
        ax.set_xticks([t for t in np.arange(-360, 361, 45) if x[0] <= t <= x[-1]])
        ax.set_yticks([t for t in np.arange(0, 181, 30) if y[0] <= t <= y[-1]])
        if ax.get_subplotspec().is_first_col():
            ax.set_ylabel(f"inclination ({DEGREE})")
        ax.set_xlabel(f"azimuth ({DEGREE})" if ax.get_subplotspec().is_last_row() else "")
    drawing.legend_below(figure, [*class_handles(values),
                                  Line2D([], [], color="black", linewidth=1.6, label=f"kappa {KAPPA:g}: axial correction fails inside"),
                                  Line2D([], [], color="black", linewidth=1.0, linestyle="dashed", label=f"{CIRCLE:g}{DEGREE} from magnetic east or west")])
    return figure


def world_figure(title, claimed, found):
    values, axes = found
    latitude, longitude = (np.asarray(a[1], float) for a in axes[-2:])
    figure, panels = panel_grid(values, axes, (4.4, 2.25))
    drawing.heading(figure, title, f"What a correction does to the last position of one well to the side, against what {claimed} "
                                   "claims, by place; first order. Shares are of the area that is drawn.")
    x, y = cell_edges(longitude), np.clip(cell_edges(latitude), -90, 90)
    coast = coast_lines()
    weights = np.cos(np.radians(latitude))[:, None] * np.ones(len(longitude))
    for ax, shown, _ in panels:
        draw_classes(ax, x, y, shown)
        for line in coast:
            for turn in (-360, 0, 360) if x[-1] > 180 or x[0] < -180 else (0,):
                ax.plot(line[0] + turn, line[1], color="white", linewidth=1.5, zorder=3)
                ax.plot(line[0] + turn, line[1], color="black", linewidth=0.55, zorder=3.1)
        ax.set_xlim(x[0], x[-1])
        ax.set_ylim(y[0], y[-1])
        ax.set_aspect("equal")
        ax.set_xticks([t for t in np.arange(-180, 361, 60) if x[0] <= t <= x[-1]])
        ax.set_yticks([t for t in np.arange(-90, 91, 30) if y[0] <= t <= y[-1]])
        shares = [weights[shown == k].sum() / weights.sum() for k in range(UNDETERMINED + 1)]
        ax.set_title(ax.get_title(loc="left") + "\n" + share_text(shares), fontsize=8.5)
        if ax.get_subplotspec().is_first_col():
            ax.set_ylabel(f"latitude ({DEGREE})")
        ax.set_xlabel(f"longitude ({DEGREE})" if ax.get_subplotspec().is_last_row() else "")
    drawing.legend_below(figure, [*class_handles(values), Line2D([], [], color="black", linewidth=0.8, label="coast lines: Natural Earth")])
    return figure


# --- wells ----------------------------------------------------------------------------------------------------------


def wells_of(table, keys):
    """[(name, rows)]: the points of the sweep without the correction, in the order of the file."""
    others = [k for k in keys if k not in ("correction.kind", "correction")]
    return [("" if not others else wording.point_name(others, list(point)), reading.at_point(table, others, point))
            for point in reading.sweep_points(table, others)]


def along_figure(title, claimed, claims, keys):
    wells = wells_of(claims.where(lambda i: claims["scope"][i] == "magnetic"), keys)
    figure, axes = drawing.panels(len(wells), (3.7, 2.5), columns=min(len(wells), 4), sharey=True)
    seen, used, is_drawn = [1.0], [], False
    looks = looks_of(list(claims["correction"]))
    for ax, (name, rows) in zip(axes, wells):
        ax.axhspan(0.01, 1.05, color="#009E73", alpha=0.12, linewidth=0, zorder=0)
        ax.axhline(1, color="#444444", linewidth=1.0, zorder=1)
        for kind in dict.fromkeys(rows["correction"]):
            colour, line, _ = looks[kind]
            of = rows.where(lambda i: rows["correction"][i] == kind)
            stations, end = (of.where(lambda i: of["quantity"][i] == q) for q in ("azimuth", "lateral"))
            shown = False
            for part, look in ((stations, {"linestyle": line}), (end, {"marker": "o", "markersize": 6, "linestyle": "none"})):
                good = part["predicted_ratio"]
                if part.rows and np.isfinite(good).any():
                    ax.plot(part["md_m"], good, color=colour, zorder=3, clip_on=False, **look)
                    seen += list(good[np.isfinite(good)])
                    shown = True
            if shown and stations.rows and np.isfinite(stations["ratio"]).any():
                ax.fill_between(stations["md_m"], stations["ratio_ci_low"], stations["ratio_ci_high"], color=colour, alpha=0.3, linewidth=0, zorder=2)
                is_drawn = True
            if kind not in used and shown:
                used.append(kind)
        ax.set_title(name)
        ax.set_xlabel("measured depth (m)")
    low, high = max(min(seen), 0.03), min(max(seen), 40)
    axes[0].set_yscale("log")
    axes[0].set_ylim(low / 1.2, high * 1.2)
    drawing.plain_log_axis(axes[0].yaxis, low / 1.2, high * 1.2)
    for ax in axes[::min(len(wells), 4)]:
        ax.set_ylabel("left / claimed")
    trials = f"; bands: of the trials, {100 * claims.confidence:g} % intervals" if is_drawn else ""
    drawing.heading(figure, title, f"sd that is left over the sd that {claimed} claims. Curves: azimuth of every station; dots: last position "
                                   f"to the side; first order{trials}. Green: the claim holds.")
    drawing.legend_below(figure, [Line2D([], [], color=colour, linestyle=line, label=words) for k, (colour, line, words) in looks.items() if k in used])
    return figure


def budget_figure(title, claimed, budget, keys):
    lateral = budget.where(lambda i: budget["quantity"][i] == "lateral")
    wells = wells_of(lateral, keys)
    looks = looks_of(list(lateral["correction"]))
    kinds = list(looks)
    columns = min(len(wells), 4)
    figure, axes = drawing.panels(len(wells), (3.3 if columns > 1 else 6.6, max(2.0, 0.26 * len(kinds) + 0.95)), columns=columns, sharex=True, sharey=True)
    used = set()
    for ax, (name, rows) in zip(axes, wells):
        for y, kind in enumerate(kinds):
            left = 0.0
            share = {n: s for n, s, k in zip(rows["input"], rows["share"], rows["correction"]) if k == kind}
            if not share or not np.isfinite(list(share.values())).all():
                ax.text(0.01, y, "not determined" if share else "", va="center", fontsize=8, style="italic")
                continue
            for group, colour, inputs in BUDGET:
                part = sum(share[n] for n in inputs)
                ax.barh(y, part, left=left, height=0.72, color=colour, edgecolor="white", linewidth=0.5)
                left += part
                used |= {group} if part > 0 else set()
        ax.set_title(name)
        ax.set_yticks(range(len(kinds)), [looks[k][2] for k in kinds])
        ax.set_ylim(len(kinds) - 0.5, -0.5)
        ax.set_xlim(0, 1)
        ax.grid(False, axis="y")
    for ax in axes[-columns:]:
        ax.set_xlabel("share of the variance")
    drawing.heading(figure, title, "What the error of the last position to the side is made of, by what was drawn; first order. What is large "
                                   f"decides whether {claimed} holds; how large the whole is, the figure along the well says.")
    drawing.legend_below(figure, [Patch(color=colour, label=group) for group, colour, _ in BUDGET if group in used])
    return figure


def figures_of(file):
    """[(name, figure)]."""
    config, title = reading.configuration(file), wording.title_of(file)
    claims, budget, validity = (reading.read_table(file, n) for n in ("claims", "budget", "validity"))
    claimed = " or ".join(dict.fromkeys(validity["claimed"]))
    out = []
    found = read_map(file, "class")
    if found is not None and [a[0] for a in found[1][-2:]] == ["latitude", "longitude"]:
        out.append(("world", world_figure(title, claimed, found)))
    elif found is not None:
        kappa = file["maps/kappa"][()].reshape(-1, *found[0].shape[-2:])
        points = [dict(zip([a[0] for a in found[1][:-2]], at)) for at in
                  (tuple(a[1][i] for a, i in zip(found[1][:-2], index)) for index in np.ndindex(found[0].shape[:-2]))]
        norths = [float(p.get("field.declination_deg", config.get("field", {}).get("declination_deg", 0.0))) for p in points]
        out.append(("class", class_figure(title, claimed, found, kappa, norths)))
    orders = read_map(file, "order_needed")
    if orders is not None and orders[1][-1][0] == "azimuth":
        out.append(("order_needed", order_map.figure(title, "the last position to the side of the hole", panels_of(*orders),
                                                     orders[1][-2][1], orders[1][-1][1])))
    if claims is not None:
        out.append(("along", along_figure(title, claimed, claims, reading.sweep_keys(config, claims))))
        out.append(("budget", budget_figure(title, claimed, budget, reading.sweep_keys(config, budget))))
    beyond = reading.read_table(file, "tails")
    figure = None if beyond is None else tails.coverage_figure(title, beyond, reading.sweep_keys(config, beyond))
    return out if figure is None else [*out, ("tails", figure)]


def main():
    arguments = saving.argument_parser(__doc__.splitlines()[0]).parse_args()
    drawing.use_style()
    stem = saving.stem_of(arguments.result)
    with reading.open_result(arguments.result, "corrected_codes") as file:
        figures = figures_of(file)
    folder = saving.figures_folder(arguments.output, arguments.result)
    for name, figure in figures:
        saving.save(figure, folder, f"{stem}_{name}")
