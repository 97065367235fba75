"""Data of the drawings that the reader can change: error ellipses, and maps. Small, for they stand in the page."""

import base64
import math

import numpy as np

from ..streams import visible

CLOUD_POINTS = 8000  # realisations of a result in the page, all sweep points together
CLOUD_MOST = 400  # of one sweep point
MAP_POINTS = 30000  # values of one map in the page: a larger one is thinned
MAP_VALUES = 250000  # of all maps of a result
ELLIPSE_ROWS = 3000


def _label(value):
    return visible(value) if isinstance(value, str) else f"{value:g}"


def _significant(value, digits=5):
    return None if not math.isfinite(value) else float(f"{value:.{digits}g}")


# --- ellipses -------------------------------------------------------------------------------------------------------


def has_ellipses(frame):
    return {"semi_major_m", "semi_minor_m", "major_azimuth_deg"} <= set(frame.columns) and 0 < len(frame) <= ELLIPSE_ROWS


def ellipses(frame, samples=None):
    """Ellipses of a table for the page, as plain lists.

    keys: what chooses a sweep point, [{name, values}]; rows: [index of each key's value ..., index of the formulation,
    north, east (of the centre, m, from the Monte-Carlo one where there is one), semi axes (m), azimuth (deg), ratios along
    both axes or null, verdict]; clouds: realisations by the keys' indices, north and east in turn (m), about their mean.
    samples: the realisations, or None.
    """
    names = [k for k in (*frame.attrs["sweep_keys"], "md_m") if k in frame and frame[k].nunique() > 1]
    values = {k: list(frame[k].unique()) for k in names}
    formulations = list(frame["formulation"].unique()) if "formulation" in frame else ["predicted"]
    rows = []
    centres = {}
    for i in range(len(frame)):
        row = frame.iloc[i]
        place = [values[k].index(row[k]) for k in names]
        formulation = formulations.index(row["formulation"]) if "formulation" in frame else 0
        centre = np.array([row.get("center_north_m", 0.0), row.get("center_east_m", 0.0)], float)
        if row.get("formulation") == "monte_carlo":
            centres[tuple(place)] = centre
        north, east = centre - centres.get(tuple(place), centre)
        numbers = [north, east, row["semi_major_m"], row["semi_minor_m"], row["major_azimuth_deg"]]
        if not np.all(np.isfinite(numbers)) or row["semi_major_m"] == 0:  # none, or the tie-on
            continue
        ratios = [row.get("ratio_major", math.nan), row.get("ratio_minor", math.nan)]
        rows.append([*place, formulation, *(_significant(v) for v in (*numbers, *ratios)), row.get("verdict", "")])
    return {"keys": [{"name": k, "values": [_label(v) for v in values[k]]} for k in names],
            "formulations": formulations, "rows": rows, "clouds": _clouds(samples, names, values)}


def _clouds(samples, names, values):
    if samples is None or not {"north_m", "east_m"} <= set(samples.columns) or not set(names) <= set(samples.columns):
        return {}
    points = max(1, math.prod(len(v) for v in values.values()))
    most = min(CLOUD_MOST, CLOUD_POINTS // points)
    if most < 50:
        return {}
    clouds = {}
    by = names if len(names) > 1 else names[0] if names else None
    for point, cloud in samples.groupby(by, sort=False) if names else [((), samples)]:
        point = point if isinstance(point, tuple) else (point,)
        if not all(v in values[k] for k, v in zip(names, point)):
            continue
        place = ",".join(str(values[k].index(v)) for k, v in zip(names, point))
        about_mean = cloud[["north_m", "east_m"]].to_numpy() - cloud[["north_m", "east_m"]].to_numpy().mean(axis=0)
        clouds[place] = [_significant(v, 4) for v in about_mean[:most].ravel()]
    return clouds


# --- maps -----------------------------------------------------------------------------------------------------------


def maps(result):
    """All maps of a result for the page, thinned if they are large; None if no map has an axis with two numbers.

    axes: [{name, unit, text, values, number}] of all maps, thinned: every `step`-th value; maps: [{name, unit, text,
    axes (their numbers), scale, data}]: values divided by scale, as 16-bit floats (three digits; inf and NaN stay), base64.
    """
    arrays = [result.map(name) for name in result.maps]
    axes = {}
    for array in arrays:
        for name in array.dims:
            axes.setdefault(name, array.coords[name])
    if not any(_is_number(axes[d]) and array.sizes[d] > 1 for array in arrays for d in array.dims):
        return None
    room = min(MAP_POINTS, MAP_VALUES // len(arrays))
    keep = _thinned({k: (v.size, _is_number(v)) for k, v in axes.items()},
                    [a.dims for a in arrays], room)
    order = list(axes)
    return {
        "axes": [{"name": k, "unit": v.attrs.get("units", ""), "text": v.attrs.get("long_name", ""), "number": _is_number(v),
                  "step": keep[k], "values": [x if isinstance(x, str) else _significant(float(x), 8)
                                             for x in v.values[:: keep[k]]]} for k, v in axes.items()],
        "maps": [_packed(a.isel({d: slice(None, None, keep[d]) for d in a.dims}), order) for a in arrays]}


def _is_number(axis):
    return axis.dtype != object


def _thinned(axes, shapes, room):
    """The step of each axis with which no map has more than `room` points: the longest axis is thinned first, to a step
    that keeps its end if there is one. axes: {name: (length, whether it may be thinned)}; shapes: axes of each map."""
    step = dict.fromkeys(axes, 1)

    def points(names):
        return math.prod(-(-axes[n][0] // step[n]) for n in names)

    while True:
        names = max(shapes, key=points)
        longest = max((n for n in names if axes[n][1]), key=lambda n: -(-axes[n][0] // step[n]), default=None)
        if points(names) <= room or longest is None or axes[longest][0] <= 2 * step[longest]:
            return step
        last = axes[longest][0] - 1
        larger = range(step[longest] + 1, last + 1)
        step[longest] = next((k for k in larger if last % k == 0 and k <= 2 * step[longest] + 1), step[longest] + 1)


def _packed(array, order):
    values = np.asarray(array.values, float)
    sizes = np.abs(values[np.isfinite(values) & (values != 0)])
    scale = float(np.median(sizes)) if sizes.size else 1.0
    scaled = values / scale
    finite = np.isfinite(scaled)
    scaled[finite] = np.clip(scaled[finite], -65000, 65000)
    words = array.attrs.get("long_name", "")
    unit = "as the observation" if "as the observation" in words else array.attrs.get("units", "")  # it differs along an axis
    return {"name": array.name, "unit": unit, "text": words.replace("mps2", "m/s²"),
            "axes": [order.index(d) for d in array.dims], "scale": scale,
            "data": base64.b64encode(scaled.astype("<f2").tobytes()).decode("ascii")}
