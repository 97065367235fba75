"""A sweep as a whole, of any experiment: each quantity against the keys that vary.

    surveymc plot sweep RESULT.h5 [--quantity TABLE.NAME[.COLUMN]] [--at KEY=VALUE] [-o FOLDER]

One numeric key: a curve with its intervals. Two: a map, a cell a point, with contours; of points that form no grid, contours
between them. More: a grid has a panel for each of some values of the others, other designs the quantity against each key.
Words (cases, estimators) have a line or a panel each. studies.toml names the quantities of an experiment; any other column of a
table, quantity of a comparison (NAME), or map is drawn by --quantity, which may be given several times. --at draws only the
points with this value.
"""
import argparse
import dataclasses
import itertools
import sys
import textwrap

import matplotlib
import numpy as np
import pandas
from matplotlib.lines import Line2D

from .. import studies
from ..arguments import USAGE, nearest
from ..result import Result
from ..storage import ResultError
from . import drawing, one_point, reading, saving, wording
from .reading import PlotError

SPANS = True  # draws a sweep over any keys
MOST_PANELS, MOST_LINES, MOST_ROWS, MOST_KEYS, MOST_FIGURES, MOST_DOTS = 9, 8, 40, 12, 6, 1000
ROW = "row"  # words that tell the rows of a point apart
LINE = "line"  # what a quantity has several of at a point: Monte Carlo and its predictions
FEW = 3  # a key with fewer values is no axis of a map
SCATTERED_MAP = 25  # fewer points that form no grid have no contours between them
LOOKS = [{"color": c, "linestyle": s, "marker": m} for c, s, m in zip(
    ("#0072B2", "#D55E00", "#222222", "#A8508A", "#009E73", "#777777", "#E69F00", "#56B4E9"),
    ("-", (0, (7, 2)), (0, (3.5, 2)), (0, (1, 1.3)), (0, (7, 2, 1, 2)), (0, (3, 1, 1, 1, 1, 1)), (0, (10, 2)), (0, (2, 2))),
    "osD^vPX*")]
NO_QUANTITY = {"answer", "warnings", "family", "failed_points", "sweep_points", "sensitivity", "validity", "failed_trials"}
FORMULATIONS = {"monte_carlo": "Monte Carlo", "iscwsa": "ISCWSA"}
NO_NAMES = ("quantity", "unit", "verdict", "expected", "family", "note", "title", "rule", "end", "found", "wishart_family",
            "claim", "predicted_verdict", "predicted_class", "class")  # words that say what was found, no names of rows
INDEX = ("md_m", "station", "ref_md_m", "component", "point", "leg")  # columns that say which row of a point


@dataclasses.dataclass
class Quantity:
    """What a figure shows: `rows` has a column for each key, `line`, `value`, `low`, `high` (NaN without an interval)."""

    name: str  # of the file
    label: str  # of the axis
    rows: pandas.DataFrame
    meaning: str = ""  # a phrase
    note: str = ""  # which rows
    row_name: str = ""  # what the words of column `row` are
    margin: float = 0.0  # within which a ratio agrees with 1
    is_ratio: bool = False


# ---- reading

def _numbers(column):
    return column.dtype.kind in "fiu"


def _identity(frame, keys, columns):
    """Those of some columns that tell the rows of a point apart: the first ones that do."""
    found = []
    for column in columns:
        if not frame.duplicated([*keys, *found]).any():
            break
        if frame.groupby([*keys, *found], sort=False, dropna=False)[column].nunique().max() > 1:
            found.append(column)
    return found


