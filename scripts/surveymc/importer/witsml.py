"""WITSML trajectories: 1.3.1 and 1.4.1 (trajectoryStation) and 2.x (TrajectoryStation), units from their uom attributes.

XML from outside is not trusted: no document type (so no entities of its own), no network, no huge trees.
"""

import re

from .problem import DATA, IO, USAGE, Problem, shown
from .table import Row, Table

NORTHS = {"true north": "true", "grid north": "grid", "magnetic north": "magnetic", "true": "true", "grid": "grid", "magnetic": "magnetic"}
READ = {"md": "md", "incl": "inc", "azi": "azi"}
COMPARED = ["tvd", "dispNs", "dispEw"]  # positions
SAID = ["typeTrajStation"]
MOST_ATTRIBUTES = 500  # of an element; the parser's time grows with the square of their number
COUNTS, REJECTED, OPEN = {"position", "accepted", "unknown", ""}, {"rejected"}, {"open"}
UOMS = {"ft[US]": "usft", "ftUS": "usft", "ft": "ft", "m": "m", "deg": "deg", "dega": "deg", "rad": "rad", "gon": "gon"}


def local(element):
    return element.tag.rsplit("}", 1)[-1] if isinstance(element.tag, str) else ""


def children(element, name):
    return [e for e in element if local(e).casefold() == name.casefold()]


def one_text(element, name):
    found = children(element, name)
    return (found[0].text or "").strip() if found else ""


def parse(data, file):
    try:
        from lxml import etree
    except ImportError:
        raise Problem("python3-lxml is not installed, which XML is read with: scripts/bootstrap.sh import", IO)
    many = re.search(rb"<[\w:.-]+(?:\s+[\w:.-]+\s*=\s*(?:\"[^\"]*\"|'[^']*')){%d}" % MOST_ATTRIBUTES, data.replace(b"\0", b""))
    if many:
        line = data.count(b"\n", 0, many.start()) + 1
        raise Problem(f"{file}:line {line}: an element of {MOST_ATTRIBUTES} attributes or more: must have less: no trajectory has as many")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, dtd_validation=False, huge_tree=False,
                             recover=False, remove_comments=True, remove_pis=True)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as fault:
        raise Problem(f"{file}:line {fault.lineno or 1}: {shown(fault.msg, 100)}: must be well-formed XML")
    if root.getroottree().docinfo.doctype or root.getroottree().docinfo.internalDTD is not None:
        raise Problem(f"{file}: has a document type (<!DOCTYPE ...>): WITSML has none, and entities are not read; remove it")
    return root


def name_of(trajectory):
    """What --trajectory may call it: uid, name or title."""
    citation = children(trajectory, "Citation")
    title = one_text(citation[0], "Title") if citation else ""
    return [n for n in (trajectory.get("uid") or trajectory.get("uuid"), one_text(trajectory, "name"), title) if n]


def lines_within(element):
    last = element.sourceline
    for e in element.iter():
        last = max(last, e.sourceline or 0)
    return range(element.sourceline, last + 1)


def counted(stations, file, options, warnings):
    """The stations that count: not those that the file rejects, nor those in lines that an option leaves out."""
    unused, kept, states = set(options.skip_lines), [], []
    for s in stations:
        hit = unused.intersection(lines_within(s)) if unused else set()
        unused -= hit
        if not hit:
            kept.append(s)
            states.append(one_text(s, "statusTrajStation").casefold())
    if unused:
        numbers = ", ".join(map(str, sorted(unused)[:5]))
        raise Problem(f"--skip-lines: {numbers}: no station of {file} stands there: must be a line of a station", USAGE)
    for s, state in zip(kept, states):
        if state not in COUNTS | REJECTED | OPEN:
            raise Problem(f"{file}:line {s.sourceline}: statusTrajStation = '{shown(state)}': must be one of position, open, rejected; correct it, "
                          f"or leave the station out: --skip-lines {s.sourceline}")
    all_open = not any(state in ("position", "accepted") for state in states)
    for word in (REJECTED, OPEN):
        some = [s for s, state in zip(kept, states) if state in word]
        if not some:
            continue
        of = f"line {some[0].sourceline}: statusTrajStation = '{next(iter(word))}', md {shown(' '.join(children(some[0], 'md')[0].itertext()) if children(some[0], 'md') else '-', 20)}"
        of += f" (and {len(some) - 1} stations more)" if len(some) > 1 else ""
        warnings.append(f"{file}:{of}: " + ("is used: no station is of status 'position'" if word is OPEN and all_open else "does not count, left out"))
    kept = [s for s, state in zip(kept, states) if state not in REJECTED and (all_open or state not in OPEN)]
    if len(kept) < 2:
        raise Problem(f"{file}: {len(kept)} stations of {len(stations)} count (statusTrajStation): must be at least 2")
    return kept


