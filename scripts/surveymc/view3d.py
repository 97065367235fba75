"""Wells with their error ellipsoids in space, and the travelling cylinder, as a page that turns and zooms.

    surveymc.view3d.write(result, "well_3d.html")

Of the results of position_covariance, clearance, collision and estimate, and of any other that has their tables. The page is one
file: three.js (Debian: libjs-three) is in it, and it needs no network.

Positions are north (true), east and down in metres, as in the result; ellipsoids are of one sigma, the page draws 1 to 3.
"""

import math
import os

import numpy as np

from . import whole_file
from .storage import ResultError

ELEMENTS = ("nn_m2", "ee_m2", "vv_m2", "ne_m2", "nv_m2", "ev_m2")
MOST_STATIONS, MOST_ELLIPSOIDS, MOST_SCENES = 400, 40, 12
MAKER = "surveymc-view3d"  # of the page, which only a page of it replaces
LIBRARY = ("three.min.js", "examples/js/controls/OrbitControls.js",
           *(f"examples/js/lines/{n}.js" for n in ("LineSegmentsGeometry", "LineGeometry", "LineMaterial", "LineSegments2", "Line2")))
PLACES = ("/usr/share/javascript/three", "/usr/share/nodejs/three")


class NoScene(ResultError):
    """The result has no wells to draw, or the library that draws them is not installed; the message says which."""


# --- what is drawn --------------------------------------------------------------------------------------------------


def semi_axes(covariance):
    """The semi-axes of the one-sigma ellipsoid of a covariance (north, east, down; m2): three vectors (m), the largest first.
    Eigenvalues that rounding made negative count as 0."""
    values, vectors = np.linalg.eigh(covariance)
    return [(np.sqrt(max(v, 0.0)) * vectors[:, k]).tolist() for k, v in reversed(list(enumerate(values)))]


def _matrix(row):
    nn, ee, vv, ne, nv, ev = (float(row[e]) for e in ELEMENTS)
    return np.array([[nn, ne, nv], [ne, ee, ev], [nv, ev, vv]])


def _round(values, digits):
    return [round(float(v), digits) for v in values]


def _evenly(count, most):
    """Indices of at most `most` of `count` rows, the first and the last among them."""
    return sorted({round(i) for i in np.linspace(0, count - 1, min(count, most))}) if count else []


def _well(name, rows, north="north_m", east="east_m", down="tvd_m"):
    fine = rows[np.isfinite(rows[[north, east, down]]).all(axis=1)]
    fine = fine.iloc[_evenly(len(fine), MOST_STATIONS)]
    return {"name": name, "md": _round(fine["md_m"], 3), "north": _round(fine[north], 4), "east": _round(fine[east], 4),
            "down": _round(fine[down], 4)}


def _ellipsoid(well, md, centre, covariance, label):
    """One for the page; None where there is no uncertainty, or none that is a number."""
    numbers = [*centre, *covariance.ravel()]
    if not np.isfinite(numbers).all() or not np.any(covariance):
        return None
    axes = [[float(f"{x:.5g}") for x in axis] for axis in semi_axes(covariance)]
    return {"well": well, "md": float(f"{md:.7g}"), "label": label, "centre": _round(centre, 4), "axes": axes}


def _along(rows, north="north_m", east="east_m", down="tvd_m", well=0):
    """Ellipsoids at stations along a well, evenly."""
    own = rows[np.isfinite(rows[list(ELEMENTS)]).all(axis=1) & (rows[list(ELEMENTS[:3])].sum(axis=1) > 0)]
    found = [_ellipsoid(well, r["md_m"], (r[north], r[east], r[down]), _matrix(r), f"{r['md_m']:.0f} m")
             for _, r in own.iloc[_evenly(len(own), MOST_ELLIPSOIDS)].iterrows()]
    return [e for e in found if e]


def _one_well(at):
    """position_covariance."""
    rows = at["ellipsoid"].merge(at["covariance"][["md_m", *ELEMENTS]], on="md_m")
    return [_well("well", rows)], _along(rows)