def _table_quantity(result, name):
    """A quantity of a table by its name (the help of --quantity), a Quantity for each unit of its rows; and the keys of the sweep."""
    is_largest = name.startswith("max:")
    table, _, rest = name.removeprefix("max:").partition(".")
    what, _, column = rest.partition(".")
    if table not in result.tables or not what:
        raise PlotError(f"--quantity {name}: no table or map of this result; there are {', '.join([*result.tables, *result.maps])}", USAGE)
    frame = result.table(table)
    keys, units, intervals = frame.attrs["sweep_keys"], frame.attrs["units"], frame.attrs["intervals"]
    meanings = frame.attrs["descriptions"]
    notes, words = [], ""
    if "quantity" in frame and (frame["quantity"] == what).any():
        frame = frame[frame["quantity"] == what]
        column = column or "monte_carlo"
        words = wording.axis_name(what).split(" (")[0]
    else:
        column = what
    if not any(frame[k].nunique() > 1 for k in keys):  # no sweep: along the well
        keys = [c for c in INDEX if c in frame and _numbers(frame[c]) and c != column][:1]
    if column not in frame or not _numbers(frame[column]):
        choice = sorted({*frame.get("quantity", []), *(c for c in frame if _numbers(frame[c]) and c not in keys)})
        near = nearest(column, choice)
        raise PlotError(f"--quantity {name}: table '{table}' has no such number" +
                        (f"; did you mean {near}?" if near else f"; there are {', '.join(choice)}"), USAGE)
    texts = [c for c in frame if c not in keys and not _numbers(frame[c]) and c not in NO_NAMES]
    has_formulation = "formulation" in texts and frame["formulation"].nunique() > 1
    others = [c for c in texts if c != "formulation"]
    for index in (c for c in INDEX if c in frame and c not in keys and c != column):
        known = [*keys, *_identity(frame, keys, texts)]
        if frame.duplicated(known).any():
            best = frame[column] if is_largest else frame[index]
            frame = frame[best == (best.groupby([frame[k] for k in known], sort=False, dropna=False).transform("max") if known else best.max())]
            notes.append("largest of all rows" if is_largest else f"at the last {wording.axis_name(index).split(' (')[0].replace('measured depth', 'depth')}")
    other = _identity(frame, [*keys, *(["formulation"] if has_formulation else [])], others)
    row = frame[other].astype(str).agg(", ".join, axis=1).map(wording.quantity_name) if other else pandas.Series("", frame.index)
    line = frame["formulation"].map(lambda w: FORMULATIONS.get(w) or wording.quantity_name(w)) if has_formulation else pandas.Series("", frame.index)
    is_ratio = "ratio" in column.split("_")
    low, high = intervals.get(column, (None, None))

    def part(column, line, low=None, high=None):
        ends = {n: frame[c].astype(float) if c else np.nan for n, c in (("low", low), ("high", high))}
        return frame[keys].assign(**{ROW: row, LINE: line, "value": frame[column].astype(float), **ends})

    rows = part(column, line, low, high)
    if column == "monte_carlo" and "analytic" in frame:
        found = part(column, FORMULATIONS["monte_carlo"], low, high)
        if found.groupby([*keys, ROW, LINE], sort=False, dropna=False)["value"].nunique().max() <= 1:  # the same for all predictions
            rows = pandas.concat([found, part("analytic", line.where(line != "", "predicted"))])
            rows = rows[(rows[LINE] == FORMULATIONS["monte_carlo"]) | rows["value"].notna()]
    if rows.duplicated([*keys, ROW, LINE]).any():
        if column != "monte_carlo":
            notes.append("the first of several rows")
        rows = rows.drop_duplicates([*keys, ROW, LINE])
    meaning = "" if column in ("monte_carlo", "ratio") or meanings.get(column) == "sweep key" else meanings.get(column, "")
    margin = float(frame["margin"].max()) if column.startswith("ratio") and "margin" in frame else 0.0
    rows["unit"] = frame["unit"].reindex(rows.index) if words and "unit" in frame and not is_ratio else ""
    found = []
    for unit, of_unit in rows.groupby("unit", sort=False):
        if words:
            label = words if column in ("monte_carlo", "continuous") else f"predicted over Monte Carlo, {words}" if column == "ratio" and "analytic" in frame else \
                f"{words}, {wording.axis_name(column)}"
        else:
            label, unit = wording.axis_name(column), units.get(column, "")
        label += f" ({wording.POINT_UNITS.get(unit, unit)})" if unit not in ("", "1") and "(" not in label else ""
        tail = (f"_{column}" if words and column != "monte_carlo" else "") + (f"_{unit}" if rows["unit"].nunique() > 1 else "")
        found.append(Quantity(f"{table}_{what}{tail}", label, of_unit.drop(columns="unit").reset_index(drop=True), _phrase(meaning, label),
                              ", ".join(notes), ", ".join(wording.axis_name(c) for c in other), margin if np.isfinite(margin) else 0.0, is_ratio))
    return keys, found


def _phrase(meaning, label):
    """What the file says of a column; "" where that says no more than its name."""
    text = wording.plain_text(meaning.replace(", in the row's unit", ""))
    return text if set(text.lower().split()) - set(label.lower().replace(",", "").split()) - {"of", "the", "a", "in"} else ""


def _map_quantity(result, name):
    """A map of a result, its axes beside the keys of the sweep: those of the panels are its own."""
    data = result.map(name)
    own = [d for d in data.dims if d in ("inclination", "inclination_deg", "azimuth", "azimuth_deg", "magnetic_azimuth", "toolface", "dip")]
    rows = data.to_dataframe(name="value").reset_index()
    dims = list(data.dims)
    if "point" in dims and "sweep_points" in result.tables:
        points = result.table("sweep_points")
        named = [k for k in points if k != "point"]
        rows = rows.merge(points, on="point").drop(columns="point")
        dims = named + [d for d in dims if d != "point"]
    rows = rows.assign(**{ROW: "", LINE: "", "low": np.nan, "high": np.nan})
    unit = data.attrs.get("units", "")
    label = wording.axis_name(name)
    label += f" ({wording.POINT_UNITS.get(unit, unit)})" if unit not in ("", "1") and "(" not in label else ""
    return dims, own, [Quantity(name, label, rows, _phrase(data.attrs.get("long_name", ""), label), is_ratio="ratio" in name)]


