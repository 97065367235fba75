"""Figures of survey tools beside each other, PNG and SVG next to the result.

    surveymc plot tool_codes RESULT.h5 [-o FOLDER] [--point I] [--md M] [--order sd|family] [--reference MODEL]

Of a tool_code_map result:
<stem>_maps     lateral standard deviation over inclination and azimuth, a panel a model, one colour scale; blank where the
                model does not claim to hold; dashed: magnetic east and west
<stem>_ratio    the same over that of the first model, or of --reference: above 1 a correction is worse than nothing
Of a position_covariance result with a sweep over error models:
<stem>_bars     lateral, high-side and along-hole standard deviation of every model at measured depth --md (the last station);
                hollow where the model does not claim to hold
Maps of a sweep are drawn of one point: --point (counted from 0, in the order of the file; the first), and they are named
<stem>_point<I>_<figure>. A position_covariance result of one model has no such figure.
"""
import sys
import textwrap

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D

from ..arguments import USAGE
from . import drawing, reading, saving, wording
from .reading import PlotError

SPANS = ("error_model.name",)  # keys of a sweep that has figures of its own here

DEGREE = "\N{DEGREE SIGN}"
DIRECTIONS = (("lateral", "#0072B2", "o"), ("high_side", "#D55E00", "s"), ("along_hole", "#555555", "^"))
SWEPT = ("error_model.name", "error_model")
BLANK = "0.82"  # grey of cells without a value: white is a colour of the ratio's scale


def words(dataset):
    return [w.decode() if isinstance(w, bytes) else w for w in dataset[()]]


# --- maps -----------------------------------------------------------------------------------------------------------


class Maps:
    """The maps of one point of a result: values [model][inclination][azimuth]."""

    def __init__(self, file, number=0):
        data = file["maps"]["sd_lateral_m"]
        scales = [dim[0] for dim in data.dims]
        index, keys, point, self.points = reading.map_point(file, data, 3, number)
        self.models = words(scales[-3])
        self.inclination, self.azimuth = (np.asarray(s[()], float) for s in scales[-2:])
        inside = file["maps"]["inside_range"][index] > 0
        self.lateral = np.where(inside, data[index], np.nan)
        config = reading.configuration(file)
        self.declination = reading.norths_at(file, config, keys, point)[0]
        self.title = ": ".join(filter(None, (wording.title_of(file), wording.point_name(keys, point))))


def cell_edges(centres):
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    inner = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - inner[0]], inner, [2 * centres[-1] - inner[-1]]])


def panels(maps, values, norm, cmap, label, blank):
    """`blank`: what a cell without a value says."""
    count = len(maps.models)
    columns = min(4, count)
    rows = -(-count // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(2.6 * columns + 1, 2.1 * rows + 0.9), squeeze=False, sharex=True,
                                sharey=True, layout="constrained")
    x, y = cell_edges(maps.azimuth), np.clip(cell_edges(maps.inclination), 0, 180)  # there is no hole beyond
    notes = ["dashed: magnetic east and west"] + ([f"grey: {blank}"] if np.isnan(values).any() else [])
    text = f"{'; '.join(notes)}."
    drawing.heading(figure, maps.title, text[0].upper() + text[1:])
    drawn = None
    for i, panel in enumerate(axes.flat):
        if i >= count:
            panel.set_axis_off()
            continue
        drawn = panel.pcolormesh(x, y, values[i], norm=norm, cmap=cmap, rasterized=True)
        panel.set_facecolor(BLANK)
        panel.set_title(maps.models[i], fontsize=8)
        for turn in (-360, 0, 360):
            for east_west in (90, 270):
                at = east_west + maps.declination + turn
                if x[0] <= at <= x[-1]:
                    panel.axvline(at, color="k", linestyle="--", linewidth=0.6)
        panel.set_xlim(x[0], x[-1])
        if x[-1] - x[0] > 180:
            panel.set_xticks([t for t in (0, 90, 180, 270, 360) if x[0] <= t <= x[-1]])
        panel.set_ylim(y[0], y[-1])
        if panel.get_subplotspec().is_last_row():
            panel.set_xlabel(f"azimuth ({DEGREE})")
        if panel.get_subplotspec().is_first_col():
            panel.set_ylabel(f"inclination ({DEGREE})")
    bar = figure.colorbar(drawn, ax=axes, label=label, extend="max")
    ticks = [t * 10.0**e for e in range(-3, 4) for t in (1, 1.5, 2, 3, 5, 7)]
    bar.set_ticks([t for t in ticks if norm.vmin <= t <= norm.vmax])
    bar.ax.minorticks_off()
    bar.ax.yaxis.set_major_formatter("{x:g}")
    return figure


def draw_maps(maps):
    finite = maps.lateral[np.isfinite(maps.lateral) & (maps.lateral > 0)]
    if finite.size == 0:
        raise PlotError("map sd_lateral_m has no value where a model holds")
    # A pole of a gyrocompass would take the whole scale.
    norm = LogNorm(finite.min(), max(np.quantile(finite, 0.98), 1.01 * finite.min()))
    return panels(maps, maps.lateral, norm, "viridis", "lateral sd (m)", "the model does not hold")