def _two_readings(at):
    """estimate: as read, and corrected with its uncertainty."""
    rows = at["stations"]
    return ([_well("corrected", rows, down="vertical_m"), _well("as read", rows, "raw_north_m", "raw_east_m", "raw_vertical_m")],
            _along(rows, down="vertical_m"))


def _many_wells(at):
    """clearance, and collision: all paths; ellipsoids of each pair where they come closest to the rule and at the depths of
    report_md_m; of collision, of the relative position, at the offset."""
    paths = at["paths"]
    names = list(dict.fromkeys(paths["well"]))
    wells = [_well(n, paths[paths["well"] == n]) for n in names]
    pairs, found = at.get("relative_covariance"), []
    if pairs is None or not len(pairs):
        return wells, found
    shares = "formulation" if "formulation" in pairs else "correlation"
    first = pairs.groupby("offset", sort=False)[shares].transform("first")
    wanted = ("reference", "offset") if "offset" in set(pairs["of"]) else ("relative",)
    for _, row in pairs[(pairs[shares] == first) & pairs["of"].isin(wanted)].iterrows():
        name = "reference" if row["of"] == "reference" else row["offset"]
        if name not in names:
            continue
        own, md = wells[names.index(name)], row["ref_md_m" if name == "reference" else "offset_md_m"]
        centre = [float(np.interp(md, own["md"], own[k])) for k in ("north", "east", "down")]
        what = ", relative to the reference" if row["of"] == "relative" else f" of {row['offset']}" if name == "reference" else ""
        label = f"{md:.0f} m ({row['where']}{what})"
        ellipsoid = _ellipsoid(names.index(name), md, centre, _matrix(row), label)
        found += [ellipsoid] if ellipsoid else []
    return wells, found


KINDS = (({"ellipsoid": {"md_m", "north_m", "east_m", "tvd_m"}, "covariance": {"md_m", *ELEMENTS}}, _one_well),
         ({"stations": {"md_m", "north_m", "east_m", "vertical_m", "raw_north_m", *ELEMENTS}}, _two_readings),
         ({"paths": {"well", "md_m", "north_m", "east_m", "tvd_m"}}, _many_wells))


def _points(frames):
    """The points of a sweep: (name of the keys, [(label, {table: its rows at the point})]), at most MOST_SCENES."""
    whole = next(iter(frames.values()))
    keys = [k for k in whole.attrs["sweep_keys"] if whole[k].nunique() > 1]
    if not keys:
        return "", [("", frames)]
    points = whole[keys].drop_duplicates()
    label = lambda v: v if isinstance(v, str) else f"{v:g}"  # noqa: E731
    found = []
    for _, point in points.iloc[_evenly(len(points), MOST_SCENES)].iterrows():
        at = {name: frame[(frame[[k for k in keys if k in frame]] == point[[k for k in keys if k in frame]]).all(axis=1)]
              for name, frame in frames.items()}
        found.append((", ".join(label(point[k]) for k in keys), at))
    return ", ".join(k.removesuffix(".name").replace("_", " ").replace(".", " ") for k in keys), found


def _frames(result, names):
    found = {n: result.table(n) for n in names if n in result.tables}
    return {n: f for n, f in found.items() if len(f)}


def wells(result):
    """The wells of a result for the page, or None if it has none: {key, scenes: [{label, wells: [{name, md, north, east, down}],
    ellipsoids: [{well, md, label, centre, axes}]}]}, a scene for each point of a sweep. Lengths in m."""
    for wanted, build in KINDS:
        frames = _frames(result, [*wanted, *(["relative_covariance"] if "paths" in wanted else [])])
        if any(t not in frames or not columns <= set(frames[t].columns) for t, columns in wanted.items()):
            continue
        key, points = _points(frames)
        scenes = []
        for label, at in points:
            own, ellipsoids = build(at)
            if any(len(w["md"]) > 1 for w in own):
                scenes.append({"label": label, "wells": [w for w in own if w["md"]], "ellipsoids": ellipsoids})
        if scenes:
            return {"key": key, "scenes": scenes}
    return None