def default_quantities(result, study):
    """What is drawn where nobody chooses: what studies.toml names and the result has; else the first of what may be drawn."""
    def has(name):
        table, *rest = name.removeprefix("max:").split(".")
        if not rest:
            return table in result.maps
        if table not in result.tables:
            return False
        frame = result.table(table)
        return bool(frame.attrs["sweep_keys"] or not study.plots) and (rest[0] in frame or rest[0] in set(frame.get("quantity", [])))

    named = [q for q in study.sweep if has(q)]
    if named:
        return named[:MOST_FIGURES]
    found = list(result.maps)[:2]
    for table in result.tables:
        frame = result.table(table) if table not in NO_QUANTITY else None
        if frame is None or not frame.attrs["sweep_keys"] or frame.empty:
            continue
        if "quantity" in frame and "monte_carlo" in frame:
            found += [f"{table}.{q}" for q in dict.fromkeys(frame["quantity"])][:2]
        else:
            numbers = [c for c in frame if _numbers(frame[c]) and c not in frame.attrs["sweep_keys"] and c not in INDEX
                       and not c.endswith(("_ci_low", "_ci_high")) and frame[c].nunique() > 1]
            found += [f"{table}.{c}" for c in numbers[:2]]
    return found[:MOST_FIGURES]


# ---- choosing

def _sorted(values):
    """Values of a key: numbers in their order, words as they come."""
    found = list(dict.fromkeys(values))
    return sorted(found) if found and not isinstance(found[0], str) else found


def _words(keys, point):
    """A point in words, its line and row first."""
    own = [str(v) for k, v in zip(keys, point) if k in (LINE, ROW)]
    pairs = [(k, v) for k, v in zip(keys, point) if k not in (LINE, ROW)]
    return ", ".join(filter(None, [*own, wording.point_name([k for k, _ in pairs], [v for _, v in pairs])]))


def facets(rows, keys, most, said):
    """([(words, rows)], columns) for each of at most `most` combinations of values of these keys; what is left out, to `said`. columns:
    of panels, so that a line has all values of the last key; None if there are too many or too few."""
    values = [_sorted(rows[k]) for k in keys]
    counts = reading.shared_out([len(v) for v in values], most)
    chosen = [reading.spread(v, n) if k != LINE else v[:n] for k, v, n in zip(keys, values, counts)]
    for key, every, some in zip(keys, values, chosen):
        if len(some) < len(every):
            of = f"values of {wording.axis_name(key).split(' (')[0]}" if key not in (LINE, ROW) else "kinds"
            said.append(f"{len(some)} of {len(every)} {of}")
    found = []
    for point in itertools.product(*chosen):
        here = np.ones(len(rows), bool)
        for key, value in zip(keys, point):
            here &= (rows[key] == value).to_numpy()
        if here.any():
            found.append((_words(keys, point), rows[here]))
    several = [len(c) for c in chosen if len(c) > 1]
    return found, several[-1] if len(several) > 1 and several[-1] <= 4 else None


def is_grid(rows, keys):
    """Whether each value of each key goes with all values of the others."""
    points = rows[keys].drop_duplicates()
    if any(rows[k].nunique() < 2 for k in keys):
        return True
    return len(points) == np.prod([rows[k].nunique() for k in keys])


# ---- drawing

def _is_log(values):
    """Whether an axis of these values is better logarithmic: they are spread over more than a decade and a half. A few that are 0
    (a probability without a hit) have then no place on it."""
    finite = np.asarray(values, float)[np.isfinite(values)]
    above = finite[finite > 0]
    return len(above) > 2 and not (finite < 0).any() and above.max() / above.min() > (30 if len(above) == len(finite) else 1000)


def _is_log_key(values):
    """Whether values of a key go by factors: their median is nearer to the middle of a logarithmic axis."""
    values = np.unique(np.asarray(values, float))
    if len(values) < 3 or values[0] <= 0 or values[-1] / values[0] < 8:
        return False
    middle, ends = np.median(values), (values[0], values[-1])
    linear, log = ((f(middle) - f(ends[0])) / (f(ends[1]) - f(ends[0])) - 0.5 for f in (float, np.log))
    return abs(log) < abs(linear) - 0.1


def _scale(ax, which, values, is_log):
    axis = getattr(ax, f"{which}axis")
    if is_log:
        getattr(ax, f"set_{which}scale")("log")
        drawing.plain_log_axis(axis, *getattr(ax, f"get_{which}lim")())
        wide = {"y": lambda t: 0.1, "x": lambda t: 0.04 * (len(drawing.plain_size(t).replace("\\times", "").strip("$")) + 1)}[which]
        axis.set_major_locator(matplotlib.ticker.FixedLocator(drawing.apart(axis.get_major_locator()(), *getattr(ax, f"get_{which}lim")(), wide)))
    elif np.ptp(values) in (90, 180, 360):
        axis.set_major_locator(matplotlib.ticker.MultipleLocator(np.ptp(values) / 6))
    else:
        axis.set_major_locator(matplotlib.ticker.MaxNLocator(5, steps=(1, 2, 5, 10)))


