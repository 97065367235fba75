"""Positions that a file lists beside its angles: true vertical depth, north, east. They are compared, never taken.

Computed by minimum curvature from the angles that were taken. Compared are differences between rows: where a datum or an
origin is does not matter, and neither does a turn of the plane (grid against true north), which is told.
"""

import cmath
import math
import re
from dataclasses import dataclass

from . import columns
from .checks import dogleg_deg
from .problem import shown

METRES = {"m": 1.0, "ft": 0.3048, "usft": 1200 / 3937}
SHARE, ROUNDING_M = 0.02, 1.0  # of the hole between two rows; positions may be listed whole: as of a survey of our own form
SLIGHT_SHARE, SLIGHT_M = 0.002, 0.5  # what is told
LARGEST_TURN_DEG = 45.0  # no convergence or declination where wells are drilled turns as far
SLIGHT_TURN_DEG = 0.3
NORTH = set("n ns north northing northings northsouth localnorth localn mapnorthing mapnorth utmnorthing dispns nscoord northcoord nsoffset "
            "localnorthing nsdisplacement ycoord y ynorth nslocal".split())
EAST = set("e ew east easting eastings eastwest localeast locale mapeasting mapeast utmeasting dispew ewcoord eastcoord ewoffset "
           "localeasting ewdisplacement xcoord x xeast ewlocal".split())
REVERSED = {"sn": "north", "south": "north", "southing": "north", "we": "east", "west": "east", "westing": "east"}


@dataclass
class Listed:
    kind: str  # "tvd", "north", "east"
    heading: str
    values: list  # of each row in the unit of the file, None where the cell is no number
    unit: str
    unit_named: bool
    sign: int = 1  # -1: counts the other way (a height, south, west)


def kind_of(heading):
    """(kind, sign) of a heading, or None."""
    name, inner = columns.split_heading(heading)
    name = re.sub(r"([a-z])([A-Z][a-z])", r"\1 \2", name)
    words = [w for w in re.split(r"[^\w]+|_", name.casefold()) if w]
    words += [w for i in inner if not columns.is_unit(i) for w in re.split(r"[^\w]+|_", i.casefold()) if w]
    if set(words) & {"sd", "sigma", "error", "uncertainty", "unc", "rate", "section", "sect", "target", "difference", "diff", "cov"}:
        return None
    if any(re.match(r"(ss)?tvd(ss|msl|sea|rkb|kb|rt)?$", w) for w in words) or ({"vertical", "vert"} & set(words) and {"depth", "dep"} & set(words)):
        return "tvd", 1
    if words and columns.is_unit(words[-1]) and len(words) > 1 and words[-1] not in ("n", "e"):
        words = words[:-1]
    joined = "".join(words)
    if re.search(r"\+\s*[sS]|[sS]\s*\+|\+\s*[wW]|[wW]\s*\+", name):
        return ("north" if "s" in joined else "east"), -1
    if joined in REVERSED:
        return REVERSED[joined], -1
    return ("north", 1) if joined in NORTH else ("east", 1) if joined in EAST else None


def value_of(cell, mark, negative):
    """A listed number: "12.3", "12.3 S", "S 12.3"; None for what is none."""
    hit = re.fullmatch(r"([NSEWnsew]?)\s*([^NSEWnsew]*?)\s*([NSEWnsew]?)", columns.tidy(cell))
    if not hit or not columns.looks_numeric(hit[2]) or columns.is_null(cell, negative):
        return None
    try:
        value = float(columns.number(hit[2], mark, "")[0])
    except columns.Problem:
        return None
    return -value if (hit[1] or hit[3]).upper() in ("S", "W") and (hit[1] or hit[3]) else value


def find(table, chosen, found):
    out, taken = [], {c.index for c in chosen.values()}
    depth_unit = chosen["md"].unit
    for i, heading in enumerate(table.headings):
        said = kind_of(heading) if i not in taken else None
        if not said:
            continue
        written = columns.read_heading(heading, table.units[i] if table.units else None).unit
        unit = columns.length_of(written) if written else depth_unit
        if unit not in METRES:
            continue
        values = [value_of(row.cells[i], found.mark, table.null) if i < len(row.cells) else None for row in found.rows]
        if sum(v is not None for v in values) >= 2:
            out.append(Listed(said[0], heading, values, unit, written is not None, said[1]))
    return out


