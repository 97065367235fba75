"""Rows of a table to stations: which rows are data, their numbers, the unit of the angles."""

import re
from dataclasses import dataclass

from . import columns, doubts
from .problem import Problem, shown


@dataclass
class Stations:
    roles: list  # in the order of the output
    heads: list  # names of the columns that are written: md_m, inclination_deg ...
    texts: list  # rows of texts, as they are written
    values: list  # rows of floats in the written units
    places: list  # of each row
    notes: list  # places of lines that were left out as no data
    rows: list  # of the table
    empty: int  # rows of a form whose values are its null
    mark: str


NAMES = {"md": "md", "inc": "inclination", "azi": "azimuth", "tf": "toolface"}


_MARKED = re.compile(r"[+-]?\d[\d.,]*\s*[^\W\d_]{0,10}[°º*?!#+†‡]{0,3}\.?")  # "1090*", "47 deg": a number and a mark behind


def is_data(row, chosen, table, file):
    """Is a row a station? False for a note. A row that is half a station is an error: nothing is dropped in silence."""
    cells = {r: row.cells[c.index] if c.index < len(row.cells) else "" for r, c in chosen.items()}
    empty = {r for r, t in cells.items() if columns.is_null(t, table.null)}
    numeric = {r for r, t in cells.items() if columns.looks_numeric(t)} - empty
    if table.null is not None and empty == set(cells) - {"md"}:
        return None
    if empty == {"azi"} and re.fullmatch(r"[+-]?0*[.,]?0*°?", columns.tidy(cells["inc"])):
        return True  # a vertical hole has no azimuth
    more = [c for c in row.cells[len(table.headings):] if c.strip()]
    if len(numeric) == len(cells):
        if any(columns.looks_numeric(c) for c in more):
            raise Problem(f"{file}:{row.place}: {len(row.cells)} values: must be {len(table.headings)}, as the header has; a decimal comma in "
                          "a file separated by commas must be quoted")
        return True
    formula = next((r for r, t in cells.items() if t.startswith("=")), None)
    if formula:
        raise Problem(f"{file}:{row.place}: {chosen[formula].heading}: formula '{shown(cells[formula], 30)}': must have a value: open the "
                      "workbook in a spreadsheet program and save it, or leave the line out: --skip-lines " + row.place.rsplit(" ", 1)[-1])
    if "md" not in numeric and len(numeric) < 2 and not all(_MARKED.fullmatch(columns.tidy(t)) for t in cells.values()):
        return False
    role = next(r for r in cells if r not in numeric)
    line = row.place.rsplit(" ", 1)[-1]
    what = "is empty" if role in empty else f"= '{shown(cells[role])}'"
    raise Problem(f"{file}:{row.place}: {chosen[role].heading} {what}: must be a number; correct it, or leave the line out: --skip-lines {line}")


def angle_units(chosen, rows, options, file, table):
    """Names the unit of angles whose headings do not: degrees, if the values can be nothing else."""
    open_ones = [c for c in chosen.values() if c.unit is None]
    if not open_ones:
        return
    said = {c.unit for r, c in chosen.items() if r in columns.ANGLES and c.unit}
    if len(said) == 1:
        for c in open_ones:
            c.unit, c.unit_from = next(iter(said)), "the other angles"
        return
    # No inclination above pi and no azimuth above 2 pi: radians would do as well.
    above = next(((p, v) for p, v in rows if v["inc"] > columns.Decimal("3.15") or v["azi"] > columns.Decimal("6.29")), None)
    if above is None:
        raise Problem(f"{file}:{table.header_place}: no unit of angles, and no inclination is above 3.15, no azimuth above 6.29: these may be "
                      "radians or small angles in degrees: must be known: --angle-unit deg|rad|gon")
    over = next((p for p, v in rows if v["inc"] > 180 or v["azi"] > 360), None)
    if over:
        return  # the check names the value
    for c in open_ones:
        c.unit, c.unit_from = "deg", f"no unit in the heading; no radians, by {above[0]}"


def check_header(row, chosen, reference, file):
    """A header further down, of a page or a second table, must say what the first says: columns, units, north."""
    read = {r: columns.read_heading(row.cells[c.index]) if c.index < len(row.cells) else columns.Heading("") for r, c in chosen.items()}
    units = {r: row.cells[chosen[r].index].strip(" ()[]") for r in read if read[r].text}
    named = {r for r, h in read.items() if h.strong | h.weak}
    if len(named) < 2 and sum(columns.is_unit(u) for u in units.values()) < 2:
        return
    for role, h in read.items():
        c = chosen[role]
        written = h.unit or (units.get(role) if columns.is_unit(units.get(role, "")) else None)
        unit = columns.unit_of(role, written) if written else None
        column = role in named and role not in h.strong | h.weak and not c.by_option
        if not column and not (unit and unit != (c.unit or "deg") and (unit, c.unit) != ("ft", "usft")) and \
                not (role == "azi" and h.reference and reference and h.reference != reference[0] and reference[0] in columns.REFERENCES):
            continue
        line = row.place.rsplit(" ", 1)[-1]
        raise Problem(f"{file}:{row.place}: '{shown(h.text)}': another header than that of the first table, where this column is "
                      f"'{shown(c.heading)}': must be the same: put each table into a file of its own, or leave the line out "
                      f"if it is not true: --skip-lines {line}")