def _is_constant(values):
    """Whether values differ by no more than a thousandth: colours and digits would show rounding."""
    finite = np.asarray(values, float)[np.isfinite(values)]
    return not len(finite) or np.ptp(finite) <= 1e-3 * np.abs(finite).max()


def _limits(quantity, rows):
    """Limits of an ordinate for all panels, and whether it is logarithmic: a few values far off leave the panel, and are counted."""
    values = rows["value"].to_numpy(float)
    ends = np.concatenate([values, rows["low"], rows["high"], [1.0 + quantity.margin, 1.0 - quantity.margin] if quantity.margin else []])
    values, ends = values[np.isfinite(values)], ends[np.isfinite(ends)]
    if not len(values):
        return (0, 1), False, 0
    log = _is_log(values)
    if log:
        high = values.max()
        low = values[values > 1e-9 * high].min()  # what is less is rounding
        return (low / (high / low) ** 0.06, high * (high / low) ** 0.06), True, int((values < low).sum())
    if _is_constant(ends):
        return (0.95 * ends.min(), 1.05 * ends.max()) if ends.min() > 0 else (ends.min() - 0.05 * np.abs(ends).max() - 1e-12, ends.max() + 0.05 * np.abs(ends).max() + 1e-12), False, 0
    middle, reach = np.median(values), np.quantile(values, 0.98) - np.quantile(values, 0.02)
    low, high = ends.min(), ends.max()
    if reach > 0:  # intervals may be cut, values only where they are far off
        low = max(low, min(values.min(), middle) - 0.6 * reach if values.min() > middle - 6 * reach else middle - 2 * reach)
        high = min(high, max(values.max(), middle) + 0.6 * reach if values.max() < middle + 6 * reach else middle + 2 * reach)
    outside = int(((values < low) | (values > high)).sum())
    room = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return (low - room if low < 0 or low - room > 0 else min(0.0, low), high + room), False, outside


def curves(heading, quantity, rows, key, words, said):
    """Against one numeric key; lines and panels for words."""
    lines = _sorted(rows[LINE])
    other = [k for k in words if rows[k].nunique() > 1]
    if len(lines) == 1 and other and np.prod([rows[k].nunique() for k in other]) <= MOST_LINES:  # words may be the lines
        rows = rows.assign(**{LINE: [_words(other, v) for v in rows[other].itertuples(index=False)]})
        other, lines = [], _sorted(rows[LINE])
    if len(lines) > MOST_LINES:
        largest = rows.groupby(LINE)["value"].max().sort_values(ascending=False).index[:MOST_LINES]
        said.append(f"the {MOST_LINES} largest of {len(lines)} lines")
        lines = [w for w in lines if w in set(largest)]
    shown, columns = facets(rows, other, MOST_PANELS, said)
    size = (7.2, 4.2) if len(shown) == 1 else (3.6, 2.8)
    figure, axes = drawing.panels(len(shown), size, columns, sharex=True, sharey=True)
    limits, log, outside = _limits(quantity, rows[rows[LINE].isin(lines)])
    if outside:
        said.append(f"{outside} values beyond the panel")
    count = rows[key].nunique()
    for ax, (title, here) in zip(axes, shown):
        if quantity.is_ratio:
            drawing.band(ax, quantity.margin)
        for n, (look, line) in enumerate(zip(LOOKS, lines)):
            own = here[here[LINE] == line].sort_values(key)
            x, y = own[key].to_numpy(float), own["value"].to_numpy(float)
            y = np.where(np.isfinite(y), y, np.nan)
            bars = _bars(own)
            style = {**look, "marker": look["marker"] if count <= 40 else "none"}
            if count > 40 and np.any(bars[0] + bars[1] > 0):
                ax.fill_between(x, own["low"], own["high"], color=look["color"], alpha=0.2, linewidth=0)
            elif np.any(bars[0] + bars[1] > 0):
                beside = (n - (len(lines) - 1) / 2) * 0.004 * np.ptp(x)  # intervals of several lines are seen beside each other
                ax.errorbar(x if _is_log_key(x) else x + beside, y, bars, fmt="none", ecolor=look["color"], elinewidth=0.9, capsize=2, alpha=0.7)
            ax.plot(x, y, markersize=4, linewidth=1.2, **style)
        ax.set_title(title, fontsize=8)
        ax.set_ylim(limits)
        _scale(ax, "x", rows[key], _is_log_key(rows[key]))
    _scale(axes[0], "y", limits, log)
    _outer_labels(axes, wording.axis_name(key), quantity.label, size[1])
    heading(figure)
    if len(lines) > 1:
        handles = [Line2D([], [], label=w, markersize=4, **{**look, "marker": look["marker"] if count <= 40 else "none"})
                   for look, w in zip(LOOKS, lines)]
        drawing.legend_below(figure, handles, fontsize=8)
    return figure