def cylinder(result):
    """The travelling cylinder of a clearance result, or None: {key, scenes: [{label, offsets: [{name, md, offset_md, distance,
    toolface, limit, factor}]}]}. limit: the distance at which the separation factor would be 1 (m); by the first formulation."""
    frames = _frames(result, ("clearance", "parameters"))
    if set(frames) != {"clearance", "parameters"} or not {"toolface_to_offset_deg", "scale_factor"} <= {
            *frames["clearance"].columns, *frames["parameters"].columns}:
        return None
    key, points = _points(frames)
    scenes = []
    for label, at in points:
        rows, wells_at = at["clearance"], at["parameters"]
        rows = rows[(rows["minimum"] == 1) & (rows["direction"] == "reference")]
        diameter, rule = dict(zip(wells_at["well"], wells_at["hole_diameter_m"])), wells_at.iloc[0]
        offsets = []
        for name, own in rows.groupby("offset", sort=False):
            own = own[own["formulation"] == own["formulation"].iloc[0]]
            own = own.iloc[_evenly(len(own), MOST_STATIONS)]
            limit = ((diameter["reference"] + diameter[name]) / 2 + rule["surface_margin_m"]
                     + rule["scale_factor"] * np.hypot(own["sd_relative_m"], rule["project_ahead_m"]))
            numbers = {"md": own["ref_md_m"], "offset_md": own["offset_md_m"], "distance": own["distance_m"],
                       "toolface": own["toolface_to_offset_deg"], "limit": limit, "factor": own["separation_factor"]}
            offsets.append({"name": name, **{k: [float(f"{x:.6g}") if math.isfinite(x) else None for x in v]
                                             for k, v in numbers.items()}})
        if offsets:
            scenes.append({"label": label, "offsets": offsets})
    return {"key": key, "scenes": scenes} if scenes else None


# --- the page -------------------------------------------------------------------------------------------------------


def _library_files():
    """Paths of three.js and what of its examples is used; none where it is not installed."""
    sets = ([os.path.join(place, name) for name in LIBRARY] for place in PLACES)
    return next((paths for paths in sets if all(os.path.isfile(p) for p in paths)), [])


def is_installed():
    """Whether the library is there that draws in space."""
    return bool(_library_files())


def library():
    """three.js and what of its examples is used, as one script. NoScene where it is not installed."""
    parts = []
    for path in _library_files():
        with open(path, encoding="utf-8") as file:
            parts.append(file.read().replace("</script", "<\\/script"))
    if parts:
        return "\n;\n".join(parts)
    raise NoScene("three.js is not installed, which draws wells in space: apt-get install libjs-three")


def write(result, path, templates=None):
    """Writes the page of a result (surveymc.Result, or the path of its file). templates: a folder of the user's own.

    A page that this function has made is replaced; any other file of that name is kept (NAME.1.html). Returns the name under
    which it is kept, or "". NoScene where the result has no wells; OSError where the page cannot be written.
    """
    from .report import templating, text  # here: they need Jinja2

    if isinstance(result, (str, os.PathLike)):
        from .result import Result

        result = Result(result)
    in_space = wells(result)
    if in_space is None:
        raise NoScene(f"{result.path}: has no wells to draw: no table of positions with a covariance, and none of paths")
    drawings = [("wells", "Wells and their error ellipsoids", in_space)]
    around = cylinder(result)
    drawings += [("cylinder", "Travelling cylinder", around)] if around else []
    page = templating.render(templating.environment(templates), "view3d.html", result=result,
                             file=text.slug(os.path.splitext(os.path.basename(result.path))[0]), drawings=drawings,
                             library=text.Markup(library()))
    data = page.encode("utf-8", "backslashreplace")
    return whole_file.write(os.fspath(path), whole_file.marked(data, MAKER), whole_file.is_marked_by(MAKER))