def computed(found):
    """(along, north, east, down) in metres of every station from the first, and the sum of what a method may differ by."""
    scale = METRES["ft"] if found.heads[0] == "md_ft" else 1.0
    at = [(0.0, 0.0, 0.0, 0.0, 0.0)]
    for a, b in zip(found.values, found.values[1:]):
        length, angle = (b[0] - a[0]) * scale, math.radians(dogleg_deg(a, b))
        half = length / 2 * (math.tan(angle / 2) / (angle / 2) if angle > 1e-9 else 1.0)
        (i, j), (p, q) = (math.radians(a[1]), math.radians(b[1])), (math.radians(a[2]), math.radians(b[2]))
        s, n, e, d, loose = at[-1]
        at.append((s + length, n + half * (math.sin(i) * math.cos(p) + math.sin(j) * math.cos(q)),
                   e + half * (math.sin(i) * math.sin(p) + math.sin(j) * math.sin(q)), d + half * (math.cos(i) + math.cos(j)),
                   loose + length * (SHARE + angle / 2)))
    return at


def worst(rows, listed, expected, along, loose):
    """([(row before, row) of the steps that contradict], row of the largest difference or None, that difference in metres)."""
    bad, most, at = [], 0.0, None
    for a, b in zip(rows, rows[1:]):
        if abs((listed[b] - listed[a]) - (expected[b] - expected[a])) > loose[b] - loose[a] + ROUNDING_M:
            bad.append((a, b))
        away = abs((listed[b] - listed[rows[0]]) - (expected[b] - expected[rows[0]]))
        if away > SLIGHT_M + SLIGHT_SHARE * (along[b] - along[rows[0]]) and away > most:
            most, at = away, b
    return bad, at, most


def compare(table, chosen, found, file):
    """([(is refused, text)], [notes]) of all listed columns."""
    if any(b[0] <= a[0] for a, b in zip(found.values, found.values[1:])):
        return [], []  # depths that do not increase are refused as such
    lists, out, notes = find(table, chosen, found), [], []
    at = computed(found)
    along, loose = [p[0] for p in at], [p[4] for p in at]
    moves = []
    still = all(len({v for v in c.values if v is not None}) == 1 for c in lists if c.kind != "tvd")  # a hole may go straight north
    for c in lists:
        filled = {v for v in c.values if v is not None}
        displaced = max(abs(p[3]) if c.kind == "tvd" else math.hypot(p[1], p[2]) for p in at)
        if len(filled) == 1 and displaced > ROUNDING_M and (c.kind == "tvd" or still):
            notes.append(f"{file}:{table.header_place}: column '{shown(c.heading)}' holds {next(iter(filled)):.10g} in all rows: not compared with the angles")
        else:
            moves.append(c)
    for c in moves:
        if c.kind != "tvd":
            continue
        rows = [k for k, v in enumerate(c.values) if v is not None]
        values = [v for v in c.values if v is not None]
        expected = [p[3] for p in at]
        gained, wanted = values[-1] - values[0], expected[rows[-1]] - expected[rows[0]]
        may_be_height = re.search(r"ss|msl|sea|elev", c.heading, re.I) or max(values) <= 0
        sign = -1 if may_be_height and gained * wanted < 0 else 1
        judge(c, rows, {k: sign * METRES[c.unit] * c.values[k] for k in rows}, expected, along, loose, file, found, out)
    north = [c for c in moves if c.kind == "north"]
    east = [c for c in moves if c.kind == "east"]
    for n, e in zip(north, east):
        there = []
        plane(n, e, at, along, loose, file, found, there)
        if there and re.search(r"\b[xy]", n.heading, re.I):  # some call north x
            back = []
            plane(e, n, at, along, loose, file, found, back)
            there = min(there, back, key=len)
        out += there
    for c in north[len(east):] + east[len(north):]:  # one of them alone: without its partner no turn can be told
        rows = [k for k, v in enumerate(c.values) if v is not None]
        expected = [p[1 if c.kind == "north" else 2] for p in at]
        alone = []
        judge(c, rows, {k: c.sign * METRES[c.unit] * c.values[k] for k in rows}, expected, along, loose, file, found, alone)
        out += [(False, text) for _, text in alone]
    return out, notes