def _outer_labels(axes, x, y, size):
    """The same names of axes for all panels, at the left and lowest ones. size: height of a panel (in)."""
    places = [ax.get_subplotspec() for ax in axes]
    lowest = {p.colspan.start: p.rowspan.start for p in places}  # the last of each column
    for ax, place in zip(axes, places):
        if place.rowspan.start == lowest[place.colspan.start]:
            ax.set_xlabel(x)
            ax.tick_params(labelbottom=True)  # above a spare place, too
        if place.colspan.start == 0:
            ax.set_ylabel(textwrap.fill(y, int(11 * size) - 3))


def _bars(rows):
    """Lengths of the intervals (below, above) of rows; 0 where there is none."""
    with np.errstate(invalid="ignore"):  # infinity less infinity
        ends = rows["value"] - rows["low"], rows["high"] - rows["value"]
    return [np.clip(np.nan_to_num(e.to_numpy(float), nan=0.0, posinf=0.0, neginf=0.0), 0, None) for e in ends]


def edges(centres, is_log):
    """Edges of cells about these centres."""
    c = np.log(centres) if is_log and len(centres) > 1 else np.asarray(centres, float)
    if len(c) == 1:  # a panel may lack points of the grid
        return np.array([c[0] - 0.02 * abs(c[0]) - 1e-9, c[0] + 0.02 * abs(c[0]) + 1e-9])
    middle = (c[1:] + c[:-1]) / 2
    both = np.concatenate([[2 * c[0] - middle[0]], middle, [2 * c[-1] - middle[-1]]])
    return np.exp(both) if is_log else both