def draw_ratio(maps, reference):
    if reference is not None and reference not in maps.models:
        raise PlotError(f"--reference {reference}: must be one of {', '.join(maps.models)}", USAGE)
    base = maps.lateral[maps.models.index(reference) if reference is not None else 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = maps.lateral / base
    finite = ratio[np.isfinite(ratio)]
    if finite.size == 0:
        raise PlotError("no cell in which two models hold")
    # A scale of factors, the same both ways; a pole of a gyrocompass would take the whole of it.
    top = float(np.clip(np.quantile(np.maximum(finite, 1 / finite), 0.98), 1.1, 3.0))
    norm = LogNorm(1 / top, top)
    name = reference if reference is not None else maps.models[0]
    return panels(maps, ratio, norm, "RdBu_r", f"lateral sd over that of {name}", f"the model or {name} does not hold")


# --- bars -----------------------------------------------------------------------------------------------------------


def family(name):
    """What a name begins with: MWD+SRGM, EMS, GYRO ..."""
    return name.replace("_Fl", "").split("-")[0]


def draw_bars(file, md, order):
    """None if the result has one model only, or if a model has several wells: one of a sweep over more than the model."""
    table, validity = reading.read_table(file, "covariance"), reading.read_table(file, "validity")
    key = next((k for k in SWEPT if table is not None and k in table), None)
    if key is None:
        return None
    models = list(dict.fromkeys(table[key]))
    depths = np.asarray(table["md_m"], float)
    at_depth = depths.max() if md is None else depths[np.argmin(np.abs(depths - md))]
    outside = set()
    if validity is not None:
        for model, rule, first, last in zip(validity[key], validity["rule"], validity["first_md_m"], validity["last_md_m"]):
            if rule in ("inclination range", "east-west exclusion", "not finite") and first <= at_depth <= last:
                outside.add(model)
    rows = {model: [i for i, (m, d) in enumerate(zip(table[key], depths)) if m == model and d == at_depth] for model in models}
    if len(models) < 2 or any(len(of_model) != 1 for of_model in rows.values()):
        return None
    values = {m: {d: float(table[f"sd_{d}_m"][row]) for d, *_ in DIRECTIONS} for m, (row,) in rows.items()}
    lateral = {m: np.nan_to_num(values[m]["lateral"], nan=np.inf) for m in models}
    models.sort(key=(lambda m: lateral[m]) if order == "sd" else (lambda m: (family(m), lateral[m])))
    lines = {}  # models of the same three values stand on one line
    for m in models:
        lines.setdefault((*(f"{v:.3g}" for v in values[m].values()), m in outside), []).append(m)
    names = [textwrap.wrap(", ".join(of), 62) for of in lines.values()]
    high = np.array([max(len(n), 1.35) for n in names])
    y = np.cumsum(high) - high / 2
    figure, panel = plt.subplots(figsize=(10, 0.165 * high.sum() + 1.6), layout="constrained")
    for at, of, tall in zip(y, lines.values(), high):
        model = of[0]
        sizes = [v for v in values[model].values() if np.isfinite(v) and v > 0]
        if not sizes:
            text = "0 m" if values[model]["lateral"] == 0 else "no covariance: a weight is not finite"
            panel.text(0.006, at, text, va="center", fontsize=7.5, style="italic", transform=panel.get_yaxis_transform())
            continue
        panel.plot((min(sizes), max(sizes)), (at, at), color="#BBBBBB", linewidth=1.2, zorder=1)
        for direction, colour, marker in DIRECTIONS:
            panel.plot(values[model][direction], at, marker, color=colour, markersize=6, markerfacecolor="white" if model in outside else colour)
    panel.set_yticks(y, ["\n".join(n) for n in names], fontsize=7)
    panel.set_ylim(high.sum(), 0)
    sizes = [v for m in models for v in values[m].values() if np.isfinite(v) and v > 0]
    if sizes and max(sizes) > 20 * np.median(sizes):  # a blind hole would make all others look alike
        panel.set_xscale("log")
        panel.set_xlim(0.7 * min(sizes), 1.4 * max(sizes))
        drawing.plain_log_axis(panel.xaxis, *panel.get_xlim())
    else:
        panel.set_xlim(0, None)
    panel.set_xlabel(f"standard deviation, 1{wording.SIGMA} (m)")
    drawing.heading(figure, wording.title_of(file), f"{len(models)} survey tools at a measured depth of {at_depth:g} m, tools of equal values on one line.")
    handles = [Line2D([], [], color=colour, marker=marker, linestyle="none", label=direction.replace("_", " "))
               for direction, colour, marker in DIRECTIONS]
    if outside:
        handles.append(Line2D([], [], color="#444444", marker="o", markerfacecolor="white", linestyle="none", label="hollow: the model does not hold there"))
    drawing.legend_below(figure, handles)
    return figure


def main():
    parser = saving.argument_parser("Draw survey tools beside each other.")
    parser.add_argument("--point", type=int, metavar="I", help="sweep point of the maps, from 0 (the first)")
    parser.add_argument("--md", type=float, metavar="M", help="measured depth of the bars (the last station)")
    parser.add_argument("--order", choices=("sd", "family"), default="sd", help="of the bars")
    parser.add_argument("--reference", metavar="MODEL", help="model that the ratios are over (the first)")
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, ("tool_code_map", "position_covariance")) as file:
        if "maps" in file and "sd_lateral_m" in file["maps"]:
            maps = Maps(file, arguments.point or 0)
            prefix = f"point{arguments.point or 0}_" if maps.points > 1 else ""
            figures = {f"{prefix}maps": draw_maps(maps)}
            if len(maps.models) > 1:
                figures[f"{prefix}ratio"] = draw_ratio(maps, arguments.reference)
        else:
            bars = draw_bars(file, arguments.md, arguments.order)
            figures = {} if bars is None else {"bars": bars}
    if not figures:
        print(f"{arguments.result}: nothing to draw: bars compare several error models at one well", file=sys.stderr)
    saving.save_all(figures, arguments)
