"""WITSML trajectories: 1.3.1 and 1.4.1 (trajectoryStation) and 2.x (TrajectoryStation), units from their uom attributes.

XML from outside is not trusted: no document type (so no entities of its own), no network, no huge trees.
"""

from .problem import DATA, IO, Problem, shown
from .table import Row, Table

NORTHS = {"true north": "true", "grid north": "grid", "magnetic north": "magnetic", "true": "true", "grid": "grid", "magnetic": "magnetic"}
READ = {"md": "md", "incl": "inc", "azi": "azi"}
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
    names = ", ".join(f"{i} '{shown((name_of(t) or ['-'])[-1], 40)}'" for i, t in enumerate(every, 1))
    if len(picked) != 1:
        raise Problem(f"{file}: {len(every)} trajector{'y' if len(every) == 1 else 'ies'}: {names}: one must be meant: --trajectory NAME, UID or NUMBER",
                      64 if options.trajectory else DATA)
    trajectory = picked[0]
    version = root.get("version") or trajectory.get("schemaVersion") or root.get("schemaVersion") or ""
    stations = children(trajectory, "trajectoryStation")
    if not stations:
        raise Problem(f"{file}:line {trajectory.sourceline}: trajectory has no stations: must have at least two")
    rows, units, extra = [], {}, set()
    for station in stations:
        place, cells = f"line {station.sourceline}", []
        for name in READ:
            found = children(station, name)
            if len(found) > 1:
                raise Problem(f"{file}:{place}: {name} stands {len(found)} times in one station: must be once")
            element = found[0] if found else None
            value = element
            if element is not None and len(element):  # 2.1: <Md><MeasuredDepth uom="m">..</MeasuredDepth></Md>
                value = next((e for e in element if e.get("uom")), element)
            uom = value.get("uom") if value is not None else None
            cells.append((value.text or "").strip() if value is not None else "")
            if value is not None and uom is None:
                raise Problem(f"{file}:line {element.sourceline}: {name}: attribute uom is missing: WITSML must have it")
            if uom and uom not in UOMS:
                raise Problem(f"{file}:line {element.sourceline}: {name}: uom = '{shown(uom)}': must be one of {', '.join(UOMS)}")
            if uom and units.setdefault(name, uom) != uom:
                raise Problem(f"{file}:line {element.sourceline}: {name}: uom = '{uom}': must be that of the stations before, '{units[name]}'")
        extra |= {local(e) for e in station} - {""}
        rows.append(Row(place, cells))
    if len(children(trajectory, "aziRef")) > 1:
        raise Problem(f"{file}:line {trajectory.sourceline}: aziRef stands {len(children(trajectory, 'aziRef'))} times in one trajectory: must be once")
    written = one_text(trajectory, "aziRef")
    if written and written.casefold() not in NORTHS:
        raise Problem(f"{file}:line {trajectory.sourceline}: aziRef = '{shown(written)}': must be one of "
                      "true north, grid north, magnetic north")
    taken = {n.casefold() for n in READ}
    table = Table(f"WITSML {version} trajectory".replace("  ", " ") + f" '{shown((name_of(trajectory) or ['-'])[-1], 40)}'", list(READ), rows,
                  f"line {trajectory.sourceline}", [UOMS[units[n]] if n in units else None for n in READ], plain_numbers=True)
    table.reference = (NORTHS[written.casefold()], f"aziRef '{shown(written)}'") if written else None
    table.ignored = sorted(e for e in extra if e.casefold() not in taken)
    return table