def contradiction(place, cells, listed, given, unit, others):
    """Of two rows whose step, m, is not what the angles give."""
    more = f" (and {others} more)" if others else ""
    unit_m = METRES[unit]
    return (True, f"{place}: {cells}: {listed / unit_m:.6g} {unit} from the row before, where the angles give {given / unit_m:.6g} {unit}{more}: are the "
            "columns, the units of angles and depths, and the inclinations (from the vertical) right?")


def judge(c, rows, listed, expected, along, loose, file, found, out):
    bad, at, most = worst(rows, listed, expected, along, loose)
    unit = METRES[c.unit]
    name = f"'{shown(c.heading, 30)}'"
    if bad:
        a, b = bad[0]
        out.append(contradiction(f"{file}:{found.places[b]}", f"{name} = {c.values[b]:.10g}", listed[b] - listed[a], expected[b] - expected[a], c.unit,
                                 len(bad) - 1))
    elif at is not None:
        out.append((False, f"{file}:{found.places[at]}: {name} = {c.values[at]:.10g}: {most / unit:.4g} {c.unit} off what minimum curvature gives from "
                    f"the angles over {(along[at] - along[rows[0]]) / unit:.6g} {c.unit} of hole"))


def plane(n, e, at, along, loose, file, found, out):
    rows = [k for k in range(len(at)) if n.values[k] is not None and e.values[k] is not None]
    if len(rows) < 2:
        return
    names = f"'{shown(n.heading, 30)}', '{shown(e.heading, 30)}'"
    expected = {k: complex(at[k][1], at[k][2]) for k in rows}

    def fit(unit):
        listed = {k: METRES[unit] * complex(n.sign * n.values[k], e.sign * e.values[k]) for k in rows}
        first = rows[0]
        turn = sum((listed[k] - listed[first]) * (expected[k] - expected[first]).conjugate() for k in rows)
        far = max(abs(expected[k] - expected[first]) for k in rows)
        turn = cmath.phase(turn) if abs(turn) > 0 and far > 10 * ROUNDING_M else 0.0
        turned = {k: expected[k] * cmath.exp(1j * turn) for k in rows}
        return listed, turned, turn, far, worst(rows, listed, turned, along, loose)

    listed, turned, turn, far, (bad, off, most) = fit(n.unit)
    unit = METRES[n.unit]
    if bad and not (n.unit_named or e.unit_named):  # a map in another unit than the depths
        for other in METRES:
            again = fit(other)
            if other != n.unit and not again[4][0] and abs(math.degrees(again[2])) <= LARGEST_TURN_DEG:
                out.append((False, f"{file}: {names}: agree with the angles in {other}, depths are in {n.unit}: is that so?"))
                return
    if bad:
        a, b = bad[0]
        out.append(contradiction(f"{file}:{found.places[b]}", f"{names} = {n.values[b]:.10g}, {e.values[b]:.10g}", abs(listed[b] - listed[a]),
                                 abs(turned[b] - turned[a]), n.unit, len(bad) - 1))
        return
    degrees = math.degrees(turn)
    if abs(degrees) > LARGEST_TURN_DEG:
        out.append((True, f"{file}: {names}: lie {degrees:+.4g} deg from where the azimuths lead: are the azimuths counted clockwise from north, "
                    "and are the columns right?"))
    elif abs(degrees) > SLIGHT_TURN_DEG and far * abs(math.sin(turn)) > ROUNDING_M:
        out.append((False, f"{file}: {names}: lie {degrees:+.3g} deg from where the azimuths lead, {far * abs(math.sin(turn)) / unit:.4g} {n.unit} at the most: "
                    "are they from another north than the azimuths?"))
    if off is not None:
        out.append((False, f"{file}:{found.places[off]}: {names} = {n.values[off]:.10g}, {e.values[off]:.10g}: {most / unit:.4g} {n.unit} off what minimum "
                    f"curvature gives from the angles over {(along[off] - along[rows[0]]) / unit:.6g} {n.unit} of hole"))