def colours_of(quantity, values, said):
    """(norm, colour map, levels of contours, which ends are cut) of the values of a map."""
    finite = values[np.isfinite(values)]
    if quantity.is_ratio and len(finite) and finite.min() > 0:  # as much above 1 as below
        far = np.exp(np.clip(np.quantile(np.abs(np.log(finite)), 0.98), np.log(1.02), np.log(1e3)))
        far = max(far, 1 + 1.5 * quantity.margin)
        levels = sorted({1.0, *((1 - quantity.margin, 1 + quantity.margin) if quantity.margin else ())})
        if far > 2:
            levels += [v for v in (0.01, 0.1, 0.2, 0.5, 2, 5, 10, 100) if 1 / far < v < far]
        norm = matplotlib.colors.LogNorm(1 / far, far)
        colour = "RdBu_r"
    else:
        low, high = (np.quantile(finite, [0.01, 0.99]) if len(finite) else (0.0, 1.0))
        if len(finite) and finite.max() - finite.min() < 3 * (high - low):  # nothing is far off
            low, high = finite.min(), finite.max()
        if _is_constant(finite):
            middle = (low + high) / 2
            said.append(f"the same everywhere within {wording.number(100 * (high - low) / abs(middle), 1)} %" if high > low else "the same everywhere")
            low, high = middle - 0.05 * abs(middle) - 1e-12, middle + 0.05 * abs(middle) + 1e-12
        colour = "cividis"
        if low > 0 and high / low > 1e4:
            low = high / 1e4
        if low > 0 and high / low > 20:
            norm = matplotlib.colors.LogNorm(low, high)
            steps = (1, 2, 5) if high / low < 1e3 else (1,)
            levels = [s * 10.0**e for e in range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1) for s in steps]
        else:
            norm = matplotlib.colors.Normalize(low, high)
            levels = matplotlib.ticker.MaxNLocator(7).tick_values(low, high) if high - low > 0.11 * abs(high) or high * low <= 0 or not said else []
    levels = sorted(v for v in levels if norm.vmin < v < norm.vmax)
    cut = (finite.min() < norm.vmin * (1 - 1e-9), finite.max() > norm.vmax * (1 + 1e-9)) if len(finite) else (False, False)
    return norm, colour, levels, {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[tuple(map(int, cut))]


def _contours(ax, draw, levels, finite):
    inside = [v for v in levels if finite.size and finite.min() < v < finite.max()]
    if inside:
        drawing.label_contours(ax, draw(inside), lambda v: f"{v:.4g}")


def map_panel(ax, x, y, rows, on_grid, norm, colour, levels):
    """One panel of a map: a cell a point of a grid; contours between points that form none."""
    ax.grid(False)
    ax.set_facecolor("#D8D8D8")
    logs = {k: _is_log_key(rows[k]) for k in (x, y)}
    values = rows["value"].to_numpy(float)
    shown = np.where(np.isposinf(values), np.nan, values)
    if on_grid and not rows.duplicated([x, y]).any():
        grid = rows.assign(value=shown).pivot(index=y, columns=x, values="value")
        filled = ax.pcolormesh(edges(grid.columns.to_numpy(float), logs[x]), edges(grid.index.to_numpy(float), logs[y]), grid.to_numpy(),
                               norm=norm, cmap=colour, rasterized=grid.size > 2000)
        if min(grid.shape) >= 4:
            _contours(ax, lambda at: ax.contour(grid.columns, grid.index, grid.to_numpy(), levels=at, colors="white", linewidths=0.7),
                      levels, shown[np.isfinite(shown)])
        if np.isposinf(values).any():
            for px, py in rows.loc[np.isposinf(values), [x, y]].itertuples(index=False):
                ax.plot(px, py, marker="x", color="#B00020", markersize=4, linestyle="none")
    else:
        px, py = rows[x].to_numpy(float), rows[y].to_numpy(float)
        good = np.isfinite(shown)
        if good.sum() >= SCATTERED_MAP:
            tx, ty = (np.log(v) if logs[k] else v for k, v in ((x, px), (y, py)))
            scaled = [(v[good] - v.min()) / (np.ptp(v) or 1) for v in (tx, ty)]
            mesh = matplotlib.tri.Triangulation(px[good], py[good], matplotlib.tri.Triangulation(*scaled).triangles)
            ax.tripcolor(mesh, shown[good], norm=norm, cmap=colour, shading="gouraud", rasterized=True)
            _contours(ax, lambda at: ax.tricontour(mesh, shown[good], levels=at, colors="white", linewidths=0.7), levels, shown[good])
        filled = ax.scatter(px[good], py[good], c=shown[good], norm=norm, cmap=colour, s=14 if good.sum() > 100 else 36, edgecolors="#333333",
                            linewidths=0.4, zorder=3)
        ax.plot(px[~good], py[~good], "x", color="#B00020", markersize=4, linestyle="none", zorder=3)
        ax.margins(0.03)
    for which, key in (("x", x), ("y", y)):
        _scale(ax, which, rows[key], logs[key])
    return filled


def maps(heading, quantity, rows, x, y, others, on_grid, said):
    """Against two numeric keys; panels for the values of the others, and for lines."""
    for line in _sorted(rows[LINE])[1:]:  # a theory that is one number needs no map
        values = rows["value"][rows[LINE] == line]
        if _is_constant(values):
            said.append(f"{line}: {wording.number(values.median())}")
            rows = rows[rows[LINE] != line]
    shown, columns = facets(rows, [LINE, *others], MOST_PANELS, said)
    shown = [(t, r) for t, r in shown if r["value"].notna().any()]
    if np.isposinf(rows["value"]).any():
        said.append("red crosses: infinite")
    if rows["value"].isna().any():
        said.append("grey: no value")
    size = (6.6, 4.8) if len(shown) == 1 else (3.5, 2.9)
    figure, axes = drawing.panels(len(shown), size, columns, sharex=True, sharey=True)
    norm, colour, levels, extend = colours_of(quantity, np.concatenate([r["value"].to_numpy(float) for _, r in shown]), said)
    for ax, (title, here) in zip(axes, shown):
        filled = map_panel(ax, x, y, here, on_grid, norm, colour, levels)
        ax.set_title(title, fontsize=8)
    bar = figure.colorbar(filled, ax=axes, extend=extend, shrink=0.95, pad=0.02)
    bar.set_label(textwrap.fill(quantity.label, int(11 * figure.get_figheight()) - 12), fontsize=9)
    if isinstance(norm, matplotlib.colors.LogNorm):
        drawing.plain_log_axis(bar.ax.yaxis, norm.vmin, norm.vmax)
    _outer_labels(axes, wording.axis_name(x), wording.axis_name(y), size[1])
    heading(figure)
    return figure


def against_each(heading, quantity, rows, keys, said):
    """Points of a design with many keys: the quantity against each of them, the strongest first; medians and the middle 80 %."""
    lines, kinds = _sorted(rows[LINE]), _sorted(rows[ROW])
    if len(lines) > 1:
        said.append(f"{lines[0]} only")
        rows = rows[rows[LINE] == lines[0]]
    rows = rows[np.isfinite(rows["value"])]
    if len(kinds) > MOST_LINES:
        said.append(f"{MOST_LINES} of {len(kinds)} kinds")
        kinds = kinds[:MOST_LINES]
        rows = rows[rows[ROW].isin(kinds)]

    def strength(key):
        """The part of the variance of the ranks that groups of a key explain."""
        ranks, groups = rows["value"].rank(), _groups(rows[key])
        return ranks.groupby(groups).transform("mean").var() / max(ranks.var(), 1e-300) - groups.nunique() / len(rows)

    keys = sorted((k for k in keys if k != ROW), key=lambda k: -round(strength(k), 6))
    if len(keys) > MOST_KEYS:
        said.append(f"the {MOST_KEYS} strongest of {len(keys)} keys")
    keys = keys[:MOST_KEYS]
    limits, log, outside = _limits(quantity, rows)
    if outside:
        said.append(f"{outside} values beyond the panels")
    if len(rows) > MOST_DOTS:
        said.append(f"a dot for {-(-len(rows) // MOST_DOTS)} points")
    said.append("lines: medians" if len(kinds) > 1 else "line and band: median and the middle 80 %")
    figure, axes = drawing.panels(len(keys), size=(3.4, 2.7), sharey=True)
    dotted = rows.iloc[::max(-(-len(rows) // MOST_DOTS), 1)]
    size = drawing.dot_size(len(dotted), 5)
    for ax, key in zip(axes, keys):
        if quantity.is_ratio:
            drawing.band(ax, quantity.margin)
        names = [] if _numbers(rows[key]) else list(rows.groupby(key)["value"].median().sort_values(kind="stable").index)
        for look, kind in zip(LOOKS, kinds):
            own = rows[rows[ROW] == kind]
            dots = {"linestyle": "none", "marker": look["marker"], "markersize": size, "color": look["color"], "alpha": 0.4, "markeredgewidth": 0,
                    "rasterized": len(dotted) > 500}
            if _numbers(own[key]):
                few = dotted[dotted[ROW] == kind]
                ax.plot(few[key], few["value"], **dots)
                groups = own.groupby(_groups(own[key]), sort=True)
                if groups.size().min() >= 5 and len(groups) > 2:
                    at, (low, mid, high) = groups[key].mean(), (groups["value"].quantile(q) for q in (0.1, 0.5, 0.9))
                    if len(kinds) == 1:
                        ax.fill_between(at, low, high, color="#E69F00", alpha=0.25, linewidth=0)
                    ax.plot(at, mid, color="#D55E00" if len(kinds) == 1 else look["color"], linestyle=look["linestyle"])
                continue
            for i, word in enumerate(names):
                y, few = own["value"][own[key] == word], dotted["value"][(dotted[ROW] == kind) & (dotted[key] == word)]
                ax.plot(i + np.linspace(-0.25, 0.25, len(few)), few, **dots)
                ax.plot([i - 0.35, i + 0.35], [y.median()] * 2, color=look["color"] if len(kinds) > 1 else "#D55E00")
        if _numbers(rows[key]):
            _scale(ax, "x", rows[key], _is_log_key(rows[key]))
        else:
            ax.set_xticks(range(len(names)), [wording.cut(wording.value_name(w), 14) for w in names], rotation=30, ha="right", fontsize=7)
        ax.set_xlabel(wording.axis_name(key), fontsize=9)
        ax.set_ylim(limits)
        if ax.get_subplotspec().colspan.start == 0:
            ax.set_ylabel(textwrap.fill(quantity.label, 27), fontsize=9)
    _scale(axes[0], "y", limits, log)
    heading(figure)
    if len(kinds) > 1:
        drawing.legend_below(figure, [Line2D([], [], label=w, markersize=4, **look) for look, w in zip(LOOKS, kinds)], fontsize=8)
    return figure


def _groups(values):
    """Which group a point is in: words by word, numbers in equal groups of about twenty points."""
    if not _numbers(values):
        return values
    if values.nunique() <= 12:
        return values
    return pandas.qcut(values, int(np.clip(len(values) // 20, 2, 12)), labels=False, duplicates="drop")


def dots(heading, quantity, rows, keys, said):
    """Of points that only words tell apart: a line each, with its interval."""
    rows = rows.assign(name=[_words(keys, v) for v in rows[keys].itertuples(index=False)])
    lines, names = _sorted(rows[LINE])[:MOST_LINES], _sorted(rows["name"])
    if len(names) > MOST_ROWS:
        order = rows[rows[LINE] == lines[0]].sort_values("value")["name"].tolist()
        names = order[:MOST_ROWS // 2] + order[-MOST_ROWS // 2:]
        said.append(f"the {MOST_ROWS // 2} least and the {MOST_ROWS // 2} largest of {rows['name'].nunique()} points")
    figure, (ax,) = drawing.panels(1, size=(8.4, 1.2 + 0.26 * len(names)))
    if quantity.is_ratio:
        ax.axvline(1, color="#444444", linewidth=1.0, zorder=1)
        ax.axvspan(1 - quantity.margin, 1 + quantity.margin, color="#009E73", alpha=0.18, linewidth=0, zorder=0)
    for n, (look, line) in enumerate(zip(LOOKS, lines)):
        own = rows[(rows[LINE] == line) & rows["name"].isin(names)]
        at = np.array([names.index(r) for r in own["name"]]) + (n - (len(lines) - 1) / 2) * 0.7 / max(len(lines), 3)
        ax.errorbar(own["value"].to_numpy(float), at, xerr=_bars(own), color=look["color"], marker=look["marker"], linestyle="none", markersize=5, capsize=2, elinewidth=1.0)
    ax.set_yticks(range(len(names)), [wording.cut(n, 46) for n in names], fontsize=8)
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.set_xlabel(quantity.label)
    finite = rows["value"].to_numpy(float)
    _scale(ax, "x", finite[np.isfinite(finite)] if np.isfinite(finite).any() else np.zeros(1), _is_log(finite))
    heading(figure)
    if len(lines) > 1:
        drawing.legend_below(figure, [Line2D([], [], label=w, **{**look, "linestyle": "none"}) for look, w in zip(LOOKS, lines)], fontsize=8)
    return figure


def draw(title, answer, quantity, keys, own=()):
    """The figure of a quantity; None where nothing varies. answer: a sentence below the title; own: keys that are axes before all others."""
    rows, said = quantity.rows, []
    there = rows.groupby(LINE)["value"].transform(lambda v: np.isfinite(v).any())
    rows = rows[there.astype(bool)]
    varying = [k for k in keys if rows[k].nunique() > 1]
    numeric = [k for k in varying if _numbers(rows[k])]
    words = [k for k in varying if k not in numeric] + ([ROW] if rows[ROW].nunique() > 1 else [])
    points = len(rows[varying].drop_duplicates()) if varying else 1
    if not varying or not np.isfinite(rows["value"]).any():
        return None
    long = [k for k in numeric if rows[k].nunique() >= FEW]
    own = [k for k in own if k in long]
    grid = is_grid(rows, numeric) if numeric else True

    def heading(figure):
        what = quantity.label.split(" (")[0]
        what = (what if what.startswith("sd ") else what[0].upper() + what[1:]) + (f": {quantity.meaning}" if quantity.meaning else "")
        count = ", ".join(filter(None, [f"{wording.grouped(points)} points", quantity.note]))
        drawing.heading(figure, title, "\n".join(filter(None, [answer, f"{what}. {'; '.join([count[0].upper() + count[1:], *said])}."])))

    if not numeric:
        figure = dots(heading, quantity, rows, words, said)
    elif len(numeric) == 1 or len(long) < 2 and grid:
        x = (long or numeric)[-1]
        rows = rows.sort_values([k for k in numeric if k != x]) if len(numeric) > 1 else rows
        figure = curves(heading, quantity, rows, x, [*(k for k in numeric if k != x), *words], said)
    elif grid or len(numeric) == 2:
        by_size = sorted(long or numeric, key=lambda k: -rows[k].nunique()) if grid else numeric
        plane = [*own[-2:], *(k for k in by_size if k not in own[-2:])][:2]
        y, x = sorted(plane, key=keys.index)
        figure = maps(heading, quantity, rows, x, y, [*(k for k in numeric if k not in plane), *words], grid, said)
    else:
        figure = against_each(heading, quantity, rows, [*numeric, *words], said)
    return figure


# ---- the drawer

def _chosen(rows, at):
    """The rows with the values of --at; the nearest of a number."""
    for text in at:
        key, _, value = text.partition("=")
        if key not in rows:
            raise PlotError(f"--at {text}: no key of the sweep; there are {', '.join(k for k in rows if k not in (ROW, LINE, 'value', 'low', 'high'))}", USAGE)
        if _numbers(rows[key]):
            try:
                wanted = float(value)
            except ValueError:
                raise PlotError(f"--at {text}: {key} is a number", USAGE) from None
            rows = rows[rows[key] == rows[key].iloc[(rows[key] - wanted).abs().argmin()]]
        elif (rows[key] == value).any():
            rows = rows[rows[key] == value]
        else:
            raise PlotError(f"--at {text}: there are {', '.join(map(str, _sorted(rows[key])[:12]))}", USAGE)
    return rows


def add_choices(parser):
    """Options that choose what is drawn of a sweep."""
    parser.add_argument("--quantity", action="append", metavar="TABLE.NAME", help="what to draw: TABLE.COLUMN, TABLE.QUANTITY or TABLE.QUANTITY.COLUMN of a comparison, or "
                        "a map; 'max:' before it: of several rows at a point, such as stations, the largest in place of the last")
    parser.add_argument("--at", action="append", default=[], metavar="KEY=VALUE", help="only points with this value of a key")


def main():
    parser = saving.argument_parser(__doc__.splitlines()[0])
    add_choices(parser)
    parser.add_argument("--point", type=int, help=argparse.SUPPRESS)  # all points are drawn
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_any(arguments.result) as file:
        title = wording.title_of(file)
    try:
        result = Result(arguments.result)
        study = studies.study_of(studies.load(), result.experiment)
        if one_point.of_sweep(arguments.result)[0] < 2 and not arguments.quantity and (study.plots or not study.sweep):
            raise PlotError(f"{arguments.result}: has no sweep")
        names, figures, constant = arguments.quantity or default_quantities(result, study), {}, []
        for name in names:
            if name in result.maps:
                keys, own, found = _map_quantity(result, name)
            else:
                (keys, found), own = _table_quantity(result, name), []
            for quantity in found:
                quantity.rows = _chosen(quantity.rows, arguments.at)
                if not arguments.quantity and len(found) + len(names) > 1 and _is_constant(quantity.rows["value"]):
                    middle = quantity.rows["value"].median()
                    constant += [f"{quantity.label} is {wording.number(middle)} at all points: no figure"] if np.isfinite(middle) else []
                    continue
                figure = draw(title, wording.answer_of(result), quantity, keys, own)
                if figure is not None:
                    figures["sweep_" + wording.name_of([quantity.name])] = figure
    except ResultError as error:
        raise PlotError(str(error)) from None
    for said in constant:
        print(f"{arguments.result}: {said}", file=sys.stderr)
    if not figures:
        raise PlotError(f"{arguments.result}: no quantity of the sweep has more than one value")
    saving.save_all(figures, arguments)
