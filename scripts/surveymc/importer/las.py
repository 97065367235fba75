"""LAS 1.2 and 2.0 (Canadian Well Logging Society): the sections ~V, ~C and ~A, as a survey log has them.

A reader of our own: Debian 12 has no lasio. Values are separated by spaces; wrapped files give a depth on its own line.
"""

import re

from . import columns
from .problem import Problem, shown
from .table import Row, Table
from .text import check_size, claims_in_titles, lines_of, north_in_titles

def parts_of(line):
    """(mnemonic, unit, value, description) of "MNEM.UNIT VALUE : DESCRIPTION", or None."""
    name, point, rest = line.partition(".")
    if not point or not name.strip():
        return None
    before, colon, after = rest.rpartition(":")
    if not colon:
        before, after = rest, ""
    unit = re.match(r"[^\s:]*", before)[0]
    return name.strip(), unit, before[len(unit):].strip(), after.strip()


def is_las(text):
    for line in lines_of(text[:65536]):
        if line.strip() and not line.lstrip().startswith("#"):
            return line.lstrip().upper().startswith("~V")
    return False


def read(text, file, options):
    section, keys, ends, curves, data, data_line = "", {}, [], [], [], 0
    said = {}  # lines that may name the north, or from where inclinations count
    lines = lines_of(text)
    check_size(lines, file)
    for n, line in enumerate(lines, 1):
        bare = line.strip()
        if not bare or bare.startswith("#") or n in options.skip_lines:
            continue
        if bare.startswith("~"):
            if section == "A":
                raise Problem(f"{file}:line {n}: section '{shown(bare, 20)}' behind ~A: the data must be the last section")
            section = bare[1:2].upper()
            data_line = n if section == "A" else 0
            continue
        if section == "A":
            data.append((n, [c.strip() for c in bare.split(",")] if keys.get("DLM", "").upper() == "COMMA" else bare.split()))
            continue
        hit = parts_of(line[:2000])
        if section in "VWC" and not hit:
            raise Problem(f"{file}:line {n}: '{shown(bare)}': must be MNEMONIC.UNIT VALUE : DESCRIPTION")
        if hit and section in "VWP":
            keys.setdefault(hit[0].upper(), hit[2])
            if hit[0].upper() in ("STRT", "STOP"):
                ends.append((n, hit[0], hit[1]))
        elif hit and section == "C":
            curves.append((hit[0], hit[1], hit[3], n))
        if section in "WPO":
            said[n - 1] = f"{hit[0]} {hit[3]}: {hit[2]} | {hit[3]}"[:400] if hit and section != "O" else line
    version = keys.get("VERS", "")
    if not re.match(r"(1\.2|2\.)", version):
        raise Problem(f"{file}: ~V: VERS = '{shown(version)}': must be 1.2 or 2.0; write it as LAS 2.0 or CSV")
    if not curves or not data_line:
        raise Problem(f"{file}: section {'~A' if curves else '~C'} is missing or empty: a LAS file must have curves and data")
    of = columns.length_of
    for n, name, unit in ends:
        index, unit_here = of(curves[0][1]), of(unit)
        if index and unit_here and index != unit_here:
            raise Problem(f"{file}:line {n}: {name} is in {shown(unit)}, the depth curve '{shown(curves[0][0])}' (line {curves[0][3]}) in "
                          f"{shown(curves[0][1])}: must agree; correct the one that is wrong")
    rows, wrapped = [], keys.get("WRAP", "NO").upper() == "YES"
    if wrapped:
        values = []
        start = 0
        for n, cells in data:
            start = start or n
            values += cells
            if len(values) >= len(curves):
                rows.append(Row(f"line {start}", values))
                if len(values) > len(curves):
                    raise Problem(f"{file}:line {n}: {len(values)} values of one depth: must be {len(curves)}, the curves of ~C")
                values, start = [], 0
        if values:
            raise Problem(f"{file}:line {start}: {len(values)} values at the end: must be {len(curves)}, the curves of ~C: is the file cut?")
    else:
        for n, cells in data:
            if len(cells) != len(curves):
                raise Problem(f"{file}:line {n}: {len(cells)} values: must be {len(curves)}, the curves of ~C; correct it, or leave it out: "
                              f"--skip-lines {n}")
            rows.append(Row(f"line {n}", cells))
    table = Table(f"LAS {version}" + (", wrapped" if wrapped else ""), [heading_of(c) for c in curves], rows,
                  f"lines {curves[0][3]}-{curves[-1][3]}", [c[1] or None for c in curves], null=keys.get("NULL"), plain_numbers=True)
    titles = [said.get(n, "") for n in range(max(said, default=-1) + 1)]
    described, titled = described_north(curves), north_in_titles(titles)
    if described and titled and described[0] != titled[0]:
        described = "several", f"{described[1]} and {titled[1]}"
    table.reference = described or titled
    claims_in_titles(titles, options)
    table.described = {i: c[2] for i, c in enumerate(curves)}
    return table


def heading_of(curve):
    """The mnemonic; and its description where that says that the depth is a vertical one."""
    read = columns.read_heading(curve[0])
    vertical = "md" in read.strong | read.weak and re.search(r"\b(vertical|tvd\w*)\b", curve[2], re.I)
    return f"{curve[0]} {curve[2]}" if vertical else curve[0]


def described_north(curves):
    """The north that the description of the only azimuth curve names, if it names one."""
    azimuths = [c for c in curves if "azi" in columns.read_heading(c[0]).strong]
    for c in azimuths if len(azimuths) == 1 else []:
        reference = columns.read_heading(c[2]).reference
        if reference:
            return reference, f"line {c[3]} '{shown(c[2], 50)}'"
    return None