def read(data, file, options):
    if options.readings:
        raise Problem(f"{file}: --readings: readings are not taken from WITSML, whose axes have no fixed meaning: must be a table of "
                      "text, LAS or Excel with Gx to Bz")
    root = parse(data, file)
    every = [e for e in root.iter() if local(e).casefold() == "trajectory"]
    if not every:
        raise Problem(f"{file}:line {root.sourceline}: root element '{shown(local(root))}': must hold a WITSML trajectory")
    if options.trajectory:
        number = int(options.trajectory) if options.trajectory.isdigit() and int(options.trajectory) <= len(every) else 0
        picked = [t for t in every if options.trajectory in name_of(t)] or ([every[number - 1]] if number else [])
    else:
        picked = every
    names = ", ".join(f"{i} '{shown((name_of(t) or ['-'])[-1], 40)}'" for i, t in enumerate(every[:20], 1))
    names += f" and {len(every) - 20} more" if len(every) > 20 else ""
    if len(picked) != 1:
        raise Problem(f"{file}: {len(every)} trajector{'y' if len(every) == 1 else 'ies'}: {names}: one must be meant: --trajectory NAME, UID or NUMBER",
                      64 if options.trajectory else DATA)
    trajectory = picked[0]
    version = root.get("version") or trajectory.get("schemaVersion") or root.get("schemaVersion") or ""
    stations = children(trajectory, "trajectoryStation")
    if not stations:
        raise Problem(f"{file}:line {trajectory.sourceline}: trajectory has no stations: must have at least two")
    rows, units, extra = [], {}, set()
    left = []
    stations = counted(stations, file, options, left)
    columns_here = [*READ, *(n for n in COMPARED + SAID if any(children(s, n) for s in stations))]
    for station in stations:
        place, cells = f"line {station.sourceline}", []
        for name in columns_here:
            if name in SAID:
                cells.append(one_text(station, name))
                continue
            found = children(station, name)
            if len(found) > 1:
                raise Problem(f"{file}:{place}: {name} stands {len(found)} times in one station: must be once")
            element = found[0] if found else None
            value = element
            if element is not None and len(element):  # 2.1: <Md><MeasuredDepth uom="m">..</MeasuredDepth></Md>
                value = next((e for e in element if e.get("uom")), element)
            uom = value.get("uom") if value is not None else None
            cells.append((value.text or "").strip() if value is not None else "")
            if value is not None and uom is None and name not in COMPARED:
                raise Problem(f"{file}:line {element.sourceline}: {name}: attribute uom is missing: WITSML must have it")
            if name in COMPARED and UOMS.get(uom) != UOMS.get(units.setdefault(name, uom)):
                cells[-1] = ""  # of another unit: not compared
                continue
            if uom and uom not in UOMS and name not in COMPARED:
                raise Problem(f"{file}:line {element.sourceline}: {name}: uom = '{shown(uom)}': must be one of {', '.join(UOMS)}")
            if uom and units.setdefault(name, uom) != uom:
                raise Problem(f"{file}:line {element.sourceline}: {name}: uom = '{uom}': must be that of the stations before, '{units[name]}'")
        extra |= {local(e) for e in station} - {""}
        rows.append(Row(place, cells))
    if len(children(trajectory, "aziRef")) > 1:
        raise Problem(f"{file}:line {trajectory.sourceline}: aziRef stands {len(children(trajectory, 'aziRef'))} times in one trajectory: must be once")
    written = one_text(trajectory, "aziRef")
    if written.casefold() in ("unknown", "not known"):
        written = ""
    if written and written.casefold() not in NORTHS:
        raise Problem(f"{file}:line {trajectory.sourceline}: aziRef = '{shown(written)}': must be one of "
                      "true north, grid north, magnetic north, unknown")
    taken = {n.casefold() for n in columns_here}
    table = Table(f"WITSML {version} trajectory".replace("  ", " ") + f" '{shown((name_of(trajectory) or ['-'])[-1], 40)}'", columns_here, rows,
                  f"line {trajectory.sourceline}", [UOMS.get(units.get(n)) for n in columns_here], plain_numbers=True)
    table.reference = (NORTHS[written.casefold()], f"aziRef '{shown(written)}'") if written else None
    table.warnings = left
    table.ignored = sorted(e for e in extra if e.casefold() not in taken)
    return table