def fill_azimuths(rows, table, chosen, file):
    """A station of inclination 0 without azimuth takes that of the next which has one, else of the one before: no turn at it."""
    index, filled = chosen["azi"].index, []
    for order in (range(len(rows) - 1, -1, -1), range(len(rows))):
        last = None
        for k in order:
            row = rows[k]
            text = row.cells[index] if index < len(row.cells) else ""
            if not columns.is_null(text, table.null):
                last = text
            elif last is not None:
                rows[k].cells = [*row.cells[:index], *[""] * (index - len(row.cells)), last, *row.cells[index + 1:]]
                filled.append(row)
    for row in rows:
        if index >= len(row.cells) or columns.is_null(row.cells[index], table.null):  # the whole hole is vertical
            row.cells = [*row.cells[:index], *[""] * (index - len(row.cells)), "0", *row.cells[index + 1:]]
            filled.append(row)
    if filled:
        filled.sort(key=rows.index)
        table.warnings.append(f"{file}:{filled[0].place}: {shown(chosen['azi'].heading, 30)} is empty at inclination 0"
                              + (f" (and in {len(filled) - 1} row{'s' * (len(filled) > 2)} more)" if len(filled) > 1 else "")
                              + f": taken from the next station, {shown(filled[0].cells[index], 20)}")


def from_the_top(rows, table, chosen, options, file):
    """Rows that are listed from the bottom up, turned."""
    try:
        mark = options.decimal or ("point" if table.plain_numbers else columns.decimal_mark([("", r.cells[chosen["md"].index], "md") for r in rows], options))
        md = [columns.number(r.cells[chosen["md"].index], mark, "")[0] for r in rows]
    except Problem:
        return rows  # told where all numbers are read
    if not all(b < a for a, b in zip(md, md[1:])):
        return rows
    table.warnings.append(f"{file}: depths decrease from {shown(rows[0].cells[chosen['md'].index], 20)} ({rows[0].place}) to "
                          f"{shown(rows[-1].cells[chosen['md'].index], 20)} ({rows[-1].place}): read from the bottom up")
    return rows[::-1]


def other_table(row, chosen):
    """Does a row without numbers begin a table of other columns?"""
    words = [w for c in row.cells for w in re.findall(r"[^\W\d_]+", c.casefold())]
    if row.repeats or len([c for c in row.cells if c.strip()]) < 2 or any(columns.looks_numeric(c) for c in row.cells if c.strip()):
        return False
    if sum(w in _OF_TABLES for w in words) + sum(columns.is_unit(c.strip(" ()[]")) for c in row.cells if c.strip()) < 2:
        return False
    read = {r: columns.read_heading(row.cells[c.index]) for r, c in chosen.items() if c.index < len(row.cells)}
    return not all(r in h.strong | h.weak for r, h in read.items())


_OF_TABLES = set("depth measured vertical md tvd name comment diameter casing hole formation lithology dip north east northing easting inclination azimuth inc "
                 "azi incl local coordinates target targets shape marker top base size".split())


def collect(table, chosen, options, file, reference=None):
    data, notes, headers, empty = [], [], [], 0
    begins = None  # a line that may begin another table
    for row in table.rows:
        try:
            kind = is_data(row, chosen, table, file)
            another = bool(kind) and begins is not None and data
        except Problem:
            if begins is None or not data:
                raise
            another = True
        if another:
            raise Problem(f"{file}:{begins.place}: '{shown(' '.join(c for c in begins.cells if c), 50)}': another table begins here, below "
                          f"{len(data)} stations: must be one table; leave the rest out: --skip-lines {doubts.line_of(begins)}-{doubts.last_line(table)}")
        if not kind and row.repeats:
            begins = None
        elif not kind and data and begins is None and other_table(row, chosen):
            begins = row
        if kind:
            data.append(row)
        elif kind is None:
            empty += 1
        elif any(c.strip() for c in row.cells):
            notes.append(row.place)
            if not row.repeats:
                headers.append(row)
                if begins is row:
                    check_header(row, chosen, reference, file)
    if not options.readings:
        data = doubts.of_one_well(data, table, chosen, options, file)
        fill_azimuths(data, table, chosen, file)
    if len(data) > 1 and options.readings is False:
        data = from_the_top(data, table, chosen, options, file)
    roles = list(chosen)
    cells = [(f"{file}:{row.place}: {c.heading}", row.cells[c.index], r) for row in data for r, c in chosen.items()]
    if not options.readings:
        cells = [(place, (columns.bearing(t) or ("", t))[1], r) for place, t, r in cells]
    mark = options.decimal or "point" if table.plain_numbers else columns.decimal_mark(cells, options)
    read = []
    for row in data:
        read.append({r: (columns.azimuth_of if r == "azi" else columns.number)(row.cells[c.index], mark, f"{file}:{row.place}: {c.heading}")
                     for r, c in chosen.items()})
    if not options.readings:
        angle_units(chosen, [(row.place, {r: v[0] for r, v in values.items()}) for row, values in zip(data, read)], options, file, table)
        for c in chosen.values():
            c.unit = c.unit or "deg"
    for row in headers:
        check_header(row, chosen, reference, file)
    heads, texts = [], [[] for _ in data]
    for r, c in chosen.items():
        for k, values in enumerate(read):
            texts[k].append(columns.converted(*values[r], c.unit)[1])
        heads.append(f"{NAMES.get(r, r)}_{columns.converted(columns.Decimal(0), '0', c.unit)[0]}")
    for axes in ("gx gy gz", "bx by bz"):
        units = {h.rsplit("_", 1)[1]: chosen[h[:2]] for h in heads if h[:2] in axes.split() and h[:2] in chosen}
        if len(units) > 1:
            raise Problem(f"{file}:{table.header_place}: {axes}: units {', '.join(sorted(units))}: the three axes must have one; correct the headings")
    return Stations(roles, heads, texts, [[float(t) for t in row] for row in texts], [row.place for row in data], notes, data, empty, mark)
